"""What verbs take: records or the files that hold them, models or their files or results, quantities with units."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from fric.control.cascade import Cascade
from fric.documents.controller import ControllerDocument
from fric.documents.friction import FrictionDocument
from fric.documents.plant import PlantDocument
from fric.documents.yaml import read_document
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.friction.stribeck import StaticMap
from fric.log import ForceVelocity, FrequencyResponse, Log, Record
from fric.plausibility.bounds import settled
from fric.plausibility.findings import of_plant
from fric.results.base import Result
from fric.units import Motion, parse, si_unit

if TYPE_CHECKING:
    from fric.documents.plan import PlanDocument  # it loads what plans and simulates
    from fric.identify.circle.measured import MeasuredCircle

D = TypeVar("D", FrictionDocument, PlantDocument, ControllerDocument, "PlanDocument")

CIRCLES = "circle tests, or their files"
"""What verbs take that are of measured circles."""


class Advance(Protocol):
    """Is told how far a verb is, for whoever waits."""

    def __call__(self, steps: int = 1, *, total: int | None = None) -> None:
        """Take that so many steps are done, and how many there are where that is known now."""


def silent(steps: int = 1, *, total: int | None = None) -> None:
    """Tell nobody."""


def records_of(verb: str, given: Iterable[Any], *, one_axis: bool = True) -> list[Record]:
    """Return the records (of one axis) that are given: records, log files, or lists of them.

    Raises
    ------
    FricError
        When something else is given, a file is no log file, or the records are of different axes.
    """
    found = list(_flat(verb, given))
    if not found:
        raise FricError(f"{verb} was given no record", hint="Give log files, or what fric.read returns.")
    axes = {(record.axis, record.motion) for record in found}
    if one_axis and len(axes) > 1:
        text = ", ".join(f"{axis} ({motion})" for axis, motion in sorted(axes))
        raise FricError(f"the logs are of different axes: {text}", hint="Identify one axis at a time.")
    return found


def logs_of(verb: str, given: Iterable[Any]) -> list[Log]:
    """Return the records in time of one axis that are given, as `records_of`."""
    records = records_of(verb, given)
    logs = [record for record in records if isinstance(record, Log)]
    if not logs:
        raise FricError("there is no record in time", where=records[0].where)
    return logs


def _flat(verb: str, given: Iterable[Any]) -> Iterable[Record]:
    for one in given:
        if isinstance(one, Log | FrequencyResponse | ForceVelocity):
            yield one
        elif isinstance(one, str | Path):
            from fric.io.hdf5 import read_records  # with HDF5, which simulations need not

            yield from read_records(Path(one))
        elif isinstance(one, Iterable) and not isinstance(one, bytes | dict):
            yield from _flat(verb, one)
        else:
            raise refused(verb, "log files, or records that fric.read returns", one)


def refused(verb: str, wanted: str, given: Any) -> FricError:
    """Return the error of an argument of a wrong type, in a sentence."""
    kind = type(given).__name__
    what = "None" if given is None else f"{'an' if kind[0].lower() in 'aeiou' else 'a'} {kind}"
    return FricError(f"{verb} takes {wanted}, and was given {what}")


def path_of(verb: str, wanted: str, given: Any) -> Path:
    """Return what is given as a path, or raise the error of a wrong type."""
    if not isinstance(given, str | Path):
        raise refused(verb, wanted, given)
    return Path(given)


def document_of(verb: str, kind: type[D], given: Any, of: tuple[str, Motion] | None = None, to: str = "log") -> D:
    """Return the document that is given as itself, as its file or as a result.

    Parameters
    ----------
    verb
        What it is for, in the words of an error.
    kind
        The type of document.
    given
        A document, the path of its file, or a result whose document it is.
    of
        Name and motion of the axis that it must be of.
    to
        What that axis is of, in the words of an error.

    Raises
    ------
    FricError
        When something else is given, or the document is of another axis or motion.
    """
    wanted = f"a {kind.type} file, or a result that holds one"
    if isinstance(given, Result):
        if given.document.get("fric") != kind.type_name():
            raise refused(verb, wanted, given)
        found = kind.model_validate(given.document)
    else:
        found = given if isinstance(given, kind) else read_document(path_of(verb, wanted, given), kind)
    if of is not None and (found.axis, found.motion) != of:
        raise FricError(
            f"is the {kind.type} of the {found.motion} axis {found.axis}, and the {to} is of the {of[1]} axis {of[0]}",
            where=where_of(given),
            hint=f"Give the {kind.type} of this axis.",
        )
    return found


def circles_of(verb: str, given: Iterable[Any], scheme: str | None = None) -> list[MeasuredCircle]:
    """Return measured circles that are given as such, as files or in lists; of a run file those of a scheme."""
    from fric.identify.circle.measured import MeasuredCircle

    ones = [one for part in given for one in (part if isinstance(part, list | tuple) else [part])]
    tests = [one for one in ones if isinstance(one, MeasuredCircle)]
    files = [path_of(verb, CIRCLES, one) for one in ones if not isinstance(one, MeasuredCircle)]
    if files:
        from fric.io.circle import choose_circles  # with HDF5, which a table needs not

        tests += choose_circles(files, scheme)
    return tests


def where_of(given: Any) -> str:
    """Return the file that is given, for an error; nothing where none is."""
    return str(given) if isinstance(given, str | Path) else ""


def plant_of(verb: str, given: Any, axis: str, motion: Motion) -> Plant | None:
    """Return the plant that is given as itself, as its file or as a result; None where none is."""
    if given is None or isinstance(given, Plant):
        return given
    document = document_of(verb, PlantDocument, given, (axis, motion))
    try:
        plant = document.plant(motion)
        settled(of_plant(plant, motion))
        return plant
    except FricError as error:
        raise error.at(where_of(given)) if where_of(given) else error from None


def cascade_of(verb: str, given: Any, axis: str, motion: Motion, to: str = "log") -> Cascade | None:
    """Return the controller that is given as itself, as its file or as a result; None where none is."""
    if given is None or isinstance(given, Cascade):
        return given
    return document_of(verb, ControllerDocument, given, (axis, motion), to).cascade(motion)


def friction_of(verb: str, given: Any, axis: str, motion: Motion) -> FrictionDocument | None:
    """Return the friction that is given as a static map, as its file or as a result; None where none is."""
    if isinstance(given, StaticMap):
        units = {p.name: si_unit(p.dimension, motion) for p in StaticMap.parameters}
        static = {name: {"value": getattr(given, name), "unit": unit} for name, unit in units.items()}
        head = {"fric": FrictionDocument.type_name(), "axis": axis, "motion": motion}
        return FrictionDocument.model_validate(head | {"static": static})
    return None if given is None else document_of(verb, FrictionDocument, given, (axis, motion))


def quantity(given: str | float | None, dimension: str, motion: Motion = "linear") -> float | None:
    """Return a positive quantity given in SI, or as a text with its unit; None where none is.

    Raises
    ------
    FricError
        When the text is no quantity of this dimension, or the value is not positive.
    """
    if given is None:
        return None
    value = in_si(given, dimension, motion)
    if not value > 0:
        raise FricError(f"'{given}' is not positive", hint="Give a positive value.")
    return value


def in_si(given: str | float, dimension: str, motion: Motion = "linear") -> float:
    """Return a quantity given in SI, or as a text with its unit."""
    if isinstance(given, str):
        return parse(given, dimension, motion)
    if isinstance(given, bool) or not isinstance(given, int | float) or not isfinite(given):
        raise refused(dimension, 'a number in SI, or a text such as "1 mm"', given)
    return float(given)


def several(given: str | Sequence[str | float] | None, dimension: str, motion: Motion) -> list[float] | None:
    """Return quantities given as a list, or as a text with commas; None where none are."""
    if given is None:
        return None
    return [in_si(one, dimension, motion) for one in (given.split(",") if isinstance(given, str) else given)]
