"""`fric identify gms`: the generalized Maxwell-slip model from pre-sliding cycles."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Implausible, Json, LogFiles, PlantFile, Plot


def gms(
    logs: LogFiles,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FRICTION.yaml", help="Friction file to write.")],
    static: Annotated[
        Path | None,
        typer.Option(metavar="FRICTION.yaml", help="Static map, from `fric identify static`; carried over."),
    ] = None,
    blocks: Annotated[
        str, typer.Option(metavar="N|auto|auto:N", help="Slip blocks: N, or up to N (6) by an information criterion.")
    ] = "auto",
    knots: Annotated[
        str, typer.Option(metavar="LIST|auto", help="Knots of the virgin curve, as in '0.9 um, 26 um, 54 um'.")
    ] = "auto",
    cycles: Annotated[
        str | None,
        typer.Option(metavar="FIRST:LAST", help="Cycles to fit, from 1; the later ones are held out and replayed."),
    ] = None,
    refine: Annotated[bool, typer.Option(help="Refine alpha, k and C by replay along the measured motion.")] = True,
    plant: PlantFile = None,
    plot: Plot = None,
    implausible: Implausible = "error",
    json: Json = False,
    force: Force = False,
) -> None:
    """Identify alpha, k and C of the GMS model (eqs. 3 to 6) from pre-sliding cycles, and C from sliding."""
    finish(
        lambda _: fric.identify_gms(
            *logs, static=static, plant=plant, blocks=blocks, knots=knots, cycles=cycles, refine=refine
        ),
        output, plot, json=json, force=force, doing="virgin curve and replay",
    )  # fmt: skip
