"""The content of a page from the collected data, and its rendering by the templates of this folder."""

import re
from base64 import b64encode
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from functools import cache
from itertools import combinations
from math import degrees, isfinite, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

import fric
from fric.circles.tune import wrong_shape
from fric.control import block_type
from fric.control.scheme import OBSERVER
from fric.design.observer import Perturbation, model_perturbation
from fric.documents.base import Quantity, provenance
from fric.documents.friction import FrictionDocument
from fric.documents.plant import PlantDocument
from fric.errors import FricError, as_options, clean
from fric.estimate import Covariance, estimate_rows
from fric.figures.circle import scheme_look
from fric.flaws import flaw_of
from fric.io.recognise import REPORT_MARK
from fric.log import ForceVelocity, Log
from fric.notice import Notice
from fric.report import plots
from fric.report.collect import Change, Contour, ContourTest, Item, Measured, ReportInput, as_data, description
from fric.results.base import Table, plain_names
from fric.results.design import perturbation_of
from fric.units import microns, readable, rotates, short_of_1
from fric.verdict import EARNED, Candidate, Evidence, Verdict, bare, decide, machine_name

FIT = (("rmse", "rms of the residual"), ("r2", "R²"), ("points", "points"), ("method", "method"))
MATTERS = 0.9  # Correlation above which a pair is reported: a change of either number can replace the other's
SAME_SIGN_LEFT = 0.1  # Largest share of the glitch that a sufficient feedforward leaves
UNEVEN = 1.3  # Ratio of the glitches of two axes, or of the two ends of an axis, above which they count as different


def groups_of(item: Item) -> Iterator[dict[str, Any]]:
    """Yield the numbers of a document by section, and those of the rigid axis identified from a motion."""
    document = item.document
    for section, estimates in item.sections().items():
        fit = document.fit_of(section) if isinstance(document, FrictionDocument) else getattr(document, "fit", None)
        shown = [(title, _fit_value(value)) for key, title in FIT if (value := getattr(fit, key, None)) is not None]
        block = getattr(fit, "covariance", None) if section != "plant" else None
        yield _group(item, section, {name: estimate.as_dict() for name, estimate in estimates.items()}, shown, block)
    fit = item.tree.get("fit") or {}
    if isinstance(document, PlantDocument) and fit.get("parameters"):
        words = [("points", str(fit["points"]))] if fit.get("points") else []
        if fit.get("relative_error"):
            words.append(("residual of the force", f"{100 * fit['relative_error']['value']:.2f} %"))
        yield _group(item, "motion", fit["parameters"], words, document.fit.covariance if document.fit else None)


def _group(
    item: Item, section: str, entries: Mapping[str, Mapping[str, Any]], fit: Sequence[tuple[str, str]], block: Any
) -> dict[str, Any]:
    rows = estimate_rows(entries)
    return {
        "section": section, "source": item.source, "fit": fit,
        "rows": [(*row, name) for row, name in zip(rows, plain_names(row[0] for row in rows), strict=True)],
        "correlations": correlations(block.covariance()) if block is not None else (),
    }  # fmt: skip


def _fit_value(value: Any) -> str:
    if isinstance(value, Quantity):
        return readable(float(value.value), value.unit)  # type: ignore[arg-type]
    return short_of_1(value) if isinstance(value, float) else str(value)


def correlations(covariance: Covariance) -> list[str]:
    """Return the pairs of parameters whose correlation is `MATTERS` or more, the closest first."""
    found = []
    for i, j in combinations(range(len(covariance.names)), 2):
        size = covariance.matrix[i][i] * covariance.matrix[j][j]
        if size > 0 and abs(r := covariance.matrix[i][j] / size**0.5) >= MATTERS:
            found.append((abs(r), f"{covariance.names[i]} and {covariance.names[j]} ({r:+.3f})".replace("-", "−")))
    return [text for _, text in sorted(found, reverse=True)]


