"""Options and arguments that commands share, so that each is spelled and explained once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from fric.cli import completion
from fric.units import parse

LogFiles = Annotated[list[Path], typer.Argument(metavar="LOG.h5…", help="Log files of one axis.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output, nothing else.")]
Force = Annotated[bool, typer.Option("--force", help="Replace an output that exists.")]
Plot = Annotated[
    Path | None,
    typer.Option(
        "--plot",
        metavar="[VIEW=]FIG",
        help="Draw a figure, or that of a name; .png, .svg or .pdf.",
    ),
]
PlantFile = Annotated[
    Path | None,
    typer.Option("--plant", metavar="PLANT.yaml", help="The plant, whose own linear damping is taken off."),
]
PlantArgument = Annotated[Path, typer.Argument(metavar="PLANT.yaml", help="The plant, eq. (1): A, B, T_d.")]
MachineFile = Annotated[Path, typer.Argument(metavar="MACHINE.yaml", help="The machine, as in configs/.")]
SchemeNames = Annotated[
    str, typer.Option("--scheme", help="A scheme's name, several as a,d,f, or all.", autocompletion=completion.schemes)
]
SchemesFile = Annotated[
    Path | None, typer.Option("--schemes", metavar="SCHEMES.yaml", help="Schemes of your own; else the paper's.")
]
NominalFiles = Annotated[
    list[str] | None,
    typer.Option(
        "--friction",
        "--with",
        metavar="AXIS=FILE.yaml",
        help="Friction that the controller of an axis believes; or its plant, controller or observer. Repeatable.",
    ),
]
Gain = Annotated[
    float | None, typer.Option("--gain", help="Gain of the friction feedforward, instead of the machine's.")
]
Lead = Annotated[
    str | None,
    typer.Option(
        "--lead",
        metavar="TIME",
        help='How far feedforward goes ahead of the reference, as "0.6 ms", or auto for the delay of the plant that is '
        "believed; instead of the machine's.",
    ),
]


def _lift(given: str) -> str:
    from fric.plausibility.bounds import lift  # with NumPy, which `--help` need not

    lift(given == "ok")
    return given


Implausible = Annotated[
    Literal["error", "ok"],
    typer.Option(callback=_lift, help="What no drive can be, as with a wrong unit: an error, or taken as it is."),
]
RunFile = Annotated[
    Path | None, typer.Option("-o", "--output", metavar="RUN.h5", help="Keep traces and metrics in this file.")
]


def lead_given(text: str | None) -> Any:
    """Return the lead that an option gives: seconds, ``auto``, or None."""
    return text if text is None or text == "auto" else parse(text, "time")
