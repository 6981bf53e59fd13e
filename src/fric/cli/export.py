"""`fric export`: what a controller runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import fric
from fric.cli.completion import axes
from fric.cli.console import finish
from fric.cli.options import Gain, Implausible, Json, Lead, MachineFile, NominalFiles, SchemesFile, lead_given


def export(
    target: Annotated[
        str, typer.Argument(metavar="TARGET", help="c, linuxcnc, fmi, st, twincat, sinumerik, csv, mat or xlsx.")
    ],
    machine: MachineFile,
    axis: Annotated[str, typer.Option("--axis", help="The axis.", autocompletion=axes)],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="DIR", help="Folder for the files.")],
    scheme: Annotated[str, typer.Option("--scheme", help="The scheme: friction feedforward, and blocks.")] = "f",
    part: Annotated[
        str, typer.Option("--part", help="compensation; or machine, the axis itself, to try a controller on.")
    ] = "compensation",
    single: Annotated[bool, typer.Option("--float", help="Single precision (c).")] = False,
    friction: NominalFiles = None,
    gain: Gain = None,
    lead: Lead = None,
    schemes: SchemesFile = None,
    circle: Annotated[
        list[Path] | None,
        typer.Option("--circle", metavar="CIRCLE.h5", help="A measured circle: it must be as the machine predicts."),
    ] = None,
    drawn: Annotated[
        list[Path] | None,
        typer.Option("--run", metavar="RUN.h5", help="The scheme on machines drawn around this one: simulate circle."),
    ] = None,
    trial: Annotated[
        bool, typer.Option("--try", help="linuxcnc: run circles in LinuxCNC, beside their simulation.")
    ] = False,
    force: Annotated[
        bool, typer.Option("--force", help="Replace files that exist, and export what is not to be trusted.")
    ] = False,
    implausible: Implausible = "error",
    json: Json = False,
) -> None:
    """Write what a controller runs: friction feedforward, observers, and a manifest of all that is in it.

    Nothing is exported that the verdict does not trust, unless --force is given. Against it speak a warning of severity
    'wrong' in the machine's files, a limit cycle, a simulated circle that becomes worse, a measured one that is not as
    predicted; it doubts what no machines were drawn for (--run) and no circle was measured for (--circle).
    """
    finish(
        lambda advance: fric.export_axis(
            target, machine, axis=axis, scheme=scheme, part=part, single=single,
            nominal_files=friction or (), gain=gain,
            lead=lead_given(lead), known=schemes, circles=circle or (),
            drawn=drawn or (), trial=output / "trial" if trial else None, force=force, advance=advance,
        ),
        json=json, force=force, doing="LinuxCNC" if trial else "", into=output,
    )  # fmt: skip
