"""The figures of a page with headings and captions; `fric.figures` draws them.

Curves and bands come from documents, points and cycles from logs. In a page a figure is SVG that its script zooms,
reads and switches; no two figures share an id.
"""

import io
import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from math import floor, inf, log10
from typing import Any

import matplotlib as mpl
import numpy as np
from markupsafe import Markup
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.projections.polar import PolarAxes

from fric.arrays import Real
from fric.columns import PRESLIDING
from fric.control.q_filter import QFilter
from fric.design.observer import Perturbation
from fric.documents.friction import Fit, FrictionDocument
from fric.documents.plant import PlantDocument, PlantPart
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import Covariance, Estimate, elements
from fric.figures.circle import SchemeContour, after_reversal_figure, along_figure, draw_drift, overlay_figure
from fric.figures.gms import FrictionMap, MapBranches, ReplayedCycle, Virgin, cycles_figure, map_figure, virgin_figure
from fric.figures.loops import QReach, reach_figure
from fric.figures.plant import motion_figure
from fric.figures.style import BLUE, DRAWING, VERMILION, Band, laid_out, style, views
from fric.friction.gms import GMS
from fric.friction.stribeck import STATIC_PARAMETERS, StaticMap
from fric.identify.gms.virgin_curve import HysteresisCycles, VirginCurve, find_cycles, virgin_curve
from fric.identify.halves import halves
from fric.identify.static_map.corrections import corrected
from fric.identify.static_map.points import Asked, SpeedPoint, Strokes
from fric.log import ForceVelocity, Log
from fric.records.prepared import prepared
from fric.report.collect import Change, Contour, ContourTest, Item, ReportInput
from fric.units import readable, rotates, si_unit

STROKE = 1.4  # Pixels for a point of a line's width, for every size and zoom of a figure on the page
_LINES = re.compile(r"(stroke-width|stroke-dasharray|stroke-dashoffset): ([^;\"]+)")
CYCLE_POINTS = 1500  # Number of points drawn of a cycle
BAND_CAPTION = "The band treats the parameters' intervals as independent."
ZOOMED = frozenset({"contour", "reversal", "diagnosis"})  # Names of the figures that a page shows in a separate way
POINTS = 1500  # Number of points drawn of a motion or a response


