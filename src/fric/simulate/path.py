"""Any smooth contour, given by points: followed at a constant feed, and what remains of it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import floor
from typing import Unpack

import numpy as np

from fric.arrays import Mask, Real
from fric.contour import ContourError, contour_error
from fric.control.scheme import Scheme
from fric.errors import FricError
from fric.flaws.prediction import NO_REVERSAL
from fric.notice import Notice
from fric.reference import Reference, cubic_spline, instants, refuse_long, smooth_step
from fric.series import LARGEST, keep
from fric.simulate.contour_run import ContourRun, How
from fric.simulate.machine import Machine

SHARPEST = np.pi / 4  # Largest turn from one chord of a path to the next [rad]: more is a corner
RAMP = 0.1  # Time in which the feed rises from rest, and falls to it [s]


@dataclass(frozen=True, eq=False)
class PointPath:
    """A path through points, followed at a constant feed.

    A cubic spline over the length of the chords runs through the points; a path that ends where it began is closed
    smoothly.

    Parameters
    ----------
    x, y
        The points [m], each of shape (n,).
    feed
        Speed along the path [m/s].

    Raises
    ------
    FricError
        When there are fewer than four points, the path has a corner or is too short for its feed.
    """

    x: Real
    y: Real
    feed: float

    def __post_init__(self) -> None:
        keep(self, {"x": "position", "y": "position"}, "", least=1)
        if not 0 < self.feed <= LARGEST["velocity"]:
            raise FricError(f"the feed of the path is {self.feed:g}", hint="Give a positive speed.")
        if len(self.points) < 4:
            raise FricError(f"the path has {len(self.points)} different points", hint="Give four points or more.")
        chords = np.diff(self.points, axis=0)
        heading = np.unwrap(np.arctan2(chords[:, 1], chords[:, 0]))
        corner = int(np.argmax(np.abs(np.diff(heading))))
        if abs(heading[corner + 1] - heading[corner]) > SHARPEST:
            x, y = self.points[corner + 1] * 1e3
            raise FricError(
                f"the path has a corner at x = {x:g} mm, y = {y:g} mm",
                hint="No drive follows it at constant feed: round it with more points.",
            )

    @property
    def points(self) -> Real:
        """The points without repetitions [m], shape (n, 2)."""
        points = np.column_stack([self.x, self.y])
        return points[np.concatenate([[True], np.any(np.diff(points, axis=0) != 0, axis=1)])]

    def references(self, sampling: float) -> tuple[Reference, Reference]:
        """Return the motion of both axes, from rest to rest, sampled at a rate [Hz]."""
        points = self.points
        knots = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        closed = np.allclose(points[0], points[-1], rtol=0, atol=1e-9 * knots[-1])
        if closed:
            points = np.vstack([points[:-1], points[:1]])
        spline = cubic_spline(knots, points, "periodic" if closed else "natural")
        # the length of the spline, by the speed along it between closely spaced parameters
        fine = np.linspace(0.0, knots[-1], 50 * len(knots))
        middle = np.hypot(*spline((fine[1:] + fine[:-1]) / 2, 1).T)
        ends = np.hypot(*spline(fine, 1).T)
        length = np.concatenate([[0.0], np.cumsum(np.diff(fine) * (ends[1:] + 4 * middle + ends[:-1]) / 6)])
        cruise = length[-1] / self.feed - RAMP
        if cruise <= 0:
            raise FricError(
                f"a path of {length[-1] * 1e3:.3g} mm is too short for {self.feed * 1e3:g} mm/s",
                hint="Lower the feed, or give a longer path.",
            )
        t = instants(cruise + 2 * RAMP, sampling, more=1)
        up, up_travel, up_slope, _ = smooth_step(t / RAMP)
        down, down_travel, down_slope, _ = smooth_step((t - cruise - RAMP) / RAMP)
        travelled = np.minimum(self.feed * RAMP * (up_travel - down_travel), length[-1])
        speed, change = self.feed * (up - down), self.feed / RAMP * (up_slope - down_slope)
        at = cubic_spline(length, fine, "not-a-knot")(travelled)
        first, second = spline(at, 1), spline(at, 2)
        rate = np.hypot(*first.T)[:, np.newaxis]
        tangent = first / rate
        bend = (second - tangent * np.sum(tangent * second, axis=1, keepdims=True)) / rate**2
        position, velocity = spline(at), tangent * speed[:, np.newaxis]
        acceleration = bend * speed[:, np.newaxis] ** 2 + tangent * change[:, np.newaxis]
        x, y = (
            Reference(sampling, *(np.ascontiguousarray(part[:, n]) for part in (position, velocity, acceleration)))
            for n in (0, 1)
        )
        return x, y

    def at_full_feed(self, velocity: Real) -> Mask:
        """Return where the feed is full, of velocities [m/s], shape (n, 2)."""
        return np.asarray(np.hypot(*velocity.T) > self.feed * (1 - 1e-6))


@dataclass(frozen=True, eq=False)
class RecordedPath:
    """A recorded reference: it is followed as it was commanded, with its instants.

    Between its samples it is a cubic spline, whose derivatives are velocity and acceleration.

    Raises FricError: When there are fewer than ten samples, the motion does not begin at rest, or `fric.series.keep`
        raises.
    """

    time: Real  # Sample instants [s], strictly increasing, shape (n,)
    x: Real  # x, y: reference of the axes [m], each of shape (n,)
    y: Real

    def __post_init__(self) -> None:
        keep(self, {"time": "time", "x": "position", "y": "position"}, "", least=10)
        steps = np.hypot(np.diff(self.x), np.diff(self.y)) / np.diff(self.time)
        if not steps.max() > 0:
            raise FricError("the reference does not move")
        if steps[0] > 0.02 * steps.max():
            raise FricError(
                f"the reference begins at {steps[0] * 1e3:.3g} mm/s", hint="Record it from rest: so the axes begin."
            )

    @cached_property
    def feed(self) -> float:
        """The speed that is held the longest [m/s]: the median of all that is above half of the largest."""
        speed = np.hypot(np.gradient(self.x, self.time), np.gradient(self.y, self.time))
        return float(np.median(speed[speed > 0.5 * speed.max()]))

    def references(self, sampling: float) -> tuple[Reference, Reference]:
        """Return the motion of both axes, sampled at a rate [Hz]."""
        span = self.time[-1] - self.time[0]
        refuse_long(span, sampling)
        t = np.arange(floor(span * sampling + 1e-6) + 1) / sampling + self.time[0]
        made = []
        for values in (self.x, self.y):
            spline = cubic_spline(self.time, values, "not-a-knot")
            made.append(Reference(sampling, *(np.ascontiguousarray(spline(t, order)) for order in (0, 1, 2))))
        return made[0], made[1]

    def at_full_feed(self, velocity: Real) -> Mask:
        """Return where the feed is full, of velocities [m/s], shape (n, 2)."""
        return np.asarray(np.hypot(*velocity.T) > 0.98 * self.feed)


class PathRun(ContourRun[PointPath | RecordedPath, ContourError]):
    """Result of one scheme on a path: contour error and glitches, where the feed is full."""

    @classmethod
    def judged(
        cls, test: PointPath | RecordedPath, references: Sequence[Reference], motion: Sequence[Real]
    ) -> tuple[ContourError, tuple[Notice, ...]]:
        """Return the distance from the path where the feed is full."""
        asked, velocity = (
            np.column_stack([getattr(reference, part) for reference in references]) for part in ("position", "velocity")
        )
        full = test.at_full_feed(velocity)
        error = contour_error(asked[full], velocity[full], np.column_stack(motion)[full], references[0].sampling)
        return error, () if error.reversals else (NO_REVERSAL.found(),)

    @property
    def path(self) -> PointPath | RecordedPath:
        """The path."""
        return self.test


def run_path(machine: Machine, scheme: Scheme, path: PointPath | RecordedPath, **how: Unpack[How]) -> PathRun:
    """Follow a path with two axes of a machine under one scheme; arguments and errors as `run_circle`."""
    return PathRun.run(machine, scheme, path, **how)
