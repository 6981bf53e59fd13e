"""The contour error under each scheme, all in one figure: around the circle, after a reversal, along a path."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes

from fric.arrays import Real
from fric.contour import QUADRANTS
from fric.control.scheme import Scheme
from fric.figures.circle import direction_arrow
from fric.figures.style import BLUE, CYCLE, GREY, VERMILION, new_figure

BEFORE, AFTER = 5.0, 25.0  # What is drawn before and after a reversal [degrees]


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

    contours, earlier: The schemes, and those of an earlier run.
    magnification: How many times larger the error is drawn than the circle [1].
    """
    R = radius * 1e6 / magnification  # the radius of the reference circle, in µm of error
    step = _round(R / 6)
    with new_figure(*size) as figure:
        axes = cast("PolarAxes", figure.add_subplot(projection="polar"))
        turn = np.linspace(0, 2 * np.pi, 181)
        for n in (-3, -2, -1, 1, 2):
            name, label, at = f"ring:{n}", f"{n * step:+g} µm".replace("-", "−"), max(n * step, -R)
            axes.plot(turn, np.full(181, at), ":", color=GREY, linewidth=0.7, gid=name)
            axes.text(np.pi / 4, at, label, fontsize=7, gid=name, va="center")
        axes.plot(turn, np.zeros(181), color=GREY, linewidth=1.6)
        for which, run in (("earlier", earlier), ("now", contours)):
            for n, contour in enumerate(run):
                look = look_of(n, contour) | ({"linestyle": ":", "label": None} if which == "earlier" else {})
                axes.plot(contour.place, contour.error * 1e6, gid=f"{which}:{contour.scheme.name}", **look)
        axes.set_ylim(-R, 0.62 * R)
        axes.set_yticks([])
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
            off = direction * np.degrees(contour.place - quarter)
            off = (off + 180) % 360 - 180
            near = (off >= -BEFORE) & (off <= AFTER)
            order = np.argsort(off[near])
            time = np.radians(off[near][order]) * radius / feed * 1e3
            error = (contour.error[near][order] - np.median(contour.error)) * 1e6
            _line(axes, n, contour, time, error)
        axes.set(xlabel="time after the reversal [ms]", ylabel="radial error [µm]")
        axes.legend()
    return figure


def along_figure(contours: Sequence[SchemeContour]) -> Figure:
    """Draw the contour error of all schemes along a path."""
    with new_figure(7.2, 3.6) as figure:
        axes = figure.subplots()
        for n, contour in enumerate(contours):
            _line(axes, n, contour, contour.place * 1e3, contour.error * 1e6)
        axes.set(xlabel="station [mm]", ylabel="contour error [µm]")
        axes.legend(loc="upper right")
    return figure


def _line(axes: Axes, n: int, contour: SchemeContour, x: Real, y: Real) -> None:
    axes.plot(x, y, gid=f"now:{contour.scheme.name}", **look_of(n, contour))


def _round(value: float) -> float:
    """Return the next of 1, 2, 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(step * power for step in (1, 2, 5, 10) if step * power >= 0.999 * value))


@dataclass(frozen=True)
class RelativeChange:
    """A number at two dates: its name, its change with 95 % limits [%], and whether it moved beyond them."""

    name: str
    change: float
    low: float
    high: float
    moved: bool


def draw_drift(changes: Sequence[RelativeChange]) -> Figure:
    """Draw the relative change of each number with its 95 % interval; a diamond where that does not hold 0."""
    with new_figure(7.0, 0.7 + 0.24 * len(changes)) as figure:
        axes = figure.subplots()
        places = np.arange(len(changes))[::-1]
        axes.axvline(0.0, color=GREY, linestyle="--", linewidth=0.8)
        for place, change in zip(places, changes, strict=True):
            colour = VERMILION if change.moved else BLUE
            axes.plot([change.low, change.high], [place, place], color=colour, linewidth=1.6)
            axes.plot(change.change, place, "D" if change.moved else "o", color=colour, markersize=4)
        axes.set_yticks(places, [change.name for change in changes])
        axes.set_xlabel("change [%]")
        axes.set_ylim(-0.7, len(changes) - 0.3)
    return figure
