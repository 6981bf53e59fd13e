"""What is run: a move of one axis along a motion, or circles of two; and what a dialect makes of it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

from fric.arrays import Real
from fric.planning.waypoints import Waypoints, waypoints
from fric.reference import Reference
from fric.units import Motion


@dataclass(frozen=True, eq=False)
class Move:
    """One record: an axis runs along a motion around the middle of its travel, where the work offset is zero.

    Parameters
    ----------
    number, name
        Number in the plan, from 1, and name of the record.
    axis, motion
        Name of the axis, and whether it is linear or rotary.
    reference
        The motion.
    log
        The part that is logged [s].
    excitation
        Voltage that is added to the control voltage [V], shape (n,); None where there is none.
    """

    number: int
    name: str
    axis: str
    motion: Motion
    reference: Reference
    log: tuple[float, float]
    excitation: Real | None = None

    @cached_property
    def points(self) -> Waypoints:
        """The motion as few points."""
        return waypoints(self.reference)


@dataclass(frozen=True)
class Arc:
    """Whole circles of two axes around the middle of their travel, begun and ended 45° before the first reversal.

    Parameters
    ----------
    number, name
        As of a `Move`.
    axes
        Names of both axes.
    radius, feed
        Radius [m] and speed [m/s].
    revolutions
        Circles each way: the first begins at rest.
    """

    number: int
    name: str
    axes: tuple[str, str]
    radius: float
    feed: float
    revolutions: int


@dataclass(frozen=True)
class Dialect:
    """A language that controllers take motions in.

    Parameters
    ----------
    name, doc
        Its name, and one line on what it is.
    move
        Returns the files of a move by name.
    arc
        Returns the files of circles by name; none where it has no circles.
    """

    name: str
    doc: str
    move: Callable[[Move], Mapping[str, str]]
    arc: Callable[[Arc], Mapping[str, str]] = lambda _: {}


def shown_scale(motion: Motion) -> tuple[float, str]:
    """Return what a position in SI is multiplied by for people and machine tools, and the unit: mm, or degrees."""
    return (1e3, "mm") if motion == "linear" else (57.29577951308232, "deg")
