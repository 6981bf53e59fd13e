"""An axis as it is known before an experiment: a machine file, and what is known better."""

from dataclasses import replace
from typing import Any

import numpy as np

from fric.arrays import Real
from fric.documents.friction import FrictionDocument
from fric.documents.plant import PlantDocument
from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.flaws.plan import PLAN_TYPICAL
from fric.friction.directed import Directed
from fric.friction.stribeck import OnStaticMap, StaticMap
from fric.identify.records.resolution import lattice_step
from fric.notice import Notice
from fric.results.given import in_si, logs_of
from fric.results.given_models import document_of
from fric.results.machine import machine_of
from fric.simulate.machine import Axis

TYPICAL = "xy-table"
"""The bundled machine that stands in where none is given."""

REST = 10
"""Samples over which the encoder does not move, at least, where a drive is at rest."""


def prior_axis(
    machine: Any = None,
    axis: str = "x",
    friction: Any = None,
    *,
    noise: float | str | None = None,
    encoder: float | str | None = None,
    like: Any = None,
    plant: Any = None,
) -> tuple[Axis, list[Notice]]:
    """Return an axis as it is known, and what stands in for what is not.

    Parameters
    ----------
    machine
        The machine, its file, or the name of a bundled one; a typical one where not given.
    axis
        Name of the axis; that of the friction where it is given.
    friction
        What is known of its friction: a friction file or a result.
    noise, encoder
        Of its logs: force noise, rms [N], and encoder step [m].
    like
        A typical log, which tells both.
    plant
        What is known of its plant: a plant file or a result.

    Raises
    ------
    FricError
        When the machine has no such axis, or a file is of another motion.
    """
    notices: list[Notice] = []
    known = None if friction is None else document_of("plan", FrictionDocument, friction)
    subject = machine_of("plan", TYPICAL if machine is None else machine)
    name = axis if known is None else known.axis
    if machine is None:
        found = replace(subject.axis("x"), name=name)
        notices.append(PLAN_TYPICAL.found(machine=TYPICAL, like=like is not None))
    else:
        found = subject.axis(name)
    if known is not None:
        if known.motion != found.motion:
            raise FricError(f"the friction is of a {known.motion} axis, and axis {name} of the machine is not",
                            hint="Give the machine with --machine.")  # fmt: skip
        found = replace(found, friction=_friction(known, found))
    if plant is not None:
        of = (known.axis, found.motion) if known is not None else None
        given = document_of("plan", PlantDocument, plant, of, "friction")
        found = replace(found, plant=given.plant(found.motion))
    if like is not None:
        found = _logged_like(found, like)
    if encoder is not None:
        found = replace(found, encoder=Encoder(in_si(encoder, "position", found.motion)))
    if noise is not None:
        found = replace(found, force_noise=in_si(noise, "force", found.motion))
    return found, notices


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


def _logged_like(axis: Axis, like: Any) -> Axis:
    """Return the axis with the force noise and the encoder of a log.

    While the encoder stands still, the loop adds nothing of its own to the force: what is white there is noise. It is
    what second differences hold, ``var(ΔΔF) = 6·σ²``. In a log without rests all of it is taken.
    """
    logs = logs_of("plan", [like])
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
