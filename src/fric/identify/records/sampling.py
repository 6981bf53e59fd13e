"""The sampling of a record, for methods that need it even."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fric.errors import FricError

if TYPE_CHECKING:
    from fric.log import Log

JITTER = 0.1
"""Share of a sample by which an interval may differ from the mean one."""


def even_sampling(log: Log) -> float:
    """Return the sampling rate [Hz] of an evenly sampled record: the samples over the time that they took.

    Raises
    ------
    FricError
        When the record has fewer than 16 samples, or an interval between samples is not the mean one.
    """
    if len(log) < 16:
        raise FricError(f"the record has {len(log)} samples", where=log.where, mend="Log a longer motion.")
    period = float(log.time[-1] - log.time[0]) / (len(log) - 1)
    off = np.abs(np.diff(log.time) / period - 1)
    worst = int(np.argmax(off))
    if off[worst] > JITTER:
        step = log.time[worst + 1] - log.time[worst]
        raise FricError(
            f"the sampling is uneven: {step:.4g} s after t = {log.time[worst]:.6g} s, and {period:.4g} s on average",
            where=log.where,
            mend="Ingest a record without gaps, or cut it at the gap into records of their own.",
        )
    return 1 / period
