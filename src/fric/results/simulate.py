"""Contours under compensation schemes: a circle on one machine or on many, circles of many feeds and radii, a path."""

import json
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from fric.circles.prediction import Prediction
from fric.contour import QUADRANTS
from fric.documents.contours import CircleMapDocument, CircleResultDocument, PathResultDocument
from fric.documents.machine_files import IdentifiedMachine, read_spreads
from fric.errors import FricError, names
from fric.flaws.prediction import INTERRUPTED, SCHEME_FAILED
from fric.notice import Notice, once
from fric.results.base import Advance, DataFrame, Figure, Piece, Result, Table, bounded, in_si, path_of, silent
from fric.results.given_models import circles_of, machine_of, schemes_of
from fric.results.kinds import (
    Address,
    AxisName,
    CirclesLike,
    Count,
    KnownSchemes,
    MachineLike,
    Quantities,
    Quantity,
    SchemesLike,
    Seed,
    Workers,
)
from fric.simulate import contour_run
from fric.simulate.contour_run import Chance, ContourRun, PointPath, RecordedPath
from fric.simulate.machine import Machine
from fric.simulate.processes import MonteCarlo, Study, run_all
from fric.simulate.spread import Spread
from fric.units import microns, readable
from fric.verb import Kind, useless, verb
from fric.verdict import Verdict, bare, candidates_of, decide, evidence_of, facts


