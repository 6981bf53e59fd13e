"""Flaws of records, judged once for `inspect` and every `identify`: clock, encoder, place and time.

A position that is sampled ``τ`` too late is off by ``v·τ``. So jitter is noise of the position that grows with the
speed, unlike noise of an encoder; and a lost sample without a gap in time is a step of the position as long as two. Two
encoders, at the motor and at the load, show lost motion and stiffness of the transmission; kicks at reversals show a
friction compensation of the control.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import comb, inf, nan, sqrt
from typing import Any, Literal

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import median_filter

from fric.arrays import Indices, Mask, Real
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws import channel
from fric.flaws.drift import FORCE_DRIFTS
from fric.flaws.files import RECORD_LEFT_OUT
from fric.flaws.static_map import FORCE_OVER_POSITION, FRICTION_OVER_POSITION
from fric.log import Log
from fric.notice import Notice
from fric.records.motion import find_reversals
from fric.records.over_strokes import OverPlace, over_time
from fric.records.recognition import fitted_sine, visible_step
from fric.records.resolution import CONVERTED, clipped_among, drive_off, fine, lattice_step
from fric.records.segments import SHORTEST, Segment
from fric.statistics import jackknife, robust_deviation
from fric.units import is_effort, readable, si_unit

KICKED, KICK_COUNTS, BEFORE, BEHIND, WITHIN = 0.3, 6.0, 1.5, 0.33, 0.5
"""Least lead about a reversal of a kick: over 99 % of the deviations elsewhere, in counts, over the deviation before
it, and over the lag after it; and the duration of the search [s]. Without a compensation the first is 0.13 at most, of
strokes, and the fourth 0.3, where friction rises as the speed falls.
"""
JUMP, JUMPED = 0.05, 0.7
"""Time in which a kick gains its lead [s], and the least share of it: kicks gain 0.94, pre-sliding in a loop without
velocity feedforward 0.5."""
RAMP = 0.9  # Share of the speed of a stroke at which its acceleration is taken to end
Encoder = Literal["motor", "load"]  # The encoder whose position is that of the axis
AFTER = 0.1  # Share of a stroke after a reversal that is left out, in which the transmission takes up its backlash
STROKES = 3  # Least number of strokes
BESIDE = 3  # Distance in samples at which the force has independent noise
SAMPLES = 256  # Least number of samples in a record
Purpose = Literal["static", "gms", "plant", "inspect"]
FASTER = 1.2  # Ratio of speeds above which a faster record also shows the jitter of a slower record
OTHER_UNIT = 500.0  # Ratio of sampling intervals of two records above which a time in ms was taken for s
COARSE = 12  # Number of steps in the force's range up to which steps affect means over strokes and cycles
OTHER_SCALE, OF_VOLTAGE = 0.15, 0.02
"""Share by which a force is off K_f times its voltage, and largest share of its power that is not of its voltage."""


@dataclass(frozen=True)
class _Kick:
    lead: float  # By how much the axis gets ahead of its reference after a reversal [m]
    lag: float  # By how much it was behind before that [m]
    before: float  # By how much it deviates at most for as long before the reversal [m]
    behind: float  # By how much it is behind at most after that [m]
    late: float  # When it leads most, after the reversal [s]
    decay: float  # Time from there until an e-th of it is left [s]
    sample: int  # At the reversal
    sudden: float  # Largest share of its lead that it gains within `JUMP`


@dataclass(frozen=True)
class Tracking:
    """The tracking error of a record."""

    reference: Real  # That was logged, or the sine that the motion follows between its reversals [m]
    position: Real  # Of the encoder of the loop: of two, the one that deviates less from the reference [m]
    rest: Real  # Deviation of that position without what goes with velocity and acceleration, as the lag of a loop [m]
    spans: list[tuple[int, int, int]]  # Of each reversal where the look at it begins, its sample, where the look ends
    far: Mask  # Samples far from reversals


def tracking(log: Log) -> Tracking | None:
    """Return the tracking of a record; None without a reference, reversals, or samples between them."""
    if log.position is None or log.added is not None or len(log) < SAMPLES:
        return None
    reference = _sine_of(log.time, log.position) if log.reference is None else log.reference
    if reference is None or not len(at := find_reversals(reference)):
        return None
    t, speed = log.time, np.gradient(reference, log.time)
    columns = np.column_stack([np.ones(len(t)), speed, np.gradient(speed, t)])
    columns /= np.maximum(np.abs(columns).max(axis=0), 1e-300)
    far, spans = np.ones(len(t), dtype=bool), _around_reversals(t, reference, at)
    for begin, _, end in spans:
        far[begin:end] = False
    if far.sum() < SAMPLES // 4:
        return None
    found = []
    for position in (log.position, log.load_position):
        if position is not None:
            deviation = position - reference
            rest = deviation - columns @ np.linalg.lstsq(columns[far], deviation[far], rcond=1e-9)[0]
            found.append(Tracking(reference, position, rest, spans, far))
    return min(found, key=lambda followed: float(np.std(followed.rest)))


def _sine_of(t: Real, position: Real) -> Real | None:
    """Return the sine that a motion to and fro follows away from its reversals [m], shape (n,); None for others."""
    sine = fitted_sine(t, position) if len(find_reversals(position)) > 1 else None
    if sine is None or not sine.reversals:
        return None
    angle = 2.0 * np.pi * sine.frequency * (t - t[0])
    columns = np.column_stack([np.ones_like(t), np.sin(angle), np.cos(angle)])
    slow = np.zeros(len(t), dtype=bool)
    for _ in range(2):  # the first shows where it is slow
        weights = np.linalg.lstsq(columns[~slow], position[~slow], rcond=None)[0]
        slow = np.abs(np.cos(angle + np.arctan2(weights[1], -weights[2]))) < 0.5
    return np.asarray(columns @ weights)


def foreign_compensation(log: Log) -> Notice | None:
    """Return the warning that a friction compensation of the control kicks the axis at reversals.

    Friction holds an axis behind its reference. If the axis is ahead after most reversals, by encoder counts and by a
    share of all deviations elsewhere, the cause is a pulse or a step of the control. Deviations proportional to
    velocity and acceleration are due to the loop, and a lead that is no larger than the lag before it is its overshoot.
    """
    if (followed := tracking(log)) is None:
        return None
    t, rest = log.time, followed.rest
    least = max(KICKED * np.quantile(np.abs(rest[followed.far]), 0.99), KICK_COUNTS * visible_step(followed.position))
    found = [_kick(t, followed.reference, rest, *span) for span in followed.spans]
    kicks = [
        kick for kick in found
        if kick.sudden > JUMPED and kick.lead > max(least, BEFORE * kick.before, BEHIND * kick.behind, kick.lag)
    ]  # fmt: skip
    if len(kicks) < 2 or 2 * len(kicks) <= len(found):  # a single one is hunting or a disturbance
        return None
    sizes = ("lead", "lag", "late", "decay")
    lead, lag, late, decay = (float(np.median([getattr(kick, size) for kick in kicks])) for size in sizes)
    when = "too early" if late < 0.0 else "too late" if lag > max(0.2 * lead, least) else "too much"
    return channel.FOREIGN_COMPENSATION.found(
        log.where, count=len(kicks), reversals=len(found), height=Estimate(lead, log.unit("position")),
        time=Estimate(float(t[kicks[0].sample]), "s"), decay=Estimate(decay, "s"), when=when,
        place=Estimate(float(followed.position[kicks[0].sample]), log.unit("position")),
    )  # fmt: skip


def _around_reversals(t: Real, reference: Real, at: Indices) -> list[tuple[int, int, int]]:
    """Return the window around each reversal: its first sample, the reversal, its last sample."""
    spans = []
    for n, first in enumerate(at):
        stop = int(at[n + 1]) if n + 1 < len(at) else len(t)
        moved = np.abs(reference[first:stop] - reference[first]) > 1e-4 * float(np.ptp(reference))
        moves = int(first) + max(int(np.argmax(moved)) - 1, 0)
        until = min(t[moves] + WITHIN, 0.5 * (t[moves] + t[stop - 1]))
        speed = np.abs(np.gradient(reference[moves:stop], t[moves:stop])) if stop - moves > 1 else np.zeros(1)
        ramp = t[moves + int(np.argmax(speed >= RAMP * speed.max()))]  # at whose end a loop overshoots
        until = min(until, max(ramp, t[moves] + JUMP))
        begin = int(np.searchsorted(t, t[first] - min(0.2 * WITHIN, 0.2 * (until - t[first]))))
        begin = max(begin, int(at[n - 1]) + 1 if n else 0)
        spans.append((begin, int(first), min(max(int(np.searchsorted(t, until)), moves + 2), len(t))))
    return spans


def _kick(t: Real, reference: Real, rest: Real, begin: int, first: int, end: int) -> _Kick:
    """Return the largest lead of the axis over its reference around a reversal."""
    before = rest[max(2 * begin - end, 0) : begin + 1]
    sense = float(np.sign(reference[end - 1] - reference[first])) or 1.0
    ahead = sense * (rest[begin:end] - float(np.median(before[-10:])))
    peak = int(np.argmax(ahead))
    left = np.flatnonzero(ahead[peak:] < ahead[peak] / np.e)
    back = begin + peak + (int(left[0]) if len(left) else len(ahead) - 1 - peak)
    from_there = np.maximum(np.searchsorted(t[begin:end], t[begin : begin + peak + 1] - JUMP) - 1, 0)
    gained = float((ahead[: peak + 1] - ahead[from_there]).max())
    return _Kick(
        float(ahead[peak]), max(-float(ahead[: peak + 1].min()), 0.0), float(np.abs(before - np.median(before)).max()),
        -float(ahead[peak:].min()),
        float(t[begin + peak] - t[first]), float(t[back] - t[begin + peak]), first, gained / max(ahead[peak], 1e-300),
    )  # fmt: skip


def without_kicked(logs: Sequence[Log]) -> tuple[list[Log], list[Notice]]:
    """Return the records without kicks of a compensation, and the warnings about the others."""
    kicked = [(log, notice) for log in logs if (notice := foreign_compensation(log)) is not None]
    kept = [log for log in logs if all(log is not log_kicked for log_kicked, _ in kicked)]
    if kicked and not kept:
        log, notice = kicked[0]
        height = readable(float(notice.values["height"]), log.unit("position"))
        what = f"the control kicks the axis by {height} at reversals, and its force is not friction"
        raise FricError(what, where=log.where, hint="Switch its friction compensation off, and log again.")
    why = "the control's friction compensation kicks the axis at reversals"
    return kept, [RECORD_LEFT_OUT.found(log.where, why=why) for log, _ in kicked]


@dataclass(frozen=True)
class Transmission:
    """Properties of a transmission from the difference of two encoders: ``z_m - z_l = c + e·z_m + s·h/2``, and with
    force ``… + F/K``.

    Here s is the direction. The stiffness uses the whole force: inertia and friction of the motor do not pass through
    the transmission, which is softer by their share of the force.
    """

    lost_motion: Estimate  #: Width h of the hysteresis between both encoders, backlash and wind-up together [m]
    #: Force over wind-up, at most; null where force and direction do not separate [N/m]
    stiffness: Estimate | None = None
    #: Difference over the range of the force (1 % to 99 %), at least; null likewise [m]
    wind_up: Estimate | None = None


def transmission_of(log: Log) -> Transmission | None:
    """Return the transmission by two encoders of a record; None without both, or without strokes in both directions."""
    if log.position is None or log.load_position is None:
        return None
    z, turns = log.position, find_reversals(log.position)
    whole = [(a, b) for a, b in pairwise(np.array([0, *turns, len(z) - 1])) if b - a >= SHORTEST]
    stroke, sense = np.full(len(z), -1), np.zeros(len(z))
    for n, (a, b) in enumerate(whole):
        stroke[a:b][np.abs(z[a:b] - z[a]) > AFTER * abs(z[b] - z[a])] = n
        sense[a:b] = np.sign(z[b] - z[a])
    used = stroke >= 0
    label = stroke[used]
    if len(np.unique(label)) < STROKES or len(np.unique(sense[used])) < 2:
        return None
    unit, difference = log.unit("position"), (z - log.load_position)[used]
    columns = np.column_stack([np.ones(len(label)), z[used] / (float(np.ptp(z)) or 1.0), 0.5 * sense[used]])

    values, half = _fitted(columns, columns, difference, label)
    lost = Estimate.around(float(values[2]), unit, float(half[2]))
    if log.force is None or not np.ptp(log.force[used]):
        return Transmission(lost)
    size = float(np.ptp(log.force[used]))
    force = log.force / size
    beside = 0.5 * (np.roll(force, BESIDE) + np.roll(force, -BESIDE))  # without the noise of the sample
    instruments = np.column_stack([columns, beside[used]])
    values, half = _fitted(np.column_stack([columns, force[used]]), instruments, difference, label)
    yields, sure = float(values[3]), float(half[3])
    if not sure < 0.5 * yields:  # of friction alone, force and direction are one
        return Transmission(lost)
    stiff = Estimate(size / yields, si_unit("stiffness", log.motion), (size / (yields + sure), size / (yields - sure)))
    low, high = np.quantile(log.force, [0.01, 0.99])
    share = float(high - low) / size
    return Transmission(lost, stiff, Estimate.around(share * yields, unit, share * sure))


def _fitted(basis: Real, instruments: Real, values: Real, label: Indices) -> tuple[Real, Real]:
    """Return coefficients by two-stage least squares, and half their 95 % intervals by the jackknife over strokes.

    Noise of the force would bias its coefficient towards 0: the force at neighbouring samples is the instrument.
    """
    stage = instruments @ np.linalg.lstsq(instruments, basis, rcond=1e-12)[0]
    found = np.asarray(np.linalg.lstsq(stage, values, rcond=1e-12)[0])
    return found, np.asarray(np.sqrt(np.diag(jackknife(stage, values - basis @ found, label))))


def two_encoders(log: Log) -> Notice | None:
    """Return the notice on two encoders of a record, and on the encoder used for friction."""
    if log.load_position is None:
        return None
    found = transmission_of(log)
    return channel.TWO_ENCODERS.found(log.where, lost=found and found.lost_motion, stiffness=found and found.stiffness)


def by_load(log: Log) -> Log:
    """Return a record with the position of the load's encoder."""
    if log.load_position is None:
        hint = "Map its column to `load_position`, or take the motor's encoder."
        raise FricError("there is no load_position, the load's encoder", where=log.where, hint=hint)
    return replace(log, position=log.load_position, load_position=None, velocity=None)


