"""`fric plan`: the records to take of an axis, and what to expect of them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Json, Plot


def plan(
    last: Annotated[
        Path | None,
        typer.Argument(
            metavar="[FRICTION.yaml]",
            help="The last result: which one more record would narrow the predicted glitch most?",
        ),
    ] = None,
    stroke: Annotated[str | None, typer.Option("--stroke", help='Travel of the axis, as "300 mm".')] = None,
    feed: Annotated[str | None, typer.Option("--feed", help='Largest speed, as "100 mm/s".')] = None,
    acceleration: Annotated[str, typer.Option("--acceleration", help="Largest acceleration.")] = "5 m/s^2",
    friction: Annotated[
        Path | None, typer.Option("--friction", metavar="PRIOR.yaml", help="What is known of its friction.")
    ] = None,
    plant: Annotated[
        Path | None, typer.Option("--plant", metavar="PLANT.yaml", help="What is known of its plant, and its scatter.")
    ] = None,
    machine: Annotated[
        str | None,
        typer.Option("--machine", metavar="MACHINE.yaml", help="Plant, controller, encoder, noise; else typical."),
    ] = None,
    axis: Annotated[str, typer.Option("--axis", help="The axis, where no friction says it.")] = "x",
    accuracy: Annotated[
        list[str] | None, typer.Option("--accuracy", metavar="F_s=2%", help="Half-width asked for; repeatable.")
    ] = None,
    noise: Annotated[str | None, typer.Option("--noise", help='Noise of a logged force (rms), as "1 N".')] = None,
    encoder: Annotated[str | None, typer.Option("--encoder", help='Encoder step, as "0.25 um".')] = None,
    like: Annotated[
        Path | None, typer.Option("--like", metavar="LOG.h5", help="A typical log, which tells noise and encoder.")
    ] = None,
    scheme: Annotated[str, typer.Option("--scheme", help="Whose glitch is to be narrowed, after a last result.")] = "c",
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder for the plan and its programs.")
    ] = None,
    plot: Plot = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Plan the records that identify an axis, with the intervals to expect; or the one more record that tells most.

    DIR gets plan.yaml, the motions as CSV, as G-code for LinuxCNC, Fanuc and SINUMERIK and as tables for TwinCAT and
    CODESYS, all inside stroke, feed and acceleration. `fric simulate experiment --plan` runs it on a virtual axis.
    """
    known: dict[str, Any] = {"machine": machine, "noise": noise, "encoder": encoder, "like": like}
    if last is not None:
        limits = {"stroke": stroke or "300 mm", "feed": feed or "100 mm/s", "acceleration": acceleration}
        finish(
            lambda advance: fric.plan_next(last, scheme=scheme, advance=advance, **limits, **known),
            plot=plot, into=output, json=json, force=force, doing="candidates",
        )  # fmt: skip
        return
    if stroke is None or feed is None:
        raise typer.BadParameter('say what the axis may do: --stroke "300 mm" --feed "100 mm/s"')
    finish(
        lambda advance: fric.plan(
            stroke=stroke, feed=feed, acceleration=acceleration, axis=axis, friction=friction, plant=plant,
            accuracy=accuracy or (), advance=advance, **known,
        ),
        plot=plot, into=output, json=json, force=force, doing="what to expect",
    )  # fmt: skip
