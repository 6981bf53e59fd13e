"""One axis in closed loop along a reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fric.compensation.base import NONE, Compensation
from fric.compensation.feedforward import friction_feedforward, inverse_model
from fric.drive.sensing import low_pass_pole
from fric.errors import FricError
from fric.friction import models
from fric.kernels.loop import Commands, ControlConstants, ObserverFilters, closed_loop
from fric.kernels.plant import velocity_tolerance
from fric.simulate.reality.motion import sensing_of, true_axis
from fric.simulate.stability import require_stable
from fric.threads import one_blas_thread

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.kernels.plant import PlantConstants
    from fric.kernels.signatures import Step
    from fric.reference import Reference
    from fric.simulate.machine import Axis


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
        The observer's estimate d̂ [V], shape (n,).
    saturated
        Samples at which the voltage was limited.
    sensed
        True position of what the encoder is on [m], shape (n,); None where that is `position`.
    """

    time: NDArray[np.float64]
    reference: NDArray[np.float64]
    position: NDArray[np.float64]
    measured: NDArray[np.float64]
    velocity: NDArray[np.float64]
    input: NDArray[np.float64]
    friction: NDArray[np.float64]
    feedforward: NDArray[np.float64]
    disturbance: NDArray[np.float64]
    saturated: int
    sensed: NDArray[np.float64] | None = None


@one_blas_thread()
def run_axis(
    axis: Axis,
    reference: Reference,
    compensation: Compensation = NONE,
    *,
    excitation: NDArray[np.float64] | None = None,
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
    compensation
        The scheme.
    excitation
        Voltage added to the control voltage [V], shape (n,).
    halvings
        How often every step of the plant is halved, to see that this changes nothing.
    accuracy
        By how much the integration of the plant may move the position [m]; 0 for the last digits.
    began
        Time since the machine was switched on, for what drifts [s].

    Raises
    ------
    FricError
        When the scheme asks for a model or an observer that the axis does not have, or the loop is not stable.
    """
    feedforward = _feedforward(axis, reference, compensation)
    arguments = _loop_arguments(axis, reference, compensation, feedforward, excitation, accuracy, began)
    traces, saturated = closed_loop(*arguments, halvings, sensing_of(axis))
    return Trace(
        time=reference.time,
        reference=reference.position,
        position=traces.position,
        measured=traces.measured,
        velocity=traces.velocity,
        input=traces.input,
        friction=traces.friction,
        feedforward=feedforward,
        disturbance=traces.disturbance,
        saturated=saturated,
        sensed=traces.sensed,
    )


def _loop_arguments(
    axis: Axis,
    reference: Reference,
    compensation: Compensation,
    feedforward: NDArray[np.float64],
    excitation: NDArray[np.float64] | None = None,
    accuracy: float = 0.0,
    began: float = 0.0,
) -> tuple[Step, NDArray[np.float64], NDArray[np.float64], PlantConstants, ControlConstants, ObserverFilters, Commands]:
    """Check what is asked of an axis, and return it as the compiled loop reads it."""
    plant, cascade = axis.plant, axis.cascade
    if reference.sampling != cascade.sampling:
        raise FricError(
            f"the reference is sampled at {reference.sampling:g} Hz, "
            f"the controller of axis {axis.name} at {cascade.sampling:g} Hz"
        )
    observer = _observer(axis, compensation)
    require_stable(axis, compensation)
    step, state, parameters, constants = true_axis(axis, float(reference.position[0]), began)
    pole, resolution = low_pass_pole(cascade.velocity_filter, cascade.sampling), axis.encoder.resolution
    model = inverse_model(axis.nominal or plant, reference)
    tolerance = velocity_tolerance(accuracy, cascade.K_v * cascade.K_p * plant.B, cascade.T_s)
    return (
        step,
        state,
        parameters,
        constants._replace(tolerance=max(constants.tolerance, tolerance)),
        ControlConstants(cascade.K_v, cascade.K_p, cascade.K_i, pole, cascade.T_s, cascade.limit, resolution),
        observer,
        Commands(
            reference.position, reference.velocity, model if excitation is None else model + excitation, feedforward
        ),
    )


def _feedforward(axis: Axis, reference: Reference, compensation: Compensation) -> NDArray[np.float64]:
    if compensation.friction is None:
        return np.zeros(len(reference))
    believed = axis.believed
    if compensation.friction not in believed.models:
        raise FricError(
            f"scheme {compensation.name} feeds '{compensation.friction}' friction forward, "
            f"and the controller of axis {axis.name} believes in {', '.join(believed.models) or 'none'}",
            mend=f"Identify it: fric identify {compensation.friction}."
            if compensation.friction in models()
            else f"There is no such model; there are {', '.join(models())}.",
        )
    gain = believed.gain if compensation.gain is None else compensation.gain
    K_f = (axis.nominal or axis.plant).K_f
    return friction_feedforward(believed.models[compensation.friction], reference, K_f, gain)


def _observer(axis: Axis, compensation: Compensation) -> ObserverFilters:
    none = np.zeros(0)
    if not compensation.observer:
        return ObserverFilters(none, none, none, none)
    if axis.observer is None:
        raise FricError(
            f"scheme {compensation.name} needs a disturbance observer, and axis {axis.name} has none",
            mend="Add 'observer: {cutoff: 60 Hz}' to the axis.",
        )
    found = axis.observer.discrete(axis.cascade.sampling)
    filters = (found.inverse.b, found.inverse.a, found.low_pass.b, found.low_pass.a)
    return ObserverFilters(*(np.ascontiguousarray(coefficients, float) for coefficients in filters))