ORDERS = (6, 8)  # Orders of the differences that show noise: motion of f Hz scales with that power of f over rate
WHITE = 0.8  # Ratio of the powers by the higher and the lower order: 1 for white noise, less for a motion
GAP = 1.5  # Sampling intervals above which samples are missing, as the time shows
BLOCK = 20.0  # Least step of a reference over those beside it that is a block of lost samples
WINDOW = 32  # Number of samples in a window for comparison of noise with speed
ABOVE = 7.0  # Noise by jitter over that of the encoder step above which there is a warning: encoder errors cause less
SMALL = 1e-3  # Harmless jitter in sampling intervals: the printed digits of a position have the same effect
SURE = 5.0  # Standard errors above which noise grows with speed
SHARE, ERRORS = 1.0 / 3.0, 3.0  # Least share of the noise that grows with speed, and its least standard errors
COUNTS = 8.0  # Encoder steps per sample above which a double step is visible
LOST = 3  # Least number of double steps for a warning; one may be a jerk of the drive
CLEARLY = 0.8  # Roughness of a motion over the count of its samples, relative to that over their stamps, that decides
MISSING = 0.05  # Largest share of missing samples in an uneven record that is resampled
JITTER = 0.1  # Share of a sample by which an interval may differ from the mean interval


@dataclass(frozen=True)
class Timing:
    """Errors of a record's clock."""

    jitter: float = 0.0  # Standard deviation of the sampling instants [s]; 0 where none is seen
    displaced: float = 0.0  # What that does to the position: root mean square [m]
    lost: float = 0.0  # Share of the samples that were lost while the time was counted on [1]; 0 where none is seen
    speed: float = 0.0  # Usual speed while it moves [m/s]; 0 where the position shows nothing of the clock


