"""The controller file: ``fric: controller/1``."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import Field

from fric.drive.cascade import Cascade
from fric.io.documents.base import AxisDocument, Physical, Quantity
from fric.units import Motion


class ControllerPart(Physical):
    """The cascade of one axis: position P, velocity PI, velocity by first difference and low-pass."""

    dimensions: ClassVar[dict[str, str]] = {
        "K_v": "rate",
        "K_p": "velocity gain",
        "K_i": "position gain",
        "velocity_filter": "frequency",
        "sampling": "frequency",
        "limit": "input",
    }

    K_v: Quantity = Field(description="position gain [1/s]")
    K_p: Quantity = Field(description="proportional velocity gain [V*s/m]")
    K_i: Quantity = Field(description="integral velocity gain [V/m]")
    velocity_filter: Quantity = Field(description="corner of the low-pass on the velocity [Hz]")
    sampling: Quantity = Field(description="sampling of the controller [Hz]")
    limit: Quantity | None = Field(None, description="saturation of the control voltage [V]; none where left out")

    def cascade(self, motion: Motion) -> Cascade:
        """Return the cascade in SI; a value that is not physical raises a `FricError`."""
        return Cascade(**self.values(motion))


class ControllerDocument(AxisDocument, ControllerPart):
    """A controller file: the cascade of one axis, and the margins it was designed for."""

    type: ClassVar[str] = "controller"

    margins: dict[str, Any] = Field(
        default_factory=dict, description="margins of velocity loop, position loop, plant input"
    )