def measured_view(measured: Measured, key: str, tolerance: float | None) -> dict[str, Any]:
    """Return the content about a measured circle; its figures are named by the key."""
    result = measured.result
    test, held, glitch = result.found.test, result.held, result.found.glitch
    alt = "The radial deviation as a polar plot, and over time at each reversal"
    alt += f"{', measured and predicted' if held else ''}; the tables have the numbers."
    caption = "Left: deviation of the radius. Right: the glitch over the time after each reversal."
    caption += " Solid: measured; dashed: predicted." if held else ""
    title = f"ircle of {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}"
    of = " and ".join(name.upper() for name in test.names)
    said = f"{measured.source}, c{title}: measured glitch of {of} at most {readable(glitch, 'm', 3)}"
    if tolerance is not None:
        said += ", within the tolerance" if glitch <= tolerance else ", beyond the tolerance"
    if held:
        said += f"; what the machine file predicts for scheme ({held.scheme}) {held.said}"
    return {
        "title": f"C{title}", "source": measured.source, "said": f"{said}.", "held": held, "causes": result.causes(),
        "tables": [piece for piece in result.report() if isinstance(piece, Table)],
        "picture": plots.PageFigure(f"{key}-diagnosis", "", caption, alt, result.figure()),
        "further": plots.pictures(result.found, key),
    }  # fmt: skip


def summary_of(
    inputs: ReportInput, verdicts: Sequence[Verdict], warnings: Sequence[tuple[str, Notice]]
) -> dict[str, Any]:
    """Return the summary of a page: facts, the stamp of the verdict that passes least, and what comes first."""
    names = dict.fromkeys(str(test.provenance.get("machine", "")) for test in inputs.tests)
    machine = "; ".join(filter(None, names)) or (machine_name(inputs.machine) if inputs.machine else "")
    files = [Path(inputs.machine).name] if inputs.machine else []
    files += [*(item.source for item in inputs.items), *(test.source for test in inputs.tests)]
    files += [*(circle.source for circle in inputs.circles), *(name for name, _ in inputs.logs + inputs.maps)]
    files += [item.source for item in (*inputs.replaced, *(before for before, _ in inputs.pairs + inputs.test_pairs))]
    made = datetime.fromisoformat(str(provenance()["created"]))
    facts = [("machine", machine)] if machine else []
    axes = dict.fromkeys([*inputs.axes(), *(name for test in inputs.tests for name in test.axes)])
    facts += [("axes", ", ".join(axes))] if axes else []
    facts += [("date", f"{made:%Y-%m-%d}"), ("files", ", ".join(dict.fromkeys(files)))]
    if inputs.tolerance is not None:
        facts.append(("tolerance", f"glitch within {readable(inputs.tolerance, 'm')}"))
    wrong = [(source, str(notice)) for source, notice in warnings if notice.severity == "wrong" and not verdicts]
    results = [verdict.result for verdict in verdicts] or [decide(Evidence(tolerance=inputs.tolerance)).result]
    stamp, meaning = min(results, key=lambda pair: ("fail", "not decided", "pass", "").index(pair[0]))
    kinds = [("notes" if notice.severity == "note" else "doubts", notice) for _, notice in warnings]
    further = Counter(kind for kind, notice in kinds if verdicts or notice.severity != "wrong")
    return {
        "facts": facts, "stamp": stamp, "meaning": meaning, "wrong": wrong, "further": further,
        "doubts": " and ".join(dict(kinds)).capitalize(), "next_step": _next_step(inputs), "failed": inputs.failed,
    }  # fmt: skip


