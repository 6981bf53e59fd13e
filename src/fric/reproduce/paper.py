"""The paper from end to end: both axes learned, then the circles with what was learned."""

import json
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from shutil import copyfile
from typing import Annotated, Any

from matplotlib.figure import Figure

from fric.control.scheme import choose_schemes
from fric.documents.base import provenance
from fric.documents.bundled import located
from fric.documents.contours import ReproductionDocument
from fric.documents.machine_files import MachineDocument, read_machine
from fric.documents.yaml import plain, read_document, read_tree, write_document
from fric.errors import FricError
from fric.figures.circle import polar_figure
from fric.figures.style import save_figure
from fric.io.run import read_runs, write_runs
from fric.output import staged
from fric.reproduce.axis import STEPS, AxisFiles, learn_axis
from fric.reproduce.page import write_page
from fric.reproduce.step_cache import StepCache
from fric.results.base import DataFrame, Result
from fric.results.circle import CircleResult
from fric.results.given import Advance, silent
from fric.results.kinds import MachineFile, Seed
from fric.results.text import Piece
from fric.simulate.circle import Circle, CircleRun, run_circle
from fric.simulate.contour_run import pair
from fric.simulate.machine import Machine
from fric.simulate.processes import end_with_parent
from fric.units import readable
from fric.verb import Kind, verb
from fric.verdict import facts

FEEDS = (0.1, 0.01)
"""Feeds of Fig. 8 and Fig. 9 [m/s]."""

MOST_SAMPLES = 30_000
"""Samples of a trace that a run file keeps: a folder is to be sent by mail."""


@dataclass(frozen=True, eq=False, repr=False)
class Reproduction(Result, schema=ReproductionDocument):
    """What a reproduction left.

    Parameters
    ----------
    machine
        The machine that was reproduced.
    page
        The page that sets it all beside the paper.
    runs
        The six schemes, by feed [m/s].
    steps, made
        Steps there are, and how many had to be made.
    """

    machine: Machine
    page: Path
    runs: Mapping[float, list[CircleRun]]
    steps: int
    made: int

    def circles(self) -> list[CircleResult]:
        """Return what each scheme leaves, a circle a feed."""
        return [CircleResult(self.machine, runs) for runs in self.runs.values()]

    def report(self) -> list[Piece]:
        """Return the circles beside the paper's, where the page is, and the conclusion."""
        tables = [piece for circle in self.circles() for piece in circle.report()]
        made = f"{self.made} of {self.steps} steps were run, the rest was up to date"
        return [*tables, made, str(self.page), *map(self._conclusion, self.runs)]

    def _conclusion(self, feed: float) -> str:
        """Return what the best scheme leaves at a feed, and how near that is to what was published."""
        runs, published = self.runs[feed], self.machine.published_glitches(self.runs[feed][0].circle.radius, feed)
        glitches = {run.scheme.name: run.chance().median for run in runs}
        best, bare = min(runs, key=lambda run: glitches[run.scheme.name]), next(run for run in runs if run.scheme.bare)
        before, after = (readable(glitches[run.scheme.name], "m", 2) for run in (bare, best))
        text = f"At {readable(feed, 'm/s')}: ({best.scheme.name}) {best.scheme.title} leaves {after} of {before}"
        off = [abs(glitches[name] - glitch) for name, glitch in published.items() if name in glitches]
        return f"{text}; within {readable(max(off), 'm', 2)} of the published glitches." if off else f"{text}."

    def figure(self) -> Figure:
        """Return the circles at the first feed."""
        return self.circles()[0].figure()

    def to_frame(self) -> DataFrame:
        """Return what each scheme leaves [m], by feed and scheme."""
        import pandas as pd

        return pd.concat({feed: circle.to_frame() for feed, circle in zip(self.runs, self.circles(), strict=True)})


def reproduction_steps(axes: int = 2) -> int:
    """Return how many steps a reproduction has."""
    return axes * len(STEPS) + len(FEEDS) + 2


