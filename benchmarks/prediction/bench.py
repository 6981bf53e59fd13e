"""One machine: logs and one circle without compensation from the rig, what is predicted, and what the machine does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fric
from benchmarks.reality.session import MACHINES, PERIODS, SPEEDS
from fric.control.scheme import PAPER_SCHEMES
from fric.documents.machine import MachineDocument
from fric.documents.machine_files import read_machine
from fric.documents.yaml import plain, read_tree, write_document
from fric.errors import FricError
from fric.identify.circle.measured import measured_from_run
from fric.io.hdf5 import write_logs
from fric.log import Log
from fric.simulate.circle import Circle, run_circle
from fric.simulate.experiment import constant_velocity, frequency_response, presliding_sine, sliding_sine_around
from fric.simulate.prediction import Prediction
from fric.simulate.trial import runs_of

KINDS = ("constant-velocity", "presliding-sine", "sliding-sine", "frequency-response")


@dataclass(frozen=True)
class Pair:
    """One scheme on one machine: its interval [m], what the machine does [m], and why the interval is not trusted."""

    flaw: str
    scheme: str
    low: float
    high: float
    done: float
    why: tuple[str, ...]

    @property
    def covered(self) -> bool:
        """Whether the interval holds what the machine does; a loop that is not stable is told by an open end."""
        return self.low <= self.done <= self.high


@dataclass(frozen=True)
class Outcome:
    """All schemes on one machine, or why none was predicted."""

    flaw: str
    pairs: tuple[Pair, ...]
    failure: str = ""
    recommended: str = ""


def logs_of(axis: fric.Axis, seed: int) -> dict[str, list[Log]]:
    """Return one session of experiments on an axis, by kind."""
    found: dict[str, list[Log]] = {}
    trials = [
        *constant_velocity.planned(axis, speeds=SPEEDS),
        *presliding_sine.planned(axis, frequency=0.2, cycles=4),
        *sliding_sine_around.planned(axis),
        *frequency_response.planned(axis, seed, periods=PERIODS),
    ]
    for trial, run in runs_of(axis, trials):
        found.setdefault(trial.kind, []).append(trial.log(axis, run, seed))
    return found


def identify(axis: fric.Axis, folder: Path, seed: int = 0) -> dict[str, str]:
    """Identify one axis as a user would, into files; return those that were made, by what they are."""
    logs = logs_of(axis, seed)
    folder.mkdir(parents=True, exist_ok=True)
    write_logs(folder / "response.h5", logs["frequency-response"], force=True)
    made: dict[str, str] = {}
    plant, static, friction, observer = (
        folder / f"{name}.yaml" for name in ("plant", "static", "friction", "observer")
    )

    def keep(name: str, path: Path, act: Any) -> Path | None:
        try:
            act().save(path, force=True)
        except FricError:
            return None
        made[name] = str(path)
        return path

    known = keep("plant", plant, lambda: fric.identify_plant(*logs["frequency-response"]))
    strokes = keep("static", static, lambda: fric.identify_static(*logs["constant-velocity"], plant=known))
    sines = [*logs["presliding-sine"], *logs["sliding-sine"]]
    keep("friction", friction, lambda: fric.identify_gms(*sines, plant=known, static=strokes))
    if known:
        response = folder / "response.h5"
        keep("observer", observer, lambda: fric.design_observer(known, response, controller=axis.cascade))
    return made


def machine_file(flaw: str, files: dict[str, dict[str, str]], folder: Path) -> Path:
    """Write the machine file that a user would: what was identified, and the controller and the encoder as stated."""
    given = plain(read_tree(MACHINES / "base.yaml"))["axes"]
    axes = {}
    for name, made in files.items():
        stated = {key: given[name][key] for key in ("motion", "controller", "encoder")}
        axes[name] = stated | {key: made[key] for key in ("plant", "friction", "observer") if key in made}
    path = folder / "machine.yaml"
    write_document(path, {"fric": MachineDocument.type_name(), "name": flaw, "axes": axes}, force=True)
    return path


def outcome(flaw: str, folder: Path, second: dict[str, str], circle: Circle, machines: int, seed: int = 0) -> Outcome:
    """Predict all schemes of one machine, and run them on it."""
    true = read_machine(MACHINES / f"{flaw}.yaml")
    made = {"x": identify(true.axis("x"), folder / flaw, seed), "y": second}
    if not {"plant", "friction"} <= made["x"].keys():
        return Outcome(flaw, (), "not identified")
    nominal = [
        f"{axis}={files[key]}" for axis, files in made.items() for key in ("plant", "friction", "observer")
        if key in files
    ]  # fmt: skip
    true = read_machine(MACHINES / f"{flaw}.yaml", nominal_files=nominal)
    try:
        measured = measured_from_run(run_circle(true, PAPER_SCHEMES["a"], circle))
        known = fric.read_identified(machine_file(flaw, made, folder / flaw))
        schemes = "all" if all("observer" in files for files in made.values()) else "a,b,c"
        found = fric.circle(
            known, schemes, velocity=circle.feed, radius=circle.radius, machines=machines, measured=measured, seed=seed,
            workers=1,
        )  # fmt: skip
    except FricError as error:
        return Outcome(flaw, (), str(error))
    prediction = found.prediction
    assert prediction is not None
    return Outcome(flaw, tuple(_pairs(flaw, prediction, true, circle)), recommended=_least(prediction))


def _pairs(flaw: str, prediction: Prediction, true: fric.Machine, circle: Circle) -> Sequence[Pair]:
    pairs = []
    for name, one in prediction.schemes.items():
        try:
            done = run_circle(true, PAPER_SCHEMES[name], circle).circularity.glitch
        except FricError:
            done = float("inf")
        pairs.append(Pair(flaw, name, *one.ci95, done, tuple(why.code for why in prediction.why_not(name))))
    return pairs


def _least(prediction: Prediction) -> str:
    """Return the trusted scheme that stays under the least; empty where none is trusted."""
    trusted = [one for name, one in prediction.schemes.items() if prediction.trusted(name)]
    return min(trusted, key=lambda one: one.under).scheme if trusted else ""
