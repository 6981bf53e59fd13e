"""The sampling of a record, for methods that need it even."""

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from fric.arrays import Real
from fric.errors import FricError
from fric.log import Log
from fric.notice import Notice

LOST = 0.05
"""Share of the samples that may be missing in an uneven record that is made even."""

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
        raise FricError(f"the record has {len(log)} samples", where=log.where, hint="Log a longer motion.")
    period = float(log.time[-1] - log.time[0]) / (len(log) - 1)
    off = np.abs(np.diff(log.time) / period - 1)
    worst = int(np.argmax(off))
    if off[worst] > JITTER:
        step = log.time[worst + 1] - log.time[worst]
        raise FricError(
            f"the sampling is uneven: {step:.4g} s after t = {log.time[worst]:.6g} s, and {period:.4g} s on average",
            where=log.where,
            hint="Ingest a record without gaps, or cut it at the gap into records of their own.",
        )
    return 1 / period


def evened(log: Log) -> tuple[Log, list[str]]:
    """Return a record as if it had been sampled evenly, with what is to be said of it; an even one as it is.

    Instants that jitter, and samples that are missing here and there, are made up for along a cubic through the others.

    Raises
    ------
    FricError
        When more than `LOST` of the samples are missing, or more than 8 at one place.
    """
    steps = np.diff(log.time)
    period = float(np.median(steps))
    if len(log) < 16 or np.all(np.abs(steps / period - 1) <= JITTER / 100):
        return log, []
    span = float(log.time[-1] - log.time[0])
    intervals = round(span / period)
    missing = intervals + 1 - len(log)
    if missing > LOST * len(log) or float(steps.max()) > 9.5 * period:
        return log, []  # which is then refused, with its place
    even = log.time[0] + np.linspace(0.0, span, intervals + 1)
    if missing == 0 and float(np.abs(even - log.time).max()) <= JITTER / 100 * period:
        return log, []
    channels: dict[str, Any] = {
        name: CubicSpline(log.time, values)(even) for name, values in log.channels().items() if name != "time"
    }
    text = Notice(
        f"{log.name}: the sampling is not even ({missing} of {intervals + 1} samples are missing, the others up to "
        f"{100 * float(np.abs(_phase(log.time, period)).max()):.0f} % of a sample off): it was made even along a cubic",
        "sampling-uneven", "note",
    )  # fmt: skip
    return replace(log, time=even, **channels), [text]


def _phase(time: Real, period: float) -> Real:
    """Return by how many samples each instant is off the even one that is next to it."""
    at = (time - time[0]) / period
    return np.asarray(at - np.rint(at))
