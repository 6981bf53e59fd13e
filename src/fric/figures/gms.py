"""Friction-velocity map (Fig. 2 of the paper); pre-sliding cycles, virgin curve, and replay (Figs. 4 and 5)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from fric.arrays import Real
from fric.figures.style import BLACK, BLUE, GREY, ORANGE, VERMILION, Band, look, new_figure, shade, view
from fric.identify.gms.identify import GMSFit, Replay
from fric.identify.gms.virgin_curve import HysteresisCycles, VirginCurve
from fric.identify.static_map.identify import StaticFit
from fric.units import Motion, prefixed, rotates, si_unit

Scale = tuple[float, str]


@dataclass(frozen=True, eq=False)
class Virgin:
    """What is drawn of a virgin curve: of a fit, or of a document with the logs that are there."""

    motion: Motion
    level: float  # force that the unit is chosen by [N]
    model: Band  # the curve of the blocks [N over m]
    knots: Real  # slip displacement of each block, increasing [m], shape (N,)
    at_knots: Real  # the force there [N], shape (N,)
    measured: VirginCurve | None = None


@view("cycles", of="GMSFit", usual=True)
def draw_gms(fit: GMSFit) -> Figure:
    """Draw the hysteresis cycles, the virgin curve with knots and band, and the measured against the replayed force.

    The first row shows each record as the paper's Fig. 4, with the parts marked that the virgin curve is from; the
    second the virgin curve as Fig. 5, and again over a logarithmic axis, where the first knots are; the third each
    record over time.
    """
    hysteresis = sorted(fit.hysteresis, key=lambda cycle: cycle.amplitude)
    rows = 2 + len(fit.records)
    with new_figure(7.4, 5.6 + 1.5 * len(fit.records)) as figure:
        grid = figure.add_gridspec(rows, 2 * len(hysteresis), height_ratios=[2.2, 2.2, *[1.2] * len(fit.records)])
        force = prefixed(fit.static.F_s, si_unit("force", fit.motion))
        for n, cycle in enumerate(hysteresis):
            _cycle(figure.add_subplot(grid[0, 2 * n : 2 * n + 2]), fit, cycle, force)
        known = {str(line.get_label()): line for axes in figure.axes for line in axes.lines}
        shown = {label: line for label, line in known.items() if not label.startswith("_")}
        figure.legend(shown.values(), shown.keys(), loc="outside upper left", ncols=2)
        middle = len(hysteresis)
        panels = (figure.add_subplot(grid[1, :middle]), figure.add_subplot(grid[1, middle:]))
        virgin = _virgin_of(fit)
        for panel, logarithmic in zip(panels, (False, True), strict=True):
            _virgin(panel, virgin, force, logarithmic=logarithmic)
        panels[0].set_title(f"virgin curve, {len(virgin.knots)} blocks")
        panels[1].set_title("the same, logarithmic")
        for n, record in enumerate(fit.records):
            _replay(figure.add_subplot(grid[2 + n, :]), record, force, legend=n == 0)
        return figure


def _cycle(axes: Axes, fit: GMSFit, hysteresis: HysteresisCycles, force: Scale) -> None:
    """Draw one record, with what is selected of it in colour."""
    length = prefixed(hysteresis.amplitude, si_unit("position", fit.motion))
    record = hysteresis.record
    position = record.motion.position
    middle = 0.5 * (position.max() + position.min())
    far = abs(middle) > 2.0 * hysteresis.amplitude
    z, F = (position - middle * far) * length[0], record.force * force[0]
    axes.plot(z, F, color=GREY, lw=0.6, label="record")
    ends = dict(fit.curve.record)
    start = max((end for end in ends.values() if end < 0.95 * ends.get(record.log.name, np.inf)), default=0.0)
    label: str | None = "for the virgin curve"
    for first, reversal, last in hysteresis.chosen() if record.log.name in ends else []:
        for a, b in ((first, reversal), (reversal, last)):
            part = slice(a, b + 1)
            chosen = 0.5 * np.abs(position[part] - position[a]) >= start
            axes.plot(z[part][chosen], F[part][chosen], color=VERMILION, lw=0.9, label=label)
            label = None
    place = "position from the middle" if far else "position"
    axes.set(xlabel=f"{place} [{length[1]}]", ylabel=f"friction [{force[1]}]", title=record.log.name)


def _virgin_of(fit: GMSFit) -> Virgin:
    curve, level = fit.curve, float(fit.alpha_sum) if fit.static_given else 1.0
    knots, stiffness = fit.model.slip_displacements * level, np.asarray(fit.k.value)
    z, far = curve.displacement, float(curve.displacement[-1])
    at = np.unique(np.concatenate([np.geomspace(z[0], end, 400) for end in (far, min(far, 2.0 * knots[-1]))] + [knots]))

    def force(x: Real) -> Real:
        return np.asarray(np.minimum(x[:, None], knots) @ stiffness)

    model = force(at)
    return Virgin(fit.motion, fit.static.F_s, Band(at, model, model, model), knots, force(knots), curve)


def virgin_figure(found: Virgin, *, logarithmic: bool) -> Figure:
    """Draw the virgin curve alone: over displacement, or over its logarithm, where the first knots are."""
    with new_figure(4.8, 3.3) as figure:
        axes = figure.subplots()
        _virgin(axes, found, prefixed(found.level, si_unit("force", found.motion)), logarithmic=logarithmic)
        return figure


def _virgin(axes: Axes, found: Virgin, force: Scale, *, logarithmic: bool) -> None:
    """Draw the measured virgin curve with its band, the model's, and the knots."""
    measured, model, knots = found.measured, found.model, found.knots
    far = float(model.x[-1] if measured is None else measured.displacement[-1])
    shown = far if logarithmic else min(far, 2.0 * float(knots[-1]))
    length = prefixed(float(np.median(knots)), si_unit("position", found.motion))
    if measured is not None:
        inside = measured.displacement <= shown
        z, F, half = (array[inside] for array in (measured.displacement, measured.force, np.nan_to_num(measured.band)))
        axes.plot(z * length[0], F * force[0], ".", ms=2.5, color=BLACK, label="measured")
        axes.fill_between(
            z * length[0], (F - half) * force[0], (F + half) * force[0], color=ORANGE, alpha=0.4, lw=0,
            label="its 95 % band",
        )  # fmt: skip
    inside = model.x <= shown
    seen = Band(*(array[inside] for array in (model.x, model.y, model.low, model.high)))
    banded = " with 95 % band" * bool(np.any(model.high > model.low))
    shade(axes, seen.scaled(length[0], force[0]), BLUE, lw=1.0, label=f"GMS{banded}")
    inside = knots <= shown
    axes.plot(
        knots[inside] * length[0], found.at_knots[inside] * force[0], "o", ms=5, mfc="white", mec=BLUE, label="knots"
    )
    axes.set(xlabel=f"displacement [{length[1]}]", ylabel=f"friction [{force[1]}]")
    if logarithmic:
        first = float(model.x[0] if measured is None else measured.displacement[0])
        axes.set(xscale="log", xlim=(max(first, 0.02 * float(knots[0])) * length[0], None))
        axes.xaxis.set_major_formatter("{x:g}")
    axes.legend(loc="lower right")


