"""Foreign traces of circle tests, read into one circle test file."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

from fric.documents.records import IngestCirclesDocument
from fric.io.ingest import sizes
from fric.io.ingest_circle import IngestedCircles, StatedCircle
from fric.io.ingest_circle import ingest_circles as read_circles
from fric.results.base import Result
from fric.results.given import Advance, quantity, silent
from fric.results.ingest import mapping_of
from fric.results.kinds import MappingLike, Quantity, SchemeName
from fric.results.text import Piece
from fric.units import readable
from fric.verb import Kind, verb


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
        return IngestCirclesDocument.made(self.done, notices=self.done.warnings).tree()

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


@verb
def ingest_circles(
    *files: Annotated[Path | str, Kind(metavar="FILE")],
    output: Annotated[Path | str, Kind(metavar="LOG.h5")],
    mapping: MappingLike | None = None,
    radius: Annotated[Quantity | None, "position"] = None,
    feed: Annotated[Quantity | None, "velocity"] = None,
    sampling: Annotated[Quantity | None, "frequency"] = None,
    instrument: Literal["encoders", "grid", "ball-bar"] | None = None,
    scheme: SchemeName | None = None,
    clockwise: bool | None = None,
    append: bool = False,
    bad_cells: Literal["error", "drop"] = "error",
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
    radius
        Circle: its nominal radius; else found.
    feed
        Circle: its feed; else found.
    sampling
        Circle: rate of a trace without time, as 4 kHz.
    instrument
        Circle: what told the position.
    scheme
        Circle: the compensation that was on, as f. A prediction is made with it.
    clockwise
        Circle: its direction; else found.
    append, bad_cells, force, advance
        As in `fric.ingest`.

    Raises
    ------
    FricError
        When a file does not read, or there is no whole circle in it.
    """
    paths, direction = list(map(Path, files)), -1 if clockwise else 1
    stated = StatedCircle(
        quantity(radius, "position"),
        quantity(feed, "velocity"),
        None if clockwise is None else direction,
        quantity(sampling, "frequency"),
        instrument or "",
        scheme or "",
    )
    advance(0, total=sizes(paths))
    given: dict[str, Any] = {"append": append, "bad_cells": bad_cells, "force": force, "progress": advance}
    return CirclesResult(read_circles(paths, Path(output), mapping=mapping_of(mapping), stated=stated, **given))
