"""The paper's identification experiments on a virtual axis, and plans of them within the limits of an axis."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from inspect import signature
from typing import Annotated, Any, Self

import numpy as np

from fric.arrays import Real
from fric.columns import Kind
from fric.control.feedforward import inverse_model
from fric.errors import FricError
from fric.log import Log
from fric.reference import Reference, instants, multisine, sine, sliding_sine, staircase, strokes
from fric.simulate.axis import Trace, run_axis
from fric.simulate.contour_run import Circle
from fric.simulate.machine import Axis
from fric.simulate.reality.flaws import Excitation
from fric.simulate.reality.trace import logged
from fric.verb import require_within

ACCURACY = 1e-10  # Error of the position by the integration that no record shows [m]: 0.01 N of a stiffness of 100 N/µm
LONG = 1_000_000  # Samples of a motion above which it is integrated to that: the last digits take five times as long
SPEEDS = tuple(v * 1e-3 for v in (0.01, 0.04, 0.08, 0.2, 0.4, 0.5, 1, 2, 4, 5, 8, 10, 14, 16, 20, 25, 30))
"""The 17 speeds of Section 3.1 [m/s]."""
AMPLITUDES = (15e-6, 450e-6)  # The amplitudes of Section 3.2.1 [m]


@dataclass(frozen=True)
class Trial:
    """What is asked of an axis, and which part of it the drive's trace logs."""

    reference: Reference  # The motion
    name: str  # name, kind: name and kind of the record
    kind: Kind
    samples: int  # Samples that the trace holds: what is longer is logged at a whole fraction of the controller's rate
    begin: float = 0.0  # begin, end: the part that is logged [s]; the whole where not given
    end: float | None = None
    excitation: Real | None = None  # Voltage added to the control voltage [V], shape (n,)

    @property
    def window(self) -> tuple[int, int]:
        """The first sample that is logged, and one past the last."""
        sampling, end = self.reference.sampling, self.end
        return round(self.begin * sampling), len(self.reference) if end is None else round(end * sampling)

    def run(self, axis: Axis, began: float = 0.0, accuracy: float = 0.0) -> Trace:
        """Run it on an axis, ``began`` seconds after the session did.

        ``accuracy`` as in `run_axis`; an excitation is integrated to the last digits: errors in its lines change A.
        """
        accuracy = (accuracy or ACCURACY * (len(self.reference) > LONG)) if self.excitation is None else 0.0
        return run_axis(axis, self.reference, excitation=self.excitation, began=began, accuracy=accuracy)

    def log(self, axis: Axis, run: Trace, seed: int = 0) -> Log:
        """Return the log of its run by the drive, with the seed of all that is random in it."""
        return logged(axis, run, self.window, self.samples, self.name, self.kind, seed)


def runs_of(axis: Axis, trials: Iterable[Trial], accuracy: float = 0.0) -> Iterator[tuple[Trial, Trace]]:
    """Run trials one after the other, as in one session, and yield each with its run; ``accuracy`` as in `run_axis`."""
    began = 0.0
    for trial in trials:
        yield trial, trial.run(axis, began, accuracy)
        began += len(trial.reference) / trial.reference.sampling


def logs_of(axis: Axis, trials: Iterable[Trial], seed: int = 0) -> Iterator[Log]:
    """Run trials one after the other, and yield the log of each."""
    began = 0.0
    for trial in trials:
        yield trial.log(axis, trial.run(axis, began), seed)  # a run is let go before the next: each takes up to 1 GB
        began += len(trial.reference) / trial.reference.sampling


@dataclass(frozen=True)
class Experiment:
    """An experiment: called with an axis, a seed and its settings it returns the records; `trials` plans them alone."""

    trials: Callable[..., Iterator[Trial]]  # The requested motion, one trial a record, by the settings

    def __call__(self, axis: Axis, *, seed: int = 0, **settings: object) -> list[Log]:
        """Return the records of the axis, which begins at rest."""
        return list(logs_of(axis, self.planned(axis, seed, **settings), seed))

    def planned(self, axis: Axis, seed: int = 0, **settings: object) -> Iterator[Trial]:
        """Yield the trials of an axis, with the seed for those that draw."""
        drawn = {"seed": seed} if "seed" in signature(self.trials).parameters else {}
        return self.trials(axis, **drawn, **settings)

    @property
    def settings(self) -> set[str]:
        """Names of what can be set, besides axis and seed."""
        return set(signature(self.trials).parameters) - {"axis", "seed"}