def observations(test: ContourTest, presliding: float | None = None) -> list[str]:
    """Return the relevant differences between contours of a test, in addition to the verdict.

    presliding: Displacement over which friction builds up after a reversal [m], where a friction file holds it.
    """
    test = replace(test, contours=tuple(contour for contour in test.contours if isfinite(contour.middle)))
    found = [*overcompensation(test), *too_weak(test.contours), *observer_share(test), *observer_spoils(test)]
    found += uneven(test)
    learned = wrong_shape((contour.scheme, contour.middle) for contour in test.contours)  # leaves clearly less
    found += [f"{text[0].upper()}{text[1:]}." for text in learned]
    if presliding is not None and test.radius is not None:
        found.append(build_up(presliding, test.radius, test.feed))
    return found


def least(test: ContourTest) -> float:
    """Return the least relevant difference of two glitches [m], by effort, encoder, and chance.

    If the bare loop was not run, it is a share of the largest glitch.
    """
    without = bare(test.contours)
    size = max(contour.middle for contour in test.contours) if without is None else without.middle
    by_chance = max((contour.chance.half for contour in test.contours), default=0.0)
    return max(EARNED * size, float(test.provenance.get("resolution", 0.0)), by_chance)


def peak(contour: Candidate) -> float:
    """Return the glitch with its sign [m]: outwards is positive."""
    return max(contour.glitches, key=abs, default=0.0)


def overcompensation(test: ContourTest) -> list[str]:
    """Describe friction feedforward that leaves an inward spike where the bare loop has an outward spike."""
    if (without := bare(test.contours)) is None:
        return []
    large = [contour for contour in test.contours if contour.scheme.friction and contour.middle > least(test)]
    reversed_signs = [contour for contour in large if peak(contour) * peak(without) < 0]
    static = [contour for contour in reversed_signs if contour.scheme.friction == "static"]
    said = [
        f"{contour.named} overcompensates: its spike of {readable(contour.middle, 'm')} points the other way. The "
        "friction is fed forward too early or is too large: `fric tune` finds the lead and gain that leave least."
        for contour in reversed_signs
        if contour not in static
    ]
    if static:
        spikes = " and ".join(f"{contour.named} ({readable(contour.middle, 'm')})" for contour in static)
        text = (
            f"{spikes} overcompensate{'s' if len(static) == 1 else ''}: the spike points the other way. A static map "
            "switches at the reversal at once; true friction builds up over the pre-sliding, as a GMS model does."
        )
        said.insert(0, text)
    return said


def too_weak(contours: Sequence[Contour]) -> list[str]:
    """Describe a feedforward with pre-sliding that leaves a part of the glitch with the same sign at every reversal.

    The glitch of a linear loop is proportional to the friction that is not fed forward, so the share that is left
    is the share that the feedforward lacks.
    """
    if (without := bare(contours)) is None or not without.middle:
        return []
    for contour in contours:
        if contour.scheme.friction in {None, "static"} or contour.scheme.observer:
            continue
        left = contour.middle / without.middle
        same = all(a * b > 0 for a, b in zip(contour.glitches, without.glitches, strict=True))
        if same and left > SAME_SIGN_LEFT:
            return [
                f"{contour.named} leaves {left:.0%} of the glitch with the same sign at every reversal: it feeds "
                f"forward about {1 - left:.0%} of the friction. Raise its gain; only where that is 1, identify again."
            ]
    return []


def _pairs(contours: Sequence[Contour]) -> list[tuple[Contour, Contour]]:
    """Return each feedforward without and with the observer."""
    cascades = [contour for contour in contours if contour.scheme.controller == "cascade"]
    with_observer = {cascade.scheme.friction: cascade for cascade in cascades if cascade.scheme.blocks == (OBSERVER,)}
    alone = [cascade for cascade in cascades if not cascade.scheme.blocks and cascade.scheme.friction in with_observer]
    return [(contour, with_observer[contour.scheme.friction]) for contour in alone]


def observer_share(test: ContourTest) -> list[str]:
    """Describe how much the observer reduces the glitch of each feedforward."""
    parts = [
        f"{1 - with_it.middle / alone.middle:.0%} off "
        + ("the bare loop" if alone.scheme.friction is None else alone.named)
        for alone, with_it in _pairs(test.contours)
        if alone.middle - with_it.middle > least(test)
    ]
    return [f"The disturbance observer takes {', '.join(parts)}."] if parts else []


