"""`fric plan`: the records to take of an axis, and what to expect of them."""

from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Json, Plot, argument, option


def plan(
    last: Annotated[
        Path | None,
        argument(
            "The last result: which one more record would narrow the predicted glitch most?", metavar="[FRICTION.yaml]"
        ),
    ] = None,
    stroke: Annotated[str | None, option('Travel of the axis, as "300 mm".')] = None,
    feed: Annotated[str | None, option('Largest speed, as "100 mm/s".')] = None,
    acceleration: Annotated[str, option("Largest acceleration.")] = "5 m/s^2",
    friction: Annotated[Path | None, option("What is known of its friction.", metavar="PRIOR.yaml")] = None,
    plant: Annotated[Path | None, option("What is known of its plant, and its scatter.", metavar="PLANT.yaml")] = None,
    machine: Annotated[
        str | None, option("Plant, controller, encoder, noise; else typical.", metavar="MACHINE.yaml")
    ] = None,
    axis: Annotated[str, option("The axis, where no friction says it.")] = "x",
    accuracy: Annotated[list[str] | None, option("Half-width asked for; repeatable.", metavar="F_s=2%")] = None,
    noise: Annotated[str | None, option('Noise of a logged force (rms), as "1 N".')] = None,
    encoder: Annotated[str | None, option('Encoder step, as "0.25 um".')] = None,
    like: Annotated[Path | None, option("A typical log, which tells noise and encoder.", metavar="LOG.h5")] = None,
    scheme: Annotated[str, option("Whose glitch is to be narrowed, after a last result.")] = "c",
    output: Annotated[
        Path | None, option("Folder for the plan and its programs.", "-o", "--output", metavar="DIR")
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