class CircleResult(Result, schema=CircleResultDocument):
    """The errors that schemes leave on a circle."""

    machine: Machine  # The machine
    runs: Sequence[contour_run.CircleRun]  # A run for each scheme
    only: str | None = None  # Name of the axis, where a single axis was simulated
    many: MonteCarlo | None = None  # What they leave on many machines, where that was requested
    identified: IdentifiedMachine | None = None
    """The identified machine, where the many machines were drawn from its intervals."""
    prediction: Prediction | None = None
    """Prediction for the schemes, on machines drawn from all uncertainty of the identified machine."""
    unused: Sequence[Notice] = ()  # Why machines were not made to agree with a measured circle

    @property
    def cut_short(self) -> bool:
        """Whether fewer machines were run than requested."""
        return self.many is not None and len(self.many) < self.many.asked

    @property
    def warnings(self) -> Sequence[Notice]:
        """Warnings of machine, runs and distributions."""
        text = [notice.at(f"scheme {run.scheme.name}") for run in self.runs for notice in run.warnings]
        before = self.identified.warnings if self.identified else ()
        spread = self.many.warnings() if self.many else ()
        return once([*self.machine.warnings, *before, *self.unused, *text, *spread])

    @cached_property
    def verdict(self) -> Verdict:
        """What to switch on, by these runs and machines."""
        candidates = candidates_of(self.runs, self.many, self.prediction)
        return decide(evidence_of(facts(self.machine, self.runs), candidates, self.prediction))

    @cached_property
    def published(self) -> Mapping[str, float]:
        """Published glitches of this circle [m], by scheme."""
        test = self.runs[0].circle
        return {} if self.only else self.machine.published_glitches(test.radius, test.feed)

    def report(self) -> list[Piece]:
        """Return what each scheme leaves in the quadrants, or how its glitch is distributed."""
        test = self.runs[0].circle
        where = f"{readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}" + ", clockwise" * (test.direction < 0)
        where += f", {self.only} alone; glitches in µm" if self.only else "; glitches in µm"
        if self.many is not None:
            fitted = " by their spread"  # and not as surely as what was identified
            if self.identified:
                measured = self.prediction and self.prediction.measured
                fitted = " fitted to the measured circle" if measured else " by their intervals"
            table = self._distributions(self.many, f"{self.machine.name}: {len(self.many)} machines{fitted}, {where}")
            return [table, *self.verdict.lines()]
        columns = ["scheme", *QUADRANTS, "glitch", "rms", "range", "saved", *(["paper"] if self.published else [])]
        rows = [[*_row(run, self.runs, *run.glitches), *self._paper(run)] for run in self.runs]
        return [Table(columns, rows, f"{self.machine.name}: {where}")]

    def _paper(self, run: contour_run.CircleRun) -> list[str]:
        known = self.published.get(run.scheme.name)
        return [] if not self.published else ["" if known is None else f"{known * 1e6:.0f}"]

    def _distributions(self, many: MonteCarlo, title: str) -> Table:
        """Return what each scheme is expected to leave, and what it leaves at most on 95 % of the machines."""
        rows, best = [], many.distributions()
        for run, candidate in zip(self.runs, candidates_of(self.runs, many, self.prediction), strict=True):
            left = [microns(value, 2 - (value >= 1e-6)) for value in (candidate.middle, candidate.stays_under)]
            share = f"{best[run.scheme.name].best:.0%}"
            rows.append([_named(run), run.chance().text(), *left, share, *self._paper(run)])
        centre = "at the estimates" if self.identified else "nominal"
        columns = ["scheme", centre, "expected", "at most", "best on", *(["paper"] if self.published else [])]
        return Table(columns, rows, title)

    def brief(self) -> str:
        """Return the circle, the glitch without compensation, and that of the recommended scheme."""
        test, without = self.runs[0].circle, bare(candidates_of(self.runs, self.many, self.prediction))
        shown = [f"{found.named} {readable(found.middle, 'm', 2)}" for found in (without, self.verdict.choice) if found]
        left = ", ".join(dict.fromkeys(shown))
        return f"{readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}: {left}"

    def figure(self) -> Figure:
        """Return the radial error of each scheme; of many machines the distribution of the glitch."""
        from fric.figures.circle import monte_carlo_figure, polar_figure

        if self.many is None:
            return polar_figure(self.runs)
        return monte_carlo_figure(self.many, {run.scheme.name: run.circularity.glitch for run in self.runs})

    def reversal_figure(self) -> Figure:
        """Return error and voltages over time near a reversal."""
        from fric.figures.circle import reversal_figure

        return reversal_figure(self.runs)

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write traces and metrics to a run file."""
        from fric.io.circle import write_runs  # with HDF5, which a table needs not

        made = json.dumps(facts(self.machine, self.runs))
        write_runs(Path(path), self.runs, made, many=self.many, prediction=self.prediction, force=force)

    def by_row(self) -> dict[str, dict[str, Any]]:
        """Return quadrants, glitch and radial error by scheme [m], and quantiles over many machines."""
        rows = {}
        distributions = self.many.distributions() if self.many else {}
        for run in self.runs:
            name, quadrants = run.scheme.name, [glitch.median for glitch in run.glitches]
            row = {"title": run.scheme.title, **dict(zip(QUADRANTS, quadrants, strict=True))}
            row |= {key: run.chance(key).median for key in ("glitch", "rms", "range")}
            rows[name] = row | (dict(distributions[name].quantiles) if distributions else {})
        return rows


def _named(run: ContourRun[Any, Any]) -> str:
    return f"({run.scheme.name}) {run.scheme.title}"


def _row(run: ContourRun[Any, Any], runs: Sequence[ContourRun[Any, Any]], *glitches: Chance) -> list[str]:
    less = contour_run.reduction(run, runs)
    sizes = [*glitches, run.chance(), run.chance("rms"), run.chance("range")]
    return [_named(run), *(chance.text() for chance in sizes), "" if less is None else f"{less:.0%}"]


@verb
def circle(
    machine: MachineLike, schemes: SchemesLike = "all", *, velocity: Annotated[Quantity, "velocity"] = "100 mm/s",
    radius: Annotated[Quantity, "position"] = "30 mm", revolutions: Count = 2, clockwise: bool = False,
    axis: AxisName | None = None, known: KnownSchemes | None = None,
    machines: Annotated[int | None, Kind(metavar="N", least=1, most=100_000)] = None,
    spread: Annotated["Mapping[str, Spread] | Path | str | None", Kind(Path, "SPREAD.yaml")] = None,
    measured: CirclesLike = (), seed: Seed = 0, accuracy: Annotated[Quantity, "position"] = "0.005 um",
    workers: Workers | None = None, scheduler: Address | None = None, advance: Advance = silent,
    interrupted: Callable[[], bool] = lambda: False,
) -> CircleResult:  # fmt: skip
    """Run a circular test under compensation schemes: the quadrant glitches that each leaves.

    machine: A machine file, or a bundled machine such as xy-table. A `Machine` is taken, too; or the result of
        `read_identified`, to draw many machines from the 95 % intervals of the identified parameters.
    velocity: Feed along the circle.
    radius: Radius of the circle.
    revolutions: Revolutions; the last is evaluated.
    clockwise: Turn clockwise.
    axis: Simulate one axis alone; the other follows its reference.
    machines: Run N machines that are drawn around this machine, in addition to it; 1000 take a minute of a core per
        scheme.
    spread: How widely each parameter is drawn; by default as the bundled spread says. Spreads by name, or their file.
    measured: A measured circle, which every drawn machine is fitted to; repeatable. The machines are drawn from what
        was identified; the circle holds reference, position and voltage of each axis.
    seed: Seed of the machines that are drawn.
    Raises FricError: When the machine has no two axes for a circle, a scheme is not known, or a loop is not stable.
    """
    subject = machine_of(machine)
    sense = -1 if clockwise else 1
    test = contour_run.Circle(bounded("radius", radius), bounded("speed", velocity), revolutions, sense)
    chosen = schemes_of(schemes, known)
    spreads = read_spreads(Path(spread)) if isinstance(spread, str | Path) else spread
    advance(0, total=len(chosen) + (machines or 0))
    runs = []
    given: dict[str, Any] = {"accuracy": in_si(accuracy, "small length")}
    for wanted in chosen:
        runs.append(contour_run.run_circle(subject, wanted, test, only=axis, schemes=len(chosen)))
        advance()
    identified = machine if isinstance(machine, IdentifiedMachine) else None
    if identified is None or machines is None:
        what = "`machines=` and a machine with its intervals (--from-intervals; in Python fric.read_identified)"
        useless(what, measured=measured or None)
    if machines is None:
        useless("`machines=`", spread=spread, workers=workers, scheduler=scheduler)
        return CircleResult(subject, runs, axis, None, identified)
    given |= {} if spreads is None else {"spreads": spreads}
    evidence = None
    if identified:
        from fric.results.circles import KnownMachine  # with SciPy's signal processing, which a table needs not

        evidence = KnownMachine.of(identified, circles_of([measured]), [axis] if axis else None, seed)
        given |= evidence.drawn()
    study = Study(subject, tuple(chosen), test, seed, only=axis, **given)
    done = run_all(study, machines, workers=workers, scheduler=scheduler, advance=advance, interrupted=interrupted)
    if not done:
        raise FricError("no machine was done", hint="Nothing was written.")
    many = MonteCarlo(study, machines, tuple(done))
    predicted, unused = (evidence.prediction(many), evidence.unused) if evidence else (None, ())
    return CircleResult(subject, runs, axis, many, identified, predicted, unused)


POINTS = 6  # Number of feeds, and of radii, in a range


class CircleMapResult(Result, schema=CircleMapDocument, of="found"):
    """The glitches that schemes leave on circles of many feeds and radii."""

    found: contour_run.CircleMap  # The glitches
    done: int  # Circles that were run: the first ones, where it was interrupted

    @property
    def cut_short(self) -> bool:
        """Whether fewer circles were run than requested."""
        return self.done < len(self.found.cells)

    @property
    def warnings(self) -> Sequence[Notice]:
        """Warnings of the machine's files, and where schemes could not run."""
        notices = [INTERRUPTED.found(done=self.done, circles=len(self.found.cells))] if self.cut_short else []
        for scheme in self.found.grid.schemes:
            if failed := [cell for cell in self.found.cells[: self.done] if scheme.name in cell.failures]:
                why = failed[0].failures[scheme.name]
                counts = {"failed": len(failed), "runs": len(self.found.cells), "of": "circles"}
                notices.append(SCHEME_FAILED.found(f"scheme {scheme.name}", **counts, why=why))
        return once([*self.found.grid.machine.warnings, *notices])

    def report(self) -> list[Piece]:
        """Return the glitch by circle and scheme, and where GMS improves it and the observer makes it worse."""
        grid = self.found.grid
        columns = ["radius", "feed", *(f"({scheme.name}) {scheme.title}" for scheme in grid.schemes)]
        rows = [
            [readable(cell.circle.radius, "m"), readable(cell.circle.feed, "m/s"),
             *(microns(glitch, 2) for glitch in cell.glitches)]
            for cell in self.found.cells
        ]  # fmt: skip
        table = Table(columns, rows, f"{grid.machine.name}: glitch in µm")
        return [table, *CircleMapDocument.model_validate(self.document).describe()]

    def to_frame(self) -> DataFrame:
        """Return the glitch [m] by radius and feed, a column a scheme."""
        import pandas as pd

        names = [scheme.name for scheme in self.found.grid.schemes]
        places = [(cell.circle.radius, cell.circle.feed) for cell in self.found.cells]
        index = pd.MultiIndex.from_tuples(places, names=["radius", "feed"])
        return pd.DataFrame([cell.glitches for cell in self.found.cells], index=index, columns=names)