def observer_spoils(test: ContourTest) -> list[str]:
    """Describe an observer that makes a feedforward worse."""
    return [
        f"With the observer, {alone.named} gets worse by {readable(with_it.middle - alone.middle, 'm')}: does the "
        "observer see the feedforward? It must be given the control voltage without it, or friction is compensated "
        "twice."
        for alone, with_it in _pairs(test.contours)
        if with_it.middle - alone.middle > least(test)
    ]


def uneven(test: ContourTest) -> list[str]:
    """Name the axis, and its reversal, with the largest glitch of the bare loop."""
    if (without := bare(test.contours)) is None or test.radius is None:
        return []
    size = np.abs(without.glitches)
    first, second = float(size[[0, 2]].max()), float(size[[1, 3]].max())
    said = []
    if len(test.axes) == 2 and max(first, second) > UNEVEN * min(first, second):
        larger, lesser = ("x", "y") if first > second else ("y", "x")
        said.append(
            f"Axis {larger} has the larger glitch without compensation{test.of_file}, "
            f"{readable(max(first, second), 'm')} against {readable(min(first, second), 'm')} of {lesser}: begin there."
        )
    for axis, ends in (("x", (0, 2)), ("y", (1, 3))):
        first, other = (float(size[end]) for end in ends)
        if axis in test.axes and max(first, other) > UNEVEN * min(first, other):
            said.append(
                f"Axis {axis} shows {readable(first, 'm')} at +{axis} and {readable(other, 'm')} at -{axis}: its "
                "friction depends on direction or place. Identify with `direction='each'`."
            )
    return said


def build_up(presliding: float, radius: float, feed: float) -> str:
    """Describe the time after a reversal in which friction builds up.

    Near a reversal of a circle the axis moves as z = v²t²/(2R) = R·φ²/2, so a displacement z is reached at the angle
    φ = √(2z/R), after the time √(2zR)/v.
    """
    angle, time = sqrt(2 * presliding / radius), sqrt(2 * presliding * radius) / feed
    return (
        f"Friction builds up over {readable(presliding, 'm')} of pre-sliding. On this circle that is the first "
        f"{degrees(angle):.2g}° after each reversal, {readable(time, 's', 2)}: what a static map cannot follow."
    )


def view(inputs: ReportInput) -> dict[str, Any]:
    """Return the content of a page from the collected data."""
    longest = plots.presliding(inputs)
    earlier = {id(after): before for before, after in inputs.test_pairs}
    tests = [_test(n, inputs, test, earlier.get(id(test)), longest) for n, test in enumerate(inputs.tests)]
    sources = [(item.source, item.kind, item.provenance) for item in (*inputs.items, *inputs.replaced)]
    sources += [(before.source, f"{before.kind}, earlier", before.provenance) for before, _ in inputs.pairs]
    sources += [(test.source, "run", test.provenance) for test in inputs.tests]
    sources += [(before.source, "run, earlier", before.provenance) for before, _ in inputs.test_pairs]
    sources += [(circle.source, "measured circle", {}) for circle in inputs.circles]
    verdicts = [test["verdict"] for test in tests]
    warnings = _warnings(inputs, verdicts)
    return {
        "summary": summary_of(inputs, verdicts, warnings), "warnings": warnings, "tests": tests, "logs": inputs.logs,
        "axes": [_axis(inputs, axis) for axis in inputs.axes()], "drifts": list(_drifts(inputs)), "sources": sources,
        "measured": [measured_view(circle, f"circle-{n}", inputs.tolerance) for n, circle in enumerate(inputs.circles)],
    }  # fmt: skip


