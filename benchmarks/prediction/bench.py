"""One machine, as a user goes: logs and one circle without compensation, what is predicted, and what it then does."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import fric
from benchmarks._tuned import recorded
from benchmarks.prediction.drawn import drawn_machine
from benchmarks.reality.session import MACHINES, PERIODS, SPEEDS, drawn, machine_with
from fric.control.scheme import PAPER_SCHEMES
from fric.documents.machine_files import MachineDocument
from fric.documents.yaml import plain, read_tree, write_document
from fric.errors import FricError
from fric.io.hdf5 import write_logs
from fric.simulate.contour_run import Circle, run_circle
from fric.simulate.experiment import (
    constant_velocity,
    frequency_response,
    logs_of,
    presliding_sine,
    sliding_sine_around,
)
from fric.verdict import CYCLE, CYCLE_RATIO

if TYPE_CHECKING:
    from fric.simulate.contour_run import CircleRun
    from fric.simulate.machine import Axis, Machine


@dataclass(frozen=True)
class Pair:
    """One scheme on one machine: its interval [m], what the machine does [m], and why the interval is not trusted."""

    scheme: str
    low: float
    high: float
    done: float
    cycles: bool
    why: tuple[str, ...]

    @property
    def covered(self) -> bool:
        """Whether the interval holds what the machine does; a loop that is not stable has an open end."""
        return self.low <= self.done <= self.high


@dataclass(frozen=True)
class Outcome:
    """All schemes on one machine, what the verdict recommends and why that is not trusted; or why there is none."""

    name: str
    pairs: tuple[Pair, ...] = ()
    choice: str = ""
    under: float = float("nan")
    why: tuple[str, ...] = ()
    failure: str = ""

    @property
    def chosen(self) -> Pair | None:
        """What the machine does under the scheme that is recommended."""
        return next((one for one in self.pairs if one.scheme == self.choice), None)

    @property
    def bare(self) -> Pair | None:
        """What it does without compensation."""
        return next((one for one in self.pairs if one.scheme == "a"), None)

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain data."""
        return asdict(self)

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Outcome:
        """Return what `as_dict` wrote."""
        pairs = tuple(Pair(**one | {"why": tuple(one["why"])}) for one in given["pairs"])
        return cls(**{**given, "pairs": pairs, "why": tuple(given["why"])})


def the_machine(name: str, seed: int) -> tuple[str, Machine]:
    """Return a machine of configs/reality by its name, phases drawn by the seed, or one that is drawn by its number."""
    if name.isdigit():
        return drawn_machine(seed, int(name))
    machine = machine_with(name)
    if seed:
        machine = replace(machine, axes={**machine.axes, "x": drawn(machine.axis("x"), seed)})
    return name, machine


def identify(axis: Axis, folder: Path, seed: int) -> dict[str, str]:
    """Identify one axis as a user would, into files; return those that were made, by what they are."""
    known = {name: folder / f"{name}.yaml" for name in ("plant", "friction", "observer")}
    if not (folder / "done").exists():
        folder.mkdir(parents=True, exist_ok=True)
        _identify(axis, folder, known, seed)
        (folder / "done").touch()
    return {name: str(path) for name, path in known.items() if path.exists()}


def _identify(axis: Axis, folder: Path, to: Mapping[str, Path], seed: int) -> None:
    logs = defaultdict(list)
    trials = [
        *constant_velocity.planned(axis, speeds=SPEEDS),
        *presliding_sine.planned(axis, frequency=0.2, cycles=4),
        *sliding_sine_around.planned(axis),
        *frequency_response.planned(axis, seed, periods=PERIODS),
    ]
    for log in logs_of(axis, trials, seed):
        logs[log.kind].append(log)
    response = folder / "response.h5"
    write_logs(response, logs["frequency-response"], force=True)
    try:
        plant = fric.identify_plant(*logs["frequency-response"])
        plant.save(to["plant"], force=True)
        strokes = fric.identify_static(*logs["constant-velocity"], plant=to["plant"])
        strokes.save(folder / "static.yaml", force=True)
        sines = [*logs["presliding-sine"], *logs["sliding-sine"]]
        friction = fric.identify_gms(*sines, plant=to["plant"], static=folder / "static.yaml")
        friction.save(to["friction"], force=True)
        fric.design_observer(to["plant"], response, controller=axis.cascade).save(to["observer"], force=True)
    except FricError as error:
        (folder / "refused").write_text(str(error), encoding="utf-8")


