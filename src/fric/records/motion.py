"""The motion behind a quantised position, between encoder counts, and its reversals; zero-phase filters."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from fric.arrays import Indices, Mask, Real
from fric.errors import FricError
from fric.log import Log
from fric.records.resolution import encoder_step, lattice_step, noise_level

DEGREE = 5  # Degree of the spline, with a smooth acceleration and a parabola at a reversal within a count
MOST_KNOTS = 20_000  # Largest number of knots of a record; between knots the motion cannot reverse
REST = 4  # Number of samples without a count after which the level itself is used, repeatedly
REFINED = 8  # Largest number of solutions of a spline, which is refined until rounding is below its spread
CONVERGED = 1e-3  # Correction, over the usual spread, below which refinement ends
FINE = 0.01  # Share of the travel of a sample under which the encoder's step does not matter
LARGE = 0.2  # Change of the acceleration from sample to sample, relative to its root mean square, that counts as one
OUTLIES = 6.0  # Ratio of such a change to the usual change, which noise makes
HIDDEN = 0.05  # Share of such changes in the variance of the acceleration from which on a record is too slow for it
BANDWIDTH = 20.0  # Bandwidth of a motion under a position loop [Hz]; the filters leave room above it


@dataclass(frozen=True)
class Motion:
    """A motion without the encoder's steps, arrays of shape (n,)."""

    time: Real  # Sample instants [s]
    position: Real  # [m]
    velocity: Real  # [m/s]
    acceleration: Real  # [m/s²]
    step: float  # The encoder's step [m]; 0 where none is visible


def smooth_motion(time: Real, position: Real) -> Motion:
    """Return the smoothest motion that an encoder would have logged as this position.

    At the instant of a count the position is known far better than the count itself: it is half way between two levels,
    to within ``v·dt/√12``. The spline that minimises its jerk while it meets these crossings as closely as they are
    known (the discrepancy principle of Morozov: reduced chi² of 1) has no phase lag and no bias towards the levels.
    Friction needs this: with k_1 = 1e8 N/m a count of 0.25 µm is a step of 25 N.

    A position without a lattice is smoothed by its noise instead, and a position without noise is not changed.

    Raises FricError: When the position moves by fewer than eight counts.
    """
    t, z = np.asarray(time, float), np.asarray(position, float)
    dt, step = float(np.median(np.diff(t))), encoder_step(z)
    if not (moved := np.abs(np.diff(z))).any():
        raise FricError("the position does not move", hint="Log a motion of many encoder steps.")
    if step < FINE * float(np.median(moved[moved > 0])):
        step = 0.0
    if step:
        if len(counted := np.flatnonzero(np.diff(z))) < 2 * DEGREE:
            hint = "Log a motion of many encoder steps."
            raise FricError(f"the position hardly moves: {np.ptp(z) / step:.0f} steps of the encoder", hint=hint)
        instant, crossing = 0.5 * (t[counted] + t[counted + 1]), 0.5 * (z[counted] + z[counted + 1])
        several = np.abs(np.diff(z)[counted]) > 1.5 * step
        speed = np.abs(np.gradient(crossing, instant))
        spread = np.sqrt((speed * dt) ** 2 / 12 + several * step**2 / 24 + (1e-3 * step) ** 2)
        spread = np.where(several, np.minimum(spread, step / np.sqrt(24)), spread)
        spread = np.where(_flickers(np.diff(z)[counted]), step / np.sqrt(12), spread)
        rests = _rests(t, z, counted, step)
        instant, crossing, spread = (np.append(a, b) for a, b in zip((instant, crossing, spread), rests, strict=True))
    else:
        if (noise := noise_level(z)) < 1e-7 * np.ptp(z):
            v = slope(t, z)
            return Motion(t, z, v, slope(t, v), 0.0)
        instant, crossing, spread = t, z, np.full_like(z, noise)
    spline = _smoothest(t, instant, crossing, spread, max(dt, (t[-1] - t[0]) / MOST_KNOTS))
    return Motion(t, spline(t), spline(t, 1), spline(t, 2), step)


