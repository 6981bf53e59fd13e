"""Resolution of channels, and channels that are clipped at the end of their range."""

from collections.abc import Sequence
from hashlib import blake2b
from math import comb

import numpy as np

from fric.arrays import Indices, Mask, Real
from fric.errors import FricError
from fric.flaws.channel import CLIPPED_UNUSED
from fric.log import Log
from fric.notice import Notice

_EVIDENCE = 16  # Least number of neighbouring values on a lattice, unless each value occurs often
FINEST = 1e-3  # Smallest step as a share of the usual gap: any gap is near a multiple of a smaller step
_GAPS = 400  # Largest number of gaps that are used
_ORDER = 6  # Highest order of differences for the estimate of noise
_FALLS = 0.64  # Ratio of variances of two orders of differences below which the lower still includes motion
_KEPT = 4096  # Number of cached lattices, by digest of the channel: every judgement needs that of the position
_known: dict[bytes, float | None] = {}
NEAR_ZERO = 0.05  # Share of its largest value below which a channel is not at an end of its range
STUCK = 5  # Number of consecutive samples at its extreme from which a force or input counts as clipped
OFF = 0.05  # Time without motion and with a force of exactly 0 from which the drive counts as off [s]
LEVELS, CONVERTED = 40, 200
"""Least number of steps in a channel's range for a flat end to be clipping, and to be nothing else: a converter of
eight bits that is clipped shows 256, and friction along a motion varies by half a percent of the range or more."""


def lattice_step(values: Real) -> float | None:
    """Return the step of the lattice of logged values (an encoder count), or None without a lattice.

    The gaps between neighbouring values that occur are whole multiples of the step. They may be off by a fifth of it:
    a log written with few decimals rounds the counts of its encoder. Scaling and offset do not matter.
    """
    values = np.ascontiguousarray(values, float)
    if (digest := blake2b(values.data, digest_size=16).digest()) not in _known:
        if len(_known) >= _KEPT:
            _known.clear()
        _known[digest] = _lattice_step(values)
    return _known[digest]


def _lattice_step(values: Real) -> float | None:
    values = values[np.isfinite(values)]
    if len(levels := np.unique(values)) < 2:
        return None
    needed = 1 if len(values) >= 10 * len(levels) else _EVIDENCE
    rounding = 16.0 * np.finfo(float).eps * float(np.abs(levels).max())
    gaps = np.diff(levels)
    if len(gaps := gaps[gaps > rounding]) < needed:
        return None
    gaps = np.sort(gaps)
    usual = float(np.median(gaps))
    often, spread = len(values) > 2 * len(levels), gaps[:: len(gaps) // _GAPS + 1]
    step = _rounded_step(gaps[:_GAPS], needed, rounding, often=often)
    step = step or _rounded_step(spread, needed, rounding, often=often, most=1)  # the smallest may be one count all
    if step is None or step < 10.0 * FINEST * usual:  # the small gaps alone show it: so does the crest of a sine
        step = _common_divisor(spread, max(64.0 * rounding, 1e-4 * float(gaps[0])))
    return None if step is None or step < FINEST * usual else step


def encoder_step(position: Real) -> float:
    """Return the step of a position's lattice, even if it has few levels; 0 for none."""
    if (step := lattice_step(position)) is not None:
        return step
    levels = np.unique(position)
    return float(np.median(np.diff(levels))) if 1 < len(levels) < 0.05 * len(position) else 0.0


def _common_divisor(gaps: Real, error: float) -> float | None:
    """Return the greatest common divisor of gaps that are off by no more than an error, by Euclid's algorithm."""
    divisor = float(gaps[0])
    for gap in gaps[1:]:
        a, b = divisor, abs(float(gap) - divisor * round(float(gap) / divisor))
        while b > error:
            a, b = b, abs(a - b * round(a / b))
        divisor = a
        if divisor < 20.0 * error:  # of what is no lattice, the error alone is left: it only gets smaller
            return None
    return float(gaps.sum() / np.round(gaps / divisor).sum())


def _rounded_step(gaps: Real, needed: int, rounding: float, *, often: bool, most: int = 5) -> float | None:
    """Return the step of a lattice whose points were rounded to few decimals; the smallest gap is ``most`` at most. As
    samples at constant velocity have equal gaps too, points must recur, or gaps must differ.
    """
    first = float(np.median(gaps[gaps < 1.75 * float(gaps[0])]))
    for divisor in range(1, most + 1):
        if (step := first / divisor) < 8.0 * rounding:
            return None
        near = gaps[gaps < 24.0 * step]
        for _ in range(3):
            counts = np.maximum(np.round(near / step), 1.0)
            step = float(near.sum() / counts.sum())
        misfit = np.abs(near - step * counts)
        proved = often or np.count_nonzero(counts == counts[0]) < 0.9 * len(counts)
        # two rounded counts make a gap: each is off by up to a fifth where the log kept few decimals
        if proved and len(near) >= needed and np.quantile(misfit, 0.99) < 0.25 * step and misfit.mean() < 0.21 * step:
            return step
    return None


def noise_level(values: Real) -> float:
    """Return the standard deviation of white noise on a smooth channel, its quantisation included.

    It is taken from differences of such an order that the next order gives no less (the variate difference method,
    Anderson, Biometrika 10, 1914): a motion's curvature is left in second differences, and would be taken for noise.
    They are taken in blocks. Blocks of exact rest are left out, and the lower quartile of the others, away from ramps,
    steps and glitches, is given.
    """
    if len(values) < 3:
        return 0.0
    length = max((len(values) - 2) // 64, min(len(values) - 2, 32))
    second = _blocks(values, 2, length)
    moves = second > (64.0 * np.finfo(float).eps * np.abs(values).max()) ** 2
    if not moves.any():
        return 0.0
    level = float(np.quantile(second[moves], 0.25))
    for order in range(3, _ORDER + 1):
        if len(values) < order + length:
            break
        blocks = _blocks(values, order, length)
        higher = float(np.quantile(blocks[moves[: len(blocks)]], 0.25)) if moves[: len(blocks)].any() else level
        if higher > _FALLS * level:
            break
        level = higher
    return float(np.sqrt(level))


def _blocks(values: Real, order: int, length: int) -> Real:
    """Return the mean square of differences in blocks, over that of unit white noise."""
    squares = np.diff(values, order) ** 2
    whole = squares[: len(squares) // length * length].reshape(-1, length)
    return np.asarray(whole.mean(axis=1)) / comb(2 * order, order)


def counts(values: Real) -> float | None:
    """Return the step in which a force or voltage was logged; 0 if that is only the last digit."""
    return None if (step := lattice_step(values)) is None or step < 1e-6 * float(np.ptp(values)) else step


def clipped(values: Real) -> Mask:
    """Return where a channel is flat at its extreme for longer than coarse steps explain, shape (n,).

    A channel with few levels is not judged: sliding friction stays within a level, as a clipped force does. If a
    channel holds each value for several samples, since its rate is lower than that of the log, values are counted
    instead of samples.
    """
    found = np.zeros(len(values), bool)
    if not len(values) or not fine(values):
        return found
    step, lasting = counts(values), np.diff(np.flatnonzero(np.diff(values)))
    held = int(np.quantile(lasting, 0.05, method="lower")) if len(lasting) else 1
    rounding = 1e-9 * float(np.ptp(np.quantile(values, [0.005, 0.995])))  # apart from a single absurd sample
    for side in (values, -values):
        if abs(side.max()) < NEAR_ZERO * float(np.abs(values).max()):
            continue  # no range ends there: it rests
        top = side >= side.max() - rounding
        runs, often = np.diff(_runs(top))[:, 0], np.count_nonzero(top)
        below = np.count_nonzero(side >= side.max() - 1.5 * step) - often if step else 0
        repeats = often >= 4 * STUCK * held and runs.mean() >= 2.0 * held  # crests are short
        if (repeats or runs.max() >= STUCK * held) and often > 3 * below:
            found |= top
    return found


def _runs(mask: Mask) -> Indices:
    """Return the first sample, and one past the last, of each run in a mask, shape (runs, 2)."""
    return np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int))).reshape(-1, 2)


