"""The gains of a controller, as a recorded circle shows them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from fric.circles.gains import FoundController, controller_of
from fric.circles.measured import MeasuredCircle
from fric.control.cascade import Cascade
from fric.documents.controller import ControllerDocument, ControllerPart
from fric.errors import FricError
from fric.results.base import Identified
from fric.results.given_models import circles_of
from fric.results.kinds import AxisName, CircleLike, SchemeName
from fric.results.text import Piece, parameters
from fric.verb import verb


@dataclass(frozen=True, eq=False, repr=False)
class GainsResult(Identified):
    """The cascade that a recorded voltage shows.

    Parameters
    ----------
    found
        The controller, and how sure its gains are.
    axis
        Name of the axis.
    test
        The circle.
    """

    found: FoundController
    axis: str
    test: MeasuredCircle

    @property
    def belief(self) -> Cascade:
        """The cascade."""
        return self.found.cascade

    @cached_property
    def document(self) -> dict[str, Any]:
        """The controller file."""
        content: dict[str, Any] = {"axis": self.axis, "motion": "linear"}
        content |= {**ControllerPart.of(self.found.cascade, "linear"), **self.found.estimates}
        return ControllerDocument.made(content).tree()

    def sections(self) -> dict[str, dict[str, dict[str, Any]]]:
        """Return the gains as they stand in the file."""
        return {"controller": {name: self.document[name] for name in self.found.estimates}}

    def report(self) -> list[Piece]:
        """Return the gains, and how much of the voltage they explain."""
        where = f"{self.test.where}: {self.found.explained:.2%} of the voltage explained"
        return [parameters(self.sections()["controller"]), where]


@verb
def identify_controller(circle: CircleLike, *, axis: AxisName = "x", scheme: SchemeName | None = None) -> GainsResult:
    """Identify the gains of an axis' controller from a circle with reference, position and voltage.

    Parameters
    ----------
    circle
        A circle test without compensation of friction.
    axis
        Name of the axis.
    scheme
        Scheme of a run file.

    Raises
    ------
    FricError
        When a channel is missing, or no cascade gives the recorded voltage.
    """
    tests = circles_of([circle], scheme)
    if not tests:
        raise FricError("there is no circle test", hint="Record one with reference, position and voltage.")
    return GainsResult(controller_of(tests[0], axis), axis, tests[0])