@Experiment
def constant_velocity(
    axis: Axis, *, speeds: Sequence[float] = SPEEDS, distance: float = 0.5e-3, lasting: float = 1.0, ramp: float = 0.1,
    repeats: int = 1, samples: int = 4096,
) -> Iterator[Trial]:  # fmt: skip
    """Yield one record a speed: a stroke, a rest, and the stroke back.

    speeds: Speeds [m/s].
    distance: Least length of a stroke at its speed [m]: long enough to leave pre-sliding behind.
    lasting: Least time at speed [s].
    ramp: Time in which the speed rises, and falls [s].
    repeats: Times that all speeds are run.
    samples: Samples that the drive's trace holds: a longer run is logged at a whole fraction of the controller's rate.
    """
    rate = axis.cascade.sampling
    motions = (strokes(v, max(distance, lasting * abs(v)), rate, ramp=ramp) for v in repeats * tuple(speeds))
    for n, motion in enumerate(motions, 1):
        yield Trial(motion, f"constant-velocity-{n:02d}", "constant-velocity", samples)


@Experiment
def presliding_sine(
    axis: Axis, *, amplitudes: Sequence[float] = AMPLITUDES, frequency: float = 0.1, cycles: int = 5,
    samples: int = 4096,
) -> Iterator[Trial]:  # fmt: skip
    """Yield one record an amplitude: whole cycles of a slow sine, logged once it has run in.

    amplitudes: Amplitudes [m].
    frequency: Frequency [Hz], low enough that inertia does not matter.
    cycles: Cycles that are logged.
    """
    motions = (sine(amplitude, frequency, cycles, axis.cascade.sampling) for amplitude in amplitudes)
    for n, motion in enumerate(motions, 1):
        yield Trial(motion, f"presliding-sine-{n:02d}", "presliding-sine", samples, 1 / frequency)


@Experiment
def micro_steps(
    axis: Axis, *, step: float = 1e-6, steps: int = 30, loops: int = 4, ramp: float = 0.25, dwell: float = 0.25,
    samples: int = 16384,
) -> Iterator[Trial]:  # fmt: skip
    """Yield one record of small steps up and down before sliding, as a machine without a slow sine makes them.

    step: Size of a step [m].
    steps, loops: Steps from one end to the other, and how many times there and back.
    ramp, dwell: Time that a step takes, and rest after it [s].
    """
    motion = staircase(step, steps, loops, axis.cascade.sampling, ramp=ramp, dwell=dwell)
    yield Trial(motion, "micro-steps", "micro-steps", samples)


@Experiment
def sliding_sine_around(
    axis: Axis, *, mean: float = 2e-3, swing: float = 1.5e-3, frequency: float = 4.0, cycles: int = 20,
    samples: int = 8192,
) -> Iterator[Trial]:  # fmt: skip
    """Yield one record of sliding at a velocity that swings around a mean, which shows the frictional lag.

    mean, swing: Mean and amplitude of the velocity [m/s].
    frequency: Frequency of the velocity [Hz].
    cycles: Cycles that are logged.
    """
    motion = sliding_sine(mean, swing, frequency, cycles, axis.cascade.sampling)
    yield Trial(motion, "sliding-sine", "sliding-sine", samples, 2 / frequency, (cycles + 2) / frequency)


