"""The common part of friction results, apart from `Result`, since most results load no friction model."""

from typing import Any

from fric.documents.friction import FrictionDocument
from fric.documents.machine_files import nominal_models
from fric.friction import FrictionModel, models
from fric.results.base import Identified


class IdentifiedFriction(Identified):
    """The common part of friction results: the models that a controller can use."""

    fit: Any

    @property
    def axis(self) -> str:
        """Name of the axis."""
        return str(self.document["axis"])

    @property
    def belief(self) -> dict[str, FrictionModel]:
        """The models that a controller can feed forward, by name."""
        return nominal_models(FrictionDocument.model_validate(self.document))

    def sections(self) -> dict[str, dict[str, dict[str, Any]]]:
        """Return the parameters by section of the friction file and by name."""
        wanted = {"static", "static_negative", "at_speed", *models()}
        return {name: self.document[name] for name in self.document if name in wanted}
