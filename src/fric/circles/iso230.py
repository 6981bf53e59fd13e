"""The figures of ISO 230-4 for circular tests: circular deviation, radial deviations, mean bidirectional deviation."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np
from scipy.optimize import linprog

from fric.arrays import Real
from fric.circles.revolutions import Revolutions

BINS = 3600
"""Parts of a turn whose means the figures are taken of, where so many were sampled."""


@dataclass(frozen=True)
class Iso230:
    """Figures of ISO 230-4 (2005), Section 3."""

    # Circular deviation of each direction of turning, by 1 and -1: least radial separation of two concentric circles
    # that hold the path [m]
    G: dict[int, float]
    # Bidirectional circular deviation: of two circles that hold both paths [m]; None of one direction
    G_b: float | None
    # F_max, F_min: largest and least radial deviation from the nominal circle around the least-squares centre of the
    # path, over all paths [m], positive outwards
    F_max: float
    F_min: float
    # Mean bidirectional radial deviation: mean radius of both paths less the nominal radius [m]; None of one direction
    D: float | None


def minimum_zone(angle: Real, deviation: Real) -> float:
    """Return the least separation [m] of two concentric circles that hold a path near a circle.

    Radial deviations move with the centre by ``-(a·cos θ + b·sin θ)``, so that least separation is a linear programme;
    what this leaves out is the shift squared over twice the radius, and the shift is what is left of the centre.

    angle, deviation: The path, as angle [rad] and radial deviation [m] from any circle around it, shape (n,).
    """
    centred, _ = around_its_centre(angle, deviation)
    scale = float(np.ptp(centred))
    if scale == 0.0:
        return 0.0
    d, cos, sin, one = centred / scale, np.cos(angle), np.sin(angle), np.ones_like(angle)
    # unknown: shift of the centre (a, b), inner and outer circle; inner ≤ d - a·cos - b·sin ≤ outer
    A = np.vstack([np.column_stack([-cos, -sin, 0 * one, -one]), np.column_stack([cos, sin, one, 0 * one])])
    found = linprog([0, 0, -1, 1], A_ub=A, b_ub=np.concatenate([-d, d]), bounds=[(None, None)] * 4, method="highs")
    inner, outer = np.asarray(found.x)[2:]
    return float(outer - inner) * scale


def around_its_centre(angle: Real, deviation: Real) -> tuple[Real, float]:
    """Return a radial deviation [m] around the least-squares centre of its path, and its mean [m]."""
    basis = np.column_stack([np.cos(angle), np.sin(angle), np.ones_like(angle)])
    a, b, mean = np.linalg.lstsq(basis, deviation, rcond=None)[0]
    return deviation - basis[:, :2] @ np.array([a, b]), float(mean)


def iso230(tests: Sequence[Revolutions]) -> Iso230:
    """Return the figures of ISO 230-4 of the mean paths of one test, or of both directions of one circle."""
    paths: dict[int, tuple[Real, Real, float]] = {}
    for tested in tests:
        bins = min(BINS, max(len(tested.angle) // tested.count, 8))
        angle, mean, _ = tested.averaged(bins)
        there = np.isfinite(mean)
        angle, mean = angle[there], mean[there]
        if tested.count == 1 and bins < BINS:  # one sample a part: its own angle, not that of the part
            angle, mean = tested.angle % (2 * pi), tested.deviation
        centred, level = around_its_centre(angle, mean)
        paths[tested.test.direction] = (angle, centred, level)
    both = len(paths) == 2
    angle = np.concatenate([path[0] for path in paths.values()])
    joint = np.concatenate([path[1] for path in paths.values()])
    return Iso230(
        {direction: minimum_zone(angle_, d) for direction, (angle_, d, _) in paths.items()},
        minimum_zone(angle, joint) if both else None,
        max(float(d.max()) for _, d, _ in paths.values()),
        min(float(d.min()) for _, d, _ in paths.values()),
        float(np.mean([level for _, _, level in paths.values()])) if both else None,
    )
