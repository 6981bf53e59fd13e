"""One run of an axis in an experiment, a session of them one after the other, and what plans them."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from inspect import signature

from fric.arrays import Real
from fric.columns import Kind
from fric.log import Log
from fric.reference import Reference
from fric.simulate.axis import Trace, run_axis
from fric.simulate.machine import Axis
from fric.simulate.reality.trace import logged


@dataclass(frozen=True)
class Trial:
    """What is asked of an axis, and which part of it the drive's trace logs."""

    reference: Reference  # The motion
    # name, kind: name and kind of the record
    name: str
    kind: Kind
    samples: int  # Samples that the trace holds: what is longer is logged at a whole fraction of the controller's rate
    # begin, end: the part that is logged [s]; the whole where not given
    begin: float = 0.0
    end: float | None = None
    excitation: Real | None = None  # Voltage added to the control voltage [V], shape (n,)

    @property
    def window(self) -> tuple[int, int]:
        """The first sample that is logged, and the one behind the last."""
        sampling, end = self.reference.sampling, self.end
        return round(self.begin * sampling), len(self.reference) if end is None else round(end * sampling)

    def run(self, axis: Axis, began: float = 0.0, accuracy: float = 0.0) -> Trace:
        """Run it on an axis, ``began`` seconds after the session did.

        ``accuracy`` is that of `run_axis`; an excitation is integrated to the last digits: its lines tell A by less.
        """
        accuracy = accuracy if self.excitation is None else 0.0
        return run_axis(axis, self.reference, excitation=self.excitation, began=began, accuracy=accuracy)

    def log(self, axis: Axis, run: Trace, seed: int = 0) -> Log:
        """Return what the drive logs of its run, with the seed of all that is random in that."""
        return logged(axis, run, self.window, self.samples, self.name, self.kind, seed)


def runs_of(axis: Axis, trials: Iterable[Trial], accuracy: float = 0.0) -> Iterator[tuple[Trial, Trace]]:
    """Run trials one after the other, as in one session, and yield each with its run; ``accuracy`` as in `run_axis`."""
    began = 0.0
    for trial in trials:
        yield trial, trial.run(axis, began, accuracy)
        began += len(trial.reference) / trial.reference.sampling


def logs_of(axis: Axis, trials: Iterable[Trial], seed: int = 0) -> Iterator[Log]:
    """Run trials one after the other, and yield the log of each."""
    for trial, run in runs_of(axis, trials):
        yield trial.log(axis, run, seed)


@dataclass(frozen=True)
class Experiment:
    """An experiment: called with an axis, a seed and its settings it returns the records; `trials` plans them alone."""

    trials: Callable[..., list[Trial]]  # What is asked of the axis, one trial a record, by the settings

    def __call__(self, axis: Axis, *, seed: int = 0, **settings: object) -> list[Log]:
        """Return the records of the axis, which begins at rest."""
        return list(logs_of(axis, self.planned(axis, seed, **settings), seed))

    def planned(self, axis: Axis, seed: int = 0, **settings: object) -> list[Trial]:
        """Return the trials of an axis, with the seed for those that draw."""
        drawn = {"seed": seed} if "seed" in signature(self.trials).parameters else {}
        return self.trials(axis, **drawn, **settings)

    @property
    def settings(self) -> set[str]:
        """Names of what can be set, besides axis and seed."""
        return set(signature(self.trials).parameters) - {"axis", "seed"}