@dataclass(frozen=True, eq=False)
class ReplayedCycle:
    """A pre-sliding cycle: displacement [m], measured force (None without a log) and that of the model [N]."""

    name: str
    position: Real
    measured: Real | None
    model: Real


def cycles_figure(cycles: Sequence[ReplayedCycle], motion: Motion) -> Figure:
    """Draw pre-sliding cycles in one panel: a measured cycle with its replay, or several of the model alone."""
    length = prefixed(max(float(np.ptp(cycle.position)) / 2 for cycle in cycles), si_unit("position", motion))
    force = prefixed(max(float(np.abs(cycle.model).max()) for cycle in cycles), si_unit("force", motion))
    with new_figure(4.8, 3.3) as figure:
        axes = figure.subplots()
        for n, cycle in enumerate(cycles):
            z = cycle.position * length[0]
            if cycle.measured is not None:
                axes.plot(z, cycle.measured * force[0], color=GREY, lw=2.5, alpha=0.5, label="measured")
            label = cycle.name if cycle.measured is None else "GMS replayed"
            axes.plot(z, cycle.model * force[0], **look(n), label=label)
        axes.set(xlabel=f"position from the middle [{length[1]}]", ylabel=f"friction [{force[1]}]")
        axes.legend(loc="center")
        return figure


