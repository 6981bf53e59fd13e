"""`fric design block`: a control block for an axis, as fast as the margins of the whole loop allow."""

from pathlib import Path
from typing import Annotated

import typer

import fric
from fric.cli.console import OUT, finish
from fric.cli.options import ControllerFile, Force, Implausible, Json, PeakSensitivity, RecordName, argument, option


def block(
    name: Annotated[str, argument("The control block; list tells which there are.", metavar="NAME")],
    plant: Annotated[Path | None, argument("The plant, eq. (1): A, B, T_d.", metavar="PLANT.yaml")] = None,
    log: Annotated[
        Path | None, argument("A frequency response, or a record to take it from.", metavar="[LOG.h5]")
    ] = None,
    output: Annotated[Path | None, option("The block file to write.", "-o", "--output", metavar="BLOCK.yaml")] = None,
    friction: Annotated[Path | None, option("The friction that was identified.", metavar="FRICTION.yaml")] = None,
    controller: ControllerFile = None,
    peak_sensitivity: PeakSensitivity = "6 dB",
    record: RecordName = None,
    joint: Annotated[bool, option("Design the gains of the cascade together with the block.", "--joint")] = False,
    implausible: Implausible = "error",
    as_json: Json = False,
    force: Force = False,
) -> None:
    """Design a control block of an axis from its plant, its friction and a measured response.

    What feeds back is made as fast as the peak sensitivity of the whole loop allows, with the response as it was
    measured; a block that is not linear is judged around rest. Feedforward is fitted to the friction.
    """
    if name == "list":
        from fric.control import blocks

        for kind in blocks().values():
            linear = "linear" if kind.linear else "not linear"
            OUT.print(f"{kind.name}  {kind.kind}, {linear}; asks for: {kind.asks}")
        return
    if plant is None:
        raise typer.BadParameter("PLANT.yaml is missing")
    finish(
        lambda _: fric.design_block(
            name, plant, log, friction=friction, controller=controller, peak_sensitivity=peak_sensitivity,
            record=record, joint=joint,
        ),
        output,
        json=as_json,
        force=force,
    )  # fmt: skip