def _warnings(inputs: ReportInput, verdicts: Sequence[Verdict]) -> list[tuple[str, Notice]]:
    """Return the warnings with their source, each once, the gravest first; those that a circle settled are notes."""
    found: list[tuple[str, Sequence[Notice]]] = [(f"{it.kind} of axis {it.axis}", it.warnings) for it in inputs.items]
    for test in inputs.tests:
        texts = inputs.warned(test)
        for contour in test.contours:
            texts += [notice.at(f"scheme ({contour.scheme.name})") for notice in contour.warnings]
        found.append((f"run {test.source}", texts))
    found += [(f"circle {circle.source}", list(circle.result.warnings)) for circle in inputs.circles]
    settled = {str(text) for verdict in verdicts for text in verdict.settled}
    settled |= {
        str(text) for circle in inputs.circles for text in circle.result.warnings
        if flaw_of(text).disagrees and settled.issuperset(circle.result.disagreements(circle.source))
    }  # fmt: skip
    settled -= {str(text) for verdict in verdicts for text in verdict.why}
    first: dict[tuple[str, str], tuple[str, Notice]] = {}
    for source, several in found:
        for text in several:
            where = "settled: the drawn machines reproduce the measured circle"
            shown = text.at(where, severity="note") if text in settled else text
            first.setdefault((text.code, text.says), (source, shown))
    in_decision = {notice.says for verdict in verdicts for notice in verdict.why}  # beside the decision
    rest = (of for of in first.values() if of[1].says not in in_decision)
    return sorted(rest, key=lambda of: ("wrong", "doubt", "note").index(of[1].severity))


def _axis(inputs: ReportInput, axis: str) -> dict[str, Any]:
    items = [item for item in inputs.items if item.axis == axis]
    groups = [group for item in items for group in groups_of(item)]
    figures: list[plots.PageFigure] = []
    notes, halves = list[str](), list[str]()
    observer = None
    for item in items:
        if item.kind == "friction":
            curves = plots.friction_curves(inputs, item)
            figures += plots.friction_map(item, curves) if curves.maps else []
            figures += plots.virgin_curves(item, curves) + plots.hysteresis(item, curves)
            notes += curves.notes
            halves.append(curves.halves)
        elif item.kind == "plant":
            records = (log for log in inputs.records if isinstance(log, Log))
            logs = [log for log in records if log.axis == axis and log.kind == "motion"]
            figures += plots.motions(item, logs)
            halves.append(plots.agreement(logs))
        elif item.kind == "observer":
            observer = plots.q_filter(item, perturbation(inputs, item))
    further = [picture for item in items for picture in plots.pictures(item.document, f"{item.kind}-{axis}")]
    return {
        "name": axis, "groups": groups, "figures": figures, "observer": observer, "notes": notes, "further": further,
        "halves": [text for text in halves if text],
    }  # fmt: skip


def perturbation(inputs: ReportInput, item: Item) -> Perturbation | None:
    """Return Delta of an axis: measured if a frequency response and the plant were given, else of the delay alone."""
    if (given := inputs.of("plant", item.axis)) is None or not isinstance(given.document, PlantDocument):
        return None
    try:
        plant = given.document.linear(item.motion)
    except FricError:  # without B, as the warnings of the plant file state
        return None
    for record in inputs.records:
        if not isinstance(record, ForceVelocity) and record.axis == item.axis and record.kind == "frequency-response":
            return perturbation_of(record, given.document)[0]
    return model_perturbation(plant, 40 * float(item.sections()["observer"]["cutoff"]))


