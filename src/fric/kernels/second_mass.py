"""A table on a spring behind the motor, as the friction of the motor's mass: a step around the table's friction.

::

    motor ──[ spring, damper, play ]── table ──> friction, load
      z ───────── elongation ───────── z - elongation

The integration of the plant sees the force of the spring as friction of one mass, and holds its error as that of any
friction; the table is part of the state.
"""

from typing import NamedTuple

from numba import types

from fric.arrays import Real
from fric.kernels.inner import step_at
from fric.kernels.signatures import compiled, compiled_step

AHEAD = 4  # State before the inner model's: elongation [m], velocity of the table [m/s], forces of spring and friction
ELONGATION, VELOCITY, SPRING, FRICTION = range(AHEAD)


class Coupling(NamedTuple):
    """The head of the parameters, before those of the inner model."""

    inner: float  # address of the inner model's step
    mass: float  # kg, of the table
    stiffness: float  # N/m
    damping: float  # N·s/m
    play: float  # m, from the middle to a flank
    load: float  # N, on the table
    on_table: float  # 1 where the friction acts on the table, 0 where on the motor


HEAD = len(Coupling._fields)
_INNER, _MASS, _STIFFNESS, _DAMPING, _PLAY, _LOAD, _ON_TABLE = range(HEAD)
_COUPLING = types.float64(types.float64, types.float64, types.float64[::1])


@compiled(_COUPLING, makes_arrays=False)
def spring_force(elongation: float, rate: float, parameters: Real) -> float:
    """Return the force [N] of the spring at an elongation [m] and its rate [m/s]; inside the play it has none."""
    play, beyond = parameters[_PLAY], 0.0
    if elongation > play:
        beyond = elongation - play
    elif elongation < -play:
        beyond = elongation + play
    elif play > 0.0:
        return 0.0
    force = parameters[_STIFFNESS] * beyond + parameters[_DAMPING] * rate
    if play > 0.0 and force * beyond < 0.0:  # a flank pushes, and does not pull
        return 0.0
    return force


@compiled_step
def second_mass_step(dz: float, v: float, dt: float, state: Real, parameters: Real) -> float:
    """Advance the table along a motion of the motor (Heun's method) and return what acts on the motor against it."""
    inner, behind, rest = step_at(parameters[_INNER]), state[AHEAD:], parameters[HEAD:]
    table = parameters[_ON_TABLE] > 0.0
    force = 0.0 if table else inner(dz, v, dt, behind, rest)
    if dt == 0.0:
        state[VELOCITY] = v
        state[FRICTION] = inner(0.0, v, 0.0, behind, rest) if table else 0.0
        state[SPRING] = spring_force(state[ELONGATION], 0.0, parameters)
        return force + state[SPRING]
    mass, load, before = parameters[_MASS], parameters[_LOAD], state[VELOCITY]
    pulled = (state[SPRING] - state[FRICTION] - load) / mass
    ahead = before + dt * pulled
    travel = 0.5 * dt * (before + ahead)
    if table:
        state[FRICTION] = inner(travel, ahead, dt, behind, rest)
    state[ELONGATION] += dz - travel
    state[SPRING] = spring_force(state[ELONGATION], v - ahead, parameters)
    state[VELOCITY] = before + 0.5 * dt * (pulled + (state[SPRING] - state[FRICTION] - load) / mass)
    return force + state[SPRING]