def between_samples(position: Real) -> Mask:
    """Return the samples at which the speed changes between samples, shape (n,); none where few do.

    A ramp that lasts a sample or two shows neither its acceleration nor when the motion began: there, neighbours do not
    predict the acceleration. In a record at a sufficient rate they do, but for noise and steps of the encoder.
    """
    bends, hidden = np.diff(position, 2), np.zeros(len(position), bool)
    if len(bends) < 3:
        return hidden
    change, size = 0.5 * np.abs(np.diff(bends, 2)), float(np.mean(bends**2))
    large = change > max(LARGE * np.sqrt(size), OUTLIES * float(np.median(change)), REST * encoder_step(position))
    if (change[large] ** 2).sum() > HIDDEN * size * len(bends):
        hidden[2:-2] = large
        hidden = np.convolve(hidden, np.ones(3), "same") > 0.0  # the slope takes in a sample on each side
    return hidden


def shows_mass(motion: Motion, used: Mask) -> bool:
    """Return whether samples that are used have an acceleration beyond the error that `between_samples` leaves."""
    squares = motion.acceleration**2
    return bool(used.any() and squares[used].mean() >= (2.0 * LARGE) ** 2 * squares.mean())


def local_motion(time: Real, position: Real) -> Motion:
    """Return the motion of samples by central differences, so that a change between samples stays where it is."""
    v = np.gradient(position, time)
    a = np.gradient(v, time)
    a[1:-1] = 2.0 * np.diff(np.diff(position) / np.diff(time)) / (time[2:] - time[:-2])
    return Motion(time, position, v, a, 0.0)


def slope(t: Real, z: Real) -> Real:
    """Return the derivative of exact samples, by the polynomial of fourth degree through five samples around each.

    Second order is not enough for friction: a velocity error of a thousandth shifts the instant of a reversal. Where a
    sample equals both neighbours, the motion rests and the derivative is zero.

    t, z: Instants, increasing, and samples, each of shape (n,).
    """
    if (n := len(t)) < 5:
        return np.asarray(np.gradient(z, t, edge_order=2 if n > 2 else 1))
    first = np.clip(np.arange(n) - 2, 0, n - 5)
    around = first[:, None] + np.arange(5)
    away, found, rows, here = t[around] - t[:, None], np.zeros(n), np.arange(n), np.arange(n) - first
    for j in range(5):
        # of Lagrange's polynomials: l_j'(t_i) = prod(m != i, j) (t_i - t_m) / prod(m != j) (t_j - t_m)
        others = -away
        others[rows, here], others[:, j] = 1.0, 1.0
        apart = np.prod(away[:, [j]] - np.delete(away, j, axis=1), axis=1)
        found += np.prod(others, axis=1) / apart * (z[around[:, j]] - z)
    found[1:-1][(z[1:-1] == z[:-2]) & (z[1:-1] == z[2:])] = 0.0
    return found


def _flickers(counts: Real) -> Mask:
    """Return the counts of a flicker: a count against the direction of both neighbours, and these neighbours."""
    turned, alone = np.diff(np.sign(counts)) != 0, np.zeros(len(counts), dtype=bool)
    alone[1:-1] = turned[1:] & turned[:-1]
    alone[1:] |= alone[:-1]
    alone[:-1] |= alone[1:]
    return alone


def _rests(t: Real, z: Real, counted: Indices, step: float) -> tuple[Real, Real, Real]:
    """Return instants, levels and spreads without counts, on a level within ±step/2: they keep the spline there."""
    bounds = np.concatenate([[0], counted + 1, [len(z)]])
    number = np.diff(bounds) // REST
    order = np.arange(number.sum()) - np.repeat(np.cumsum(number) - number, number)
    place = np.repeat(bounds[:-1], number) + REST // 2 + REST * order
    return t[place], z[place], np.full(len(place), step / np.sqrt(12))


