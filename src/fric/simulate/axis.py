"""One axis in closed loop along a reference."""

from dataclasses import dataclass

import numpy as np

from fric.arrays import Real
from fric.control.feedforward import friction_feedforward, inverse_model
from fric.control.scheme import NONE, Scheme
from fric.errors import FricError
from fric.kernels.block import Commands
from fric.kernels.loop import Block, Board, closed_loop
from fric.kernels.plant import PlantConstants, velocity_tolerance
from fric.kernels.signatures import Step
from fric.reference import Reference
from fric.simulate.blocks import blocks_of, jointly_designed, setting_of
from fric.simulate.machine import Axis
from fric.simulate.reality.motion import sensing_of, true_axis
from fric.simulate.stability import require_stable
from fric.threads import one_blas_thread


@dataclass(frozen=True)
class Trace:
    """What a run of one axis recorded, one value a controller sample.

    Parameters
    ----------
    time
        Sample instants [s], shape (n,).
    reference, position, measured
        Position asked for, true, and as the encoder tells it [m], shape (n,).
    velocity
        True velocity [m/s], shape (n,).
    input
        Control voltage [V], shape (n,).
    friction
        True friction force [N], shape (n,).
    feedforward
        Friction feedforward [V], shape (n,).
    disturbance
        The observers' estimate d̂ [V], shape (n,).
    saturated
        Samples at which the voltage was limited.
    sensed
        True position of what the encoder is on [m], shape (n,); None where that is `position`.
    """

    time: Real
    reference: Real
    position: Real
    measured: Real
    velocity: Real
    input: Real
    friction: Real
    feedforward: Real
    disturbance: Real
    saturated: int
    sensed: Real | None = None


@one_blas_thread()
def run_axis(
    axis: Axis,
    reference: Reference,
    scheme: Scheme = NONE,
    *,
    excitation: Real | None = None,
    against: Real | None = None,
    halvings: int = 0,
    accuracy: float = 0.0,
    began: float = 0.0,
) -> Trace:
    """Return the traces of one axis that starts at rest and follows a reference in closed loop.

    Parameters
    ----------
    axis
        The axis; the reference must be sampled at its controller's rate.
    reference
        What is asked of it.
    scheme
        The scheme.
    excitation
        Voltage added to the control voltage [V], shape (n,).
    against
        Voltage fed forward against friction in place of what the scheme's model gives [V], shape (n,).
    halvings
        How often every step of the plant is halved, to see that this changes nothing.
    accuracy
        By how much the integration of the plant may move the position [m]; 0 for the last digits.
    began
        Time since the machine was switched on, for what drifts [s].

    Raises
    ------
    FricError
        When the scheme asks for a model or a block that the axis does not have, or the loop is not stable.
    """
    arguments = _loop_arguments(axis, reference, scheme, excitation, accuracy, began)
    if against is not None:
        commands = arguments[-1]._replace(friction=np.ascontiguousarray(against, float))
        arguments = (*arguments[:-1], commands)
    traces, saturated = closed_loop(*arguments, halvings, sensing_of(axis))
    return Trace(time=reference.time, reference=reference.position, saturated=saturated, **traces._asdict())


def _loop_arguments(
    axis: Axis,
    reference: Reference,
    scheme: Scheme,
    excitation: Real | None = None,
    accuracy: float = 0.0,
    began: float = 0.0,
) -> tuple[Step, Real, Real, PlantConstants, Board, list[Block], Commands]:
    """Check what is asked of an axis, and return it as the compiled loop reads it."""
    axis = jointly_designed(axis, scheme, reference)
    plant, cascade = axis.plant, axis.cascade
    if reference.sampling != cascade.sampling:
        raise FricError(
            f"the reference is sampled at {reference.sampling:g} Hz, "
            f"the controller of axis {axis.name} at {cascade.sampling:g} Hz"
        )
    setting = setting_of(axis, scheme, reference)
    controller, *others = blocks_of(axis, scheme, setting)
    require_stable(axis, setting, controller, others)
    step, state, parameters, constants = true_axis(axis, float(reference.position[0]), began)
    ahead = reference.ahead(setting.lead)
    model = inverse_model(setting.plant, ahead)
    tolerance = velocity_tolerance(accuracy, cascade.K_v * cascade.K_p * plant.B, cascade.T_s)
    against = np.zeros(len(reference))
    if setting.friction is not None:
        against = friction_feedforward(setting.friction, ahead, setting.K_f, setting.gain)
    return (
        step,
        state,
        parameters,
        constants._replace(tolerance=max(constants.tolerance, tolerance)),
        Board(cascade.T_s, cascade.limit, axis.encoder.resolution),
        [block.ready(setting) for block in (controller, *others)],
        Commands(
            reference.position, reference.velocity, reference.acceleration,
            model if excitation is None else model + excitation, against, ahead.position, ahead.velocity,
        ),
    )  # fmt: skip
