"""By what time each axis of a circle is behind its reference."""

from collections.abc import Mapping, Sequence
from math import inf, pi

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Real
from fric.circles.geometry import Geometry, quiet, tails_of
from fric.circles.revolutions import Revolutions
from fric.estimate import Estimate
from fric.identify.replay.replay_intervals import covariance_of


def lags(tests: Sequence[Revolutions], behind: Sequence[Mapping[str, float]], fit: Geometry) -> dict[str, Estimate]:
    """Return the time by which each axis is behind its reference [s], with its 95 % interval.

    What of an axis' error goes with its velocity, where no glitch peaks, beside a constant, scale, backlash and the
    tails of the glitches. Squareness does the same in one direction and the opposite in the other: the mean over both
    is free of it, and of one direction the interval is open, but for the axes' own encoders, which do not see it.

    tests: Revolutions of each test; an axis without reference has no lag.
    behind: Per test and quadrant, up to what angle behind the reversal a glitch is left out [rad].
    fit: The geometry, whose tails these have.
    """
    found = {}
    for n, name in enumerate(tests[0].test.names):
        if not all(name in one.errors for one in tests):
            continue
        values, errors, freedom = zip(
            *(_lag(one, one.errors[name], n, ends, fit) for one, ends in zip(tests, behind, strict=True)), strict=True
        )
        value = float(np.mean(values))
        half_width = float(stdtrit(sum(freedom), 0.975)) * float(np.linalg.norm(errors)) / len(tests)
        if len(tests) == 1 and tests[0].test.instrument != "encoders":
            half_width = inf
        found[name] = Estimate.around(value, "s", half_width)
    return found


def _lag(
    tested: Revolutions, error: Real, axis: int, behind: Mapping[str, float], fit: Geometry
) -> tuple[float, float, int]:
    """Return a lag and its standard error [s], and the degrees of freedom of that."""
    used = np.flatnonzero(quiet(tested, behind))
    along = tested.angle[used] - axis * pi / 2  # the axis moves as the cosine of this
    speed = -tested.test.direction * tested.test.feed * np.sin(along)
    tails, _, bent = tails_of(tested, behind, fit.fade, fit.bend)[:, used]  # each bent by itself: one axis' share alone
    columns = np.column_stack([speed, np.ones(len(used)), np.cos(along), np.sign(speed), tails, bent])
    values, *_ = np.linalg.lstsq(columns, error[used], rcond=None)
    segments = [len(one) for one in np.split(used, np.flatnonzero(np.diff(used) > 1) + 1)]
    residual = error[used] - columns @ values
    if np.ptp(residual) <= 1e-12 * max(float(np.ptp(error)), 1e-15):
        return float(values[0]), 0.0, 1
    variance = float(covariance_of(columns, residual, segments)[0, 0])
    return float(values[0]), variance**0.5, max(len(segments) - 1, 1)
