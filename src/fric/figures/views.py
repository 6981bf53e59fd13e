"""The figures by name: each is a function in a file of this room, entered by `view`; a new figure is one new file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any, TypeVar

import fric.figures
from fric.errors import FricError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Draw = TypeVar("Draw", bound="Callable[..., Figure]")


@dataclass(frozen=True)
class View:
    """One figure: its name, the type that it draws (or a sequence of), the function, whether it is drawn by default."""

    name: str
    of: str
    draw: Callable[..., Figure]
    usual: bool = False

    @property
    def summary(self) -> str:
        """The first sentence of the function's docstring."""
        return (self.draw.__doc__ or "").strip().split("\n\n", 1)[0].replace("\n", " ")


_FOUND: dict[tuple[str, str], View] = {}


def view(name: str, of: str, *, usual: bool = False) -> Callable[[Draw], Draw]:
    """Enter a function as a figure of a type.

    name: Its name in ``--plot NAME=FILE``.
    of: Name of the type that it draws: a figure does not import the types that it draws.
    usual: Whether it is what ``--plot FILE`` draws of that type; one figure is.
    """

    def entered(draw: Draw) -> Draw:
        _FOUND[of, name] = View(name, of, draw, usual)
        return draw

    return entered


@cache
def _imported() -> None:
    """Import each file of this room, which enters its figures; a file that is there is all that a figure takes."""
    for module in iter_modules(fric.figures.__path__):
        import_module(f"fric.figures.{module.name}")


def views(of: str | None = None) -> tuple[View, ...]:
    """Return every figure, by type and name; or those of one type."""
    _imported()
    return tuple(view for _, view in sorted(_FOUND.items()) if of in {None, view.of})


def views_of(parts: Sequence[Any], *, usual: bool = False) -> dict[str, Callable[[], Figure]]:
    """Return the figures of what a result holds by name, each ready to be drawn: all, or those drawn by default."""
    found: dict[str, Callable[[], Figure]] = {}
    for part in parts:
        many = isinstance(part, Sequence) and not isinstance(part, str)
        for view in views(type(part[0] if many and part else part).__name__):
            if view.usual or not usual:
                found[view.name] = lambda one=view, part=part: one.draw(part)  # type: ignore[misc]
    return found


def figure_named(name: str, parts: Sequence[Any]) -> Figure:
    """Draw the figure of that name.

    name: As in `view`.
    parts: What a result holds: identified models, runs, …; the first that has such a figure is drawn.
    Raises FricError: When none has a figure of that name.
    """
    found = views_of(parts)
    if name not in found:
        raise FricError(
            f"there is no figure '{name}' of this result", hint=f"Take one of {', '.join(found)}." if found else ""
        )
    return found[name]()
