"""Friction with the residual of a measured circle: a step around another model's step, and a force over the travel."""

from typing import NamedTuple

import numpy as np
from numba import types

from fric.arrays import Real
from fric.kernels.elementary import exp, log
from fric.kernels.inner import step_at
from fric.kernels.signatures import compiled, compiled_step

DIRECTION, TRAVEL, BACK = range(3)
AHEAD = 3  # State before the inner model's: direction of motion, travel in it, and the travel back from its end [m]


class TravelGrid(NamedTuple):
    """The head of the parameters; behind it the force forwards and backwards, and the inner model's parameters."""

    inner: float  # address of the inner model's step
    points: float  # of the travel, for either direction
    play: float  # m, travel back that makes a reversal; the first point
    knee: float  # index up to which the distance of the points equals their distance from 0
    ratio: float  # logarithm of the ratio of two of these
    step: float  # m, distance of those behind


HEAD = len(TravelGrid._fields)
_INNER, _POINTS, _PLAY, _KNEE, _RATIO, _STEP = range(HEAD)


@compiled(types.void(types.float64, types.float64, types.float64[::1]), makes_arrays=False)
def travelled(dz: float, play: float, state: Real) -> None:
    """Advance direction, travel and travel back by a displacement [m]; less than the play is no reversal."""
    if state[DIRECTION] == 0.0 and dz != 0.0:
        state[DIRECTION] = 1.0 if dz > 0.0 else -1.0
    ahead = state[DIRECTION] * dz
    if ahead > 0.0:
        taken = min(ahead, state[BACK])
        state[BACK] -= taken
        state[TRAVEL] += ahead - taken
    else:
        state[BACK] -= ahead
        if state[BACK] > play:
            state[DIRECTION], state[TRAVEL], state[BACK] = -state[DIRECTION], state[BACK], 0.0


@compiled(types.void(types.float64[::1], types.float64, types.float64[:, ::1]))
def travels_along(position: Real, play: float, found: Real) -> None:
    """Enter direction and travel along a motion [m], shape (2, n)."""
    state = np.zeros(AHEAD)
    for n in range(1, len(position)):
        travelled(position[n] - position[n - 1], play, state)
        found[0, n], found[1, n] = state[DIRECTION], state[TRAVEL]


@compiled_step
def left_over_step(dz: float, v: float, dt: float, state: Real, parameters: Real) -> float:
    """Advance the inner model, and add the residual force at this travel since the last reversal, linear in between."""
    travelled(dz, parameters[_PLAY], state)
    n, knee = int(parameters[_POINTS]), parameters[_KNEE]
    play = parameters[_PLAY]
    x = log(max(state[TRAVEL], play) / play) / parameters[_RATIO]
    if x > knee:
        x = knee + (state[TRAVEL] - play * exp(knee * parameters[_RATIO])) / parameters[_STEP]
    at = min(int(x), n - 2)
    share = min(x - at, 1.0)
    at += HEAD + (n if state[DIRECTION] < 0.0 else 0)
    more = 0.0
    if state[DIRECTION] != 0.0:
        more = (1.0 - share) * parameters[at] + share * parameters[at + 1]
    inner = step_at(parameters[_INNER])
    force: float = inner(dz, v, dt, state[AHEAD:], parameters[HEAD + 2 * n :])
    return force + more
