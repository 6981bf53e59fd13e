"""Foreign traces of circle tests, read into one circle test file."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from fric.documents.mapping import MappingDocument
from fric.documents.records import IngestCirclesDocument
from fric.io.ingest import sizes
from fric.io.ingest_circle import IngestedCircles, StatedCircle
from fric.io.ingest_circle import ingest_circles as read_circles
from fric.io.ingest_session import BadCells
from fric.results.base import Result
from fric.results.given import Advance, quantity, silent
from fric.results.ingest import mapping_of
from fric.results.text import Piece
from fric.units import readable
from fric.verb import verb


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
        scheme,
    )
    advance(0, total=sizes(paths))
    given: dict[str, Any] = {"append": append, "bad_cells": bad_cells, "force": force, "progress": advance}
    return CirclesResult(read_circles(paths, Path(output), mapping=mapping_of(mapping), stated=stated, **given))
