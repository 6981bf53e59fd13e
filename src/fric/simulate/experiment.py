"""The paper's identification experiments on a virtual axis, in closed loop, as a drive logs them."""

from __future__ import annotations

from dataclasses import replace
from hashlib import sha256
from inspect import signature
from math import ceil
from typing import TYPE_CHECKING
from zlib import crc32

import numpy as np

from fric.compensation.feedforward import inverse_model
from fric.errors import FricError
from fric.log import Kind, Log
from fric.reference import Reference, multisine, sine, sliding_sine, strokes
from fric.simulate.axis import run_axis

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from numpy.typing import NDArray

    from fric.simulate.machine import Axis

EXPERIMENTS: tuple[Kind, ...] = ("constant-velocity", "presliding-sine", "sliding-sine", "frequency-response")
"""The kinds of record that can be made."""

SPEEDS = tuple(v * 1e-3 for v in (0.01, 0.04, 0.08, 0.2, 0.4, 0.5, 1, 2, 4, 5, 8, 10, 14, 16, 20, 25, 30))
"""The 17 speeds of Section 3.1 [m/s]."""

AMPLITUDES = (15e-6, 450e-6)
"""The amplitudes of Section 3.2.1 [m]."""


def constant_velocity(
    axis: Axis, *, speeds: Sequence[float] = SPEEDS, distance: float = 0.5e-3, samples: int = 4096, seed: int = 0
) -> list[Log]:
    """Return one record a speed: a stroke, a rest, and the stroke back.

    Parameters
    ----------
    axis
        The axis.
    speeds
        Speeds [m/s].
    distance
        Least length of a stroke at its speed [m]: long enough to leave pre-sliding behind. A stroke lasts one second
        or more.
    samples
        Samples that the drive's trace holds: a longer run is logged at a whole fraction of the controller's rate.
    seed
        Seed of the force channel's noise.
    """
    return [
        _record(
            axis,
            strokes(speed, max(distance, abs(speed)), axis.cascade.sampling),
            name=f"constant-velocity-{n:02d}",
            kind="constant-velocity",
            samples=samples,
            seed=seed,
        )
        for n, speed in enumerate(speeds, 1)
    ]


def presliding_sine(
    axis: Axis,
    *,
    amplitudes: Sequence[float] = AMPLITUDES,
    frequency: float = 0.1,
    cycles: int = 5,
    samples: int = 4096,
    seed: int = 0,
) -> list[Log]:
    """Return one record an amplitude: whole cycles of a slow sine, logged once it has run in.

    Parameters
    ----------
    axis
        The axis.
    amplitudes
        Amplitudes [m].
    frequency
        Frequency [Hz], low enough that inertia does not matter.
    cycles
        Cycles that are logged.
    samples, seed
        As in `constant_velocity`.
    """
    return [
        _record(
            axis,
            sine(amplitude, frequency, cycles, axis.cascade.sampling),
            name=f"presliding-sine-{n:02d}",
            kind="presliding-sine",
            begin=1 / frequency,
            samples=samples,
            seed=seed,
        )
        for n, amplitude in enumerate(amplitudes, 1)
    ]


def sliding_sine_around(
    axis: Axis,
    *,
    mean: float = 2e-3,
    swing: float = 1.5e-3,
    frequency: float = 4.0,
    cycles: int = 20,
    samples: int = 8192,
    seed: int = 0,
) -> list[Log]:
    """Return one record of sliding at a velocity that swings around a mean, which shows the frictional lag.

    Parameters
    ----------
    axis
        The axis.
    mean, swing
        Mean and amplitude of the velocity [m/s].
    frequency
        Frequency of the velocity [Hz].
    cycles
        Cycles that are logged.
    samples, seed
        As in `constant_velocity`.
    """
    return [
        _record(
            axis,
            sliding_sine(mean, swing, frequency, cycles, axis.cascade.sampling),
            name="sliding-sine",
            kind="sliding-sine",
            begin=2 / frequency,
            end=(cycles + 2) / frequency,
            samples=samples,
            seed=seed,
        )
    ]


