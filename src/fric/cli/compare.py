"""`fric compare`: friction models on samples that none of them was fitted to."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.console import OUT, print_json, print_table, print_warnings, progress
from fric.cli.identify.by_replay import MODELS
from fric.cli.options import Force, Json, LogFiles, PlantFile, Plot
from fric.errors import FricError
from fric.units import readable


def compare(
    logs: LogFiles,
    models: Annotated[
        str, typer.Option(metavar="all|NAME,NAME…", help=f"Models to compare, of {', '.join(MODELS)}.")
    ] = "all",
    fit_on: Annotated[
        list[str] | None,
        typer.Option("--fit-on", metavar="RECORD", help="Fit on this record, score on those not named; repeatable."),
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
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Fit friction models on some records or cycles and score them on others."""
    fric.refuse_existing(plot, force=force)
    names = list(MODELS) if models == "all" else [name.strip() for name in models.split(",")]
    if fit_on and cycles:
        raise FricError("--fit-on and --cycles are two ways to split", mend="Give one of them.")
    records = fric.read_logs(logs)
    axis, motion = records[0].axis, records[0].motion
    kept = fric.read_friction(static, axis=axis, motion=motion) if static else None
    ready = fric.prepared(records, fric.read_plant(plant, axis=axis, motion=motion) if plant else None)
    if fit_on:
        splits = fric.split_by_record(ready, fit_on)
    elif cycles:
        splits = fric.split_by_cycles(ready, cycles)
    else:
        splits = fric.split_by_folds(ready, folds)
    with progress("fitting", total=len(names)) as done:
        comparison = fric.compare_models(
            names,
            ready,
            splits,
            static=kept.estimates("static") if kept else None,
            negative=kept.backward() if kept else None,
            blocks=blocks,
            seed=seed,
            told=done,
        )
    document = fric.comparison_tree(comparison)
    if plot:
        fric.save_figure(fric.draw_comparison(comparison), plot, force=force)
    if json:
        print_json(document)
    else:
        _print(document, plot)
    print_warnings(document["warnings"])


def _print(document: dict[str, Any], plot: Path | None) -> None:
    unit = document["unit"]
    rows = [
        (
            name,
            readable(score["rms"], unit),
            "–" if score["rms_near_reversals"] is None else readable(score["rms_near_reversals"], unit),
            readable(score["rms_fitted"], unit),
            str(score["parameters"]),
            f"{score['bits_per_parameter']:.0f}",
            f"{score['ns_per_step']:.0f} ns",
        )
        for name, score in document["models"].items()
    ]
    print_table(("", "rms scored", "near reversals", "rms fitted", "parameters", "bits per parameter", "a step"), rows)
    if document["winner"]:
        OUT.print(f"best: {document['winner']}, by more than the error of the difference to any other")
    else:
        tied = [
            name for name, lead in document["leads"].items() if lead["error"] is None or lead["lead"] <= lead["error"]
        ]
        best = next(iter(document["models"]))
        OUT.print(f"no winner: the lead of {best} over {', '.join(tied) or 'nothing'} is within its error")
    if plot:
        OUT.print(f"wrote {plot}")
