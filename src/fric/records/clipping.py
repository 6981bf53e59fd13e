"""Channels that are clipped at the end of their range."""

from collections.abc import Sequence

import numpy as np

from fric.arrays import Indices, Mask, Real
from fric.errors import FricError
from fric.flaws.channel import CLIPPED_UNUSED
from fric.log import Log
from fric.notice import Notice
from fric.records.resolution import lattice_step

STUCK = 5  # Number of consecutive samples at its extreme from which a force or input counts as clipped
OFF = 0.05  # Time without motion and with a force of exactly 0 from which the drive counts as off [s]
LEVELS = 40  # Least number of steps in a channel's range for a flat end to be clipping


def counts(values: Real) -> float | None:
    """Return the step in which a force or voltage was logged; 0 if that is only the last digit."""
    step = lattice_step(values)
    return None if step is None or step < 1e-6 * float(np.ptp(values)) else step


def clipped(values: Real) -> Mask:
    """Return where a channel is flat at its extreme for longer than coarse steps explain, shape (n,).

    A channel with few levels is not judged: sliding friction stays within a level, as a clipped force does. If a
    channel holds each value for several samples, since its rate is lower than that of the log, values are counted
    instead of samples.
    """
    found = np.zeros(len(values), bool)
    if not len(values) or not _fine(values):
        return found
    step = counts(values)
    lasting = np.diff(np.flatnonzero(np.diff(values)))
    held = int(np.quantile(lasting, 0.05, method="lower")) if len(lasting) else 1
    rounding = 1e-9 * float(np.ptp(np.quantile(values, [0.005, 0.995])))  # apart from a single absurd sample
    for side in (values, -values):
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
    if log.force is None or log.position is None or not np.any(log.force == 0.0) or not _fine(log.force):
        return found
    still = np.append(np.diff(log.position) == 0.0, True) & (log.force == 0.0)
    for begin, end in _runs(still):
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
    if any(_fine(record) for record in records):
        ends = (min(float(record.min()) for record in records), max(float(record.max()) for record in records))
        for n, record in enumerate(records):
            flat = int(np.count_nonzero(np.isin(record, ends)))
            if not found[n] and flat > len(record) / 2:
                found[n] = flat
    return found


def _fine(values: Real) -> bool:
    """Return whether a record shows values finer than its range."""
    span, step = float(np.ptp(values)), counts(values)
    return span > 0.0 and (step is None or span >= LEVELS * step)


def without_clipped(logs: Sequence[Log], most: float) -> tuple[list[Log], list[Notice]]:
    """Return the records whose force is not cut off, and the warnings about the others.

    most: Largest share of clipped samples: 0 where the force at reversals is the start of a branch.
    Raises FricError: When no record is left.
    """
    counts = [0 if log.force is None else clipped_samples(log.force) for log in logs]
    kept = [log for log, count in zip(logs, counts, strict=True) if count <= most * len(log)]
    counted = ", ".join(f"{count} samples of '{log.name}'" for log, count in zip(logs, counts, strict=True) if count)
    if not counted:
        return kept, []
    if not kept:
        raise FricError(
            f"the force is clipped in {counted}: the largest friction and the stiffness are not known",
            where=logs[0].source, hint="Log with a larger range of the force's trace, or a smaller amplitude.",
        )  # fmt: skip
    return kept, [CLIPPED_UNUSED.found(counted=counted, left_out=len(kept) < len(logs))]
