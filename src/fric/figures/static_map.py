"""Measured and fitted friction-velocity map, as Fig. 2 of the paper."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fric.arrays import Real
from fric.figures.style import BLACK, BLUE, GREY, VERMILION, new_figure
from fric.figures.views import view
from fric.identify.static_map.identify import StaticFit
from fric.identify.static_map.map_fit import MapFit, SpeedPoint
from fric.units import prefixed, si_unit

_VELOCITY_SCALES = {"linear": (1e3, "mm/s"), "rotary": (1.0, "rad/s")}


@view("map", of="StaticFit", usual=True)
def draw_static_map(fit: StaticFit) -> Figure:
    """Draw the measured forces with error bars, the fitted map of eq. (2) and its 95 % band.

    The left panel shows the whole range as the paper's Fig. 2, the right one speed on a logarithmic axis, where the
    Stribeck effect is; there both directions lie on one another, the offset taken off.

    Parameters
    ----------
    fit
        What `fric.identify.static_map.identify.identify_static` found.
    """
    scale, unit = _VELOCITY_SCALES[fit.motion]
    peak = max(abs(point.force) for point in fit.points)
    factor, force_unit = prefixed(peak, si_unit("force", fit.motion))
    v = np.array([p.velocity for p in fit.points])
    F = np.array([p.force for p in fit.points])
    between = fit.static.between if fit.static else 0.0
    error = 1.96 * np.sqrt(np.array([p.standard_error for p in fit.points]) ** 2 + between**2)
    with new_figure(7.2, 3.6) as figure:
        left, right = figure.subplots(1, 2)
        _points(left, v * scale, F * factor, error * factor)
        for map_fit, _, _ in _maps(fit):
            for p in map_fit.left_out:
                left.plot(p.velocity * scale, p.force * factor, "x", color=GREY, zorder=4)
                right.plot(abs(p.velocity) * scale, _along(p, map_fit) * factor, "x", color=GREY, zorder=4)
        offset = fit.static.solution.theta["offset"] if fit.static else 0.0
        forward, backward = v > 0, v < 0
        for chosen, colour, marker, label in (
            (forward, BLUE, "o", "positive direction"),
            (backward, VERMILION, "s", "negative direction"),
        ):
            if chosen.any():
                size = (F[chosen] - offset) * np.sign(v[chosen])
                _points(right, np.abs(v[chosen]) * scale, size * factor, error[chosen] * factor, colour, marker, label)
        for map_fit, sign, colour in _maps(fit):
            _curve(left, right, map_fit, sign, colour, v, scale, factor, single=fit.negative is None)
        left.set(xlabel=f"velocity [{unit}]", ylabel=f"friction [{force_unit}]", title="measured and fitted map")
        right.set(
            xlabel=f"speed [{unit}]", ylabel=f"friction in the direction of motion [{force_unit}]", xscale="log",
            title="both directions, offset taken off" if offset else "both directions",
        )  # fmt: skip
        left.legend(loc="center right")
        right.legend()
        return figure


def _points(
    axes: Axes, x: Real, y: Real, error: Real,
    colour: str = BLACK, marker: str = "o", label: str = "measured, 95 %",
) -> None:  # fmt: skip
    axes.errorbar(
        x, y, yerr=error, fmt=marker, color=colour, markersize=3.5, markerfacecolor="white", elinewidth=0.8, capsize=2,
        label=label, zorder=3,
    )  # fmt: skip


def _along(point: SpeedPoint, fit: MapFit) -> float:
    """Return the force of a stroke in the direction of its motion, the offset taken off [N]."""
    return (point.force - fit.solution.theta["offset"]) * float(np.sign(point.velocity))


def _maps(fit: StaticFit) -> list[tuple[MapFit, int, str]]:
    maps = [(fit.static, 1, BLUE)] if fit.static else []
    return maps + ([(fit.negative, -1, VERMILION)] if fit.negative else [])


def _curve(
    left: Axes, right: Axes, fit: MapFit, sign: int, colour: str, v: Real, scale: float, factor: float,
    *, single: bool,
) -> None:  # fmt: skip
    line = "-" if sign > 0 else "--"
    speed = np.geomspace(np.abs(v).min() / 2, np.abs(v).max() * 1.05, 400)
    offset = fit.solution.theta["offset"]
    size, half = fit.predict(speed)
    right.plot(speed * scale, (size - offset) * factor, line, color=colour)
    right.fill_between(
        speed * scale, (size - offset - half) * factor, (size - offset + half) * factor, color=colour, alpha=0.2, lw=0
    )
    for branch in (-1, 1) if single else (sign,):
        if not np.any(v * branch > 0):
            continue
        force, half = fit.predict(branch * speed) if single else (sign * size, half)
        label = "eq. (2) with 95 % band" if branch == 1 else None
        left.plot(branch * speed * scale, force * factor, line, color=colour, label=label)
        left.fill_between(
            branch * speed * scale, (force - half) * factor, (force + half) * factor, color=colour, alpha=0.2, lw=0
        )
