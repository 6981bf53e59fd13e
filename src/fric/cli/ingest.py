"""`fric ingest`: foreign logs into a log file."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

import fric
from fric.cli.console import OUT, finish, print_json
from fric.cli.options import Force, Json, argument, option
from fric.columns import CIRCLE, KINDS
from fric.errors import printable
from fric.units import Motion

KindChoice = StrEnum("KindChoice", [(kind, kind) for kind in (*KINDS, CIRCLE)])  # type: ignore[misc]


def ingest(
    files: Annotated[
        list[Path] | None, argument("Logs: text (also .gz), .mat, .mf4, …; --list tells the formats.", metavar="FILE…")
    ] = None,
    output: Annotated[Path | None, option("The log file to write.", "-o", "--output", metavar="LOG.h5")] = None,
    mapping: Annotated[
        Path | None, option("What the columns mean, where the header does not say it.", "--map", metavar="MAP.yaml")
    ] = None,
    kind: Annotated[
        KindChoice | None, option(f"What was logged: {', '.join((*KINDS, CIRCLE))}.", metavar="KIND")
    ] = None,
    axis: Annotated[str | None, option("Name of the axis, such as x.", metavar="NAME")] = None,
    motion: Annotated[Motion | None, option("Of the axis, where the units do not tell.")] = None,
    append: Annotated[bool, option("Add to LOG.h5; what it holds already is skipped.", "--append")] = False,
    bad_cells: Annotated[
        Literal["error", "drop"], option("What a cell that is no number is: an error, or a sample to drop.")
    ] = "error",
    begin: Annotated[str | None, option("First time to read, as 8.5 s.", "--from", metavar="TIME")] = None,
    end: Annotated[str | None, option("Last time to read.", "--to", metavar="TIME")] = None,
    join: Annotated[
        bool, option("One record of all files: its channels were logged apart, by one clock.", "--join")
    ] = False,
    propose: Annotated[
        Path | None,
        option("Write the mapping that would be guessed; read nothing in.", metavar="MAP.yaml"),
    ] = None,
    list_formats: Annotated[
        bool, option("List the formats that are read, and which libraries are installed.", "--list")
    ] = False,
    radius: Annotated[str | None, option("Circle: its nominal radius; else found.")] = None,
    feed: Annotated[str | None, option("Circle: its feed; else found.")] = None,
    sampling: Annotated[str | None, option("Circle: rate of a trace without time, as 4 kHz.")] = None,
    instrument: Annotated[
        Literal["encoders", "grid", "ball-bar"] | None, option("Circle: what told the position.")
    ] = None,
    scheme: Annotated[str | None, option("Circle: the compensation that was on, as f.")] = None,
    clockwise: Annotated[
        bool | None, option("Circle: its direction; else found.", "--clockwise/--counter-clockwise")
    ] = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Read logs of a drive into one log file, each a record, in SI units.

    Of kind circle: traces of two axes on a circle, LinuxCNC's sampler text, or angle and deviation of a ball bar, into
    a circle test file for `fric diagnose` and `fric tune`.
    """
    from fric.io.memory import keep_freed_memory

    if list_formats:
        finish(lambda _: fric.formats(), json=as_json)
        return
    if not files:
        raise typer.BadParameter("name the files to read; `fric ingest --list` tells the formats")
    if propose is not None:
        from fric.io.propose import propose as propose_mapping

        text = propose_mapping(files, propose, force=force, join=join)
        if as_json:
            print_json({"output": str(propose), "mapping": text})
        else:
            OUT.print(text, markup=False)
            OUT.print(f"wrote {printable(str(propose))}: look at it, edit it, and give it with --map", markup=False)
        return
    if output is None:
        raise typer.BadParameter("say which log file to write: -o LOG.h5")
    keep_freed_memory()
    given: dict[str, Any] = {"output": output, "mapping": mapping, "append": append, "bad_cells": bad_cells}
    circle = {"radius": radius, "feed": feed, "sampling": sampling, "clockwise": clockwise, "instrument": instrument}
    if fric.holds_circles(mapping, kind.value if kind else None):
        given |= circle | {"scheme": scheme or ""}
        make: Any = fric.ingest_circles
    elif scheme or any(value is not None for value in circle.values()):
        misplaced = "--radius, --feed, --sampling, --instrument, --scheme and the direction go with --kind circle"
        raise typer.BadParameter(misplaced)
    else:
        given |= {"kind": kind.value if kind else None, "axis": axis, "motion": motion}
        given |= {"begin": begin, "end": end, "join": join}
        make = fric.ingest
    finish(lambda advance: make(*files, force=force, advance=advance, **given), json=as_json, doing="ingesting")