def embedded(figure: Figure, key: str, alt: str) -> str:
    """Return a figure as an element of a page, the same text each time.

    Text stays text. An artist's ``gid`` that has a colon becomes ``data-name``, for the page's script; other ids are
    those of the drawing, made unique by the key, or left out. ``data-panels`` holds for each panel its frame in the
    drawing, its labels, and its limits, from which the script reads the numbers under the pointer. Curves and their
    entries in a legend get the same number in ``curve:N`` and ``legend:N``, unless they have a name.

    key: What its ids begin with; no other figure of the page has it.
    alt: What it shows, for those who do not see it.
    """
    _name_curves(figure)
    names = [str(artist.get_gid()) for artist in figure.findobj(Artist)]
    named = any(":" in name and "curve:" not in name for name in names)
    out = io.StringIO()
    # what the script magnifies must have all its points; else points that lie within a fiftieth of one go
    rules = style() | {"svg.fonttype": "none", "path.simplify": not named, "path.simplify_threshold": 0.02}
    with mpl.rc_context(rules), laid_out(figure, DRAWING):
        figure.savefig(out, format="svg", metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    width, height = (72 * float(inches) for inches in figure.get_size_inches())
    text = out.getvalue()
    text = text[text.index("<svg") :]
    text = text[text.index(">") + 1 :]
    text = re.sub(r"\s*<(metadata|defs)>\s*(<style|<rdf:RDF).*?</\1>", "", text, count=2, flags=re.DOTALL)
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    used = set(re.findall(r"(?:url\(|href=\")#([^\")]+)", text))

    def tag(found: re.Match[str]) -> str:
        svg = _LINES.sub(lambda line: f"{line[1]}: {_wider(line[2])}", found[0])
        svg = re.sub(r"-?\d+\.\d{3,}(?!\d*e)", lambda number: f"{float(number[0]):.2f}".rstrip("0").rstrip("."), svg)
        svg = re.sub(r"font-family: 'DejaVu Sans', [^;\"]+;? ?", "", svg)  # the page shows it once
        svg = re.sub(r'\sid="([^"]*)"', lambda name: _named(name[1], key, used), svg)
        svg = svg.replace("url(#", f"url(#{key}-").replace("xlink:href=", "href=").replace('href="#', f'href="#{key}-')
        return re.sub(r"\s+", " ", svg)

    text = re.sub(r"<[^>]+>", tag, text)
    text = re.sub(r">\s*\n\s*<", "><", text)
    panels = escape(json.dumps([_panel(figure, axes, width, height) for axes in figure.axes], separators=(",", ":")))
    return (
        f'<svg class="plot" role="img" tabindex="0" aria-label="{escape(alt)}" data-panels="{panels}" '
        f'viewBox="0 0 {width:g} {height:g}" style="max-width: {1.25 * width:.0f}pt">{text}'
    )


def _wider(lengths: str) -> str:
    """Return widths of lines, or lengths of dashes, as the page draws them."""
    return ",".join(f"{STROKE * float(text):.2f}" for text in lengths.split(","))


def _named(name: str, key: str, used: set[str]) -> str:
    return f' data-name="{name}"' if ":" in name else f' id="{key}-{name}"' if name in used else ""


def _name_curves(figure: Figure) -> None:
    """Give curves and their entries in legends a common number."""
    legends = [legend for legend in figure.findobj(Legend) if isinstance(legend, Legend)]
    shown = {text.get_text() for legend in legends for text in legend.get_texts()}
    numbers = {label: n for n, label in enumerate(sorted(shown))}
    named: dict[str, list[Artist]] = {}
    for axes in figure.axes:
        for container in axes.containers:
            named.setdefault(str(container.get_label()), []).extend(_leaves(container))
        for artist in axes.get_children():
            named.setdefault(str(artist.get_label()), []).append(artist)
    for legend in legends:
        for handle, text in zip(legend.legend_handles, legend.get_texts(), strict=True):
            drawn = named.get(text.get_text(), [])
            if drawn and not any(item.get_gid() for item in drawn if not str(item.get_gid()).startswith("curve:")):
                for artist in drawn:
                    artist.set_gid(f"curve:{numbers[text.get_text()]}")
                for part in (handle, text):
                    if part is not None:
                        part.set_gid(f"legend:{numbers[text.get_text()]}")


def _leaves(container: Any) -> list[Artist]:
    parts = (part if isinstance(part, tuple | list) else [part] for part in container)
    return [item for part in parts for item in part if item is not None]


def _panel(figure: Figure, axes: Axes, width: float, height: float) -> dict[str, Any]:
    """Return the frame of a panel in the drawing, and its scales."""

    def place(x: float, y: float) -> list[float]:
        across, up = figure.transFigure.inverted().transform(axes.transData.transform((x, y)))
        return [round(float(across) * width, 3), round(float((1 - up) * height), 3)]

    if isinstance(axes, PolarAxes):
        low, high = axes.get_ylim()
        centre, rim = place(0.0, low), place(0.0, high)
        return {"centre": centre, "rim": round(rim[0] - centre[0], 3), "r": [low, high]}
    box = axes.get_position()
    return {
        "frame": [round(v, 3) for v in (box.x0 * width, (1 - box.y1) * height, box.x1 * width, (1 - box.y0) * height)],
        "x": [*axes.get_xlim(), axes.get_xscale(), axes.get_xlabel()],
        "y": [*axes.get_ylim(), axes.get_yscale(), axes.get_ylabel()],
    }


@dataclass(frozen=True, eq=False)
class FrictionCurves:
    """Curves of the friction of an axis."""

    maps: Mapping[str, Band]  # ``both``, or ``positive`` and ``negative``: force over speed in the direction of motion
    points: tuple[SpeedPoint, ...] = ()  # measured strokes, the offset of the force channel taken off
    fitted: bool = False  # whether the map's band is by the covariance of its fit, not by the intervals alone
    virgin: Virgin | None = None  # of the GMS model, and of the logs
    hysteresis: tuple[ReplayedCycle, ...] = ()
    notes: tuple[str, ...] = ()  # why something is not drawn
    halves: str = ""  # whether halves of the strokes agree, see `agreement`


def agreement(logs: Sequence[Log], plant: Plant | None = None) -> str:
    """Return a sentence on the agreement of halves of the logs; empty without logs."""
    if not logs:
        return ""
    try:
        what = f"To check the intervals, each half of the {logs[0].kind or 'motion'} logs was identified alone"
        return f"{what}: {halves(logs, plant).conclusion}."
    except FricError as error:
        return f"{error.what[:1].upper()}{error.what[1:]}."


def friction_curves(inputs: ReportInput, item: Item) -> FrictionCurves:
    """Return the curves of a friction document, with the logs of its axis if given."""
    sections = item.sections()
    static = {name: content for name, content in sections.items() if name in {"static", "static_negative"}}
    records = [record for record in inputs.records if item.document.belongs(record.axis, record.motion)]
    steady = [record for record in records if isinstance(record, Log) and record.kind == "constant-velocity"]
    strokes: list[Log | ForceVelocity] = [*steady, *(record for record in records if isinstance(record, ForceVelocity))]
    waves = [record for record in records if isinstance(record, Log) and record.kind in PRESLIDING]
    assert isinstance(item.document, FrictionDocument)
    plant, notes = _plant(inputs, item, item.document.fit_of("static")) if strokes else (None, [])
    points: tuple[SpeedPoint, ...] = ()
    if static and strokes and not notes:
        offset = float(sections["static"]["offset"]) if "offset" in sections["static"] else 0.0
        found = corrected(Strokes.of(strokes, Asked(item.motion, plant)))  # as `identify_static` does by default
        points = tuple(replace(point, force=point.force - offset) for point in found.points)
    agree = agreement(steady, plant) if points else ""
    together = {name: block.covariance() for name in static if (block := item.document.fit_of(name).covariance)}
    maps = {
        "both" if len(static) == 1 else "negative" if name.endswith("negative") else "positive":
        map_band(mapping, _speeds(mapping, points), together.get(name)) for name, mapping in static.items()
    }  # fmt: skip
    if "gms" not in sections:
        return FrictionCurves(maps, points, bool(together), notes=tuple(notes), halves=agree)
    model = GMS.from_sections(sections)
    plant, without = _plant(inputs, item, item.document.fit_of("gms")) if waves else (None, [])
    notes = list(dict.fromkeys(notes + without))
    hysteresis, curve, left = ((), None, ()) if without else _measured(waves, plant, model)
    notes += left
    longest = 1.6 * float(model.slip_displacements.max())
    longest = max(longest, float(curve.displacement[-1])) if curve is not None else longest
    knots, band = np.sort(model.slip_displacements), virgin_band(sections, longest)
    virgin = Virgin(item.motion, float(band.y.max()), band, knots, model.virgin_curve(knots), curve)
    return FrictionCurves(maps, points, bool(together), virgin, hysteresis or model_cycles(model), tuple(notes), agree)


def _plant(inputs: ReportInput, item: Item, fit: Fit) -> tuple[Plant | None, list[str]]:
    """Return the plant whose damping is subtracted from the logged force, as in the identification."""
    if not fit.taken_off:
        return None, []
    given = inputs.of("plant", item.axis)
    part: PlantPart | None = fit.plant
    if part is None and given is not None and isinstance(given.document, PlantDocument):
        part = given.document  # of a file that does not name the plant yet
    if part is None:
        return None, [
            "The logs are not drawn: the drive's own damping was taken off before the friction was identified. "
            "Give the plant file too."
        ]
    try:
        return part.plant(item.motion), []
    except FricError as error:
        return None, [f"The logs are not drawn, because the plant does not tell enough: {error.what}."]


def _speeds(static: Mapping[str, Estimate], points: Sequence[SpeedPoint]) -> Real:
    """Return the speeds [m/s] at which a map is drawn: those that were measured, or around the Stribeck velocity."""
    v_s, seen = float(static["v_s"]), np.abs([point.velocity for point in points])
    low, high = (seen.min() / 2, seen.max() * 1.05) if points else (v_s / 30, v_s * 100)
    return np.geomspace(low, high, 240)


def map_band(static: Mapping[str, Estimate], speed: Real, covariance: Covariance | None = None) -> Band:
    """Return the static map, eq. (2), over speed [m/s], with a band of 95 %.

    The band uses the covariance of the parameters if the file has it. Else each parameter moves to the limits of its
    interval, and the effects add in quadrature; the parameters are correlated, so this band is too wide.
    """
    values = {name: float(static[name]) for name in STATIC_PARAMETERS if name in static}

    def force(changed: Mapping[str, float]) -> Real:
        return StaticMap(**{**values, **changed}).steady_state(speed)

    if covariance is None:
        return Band(speed, *_in_quadrature(force, {name: static[name] for name in values}))
    kept = [n for n, name in enumerate(covariance.names) if name in values]
    slope = [values[covariance.names[n]] if covariance.scales[n] == "log" else 1.0 for n in kept]
    matrix = np.array(covariance.matrix)[np.ix_(kept, kept)] * np.outer(slope, slope)
    steps = 1e-3 * np.sqrt(np.diag(matrix))
    moved = [
        (force({name: values[name] + step}) - force({name: values[name] - step})) / (2 * step) if step else 0.0 * speed
        for name, step in zip((covariance.names[n] for n in kept), steps, strict=True)
    ]
    half = _quantile(static, covariance) * np.sqrt(np.einsum("in,ij,jn->n", moved, matrix, moved))
    middle = force({})
    return Band(speed, middle, middle - half, middle + half)


def _quantile(static: Mapping[str, Estimate], covariance: Covariance) -> float:
    """Return half an interval in standard deviations, of the offset or else of F_c: about 2 with many strokes."""
    for name in ("offset", "F_c"):
        if name in static and name in covariance.names and static[name].ci95:
            n, limits = covariance.names.index(name), np.array(static[name].limits)
            limits = np.log(np.maximum(limits, 1e-300)) if covariance.scales[n] == "log" else limits
            if covariance.matrix[n][n] > 0.0:
                return float(np.clip(0.5 * (limits[1] - limits[0]) / covariance.matrix[n][n] ** 0.5, 1.96, 4.0))
    return 1.96


def virgin_band(sections: Mapping[str, Mapping[str, Estimate]], longest: float) -> Band:
    """Return the virgin curve ``Σ min(k_i·z, alpha_i·F_s)`` up to a displacement [m], with its band as `map_band`."""
    model = GMS.from_sections(sections)
    knots = model.slip_displacements
    z = np.unique(np.concatenate([np.geomspace(0.02 * knots.min(), longest, 300), knots[knots <= longest]]))
    single = {"F_s": sections["static"]["F_s"]} | {name: sections["gms"][name] for name in ("alpha", "k")}

    def force(changed: Mapping[str, float]) -> Real:
        limit = np.array([changed.get(f"alpha_{n}", a) for n, a in enumerate(model.alpha, 1)])
        limit = limit / limit.sum() * changed.get("F_s", model.static.F_s)
        stiffness = np.array([changed.get(f"k_{n}", value) for n, value in enumerate(model.k, 1)])
        return np.asarray(np.minimum(stiffness * z[:, np.newaxis], limit).sum(axis=1))

    return Band(z, *_in_quadrature(force, dict(elements(single))))


def _in_quadrature(
    force: Callable[[Mapping[str, float]], Real], parameters: Mapping[str, Estimate]
) -> tuple[Real, Real, Real]:
    """Return a curve and its limits; an open limit has no effect, and the page says so."""
    middle = force({})
    below, above = np.zeros_like(middle), np.zeros_like(middle)
    for name, estimate in parameters.items():
        limits: tuple[float, ...] = tuple(estimate.ci95) if estimate.ci95 is not None else ()  # type: ignore[arg-type]
        if moved := [force({name: limit}) - middle for limit in limits if abs(limit) != inf]:
            above += np.maximum(np.max(moved, axis=0), 0.0) ** 2
            below += np.minimum(np.min(moved, axis=0), 0.0) ** 2
    return middle, middle - np.sqrt(below), middle + np.sqrt(above)


def model_cycles(model: GMS) -> tuple[ReplayedCycle, ...]:
    """Return slow cycles of a GMS model: small cycles within pre-sliding, and a cycle that slides at its ends."""
    longest = float(model.slip_displacements.max())
    hysteresis = []
    for share in (0.25, 0.5, 1.5):
        time = np.linspace(0.0, 2.25, 3 * CYCLE_POINTS)
        position = share * longest * np.sin(2 * np.pi * time)
        # so slow that the level is F_s throughout
        force = model.replay(time * 1e6, position, np.gradient(position, time * 1e6))
        last, name = time >= 1.25, f"amplitude {share:g} times the pre-sliding"
        hysteresis.append(ReplayedCycle(name, position[last][::3], None, force[last][::3]))
    return tuple(hysteresis)


def _measured(
    waves: Sequence[Log], plant: Plant | None, model: GMS
) -> tuple[tuple[ReplayedCycle, ...], VirginCurve | None, tuple[str, ...]]:
    """Return the measured cycles with the replayed model, their virgin curve, and which records show none."""
    found: list[HysteresisCycles] = []
    hysteresis, left = [], []
    for log in waves:
        try:
            log.require("force", "its cycle")
            cycle = find_cycles(prepared([log], plant)[0])
        except FricError as error:  # it was left out of the fit, too
            left.append(f"Record '{log.name}' is not drawn: {error.what}.")
            continue
        motion, force = cycle.record.motion, cycle.record.force
        found.append(cycle)
        replayed = model.replay(log.time, motion.position, motion.velocity)
        start = int(cycle.record.reversals[0])  # the state before the first reversal is not known
        part = slice(start, None, max(1, (len(force) - start) // CYCLE_POINTS))
        replayed += float(np.mean(force[start:] - replayed[start:]))  # the constant force of the record, as in the fit
        middle = 0.5 * float(motion.position.max() + motion.position.min())
        hysteresis.append(ReplayedCycle(log.name, motion.position[part] - middle, force[part], replayed[part]))
    return tuple(hysteresis), (virgin_curve(found, model.static) if found else None), tuple(left)


def presliding(inputs: ReportInput) -> float | None:
    """Return the largest slip displacement of the given GMS models [m]; None without any."""
    linear = (item.sections() for item in inputs.items if item.kind == "friction" and not rotates(item.motion))
    models = (GMS.from_sections(sections) for sections in linear if {"gms", "static"} <= sections.keys())
    return max((float(model.slip_displacements.max()) for model in models), default=None)


@dataclass(frozen=True)
class PageFigure:
    """A figure of the page, the text above and below it, and a description for those who do not see it."""

    id: str
    title: str
    caption: str
    alt: str
    figure: Figure

    def svg(self) -> Markup:
        """Return the figure as an element of the page."""
        return Markup(embedded(self.figure, self.id, self.alt))


def pictures(part: Any, key: str) -> list[PageFigure]:
    """Return the figures of an object, or of several of one type; new figures need no change here."""
    if not part:
        return []
    of = type(part[0] if isinstance(part, list | tuple) else part).__name__
    found = (view for view in views(of) if view.name not in ZOOMED)
    return [PageFigure(f"{key}-{view.name}", "", view.summary, view.summary, view.draw(part)) for view in found]


def friction_map(item: Item, curves: FrictionCurves) -> list[PageFigure]:
    """Return the friction-velocity map over both directions, and over speed on a logarithmic axis."""
    maps = []
    for direction, band in curves.maps.items():
        signs = {"both": (-1, 1), "positive": (1,), "negative": (-1,)}[direction]
        branches = [Band(sign * band.x, sign * band.y, sign * band.low, sign * band.high) for sign in signs]
        branches = [replace(b, low=np.minimum(b.low, b.high), high=np.maximum(b.low, b.high)) for b in branches]
        maps.append(MapBranches(signs[-1], branches, band))
    between = item.tree.get("fit", {}).get("between_strokes", {}).get("value", 0.0)
    names = ("velocity", "force", "standard_error")
    v, F, error = (np.array([getattr(p, name) for p in curves.points]) for name in names)
    found = FrictionMap(item.motion, maps, v, F, 1.96 * np.hypot(error, between))
    first = next(iter(curves.maps.values()))
    lowest = int(np.argmin(first.y))
    unit, per_second = si_unit("force", item.motion), si_unit("velocity", item.motion)
    alt = (
        f"Friction of axis {item.axis} over velocity. At {readable(first.x[0], per_second)} it is "
        f"{readable(first.y[0], unit)}; the least is {readable(first.y[lowest], unit)} at "
        f"{readable(first.x[lowest], per_second)}; at the highest speed drawn it is {readable(first.y[-1], unit)}."
    )
    text = "The band is that of the fit." if curves.fitted else BAND_CAPTION
    parts = [item.sections().get(name, {}) for name in ("static", "static_negative")]
    if any(inf in np.abs(estimate.limits) for part in parts for estimate in part.values() if estimate.ci95):
        text += " A limit that the records leave open is not drawn."
    text += f" Points: {len(curves.points)} measured strokes with 95 % intervals." if curves.points else ""
    wide, near = (map_figure(found, logarithmic=logarithmic) for logarithmic in (False, True))
    return [
        PageFigure(f"map-{item.axis}", "Friction-velocity map", text, alt, wide),
        PageFigure(f"map-log-{item.axis}", "The same over the logarithm of speed", "", alt, near),
    ]


def virgin_curves(item: Item, curves: FrictionCurves) -> list[PageFigure]:
    """Return the virgin curve with its band and knots, over displacement and over its logarithm."""
    if (found := curves.virgin) is None:
        return []
    text = ", ".join(readable(float(knot), si_unit("position", item.motion)) for knot in found.knots)
    rise = readable(float(found.at_knots[-1]), si_unit("force", item.motion))
    alt = f"Virgin curve of axis {item.axis}: from rest the friction rises to {rise}"
    alt += f"; its {len(found.knots)} blocks slip at {text}."
    plain, near = (virgin_figure(found, logarithmic=logarithmic) for logarithmic in (False, True))
    return [
        PageFigure(f"virgin-{item.axis}", "Virgin curve", f"Knots at {text}. {BAND_CAPTION}", alt, plain),
        PageFigure(f"virgin-log-{item.axis}", "The same over the logarithm of displacement", "", alt, near),
    ]


def hysteresis(item: Item, curves: FrictionCurves) -> list[PageFigure]:
    """Return the pre-sliding cycles: each record with the model replayed along it, or those of the model alone."""
    if not curves.hysteresis:
        return []
    if curves.hysteresis[0].measured is None:
        alt = f"Hysteresis cycles of the GMS model of axis {item.axis}, the larger the wider."
        figure = cycles_figure(curves.hysteresis, item.motion)
        text = "No pre-sliding log was given."
        return [PageFigure(f"cycles-{item.axis}", "Pre-sliding cycles of the model", text, alt, figure)]
    drawn = []
    for n, cycle in enumerate(curves.hysteresis):
        assert cycle.measured is not None
        rms = readable(float(np.sqrt(np.mean((cycle.measured - cycle.model) ** 2))), si_unit("force", item.motion))
        amplitude = readable(0.5 * float(np.ptp(cycle.position)), si_unit("position", item.motion))
        text = f"amplitude {amplitude}; measured less replayed {rms} rms"
        alt = f"Cycle {cycle.name} of axis {item.axis}, {text}."
        figure = cycles_figure([cycle], item.motion)
        drawn.append(PageFigure(f"cycle-{item.axis}-{n}", f"Cycle {cycle.name}", f"A{text[1:]}.", alt, figure))
    return drawn


def motions(item: Item, logs: Sequence[Log]) -> list[PageFigure]:
    """Return the force along each ordinary motion of an axis: logged, and of the rigid axis of the plant file.

    ``M·a + F_v·v + F_c·sgn v + offset``, along the motion without the encoder's steps.
    """
    known = {name: float(item["value"]) for name, item in (item.tree.get("fit") or {}).get("parameters", {}).items()}
    drawn: list[PageFigure] = []
    unit = si_unit("force", item.motion)
    for log in logs:
        if log.force is None or not {"M", "F_v", "F_c", "offset"} <= known.keys():
            continue
        motion = prepared([log])[0].motion
        v = motion.velocity
        rigid = known["M"] * motion.acceleration + known["F_v"] * v + known["F_c"] * np.sign(v) + known["offset"]
        part = slice(None, None, max(1, len(log) // POINTS))
        rms = readable(float(np.sqrt(np.mean((log.force - rigid) ** 2))), unit)
        caption = f"Inertia, viscous and Coulomb friction of the plant file along the motion miss it by {rms} rms."
        figure = motion_figure(log.time[part] - log.time[0], log.force[part], rigid[part], f"force [{unit}]")
        key = f"motion-{item.axis}-{len(drawn)}"
        drawn.append(PageFigure(key, f"Motion {log.name}", caption, f"{log.name}: {caption}", figure))
    return drawn


def q_filter(item: Item, Delta: Perturbation | None) -> PageFigure:
    """Return |Q| with what limits it: eq. (8), the peak sensitivity, and 1/|Delta| where it is known."""
    name, cutoff = str(item.tree.get("filter", "binomial2")), float(item.sections()["observer"]["cutoff"])
    limits = item.tree.get("limits", {})
    known = {key: limit["cutoff"]["value"] for key, limit in limits.items() if limit.get("cutoff")}
    largest = {key: QFilter(name, value) for key, value in known.items() if abs(value / cutoff - 1) > 1e-3}
    top = max([8 * cutoff if Delta is None else float(Delta.frequency[-1]), *(3 * item for item in known.values())])
    binding = [(limit.get("frequency"), limit.get("Delta")) for limit in limits.values()]
    touches = [(at["value"], size["value"]) for at, size in binding if at and size]
    if Delta is not None:
        every = slice(None, None, max(1, len(Delta.frequency) // POINTS))
        arrays = ("frequency", "Delta", "radius", "ratio")
        Delta = replace(Delta, **{array: getattr(Delta, array)[every] for array in arrays})
    found = QReach(QFilter(name, cutoff), largest.get("robust"), largest.get("sensitive"), touches, Delta, top)
    reason = str(item.tree.get("reason", ""))
    text = ", ".join(
        f"{what} allows {known[key]:.3g} Hz"
        for key, what in (("robust", "eq. (8), |T·Δ| ≤ 1,"), ("sensitive", "the peak sensitivity of the whole loop"))
        if key in known
    )
    caption = f"Q is a {name} filter with its cutoff at {cutoff:.3g} Hz" + (f", {reason}." if reason else ".")
    caption += f" The largest cutoffs: {text}." if text else ""
    alt = f"Magnitude of the filter Q of axis {item.axis} over frequency. {caption}"
    return PageFigure(f"q-{item.axis}", "How far Q may reach", caption, alt, reach_figure(found, 4.8, 3.3))


def drift_figure(identity: str, title: str, changes: Sequence[Change]) -> PageFigure | None:
    """Return each relative change with its 95 % interval; None where no number has both."""
    if not (shown := [change for change in changes if change.relative is not None and change.verdict != "unknown"]):
        return None
    values = np.array([[change.difference, *(change.difference_ci95 or (0.0, 0.0))] for change in shown])
    percent = np.clip(np.nan_to_num(values / np.abs([[change.before] for change in shown]) * 100), -1e4, 1e4)
    moved = [change.verdict == "moved" for change in shown]
    named = ", ".join(change.name for change in shown if change.verdict == "moved")
    alt = f"Relative change of {len(shown)} numbers with 95 % intervals; {named or 'none'} moved beyond them."
    caption = "Diamonds: the interval of the difference does not hold 0. Circles: it does."
    return PageFigure(identity, title, caption, alt, draw_drift([change.name for change in shown], percent, moved))


def magnification(test: ContourTest) -> float:
    """Return the round magnification (1, 2 or 5 times a power of ten) that draws the largest error at up to R/2."""
    assert test.radius is not None
    largest = max(float(np.abs(contour.error).max()) for contour in test.contours)
    wanted = 0.5 * test.radius / max(largest, 1e-12)
    power = 10.0 ** floor(log10(wanted))
    return float(max(step * power for step in (1, 2, 5) if step * power <= wanted))


def contour_figure(n: int, test: ContourTest, earlier: ContourTest | None) -> PageFigure:
    """Return the contours of one test: a magnified circle, or the error along a path."""
    parts = [f"({run.scheme.name}) {run.scheme.title} {readable(run.middle, 'm')}" for run in test.contours]
    what = "radial error of a circle" if test.radius is not None else "contour error along a path"
    alt = f"The {what} under each scheme; largest glitch of each: {', '.join(parts)}. The table gives every number."
    if test.radius is None:
        title = f"Path at {readable(test.feed, 'm/s')}"
        return PageFigure(f"contour-{n}", title, "Dashed lines: with observer.", alt, along_figure(_contours(test)))
    before = _contours(earlier) if earlier else []
    text = (
        f"The error of the radius{test.of_file}, magnified around the reference circle (grey). Outwards is positive; "
        "dotted circles are labelled in µm; the arrow has the direction of the motion. Dashed lines: with observer."
    )
    figure = overlay_figure(_contours(test), test.radius, test.direction, magnification(test), before)
    title = f"Circle of {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}"
    return PageFigure(f"contour-{n}", title, text, alt, figure)


def decision_figure(n: int, test: ContourTest, chosen: Contour) -> PageFigure:
    """Return the contour without and with the chosen compensation, the figure of a decision."""
    pair = dict([("now", contour) for contour in test.contours if contour.scheme.bare and contour is not chosen])
    pair[f"with {chosen.named}"] = chosen
    drawn = replace(test, contours=tuple(pair.values()))
    looks = ({"color": VERMILION, "linewidth": 2.0}, {"color": BLUE, "linewidth": 1.4})[-len(pair) :]
    styled = zip(_contours(drawn), looks, pair, strict=True)
    contours = [replace(contour, look=look | {"linestyle": "-", "label": label}) for contour, look, label in styled]
    sizes = ", ".join(f"{label} {readable(contour.middle, 'm', 2)}" for label, contour in pair.items())
    key, alt = f"decision-{n}", f"Contour error around its largest glitch: {sizes}."
    if test.radius is None:
        return PageFigure(key, "", "Error along the path.", alt, along_figure(contours))
    times = magnification(drawn)
    figure = overlay_figure(contours, test.radius, test.direction, times, size=(4.6, 4.6))
    text = f"Error of the radius{test.of_file}, magnified {times:g} times; outwards is positive."
    text += f" Axis {test.axes[0]} alone was simulated: no glitch of the other axis is drawn." * (len(test.axes) == 1)
    return PageFigure(key, "", text, alt, figure)


def reversal_figures(n: int, test: ContourTest) -> list[PageFigure]:
    """Return the radial error of every scheme over the time after a reversal, one figure for each axis that was run."""
    if test.radius is None:
        return []
    drawn = []
    for k, axis in enumerate(test.axes[:2]):
        quarter = k if len(test.axes) > 1 or axis != "y" else 1
        figure = after_reversal_figure(_contours(test), test.radius, test.feed, test.direction, quarter * np.pi / 2)
        label = test.labels[quarter]
        peaks = ", ".join(f"({run.scheme.name}) {readable(abs(run.glitches[quarter]), 'm')}" for run in test.contours)
        alt = f"Radial error over time around the reversal at {label}; peaks{test.of_file}: {peaks}."
        drawn.append(PageFigure(f"reversal-{n}-{axis}", f"At the reversal of axis {axis}, {label}", "", alt, figure))
    return drawn


def _contours(test: ContourTest) -> list[SchemeContour]:
    return [SchemeContour(contour.scheme, contour.place, contour.error) for contour in test.contours]
