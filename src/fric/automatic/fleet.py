"""A fleet: a folder ``DIR/machine/date`` of logs, identified on all cores or on a cluster, and how it changed.

Every number at two dates is compared with its intervals, corrected for multiple comparisons.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import stdtr, stdtrit

from fric.arrays import Real
from fric.automatic.sources import find_sources
from fric.automatic.steps import Session, Step, identify_axes
from fric.circles.diagnose import Diagnosis
from fric.documents.friction import FrictionDocument
from fric.documents.listings import FleetDocument
from fric.documents.plant import PlantDocument
from fric.documents.yaml import read_document, write_document
from fric.errors import FricError, clean
from fric.estimate import Estimate
from fric.flaws.files import CIRCLE_FAILED, NO_LOG, UNIT_FAILED
from fric.notice import Notice
from fric.output import staged, together
from fric.report.collect import Change, Item
from fric.report.view import environment
from fric.results.base import Piece, Result, Table
from fric.results.circles import diagnose
from fric.results.kinds import EncoderName
from fric.simulate.processes import run_all
from fric.units import readable

DATE = re.compile(r"\d{4}-?\d{2}(-?\d{2}(\D.*)?)?")  # Folders: 2026-11, 2026-11-21, 20261121, with a time or without
LEVEL = 0.05  # Largest probability, over a fleet, with which an unchanged axis is reported as changed
FREEDOM = {"gms": 4.0, "plant": 7.0, "glitch": 7.0}
"""Degrees of freedom of intervals: cycles of a record or periods of an excitation, less 1. A glitch has as few as a
plant: 400 circles tested its intervals, and do not show their tails further."""
SHOWN = ("F_c", "F_s", "v_s", "sigma")  # Numbers of an axis that the table of a fleet shows


@dataclass(frozen=True)
class Unit:
    """The logs of one machine at one date."""

    machine: str
    date: str
    folder: Path


@dataclass
class UnitAxis:
    """Results for an axis of one machine at one date."""

    done: list[str] = field(default_factory=list)  # Which steps were done
    missing: list[str] = field(default_factory=list)  # What is missing for others
    friction: FrictionDocument | None = None  # Its friction, or its static map alone
    plant: PlantDocument | None = None  # Its plant
    glitches: dict[str, Estimate] = field(default_factory=dict)  # Glitches on measured circles [m], by name


@dataclass(frozen=True)
class UnitOutcome:
    """Results for the logs of one machine at one date."""

    unit: Unit  # Where they are from
    axes: dict[str, UnitAxis]  # What came of each axis
    description: tuple[Notice, ...]  # What was guessed, left out, or could not be read
    steps: int = 0  # steps, made: steps there are, and how many had to be run
    made: int = 0


def find_fleet(given: Sequence[Path]) -> list[Unit]:
    """Return machines and dates, if a single folder of machines is given, each with folders of dates; else nothing."""
    if len(given) != 1 or not given[0].is_dir():
        return []
    machines = [path for path in sorted(given[0].iterdir()) if path.is_dir() and not path.name.startswith(".")]
    dates = (path for machine in machines for path in sorted(machine.iterdir()) if path.is_dir())
    units = [Unit(date.parent.name, date.name, date.resolve()) for date in dates]
    dated = all(DATE.fullmatch(unit.date) for unit in units)
    return units if dated and {unit.machine for unit in units} == {machine.name for machine in machines} else []


@dataclass(frozen=True)
class FleetStudy:
    """Identifies the axes of one machine at one date, by its number in the fleet."""

    units: tuple[Unit, ...]  # Machines and dates
    output: Path  # Folder for all that is made: a folder of each machine and date, with its steps
    mappings: Sequence[str] = ()  # What the columns of foreign logs mean
    run: Callable[[Step], Result | None] = Step.make  # Makes one step
    assume: bool = False  # Whether the likeliest meaning of columns is taken where they leave it open
    encoder: EncoderName = "motor"  # Whose position is identified

    def __call__(self, index: int) -> UnitOutcome:
        """Identify plant, static map and GMS of each axis; a failure is reported, and the others continue."""
        unit = self.units[index]
        try:
            mappings = self.output / unit.machine / unit.date / "mappings"
            found = find_sources([unit.folder], self.mappings, mappings, assume=self.assume)
        except FricError as error:
            return UnitOutcome(unit, {}, (UNIT_FAILED.found(why=str(error)),))
        if not (found.logs or found.circles):
            return UnitOutcome(unit, {}, (NO_LOG.found(), *found.description))
        session = Session(self.output / unit.machine / unit.date, self.run, lambda _: None)
        axes: dict[str, UnitAxis] = {}
        for name, outcome in identify_axes(session, found, encoder=self.encoder).items():
            frictions = (session.folder / name / file for file in ("friction.yaml", "static.yaml"))
            friction = next((read_document(file, FrictionDocument) for file in frictions if file.exists()), None)
            plant = read_document(outcome.files["plant"], PlantDocument) if outcome.files["plant"].exists() else None
            axes[name] = UnitAxis(outcome.done, outcome.missing, friction, plant)
        for path in found.circles:
            try:
                glitches = _glitches(diagnose(path).found)
            except FricError as error:
                found.description.append(CIRCLE_FAILED.found(str(path), why=error.what))
                continue
            for name, of_axis in glitches.items():
                axis = axes.setdefault(name, UnitAxis())
                axis.glitches |= of_axis
                axis.done += [] if "circle" in axis.done else ["circle"]
        session.close()
        return UnitOutcome(unit, axes, tuple(found.description), session.steps, session.made)


def _glitches(found: Diagnosis) -> dict[str, dict[str, Estimate]]:
    """Return the glitches of a measured circle by axis and name, which says quadrant and test."""
    test = found.test
    radius, feed = readable(test.radius, "m"), readable(test.feed, "m/s")
    sense = ", clockwise" if test.direction < 0 else ""
    glitches: dict[str, dict[str, Estimate]] = {}
    for quadrant, glitch in found.glitches.items():
        name = f"glitch {quadrant}, {radius} at {feed}{sense}"
        glitches.setdefault(quadrant[1:], {})[name] = Estimate(glitch.value, glitch.unit, glitch.ci95)
    return glitches


@dataclass(frozen=True)
class ParameterDrift:
    """One number of an axis at two dates."""

    machine: str  # machine, axis, dates: where and when
    axis: str
    dates: tuple[str, str]
    change: Change  # The number at both dates
    p: float  # Probability of such a difference where nothing changed
    adjusted: float = 1.0  # The same, by Holm, with all numbers of the fleet in mind

    @property
    def changed(self) -> bool:
        """Whether it changed, at the significance level of the whole fleet."""
        return self.adjusted <= LEVEL


def drifts(found: Sequence[UnitOutcome]) -> list[ParameterDrift]:
    """Return every number that two consecutive dates of an axis share, sorted by adjusted probability."""
    dates = pairwise(sorted(found, key=lambda outcome: (outcome.unit.machine, outcome.unit.date)))
    every = [drift for early, late in dates if early.unit.machine == late.unit.machine for drift in _of(early, late)]
    adjusted = holm(np.array([drift.p for drift in every]))
    done = [replace(drift, adjusted=float(p)) for drift, p in zip(every, adjusted, strict=True)]
    return sorted(done, key=lambda drift: (drift.adjusted, drift.p))


def holm(p: Real) -> Real:
    """Return probabilities adjusted for their number, shape (n,): by chance, any is below 5 % in 5 % of all families.

    Holm's step-down (Scandinavian Journal of Statistics 6, 1979): ``max over j ≤ i of (n - j + 1)·p_(j)``, for any
    dependence of the tests.
    """
    order = np.argsort(p, kind="stable")
    stepped = np.maximum.accumulate((len(p) - np.arange(len(p))) * p[order])
    adjusted = np.empty_like(p)
    adjusted[order] = np.minimum(stepped, 1.0)
    return adjusted


def probability(change: Change, freedom: float) -> float | None:
    """Return the two-sided probability of a difference where nothing changed; None where its interval is unbounded.

    The interval's side towards 0 is ``t·s`` with Student's quantile t at 97.5 %: the difference over s is compared with
    Student's distribution. Among hundreds of comparisons its tails matter, which the normal distribution does not have.
    """
    limits = change.difference_ci95
    if limits is None:
        return None
    side = change.difference - limits[0] if change.difference > 0 else limits[1] - change.difference
    if not (isfinite(side) and side > 0):
        return None
    return float(2 * stdtr(freedom, -abs(change.difference) / side * float(stdtrit(freedom, 0.975))))


def _of(before: UnitOutcome, after: UnitOutcome) -> Iterator[ParameterDrift]:
    """Yield the differences of a machine between two dates."""
    for axis in before.axes.keys() & after.axes.keys():
        of = (before.unit.machine, axis, (before.unit.date, after.unit.date))
        for change, freedom in _changes(before.axes[axis], after.axes[axis]):
            if (p := probability(change, freedom)) is not None:
                yield ParameterDrift(*of, change, p)


def _changes(before: UnitAxis, after: UnitAxis) -> Iterator[tuple[Change, float]]:
    """Yield each number that an axis has at both dates, and the degrees of freedom of its intervals."""
    for first, other in ((before.friction, after.friction), (before.plant, after.plant)):
        if first is not None and other is not None:
            for change in Item("", first).changes(Item("", other)):
                yield change, min(_freedom(document, change.name) for document in (first, other))
    for name in sorted(before.glitches.keys() & after.glitches.keys()):
        early, late = before.glitches[name], after.glitches[name]
        limits: Any = early.ci95, late.ci95
        yield Change(name, early.unit, float(early), float(late), *limits), FREEDOM["glitch"]


def _freedom(document: FrictionDocument | PlantDocument, name: str) -> float:
    """Return the degrees of freedom of a number's interval: of a static map its strokes less its parameters."""
    if isinstance(document, PlantDocument):
        return FREEDOM["plant"]
    if name.startswith("gms."):
        return FREEDOM["gms"]
    fit = document.fit_of("static")
    count = len(fit.covariance.names) if fit.covariance is not None else 5
    return max(float((fit.points or count + 5) - count), 1.0)


