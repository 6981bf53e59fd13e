"""`fric export`: what a controller runs."""

from pathlib import Path
from typing import Annotated

import fric
from fric.cli.completion import axes
from fric.cli.console import finish
from fric.cli.options import (
    Gain,
    Implausible,
    Json,
    Lead,
    MachineFile,
    NominalFiles,
    SchemesFile,
    argument,
    lead_given,
    option,
)


def export(
    target: Annotated[str, argument("c, linuxcnc, fmi, st, twincat, sinumerik, csv, mat or xlsx.", metavar="TARGET")],
    machine: MachineFile,
    axis: Annotated[str, option("The axis.", autocompletion=axes)],
    output: Annotated[Path, option("Folder for the files.", "-o", "--output", metavar="DIR")],
    scheme: Annotated[str, option("The scheme: friction feedforward, and blocks.")] = "f",
    part: Annotated[str, option("compensation; or machine, the axis itself, to try a controller on.")] = "compensation",
    single: Annotated[bool, option("Single precision (c).", "--float")] = False,
    friction: NominalFiles = None,
    gain: Gain = None,
    lead: Lead = None,
    schemes: SchemesFile = None,
    circle: Annotated[
        list[Path] | None,
        option("A measured circle: it must be as the machine predicts.", metavar="CIRCLE.h5"),
    ] = None,
    drawn: Annotated[
        list[Path] | None,
        option("The scheme on machines drawn around this one: simulate circle.", "--run", metavar="RUN.h5"),
    ] = None,
    trial: Annotated[
        bool, option("linuxcnc, from a checkout of fric: run circles in LinuxCNC, beside their simulation.", "--try")
    ] = False,
    force: Annotated[
        bool, option("Replace files that exist, and export what is not to be trusted.", "--force")
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
