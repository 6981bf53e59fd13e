"""The controller file: ``fric: controller/1``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import Field

from fric.control.cascade import Cascade
from fric.documents.base import AxisDocument
from fric.documents.generated import FilePart
from fric.documents.quantity import Part, Quantity
from fric.notice import Notice
from fric.units import Motion

if TYPE_CHECKING:
    from fric.design.cascade import CascadeDesign


class ControllerPart(FilePart[Cascade]):
    """The cascade of one axis: position P, velocity PI, velocity by first difference and low-pass."""


class MarginsPart(Part):
    """Margins of one loop; what is infinite is left out."""

    phase_margin: Quantity | None = None
    gain_margin: Quantity | None = None
    gain_reduction: Quantity | None = Field(None, description="by how much the gain may fall")
    peak_sensitivity: Quantity | None = None
    crossover: Quantity | None = None
    phase_crossover: Quantity | None = None
    peak_frequency: Quantity | None = Field(None, description="where the sensitivity peaks")
    bandwidth: Quantity | None = None


class ControllerDocument(AxisDocument, ControllerPart):
    """A controller file: the cascade of one axis, and the margins it was designed for."""

    type: ClassVar[str] = "controller"

    margins: dict[str, MarginsPart] = Field(
        default_factory=dict, description="margins of velocity loop, position loop, plant input"
    )


def controller_tree(design: CascadeDesign, axis: str, motion: Motion, notices: Iterable[Notice] = ()) -> dict[str, Any]:
    """Return a cascade with its margins as a controller document."""
    content: dict[str, Any] = {"axis": axis, "motion": motion, **ControllerPart.of(design.cascade, motion)}
    content["margins"] = {name: loop.margins.as_dict() for name, loop in design.loops().items()}
    return ControllerDocument.made(content, notices=notices).tree()
