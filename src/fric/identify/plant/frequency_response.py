"""The empirical frequency response of an excited axis, by whole periods or Welch's segments, and its uncertainty."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import permutations
from typing import Literal, NamedTuple

import numpy as np
from scipy import fft, ndimage, special

from fric.arrays import Complex, Mask, Real
from fric.errors import FricError, found_in
from fric.flaws.response import FEW_PERIODS, LOOP_FEEDS_BACK, NO_COHERENCE
from fric.log import FrequencyResponse, Log
from fric.notice import Notice
from fric.records.flaws import even_sampling
from fric.records.motion import butterworth, zero_phase
from fric.records.resolution import lattice_step

SHORTEST = 8  # Least number of samples in a period
PERIODIC = 0.5  # Autocorrelation above which a signal counts as periodic; noise in the loop reduces it
NEIGHBOURS = 16  # Lines of a sweep that are averaged to a frequency
TALL, SURELY = 0.05, 0.3  # Least share of the tallest line for a driven line, and that for one without further test
QUIET = 12  # Number of lines, not driven, that show the distortion of a driven line
ALONE = 0.9  # Share of the driver's power above which a single segment dominates a line, as at a step in the reference
HANN_CORRELATION = 1 + 2 * ((2 / 3) ** 2 + (1 / 6) ** 2)  # Lines per independent one: neighbours correlate by 2/3, 1/6
LEAST_ASKED = 0.01  # Share of the motion that a reference asks for, if it drives the axis: a resonance is less
DRIVEN_APART = 1.5  # Ratio of two amplitudes above which they separate driven lines from the others
LESS = 0.75  # Least power of that ratio by which a driven line grows
SINE = 0.865  # Mean of a sine's size over its deviation is 0.90, that of normally distributed values 0.80: between them
STRETCHES = 16  # Stretches of a motion, in each of which a sweep is about a sine
SEGMENTS = 8  # Length of the record over that of a Welch segment, unless another is given
DISTORTED = 1.5  # Ratio to the noise of a line above which the periodic part at its neighbours is more than noise
ABOVE_ROUNDING = 3.0  # Ratio of a driven line to the rounding of the encoder that all periods repeat, at least
COHERENT = 0.5  # Coherence above which a signal counts as driven by another
UNKNOWN = 1e9  # Relative deviation of a line without an estimate of its noise: its weight is practically 0


class Spectra(NamedTuple):
    """Spectra of driver, input and position at the lines k ≥ 1, one row a period or segment."""

    frequency: Real  # Frequencies [Hz], shape (n,)
    driver: Complex  # driver, input, position: complex amplitudes, each of shape (p, n)
    input: Complex
    position: Complex
    averages: float  # Independent rows, p less what overlapping segments share
    correlation: float  # Neighbouring lines that equal one independent line

    def at(self, lines: Mask) -> "Spectra":
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
    r = fft.irfft(np.abs(fft.rfft(x, fft.next_fast_len(2 * n))) ** 2)[: n // 2 + 1]
    if r[0] <= 1e-24 * n * max(float(np.max(np.abs(values))), 1e-300) ** 2:
        return None
    r = r / r[0] * (n / (n - np.arange(len(r))))  # of as many products as each lag has
    if (below := np.flatnonzero(r < 0)).size == 0:
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
    common, differing = (np.abs(fft.rfft(of[-(len(of) // period * period) :])) ** 2 for of in (x, x[lag:] - x[:-lag]))
    lines, beside = (power[:: (2 * len(power) - 1) // period] for power in (common, differing))
    falling = np.sort(lines)[::-1]
    driven = lines >= falling[np.searchsorted(np.cumsum(falling), 0.99 * np.sum(lines))]
    return float(np.sum(beside[driven]) / max(np.sum(differing), 1e-300))


def period_spectra(input: Real, position: Real, period: int, sampling: float) -> Spectra:
    """Return the spectra of whole periods, counted back from the end, without mean drifts.

    The driver is 1: the excitation is the same in each period.
    """
    if period < SHORTEST:
        raise FricError(f"a period of {period} samples is too short for a response", hint="Give the right `period=`.")
    if (count := len(input) // period) < 2:
        hint = "Log two periods or more, ten are good; or give the right `period=`."
        raise FricError(f"a record of {len(input)} samples holds {count} period(s) of {period}", hint=hint)
    U, Z = (periods(x, period) for x in (input, position))
    if count > 2 and _swings_in(U, Z):  # its transient is no drift of the others
        U, Z = (periods(x[-(count - 1) * period :], period) for x in (input, position))
    return Spectra(np.arange(1, U.shape[1] + 1) * sampling / period, np.ones_like(U), U, Z, len(U), 1.0)


def periods(values: Real, period: int) -> Complex:
    """Return the lines k ≥ 1 of each whole period, counted back from the end, without the mean drift: (p, n)."""
    count = len(values) // period
    x = values[-count * period :]
    x = x - drift(x, period) * np.arange(len(x))  # of these periods alone: an axis may start before them
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


def segment_spectra(
    input: Real, position: Real, driver: Real, segment: int, sampling: float, integrates: bool = True
) -> Spectra:
    """Return the spectra of segments under Hann's window that overlap by half (Welch 1967).

    The position is differenced first and the lines are corrected for that: an integrating plant's position wanders, and
    would leak into every line. A force leaks as its input does, and is not differenced.

    input, position, driver: Control voltage [V], position [m], and their driver: the reference or the input itself,
        each shape (n,).
    integrates: False for a force in place of the position.
    """
    starts = np.arange(0, len(input) - segment, max(segment // 2, 1))
    from scipy import signal

    window = signal.windows.hann(segment, sym=False)
    pick = starts[:, None] + np.arange(segment)
    channels = driver[1:], input[1:], np.diff(position) if integrates else position[1:]
    rows = [signal.detrend(x[pick]) * window for x in channels]
    R, U, dZ = (fft.rfft(x)[:, 3 : segment // 2] / segment for x in rows)  # the window smears 0 Hz over the first two
    frequency = np.arange(3, segment // 2) * sampling / segment
    Z = dZ / -np.expm1(-2j * np.pi * frequency / sampling) if integrates else dZ
    return Spectra(frequency, R, U, Z, len(starts) / (1 + 2 / 36 * (1 - 1 / len(starts))), HANN_CORRELATION)


def neighbour_spectra(input: Real, position: Real, driver: Real, sampling: float, integrates: bool = True) -> Spectra:
    """Return the lines of a whole record, with `NEIGHBOURS` as the rows of a frequency.

    This is for a single sweep, which passes each frequency only once, so that single segments would dominate. The
    position is differenced twice, after which an integrating plant is smooth over neighbouring lines, and the result is
    corrected for that. The first and last fortieth of the record are faded in and out.

    input, position, driver, integrates: As in `segment_spectra`, each shape (n,).
    """
    n = len(input) - 2
    from scipy import signal

    fade = signal.windows.tukey(n, 0.05)
    moved = np.diff(position, 2) if integrates else position[1:-1]
    rows = [signal.detrend(x) * fade for x in (driver[1:-1], input[1:-1], moved)]
    count = NEIGHBOURS
    bands = (n // 2 - 3) // count
    R, U, ddZ = (fft.rfft(x)[3 : 3 + bands * count].reshape(bands, count).T / n for x in rows)
    frequency = (3 + (count - 1) / 2 + count * np.arange(bands)) * sampling / n
    shift = np.exp(2j * np.pi * frequency / sampling)  # the second difference is centred
    return Spectra(frequency, R, U, ddZ / (shift - 2 + 1 / shift) if integrates else ddZ, float(count), 1.0)


def swept(spectra: Spectra) -> bool:
    """Return whether single segments hold most of the driver's power at its lines, as those of a sweep do."""
    power = np.abs(spectra.driver) ** 2
    return bool(np.median(power.max(axis=0) / power.sum(axis=0)) > 0.4)