def timing(log: Log) -> Timing:
    """Return the errors of a record's clock from its position: none without, or with fewer than 256 samples."""
    z, t = log.position, log.time
    if z is None or len(z) < 8 * WINDOW:
        return Timing()
    dt, step = np.diff(t), lattice_step(z) or 0.0
    gaps = np.diff(np.unique(z))  # a lattice too fine to be seen is no coarser than the smallest: a creep is in counts
    finest = step or float(gaps[gaps > 4e-15 * np.abs(z).max()].min(initial=np.ptp(z)))
    lost = max(_lost(np.diff(z)[dt < GAP * np.median(dt)], finest), blocks_lost(log))
    return Timing(lost=lost) if lost else _jitter(z, t, step)


def _lost(steps: Real, encoder: float) -> float:
    """Return the share of steps of double length between two of the usual length."""
    usual = median_filter(steps, 9, mode="nearest")
    steady = np.abs(usual) > max(COUNTS * encoder, 1e-12 * float(np.abs(steps).max()))
    around = np.lib.stride_tricks.sliding_window_view(np.pad(steps, 4, mode="edge"), 9)[steady]
    steady[steady] = np.median(np.abs(around - usual[steady, np.newaxis]), axis=1) < 0.1 * np.abs(usual[steady])
    if steady.sum() < WINDOW:
        return 0.0
    ratio = np.where(steady, steps / np.where(steady, usual, 1.0), 1.0)
    double = steady & (np.abs(ratio - np.rint(ratio)) < 0.25) & (np.rint(ratio) >= 2.0)
    alone = double[1:-1] & (np.abs(ratio[:-2] - 1.0) < 0.35) & (np.abs(ratio[2:] - 1.0) < 0.35)
    odd = steady & (np.abs(ratio - 1.0) > 0.35) & ~double
    return 0.0 if alone.sum() < LOST or odd.sum() > 0.3 * alone.sum() else float(alone.sum() / steady.sum())


