"""The motion behind encoder counts: even instants, and a tracking error that is smoothed."""

from math import pi

import numpy as np
from scipy.fft import next_fast_len

from fric.arrays import Complex, Real
from fric.errors import FricError

MOST_MISSING = 4.0
"""Samples that the time of one that was recorded may hold on average."""
SMOOTHED = 200.0
"""Corner of the filter over the tracking error [Hz]."""


def smoothed(t: Real, r: Real, error: Real, acceleration: Real | None = None) -> tuple[Real, Real]:
    """Return position [m] and velocity [m/s] behind encoder counts: the reference less the error, smoothed.

    t, r, error: Even instants [s], reference [m], and tracking error as measured [m], shape (n,).
    acceleration: Acceleration of the error as the voltages tell it [m/s²]; above the filter's corner the error is taken
        from it.
    """
    n, dt = len(t), float(t[1] - t[0])
    length = next_fast_len(2 * n, real=True)
    f = np.fft.rfftfreq(length, dt)
    low = 1.0 / (1.0 + (f / SMOOTHED) ** 4)

    def spectrum_of(values: Real) -> Complex:
        """Return the spectrum of a signal, mirrored at its end and at its beginning so that it has no step."""
        return np.fft.rfft(np.concatenate([values, np.full(length - 2 * n, values[-1]), values[::-1]]))

    spectrum = low * spectrum_of(error)
    if acceleration is not None:
        square = (2 * pi * np.maximum(f, f[1])) ** 2
        spectrum -= (1 - low) / square * spectrum_of(acceleration)
    z = r - np.fft.irfft(spectrum, length)[:n]
    return np.ascontiguousarray(z), np.gradient(z, t)


def low_pass(corner: float, sampling: float) -> Real:
    """Return the second-order sections of a Butterworth low-pass of second order with a corner [Hz]."""
    from scipy.signal import butter

    return np.asarray(butter(2, min(corner / (sampling / 2), 0.95), output="sos"))


def even(time: Real, *channels: Real) -> tuple[Real, list[Real]]:
    """Return channels at even instants: as they are, or between their samples where these are missing or jitter.

    Raises FricError: When most samples are missing.
    """
    period = float(np.median(np.diff(time)))
    samples = round((time[-1] - time[0]) / period) + 1
    if samples > MOST_MISSING * len(time):
        raise FricError(
            f"{len(time)} samples cover the time of {samples:.3g}", hint="Record it again, without gaps in its time."
        )
    t = time[0] + period * np.arange(samples)
    if len(t) == len(time) and np.abs(t - time).max() < 0.02 * period:
        mean = float(time[-1] - time[0]) / (len(time) - 1)
        return time[0] + mean * np.arange(len(time)), list(channels)
    return t, [np.interp(t, time, channel) for channel in channels]
