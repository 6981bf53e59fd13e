"""The paper from end to end: both axes learned, then the circles with what was learned."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from shutil import copyfile
from typing import Any

import fric
from fric.control.scheme import choose_schemes
from fric.documents.machine import MachineDocument
from fric.documents.machine_files import read_machine
from fric.documents.provenance import provenance
from fric.documents.yaml import plain, read_document, read_tree, write_document
from fric.errors import FricError
from fric.figures.circle import polar_figure
from fric.figures.style import save_figure
from fric.io.run import read_runs, write_runs
from fric.reproduce.axis import STEPS, AxisFiles, learn_axis
from fric.reproduce.page import write_page
from fric.reproduce.workshop import Workshop
from fric.simulate.circle import Circle, CircleRun, pair, run_circle

FEEDS = (0.1, 0.01)
"""Feeds of Fig. 8 and Fig. 9 [m/s]."""

MOST_SAMPLES = 30_000
"""Samples of a trace that a run file keeps: a folder is to be sent by mail."""

Advance = Callable[[str, bool], None]


@dataclass(frozen=True)
class Reproduction:
    """What a reproduction left.

    Parameters
    ----------
    page
        The page that sets it all beside the paper.
    runs
        The six schemes, by feed [m/s].
    steps, made
        Steps there are, and how many had to be made.
    """

    page: Path
    runs: Mapping[float, list[CircleRun]]
    steps: int
    made: int


def paper_machine() -> Path:
    """Return the machine file of the paper's table, which comes with fric."""
    package = Path(fric.__file__).parent
    found = [folder / "configs" / "xy-table.yaml" for folder in (package, package.parents[1])]
    return next(path for path in found if path.exists())


def reproduction_steps(axes: int = 2) -> int:
    """Return how many steps a reproduction has."""
    return axes * len(STEPS) + len(FEEDS) + 2


def reproduce_paper(machine: Path, folder: Path, *, seed: int = 1, advance: Advance | None = None) -> Reproduction:
    """Run the paper from end to end on a machine: experiments, identification, design, circles, page.

    The controller of the circles believes what was identified from the virtual experiments, and nothing else; true is
    what the machine file says. Where the machine file holds published glitches, its plant counts as published too, and
    the drive's own damping is taken from it (see `learn_axis`).

    Parameters
    ----------
    machine
        The machine file.
    folder
        Where all files go. Steps whose inputs have not changed are not made again.
    seed
        Seed of all noise.
    advance
        Is told the name of each step that is done, and whether it was made.

    Raises
    ------
    FricError
        When the machine or its folder does not allow it.
    """
    tell = advance or (lambda name, made: None)
    shop = Workshop(folder)
    subject = read_machine(machine)
    names = pair(subject)
    given = folder / "given-machine.yaml"
    if not given.exists() or given.read_bytes() != machine.read_bytes():
        copyfile(machine, given)
    made = 0
    for name, ran in _learn(machine, names, folder, seed, bool(subject.published)):
        made += ran
        tell(name, ran)
    files = {name: AxisFiles(folder / name) for name in names}
    learned = [path for one in files.values() for path in (one.plant, one.controller, one.observer, one.friction)]
    identified = folder / "machine.yaml"
    make = partial(_identified_machine, machine, files, identified)
    ran = shop.step("machine", make, reads=[machine, *learned], leaves=[identified])
    made += ran
    tell("machine", ran)
    runs: dict[float, list[CircleRun]] = {}
    for feed in FEEDS:
        run_file, figure = circle_files(folder, feed)
        ran = shop.step(
            f"circle at {1e3 * feed:g} mm/s",
            partial(_circle, identified, feed, run_file, figure),
            reads=[identified, *learned],
            leaves=[run_file, figure],
        )
        made += ran
        tell(f"circle at {1e3 * feed:g} mm/s", ran)
        runs[feed] = [run for run in read_runs(run_file) if isinstance(run, CircleRun)]
    page = folder / "index.html"
    figures = [path for one in files.values() for path in (one.fig_plant, one.fig_2, one.fig_4_5, one.fig_7)]
    reads = [machine, *learned, *figures, *(path for feed in FEEDS for path in circle_files(folder, feed))]
    shown = {feed: (found, circle_files(folder, feed)[1]) for feed, found in runs.items()}
    ran = shop.step("page", lambda: write_page(page, machine, files, shown), reads=reads, leaves=[page])
    made += ran
    tell("page", ran)
    return Reproduction(page, runs, reproduction_steps(len(names)), made)


def circle_files(folder: Path, feed: float) -> tuple[Path, Path]:
    """Return the run file and the figure of the circles at one feed [m/s]."""
    stem = f"circle-{1e3 * feed:g}mm_s"
    return folder / f"{stem}.h5", folder / f"fig-{'8' if feed == FEEDS[0] else '9'}.png"


def _learn(
    machine: Path, names: tuple[str, ...], folder: Path, seed: int, published: bool
) -> Iterator[tuple[str, bool]]:
    """Learn the axes side by side, each in a process of its own."""
    with ProcessPoolExecutor(max_workers=len(names)) as pool:
        work = {name: pool.submit(_learned, machine, name, folder / name, seed, published) for name in names}
        for name, future in work.items():
            for step, ran in future.result():
                yield f"{name}: {step}", ran


def _learned(machine: Path, axis: str, folder: Path, seed: int, published: bool) -> list[tuple[str, bool]]:
    return list(learn_axis(machine, axis, folder, seed=seed, published_plant=published))


def _identified_machine(machine: Path, files: Mapping[str, AxisFiles], output: Path) -> None:
    """Write the machine again, with controllers that believe what was identified."""
    tree: dict[str, Any] = plain(read_tree(machine))
    for name, one in files.items():
        axis = tree["axes"][name]
        place = {key: f"{name}/{getattr(one, key).name}" for key in ("plant", "controller", "observer", "friction")}
        axis |= {"nominal": place["plant"], "controller": place["controller"], "observer": place["observer"]}
        axis["feedforward"] = axis.get("feedforward", {}) | {"friction": place["friction"]}
    tree["provenance"] = provenance()
    write_document(output, tree, force=True)
    read_document(output, MachineDocument)


def _circle(machine: Path, feed: float, run_file: Path, figure: Path) -> None:
    subject = read_machine(machine)
    test = Circle(feed=feed)
    runs = [run_circle(subject, scheme, test) for scheme in choose_schemes("all")]
    if not runs:
        raise FricError("there is no scheme to run")
    write_runs(run_file, runs, json.dumps(provenance()), most_samples=MOST_SAMPLES, force=True)
    save_figure(polar_figure(runs), figure, force=True)
