"""The paper from end to end: both axes learned, circles with what was learned, and a page of all beside the paper."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, wait
from dataclasses import dataclass, replace
from functools import partial
from math import isfinite
from pathlib import Path
from shutil import copyfile
from typing import Annotated, Any

import numpy as np
from matplotlib.figure import Figure

from fric.control.scheme import choose_schemes
from fric.documents.base import provenance
from fric.documents.bundled import located
from fric.documents.contours import ReproductionDocument
from fric.documents.controller import ControllerDocument, ObserverDocument
from fric.documents.friction import FrictionDocument
from fric.documents.machine_files import AxisPart, MachineDocument, read_machine, read_machine_document
from fric.documents.plant import PlantDocument
from fric.documents.yaml import read_document, write_document
from fric.estimate import Estimate, elements, in_digits
from fric.figures.circle import polar_figure
from fric.figures.style import save_figure
from fric.friction.gms import GMS
from fric.friction.stribeck import STATIC_PARAMETERS
from fric.io.circle import read_runs, write_runs
from fric.io.hdf5 import write_logs
from fric.output import staged, written
from fric.process import tried
from fric.report.collect import collect
from fric.report.view import render_view, view
from fric.reproduce.step_cache import StepCache
from fric.results.base import Advance, DataFrame, Piece, Result, silent
from fric.results.design import design_controller, design_observer
from fric.results.identify import identify_gms, identify_plant, identify_static
from fric.results.kinds import MachineFile, Seed
from fric.results.simulate import CircleResult
from fric.simulate.contour_run import Circle, CircleRun, pair, run_circle
from fric.simulate.experiment import OF_THE_PAPER, experiment
from fric.simulate.machine import Machine
from fric.simulate.processes import end_with_parent
from fric.units import prefixed, readable
from fric.verb import Kind, verb
from fric.verdict import facts

POLL = 0.5  # Time between looks at which steps of axes were made [s]
REPEATS = {"constant-velocity": 3}  # Repetitions, each with its noise: sigma is a small part of the force in a stroke

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
        if name not in {"plant", "static", "friction", "controller", "observer"} and not name.startswith("fig_"):
            raise AttributeError(name)
        return self.folder / f"{name.replace('_', '-')}.{'png' if name.startswith('fig_') else 'yaml'}"


STEPS = len(OF_THE_PAPER) + 5  # Steps of an axis: experiments, plant, static map, GMS, controller, observer


def learn_axis(machine: Path, axis: str, folder: Path, *, seed: int, published_plant: bool) -> list[bool]:
    """Make the experiments on one axis and identify all from their logs; return of each step whether it ran.

    published_plant: True where the linear damping of the drive is taken from the machine file, which gives eq. (1), and
        not from the response: A of the response includes the guideway's sigma, and the two could not be separated.
    """
    shop, files, published = StepCache(folder), AxisFiles(folder), {"published_plant": published_plant}

    def made(name: str, make: Callable[[], None], reads: Sequence[Path], *leaves: Path, **settings: Any) -> bool:
        return shop.step(name, make, reads=reads, leaves=leaves, settings={"axis": axis, **settings})

    def found(name: str, find: Callable[[], Result], reads: Sequence[Path], *leaves: Path, **settings: Any) -> bool:
        return made(name, lambda: _save(find(), *leaves), reads, *leaves, **settings)

    def damping() -> Any:
        return read_machine(machine).axis(axis).plant if published_plant else files.plant

    ran = []
    for kind in OF_THE_PAPER:
        make, noise = partial(_experiment, machine, axis, kind, files, seed), {"seed": seed, "samples": SAMPLES[kind]}
        ran.append(made(kind, make, [machine], files.log(kind), repeats=REPEATS.get(kind, 1), **noise))
    response, strokes = files.log("frequency-response"), files.log("constant-velocity")
    waves = [files.log("presliding-sine"), files.log("sliding-sine")]
    return [
        *ran,
        found("plant", lambda: identify_plant(response), [response], files.plant, files.fig_plant),
        found(
            "static map",  # in the form of Table 1: one map
            lambda: identify_static(strokes, plant=damping(), delta=1.0, direction="both", over_position="off"),
            [machine, strokes, files.plant], files.static, files.fig_2, **published,
        ),
        found(
            "GMS", lambda: identify_gms(waves, static=files.static, plant=damping()),
            [machine, *waves, files.static, files.plant], files.friction, files.fig_4_5, **published,
        ),
        found("controller", lambda: _controller(files, machine, axis), [machine, files.plant], files.controller),
        found(
            "observer", lambda: design_observer(files.plant, response, controller=files.controller),
            [files.plant, files.controller, response], files.observer, files.fig_7,
        ),
    ]  # fmt: skip


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


FAR = 0.05  # Relative difference above which a row gives the reason
CURVE = 100e-6  # Length of the virgin curve that is compared [m]


@dataclass(frozen=True)
class ComparedRow:
    """A number beside the number it is compared with."""

    name: str
    given: str  # of the machine file, in ``unit``
    found: str  # the result, in ``unit``
    interval: str  # its 95 % interval, in ``unit``; empty where there is none
    unit: str
    difference: float | None  # relative; None where it means nothing
    reason: str = ""  # why it differs, where it differs much


Estimates = Mapping[str, Estimate]


def compared(names: Iterable[str], given: Estimates, found: Estimates, reasons: Mapping[str, str]) -> list[ComparedRow]:
    """Compare the numbers that both have, with a reason by name (that of "" for others) where they differ much."""
    rows = []
    for name in (name for name in names if name in given and name in found):
        row, reason = _row(name, given[name], found[name]), reasons.get(name) or reasons.get("", "")
        far = row.difference is None or abs(row.difference) > FAR or name in {"A", "observer cutoff"}
        rows.append(replace(row, reason=reason) if far else row)
    return rows


def plant_rows(part: AxisPart, found: PlantDocument) -> list[ComparedRow]:
    """Compare eq. (1) with the result of the response."""
    given = part.plant.estimates(part.motion)
    sigma = float(part.friction.estimates("static").get("sigma", Estimate(0.0, "")))
    M = float(given["K_f"]) / float(given["B"])
    reason = (
        f"The response was measured while sliding: its A holds the guideway's viscous friction over the moving mass, "
        f"sigma/M = {sigma / M:.2f} 1/s, besides the drive's own {float(given['A']):.2f} 1/s."
    )
    names, reasons = ("A", "B", "T_d", "K_f"), {"A": reason} if sigma else {}
    return compared(names, given, found.estimates(part.motion), reasons)


def static_rows(part: AxisPart, found: FrictionDocument, *, published_plant: bool) -> list[ComparedRow]:
    """Compare Table 1's map with the result of the strokes."""
    given, estimates = part.friction.estimates("static"), found.estimates("static")
    other = part.friction.static_negative is not None
    free = {name for name, estimate in estimates.items() if not (estimate.fixed or estimate.assumed)}
    reasons = {
        "sigma": ""
        if published_plant
        else "The drive's own damping that was taken off is the response's A, which holds the guideway's sigma too: "
        "the sum is right, and so is what is fed forward; the two cannot be told apart.",
        "offset": "The two directions differ; a map of both takes the difference for an offset." if other else "",
        "delta": "" if "delta" in free else "It was held at 1; `--delta free` fits it.",
        "v_s": "It follows the shape factor that was held." if "delta" in given and float(given["delta"]) != 1 else "",
        "": "The two directions have maps of their own here; this is one for both." if other else "",
    }
    return compared((*STATIC_PARAMETERS, "offset"), given, estimates, reasons)


