"""Machines and compensation schemes from their files."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from fric.documents.base import AxisDocument, Document
from fric.documents.controller import BlockDocument, ControllerDocument, ObserverDocument
from fric.documents.friction import FrictionDocument
from fric.documents.machine import MachineDocument
from fric.documents.plant import PlantDocument
from fric.documents.yaml import read_document, read_tree
from fric.errors import FricError
from fric.flaws.files import GAINS_DESIGNED
from fric.friction.stribeck import StaticMap
from fric.notice import Notice
from fric.plausibility import Finding, of_friction, of_plant, settled
from fric.simulate.machine import Axis, Machine
from fric.units import parse
from fric.verb import Kind, verb

NOMINAL_DOCUMENTS: dict[str, type[AxisDocument | FrictionDocument | BlockDocument]] = {
    "plant": PlantDocument,
    "controller": ControllerDocument,
    "observer": ObserverDocument,
    "friction": FrictionDocument,
    "block": BlockDocument,
}
"""What a controller's side of an axis can be given as a file, by document type."""


@verb
def read_machine(
    path: Path | str,
    *,
    nominal_files: Annotated[Iterable[str], Kind(list[str], "AXIS=FILE.yaml")] = (),
    gain: float | None = None,
    lead: Annotated[float | str | None, Kind(metavar="TIME")] = None,
    friction_model: Annotated[str | None, Kind(metavar="NAME")] = None,
) -> Machine:
    """Read a machine file, and the files that it names.

    Parameters
    ----------
    path
        The machine file.
    nominal_files
        Friction that the controller of an axis believes; or its plant, controller, observer or block; repeatable.
        Files that its controllers use instead of the machine's, each as ``AXIS=FILE.yaml``. What the axis truly is
        stays as it is.
    gain
        Gain of the friction feedforward, instead of the machine's. On all axes.
    lead
        How far feedforward goes ahead of the reference, as "0.6 ms", or auto for the delay of the plant that is
        believed; instead of the machine's. A number is in seconds.
    friction_model
        Model that the machine has, of those in its file; else the richest.

    Raises
    ------
    FricError
        When a file does not read, a value is missing, of the wrong unit or not physical, or a part is of another axis.
    """
    nominal_files = tuple(nominal_files)
    ahead: Any = parse(lead, "time") if isinstance(lead, str) and lead != "auto" else lead
    document = read_machine_document(path, nominal_files)
    try:
        machine = document.machine()
        if friction_model is not None:
            own = {name: part.friction.friction(friction_model) for name, part in document.axes.items()}
            axes = {name: replace(axis, friction=own[name]) for name, axis in machine.axes.items()}
            machine = replace(machine, axes=axes)
    except FricError as error:
        raise error.at(str(path)) from None
    instead: dict[str, Any] = {key: value for key, value in (("gain", gain), ("lead", ahead)) if value is not None}
    axes = {
        name: replace(axis, nominal_friction=replace(axis.nominal_friction, **instead))
        for name, axis in machine.axes.items()
    }
    designed = [
        GAINS_DESIGNED.found(f"axis {name}") for name, part in document.axes.items()
        if isinstance(part.controller, ControllerDocument) and part.controller.margins
    ]  # fmt: skip
    doubtful = settled(finding for axis in machine.axes.values() for finding in _of_axis(axis, str(path)))
    machine = replace(machine, warnings=(*machine.warnings, *doubtful, *designed))
    origin: dict[str, Any] = {"path": str(path), "nominal_files": list(nominal_files), "friction_model": friction_model}
    return replace(machine, axes=axes, origin=origin | instead)


def _of_axis(axis: Axis, where: str) -> Iterator[Finding]:
    """Yield what can be held against physics in an axis: both plants, all frictions beside the mass, the sampling."""
    where = f"{where}, axis {axis.name}"
    for plant in filter(None, (axis.plant, axis.nominal)):
        yield from of_plant(plant, axis.motion, where)
    for model in (axis.friction, *axis.nominal_friction.models.values()):
        static = model if isinstance(model, StaticMap) else getattr(model, "static", None)
        if static is not None:
            yield from of_friction(static, axis.motion, axis.plant.M, where)
    yield Finding("sampling", axis.cascade.sampling, axis.motion, where)


def read_machine_document(path: Path | str, nominal_files: Iterable[str] = ()) -> MachineDocument:
    """Read a machine file as a document, with the files that its controllers use instead in their places."""
    document = read_document(path, MachineDocument)
    axes = dict(document.axes)
    for given in nominal_files:
        name, equals, file = given.partition("=")
        if not equals:
            raise FricError(f"'{given}' does not say which axis it is for", hint="Write it as x=FRICTION.yaml.")
        if name not in axes:
            raise FricError(f"the machine has no axis '{name}'", hint=f"Its axes are {', '.join(axes)}.")
        kind, part = _nominal_document(Path(file))
        if (part.axis, part.motion) != (name, axes[name].motion):
            raise FricError(
                f"is the {kind} of the {part.motion} axis {part.axis}, "
                f"and axis {name} of the machine is {axes[name].motion}",
                where=file,
                hint=f"Give the {kind} file of this axis.",
            )
        if isinstance(part, BlockDocument):
            update: dict[str, object] = {"blocks": axes[name].blocks | {part.block: part}}
            if part.controller is not None:
                update["controller"] = part.controller
        elif kind == "friction":
            update = {"feedforward": axes[name].feedforward.model_copy(update={"friction": part})}
        else:
            update = {"nominal" if kind == "plant" else kind: part}
        axes[name] = axes[name].model_copy(update=update)
    return document.model_copy(update={"axes": axes})


def axis_notices(document: MachineDocument, name: str) -> tuple[Notice, ...]:
    """Return what the files that an axis of a machine is made of say of themselves, each notice once."""
    parts = document.axes[name].parts().values() if name in document.axes else ()
    text = [notice for part in parts if isinstance(part, Document) for notice in part.notices()]
    return tuple(dict.fromkeys([*document.notices(), *text]))


def _nominal_document(file: Path) -> tuple[str, AxisDocument | FrictionDocument | BlockDocument]:
    tree = read_tree(file)
    kind = str(tree.get("fric", "") if hasattr(tree, "get") else "").partition("/")[0]
    if kind not in NOMINAL_DOCUMENTS:
        raise FricError(
            f"is no file that a controller uses: its first line says 'fric: {kind}'"
            if kind
            else "is no file of fric's",
            where=str(file),
            hint=f"Give one of {', '.join(NOMINAL_DOCUMENTS)}.",
        )
    return kind, read_document(file, NOMINAL_DOCUMENTS[kind])
