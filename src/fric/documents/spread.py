"""The spread file: ``fric: spread/1``."""

from pathlib import Path
from typing import Self

from pydantic import Field, model_validator

from fric.documents.base import Document
from fric.documents.quantity import Part, Quantity, refused
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.simulate.spread import Distribution, Spread, check_spreads
from fric.verb import verb


class SpreadPart(Part):
    """The factor by which a parameter of a drawn machine differs from that of the nominal machine."""

    distribution: Distribution = Field("uniform", description="of the factor, or of its logarithm")
    factor: Quantity = Field(
        description="limits [low, high] of the factor; its 95 % interval where the distribution is normal or log-normal"
    )

    def spread(self) -> Spread:
        """Return the spread."""
        limits = self.factor.si("ratio", "linear")
        if not isinstance(limits.value, tuple) or len(limits.value) != 2:
            raise FricError("a spread has a lower and an upper factor", hint="Give them as value: [0.7, 1.3].")
        return Spread(*limits.value, self.distribution, limits.source)


class SpreadDocument(Document, type="spread"):
    """A spread file: which parameters of the true machine are drawn around the nominal values, and how widely."""

    spreads: dict[str, SpreadPart] = Field(
        description="by level (every friction force), stiffness (every stiffness), load, M, or a parameter's name"
    )

    @model_validator(mode="after")
    def _names_and_factors_fit(self) -> Self:
        for name, part in self.spreads.items():
            with refused(f"spreads.{name}"):
                check_spreads({name: part.spread()})
        return self

    def read(self) -> dict[str, Spread]:
        """Return the spreads by name."""
        return {name: part.spread() for name, part in self.spreads.items()}


@verb
def read_spreads(path: Path | str) -> dict[str, Spread]:
    """Read spreads by name from a spread file."""
    return read_document(path, SpreadDocument).read()
