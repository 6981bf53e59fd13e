"""The friction and the masses that an axis truly has, as the compiled loop runs them."""

from math import pi

import numpy as np

from fric.arrays import Real
from fric.errors import FricError
from fric.friction.directed import Directed
from fric.friction.rolling import Rolling
from fric.friction.stribeck import OnStaticMap
from fric.kernels import second_mass
from fric.kernels.guideway import Guideway, guideway_step
from fric.kernels.inner import address_of
from fric.kernels.plant import TOLERANCE, PlantConstants
from fric.kernels.second_mass import Coupling, second_mass_step
from fric.kernels.sensing import Sensing
from fric.kernels.signatures import Step
from fric.simulate.machine import Axis
from fric.simulate.reality.flaws import Direction

SPRING_TOLERANCE = 1e-10  # Of the velocity of a motor on a spring [m/s]: the last digits of the spring take many steps


def true_axis(axis: Axis, place: float, began: float) -> tuple[Step, Real, Real, PlantConstants]:
    """Return the friction that an axis truly has (step, state, parameters), and its masses.

    With a second mass, the stretch of its spring is first in the state.

    place: Where it begins [m], for what depends on the position.
    began: Time since the machine was switched on [s], for what drifts.
    """
    plant, flaws, second = axis.plant, axis.reality, axis.second_mass
    step, state, parameters = type(axis.friction).step, axis.friction.initial_state(), axis.friction.packed()
    delay, set_valued = plant.transport_delay(axis.cascade.sampling), float(state.size == 0)
    if set_valued and (second is not None or flaws.moves_friction):
        hint = "Give it a model with memory, as 'gms'."
        raise FricError(f"the friction of axis {axis.name} has no memory, and its guideway has flaws", hint=hint)
    if flaws.moves_friction:
        inner, step = parameters.size, guideway_step
        parameters = _on_guideway(axis, parameters)
        state = np.array([place, began, 0.0, *np.zeros(inner), *state])
    A, B, M, load = plant.A, plant.B, plant.M, axis.constant_load
    if second is not None:
        if not (motor := M - second.mass) > 0.0:
            hint = "It is a part of that."
            raise FricError(f"the second mass is {second.mass:g} kg, and all that moves {M:g} kg", hint=hint)
        on_table = second.friction == "table"
        coupling = Coupling(
            address_of(step), second.mass, second.stiffness, second.damping, 0.5 * second.backlash,
            load if on_table else 0.0, float(on_table),
        )  # fmt: skip
        step, parameters = second_mass_step, np.array([*coupling, *parameters])
        state = np.array([*np.zeros(second_mass.AHEAD), *state])
        A, B, M, load = A * M / motor, plant.K_f / motor, motor, 0.0 if on_table else load
    drift = (fade.amount, fade.time, began) if (fade := flaws.force_constant) is not None else (0.0, 1.0, 0.0)
    tolerance = SPRING_TOLERANCE if second is not None else TOLERANCE
    return step, state, parameters, PlantConstants(A, B, M, load, delay, set_valued, 0.0, 0.0, tolerance, *drift)


def sensing_of(axis: Axis) -> Sensing:
    """Return the errors of the encoder of an axis, and the place of its counts."""
    error, second, shift = axis.reality.encoder, axis.second_mass, axis.encoder.shift
    spring = 0.0 if second is None else 1.0 if second.encoder == "motor" else 2.0
    if error is None:
        return Sensing(spring=spring, shift=shift)
    return Sensing(error.error, 2 * pi / error.pitch, error.phase, spring, shift)


def _on_guideway(axis: Axis, inner: Real) -> Real:
    friction, flaws = axis.friction, axis.reality
    model = friction.model if isinstance(friction, Directed) else friction
    if isinstance(model, OnStaticMap):
        maps = [1 + 3 * len(model.amplitude) if isinstance(model, Rolling) else 0]
        if friction is not model:  # a map for each direction, behind the address of the step
            maps = [1 + maps[0], 1 + maps[0] + len(model.packed())]
    elif flaws.waves or flaws.dwell or flaws.friction or flaws.direction != Direction():
        what = f"the friction of axis {axis.name} is '{friction.name}', which stands on no static map"
        raise FricError(what, hint="Its level cannot vary; give it a model that does, as 'gms'.")
    else:
        maps = []
    dwell, drift = flaws.dwell, flaws.friction
    head = Guideway(
        address_of(type(friction).step), len(maps), maps[0] if maps else 0, maps[-1] if maps else 0,
        flaws.direction.level, flaws.direction.viscous,
        *((dwell.growth, dwell.time, dwell.distance) if dwell else (0.0, 1.0, 1.0)),
        *((drift.amount, drift.time) if drift else (0.0, 1.0)),
        len(flaws.cogging), len(flaws.waves),
    )  # fmt: skip
    waves = [(wave.force, wave.pitch, wave.phase) for wave in flaws.cogging]
    waves += [(wave.amplitude, wave.pitch, wave.phase) for wave in flaws.waves]
    return np.array([*head, *(number for wave in waves for number in wave), *inner])
