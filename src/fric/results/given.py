"""What verbs take: records or the files that hold them, paths, quantities with units, and who is told of progress."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from fric.control.cascade import Cascade
from fric.control.scheme import Scheme, choose_schemes
from fric.documents.controller import ControllerDocument
from fric.documents.friction import FrictionDocument
from fric.documents.identified import Identified
from fric.documents.machine_files import read_machine
from fric.documents.plant import PlantDocument
from fric.documents.quantity import in_units
from fric.documents.schemes import read_schemes
from fric.documents.yaml import read_document
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import as_filed
from fric.flaws.unit import BOUNDS
from fric.friction.stribeck import StaticMap
from fric.log import ForceVelocity, FrequencyResponse, Log, Record
from fric.plausibility import Finding, of_plant, settled
from fric.results.base import Result
from fric.simulate.machine import Machine
from fric.units import Motion, likely, parse
from fric.verb import UnfitError, refused

if TYPE_CHECKING:
    from fric.circles.measured import MeasuredCircle
    from fric.documents.plan import PlanDocument  # it loads what plans and simulates

D = TypeVar("D", FrictionDocument, PlantDocument, ControllerDocument, "PlanDocument")

CIRCLES = "circle tests, or their files"
"""What verbs take that are of measured circles."""


def document_of(kind: type[D], given: Any, of: tuple[str, Motion] | None = None, to: str = "log") -> D:
    """Return the document that is given as itself, as its file or as a result.

    Parameters
    ----------
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
            raise UnfitError(wanted, given)
        found = kind.model_validate(as_filed(given.document))  # as its file would say: digits hang on no way
    else:
        found = given if isinstance(given, kind) else read_document(path_of(wanted, given), kind)
    if of is not None and (found.axis, found.motion) != of:
        raise FricError(
            f"is the {kind.type} of the {found.motion} axis {found.axis}, and the {to} is of the {of[1]} axis {of[0]}",
            where=where_of(given),
            hint=f"Give the {kind.type} of this axis.",
        )
    return found


def plant_of(given: Any, axis: str, motion: Motion) -> Plant | None:
    """Return the plant that is given as itself, as its file or as a result; None where none is."""
    if given is None or isinstance(given, Plant):
        return given
    document = document_of(PlantDocument, given, (axis, motion))
    try:
        plant = document.plant(motion)
        settled(of_plant(plant, motion))
        return plant
    except FricError as error:
        raise error.at(where_of(given)) if where_of(given) else error from None


def cascade_of(given: Any, axis: str, motion: Motion, to: str = "log") -> Cascade | None:
    """Return the controller that is given as itself, as its file or as a result; None where none is."""
    if given is None or isinstance(given, Cascade):
        return given
    return document_of(ControllerDocument, given, (axis, motion), to).in_si(motion)


def friction_of(given: Any, axis: str, motion: Motion) -> FrictionDocument | None:
    """Return the friction that is given as a static map, as its file or as a result; None where none is."""
    if isinstance(given, StaticMap):
        static = in_units(vars(given), {p.name: p.dimension for p in StaticMap.parameters}, motion)
        head = {"fric": FrictionDocument.type_name(), "axis": axis, "motion": motion}
        return FrictionDocument.model_validate(head | {"static": static})
    return None if given is None else document_of(FrictionDocument, given, (axis, motion))


def circles_of(given: Iterable[Any], scheme: str | None = None) -> list[MeasuredCircle]:
    """Return measured circles that are given as such, as files or in lists; of a run file those of a scheme."""
    from fric.circles.measured import MeasuredCircle

    ones = [one for part in given for one in (part if isinstance(part, list | tuple) else [part])]
    ones = [test for one in ones for test in _of_run(one, scheme)]
    tests = [one for one in ones if isinstance(one, MeasuredCircle)]
    files = [path_of(CIRCLES, one) for one in ones if not isinstance(one, MeasuredCircle)]
    if files:
        from fric.io.circle import choose_circles  # with HDF5, which a table needs not

        tests += choose_circles(files, scheme)
    return tests


def _of_run(given: Any, scheme: str | None) -> list[Any]:
    """Return the circles of a result that was simulated, as they were recorded; anything else as it is."""
    runs = getattr(given, "runs", None) if isinstance(given, Result) else None
    if runs is None:
        return [given]
    from fric.circles.measured import measured_from_run

    chosen = [run for run in runs if scheme in (None, run.scheme.name)]
    if len(chosen) != 1:
        names = " or ".join(f"`scheme='{run.scheme.name}'`" for run in runs)
        raise FricError(f"the result holds {len(chosen)} circles, and one is asked for", hint=f"Say which: {names}.")
    return [measured_from_run(chosen[0])]