def gms_rows(part: AxisPart, found: FrictionDocument) -> list[ComparedRow]:
    """Compare Table 1's blocks with those of the loops: block by block where there are as many, else by the curve."""
    given, estimates = part.friction.estimates("gms"), found.estimates("gms")
    true, model = (
        GMS.from_sections({n: document.estimates(n) for n in ("static", "gms")}) for document in (part.friction, found)
    )
    z = np.linspace(0.0, CURVE, 2001)
    apart = float(np.sqrt(np.mean((model.virgin_curve(z) - true.virgin_curve(z)) ** 2)))
    F_s = float(part.friction.estimates("static")["F_s"])
    many, few = len(true.alpha), len(model.alpha)
    blocks = f"{found.fit_of('gms').blocks or ''}." if few != many else ""
    C = _row("C", given["C"], estimates["C"])
    rows = [
        ComparedRow("slip blocks", str(many), str(few), "", "", None, blocks),
        ComparedRow("virgin curve, rms over 100 µm", "0", f"{apart:.2f}", "", "N", apart / F_s, "Relative to F_s."),
        replace(C, interval="assumed", reason="No sliding record was given.") if estimates["C"].assumed else C,
    ]
    if few == many:
        vectors = ({name: part[name] for name in ("alpha", "k")} for part in (given, estimates))
        rows += [_row(name, ours, other) for (name, ours), (_, other) in zip(*map(elements, vectors), strict=True)]
    return rows


