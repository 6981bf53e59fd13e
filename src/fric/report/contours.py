"""The contour of every scheme in one figure, for the page's controls to magnify and to switch."""

from math import floor, log10

import numpy as np
from bokeh.models import ColumnDataSource, Label, Range1d

from fric.figures.style import CYCLE, GREY
from fric.report.canvas import INK, Drawn, canvas, curve, hover
from fric.report.canvas import legend as place_legend
from fric.report.report_input import Contour, ContourTest
from fric.units import readable


def colour(n: int) -> str:
    """Return the colour of the n-th scheme."""
    return CYCLE[n % len(CYCLE)]


def dash(contour: Contour) -> str:
    """Return how the line of a scheme is broken: whole without an observer, dashed with one."""
    return "dashed" if contour.scheme.observer else "solid"


def magnification(test: ContourTest) -> float:
    """Return the round magnification (1, 2 or 5 times a power of ten) that draws the largest error at most R/2 high."""
    assert test.radius is not None
    largest = max(float(np.abs(one.error).max()) for one in test.contours)
    wanted = 0.5 * test.radius / max(largest, 1e-12)
    power = 10.0 ** floor(log10(wanted))
    return float(max(step * power for step in (1, 2, 5) if step * power <= wanted))


def contour_figure(n: int, test: ContourTest, earlier: ContourTest | None) -> Drawn:
    """Return the contours of one test: a magnified circle, or the error along a path."""
    return _polar(n, test, earlier) if test.radius is not None else _along(n, test)


def _polar(n: int, test: ContourTest, earlier: ContourTest | None) -> Drawn:
    """Return the circle with its error magnified; the page's script places the points for a magnification."""
    assert test.radius is not None
    R = test.radius * 1e3
    plot = canvas(
        "x, its error magnified [mm]", "y, its error magnified [mm]", x_range=Range1d(-1.6 * R, 1.6 * R),
        y_range=Range1d(-1.6 * R, 1.6 * R), aspect_ratio=1.25, min_height=300,
    )  # fmt: skip
    grid = ColumnDataSource({"xs": [], "ys": [], "label": [], "lx": [], "ly": []}, name="grid")
    plot.multi_line("xs", "ys", source=grid, color=GREY, line_width=0.6, line_dash="dotted")
    plot.text("lx", "ly", "label", source=grid, text_font_size="8pt", text_color=INK, text_baseline="middle")
    arc = np.linspace(0, 2 * np.pi, 361)
    plot.line(R * np.cos(arc), R * np.sin(arc), color=GREY, line_width=1.5)
    lines = []
    for which, run in (("now", test), ("earlier", earlier)):
        for k, contour in enumerate(run.contours if run else ()):
            source = ColumnDataSource(
                {
                    "angle": np.degrees(contour.place).astype(np.float32),
                    "error": (contour.error * 1e6).astype(np.float32),
                    "x": np.zeros(len(contour.place), np.float32),
                    "y": np.zeros(len(contour.place), np.float32),
                    "name": [contour.scheme.name] * len(contour.place),
                }
            )
            style = {"line_dash": dash(contour), "line_width": 1.8, "line_alpha": 1.0}
            if which == "earlier":
                style |= {"line_dash": "dotted", "line_alpha": 0.7, "visible": False}
            line = plot.line(
                "x", "y", source=source, color=colour(k), name=f"{which}:{contour.scheme.name}", **style
            )  # fmt: skip
            lines.append(line)
    hover(plot, lines, [("scheme", "@name"), ("angle", "@angle{0.0}°"), ("error", "@error{+0.00} µm")])
    arrow = "counter-clockwise" if test.direction > 0 else "clockwise"
    plot.add_layout(
        Label(x=0, y=0, text=arrow, text_align="center", text_baseline="middle", text_color=INK, text_font_size="9pt")
    )
    return Drawn(
        f"contour-{n}",
        f"Circle of {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}",
        "The error of the radius, magnified around the circle that was asked for (grey). Outwards is positive; dotted "
        "circles are labelled in µm. Dashed lines: with observer.",
        _alt(test),
        plot,
        {"kind": "circle", "radius": R, "magnification": magnification(test)},
    )


BEFORE, AFTER = 5.0, 25.0
"""What is drawn before and after a reversal [degrees]."""


def reversal_figures(n: int, test: ContourTest) -> list[Drawn]:
    """Return the radial error of every scheme over the time after a reversal, one figure for each axis that was run.

    The time is the angle from the reversal times R/F; the error less its median around it, so that spikes compare.
    """
    if test.radius is None:
        return []
    drawn = []
    for k, axis in enumerate(test.axes[:2]):
        quarter = 90.0 * k if len(test.axes) > 1 or axis != "y" else 90.0
        plot = canvas("time after the reversal [ms]", "radial error [µm]")
        lines = []
        for m, contour in enumerate(test.contours):
            off = test.direction * (np.degrees(contour.place) - quarter)
            off = (off + 180) % 360 - 180
            near = (off >= -BEFORE) & (off <= AFTER)
            order = np.argsort(off[near])
            time = np.radians(off[near][order]) * test.radius / test.feed * 1e3
            error = (contour.error[near][order] - np.median(contour.error)) * 1e6
            lines.append(
                curve(
                    plot, time.astype(np.float32), error.astype(np.float32), colour(m), line_dash=dash(contour),
                    line_width=1.8, name=f"now:{contour.scheme.name}",
                )
            )  # fmt: skip
        hover(plot, lines, [("scheme", "$name"), ("time", "@x{0.0} ms"), ("error", "@y{+0.00} µm")])
        label = test.labels[int(quarter // 90)]
        peaks = ", ".join(f"({one.scheme.name}) {readable(abs(one.glitches[int(quarter // 90)]), 'm')}"
                         for one in test.contours)  # fmt: skip
        drawn.append(
            Drawn(
                f"reversal-{n}-{axis}", f"At the reversal of axis {axis}, {label}", "",
                f"Radial error over time around the reversal at {label}; peaks: {peaks}.", plot, {"kind": "reversal"},
            )
        )  # fmt: skip
    return drawn


def _along(n: int, test: ContourTest) -> Drawn:
    """Return the contour error along a path."""
    plot = canvas("station [mm]", "contour error [µm]")
    lines = []
    for k, contour in enumerate(test.contours):
        source = ColumnDataSource({"x": contour.place * 1e3, "y": contour.error * 1e6})
        lines.append(
            plot.line(
                "x", "y", source=source, color=colour(k), line_dash=dash(contour), line_width=1.5,
                name=f"now:{contour.scheme.name}", legend_label=contour.scheme.name,
            )
        )  # fmt: skip
    hover(plot, lines, [("station", "@x mm"), ("error", "@y µm")])
    place_legend(plot, "top_right")
    title = f"Path at {readable(test.feed, 'm/s')}"
    return Drawn(f"contour-{n}", title, "Dashed lines: with observer.", _alt(test), plot, {"kind": "path"})


def _alt(test: ContourTest) -> str:
    parts = [f"({one.scheme.name}) {one.scheme.title} {readable(one.glitch, 'm')}" for one in test.contours]
    what = "radial error of a circle" if test.radius is not None else "contour error along a path"
    return f"The {what} under each scheme; largest glitch of each: {', '.join(parts)}. The table gives every number."
