"""The circular test: two axes, one scheme, and what remains of the circle."""

from dataclasses import dataclass
from functools import lru_cache

from fric.contour import Circularity, circularity
from fric.control.scheme import Scheme
from fric.errors import FricError
from fric.reference import Reference, circle
from fric.simulate.chance import PLACES
from fric.simulate.contour_run import ContourRun, at_places, follow, run_warnings
from fric.simulate.machine import Machine


@dataclass(frozen=True)
class Circle:
    """A circular test.

    Raises
    ------
    FricError
        When radius, feed or revolutions are not positive.
    """

    radius: float = 0.03  # Radius [m]
    feed: float = 0.1  # Speed along the circle [m/s]
    revolutions: int = 2  # Revolutions at full feed; the last one is looked at
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

    @property
    def circle(self) -> Circle:
        """The circle."""
        return self.test

    @property
    def circularity(self) -> Circularity:
        """What the scheme leaves of it."""
        return self.contour


def run_circle(
    machine: Machine,
    scheme: Scheme,
    test: Circle | None = None,
    *,
    only: str | None = None,
    halvings: int = 0,
    accuracy: float = 0.0,
    places: int = PLACES,
) -> CircleRun:
    """Run a circle on two axes of a machine under one scheme.

    test: The circle; that of the paper, 30 mm at 100 mm/s, where it is not given.
    machine, scheme, only, halvings, accuracy: As in `follow`.
    places: As in `at_places`.
    Raises FricError: As `follow`.
    """
    circle = test or Circle()

    def once(subject: Machine, accuracy: float) -> CircleRun:
        _, traces, (x, y) = follow(subject, scheme, circle, only=only, halvings=halvings, accuracy=accuracy)
        return CircleRun(scheme, circle, traces, circularity(x, y, circle.radius), run_warnings(scheme, traces))

    return at_places(machine, circle.feed, once, accuracy=accuracy, places=places, only=only)
