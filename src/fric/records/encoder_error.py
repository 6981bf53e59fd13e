"""Whether an encoder errs between the lines of its scale: a ripple of the position with one pitch at every speed.

At constant velocity the position is a straight line, and the error of interpolation a sine on it, of ``v/pitch`` Hz.
Below the bandwidth of the control the drive follows it, and the force shows it instead; above, the position does. What
has one frequency in time, as hum or a resonance, has another pitch at another speed, and is none.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from fric.log import Log
from fric.records.resolution import lattice_step
from fric.records.segments import Segment
from fric.units import rotates

SAMPLES = 256
"""Samples that a segment has at least."""
PERIODS = 12
"""Periods that lie in a segment at least."""
HEIGHT = 8.0
"""Amplitude of a line over the median of those around it."""
AROUND = 40
"""Lines to each side that it is compared with."""
PEAKS = 3
"""Lines of a segment that are looked at: its highest."""
SEGMENTS = 3
"""Segments that show one pitch, at least."""
FASTER = 1.4
"""Ratio of the greatest to the least of their speeds, at least."""

LONGEST = (0.5e-3, 0.02)
"""Pitch of a scale [m, rad] at most; what ripples with a longer one is a screw or a motor, and moves."""
SMALLEST = 0.5
"""Amplitude, in steps of the encoder, from which on it is told."""


@dataclass(frozen=True)
class EncoderError:
    """A sub-divisional error: its pitch [m], its amplitude [m], and the encoder's step [m] (0 where none is seen)."""

    pitch: float
    amplitude: float
    step: float


@dataclass(frozen=True)
class _Line:
    number: float  # 1/m
    width: float  # 1/m
    amplitude: float  # m
    speed: float  # m/s
    segment: int


def encoder_error(strokes: Sequence[tuple[Log, Segment]]) -> EncoderError | None:
    """Return the sub-divisional error that segments at constant velocity agree on; None where they do not.

    strokes: Constant-velocity segments, each with its record.
    """
    lines = [line for n, (log, segment) in enumerate(strokes) for line in _lines(log, segment, n)]
    lines = [line for line in lines if not _hums(line, lines)]
    best: list[_Line] = []
    for line in lines:
        alike = [other for other in lines if abs(other.number - line.number) <= 0.5 * (other.width + line.width)]
        speeds = [other.speed for other in alike]
        if max(speeds) >= FASTER * min(speeds) and len({o.segment for o in alike}) > len({o.segment for o in best}):
            best = alike
    if len({line.segment for line in best}) < SEGMENTS:
        return None
    number = float(np.average([line.number for line in best], weights=[1.0 / line.width for line in best]))
    logs = {id(log): log for log, _ in strokes}.values()
    step = max((lattice_step(log.position) or 0.0 for log in logs if log.position is not None), default=0.0)
    amplitude = float(np.median([line.amplitude for line in best]))
    if amplitude <= SMALLEST * step or 1.0 / number > LONGEST[rotates(strokes[0][0].motion)]:
        return None
    return EncoderError(1.0 / number, amplitude, step)


def _hums(line: _Line, lines: Sequence[_Line]) -> bool:
    """Say whether a line has one frequency in time, in segments of different speed."""
    alike = [
        other.speed
        for other in lines
        if abs(other.number * other.speed - line.number * line.speed)
        <= 0.5 * (other.width * other.speed + line.width * line.speed)
    ]
    return len(alike) >= SEGMENTS and max(alike) >= FASTER * min(alike)


def _lines(log: Log, segment: Segment, n: int) -> list[_Line]:
    """Return the highest lines of a segment that stand out of those around them."""
    if log.position is None or len(segment) < SAMPLES:
        return []
    t, z = (values[segment.start : segment.stop] for values in (log.time, log.position))
    dt = np.diff(t)
    if np.ptp(dt) > 0.2 * np.median(dt):
        return []
    rest = z - np.polynomial.Polynomial.fit(t, z, 2)(t)
    window = np.hanning(len(rest))
    amplitude = 2.0 * np.abs(np.fft.rfft(rest * window)) / window.sum()
    number = np.fft.rfftfreq(len(rest), float(np.median(dt))) / abs(segment.velocity)
    first = PERIODS
    if len(amplitude) < first + 2 * AROUND:
        return []
    inner = slice(first, len(amplitude) - 2)
    level = median_filter(amplitude, 2 * AROUND + 1, mode="mirror")
    peak = np.zeros(len(amplitude), dtype=bool)
    peak[1:-1] = (amplitude[1:-1] > amplitude[:-2]) & (amplitude[1:-1] >= amplitude[2:])
    high = np.flatnonzero(peak[inner] & (amplitude[inner] > HEIGHT * level[inner])) + first
    high = high[np.argsort(amplitude[high])][-PEAKS:]
    width = float(number[1])
    found = []
    for k in high:
        # where the line lies between the bins, by the parabola through the logarithms of the three highest
        below, here, above = np.log(amplitude[k - 1 : k + 2] + 1e-300)
        bend = below - 2.0 * here + above
        shift = 0.5 * (below - above) / bend if bend < 0.0 else 0.0
        found.append(_Line(float((k + shift) * width), width, float(amplitude[k]), abs(segment.velocity), n))
    return found