def _test(
    n: int, inputs: ReportInput, test: ContourTest, earlier: ContourTest | None, longest: float | None
) -> dict[str, Any]:
    verdict = inputs.verdict(test)
    without, chosen = bare(test.contours), verdict.choice
    now = 0.0 if without is None else without.middle
    lines = [
        {
            "contour": contour, "advised": contour is chosen, "look": scheme_look(k, contour.scheme),
            "reduction": 1 - contour.middle / now
            if now and contour is not without and isfinite(contour.middle) else None,
        }
        for k, contour in enumerate(test.contours)
    ]  # fmt: skip
    asked = {
        kind.name: f"{kind.name} ({kind.kind}): {kind.asks}" for contour in test.contours
        for kind in (block_type(contour.scheme.controller), *contour.scheme.block_types) if kind.name != "cascade"
    }  # fmt: skip
    sizes = {} if without in (None, chosen) else {"now": ("now", verdict.now)}
    if chosen is not None:
        sizes["with"] = (f"with {chosen.named}", readable(chosen.middle, "m", 2))
        sizes |= {"most": ("at most", readable(chosen.stays_under, "m", 2))} if chosen.drawn else {}
    return {
        "test": test, "earlier": earlier, "lines": lines, "verdict": verdict, "sizes": sizes,
        "observations": observations(test, longest), "blocks": tuple(asked.values()),
        "figure": plots.contour_figure(n, test, earlier), "reversals": plots.reversal_figures(n, test),
        "decision": plots.decision_figure(n, test, chosen) if isinstance(chosen, Contour) else None,
        "further": plots.pictures(test.runs, f"run-{n}"),
        "magnification": plots.magnification(test) if test.radius is not None else None,
    }  # fmt: skip


def _drifts(inputs: ReportInput) -> Iterator[dict[str, Any]]:
    for n, (before, after) in enumerate(inputs.pairs):
        counts, title = _block_counts(before, after), f"{after.kind.capitalize()} of axis {after.axis}"
        found = _drift(f"drift-{n}", title, before, after, before.changes(after))
        if counts:
            text = f" The models have {counts[0]} and {counts[1]} blocks, which cannot be compared one by one."
            found["description"] += text
        yield found
    for n, (early, late) in enumerate(inputs.test_pairs):
        what = f"circle of {readable(late.radius, 'm')}" if late.radius is not None else "path"
        title = f"Glitch: {what} at {readable(late.feed, 'm/s')}"
        yield _drift(f"drift-run-{n}", title, early, late, early.changes(late))


def _block_counts(before: Item, after: Item) -> tuple[int, int] | None:
    """Return the numbers of slip blocks in the GMS models of two friction documents, if they differ."""
    blocks = [item.sections().get("gms", {}).get("k") for item in (before, after)]
    counts = [len(k.value) if k is not None and isinstance(k.value, tuple) else 0 for k in blocks]
    return (counts[0], counts[1]) if all(counts) and counts[0] != counts[1] else None


def _drift(
    key: str, title: str, before: Item | ContourTest, after: Item | ContourTest, changes: list[Change]
) -> dict[str, Any]:
    dated = [f"{of.source} ({of.created[:10]})" if of.created else of.source for of in (before, after)]
    figure = plots.drift_figure(key, title, changes)
    return {"title": title, "dated": dated, "description": description(changes), "changes": changes, "figure": figure}


def _next_step(inputs: ReportInput) -> str:
    """Name what is missing for advice, if there is no run."""
    if inputs.tests:
        return ""
    if any(text.startswith("circle: ") for text in inputs.failed):
        return "The glitch under each compensation is not known: a circle could not be simulated."
    frictions = [item for item in inputs.items if item.kind == "friction"]
    if not frictions and any((item.tree.get("fit") or {}).get("parameters") for item in inputs.items):
        return (
            "The motion gave mass, viscous and Coulomb friction. The behaviour at a reversal needs strokes at "
            "constant velocity (`fric identify static`) and slow sines (`fric identify gms`)."
        )
    if not frictions:
        return "No friction and no run was given. Begin with `fric identify static` on strokes at constant velocity."
    step = "The friction has no pre-sliding part yet; `fric identify gms` finds it from slow sines. "
    step *= not any("gms" in item.sections() for item in frictions)
    if all(rotates(item.motion) for item in frictions):
        return step + "Compensations are compared on a circle of two linear axes, and this axis is rotary."
    if not inputs.machine:
        return (
            step + "The glitch under each compensation is not known yet: a circle needs plant and controller of axis "
            f"{frictions[0].axis}, too. `fric auto LOGS -o found` says which record is missing, and `fric "
            "plan` plans it."
        )
    given = f"{frictions[0].axis}={frictions[0].source}"
    command = f"fric simulate circle {machine_name(inputs.machine)} --friction {given}"
    return step + f"To compare the glitch under each compensation, run `{command} -o run.h5`, and report run.h5 too."


