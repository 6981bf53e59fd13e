"""Recognition of a record's experiment from the motion, and from the force if logged."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from fric.arrays import Indices, Real
from fric.columns import PRESLIDING, Kind
from fric.log import Log
from fric.records.holding import is_holding_map
from fric.records.motion import find_reversals
from fric.records.resolution import lattice_step, noise_level
from fric.records.segments import Segment, segments_and_rests, travelled
from fric.statistics import pair_power

STEADY_SHARE = 0.75  # Share of the time in motion above which a record counts as strokes at constant velocity
STROKE_SHARE = 0.3  # The same if the axis reverses or stops between any two speeds, as between strokes with ramps
SINE_FIT = 0.99  # Share of the variance that a sine explains in a record of a sine; a triangle has 0.986
AROUND = 0.9  # Share of a motion's spectrum about its strongest line, above which a sine is fitted to it
SINE_SAMPLES = 1 << 17  # Samples at most in which its frequency is sought
SWINGS = 0.25  # Swing of the velocity over its mean above which a sine in sliding is no ripple of a stroke
REPEATS = 1.5  # Least number of cycles of a sine in sliding, without those at the ends
PIECES = 400  # Number of pieces of a record that are searched for pauses
QUIET, PAUSES = 0.02, 0.05  # Largest travel in a pause over that of a fast piece, and share of pauses between moves
LINES = 9.0  # Least number of spectral lines with the power of a broad-band excitation; strokes have at most five
REPEATED = 0.8  # Least correlation of an excitation with its next period
RISING_SHARE = 0.01  # Share of the stroke in which the force rises after a reversal, above which it is pre-sliding
LOOP_SHARE = 0.03  # The same for a motion of any other shape, as by hand or distorted by friction
LOOP_OF_STROKES = 0.1  # The same at constant velocity back and forth: strokes so short show pre-sliding, and no map
SWAY = 0.1  # Share of the longest stroke below which a stroke is an overshoot of the control loop, and no branch
JITTER = 0.03  # The same below which it is the jitter of a loop that hunts for its reference, and no stroke
RIGID = 0.98  # Share of the force that mass and viscous and Coulomb friction explain, above which these make it rise
REST = 0.1  # Share of the largest speeds, without the largest fiftieth, up to which an axis may be at rest
WHOLE = 3  # Least number of reversals of a reference between which there are whole branches
LEAST_REVERSALS = 4  # Least number of reversals of such a motion


STAIRS = 12  # Least number of steps of a staircase, on average three or more in the same direction
STEPS_ALIKE = 0.3  # Largest relative difference of four out of five steps of a staircase
STAIRCASE_SAMPLES = 4096  # Number of samples searched for a staircase
RESTS = 0.3  # Least share of time at rest between the steps of a staircase


@dataclass(frozen=True)
class Staircase:
    """Small equal steps up and down, with a rest after each."""

    step: float  # Size of a step [m]
    count: float  # Of the encoder, or three standard deviations of the noise [m]
    reversals: Indices  # Samples at which its direction changes: the middle of the rest there


def fitted_staircase(position: Real) -> Staircase | None:
    """Return the staircase of a motion, or None: levels at rest with equal distances.

    A level is a run of samples, which may settle or creep. Bounds on this are tried from two encoder counts or the
    noise up to a tenth of the motion: in a steady motion the levels would not be further apart.
    """
    every = -(-len(position) // STAIRCASE_SAMPLES)
    x, count = position[::every], visible_step(position)
    within = max(2.0 * count, 1e-4 * float(np.ptp(x)))
    while 0.0 < within < 0.1 * float(np.ptp(x)):
        if (found := _levels(x, within)) is not None:
            return Staircase(found[0], count, every * found[1])
        within *= 2.0
    return None


def visible_step(position: Real) -> float:
    """Return an encoder count, or three standard deviations of the noise, by which levels surely differ [m]."""
    return max(lattice_step(position) or 0.0, 3.0 * noise_level(position))


def _levels(x: Real, within: float) -> tuple[float, Indices] | None:
    """Return step and reversals of a staircase whose levels are samples within a bound of each other, or None."""
    runs, start, low, high = list[tuple[int, int]](), 0, np.inf, -np.inf
    for n, at in enumerate([*x.tolist(), np.inf]):
        if at < low:  # rather than min and max, which take three times as long
            low = at
        if at > high:
            high = at
        if high - low > within:
            runs.append((start, n))
            start, low, high = n, at, at
    lengths = np.array([b - a for a, b in runs])
    least = max(0.4 * float(np.quantile(lengths, 0.9)), 3.0)
    if (lengths >= least).sum() <= STAIRS or lengths[lengths >= least].sum() <= RESTS * len(x):
        return None
    levels = list[tuple[float, int, int]]()
    for a, b in runs:
        level = float(x[(a + b) // 2])
        if levels and abs(level - levels[-1][0]) < 1.5 * within:  # it settles, or hunts
            levels[-1] = (level, levels[-1][1], b)
        elif b - a >= least:
            levels.append((level, a, b))
    if len(moves := np.diff([level for level, *_ in levels])) < STAIRS:
        return None
    step = float(np.median(np.abs(moves)))
    turns = np.flatnonzero(moves[1:] * moves[:-1] < 0.0) + 1
    alike = float(np.mean(np.abs(np.abs(moves) - step) < STEPS_ALIKE * step))
    if not (len(turns) and len(moves) >= 3 * (len(turns) + 1) and alike >= 0.8):
        return None
    return step, np.array([(levels[n][1] + levels[n][2]) // 2 for n in turns], dtype=np.intp)


@dataclass(frozen=True)
class Sine:
    """A sine that a motion follows, ``z = z_0 + v_0·t + amplitude·sin(2π·frequency·t + phase)``."""

    #: Of the position: half the travel between reversals, where it does (friction flattens the crests) [m]
    amplitude: float
    frequency: float  #: [Hz]
    mean_velocity: float  #: Velocity v_0 that it rides on [m/s]
    cycles: float  #: At full amplitude
    explained: float  #: Share of the variance about the line that it explains

    @property
    def reversals(self) -> bool:
        """Whether the motion reverses, instead of sliding on."""
        return 2.0 * np.pi * self.frequency * self.amplitude > abs(self.mean_velocity)

    @property
    def in_sliding(self) -> bool:
        """Whether it swings periodically about a steady speed, by more than a stroke does."""
        swing = 2.0 * np.pi * self.frequency * self.amplitude
        return not self.reversals and self.cycles >= REPEATS and swing > SWINGS * abs(self.mean_velocity)


def fitted_sine(time: Real, position: Real) -> Sine | None:
    """Return the sine that a motion follows at full amplitude, or None.

    Run-in and end are left out: before the second reversal and after the last; of a motion without reversals, a quarter
    at each end.
    """
    reversals, n = _turns(position), len(position)
    start, stop = (int(reversals[1]), int(reversals[-1]) + 1) if len(reversals) > 3 else (n // 4, n - n // 4)
    if stop - start < 32:
        return None
    t, z = time[start:stop] - time[start], position[start:stop]
    span = float(t[-1])
    line = np.stack([np.ones_like(t), t / span - 0.5], axis=1)
    level = z - line @ np.linalg.lstsq(line, z, rcond=None)[0]
    if (spread := float(level @ level)) == 0.0:
        return None
    even = np.interp(np.linspace(0.0, span, min(len(t), SINE_SAMPLES)), t, level)
    spectrum = np.abs(np.fft.rfft(even * np.hanning(len(even)))) ** 2
    peak = int(np.argmax(spectrum[1:])) + 1
    if spectrum[max(peak - 2, 0) : peak + 3].sum() < AROUND * spectrum.sum():
        return None
    thin = max(len(t) // 4096, 1)
    t, z, line = t[::thin], z[::thin], line[::thin]
    spread *= len(t) / len(level)

    width, frequency, known = 1.0 / span, peak / span, np.linalg.qr(line)[0]
    for _ in range(6):  # the misfit has one minimum within a line's width: narrow it down
        trial = frequency + width * np.linspace(-1.0, 1.0, 9)
        trial = trial[trial > 0.2 / span]
        angle = 2.0 * np.pi * np.multiply.outer(t, trial)
        frequency = float(trial[np.argmax(pair_power((np.sin(angle), np.cos(angle)), z, known))])
        width /= 4.0
    angle = 2.0 * np.pi * frequency * t
    columns = np.column_stack([line, np.sin(angle), np.cos(angle)])
    weights = np.linalg.lstsq(columns, z, rcond=None)[0]
    explained = 1.0 - float(np.sum((z - columns @ weights) ** 2)) / spread
    if explained < SINE_FIT or frequency * span < 1.0:
        return None
    amplitude, velocity = float(np.hypot(weights[2], weights[3])), float(weights[1]) / span
    if len(reversals) > 3:
        amplitude, velocity = 0.5 * float(np.median(np.abs(np.diff(position[reversals[1:]])))), 0.0
    return Sine(amplitude, frequency, velocity, frequency * span, explained)


def recognised_kind(
    log: Log, segments: list[Segment], rests: list[tuple[int, int]], sine: Sine | None, rise: float | None,
    reversals: int, stairs: Staircase | None,
) -> Kind:  # fmt: skip
    """Return the kind of a record by its motion.

    A staircase before sliding; a sine; a broad-band excitation; a motion back and forth before sliding, of any shape;
    strokes at constant velocity, if that is most of the time in motion; else a motion. The arguments are what
    `segments_and_rests`, `turns_of` and `force_rise` found: without a force, pre-sliding is assumed. Of a short stroke,
    which settles late, and of one that sticks and slips, the reference shows that it is asked for.
    """
    found = _kind_by_motion(log, segments, rests, sine, rise, reversals, stairs)
    if found in PRESLIDING and log.reference is not None and len(find_reversals(log.reference)) < WHOLE:
        found = "motion"  # it sticks and slips, or jitters at rest
    if found == "motion" and segments and log.reference is not None:
        asked = replace(log, position=log.reference, velocity=None, force=None, input=None)
        plateaus, pauses = segments_and_rests(asked)
        moving = len(log) - sum(stop - start for start, stop in pauses)
        even = sum(segment.stop - segment.onset for segment in plateaus) >= STEADY_SHARE * moving
        found = "constant-velocity" if even and len(segments) < len(plateaus) else found
    return found


def _kind_by_motion(
    log: Log, segments: list[Segment], rests: list[tuple[int, int]], sine: Sine | None, rise: float | None,
    reversals: int, stairs: Staircase | None,
) -> Kind:  # fmt: skip
    if stairs is not None and rise is not None and rise > LOOP_SHARE:
        return "micro-steps"
    steady = sum(segment.stop - segment.onset for segment in segments)
    if sine is not None and sine.in_sliding:
        return "sliding-sine"
    if sine is not None and steady < STROKE_SHARE * len(log):
        return "presliding-sine" if sine.reversals and (rise is None or rise > RISING_SHARE) else "sliding-sine"
    if _is_broad_band(log):
        return "frequency-response"
    least = LOOP_SHARE if steady < STROKE_SHARE * len(log) else LOOP_OF_STROKES
    if rise is not None and rise > least and reversals >= LEAST_REVERSALS and not is_rigid(log):
        return "presliding-sine"
    moving = max(len(log) - sum(stop - start for start, stop in rests), 1)
    z = travelled(log)
    strokes = all(
        a.velocity * b.velocity < 0.0
        or a.velocity * (z[b.start] - z[a.stop - 1]) < 0.0  # a stroke back, which is not steady, lies between
        or any(a.stop <= start and stop <= b.start for start, stop in rests)
        for a, b in pairwise(segments)
    )
    return "constant-velocity" if steady >= (STROKE_SHARE if strokes else STEADY_SHARE) * moving else "motion"


def kind_of(log: Log) -> Kind:
    """Return the kind of a record: as stated in it, else recognised from its motion."""
    if log.kind is not None:
        return log.kind
    if is_holding_map(log):
        return "holding-map"
    segments, rests = segments_and_rests(log)
    sine, reversals, stairs = turns_of(log)
    return recognised_kind(log, segments, rests, sine, force_rise(log, reversals), len(reversals), stairs)


def turns_of(log: Log) -> tuple[Sine | None, Indices, Staircase | None]:
    """Return the sine or the staircase that a motion follows, and where it reverses."""
    if log.position is None:
        return None, np.zeros(0, dtype=np.intp), None
    stairs = fitted_staircase(log.position)
    if log.reference is not None and (asked := fitted_staircase(log.reference)) is not None:
        stairs = replace(asked, count=visible_step(log.position))
    if stairs is not None:
        return None, stairs.reversals, stairs
    return fitted_sine(log.time, log.position), _turns(log.position), None


def _turns(position: Real) -> Indices:
    """Return the samples at which a motion reverses, without the jitter of a loop that hunts."""
    found = find_reversals(position)
    longest = float(np.abs(np.diff(position[found])).max(initial=0.0))
    ends = np.minimum(found, len(position) - found) < 0.02 * len(position)
    if ends.all() and longest < JITTER * float(np.ptp(position)):  # before it moves, and when it has
        return found[:0]
    return min(found, find_reversals(position, threshold=JITTER * longest) if longest else found, key=len)


def force_rise(log: Log, reversals: Indices) -> float | None:
    """Return the share of the stroke in which the force rises, the median of `force_rises`; None if there is none."""
    shares = [share for share, *_ in force_rises(log, reversals)]
    return float(np.median(shares)) if shares else None


def force_rises(log: Log, reversals: Indices) -> list[tuple[float, int, float]]:
    """Return the share of each stroke, the samples and the travel [m] after which the force has risen by nine tenths.

    The full rise is the force of the later half of a branch between reversals. A force against the motion, as the
    inertia of a fast motion, does not rise. The result is empty without a force, a position or a branch.
    """
    if log.force is None or log.position is None or len(reversals) < 2:
        return []
    found = []
    strokes = np.abs(np.diff(log.position[reversals]))
    whole = (strokes > 0.0) & (strokes >= SWAY * strokes.max())
    for begin, end in np.column_stack([reversals[:-1], reversals[1:]])[whole]:
        z, force = log.position[begin : end + 1], log.force[begin : end + 1]
        if (up := float(np.median(force[len(force) // 2 :])) - float(force[0])) != 0.0:
            risen = int(np.argmax((force - force[0]) / up >= 0.9))
            travel = abs(float(z[risen] - z[0])) if up * (z[-1] - z[0]) > 0.0 else 0.0
            found.append((travel / abs(float(z[-1] - z[0])), risen, travel))
    return found


def is_rigid(log: Log) -> bool:
    """Return whether the force is that of a rigid body that slides: ``M·z̈ + F_v·ż + F_c·sign(ż)`` and an offset.

    At rest, as between the moves of a robot, friction is anything up to F_c: it is not judged there.
    """
    velocity = log.velocity if log.velocity is not None else np.gradient(travelled(log), log.time)
    terms = np.column_stack([np.gradient(velocity, log.time), velocity, np.sign(velocity), np.ones_like(velocity)])
    terms /= np.maximum(np.abs(terms).max(axis=0), 1e-300)
    moves = np.abs(velocity) > REST * np.quantile(np.abs(velocity), 0.98)
    terms, force = terms[moves], log.require("force", "the law of a rigid body")[moves]
    values = np.linalg.lstsq(terms, force, rcond=None)[0]
    left = force - terms @ values
    return bool(terms.any(axis=0).all() and values[:3].min() >= 0.0 and left.var() < (1.0 - RIGID) * force.var())


def _is_broad_band(log: Log) -> bool:
    """Return whether effort (input or, where none is logged, force) and velocity have many spectral lines, and the
    motion exceeds the encoder's noise. So do moves of many lengths, but these have pauses.
    """
    effort = log.force if log.input is None else log.input
    if effort is None or log.position is None or len(log) < 256:
        return False
    moved = np.array([np.ptp(piece) for piece in np.array_split(log.position, min(len(log) // 8, PIECES))])
    if np.mean(moved < QUIET * np.quantile(moved, 0.9)) > PAUSES:
        return False
    velocity = np.gradient(log.position, log.time)
    noise = max(noise_level(log.position), (lattice_step(log.position) or 0.0) / np.sqrt(12.0))
    shaking = noise * np.sqrt(2.0) / float(np.median(np.diff(log.time)))
    shows = velocity.std() > 3.0 * shaking or repeats(effort)  # the average of periods shows what a sample does not
    if not shows or min(spectral_lines(velocity), spectral_lines(effort)) >= LINES:
        return bool(shows)
    begun = slice(len(log) // 4, None)  # a start before the excitation is a line by itself
    return min(spectral_lines(velocity[begun]), spectral_lines(effort[begun])) >= LINES and repeats(effort[begun])


def repeats(signal: Real) -> bool:
    """Return whether a signal repeats itself: its correlation with itself a twentieth to half of its length later."""
    n = len(signal)
    rest = signal - np.polyval(np.polyfit(np.arange(n), signal, 1), np.arange(n))
    power = np.fft.irfft(np.abs(np.fft.rfft(rest, 2 * n)) ** 2)[: n // 2] / np.arange(n, n - n // 2, -1)
    return bool(power[n // 20 :].max() > REPEATED * power[0] > 0.0)


def spectral_lines(signal: Real) -> float:
    """Return the effective number of spectral lines of a signal, ``1/Σp²`` with p their shares of the power."""
    n = len(signal)
    slope, level = np.polyfit(np.arange(n), signal, 1)
    power = np.abs(np.fft.rfft((signal - slope * np.arange(n) - level) * np.hanning(n))) ** 2
    return float(1.0 / ((power / total) ** 2).sum()) if (total := float(power.sum())) > 0.0 else 0.0
