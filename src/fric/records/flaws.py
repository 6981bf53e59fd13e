"""Flaws of records, judged once for `inspect` and every `identify`: clock, encoder, place and time."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, sqrt
from typing import Literal

import numpy as np
from scipy.ndimage import median_filter

from fric.estimate import Estimate
from fric.flaws.channel import (
    DRIVE_OFF,
    ENCODER_ERRS,
    FORCE_CLIPPED,
    FORCE_COARSE,
    INPUT_CLIPPED,
    SAMPLES_LOST,
    SAMPLING_DIFFERS,
    SAMPLING_JITTERS,
)
from fric.flaws.drift import FORCE_DRIFTS
from fric.flaws.static_map import FORCE_OVER_POSITION, FRICTION_OVER_POSITION
from fric.log import Log
from fric.notice import Notice
from fric.records.clipping import clipped_among, drive_off
from fric.records.encoders import two_encoders
from fric.records.kicks import foreign_compensation
from fric.records.over_strokes import OverPlace, over_time
from fric.records.resolution import lattice_step
from fric.records.segments import Segment
from fric.records.timing import timing
from fric.units import rotates

SAMPLES = 256  # Least number of samples in a segment
PERIODS = 12  # Least number of periods in a segment
HEIGHT = 8.0  # Amplitude of a line over the median of those around it
AROUND = 40  # Number of lines on each side for comparison
PEAKS = 3  # Number of lines of a segment that are used: its highest
SEGMENTS = 3  # Least number of segments that show a pitch
SPREAD = 1.4  # Least ratio of their greatest to their least speed
LONGEST = (0.5e-3, 0.02)  # Largest pitch of a scale [m, rad]; a longer ripple is a screw or a motor, and real motion
SMALLEST = 0.5  # Amplitude, in steps of the encoder, above which there is a warning


@dataclass(frozen=True)
class EncoderError:
    """A sub-divisional error."""

    pitch: float  # [m]
    amplitude: float  # [m]


@dataclass(frozen=True)
class _Line:
    number: float  # 1/m
    width: float  # 1/m
    amplitude: float  # m
    speed: float  # m/s
    segment: int


def encoder_error(strokes: Sequence[tuple[Log, Segment]]) -> EncoderError | None:
    """Return the sub-divisional error that segments at constant velocity agree on; None where they do not."""
    lines = [line for n, (log, segment) in enumerate(strokes) for line in _lines(log, segment, n)]
    lines = [line for line in lines if not _hums(line, lines)]
    best: list[_Line] = []
    for line in lines:
        alike = [other for other in lines if abs(other.number - line.number) <= 0.5 * (other.width + line.width)]
        speeds = [other.speed for other in alike]
        if max(speeds) >= SPREAD * min(speeds) and len({o.segment for o in alike}) > len({o.segment for o in best}):
            best = alike
    if len({line.segment for line in best}) < SEGMENTS:
        return None
    number = float(np.average([line.number for line in best], weights=[1.0 / line.width for line in best]))
    step = max(lattice_step(log.position) or 0.0 for log, _ in strokes if log.position is not None)
    amplitude = float(np.median([line.amplitude for line in best]))
    if amplitude <= SMALLEST * step or 1.0 / number > LONGEST[rotates(strokes[0][0].motion)]:
        return None
    return EncoderError(1.0 / number, amplitude)


def _hums(line: _Line, lines: Sequence[_Line]) -> bool:
    """Return whether a line has one frequency in time, in segments of different speed."""
    v = line.speed
    alike = [
        other.speed for other in lines
        if abs(other.number * other.speed - line.number * v) <= 0.5 * (other.width * other.speed + line.width * v)
    ]  # fmt: skip
    return len(alike) >= SEGMENTS and max(alike) >= SPREAD * min(alike)


def _lines(log: Log, segment: Segment, n: int) -> list[_Line]:
    """Return the highest lines of a segment that are clearly above those around them."""
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
    if len(amplitude) < PERIODS + 2 * AROUND:
        return []
    inner = slice(PERIODS, len(amplitude) - 2)
    level = median_filter(amplitude, 2 * AROUND + 1, mode="mirror")
    peak = np.zeros(len(amplitude), dtype=bool)
    peak[1:-1] = (amplitude[1:-1] > amplitude[:-2]) & (amplitude[1:-1] >= amplitude[2:])
    high = np.flatnonzero(peak[inner] & (amplitude[inner] > HEIGHT * level[inner])) + PERIODS
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


Purpose = Literal["static", "gms", "plant", "inspect"]
Strokes = Sequence[tuple["Log", "Segment"]]

FASTER = 1.2  # Ratio of speeds above which a faster record also shows the jitter of a slower record
OTHER_UNIT = 500.0  # Ratio of sampling intervals of two records above which a time in ms was taken for s
COARSE = 12  # Number of steps in the force's range up to which steps affect means over strokes and cycles


def record_flaws(logs: Sequence[Log], purpose: Purpose) -> list[Notice]:
    """Return the warnings of records with any motion: forces and inputs that are clipped, and their clock.

    purpose: Their purpose, as in `clock_flaws`.
    """
    found = []
    for name, flaw in (("input", INPUT_CLIPPED), ("force", FORCE_CLIPPED)):
        if name == "force" or purpose == "plant":
            had = [log for log in logs if getattr(log, name) is not None]
            counted = clipped_among([getattr(log, name) for log in had])
            found += [flaw.found(log.where, samples=count) for log, count in zip(had, counted, strict=True) if count]
    off = {log.where: float(drive_off(log).mean()) for log in logs if purpose == "gms"}
    if resting := {where: share for where, share in off.items() if share > 0.0}:
        found.append(DRIVE_OFF.found(share=max(resting.values()), records=list(resting)))
    return found + ([] if purpose == "static" else _coarse_force(logs)) + clock_flaws(logs, purpose)


def _coarse_force(logs: Sequence[Log]) -> list[Notice]:
    """Return a warning if the steps of the force are a large part of it."""
    levels = [np.unique(log.force) for log in logs if log.force is not None]
    if not levels or sum(map(len, levels)) > COARSE * len(levels):  # noise of the channel itself is finer
        return []
    forces = np.unique(np.concatenate(levels))
    step = float(np.min(np.diff(forces))) if len(forces) > 1 else 0.0
    coarse = 0.0 < float(np.ptp(forces)) <= COARSE * step
    return [FORCE_COARSE.found(step=Estimate(step, logs[0].unit("force")))] * coarse


def clock_flaws(logs: Sequence[Log], purpose: Purpose) -> list[Notice]:
    """Return the warnings about the clock of records from their positions: lost samples, instants that jitter.

    purpose: Their purpose: the mean of a stroke tolerates jitter, a response and an acceleration do not.
    """
    found = [(log, timing(log)) for log in logs]
    warnings = []
    if lost := [(log.name, clock.lost) for log, clock in found if clock.lost]:
        warnings.append(SAMPLES_LOST.found(_records([name for name, _ in lost]), lost=max(by for _, by in lost)))
    # what jitters shows in every record that is as fast; a ripple of one speed is no jitter
    unmoved = max((clock.speed for _, clock in found if not (clock.jitter or clock.lost)), default=0.0)
    if jitters := [(log, clock) for log, clock in found if clock.jitter and FASTER * clock.speed > unmoved]:
        log, worst = max(jitters, key=lambda pair: pair[1].displaced)
        warnings.append(SAMPLING_JITTERS.found(
            _records([log.name for log, _ in jitters]), jitter=Estimate(worst.jitter, "s"), purpose=purpose,
            displaced=Estimate(worst.displaced, log.unit("position")),
            share=worst.jitter / float(np.median(np.diff(log.time))),
        ))  # fmt: skip
    intervals = [float(np.median(np.diff(log.time))) for log in logs]
    usual = sorted(intervals)[(len(logs) - 1) // 2] if logs else 1.0
    for log, interval in zip(logs, intervals, strict=True):
        if max(interval / usual, usual / interval) > OTHER_UNIT:
            apart = {"interval": Estimate(interval, "s"), "usual": Estimate(usual, "s")}
            warnings.append(SAMPLING_DIFFERS.found(log.where, **apart))
    warnings += [notice for log in logs if (notice := foreign_compensation(log)) is not None]
    return warnings + [notice for log in logs if (notice := two_encoders(log)) is not None][:1]


def stroke_flaws(
    strokes: Strokes, place: OverPlace | None, *, force: float = inf, half_width: float = 0.0, taken_off: bool = False
) -> list[Notice]:
    """Return the warnings from strokes at constant velocity about the encoder, and about the force over place and time.

    force, half_width: The identified friction, and the smaller half-width of Coulomb friction and offset [N], the scale
        of severity.
    taken_off: Whether the force over position was subtracted from the map.
    """
    if not strokes:
        return []
    warnings, tightest = [], {"level": force, "half_width": half_width}
    unit, length = (strokes[0][0].unit(channel) for channel in ("force", "position"))
    if (error := encoder_error(strokes)) is not None:
        ripple = {"amplitude": Estimate(error.amplitude, length), "pitch": Estimate(error.pitch, length)}
        warnings.append(ENCODER_ERRS.found(**ripple))
    if place is not None:
        alike = place.cogging == place.friction  # the strokes of the two directions do not meet: it may be either
        found = [(FORCE_OVER_POSITION, place.cogging), (FRICTION_OVER_POSITION, 0.0 if alike else place.friction)]
        for flaw, size in found:
            if size > 0.0:
                varies = Estimate(sqrt(2.0) * size * (sqrt(2.0) if alike else 1.0), unit)
                over = Estimate(place.length, length)
                warnings.append(flaw.found(varies=varies, length=over, either=alike, taken_off=taken_off, **tightest))
    if (time := over_time(strokes)) is not None:
        warnings.append(FORCE_DRIFTS.found(
            rate=time.rate, a_minute=60 * abs(time.rate), change=abs(time.change), clocked=time.clocked, sure=time.sure,
            **tightest,
        ))  # fmt: skip
    return warnings


def _records(names: Sequence[str]) -> str:
    return f"record '{names[0]}'" if len(names) == 1 else f"{len(names)} records (as '{names[0]}')"
