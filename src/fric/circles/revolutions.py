"""Circles in a motion of two axes, their whole revolutions at steady feed, and the glitch at each reversal."""

from collections.abc import Container
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import floor, log10, pi, radians, sqrt

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Indices, Real
from fric.circles.measured import MeasuredCircle
from fric.contour import QUADRANTS, WINDOW
from fric.errors import FricError
from fric.statistics import parameter_covariance

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


def find_circles(time: Real, x: Real, y: Real) -> list[FoundCircle]:
    """Return the circles of a motion: segments between rests along which it turns steadily around one point.

    time, x, y: Sample instants [s], reference or measured position [m], each of shape (n,).
    """
    parts = (slice(*ends) for ends in _moving(time, x, y))
    return [circle for circle in (_circle_in(part, time[part], x[part], y[part]) for part in parts) if circle]


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


def _circle_in(part: slice, time: Real, x: Real, y: Real) -> FoundCircle | None:
    a, b, r = fit_circle(x, y)
    if not (np.isfinite([a, b, r]).all() and r > 0):
        return None
    if np.quantile(np.abs(np.hypot(x - a, y - b) - r), 0.95) > 0.02 * r:
        return None
    angle = np.unwrap(np.arctan2(y - b, x - a))
    if abs(turned := float(angle[-1] - angle[0])) < 2 * pi - 1e-3:
        return None
    inside = steady(time, angle)
    rate = np.ptp(angle[[inside.start, inside.stop - 1]]) / np.ptp(time[[inside.start, inside.stop - 1]])
    # centre and radius of the steady part alone: the run-in may swing
    a, b, r = fit_circle(x[inside], y[inside])
    return FoundCircle(part, (a, b), r, float(rate) * r, 1 if turned > 0 else -1, abs(turned) / (2 * pi))


