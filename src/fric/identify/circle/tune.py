"""What a controller believes, refitted to recorded circles: friction, plant, delay."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fric.drive.plant import Plant
from fric.errors import FricError
from fric.friction.gms import GMS
from fric.identify.circle.belief import Coordinates
from fric.identify.circle.tune_doubts import doubts_of
from fric.identify.circle.tune_fit import STARTS, Balance, Fitted, at, fit
from fric.identify.circle.voltage import VoltageRecord, refined, voltage_record
from fric.notice import Notice
from fric.simulate.machine import Believed

if TYPE_CHECKING:
    from fric.identify.circle.measured import MeasuredCircle
    from fric.simulate.machine import Axis

SHAPE = 1.1
"""Times the noise of the log that four parameters may leave; above it the full shape is fitted."""
GAIN = 0.97
"""Share of what four parameters leave that the full shape must leave at most, to be believed."""


@dataclass(frozen=True)
class TunedAxis:
    """What circles say of one axis.

    Parameters
    ----------
    axis
        The axis with its new belief; as it was, where the belief is refused.
    friction, nominal
        The friction and the plant that were found.
    before, after
        What belief and result leave of the recorded voltages.
    full
        Whether the full shape was fitted.
    improves
        Whether the result is better than what was believed.
    warnings
        What the circles cannot tell.
    """

    axis: Axis
    friction: GMS
    nominal: Plant
    before: Fitted
    after: Fitted
    full: bool
    improves: bool
    warnings: tuple[Notice, ...]


def tune_axis(
    axis: Axis, tests: Sequence[MeasuredCircle], done: Callable[[], object] = lambda: None
) -> TunedAxis:
    """Refit what the controller of an axis believes to recorded circles.

    Per axis ``W[u(t - T_d)] = m·W[z̈] + a·W[ż] + o + W[F(z)]/K_f`` with W a low-pass of 100 Hz, zero phase; m, a and
    an offset of each circle are linear. First the level of friction, its stiffness, C and T_d are searched; then, where
    that leaves more than the log's own noise, F_s/F_c, v_s, delta, each alpha and each k.

    Parameters
    ----------
    axis
        The axis; its controller believes a GMS model.
    tests
        Circle tests with reference, position and voltage.
    done
        Called after each of `stages`.

    Raises
    ------
    FricError
        When no GMS model is believed, or a test lacks a channel.
    """
    believed = axis.believed.models.get("gms")
    if not isinstance(believed, GMS):
        raise FricError(
            f"the controller of axis {axis.name} believes no GMS model, which tuning starts from",
            mend="Identify one: fric identify gms, and name it under feedforward in the machine file.",
        )
    nominal = axis.nominal or axis.plant
    records = tuple(voltage_record(test, axis.name) for test in tests)
    few = Coordinates.of(believed, nominal.T_d, full=False)
    gain = float(np.log(axis.believed.gain)) if axis.believed.gain > 0 else 0.0
    start = np.array([gain, 0.0, 0.0, 0.0])
    before = at(Balance(records, few, nominal.K_f), start, np.array([1 / nominal.B, nominal.A / nominal.B]))
    if not axis.believed.gain > 0:  # nothing was fed forward: that is what the circle was without
        before = replace(before)
    starts = [start + np.array([0.0, np.log(stiffness), np.log(C), 0.0]) for stiffness, C in STARTS]
    found = fit(Balance(records, few, nominal.K_f), starts)
    done()
    found = _again(found, nominal.K_f)
    done()
    full = False
    noise = found.noise()
    if noise is None or found.rms > SHAPE * noise:
        shape = Coordinates.of(believed, nominal.T_d, full=True)
        start = shape.moved(found.balance.coordinates, found.x)
        richer = fit(replace(found.balance, coordinates=shape), [start], found.rms)
        richer = _again(richer, nominal.K_f)
        compared = at(replace(found.balance, records=richer.balance.records), found.x)
        if full := richer.rms < GAIN * compared.rms:
            found = richer
    done()
    friction, T_d = found.balance.coordinates.friction(found.x), found.balance.coordinates.delay(found.x)
    m, a = found.plant[:2]
    warnings = list(doubts_of(axis, tests, before, found))
    improves = bool(m > 0 and found.rms < before.rms and T_d >= 0.5 / axis.cascade.sampling)
    if not improves:
        return TunedAxis(axis, friction, nominal, before, found, full, False, tuple(warnings))
    plant = Plant(A=max(float(a / m), 0.0), B=float(1 / m), T_d=T_d, K_f=nominal.K_f)
    return TunedAxis(with_belief(axis, friction, plant), friction, plant, before, found, full, True, tuple(warnings))


def stages(axes: int) -> int:
    """Return how often `tune_axis` tells that it is a step further, for so many axes."""
    return 3 * axes


def with_belief(axis: Axis, friction: GMS, plant: Plant) -> Axis:
    """Return an axis whose controller believes a friction and a plant: feedforward with lead, and observer."""
    models = {**axis.believed.models, "static": friction.static, "gms": friction}
    observer = None if axis.observer is None else replace(axis.observer, A=plant.A, B=plant.B)
    return replace(axis, believed=Believed(models, 1.0, "auto"), nominal=plant, observer=observer)


def _again(found: Fitted, K_f: float) -> Fitted:
    """Return the fit along the motion that the first fit tells more finely."""
    coordinates = found.balance.coordinates
    model, T_d = coordinates.friction(found.x), coordinates.delay(found.x)
    m, a = (float(value) for value in found.plant[:2])
    if not m > 0:
        return found
    records: tuple[VoltageRecord, ...] = tuple(
        refined(record, model, T_d, (m, a, float(found.plant[2 + n])), K_f)
        for n, record in enumerate(found.balance.records)
    )
    return fit(replace(found.balance, records=records), [found.x], found.rms)