def machine_file(name: str, files: Mapping[str, Mapping[str, str]], path: Path) -> Path:
    """Write the machine file that a user would: what was identified, and the controller and the encoder as stated."""
    given = plain(read_tree(MACHINES / "base.yaml"))["axes"]
    axes = {}
    for axis, made in files.items():
        stated = {key: given[axis][key] for key in ("motion", "controller", "encoder")}
        axes[axis] = stated | dict(made)
    write_document(path, {"fric": MachineDocument.type_name(), "name": name, "axes": axes}, force=True)
    return path


def outcome(name: str, seed: int, folder: Path, circle: Circle, machines: int) -> Outcome:
    """Predict all schemes of one machine, ask for the verdict, and run them on the machine itself.

    Parameters
    ----------
    name, seed
        As in `the_machine`.
    folder
        Where the files of what is identified are kept, and found again.
    circle
        The circle that is measured, and predicted.
    machines
        Machines that are drawn.
    """
    called, machine = the_machine(name, seed)
    made = {
        "x": identify(machine.axis("x"), folder / f"{name}-{seed}", seed),
        "y": identify(machine_with("base").axis("y"), folder / f"y-{seed}", seed),
    }
    if not {"plant", "friction"} <= made["x"].keys():
        return Outcome(called, failure=(folder / f"{name}-{seed}" / "refused").read_text(encoding="utf-8"))
    known = fric.read_identified(machine_file(called, made, folder / f"{name}-{seed}" / "machine.yaml"))
    true = replace(machine, axes={key: _controlled(machine.axes[key], known.machine.axes[key]) for key in made})
    schemes = "all" if all("observer" in files for files in made.values()) else "a,b,c"
    try:
        measured = recorded(true, run_circle(true, PAPER_SCHEMES["a"], circle, places=1), seed)
        found = fric.circle(
            known, schemes, velocity=circle.feed, radius=circle.radius, machines=machines, measured=measured, seed=seed,
            workers=1,
        )  # fmt: skip
    except FricError as error:
        return Outcome(called, failure=str(error))
    prediction, verdict = found.prediction, found.verdict
    assert prediction is not None
    runs = {scheme: _run(true, scheme, circle) for scheme in prediction.schemes}
    pairs = []
    for scheme, one in prediction.schemes.items():
        run, bare = runs[scheme], runs["a"]
        done = run.circularity.glitch if run else float("inf")
        swing = run.circularity.oscillation if run else float("inf")
        least = CYCLE_RATIO * (bare.circularity.oscillation if bare else 0.0)
        why = tuple(dict.fromkeys(reason.code for reason in one.why))
        pairs.append(Pair(scheme, *one.ci95, done, swing > max(CYCLE, least), why))
    chosen = verdict.choice
    return Outcome(
        called, tuple(pairs), chosen.scheme.name if chosen else "", chosen.stays_under if chosen else float("nan"),
        tuple(dict.fromkeys(reason.code for reason in verdict.why)),
    )  # fmt: skip


def _controlled(true: Axis, known: Axis) -> Axis:
    """Return the true axis with the controller of the one that is known, and all that it believes."""
    nominal = known.nominal or known.plant
    return replace(true, nominal=nominal, nominal_friction=known.nominal_friction, observer=known.observer)


def _run(machine: Machine, scheme: str, circle: Circle) -> CircleRun | None:
    try:
        return run_circle(machine, PAPER_SCHEMES[scheme], circle)
    except FricError:
        return None
