"""From what was collected to what the page tells: rows of tables, figures, words."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeGuard

from fric.control import block_type
from fric.design.perturbation import Perturbation, model_perturbation
from fric.documents.plant import PlantDocument
from fric.errors import FricError
from fric.figures.contours import scheme_look
from fric.flaws import flaw_of
from fric.log import ForceVelocity, FrequencyResponse, Log, Record
from fric.notice import Notice
from fric.report.advice import observations
from fric.report.curves import friction_curves, presliding
from fric.report.drift import Change, block_counts, description, document_changes, glitch_changes
from fric.report.groups import Group, groups_of
from fric.report.measured import MeasuredView, gravest_first, measured_view
from fric.report.onepage import Summary, summary_of
from fric.report.plots import (
    Drawn,
    contour_figure,
    drift_figure,
    friction_map,
    hysteresis,
    magnification,
    motions,
    pictures,
    q_filter,
    reversal_figures,
    virgin_curves,
)
from fric.report.report_input import Contour, ContourTest, Item, ReportInput
from fric.results.design import perturbation_of
from fric.units import readable, rotates
from fric.verdict.evidence import Verdict


@dataclass(frozen=True)
class AxisView:
    """What is told of one axis."""

    name: str
    groups: Sequence[Group]
    figures: Sequence[Drawn]
    observer: Drawn | None
    notes: Sequence[str]
    further: Sequence[Drawn] = ()


@dataclass(frozen=True)
class Line:
    """One scheme in the table and among the switches of a contour."""

    contour: Contour
    reduction: float | None
    advised: bool
    look: Mapping[str, str]


@dataclass(frozen=True)
class TestView:
    """What is told of one contour."""

    test: ContourTest
    figure: Drawn
    reversals: Sequence[Drawn]
    lines: Sequence[Line]
    verdict: Verdict
    observations: Sequence[str]
    earlier: ContourTest | None
    blocks: Sequence[str] = ()
    further: Sequence[Drawn] = ()
    magnification: float | None = None

    __test__ = False  # no test of pytest's


@dataclass(frozen=True)
class DriftView:
    """What changed between two files."""

    title: str
    before: str
    after: str
    description: str
    changes: Sequence[Change]
    figure: Drawn | None


@dataclass(frozen=True)
class View:
    """All that the page tells."""

    summary: Summary
    warnings: Sequence[tuple[str, Sequence[Notice]]]
    axes: Sequence[AxisView]
    tests: Sequence[TestView]
    measured: Sequence[MeasuredView]
    logs: Sequence[tuple[str, str]]
    drifts: Sequence[DriftView]
    sources: Sequence[tuple[str, str, Any]]
    next_step: str


def view(inputs: ReportInput) -> View:
    """Return what a page tells of what was collected."""
    longest = presliding(inputs)
    earlier = {id(after): before for before, after in inputs.test_pairs}
    tests = [_test(n, inputs, test, earlier.get(id(test)), longest) for n, test in enumerate(inputs.tests)]
    sources = [(item.source, item.kind, item.provenance) for item in (*inputs.items, *inputs.replaced)]
    sources += [(before.source, f"{before.kind}, earlier", before.provenance) for before, _ in inputs.pairs]
    sources += [(test.source, "run", test.provenance) for test in inputs.tests]
    sources += [(before.source, "run, earlier", before.provenance) for before, _ in inputs.test_pairs]
    sources += [(one.source, "measured circle", {}) for one in inputs.circles]
    measured = [measured_view(one, f"circle-{n}") for n, one in enumerate(inputs.circles)]
    warnings = _warnings(inputs, [test.verdict for test in tests])
    next_step = _next_step(inputs)
    return View(
        summary_of(inputs, [(test.figure.title, test.verdict) for test in tests], measured, warnings, next_step),
        warnings, [_axis(inputs, axis) for axis in inputs.axes()], tests, measured, inputs.logs,
        list(_drifts(inputs)), sources, next_step,
    )  # fmt: skip


def _warnings(inputs: ReportInput, verdicts: Sequence[Verdict]) -> list[tuple[str, list[Notice]]]:
    """Return the warnings by where they are from, each once, the gravest first; what a circle settled is a note."""
    found: list[tuple[str, Sequence[Notice]]] = [
        (f"{item.kind} of axis {item.axis}", item.warnings) for item in inputs.items
    ]
    for test in inputs.tests:
        texts = inputs.warned(test)
        for one in test.contours:
            texts += [notice.at(f"scheme ({one.scheme.name})") for notice in one.warnings]
        found.append((f"run {test.source}", texts))
    found += [(f"circle {one.source}", list(one.result.warnings)) for one in inputs.circles]
    settled = {str(text) for one in verdicts for text in one.settled}
    settled |= {
        str(text) for one in inputs.circles for text in one.result.warnings
        if flaw_of(text).disagrees and settled.issuperset(one.disagreements())
    }  # fmt: skip
    settled -= {str(text) for one in verdicts for text in one.why}
    return [
        (source, gravest_first([_settled(one) if one in settled else one for one in dict.fromkeys(texts)]))
        for source, texts in found
        if texts
    ]


def _settled(text: Notice) -> Notice:
    return text.at("settled, for the machines that were drawn show the measured circle", severity="note")


def _axis(inputs: ReportInput, axis: str) -> AxisView:
    items = [item for item in inputs.items if item.axis == axis]
    groups = [group for item in items for group in groups_of(item)]
    figures: list[Drawn] = []
    notes: list[str] = []
    observer = None
    for item in items:
        if item.kind == "friction":
            curves = friction_curves(inputs, item)
            figures += friction_map(item, curves) if curves.maps else []
            figures += virgin_curves(item, curves) + hysteresis(item, curves)
            notes += curves.notes
        elif item.kind == "plant":
            figures += motions(item, [log for log in inputs.records if _is_motion(log, axis)])
        elif item.kind == "observer":
            observer = q_filter(item, perturbation(inputs, item))
    further = [one for item in items for one in pictures(item.document, f"{item.kind}-{axis}")]
    return AxisView(axis, groups, figures, observer, notes, further)


def _is_motion(log: Record, axis: str) -> TypeGuard[Log]:
    return isinstance(log, Log) and log.axis == axis and log.kind == "motion"


def perturbation(inputs: ReportInput, item: Item) -> Perturbation | None:
    """Return Delta of an axis: measured where a frequency response and the plant were given, else the delay alone."""
    given = inputs.of("plant", item.axis)
    if given is None or not isinstance(given.document, PlantDocument):
        return None
    try:
        plant = given.document.linear(item.motion)
    except FricError:  # without B, which the warnings of the plant file tell
        return None
    for record in inputs.records:
        if isinstance(record, ForceVelocity) or record.axis != item.axis:
            continue
        if isinstance(record, FrequencyResponse) or record.kind == "frequency-response":
            return perturbation_of(record, given.document)[0]
    cutoff = float(item.sections()["observer"]["cutoff"])
    return model_perturbation(plant, 40 * cutoff)


def _test(
    n: int, inputs: ReportInput, test: ContourTest, earlier: ContourTest | None, longest: float | None
) -> TestView:
    verdict = inputs.verdict(test)
    bare = next((one for one in test.contours if one.scheme.bare), None)
    lines = [
        Line(
            one, None if bare is None or one is bare or not bare.glitch else 1 - one.glitch / bare.glitch,
            one is verdict.choice, scheme_look(k, one.scheme),
        )
        for k, one in enumerate(test.contours)
    ]  # fmt: skip
    asked = {
        kind.name: f"{kind.name} ({kind.kind}): {kind.asks}"
        for one in test.contours
        for kind in (block_type(one.scheme.controller), *one.scheme.block_types)
        if kind.name != "cascade"
    }
    figure = contour_figure(n, test, earlier)
    return TestView(
        test,
        figure,
        reversal_figures(n, test),
        lines,
        verdict,
        observations(test, longest),
        earlier,
        tuple(asked.values()),
        pictures(test.runs, f"run-{n}"),
        magnification(test) if test.radius is not None else None,
    )


def _drifts(inputs: ReportInput) -> Iterator[DriftView]:
    for n, (before, after) in enumerate(inputs.pairs):
        changes = document_changes(before, after)
        counts = block_counts(before, after)
        words = description(changes)
        if counts:
            words += f" The models have {counts[0]} and {counts[1]} blocks, which cannot be compared one by one."
        title = f"{after.kind.capitalize()} of axis {after.axis}"
        yield DriftView(
            title, _dated(before), _dated(after), words, changes, drift_figure(f"drift-{n}", title, changes)
        )
    for n, (earlier, later) in enumerate(inputs.test_pairs):
        changes = glitch_changes(earlier, later)
        what = f"circle of {readable(later.radius, 'm')}" if later.radius is not None else "path"
        title = f"Glitch: {what} at {readable(later.feed, 'm/s')}"
        figure = drift_figure(f"drift-run-{n}", title, changes)
        yield DriftView(title, _dated(earlier), _dated(later), description(changes), changes, figure)


def _dated(thing: Item | ContourTest) -> str:
    return f"{thing.source} ({thing.created[:10]})" if thing.created else thing.source


def _next_step(inputs: ReportInput) -> str:
    """Tell what is missing for an advice, where there is no run."""
    if inputs.tests:
        return ""
    has_gms = any("gms" in item.sections() for item in inputs.items if item.kind == "friction")
    frictions = [item for item in inputs.items if item.kind == "friction"]
    if not frictions and any((item.tree.get("fit") or {}).get("parameters") for item in inputs.items):
        return (
            "The motion gave mass, viscous and Coulomb friction. What happens at a reversal takes strokes at constant "
            "velocity (`fric identify static`) and slow sines (`fric identify gms`)."
        )
    if not frictions:
        return "No friction and no run was given. Begin with `fric identify static` on strokes at constant velocity."
    step = "" if has_gms else "The friction has no pre-sliding part yet; `fric identify gms` finds it from slow sines. "
    if all(rotates(item.motion) for item in frictions):
        return step + "What a compensation leaves is told by a circle of two linear axes, and this axis is rotary."
    return (
        step + "To see which compensation leaves how large a glitch, run `fric simulate circle MACHINE.yaml --friction "
        f"{frictions[0].axis}=FRICTION.yaml -o RUN.h5` and give RUN.h5 to `fric report` too."
    )
