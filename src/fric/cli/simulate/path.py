"""`fric simulate path`: any smooth contour under compensation schemes."""

from pathlib import Path
from typing import Annotated

import fric
from fric.cli.console import finish
from fric.cli.options import (
    Force,
    Gain,
    Implausible,
    Json,
    Lead,
    MachineFile,
    NominalFiles,
    Plot,
    RunFile,
    SchemeNames,
    SchemesFile,
    argument,
    lead_given,
    option,
)


def path(
    machine: MachineFile,
    points: Annotated[
        Path,
        argument(
            "Points of the path, headed 'x [mm], y [mm]'; or a recorded reference, with a column 'time [s]' too, "
            "or in a circle or run file.",
            metavar="PATH.csv",
        ),
    ],
    scheme: SchemeNames = "all",
    velocity: Annotated[str, option("Feed along the path; a recorded one has its own.")] = "100 mm/s",
    friction: NominalFiles = None,
    gain: Gain = None,
    lead: Lead = None,
    schemes: SchemesFile = None,
    output: RunFile = None,
    plot: Plot = None,
    force: Force = False,
    implausible: Implausible = "error",
    json: Json = False,
) -> None:
    """Follow a contour given by points under compensation schemes: the glitch at each reversal of an axis."""
    finish(
        lambda advance: fric.path(
            fric.read_machine(machine, nominal_files=friction or (), gain=gain, lead=lead_given(lead)),
            points, scheme, velocity=velocity, known=schemes, advance=advance,
        ),
        output, plot, json=json, force=force, doing="schemes", writes="HDF5",
    )  # fmt: skip
