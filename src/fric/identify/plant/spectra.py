"""Spectra of an excited axis: the period of the excitation, averages over periods, Welch's segments."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations
from typing import NamedTuple

import numpy as np
from scipy import fft, ndimage, special

from fric.arrays import Complex, Mask, Real
from fric.errors import FricError

SHORTEST = 8
"""Least number of samples in a period."""
PERIODIC = 0.5
"""Autocorrelation above which a signal counts as periodic; noise in the loop reduces it."""
ALONE = 0.9
"""Share of the driver's power above which a single segment dominates a line, as at a step in the reference."""
HANN_CORRELATION = 1 + 2 * ((2 / 3) ** 2 + (1 / 6) ** 2)
"""Lines of Hann's window per independent line: errors and driver of neighbouring lines correlate by 2/3, 1/6."""


class Spectra(NamedTuple):
    """Spectra of driver, input and position at the lines k ≥ 1, one row a period or segment."""

    frequency: Real  # Frequencies [Hz], shape (n,)
    driver: Complex  # driver, input, position: complex amplitudes, each of shape (p, n)
    input: Complex
    position: Complex
    averages: float  # Independent rows, p less what overlapping segments share
    correlation: float  # Neighbouring lines that equal one independent line

    def at(self, lines: Mask) -> Spectra:
        """Return the chosen lines, shape (n,)."""
        driver, input, position = (x[:, lines] for x in (self.driver, self.input, self.position))
        return Spectra(self.frequency[lines], driver, input, position, self.averages, self.correlation)


def coherence_of(X: Complex, Y: Complex) -> Real:
    """Return the coherence of two signals from their spectra, each of shape (p, n)."""
    power = np.sum(np.abs(X) ** 2, axis=0) * np.sum(np.abs(Y) ** 2, axis=0)
    return np.asarray(np.abs(np.sum(X * Y.conj(), axis=0)) ** 2 / np.maximum(power, 1e-300))


