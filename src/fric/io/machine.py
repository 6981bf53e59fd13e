"""Machines and compensation schemes from their files."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from fric.compensation.base import Compensation
from fric.errors import FricError
from fric.io.documents.friction import FrictionDocument
from fric.io.documents.machine import MachineDocument, believed_models
from fric.io.documents.schemes import SchemesDocument
from fric.io.yaml import read_document
from fric.simulate.machine import Believed, Machine


def read_machine(
    path: Path, *, believed: Iterable[str] = (), gain: float | None = None, friction_model: str | None = None
) -> Machine:
    """Read a machine file, and the files that it names.

    Parameters
    ----------
    path
        The machine file.
    believed
        Friction files that its controllers believe instead, each as ``AXIS=FRICTION.yaml``.
    gain
        Gain of the friction feedforward on all axes, instead of the machine's.
    friction_model
        Name of the model, of those in the machine's own friction, that the axes have; the richest where not given.

    Raises
    ------
    FricError
        When a file does not read, a value is missing, of the wrong unit or not physical, or a part is of another axis.
    """
    document = read_document(path, MachineDocument)
    try:
        machine = document.machine()
        if friction_model is not None:
            own = {name: part.friction.friction(friction_model) for name, part in document.axes.items()}
            axes = {name: replace(axis, friction=own[name]) for name, axis in machine.axes.items()}
            machine = replace(machine, axes=axes)
    except FricError as error:
        raise error.at(str(path)) from None
    for given in believed:
        name, equals, file = given.partition("=")
        if not equals:
            raise FricError(f"'{given}' does not say which axis it is for", mend="Write it as x=FRICTION.yaml.")
        axis = machine.axis(name)
        friction = read_document(Path(file), FrictionDocument)
        if (friction.axis, friction.motion) != (axis.name, axis.motion):
            raise FricError(
                f"is the friction of the {friction.motion} axis {friction.axis}, "
                f"and axis {axis.name} of the machine is {axis.motion}",
                where=file,
                mend="Give the friction file of this axis.",
            )
        believing = replace(axis, believed=Believed(believed_models(friction), axis.believed.gain))
        machine = replace(machine, axes={**machine.axes, name: believing})
    if gain is None:
        return machine
    axes = {name: replace(axis, believed=replace(axis.believed, gain=gain)) for name, axis in machine.axes.items()}
    return replace(machine, axes=axes)


def read_schemes(path: Path) -> dict[str, Compensation]:
    """Read compensation schemes by name from a schemes file."""
    return read_document(path, SchemesDocument).compensations()
