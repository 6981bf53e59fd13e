"""Errors of a record's clock: jitter and lost samples, found in the position.

A position that is sampled ``τ`` too late is off by ``v·τ``. So jitter is noise of the position that grows with the
speed, unlike noise of an encoder; and a lost sample without a gap in time is a step of the position as long as two.
"""

from dataclasses import dataclass, replace
from math import comb
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import median_filter

from fric.arrays import Mask, Real
from fric.errors import FricError
from fric.flaws.channel import SAMPLING_UNEVEN
from fric.log import Log
from fric.notice import Notice
from fric.records.resolution import lattice_step
from fric.statistics import robust_deviation

ORDERS = (6, 8)  # Orders of the differences that show noise: motion of f Hz scales with that power of f over rate
WHITE = 0.8  # Ratio of the powers by the higher and the lower order: 1 for white noise, less for a motion
GAP = 1.5  # Sampling intervals above which samples are missing, as the time shows
WINDOW = 32  # Number of samples in a window for comparison of noise with speed
ABOVE = 7.0  # Noise by jitter over that of the encoder step above which there is a warning: encoder errors cause less
SMALL = 1e-3  # Harmless jitter in sampling intervals: the printed digits of a position have the same effect
SURE = 5.0  # Standard errors above which noise grows with speed
SHARE, ERRORS = 1.0 / 3.0, 3.0  # Least share of the noise that grows with speed, and its least standard errors
COUNTS = 8.0  # Encoder steps per sample above which a double step is visible
LOST = 3  # Least number of double steps for a warning; one may be a jerk of the drive
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
    lost = _lost(np.diff(z)[dt < GAP * np.median(dt)], step)
    return Timing(lost=lost) if lost else _jitter(z, t, step)


def _lost(steps: Real, encoder: float) -> float:
    """Return the share of steps of double length between two of the usual length."""
    usual = median_filter(steps, 9, mode="nearest")
    steady = np.abs(usual) > max(COUNTS * encoder, 1e-12 * float(np.abs(steps).max()))
    if steady.sum() < WINDOW:
        return 0.0
    around = np.lib.stride_tricks.sliding_window_view(np.pad(steps, 4, mode="edge"), 9)[steady]
    scatter = np.median(np.abs(around - usual[steady, np.newaxis]), axis=1)
    steady[steady] = scatter < 0.1 * np.abs(usual[steady])
    if steady.sum() < WINDOW:
        return 0.0
    ratio = np.where(steady, steps / np.where(steady, usual, 1.0), 1.0)
    double = steady & (np.abs(ratio - np.rint(ratio)) < 0.25) & (np.rint(ratio) >= 2.0)
    alone = double[1:-1] & (np.abs(ratio[:-2] - 1.0) < 0.35) & (np.abs(ratio[2:] - 1.0) < 0.35)
    odd = steady & (np.abs(ratio - 1.0) > 0.35) & ~double
    if alone.sum() < LOST or odd.sum() > 0.3 * alone.sum():
        return 0.0
    return float(alone.sum() / steady.sum())


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
    excess = power[moving] - floor
    tau2 = excess / v2[moving]
    found = float(np.median(tau2))
    error = 1.2533 * robust_deviation(tau2 - found) / np.sqrt(moving.sum())
    speed = float(np.sqrt(np.median(v2[moving])))
    displaced = speed * max(found, 0.0) ** 0.5
    small = found < (SMALL * float(np.median(np.diff(t)))) ** 2
    # no encoder's noise is many of its steps; where these are not seen, it is noise that does not grow with speed
    unseen = encoder == 0.0 and not _grows(v2, power, whole, floor)
    if small or found < SURE * error or displaced < ABOVE * encoder / np.sqrt(12.0) or unseen:
        return Timing(speed=speed)
    return Timing(float(np.sqrt(found)), displaced, speed=speed)


def _grows(v2: Real, power: Real, whole: Mask, floor: float) -> bool:
    """Return whether noise (n,) grows with the square of the speed; that of an encoder is in slow windows, too."""
    order = np.flatnonzero(whole)[np.argsort(v2[whole])]
    if (third := len(order) // 3) < 3:
        return False
    fast = order[-third:]
    slow = order[: int(np.sum(v2[order] < 0.5 * np.median(v2[fast])))]
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
    rows = (high**2).reshape(count, WINDOW)[1:-1] / np.sum(weights**2)
    return np.asarray(np.median(rows, axis=1) / 0.4549)


def even_sampling(log: Log) -> float:
    """Return the sampling rate [Hz] of an evenly sampled record: its samples over its duration.

    Raises FricError: When the record has fewer than 16 samples, or an interval differs from the mean.
    """
    if len(log) < 16:
        raise FricError(f"the record has {len(log)} samples", where=log.where, hint="Log a longer motion.")
    period = float(log.time[-1] - log.time[0]) / (len(log) - 1)
    off = np.abs(np.diff(log.time) / period - 1)
    worst = int(np.argmax(off))
    if off[worst] > JITTER:
        step = log.time[worst + 1] - log.time[worst]
        raise FricError(
            f"the sampling is uneven: {step:.4g} s after t = {log.time[worst]:.6g} s, and {period:.4g} s on average",
            where=log.where,
            hint="Ingest a record without gaps, or split it at the gap.",
        )
    return 1 / period


def evened(log: Log) -> tuple[Log, list[Notice]]:
    """Return a record resampled evenly, with warnings; an even record is not changed.

    Instants that jitter, and single missing samples, are interpolated by a cubic through the others.

    Raises FricError: When more than `MISSING` of the samples are missing, or more than 8 at one place.
    """
    steps = np.diff(log.time)
    period = float(np.median(steps))
    if len(log) < 16 or np.all(np.abs(steps / period - 1) <= JITTER / 100):
        return log, []
    span = float(log.time[-1] - log.time[0])
    intervals = len(steps) if float(steps.max()) < GAP * period else round(span / period)
    missing = intervals + 1 - len(log)
    if missing > MISSING * len(log) or float(steps.max()) > 9.5 * period:
        return log, []  # which is then refused, with its place
    even = log.time[0] + np.linspace(0.0, span, intervals + 1)
    if missing == 0 and float(np.abs(even - log.time).max()) <= JITTER / 100 * period:
        return log, []
    channels: dict[str, Any] = {
        name: CubicSpline(log.time, values)(even) for name, values in log.channels().items() if name != "time"
    }
    at = (log.time - log.time[0]) * (intervals / span)
    off = float(np.abs(at - np.rint(at)).max())
    return replace(log, time=even, **channels), [
        SAMPLING_UNEVEN.found(log.name, missing=missing, samples=intervals + 1, off=off)
    ]
