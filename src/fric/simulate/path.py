"""Any smooth contour, given by points: followed at a constant feed, and what remains of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np

from fric.contour import ContourError, contour_error
from fric.errors import FricError
from fric.reference import Reference, smooth_step
from fric.simulate.axis import Trace, run_axis
from fric.simulate.circle import pair, require_voltage, run_warnings

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.control.scheme import Scheme
    from fric.simulate.machine import Machine

SHARPEST = np.pi / 4
"""Largest turn from one chord of a path to the next [rad]: more is a corner."""

RAMP = 0.1
"""Time in which the feed rises from rest, and falls to it [s]."""


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

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    feed: float

    def __post_init__(self) -> None:
        if not self.feed > 0:
            raise FricError(f"the feed of the path is {self.feed:g}", mend="Give a positive speed.")
        if len(self.points) < 4:
            raise FricError(f"the path has {len(self.points)} different points", mend="Give four points or more.")
        chords = np.diff(self.points, axis=0)
        heading = np.unwrap(np.arctan2(chords[:, 1], chords[:, 0]))
        corner = int(np.argmax(np.abs(np.diff(heading))))
        if abs(heading[corner + 1] - heading[corner]) > SHARPEST:
            x, y = self.points[corner + 1] * 1e3
            raise FricError(
                f"the path has a corner at x = {x:g} mm, y = {y:g} mm",
                mend="No drive follows it at constant feed: round it with more points.",
            )

    @property
    def points(self) -> NDArray[np.float64]:
        """The points without repetitions [m], shape (n, 2)."""
        points = np.column_stack([self.x, self.y])
        return points[np.concatenate([[True], np.any(np.diff(points, axis=0) != 0, axis=1)])]

    def references(self, sampling: float) -> tuple[Reference, Reference]:
        """Return the motion of both axes, from rest to rest, sampled at a rate [Hz]."""
        from scipy.interpolate import CubicSpline  # not at the start, which circles share: it takes 0.1 s

        points = self.points
        knots = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        closed = np.allclose(points[0], points[-1], rtol=0, atol=1e-9 * knots[-1])
        if closed:
            points = np.vstack([points[:-1], points[:1]])
        spline = CubicSpline(knots, points, bc_type="periodic" if closed else "natural")
        # the length of the spline, by the speed along it between closely spaced parameters
        fine = np.linspace(0.0, knots[-1], 50 * len(knots))
        middle = np.hypot(*spline((fine[1:] + fine[:-1]) / 2, 1).T)
        ends = np.hypot(*spline(fine, 1).T)
        length = np.concatenate([[0.0], np.cumsum(np.diff(fine) * (ends[1:] + 4 * middle + ends[:-1]) / 6)])
        cruise = length[-1] / self.feed - RAMP
        if cruise <= 0:
            raise FricError(
                f"a path of {length[-1] * 1e3:.3g} mm is too short for {self.feed * 1e3:g} mm/s",
                mend="Lower the feed, or give a longer path.",
            )
        t = np.arange(ceil((cruise + 2 * RAMP) * sampling) + 1) / sampling
        up, up_travel, up_slope, _ = smooth_step(t / RAMP)
        down, down_travel, down_slope, _ = smooth_step((t - cruise - RAMP) / RAMP)
        travelled = np.minimum(self.feed * RAMP * (up_travel - down_travel), length[-1])
        speed, change = self.feed * (up - down), self.feed / RAMP * (up_slope - down_slope)
        at = CubicSpline(length, fine)(travelled)
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


@dataclass(frozen=True, eq=False)
class PathRun:
    """What one scheme makes of a path.

    Parameters
    ----------
    scheme
        The compensation scheme.
    path
        The path.
    traces
        What each axis recorded, by its name.
    contour
        Contour error and glitches, where the feed is full.
    warnings
        What the user should know.
    """

    scheme: Scheme
    path: PointPath
    traces: Mapping[str, Trace]
    contour: ContourError
    warnings: tuple[str, ...] = ()


def run_path(machine: Machine, scheme: Scheme, path: PointPath, *, halvings: int = 0, accuracy: float = 0.0) -> PathRun:
    """Follow a path with two axes of a machine under one scheme.

    Parameters
    ----------
    machine
        The machine; its first two axes are x and y of the path.
    scheme
        The compensation scheme.
    path
        The path.
    halvings
        How often every step of the plant is halved, to see that this changes nothing.
    accuracy
        By how much the integration of the plant may move a position [m]; 0 for the last digits.

    Raises
    ------
    FricError
        When the machine has no two linear axes at one controller rate, or a run is not possible.
    """
    names = pair(machine)
    sampling = machine.axes[names[0]].cascade.sampling
    references = path.references(sampling)
    for name, reference in zip(names, references, strict=True):
        require_voltage(machine.axes[name], reference)
    traces = {
        name: run_axis(machine.axes[name], reference, scheme, halvings=halvings, accuracy=accuracy)
        for name, reference in zip(names, references, strict=True)
    }
    asked, velocity = (
        np.column_stack([getattr(reference, part) for reference in references]) for part in ("position", "velocity")
    )
    motion = np.column_stack([traces[name].position for name in names])
    full = np.hypot(*velocity.T) > path.feed * (1 - 1e-6)
    error = contour_error(asked[full], velocity[full], motion[full], sampling)
    warnings = run_warnings(scheme, traces)
    if not error.reversals:
        warnings += ("no axis turns on this path at full feed: there is no glitch",)
    return PathRun(scheme, path, traces, error, warnings)


def path_document(runs: Sequence[PathRun]) -> dict[str, Any]:
    """Return what schemes leave of one path as a plain document, for programs."""
    schemes = {
        run.scheme.name: {
            "title": run.scheme.title,
            "glitch": run.contour.glitch,
            "reversals": [
                {"axis": tuple(run.traces)[found.axis], "x": found.x, "y": found.y, "glitch": found.glitch}
                for found in run.contour.reversals
            ],
            "contour_rms": run.contour.rms,
            "contour_range": run.contour.range,
            "warnings": list(run.warnings),
        }
        for run in runs
    }
    return {"velocity": runs[0].path.feed, "schemes": schemes}
