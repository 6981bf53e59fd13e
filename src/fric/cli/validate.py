"""`fric validate`: a recorded motion replayed by the identified axis."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Implausible, Json, LogFiles, Plot


def validate(
    logs: LogFiles,
    plant: Annotated[Path, typer.Option("--plant", metavar="PLANT.yaml", help="The identified plant.")],
    controller: Annotated[
        Path | None,
        typer.Option(metavar="CONTROLLER.yaml", help="The drive's own controller; without it, the open loop alone."),
    ] = None,
    friction: Annotated[
        Path | None,
        typer.Option(metavar="FRICTION.yaml", help="The identified friction; else Coulomb, from the plant's own fit."),
    ] = None,
    model: Annotated[
        str | None, typer.Option(metavar="NAME", help="The friction file's model, where it holds several.")
    ] = None,
    load: Annotated[
        str | None, typer.Option(metavar="FORCE", help='Constant load, as "-3.2 N"; else the identified offset.')
    ] = None,
    plot: Plot = None,
    implausible: Implausible = "error",
    json: Json = False,
    force: Force = False,
) -> None:
    """Replay a recorded motion in closed loop, in open loop and inversely, and score it against the record."""
    finish(
        lambda _: fric.validate(
            *logs, plant=plant, controller=controller, friction=friction, model=model, load=load
        ),
        None, plot, json=json, force=force, doing="replaying",
    )  # fmt: skip
