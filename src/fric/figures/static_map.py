"""Measured and fitted friction-velocity map, as Fig. 2 of the paper."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fric.arrays import Real
from fric.figures.style import BLACK, BLUE, GREY, VERMILION, Band, new_figure, shade, view
from fric.identify.static_map.identify import StaticFit
from fric.units import Motion, prefixed, rotates, si_unit

_VELOCITY_SCALES = ((1e3, "mm/s"), (1.0, "rad/s"))


@dataclass(frozen=True, eq=False)
class MapBranches:
    """A fitted map for both directions or for one direction, and its offset [N]."""

    sign: int  # 1 for both directions or the positive direction, -1 for the negative direction
    branches: Sequence[Band]  # force as it was logged over velocity [N over m/s], a curve a direction
    size: Band  # force in the direction of motion, the offset taken off, over speed [N over m/s]
    standing_off: Sequence[tuple[float, float]] = ()  # velocity [m/s] and force [N] of strokes that weigh less
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class FrictionMap:
    """What is drawn of a friction-velocity map: of a fit, or of a document with the logs that are there."""

    motion: Motion
    maps: Sequence[MapBranches]  # a single map, or one a direction
    velocity: Real  # of measured strokes [m/s], shape (n,)
    force: Real  # [N], shape (n,)
    half: Real  # half of their 95 % intervals [N], shape (n,)

    def scales(self) -> tuple[float, str, float, str]:
        """Return factor and unit of velocity and of force, in which people read them."""
        ends = [np.max(np.abs(branch.y)) for branches in self.maps for branch in branches.branches]
        peak = np.max(np.abs(self.force)) if self.force.size else max(ends)
        return *_VELOCITY_SCALES[rotates(self.motion)], *prefixed(float(peak), si_unit("force", self.motion))


@view("map", of="StaticFit", usual=True)
def draw_static_map(fit: StaticFit) -> Figure:
    """Draw the measured forces with error bars, the fitted map of eq. (2) and its 95 % band.

    The left panel shows the whole range as the paper's Fig. 2, the right panel the range of the Stribeck effect over a
    logarithmic speed, with both directions overlaid and the offset subtracted.
    """
    found = _map_of(fit)
    with new_figure(7.2, 3.6) as figure:
        left, right = figure.subplots(1, 2)
        _over_velocity(left, found)
        _over_speed(right, found)
        left.set_title("measured and fitted map")
        any_offset = fit.static is not None and fit.static.solution.theta["offset"]
        right.set_title("both directions, offset taken off" if any_offset else "both directions")
        return figure


def map_figure(found: FrictionMap, *, logarithmic: bool) -> Figure:
    """Draw a panel of `draw_static_map` alone: over velocity, or over the logarithm of speed."""
    with new_figure(4.8, 3.3) as figure:
        (_over_speed if logarithmic else _over_velocity)(figure.subplots(), found)
        return figure


def _map_of(fit: StaticFit) -> FrictionMap:
    """Return what is drawn of a fit."""
    v = np.array([p.velocity for p in fit.points])
    between = fit.static.between if fit.static else 0.0
    half = 1.96 * np.sqrt(np.array([p.standard_error for p in fit.points]) ** 2 + between**2)
    speed = np.geomspace(np.abs(v).min() / 2, np.abs(v).max() * 1.05, 400)
    maps = []
    for one, sign in ((fit.static, 1), (fit.negative, -1)):
        if one is None:
            continue
        offset, (size, error) = one.solution.theta["offset"], one.predict(speed)
        branches = []
        for branch in (-1, 1) if fit.negative is None else (sign,):
            if np.any(v * branch > 0):
                force, wide = one.predict(branch * speed) if fit.negative is None else (sign * size, error)
                branches.append(Band(branch * speed, force, force - wide, force + wide))
        along = Band(speed, size - offset, size - offset - error, size - offset + error)
        maps.append(MapBranches(sign, branches, along, [(p.velocity, p.force) for p, _ in one.standing_off], offset))
    return FrictionMap(fit.motion, maps, v, np.array([p.force for p in fit.points]), half)


def _over_velocity(axes: Axes, found: FrictionMap) -> None:
    scale, unit, factor, force_unit = found.scales()
    _points(axes, found.velocity * scale, found.force * factor, found.half * factor)
    for branches in found.maps:
        for v, F in branches.standing_off:
            axes.plot(v * scale, F * factor, "x", color=GREY, zorder=4)
        for branch in branches.branches:
            label = "eq. (2) with 95 % band" if branch.x[-1] > 0 else None
            shade(axes, branch.scaled(scale, factor), **_look(branches), label=label)
    axes.set(xlabel=f"velocity [{unit}]", ylabel=f"friction [{force_unit}]")
    axes.legend(loc="center right")


def _over_speed(axes: Axes, found: FrictionMap) -> None:
    scale, unit, factor, force_unit = found.scales()
    offset = found.maps[0].offset if found.maps and found.maps[0].sign > 0 else 0.0
    for branches in found.maps:
        for v, F in branches.standing_off:
            axes.plot(abs(v) * scale, (F - branches.offset) * np.sign(v) * factor, "x", color=GREY, zorder=4)
    for sign, colour, marker, label in (
        (1, BLUE, "o", "positive direction"),
        (-1, VERMILION, "s", "negative direction"),
    ):
        chosen = found.velocity * sign > 0
        size = sign * (found.force[chosen] - offset)
        _points(axes, sign * found.velocity[chosen] * scale, size * factor, found.half[chosen] * factor,
                colour, marker, label)  # fmt: skip
    for branches in found.maps:
        shade(axes, branches.size.scaled(scale, factor), **_look(branches))
    axes.set(xlabel=f"speed [{unit}]", ylabel=f"friction in the direction of motion [{force_unit}]", xscale="log")
    axes.xaxis.set_major_formatter("{x:g}")
    if found.velocity.size:
        axes.legend()


def _look(branches: MapBranches) -> dict[str, str]:
    return {"colour": BLUE, "line": "-"} if branches.sign > 0 else {"colour": VERMILION, "line": "--"}


def _points(
    axes: Axes, x: Real, y: Real, error: Real,
    colour: str = BLACK, marker: str = "o", label: str = "measured, 95 %",
) -> None:  # fmt: skip
    if x.size:
        axes.errorbar(
            x, y, yerr=error, fmt=marker, color=colour, markersize=3.5, markerfacecolor="white", elinewidth=0.8,
            capsize=2, label=label, zorder=3,
        )  # fmt: skip