def moved_at(spectra: Spectra, *, is_input: bool) -> Mask:
    """Return the lines at which the driver has power, apart from leakage of the window from lower lines.

    is_input: Whether the driver is the input; a reference, which falls with frequency, is evaluated by its speed.
    """
    size = np.sqrt(np.mean(np.abs(spectra.driver) ** 2, axis=0)) * (1.0 if is_input else spectra.frequency)
    return np.asarray(size > (0.05 if is_input else 0.01) * np.maximum.accumulate(size))


def estimate(spectra: Spectra) -> tuple[Complex, Real, Real]:
    """Return Z/U [m/V], its relative deviation, and its coherence, each of shape (n,).

    Input and position are each regressed on the driver, and the response is the quotient of both (joint input-output;
    Pintelon and Schoukens, System Identification, 2nd ed., section 2.5). Noise that the loop feeds back is in both
    regressions and averages out; with the input itself as driver this is the ordinary quotient of spectra.

    The deviation is that of real and imaginary part over |Z/U|, smoothed over neighbouring lines; the coherence is that
    at which an ordinary response of as many averages has that deviation.
    """
    R, p = spectra.driver, len(spectra.driver)
    power = np.maximum(np.sum(np.abs(R) ** 2, axis=0), 1e-300)
    T_u, T_z = (np.sum(X * R.conj(), axis=0) / power for X in (spectra.input, spectra.position))
    e_u, e_z = spectra.input - T_u * R, spectra.position - T_z * R
    with np.errstate(divide="ignore", invalid="ignore"):
        G = T_z / T_u
        spread = np.sum(np.abs(e_z / T_z - e_u / T_u) ** 2, axis=0) / (p - 1)
    variance = spread / power * (p / spectra.averages)
    alone = np.max(np.abs(R) ** 2, axis=0) > ALONE * power  # a single row fits itself, and does not show its error
    usable = np.isfinite(variance) & np.isfinite(G) & (np.abs(G) > 0) & ~alone
    variance = _smoothed(np.where(usable, variance, np.inf), 2 * (p - 1))
    return np.where(usable, G, 0.0), np.sqrt(variance / 2), 1 / (1 + spectra.averages * variance)


