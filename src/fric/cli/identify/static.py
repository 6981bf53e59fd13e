"""`fric identify static`: the Stribeck map from strokes at constant velocity."""

from pathlib import Path
from typing import Annotated, Literal

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Implausible, Json, LogFiles, PlantFile, Plot, option


def static(
    logs: LogFiles,
    output: Annotated[Path, option("Friction file to write.", "-o", "--output", metavar="FRICTION.yaml")],
    plant: PlantFile = None,
    delta: Annotated[
        str,
        option(
            "Stribeck shape factor, fixed or free; auto: 1, or free where that predicts held-out strokes better.",
            metavar="VALUE|free|auto",
        ),
    ] = "auto",
    direction: Annotated[
        Literal["auto", "both", "each"],
        option("One map and an offset, a map for each direction, or what predicts held-out strokes better."),
    ] = "auto",
    over_position: Annotated[
        Literal["auto", "off", "on"],
        option("Whether to take off what comes again at the same places; auto: where that predicts better."),
    ] = "auto",
    weights: Annotated[
        Literal["error", "equal"], option("Weigh strokes by their errors and scatter, or all the same.")
    ] = "error",
    average: Annotated[
        Literal["robust", "median"], option("Force of a stroke: Huber's robust mean, or the median.")
    ] = "robust",
    form: Annotated[
        Literal["auto", "coulomb", "stribeck"],
        option("Coulomb plus viscous friction, eq. (2), or what predicts held-out strokes better."),
    ] = "auto",
    load: Annotated[
        str | None,
        option('Constant load where you know it, as "60 N" or "0 N": the offset is then it.', metavar="FORCE"),
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
