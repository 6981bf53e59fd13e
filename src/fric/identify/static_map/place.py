"""What the force of strokes shows at the same places again, whatever the speed, taken off their means.

Along stroke i the force is ``F_i(z) = m_i + c(z) + w(z)·m_i/|m|``, |m| being the median of all: c is a force over
position, w friction over position, both zero in the mean over the travel that strokes cover. A slow stroke is at one
place alone, and its mean is off by what c and w are there; they are told by the strokes that go far.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Real
from fric.identify.static_map.forms import FEWEST, predicts_better, weighted_rms
from fric.identify.static_map.map_fit import solved
from fric.identify.static_map.points import SpeedPoint
from fric.identify.static_map.strokes import Correction, Strokes
from fric.records.over_strokes import PLACES

FINER = 4
"""Cells that a place is looked at in."""


def place(strokes: Strokes) -> Correction | None:
    """Take off what comes again at the places of strokes, where held-out strokes are predicted better so."""
    asked = strokes.asked.over_position
    few = len(strokes.stretches.with_position) < FEWEST
    if asked == "off" or few or (asked == "auto" and strokes.stretches.place is None):
        return None
    profile = Profile(strokes)
    if asked == "on":
        points, together = profile.taken_off(strokes.points)
        return Correction(points=points, together=together)
    (plain, raw), (fitted, placed) = (
        solved(replace(strokes, points=points), strokes.offset)
        for points in (strokes.points, profile.held_out(strokes.points))
    )
    both = plain.kept & fitted.kept
    weight = raw.weight[both[plain.kept]]
    as_logged, without = raw.errors[raw.form][both[plain.kept]], placed.errors[placed.form][both[fitted.kept]]
    again = "what comes again at the same places"
    if not predicts_better(weight, as_logged, without):
        return Correction(tried={f"without {again}": weighted_rms(weight, without)})
    points, together = profile.taken_off(strokes.points)
    return Correction(points=points, together=together, tried={f"with {again}": weighted_rms(weight, as_logged)})


class Profile:
    """Forces over position, as the strokes tell them."""

    def __init__(self, strokes: Strokes) -> None:
        self.numbers, points = list(strokes.stretches.with_position), strokes.points
        stretches = strokes.stretches.with_position.values()
        travels = [log.require("position", "a force over position")[s.start : s.stop] for log, s in stretches]
        low, high = min(z.min() for z in travels), max(z.max() for z in travels)
        edges = np.linspace(low, high, FINER * PLACES + 1)
        level = float(np.median([abs(points[number].force) for number in self.numbers])) or 1.0
        normal, right, self._means = [], [], []
        covered = np.zeros(PLACES + 1)
        for number, (log, segment), z in zip(self.numbers, stretches, travels, strict=True):
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
