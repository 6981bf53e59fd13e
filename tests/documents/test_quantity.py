"""Quantities in documents: their dimensions, what is read and written by them, and parts made from dataclasses."""

from dataclasses import dataclass, fields, is_dataclass
from math import inf, nan
from typing import Annotated, get_args, get_type_hints

import pytest
from pydantic import TypeAdapter

from fric.control.cascade import Cascade
from fric.documents import document_types
from fric.documents.base import FilePart, Known, Physical, Quantity
from fric.documents.controller import ControllerPart
from fric.simulate.reality.flaws import Reality, SecondMass
from fric.units import SI_UNITS


@dataclass(frozen=True)
class Step:
    """A step of the guideway.

    Parameters
    ----------
    height
        How high it is [m], from the left.
    place
        Where it is. From the middle on.
    hard
        Whether it gives way.
    """

    height: Annotated[float, "position"]
    place: Annotated[float, "position"] = 0.0
    hard: bool = True


@dataclass(frozen=True)
class Way:
    """A guideway."""

    slope: Annotated[float, "ratio"] = 0.0
    steps: tuple[Step, ...] = ()
    first: Step | None = None


def test_a_dataclass_says_what_a_file_gives_it_by() -> None:
    given = {"slope": "0.1 1", "steps": [{"height": "2 um"}, {"height": "1e-6 m", "place": "3 mm", "hard": False}]}
    part = FilePart[Way].model_validate(given)
    assert part.in_si("linear") == Way(0.1, (Step(2e-6), Step(1e-6, 3e-3, hard=False)))
    step = FilePart[Way].model_json_schema()["$defs"]["StepPart"]
    assert step["description"] == "A step of the guideway."
    assert step["required"] == ["height"]
    told = {name: one["description"] for name, one in step["properties"].items()}
    assert told == {"height": "how high it is", "place": "where it is", "hard": "whether it gives way"}
    wrong = FilePart[Way].model_validate({"steps": [{"height": "2 um"}, {"height": "2 N"}]})
    with pytest.raises(ValueError, match=r"axis\.steps\.1\.height: position cannot be in 'N'"):
        wrong.estimates("linear", "axis")


def flaws(kind: type) -> set[type]:
    """Return a dataclass of flaws, and all within it."""
    parts = {one for hint in get_type_hints(kind).values() for one in (hint, *get_args(hint)) if is_dataclass(one)}
    return {kind}.union(*map(flaws, parts))


@pytest.mark.parametrize("flaw", sorted(flaws(Reality) | {SecondMass}, key=lambda one: one.__name__))
def test_every_number_of_a_flaw_has_a_dimension(flaw: type) -> None:
    hints = get_type_hints(flaw, include_extras=True)
    numbers = [hints[one.name] for one in fields(flaw) if get_type_hints(flaw)[one.name] is float]
    assert all(one.__metadata__[0] in SI_UNITS for one in numbers)


def test_every_dimension_is_known() -> None:
    document_types()
    pending, found = [Physical], set()
    while pending:
        part = pending.pop()
        pending += part.__subclasses__()
        found |= set(getattr(part, "dimensions", {}).values())
    assert {"rate", "force", "position"} <= found <= set(SI_UNITS)


def test_what_is_written_is_read_again() -> None:
    cascade = Cascade(126.0, 83.7, 3156.0, 500.0, 4000.0)
    written = ControllerPart.of(cascade, "rotary")
    assert written["K_p"].unit == "V*s/rad"
    assert "limit" not in written  # none is infinite
    assert ControllerPart.model_validate(written).in_si("rotary") == cascade


def test_json_holds_no_number_that_is_none() -> None:
    assert TypeAdapter(list[Known]).validate_python([1.0, inf, nan, None]) == [1.0, None, None, None]


@pytest.mark.parametrize(
    ("value", "ci95"),
    [(1.0, [0.0]), (1.0, [[0.0, 2.0]]), (1.0, [0.0, 1.0, 2.0]), ([1.0, 2.0], [0.0, 2.0]), ([1.0, 2.0], [[0.0, 2.0]]),
     ([1.0], [[0.0]]), (1.0, [])],
)  # fmt: skip
def test_an_interval_that_is_not_of_its_value_makes_no_quantity(value: object, ci95: object) -> None:
    with pytest.raises(ValueError, match="ci95 does not fit the value"):
        Quantity.model_validate({"value": value, "unit": "N", "ci95": ci95})


def test_an_open_limit_is_infinite() -> None:
    one = Quantity.model_validate({"value": 1.0, "unit": "kN", "ci95": [None, 2.0]}).si("force", "linear")
    assert one.ci95 == (-inf, 2000.0)
    two = Quantity.model_validate({"value": [1.0, 2.0], "unit": "N", "ci95": [[0.5, None], [None, None]]})
    assert two.si("force", "linear").ci95 == ((0.5, inf), (-inf, inf))
