"""Options and arguments that commands share, so that each is spelled and explained once."""

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from fric.cli import completion
from fric.units import parse


def option(help: str, *names: str, **settings: Any) -> Any:
    """Return an option with its help, under these names or that of the parameter, as `typer.Option` takes the rest."""
    return typer.Option(*names, help=help, **settings)


def argument(help: str, **settings: Any) -> Any:
    """Return an argument with its help, as `typer.Argument` takes the rest."""
    return typer.Argument(help=help, **settings)


LogFiles = Annotated[list[Path], argument("Log files of one axis.", metavar="LOG.h5…")]
Json = Annotated[bool, option("Print one JSON object on standard output, nothing else.", "--json")]
Force = Annotated[bool, option("Replace an output that exists.", "--force")]
Plot = Annotated[
    Path | None, option("Draw a figure, or that of a name; .png, .svg or .pdf.", "--plot", metavar="[VIEW=]FIG")
]
PlantFile = Annotated[
    Path | None, option("The plant, whose own linear damping is taken off.", "--plant", metavar="PLANT.yaml")
]
PlantArgument = Annotated[Path, argument("The plant, eq. (1): A, B, T_d.", metavar="PLANT.yaml")]
ControllerFile = Annotated[
    Path | None, option("The controller; by `fric design controller` where not given.", metavar="CONTROLLER.yaml")
]
PeakSensitivity = Annotated[str, option("Ms that the whole loop may have at most.", metavar="GAIN")]
RecordName = Annotated[
    str | None, option("The record of LOG.h5 that holds it.", metavar="NAME", autocompletion=completion.records)
]
MachineFile = Annotated[Path, argument("The machine, as in configs/.", metavar="MACHINE.yaml")]
SchemeNames = Annotated[
    str, option("A scheme's name, several as a,d,f, or all.", "--scheme", autocompletion=completion.schemes)
]
SchemesFile = Annotated[
    Path | None, option("Schemes of your own; else the paper's.", "--schemes", metavar="SCHEMES.yaml")
]
NominalFiles = Annotated[
    list[str] | None,
    option(
        "Friction that the controller of an axis believes; or its plant, controller or observer. Repeatable.",
        "--friction",
        "--with",
        metavar="AXIS=FILE.yaml",
    ),
]
Gain = Annotated[float | None, option("Gain of the friction feedforward, instead of the machine's.", "--gain")]
Lead = Annotated[
    str | None,
    option(
        'How far feedforward goes ahead of the reference, as "0.6 ms", or auto for the delay of the plant that is '
        "believed; instead of the machine's.",
        "--lead",
        metavar="TIME",
    ),
]


def _lift(given: str) -> str:
    from fric.plausibility.bounds import lift  # with NumPy, which `--help` need not

    lift(given == "ok")
    return given


Implausible = Annotated[
    Literal["error", "ok"],
    option("What no drive can be, as with a wrong unit: an error, or taken as it is.", callback=_lift),
]
RunFile = Annotated[Path | None, option("Keep traces and metrics in this file.", "-o", "--output", metavar="RUN.h5")]


def lead_given(text: str | None) -> Any:
    """Return the lead that an option gives: seconds, ``auto``, or None."""
    return text if text is None or text == "auto" else parse(text, "time")