def steady(time: Real, angle: Real) -> slice:
    """Return the longest segment at which an angle turns at its median rate, within 1 %.

    Over 1/48 of a turn; over a quarter where that leaves no whole turn: glitches turn the angle of a position, too.
    """
    revolved, found = abs(float(angle[-1] - angle[0])) / (2 * pi), list[slice]()
    for parts in (48, 4):
        span = max(int(len(time) / max(revolved, 1.0) / parts), 1)
        rate = (angle[span:] - angle[:-span]) / (time[span:] - time[:-span])
        middle = float(np.median(rate[len(rate) // 4 : max(3 * len(rate) // 4, len(rate) // 4 + 1)]))
        good = np.abs(rate - middle) <= STEADY * abs(middle)
        if not len(edges := np.flatnonzero(np.diff(np.concatenate([[0], good.astype(int), [0]])))):
            return found[0] if found else slice(0, len(time))
        runs = edges.reshape(-1, 2)
        first, last = runs[np.argmax(runs[:, 1] - runs[:, 0])]
        found.append(slice(int(first), min(int(last) + span, len(time))))
        if abs(float(angle[found[-1].stop - 1] - angle[found[-1].start])) >= 2 * pi:
            return found[-1]
    return found[0]


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
    errors: dict[str, Real]  # Reference less position [m], by name of an axis with reference, shape (n,)

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

    def beside(self, simulated: MeasuredCircle, known: Container[str]) -> MeasuredCircle:
        """Return a simulated circle on which an axis without a model errs as it was measured to.

        Centre, scales and the median radius are of both axes: where one followed its reference, the glitches of the
        other were 4 to 12 % off.
        """
        axes = dict(simulated.axes)
        for name in axes.keys() & self.errors.keys():
            if name not in known:
                bins = min(1440, max(len(self.angle) // self.count, 8))
                angle, error, _ = replace(self, deviation=self.errors[name]).averaged(bins)
                x, y = (trace.asked for trace in simulated.together())
                a, b, _ = fit_circle(x, y)
                seen = np.isfinite(error)
                along = np.interp(np.arctan2(y - b, x - a), angle[seen], error[seen], period=2 * pi)
                axes[name] = replace(axes[name], position=axes[name].asked - along)
        return replace(simulated, axes=axes)


def revolutions(test: MeasuredCircle) -> Revolutions:
    """Return the whole revolutions of a circle test at steady feed, counted back from where the feed ends.

    The angle is that of the reference where it was recorded, and else of the position. A ball bar measures both.
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
        both_named = zip(test.names, traces, strict=True)
        errors = {name: of.reference - of.position for name, of in both_named if of.reference is not None}
        deviation = np.hypot(traces[0].position - a, traces[1].position - b) - test.radius
    angle, deviation = angle[inside], deviation[inside]
    turned = np.abs(angle[-1] - angle)
    spare = max(1e-3, 1.5 * float(np.median(np.abs(np.diff(angle)))))  # of a last sample on the first
    if (whole := int((turned[0] + spare) // (2 * pi))) < 1:
        raise FricError(
            f"covers {np.degrees(turned[0]):.0f}° of the circle at steady feed, and a whole revolution is needed",
            where=test.where, hint="Record one revolution more than the run-in and the run-out take.",
        )  # fmt: skip
    start = int(np.flatnonzero(turned >= 2 * pi * whole - spare)[-1])
    revolution = np.minimum((np.abs(angle[start:] - angle[start]) / (2 * pi) + 1e-9).astype(np.intp), whole - 1)
    errors = {name: error[inside][start:] for name, error in errors.items()}
    _refuse_coarse(angle[start:], test.where)
    return Revolutions(test, angle[start:], deviation[start:], revolution, errors)


def _refuse_coarse(angle: Real, where: str) -> None:
    """Raise where around a reversal the samples of all revolutions are more than `COARSE` apart."""
    for n in range(len(QUADRANTS)):
        phi = (angle - n * pi / 2 + pi) % (2 * pi) - pi
        gap = float(np.diff(np.sort(np.append(phi[np.abs(phi) <= WINDOW], [-WINDOW, WINDOW]))).max())
        if gap > COARSE:
            what = f"samples at the reversal at {90 * n}° are {np.degrees(gap):.0f}° apart, too far to show its glitch"
            raise FricError(what, where=where, hint="Sample faster or run slower: 90 samples a revolution at least.")


LEAST = 12  # Least number of samples for a parabola
COARSE = radians(4.5)  # Largest angle between samples around a reversal; a glitch is a few degrees wide
NARROWER = 0.45
"""Share of the widest window with a valid parabola that is used for the peak: its bias is then a quarter of the noise.
At 0.6 it was 0.7 of it, and intervals held 86 %."""
SUDDEN = 0.02  # Longest time in which a kick moves an axis inwards [s]
KICK = 0.12  # Least ratio of depth inwards to height outwards of a kick
AHEAD = 0.25  # Share of its depth that a kick has reached a fifth of `SUDDEN` before the reversal: more is too early
GRADUAL = 0.75
"""Share of a smaller depth that comes within the second half of `SUDDEN`, below which friction moves the axis: in
simulations 0.83 or more by a compensation, 0.67 or less by friction that rises as the speed falls."""
STUCK = 0.2  # Height outwards over the depth of the kick after it, above which the kick is too late


@dataclass(frozen=True)
class Glitch:
    """The pulse at one reversal."""

    value: float  # Its peak [m], outwards positive
    unit: str = field(default="m", kw_only=True)
    ci95: tuple[float, float]  # 95 % interval of the peak [m]
    width: float  # Its width at half its height along the circle [m]
    place: float  # Where it peaks along the circle, behind the reversal of the reference [m]


@dataclass(frozen=True)
class GlitchPulse:
    """The deviation of a circle around a reversal, less the geometry."""

    phi: Real  # Angle behind the reversal in the direction of motion [rad], increasing, shape (n,)
    rest: Real  # Radial deviation [m], shape (n,)
    revolution: Indices  # Number of the revolution, shape (n,)

    def smoothed(self, width: float) -> tuple[Real, Real]:
        """Return angles [rad] and means [m] of the deviation over windows of a width [rad] that overlap by half."""
        sums, places = np.concatenate([[0.0], np.cumsum(self.rest)]), np.concatenate([[0.0], np.cumsum(self.phi)])
        centres = np.arange(self.phi[0] + width / 2, self.phi[-1] - width / 2, width / 4)
        low, high = np.searchsorted(self.phi, centres - width / 2), np.searchsorted(self.phi, centres + width / 2)
        held = high > low
        low, high = low[held], high[held]
        return (places[high] - places[low]) / (high - low), (sums[high] - sums[low]) / (high - low)

    def noise(self) -> float:
        """Return the standard deviation of a sample about its neighbourhood [m], by second differences of a turn."""
        seconds = (np.diff(self.rest[self.revolution == turn], 2) for turn in np.unique(self.revolution))
        found = [float(np.mean(second**2)) / 6.0 for second in seconds if len(second)]
        return sqrt(float(np.median(found))) if found else 0.0


def pulses(angle: Real, rest: Real, revolution: Indices, direction: int) -> dict[str, GlitchPulse]:
    """Return the deviation within 45° of each of the four reversals, by quadrant."""
    found = {}
    for n, name in enumerate(QUADRANTS):
        phi = (direction * (angle - n * pi / 2) + pi) % (2 * pi) - pi
        near = np.flatnonzero(np.abs(phi) <= pi / 4)
        near = near[np.argsort(phi[near], kind="stable")]
        found[name] = GlitchPulse(phi[near], rest[near], revolution[near])
    return found


def glitch_of(pulse: GlitchPulse, radius: float, base: float, resolution: float) -> Glitch:
    """Return peak, width and place of a pulse.

    The peak is that of a parabola, over the widest window around it (to both sides, or to one side, where the pulse
    rises at once) in which a parabola fits within the noise of a sample.

    base: Standard error of the subtracted geometry, at the reversal [m].
    resolution: One step of the encoder [m]; 0 where none is seen.
    """
    near = np.abs(pulse.phi) <= WINDOW
    pulse = GlitchPulse(pulse.phi[near], pulse.rest[near], pulse.revolution[near])
    sigma = max(pulse.noise(), resolution / sqrt(12.0), 1e-12)
    spacing = 2 * WINDOW / max(len(pulse.phi), 1)
    # windows from fine to coarse, until the noise of a mean is small beside the largest of them
    width = LEAST * spacing
    while True:
        phi, mean = pulse.smoothed(width)
        top = int(np.argmax(np.abs(mean)))
        if sigma / sqrt(max(width / spacing, 1.0)) <= 0.03 * abs(mean[top]) or width > WINDOW / 4:
            break
        width *= 1.5
    sign = 1.0 if mean[top] >= 0 else -1.0
    low, high = _half_height(phi, sign * mean, top)
    place, value, se = _parabola(pulse, phi[top], max(high - low, width), sigma, sign)
    near = np.abs(pulse.phi - place) <= max((high - low) / 4, LEAST * spacing) / 2
    turns = (near & (pulse.revolution == turn) for turn in np.unique(pulse.revolution[near]))
    means = [float(np.mean(pulse.rest[turn])) for turn in turns]
    scatter = float(np.std(means, ddof=1)) if len(means) > 2 else 0.0  # between revolutions
    count = len(np.unique(pulse.revolution))
    se = sqrt(max(se, scatter / sqrt(count)) ** 2 + base**2)
    half_width = float(stdtrit(max(4 * (count - 1), 8), 0.975)) * se
    return Glitch(value, (value - half_width, value + half_width), radius * (high - low), radius * place)


def _half_height(phi: Real, mean: Real, top: int) -> tuple[float, float]:
    """Return where a curve falls below half of its peak to either side, by linear interpolation."""
    low, high = phi[0], phi[-1]
    for side in (slice(top, None, -1), slice(top, None)):
        at, height = phi[side], mean[side] - mean[top] / 2
        if len(below := np.flatnonzero(height < 0)):
            k = below[0]
            end = at[k] - height[k] / (height[k - 1] - height[k]) * (at[k - 1] - at[k])
            low, high = (end, high) if side.step else (low, end)
    return float(low), float(high)


def _parabola(pulse: GlitchPulse, about: float, width: float, sigma: float, sign: float) -> tuple[float, float, float]:
    """Return place [rad], height [m] and standard error [m] of the peak."""
    centre = int(np.searchsorted(pulse.phi, about))
    spacing = float(pulse.phi[-1] - pulse.phi[0]) / max(len(pulse.phi) - 1, 1)
    most = max(int(0.75 * width / spacing), LEAST)
    offsets = [0, 1, 2, 3]
    while offsets[-1] < most:
        offsets.append(max(int(1.4 * offsets[-1]), offsets[-1] + 1))
    best: tuple[int, int] | None = None
    for left in offsets:
        for right in offsets:
            a, b = max(centre - left, 0), min(centre + right + 1, len(pulse.phi))
            if b - a >= LEAST and (best is None or b - a > best[1] - best[0]):
                rss = _fitted(pulse, a, b)[3]
                if rss <= sigma**2 * ((b - a - 3) + 2.0 * sqrt(2.0 * (b - a - 3))):
                    best = (a, b)
    if best is None:
        a = min(max(centre - LEAST // 2, 0), max(len(pulse.phi) - LEAST, 0))
        vertex, value, unit, rss = _peak_of(pulse, a, min(a + LEAST, len(pulse.phi)), sign)
        return vertex, value, unit * max(sigma, sqrt(rss / (LEAST - 3)))
    # the widest window that fits passes a bias of up to (8/n)^¼ of a sample's noise, which falls with its width cubed
    vertex = _peak_of(pulse, *best, sign)[0]
    at = int(np.searchsorted(pulse.phi, vertex))
    a, b = at - int(NARROWER * (at - best[0])), at + int(NARROWER * (best[1] - at))
    if b - a < LEAST:
        a, b = best
    vertex, value, unit, _ = _peak_of(pulse, a, b, sign)
    return vertex, value, unit * sigma


def _fitted(pulse: GlitchPulse, a: int, b: int) -> tuple[Real, Real, tuple[float, float], float]:
    """Return a parabola's coefficients and columns, middle and half of its window [rad], and the squares left."""
    middle, half = (pulse.phi[a] + pulse.phi[b - 1]) / 2, max((pulse.phi[b - 1] - pulse.phi[a]) / 2, 1e-12)
    t = (pulse.phi[a:b] - middle) / half
    X = np.column_stack([np.ones_like(t), t, t * t])
    p, *_ = np.linalg.lstsq(X, pulse.rest[a:b], rcond=None)
    return p, X, (float(middle), float(half)), float(np.sum((pulse.rest[a:b] - X @ p) ** 2))


def _peak_of(pulse: GlitchPulse, a: int, b: int, sign: float) -> tuple[float, float, float, float]:
    """Return place [rad] and height [m] of a parabola's peak, its error over that of a sample, and the squares left."""
    p, X, (middle, half), rss = _fitted(pulse, a, b)
    vertex = -p[1] / (2 * p[2]) if sign * p[2] < 0 else (-1.0 if sign * p[1] < 0 else 1.0)
    at = np.array([1.0, vertex := float(np.clip(vertex, -1.0, 1.0)), vertex**2])
    return middle + half * vertex, float(at @ p), sqrt(float(at @ parameter_covariance(X) @ at)), rss


def kick_of(pulse: GlitchPulse, rate: float, resolution: float) -> str:
    """Return how a friction compensation kicks the axis at a reversal; empty where friction alone is seen.

    Friction holds an axis outside the circle; if it rises as the speed falls, it also moves the axis slowly inside
    before the reversal. A motion inwards within `SUDDEN` is due to a compensation: too early if before the reversal,
    too late if the axis stuck before it, too low if it still sticks after it, else too high.

    resolution: One step of the encoder [m]; 0 where none is seen.
    """
    spacing = float(np.ptp(pulse.phi)) / max(len(pulse.phi) - 1, 1)
    width = max(0.2 * SUDDEN * rate, LEAST * spacing)
    phi, mean = pulse.smoothed(width)
    near = (phi > -WINDOW / 2) & (phi < WINDOW)
    phi, mean = phi[near], mean[near]
    if not len(phi):
        return ""
    out, deep = int(np.argmax(mean)), int(np.argmin(mean))
    base = float(np.interp(phi[deep] - SUDDEN * rate, phi, mean))
    height, depth = max(float(mean[out]), 0.0), min(base, 0.0) - float(mean[deep])
    error = pulse.noise() / sqrt(max(width / spacing, 1.0))
    if depth < max(KICK * height, 6.0 * error, 2.0 * resolution):
        return ""
    if min(base, 0.0) - float(np.interp(-0.2 * SUDDEN * rate, phi, mean)) > AHEAD * depth:
        return "too early"
    if out < deep and height > STUCK * depth:
        return "too late"
    if height <= depth:
        return "too high"
    sudden = float(np.interp(phi[deep] - SUDDEN / 2 * rate, phi, mean)) - float(mean[deep])
    return "too low" if sudden > GRADUAL * depth else ""
