"""Replay of a friction model along a given motion."""

import numpy as np
from numba import types

from fric.arrays import Real
from fric.kernels.signatures import STEP_FUNCTION, Step, compiled

_ARRAY = types.float64[::1]


@compiled(types.void(STEP_FUNCTION, _ARRAY, _ARRAY, _ARRAY, _ARRAY, _ARRAY, _ARRAY), makes_arrays=False)
def _replay(step: Step, position: Real, velocity: Real, time: Real, state: Real, parameters: Real, force: Real) -> None:
    force[0] = step(0.0, velocity[0], 0.0, state, parameters)
    for n in range(1, position.size):
        force[n] = step(position[n] - position[n - 1], velocity[n], time[n] - time[n - 1], state, parameters)


def replay(step: Step, position: Real, velocity: Real, time: Real, state: Real, parameters: Real) -> Real:
    """Return the friction force [N], shape (n,), of a model moved along a motion.

    Parameters
    ----------
    step
        The model's compiled step.
    position, velocity, time
        The motion [m], [m/s], [s], each of shape (n,).
    state
        The model's state at the first sample; changed in place to that at the last.
    parameters
        The model's parameters as it packs them.
    """
    force = np.empty_like(position)
    _replay(step, position, velocity, time, state, parameters, force)
    return force
