"""`fric simulate map`: the glitch of each scheme over feed and radius."""

from pathlib import Path
from typing import Annotated

import typer

import fric
from fric.cli.console import finish, interruption
from fric.cli.options import (
    Force,
    Gain,
    Json,
    Lead,
    MachineFile,
    NominalFiles,
    Plot,
    SchemeNames,
    SchemesFile,
    lead_given,
    option,
)
from fric.cli.simulate import monte_carlo as many


def circle_map(
    machine: MachineFile,
    feeds: Annotated[str, option("A range, or feeds with commas.")] = "5 … 200 mm/s",
    radii: Annotated[str, option("A range, or radii with commas.")] = "5 … 100 mm",
    scheme: SchemeNames = "a,b,c,f",
    points: Annotated[int, option("Values that a range stands for.", min=2)] = 6,
    friction: NominalFiles = None,
    gain: Gain = None,
    lead: Lead = None,
    schemes: SchemesFile = None,
    accuracy: many.Accuracy = "0.005 um",
    workers: many.Workers = None,
    scheduler: many.Scheduler = None,
    output: Annotated[Path | None, option("Keep the map in this file.", "-o", "--output", metavar="MAP.yaml")] = None,
    plot: Plot = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Run circles of many feeds and radii: where GMS beats the static map, by how much, where the observer spoils.

    Ctrl-C keeps the circles that are done; the others stay empty.
    """
    with interruption() as interrupted:
        made = finish(
            lambda advance: fric.circle_map(
                fric.read_machine(machine, nominal_files=friction or (), gain=gain, lead=lead_given(lead)),
                scheme, feeds=feeds, radii=radii, points=points, known=schemes, accuracy=accuracy, workers=workers,
                scheduler=scheduler, advance=advance, interrupted=interrupted,
            ),
            output, plot, json=json, force=force, doing="circles",
        )  # fmt: skip
    if made.cut_short:
        raise typer.Exit(interrupted.status)