def frequency_response(
    axis: Axis,
    *,
    mean: float = 30e-3,
    peaks: Sequence[float] | None = None,
    lowest: float = 2.0,
    highest: float = 500.0,
    lines: int = 60,
    periods: int = 8,
    seed: int = 0,
) -> list[Log]:
    """Return one record a peak of a periodic multisine on the control voltage, while the axis slides or rests.

    Sliding one way keeps Coulomb friction constant, so that it stays out of the response; around rest, two peaks tell
    what friction adds. The voltage is what the inverse model asks for a multisine of equal velocity amplitudes, the
    same for every peak but for its size. One period is left to run in; then whole periods are logged, at the
    controller's rate.

    Parameters
    ----------
    axis
        The axis.
    mean
        Mean speed [m/s]; 0 for an axis at rest.
    peaks
        Peak velocity of each multisine [m/s]; one of half the mean speed where not given.
    lowest, highest
        First and last frequency [Hz]; all are multiples of the lowest.
    lines
        Frequencies, spaced evenly on a logarithmic scale as far as multiples allow.
    periods
        Periods that are logged, each of 1/lowest.
    seed
        Seed of the phases and of the force channel's noise.

    Raises
    ------
    FricError
        When the highest frequency is not below half the controller's rate, or there is no peak.
    """
    peaks = (abs(mean) / 2,) if peaks is None else peaks
    if not peaks or min(peaks) <= 0:
        raise FricError(
            "a multisine has no peak velocity above zero",
            mend="Around rest, say how fast it swings: --peaks '15 mm/s'.",
        )
    sampling = axis.cascade.sampling
    if not 0 < lowest < highest < sampling / 2:
        raise FricError(
            f"a multisine from {lowest:g} to {highest:g} Hz does not fit a controller at {sampling:g} Hz",
            mend="Keep it below half the controller's rate.",
        )
    ramp, begin = 0.1, 0.2 + 1 / lowest
    lasting = 1.1 + (periods + 1) / lowest
    still = Reference(sampling, *(np.zeros(ceil((lasting + 2 * ramp) * sampling)) for _ in range(3)))
    stroke = strokes(mean, abs(mean) * lasting, sampling, ramp=ramp) if mean else still
    frequencies = lowest * np.unique(np.rint(np.geomspace(1, highest / lowest, lines)))
    shaken = multisine(frequencies, peaks[0], len(stroke), sampling, np.random.default_rng([seed, 0]))
    voltage = inverse_model(axis.plant, shaken)
    voltage[: int((begin - 1 / lowest) * sampling)] = 0.0
    voltage[int((begin + periods / lowest) * sampling) :] = 0.0
    return [
        _record(
            axis,
            stroke,
            name="frequency-response" if len(peaks) == 1 else f"frequency-response-{n:02d}",
            kind="frequency-response",
            begin=begin,
            end=begin + periods / lowest,
            samples=len(stroke),
            seed=seed,
            excitation=peak / peaks[0] * voltage,
        )
        for n, peak in enumerate(peaks, 1)
    ]


def experiment(axis: Axis, kind: str, *, seed: int = 0, **settings: object) -> Iterator[Log]:
    """Make the records of one kind of experiment, or of ``all``.

    Parameters
    ----------
    axis
        The axis.
    kind
        One of `EXPERIMENTS`, or ``all``.
    seed
        Seed of all that is random.
    settings
        Settings of that experiment's own function, such as ``speeds``; of all, each takes those it knows.

    Raises
    ------
    FricError
        When there is no such experiment, or a setting is none of its own.
    """
    makers: dict[str, Callable[..., list[Log]]] = {
        "constant-velocity": constant_velocity,
        "presliding-sine": presliding_sine,
        "sliding-sine": sliding_sine_around,
        "frequency-response": frequency_response,
    }
    if kind != "all" and kind not in makers:
        raise FricError(f"there is no experiment '{kind}'", mend=f"There are {', '.join(makers)}, and all.")
    wanted = {name: make for name, make in makers.items() if kind in {name, "all"}}
    takes = {name: settings.keys() & signature(make).parameters for name, make in wanted.items()}
    for unknown in settings.keys() - set().union(*takes.values()):
        raise FricError(
            f"the experiment '{kind}' has no setting '{unknown}'",
            mend=f"It has {', '.join(sorted(_settings(wanted.values())))}.",
        )
    for name, make in wanted.items():
        yield from make(axis, seed=seed, **{key: settings[key] for key in takes[name]})


def _settings(makers: Iterable[Callable[..., list[Log]]]) -> set[str]:
    """Return the names of what can be set of experiments, besides axis and seed."""
    return {name for make in makers for name in signature(make).parameters} - {"axis", "seed"}


def _record(
    axis: Axis,
    reference: Reference,
    *,
    name: str,
    kind: Kind,
    samples: int,
    seed: int,
    begin: float = 0.0,
    end: float | None = None,
    excitation: NDArray[np.float64] | None = None,
) -> Log:
    """Run one experiment and log it as a drive does.

    The trace keeps every ``divider``-th sample; voltage and force are averaged over that interval, as the drive's
    trace filter does, so that what the controller makes of encoder steps does not alias into them, and are kept in
    single precision.
    """
    run = run_axis(axis, reference, excitation=excitation)
    first = round(begin * reference.sampling)
    last = len(reference) if end is None else round(end * reference.sampling)
    divider = ceil((last - first) / samples)
    kept = np.arange(first, last, divider)
    voltage = _averaged(run.input, kept, divider)
    noise = np.random.default_rng([seed, crc32(name.encode())]).normal(0.0, 1.0, len(kept)) * axis.force_noise
    log = Log(
        time=(kept - first) / reference.sampling,
        position=run.measured[kept],
        force=_single(axis.plant.K_f * voltage + noise),
        input=_single(voltage),
        reference=run.reference[kept],
        name=name,
        kind=kind,
        axis=axis.name,
        motion=axis.motion,
    )
    return replace(log, sha256=sha256(b"".join(values.tobytes() for values in log.channels().values())).hexdigest())


def _averaged(values: NDArray[np.float64], at: NDArray[np.int64], width: int) -> NDArray[np.float64]:
    """Return the mean of ``width`` values around each of the indices."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    start, stop = np.clip(at - width // 2, 0, len(values)), np.clip(at - width // 2 + width, 0, len(values))
    return np.asarray((sums[stop] - sums[start]) / (stop - start))


def _single(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values rounded to single precision."""
    return values.astype(np.float32).astype(np.float64)
