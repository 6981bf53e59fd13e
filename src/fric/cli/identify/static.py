"""`fric identify static`: the Stribeck map from strokes at constant velocity."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Implausible, Json, LogFiles, PlantFile, Plot


def static(
    logs: LogFiles,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FRICTION.yaml", help="Friction file to write.")],
    plant: PlantFile = None,
    delta: Annotated[
        str,
        typer.Option(
            metavar="VALUE|free|auto",
            help="Stribeck shape factor, fixed or free; auto: 1, or free where that predicts held-out strokes better.",
        ),
    ] = "auto",
    direction: Annotated[
        Literal["auto", "both", "each"],
        typer.Option(help="One map and an offset, a map for each direction, or what predicts held-out strokes better."),
    ] = "auto",
    over_position: Annotated[
        Literal["auto", "off", "on"],
        typer.Option(help="Whether to take off what comes again at the same places; auto: where that predicts better."),
    ] = "auto",
    weights: Annotated[
        Literal["error", "equal"], typer.Option(help="Weigh strokes by their errors and scatter, or all the same.")
    ] = "error",
    average: Annotated[
        Literal["robust", "median"], typer.Option(help="Force of a stroke: Huber's robust mean, or the median.")
    ] = "robust",
    form: Annotated[
        Literal["auto", "coulomb", "stribeck"],
        typer.Option(help="Coulomb plus viscous friction, eq. (2), or what predicts held-out strokes better."),
    ] = "auto",
    load: Annotated[
        str | None,
        typer.Option(
            metavar="FORCE", help='Constant load where you know it, as "60 N" or "0 N": the offset is then it.'
        ),
    ] = None,
    plot: Plot = None,
    implausible: Implausible = "error",
    json: Json = False,
    force: Force = False,
) -> None:
    """Identify the static friction map F_c, F_s, v_s, delta, sigma (eq. 2) from constant-velocity strokes."""
    finish(
        lambda _: fric.identify_static(
            *logs, plant=plant, delta=delta, direction=direction, weights=weights, average=average, form=form,
            load=load, over_position=over_position,
        ),
        output, plot, json=json, force=force, doing="friction map",
    )  # fmt: skip
