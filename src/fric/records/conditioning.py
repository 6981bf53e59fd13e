"""Zero-phase filters and decimation before a fit to motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fric.arrays import Real
from fric.errors import FricError
from fric.log import Log
from fric.records.motion import Motion

BANDWIDTH = 20.0
"""What a position loop makes of a motion [Hz]; the filters leave room above it."""


@dataclass(frozen=True)
class Conditioning:
    """How a record is filtered and thinned out before the fit."""

    cutoff: float  # Corner of the fourth-order Butterworth filter, run forwards and backwards over the position [Hz]
    decimation: int  # One sample of so many is kept, after a zero-phase Chebyshev filter over each column of the fit
    border: int  # Samples left out at the start of a record, where filter and differences see its edge

    @classmethod
    def of(
        cls, sampling: float, cutoff: float | None = None, decimation: int | None = None, border: int | None = None
    ) -> Conditioning:
        """Return what suits a sampling rate [Hz], as far as it is not given.

        The corner is five times the bandwidth of the motion, so that the filter leaves its acceleration alone; the
        decimated signals reach to twice that bandwidth, and 4.9 periods of the corner are left out at the start.

        Raises FricError: When the corner is not below half the sampling rate, or a count is negative.
        """
        cutoff = min(5 * BANDWIDTH, 0.2 * sampling) if cutoff is None else cutoff
        if not 0 < cutoff < sampling / 2:
            raise FricError(
                f"the cut-off of {cutoff:g} Hz is not between 0 and half the sampling rate ({sampling / 2:g} Hz)"
            )
        decimation = max(1, round(0.8 * sampling / 2 / (2 * BANDWIDTH))) if decimation is None else decimation
        border = round(4.9 * sampling / cutoff) if border is None else border
        if decimation < 1 or border < 0:
            raise FricError("decimation is at least 1, and the border not negative")
        return cls(cutoff, decimation, border)


def filtered_motion(log: Log, settings: Conditioning) -> Motion:
    """Return a record's motion behind the filter of the published fit, by central differences.

    log: An evenly sampled record with a position or a velocity.
    settings: The filter.
    Raises FricError: When the record is too short for the filter and its decimation.
    """
    if len(log) < settings.border + 30 * settings.decimation:
        raise FricError(
            f"{len(log)} samples are too few for a border of {settings.border} and a decimation of "
            f"{settings.decimation}", where=log.where, hint="Log a longer motion, or give a smaller `decimation=`.",
        )  # fmt: skip
    dt = float(log.time[-1] - log.time[0]) / (len(log) - 1)
    sos = butterworth(settings.cutoff, 1 / dt)
    if log.position is not None:
        position = zero_phase(sos, log.position, 4)
        velocity = np.gradient(position, dt)
    else:
        velocity = zero_phase(sos, log.require("velocity", "a motion"), 4)
        position = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * dt)])
    return Motion(log.time, position, velocity, np.gradient(velocity, dt), 0.0)


def butterworth(corner: float, sampling: float) -> Real:
    """Return the second-order sections of a Butterworth low-pass of fourth order with a corner [Hz]."""
    from scipy import signal  # not at the start: it brings scipy.stats, 0.5 s, which pages and circles do not need

    return np.asarray(signal.butter(4, corner, fs=sampling, output="sos"))


def thinned(values: Real, decimation: int) -> Real:
    """Return one sample of so many, the last one among them, after a zero-phase Chebyshev filter.

    Eighth order, 0.05 dB, 0.8 of the new half rate, as in MATLAB's ``decimate``, from which the published figures
    come; `scipy.signal.decimate` counts from the first sample and extends the edges otherwise.
    """
    from scipy import signal

    if decimation == 1:
        return values
    order = 8
    sos = signal.cheby1(order, 0.05, 0.8 / decimation, output="sos")
    return zero_phase(sos, values, order)[kept(len(values), decimation)]


def kept(n: int, decimation: int) -> slice:
    """Return which of n samples `thinned` keeps."""
    return slice((n - 1) % decimation, None, decimation)


def zero_phase(sos: Real, values: Real, order: int) -> Real:
    """Return the values filtered forwards and backwards, their edges mirrored over three times the order."""
    from scipy import signal

    return np.asarray(signal.sosfiltfilt(sos, values, padlen=3 * order))
