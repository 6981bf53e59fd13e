"""Figures of `fric.figures` on a page: all that there are of what it holds, but for those that it draws itself."""

from dataclasses import dataclass
from typing import Any

from fric.figures.style import rendered
from fric.figures.views import views

ZOOMED = frozenset({"contour", "reversal", "diagnosis"})
"""Names of the figures that a page draws in a way of its own."""


@dataclass(frozen=True)
class Picture:
    """A figure as SVG, and what it shows."""

    caption: str
    svg: bytes


def pictures(part: Any) -> list[Picture]:
    """Return the figures of one thing, or of several of one type; a new one is drawn without another edit."""
    if not part:
        return []
    of = type(part[0] if isinstance(part, list | tuple) else part).__name__
    return [Picture(one.summary, rendered(one.draw(part))) for one in views(of, ZOOMED)]
