"""The figures of a page, with what is written above and below them: each is drawn by `fric.figures`."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import floor, log10
from typing import Any

import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure

from fric.control.q_filter import QFilter
from fric.design.perturbation import Perturbation
from fric.figures.contours import (
    RelativeChange,
    SchemeContour,
    after_reversal_figure,
    along_figure,
    draw_drift,
    overlay_figure,
)
from fric.figures.embedded import embedded
from fric.figures.gms import Virgin, cycles_figure, virgin_figure
from fric.figures.loops import QReach, reach_figure
from fric.figures.plant import motion_figure
from fric.figures.static_map import FrictionMap, MapBranches, map_figure
from fric.figures.style import BLUE, VERMILION, Band
from fric.figures.views import views
from fric.log import Log
from fric.records.prepared import prepared
from fric.report.collect import Contour, ContourTest, Item
from fric.report.curves import FrictionCurves
from fric.report.drift import Change
from fric.units import readable, si_unit

BAND_CAPTION = "The band is from the intervals of the parameters one by one, as if they were independent."
ZOOMED = frozenset({"contour", "reversal", "diagnosis"})
"""Names of the figures that a page shows in a separate way."""
POINTS = 1500
"""Points of a motion, or of a response, that are drawn."""


@dataclass(frozen=True)
class Drawn:
    """A figure of the page, the text above and below it, and a description for those who do not see it."""

    id: str
    title: str
    caption: str
    alt: str
    figure: Figure

    def svg(self) -> Markup:
        """Return the figure as an element of the page."""
        return Markup(embedded(self.figure, self.id, self.alt))


def pictures(part: Any, key: str) -> list[Drawn]:
    """Return the figures of an object, or of several of one type; a new figure is drawn without another edit."""
    if not part:
        return []
    of = type(part[0] if isinstance(part, list | tuple) else part).__name__
    found = (view for view in views(of) if view.name not in ZOOMED)
    return [Drawn(f"{key}-{view.name}", "", view.summary, view.summary, view.draw(part)) for view in found]


def friction_map(item: Item, curves: FrictionCurves) -> list[Drawn]:
    """Return the friction-velocity map over both directions, and over speed on a logarithmic axis."""
    maps = []
    for direction, band in curves.maps.items():
        signs = {"both": (-1, 1), "positive": (1,), "negative": (-1,)}[direction]
        branches = [Band(sign * band.x, sign * band.y, sign * band.low, sign * band.high) for sign in signs]
        branches = [replace(b, low=np.minimum(b.low, b.high), high=np.maximum(b.low, b.high)) for b in branches]
        maps.append(MapBranches(signs[-1], branches, band))
    between = item.tree.get("fit", {}).get("between_strokes", {}).get("value", 0.0)
    v, F, error = (
        np.array([getattr(p, name) for p in curves.points]) for name in ("velocity", "force", "standard_error")
    )
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
    text += f" Points: {len(curves.points)} measured strokes with 95 % intervals." if curves.points else ""
    wide, near = (map_figure(found, logarithmic=logarithmic) for logarithmic in (False, True))
    return [
        Drawn(f"map-{item.axis}", "Friction-velocity map", text, alt, wide),
        Drawn(f"map-log-{item.axis}", "The same over the logarithm of speed", "", alt, near),
    ]


def virgin_curves(item: Item, curves: FrictionCurves) -> list[Drawn]:
    """Return the virgin curve with its band and knots, over displacement and over its logarithm."""
    if curves.virgin is None or curves.knots is None:
        return []
    knots, at_knots = curves.knots
    found = Virgin(item.motion, float(curves.virgin.y.max()), curves.virgin, knots, at_knots, curves.measured_virgin)
    unit = si_unit("position", item.motion)
    text = ", ".join(readable(float(knot), unit) for knot in knots)
    alt = (
        f"Virgin curve of axis {item.axis}: from rest the friction rises to "
        f"{readable(float(at_knots[-1]), si_unit('force', item.motion))}; its {len(knots)} blocks slip at {text}."
    )
    plain, near = (virgin_figure(found, logarithmic=logarithmic) for logarithmic in (False, True))
    return [
        Drawn(f"virgin-{item.axis}", "Virgin curve", f"Knots at {text}. {BAND_CAPTION}", alt, plain),
        Drawn(f"virgin-log-{item.axis}", "The same over the logarithm of displacement", "", alt, near),
    ]


def hysteresis(item: Item, curves: FrictionCurves) -> list[Drawn]:
    """Return the pre-sliding cycles: each record with the model replayed along it, or those of the model alone."""
    if not curves.hysteresis:
        return []
    if curves.hysteresis[0].measured is None:
        alt = f"Hysteresis cycles of the GMS model of axis {item.axis}, the larger the wider."
        figure = cycles_figure(curves.hysteresis, item.motion)
        text = "No pre-sliding log was given."
        return [Drawn(f"cycles-{item.axis}", "Pre-sliding cycles of the model", text, alt, figure)]
    drawn = []
    for n, cycle in enumerate(curves.hysteresis):
        assert cycle.measured is not None
        rms = readable(float(np.sqrt(np.mean((cycle.measured - cycle.model) ** 2))), si_unit("force", item.motion))
        amplitude = readable(0.5 * float(np.ptp(cycle.position)), si_unit("position", item.motion))
        text = f"amplitude {amplitude}; measured less replayed {rms} rms"
        alt = f"Cycle {cycle.name} of axis {item.axis}, {text}."
        figure = cycles_figure([cycle], item.motion)
        drawn.append(Drawn(f"cycle-{item.axis}-{n}", f"Cycle {cycle.name}", f"A{text[1:]}.", alt, figure))
    return drawn


def motions(item: Item, logs: Sequence[Log]) -> list[Drawn]:
    """Return the force along each ordinary motion of an axis: logged, and of the rigid axis of the plant file.

    ``M·a + F_v·v + F_c·sgn v + offset``, along the motion without the encoder's steps.
    """
    known = {name: float(item["value"]) for name, item in (item.tree.get("fit") or {}).get("parameters", {}).items()}
    drawn: list[Drawn] = []
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
        drawn.append(
            Drawn(f"motion-{item.axis}-{len(drawn)}", f"Motion {log.name}", caption, f"{log.name}: {caption}", figure)
        )
    return drawn


def q_filter(item: Item, Delta: Perturbation | None) -> Drawn:
    """Return |Q| with what limits it: eq. (8), the peak sensitivity, and 1/|Delta| where it is known."""
    sections = item.sections()["observer"]
    name, cutoff = str(item.tree.get("filter", "binomial2")), float(sections["cutoff"])
    limits = item.tree.get("limits", {})
    known = {key: limit["cutoff"]["value"] for key, limit in limits.items() if "cutoff" in limit}
    largest = {key: QFilter(name, value) for key, value in known.items() if abs(value / cutoff - 1) > 1e-3}
    top = max([8 * cutoff if Delta is None else float(Delta.frequency[-1]), *(3 * item for item in known.values())])
    touches = [(limit["frequency"]["value"], limit["Delta"]["value"]) for limit in limits.values() if "Delta" in limit]
    if Delta is not None:
        every = slice(None, None, max(1, len(Delta.frequency) // POINTS))
        arrays = ("frequency", "Delta", "radius", "ratio")
        Delta = replace(Delta, **{array: getattr(Delta, array)[every] for array in arrays})
    found = QReach(QFilter(name, cutoff), largest.get("robust"), largest.get("sensitive"), touches, Delta, top)
    reason = str(item.tree.get("reason", ""))
    text = ", ".join(
        f"{what} allows {known[key]:.3g} Hz"
        for key, what in (("robust", "|T·Δ| ≤ 1, eq. (8),"), ("sensitive", "the peak sensitivity of the whole loop"))
        if key in known
    )
    caption = f"Q is {name} with its cutoff at {cutoff:.3g} Hz" + (f": {reason}." if reason else ".")
    caption += f" As limit, {text}." if text else ""
    alt = f"Magnitude of the filter Q of axis {item.axis} over frequency. {caption}"
    return Drawn(f"q-{item.axis}", "How far Q may reach", caption, alt, reach_figure(found, 4.8, 3.3))


def drift_figure(identity: str, title: str, changes: Sequence[Change]) -> Drawn | None:
    """Return each relative change with its 95 % interval; None where no number has both."""
    shown = [change for change in changes if change.relative is not None and change.verdict != "unknown"]
    if not shown:
        return None
    rows = []
    for one in shown:
        values = np.array([one.difference, *(one.difference_ci95 or (0.0, 0.0))]) / abs(one.before) * 100
        change, low, high = np.clip(np.nan_to_num(values), -1e4, 1e4).tolist()
        rows.append(RelativeChange(one.name, change, low, high, one.verdict == "moved"))
    moved = ", ".join(row.name for row in rows if row.moved)
    alt = f"Relative change of {len(shown)} numbers with 95 % intervals; {moved or 'none'} moved beyond them."
    caption = "Diamonds: the interval of the difference does not hold 0. Circles: it does."
    return Drawn(identity, title, caption, alt, draw_drift(rows))


def magnification(test: ContourTest) -> float:
    """Return the round magnification (1, 2 or 5 times a power of ten) that draws the largest error at most R/2 high."""
    assert test.radius is not None
    largest = max(float(np.abs(contour.error).max()) for contour in test.contours)
    wanted = 0.5 * test.radius / max(largest, 1e-12)
    power = 10.0 ** floor(log10(wanted))
    return float(max(step * power for step in (1, 2, 5) if step * power <= wanted))


def contour_figure(n: int, test: ContourTest, earlier: ContourTest | None) -> Drawn:
    """Return the contours of one test: a magnified circle, or the error along a path."""
    parts = [
        f"({contour.scheme.name}) {contour.scheme.title} {readable(contour.glitch, 'm')}" for contour in test.contours
    ]
    what = "radial error of a circle" if test.radius is not None else "contour error along a path"
    alt = f"The {what} under each scheme; largest glitch of each: {', '.join(parts)}. The table gives every number."
    if test.radius is None:
        title = f"Path at {readable(test.feed, 'm/s')}"
        return Drawn(f"contour-{n}", title, "Dashed lines: with observer.", alt, along_figure(_contours(test)))
    before = _contours(earlier) if earlier else []
    text = (
        "The error of the radius, magnified around the circle that was asked for (grey). Outwards is positive; dotted "
        "circles are labelled in µm; the arrow has the direction of the motion. Dashed lines: with observer."
    )
    figure = overlay_figure(_contours(test), test.radius, test.direction, magnification(test), before)
    title = f"Circle of {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}"
    return Drawn(f"contour-{n}", title, text, alt, figure)


def decision_figure(n: int, test: ContourTest, chosen: Contour) -> Drawn:
    """Return the contour without and with the chosen compensation: the picture beside a decision."""
    pair = dict([("now", contour) for contour in test.contours if contour.scheme.bare and contour is not chosen])
    pair[f"with {chosen.named}"] = chosen
    drawn = replace(test, contours=tuple(pair.values()))
    looks = ({"color": VERMILION, "linewidth": 2.0}, {"color": BLUE, "linewidth": 1.4})[-len(pair) :]
    contours = [
        replace(contour, look=look | {"linestyle": "-", "label": label})
        for contour, look, label in zip(_contours(drawn), looks, pair, strict=True)
    ]
    sizes = ", ".join(f"{label} {readable(contour.glitch, 'm', 2)}" for label, contour in pair.items())
    key, alt = f"decision-{n}", f"Contour error around its largest glitch: {sizes}."
    if test.radius is None:
        return Drawn(key, "", "Error along the path.", alt, along_figure(contours))
    times = magnification(drawn)
    figure = overlay_figure(contours, test.radius, test.direction, times, size=(4.6, 4.6))
    return Drawn(key, "", f"Error of the radius, magnified {times:g} times; outwards is positive.", alt, figure)


def reversal_figures(n: int, test: ContourTest) -> list[Drawn]:
    """Return the radial error of every scheme over the time after a reversal, one figure for each axis that was run."""
    if test.radius is None:
        return []
    drawn = []
    for k, axis in enumerate(test.axes[:2]):
        quarter = k if len(test.axes) > 1 or axis != "y" else 1
        figure = after_reversal_figure(_contours(test), test.radius, test.feed, test.direction, quarter * np.pi / 2)
        label = test.labels[quarter]
        peaks = ", ".join(
            f"({contour.scheme.name}) {readable(abs(contour.glitches[quarter]), 'm')}" for contour in test.contours
        )
        alt = f"Radial error over time around the reversal at {label}; peaks: {peaks}."
        drawn.append(Drawn(f"reversal-{n}-{axis}", f"At the reversal of axis {axis}, {label}", "", alt, figure))
    return drawn


def _contours(test: ContourTest) -> list[SchemeContour]:
    return [SchemeContour(contour.scheme, contour.place, contour.error) for contour in test.contours]
