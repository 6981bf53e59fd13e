"""The part of `fric simulate circle` that runs many machines: `--monte-carlo N`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

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
Measured = Annotated[
    list[Path] | None,
    typer.Option(
        "--measured",
        metavar="CIRCLE.h5",
        help="A measured circle, which every machine drawn is made to agree with; can be given more than once.",
    ),
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
