"""The plant file: ``fric: plant/1``."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import Field

from fric.drive.plant import LinearPlant, Plant
from fric.errors import FricError
from fric.io.documents.base import AxisDocument, Physical, Quantity
from fric.units import Motion


class PlantPart(Physical):
    """The plant of eq. (1), ``B·e^(-s·T_d)/(s·(s + A))``."""

    dimensions: ClassVar[dict[str, str]] = {
        "A": "rate",
        "B": "acceleration per input",
        "T_d": "time",
        "K_f": "force per input",
    }

    A: Quantity = Field(description="linear damping of the drive [1/s]")
    B: Quantity | None = Field(
        None, description="acceleration per volt [m/(s^2*V)]; left out where no input was logged"
    )
    T_d: Quantity = Field(description="delay of the measured response, half a sample of hold included [s]")
    K_f: Quantity | None = Field(None, description="force constant [N/V]; left out where no force was logged")

    def linear(self, motion: Motion) -> LinearPlant:
        """Return eq. (1) in SI, without a force scale; a value that is missing or not physical raises a `FricError`."""
        values = self._with_B(motion)
        values.pop("K_f", None)
        return LinearPlant(**values)

    def _with_B(self, motion: Motion) -> dict[str, float]:
        values = self.values(motion)
        if "B" not in values:
            raise FricError(
                "the acceleration per volt B is not given",
                mend="Identify the plant again from a log with input, or with --force-constant.",
            )
        return values

    def plant(self, motion: Motion) -> Plant:
        """Return the plant in SI.

        Raises
        ------
        FricError
            When B or K_f is not given, or a value is not physical.
        """
        values = self._with_B(motion)
        if "K_f" not in values:
            raise FricError(
                "the force constant K_f is not given",
                mend="Add 'K_f: {value: 548, unit: N/V}' from the drive's data sheet, or identify it with a force log.",
            )
        return Plant(**values)


class PlantDocument(AxisDocument, PlantPart):
    """A plant file: eq. (1) of one axis."""

    type: ClassVar[str] = "plant"

    fit: dict[str, Any] = Field(default_factory=dict, description="how well the plant fits the response")