def _smoothest(t: Real, instant: Real, value: Real, spread: Real, knot: float) -> Any:
    """Return the spline of least jerk whose distance from the values is their spread (a P-spline)."""
    from scipy import sparse  # not at the start: who reads a friction file does without
    from scipy.interpolate import BSpline
    from scipy.linalg import cho_solve_banded, cholesky_banded

    knots = t[0] + knot * np.arange(-DEGREE, int(np.ceil((t[-1] - t[0]) / knot)) + DEGREE + 1)
    unit = float(np.median(spread))
    inside = np.clip(instant, knots[DEGREE], knots[-DEGREE - 1])  # an end may be beyond by its last digit
    basis: Any = BSpline.design_matrix(inside, knots, DEGREE)
    weight = (unit / spread) ** 2
    across = basis.T
    normal: Any = across @ sparse.diags_array(weight) @ basis
    size = normal.shape[0]
    third: Any = sparse.diags_array([[-1.0], [3.0], [-3.0], [1.0]], offsets=[0, 1, 2, 3], shape=(size - 3, size))
    back, middle = third.T, float(np.mean(value))
    wanted = (value - middle) / unit
    banded, penalty = _upper(normal), _upper(back @ third)

    smoothest, met = None, False
    low, high = -6.0, 14.0
    for _ in range(12):
        exponent = 0.5 * (low + high)
        try:
            factor = cholesky_banded(banded + 10.0**exponent * penalty)
        except np.linalg.LinAlgError:  # too little penalty to bridge a rest
            low = exponent
            continue
        solved = np.zeros(size)
        for _ in range(REFINED):
            left = across @ (weight * (wanted - basis @ solved)) - 10.0**exponent * (back @ (third @ solved))
            correction = np.asarray(cho_solve_banded((factor, False), left))
            solved = solved + correction
            if np.abs(correction).max() < CONVERGED:
                break
        chi2 = float(np.mean(weight * (wanted - basis @ solved) ** 2))
        if chi2 <= 1.0 or not met:  # what no spline of these knots meets is met as closely as any does
            smoothest, met = solved, chi2 <= 1.0
        low, high = (low, exponent) if chi2 > 1.0 else (exponent, high)
    if smoothest is None:
        raise FricError("the position jumps more than it moves", hint="Look at the log with `fric inspect`.")
    return BSpline(knots, middle + unit * smoothest, DEGREE)


def _upper(matrix: Any) -> Real:
    """Return the upper bands of a symmetric matrix for `scipy.linalg.solveh_banded`."""
    bands = np.zeros((DEGREE + 1, matrix.shape[0]))
    for offset in range(DEGREE + 1):
        bands[DEGREE - offset, offset:] = matrix.diagonal(offset)
    return bands


@dataclass(frozen=True)
class Conditioning:
    """Filter and decimation of a record before the fit."""

    # Corner of the fourth-order Butterworth filter, run forwards and backwards over the position [Hz]; 0 for no filter
    cutoff: float
    decimation: int  # Every n-th sample is kept, after a zero-phase Chebyshev filter over each column of the fit
    border: int  # Samples left out at the start of a record, where filter and differences see its edge

    @classmethod
    def of(
        cls, sampling: float, cutoff: float | None = None, decimation: int | None = None, border: int | None = None
    ) -> Self:
        """Return the settings, with defaults for a sampling rate [Hz].

        The corner is five times the bandwidth of the motion, so that the filter leaves its acceleration alone; the
        decimated signals reach to twice that bandwidth, and 4.9 periods of the corner are left out at the start.
        """
        cutoff = min(5 * BANDWIDTH, 0.2 * sampling) if cutoff is None else cutoff
        if not 0 < cutoff < sampling / 2:
            what = f"the cut-off of {cutoff:g} Hz is not between 0 and half the sampling rate ({sampling / 2:g} Hz)"
            raise FricError(what)
        decimation = max(1, round(0.8 * sampling / 2 / (2 * BANDWIDTH))) if decimation is None else decimation
        border = round(4.9 * sampling / cutoff) if border is None else border
        return cls(cutoff, decimation, border)


