"""What is run: a move of one axis along a motion, or circles of two; and what a dialect makes of it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import sqrt

from fric.arrays import Real
from fric.planning.waypoints import Waypoints, waypoints
from fric.reference import Reference
from fric.units import Motion, rotates


@dataclass(frozen=True, eq=False)
class Move:
    """One record: an axis runs along a motion around the middle of its travel, where the work offset is zero."""

    # number, name: number in the plan, from 1, and name of the record
    number: int
    name: str
    # axis, motion: name of the axis, and whether it is linear or rotary
    axis: str
    motion: Motion
    reference: Reference  # The motion
    log: tuple[float, float]  # The part that is logged [s]
    approach: float  # Speed with which its begin is approached, from anywhere in the travel [m/s, rad/s]
    # Voltage that is added to the control voltage [V], shape (n,); None where there is none
    excitation: Real | None = None

    @cached_property
    def points(self) -> Waypoints:
        """The motion as few points."""
        return waypoints(self.reference)

    @property
    def ends(self) -> tuple[float, float]:
        """Where it begins and ends, from the middle of the travel [m, rad]."""
        return float(self.points.position[0]), float(self.points.position[-1])


@dataclass(frozen=True)
class Arc:
    """Whole circles of two axes around the middle of their travel, begun and ended 45° before the first reversal."""

    # number, name: as of a `Move`
    number: int
    name: str
    axes: tuple[str, str]  # Names of both axes
    # radius, feed: radius [m] and speed [m/s]
    radius: float
    feed: float
    revolutions: int  # Circles each way: the first begins at rest
    approach: float  # As of a `Move` [m/s]

    @property
    def ends(self) -> tuple[float, float]:
        """Where the axes begin and end [m]; both are as far from the middle."""
        return self.radius / sqrt(2.0), self.radius / sqrt(2.0)


@dataclass(frozen=True)
class Dialect:
    """A language that controllers take motions in."""

    # name, doc: its name, and one line on what it is
    name: str
    doc: str
    move: Callable[[Move], Mapping[str, str]]  # Returns the files of a move by name
    # Returns the files of circles by name; none where it has no circles
    arc: Callable[[Arc], Mapping[str, str]] = lambda _: {}


def shown_scale(motion: Motion) -> tuple[float, str]:
    """Return what a position in SI is multiplied by for people and machine tools, and the unit: mm, or degrees."""
    return (1e3, "mm") if not rotates(motion) else (57.29577951308232, "deg")
