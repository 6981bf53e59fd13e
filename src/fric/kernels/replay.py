"""Replay of a friction model along a given motion."""

import numpy as np
from numba import types

from fric.arrays import Real
from fric.kernels.signatures import ARRAY, STEP_FUNCTION, TABLE, Step, compiled


@compiled(types.void(STEP_FUNCTION, ARRAY, ARRAY, ARRAY, ARRAY, ARRAY, ARRAY), makes_arrays=False)
def _replay(step: Step, position: Real, velocity: Real, time: Real, state: Real, parameters: Real, force: Real) -> None:
    force[0] = step(0.0, velocity[0], 0.0, state, parameters)
    for n in range(1, position.size):
        force[n] = step(position[n] - position[n - 1], velocity[n], time[n] - time[n - 1], state, parameters)


@compiled(types.void(STEP_FUNCTION, ARRAY, ARRAY, ARRAY, ARRAY, ARRAY, TABLE), makes_arrays=False)
def _loads(step: Step, position: Real, velocity: Real, time: Real, state: Real, parameters: Real, loads: Real) -> None:
    for n in range(position.size):
        last = n - 1 if n else 0
        step(position[n] - position[last], velocity[n], time[n] - time[last], state, parameters)
        for i in range(loads.shape[1]):
            loads[n, i] = state[2 + i]


def replay_loads(
    step: Step, position: Real, velocity: Real, time: Real, state: Real, parameters: Real, count: int
) -> Real:
    """Return the loads of ``count`` blocks [N], shape (n, count), which follow the first two numbers of a state.

    The arguments are as in `replay`.
    """
    loads = np.empty((len(position), count))
    _loads(step, position, velocity, time, state, parameters, loads)
    return loads


def replay(step: Step, position: Real, velocity: Real, time: Real, state: Real, parameters: Real) -> Real:
    """Return the friction force [N], shape (n,), of a model moved along a motion.

    step: The model's compiled step.
    position, velocity, time: The motion [m], [m/s], [s], each of shape (n,).
    state: The model's state at the first sample; changed in place to that at the last.
    parameters: The model's parameters as it packs them.
    """
    force = np.empty_like(position)
    _replay(step, position, velocity, time, state, parameters, force)
    return force