def filtered_motion(log: Log, settings: Conditioning) -> Motion:
    """Return a record's motion behind the filter of the published fit, by central differences.

    log: An evenly sampled record with a position or a velocity.
    """
    dt = float(log.time[-1] - log.time[0]) / (len(log) - 1)
    if len(log) < (needed := settings.border + 30 * settings.decimation):
        hint = f"Log a motion of {needed * dt:.2g} s or more, or give a smaller `decimation=`."
        raise FricError(f"{len(log)} samples are too few: {needed} are needed", where=log.where, hint=hint)
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
    """Return every n-th sample, including the last, after a zero-phase Chebyshev filter.

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
    """Return the indices of the n samples that `thinned` keeps."""
    return slice((n - 1) % decimation, None, decimation)


def zero_phase(sos: Real, values: Real, order: int) -> Real:
    """Return the values filtered forwards and backwards, their edges mirrored over three times the order.

    Raises FricError: When there are no more values than that.
    """
    from scipy import signal

    if len(values) <= 3 * order:
        raise FricError(f"{len(values)} samples are too few for a filter", hint=f"It takes {3 * order + 1} at least.")
    return np.asarray(signal.sosfiltfilt(sos, values, padlen=3 * order))


def find_reversals(position: Real, threshold: float | None = None) -> Indices:
    """Return the samples at which a motion reverses, in order of time.

    A reversal is an extreme from which the motion returns by more than the threshold, which excludes the flicker of an
    encoder. If the extreme lasts (a dwell, a flat crest of counts), its middle is returned.

    threshold: Travel back [m] that makes a reversal; where it is not given, two counts of the encoder, or the swing of
        white noise over n samples, 2·√(2·ln n) standard deviations (Leadbetter et al., Extremes, 1983), and a tenth.
    """
    if len(z := np.asarray(position, float)) < 3:
        return np.zeros(0, dtype=np.intp)
    count = lattice_step(z) or 0.0
    if threshold is None:
        swing = 2.2 * float(np.sqrt(2.0 * np.log(len(z)))) * noise_level(z)
        threshold = max(2.0 * count, swing, 1e-9 * float(np.ptp(z)))
    flat = 0.5 * count
    found: list[int] = []
    direction, begin = 0, 0
    while (reversal := _next_reversal(z, begin, direction, threshold)) is not None:
        extreme, passed, turned = reversal
        if direction:
            level = np.flatnonzero(np.abs(z[begin:passed] - z[extreme]) <= flat) + begin
            found.append(int(level[0] + level[-1]) // 2)
        direction, begin = turned, extreme
    return np.array(found, dtype=np.intp)


def _next_reversal(z: Real, begin: int, direction: int, threshold: float) -> tuple[int, int, int] | None:
    """Return the extreme after ``begin``, the sample that is past it by the threshold, and the direction from there."""
    stop, block = begin, 1024
    high = low = z[begin]
    at_high = at_low = begin
    while stop < len(z):
        start, stop = stop, min(stop + block, len(z))
        part = z[start:stop]
        highest = np.maximum(np.maximum.accumulate(part), high)
        lowest = np.minimum(np.minimum.accumulate(part), low)
        down = np.flatnonzero(highest - part > threshold) if direction >= 0 else np.zeros(0, int)
        up = np.flatnonzero(part - lowest > threshold) if direction <= 0 else np.zeros(0, int)
        first_down, first_up = (int(k[0]) if len(k) else len(part) for k in (down, up))
        k = min(first_down, first_up)
        seen = part[: k + 1]
        if seen.max() > high:
            high, at_high = seen.max(), start + int(seen.argmax())
        if seen.min() < low:
            low, at_low = seen.min(), start + int(seen.argmin())
        if k < len(part):
            return (at_high, start + k, -1) if first_down < first_up else (at_low, start + k, 1)
        block *= 2
    return None
