"""The circular test: two axes, one scheme, and what remains of the circle, at one feed and radius or over a grid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Unpack

import numpy as np

from fric.arrays import Real
from fric.contour import Circularity, circularity
from fric.control.scheme import Scheme
from fric.errors import FricError
from fric.notice import Notice
from fric.reference import Reference, circle
from fric.simulate.contour_run import ContourRun, How
from fric.simulate.machine import Machine


@dataclass(frozen=True)
class Circle:
    """A circular test.

    Raises FricError: When radius, feed or revolutions are not positive.
    """

    radius: float = 0.03  # Radius [m]
    feed: float = 0.1  # Speed along the circle [m/s]
    revolutions: int = 2  # Revolutions at full feed; the last is evaluated
    direction: int = 1  # 1 counter-clockwise, -1 clockwise

    def __post_init__(self) -> None:
        for name in ("radius", "feed", "revolutions"):
            if not getattr(self, name) > 0:
                raise FricError(f"the {name} of the circle is {getattr(self, name):g}", hint="Give a positive value.")

    def references(self, sampling: float) -> tuple[Reference, Reference]:
        """Return the motion of both axes, sampled at a rate [Hz]."""
        return _references(self, sampling)


@lru_cache(maxsize=4)
def _references(test: Circle, sampling: float) -> tuple[Reference, Reference]:
    """Return the motion of both axes, which schemes and machines share."""
    return circle(test.radius, test.feed, test.revolutions, sampling, direction=test.direction)


class CircleRun(ContourRun[Circle, Circularity]):
    """What one scheme makes of a circle: radial error and glitches of the last revolution."""

    @classmethod
    def judged(
        cls, test: Circle, references: Sequence[Reference], motion: Sequence[Real]
    ) -> tuple[Circularity, tuple[Notice, ...]]:
        """Return the radial error of the last revolution."""
        return circularity(motion[0], motion[1], test.radius), ()

    @property
    def circle(self) -> Circle:
        """The circle."""
        return self.test

    @property
    def circularity(self) -> Circularity:
        """Result of the scheme."""
        return self.contour


def run_circle(machine: Machine, scheme: Scheme, test: Circle | None = None, **how: Unpack[How]) -> CircleRun:
    """Run a circle on two axes of a machine under one scheme.

    test: The circle; that of the paper, 30 mm at 100 mm/s, where it is not given.
    """
    return CircleRun.run(machine, scheme, test or Circle(), **how)


@dataclass(frozen=True)
class CircleGrid:
    """What is run on each of many circles; a circle by its number, radius by radius.

    Raises FricError: When there is no feed or no radius.
    """

    machine: Machine  # The machine
    schemes: tuple[Scheme, ...]  # The compensation schemes
    feeds: tuple[float, ...]  # feeds, radii: feeds [m/s] and radii [m] of the circles, in all combinations
    radii: tuple[float, ...]
    accuracy: float  # Largest error of a glitch by the integration [m]

    def __post_init__(self) -> None:
        if not (self.feeds and self.radii):
            raise FricError("there is no circle to run", hint="Give feeds and radii, as '5 … 200 mm/s'.")

    def __len__(self) -> int:
        return len(self.feeds) * len(self.radii)

    def circle(self, index: int) -> Circle:
        """Return a circle by its number."""
        row, column = divmod(index, len(self.feeds))
        return Circle(self.radii[row], self.feeds[column], revolutions=1)

    def not_run(self, index: int) -> Cell:
        """Return the cell of a circle that was never begun."""
        return Cell(self.circle(index), np.full(len(self.schemes), np.nan), {})

    def __call__(self, index: int) -> Cell:
        """Run all schemes on one circle; a scheme that cannot run has no glitch, but a reason."""
        circle, glitches, why = self.circle(index), np.full(len(self.schemes), np.nan), {}
        for n, scheme in enumerate(self.schemes):
            try:
                glitches[n] = run_circle(self.machine, scheme, circle, accuracy=self.accuracy).circularity.glitch
            except FricError as error:
                why[scheme.name] = error.what
        return Cell(circle, glitches, why)


@dataclass(frozen=True)
class Cell:
    """Result of schemes on one circle: glitch by scheme [m], nan with the reason where a scheme could not run."""

    circle: Circle
    glitches: Real
    failures: dict[str, str]


@dataclass(frozen=True)
class CircleMap:
    """Results of schemes on all circles.

    grid: What was run.
    cells: One a circle, in their order.
    """

    grid: CircleGrid
    cells: Sequence[Cell]

    @property
    def glitches(self) -> Real:
        """Glitch by scheme, radius and feed [m], shape (schemes, radii, feeds); nan where a scheme could not run."""
        shape = (len(self.grid.radii), len(self.grid.feeds), len(self.grid.schemes))
        return np.moveaxis(np.array([cell.glitches for cell in self.cells]).reshape(shape), 2, 0)

    def of(self, scheme: str) -> Real | None:
        """Return the glitch of a scheme by radius and feed [m]; None where it was not run."""
        names = [scheme.name for scheme in self.grid.schemes]
        return self.glitches[names.index(scheme)] if scheme in names else None

    def pairs(self) -> dict[str, tuple[Scheme, Scheme]]:
        """Return the pairs of schemes that show the gain of GMS over a static map, and of an observer over none."""
        found = {}
        for scheme in self.grid.schemes:
            for other in self.grid.schemes:
                alike = scheme.controller == other.controller
                if alike and scheme.blocks == other.blocks and (scheme.friction, other.friction) == ("gms", "static"):
                    found[f"gms over static ({scheme.name} against {other.name})"] = (scheme, other)
                if alike and scheme.friction == other.friction and scheme.observer and not other.blocks:
                    found[f"observer ({scheme.name} against {other.name})"] = (scheme, other)
        return found

    def less(self, one: Scheme, other: Scheme) -> Real:
        """Return the reduction of the glitch against another scheme, by radius and feed [m]; negative where worse."""
        names = [scheme.name for scheme in self.grid.schemes]
        return np.asarray(self.glitches[names.index(other.name)] - self.glitches[names.index(one.name)])
