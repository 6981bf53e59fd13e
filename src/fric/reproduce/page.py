"""The page of a reproduction: every table and figure of the paper beside ours."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from fric.documents.controller import ControllerDocument
from fric.documents.friction import FrictionDocument
from fric.documents.machine import MachineDocument
from fric.documents.observer import ObserverDocument
from fric.documents.plant import PlantDocument
from fric.documents.yaml import read_document
from fric.output import staged
from fric.report.collect import collect
from fric.report.page import render_view
from fric.report.view import view
from fric.reproduce.axis import AxisFiles
from fric.reproduce.compare import (
    Row,
    SchemeRow,
    design_rows,
    gms_rows,
    largest_difference,
    plant_rows,
    scheme_rows,
    static_rows,
)
from fric.simulate.circle import CircleRun


@dataclass(frozen=True)
class AxisPage:
    """The part of the page that is of one axis: comparisons by title, figures as PNG by name."""

    name: str
    tables: Mapping[str, Sequence[Row]]
    figures: Mapping[str, bytes]


@dataclass(frozen=True)
class CirclePage:
    """The part of the page that is of one feed."""

    feed: float
    rows: Sequence[SchemeRow]
    largest: float | None
    figure: bytes


def write_page(
    page: Path,
    machine: Path,
    files: Mapping[str, AxisFiles],
    runs: Mapping[float, tuple[list[CircleRun], Path]],
    run_files: Sequence[Path],
) -> None:
    """Write the page of a reproduction: the report of what was learned and run, and the paper beside it.

    page: The file.
    machine: The machine file that all began with.
    files: What is known of each axis.
    runs: Runs and figure of the circles, by feed [m/s].
    run_files: The files of these runs.
    """
    document = read_document(machine, MachineDocument)
    subject = document.machine()
    circles = []
    for feed, (found, figure) in runs.items():
        rows = scheme_rows(found, subject.published_glitches(found[0].circle.radius, feed))
        circles.append(CirclePage(feed, rows, largest_difference(rows), figure.read_bytes()))
    inputs = collect([*(path for one in files.values() for path in one.learned), *run_files])
    text = render_view(
        replace(view(inputs), axes=()), inputs, f"{subject.name}: the paper from end to end", "reproduce.html.j2",
        published=bool(subject.published), circles=circles,
        axes=[_axis(name, one, document, bool(subject.published)) for name, one in files.items()],
    )  # fmt: skip
    with staged(page, force=True) as draft:
        draft.write_text(text, encoding="utf-8")


def _axis(name: str, files: AxisFiles, document: MachineDocument, published: bool) -> AxisPage:
    part = document.axes[name]
    plant, friction = read_document(files.plant, PlantDocument), read_document(files.friction, FrictionDocument)
    controller = read_document(files.controller, ControllerDocument)
    observer = read_document(files.observer, ObserverDocument)
    tables = {
        "Plant, eq. (1)": plant_rows(part, plant, part.motion),
        "Static friction map, eq. (2) and Table 1": static_rows(part, friction, part.motion, published_plant=published),
        "GMS model, eqs. (3) to (6) and Table 1": gms_rows(part, friction, part.motion),
        "Controller and observer": design_rows(part, controller, observer, part.motion),
    }
    figures = {
        "Fig. 2 – friction over velocity, measured and fitted": files.fig_2.read_bytes(),
        "Figs. 4 and 5 – pre-sliding cycles, virgin curve with its knots, replay": files.fig_4_5.read_bytes(),
        "Fig. 7 – how far the Q-filter may reach": files.fig_7.read_bytes(),
        "The plant's frequency response": files.fig_plant.read_bytes(),
    }
    return AxisPage(name, tables, figures)