class FleetResult(Result):
    """Results for a fleet."""

    folder: Path  # Where all files are
    outcomes: Sequence[UnitOutcome]  # Results for each machine and date
    drifts: Sequence[ParameterDrift]  # Each number at two consecutive dates, the most probable change first

    @property
    def changed(self) -> list[tuple[str, str]]:
        """Machine and axis of each change, the most probable first."""
        return list(dict.fromkeys((drift.machine, drift.axis) for drift in self.drifts if drift.changed))

    @property
    def warnings(self) -> Sequence[Notice]:
        """What was guessed, left out, or could not be read, by machine and date."""
        return [notice.at(f"{of.unit.machine}/{of.unit.date}") for of in self.outcomes for notice in of.description]

    @cached_property
    def document(self) -> dict[str, Any]:
        """The fleet file."""
        return FleetDocument.made(
            {
                "page": str(self.folder / "fleet.html"), "level": LEVEL, "tests": len(self.drifts),
                "units": self.outcomes, "changed": self.changed,
                "changes": [drift for drift in self.drifts if drift.change.verdict == "moved"],
            }
        ).tree()  # fmt: skip

    def report(self) -> list[Piece]:
        """Return what changed, and the numbers of every axis at every date."""
        rows = [
            (
                f"{drift.machine} {drift.axis}", " → ".join(drift.dates), drift.change.name,
                readable(drift.change.before, drift.change.unit), readable(drift.change.after, drift.change.unit),
                "" if drift.change.relative is None else f"{drift.change.relative:+.1%}", f"{drift.adjusted:.2g}",
            )
            for drift in self.drifts if drift.changed
        ]  # fmt: skip
        machines = len({outcome.unit.machine for outcome in self.outcomes})
        count = len(self.changed)
        head = f"{count} {'axis' if count == 1 else 'axes'} of {machines} machines changed"
        head += f", at {LEVEL:.0%} for all {len(self.drifts)} numbers together"
        made, steps = sum(outcome.made for outcome in self.outcomes), sum(outcome.steps for outcome in self.outcomes)
        changes = Table(("changed", "dates", "", "before", "after", "", "by chance"), rows)
        every = Table(("axis", "date", *SHOWN, "glitch"), self.values())
        foot = f"{made} of {steps} steps were run, the rest was up to date"
        return [head, *([changes] if rows else []), every, foot, str(self.folder / "fleet.html")]

    def values(self) -> list[tuple[str, ...]]:
        """Return a row for each axis and date, for people: name, date, identified values, largest glitch."""
        rank = {pair: n for n, pair in enumerate(self.changed)}
        rows = []
        for outcome in self.outcomes:
            for name, axis in outcome.axes.items():
                friction = axis.friction
                known = friction.estimates("static") if friction and friction.static else {}
                glitch = max(axis.glitches.values(), key=lambda estimate: abs(float(estimate)), default=None)
                shown = tuple(_shown(estimate) for estimate in (*map(known.get, SHOWN), glitch))
                place = rank.get((outcome.unit.machine, name), len(rank))
                rows.append((place, (f"{outcome.unit.machine} {name}", outcome.unit.date, *shown)))
        return [row for _, row in sorted(rows, key=lambda pair: pair[0])]

    def write(self) -> None:
        """Write the page and the fleet file into the folder."""
        document, target = self.folder / "fleet.yaml", self.folder / "fleet.html"
        page = environment().get_template("fleet.html.j2").render(
            fleet=self, level=LEVEL, shown=(*SHOWN, "glitch"), rows=self.values(),
            unchanged=[drift for drift in self.drifts if not drift.changed and drift.change.verdict == "moved"][:50],
        )  # fmt: skip
        with together(document) as made, staged(target, force=True) as draft:
            draft.write_text(clean(page), encoding="utf-8")
            write_document(document, self.document, force=True)
            made.append(document)


def _shown(found: Estimate | None) -> str:
    if found is None:
        return "–"
    low, high = found.limits
    half = f" ± {readable(0.5 * (high - low), found.unit, 2)}" if isfinite(high - low) else ""
    return readable(float(found), found.unit) + half


def fleet(
    study: FleetStudy, folder: Path, workers: int | None, scheduler: str | None, advance: Callable[..., object]
) -> FleetResult:
    """Identify every machine at every date, by processes here or by a Dask cluster, and write the fleet's page.

    folder: For all results, as it was given; workers of a cluster must see the study's folders under the same names.
    workers: Processes; one a core where not given.
    scheduler: Address of a Dask cluster.
    """
    advance(0, total=len(study.units))
    found = run_all(study, len(study.units), workers=workers, scheduler=scheduler, advance=advance)
    made = FleetResult(folder, found, drifts(found))
    made.write()
    return made
