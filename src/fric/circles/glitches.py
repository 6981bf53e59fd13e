"""The friction glitch at each reversal of a circle: height, width and place of the transient pulse."""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Indices, Real
from fric.contour import QUADRANTS, WINDOW

LEAST = 12  # Least number of samples for a parabola
NARROWER = 0.45
"""Share of the widest window with a valid parabola that is used for the peak: its bias is then a quarter of the noise.
At 0.6 it was 0.7 of it, and intervals held 86 %."""
SUDDEN = 0.02  # Longest time in which a kick moves an axis inwards [s]
KICK = 0.12  # Least ratio of depth inwards to height outwards of a kick
AHEAD = 0.25
"""Share of its depth that a kick has reached a fifth of `SUDDEN` before the reversal, above which it is too early."""
STUCK = 0.2  # Height outwards over the depth of the kick after it, above which the kick is too late


@dataclass(frozen=True)
class Glitch:
    """The pulse at one reversal."""

    value: float  # Its peak [m], outwards positive
    ci95: tuple[float, float]  # 95 % interval of the peak [m]
    width: float  # Its width at half its height along the circle [m]
    place: float  # Where it peaks along the circle, behind the reversal of the reference [m]
    unit: str = "m"  # Of its peak


@dataclass(frozen=True)
class GlitchPulse:
    """The deviation of a circle around a reversal, less the geometry."""

    phi: Real  # Angle behind the reversal in the direction of motion [rad], increasing, shape (n,)
    rest: Real  # Radial deviation [m], shape (n,)
    revolution: Indices  # Number of the revolution, shape (n,)


def pulses(angle: Real, rest: Real, revolution: Indices, direction: int) -> dict[str, GlitchPulse]:
    """Return the deviation within 45° of each of the four reversals, by quadrant."""
    found = {}
    for n, name in enumerate(QUADRANTS):
        phi = (direction * (angle - n * pi / 2) + pi) % (2 * pi) - pi
        near = np.flatnonzero(np.abs(phi) <= pi / 4)
        near = near[np.argsort(phi[near], kind="stable")]
        found[name] = GlitchPulse(phi[near], rest[near], revolution[near])
    return found


def smoothed(pulse: GlitchPulse, width: float) -> tuple[Real, Real]:
    """Return angles [rad] and means [m] of the deviation over windows of a width [rad] that overlap by half."""
    sums, places = np.concatenate([[0.0], np.cumsum(pulse.rest)]), np.concatenate([[0.0], np.cumsum(pulse.phi)])
    centres = np.arange(pulse.phi[0] + width / 2, pulse.phi[-1] - width / 2, width / 4)
    low, high = np.searchsorted(pulse.phi, centres - width / 2), np.searchsorted(pulse.phi, centres + width / 2)
    held = high > low
    low, high = low[held], high[held]
    return (places[high] - places[low]) / (high - low), (sums[high] - sums[low]) / (high - low)


def noise_of(pulse: GlitchPulse) -> float:
    """Return the standard deviation of a sample about its neighbourhood [m], by second differences within a turn."""
    seconds = (np.diff(pulse.rest[pulse.revolution == turn], 2) for turn in np.unique(pulse.revolution))
    found = [float(np.mean(second**2)) / 6.0 for second in seconds if len(second)]
    return sqrt(float(np.median(found))) if found else 0.0


def glitch_of(pulse: GlitchPulse, radius: float, base: float, resolution: float) -> Glitch:
    """Return peak, width and place of a pulse.

    The peak is that of a parabola, over the widest window around it (to both sides, or to one side, where the pulse
    rises at once) in which a parabola fits within the noise of a sample.

    base: Standard error of the subtracted geometry, at the reversal [m].
    resolution: One step of the encoder [m]; 0 where none is seen.
    """
    near = np.abs(pulse.phi) <= WINDOW
    pulse = GlitchPulse(pulse.phi[near], pulse.rest[near], pulse.revolution[near])
    sigma = max(noise_of(pulse), resolution / sqrt(12.0), 1e-12)
    spacing = 2 * WINDOW / max(len(pulse.phi), 1)
    # windows from fine to coarse, until the noise of a mean is small beside the largest of them
    width = LEAST * spacing
    while True:
        phi, mean = smoothed(pulse, width)
        top = int(np.argmax(np.abs(mean)))
        error = sigma / sqrt(max(width / spacing, 1.0))
        if error <= 0.03 * abs(mean[top]) or width > WINDOW / 4:
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
        half = LEAST // 2
        a = min(max(centre - half, 0), max(len(pulse.phi) - LEAST, 0))
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
    error = sqrt(float(at @ np.linalg.pinv(X.T @ X) @ at))
    return middle + half * vertex, float(at @ p), error, rss


def kick_of(pulse: GlitchPulse, rate: float, resolution: float) -> str:
    """Return how a friction compensation kicks the axis at a reversal; empty where friction alone is seen.

    Friction holds an axis outside the circle; if it rises as the speed falls, it also moves the axis slowly inside
    before the reversal. A motion inwards within `SUDDEN` is due to a compensation: too early if before the reversal,
    too late if the axis stuck before it, too low if it still sticks after it, else too high.

    resolution: One step of the encoder [m]; 0 where none is seen.
    """
    spacing = float(np.ptp(pulse.phi)) / max(len(pulse.phi) - 1, 1)
    width = max(0.2 * SUDDEN * rate, LEAST * spacing)
    phi, mean = smoothed(pulse, width)
    near = (phi > -WINDOW / 2) & (phi < WINDOW)
    phi, mean = phi[near], mean[near]
    if not len(phi):
        return ""
    out, deep = int(np.argmax(mean)), int(np.argmin(mean))
    base = float(np.interp(phi[deep] - SUDDEN * rate, phi, mean))
    height, depth = max(float(mean[out]), 0.0), min(base, 0.0) - float(mean[deep])
    error = noise_of(pulse) / sqrt(max(width / spacing, 1.0))
    if depth < max(KICK * height, 6.0 * error, 2.0 * resolution):
        return ""
    if min(base, 0.0) - float(np.interp(-0.2 * SUDDEN * rate, phi, mean)) > AHEAD * depth:
        return "too early"
    if out < deep and height > STUCK * depth:
        return "too late"
    return "too low" if height > depth else "too high"
