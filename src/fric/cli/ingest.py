"""`fric ingest`: foreign logs into a log file."""

from __future__ import annotations

from dataclasses import asdict
from enum import StrEnum
from pathlib import Path
from typing import Annotated, cast

import typer

import fric
from fric.cli.console import OUT, print_json, print_warnings, progress
from fric.cli.options import Force, Json
from fric.log import CIRCLE, KINDS, Kind
from fric.units import parse, readable

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
        list[Path],
        typer.Argument(metavar="FILE…", help="Logs: text (also .gz), MATLAB .mat, Parquet, fric's own .h5."),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="LOG.h5", help="The log file to write.")],
    mapping: Annotated[
        Path | None,
        typer.Option("--map", metavar="MAP.yaml", help="What the columns mean, where the header does not say it."),
    ] = None,
    kind: Annotated[KindChoice | None, typer.Option(help="The experiment that was logged.")] = None,
    axis: Annotated[str | None, typer.Option(metavar="NAME", help="Name of the axis, such as x.")] = None,
    motion: Annotated[_Motion | None, typer.Option(help="Of the axis, where the units do not tell.")] = None,
    append: Annotated[bool, typer.Option("--append", help="Add to LOG.h5; what it holds already is skipped.")] = False,
    bad_cells: Annotated[
        _BadCells, typer.Option(help="What a cell that is no number is: an error, or a sample to drop.")
    ] = _BadCells.error,
    radius: Annotated[str | None, typer.Option(help="Circle: its nominal radius; else found.")] = None,
    feed: Annotated[str | None, typer.Option(help="Circle: its feed; else found.")] = None,
    sampling: Annotated[str | None, typer.Option(help="Circle: rate of a trace without time, as 4 kHz.")] = None,
    instrument: Annotated[_Instrument | None, typer.Option(help="Circle: what told the position.")] = None,
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
    fric.keep_freed_memory()
    document = fric.read_document(mapping, fric.MappingDocument) if mapping else None
    if (kind.value if kind else document.kind if document else None) == CIRCLE:
        stated = fric.StatedCircle(
            parse(radius, "position") if radius else None,
            parse(feed, "velocity") if feed else None,
            None if clockwise is None else (-1 if clockwise else 1),
            parse(sampling, "frequency") if sampling else None,
            instrument.value if instrument else "",
        )
        with progress("ingesting", total=fric.sizes(files)) as advance:
            circles = fric.ingest_circles(
                files, output, mapping=document, stated=stated, append=append, bad_cells=bad_cells.value, force=force,
                progress=advance,
            )  # fmt: skip
        _tell_circles(circles, as_json)
        return
    if radius or feed or sampling or instrument or clockwise is not None:
        raise typer.BadParameter("--radius, --feed, --sampling, --instrument and the direction go with --kind circle")
    with progress("ingesting", total=fric.sizes(files)) as advance:
        done = fric.ingest(
            files,
            output,
            mapping=document,
            kind=cast("Kind | None", kind.value if kind else None),
            axis=axis,
            motion=motion.value if motion else None,
            append=append,
            bad_cells=bad_cells.value,
            force=force,
            progress=advance,
        )
    print_warnings(done.warnings)
    if as_json:
        print_json(asdict(done) | {"samples": done.samples, "dropped": done.dropped})
        return
    for source, name in done.skipped:
        print_warnings([f"{source} is there already, as record '{name}': skipped"])
    for record in done.records:
        if record.left_out and not mapping:
            print_warnings([f"{record.source}: left out are the columns {', '.join(record.left_out)}"])
    OUT.print(
        f"{len(done.records)} record{'s' * (len(done.records) != 1)} of the {done.motion} axis {done.axis}, "
        f"{done.samples} samples, in {done.output}"
    )


def _tell_circles(done: fric.IngestedCircles, as_json: bool) -> None:
    """Print what circles were read."""
    print_warnings(done.warnings)
    if as_json:
        print_json(done.as_dict())
        return
    for test in done.tests:
        way = "counter-clockwise" if test.direction > 0 else "clockwise"
        held = ", ".join(f"{name}: {' '.join(list(trace.channels())[1:])}" for name, trace in test.axes.items())
        OUT.print(
            f"{test.name}: {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}, {way}; "
            f"{held or 'ball bar: angle deviation'}",
            markup=False,
        )
    OUT.print(f"{len(done.tests)} circle test{'s' * (len(done.tests) != 1)} in {done.output}")