def _replay(axes: Axes, record: Replay, force: Scale, *, legend: bool) -> None:
    """Draw measured and replayed force over time, and what is left."""
    t, measured = record.record.motion.time, record.record.force
    axes.plot(t, measured * force[0], color=GREY, lw=1.6, label="measured")
    axes.plot(t, record.replayed * force[0], color=BLUE, lw=0.8, label="replayed")
    difference = np.where(record.record.used | record.held_out, measured - record.replayed, np.nan)
    axes.plot(t, difference * force[0], color=VERMILION, lw=0.5, label="difference")
    if record.held_out.any():
        axes.axvspan(t[record.held_out][0], t[-1], color=ORANGE, alpha=0.12, lw=0, label="held out")
    axes.set(xlabel="time [s]", ylabel=f"friction [{force[1]}]")
    axes.set_title(record.name, loc="left")
    axes.margins(x=0.01)
    if legend:
        axes.legend(loc="lower right", ncols=4, bbox_to_anchor=(1.0, 1.0))


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
        speed = (1.0, "rad/s") if rotates(self.motion) else (1e3, "mm/s")
        return *speed, *prefixed(float(peak), si_unit("force", self.motion))


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
    v = np.array([p.velocity for p in fit.points])
    between = fit.static.between if fit.static else 0.0
    half = 1.96 * np.sqrt(np.array([p.standard_error for p in fit.points]) ** 2 + between**2)
    speed = np.geomspace(np.abs(v).min() / 2, np.abs(v).max() * 1.05, 400)
    maps = []
    for fitted, sign in ((fit.static, 1), (fit.negative, -1)):
        if fitted is None:
            continue
        offset, (size, error) = fitted.solution.theta["offset"], fitted.predict(speed)
        branches = []
        for branch in (-1, 1) if fit.negative is None else (sign,):
            if np.any(v * branch > 0):
                force, wide = fitted.predict(branch * speed) if fit.negative is None else (sign * size, error)
                branches.append(Band(branch * speed, force, force - wide, force + wide))
        along = Band(speed, size - offset, size - offset - error, size - offset + error)
        maps.append(MapBranches(sign, branches, along, [(p.velocity, p.force) for p, _ in fitted.standing_off], offset))
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
    axes.legend(loc="best")


def _over_speed(axes: Axes, found: FrictionMap) -> None:
    scale, unit, factor, force_unit = found.scales()
    offset = found.maps[0].offset if found.maps and found.maps[0].sign > 0 else 0.0
    for branches in found.maps:
        for v, F in branches.standing_off:
            axes.plot(abs(v) * scale, (F - branches.offset) * np.sign(v) * factor, "x", color=GREY, zorder=4)
    for sign, colour, marker, label in (1, BLUE, "o", "positive direction"), (-1, VERMILION, "s", "negative direction"):
        chosen = found.velocity * sign > 0
        size = sign * (found.force[chosen] - offset)
        _points(axes, sign * found.velocity[chosen] * scale, size * factor, found.half[chosen] * factor,
                colour, marker, label)  # fmt: skip
    for branches in found.maps:
        shade(axes, branches.size.scaled(scale, factor), **_look(branches))
    axes.set(xlabel=f"speed [{unit}]", ylabel=f"friction in the direction of motion [{force_unit}]", xscale="log")
    axes.xaxis.set_major_formatter("{x:g}")
    low, high = axes.get_xlim()
    if high < 20 * low:  # about a decade, of which powers of ten alone would be one label
        axes.xaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
        axes.xaxis.set_minor_formatter("{x:g}")
    if found.velocity.size:
        axes.legend()


def _look(branches: MapBranches) -> dict[str, str]:
    return {"colour": BLUE, "line": "-"} if branches.sign > 0 else {"colour": VERMILION, "line": "--"}


def _points(
    axes: Axes, x: Real, y: Real, error: Real, colour: str = BLACK, marker: str = "o", label: str = "measured, 95 %",
) -> None:  # fmt: skip
    if x.size:
        axes.errorbar(
            x, y, yerr=error, fmt=marker, color=colour, markersize=3.5, markerfacecolor="white", elinewidth=0.8,
            capsize=2, label=label, zorder=3,
        )  # fmt: skip
