"""Model arguments of verbs: plants, controllers, friction, circles, machines, schemes; objects, files or results."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import ValidationError

from fric.control.cascade import Cascade
from fric.control.scheme import Scheme, choose_schemes
from fric.documents.bundled import located
from fric.documents.controller import ControllerDocument
from fric.documents.friction import FrictionDocument
from fric.documents.machine_files import IdentifiedMachine, read_machine, sections_of
from fric.documents.plant import PlantDocument
from fric.documents.schemes import read_schemes
from fric.documents.yaml import read_document
from fric.drive.plant import Plant
from fric.errors import FricError, found_in
from fric.estimate import as_filed
from fric.friction.stribeck import StaticMap
from fric.input import other_kind
from fric.plausibility import of_plant, settled
from fric.results.base import Result, path_of
from fric.simulate.machine import Machine
from fric.units import Motion
from fric.verb import UnfitError

if TYPE_CHECKING:
    from fric.circles.measured import MeasuredCircle
    from fric.documents.plan import PlanDocument  # it loads what plans and simulates

D = TypeVar("D", FrictionDocument, PlantDocument, ControllerDocument, "PlanDocument")
CIRCLES = "circle tests, or their files"  # Arguments of verbs that are measured circles


def where_of(given: Any) -> str:
    """Return the given file for an error message; empty if it is no file."""
    return str(given) if isinstance(given, str | Path) else ""


def document_of(kind: type[D], given: Any, of: tuple[str, Motion] | None = None, to: str = "log") -> D:
    """Return the document of a type that is given directly, as its file or as a result.

    of, to: Name and motion of the axis that it must belong to, and name of what is of that axis, for an error.
    """
    wanted = f"a {kind.type} file, or a result that holds one"
    if kind is PlantDocument and isinstance(given, Plant):
        axis, motion = of or ("x", "linear")
        head = {"fric": kind.type_name(), "axis": axis, "motion": motion}
        return kind.model_validate(head | PlantDocument.of(given, motion))
    if isinstance(given, Result):
        if given.document.get("fric") != kind.type_name():
            raise UnfitError(wanted, given)
        found = kind.model_validate(as_filed(given.document))  # as its file would say: digits hang on no way
    else:
        found = given if isinstance(given, kind) else read_document(path_of(wanted, given), kind)
    if isinstance(found, PlantDocument) and found.B is not None:
        with found_in(where_of(given)):
            settled(of_plant(found.plant(found.motion) if found.K_f else found.linear(found.motion), found.motion))
    if isinstance(found, FrictionDocument):
        with found_in(where_of(given)):
            for name in found.model_names():
                found.friction(name)
    if of is not None and not found.belongs(*of):
        what = (
            f"is the {kind.type} of the {found.motion} axis {found.axis}, and the {to} is of the {of[1]} axis {of[0]}"
        )
        raise FricError(what, where=where_of(given), hint=f"Give the {kind.type} of this axis.")
    return found


def plant_of(given: Any, axis: str, motion: Motion) -> Plant | None:
    """Return the plant that is given directly, as its file or as a result; None if not given."""
    if given is None or isinstance(given, Plant):
        return given
    document = document_of(PlantDocument, given, (axis, motion))
    with found_in(where_of(given)):
        return document.plant(motion)


def cascade_of(given: Any, axis: str, motion: Motion, to: str = "log") -> Cascade | None:
    """Return the controller that is given directly, as its file or as a result; None if not given."""
    if given is None or isinstance(given, Cascade):
        return given
    return document_of(ControllerDocument, given, (axis, motion), to).in_si(motion)


def friction_of(given: Any, axis: str, motion: Motion) -> FrictionDocument | None:
    """Return the friction that is given as a static map, as its file or as a result; None where none is."""
    if isinstance(given, StaticMap):
        head = {"fric": FrictionDocument.type_name(), "axis": axis, "motion": motion}
        try:
            return FrictionDocument.model_validate(head | sections_of(given, motion))
        except ValidationError as error:
            raise FricError(error.errors()[0]["msg"].removeprefix("Value error, ").partition("\n")[0]) from None
    return None if given is None else document_of(FrictionDocument, given, (axis, motion))


def some_circles(given: Iterable[Any], scheme: str | None = None, *, other: bool = False) -> list["MeasuredCircle"]:
    """Return measured circles as `circles_of` does; raise a `FricError` if there are none."""
    if not (found := circles_of(given, scheme, other=other)):
        raise FricError("no circle was given", hint=f"Give {CIRCLES}.")
    return found


def circles_of(given: Iterable[Any], scheme: str | None = None, *, other: bool = False) -> list["MeasuredCircle"]:
    """Return measured circles that are given directly, as files or in lists; of a run file those of a scheme.

    other: Whether the scheme says something of circles of another scheme, or of none, too; else they are refused.
    """
    from fric.circles.measured import MeasuredCircle

    ones = [item for part in given for item in (part if isinstance(part, list | tuple) else [part])]
    ones = [test for test in ones for test in _of_run(test, scheme)]
    tests = [test for test in ones if isinstance(test, MeasuredCircle)]
    if files := [path_of(CIRCLES, test) for test in ones if not isinstance(test, MeasuredCircle)]:
        from fric.io.circle import choose_circles  # with HDF5, which a table needs not

        if twice := next((file for n, file in enumerate(files) if file in files[:n]), None):
            raise FricError("this circle is given twice", where=str(twice), hint="Give each once: it counts once.")
        tests += choose_circles(files, scheme)
    if tests and not other and scheme not in {None, *(test.scheme for test in tests)}:
        raise FricError(f"no circle is of the scheme '{scheme}'", hint="It chooses from a run file: leave it out here.")
    return tests


def _of_run(given: Any, scheme: str | None) -> list[Any]:
    """Return the circles of a simulated result as measured circles; anything else unchanged."""
    runs = getattr(given, "runs", None) if isinstance(given, Result) else None
    if runs is None:
        return [given]
    from fric.circles.measured import measured_from_run

    if len(chosen := [run for run in runs if scheme in (None, run.scheme.name)]) != 1:
        names = " or ".join(f"`scheme='{run.scheme.name}'`" for run in runs)
        raise FricError(f"the result holds {len(chosen)} circles, and one is needed", hint=f"Say which: {names}.")
    return [measured_from_run(chosen[0])]


def machine_of(given: Any) -> Machine:
    """Return the machine that is given directly, as identified, as its file, or as the name of a bundled machine."""
    if isinstance(given, IdentifiedMachine):
        return given.machine
    return given if isinstance(given, Machine) else read_machine(path_of("a machine, or its file", given))


def machine_ran_on(circle: Any) -> Machine:
    """Return the machine that a run file was simulated on; raise if the circle does not name it or its file is gone."""
    from fric.circles.measured import MeasuredCircle
    from fric.io.circle import read_run_provenance  # with HDF5, which a table needs not
    from fric.io.recognise import recognise

    path = None if isinstance(circle, MeasuredCircle) else path_of("a circle", circle)
    if path is not None and (kind := recognise(path)) not in {"run/1", "circle/1"}:
        raise other_kind(path, kind, "circle/1")
    origin = ({} if path is None else read_run_provenance(path)).get("origin", {})
    if not origin.get("path"):
        raise FricError("the circle does not say on which machine it was run", hint="Name it with `machine=`.")
    return read_machine(located(Path(origin["path"]), "machine"), nominal_files=origin.get("nominal_files", ()))


def schemes_of(asked: Any, known: Any = None) -> list[Scheme]:
    """Return the requested schemes, given by name or directly.

    known: Schemes by name, or their file; the paper's where not given.
    """
    given = [*asked] if isinstance(asked, Iterable) and not isinstance(asked, str | Scheme) else [asked]
    if isinstance(known, str | Path):
        known = read_schemes(Path(known))
    of_schemes = isinstance(known, Mapping) and all(isinstance(item, Scheme) for item in known.values())
    if known is not None and not of_schemes:
        raise UnfitError("schemes by name, or their file", known)
    if not all(isinstance(item, str | Scheme) for item in given):
        raise UnfitError("names of schemes, as a,c,f or all", asked)
    every = ([item] if isinstance(item, Scheme) else choose_schemes(item, known) for item in given)
    found: dict[str, Scheme] = {}
    for scheme in (scheme for part in every for scheme in part):
        if found.setdefault(scheme.name, scheme) != scheme:
            raise FricError(f"two schemes have the name '{scheme.name}'", hint="Give each its name.")
    if not found:
        raise FricError("there is no scheme to run", hint="Name one, as 'f', of schemes that there are.")
    return list(found.values())
