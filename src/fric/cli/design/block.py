"""`fric design block`: a control block for an axis, as fast as the margins of the whole loop allow."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import fric
from fric.cli.completion import records
from fric.cli.console import OUT, finish
from fric.cli.options import Force, Implausible, Json


def block(
    name: Annotated[str, typer.Argument(metavar="NAME", help="The control block; list tells which there are.")],
    plant: Annotated[Path | None, typer.Argument(metavar="PLANT.yaml", help="The plant, eq. (1): A, B, T_d.")] = None,
    log: Annotated[
        Path | None,
        typer.Argument(metavar="[LOG.h5]", help="A frequency response, or a record to take it from."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="BLOCK.yaml", help="The block file to write.")
    ] = None,
    friction: Annotated[
        Path | None, typer.Option(metavar="FRICTION.yaml", help="The friction that was identified.")
    ] = None,
    controller: Annotated[
        Path | None,
        typer.Option(metavar="CONTROLLER.yaml", help="The controller; by `fric design controller` where not given."),
    ] = None,
    peak_sensitivity: Annotated[
        str, typer.Option(metavar="GAIN", help="Ms that the whole loop may have at most.")
    ] = "6 dB",
    record: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="The record of LOG.h5 that holds it.", autocompletion=records),
    ] = None,
    joint: Annotated[
        bool, typer.Option("--joint", help="Design the gains of the cascade together with the block.")
    ] = False,
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
