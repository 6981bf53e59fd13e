"""The look of every figure: colour-blind safe, readable in print, axes with units; and the figures by name.

Each is a function in a file of this room, entered by `view`: a new figure is one new file.
"""

from __future__ import annotations

import io
import logging
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from cycler import cycler

from fric.arrays import Real
from fric.errors import FricError, clean
from fric.family import files_of
from fric.output import staged

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

logging.getLogger("matplotlib").setLevel(logging.ERROR)  # it says in 17 lines which font it takes, and where no home is

# Okabe and Ito's palette, distinguishable with every common colour vision and in grey.
BLUE, ORANGE, GREEN, VERMILION = "#0072B2", "#E69F00", "#009E73", "#D55E00"
SKY, PURPLE, BLACK, GREY = "#56B4E9", "#CC79A7", "#000000", "#7F7F7F"
CYCLE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)
DASHES: Any = ("-", "--", "-.", ":", (0, (6, 1.5, 1, 1.5, 1, 1.5)), (0, (8, 2)), (0, (2, 1)))
DRAWING = 72.0  # Points of an inch, as which SVG and PDF are drawn
Draw = TypeVar("Draw", bound="Callable[..., Figure]")


@cache
def style() -> dict[Any, Any]:
    """Return the settings of Matplotlib that every figure has."""
    from matplotlib import rc_params_from_file  # not at the start: pages have these colours without it

    sheet = rc_params_from_file(Path(__file__).with_name("fric.mplstyle"), use_default_template=False)
    return dict(sheet) | {"axes.prop_cycle": cycler(color=CYCLE)}


def thinned(x: Real, y: Real, bins: int) -> tuple[Real, Real]:
    """Return the least and the greatest value of each part of a curve, in order, and its two ends."""
    if len(x) <= 2 * bins:
        return x, y
    edges = np.linspace(0, len(x), bins + 1).astype(int)
    kept = {0, len(x) - 1}
    for start, stop in pairwise(edges):
        kept |= {start + int(np.argmin(y[start:stop])), start + int(np.argmax(y[start:stop]))}
    chosen = np.array(sorted(kept))
    return x[chosen], y[chosen]


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


def feed_of(circle: Any) -> str:
    """Return radius and feed of a circle [m], [m/s], for a title."""
    return f"{circle.radius * 1e3:g} mm at {circle.feed * 1e3:g} mm/s"


@contextmanager
def new_figure(width: float = 6.3, height: float = 4.0) -> Iterator[Figure]:
    """Give an empty figure [inch] in the style, without pyplot's global state."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.text import Text

    with mpl.rc_context(style()):
        figure = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(figure)
        yield figure
        for text in figure.findobj(Text):  # which may name what a file names; but for labels of ticks none is a formula
            text.set_text(said := clean(text.get_text()))
            text.set_parse_math(said.startswith("$\\mathdefault") or not said)


def save_figure(figure: Figure, path: Path, *, force: bool = False) -> None:
    """Write a figure whole or not at all; the name's ending determines the format."""
    path = Path(path)
    if (ending := path.suffix.lstrip(".").lower()) not in {"png", "svg", "pdf"}:
        hint = "End the name in .png, .svg or .pdf."
        raise FricError(f"'{path.suffix}' is not a figure format", where=str(path), hint=hint)
    with staged(path, force=force) as draft:
        draft.write_bytes(rendered(figure, ending))


def rendered(figure: Figure, ending: str = "svg") -> bytes:
    """Return a figure as the content of a file, the same bytes each time."""
    import matplotlib as mpl

    out = io.BytesIO()  # on a full disk the PDF backend raises an unrelated exception
    metadata = {"Date": None} if ending == "svg" else {"CreationDate": None} if ending == "pdf" else None
    with mpl.rc_context(style()), laid_out(figure, style()["savefig.dpi"] if ending == "png" else DRAWING):
        figure.savefig(out, format=ending, metadata=metadata)
    return out.getvalue()


@contextmanager
def laid_out(figure: Figure, dpi: float) -> Iterator[None]:
    """Lay a figure out once, for so many dots an inch: savefig lays it out and draws it twice."""
    layout, before = figure.get_layout_engine(), figure.dpi
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph ")  # of a letter that the font lacks
        if layout is not None:
            figure.dpi = dpi
            layout.execute(figure)
            figure.set_layout_engine(None)
        yield
    figure.dpi = before
    figure.set_layout_engine(layout)


@dataclass(frozen=True)
class FigureView:
    """One figure: its name, the type that it draws (or a sequence of), the function, whether it is drawn by default."""

    name: str
    of: str
    draw: Callable[..., Figure]
    usual: bool = False

    @property
    def summary(self) -> str:
        """The first sentence of the function's docstring."""
        return (self.draw.__doc__ or "").strip().split("\n\n", 1)[0].replace("\n", " ")


_FOUND: dict[tuple[str, str], FigureView] = {}


def view(name: str, of: str, *, usual: bool = False) -> Callable[[Draw], Draw]:
    """Enter a function as a figure of a type.

    name: Its name in ``--plot NAME=FILE``.
    of: Name of the type that it draws: a figure does not import the types that it draws.
    usual: Whether it is what ``--plot FILE`` draws of that type; one figure is.
    """

    def entered(draw: Draw) -> Draw:
        _FOUND[of, name] = FigureView(name, of, draw, usual)
        return draw

    return entered


def views(of: str | None = None) -> tuple[FigureView, ...]:
    """Return every figure, by type and name; or those of one type."""
    files_of("fric.figures")  # each enters its figures; a file that is there is all that a figure takes
    return tuple(view for _, view in sorted(_FOUND.items()) if of in {None, view.of})


def views_of(parts: Sequence[Any], *, usual: bool = False) -> dict[str, Callable[[], Figure]]:
    """Return the figures of what a result holds by name, each ready to be drawn: all, or those drawn by default."""
    found: dict[str, Callable[[], Figure]] = {}
    for part in parts:
        many = isinstance(part, Sequence) and not isinstance(part, str)
        for view in views(type(part[0] if many and part else part).__name__):
            if view.usual or not usual:
                found[view.name] = lambda shown=view, part=part: shown.draw(part)  # type: ignore[misc]
    return found
