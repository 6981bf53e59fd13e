"""Which axes of a fleet changed: every number at two dates against its intervals, with as many chances in mind."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise
from math import isfinite
from typing import Any

import numpy as np
from scipy.special import stdtr, stdtrit

from fric.arrays import Real
from fric.automatic.fleet import UnitOutcome
from fric.documents.friction import FrictionDocument
from fric.documents.plant import PlantDocument
from fric.report.drift import Change, document_changes, limits_of
from fric.report.report_input import Item

LEVEL = 0.05
"""Probability with which an axis of a fleet that did not change is said to have, at most: of all axes together."""

FREEDOM = {"gms": 4.0, "plant": 7.0, "glitch": 7.0}
"""Degrees of freedom of what intervals are from: cycles of a record, periods of an excitation, less one.

Of a glitch as few as of a plant: its intervals are held against 400 circles, and no more of their tails is known.
"""


@dataclass(frozen=True)
class Drift:
    """One number of an axis at two dates."""

    # machine, axis, dates: where and when
    machine: str
    axis: str
    dates: tuple[str, str]
    change: Change  # The number at both dates
    p: float  # Probability of such a difference where nothing changed
    adjusted: float = 1.0  # The same, by Holm, with all numbers of the fleet in mind

    @property
    def changed(self) -> bool:
        """Whether it changed, at the level that holds for the whole fleet."""
        return self.adjusted <= LEVEL


def drifts(found: Sequence[UnitOutcome]) -> list[Drift]:
    """Return every number that two following dates of an axis share, by its adjusted probability."""
    every = [drift for machine in _machines(found) for drift in _of_machine(machine)]
    adjusted = holm(np.array([one.p for one in every]))
    done = [replace(one, adjusted=float(p)) for one, p in zip(every, adjusted, strict=True)]
    return sorted(done, key=lambda one: (one.adjusted, one.p))


def holm(p: Real) -> Real:
    """Return probabilities adjusted for their number, shape (n,): one at most 5 % is by chance in 5 % of all families.

    Holm's step-down (Scandinavian Journal of Statistics 6, 1979): ``max over j ≤ i of (n - j + 1)·p_(j)``, for any
    dependence of the tests.
    """
    order = np.argsort(p, kind="stable")
    stepped = np.maximum.accumulate((len(p) - np.arange(len(p))) * p[order])
    adjusted = np.empty_like(p)
    adjusted[order] = np.minimum(stepped, 1.0)
    return adjusted


def probability(change: Change, freedom: float) -> float | None:
    """Return the two-sided probability of a difference where nothing changed; None where its interval tells nothing.

    The interval's side towards 0 is ``t·s`` with Student's quantile t at 97.5 %: the difference over s is held against
    Student's distribution. Its tails, and not the normal one's, are what hundreds of comparisons meet.

    Parameters
    ----------
    change
        The number at both dates.
    freedom
        Degrees of freedom of its intervals.
    """
    limits = change.difference_ci95
    if limits is None:
        return None
    side = change.difference - limits[0] if change.difference > 0 else limits[1] - change.difference
    if not (isfinite(side) and side > 0):
        return None
    return float(2 * stdtr(freedom, -abs(change.difference) / side * float(stdtrit(freedom, 0.975))))


def _machines(found: Sequence[UnitOutcome]) -> Iterator[list[UnitOutcome]]:
    ordered = sorted(found, key=lambda one: (one.unit.machine, one.unit.date))
    for _, dates in groupby(ordered, key=lambda one: one.unit.machine):
        yield list(dates)


def _of_machine(dates: Sequence[UnitOutcome]) -> Iterator[Drift]:
    for before, after in pairwise(dates):
        for axis in before.axes.keys() & after.axes.keys():
            of = (before.unit.machine, axis, (before.unit.date, after.unit.date))
            for change, freedom in _changes(before.axes[axis], after.axes[axis]):
                if (p := probability(change, freedom)) is not None:
                    yield Drift(*of, change, p)


def _changes(before: Mapping[str, Any], after: Mapping[str, Any]) -> Iterator[tuple[Change, float]]:
    """Yield each number that an axis has at both dates, and the degrees of freedom of its intervals."""
    earlier, later = (_items(one["documents"]) for one in (before, after))
    for kind in sorted(earlier.keys() & later.keys()):
        for change in document_changes(earlier[kind], later[kind]):
            yield change, min(_freedom(one[kind], change.name) for one in (earlier, later))
    for name in sorted(before["glitches"].keys() & after["glitches"].keys()):
        one, other = (of["glitches"][name] for of in (before, after))
        limits = (limits_of(one["ci95"]), limits_of(other["ci95"]))
        yield Change(name, "m", one["value"], other["value"], *limits), FREEDOM["glitch"]


def _items(documents: Mapping[str, Any]) -> dict[str, Item]:
    """Return the documents of an axis to compare: its friction, or the static map alone, and its plant."""
    found = {}
    friction = documents.get("friction") or documents.get("static")
    plant = documents.get("plant")
    for kind, tree, document in (("friction", friction, FrictionDocument), ("plant", plant, PlantDocument)):
        if tree is not None:
            found[kind] = Item("", document.model_validate(tree))
    return found


def _freedom(item: Item, name: str) -> float:
    """Return the degrees of freedom of a number's interval: of a static map its strokes less its parameters."""
    if item.kind == "plant":
        return FREEDOM["plant"]
    assert isinstance(item.document, FrictionDocument)
    if name.startswith("gms."):
        return FREEDOM["gms"]
    fit = item.document.fit_of("static")
    count = len(fit.covariance.names) if fit.covariance is not None else 5
    return max(float((fit.points or count + 5) - count), 1.0)