@verb
def reproduce_paper(
    folder: Annotated[Path | str, Kind(metavar="DIR")] = "reproduction",
    machine: MachineFile = "xy-table",
    *,
    seed: Seed = 1,
    advance: Advance = silent,
) -> Reproduction:
    """Run the paper from end to end: experiments, identification, design, six schemes, and a page beside the paper.

    Steps whose inputs have not changed are not run again. The controller of the circles believes what was identified
    from the virtual experiments, and nothing else; true is what the machine file says. Where the machine file holds
    published glitches, its plant counts as published too, and the drive's own damping is taken from it (see
    `learn_axis`).

    Parameters
    ----------
    folder
        Folder for logs, YAML, runs, figures and the page. Steps whose inputs have not changed are not made again.
    machine
        A machine of your own; else the paper's. Its file, or the name of a bundled one.
    seed
        Seed of all noise.
    advance
        Is called for each step that is done.

    Raises
    ------
    FricError
        When the machine or its folder does not allow it.
    """
    folder, machine = Path(folder), located(Path(machine), "machine")
    advance(0, total=reproduction_steps())
    shop = StepCache(folder)
    subject = read_machine(machine)
    names = pair(subject, both=True)
    given = folder / "given-machine.yaml"
    if not given.exists() or given.read_bytes() != machine.read_bytes():
        with staged(given, force=True) as draft:
            copyfile(machine, draft)
    made = 0
    for _, ran in _learn(machine, names, folder, seed, bool(subject.published)):
        made += ran
        advance()
    files = {name: AxisFiles(folder / name) for name in names}
    learned = [path for file in files.values() for path in file.learned]
    identified = folder / "machine.yaml"
    make = partial(_identified_machine, machine, files, identified)
    ran = shop.step("machine", make, reads=[machine, *learned], leaves=[identified])
    made += ran
    advance()
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
        advance()
        runs[feed] = [run for run in read_runs(run_file) if isinstance(run, CircleRun)]
    page = folder / "index.html"
    figures = [path for file in files.values() for path in (file.fig_plant, file.fig_2, file.fig_4_5, file.fig_7)]
    reads = [machine, *learned, *figures, *(path for feed in FEEDS for path in circle_files(folder, feed))]
    shown = {feed: (found, circle_files(folder, feed)[1]) for feed, found in runs.items()}
    run_files = [circle_files(folder, feed)[0] for feed in FEEDS]
    ran = shop.step("page", lambda: write_page(page, machine, files, shown, run_files), reads=reads, leaves=[page])
    made += ran
    advance()
    return Reproduction(subject, page, runs, reproduction_steps(len(names)), made)


def circle_files(folder: Path, feed: float) -> tuple[Path, Path]:
    """Return the run file and the figure of the circles at one feed [m/s]."""
    stem = f"circle-{1e3 * feed:g}mm_s"
    return folder / f"{stem}.h5", folder / f"fig-{'8' if feed == FEEDS[0] else '9'}.png"


def _learn(
    machine: Path, names: tuple[str, ...], folder: Path, seed: int, published: bool
) -> Iterator[tuple[str, bool]]:
    """Learn the axes side by side, each in a process of its own."""
    with ProcessPoolExecutor(max_workers=len(names), initializer=end_with_parent) as pool:
        work = {name: pool.submit(_learned, machine, name, folder / name, seed, published) for name in names}
        for name, future in work.items():
            for step, ran in future.result():
                yield f"{name}: {step}", ran


def _learned(machine: Path, axis: str, folder: Path, seed: int, published: bool) -> list[tuple[str, bool]]:
    return list(learn_axis(machine, axis, folder, seed=seed, published_plant=published))


def _identified_machine(machine: Path, files: Mapping[str, AxisFiles], output: Path) -> None:
    """Write the machine again, with controllers that believe what was identified."""
    tree: dict[str, Any] = plain(read_tree(machine))
    for name, file in files.items():
        axis = tree["axes"][name]
        place = {key: f"{name}/{getattr(file, key).name}" for key in ("plant", "controller", "observer", "friction")}
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
    write_runs(run_file, runs, json.dumps(facts(subject, runs)), most_samples=MOST_SAMPLES, force=True)
    save_figure(polar_figure(runs), figure, force=True)
