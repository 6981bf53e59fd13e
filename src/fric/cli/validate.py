"""`fric validate`: a recorded motion replayed by the identified axis."""

from pathlib import Path
from typing import Annotated

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Implausible, Json, LogFiles, Plot, option


def validate(
    logs: LogFiles,
    plant: Annotated[Path, option("The identified plant.", metavar="PLANT.yaml")],
    controller: Annotated[
        Path | None, option("The drive's own controller; without it, the open loop alone.", metavar="CONTROLLER.yaml")
    ] = None,
    friction: Annotated[
        Path | None, option("The identified friction; else Coulomb, from the plant's own fit.", metavar="FRICTION.yaml")
    ] = None,
    model: Annotated[str | None, option("The friction file's model, where it holds several.", metavar="NAME")] = None,
    load: Annotated[
        str | None, option('Constant load, as "-3.2 N"; else the identified offset.', metavar="FORCE")
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