def machine_of(given: Any) -> Machine:
    """Return the machine that is given as itself, as identified, as its file, or by the name of a bundled one."""
    if isinstance(given, Identified):
        return given.machine
    if isinstance(given, Machine):
        return given
    return read_machine(path_of("a machine, or its file", given))


def schemes_of(asked: Any, known: Any = None) -> list[Scheme]:
    """Return the schemes that are asked for by their names, or given as themselves.

    Parameters
    ----------
    asked
        A scheme, several, or names as in ``a,c,f`` or ``all``.
    known
        Schemes by name, or their file; the paper's where not given.
    """
    if isinstance(asked, Scheme):
        return [asked]
    if isinstance(known, str | Path):
        known = read_schemes(Path(known))
    if known is not None and not (
        isinstance(known, Mapping) and all(isinstance(one, Scheme) for one in known.values())
    ):
        raise UnfitError("schemes by name, or their file", known)
    if isinstance(asked, str):
        return choose_schemes(asked, known)
    if not isinstance(asked, Iterable):
        raise UnfitError("names of schemes, as a,c,f or all", asked)
    found: list[Scheme] = []
    for one in asked:
        found += schemes_of(one, known)
    return found


class Advance(Protocol):
    """Is told how far a verb is, for whoever waits."""

    def __call__(self, steps: int = 1, *, total: int | None = None) -> None:
        """Take that so many steps are done, and how many there are where that is known now."""


def silent(steps: int = 1, *, total: int | None = None) -> None:
    """Tell nobody."""


def records_of(given: Iterable[Any], *, one_axis: bool = True) -> list[Record]:
    """Return the records (of one axis) that are given: records, log files, or lists of them.

    Raises
    ------
    FricError
        When something else is given, a file is no log file, or the records are of different axes.
    """
    found = list(_flat(given))
    if not found:
        raise FricError("no record was given", hint="Give log files, or what fric.read returns.")
    axes = {(record.axis, record.motion) for record in found}
    if one_axis and len(axes) > 1:
        text = ", ".join(f"{axis} ({motion})" for axis, motion in sorted(axes))
        raise FricError(f"the logs are of different axes: {text}", hint="Identify one axis at a time.")
    return found


def logs_of(given: Iterable[Any]) -> list[Log]:
    """Return the records in time of one axis that are given, as `records_of`."""
    records = records_of(given)
    logs = [record for record in records if isinstance(record, Log)]
    if not logs:
        raise FricError("there is no record in time", where=records[0].where)
    return logs


def _flat(given: Iterable[Any]) -> Iterable[Record]:
    for one in given:
        if isinstance(one, Log | FrequencyResponse | ForceVelocity):
            yield one
        elif isinstance(one, str | Path):
            from fric.io.hdf5 import read_records  # with HDF5, which simulations need not

            yield from read_records(Path(one))
        elif isinstance(one, Iterable) and not isinstance(one, bytes | dict):
            yield from _flat(one)
        else:
            raise UnfitError("log files, or records that fric.read returns", one)


def path_of(wanted: str, given: Any) -> Path:
    """Return what is given as a path, or raise the error of a wrong type."""
    if not isinstance(given, str | Path):
        raise UnfitError(wanted, given)
    return Path(given)


def where_of(given: Any) -> str:
    """Return the file that is given, for an error; nothing where none is."""
    return str(given) if isinstance(given, str | Path) else ""


def quantity(given: str | float | None, dimension: str, motion: Motion = "linear") -> float | None:
    """Return a positive quantity given in SI, or as a text with its unit; None where none is.

    Raises
    ------
    FricError
        When the text is no quantity of this dimension, or the value is not positive.
    """
    return None if given is None else positive(given, dimension, motion)


def positive(given: str | float, dimension: str, motion: Motion = "linear") -> float:
    """Return a positive quantity given in SI, or as a text with its unit."""
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


def bounded(name: str, given: str | float, motion: Motion = "linear") -> float:
    """Return a quantity that is given, in SI, held against its bound of `fric.plausibility` as what files hold is.

    Raises
    ------
    FricError
        When it is no quantity of its dimension, or of no machine.
    """
    dimension = BOUNDS[name].dimension
    value = in_si(given, dimension, motion)
    meant = f"Is '{likely(f'{value:g}', dimension, motion)}' meant? Write the unit"
    if value > 0:  # of anything else whoever takes it tells what it is
        settled([Finding(name, value, motion)], meant)
    return value


def several(given: float | str | Sequence[str | float] | None, dimension: str, motion: Motion) -> list[float] | None:
    """Return quantities given as a list, or as a text with commas; None where none are."""
    if given is None:
        return None
    ones = given.split(",") if isinstance(given, str) else [given] if isinstance(given, float | int) else given
    return [in_si(one, dimension, motion) for one in ones]
