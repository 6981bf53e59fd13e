"""One session of experiments on a machine of configs/reality, with a seed for all that is random."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from pathlib import Path

import numpy as np

from fric.documents.machine_files import read_machine
from fric.log import Log
from fric.simulate.axis import Trace
from fric.simulate.experiment import Trial, constant_velocity, frequency_response, presliding_sine, sliding_sine_around
from fric.simulate.machine import Axis, Machine

MACHINES = Path(__file__).parents[2] / "configs" / "reality"
SPEEDS = tuple(v * 1e-3 for v in (0.05, 0.1, 0.2, 0.5, 1, 2, 4, 8, 14, 20, 30))
"""Speeds of the strokes [m/s]: those of the paper but for the slowest, which take as long as all others together."""
PERIODS = 8
"""Periods of the multisine."""


def flaws() -> list[str]:
    """Return the names of the machines, the base machine first and that with all flaws last."""
    names = sorted(file.stem for file in MACHINES.glob("*.yaml"))
    return ["base", *(name for name in names if name not in {"base", "all"}), "all"]


def machine_with(flaw: str) -> Machine:
    """Return the machine with a flaw."""
    return read_machine(MACHINES / f"{flaw}.yaml")


def drawn(axis: Axis, seed: int) -> Axis:
    """Return an axis with the phases of all that goes with the position drawn anew: where on its guideway it begins."""
    phase, flaws = iter(np.random.default_rng([seed, 7]).uniform(0.0, 2 * pi, 16)), axis.reality
    return replace(axis, reality=replace(
        flaws,
        cogging=tuple(replace(one, phase=float(next(phase))) for one in flaws.cogging),
        waves=tuple(replace(one, phase=float(next(phase))) for one in flaws.waves),
        encoder=flaws.encoder and replace(flaws.encoder, phase=float(next(phase))),
    ))  # fmt: skip


@dataclass(frozen=True)
class Session:
    """Experiments on one axis, one after the other, and when each begins [s]."""

    axis: Axis
    runs: tuple[tuple[Trial, Trace, float], ...]
    seed: int

    @property
    def logs(self) -> dict[str, list[Log]]:
        """The records by kind."""
        found: dict[str, list[Log]] = {}
        for trial, run, _ in self.runs:
            found.setdefault(trial.kind, []).append(trial.log(self.axis, run, self.seed))
        return found

    def middle(self, kind: str) -> float:
        """Return the middle of the time in which a kind of experiment was logged [s]."""
        times = [
            (began + trial.window[0] / trial.reference.sampling, began + trial.window[1] / trial.reference.sampling)
            for trial, _, began in self.runs
            if trial.kind == kind
        ]
        return (times[0][0] + times[-1][1]) / 2


class Sessions:
    """Sessions on the machine with a flaw, seed by seed; a motion that no seed changes is simulated once."""

    def __init__(self, flaw: str) -> None:
        self.flaw = flaw
        self.axis = machine_with(flaw).axis("x")
        self._same: dict[str, Trace] = {}

    def session(self, seed: int) -> Session:
        """Return the session of a seed."""
        axis, runs, began = drawn(self.axis, seed), [], 0.0
        for trial in [
            *constant_velocity.planned(axis, speeds=SPEEDS),
            *presliding_sine.planned(axis, frequency=0.2, cycles=4),
            *sliding_sine_around.planned(axis),
            *frequency_response.planned(axis, seed, periods=PERIODS),
        ]:
            fixed = axis == self.axis and trial.kind != "frequency-response"
            run = (self._same.get(trial.name) if fixed else None) or trial.run(axis, began)
            if fixed:
                self._same[trial.name] = run
            runs.append((trial, run, began))
            began += len(trial.reference) / trial.reference.sampling
        return Session(axis, tuple(runs), seed)