def _smoothed(variance: Real, freedom: int) -> Real:
    """Return symmetric geometric means over neighbouring lines, unbiased for chi-squared values."""
    n = len(variance)
    log = np.log(np.maximum(variance, 1e-300))
    total = np.concatenate([[0.0], np.cumsum(np.where(np.isfinite(log), log, 0.0))])
    count = np.concatenate([[0], np.cumsum(np.isfinite(log))])
    at = np.arange(n)
    wide = np.minimum(np.minimum(at, n - 1 - at), 4)
    low, high = at - wide, at + wide + 1
    mean = (total[high] - total[low]) / np.maximum(count[high] - count[low], 1)
    bias = float(special.digamma(freedom / 2) - np.log(freedom / 2))
    return np.where(np.isfinite(log), np.exp(mean - bias), np.inf)


class MeanLines(NamedTuple):
    """Lines of a period: frequency [Hz], mean complex amplitude of input [V] and position [m], which are driven; (n,).

    The driven lines may be known from the reference.
    """

    frequency: Real
    input: Complex
    position: Complex
    driven: Mask
    stated: bool


def excited(spectra: Spectra) -> Mask:
    """Return the driven lines of a periodic excitation.

    At a line that is not driven a closed loop shows the controller, encoder steps or friction's harmonics, which may
    repeat as exactly as the excitation. A driven line is tall among its neighbours in input and position together, not
    small against the input at any lower frequency, and above the noise. A line that is less than surely tall must take
    power from the voltage, ``Re(u*·jωz) > 0``: friction's harmonics bring it.
    """
    U, Z = (np.abs(np.mean(x, axis=0)) for x in (spectra.input, spectra.position))
    variance = np.var(spectra.input, axis=0, ddof=1) / len(spectra.input)
    noise = np.sqrt(ndimage.median_filter(variance, size=21, mode="nearest"))
    both = np.sqrt(U * Z)
    half_width = np.maximum(2, np.arange(len(U)) // 4)
    around = np.array([both[max(0, k - r) : k + r + 1].max() for k, r in enumerate(half_width)])
    power = np.real(1j * np.mean(spectra.position, axis=0) * np.mean(spectra.input, axis=0).conj())
    seen = (both > SURELY * around) | ((both > TALL * around) & (power > 0))
    return np.asarray(seen & (TALL * np.maximum.accumulate(U) < U) & (5 * noise < U))


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


def distortion(spectra: Spectra, driven: Mask) -> Real:
    """Return the relative deviation of each driven line due to periodic components that are not driven.

    Friction's harmonics and encoder steps repeat from period to period, and the scatter over periods does not show
    them. The lines between the driven lines do (Pintelon and Schoukens, System Identification, 2nd ed., section 4.3):
    they show the voltage ``|Z_j/G - U_j|``, with G between the driven lines; its median over the `QUIET` nearest lines
    j that are not driven, over U_k, is the error of line k. With fewer than four such lines it is not known: 0.
    """
    U, Z = np.mean(spectra.input, axis=0), np.mean(spectra.position, axis=0)
    at = np.flatnonzero(driven)
    inside = np.arange(len(U)) <= (at[-1] if len(at) else -1)
    quiet = np.flatnonzero(~driven & inside)
    found = np.zeros(len(at))
    if len(quiet) < 4 or np.any(U[at] == 0) or np.any(Z[at] == 0):
        return found
    f, log_G = np.log(spectra.frequency), np.log(Z[at] / U[at])
    G = np.exp(np.interp(f[quiet], f[at], log_G.real) + 1j * np.interp(f[quiet], f[at], np.unwrap(log_G.imag)))
    voltage = np.abs(Z[quiet] / G - U[quiet]) ** 2
    for n, k in enumerate(at):
        near = np.argsort(np.abs(f[quiet] - f[k]))[:QUIET] if len(quiet) > QUIET else slice(None)
        found[n] = np.sqrt(np.median(voltage[near]) / np.log(2.0) / 2) / np.abs(U[k])
    return found


@dataclass(frozen=True)
class MeasuredResponse:
    """A measured frequency response Z/U, with data on the experiment."""

    table: FrequencyResponse  # Frequency, magnitude, unwrapped phase, coherence and deviation
    method: Literal["periods", "segments", "table"]  # How it was averaged; a ``table`` was given
    description: str  # How it was estimated, in words
    averages: float  # Independent averages; 0 where a table does not state them
    correlation: float = 1.0  # Neighbouring lines per independent line (1 where they are independent)
    sampling: float | None = None  # Sampling rate of the record [Hz]; None for a table
    # Equivalent gain of Coulomb friction along the motion, ``mean(v'·sign(v))/mean(v'²)`` [s/m] with v' = v - mean(v):
    # a friction of F_c N damps the small motion like F_c times as much N·s/m. 0 where the motion never reverses; None
    # for a table.
    reversing: float | None = None
    speed: float | None = None  # Root mean square of v' [m/s]; None for a table
    sweeps: bool = False  # Whether the axis moves at one frequency at a time
    lines: MeanLines | None = None  # All lines of the excitation's period; None where it has none
    warnings: tuple[Notice, ...] = ()  # Warnings: what the record does not determine

    @property
    def response(self) -> Complex:
        """Z/U [m/V], shape (n,)."""
        return np.asarray(self.table.magnitude * np.exp(1j * self.table.phase))


def measure_response(
    record: Log | FrequencyResponse, *, period: float | None = None, segment: float | None = None,
    output: Literal["position", "force"] = "position", driven: Mask | None = None,
) -> MeasuredResponse:  # fmt: skip
    """Return the frequency response from control voltage to position (or to force) of one record.

    A periodic excitation (multisine, repeated sweep) is averaged over its periods, anything else over Welch's
    segments, with the reference as driver where it was logged and moves the axis. A table is used directly, with its
    phase unwrapped.

    record: A record in time with input and position, or a measured response.
    period: Period of the excitation [s]; found in the record where not given.
    segment: Length of a Welch segment [s]; where given, the record is not searched for periods.
    output: The channel that answers the input; of a force the magnitude is F/U [N/V].
    driven: Which lines of the period are driven, where that is known already.
    Raises FricError: When input or output were not logged, the record is unevenly sampled or too short, or nothing is
        excited.
    """
    if isinstance(record, FrequencyResponse):
        return _table(record)
    u = record.require("input", "a frequency response")
    z = record.require(output, "a frequency response")
    sampling = even_sampling(record)
    if np.ptp(u) == 0:
        raise FricError("the input does not move", where=record.where, hint="Log an excitation.")
    samples = round(period * sampling) if period is not None else _period(record, u) if segment is None else None
    if segment is not None or samples is None:
        return _over_segments(record, u, z, segment, sampling, integrates=output == "position")
    found = _over_periods(record, u, z, samples, sampling, driven)
    begin, end = _repeating(u, samples)
    if _certain(found) < 0.25 and end - begin >= 2 * samples:
        with suppress(FricError):  # a start and a stop that were logged, too
            part = _over_periods(record.slice(begin, end), u[begin:end], z[begin:end], samples, sampling, driven)
            return max(found, part, key=_certain)
    return found


def _certain(found: MeasuredResponse) -> float:
    return float(np.mean(np.asarray(found.table.coherence, float) >= 0.5))


def _repeating(u: Real, period: int) -> tuple[int, int]:
    """Return begin and end of the longest part of an input that repeats after a period, without start and stop."""
    apart = ndimage.uniform_filter1d((u[period:] - u[:-period]) ** 2, max(period // 4, 1))
    alike = apart <= np.sqrt(max(apart.min(), 1e-12 * apart.max()) * apart.max())
    edges = np.flatnonzero(np.diff(alike, prepend=False, append=False))
    begin, end = max(zip(edges[::2], edges[1::2], strict=True), key=lambda run: run[1] - run[0])
    return int(begin), int(end) + period


def _table(record: FrequencyResponse) -> MeasuredResponse:
    deviation, warnings = record.relative_deviation(), list[Notice]()
    if deviation is None:
        deviation = np.full(record.frequency.size, 1.0)
        warnings = [NO_COHERENCE.found()]
    table = replace(record, phase=np.unwrap(record.phase), deviation=deviation)
    return MeasuredResponse(table, "table", "a table", 0, warnings=tuple(warnings))


def _period(record: Log, u: Real) -> int | None:
    """Return the period of the excitation in samples: of the reference, if periodic, or of the input."""
    r, z = record.reference, record.position
    found = find_period(np.diff(r)) if r is not None and _accelerates(r) and _asks(r, z) else None
    return find_period(u) if found is None else found


def _asks(reference: Real, position: Real | None) -> bool:
    """Return whether a reference asks for a hundredth at least of the motion about a uniform motion, in the last half:
    a uniform motion that is rounded is periodic, too, and asks for nothing.
    """
    if position is None:
        return True
    asked, moved = (
        np.std(x - np.linspace(x[0], x[-1], len(x))) for x in (v[len(v) // 2 :] for v in (reference, position))
    )
    return bool(asked > LEAST_ASKED * moved)


def _accelerates(reference: Real) -> bool:
    """Return whether a reference is more than a uniform motion, apart from its rounding."""
    return bool(np.ptp(np.diff(reference, 2)) > 1e-9 * np.max(np.abs(reference)))


def _over_periods(record: Log, u: Real, z: Real, period: int, sampling: float, known: Mask | None) -> MeasuredResponse:
    with found_in(record.where):
        spectra = period_spectra(u, z, period, sampling)
    if known is None and record.reference is not None:
        known = _driven(record.reference, record.position, period)
    rounding, size = _repeated_rounding(spectra, z, period), np.abs(np.mean(spectra.position, axis=0))
    lines = excited(spectra) & (size > ABOVE_ROUNDING * rounding) if known is None else known
    if np.count_nonzero(lines) < 3:
        raise FricError("fewer than three frequencies are excited", where=record.where, hint="Excite more of them.")
    repeating = distortion(spectra, lines)
    U, Z = (np.mean(x, axis=0) for x in (spectra.input, spectra.position))
    mean_lines = MeanLines(spectra.frequency, U, Z, lines, stated=known is not None)
    spectra = spectra.at(lines)
    G, deviation, coherence = estimate(spectra)
    deviation = np.where(repeating > DISTORTED * deviation, np.hypot(repeating, deviation), deviation)
    deviation = np.hypot(deviation, rounding[lines] / np.sqrt(2.0) / np.maximum(size[lines], 1e-300))
    count = len(spectra.input)
    mean = np.zeros(period // 2 + 1, complex)
    mean[1 : len(lines) + 1][lines] = spectra.position.mean(axis=0) * 2j * np.pi * spectra.frequency * period
    text = f"quotient of averages over {count} periods of {period / sampling:.4g} s, {len(G)} lines; "
    text += "what the loop feeds back averages out"
    table = as_table(record, spectra.frequency, G, deviation, coherence)
    moved = _motion(fft.irfft(mean, period) + drift(z[-count * period :], period) * sampling)
    warnings = (FEW_PERIODS.found(periods=count),) if count < 4 else ()
    averages, correlation = spectra.averages, spectra.correlation
    return MeasuredResponse(table, "periods", text, averages, correlation, sampling, *moved, mean_lines, warnings)


def _repeated_rounding(spectra: Spectra, position: Real, period: int) -> Real:
    """Return the size of an encoder's rounding in each line [m] that all periods have alike, which none averages out.

    Rounding to steps of q is ``q²/12/N`` in each of N lines. Periods that begin at other places between two counts
    scatter by as much; what they scatter less is the same in each, and a loop answers it as if it were driven.
    """
    step = lattice_step(position) or 0.0
    scatter = ndimage.median_filter(np.var(spectra.position, axis=0, ddof=1), size=21, mode="nearest")
    return np.asarray(np.sqrt(np.maximum(step**2 / 12.0 / period - scatter, 0.0)))


def _driven(reference: Real, position: Real | None, period: int) -> Mask | None:
    """Return the lines that the reference drives; None where it drives none, but adds a slow motion."""
    if not (_accelerates(reference) and _asks(reference, position)):
        return None
    lines = np.abs(periods(reference, period))
    steady = lines.min(axis=0) > 0.5 * lines.max(axis=0)
    driven = steady & (lines.mean(axis=0) > 1e-3 * np.max(lines.mean(axis=0), where=steady, initial=0.0))
    return driven if np.count_nonzero(driven) >= 3 else None


def _over_segments(
    record: Log, u: Real, z: Real, segment: float | None, sampling: float, *, integrates: bool
) -> MeasuredResponse:
    length = len(u) // SEGMENTS if segment is None else round(segment * sampling)
    if length < 32 or 3 * length > 2 * len(u):
        what = f"a segment of {length} samples does not suit a record of {len(u)}"
        raise FricError(what, where=record.where, hint="Log a longer excitation, or give another `segment=`.")
    spectra, driver, text = segment_spectra(u, z, u, length, sampling, integrates), u, "the input as driver"
    if record.reference is not None and _accelerates(record.reference):
        joint = segment_spectra(u, z, record.reference, length, sampling, integrates)
        moved = joint.frequency[coherence_of(joint.driver, joint.input) > COHERENT]
        if moved.size >= 20 and moved.max() > 10 * moved.min():  # more than a slow motion added to the excitation
            spectra, driver = joint, record.reference
            text = "the reference as driver, so that what a closed loop feeds back averages out"
    manner = f"{len(spectra.input)} Welch segments of {length / sampling:.4g} s"
    if segment is None and swept(spectra.at(moved_at(spectra, is_input=driver is u))):
        spectra = neighbour_spectra(u, z, driver, sampling, integrates)
        manner = f"a single sweep, averaged over {len(spectra.input)} neighbouring lines"
    spectra = spectra.at(moved_at(spectra, is_input=driver is u))
    G, deviation, coherence = estimate(spectra)
    sure = spectra.frequency[coherence > COHERENT]
    top = min(float(sure.max()) if sure.size else 0.1 * sampling, 0.4 * sampling)
    smooth = zero_phase(butterworth(top, sampling), z, 4)
    return MeasuredResponse(
        as_table(record, spectra.frequency, G, deviation, coherence), "segments", f"{manner}, {text}",
        spectra.averages, spectra.correlation, sampling, *_motion(np.gradient(smooth, 1 / sampling)), None,
        (LOOP_FEEDS_BACK.found(),) if driver is u else (),
    )  # fmt: skip


def as_table(record: Log, frequency: Real, G: Complex, deviation: Real, coherence: Real) -> FrequencyResponse:
    """Return a response as the table of a record, without the lines at which it was not found (0)."""
    about = {name: getattr(record, name) for name in ("name", "axis", "motion", "source", "sha256")}
    unknown, found = np.nan_to_num(deviation, nan=UNKNOWN, posinf=UNKNOWN), np.abs(G) > 0
    columns = (frequency, np.abs(G), np.angle(G), coherence, unknown)
    f, magnitude, phase, coherence, unknown = (column[found] for column in columns)
    return FrequencyResponse(f, magnitude, np.unwrap(phase), coherence, unknown, **about)


def _motion(v: Real) -> tuple[float, float, bool]:
    """Return the equivalent gain of Coulomb friction along a velocity, its deviation, and whether it is a sweep."""
    around, stretches = v - v.mean(), [part - part.mean() for part in np.array_split(v, STRETCHES)]
    sizes = [np.mean(np.abs(part)) / max(float(part.std()), 1e-300) for part in stretches]
    gain = float(np.mean(around * np.sign(v)) / np.mean(around**2)) if v.min() <= 0 <= v.max() and v.any() else 0.0
    return gain, float(np.std(v)), bool(np.median(sizes) > SINE)
