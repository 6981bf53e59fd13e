"""The sections ``reality`` and ``second_mass`` of an axis in a machine file: flaws, each off where it is left out.

What they hold is said once, by the dataclasses of the flaws (`fric.documents.generated`).
"""

from dataclasses import Field, is_dataclass
from typing import Annotated, Any, TypeVar, get_args, get_origin

import pydantic

from fric.documents.generated import PartOf, optional
from fric.documents.quantity import Quantity
from fric.estimate import Estimate
from fric.units import Motion

F = TypeVar("F")


class FlawPart(PartOf[F]):
    """A flaw as a file gives it: its numbers as quantities, and flaws within it as parts of their own."""

    @classmethod
    def entry(cls, field: Field[Any], kind: Any, text: str | None) -> dict[str, tuple[Any, Any]]:
        """Return the key of a field, which may be left out where the flaw has a value for it."""
        within: list[Any] = [one for one in (kind, *get_args(kind)) if is_dataclass(one)]
        text = text and text.partition(" [")[0]  # a quantity says its unit
        if within and get_origin(kind) is tuple:
            return {field.name: (cls.of_type(kind), pydantic.Field(default_factory=list))}
        if within:
            return {field.name: (cls.of_type(within[0]) | None, pydantic.Field(None, description=text))}
        if get_origin(kind) is not Annotated:
            given = field.default if optional(field) else ...
            return {field.name: (kind, pydantic.Field(given, description=text))}
        asked: Any = Quantity | None if optional(field) else Quantity
        given = None if optional(field) else ...
        return {field.name: (Annotated[asked, *kind.__metadata__], pydantic.Field(given, description=text))}

    def estimates(self, motion: Motion, where: str = "") -> dict[str, Estimate]:
        """Return its numbers, once every flaw within has been looked at too; raise ValueError with the mend."""
        for name, one in self:
            for n, part in enumerate(one if isinstance(one, list) else [one]):
                if isinstance(part, FlawPart):
                    part.estimates(motion, f"{where}.{name}" + (f".{n}" if isinstance(one, list) else ""))
        return super().estimates(motion, where)

    def made(self, motion: Motion) -> F:
        """Return the flaw in SI; raise a `FricError` where it is not physical."""

        def made(one: Any) -> Any:
            return one.made(motion) if isinstance(one, FlawPart) else one

        given = {
            name: tuple(map(made, one)) if isinstance(one, list) else made(one)
            for name, one in self
            if one is not None and name not in self.dimensions
        }
        found: F = self.held(**given, **self.values(motion))
        return found
