"""The reversals of a motion."""

import numpy as np

from fric.arrays import Indices, Real
from fric.records.resolution import lattice_step, noise_level


def find_reversals(position: Real, threshold: float | None = None) -> Indices:
    """Return the samples at which a motion reverses, in order of time.

    A reversal is an extreme from which the motion returns by more than the threshold, which excludes the flicker of an
    encoder. If the extreme lasts (a dwell, a flat crest of counts), its middle is returned.

    threshold: Travel back [m] that makes a reversal; where it is not given, two counts of the encoder, or the swing of
        white noise over n samples, 2·√(2·ln n) standard deviations (Leadbetter et al., Extremes, 1983), and a tenth.
    """
    z = np.asarray(position, float)
    if len(z) < 3:
        return np.zeros(0, dtype=np.intp)
    count = lattice_step(z) or 0.0
    if threshold is None:
        swing = 2.2 * float(np.sqrt(2.0 * np.log(len(z)))) * noise_level(z)
        threshold = max(2.0 * count, swing, 1e-9 * float(np.ptp(z)))
    flat = 0.5 * count
    found: list[int] = []
    direction, begin = 0, 0
    while (reversal := _next_reversal(z, begin, direction, threshold)) is not None:
        extreme, passed, turned = reversal
        if direction:
            level = np.flatnonzero(np.abs(z[begin:passed] - z[extreme]) <= flat) + begin
            found.append(int(level[0] + level[-1]) // 2)
        direction, begin = turned, extreme
    return np.array(found, dtype=np.intp)


def _next_reversal(z: Real, begin: int, direction: int, threshold: float) -> tuple[int, int, int] | None:
    """Return the extreme after ``begin``, the sample that is past it by the threshold, and the direction from there."""
    stop = begin
    block = 1024
    high = low = z[begin]
    at_high = at_low = begin
    while stop < len(z):
        start, stop = stop, min(stop + block, len(z))
        part = z[start:stop]
        highest = np.maximum(np.maximum.accumulate(part), high)
        lowest = np.minimum(np.minimum.accumulate(part), low)
        down = np.flatnonzero(highest - part > threshold) if direction >= 0 else np.zeros(0, int)
        up = np.flatnonzero(part - lowest > threshold) if direction <= 0 else np.zeros(0, int)
        first_down, first_up = (int(k[0]) if len(k) else len(part) for k in (down, up))
        k = min(first_down, first_up)
        seen = part[: k + 1]
        if seen.max() > high:
            high, at_high = seen.max(), start + int(seen.argmax())
        if seen.min() < low:
            low, at_low = seen.min(), start + int(seen.argmin())
        if k < len(part):
            return (at_high, start + k, -1) if first_down < first_up else (at_low, start + k, 1)
        block *= 2
    return None
