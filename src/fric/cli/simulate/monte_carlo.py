"""The part of `fric simulate circle` that runs many machines: `--monte-carlo N`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.console import ERR, interruption, print_table, progress

Machines = Annotated[
    int | None,
    typer.Option("--monte-carlo", metavar="N", min=1, help="Run N machines that are drawn around this one."),
]
SpreadFile = Annotated[
    Path | None,
    typer.Option("--spread", metavar="SPREAD.yaml", help="What is drawn how widely; else as configs/spread.yaml."),
]
FromIntervals = Annotated[
    bool,
    typer.Option("--from-intervals", help="Draw what was identified from its 95 % intervals instead."),
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Seed of the machines that are drawn.")]
Accuracy = Annotated[
    str,
    typer.Option("--accuracy", help="By how much the integration may move a glitch of the machines drawn; 0 is exact."),
]
Workers = Annotated[int | None, typer.Option("--workers", min=1, help="Machines at a time; one a core if not given.")]
Scheduler = Annotated[
    str | None, typer.Option("--scheduler", metavar="ADDRESS", help="Run the machines on this Dask cluster.")
]


def run_study(study: Any, machines: int, workers: int | None, scheduler: str | None) -> Any:
    """Run a study with a progress bar; a Ctrl-C keeps the machines that are done."""
    given = (
        fric.cluster_outcomes(study, machines, scheduler)
        if scheduler
        else fric.outcomes(study, machines, workers=workers)
    )
    done: list[Any] = []
    with interruption() as interrupted, progress("machines", total=machines) as advance, given as outcomes:
        for outcome in outcomes:
            done.append(outcome)
            advance()
            if interrupted():
                break
    if not done:
        raise fric.FricError("interrupted before a machine was done", mend="Nothing was written.")
    if len(done) < machines:
        ERR.print(
            f"[bold yellow]interrupted:[/] {len(done)} of {machines} machines are done, and are kept: "
            f"what --monte-carlo {len(done)} gives"
        )
    return fric.MonteCarlo(study, machines, tuple(done))


def print_distributions(found: Any, runs: list[Any], published: Any, title: str, *, intervals: bool) -> None:
    """Print how the glitch of each scheme is distributed: quantiles, or a value with its 95 % interval."""
    rows = []
    nominal = {run.scheme.name: run.circularity.glitch for run in runs}
    for scheme in found.study.schemes:
        one = found.distributions()[scheme.name]
        microns = {name: f"{value * 1e6:.1f}" for name, value in one.quantiles.items()}
        shown = (
            [f"{microns['median']} ({microns['low']} … {microns['high']})"]
            if intervals
            else [microns["p05"], microns["median"], microns["p95"]]
        )
        row = [f"({scheme.name}) {scheme.title}", f"{nominal[scheme.name] * 1e6:.1f}", *shown, f"{one.best:.0%}"]
        if published:
            row.append(f"{published[scheme.name] * 1e6:.0f}" if scheme.name in published else "")
        rows.append(row)
    quantiles = ["median (95 % interval)"] if intervals else ["5 %", "median", "95 %"]
    centre = "at the estimates" if intervals else "nominal"
    columns = ["scheme", centre, *quantiles, "best on", *(["paper"] if published else [])]
    print_table(columns, rows, title)
