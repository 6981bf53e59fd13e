"""The circular test under compensation schemes, on one machine or on many."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from fric.circles.prediction import Prediction
from fric.contour import QUADRANTS
from fric.documents.contours import CircleResultDocument
from fric.documents.identified import IdentifiedMachine
from fric.documents.spread import read_spreads
from fric.errors import FricError
from fric.notice import Notice, once
from fric.results.base import Figure, Result
from fric.results.given import Advance, bounded, in_si, silent
from fric.results.given_models import circles_of, machine_of, schemes_of
from fric.results.kinds import (
    Address,
    AxisName,
    CirclesLike,
    Count,
    KnownSchemes,
    MachineLike,
    Quantity,
    SchemesLike,
    Seed,
    SpreadsLike,
)
from fric.results.text import Piece, Table
from fric.simulate.circle import Circle, CircleRun, run_circle
from fric.simulate.contour_run import reduction
from fric.simulate.machine import Machine
from fric.simulate.monte_carlo import MonteCarlo, Study
from fric.simulate.processes import run_all
from fric.units import readable
from fric.verb import Kind, verb
from fric.verdict import Verdict, candidates_of, decide, evidence_of, facts


@dataclass(frozen=True, eq=False, repr=False)
class CircleResult(Result, schema=CircleResultDocument):
    """The errors that schemes leave on a circle."""

    machine: Machine  # The machine
    runs: Sequence[CircleRun]  # A run for each scheme
    only: str | None = None  # Name of the axis, where a single axis was simulated
    many: MonteCarlo | None = None  # What they leave on many machines, where that was requested
    identified: IdentifiedMachine | None = None
    """The identified machine, where the many machines were drawn from its intervals."""
    prediction: Prediction | None = None
    """Prediction for the schemes, on machines drawn from all uncertainty of the identified machine."""

    @property
    def cut_short(self) -> bool:
        """Whether fewer machines were run than requested."""
        return self.many is not None and len(self.many) < self.many.asked

    @property
    def warnings(self) -> Sequence[Notice]:
        """Warnings of machine, runs and distributions."""
        text = [notice.at(f"scheme {run.scheme.name}") for run in self.runs for notice in run.warnings]
        before = self.identified.warnings if self.identified else ()
        return once([*self.machine.warnings, *before, *text, *(self.many.warnings() if self.many else ())])

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
        where = f"{readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}"
        where += ", clockwise" if test.direction < 0 else ""
        where += f", {self.only} alone; glitches in µm" if self.only else "; glitches in µm"
        if self.many is not None:
            table = self._distributions(self.many, f"{self.machine.name}: {len(self.many)} machines, {where}")
            return [table, *self.verdict.lines()]
        columns = ["scheme", *QUADRANTS, "glitch", "rms", "range", "reduction", *(["paper"] if self.published else [])]
        return [Table(columns, [self._row(run) for run in self.runs], f"{self.machine.name}: {where}")]

    def _row(self, run: CircleRun) -> list[str]:
        less = reduction(run, self.runs)
        microns = [*run.glitches, run.chance(), run.chance("rms"), run.chance("range")]
        row = [_named(run), *(chance.text() for chance in microns), "" if less is None else f"{less:.0%}"]
        return row + self._paper(run)

    def _paper(self, run: CircleRun) -> list[str]:
        known = self.published.get(run.scheme.name)
        return [] if not self.published else ["" if known is None else f"{known * 1e6:.0f}"]

    def _distributions(self, many: MonteCarlo, title: str) -> Table:
        """Return what each scheme is expected to leave, and what it leaves at most on 95 % of the machines."""
        rows, best = [], many.distributions()
        for run, candidate in zip(self.runs, candidates_of(self.runs, many, self.prediction), strict=True):
            left = [
                f"{1e6 * value:.{1 if value >= 1e-6 else 2}f}" for value in (candidate.middle, candidate.stays_under)
            ]
            share = f"{best[run.scheme.name].best:.0%}"
            rows.append([_named(run), run.chance().text(), *left, share, *self._paper(run)])
        centre = "at the estimates" if self.identified else "nominal"
        columns = ["scheme", centre, "expected", "at most", "best on", *(["paper"] if self.published else [])]
        return Table(columns, rows, title)

    def brief(self) -> str:
        """Return the glitch without compensation, and that of the recommended scheme."""
        found = self.verdict.choice
        bare = next((run for run in self.runs if run.scheme.bare), None)
        now = "" if bare is None else f"now {readable(bare.chance().median, 'm', 2)}"
        left = "" if found is None else f"{found.named} {readable(found.middle, 'm', 2)}"
        return ", ".join(filter(None, (now, left, f"{len(self.many)} varied machines" if self.many else "")))

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
        from fric.io.run import write_runs  # with HDF5, which a table needs not

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


def _named(run: CircleRun) -> str:
    return f"({run.scheme.name}) {run.scheme.title}"


@verb
def circle(
    machine: MachineLike,
    schemes: SchemesLike = "all",
    *,
    velocity: Annotated[Quantity, "velocity"] = "100 mm/s",
    radius: Annotated[Quantity, "position"] = "30 mm",
    revolutions: int = 2,
    clockwise: bool = False,
    axis: AxisName | None = None,
    known: KnownSchemes | None = None,
    machines: Annotated[int | None, Kind(metavar="N", least=1)] = None,
    spread: SpreadsLike | None = None,
    measured: CirclesLike = (),
    seed: Seed = 0,
    accuracy: Annotated[Quantity, "position"] = "0.005 um",
    workers: Count | None = None,
    scheduler: Address | None = None,
    advance: Advance = silent,
    interrupted: Callable[[], bool] = lambda: False,
) -> CircleResult:
    """Run a circular test under compensation schemes: the quadrant glitches that each leaves.

    Parameters
    ----------
    machine
        The machine, as in configs/. Itself, its file, the name of a bundled machine; or the result of
        `read_identified`, to draw many machines from the 95 % intervals of the identified parameters.
    velocity
        Feed along the circle.
    radius
        Radius of the circle.
    revolutions
        Revolutions; the last is evaluated.
    clockwise
        Turn clockwise.
    axis
        Simulate one axis alone; the other follows its reference.
    machines
        Run N machines that are drawn around this machine, in addition to it.
    spread
        How widely each parameter is drawn; by default configs/spread.yaml. Spreads by name, or their file.
    measured
        A measured circle, which every drawn machine is fitted to; repeatable. The machines are drawn from what was
        identified; the circle holds reference, position and voltage of each axis.
    seed
        Seed of the machines that are drawn.

    Raises
    ------
    FricError
        When the machine has no two axes for a circle, a scheme is not known, or a loop is not stable.
    """
    subject = machine_of(machine)
    sense = -1 if clockwise else 1
    test = Circle(bounded("radius", radius), bounded("speed", velocity), revolutions, sense)
    chosen = schemes_of(schemes, known)
    spreads = read_spreads(Path(spread)) if isinstance(spread, str | Path) else spread
    advance(0, total=len(chosen) + (machines or 0))
    runs = []
    for wanted in chosen:
        runs.append(run_circle(subject, wanted, test, only=axis))
        advance()
    identified = machine if isinstance(machine, IdentifiedMachine) else None
    if measured and (identified is None or machines is None):
        raise FricError(
            "measured circles were given, and no machines to make agree with them",
            hint="Give what fric.read_identified returns, and `machines=`.",
        )
    if machines is None:
        return CircleResult(subject, runs, axis, None, identified)
    given: dict[str, Any] = {} if spreads is None else {"spreads": spreads}
    evidence = None
    if identified:
        from fric.results.known_machine import KnownMachine  # with SciPy's signal processing, which a table needs not

        tests = circles_of([measured])
        evidence = KnownMachine.of(identified, tests, [axis] if axis else None, seed)
        given |= evidence.drawn()
    given["accuracy"] = in_si(accuracy, "position")
    study = Study(subject, tuple(chosen), test, seed, only=axis, **given)
    done = run_all(study, machines, workers=workers, scheduler=scheduler, advance=advance, interrupted=interrupted)
    if not done:
        raise FricError("no machine was done", hint="Nothing was written.")
    many = MonteCarlo(study, machines, tuple(done))
    return CircleResult(subject, runs, axis, many, identified, evidence.prediction(many) if evidence else None)
