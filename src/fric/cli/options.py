"""Options and arguments that commands share, so that each is spelled and explained once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

LogFiles = Annotated[list[Path], typer.Argument(metavar="LOG.h5…", help="Log files of one axis.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output, nothing else.")]
Force = Annotated[bool, typer.Option("--force", help="Replace an output that exists.")]
Plot = Annotated[
    Path | None,
    typer.Option("--plot", metavar="FIG", help="Draw a figure: .png, .svg or .pdf by the name's ending."),
]
PlantFile = Annotated[
    Path | None,
    typer.Option("--plant", metavar="PLANT.yaml", help="The plant, whose own linear damping is taken off."),
]
