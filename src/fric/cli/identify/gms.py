"""`fric identify gms`: the generalized Maxwell-slip model from pre-sliding cycles."""

from pathlib import Path
from typing import Annotated, Any

import fric
from fric.cli.console import ERR, finish
from fric.cli.options import Force, Implausible, Json, LogFiles, PlantFile, Plot, option
from fric.output import refuse_existing


def gms(
    logs: LogFiles,
    output: Annotated[Path, option("Friction file to write.", "-o", "--output", metavar="FRICTION.yaml")],
    static: Annotated[
        Path | None, option("Static map, from `fric identify static`; carried over.", metavar="FRICTION.yaml")
    ] = None,
    blocks: Annotated[
        str, option("Slip blocks: N, or up to N (6) by an information criterion.", metavar="N|auto|auto:N")
    ] = "auto",
    knots: Annotated[
        str, option("Knots of the virgin curve, as in '0.9 um, 26 um, 54 um'.", metavar="LIST|auto")
    ] = "auto",
    cycles: Annotated[
        str | None, option("Cycles to fit, from 1; the later ones are held out and replayed.", metavar="FIRST:LAST")
    ] = None,
    interactive: Annotated[
        bool, option("Move the knots by hand, on a page that this computer alone sees.", "--interactive")
    ] = False,
    refine: Annotated[bool, option("Refine alpha, k and C by replay along the measured motion.")] = True,
    plant: PlantFile = None,
    plot: Plot = None,
    implausible: Implausible = "error",
    json: Json = False,
    force: Force = False,
) -> None:
    """Identify alpha, k and C of the GMS model (eqs. 3 to 6) from pre-sliding cycles, and C from sliding."""
    given: dict[str, Any] = {"static": static, "plant": plant, "cycles": cycles}
    if interactive:
        refuse_existing(output, plot, force=force)
        chosen = by_hand(logs, {"blocks": blocks, "knots": knots, "refine": False, **given})
        blocks, knots = "auto", chosen
    finish(
        lambda _: fric.identify_gms(*logs, blocks=blocks, knots=knots, refine=refine, **given),
        output, plot, json=json, force=force, doing="virgin curve and replay",
    )  # fmt: skip


def by_hand(logs: list[Path], given: dict[str, Any]) -> str:
    """Serve a page to move the knots on; return them as ``--knots`` takes them, which is printed, too."""
    from fric.report.knots import KnotPage

    records = fric.read(*logs)
    start = fric.identify_gms(records, **given)
    page = KnotPage(start, lambda knots: fric.identify_gms(records, **given | {"blocks": "auto", "knots": list(knots)}))
    ERR.print(f"move the knots at {page.address} ; Ctrl-C ends without writing", markup=False)
    unit = "um" if start.fit.motion == "linear" else "urad"
    chosen = ", ".join(f"{knot * 1e6:.6g} {unit}" for knot in page.serve())
    ERR.print(f"the same again: --knots '{chosen}'", markup=False)
    return chosen