def drive_off(log: Log) -> Mask:
    """Return where the drive is off, shape (n,): at rest without any force, which is not friction.

    A coarse force that is mostly 0 at rest is not judged: its other levels are missing.
    """
    found = np.zeros(len(log), bool)
    if log.force is None or log.position is None or not np.any(log.force == 0.0) or not fine(log.force):
        return found
    for begin, end in _runs(np.append(np.diff(log.position) == 0.0, True) & (log.force == 0.0)):
        if end - begin > STUCK and log.time[end - 1] - log.time[begin] >= OFF:
            found[begin:end] = True
    return found


def clipped_samples(values: Real) -> int:
    """Count the samples at which a channel is clipped."""
    return int(np.count_nonzero(clipped(values)))


def clipped_among(records: Sequence[Real]) -> list[int]:
    """Count the samples of each record at which a channel is clipped, judged from all its records.

    A record that is flat at the common extreme is clipped if other records show that the channel is finer, and none
    exceeds it.
    """
    found = [clipped_samples(record) for record in records]
    if any(fine(record) for record in records):
        ends = (min(float(record.min()) for record in records), max(float(record.max()) for record in records))
        for n, record in enumerate(records):
            flat = int(np.count_nonzero(np.isin(record, ends)))
            if not found[n] and flat > len(record) / 2:
                found[n] = flat
    return found


def fine(values: Real, levels: int = LEVELS) -> bool:
    """Return whether the range of a channel has so many steps, or no steps are seen."""
    span, step = float(np.ptp(values)), counts(values)
    return span > 0.0 and (step is None or span >= levels * step)


def without_clipped(logs: Sequence[Log], most: float) -> tuple[list[Log], list[Notice]]:
    """Return the records whose force is not cut off, and the warnings about the others.

    most: Largest share of clipped samples: 0 where the force at reversals is the start of a branch.
    """
    counts = [0 if log.force is None else clipped_samples(log.force) for log in logs]
    kept = [log for log, count in zip(logs, counts, strict=True) if count <= most * len(log)]
    counted = ", ".join(f"{count} samples of '{log.name}'" for log, count in zip(logs, counts, strict=True) if count)
    if not counted:
        return kept, []
    if not kept:
        what = f"the force is clipped in {counted}: the largest friction and the stiffness are not known"
        hint = "Log with a larger range of the force's trace, or a smaller amplitude."
        raise FricError(what, where=logs[0].source, hint=hint)
    return kept, [CLIPPED_UNUSED.found(counted=counted, left_out=len(kept) < len(logs))]
