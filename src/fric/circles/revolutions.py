"""Circles found in a motion of two axes, and the whole revolutions at steady feed of a circle test."""

from dataclasses import dataclass
from itertools import pairwise
from math import floor, log10, pi

import numpy as np

from fric.arrays import Indices, Real
from fric.circles.measured import MeasuredCircle
from fric.errors import FricError

STEADY = 0.01  # Relative deviation of the feed from its median up to which a motion is steady
ROUND = 2e-3  # Relative distance within which a measured radius or feed counts as a round number


@dataclass(frozen=True)
class FoundCircle:
    """A circle within a motion."""

    samples: slice  # The samples from rest to rest
    centre: tuple[float, float]  # Its centre [m]
    radius: float  # radius, feed: as found [m], [m/s]
    feed: float
    direction: int  # 1 counter-clockwise, -1 clockwise
    revolutions: float  # How far it turns [1]


def fit_circle(x: Real, y: Real) -> tuple[float, float, float]:
    """Return centre and radius [m] of the least-squares circle through points, by Gauss and Newton.

    The first guess is Kåsa's algebraic fit; the steps then minimise the radial deviations themselves.
    """
    shift_x, shift_y = float(x.mean()), float(y.mean())
    u, w = x - shift_x, y - shift_y
    a, b, c = np.linalg.lstsq(np.column_stack([2 * u, 2 * w, np.ones_like(u)]), u * u + w * w, rcond=None)[0].tolist()
    r = float(np.sqrt(max(c + a * a + b * b, 0.0)))
    for _ in range(6):
        rho = np.hypot(u - a, w - b)
        safe = np.where(rho > 0, rho, 1.0)
        slope = np.column_stack([(u - a) / safe, (w - b) / safe, np.ones_like(u)])
        step = np.linalg.lstsq(slope, rho - r, rcond=None)[0]
        a, b, r = a + float(step[0]), b + float(step[1]), r + float(step[2])
        if np.abs(step).max() < 1e-12 * max(r, 1e-12):
            break
    return a + shift_x, b + shift_y, r


def find_circles(time: Real, x: Real, y: Real, least: float = 1.0) -> list[FoundCircle]:
    """Return the circles of a motion: segments between rests along which it turns steadily around one point.

    time, x, y: Sample instants [s], reference or measured position [m], each of shape (n,).
    """
    parts = (slice(*ends) for ends in _moving(time, x, y))
    circles = (_circle_in(part, time[part], x[part], y[part], least) for part in parts)
    return [circle for circle in circles if circle]


def _moving(time: Real, x: Real, y: Real) -> list[tuple[int, int]]:
    """Return first and last sample (exclusive) of each segment that moves, cut at rests, gaps and full turns back.

    The motion is evaluated over spans of at least a 400th of it, to which noise and quantisation matter little.
    """
    n = len(time)
    size = 0.5 * max(float(np.ptp(x)), float(np.ptp(y))) if n >= 16 else 0.0
    if not size > 0:
        return []
    step = np.hypot(np.diff(x), np.diff(y))
    period = float(np.median(np.diff(time)))
    # a span long enough that noise is no motion: its displacement is compared with the noise of one sample
    noise = float(np.median(np.abs(np.diff(x, 2)))) + float(np.median(np.abs(np.diff(y, 2))))
    span = 1
    while span < n // 64 and np.median(np.hypot(x[span:] - x[:-span], y[span:] - y[:-span])) < 20 * noise:
        span *= 2
    moved = np.hypot(x[span:] - x[:-span], y[span:] - y[:-span])
    still = np.concatenate([moved <= max(5 * noise, 1e-9 * size), np.zeros(span, bool)])
    gaps = np.concatenate([[False], np.diff(time) > 20 * period]) | np.concatenate([[False], step > 0.2 * size])
    edges = {0, n, *(np.flatnonzero(np.diff(still)) + 1).tolist(), *np.flatnonzero(gaps).tolist()}
    return [(a, b) for a, b in pairwise(sorted(edges)) if b - a > 16 and not still[a:b].all()]


def _circle_in(part: slice, time: Real, x: Real, y: Real, least: float) -> FoundCircle | None:
    a, b, r = fit_circle(x, y)
    if not (np.isfinite([a, b, r]).all() and r > 0):
        return None
    if np.quantile(np.abs(np.hypot(x - a, y - b) - r), 0.95) > 0.02 * r:
        return None
    angle = np.unwrap(np.arctan2(y - b, x - a))
    turned = float(angle[-1] - angle[0])
    if abs(turned) < 2 * pi * least - 1e-3:
        return None
    inside = steady(time, angle)
    rate = np.ptp(angle[[inside.start, inside.stop - 1]]) / np.ptp(time[[inside.start, inside.stop - 1]])
    # centre and radius of the steady part alone: the run-in may swing
    a, b, r = fit_circle(x[inside], y[inside])
    return FoundCircle(part, (a, b), r, float(rate) * r, 1 if turned > 0 else -1, abs(turned) / (2 * pi))