@Experiment
def frequency_response(  # noqa: PLR0913 - the verb experiment gives each setting
    axis: Axis, *, mean: float | None = None, peaks: Sequence[float] | None = None, lowest: float | None = None,
    highest: float | None = None, lines: int | None = None, periods: int = 8, ramp: float = 0.1, seed: int = 0,
) -> Iterator[Trial]:  # fmt: skip
    """Yield one record a peak of a periodic multisine on the control voltage, while the axis slides or rests.

    Sliding one way keeps Coulomb friction constant, so that it stays out of the response; around rest, two peaks show
    what friction adds. The voltage is that of the inverse model for a multisine of equal velocity amplitudes, the same
    for every peak except its size. The first period runs in; then whole periods are logged, at the controller's rate.

    mean: Mean speed [m/s], 30 mm/s where neither it nor the axis sets it; 0 for an axis at rest.
    peaks: Peak velocity of each multisine [m/s]; a single peak of half the mean speed where not given.
    lowest, highest: First and last frequency [Hz]; all are multiples of the lowest. 2 and 500 where neither they nor
        the axis say.
    lines: Frequencies, spaced evenly on a logarithmic scale as far as multiples allow; 60 by default.
    periods: Periods that are logged, each of 1/lowest.
    ramp: Time in which the mean speed rises, and falls [s].
    """
    usual = axis.reality.multisine or Excitation(60, 2.0, 500.0)
    mean = usual.mean if mean is None else mean
    peaks = (usual.peak or abs(mean) / 2,) if peaks is None else peaks
    if not peaks or min(peaks) <= 0:
        hint = "Around rest, say how fast it swings: `peaks='15 mm/s'`."
        raise FricError("a multisine has no peak velocity above zero", hint=hint)
    sampling = axis.cascade.sampling
    lowest, highest = lowest or usual.lowest, highest or usual.highest
    if not 0 < lowest < highest < sampling / 2:
        what = f"a multisine from {lowest:g} to {highest:g} Hz does not fit a controller at {sampling:g} Hz"
        raise FricError(what, hint="Keep it below half the controller's rate.")
    begin = 0.1 + ramp + 1 / lowest
    end, lasting = begin + periods / lowest, 1.1 + (periods + 1) / lowest
    still = Reference(sampling, *np.zeros((3, instants(lasting + 2 * ramp, sampling).size)))
    stroke = strokes(mean, abs(mean) * lasting, sampling, ramp=ramp) if mean else still
    frequencies = lowest * np.unique(np.rint(np.geomspace(1, highest / lowest, lines or usual.lines)))
    shaken = multisine(frequencies, peaks[0], len(stroke), sampling, np.random.default_rng([seed, 0]))
    voltage = inverse_model(axis.plant, shaken)
    voltage[: int((begin - 1 / lowest) * sampling)] = 0.0
    voltage[int(end * sampling) :] = 0.0
    kind: Kind = "frequency-response"
    names = [kind] if len(peaks) == 1 else [f"{kind}-{n:02d}" for n in range(1, len(peaks) + 1)]
    for name, peak in zip(names, peaks, strict=True):
        yield Trial(stroke, name, kind, len(stroke), begin, end, peak / peaks[0] * voltage)


def _made(kind: str) -> Experiment:
    if kind not in EXPERIMENTS:
        raise FricError(f"there is no experiment '{kind}'", hint=f"There are {', '.join(EXPERIMENTS)}, and all.")
    return _MADE[kind]


def experiment(axis: Axis, kind: str, *, seed: int = 0, **settings: object) -> Iterator[Log]:
    """Make the records of one kind of experiment, or of ``all``: those of the paper, which are all but micro-steps.

    kind: One of `EXPERIMENTS`, or ``all``.
    settings: Settings of the function of that experiment, such as ``speeds``; of ``all``, each takes those it knows.
    Raises FricError: When there is no such experiment, or it has no such setting.
    """
    wanted = [_MADE[name] for name in OF_THE_PAPER] if kind == "all" else [_made(kind)]
    known = set().union(*(made.settings for made in wanted))
    for unknown in settings.keys() - known:
        hint = f"It has {', '.join(sorted(known))}."
        raise FricError(f"the experiment '{kind}' has no setting '{unknown}'", hint=hint)
    trials = (
        trial for made in wanted
        for trial in made.planned(axis, seed, **{key: settings[key] for key in settings.keys() & made.settings})
    )  # fmt: skip
    yield from logs_of(axis, trials, seed)