@cache
def environment() -> Environment:
    """Return the environment that every page of fric is rendered with.

    A page extends ``base.html.j2``. Text is escaped, a name that is not given is an error. Filters: ``readable``
    (``2.2e-5 | readable("m")`` is ``22 µm``), ``micrometres`` (a length as a bare
    number of µm, one decimal), ``percent`` (of a relative difference), ``embedded``
    (bytes of a picture as a ``data:`` address).
    """
    made = Environment(
        loader=PackageLoader("fric.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True, finalize=_shown,
    )  # fmt: skip
    made.filters |= {item.__name__: item for item in (readable, micrometres, embedded, percent, limit, minus)}
    made.policies["json.dumps_kwargs"] = {"separators": (",", ":")}
    made.globals["version"] = fric.__version__
    return made


def _shown(value: Any) -> Any:
    if isinstance(value, Markup):
        return Markup(clean(value))
    if not isinstance(value, str):
        return value
    parts = clean(as_options(value)).split("`")  # what is between two of them is code
    code = (Markup("<code>{}</code>").format(part) if n % 2 else escape(part) for n, part in enumerate(parts))
    return Markup().join(code) if len(parts) > 2 and len(parts) % 2 else "`".join(parts)


def micrometres(length: float | None, *, sign: bool = False) -> str:
    """Return a length [m] in µm with one decimal: ``micrometres(-9.13e-6) == "−9.1"``."""
    return minus(microns(length, sign="+" * sign))


def percent(share: float) -> str:
    """Return a relative difference in per cent with its sign: ``percent(-0.021) == "−2.1 %"``."""
    return "0.0 %" if (text := f"{100 * share:+.1f} %") in {"+0.0 %", "-0.0 %"} else minus(text)


def limit(value: float, unit: str) -> str:
    """Return a limit of an interval for people; an infinite limit is open."""
    return minus(readable(value, unit)) if isfinite(value) else "open"


def minus(text: str) -> str:
    """Return a text with minus signs for the hyphens before numbers and quadrants."""
    return re.sub(r"(?<!\S)-(?=[\dxy])", "−", text)


def embedded(picture: bytes, media: str = "image/svg+xml") -> str:
    """Return a picture as a ``data:`` address, so that the page needs no other file."""
    return f"data:{media};base64,{b64encode(picture).decode()}"


def render_report(inputs: ReportInput, title: str = "") -> str:
    """Return the report of what was collected as one HTML page that needs nothing else."""
    return render_view(view(inputs), inputs, title or _title(inputs))


def render_view(
    seen: Mapping[str, Any], inputs: ReportInput, title: str, template: str = "report.html.j2", **more: Any
) -> str:
    """Return a page by the report's template, or by a template that extends it with more data."""
    page, mark = environment().get_template(template), Markup(REPORT_MARK)
    return page.render(view=seen, maps=inputs.maps, title=title, data=as_data(inputs), mark=mark, **more)


def _title(inputs: ReportInput) -> str:
    names = [name for name in dict.fromkeys(str(test.provenance.get("machine", "")) for test in inputs.tests) if name]
    axes = inputs.axes()
    parts = names + ([f"axis {axes[0]}" if len(axes) == 1 else f"axes {', '.join(axes)}"] if axes else [])
    return "Friction report: " + "; ".join(parts or ["contours"])