def design_rows(part: AxisPart, controller: ControllerDocument, observer: ObserverDocument) -> list[ComparedRow]:
    """Compare the machine's controller and observer with those designed on the identified plant."""
    given, found = part.controller.estimates(part.motion), controller.estimates(part.motion)
    if part.observer:
        given = given | {"observer cutoff": part.observer.estimates(part.motion)["cutoff"]}
    found = found | {"observer cutoff": observer.estimates(part.motion)["cutoff"]}
    reasons = {"observer cutoff": f"{observer.reason[:1].upper()}{observer.reason[1:]}."}
    return compared(("K_v", "K_p", "K_i", "observer cutoff"), given, found, reasons)


def _row(name: str, given: Estimate, found: Estimate) -> ComparedRow:
    size, value = float(given), float(found)
    scale, unit = prefixed(size or value, found.unit)
    description, interval = in_digits(value, found.ci95, scale)
    difference = value / size - 1 if size else None
    return ComparedRow(
        name, f"{size * scale:.4g}", description, interval or ("fixed" if found.fixed else ""), unit, difference
    )


def write_page(
    page: Path, machine: Path, files: Mapping[str, AxisFiles], runs: Mapping[float, tuple[list[CircleRun], Path]],
    run_files: Sequence[Path],
) -> None:  # fmt: skip
    """Write the page of a reproduction: the report of what was learned and run, and the paper beside it."""
    document = read_document(machine, MachineDocument)
    subject = document.machine()
    circles = []
    for feed, (found, figure) in runs.items():
        published = subject.published_glitches(found[0].circle.radius, feed)
        bare = next(run.circularity.glitch for run in found if run.scheme.bare)
        rows: list[dict[str, Any]] = [
            {
                "run": run, "published": (paper := published.get(run.scheme.name)),
                "difference": None if paper is None else run.circularity.glitch - paper,
                "reduction": None if run.scheme.bare else 1 - run.circularity.glitch / bare,
            }
            for run in found
        ]  # fmt: skip
        off = [abs(row["difference"]) for row in rows if row["difference"] is not None]
        circles.append({"feed": feed, "rows": rows, "largest": max(off, default=None), "figure": figure.read_bytes()})
    inputs = collect([*(path for file in files.values() for path in file.learned), *run_files])
    text = render_view(
        view(inputs) | {"axes": ()}, inputs, f"{subject.name}: the paper from end to end", "reproduce.html.j2",
        published=bool(subject.published), circles=circles,
        axes=[_axis(name, file, document.axes[name], bool(subject.published)) for name, file in files.items()],
    )  # fmt: skip
    written(page, text, force=True)


def _axis(name: str, files: AxisFiles, part: AxisPart, published: bool) -> dict[str, Any]:
    """Return the part of the page that is of one axis: comparisons by title, figures as PNG by caption."""
    friction = read_document(files.friction, FrictionDocument)
    controller = read_document(files.controller, ControllerDocument)
    tables = {
        "Plant, eq. (1)": plant_rows(part, read_document(files.plant, PlantDocument)),
        "Static friction map, eq. (2) and Table 1": static_rows(part, friction, published_plant=published),
        "GMS model, eqs. (3) to (6) and Table 1": gms_rows(part, friction),
        "Controller and observer": design_rows(part, controller, read_document(files.observer, ObserverDocument)),
    }
    figures = {
        "Fig. 2 – friction over velocity, measured and fitted": files.fig_2,
        "Figs. 4 and 5 – pre-sliding cycles, virgin curve with its knots, replay": files.fig_4_5,
        "Fig. 7 – how far the Q-filter may reach": files.fig_7,
        "The plant's frequency response": files.fig_plant,
    }
    pictures = {caption: path.read_bytes() for caption, path in figures.items()}
    return {"name": name, "tables": tables, "figures": pictures}


FEEDS = {8: 0.1, 9: 0.01}  # Feeds by the figure of the paper that shows their circles [m/s]
MOST_SAMPLES = 30_000  # Samples of a trace that a run file keeps: a folder is to be sent by mail


