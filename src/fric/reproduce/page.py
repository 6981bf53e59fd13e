"""The page of a reproduction: every table and figure of the paper beside ours."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fric.documents.controller import ControllerDocument, ObserverDocument
from fric.documents.friction import FrictionDocument
from fric.documents.machine_files import AxisPart, MachineDocument
from fric.documents.plant import PlantDocument
from fric.documents.yaml import read_document
from fric.estimate import Estimate, in_digits
from fric.friction.gms import GMS
from fric.friction.stribeck import STATIC_PARAMETERS
from fric.output import staged
from fric.report.collect import collect
from fric.report.page import render_view
from fric.report.view import view
from fric.reproduce.axis import AxisFiles
from fric.simulate.circle import CircleRun
from fric.units import Motion, prefixed

FAR = 0.05
"""Relative difference above which a row gives the reason."""

CURVE = 100e-6
"""Length of the virgin curve that is compared [m]."""


@dataclass(frozen=True)
class Row:
    """A number beside the number it is compared with."""

    name: str  # Its name
    # given, found: the value of the machine file, and the result, in ``unit``
    given: str
    found: str
    interval: str  # 95 % interval of what came out, in ``unit``; empty where there is none
    unit: str  # The unit that people read
    difference: float | None  # Relative difference; None where it means nothing
    reason: str = ""  # Why it differs, where it differs much


def plant_rows(part: AxisPart, found: PlantDocument, motion: Motion) -> list[Row]:
    """Compare eq. (1) with the result of the response."""
    given, estimates = part.plant.estimates(motion), found.estimates(motion)
    rows = [_row(name, given[name], estimates[name]) for name in ("A", "B", "T_d", "K_f") if name in estimates]
    sigma = float(part.friction.estimates("static").get("sigma", Estimate(0.0, "")))
    M = float(given["K_f"]) / float(given["B"])
    reason = (
        f"The response was measured while sliding: its A holds the guideway's viscous friction over the moving mass, "
        f"sigma/M = {sigma / M:.2f} 1/s, besides the drive's own {float(given['A']):.2f} 1/s."
    )
    return [_because(row, reason) if row.name == "A" and sigma else row for row in rows]


def static_rows(part: AxisPart, found: FrictionDocument, motion: Motion, *, published_plant: bool) -> list[Row]:
    """Compare Table 1's map with the result of the strokes."""
    given, estimates = part.friction.estimates("static"), found.estimates("static")
    names = [name for name in (*STATIC_PARAMETERS, "offset") if name in given]
    rows = [_row(name, given[name], estimates[name]) for name in names]
    other = part.friction.static_negative is not None
    reasons = {
        "sigma": ""
        if published_plant
        else "The drive's own damping that was taken off is the response's A, which holds the guideway's sigma too: "
        "the sum is right, and so is what is fed forward; the two cannot be told apart.",
        "offset": "The two directions differ; a map of both takes the difference for an offset." if other else "",
        "delta": "It was held at 1; `--delta free` fits it." if estimates["delta"].fixed else "",
        "v_s": "It follows the shape factor that was held." if "delta" in given and float(given["delta"]) != 1 else "",
    }
    two = "The two directions have maps of their own here; this is one for both." if other else ""
    return [_because(row, reasons.get(row.name) or two) for row in rows]


def gms_rows(part: AxisPart, found: FrictionDocument, motion: Motion) -> list[Row]:
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
    rows = [
        Row("slip blocks", str(many), str(few), "", "", None, blocks),
        Row("virgin curve, rms over 100 µm", "0", f"{apart:.2f}", "", "N", apart / F_s, "Relative to F_s."),
        _row("C", given["C"], estimates["C"]) if not estimates["C"].assumed else _assumed(given["C"], estimates["C"]),
    ]
    if few == many:
        for name in ("alpha", "k"):
            rows += [
                _row(f"{name}_{n}", one, other)
                for n, (one, other) in enumerate(zip(_split(given[name]), _split(estimates[name]), strict=True), 1)
            ]
    return rows


def design_rows(
    part: AxisPart, controller: ControllerDocument, observer: ObserverDocument, motion: Motion
) -> list[Row]:
    """Compare the machine's controller and observer with those designed on the identified plant."""
    given = part.controller.estimates(motion) | (
        {"observer cutoff": part.observer.estimates(motion)["cutoff"]} if part.observer else {}
    )
    found = controller.estimates(motion) | {"observer cutoff": observer.estimates(motion)["cutoff"]}
    rows = [_row(name, given[name], found[name]) for name in ("K_v", "K_p", "K_i", "observer cutoff") if name in given]
    return [
        _because(row, f"{observer.reason[:1].upper()}{observer.reason[1:]}.") if row.name == "observer cutoff" else row
        for row in rows
    ]


@dataclass(frozen=True)
class SchemeRow:
    """Result of a scheme on a circle, beside the published result."""

    run: CircleRun  # The run
    published: float | None  # The published glitch [m], where given
    reduction: float | None  # Share by which the glitch without compensation is reduced; None for that row itself

    @property
    def difference(self) -> float | None:
        """Glitch less the published glitch [m]."""
        return None if self.published is None else self.run.circularity.glitch - self.published


def scheme_rows(runs: Sequence[CircleRun], published: Mapping[str, float]) -> list[SchemeRow]:
    """Compare the six schemes with Table 2."""
    bare = next(run.circularity.glitch for run in runs if run.scheme.bare)
    return [
        SchemeRow(
            run, published.get(run.scheme.name), 1 - run.circularity.glitch / bare if not run.scheme.bare else None
        )
        for run in runs
    ]


def largest_difference(rows: Iterable[SchemeRow]) -> float | None:
    """Return the largest distance from a published glitch [m]; None where none was published."""
    found = [abs(row.difference) for row in rows if row.difference is not None]
    return max(found) if found else None


def _row(name: str, given: Estimate, found: Estimate) -> Row:
    size, value = float(given), float(found)
    scale, unit = prefixed(size or value, found.unit)
    description, interval = in_digits(value, found.ci95, scale)
    difference = value / size - 1 if size else None
    return Row(name, f"{size * scale:.4g}", description, interval or ("fixed" if found.fixed else ""), unit, difference)


def _assumed(given: Estimate, found: Estimate) -> Row:
    row = _row("C", given, found)
    return Row(row.name, row.given, row.found, "assumed", row.unit, row.difference, "No sliding record was given.")


def _because(row: Row, reason: str) -> Row:
    far = row.difference is None or abs(row.difference) > FAR or row.name in {"A", "observer cutoff"}
    if not (reason and far):
        return row
    return Row(row.name, row.given, row.found, row.interval, row.unit, row.difference, reason)


def _split(vector: Estimate) -> list[Estimate]:
    assert isinstance(vector.value, tuple)
    intervals = vector.ci95 or (None,) * len(vector.value)
    return [
        Estimate(value, vector.unit, interval if isinstance(interval, tuple) else None)
        for value, interval in zip(vector.value, intervals, strict=True)
    ]


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
    inputs = collect([*(path for file in files.values() for path in file.learned), *run_files])
    text = render_view(
        replace(view(inputs), axes=()), inputs, f"{subject.name}: the paper from end to end", "reproduce.html.j2",
        published=bool(subject.published), circles=circles,
        axes=[_axis(name, file, document, bool(subject.published)) for name, file in files.items()],
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
