"""What the data cannot tell about a fitted static map, in words."""

from __future__ import annotations

from math import isinf, sqrt
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import chdtrc

from fric.estimate import Interval
from fric.units import Motion, readable, si_unit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.drive.plant import Plant
    from fric.identify.strokes.map_fit import MapFit

CORRELATED = 0.95
"""Correlation of two parameters from which on the data tell them apart badly."""


def map_doubts(fit: MapFit, motion: Motion) -> list[str]:
    """Say what the data cannot tell about a fitted map."""
    problem, theta = fit.problem, fit.solution.theta
    doubts: list[str] = []
    slowest = float(np.abs(problem.v).min())
    told = readable(slowest, si_unit("velocity", motion))
    flat = theta["F_s"] <= theta["F_c"] * (1 + 1e-9)
    if flat:
        doubts.append(
            f"F_s sits at its bound F_c: friction does not fall with speed down to {told}; v_s means nothing here."
        )
    elif any(isinf(limit) or limit == 0.0 for name in ("F_s", "v_s") for limit in _interval(fit, name)):
        doubts.append(
            f"the data do not reach the Stribeck range: F_s and v_s are not settled by strokes from {told} up. "
            "Log slower strokes."
        )
    if fit.left_out:
        speeds = dict.fromkeys(readable(p.velocity, si_unit("velocity", motion)) for p in fit.left_out)
        strokes = ", ".join(speeds)
        doubts.append(f"left out, because they stand off all others: the strokes at {strokes}. Look at their records.")
    doubts += _correlations(fit, without=("v_s", "delta") if flat else ())
    own_scatter = float(np.sum(fit.residual**2 / (problem.standard_error**2 - fit.between**2)))
    if fit.between and chdtrc(problem.degrees_of_freedom, own_scatter) < 0.01:
        spread = readable(fit.between, si_unit("force", motion), 2)
        doubts.append(f"strokes scatter by {spread} beyond their own noise; weights and intervals allow for it.")
    visible = fit.rmse > 1e-6 * float(np.abs(problem.F).max())
    if visible and _patterned(problem.v, fit.residual / problem.standard_error):
        doubts.append(
            "the residuals are not noise, they follow the speed: eq. (2) does not describe these strokes wholly. "
            "Try --delta free or --direction each, and look at the figure."
        )
    return doubts


def _interval(fit: MapFit, name: str) -> Interval:
    low, high = fit.estimates[name].ci95 or (0.0, 0.0)
    assert isinstance(low, float)
    assert isinstance(high, float)
    return low, high


def _correlations(fit: MapFit, without: tuple[str, ...]) -> list[str]:
    size = np.sqrt(np.diag(fit.covariance))
    free = fit.problem.free
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = fit.covariance / np.outer(size, size)
    pairs = [
        f"{free[j]} and {free[i]} ({correlation[i, j]:+.3f})"
        for i in range(len(free))
        for j in range(i)
        if not {free[i], free[j]}.intersection(without)
        and CORRELATED < abs(correlation[i, j]) <= 1.0 + 1e-9  # beyond 1 at a bound, where the curvature says nothing
    ]
    return [f"correlated, the data tell them apart badly: {', '.join(pairs)}."] if pairs else []


def _patterned(v: NDArray[np.float64], residual: NDArray[np.float64]) -> bool:
    """Test whether residuals in the order of velocity are smoother than noise (von Neumann's ratio, 1 % level)."""
    n = len(v)
    if n < 8:
        return False
    r = residual[np.argsort(v)]
    ratio = float(np.sum(np.diff(r) ** 2) / np.sum((r - r.mean()) ** 2))
    return (ratio - 2.0) / sqrt(4.0 * (n - 2) / (n**2 - 1)) < -2.33


def damping_doubt(fit: MapFit, plant: Plant, motion: Motion) -> list[str]:
    """Say when the drive's own damping, taken off with a plant, leaves no viscous friction."""
    damping = plant.K_f * plant.A / plant.B
    interval = fit.estimates["sigma"].ci95
    if fit.solution.theta["sigma"] > 0 or interval is None:
        return []
    told = readable(damping, si_unit("viscous", motion))
    return [f"sigma is 0 after the drive's own damping of {told} was taken off: is the plant's A or K_f too large?"]
