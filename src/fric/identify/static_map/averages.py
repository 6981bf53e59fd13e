"""One number from a segment of noisy samples: robust location, with a standard error that knows autocorrelation."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from fric.arrays import Real
from fric.statistics import robust_deviation

Average = Literal["robust", "median"]

HUBER = 1.345
"""Huber's tuning constant: 95 % efficiency on Gaussian noise (Huber 1964)."""
GLITCH = 8.0
"""Deviations from the median beyond which a sample is a glitch, where few are."""
LEVELS = 16
"""Levels of a segment's force up to which its steps are coarse."""
GLITCHES = 0.01
"""Share of the samples that glitches are at most: more of them is what the drive did."""


@dataclass(frozen=True)
class Mean:
    """A location with its standard error."""

    value: float
    """The robust mean or median, in the unit of the samples."""
    standard_error: float
    """In the same unit."""
    tau: float
    """Integrated autocorrelation time [samples]: ``n / tau`` samples are worth as much as independent ones."""
    rounding: float = 0.0
    """What coarse steps of the samples have of the standard error, in the same unit."""


def average(samples: Real, method: Average = "robust", step: float = 0.0) -> Mean:
    """Return the robust mean (Huber) or the median of a segment of samples, shape (n,), that come in steps."""
    return huber_mean(samples, step) if method == "robust" else median(samples, step)


def huber_mean(samples: Real, step: float = 0.0) -> Mean:
    """Return Huber's M-estimate of location, with the scale from the median absolute deviation, or the mean.

    At constant velocity the mean force is that of friction, and Huber's is not where an encoder's counts make the drive
    push to one side (2.5 % off, thirty standard errors): where they differ by more than its standard error, which noise
    makes of one segment in ten thousand, the mean of what is no glitch is given.

    The standard error is that of an M-estimate from correlated samples,
    ``se² = s²·tau·E[psi²] / (n·E[psi']²)``, with tau from the winsorised samples, so that glitches lengthen
    neither the mean nor the memory.
    """
    x = np.asarray(samples, float)
    centre = float(np.median(x))
    scale = robust_deviation(x - centre) or float(np.std(x))
    rounding = _rounding_error(x, step)
    if scale <= np.finfo(float).eps * abs(centre):
        return Mean(float(np.mean(x)), rounding, 1.0, rounding)
    for _ in range(50):
        psi = np.clip((x - centre) / scale, -HUBER, HUBER)
        inside = float(np.mean(np.abs(psi) < HUBER))
        shift = scale * float(np.mean(psi)) / max(inside, 0.1)
        centre += shift
        if abs(shift) < 1e-10 * scale:
            break
    psi = np.clip((x - centre) / scale, -HUBER, HUBER)
    tau = autocorrelation_time(psi)
    spread = scale * float(np.sqrt(np.mean(psi**2))) / max(float(np.mean(np.abs(psi) < HUBER)), 0.1)
    error = spread * np.sqrt(tau / len(x))
    glitch = np.abs(x - np.median(x)) > GLITCH * scale
    kept = x[~glitch] if np.mean(glitch) <= GLITCHES else x
    if rounding < error and abs(np.mean(kept) - centre) <= error:
        return Mean(centre, float(np.hypot(error, rounding)), tau, rounding)
    tau = autocorrelation_time(kept)
    error = float(np.std(kept)) * np.sqrt(tau / len(kept))
    return Mean(float(np.mean(kept)), float(np.hypot(error, rounding)), tau, rounding)


def _rounding_error(x: Real, step: float) -> float:
    """Return what rounding to coarse steps q may do to a mean, where noise σ moves it over few of them.

    The samples themselves tell the step where they have two levels or more, and none was given.

    Rounding Gaussian noise shifts a mean by at most about ``q/π·exp(-2π²σ²/q²)`` (Widrow and Kollár, Quantization
    Noise, 2008). Of the variance that is seen, up to q²/4 may be of two neighbouring levels alone, and is no noise; and
    without noise the error is uniform over a step: so ``q/√12·exp(-2π²·max(s² - q²/4, 0)/q²)`` is taken.
    """
    levels = np.unique(x)
    if len(levels) > LEVELS or (len(levels) == 1 and not step):
        return 0.0
    q = step or float(np.min(np.diff(levels)))
    variance = max(float(np.var(x)) - q**2 / 4, 0.0)
    return q / np.sqrt(12) * float(np.exp(-2 * np.pi**2 * variance / q**2))


def median(samples: Real, step: float = 0.0) -> Mean:
    """Return the median; its standard error is read off the order statistics around it.

    With n/tau independent samples the rank of the true median is n/2 ± sqrt(n/tau)/2 of the effective ranks, so one
    standard error is half the distance between the two quantiles ``1/2 ± 1/(2·sqrt(n/tau))``. Of samples
    in steps it is one of them, whatever their noise.
    """
    x = np.asarray(samples, float)
    middle = float(np.median(x))
    tau = autocorrelation_time(np.sign(x - middle))
    half = min(0.5, 0.5 / np.sqrt(len(x) / tau))
    low, high = np.quantile(x, [0.5 - half, 0.5 + half])
    rounding = step / np.sqrt(12)
    return Mean(middle, float(np.hypot((high - low) / 2, rounding)), tau, rounding)


def autocorrelation_time(x: Real, window: float = 5.0) -> float:
    """Return the integrated autocorrelation time [samples], ``1 + 2·Σ rho_k``, at least 1.

    The sum runs to the first lag beyond ``window`` times itself (Sokal 1989): longer sums add noise and no truth.
    """
    n = len(x)
    deviation = x - np.mean(x)
    if n < 8 or not np.any(deviation):
        return 1.0
    size = next_fast_len(2 * n, real=True)
    spectrum = rfft(deviation, size)
    covariance = irfft(np.abs(spectrum) ** 2, size)[:n]
    tau = 2.0 * np.cumsum(covariance / covariance[0]) - 1.0
    enough = np.arange(n) >= window * tau
    at = int(np.argmax(enough)) if enough.any() else n - 1
    return float(np.clip(tau[at], 1.0, n))