_MADE: dict[Kind, Experiment] = {
    "constant-velocity": constant_velocity, "presliding-sine": presliding_sine, "micro-steps": micro_steps,
    "sliding-sine": sliding_sine_around, "frequency-response": frequency_response,
}  # fmt: skip
EXPERIMENTS: tuple[Kind, ...] = tuple(_MADE)  # The kinds of record that can be made
OF_THE_PAPER: tuple[Kind, ...] = tuple(kind for kind in EXPERIMENTS if kind != "micro-steps")
"""The kinds of record that the paper identifies an axis from."""

Setting = float | int | tuple[float, ...]

APPROACH = 20.0  # Time that the begin of a motion is approached in, from the other end of the stroke [s]


@dataclass(frozen=True)
class Limits:
    """What an axis may do."""

    stroke: Annotated[float, "position"]  #: Length that it may travel [m]
    feed: Annotated[float, "velocity"]  #: Largest speed [m/s]
    acceleration: Annotated[float, "acceleration"]  #: Largest acceleration [m/s²]

    def __post_init__(self) -> None:
        require_within(self, "the axis", stroke="(0, inf)", feed="(0, inf)", acceleration="(0, inf)")

    @property
    def approach(self) -> float:
        """Speed with which the begin of a motion is approached: over the whole stroke in `APPROACH` or so."""
        return min(0.5 * self.feed, self.stroke / APPROACH)

    def broken_by(self, motion: Reference) -> str:
        """Return which limit a motion breaks; empty where it keeps all of them."""
        used = (np.ptp(motion.position), np.abs(motion.velocity).max(), np.abs(motion.acceleration).max())
        return next((name for (name, most), item in zip(vars(self).items(), used, strict=True) if item > most), "")


@dataclass(frozen=True)
class Planned:
    """One experiment of a plan."""

    kind: str  # A kind of record, or ``circle``
    settings: Mapping[str, Setting]  # Its settings, as `fric.simulate.experiment` takes them, in SI
    why: str  # Its purpose

    def trials(self, axis: Axis) -> Iterator[Trial]:
        """Yield the motion of the axis, one trial a record; a circle has two axes, and no trial."""
        if self.kind != "circle":
            yield from _made(self.kind).planned(axis, **dict[str, Any](self.settings))

    def changed(self, **settings: Setting) -> Self:
        """Return the experiment with other settings."""
        return replace(self, settings={**self.settings, **settings})


@dataclass(frozen=True)
class Expected:
    """Expected interval of one parameter from planned records."""

    value: float  # Its median identified value [SI]
    half_width: float  # Half of its 95 % interval [SI], geometric mean of runs; infinite where most set no limit
    unit: str  # SI unit
    between: tuple[float, float]  # The least and the largest of them


@dataclass(frozen=True, eq=False)
class Plan:
    """The experiments to run, and the intervals expected of them."""

    axis: Axis  # The axis as known beforehand
    limits: Limits  # What it may do
    planned: Sequence[Planned]  # planned, lasting: The experiments, and how long each lasts [s]
    lasting: Sequence[float]
    expected: Mapping[str, Expected]  # Expected intervals, by parameter


@dataclass(frozen=True)
class CandidateRecord:
    """One more record."""

    planned: Planned  # The experiment
    lasting: float  # How long it lasts [s]
    half_width: float  # Half the 95 % interval of the predicted glitch with it [m]
    scatter: float  # Scatter of it with other noise, and other places between two encoder counts [m]


@dataclass(frozen=True)
class Narrowing:
    """What the glitch is not known for, and what narrows it."""

    half_width: float  # Half the 95 % interval of the predicted glitch so far [m]
    shares: Mapping[str, float]  # Share of its variance due to each parameter with its covariances [1]; they sum to 1
    candidates: tuple[CandidateRecord, ...]  # The best interval first; where they scatter by more, the shortest record
    test: Circle  # The circle
    scheme: str  # Name of the compensation
