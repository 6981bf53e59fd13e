"""Friction on a real guideway: a step around another model's, with a level by place, direction, rest and time."""

from typing import NamedTuple

import numpy as np
from numba import types

from fric.arrays import Real
from fric.kernels.elementary import exp, expm1, log, sin
from fric.kernels.inner import step_at
from fric.kernels.signatures import compiled, compiled_step

AHEAD = 3  # State before that of the inner model: position [m], time [s], age of the contact [s]


class Guideway(NamedTuple):
    """The head of the parameters; behind it cogging and waves, three each, and the inner model's parameters."""

    inner: float  # address of the inner model's step
    maps: float  # static maps among the inner model's parameters
    first: float  # where the first of them begins
    second: float  # and the second
    level: float  # F_c and F_s of the negative direction over those of the positive direction
    viscous: float  # and sigma
    growth: float  # of F_s for each factor e of the age
    ageing: float  # s, age from which it counts
    distance: float  # m, sliding that renews the contact
    drift: float  # final level, less 1
    warming: float  # s, time constant of that
    coggings: float  # waves of force
    waves: float  # waves of the level


HEAD = len(Guideway._fields)
(
    _INNER, _MAPS, _FIRST, _SECOND, _LEVEL, _VISCOUS, _GROWTH, _AGEING, _DISTANCE, _DRIFT, _WARMING, _COGGINGS, _WAVES
) = range(HEAD)  # fmt: skip


@compiled(types.float64(*[types.float64] * 4), makes_arrays=False)
def aged(age: float, travel: float, dt: float, distance: float) -> float:
    """Return the age of a contact [s] after a travel [m] in a time [s], exact at even speed.

    ``dθ/dt = 1 - θ·|v|/distance``, the ageing law of rate-and-state friction.
    """
    x = travel / distance
    renewed = -expm1(-x)
    return age * exp(-x) + dt * (renewed / x if x > 1e-9 else 1.0 - 0.5 * x)


@compiled_step
def guideway_step(dz: float, v: float, dt: float, state: Real, parameters: Real) -> float:
    """Advance the inner model with the parameters as they hold at this place, in this direction, at this time."""
    coggings, waves = int(parameters[_COGGINGS]), int(parameters[_WAVES])
    start = HEAD + 3 * (coggings + waves)
    size = parameters.size - start
    state[0] += dz
    state[1] += dt
    z, cogging, level, viscous = state[0], 0.0, 1.0, 1.0
    for i in range(coggings):
        at = HEAD + 3 * i
        cogging += parameters[at] * sin(2.0 * np.pi * z / parameters[at + 1] + parameters[at + 2])
    for i in range(coggings, coggings + waves):
        at = HEAD + 3 * i
        level += parameters[at] * sin(2.0 * np.pi * z / parameters[at + 1] + parameters[at + 2])
    level *= 1.0 - parameters[_DRIFT] * expm1(-state[1] / parameters[_WARMING])
    if dz < 0.0 or (dz == 0.0 and v < 0.0):
        level *= parameters[_LEVEL]
        viscous = parameters[_VISCOUS]
    static = level
    if parameters[_GROWTH] > 0.0:
        state[2] = aged(state[2], abs(dz), dt, parameters[_DISTANCE])
        static *= 1.0 + parameters[_GROWTH] * log(1.0 + state[2] / parameters[_AGEING])
    here = state[AHEAD : AHEAD + size]
    for i in range(size):
        here[i] = parameters[start + i]
    for i in range(int(parameters[_MAPS])):
        at = int(parameters[_FIRST + i])
        here[at] *= level
        here[at + 1] *= static
        here[at + 4] *= viscous
    inner = step_at(parameters[_INNER])
    force: float = inner(dz, v, dt, state[AHEAD + size :], here) + cogging
    return force
