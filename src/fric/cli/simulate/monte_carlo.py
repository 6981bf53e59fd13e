"""The part of `fric simulate circle` that runs many machines: `--monte-carlo N`."""

from pathlib import Path
from typing import Annotated

from fric.cli.options import option

Machines = Annotated[
    int | None, option("Run N machines that are drawn around this one.", "--monte-carlo", metavar="N", min=1)
]
SpreadFile = Annotated[
    Path | None, option("What is drawn how widely; else as configs/spread.yaml.", "--spread", metavar="SPREAD.yaml")
]
FromIntervals = Annotated[bool, option("Draw what was identified from its 95 % intervals instead.", "--from-intervals")]
Measured = Annotated[
    list[Path] | None,
    option(
        "A measured circle, which every machine drawn is made to agree with; can be given more than once.",
        "--measured",
        metavar="CIRCLE.h5",
    ),
]
Seed = Annotated[int, option("Seed of the machines that are drawn.", "--seed", min=0)]
Accuracy = Annotated[
    str, option("By how much the integration may move a glitch of the machines drawn; 0 is exact.", "--accuracy")
]
Workers = Annotated[int | None, option("Machines at a time; one a core if not given.", "--workers", min=1)]
Scheduler = Annotated[str | None, option("Run the machines on this Dask cluster.", "--scheduler", metavar="ADDRESS")]