def find_period(values: Real) -> int | None:
    """Return the period of a signal in samples, None without two equal periods.

    It is the smallest lag, after the autocorrelation was below zero, with a peak about as high as the highest and a
    difference of the signal from itself about as small as the smallest: sparse lines almost repeat at a lag at which
    the highest of them do. If only the part between the lines differs, such as the rounding of an encoder, which may
    repeat after some periods, the period is the shorter lag.
    """
    n = len(values)
    along = np.arange(n) - 0.5 * (n - 1)
    x = values - np.mean(values) - along * (along @ values / max(float(along @ along), 1.0))
    power = np.abs(fft.rfft(x, fft.next_fast_len(2 * n))) ** 2
    r = fft.irfft(power)[: n // 2 + 1]
    if r[0] <= 1e-24 * n * max(float(np.max(np.abs(values))), 1e-300) ** 2:
        return None
    r = r / r[0] * (n / (n - np.arange(len(r))))  # of as many products as each lag has
    below = np.flatnonzero(r < 0)
    if below.size == 0:
        return None
    r[: below[0]] = 0.0
    best = float(r.max())  # a few high lines almost repeat at a shorter lag, and only almost beyond the noise
    high, after = r[1:] >= max(PERIODIC, best - 0.005 - 0.2 * max(1 - best, 0.0)), np.append(r[2:], 0.0)
    peaks = 1 + np.flatnonzero(high & (r[1:] > r[:-1]) & (r[1:] >= after))
    if not peaks.size:
        return None
    unlike = np.array([np.mean((x[lag:] - x[:-lag]) ** 2) for lag in peaks])
    found = int(peaks[np.argmax(unlike <= 1.1 * unlike.min() + 1e-4 * np.mean(x**2))])
    parts = (int(lag) for lag in peaks if lag < found and found % lag == 0)
    return next((lag for lag in parts if _at_lines(x, lag, found) < 0.1), found)


def _at_lines(x: Real, lag: int, period: int) -> float:
    """Return the share of the lines in the power of the difference of a signal from itself at a lag."""
    common, differing = (
        np.abs(fft.rfft(signal[-(len(signal) // period * period) :])) ** 2 for signal in (x, x[lag:] - x[:-lag])
    )
    lines, beside = (power[:: (2 * len(power) - 1) // period] for power in (common, differing))
    falling = np.sort(lines)[::-1]
    driven = lines >= falling[np.searchsorted(np.cumsum(falling), 0.99 * np.sum(lines))]
    return float(np.sum(beside[driven]) / max(np.sum(differing), 1e-300))


def period_spectra(input: Real, position: Real, period: int, sampling: float) -> Spectra:
    """Return the spectra of whole periods, counted back from the end, without mean drifts.

    The driver is 1: the excitation is the same in each period.

    input, position: Control voltage [V] and position [m], each of shape (n,).
    period: Samples a period.
    sampling: Samples a second [Hz].
    Raises FricError: When there are fewer than two periods.
    """
    if period < SHORTEST:
        raise FricError(f"a period of {period} samples is too short for a response", hint="Give the right `period=`.")
    count = len(input) // period
    if count < 2:
        raise FricError(
            f"a record of {len(input)} samples holds {count} period(s) of {period}",
            hint="Log two periods or more, ten are good; or give the right `period=`.",
        )
    U, Z = (periods(x, period) for x in (input, position))
    if count > 2 and _swings_in(U, Z):  # its transient is no drift of the others
        U, Z = (periods(x[-(count - 1) * period :], period) for x in (input, position))
    frequency = np.arange(1, U.shape[1] + 1) * sampling / period
    return Spectra(frequency, np.ones_like(U), U, Z, len(U), 1.0)


def periods(values: Real, period: int) -> Complex:
    """Return the lines k ≥ 1 of each whole period, counted back from the end, without the mean drift: (p, n)."""
    count = len(values) // period
    x = values[-count * period :]
    x = x - drift(values, period) * np.arange(len(x))
    return np.asarray(fft.rfft(x.reshape(count, period))[:, 1 : (period + 1) // 2] / period)


def drift(values: Real, period: int) -> float:
    """Return the average rise of a periodic signal in one sample."""
    return float(np.mean(values[period:] - values[:-period])) / period


def _swings_in(U: Complex, Z: Complex) -> bool:
    """Return whether the first period differs from the later periods by more than ten times their variance."""
    first, others = 0.0, 0.0
    for X in (U, Z):
        rest = X[1:]
        variance = np.mean(np.abs(rest - rest.mean(axis=0)) ** 2, axis=0) + 1e-30 * np.abs(rest.mean(axis=0)) ** 2
        if not variance.max() > 0.0:
            continue  # a channel that never moves
        weight = 1 / np.maximum(variance, 1e-12 * variance.max())
        first += float(np.sum(np.abs(X[0] - rest.mean(axis=0)) ** 2 * weight))
        others += float(np.sum(variance * weight))
    return first > 10 * others


def segment_spectra(input: Real, position: Real, driver: Real, segment: int, sampling: float) -> Spectra:
    """Return the spectra of segments under Hann's window that overlap by half (Welch 1967).

    The position is differenced first and the lines are corrected for that: an integrating plant's position wanders, and
    would leak into every line.

    input, position, driver: Control voltage [V], position [m], and their driver: the reference or the input itself,
        each shape (n,).
    segment: Samples a segment.
    sampling: Samples a second [Hz].
    """
    n = len(input) - 1
    starts = np.arange(0, n - segment + 1, max(segment // 2, 1))
    from scipy import signal

    window = signal.windows.hann(segment, sym=False)
    pick = starts[:, None] + np.arange(segment)
    rows = [signal.detrend(x[pick]) * window for x in (driver[1:], input[1:], np.diff(position))]
    R, U, dZ = (fft.rfft(x)[:, 3 : segment // 2] / segment for x in rows)  # the window smears 0 Hz over the first two
    frequency = np.arange(3, segment // 2) * sampling / segment
    Z = dZ / -np.expm1(-2j * np.pi * frequency / sampling)
    averages = len(starts) / (1 + 2 / 36 * (1 - 1 / len(starts)))
    return Spectra(frequency, R, U, Z, averages, HANN_CORRELATION)


def neighbour_spectra(input: Real, position: Real, driver: Real, sampling: float, count: int = 16) -> Spectra:
    """Return the lines of a whole record, with ``count`` neighbours as the rows of a frequency.

    This is for a single sweep, which passes each frequency only once, so that single segments would dominate. The
    position is differenced twice, after which an integrating plant is smooth over neighbouring lines, and the result is
    corrected for that. The first and last fortieth of the record are faded in and out.

    input, position, driver: As in `segment_spectra`, each shape (n,).
    sampling: Samples a second [Hz].
    count: Lines to each frequency.
    """
    n = len(input) - 2
    from scipy import signal

    fade = signal.windows.tukey(n, 0.05)
    rows = [signal.detrend(x) * fade for x in (driver[1:-1], input[1:-1], np.diff(position, 2))]
    bands = (n // 2 - 3) // count
    R, U, ddZ = (fft.rfft(x)[3 : 3 + bands * count].reshape(bands, count).T / n for x in rows)
    frequency = (3 + (count - 1) / 2 + count * np.arange(bands)) * sampling / n
    shift = np.exp(2j * np.pi * frequency / sampling)  # the second difference is centred
    return Spectra(frequency, R, U, ddZ / (shift - 2 + 1 / shift), float(count), 1.0)


def swept(spectra: Spectra, share: float = 0.4) -> bool:
    """Return whether single segments hold most of the driver's power at its lines, as those of a sweep do."""
    power = np.abs(spectra.driver) ** 2
    return bool(np.median(power.max(axis=0) / power.sum(axis=0)) > share)


def moved_at(spectra: Spectra, *, is_input: bool) -> Mask:
    """Return the lines at which the driver has power, apart from leakage of the window from lower lines.

    spectra: Spectra of segments or neighbouring lines.
    is_input: Whether the driver is the input; a reference, which falls with frequency, is evaluated by its speed.
    """
    size = np.sqrt(np.mean(np.abs(spectra.driver) ** 2, axis=0)) * (1.0 if is_input else spectra.frequency)
    driven: Mask = size > (0.05 if is_input else 0.01) * np.maximum.accumulate(size)
    return driven


def estimate(spectra: Spectra) -> tuple[Complex, Real, Real]:
    """Return Z/U [m/V], its relative deviation, and its coherence, each of shape (n,).

    Input and position are each regressed on the driver, and the response is the quotient of both (joint input-output;
    Pintelon and Schoukens, System Identification, 2nd ed., section 2.5). Noise that the loop feeds back is in both
    regressions and averages out; with the input itself as driver this is the ordinary quotient of spectra.

    The deviation is that of real and imaginary part over |Z/U|, smoothed over neighbouring lines; the coherence is that
    at which an ordinary response of as many averages has that deviation.
    """
    R, p = spectra.driver, len(spectra.driver)
    power = np.sum(np.abs(R) ** 2, axis=0)
    power = np.maximum(power, 1e-300)
    T_u, T_z = (np.sum(X * R.conj(), axis=0) / power for X in (spectra.input, spectra.position))
    e_u, e_z = spectra.input - T_u * R, spectra.position - T_z * R
    with np.errstate(divide="ignore", invalid="ignore"):
        G = T_z / T_u
        spread = np.sum(np.abs(e_z / T_z - e_u / T_u) ** 2, axis=0) / (p - 1)
    variance = spread / power * (p / spectra.averages)
    alone = np.max(np.abs(R) ** 2, axis=0) > ALONE * power  # a single row fits itself, and does not show its error
    usable = np.isfinite(variance) & np.isfinite(G) & (np.abs(G) > 0) & ~alone
    variance = _smoothed(np.where(usable, variance, np.inf), 2 * (p - 1))
    deviation = np.sqrt(variance / 2)
    return np.where(usable, G, 0.0), deviation, 1 / (1 + spectra.averages * variance)


def _smoothed(variance: Real, freedom: int, half_width: int = 4) -> Real:
    """Return symmetric geometric means over neighbouring lines, unbiased for chi-squared values."""
    n = len(variance)
    log = np.log(np.maximum(variance, 1e-300))
    total = np.concatenate([[0.0], np.cumsum(np.where(np.isfinite(log), log, 0.0))])
    count = np.concatenate([[0], np.cumsum(np.isfinite(log))])
    at = np.arange(n)
    wide = np.minimum(np.minimum(at, n - 1 - at), half_width)
    low, high = at - wide, at + wide + 1
    mean = (total[high] - total[low]) / np.maximum(count[high] - count[low], 1)
    bias = float(special.digamma(freedom / 2) - np.log(freedom / 2))
    return np.where(np.isfinite(log), np.exp(mean - bias), np.inf)


DRIVEN_APART = 1.5
"""Ratio of two amplitudes above which they separate driven lines from the others."""
LESS = 0.75
"""Least power of that ratio by which a driven line grows."""


class MeanLines(NamedTuple):
    """Lines of a period: frequency [Hz], mean complex amplitude of input [V] and position [m], which are driven; (n,).

    The driven lines may be known from the reference.
    """

    frequency: Real
    input: Complex
    position: Complex
    driven: Mask
    stated: bool


def excited(spectra: Spectra, driven: Mask | None = None, tall: float = 0.05, surely: float = 0.3) -> Mask:
    """Return the driven lines of a periodic excitation.

    At a line that is not driven a closed loop shows the controller, encoder steps or friction's harmonics, which may
    repeat as exactly as the excitation. A driven line is tall among its neighbours in input and position together, not
    small against the input at any lower frequency, and above the noise. A line that is less than surely tall must take
    power from the voltage, ``Re(u*·jωz) > 0``: friction's harmonics bring it.

    spectra: Spectra of whole periods.
    driven: The lines that the reference drives, shape (n,), where it is known: it settles the question.
    tall, surely: Least share of the tallest line for a driven line, and the share above which it is driven without
        further test.
    """
    U, Z = (np.abs(np.mean(x, axis=0)) for x in (spectra.input, spectra.position))
    variance = np.var(spectra.input, axis=0, ddof=1) / len(spectra.input)
    noise = np.sqrt(ndimage.median_filter(variance, size=21, mode="nearest"))
    if driven is not None:
        return driven
    both = np.sqrt(U * Z)
    half_width = np.maximum(2, np.arange(len(U)) // 4)
    around = np.array([both[max(0, k - r) : k + r + 1].max() for k, r in enumerate(half_width)])
    power = np.real(1j * np.mean(spectra.position, axis=0) * np.mean(spectra.input, axis=0).conj())
    seen = (both > surely * around) | ((both > tall * around) & (power > 0))
    return np.asarray(seen & (tall * np.maximum.accumulate(U) < U) & (5 * noise < U))


def driven_alike(records: Sequence[MeanLines | None]) -> list[Mask | None]:
    """Return the driven lines of each record by comparing two amplitudes of an excitation, None if not possible.

    What is driven grows with the excitation, in input or in position (a loop that holds one leaves the other to
    friction); friction's harmonics do not. So a line is driven where one of two records shows it as driven, and where
    it grows between them about as much as the median of the lines that both show and that grow: with much friction, a
    loop grows by more than its excitation.

    records: The lines of each record, None for one without periods.
    """
    found: list[Mask | None] = [None] * len(records)
    for small, large in permutations(range(len(records)), 2):
        lines, other = records[small], records[large]
        if lines is None or other is None or not np.array_equal(lines.frequency, other.frequency):
            continue
        growth = np.maximum(_ratio(other.input, lines.input), _ratio(other.position, lines.position))
        both = lines.driven & other.driven
        if not both.any() or np.quantile(growth[both], 0.75) < DRIVEN_APART:
            continue
        driven = (growth > np.median(growth[both & (growth > DRIVEN_APART)]) ** LESS) & (lines.driven | other.driven)
        for n in (small, large):
            if not records[n].stated:  # type: ignore[union-attr]
                found[n] = driven if found[n] is None else driven & found[n]
    return found


def _ratio(over: Complex, under: Complex) -> Real:
    return np.asarray(np.abs(over) / np.maximum(np.abs(under), 1e-300))


def distortion(spectra: Spectra, driven: Mask, neighbours: int = 12) -> Real:
    """Return the relative deviation of each driven line due to periodic components that are not driven.

    Friction's harmonics and encoder steps repeat from period to period, and the scatter over periods does not show
    them. The lines between the driven lines do (Pintelon and Schoukens, System Identification, 2nd ed., section 4.3):
    they show the voltage ``|Z_j/G - U_j|``, with G between the driven lines; its median over the nearest lines j that
    are not driven, over U_k, is the error of line k.

    spectra: Spectra of whole periods.
    driven: Which lines are driven, shape (n,).
    neighbours: Number of lines that are used; with fewer than four the deviation is not known: 0.
    """
    U, Z = np.mean(spectra.input, axis=0), np.mean(spectra.position, axis=0)
    at = np.flatnonzero(driven)
    inside = np.arange(len(U)) <= (at[-1] if len(at) else -1)
    quiet = np.flatnonzero(~driven & inside)
    found = np.zeros(len(at))
    if len(quiet) < 4 or np.any(U[at] == 0) or np.any(Z[at] == 0):
        return found
    f, log_G = np.log(spectra.frequency), np.log(Z[at] / U[at])
    angle = np.unwrap(log_G.imag)
    G = np.exp(np.interp(f[quiet], f[at], log_G.real) + 1j * np.interp(f[quiet], f[at], angle))
    voltage = np.abs(Z[quiet] / G - U[quiet]) ** 2
    for n, k in enumerate(at):
        near = np.argsort(np.abs(f[quiet] - f[k]))[:neighbours] if len(quiet) > neighbours else slice(None)
        found[n] = np.sqrt(np.median(voltage[near]) / np.log(2.0) / 2) / np.abs(U[k])
    return found
