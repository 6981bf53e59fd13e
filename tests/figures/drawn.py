"""What is drawn in a figure, as numbers; and what must be."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

Real = NDArray[np.float64]
Wanted = Callable[[Real, Real], bool]
"""Says of the x and y of a curve whether it is the one that is wanted."""


@contextmanager
def undrawn() -> Iterator[None]:
    """Write and embed empty figures, for a test that looks at none: to draw them takes a third of `fric auto`."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fric.figures.style.rendered", lambda figure, ending="svg": b"")
        patch.setattr("fric.report.plots.embedded", lambda figure, key, alt: "<svg></svg>")
        yield


def near(found: Any, wanted: Any) -> bool:
    """Tell whether two arrays are the same but for a part in a million of their size, nan included."""
    found, wanted = np.asarray(found, float), np.asarray(wanted, float)
    if found.shape != wanted.shape:
        return False
    return np.allclose(found, wanted, rtol=1e-6, atol=1e-6 * np.nanmax(np.abs(wanted), initial=0.0), equal_nan=True)


def curve(x: Any, y: Any) -> Wanted:
    """Want this curve, sample by sample."""
    return lambda drawn_x, drawn_y: near(drawn_x, x) and near(drawn_y, y)


def function(f: Callable[[Real], Any], first: float | None = None, last: float | None = None) -> Wanted:
    """Want a function over whatever x is drawn, which covers a range where one is given."""

    def right(x: Real, y: Real) -> bool:
        ends = [first is None or np.isclose(x.min(), first), last is None or np.isclose(x.max(), last)]
        return len(x) >= 50 and all(ends) and near(y, f(x))

    return right


def part(x: Any, y: Any) -> Wanted:
    """Want samples that follow one another in this curve."""
    whole = np.column_stack([x, y])

    def right(drawn_x: Real, drawn_y: Real) -> bool:
        off = np.abs(whole - [drawn_x[0], drawn_y[0]]) <= 1e-9 * np.abs(whole).max(axis=0)
        starts = np.flatnonzero(off.all(axis=1))
        n = len(drawn_x)
        return any(near(drawn_x, x[s : s + n]) and near(drawn_y, y[s : s + n]) for s in starts)

    return right


@dataclass
class Panel:
    """Axes of a figure, and what must be drawn in it.

    Parameters
    ----------
    axes
        The axes.
    curves
        One for each line that is not straight and level.
    bands
        Lower and upper edge of each filled band, over whatever x is drawn.
    bars
        Lengths of horizontal bars, in the order drawn.
    several
        True where one entry of ``curves`` stands for several lines.
    """

    axes: Axes
    curves: Sequence[Wanted] = ()
    bands: Sequence[tuple[Callable[[Real], Any], Callable[[Real], Any]]] = ()
    bars: Sequence[float] = ()
    several: bool = False

    def __post_init__(self) -> None:
        self.lines = len(varied(self)) if self.several else len(self.curves)

    def check(self) -> None:
        """Raise an `AssertionError` unless all that must be drawn is, and nothing else."""
        lines = [(np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)) for line in varied(self)]
        open_ = list(self.curves)
        for x, y in lines:
            fits = [wanted for wanted in open_ if wanted(x, y)]
            assert fits, f"a line of {len(x)} points is none of those that are wanted: {x[:3]} … {y[:3]} …"
            if not self.several:
                open_.remove(fits[0])
        assert len(lines) == self.lines, f"{self.lines - len(lines)} curves are not drawn"
        filled = list(self.bands)
        for x, low, high in edges(self.axes):
            fit = next((one for one in filled if near(low, one[0](x)) and near(high, one[1](x))), None)
            assert fit is not None, "a band is none of those that are wanted"
            filled.remove(fit)
        assert not filled, f"{len(filled)} bands are not drawn"
        assert near([patch.get_width() for patch in self.axes.patches if hasattr(patch, "get_width")], self.bars)


def varied(panel: Panel) -> list[Line2D]:
    """Return the lines of a panel that are curves or points, not levels or marks across it."""
    found = []
    for line in panel.axes.get_lines():
        own = line.get_transform() == panel.axes.transData
        y = np.asarray(line.get_ydata(), float)
        if own and len(y) > 1 and np.nanmax(y) > np.nanmin(y):
            found.append(line)
    return found


def edges(axes: Axes) -> Iterator[tuple[Real, Real, Real]]:
    """Give x, lower and upper edge of each band between two curves."""
    for band in axes.collections:
        if isinstance(band, PolyCollection):
            ring = band.get_paths()[0].vertices  # lower edge, corner, upper edge backwards, corner
            n = (len(ring) - 3) // 2
            yield ring[1 : n + 1, 0], ring[1 : n + 1, 1], ring[n + 2 : 2 * n + 2, 1][::-1]


def labels(figure: Figure) -> list[str]:
    """Return the labels of all axes."""
    return [text for axes in figure.findobj(Axes) for text in (axes.get_xlabel(), axes.get_ylabel()) if text]
