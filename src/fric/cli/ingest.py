"""`fric ingest`: foreign logs into a log file."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.console import OUT, finish, print_json
from fric.cli.options import Force, Json
from fric.columns import CIRCLE, KINDS
from fric.errors import printable

KindChoice = StrEnum("KindChoice", [(kind, kind) for kind in (*KINDS, CIRCLE)])  # type: ignore[misc]


class _Motion(StrEnum):
    linear = "linear"
    rotary = "rotary"


class _Instrument(StrEnum):
    encoders = "encoders"
    grid = "grid"
    ball_bar = "ball-bar"


class _BadCells(StrEnum):
    error = "error"
    drop = "drop"


def ingest(
    files: Annotated[
        list[Path] | None,
        typer.Argument(metavar="FILE…", help="Logs: text (also .gz), .mat, .mf4, …; --list tells the formats."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="LOG.h5", help="The log file to write.")
    ] = None,
    mapping: Annotated[
        Path | None,
        typer.Option("--map", metavar="MAP.yaml", help="What the columns mean, where the header does not say it."),
    ] = None,
    kind: Annotated[
        KindChoice | None, typer.Option(metavar="KIND", help=f"What was logged: {', '.join((*KINDS, CIRCLE))}.")
    ] = None,
    axis: Annotated[str | None, typer.Option(metavar="NAME", help="Name of the axis, such as x.")] = None,
    motion: Annotated[_Motion | None, typer.Option(help="Of the axis, where the units do not tell.")] = None,
    append: Annotated[bool, typer.Option("--append", help="Add to LOG.h5; what it holds already is skipped.")] = False,
    bad_cells: Annotated[
        _BadCells, typer.Option(help="What a cell that is no number is: an error, or a sample to drop.")
    ] = _BadCells.error,
    begin: Annotated[str | None, typer.Option("--from", metavar="TIME", help="First time to read, as 8.5 s.")] = None,
    end: Annotated[str | None, typer.Option("--to", metavar="TIME", help="Last time to read.")] = None,
    join: Annotated[
        bool, typer.Option("--join", help="One record of all files: its channels were logged apart, by one clock.")
    ] = False,
    propose: Annotated[
        Path | None,
        typer.Option("--propose", metavar="MAP.yaml", help="Write the mapping that would be guessed; read nothing in."),
    ] = None,
    list_formats: Annotated[
        bool, typer.Option("--list", help="List the formats that are read, and which libraries are installed.")
    ] = False,
    radius: Annotated[str | None, typer.Option(help="Circle: its nominal radius; else found.")] = None,
    feed: Annotated[str | None, typer.Option(help="Circle: its feed; else found.")] = None,
    sampling: Annotated[str | None, typer.Option(help="Circle: rate of a trace without time, as 4 kHz.")] = None,
    instrument: Annotated[_Instrument | None, typer.Option(help="Circle: what told the position.")] = None,
    scheme: Annotated[str | None, typer.Option(help="Circle: the compensation that was on, as f.")] = None,
    clockwise: Annotated[
        bool | None, typer.Option("--clockwise/--counter-clockwise", help="Circle: its direction; else found.")
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
    given: dict[str, Any] = {"output": output, "mapping": mapping, "append": append, "bad_cells": bad_cells.value}
    circle = {"radius": radius, "feed": feed, "sampling": sampling, "clockwise": clockwise}
    circle |= {"instrument": instrument.value if instrument else None}
    if fric.holds_circles(mapping, kind.value if kind else None):
        given |= circle | {"scheme": scheme or ""}
        make: Any = fric.ingest_circles
    elif scheme or any(value is not None for value in circle.values()):
        told = "--radius, --feed, --sampling, --instrument, --scheme and the direction go with --kind circle"
        raise typer.BadParameter(told)
    else:
        given |= {"kind": kind.value if kind else None, "axis": axis, "motion": motion.value if motion else None}
        given |= {"begin": begin, "end": end, "join": join}
        make = fric.ingest
    finish(lambda advance: make(*files, force=force, advance=advance, **given), json=as_json, doing="ingesting")
