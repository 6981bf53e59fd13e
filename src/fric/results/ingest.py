"""Foreign logs, read into one log file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from fric.columns import CIRCLE, Kind
from fric.documents.mapping import MappingDocument
from fric.documents.records import IngestCirclesDocument, IngestDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.io.ingest import Ingested, sizes
from fric.io.ingest import ingest as read_foreign
from fric.io.ingest_circle import IngestedCircles, StatedCircle
from fric.io.ingest_circle import ingest_circles as read_circles
from fric.io.ingest_session import BadCells
from fric.results.base import Result
from fric.results.given import Advance, in_si, path_of, quantity, silent
from fric.results.records import inspect, read
from fric.results.text import Piece
from fric.units import Motion, readable

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False)
class IngestResult(Result):
    """What was read into a log file.

    Parameters
    ----------
    done
        The log file, its axis, and the records that were added or skipped.
    mapped
        Whether a mapping told what the columns mean.
    """

    done: Ingested
    mapped: bool

    @cached_property
    def document(self) -> dict[str, Any]:
        """The records that were added and skipped."""
        counts = {"samples": self.done.samples, "dropped": self.done.dropped}
        return IngestDocument.made(asdict(self.done) | counts, notices=self.warnings).tree()

    @property
    def warnings(self) -> Sequence[str]:
        """What was skipped, left out or wrong."""
        skipped = [f"{source} is there already, as record '{name}': skipped" for source, name in self.done.skipped]
        left_out = [
            f"{record.source}: left out are the columns {', '.join(record.left_out)}"
            for record in self.done.records
            if record.left_out and not self.mapped
        ]
        return [*self.done.warnings, *skipped, *left_out]

    def report(self) -> list[Piece]:
        """Return how much was read."""
        done, count = self.done, len(self.done.records)
        of = f"{count} record{'s' * (count != 1)} of the {done.motion} axis {done.axis}"
        return [f"{of}, {done.samples} samples, in {done.output}"]

    def figure(self) -> Figure:
        """Return what each record of the log file holds."""
        return inspect(self.done.output).figure()

    def to_frame(self) -> pd.DataFrame:
        """Return the samples of the log file, as `Records` gives them."""
        return read(self.done.output).to_frame()


def ingest(
    *files: Path | str,
    output: Path | str,
    mapping: MappingDocument | Path | str | None = None,
    kind: Kind | None = None,
    axis: str | None = None,
    motion: Motion | None = None,
    append: bool = False,
    bad_cells: BadCells = "error",
    begin: float | str | None = None,
    end: float | str | None = None,
    join: bool = False,
    force: bool = False,
    advance: Advance = silent,
) -> IngestResult:
    """Read foreign logs of one axis into a log file, one record a file, in SI.

    Parameters
    ----------
    files
        Text logs (also ``.gz``), MATLAB ``.mat``, Parquet, or log files of fric's own.
    output
        The log file that is written, whole or not at all.
    mapping
        What the columns mean, or its file. Without it the header must name channels and units: ``time [s]``.
    kind, axis, motion
        Kind of the experiment, name and motion of the axis; they go before what mapping and files say.
    append
        Add to the log file. A file that it holds already (by its sha256) is skipped.
    bad_cells
        ``error``: a cell that is no number is an error; ``drop``: its sample is left out, and counted.
    begin, end
        First and last time that is read [s], or as ``"8.5 s"``; all where not given.
    join
        Make one record of all files, whose channels were logged by one clock.
    force
        Replace an output that exists.
    advance
        Is told of the bytes that are read.

    Raises
    ------
    FricError
        When a file cannot be read, a column has no meaning, or a cell is no number.
    """
    paths, mapping = [path_of("ingest", "files", one) for one in files], _mapping(mapping)
    advance(0, total=sizes(paths))
    done = read_foreign(
        paths,
        Path(output),
        mapping=mapping,
        kind=kind,
        axis=axis,
        motion=motion,
        append=append,
        bad_cells=bad_cells,
        force=force,
        progress=advance,
        window=_window(begin, end),
        join=join,
    )
    return IngestResult(done, mapping is not None)


def _window(begin: float | str | None, end: float | str | None) -> tuple[float, float]:
    low = -inf if begin is None else in_si(begin, "time")
    high = inf if end is None else in_si(end, "time")
    if not low < high:
        raise FricError(f"a window from {low:g} to {high:g} s holds nothing", hint="Give --from before --to.")
    return low, high


def _mapping(given: MappingDocument | Path | str | None) -> MappingDocument | None:
    return read_document(Path(given), MappingDocument) if isinstance(given, str | Path) else given


@dataclass(frozen=True, eq=False, repr=False)
class CirclesResult(Result):
    """What was read into a circle test file.

    Parameters
    ----------
    done
        The file, and the tests in it.
    """

    done: IngestedCircles

    @cached_property
    def document(self) -> dict[str, Any]:
        """The tests that were added."""
        return IngestCirclesDocument.made(self.done.as_dict(), notices=self.done.warnings).tree()

    def report(self) -> list[Piece]:
        """Return a line a test."""
        pieces: list[Piece] = []
        for test in self.done.tests:
            sense = "counter-clockwise" if test.direction > 0 else "clockwise"
            held = ", ".join(f"{name}: {' '.join(list(trace.channels())[1:])}" for name, trace in test.axes.items())
            of = f"{test.name}: {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}, {sense}"
            pieces.append(f"{of}; {held or 'ball bar: angle deviation'}")
        count = len(self.done.tests)
        return [*pieces, f"{count} circle test{'s' * (count != 1)} in {self.done.output}"]


def holds_circles(mapping: MappingDocument | Path | str | None = None, kind: str | None = None) -> bool:
    """Return whether files are of circles: where the kind, or else the mapping, says so.

    Parameters
    ----------
    mapping
        What the columns mean, or its file.
    kind
        The kind that is stated.
    """
    found = _mapping(mapping)
    return (kind or (found.kind if found else None)) == CIRCLE


def ingest_circles(
    *files: Path | str,
    output: Path | str,
    mapping: MappingDocument | Path | str | None = None,
    radius: float | str | None = None,
    feed: float | str | None = None,
    clockwise: bool | None = None,
    sampling: float | str | None = None,
    instrument: Literal["encoders", "grid", "ball-bar"] | None = None,
    scheme: str = "",
    append: bool = False,
    bad_cells: BadCells = "error",
    force: bool = False,
    advance: Advance = silent,
) -> CirclesResult:
    """Read traces of circle tests, or a ball bar's angle and radial deviation, into a circle test file.

    Parameters
    ----------
    files
        Text (also ``.gz``, also LinuxCNC's sampler), MATLAB ``.mat``, Parquet. A trace may hold several circles.
    output
        The circle test file that is written, whole or not at all.
    mapping
        What the columns mean, or its file. Without it the header must name axes and units: ``x_ref [mm]``.
    radius, feed, clockwise
        Nominal radius [m], feed [m/s] and direction; found where not given.
    sampling
        Rate of a trace without time [Hz].
    instrument
        What told the position: ``encoders``, ``grid`` or ``ball-bar``.
    scheme
        Name of the compensation that was on, which a prediction is then made with; none where not given.
    append, bad_cells, force, advance
        As in `ingest`.

    Raises
    ------
    FricError
        When a file does not read, or there is no whole circle in it.
    """
    paths, direction = [path_of("ingest_circles", "files", one) for one in files], -1 if clockwise else 1
    stated = StatedCircle(
        quantity(radius, "position"),
        quantity(feed, "velocity"),
        None if clockwise is None else direction,
        quantity(sampling, "frequency"),
        instrument or "",
        scheme,
    )
    advance(0, total=sizes(paths))
    given: dict[str, Any] = {"append": append, "bad_cells": bad_cells, "force": force, "progress": advance}
    return CirclesResult(read_circles(paths, Path(output), mapping=_mapping(mapping), stated=stated, **given))
