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
from fric.log import KINDS, Kind

KindChoice = StrEnum("KindChoice", [(kind, kind) for kind in KINDS])  # type: ignore[misc]


class _Motion(StrEnum):
    linear = "linear"
    rotary = "rotary"


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
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Read logs of a drive into one log file, each a record, in SI units."""
    fric.keep_freed_memory()
    document = fric.read_document(mapping, fric.MappingDocument) if mapping else None
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