def blocks_lost(log: Log) -> float:
    """Return the share of samples that are missing in blocks: there position and reference jump along their motion."""
    if log.position is None or log.reference is None or len(log) < WINDOW:
        return 0.0
    asked, moved = np.diff(log.reference), np.diff(log.position)
    before, step, after = np.abs(asked[:-2]), np.abs(asked[1:-1]), np.abs(asked[2:])
    along = (asked[:-2] * asked[1:-1] > 0) & (asked[2:] * asked[1:-1] > 0) & (np.abs(moved - asked)[1:-1] < 0.5 * step)
    usual = np.maximum(before, after)
    jumps = along & (step > BLOCK * usual) & (step > 5.0 * np.quantile(np.abs(asked), 0.98))
    missing = float(np.sum(step[jumps] / usual[jumps]))
    return missing / (missing + len(log))


def _jitter(z: Real, t: Real, encoder: float) -> Timing:
    """Return the deviation of the instants, and its effect on the position, by regression of noise on speed²."""
    count = len(z) // WINDOW
    power, higher = (_power(z, order, count) for order in ORDERS)
    moved, lasted = (x[WINDOW - 1 : count * WINDOW : WINDOW] - x[: count * WINDOW : WINDOW] for x in (z, t))
    v2 = (moved / lasted)[1:-1] ** 2
    wide = np.convolve(np.diff(t) > GAP * np.median(np.diff(t)), np.ones(2 * max(ORDERS) + 1), mode="same") > 0
    gaps = np.append(wide, False)[: count * WINDOW].reshape(count, WINDOW)
    whole = ~np.asarray(np.any(gaps, axis=1))[1:-1]
    moving = (v2 > 0.01 * np.max(v2, initial=0.0)) & whole
    if moving.sum() < 8 or np.median(higher[moving]) < WHITE * np.median(power[moving]):
        return Timing()
    floor = encoder**2 / 12.0
    tau2 = (power[moving] - floor) / v2[moving]
    found = float(np.median(tau2))
    error = 1.2533 * robust_deviation(tau2 - found) / np.sqrt(moving.sum())
    speed = float(np.sqrt(np.median(v2[moving])))
    displaced = speed * max(found, 0.0) ** 0.5
    small = found < (SMALL * float(np.median(np.diff(t)))) ** 2
    # noise as large at rest is that of the sensor; of one speed alone, an encoder's noise is not many of its steps
    unseen = not _grows(v2, power, whole, floor, alone=encoder > 0.0)
    if small or found < SURE * error or displaced < ABOVE * encoder / np.sqrt(12.0) or unseen:
        return Timing(speed=speed)
    return Timing(float(np.sqrt(found)), displaced, speed=speed)


