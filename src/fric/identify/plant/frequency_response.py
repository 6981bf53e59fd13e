"""The empirical frequency response of an excited axis, and its uncertainty."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy import fft

from fric.arrays import Complex, Mask, Real
from fric.errors import FricError
from fric.flaws.response import FEW_PERIODS, LOOP_FEEDS_BACK, NO_COHERENCE
from fric.identify.plant.spectra import (
    MeanLines,
    coherence_of,
    distortion,
    drift,
    estimate,
    excited,
    find_period,
    moved_at,
    neighbour_spectra,
    period_spectra,
    periods,
    segment_spectra,
    swept,
)
from fric.log import FrequencyResponse, Log
from fric.notice import Notice
from fric.records.motion import butterworth, zero_phase
from fric.records.timing import even_sampling

SEGMENTS = 8
"""Length of the record over that of a Welch segment, unless another is given."""


DISTORTED = 1.5
"""Ratio to the noise of a line above which the periodic part at its neighbours is more than noise."""
COHERENT = 0.5
"""Coherence above which a signal counts as driven by another."""


UNKNOWN = 1e9
"""Relative deviation of a line without an estimate of its noise: its weight is practically 0."""


@dataclass(frozen=True)
class MeasuredResponse:
    """A measured frequency response Z/U, with data on the experiment."""

    table: FrequencyResponse  # Frequency, magnitude, unwrapped phase, coherence and deviation
    # Averaged over ``periods`` or ``segments``, or given as a ``table``
    method: Literal["periods", "segments", "table"]
    description: str  # How it was estimated, in words
    averages: float  # Independent averages; 0 where a table does not state them
    correlation: float = 1.0  # Neighbouring lines per independent line (1 where they are independent)
    sampling: float | None = None  # Sampling rate of the record [Hz]; None for a table
    # Equivalent gain of Coulomb friction along the motion, ``mean(v'·sign(v))/mean(v'²)`` [s/m] with v' = v - mean(v):
    # a friction of F_c N damps the small motion like F_c times as much N·s/m. 0 where the motion never reverses; None
    # for a table.
    reversing: float | None = None
    speed: float | None = None  # Root mean square of v' [m/s]; None for a table
    lines: MeanLines | None = None  # All lines of the excitation's period; None where it has none
    warnings: tuple[Notice, ...] = ()  # Warnings: what the record does not determine

    @property
    def response(self) -> Complex:
        """Z/U [m/V], shape (n,)."""
        return np.asarray(self.table.magnitude * np.exp(1j * self.table.phase))


def measure_response(
    record: Log | FrequencyResponse,
    *,
    period: float | None = None,
    segment: float | None = None,
    output: Literal["position", "force"] = "position",
    driven: Mask | None = None,
) -> MeasuredResponse:
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
    if segment is None:
        samples = _period(record, u) if period is None else round(period * sampling)
        if samples is not None:
            return _over_periods(record, u, z, samples, sampling, driven)
    return _over_segments(record, u, z, segment, sampling)


def _table(record: FrequencyResponse) -> MeasuredResponse:
    deviation, warnings = record.relative_deviation(), list[Notice]()
    if deviation is None:
        deviation = np.full(record.frequency.size, 1.0)
        warnings = [NO_COHERENCE.found()]
    table = replace(record, phase=np.unwrap(record.phase), deviation=deviation)
    return MeasuredResponse(table, "table", "a table", 0, warnings=tuple(warnings))


def _period(record: Log, u: Real) -> int | None:
    """Return the period of the excitation in samples: of the reference, if periodic, or of the input."""
    r = record.reference
    found = find_period(np.diff(r)) if r is not None and _accelerates(r) else None
    return find_period(u) if found is None else found


def _accelerates(reference: Real) -> bool:
    """Return whether a reference is more than a uniform motion, apart from its rounding."""
    return bool(np.ptp(np.diff(reference, 2)) > 1e-9 * np.max(np.abs(reference)))


def _over_periods(record: Log, u: Real, z: Real, period: int, sampling: float, known: Mask | None) -> MeasuredResponse:
    try:
        spectra = period_spectra(u, z, period, sampling)
    except FricError as error:
        raise error.at(record.where) from None
    if known is None and record.reference is not None:
        known = _driven(record.reference, period)
    lines = excited(spectra, known)
    if np.count_nonzero(lines) < 3:
        raise FricError("fewer than three frequencies are excited", where=record.where, hint="Excite more of them.")
    repeating = distortion(spectra, lines)
    U, Z = (np.mean(x, axis=0) for x in (spectra.input, spectra.position))
    mean_lines = MeanLines(spectra.frequency, U, Z, lines, stated=known is not None)
    spectra = spectra.at(lines)
    G, deviation, coherence = estimate(spectra)
    deviation = np.where(repeating > DISTORTED * deviation, np.hypot(repeating, deviation), deviation)
    count = len(spectra.input)
    mean = np.zeros(period // 2 + 1, complex)
    mean[1 : len(lines) + 1][lines] = spectra.position.mean(axis=0) * 2j * np.pi * spectra.frequency * period
    return MeasuredResponse(
        as_table(record, spectra.frequency, G, deviation, coherence),
        "periods",
        f"quotient of averages over {count} periods of {period / sampling:.4g} s, {len(G)} lines; "
        "what the loop feeds back averages out",
        spectra.averages,
        spectra.correlation,
        sampling,
        *_motion(fft.irfft(mean, period) + drift(z[-count * period :], period) * sampling),
        mean_lines,
        (FEW_PERIODS.found(periods=count),) if count < 4 else (),
    )


def _driven(reference: Real, period: int) -> Mask | None:
    """Return the lines that the reference drives; None where it drives none, but adds a slow motion."""
    if not _accelerates(reference):
        return None
    lines = np.abs(periods(reference, period))
    steady = lines.min(axis=0) > 0.5 * lines.max(axis=0)
    driven = steady & (lines.mean(axis=0) > 1e-3 * np.max(lines.mean(axis=0), where=steady, initial=0.0))
    return driven if np.count_nonzero(driven) >= 3 else None


def _over_segments(record: Log, u: Real, z: Real, segment: float | None, sampling: float) -> MeasuredResponse:
    length = len(u) // SEGMENTS if segment is None else round(segment * sampling)
    if length < 32 or 3 * length > 2 * len(u):
        raise FricError(
            f"a segment of {length} samples does not suit a record of {len(u)}",
            where=record.where,
            hint="Log a longer excitation, or give another `segment=`.",
        )
    spectra, driver, text = segment_spectra(u, z, u, length, sampling), u, "the input as driver"
    if record.reference is not None and _accelerates(record.reference):
        joint = segment_spectra(u, z, record.reference, length, sampling)
        moved = joint.frequency[coherence_of(joint.driver, joint.input) > COHERENT]
        if moved.size >= 20 and moved.max() > 10 * moved.min():  # more than a slow motion added to the excitation
            spectra, driver = joint, record.reference
            text = "the reference as driver, so that what a closed loop feeds back averages out"
    manner = f"{len(spectra.input)} Welch segments of {length / sampling:.4g} s"
    if segment is None and swept(spectra.at(moved_at(spectra, is_input=driver is u))):
        spectra = neighbour_spectra(u, z, driver, sampling)
        manner = f"a single sweep, averaged over {len(spectra.input)} neighbouring lines"
    spectra = spectra.at(moved_at(spectra, is_input=driver is u))
    G, deviation, coherence = estimate(spectra)
    sure = spectra.frequency[coherence > COHERENT]
    top = min(float(sure.max()) if sure.size else 0.1 * sampling, 0.4 * sampling)
    smooth = zero_phase(butterworth(top, sampling), z, 4)
    return MeasuredResponse(
        as_table(record, spectra.frequency, G, deviation, coherence),
        "segments",
        f"{manner}, {text}",
        spectra.averages,
        spectra.correlation,
        sampling,
        *_motion(np.gradient(smooth, 1 / sampling)),
        None,
        (LOOP_FEEDS_BACK.found(),) if driver is u else (),
    )


def as_table(record: Log, frequency: Real, G: Complex, deviation: Real, coherence: Real) -> FrequencyResponse:
    """Return a response as the table of a record."""
    about = {name: getattr(record, name) for name in ("name", "axis", "motion", "source", "sha256")}
    unknown = np.nan_to_num(deviation, nan=UNKNOWN, posinf=UNKNOWN)
    return FrequencyResponse(frequency, np.abs(G), np.unwrap(np.angle(G)), coherence, unknown, **about)


def _motion(v: Real) -> tuple[float, float]:
    """Return the equivalent gain of Coulomb friction along a velocity, and the velocity's deviation from its mean."""
    around = v - v.mean()
    if v.min() > 0 or v.max() < 0 or not np.any(around):
        return 0.0, float(np.std(v))
    return float(np.mean(around * np.sign(v)) / np.mean(around**2)), float(np.std(v))
