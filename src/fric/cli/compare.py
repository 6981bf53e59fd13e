"""`fric compare`: friction models on samples that none of them was fitted to."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import fric
from fric.cli.completion import records
from fric.cli.console import finish
from fric.cli.identify.by_replay import MODELS
from fric.cli.options import Force, Implausible, Json, LogFiles, PlantFile, Plot


def compare(
    logs: LogFiles,
    models: Annotated[
        str, typer.Option(metavar="all|NAME,NAME…", help=f"Models to compare, of {', '.join(MODELS)}.")
    ] = "all",
    fit_on: Annotated[
        list[str] | None,
        typer.Option(
            "--fit-on",
            metavar="RECORD",
            help="Fit on this record, score on those not named; repeatable.",
            autocompletion=records,
        ),
    ] = None,
    cycles: Annotated[
        int | None,
        typer.Option(min=1, metavar="N", help="Fit on the first N cycles of a record, score on the rest."),
    ] = None,
    folds: Annotated[
        int, typer.Option(min=2, help="Cut each record in so many parts, each scored by a fit to the others.")
    ] = 3,
    static: Annotated[
        Path | None, typer.Option(metavar="FRICTION.yaml", help="A friction file whose static map is kept.")
    ] = None,
    plant: PlantFile = None,
    blocks: Annotated[int, typer.Option(min=1, help="Slip blocks, for models that have any.")] = 4,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the coarse search.")] = 0,
    circles: Annotated[
        list[Path] | None,
        typer.Option(
            "--circles", metavar="RUN.h5", help="Runs of one circle, learned and with a model: what they say."
        ),
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