class Reproduction(Result, schema=ReproductionDocument):
    """What a reproduction left."""

    machine: Machine  # The machine that was reproduced
    page: Path  # The page that sets it all beside the paper
    runs: Mapping[float, list[CircleRun]]  # The six schemes, by feed [m/s]
    steps: int  # Steps there are
    made: int  # How many of them had to be made

    def circles(self) -> list[CircleResult]:
        """Return what each scheme leaves, a circle a feed."""
        return [CircleResult(self.machine, runs) for runs in self.runs.values()]

    def report(self) -> list[Piece]:
        """Return the circles beside the paper's, where the page is, and the conclusion."""
        tables = [piece for circle in self.circles() for piece in circle.report()]
        made = f"{self.steps} steps: {self.made} run, {self.steps - self.made} up to date"
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
    return axes * STEPS + len(FEEDS) + 2


@verb
def reproduce_paper(
    folder: Annotated[Path | str, Kind(metavar="DIR")] = "reproduction", machine: MachineFile = "xy-table", *,
    seed: Seed = 1, advance: Advance = silent,
) -> Reproduction:  # fmt: skip
    """Run the paper from end to end: experiments, identification, design, six schemes, and a page beside the paper.

    Steps whose inputs have not changed are not run again. The controller of the circles believes what was identified
    from the virtual experiments, and nothing else; true is what the machine file says. Where the machine file holds
    published glitches, its plant counts as published too, and the drive's own damping is taken from it (see
    `learn_axis`).

    folder: Folder for logs, YAML, runs, figures and the page. Steps whose inputs have not changed are not made again.
    machine: A machine of your own; else the paper's. Its file, or the name of a bundled one.
    seed: Seed of all noise.
    advance: Is called for each step that is done.
    Raises FricError: When the machine or its folder does not allow it.
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
    files = {name: AxisFiles(folder / name) for name in names}
    learned = [path for file in files.values() for path in file.learned]
    figures = [path for file in files.values() for path in (file.fig_plant, file.fig_2, file.fig_4_5, file.fig_7)]
    circles = {feed: (folder / f"circle-{1e3 * feed:g}mm_s.h5", folder / f"fig-{n}.png") for n, feed in FEEDS.items()}
    identified, page = folder / "machine.yaml", folder / "index.html"
    runs: dict[float, list[CircleRun]] = {}
    ahead = 0  # Steps of axes that were counted while they were made

    def whole_page() -> None:
        shown = {feed: (found, circles[feed][1]) for feed, found in runs.items()}
        write_page(page, machine, files, shown, [run_file for run_file, _ in circles.values()])

    def steps() -> Iterator[bool]:
        nonlocal ahead
        with ProcessPoolExecutor(max_workers=len(names), initializer=end_with_parent) as pool:
            learn = partial(learn_axis, seed=seed, published_plant=bool(subject.published))
            before = sum(len(StepCache(folder / name)) for name in names)
            learnings = [pool.submit(learn, machine, name, folder / name) for name in names]
            tried(f"axes {' and '.join(names)}")
            while wait(learnings, timeout=POLL).not_done:
                made_there = sum(len(StepCache(folder / name)) for name in names) - before
                advance(made_there - ahead)
                ahead = made_there
            for learning in learnings:
                yield from learning.result()
        make = partial(_identified_machine, machine, files, identified)
        yield shop.step("machine", make, reads=[machine, *learned], leaves=[identified])
        for feed, leaves in circles.items():
            make = partial(_circle, identified, feed, *leaves)
            yield shop.step(f"circle at {1e3 * feed:g} mm/s", make, reads=[identified, *learned], leaves=leaves)
            runs[feed] = [run for run in read_runs(leaves[0]) if isinstance(run, CircleRun)]
        reads = [machine, *learned, *figures, *(path for leaves in circles.values() for path in leaves)]
        yield shop.step("page", whole_page, reads=reads, leaves=[page])

    made = 0
    for n, ran in enumerate(steps()):
        made += ran
        advance(int(n >= ahead))
    return Reproduction(subject, page, runs, reproduction_steps(len(names)), made)


def _identified_machine(machine: Path, files: Mapping[str, AxisFiles], output: Path) -> None:
    """Write the machine again, with controllers that believe what was identified."""
    tree = read_machine_document(machine).tree()
    tree.pop("like", None)  # its axes are all here
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
    runs = [run_circle(subject, scheme, Circle(feed=feed)) for scheme in choose_schemes("all")]
    write_runs(run_file, runs, json.dumps(facts(subject, runs)), most_samples=MOST_SAMPLES, force=True)
    save_figure(polar_figure(runs), figure, force=True)
