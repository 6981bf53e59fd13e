"""Any smooth contour under compensation schemes."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from fric.documents.contours import PathResultDocument
from fric.io.circle import read_path
from fric.notice import Notice, once
from fric.results.base import Result
from fric.results.given import Advance, bounded, path_of, silent
from fric.results.given_models import machine_of, schemes_of
from fric.results.kinds import KnownSchemes, MachineLike, PathLike, Quantity, SchemesLike
from fric.results.text import Piece, Table
from fric.simulate.contour_run import reduction
from fric.simulate.machine import Machine
from fric.simulate.path import PathRun, PointPath, RecordedPath, run_path
from fric.units import readable
from fric.verb import verb
from fric.verdict import facts


@dataclass(frozen=True, eq=False, repr=False)
class PathResult(Result, schema=PathResultDocument):
    """The errors that schemes leave on a path."""

    machine: Machine  # The machine
    runs: Sequence[PathRun]  # A run for each scheme
    name: str  # Description of the path

    @property
    def warnings(self) -> Sequence[Notice]:
        """Warnings for the user."""
        text = [notice.at(f"scheme {run.scheme.name}") for run in self.runs for notice in run.warnings]
        return once([*self.machine.warnings, *text])

    def report(self) -> list[Piece]:
        """Return the error under each scheme, and the glitch at each reversal."""
        title = f"{self.machine.name}: {self.name} at {readable(self.runs[0].path.feed, 'm/s')}; contour error in µm"
        text: list[Piece] = [
            Table(["scheme", "glitch", "rms", "range", "reduction"], [self._row(run) for run in self.runs], title)
        ]
        worst = max(self.runs, key=lambda run: run.contour.glitch)
        names = tuple(worst.traces)
        rows = [
            [f"{names[reversal.axis]} turns at {reversal.x * 1e3:z.1f}, {reversal.y * 1e3:z.1f} mm"]
            + [run.glitches[n].text() for run in self.runs]
            for n, reversal in enumerate(worst.contour.reversals)
        ]
        columns = ["reversal", *(f"({run.scheme.name})" for run in self.runs)]
        return [*text, Table(columns, rows, "glitch at each reversal in µm")] if rows else text

    def _row(self, run: PathRun) -> list[str]:
        less = reduction(run, self.runs)
        microns = [chance.text() for chance in (run.chance(), run.chance("rms"), run.chance("range"))]
        return [f"({run.scheme.name}) {run.scheme.title}", *microns, "" if less is None else f"{less:.0%}"]

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write traces and metrics to a run file."""
        from fric.io.run import write_runs  # with HDF5, which a table needs not

        made = json.dumps(facts(self.machine, self.runs))
        write_runs(Path(path), self.runs, made, force=force)

    def by_row(self) -> dict[str, dict[str, Any]]:
        """Return glitch and contour error by scheme [m]."""
        return {
            run.scheme.name: {"title": run.scheme.title}
            | {key: run.chance(key).median for key in ("glitch", "rms", "range")}
            for run in self.runs
        }


@verb
def path(
    machine: MachineLike,
    points: PathLike,
    schemes: SchemesLike = "all",
    *,
    velocity: Annotated[Quantity, "velocity"] = "100 mm/s",
    known: KnownSchemes | None = None,
    advance: Advance = silent,
) -> PathResult:
    """Follow a contour given by points under compensation schemes: the glitch at each reversal of an axis.

    Parameters
    ----------
    points
        Points of the path, headed 'x [mm], y [mm]'; or a recorded reference, with a column 'time [s]' too, or in a
        circle or run file. A recorded reference is followed in its own time.
    velocity
        Feed along the path; a recorded path has its time. So does a path that is given directly.

    Raises
    ------
    FricError
        When the path has a corner, or the machine cannot follow it.
    """
    subject = machine_of(machine)
    if isinstance(points, PointPath | RecordedPath):
        name, followed = "path", points
    else:
        file = path_of("points, or their file", points)
        name, followed = file.name, read_path(file, bounded("speed", velocity))
    chosen = schemes_of(schemes, known)
    advance(0, total=len(chosen))
    runs = []
    for wanted in chosen:
        runs.append(run_path(subject, wanted, followed))
        advance()
    return PathResult(subject, runs, name)
