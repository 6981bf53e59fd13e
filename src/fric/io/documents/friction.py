"""The friction file: ``fric: friction/1``."""

from __future__ import annotations

from typing import Any, ClassVar, Self

from pydantic import ConfigDict, Field, model_validator

from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction import FrictionModel, models
from fric.io.documents.base import Document, Quantity, quantities
from fric.units import Motion


class FrictionDocument(Document):
    """A friction file: the static map, and any other model under its own name."""

    model_config = ConfigDict(extra="allow", frozen=True)
    type: ClassVar[str] = "friction"

    axis: str
    motion: Motion = "linear"
    static: dict[str, Quantity] | None = Field(None, description="F_c, F_s, v_s, delta, sigma, offset of eq. (2)")
    static_negative: dict[str, Quantity] | None = Field(None, description="the negative direction's own values")
    at_speed: dict[str, Quantity] | None = Field(
        None, description="velocity and force where one speed alone was logged"
    )
    fit: dict[str, Any] = Field(default_factory=dict, description="how well the static map fits")

    @model_validator(mode="after")
    def _models_are_known(self) -> Self:
        for name in self.model_extra or {}:
            if name not in models() and name.removesuffix("_fit") not in models():
                raise ValueError(f"'{name}' is not a friction model\nKnown are {', '.join(models())}.")
        self.estimates("static") if self.static else None
        return self

    def estimates(self, section: str) -> dict[str, Estimate]:
        """Return the parameters of one section (``static``, ``gms``, …) in SI."""
        name = section.removesuffix("_negative")
        given = getattr(self, section, None) or (self.model_extra or {}).get(section)
        if not given:
            raise FricError(f"there is no '{section}' in the friction of axis {self.axis}")
        dimensions = {p.name: p.dimension for p in models()[name].parameters}
        if name == "static":
            dimensions["offset"] = "force"
        raw = {key: value.model_dump() if isinstance(value, Quantity) else value for key, value in given.items()}
        return quantities(raw, dimensions, self.motion, section)

    def fit_of(self, model: str) -> dict[str, Any]:
        """Return how well a model fitted, as its identification told it; empty where it was not identified."""
        return self.fit if model == "static" else dict((self.model_extra or {}).get(f"{model}_fit", {}))

    def sections(self) -> list[str]:
        """Return the names of the sections that hold parameters: the static map's, and those of other models."""
        given = {key for key in ("static", "static_negative") if getattr(self, key)}
        return sorted(given | set(self.model_extra or {}) & set(models()))

    def friction(self, name: str) -> FrictionModel:
        """Return one friction model of this file (``static``, ``gms``, …) with the parameters given here."""
        sections = {key: self.estimates(key) for key in self.sections()}
        return models()[name].from_sections(sections)
