"""Drift: changes from one date to another, compared with the intervals of the numbers."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import hypot, inf, isnan
from typing import Any, Literal

from fric.estimate import Estimate
from fric.report.collect import ContourTest, Item

Verdict = Literal["moved", "within", "unknown"]


@dataclass(frozen=True)
class Change:
    """One number at two dates."""

    name: str  # name, unit: its name, and its SI unit
    unit: str
    before: float  # before, after: its values
    after: float
    # before_ci95, after_ci95: their 95 % intervals; an infinite limit is not determined by the data; None where there
    # is no interval
    before_ci95: tuple[float, float] | None = None
    after_ci95: tuple[float, float] | None = None

    @property
    def difference(self) -> float:
        """After less before."""
        return self.after - self.before

    @property
    def relative(self) -> float | None:
        """The difference over the earlier value; None where that is 0."""
        return self.difference / abs(self.before) if self.before else None

    @property
    def difference_ci95(self) -> tuple[float, float] | None:
        """95 % interval of the difference of two independent numbers with intervals that need not be symmetric.

        The distances of the limits from the values add in quadrature (Zou and Donner 2008, the method of variance
        estimates recovery): below, the later number's lower with the earlier number's upper; above, the other way
        round.
        """
        if self.before_ci95 is None or self.after_ci95 is None:
            return None
        below = hypot(self.after - self.after_ci95[0], self.before_ci95[1] - self.before)
        above = hypot(self.after_ci95[1] - self.after, self.before - self.before_ci95[0])
        return self.difference - below, self.difference + above

    @property
    def verdict(self) -> Verdict:
        """``moved`` if the interval of the difference does not contain 0; ``unknown`` without an interval."""
        interval = self.difference_ci95
        if interval is None or interval == (-inf, inf):
            return "unknown"
        return "within" if interval[0] <= 0 <= interval[1] else "moved"


def document_changes(before: Item, after: Item) -> list[Change]:
    """Return the change of each number that two documents of one kind and axis share.

    Values that were set by hand or assumed are left out. Slip blocks are compared one by one if their number is equal.
    """
    found: list[Change] = []
    earlier_sections = before.sections()
    for section, later in after.sections().items():
        prefix = "" if section in {"static", after.kind} else f"{section}."
        earlier = earlier_sections.get(section, {})
        for name in (name for name in later if name in earlier):
            estimate, other = earlier[name], later[name]
            if not (estimate.fixed or estimate.assumed or other.fixed or other.assumed):
                found += _changes(prefix + name, estimate, other)
    return found


def block_counts(before: Item, after: Item) -> tuple[int, int] | None:
    """Return the numbers of slip blocks in the GMS models of two friction documents, if they differ."""
    blocks = [item.sections().get("gms", {}).get("k") for item in (before, after)]
    counts = [len(k.value) if k is not None and isinstance(k.value, tuple) else 0 for k in blocks]
    return (counts[0], counts[1]) if all(counts) and counts[0] != counts[1] else None


def _changes(name: str, before: Estimate, after: Estimate) -> Iterator[Change]:
    if not isinstance(before.value, tuple) or not isinstance(after.value, tuple):
        if isinstance(before.value, float) and isinstance(after.value, float):
            yield Change(name, after.unit, before.value, after.value, limits_of(before.ci95), limits_of(after.ci95))
        return
    if len(before.value) != len(after.value):
        return
    intervals = [estimate.ci95 or (None,) * len(before.value) for estimate in (before, after)]
    for n, (one, other, low, high) in enumerate(zip(before.value, after.value, *intervals, strict=True), 1):
        yield Change(f"{name}_{n}", after.unit, one, other, limits_of(low), limits_of(high))


def limits_of(given: Any) -> tuple[float, float] | None:
    """Return the limits of an interval; None and NaN are limits that the data do not determine."""
    if given is None:
        return None
    low, high = given
    return (-inf if low is None or isnan(low) else float(low)), (inf if high is None or isnan(high) else float(high))


def glitch_changes(before: ContourTest, after: ContourTest) -> list[Change]:
    """Return the change of the glitch of each scheme that both tests ran."""
    earlier = {contour.scheme.name: contour for contour in before.contours}
    return [
        Change(
            f"({contour.scheme.name}) {contour.scheme.title}", "m", earlier[contour.scheme.name].glitch, contour.glitch,
            earlier[contour.scheme.name].interval, contour.interval,
        )
        for contour in after.contours
        if contour.scheme.name in earlier
    ]  # fmt: skip


def description(changes: list[Change]) -> str:
    """Return a sentence on how many numbers changed by more than their intervals allow."""
    moved = [change for change in changes if change.verdict == "moved"]
    known = [change for change in changes if change.verdict != "unknown"]
    if not any(change.difference for change in changes):
        return "No number changed." if changes else "The two share no identified number."
    if not known:
        return "None of the numbers has an interval: whether a difference is a change is not known."
    if not moved:
        return f"None of the {len(known)} numbers with intervals moved beyond them."
    names = ", ".join(f"{change.name} ({_percent(change)})" for change in moved)
    return f"{len(moved)} of {len(known)} numbers moved beyond their intervals: {names}."


def _percent(change: Change) -> str:
    return "from 0" if change.relative is None else f"{change.relative:+.1%}".replace("-", "−")
