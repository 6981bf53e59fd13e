"""`fric identify gms`: the generalized Maxwell-slip model from pre-sliding loops."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.console import OUT, print_json, print_table, print_warnings, progress
from fric.cli.options import Force, Json, LogFiles, PlantFile, Plot
from fric.errors import FricError
from fric.units import Motion, parse, readable


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
    json: Json = False,
    force: Force = False,
) -> None:
    """Identify alpha, k and C of the GMS model (eqs. 3 to 6) from pre-sliding loops, and C from sliding."""
    fric.refuse_existing(output, plot, force=force)
    records = fric.read_logs(logs)
    axis, motion = records[0].axis, records[0].motion
    given = fric.read_static(static, axis=axis, motion=motion) if static else None
    count, most = _blocks(blocks)
    settings: dict[str, Any] = {
        "static": given.static if given else None,
        "negative": given.negative if given else None,
        "plant": fric.read_plant(plant, axis=axis, motion=motion) if plant else None,
        "blocks": count,
        "knots": _knots(knots, blocks, motion),
        "refined": refine,
        "cycles": _cycles(cycles),
    }
    with progress("virgin curve and replay"):
        fit = fric.identify_gms(records, **settings | ({"most_blocks": most} if most else {}))
    document = fric.gms_tree(fit, records, given)
    if plot:
        fric.save_figure(fric.draw_gms(fit), plot, force=force)
    fric.write_document(output, document, force=force)
    if json:
        print_json(document)
    else:
        _print(document, output, plot)
    print_warnings(document["warnings"])


def _blocks(given: str) -> tuple[int | None, int | None]:
    """Return the number of blocks, or None and the most that the criterion may choose."""
    word, colon, most = given.partition(":")
    number = most if word == "auto" else given
    if word == "auto" and not colon:
        return None, None
    if not number.isdigit() or not 1 <= int(number) <= 12:
        raise FricError(f"'{given}' is not a number of blocks", mend="Give 1 to 12, auto, or auto:8 for 8 at most.")
    return (None, int(number)) if word == "auto" else (int(number), None)


def _knots(given: str, blocks: str, motion: Motion) -> list[float] | None:
    if given == "auto":
        return None
    found = [parse(one, "position", motion) for one in given.split(",")]
    if blocks not in {"auto", str(len(found))}:
        raise FricError(f"{len(found)} knots give {len(found)} blocks, not {blocks}", mend="Leave --blocks out.")
    return found


def _cycles(given: str | None) -> tuple[int, int] | None:
    if given is None:
        return None
    first, _, last = given.partition(":")
    if not (first.isdigit() and last.isdigit() and 1 <= int(first) <= int(last)):
        raise FricError(f"'{given}' is no range of cycles", mend="Write the first and the last, as in 1:5.")
    return int(first), int(last)


def _print(document: dict[str, Any], output: Path, plot: Path | None) -> None:
    print_table(("", "value", "95 % interval", "unit"), fric.estimate_rows(document["gms"]))
    fit = document["gms_fit"]
    OUT.print(fit["blocks"])
    for record in fit["records"]:
        told = f"{record['record']}: rms of measured less replayed force {readable(**record['rmse'])}"
        if "rmse_held_out" in record:
            told += f", {readable(**record['rmse_held_out'])} over the cycles held out"
        if "inertia_share" in (done := record["prepared"]):
            told += f"; inertia {done['inertia_share']:.1%}, damping {done['damping_share']:.1%} of the force"
        OUT.print(told)
    if "assumed" in document["static"]["F_c"]:
        print_table(
            ("plateau", "value", "95 % interval", "unit"), fric.estimate_rows({"F_s": document["static"]["F_s"]})
        )
    else:
        OUT.print(f"alpha summed to {fit['alpha_sum']['value']:.4f} before it was normalised")
    OUT.print(f"wrote {output}" + (f" and {plot}" if plot else ""))
