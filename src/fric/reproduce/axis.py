"""One axis: from virtual experiments to all that its controller needs to believe."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any

from fric.documents.machine_files import read_machine
from fric.io.hdf5 import write_logs
from fric.reproduce.step_cache import StepCache
from fric.results.base import Result
from fric.results.controller import design_controller
from fric.results.gms import identify_gms
from fric.results.observer import design_observer
from fric.results.plant import identify_plant
from fric.results.static import identify_static
from fric.simulate.experiment import OF_THE_PAPER, experiment

REPEATS = {"constant-velocity": 3}
"""Number of repetitions of an experiment, each with its noise: sigma is a small part of the force in a stroke."""

SAMPLES = {"constant-velocity": 16_384, "presliding-sine": 4096, "sliding-sine": 4096, "frequency-response": 16_000}


@dataclass(frozen=True)
class AxisFiles:
    """The files of one axis in the folder of a reproduction."""

    folder: Path  # Where they are

    def log(self, kind: str) -> Path:
        """Return the log of one kind of experiment."""
        return self.folder / f"{kind}.h5"

    @property
    def learned(self) -> tuple[Path, ...]:
        """Return the documents that were identified and designed."""
        return self.plant, self.controller, self.observer, self.friction

    def __getattr__(self, name: str) -> Path:
        endings = {
            "plant": "yaml", "static": "yaml", "friction": "yaml", "controller": "yaml", "observer": "yaml",
            "fig_plant": "png", "fig_2": "png", "fig_4_5": "png", "fig_7": "png",
        }  # fmt: skip
        if name not in endings:
            raise AttributeError(name)
        return self.folder / f"{name.replace('_', '-')}.{endings[name]}"


STEPS = (*OF_THE_PAPER, "plant", "static map", "GMS", "controller", "observer")


def learn_axis(
    machine: Path, axis: str, folder: Path, *, seed: int, published_plant: bool
) -> Iterator[tuple[str, bool]]:
    """Make the experiments on one axis and identify all from their logs; yield each step's name, and whether it ran.

    machine: The machine file.
    axis: Name of the axis.
    folder: Where the files of this axis go.
    seed: Seed of all noise.
    published_plant: True where the linear damping of the drive is taken from the machine file, which gives eq. (1), and
        not from the response: A of the response includes the guideway's sigma, and the two could not be separated.
    """
    shop, files = StepCache(folder), AxisFiles(folder)

    def made(name: str, make: Any, reads: Sequence[Path], leaves: Sequence[Path], **settings: Any) -> tuple[str, bool]:
        return name, shop.step(name, make, reads=reads, leaves=leaves, settings={"axis": axis, **settings})

    def found(
        name: str, find: Callable[[], Result], reads: Sequence[Path], *leaves: Path, **settings: Any
    ) -> tuple[str, bool]:
        return made(name, lambda: _save(find(), *leaves), reads, leaves, **settings)

    def damping() -> Any:
        return read_machine(machine).axis(axis).plant if published_plant else files.plant

    for kind in OF_THE_PAPER:
        make = partial(_experiment, machine, axis, kind, files, seed)
        yield made(
            kind, make, [machine], [files.log(kind)], seed=seed, samples=SAMPLES[kind], repeats=REPEATS.get(kind, 1)
        )
    response, strokes = files.log("frequency-response"), files.log("constant-velocity")
    yield found("plant", lambda: identify_plant(response), [response], files.plant, files.fig_plant)
    yield found(
        "static map",  # in the form of Table 1: one map
        lambda: identify_static(strokes, plant=damping(), delta=1.0, direction="both", over_position="off"),
        [machine, strokes, files.plant], files.static, files.fig_2, published_plant=published_plant,
    )  # fmt: skip
    waves = [files.log("presliding-sine"), files.log("sliding-sine")]
    yield found(
        "GMS", lambda: identify_gms(waves, static=files.static, plant=damping()),
        [machine, *waves, files.static, files.plant], files.friction, files.fig_4_5, published_plant=published_plant,
    )  # fmt: skip
    yield found("controller", lambda: _controller(files, machine, axis), [machine, files.plant], files.controller)
    yield found(
        "observer", lambda: design_observer(files.plant, response, controller=files.controller),
        [files.plant, files.controller, response], files.observer, files.fig_7,
    )  # fmt: skip


def _experiment(machine: Path, axis: str, kind: str, files: AxisFiles, seed: int) -> None:
    subject = read_machine(machine).axis(axis)
    settings = {} if kind == "frequency-response" else {"samples": SAMPLES[kind]}
    logs = []
    for n in range(REPEATS.get(kind, 1)):
        made = experiment(subject, kind, seed=1000 * seed + n, **settings)
        logs += [replace(log, source=machine.name, name=f"{log.name}-{n + 1}" if n else log.name) for log in made]
    write_logs(files.log(kind), logs, force=True)


def _save(result: Result, file: Path, figure: Path | None = None) -> None:
    result.save(file, force=True)
    if figure is not None:
        result.plot(figure, force=True)


def _controller(files: AxisFiles, machine: Path, axis: str) -> Result:
    cascade = read_machine(machine).axis(axis).cascade
    limit = cascade.limit if isfinite(cascade.limit) else None
    return design_controller(
        files.plant, sampling=cascade.sampling, velocity_filter=cascade.velocity_filter, limit=limit
    )
