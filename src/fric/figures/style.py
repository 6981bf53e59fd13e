"""The look of every figure: colour-blind safe, readable in print, axes with units."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from cycler import cycler

from fric.arrays import Real
from fric.errors import FricError
from fric.output import staged

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's palette, distinguishable with every common colour vision and in grey.
BLUE, ORANGE, GREEN, VERMILION = "#0072B2", "#E69F00", "#009E73", "#D55E00"
SKY, PURPLE, BLACK, GREY = "#56B4E9", "#CC79A7", "#000000", "#7F7F7F"
CYCLE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)
DASHES: Any = ("-", "--", "-.", ":", (0, (6, 1.5, 1, 1.5, 1, 1.5)), (0, (8, 2)), (0, (2, 1)))

STYLE: Any = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.labelsize": 9,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E3E3E3",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "lines.linewidth": 1.2,
    "axes.prop_cycle": cycler(color=CYCLE),
    "savefig.dpi": 160,
    "svg.hashsalt": "fric",
}


@dataclass(frozen=True, eq=False)
class Band:
    """A curve with its 95 % band: shape (n,) each."""

    x: Real
    y: Real
    low: Real
    high: Real

    def scaled(self, x: float, y: float) -> Band:
        """Return the curve in other units."""
        return Band(self.x * x, self.y * y, self.low * y, self.high * y)


def shade(axes: Axes, band: Band, colour: str, *, line: str = "-", label: str | None = None, **given: Any) -> None:
    """Draw a curve, and its band where it has any width."""
    axes.plot(band.x, band.y, line, color=colour, label=label, **given)
    if np.any(band.high > band.low):
        axes.fill_between(band.x, band.low, band.high, color=colour, alpha=0.2, lw=0)


def look(n: int) -> dict[str, Any]:
    """Return the colour and the dashes of the n-th of curves that may coincide.

    A later curve is drawn above an earlier curve, with gaps that show it.
    """
    return {"color": CYCLE[n % len(CYCLE)], "linestyle": DASHES[n % len(DASHES)]}


@contextmanager
def new_figure(width: float = 6.3, height: float = 4.0) -> Iterator[Figure]:
    """Give an empty figure [inch] in the style, without pyplot's global state."""
    import matplotlib as mpl  # not at the start: pages have these colours without it
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(figure)
        yield figure


def save_figure(figure: Figure, path: Path, *, force: bool = False) -> None:
    """Write a figure whole or not at all; the name's ending determines the format.

    Raises FricError: When the ending is none that Matplotlib writes.
    """
    path = Path(path)
    ending = path.suffix.lstrip(".").lower()
    if ending not in {"png", "svg", "pdf"}:
        raise FricError(
            f"'{path.suffix}' is no figure format", where=str(path), hint="End the name in .png, .svg or .pdf."
        )
    with staged(path, force=force) as draft:
        draft.write_bytes(rendered(figure, ending))


def rendered(figure: Figure, ending: str = "svg") -> bytes:
    """Return a figure as the content of a file, the same bytes each time."""
    import matplotlib as mpl

    out = io.BytesIO()  # on a full disk the PDF backend raises an unrelated exception
    with mpl.rc_context(STYLE):
        metadata = {"Date": None} if ending == "svg" else {"CreationDate": None} if ending == "pdf" else None
        layout, dpi = figure.get_layout_engine(), figure.dpi
        if layout is not None and ending == "png":  # to lay out, savefig draws all of it once more
            figure.dpi = STYLE["savefig.dpi"]
            layout.execute(figure)
            figure.set_layout_engine(None)
        figure.savefig(out, format=ending, metadata=metadata)
        figure.dpi = dpi
        figure.set_layout_engine(layout)
    return out.getvalue()
