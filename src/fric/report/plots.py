"""The figures of friction and observer: map, virgin curve, hysteresis cycles, Q-filter limit, drift."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fric.control.q_filter import QFilter
from fric.design.perturbation import Perturbation
from fric.figures.style import BLACK, BLUE, GREY, ORANGE, VERMILION
from fric.identify.records.prepared import prepared
from fric.log import Log
from fric.report.canvas import Drawn, band, canvas, curve, hover, legend, measured, scale
from fric.report.curves import Band, FrictionCurves
from fric.report.drift import Change
from fric.report.report_input import Item
from fric.units import readable, si_unit

BAND_CAPTION = "The band is from the intervals of the parameters one by one, as if they were independent."


def friction_map(item: Item, curves: FrictionCurves) -> list[Drawn]:
    """Return the friction-velocity map over both directions, and over speed on a logarithmic axis."""
    first = next(iter(curves.maps.values()))
    peak = float(max(np.abs(one.y).max() for one in curves.maps.values()))
    force = scale(peak, "force", item.motion)
    speed: tuple[float, str] = (1e3, "mm/s") if item.motion == "linear" else (1.0, "rad/s")
    wide = canvas(f"velocity [{speed[1]}]", f"friction [{force[1]}]")
    near = canvas(f"speed [{speed[1]}]", f"friction in the direction of motion [{force[1]}]", x_axis_type="log")
    for direction, one in curves.maps.items():
        color = VERMILION if direction == "negative" else BLUE
        label = "eq. (2)" if direction == "both" else f"eq. (2), {direction}"
        for sign in {"both": (-1, 1), "positive": (1,), "negative": (-1,)}[direction]:
            _branch(wide, one, sign, speed[0], force[0], color, label)
        _branch(near, one, 1, speed[0], force[0], color, label)
    _strokes(wide, near, item, curves, speed[0], force[0])
    for plot, place in ((wide, "bottom_right"), (near, "bottom_left")):
        legend(plot, place)
    lowest = int(np.argmin(first.y))
    unit, per_second = si_unit("force", item.motion), si_unit("velocity", item.motion)
    alt = (
        f"Friction of axis {item.axis} over velocity. At {readable(first.x[0], per_second)} it is "
        f"{readable(first.y[0], unit)}; the least is {readable(first.y[lowest], unit)} at "
        f"{readable(first.x[lowest], per_second)}; at the highest speed drawn it is {readable(first.y[-1], unit)}."
    )
    text = "The band is that of the fit." if curves.fitted else BAND_CAPTION
    points = f" Points: {len(curves.points)} measured strokes with 95 % intervals." if curves.points else ""
    return [
        Drawn(f"map-{item.axis}", "Friction-velocity map", text + points, alt, wide),
        Drawn(f"map-log-{item.axis}", "The same over the logarithm of speed", "", alt, near),
    ]


def _branch(plot: Any, one: Band, sign: int, speed: float, force: float, color: str, label: str) -> None:
    x, low, high = sign * one.x * speed, sign * one.low * force, sign * one.high * force
    band(plot, x, low, high, color, f"{label}: 95 % band")
    line = curve(plot, x, sign * one.y * force, color, label, line_dash="dashed" if color == VERMILION else "solid")
    hover(plot, [line], [("velocity", "@x"), ("friction", "@y")])


def _strokes(wide: Any, near: Any, item: Item, curves: FrictionCurves, speed: float, force: float) -> None:
    if not curves.points:
        return
    v = np.array([point.velocity for point in curves.points])
    F = np.array([point.force for point in curves.points]) * force
    between = item.tree.get("fit", {}).get("between_strokes", {}).get("value", 0.0)
    half = 1.96 * force * np.hypot([point.standard_error for point in curves.points], between)
    measured(wide, v * speed, F, F - half, F + half)
    size = F * np.sign(v)
    for chosen, color, label in ((v > 0, BLACK, "measured, positive"), (v < 0, ORANGE, "measured, negative")):
        if chosen.any():
            x, y, h = np.abs(v[chosen]) * speed, size[chosen], half[chosen]
            measured(near, x, y, y - h, y + h, color, label)


def virgin_curves(item: Item, curves: FrictionCurves) -> list[Drawn]:
    """Return the virgin curve with its band and knots, over displacement and over its logarithm."""
    if curves.virgin is None or curves.knots is None:
        return []
    model, (knots, at_knots) = curves.virgin, curves.knots
    force = scale(float(model.y.max()), "force", item.motion)
    length = scale(float(knots.max()), "position", item.motion)
    drawn = []
    for axis_type in ("linear", "log"):
        plot = canvas(f"displacement [{length[1]}]", f"friction [{force[1]}]", x_axis_type=axis_type)
        found = curves.measured_virgin
        if found is not None:
            z, F, half = found.displacement * length[0], found.force * force[0], np.nan_to_num(found.band) * force[0]
            band(plot, z, F - half, F + half, ORANGE, "measured: 95 % band")
            plot.scatter(z, F, size=3, color=BLACK, legend_label="measured")
        band(plot, model.x * length[0], model.low * force[0], model.high * force[0], BLUE, "GMS: 95 % band")
        line = curve(plot, model.x * length[0], model.y * force[0], BLUE, "GMS")
        hover(plot, [line], [("displacement", "@x"), ("friction", "@y")])
        plot.scatter(
            knots * length[0], at_knots * force[0], size=8, color=BLUE, fill_color="#ffffff", legend_label="knots"
        )
        legend(plot)
        drawn.append(plot)
    unit = si_unit("position", item.motion)
    text = ", ".join(readable(float(knot), unit) for knot in knots)
    alt = (
        f"Virgin curve of axis {item.axis}: from rest the friction rises to "
        f"{readable(float(at_knots[-1]), si_unit('force', item.motion))}; its {len(knots)} blocks slip at {text}."
    )
    return [
        Drawn(f"virgin-{item.axis}", "Virgin curve", f"Knots at {text}. {BAND_CAPTION}", alt, drawn[0]),
        Drawn(f"virgin-log-{item.axis}", "The same over the logarithm of displacement", "", alt, drawn[1]),
    ]


def hysteresis(item: Item, curves: FrictionCurves) -> list[Drawn]:
    """Return the pre-sliding cycles: each record with the model replayed along it, or those of the model alone."""
    if not curves.hysteresis:
        return []
    largest = max(float(np.abs(cycle.model).max()) for cycle in curves.hysteresis)
    force = scale(largest, "force", item.motion)
    if curves.hysteresis[0].measured is None:
        length = scale(max(float(cycle.position.max()) for cycle in curves.hysteresis), "position", item.motion)
        plot = canvas(f"position [{length[1]}]", f"friction [{force[1]}]")
        looks = ((ORANGE, "dotted"), (VERMILION, "dashed"), (BLUE, "solid"))
        for cycle, (color, dash) in zip(curves.hysteresis, looks, strict=False):
            curve(plot, cycle.position * length[0], cycle.model * force[0], color, cycle.name, line_dash=dash)
        legend(plot)
        alt = f"Hysteresis cycles of the GMS model of axis {item.axis}, the larger the wider."
        return [
            Drawn(f"cycles-{item.axis}", "Pre-sliding cycles of the model", "No pre-sliding log was given.", alt, plot)
        ]
    drawn = []
    for n, cycle in enumerate(curves.hysteresis):
        assert cycle.measured is not None
        amplitude = 0.5 * float(np.ptp(cycle.position))
        length = scale(amplitude, "position", item.motion)
        plot = canvas(f"position from the middle [{length[1]}]", f"friction [{force[1]}]")
        curve(
            plot,
            cycle.position * length[0],
            cycle.measured * force[0],
            GREY,
            "measured",
            line_width=3.5,
            line_alpha=0.5,
        )
        curve(plot, cycle.position * length[0], cycle.model * force[0], BLUE, "GMS replayed", line_width=1.2)
        legend(plot)
        rms = readable(float(np.sqrt(np.mean((cycle.measured - cycle.model) ** 2))), si_unit("force", item.motion))
        text = f"amplitude {readable(amplitude, si_unit('position', item.motion))}; measured less replayed {rms} rms"
        alt = f"Cycle {cycle.name} of axis {item.axis}, {text}."
        drawn.append(Drawn(f"cycle-{item.axis}-{n}", f"Cycle {cycle.name}", f"A{text[1:]}.", alt, plot))
    return drawn


MOTION_POINTS = 1500
"""Points of a motion that are drawn."""


def motions(item: Item, logs: Sequence[Log]) -> list[Drawn]:
    """Return the force along each ordinary motion of an axis: logged, and of the rigid axis that the plant file tells.

    ``M·a + F_v·v + F_c·sgn v + offset``, along the motion without the encoder's steps.
    """
    known = {name: float(one["value"]) for name, one in (item.tree.get("fit") or {}).get("parameters", {}).items()}
    drawn: list[Drawn] = []
    for log in logs:
        if log.force is None or not {"M", "F_v", "F_c", "offset"} <= known.keys():
            continue
        motion = prepared([log])[0].motion
        v = motion.velocity
        rigid = known["M"] * motion.acceleration + known["F_v"] * v + known["F_c"] * np.sign(v) + known["offset"]
        part = slice(None, None, max(1, len(log) // MOTION_POINTS))
        force = scale(float(np.abs(log.force).max()), "force", item.motion)
        plot = canvas("time [s]", f"force [{force[1]}]")
        time = log.time[part] - log.time[0]
        curve(plot, time, log.force[part] * force[0], GREY, "logged", line_width=3, line_alpha=0.5)
        curve(plot, time, rigid[part] * force[0], BLUE, "rigid axis", line_width=1.2)
        legend(plot, "top_right")
        rms = readable(float(np.sqrt(np.mean((log.force - rigid) ** 2))), si_unit("force", item.motion))
        caption = f"Inertia, viscous and Coulomb friction of the plant file along the motion miss it by {rms} rms."
        drawn.append(
            Drawn(f"motion-{item.axis}-{len(drawn)}", f"Motion {log.name}", caption, f"{log.name}: {caption}", plot)
        )
    return drawn


def q_filter(item: Item, Delta: Perturbation | None) -> Drawn:
    """Return |Q| with what limits it: eq. (8), the peak sensitivity, and 1/|Delta| where it is known."""
    sections = item.sections()["observer"]
    name, cutoff = str(item.tree.get("filter", "binomial2")), float(sections["cutoff"])
    limits = item.tree.get("limits", {})
    plot = canvas("frequency [Hz]", "magnitude [dB]", x_axis_type="log", y_range=(-50, 40))
    top = 8 * cutoff if Delta is None else float(Delta.frequency[-1])
    known = [one["cutoff"]["value"] for one in limits.values() if "cutoff" in one]
    f = np.geomspace(cutoff / 30, max([top, *(3 * one for one in known)]), 600)

    def size(at: float) -> Any:
        return 20 * np.log10(np.abs(QFilter(name, at).response(f)))

    line = curve(plot, f, size(cutoff), BLUE, f"Q, cutoff {cutoff:.3g} Hz", line_width=2.5)
    hover(plot, [line], [("frequency", "@x Hz"), ("|Q|", "@y dB")])
    for key, text, color in (("robust", "eq. (8)", VERMILION), ("sensitive", "peak sensitivity", ORANGE)):
        limit = limits.get(key, {})
        if "cutoff" in limit and abs(limit["cutoff"]["value"] / cutoff - 1) > 1e-3:
            label = f"limit by {text}, cutoff {limit['cutoff']['value']:.3g} Hz"
            curve(plot, f, size(limit["cutoff"]["value"]), color, label, line_dash="dashed")
        if "Delta" in limit:
            plot.scatter(
                [limit["frequency"]["value"]], [-20 * np.log10(limit["Delta"]["value"])], size=9, color=color,
                legend_label="1/|Δ| where it limits",
            )  # fmt: skip
    if Delta is not None:
        every = slice(None, None, max(1, len(Delta.frequency) // 600))
        inverse = -20 * np.log10(np.maximum(np.abs(Delta.Delta), 1e-12))
        curve(
            plot, Delta.frequency[every], inverse[every], BLACK,
            "1/|Δ|, measured" if Delta.measured else "1/|Δ| of the delay alone", line_width=1.2,
        )  # fmt: skip
    legend(plot, "bottom_left")
    reason = str(item.tree.get("reason", ""))
    text = ", ".join(
        f"{what} allows {limits[key]['cutoff']['value']:.3g} Hz"
        for key, what in (("robust", "|T·Δ| ≤ 1, eq. (8),"), ("sensitive", "the peak sensitivity of the whole loop"))
        if "cutoff" in limits.get(key, {})
    )
    caption = f"Q is {name} with its cutoff at {cutoff:.3g} Hz" + (f": {reason}." if reason else ".")
    caption += f" As limit, {text}." if text else ""
    alt = f"Magnitude of the filter Q of axis {item.axis} over frequency. {caption}"
    return Drawn(f"q-{item.axis}", "How far Q may reach", caption, alt, plot)


def drift_figure(identity: str, title: str, changes: Sequence[Change]) -> Drawn | None:
    """Return each relative change with its 95 % interval; None where no number has both."""
    shown = [one for one in changes if one.relative is not None and one.verdict != "unknown"]
    if not shown:
        return None
    names = [one.name for one in shown][::-1]
    plot = canvas("change [%]", "", height=90 + 26 * len(shown), y_range=names, max_width=820)
    plot.line([0, 0], [names[0], names[-1]], color=GREY, line_dash="dashed")
    for one in shown:
        low, high = one.difference_ci95 or (0.0, 0.0)
        percent = np.array([one.difference, low, high]) / abs(one.before) * 100
        percent = np.clip(np.nan_to_num(percent), -1e4, 1e4)
        color = VERMILION if one.verdict == "moved" else BLUE
        plot.segment(x0=[percent[1]], x1=[percent[2]], y0=[one.name], y1=[one.name], color=color, line_width=2)
        marker = "diamond" if one.verdict == "moved" else "circle"
        plot.scatter([percent[0]], [one.name], size=9, color=color, marker=marker)
    moved = [one.name for one in shown if one.verdict == "moved"]
    alt = (
        f"Relative change of {len(shown)} numbers with 95 % intervals; {', '.join(moved) or 'none'} moved beyond them."
    )
    caption = "Diamonds: the interval of the difference does not hold 0. Circles: it does."
    return Drawn(identity, title, caption, alt, plot)