def steady(time: Real, angle: Real) -> slice:
    """Return the longest segment at which an angle turns at its median rate, within 1 %, over eighths of a turn."""
    revolved = abs(float(angle[-1] - angle[0])) / (2 * pi)
    span = max(int(len(time) / max(revolved, 1.0) / 48), 1)
    rate = (angle[span:] - angle[:-span]) / (time[span:] - time[:-span])
    middle = float(np.median(rate[len(rate) // 4 : max(3 * len(rate) // 4, len(rate) // 4 + 1)]))
    good = np.abs(rate - middle) <= STEADY * abs(middle)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(int), [0]])))
    if not len(edges):
        return slice(0, len(time))
    runs = edges.reshape(-1, 2)
    first, last = runs[np.argmax(runs[:, 1] - runs[:, 0])]
    return slice(int(first), min(int(last) + span, len(time)))


def rounded(value: float, within: float = ROUND) -> float:
    """Return the roundest number of up to three digits within a relative distance of a value; else the value."""
    for digits in (1, 2, 3):
        scale = 10.0 ** (digits - 1 - floor(log10(value)))
        if abs(round(value * scale) / scale - value) <= within * value:
            return round(value * scale) / scale
    return value


@dataclass(frozen=True)
class Revolutions:
    """The whole revolutions of a circle test at steady feed."""

    test: MeasuredCircle  # The circle test
    angle: Real  # Angle on the reference circle [rad], unwrapped, in the order of the motion, shape (n,)
    deviation: Real  # Radial deviation from the nominal circle [m], shape (n,)
    revolution: Indices  # Number of the revolution that each sample is of, shape (n,)
    # Reference less position of each axis [m], by name, shape (n,); none of an axis without reference
    errors: dict[str, Real]

    @property
    def count(self) -> int:
        """Number of whole revolutions."""
        return int(self.revolution[-1]) + 1

    def averaged(self, bins: int) -> tuple[Real, Real, Real]:
        """Return centres of equal parts of a turn [rad], the mean deviation in each [m], and its scatter [m].

        The scatter is the standard deviation between the means of the revolutions; nan of one revolution alone, and
        of parts without samples.
        """
        part = np.floor((self.angle % (2 * pi)) / (2 * pi) * bins).astype(int) % bins
        index = self.revolution * bins + part
        cells = self.count * bins
        number = np.bincount(index, minlength=cells)
        with np.errstate(invalid="ignore", divide="ignore"):
            means = (np.bincount(index, self.deviation, cells) / number).reshape(self.count, bins)
        there = np.isfinite(means)
        count = np.maximum(there.sum(axis=0), 1)
        mean = np.where(there.any(axis=0), np.where(there, means, 0.0).sum(axis=0) / count, np.nan)
        square = np.where(there, (means - mean) ** 2, 0.0).sum(axis=0)
        scatter = np.where(count > 1, np.sqrt(square / np.maximum(count - 1, 1)), np.nan)
        return (np.arange(bins) + 0.5) * 2 * pi / bins, mean, scatter


def revolutions(test: MeasuredCircle) -> Revolutions:
    """Return the whole revolutions of a circle test at steady feed, counted back from where the feed ends.

    The angle is that of the reference where it was recorded, and else of the position. A ball bar measures both.

    Raises FricError: When there is no whole revolution.
    """
    errors: dict[str, Real] = {}
    if test.angle is not None and test.deviation is not None:
        angle, deviation = np.unwrap(test.angle), test.deviation
        inside = slice(0, len(angle))
    else:
        traces = test.together()
        both = all(trace.reference is not None for trace in traces)
        x, y = (trace.asked if both else trace.position for trace in traces)
        a, b, _ = fit_circle(x, y)
        angle = np.unwrap(np.arctan2(y - b, x - a))
        inside = steady(traces[0].time, angle)
        for name, trace in zip(test.names, traces, strict=True):
            if trace.reference is not None:
                errors[name] = trace.reference - trace.position
        deviation = np.hypot(traces[0].position - a, traces[1].position - b) - test.radius
    angle, deviation = angle[inside], deviation[inside]
    turned = np.abs(angle[-1] - angle)
    spare = max(1e-3, 1.5 * float(np.median(np.abs(np.diff(angle)))))  # of a last sample on the first
    whole = int((turned[0] + spare) // (2 * pi))
    if whole < 1:
        raise FricError(
            f"covers {np.degrees(turned[0]):.0f}° of the circle at steady feed, and a whole revolution is needed",
            where=test.where, hint="Record one revolution more than the run-in and the run-out take.",
        )  # fmt: skip
    start = int(np.flatnonzero(turned >= 2 * pi * whole - spare)[-1])
    revolution = np.minimum((np.abs(angle[start:] - angle[start]) / (2 * pi) + 1e-9).astype(np.intp), whole - 1)
    errors = {name: error[inside][start:] for name, error in errors.items()}
    return Revolutions(test, angle[start:], deviation[start:], revolution, errors)
