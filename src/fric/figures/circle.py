"""Circles and paths under schemes: the contour error, reversals over time, maps over circles, many machines."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import ceil, pi
from typing import Any, cast

import numpy as np
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import LogLocator, NullLocator

from fric.arrays import Real
from fric.contour import QUADRANTS, beside
from fric.control.scheme import Scheme
from fric.figures.style import BLUE, CYCLE, GREEN, GREY, SKY, VERMILION, feed_of, new_figure, view
from fric.simulate.axis import Trace
from fric.simulate.contour_run import CircleMap, CircleRun, PathRun
from fric.simulate.processes import MonteCarlo

LINES = 4  # Grid lines on either side of the nominal circle, which is drawn with a radius of twice as many
AROUND = np.pi / 12  # Half the width of what is shown, as an angle on the circle [rad]
BEFORE, AFTER = 5.0, 25.0  # What is drawn before and after a reversal [degrees]
WIDE = 8.0  # Ratio of the largest glitch to the smallest from which on they are on a logarithmic axis
TOP = 0.62  # Largest error in the figure of all schemes, over the radius of its reference circle


@view("contour", of="CircleRun", usual=True)
def polar_figure(runs: Sequence[CircleRun]) -> Figure:
    """Return the radial error of each scheme on a polar plot, all at one magnification (Figs. 8 and 9 of the paper).

    The heavy grey circle is the reference; the grid is in µm, outwards positive; the arrow shows the direction of the
    motion; the number at each reversal is its glitch in µm. The magnification is that of the error against the circle.
    """
    grid = grid_of(max(float(np.abs(run.circularity.error).max()) for run in runs) * 1e6)
    magnified = runs[0].circle.radius * 1e6 / (2 * LINES * grid)
    columns = 2 if len(runs) == 4 else min(3, len(runs))
    rows = ceil(len(runs) / columns)
    with new_figure(max(2.9 * columns, 3.4), 3.15 * rows + 0.5) as figure:
        for n, run in enumerate(runs, 1):
            _draw(cast("PolarAxes", figure.add_subplot(rows, columns, n, projection="polar")), run, grid)
        text = f"Radial error of a circle of {feed_of(runs[0].circle)}\nlines {grid:g} µm apart, "
        figure.suptitle(f"{text}magnified {magnified:.3g} times", fontsize=9)
    return figure


def grid_of(largest: float) -> float:
    """Return a round grid [µm] with two to five lines up to the largest error."""
    step = 10.0 ** np.floor(np.log10(max(largest, 1e-3) / 2))
    return float(next(step * factor for factor in (1, 2, 5, 10) if largest <= 4 * step * factor))


def grid_lines(axes: PolarAxes, grid: float) -> None:
    """Draw the reference circle, and a labelled grid [µm] to either side of it."""
    axes.plot(np.linspace(0, 2 * pi, 361), np.zeros(361), color=GREY, linewidth=1.6, zorder=1.9)
    axes.set_ylim(-2 * LINES * grid, LINES * grid * 1.15)
    labels = ["" if n % 2 else f"{n * grid:+g}".replace("-", "−") if n else "0" for n in range(-LINES, LINES)]
    labels.append(f"+{LINES * grid:g} µm")
    axes.set_yticks(grid * np.arange(-LINES, LINES + 1), labels, fontsize=6, color=GREY)
    axes.set_rlabel_position(45)
    axes.set_xticks(np.arange(4) * pi / 2, [name.replace("-", "−") for name in QUADRANTS])
    axes.tick_params(axis="x", pad=-1)
    axes.spines["polar"].set_visible(False)


def direction_arrow(axes: PolarAxes, direction: int, radius: float, colour: str) -> None:
    """Draw an arrow in the direction of the motion: 1 counter-clockwise, -1 clockwise."""
    arc = direction * pi / 15
    axes.annotate(
        "", xy=(1.25 * pi + arc, radius), xytext=(1.25 * pi - arc, radius),
        arrowprops={"arrowstyle": "->", "color": colour, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip


def _draw(axes: PolarAxes, run: CircleRun, grid: float) -> None:
    found = run.circularity
    axes.plot(found.angle, found.error * 1e6, color=BLUE, linewidth=1.0)
    grid_lines(axes, grid)
    for quarter, glitch in enumerate(run.glitches):
        place, text = (quarter * pi / 2 + 0.2, -0.75 * LINES * grid), f"{glitch.median * 1e6:+.1f}"
        axes.text(*place, text, color=VERMILION, fontsize=7, ha="center", va="center")
    direction_arrow(axes, run.circle.direction, -0.45 * LINES * grid, GREY)
    axes.set_title(f"({run.scheme.name}) {run.scheme.title}\nglitch {run.chance().text()} µm", fontsize=8)


@view("map", of="CircleMap", usual=True)
def draw_circle_map(found: CircleMap) -> Figure:
    """Return a panel a scheme: its glitch in µm by feed and radius, one scale of colours; a cross where it cannot run.

    Where a scheme with an observer leaves more than without, the cell is framed: there the observer spoils.
    """
    from matplotlib.colors import LogNorm
    from matplotlib.patches import Rectangle
    from matplotlib.ticker import LogLocator

    grid, glitches = found.grid, found.glitches * 1e6
    count = len(grid.schemes)
    columns = 2 if count > 1 else 1
    rows = -(-count // columns)
    known = glitches[np.isfinite(glitches)]
    low, high = (float(known.min()), float(known.max())) if known.size else (1.0, 10.0)
    scale = LogNorm(max(low, 1e-3), max(high, 2 * max(low, 1e-3)))
    of_observers = (pair for name, pair in found.pairs().items() if name.startswith("observer"))
    spoiled = {scheme.name: found.less(scheme, other) < 0 for scheme, other in of_observers}
    with new_figure(2.0 + 3.0 * columns, 0.6 + 2.3 * rows) as figure:
        panels = np.atleast_1d(figure.subplots(rows, columns, squeeze=False)).ravel()
        drawn = None
        for panel, scheme, values in zip(panels, grid.schemes, glitches, strict=False):
            drawn = panel.imshow(values, norm=scale, cmap="cividis", origin="lower", aspect="auto")
            for (row, column), value in np.ndenumerate(values):
                dark = np.isfinite(value) and scale(value) < 0.55
                text = f"{value:.3g}" if np.isfinite(value) else "×"
                panel.text(column, row, text, ha="center", va="center", fontsize=6, color="white" if dark else "black")
                if scheme.name in spoiled and spoiled[scheme.name][row, column]:
                    corner = (column - 0.46, row - 0.46)
                    panel.add_patch(Rectangle(corner, 0.92, 0.92, fill=False, linewidth=1.2, color=VERMILION))
            panel.set_xticks(range(len(grid.feeds)), [f"{1e3 * feed:.3g}" for feed in grid.feeds])
            panel.set_yticks(range(len(grid.radii)), [f"{1e3 * value:.3g}" for value in grid.radii])
            panel.set_title(f"({scheme.name}) {scheme.title}", fontsize=8)
            panel.set(xlabel="feed [mm/s]", ylabel="radius [mm]")
            panel.grid(visible=False)
            panel.tick_params(length=0)
        for panel in panels[count:]:
            panel.set_axis_off()
        if drawn is not None:
            bar = figure.colorbar(drawn, ax=list(panels), shrink=0.9)
            bar.set_label("glitch [µm]")
            bar.ax.yaxis.set_major_formatter("{x:g}")
            bar.ax.yaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
            bar.ax.yaxis.set_minor_formatter("{x:g}")
            bar.ax.tick_params(which="both", labelsize=7)
        framed = "; framed: the observer leaves more" if any(np.any(array) for array in spoiled.values()) else ""
        figure.suptitle(f"{grid.machine.name}{framed}", fontsize=9, color=GREY)
    return figure


@view("reversal", of="CircleRun")
def reversal_figure(runs: Sequence[CircleRun]) -> Figure:
    """Return error and voltages over time around the last reversal of an axis, one column per scheme.

    Above the tracking error of the axis, position less reference; below the control voltage, and in it the friction
    feedforward and the output of the observer, which is its estimate with opposite sign.
    """
    name = next(iter(runs[0].traces))
    test = runs[0].circle
    half = AROUND * test.radius / test.feed
    columns = len(runs)
    with new_figure(1.2 + 1.7 * columns, 4.2) as figure:
        panels = figure.subplots(2, columns, sharex=True, sharey="row", squeeze=False, height_ratios=(1, 1.25))
        for (above, below), run in zip(panels.T, runs, strict=True):
            trace = run.traces[name]
            t = (trace.time - last_reversal(trace, half)) * 1e3
            near = np.abs(t) <= half * 1e3
            above.plot(t[near], (trace.position - trace.reference)[near] * 1e6, color=BLUE)
            above.set_title(f"({run.scheme.name})\n{run.scheme.title}", fontsize=8)
            below.plot(t[near], trace.input[near], color=GREY, label="control voltage", linewidth=0.8)
            if run.scheme.feeds_forward:
                below.plot(t[near], trace.feedforward[near], "--", color=VERMILION, label="friction feedforward")
            if run.scheme.observer:
                below.plot(t[near], -trace.disturbance[near], "-.", color=GREEN, label="observer, −d̂")
            for axes in (above, below):
                axes.axvline(0, color=GREY, linewidth=0.6)
            below.set_xlabel("time [ms]")
        panels[0, 0].set_ylabel(f"error of {name} [µm]")
        panels[1, 0].set_ylabel("voltage [V]")
        drawn = (line for axes in panels[1] for line in axes.get_lines())
        shown = {line.get_label(): line for line in drawn if not str(line.get_label()).startswith("_")}
        figure.legend(shown.values(), shown.keys(), loc="outside lower center", ncols=len(shown))
        figure.suptitle(f"Reversal of axis {name}: circle of {feed_of(test)}", fontsize=9)
    return figure


def last_reversal(trace: Trace, margin: float) -> float:
    """Return the time [s] of the last reversal of the reference at least ``margin`` [s] before its end."""
    steps = np.sign(np.diff(trace.reference))
    reversals = trace.time[np.flatnonzero(steps[1:] * steps[:-1] < 0) + 1]
    whole = reversals[reversals <= trace.time[-1] - margin]
    return float(whole[-1] if len(whole) else reversals[-1])


@view("contour", of="PathRun", usual=True)
def path_figure(runs: Sequence[PathRun]) -> Figure:
    """Return the path with the places where an axis reverses, and beside it the contour error of each scheme."""
    first = runs[0]
    names = tuple(first.traces) if len(first.traces) > 1 else beside(*first.traces)
    time = next(iter(first.traces.values())).time
    apart = 2.2 * max(float(np.ptp(run.contour.error)) for run in runs) * 1e6 / 2
    with new_figure(8.4, 1.6 + 0.75 * len(runs)) as figure:
        plan, along = figure.subplots(1, 2, width_ratios=(1, 2))
        plan.plot(*(1e3 * axis.position for axis in first.test.references(1.0 / (time[1] - time[0]))), color=GREY)
        for n, reversal in enumerate(first.contour.reversals, 1):
            place = (1e3 * reversal.x, 1e3 * reversal.y)
            plan.plot(*place, "o", color=VERMILION, markersize=4)
            plan.annotate(str(n), place, textcoords="offset points", xytext=(4, 4), fontsize=7)
        plan.set_aspect("equal", adjustable="box")
        plan.set(xlabel=f"{names[0]} [mm]", ylabel=f"{names[1]} [mm]")
        plan.set_title("path; numbers where an axis reverses", fontsize=8)
        ticks = [-n * apart for n in range(len(runs))]
        for n, (level, run) in enumerate(zip(ticks, runs, strict=True)):
            along.axhline(level, color=GREY, linewidth=0.6)
            station, error = run.contour.station * 1e3, run.contour.error * 1e6 + level
            along.plot(station, error, color=CYCLE[n % len(CYCLE)], linewidth=0.9)
        along.set_yticks(ticks, [f"({run.scheme.name}) {run.chance().text()} µm" for run in runs])
        along.set(xlabel="distance along the path [mm]", ylabel="contour error [µm]")
        along.set_title(f"contour error, lines {apart:.3g} µm apart; glitch of each scheme", fontsize=8)
    return figure


@view("distribution", of="MonteCarlo", usual=True)
def monte_carlo_figure(found: MonteCarlo, nominal: Mapping[str, float] | None = None) -> Figure:
    """Return the glitches of all machines by scheme, and the share of machines on which each scheme is the best.

    A dot is a machine; the bar goes from the 5 % to the 95 % quantile, with the quartiles thick and the median white.

    nominal: Glitch of the nominal machine by scheme [m], drawn as a diamond.
    """
    schemes, glitches = found.study.schemes, found.glitches * 1e6
    text = found.distributions()
    places = np.arange(len(schemes))
    with new_figure(6.3, 1.3 + 0.42 * len(schemes)) as figure:
        left, right = figure.subplots(1, 2, sharey=True, width_ratios=(3, 1))
        for place, scheme, column in zip(places, schemes, glitches.T, strict=True):
            if len(ran := column[np.isfinite(column)]):
                # spread out by machine number: a golden-ratio sequence fills the strip evenly
                offset = 0.08 + 0.27 * (np.arange(len(ran)) * 0.618034 % 1.0)
                left.plot(ran, place + offset, ".", color=SKY, markersize=4, alpha=0.8, markeredgewidth=0)
                low, first, median, third, high = np.quantile(ran, (0.05, 0.25, 0.5, 0.75, 0.95))
                bar = [place - 0.12] * 2
                left.plot([low, high], bar, color=BLUE, linewidth=1.4, solid_capstyle="butt")
                left.plot([first, third], bar, color=BLUE, linewidth=6, solid_capstyle="butt")
                left.plot([median], bar[:1], "|", color="white", markersize=6, markeredgewidth=1.6)
            if nominal and scheme.name in nominal:
                left.plot(nominal[scheme.name] * 1e6, place - 0.32, "D", color=VERMILION, markersize=4)
            share = text[scheme.name].best * 100
            right.barh(place, share, height=0.5, color=BLUE)
            right.text(share + 2, place, f"{share:.0f} %", va="center", fontsize=7, color=GREY)
        left.set_yticks(places, [f"({scheme.name}) {scheme.title}" for scheme in schemes])
        left.invert_yaxis()
        left.set(xlim=(0, None), xlabel="glitch [µm]")
        shown = np.append(glitches, [1e6 * value for value in (nominal or {}).values()])
        shown = shown[np.isfinite(shown) & (shown > 0.0)]
        if len(shown) and shown.max() > WIDE * shown.min():  # else small glitches and their bars are points
            left.set(xscale="log", xlim=(0.8 * shown.min(), 1.25 * shown.max()))
            left.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            left.xaxis.set_major_formatter("{x:g}")
            left.xaxis.set_minor_locator(NullLocator())
        right.set(xlim=(0, 118), xticks=[0, 50, 100])
        right.set_xlabel("least glitch on [%]", loc="right")  # it is wider than its axes
        for axes in (left, right):
            axes.grid(visible=False, axis="y")
            axes.tick_params(axis="y", length=0)
        note = "line: 90 % of them, bar: half, white: median" + ", diamond: nominal machine" * bool(nominal)
        figure.suptitle(f"{len(found)} machines, circle of {feed_of(found.study.circle)}\n{note}", fontsize=9)
    return figure


@dataclass(frozen=True, eq=False)
class SchemeContour:
    """Result of one scheme on a contour."""

    scheme: Scheme
    place: Real  # angle on the circle [rad], or station along the path [m], shape (n,)
    error: Real  # contour error there [m], outwards positive, shape (n,)
    look: Mapping[str, Any] = field(default_factory=dict)  # its label, and changes to `look_of`


def look_of(n: int, contour: SchemeContour) -> dict[str, Any]:
    """Return the look of the n-th contour with its label."""
    label = {"label": f"({contour.scheme.name}) {contour.scheme.title}"}
    return scheme_look(n, contour.scheme) | label | dict(contour.look)


def scheme_look(n: int, scheme: Scheme) -> dict[str, Any]:
    """Return the look of the n-th scheme: dashed with an observer; thinner than those beneath it, which it may hide."""
    width = max(2.0 - 0.25 * n, 0.8)
    return {"color": CYCLE[n % len(CYCLE)], "linestyle": "--" if scheme.observer else "-", "linewidth": width}


def overlay_figure(
    contours: Sequence[SchemeContour], radius: float, direction: int, magnification: float,
    earlier: Sequence[SchemeContour] = (), size: tuple[float, float] = (6.6, 5.6),
) -> Figure:  # fmt: skip
    """Draw the radial error of all schemes around one circle, magnified; those of an earlier run are dotted.

    Lines are called ``now:NAME`` and ``earlier:NAME``, the rings of the grid and their labels ``ring:-3`` to
    ``ring:2``, so that a page can switch and magnify them.

    magnification: How many times larger the error is drawn than the circle [1].
    """
    R = radius * 1e6 / magnification  # the radius of the reference circle, in µm of error
    step = _round(R / 6)
    with new_figure(*size) as figure:
        axes = cast("PolarAxes", figure.add_subplot(projection="polar"))
        for n in (-3, -2, -1, 1, 2):
            within = -0.7 * R <= n * step <= TOP * R  # others are a point, which a page may magnify
            label, at = (f"{n * step:+g} µm".replace("-", "−"), n * step) if within else (" ", -R)
            apart = np.pi / 4 + 0.12 * R / max(R + at, 0.3 * R)  # its label breaks the ring
            turn = np.linspace(apart, 2.5 * np.pi - apart, 181)
            axes.plot(turn, np.full(181, at), ":", color=GREY, linewidth=0.7, gid=f"ring:{n}")
            axes.text(np.pi / 4, at, label, fontsize=7, gid=f"ring:{n}", va="center", ha="center")
        axes.plot(np.linspace(0, 2 * np.pi, 181), np.zeros(181), color=GREY, linewidth=1.6)
        for which, run in (("earlier", earlier), ("now", contours)):
            for n, contour in enumerate(run):
                look = look_of(n, contour) | ({"linestyle": ":", "label": None} if which == "earlier" else {})
                axes.plot(contour.place, contour.error * 1e6, gid=f"{which}:{contour.scheme.name}", **look)
        axes.set(ylim=(-R, TOP * R), yticks=[])
        axes.set_xticks(np.arange(4) * np.pi / 2, [name.replace("-", "−") for name in QUADRANTS])
        axes.spines["polar"].set_visible(False)
        direction_arrow(axes, direction, -0.72 * R, GREY)
        figure.legend(loc="outside lower center", ncols=3)
    return figure


def after_reversal_figure(
    contours: Sequence[SchemeContour], radius: float, feed: float, direction: int, quarter: float
) -> Figure:
    """Draw the radial error of all schemes over the time after a reversal.

    The time is the angle from the reversal times R/F; the error less its median around the circle, so that spikes
    compare.
    """
    with new_figure(4.8, 3.3) as figure:
        axes = figure.subplots()
        for n, contour in enumerate(contours):
            off = (direction * np.degrees(contour.place - quarter) + 180) % 360 - 180
            near = (off >= -BEFORE) & (off <= AFTER)
            order = np.argsort(off[near])
            time = np.radians(off[near][order]) * radius / feed * 1e3
            error = (contour.error[near][order] - np.median(contour.error)) * 1e6
            axes.plot(time, error, gid=f"now:{contour.scheme.name}", **look_of(n, contour))
        axes.set(xlabel="time after the reversal [ms]", ylabel="radial error [µm]")
        axes.legend()
    return figure


def along_figure(contours: Sequence[SchemeContour]) -> Figure:
    """Draw the contour error of all schemes along a path."""
    with new_figure(7.2, 3.6) as figure:
        axes = figure.subplots()
        for n, contour in enumerate(contours):
            axes.plot(contour.place * 1e3, contour.error * 1e6, gid=f"now:{contour.scheme.name}", **look_of(n, contour))
        axes.set(xlabel="station [mm]", ylabel="contour error [µm]")
        axes.legend(loc="upper right")
    return figure


def _round(value: float) -> float:
    """Return the next of 1, 2, 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(step * power for step in (1, 2, 5, 10) if step * power >= 0.999 * value))


def draw_drift(names: Sequence[str], percent: Real, moved: Sequence[bool]) -> Figure:
    """Draw the relative change of each number with its 95 % interval; a diamond where that does not hold 0.

    percent: Each change, and its lower and upper limit [%], shape (n, 3).
    moved: Whether the number moved beyond its limits.
    """
    with new_figure(7.0, 0.7 + 0.24 * len(names)) as figure:
        axes = figure.subplots()
        places = np.arange(len(names))[::-1]
        axes.axvline(0.0, color=GREY, linestyle="--", linewidth=0.8)
        for place, (change, low, high), beyond in zip(places, percent, moved, strict=True):
            colour = VERMILION if beyond else BLUE
            axes.plot([low, high], [place, place], color=colour, linewidth=1.6)
            axes.plot(change, place, "D" if beyond else "o", color=colour, markersize=4)
        axes.set_yticks(places, names)
        axes.set(xlabel="change [%]", ylim=(-0.7, len(names) - 0.3))
    return figure