@names
def values_of(given: Any, dimension: str, points: int = POINTS) -> tuple[float, ...]:
    """Return quantities given as numbers in SI, as a list such as "5, 10, 50 mm/s", or as a range "5 … 200 mm/s".

    A range has ``points`` values in geometric progression. The last unit holds for values without a unit.
    """
    if not isinstance(given, str):
        found = tuple(in_si(item, dimension) for item in (given if isinstance(given, list | tuple) else [given]))
    else:
        text = given.replace("...", "…")
        ends = text.split("…")
        parts = [part.strip() for part in (ends if len(ends) == 2 else text.split(","))]
        unit = parts[-1].lstrip("0123456789.eE+- ")
        whole = (part if part.lstrip("0123456789.eE+- ") else f"{part} {unit}".strip() for part in parts)
        found = read = tuple(in_si(part, dimension) for part in whole)
        if len(ends) == 2 and min(read) > 0:
            found = tuple(float(item) for item in np.geomspace(read[0], read[1], points))
    if not found or min(found) <= 0:
        raise FricError(f"'{given}' is not a positive range", hint="Write '5 … 200 mm/s', or '5, 10, 50 mm/s'.")
    return found


@verb
def circle_map(
    machine: MachineLike, schemes: SchemesLike = "a,b,c,f", *, feeds: Quantities = "5 … 200 mm/s",
    radii: Quantities = "5 … 100 mm", points: Annotated[int, Kind(least=2, most=100)] = POINTS,
    known: KnownSchemes | None = None, accuracy: Annotated[Quantity, "position"] = "0.005 um",
    workers: Workers | None = None, scheduler: Address | None = None, advance: Advance = silent,
    interrupted: Callable[[], bool] = lambda: False,
) -> CircleMapResult:  # fmt: skip
    """Run circles of many feeds and radii: where GMS beats the static map, and where the observer makes it worse.

    feeds: A range, or feeds with commas. As "5, 10, 50 mm/s", or numbers [m/s].
    radii: A range, or radii with commas. As "5 … 100 mm", or numbers [m].
    points: Number of values in a range.
    Raises FricError: When the machine does not have two axes for a circle, or no circle was completed.
    """
    subject = machine_of(machine)
    contour_run.pair(subject)
    chosen = tuple(schemes_of(schemes, known))
    over = values_of(feeds, "velocity", points), values_of(radii, "position", points)
    for name, values in zip(("speed", "radius"), over, strict=True):
        bounded(name, max(values))
    grid = contour_run.CircleGrid(subject, chosen, *over, in_si(accuracy, "small length"))
    total = len(grid)
    advance(0, total=total)
    cells = run_all(
        grid, total, memory=grid.memory, workers=workers, scheduler=scheduler, advance=advance, interrupted=interrupted
    )
    if not cells:
        raise FricError("no circle was done", hint="Nothing was written.")
    done = len(cells)
    cells += [grid.not_run(n) for n in range(done, total)]
    return CircleMapResult(contour_run.CircleMap(grid, cells), done)


