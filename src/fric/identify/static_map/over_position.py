"""What the force of strokes shows at the same places again, whatever the speed, taken off their means.

Along stroke i the force is ``F_i(z) = m_i + c(z) + w(z)·m_i/|m|``, |m| being the median of all: c is a force over
position, w friction over position, both zero in the mean over the travel that strokes cover. A slow stroke is at one
place alone, and its mean is off by what c and w are there; they are told by the strokes that go far.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Real
from fric.identify.records.flaws import SMALL
from fric.identify.records.over_strokes import PLACES, OverPlace, along_axis, over_place
from fric.identify.records.segments import Segment
from fric.identify.static_map.forms import FEWEST, HeldOut
from fric.identify.static_map.map_fit import SpeedPoint
from fric.identify.static_map.scatter import Fitted
from fric.log import ForceVelocity, Log
from fric.notice import Notice
from fric.units import Motion, readable, si_unit

OverPosition = Literal["auto", "off", "on"]

FINER = 4
"""Cells that a place is looked at in."""


class Profile:
    """Forces over position, told by strokes.

    Parameters
    ----------
    strokes
        By the number of a point, its record and steady segment.
    points
        The points of all strokes.
    """

    def __init__(self, strokes: Sequence[tuple[int, Log, Segment]], points: Sequence[SpeedPoint]) -> None:
        self.numbers = [number for number, *_ in strokes]
        travels = [log.require("position", "a force over position")[s.start : s.stop] for _, log, s in strokes]
        low, high = min(z.min() for z in travels), max(z.max() for z in travels)
        edges = np.linspace(low, high, FINER * PLACES + 1)
        level = float(np.median([abs(points[number].force) for number in self.numbers])) or 1.0
        normal, right, self._means = [], [], []
        covered = np.zeros(PLACES + 1)
        for (number, log, segment), z in zip(strokes, travels, strict=True):
            cell = np.clip(np.digitize(z, edges) - 1, 0, len(edges) - 2)
            count = np.bincount(cell, minlength=len(edges) - 1)
            there = np.flatnonzero(count)
            force = np.bincount(cell, log.require("force", "it")[segment.start : segment.stop])[there] / count[there]
            at = (0.5 * (edges[there] + edges[there + 1]) - low) / (high - low) * PLACES
            hat = np.maximum(0.0, 1.0 - np.abs(at[:, np.newaxis] - np.arange(PLACES + 1)))
            both = np.hstack([hat, hat * points[number].force / level])
            weight = count[there] / count.sum()
            self._means.append(weight @ both)
            # each place counts alike: a slow stroke has more samples there, and the same profile
            around = both - weight @ both
            normal.append(around.T @ around)
            right.append(around.T @ (force - weight @ force))
            covered += hat.sum(axis=0)
        self._normal, self._right = np.array(normal), np.array(right)
        middle = covered / covered.sum()
        zero = np.zeros_like(middle)
        self._zero = np.array([np.append(middle, zero), np.append(zero, middle)])

    def means(self, without: int | None = None) -> Real:
        """Return what the profile adds to the mean of each stroke [N], as all tell it, or all but one; shape (n,)."""
        normal, right = self._normal.sum(axis=0), self._right.sum(axis=0)
        if without is not None:
            normal, right = normal - self._normal[without], right - self._right[without]
        size = float(np.trace(normal)) / len(normal)
        bound = 1e-3 * size * np.eye(len(normal)) + 1e3 * size * self._zero.T @ self._zero
        return np.asarray(np.array(self._means) @ np.linalg.solve(normal + bound, right))

    def held_out(self, points: Sequence[SpeedPoint]) -> list[SpeedPoint]:
        """Return the points without what the profile of all other strokes adds to each."""
        return self._without(points, np.array([self.means(n)[n] for n in range(len(self.numbers))]))

    def taken_off(self, points: Sequence[SpeedPoint]) -> tuple[list[SpeedPoint], Real]:
        """Return the points without what the profile adds to each, and how that errs, by leaving out each stroke.

        The errors [N], shape (strokes, n), are directions in which the forces of all points move together: the sum of
        their squares is that of half a 95 % interval.
        """
        n, by = len(self.numbers), self.means()
        each = np.array([self.means(k) for k in range(n)])
        errors = np.zeros((n, len(points)))
        errors[:, self.numbers] = np.sqrt((n - 1) / n) * (each - each.mean(axis=0))
        return self._without(points, by, np.linalg.norm(errors, axis=0)), float(stdtrit(n - 1, 0.975)) * errors

    def _without(self, points: Sequence[SpeedPoint], by: Real, errors: Real | None = None) -> list[SpeedPoint]:
        found = list(points)
        for number, size in zip(self.numbers, by, strict=True):
            one = points[number]
            error = float(np.hypot(one.standard_error, 0.0 if errors is None else errors[number]))
            found[number] = replace(one, force=one.force - float(size), standard_error=error, over_position=float(size))
        return found


class Slope(NamedTuple):
    """A force that rises along the axis, taken off the records.

    Parameters
    ----------
    rises, half
        By how much [N/m], and half its 95 % interval.
    middle, length
        Of the way that the strokes cover [m].
    """

    rises: float
    half: float
    middle: float
    length: float

    def together(self, points: Sequence[SpeedPoint], strokes: Sequence[tuple[int, Log, Segment]]) -> Real:
        """Return how the error of the slope moves the forces of all points [N], half widths, shape (1, n)."""
        moved = np.zeros((1, len(points)))
        for number, log, segment in strokes:
            at = log.require("position", "a force over position")[segment.start : segment.stop]
            moved[0, number] = self.half * (float(at.mean()) - self.middle)
        return moved

    def notice(self, motion: Motion) -> Notice:
        """Return what there is to say of it."""
        newton, metre = si_unit("force", motion), si_unit("position", motion)
        return Notice(
            f"the force rises along the axis by {readable(self.rises * self.length, newton, 3)} over the "
            f"{readable(self.length, metre, 3)} of the strokes, as a spring, a cable, a balance or a tilt makes it: "
            f"it is taken off, and the offset is that at {readable(self.middle, metre, 3)}",
            "force-over-position", "note",
        )  # fmt: skip


def without_slope(
    records: Sequence[Log | ForceVelocity], points: Sequence[SpeedPoint], asked: OverPosition
) -> tuple[Sequence[Log | ForceVelocity], Slope | None]:
    """Return the records without a force that rises along the axis, where strokes show it, and that force.

    Slow strokes stay at one end of the way that fast ones cover: the rise would be taken for friction over speed.
    Where more than a slope comes again at the same places, all is left to `without_places`.
    """
    logs = [one for one in records if isinstance(one, Log) and one.position is not None]
    strokes = [] if asked == "off" else [(log, segment) for _, log, segment in steady_strokes(logs, points)]
    if (found := along_axis(strokes)) is None or over_place(strokes) is not None:
        return records, None
    ways = [log.require("position", "it")[segment.onset : segment.stop] for log, segment in strokes]
    low, high = min(float(way.min()) for way in ways), max(float(way.max()) for way in ways)
    if abs(found[0]) * (high - low) < SMALL * float(np.median([abs(point.force) for point in points])):
        return records, None
    slope = Slope(*found, 0.5 * (low + high), high - low)
    level = [
        one if not isinstance(one, Log) or one.position is None or one.force is None
        else replace(one, force=one.force - slope.rises * (one.position - slope.middle))
        for one in records
    ]  # fmt: skip
    return level, slope


def steady_strokes(logs: Sequence[Log], points: Sequence[SpeedPoint]) -> list[tuple[int, Log, Segment]]:
    """Return record and steady segment of each point that is from a stroke that does not swing, with its number."""
    named = {log.name: log for log in logs}
    return [
        (n, named[point.record], Segment(start, stop + 1, point.velocity, 0.0, onset, point.settled))
        for n, point in enumerate(points)
        if not point.swing and len(named) == len(logs) and point.record in named
        for times in [(point.start if point.onset is None else point.onset, point.start, point.stop)]
        for onset, start, stop in [np.searchsorted(named[point.record].time, times)]
    ]


def without_places(
    points: list[SpeedPoint], strokes: list[tuple[int, Log, Segment]], place: OverPlace | None, asked: OverPosition,
    solving: Callable[..., tuple[Fitted, HeldOut]], offset_open: bool,
) -> tuple[list[SpeedPoint], Real | None, dict[str, float]]:  # fmt: skip
    """Return the points, without what comes again at their places where that predicts better.

    And how they then err together, and how well what was not chosen predicts.

    Parameters
    ----------
    points
        The points of all strokes.
    strokes
        Those of `steady_strokes`.
    place
        What the records show over position; None for nothing.
    asked
        Whether to take it off.
    solving
        Fits the map, and tells how well each form predicts what is held out.
    offset_open
        Whether the offset is told by the strokes, and not stated.
    """
    strokes = [one for one in strokes if one[1].position is not None]
    if asked == "off" or len(strokes) < FEWEST or (asked == "auto" and place is None):
        return points, None, {}
    profile = Profile(strokes, points)
    if asked == "on":
        return *profile.taken_off(points), {}
    both_directions = len({np.sign(p.velocity) for p in points}) == 2
    (plain, raw), (fitted, placed) = (
        solving(some, with_offset=both_directions and offset_open) for some in (points, profile.held_out(points))
    )
    both = plain.kept & fitted.kept
    as_logged, without = raw.errors[raw.form][both[plain.kept]], placed.errors[placed.form][both[fitted.kept]]
    held_out = HeldOut(raw.weight[both[plain.kept]], "as logged", {"as logged": as_logged})
    if held_out.better("without", without):
        return *profile.taken_off(points), {"with what comes again at the same places": held_out["as logged"]}
    return points, None, {"without what comes again at the same places": held_out["without"]}