def _grows(v2: Real, power: Real, whole: Mask, floor: float, *, alone: bool) -> bool:
    """Return whether noise (n,) grows with the square of the speed; ``alone`` where there are no slow windows."""
    order = np.flatnonzero(whole)[np.argsort(v2[whole])]
    if (third := len(order) // 3) < 3:
        return alone
    fast = order[-third:]
    slow = order[: int(np.sum(v2[order] < 0.5 * np.median(v2[fast])))]
    if alone and len(slow) < 3:
        return True
    slow = slow if len(slow) >= 3 else order[:third]
    (low, error), (high, beside) = (
        (float(np.median(power[some])), robust_deviation(power[some] - np.median(power[some])) / np.sqrt(len(some)))
        for some in (slow, fast)
    )
    v_low, v_high = float(np.median(v2[slow])), float(np.median(v2[fast]))
    more = high - max(low, floor)
    return more > ERRORS * 1.2533 * np.hypot(error, beside) and more * v_high > SHARE * high * (v_high - v_low)


def _power(z: Real, order: int, count: int) -> Real:
    """Return the noise power in each window but the first and the last [m²], by differences of an order.

    It is the median over the window (0.4549 of χ² with one degree of freedom), insensitive to a corner of the motion.
    """
    weights = np.array([(-1.0) ** k * comb(order, k) for k in range(order + 1)])
    high = np.convolve(z - z[0], weights, mode="same")[: count * WINDOW]
    return np.asarray(np.median((high**2).reshape(count, WINDOW)[1:-1] / np.sum(weights**2), axis=1) / 0.4549)


def even_sampling(log: Log) -> float:
    """Return the sampling rate [Hz] of an evenly sampled record: its samples over its duration."""
    if len(log) < 16:
        raise FricError(f"the record has {len(log)} samples", where=log.where, hint="Log a longer motion.")
    period = float(log.time[-1] - log.time[0]) / (len(log) - 1)
    off = np.abs(np.diff(log.time) / period - 1)
    worst = int(np.argmax(off))
    if off[worst] > JITTER:
        step = log.time[worst + 1] - log.time[worst]
        what = f"the sampling is uneven: {step:.4g} s after t = {log.time[worst]:.13g} s, and {period:.4g} s on average"
        hint = "Ingest a record without gaps, or split it at the gap."
        if off.max() < 1.0:  # no sample is missing
            hint = f"The stamps jitter: if the clock is even, say `time: {{rate: {1 / period:.6g} Hz}}` in a mapping."
        raise FricError(what, where=log.where, hint=hint)
    return 1 / period


def evened(log: Log) -> tuple[Log, list[Notice]]:
    """Return a record resampled evenly, with warnings; an even record is not changed.

    Instants that jitter, and single missing samples, are interpolated by a cubic through the others: over the stamps,
    or over the count of samples where the motion is smoother over it, for then the stamps jitter, and not the samples.

    Raises FricError: When more than `MISSING` of the samples are missing, or more than 8 at one place.
    """
    steps = np.diff(log.time)
    period = float(np.median(steps))
    if len(log) < 16 or np.all(np.abs(steps / period - 1) <= JITTER / 100):
        return log, []
    span = float(log.time[-1] - log.time[0])
    counts = np.ones(len(steps)) if float(steps.max()) < GAP * period else np.maximum(np.rint(steps / period), 1.0)
    at = np.concatenate([[0.0], np.cumsum(counts)])
    intervals = int(at[-1])
    if (missing := intervals + 1 - len(log)) > MISSING * len(log) or float(steps.max()) > 9.5 * period:
        return log, []  # which is then refused, with its place
    even = log.time[0] + np.linspace(0.0, span, intervals + 1)
    if missing == 0 and float(np.abs(even - log.time).max()) <= JITTER / 100 * period:
        return log, []
    stamps = (log.time - log.time[0]) * (intervals / span)
    off = float(np.abs(stamps - at).max())
    motion = log.position if log.position is not None else log.require("velocity", "a motion")
    rough = [np.abs(np.diff(CubicSpline(by, motion)(np.arange(intervals + 1)), 3)).mean() for by in (stamps, at)]
    by = at if rough[1] < CLEARLY * rough[0] else stamps
    logged = {name: values for name, values in log.channels().items() if name != "time"}
    channels: dict[str, Any] = {name: CubicSpline(by, x)(np.arange(intervals + 1)) for name, x in logged.items()}
    evened = channel.SAMPLING_UNEVEN.found(log.name, missing=missing, samples=intervals + 1, off=off)
    return replace(log, time=even, **channels), [evened]


def _scale_of_force(logs: Sequence[Log], plant: Plant | None) -> Iterator[Notice]:
    """Warn of records whose force is no K_f times their voltage, though it is proportional to that."""
    ratios, alike = dict[str, float](), 0
    for log in logs:
        if plant is None or log.force is None or log.input is None or is_effort(log.motion) or not log.input.any():
            continue
        slope = float(log.force @ log.input) / float(log.input @ log.input)
        rest = log.force - slope * log.input
        if rest @ rest < OF_VOLTAGE * (log.force @ log.force):
            alike += abs(slope / plant.K_f - 1.0) <= OTHER_SCALE
            ratios |= {} if abs(slope / plant.K_f - 1.0) <= OTHER_SCALE else {log.name: slope / plant.K_f}
    if ratios:
        ratio = float(np.median([*ratios.values()]))
        spread = float(np.ptp([*ratios.values()])) / abs(ratio)
        every = not alike and len(ratios) > 2 and spread < OTHER_SCALE  # then it is K_f that is of another scale
        yield channel.FORCE_SCALE_DIFFERS.found(records=[*ratios], ratio=ratio, other=1.0 / ratio, every=every)


def record_flaws(logs: Sequence[Log], purpose: Purpose, plant: Plant | None = None) -> list[Notice]:
    """Return the warnings of records with any motion: forces and inputs that are clipped, and their clock.

    plant: The plant, with whose K_f forces and voltages are compared.
    """
    found = [*_scale_of_force(logs, plant), *_unit_of_position(logs)]
    for name, flaw in (("input", channel.INPUT_CLIPPED), ("force", channel.FORCE_CLIPPED)):
        if name == "force" or purpose == "plant":
            had = [log for log in logs if getattr(log, name) is not None]
            counted = clipped_among(values := [getattr(log, name) for log in had])
            sure = any(fine(column, CONVERTED) for column in values)
            found += [flaw.found(log.where, samples=n, sure=sure) for log, n in zip(had, counted, strict=True) if n]
    off = {log.where: float(drive_off(log).mean()) for log in logs if purpose == "gms"}
    if resting := {where: share for where, share in off.items() if share > 0.0}:
        found.append(channel.DRIVE_OFF.found(share=max(resting.values()), records=list(resting)))
    return found + ([] if purpose == "static" else _coarse_force(logs)) + clock_flaws(logs, purpose)


def _unit_of_position(logs: Sequence[Log]) -> Iterator[Notice]:
    """Yield the warning about records whose encoder has steps a thousand or a million times those of most others."""
    steps = {log.name: lattice_step(log.position) for log in logs if log.position is not None}
    known = {name: step for name, step in steps.items() if step}
    usual = float(np.median([*known.values()])) if len(known) > 2 else nan
    for factor in (1e-6, 1e-3, 1e3, 1e6):
        if apart := [name for name, step in known.items() if abs(step / (factor * usual) - 1.0) < 0.01]:
            yield channel.POSITION_UNIT_DIFFERS.found(records=_records(apart), factor=factor)


def _coarse_force(logs: Sequence[Log]) -> list[Notice]:
    """Return a warning if the steps of the force are a large part of it."""
    levels = [np.unique(log.force) for log in logs if log.force is not None]
    if not levels or sum(map(len, levels)) > COARSE * len(levels):  # noise of the channel itself is finer
        return []
    step = float(np.min(np.diff(forces))) if len(forces := np.unique(np.concatenate(levels))) > 1 else 0.0
    coarse = 0.0 < float(np.ptp(forces)) <= COARSE * step
    return [channel.FORCE_COARSE.found(step=Estimate(step, logs[0].unit("force")))] * coarse


def clock_flaws(logs: Sequence[Log], purpose: Purpose) -> list[Notice]:
    """Return the warnings about the clock of records from their positions: lost samples, instants that jitter.

    purpose: Their purpose: the mean of a stroke tolerates jitter, a response and an acceleration do not.
    """
    found = [(log, timing(log)) for log in logs]
    warnings = []
    if lost := [(log.name, clock.lost) for log, clock in found if clock.lost]:
        warnings.append(channel.SAMPLES_LOST.found(_records([n for n, _ in lost]), lost=max(by for _, by in lost)))
    # what jitters shows in every record that is as fast; a ripple of one speed is no jitter
    unmoved = max((clock.speed for _, clock in found if not (clock.jitter or clock.lost)), default=0.0)
    if jitters := [(log, clock) for log, clock in found if clock.jitter and FASTER * clock.speed > unmoved]:
        log, worst = max(jitters, key=lambda pair: pair[1].displaced)
        warnings.append(channel.SAMPLING_JITTERS.found(
            _records([log.name for log, _ in jitters]), jitter=Estimate(worst.jitter, "s"), purpose=purpose,
            displaced=Estimate(worst.displaced, log.unit("position")),
            share=worst.jitter / float(np.median(np.diff(log.time))),
        ))  # fmt: skip
    intervals = [float(np.median(np.diff(log.time))) for log in logs]
    usual = sorted(intervals)[(len(logs) - 1) // 2] if logs else 1.0
    for log, interval in zip(logs, intervals, strict=True):
        if max(interval / usual, usual / interval) > OTHER_UNIT:
            apart = {"interval": Estimate(interval, "s"), "usual": Estimate(usual, "s")}
            warnings.append(channel.SAMPLING_DIFFERS.found(log.where, **apart))
    warnings += [notice for log in logs if (notice := foreign_compensation(log)) is not None]
    return warnings + [notice for log in logs if (notice := two_encoders(log)) is not None][:1]


def stroke_flaws(
    strokes: Sequence[tuple[Log, Segment]], place: OverPlace | None, *, force: float = inf, half_width: float = 0.0,
    taken_off: bool = False, scattered: bool = False,
) -> list[Notice]:  # fmt: skip
    """Return the warnings from strokes at constant velocity about the encoder, and about the force over place and time.

    force, half_width: The identified friction, and the smaller half-width of Coulomb friction and offset [N], the scale
        of severity.
    taken_off: Whether the force over position was subtracted from the map.
    scattered: Whether the means of strokes scatter beyond their noise.
    """
    if not strokes:
        return []
    warnings, tightest = [], {"level": force, "half_width": half_width}
    unit, length = (strokes[0][0].unit(name) for name in ("force", "position"))
    if place is not None:
        alike = place.either
        found = [(FORCE_OVER_POSITION, place.cogging), (FRICTION_OVER_POSITION, 0.0 if alike else place.friction)]
        for flaw, size in found:
            if size > 0.0:
                varies = Estimate(sqrt(2.0) * size * (sqrt(2.0) if alike else 1.0), unit)
                over = Estimate(place.length, length)
                about = {"varies": varies, "length": over, "either": alike, "taken_off": taken_off, **tightest}
                warnings.append(flaw.found(**about, share=float(varies) / force if force else 0.0))
    if (time := over_time(strokes, scattered=scattered)) is not None:
        warnings.append(FORCE_DRIFTS.found(
            rate=time.rate, a_minute=60 * abs(time.rate), change=abs(time.change), clocked=time.clocked, sure=time.sure,
            **tightest,
        ))  # fmt: skip
    return warnings


def _records(names: Sequence[str]) -> str:
    return f"record '{names[0]}'" if len(names) == 1 else f"{len(names)} records (as '{names[0]}')"
