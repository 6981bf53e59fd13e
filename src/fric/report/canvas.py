"""What all figures of a report share: Bokeh's figure in the house's style, and what stands under it in words."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from bokeh.models import BasicTickFormatter, ColumnDataSource, HoverTool, LogAxis
from bokeh.plotting import figure
from numpy.typing import ArrayLike

from fric.figures.style import BLACK, BLUE, GREY
from fric.units import Motion, prefixed, si_unit

INK, PALE = "#333333", "#dddddd"

Scale = tuple[float, str]
"""Factor from SI, and the unit that is read."""


@dataclass(frozen=True)
class Drawn:
    """A figure of the page.

    Parameters
    ----------
    id
        Its id in the page.
    title, caption
        What stands above and below it.
    alt
        What it shows, for those who do not see it.
    model
        The Bokeh figure.
    settings
        What its controls need to know.
    """

    id: str
    title: str
    caption: str
    alt: str
    model: Any
    settings: Mapping[str, Any] = field(default_factory=dict)


def canvas(x: str, y: str, **given: Any) -> Any:
    """Return an empty figure; pan, zoom and reset, and no address of anything elsewhere."""
    plot: Any = figure(
        x_axis_label=x,
        y_axis_label=y,
        **{"height": 330, "sizing_mode": "stretch_width", "tools": "pan,box_zoom,wheel_zoom,reset,save"} | given,
    )
    plot.toolbar.logo = None
    plot.background_fill_color = plot.border_fill_color = "#ffffff"  # without it, what was painted before shows through
    plot.outline_line_color = None
    for axis in plot.axis:
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_color = axis.major_label_text_color = INK
        axis.axis_line_color = axis.major_tick_line_color = axis.minor_tick_line_color = GREY
    plot.grid.grid_line_color = PALE
    for log_axis in plot.axis:
        if isinstance(log_axis, LogAxis):  # 0.01 and 1000, not powers with raised exponents
            log_axis.formatter = BasicTickFormatter(use_scientific=False)
    return plot


def legend(plot: Any, place: str = "bottom_right") -> None:
    """Put the legend where it is, plainly; a click on an entry hides what it stands for."""
    plot.legend.location = place
    plot.legend.click_policy = "hide"
    plot.legend.label_text_color = INK
    plot.legend.label_text_font_size = "9pt"
    plot.legend.background_fill_color = "#ffffff"
    plot.legend.background_fill_alpha = 0.7
    plot.legend.border_line_color = None
    plot.legend.spacing, plot.legend.padding = 0, 4


def hover(plot: Any, renderers: Sequence[Any], text: Sequence[tuple[str, str]]) -> None:
    """Tell the numbers under the pointer."""
    plot.add_tools(HoverTool(renderers=list(renderers), tooltips=list(text)))


def curve(plot: Any, x: ArrayLike, y: ArrayLike, color: str = BLUE, label: str = "", **given: Any) -> Any:
    """Draw a line."""
    entry = {"legend_label": label} if label else {}
    return plot.line(
        x="x", y="y", source=ColumnDataSource({"x": x, "y": y}), color=color, **{"line_width": 2} | entry | given
    )


def band(plot: Any, x: ArrayLike, low: ArrayLike, high: ArrayLike, color: str = BLUE, label: str = "") -> None:
    """Shade what lies between two curves."""
    entry = {"legend_label": label} if label else {}
    plot.varea(x=x, y1=low, y2=high, fill_color=color, fill_alpha=0.18, **entry)


def measured(
    plot: Any, x: ArrayLike, y: ArrayLike, low: ArrayLike, high: ArrayLike, color: str = BLACK, label: str = "measured"
) -> Any:
    """Draw points with their intervals."""
    source = ColumnDataSource({"x": x, "y": y, "low": low, "high": high})
    plot.segment(x0="x", x1="x", y0="low", y1="high", source=source, color=color, legend_label=label)
    return plot.scatter("x", "y", source=source, size=6, color=color, fill_color="#ffffff", legend_label=label)


def scale(value: float, dimension: str, motion: Motion) -> Scale:
    """Return the factor and the unit in which people read values of this size."""
    return prefixed(value, si_unit(dimension, motion))
