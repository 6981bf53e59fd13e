"""An axis as it is known before an experiment: a machine file, and what is known better."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fric.arrays import Real
from fric.documents.friction import FrictionDocument
from fric.documents.machine_files import read_machine
from fric.documents.plant import PlantDocument
from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.flaws.prediction import PLAN_TYPICAL
from fric.friction.directed import Directed
from fric.friction.stribeck import OnStaticMap, StaticMap
from fric.log import Log
from fric.notice import Notice
from fric.records.resolution import lattice_step
from fric.simulate.machine import Axis, Machine

TYPICAL = "xy-table"
"""The bundled machine that stands in where none is given."""

REST = 10
"""Samples over which the encoder does not move, at least, where a drive is at rest."""


def prior_axis(
    machine: Machine | None = None,
    axis: str = "x",
    friction: FrictionDocument | None = None,
    plant: PlantDocument | None = None,
    like: Sequence[Log] = (),
) -> tuple[Axis, list[Notice]]:
    """Return an axis as it is known, and what stands in for what is not.

    machine: The machine; a typical one where not given.
    axis: Name of the axis; that of the friction where it is given.
    friction, plant: What is known of its friction and of its plant.
    like: A typical log, which tells the force noise and the encoder step of others.
    Raises FricError: When the machine has no such axis, or a file is of another motion.
    """
    notices: list[Notice] = []
    name = axis if friction is None else friction.axis
    if machine is None:
        found = replace(read_machine(TYPICAL).axis("x"), name=name)
        notices.append(PLAN_TYPICAL.found(machine=TYPICAL, like=bool(like)))
    else:
        found = machine.axis(name)
    if friction is not None:
        if friction.motion != found.motion:
            raise FricError(f"the friction is of a {friction.motion} axis, and axis {name} of the machine is not",
                            hint="Give the machine with `machine=`.")  # fmt: skip
        found = replace(found, friction=_friction(friction, found))
    if plant is not None:
        found = replace(found, plant=plant.plant(found.motion))
    return _logged_like(found, like) if like else found, notices


def _friction(known: FrictionDocument, axis: Axis) -> Any:
    """Return the model of a friction file; a static map alone gets the pre-sliding of the machine, at its own level."""
    names = known.model_names()
    if names:
        return known.friction("gms" if "gms" in names else names[0])
    static = known.friction("static")
    model = axis.friction.model if isinstance(axis.friction, Directed) else axis.friction
    forward = static.model if isinstance(static, Directed) else static
    if not (isinstance(model, OnStaticMap) and isinstance(forward, StaticMap) and hasattr(model, "k")):
        return static
    k = tuple(one * forward.F_s / model.static.F_s for one in model.k)
    whole = replace(model, static=forward, k=k)  # type: ignore[call-arg]
    return Directed(whole, static.negative) if isinstance(static, Directed) else whole


def _logged_like(axis: Axis, logs: Sequence[Log]) -> Axis:
    """Return the axis with the force noise and the encoder of a log.

    While the encoder stands still, the loop adds nothing of its own to the force: what is white there is noise. It is
    what second differences hold, ``var(ΔΔF) = 6·σ²``. In a log without rests all of it is taken.
    """
    second: list[Real] = []
    whole: list[Real] = []
    for log in (one for one in logs if one.force is not None):
        white = np.diff(log.require("force", "its noise"), 2)
        whole.append(white)
        if log.position is not None and len(white) > REST:
            moved = np.append(0, np.cumsum(np.diff(log.position) != 0))
            still = moved[REST:] == moved[:-REST]
            second.append(white[: len(still)][still])
    found = np.concatenate(second or whole or [np.zeros(0)])
    if len(found) < REST:
        found = np.concatenate(whole or [found])
    if len(found) < REST:
        raise FricError("the log has no force that tells its noise", where=logs[0].where)
    steps = [step for log in logs if log.position is not None and (step := lattice_step(log.position))]
    axis = replace(axis, force_noise=float(np.sqrt(np.mean(found**2) / 6.0)))
    return replace(axis, encoder=Encoder(float(np.median(steps)))) if steps else axis