class PathResult(Result, schema=PathResultDocument):
    """The errors that schemes leave on a path."""

    machine: Machine  # The machine
    runs: Sequence[contour_run.PathRun]  # A run for each scheme
    name: str  # Description of the path

    @property
    def warnings(self) -> Sequence[Notice]:
        """Warnings for the user."""
        text = [notice.at(f"scheme {run.scheme.name}") for run in self.runs for notice in run.warnings]
        return once([*self.machine.warnings, *text])

    def report(self) -> list[Piece]:
        """Return the error under each scheme, and the glitch at each reversal."""
        title = f"{self.machine.name}: {self.name} at {readable(self.runs[0].test.feed, 'm/s')}; contour error in µm"
        sizes = [_row(run, self.runs) for run in self.runs]
        text: list[Piece] = [Table(["scheme", "glitch", "rms", "range", "reduction"], sizes, title)]
        worst = max(self.runs, key=lambda run: run.contour.glitch)
        names = contour_run.pair(self.machine)
        rows = [
            [f"{names[reversal.axis]} turns at {reversal.x * 1e3:z.1f}, {reversal.y * 1e3:z.1f} mm"]
            + [run.glitches[n].text() for run in self.runs]
            for n, reversal in enumerate(worst.contour.reversals)
        ]
        columns = ["reversal", *(f"({run.scheme.name})" for run in self.runs)]
        return [*text, Table(columns, rows, "glitch at each reversal in µm")] if rows else text

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write traces and metrics to a run file."""
        from fric.io.circle import write_runs  # with HDF5, which a table needs not

        write_runs(Path(path), self.runs, json.dumps(facts(self.machine, self.runs)), force=force)

    def by_row(self) -> dict[str, dict[str, Any]]:
        """Return glitch and contour error by scheme [m]."""
        return {
            run.scheme.name: {"title": run.scheme.title}
            | {key: run.chance(key).median for key in ("glitch", "rms", "range")}
            for run in self.runs
        }


@verb
def path(
    machine: MachineLike, points: Annotated["PointPath | RecordedPath | Path | str", Kind(Path, "PATH.csv")],
    schemes: SchemesLike = "all", *, velocity: Annotated[Quantity, "velocity"] = "100 mm/s",
    known: KnownSchemes | None = None, advance: Advance = silent,
) -> PathResult:  # fmt: skip
    """Follow a contour given by points under compensation schemes: the glitch at each reversal of an axis.

    points: Points of the path, headed 'x [mm], y [mm]'; or a recorded reference, with a column 'time [s]' too, or in a
        circle or run file. A recorded reference is followed in its own time.
    velocity: Feed along the path; a recorded path has its time. So does a path that is given directly.
    Raises FricError: When the path has a corner, or the machine cannot follow it.
    """
    subject = machine_of(machine)
    if isinstance(points, PointPath | RecordedPath):
        name, followed = "path", points
    else:
        from fric.io.circle import read_path  # with HDF5, which a table needs not

        file = path_of("points, or their file", points)
        name, followed = file.name, read_path(file, bounded("speed", velocity))
    chosen = schemes_of(schemes, known)
    advance(0, total=len(chosen))
    runs = []
    for wanted in chosen:
        runs.append(contour_run.run_path(subject, wanted, followed, schemes=len(chosen)))
        advance()
    return PathResult(subject, runs, name)
