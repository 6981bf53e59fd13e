"""The sections ``reality`` and ``second_mass`` of an axis in a machine file: flaws, each off where it is left out.

What they hold is said once, by the dataclasses of the flaws: their fields, the dimensions beside these, and in the
docstrings what each is.
"""

import re
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import cache
from inspect import getdoc
from typing import Annotated, Any, ClassVar, Generic, TypeVar, get_args, get_origin, get_type_hints

import pydantic

from fric.documents.quantity import Physical, Quantity
from fric.estimate import Estimate
from fric.units import Motion

F = TypeVar("F")


class FlawPart(Physical, Generic[F]):
    """A flaw as a file gives it: its numbers as quantities, and flaws within it as parts of their own."""

    flaw: ClassVar[type[Any]]

    def __class_getitem__(cls, flaw: Any) -> Any:
        """Return the part that gives a flaw."""
        return _part(flaw) if hasattr(flaw, "__dataclass_fields__") else super().__class_getitem__(flaw)

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
        found: F = self.flaw(**given, **self.values(motion))
        return found


@cache
def _part(flaw: type[Any]) -> type[FlawPart[Any]]:
    summary, described = _described(flaw)
    types = get_type_hints(flaw, include_extras=True)
    given: dict[str, Any] = {one.name: _field(one, types[one.name], described.get(one.name)) for one in fields(flaw)}
    name = f"{flaw.__name__}Part"
    made = pydantic.create_model(name, __base__=FlawPart, __doc__=summary, __module__=__name__, **given)
    made.flaw = flaw
    return made


def _field(field: Field[Any], kind: Any, text: str | None) -> tuple[Any, Any]:
    """Return type and default of a field in files."""
    needed = field.default is MISSING and field.default_factory is MISSING
    within: list[Any] = [one for one in (kind, *get_args(kind)) if is_dataclass(one)]
    if within:
        part: Any = _part(within[0])
        if get_origin(kind) is tuple:
            return list[part], pydantic.Field(default_factory=list)
        return part | None, pydantic.Field(None, description=text)
    if get_origin(kind) is not Annotated:
        return kind, pydantic.Field(... if needed else field.default, description=text)
    asked: Any = Quantity if needed else Quantity | None
    return Annotated[asked, *kind.__metadata__], pydantic.Field(... if needed else None, description=text)


def _described(flaw: type[Any]) -> tuple[str, dict[str, str]]:
    """Return what a docstring says of a class, its first paragraph, and of each field: a sentence, without the unit."""
    text = getdoc(flaw) or ""
    found = {}
    for name, body in re.findall(r"^(\w+)\n((?:    .*\n?)+)", text.partition("Parameters\n-")[2], re.MULTILINE):
        sentence = re.split(r" \[|\.(?: |$)", " ".join(body.split()))[0]
        found[name] = sentence[0].lower() + sentence[1:]
    return text.partition("\n\n")[0], found
