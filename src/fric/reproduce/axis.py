"""One axis: from virtual experiments to all that its controller needs to believe."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from fric.design.cascade import design_cascade
from fric.design.observer import design_observer
from fric.design.perturbation import measured_perturbation
from fric.documents.controller import ControllerDocument, controller_tree
from fric.documents.friction import gms_tree, read_static, static_tree
from fric.documents.machine_files import read_machine
from fric.documents.observer import observer_tree
from fric.documents.plant import PlantDocument, plant_tree, read_plant
from fric.documents.yaml import read_document, write_document
from fric.figures.gms import draw_gms
from fric.figures.plant import draw_plant
from fric.figures.qfilter import q_filter_figure
from fric.figures.static_map import draw_static_map
from fric.figures.style import save_figure
from fric.identify.dynamics.frequency_response import measure_response
from fric.identify.dynamics.plant import identify_plant
from fric.identify.gms.identify import identify_gms
from fric.identify.strokes.static import identify_static
from fric.io.hdf5 import read_logs, write_logs
from fric.reproduce.workshop import Workshop
from fric.simulate.experiment import EXPERIMENTS, experiment

REPEATS = {"constant-velocity": 3}
"""How often an experiment is made, each with noise of its own: sigma is a small part of what a stroke shows."""

SAMPLES = {"constant-velocity": 16_384, "presliding-sine": 4096, "sliding-sine": 4096, "frequency-response": 16_000}


@dataclass(frozen=True)
class AxisFiles:
    """The files of one axis in the folder of a reproduction.

    Parameters
    ----------
    folder
        Where they are.
    """

    folder: Path

    def log(self, kind: str) -> Path:
        """Return the log of one kind of experiment."""
        return self.folder / f"{kind}.h5"

    def __getattr__(self, name: str) -> Path:
        endings = {
            "plant": "yaml", "static": "yaml", "friction": "yaml", "controller": "yaml", "observer": "yaml",
            "fig_plant": "png", "fig_2": "png", "fig_4_5": "png", "fig_7": "png",
        }  # fmt: skip
        if name not in endings:
            raise AttributeError(name)
        return self.folder / f"{name.replace('_', '-')}.{endings[name]}"


STEPS = (*EXPERIMENTS, "plant", "static map", "GMS", "controller", "observer")


def learn_axis(
    machine: Path, axis: str, folder: Path, *, seed: int, published_plant: bool
) -> Iterator[tuple[str, bool]]:
    """Make the experiments on one axis and identify all from their logs; yield each step's name, and whether it ran.

    Parameters
    ----------
    machine
        The machine file.
    axis
        Name of the axis.
    folder
        Where the files of this axis go.
    seed
        Seed of all noise.
    published_plant
        True where the drive's own linear damping is taken from the machine file, which prints eq. (1), and not from
        the response: the response's A holds the guideway's sigma too, and the two could not be told apart.
    """
    shop, files = Workshop(folder), AxisFiles(folder)

    def made(name: str, make: Any, reads: Sequence[Path], leaves: Sequence[Path], **settings: Any) -> tuple[str, bool]:
        return name, shop.step(name, make, reads=reads, leaves=leaves, settings={"axis": axis, **settings})

    for kind in EXPERIMENTS:
        make = partial(_experiment, machine, axis, kind, files, seed)
        yield made(
            kind, make, [machine], [files.log(kind)], seed=seed, samples=SAMPLES[kind], repeats=REPEATS.get(kind, 1)
        )
    response, strokes = files.log("frequency-response"), files.log("constant-velocity")
    yield made("plant", lambda: _plant(files), [response], [files.plant, files.fig_plant])
    yield made(
        "static map",
        lambda: _static(files, machine if published_plant else None, axis),
        [machine, strokes, files.plant],
        [files.static, files.fig_2],
        published_plant=published_plant,
    )
    loops = [files.log("presliding-sine"), files.log("sliding-sine")]
    yield made(
        "GMS",
        lambda: _gms(files, loops, machine if published_plant else None, axis),
        [machine, *loops, files.static, files.plant],
        [files.friction, files.fig_4_5],
        published_plant=published_plant,
    )
    yield made("controller", lambda: _controller(files, machine, axis), [machine, files.plant], [files.controller])
    yield made(
        "observer",
        lambda: _observer(files),
        [files.plant, files.controller, response],
        [files.observer, files.fig_7],
    )


def _experiment(machine: Path, axis: str, kind: str, files: AxisFiles, seed: int) -> None:
    subject = read_machine(machine).axis(axis)
    settings = {} if kind == "frequency-response" else {"samples": SAMPLES[kind]}
    logs = []
    for n in range(REPEATS.get(kind, 1)):
        made = experiment(subject, kind, seed=1000 * seed + n, **settings)
        logs += [replace(log, source=machine.name, name=f"{log.name}-{n + 1}" if n else log.name) for log in made]
    write_logs(files.log(kind), logs, force=True)


def _plant(files: AxisFiles) -> None:
    logs = read_logs(files.log("frequency-response"))
    fit = identify_plant(logs)
    write_document(files.plant, plant_tree(fit, logs), force=True)
    save_figure(draw_plant(fit), files.fig_plant, force=True)


def _damping_plant(files: AxisFiles, machine: Path | None, axis: str) -> Any:
    if machine is not None:
        return read_machine(machine).axis(axis).plant
    document = read_document(files.plant, PlantDocument)
    return read_plant(files.plant, axis=axis, motion=document.motion)


def _static(files: AxisFiles, machine: Path | None, axis: str) -> None:
    logs = read_logs(files.log("constant-velocity"))
    fit = identify_static(logs, plant=_damping_plant(files, machine, axis))
    write_document(files.static, static_tree(fit, logs), force=True)
    save_figure(draw_static_map(fit), files.fig_2, force=True)


def _gms(files: AxisFiles, loops: Sequence[Path], machine: Path | None, axis: str) -> None:
    logs = read_logs(loops)
    given = read_static(files.static, axis=axis, motion=logs[0].motion)
    fit = identify_gms(logs, static=given.static, negative=given.negative, plant=_damping_plant(files, machine, axis))
    write_document(files.friction, gms_tree(fit, logs, given), force=True)
    save_figure(draw_gms(fit), files.fig_4_5, force=True)


def _controller(files: AxisFiles, machine: Path, axis: str) -> None:
    document = read_document(files.plant, PlantDocument)
    own = read_machine(machine).axis(axis).cascade
    design = design_cascade(
        document.linear(document.motion),
        sampling=own.sampling,
        velocity_filter=own.velocity_filter,
        limit=own.limit,
    )
    write_document(files.controller, controller_tree(design, axis, document.motion), force=True)


def _observer(files: AxisFiles) -> None:
    document = read_document(files.plant, PlantDocument)
    plant = document.linear(document.motion)
    cascade = read_document(files.controller, ControllerDocument).cascade(document.motion)
    logs = read_logs(files.log("frequency-response"))
    response = measure_response(logs[0])
    Delta = measured_perturbation(response.table, plant, sampling=response.sampling)
    design = design_observer(plant, cascade, perturbation=Delta)
    write_document(files.observer, observer_tree(design, document.axis, document.motion, logs), force=True)
    save_figure(q_filter_figure(design), files.fig_7, force=True)
