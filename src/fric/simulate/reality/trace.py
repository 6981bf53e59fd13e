"""What a drive's trace keeps of a run: averaged, late, jittered, quantised, with noise, as its flaws make it."""

from collections.abc import Callable
from dataclasses import replace
from hashlib import sha256
from math import ceil
from zlib import crc32

import numpy as np
from scipy.interpolate import CubicSpline

from fric.arrays import Real
from fric.columns import Kind
from fric.drive.sensing import low_pass_pole, low_passed
from fric.kernels.sensing import read
from fric.log import Log
from fric.simulate.axis import Trace
from fric.simulate.machine import Axis
from fric.simulate.reality.flaws import NoiseColour
from fric.simulate.reality.motion import sensing_of

PIECE = 1_000_000  # Samples of a run that a spline goes through at once: it takes 100 bytes a sample
FORGOTTEN = 64  # Samples after which a cubic spline has forgotten a value: each leaves 0.27 of it


def logged(axis: Axis, run: Trace, window: tuple[int, int], samples: int, name: str, kind: Kind, seed: int) -> Log:
    """Log a run as the axis' drive does.

    The trace keeps every n-th sample, with n such that it holds the window; voltage and force are averaged over that
    interval, as the drive's trace filter does, so that the controller's response to encoder steps does not alias into
    them, and are kept in single precision.

    axis: The axis, with the flaws of its force channel, its clock and its encoder.
    seed: Seed of the noise, of the jitter and of what is lost; with the name of the record.
    """
    first, last = window
    sampling, flaws = axis.cascade.sampling, axis.reality
    divider = ceil((last - first) / samples)
    even = np.arange(first, last, divider, dtype=float)
    count, key = len(even), [seed, crc32(name.encode())]
    noise = np.random.default_rng(key).normal(0.0, 1.0, count) * axis.force_noise
    rng = np.random.default_rng([*key, 1])
    off = rng.normal(0.0, 1.0, count) * (flaws.clock.jitter * sampling)
    taken = even + np.clip(off, -0.45 * divider, 0.45 * divider)  # never so far that two change places
    late = flaws.clock.position * sampling
    driven = _driven(axis, run.input) if axis.second_mass is None else None
    sensed = _between(run.position if run.sensed is None else run.sensed, taken - late, driven)
    read(sensed, axis.encoder.resolution, sensing_of(axis))
    voltage = _averaged(run.input, taken - flaws.clock.input * sampling, divider)
    behind = low_passed(run.input, flaws.force.filter, sampling)
    force = axis.plant.K_f * _averaged(behind, taken - flaws.force.lag * sampling, divider) + noise
    if flaws.noise is not None:
        force += _coloured(rng, count, flaws.noise, sampling / divider)
    stamp = (taken if flaws.clock.stamped else even) - first
    kept = np.ones(count, dtype=bool)
    if flaws.clock.lost:  # the first and the last sample never are
        kept[1:-1] = rng.uniform(size=count - 2) >= flaws.clock.lost
    log = Log(
        time=(stamp[kept] if flaws.clock.stamped else stamp[: kept.sum()]) / sampling,
        position=sensed[kept],
        force=_single(np.rint(force / step) * step if (step := flaws.force.step) else force)[kept],
        input=_single(voltage)[kept], reference=_between(run.reference, taken)[kept], name=name, kind=kind,
        axis=axis.name, motion=axis.motion,
    )  # fmt: skip
    return replace(log, sha256=sha256(b"".join(values.tobytes() for values in log.channels().values())).hexdigest())


def _averaged(values: Real, at: Real, width: int) -> Real:
    """Return the mean of ``width`` values, each held for a sample, around each of the places."""
    sums, n = np.concatenate([[0.0], np.cumsum(values)]), len(values)
    at = np.maximum(at, 0.0)
    start, stop = np.clip(at - width // 2, 0, n), np.clip(at - width // 2 + width, 0, n)
    up_to = np.interp(np.concatenate([start, stop]), np.arange(n + 1), sums)
    return np.asarray((up_to[len(at) :] - up_to[: len(at)]) / (stop - start))


def _between(values: Real, at: Real, part: Callable[[Real], Real] | None = None) -> Real:
    """Return values at places between the samples, on the cubic spline through them; at a sample the value itself.

    Of a part that is known at every place the spline has no share.
    """
    at = np.clip(at, 0, len(values) - 1)
    if np.array_equal(at, np.rint(at)):
        return np.asarray(values[at.astype(np.int64)])
    pieces = np.array_split(at, ceil(len(values) / PIECE))
    return np.concatenate([_splined(values, piece, part) for piece in pieces if len(piece)])


def _splined(values: Real, at: Real, part: Callable[[Real], Real] | None) -> Real:
    """Return values at rising places on the spline through the samples around them: it forgets the others' values."""
    first, last = max(int(at.min()) - FORGOTTEN, 0), int(at.max()) + FORGOTTEN
    near = values[first:last]
    n = np.arange(first, first + len(near), dtype=float)
    if part is None:
        return np.asarray(CubicSpline(n, near)(at))
    return np.asarray(CubicSpline(n, near - part(n))(at) + part(at))


def _driven(axis: Axis, voltage: Real) -> Callable[[Real], Real]:
    """Return the effect of a held voltage (n,) on the position [m], over places in samples, ``B·∬u(t - τ)``: its second
    derivative has steps, and no spline has them (0.4 % of magnitude, 3 mrad at an eighth of the sampling rate).
    """
    speed = np.concatenate([[0.0], np.cumsum(voltage)[:-1]])
    swept = np.concatenate([[0.0], np.cumsum(speed + 0.5 * voltage)[:-1]])
    size = axis.plant.B / axis.cascade.sampling**2
    delay = axis.plant.transport_delay(axis.cascade.sampling) * axis.cascade.sampling

    def added(at: Real) -> Real:
        x = np.maximum(at - delay, 0.0)
        k = np.minimum(x.astype(np.int64), len(voltage) - 1)
        return np.asarray(size * (swept[k] + (x - k) * (speed[k] + 0.5 * (x - k) * voltage[k])))

    return added


def _coloured(rng: np.random.Generator, count: int, noise: NoiseColour, sampling: float) -> Real:
    """Return noise that remembers, in its steady state from the first sample on."""
    from scipy.signal import lfilter

    p = low_pass_pole(noise.corner, sampling)
    white = rng.normal(size=count)
    white[1:] *= np.sqrt(1.0 - p * p)
    return noise.force * np.asarray(lfilter([1.0], [1.0, -p], white))


def _single(values: Real) -> Real:
    return values.astype(np.float32).astype(np.float64)
