"""One session of experiments on a machine of configs/reality, with a seed for all that is random."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from pathlib import Path

import numpy as np

from fric.documents.machine_files import read_machine
from fric.friction.gms import GMS
from fric.log import Log
from fric.simulate.axis import Trace
from fric.simulate.experiment import Trial, constant_velocity, frequency_response, presliding_sine, sliding_sine_around
from fric.simulate.machine import Axis, Machine

MACHINES = Path(__file__).parents[2] / "configs" / "reality"
SPEEDS = tuple(v * 1e-3 for v in (0.05, 0.1, 0.2, 0.5, 1, 2, 4, 8, 14, 20, 30))
"""Speeds of the strokes [m/s]: those of the paper but for the slowest, which take as long as all others together."""
PERIODS = 8
"""Periods of the multisine."""


CLEAN = "clean"
"""In place of a flaw: each session is of another machine, which has none."""


def flaws() -> list[str]:
    """Return the names of the machines, the base machine first and that with all flaws last."""
    names = sorted(file.stem for file in MACHINES.glob("*.yaml"))
    return ["base", *(name for name in names if name not in {"base", "all"}), "all"]


def file_of(flaw: str) -> Path:
    """Return the file of the machine with a flaw."""
    return MACHINES / f"{'base' if flaw == CLEAN else flaw}.yaml"


def machine_with(flaw: str) -> Machine:
    """Return the machine with a flaw."""
    return read_machine(file_of(flaw))


def another(axis: Axis, seed: int) -> Axis:
    """Return an axis of the same kind that has no flaw either: mass, friction, drive and channels are drawn anew."""
    random = np.random.default_rng([seed, 11])

    def times(most: float) -> float:
        return float(np.exp(random.uniform(-1.0, 1.0) * np.log(most)))

    # a contact too stiff for its mass, or a drive too weak for it, would be a flaw: they grow with the mass
    mass, slip, known = times(3.0), times(1.5), axis.friction
    level = mass * times(1.5)
    assert isinstance(known, GMS)
    F_c, share = known.static.F_c * level, 1.0 + random.uniform(0.1, 0.6)
    static = replace(
        known.static, F_c=F_c, F_s=F_c * share, v_s=known.static.v_s * times(2.0),
        sigma=known.static.sigma * level * times(2.0),
    )  # fmt: skip
    count = int(random.integers(3, 11))
    alpha = random.dirichlet(np.full(count, 4.0))
    slips = 70e-6 * slip * np.geomspace(0.01, 1.0, count)
    friction = GMS(static, tuple(alpha), tuple(alpha * static.F_s / slips), known.C * level * times(2.0))
    cascade, plant = axis.cascade, replace(axis.plant, A=axis.plant.A * times(1.5), B=axis.plant.B / mass)
    return replace(
        axis, plant=plant, friction=friction, force_noise=axis.force_noise * level * times(2.0),
        cascade=replace(cascade, K_p=cascade.K_p * mass, K_i=cascade.K_i * mass, limit=cascade.limit * mass),
        encoder=replace(axis.encoder, resolution=axis.encoder.resolution * slip * times(2.0)),
    )  # fmt: skip


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
        draw, runs, began = another if self.flaw == CLEAN else drawn, [], 0.0
        axis = draw(self.axis, seed)
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
