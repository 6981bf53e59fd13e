"""`fric compare`: friction models on samples that none of them was fitted to."""

from pathlib import Path
from typing import Annotated

import fric
from fric.cli.completion import records
from fric.cli.console import finish
from fric.cli.identify.by_replay import MODELS
from fric.cli.options import Force, Implausible, Json, LogFiles, PlantFile, Plot, option


def compare(
    logs: LogFiles,
    models: Annotated[str, option(f"Models to compare, of {', '.join(MODELS)}.", metavar="all|NAME,NAME…")] = "all",
    fit_on: Annotated[
        list[str] | None,
        option(
            "Fit on this record, score on those not named; repeatable.",
            metavar="RECORD",
            autocompletion=records,
        ),
    ] = None,
    cycles: Annotated[
        int | None, option("Fit on the first N cycles of a record, score on the rest.", metavar="N", min=1)
    ] = None,
    folds: Annotated[int, option("Cut each record in so many parts, each scored by a fit to the others.", min=2)] = 3,
    static: Annotated[Path | None, option("A friction file whose static map is kept.", metavar="FRICTION.yaml")] = None,
    plant: PlantFile = None,
    blocks: Annotated[int, option("Slip blocks, for models that have any.", min=1)] = 4,
    seed: Annotated[int, option("Seed of the coarse search.", min=0)] = 0,
    circles: Annotated[
        list[Path] | None,
        option("Runs or measured tests of one circle, learned and with a model: what they say.", metavar="CIRCLE.h5"),
    ] = None,
    plot: Plot = None,
    implausible: Implausible = "error",
    json: Json = False,
    force: Force = False,
) -> None:
    """Fit friction models on some records or cycles and score them on others."""
    finish(
        lambda advance: fric.compare(
            *logs, models=models, fit_on=fit_on, cycles=cycles, folds=folds, static=static, plant=plant, blocks=blocks,
            seed=seed, circles=circles or (), advance=advance,
        ),
        None, plot, json=json, force=force, doing="fitting",
    )  # fmt: skip
