"""The one signature that every compiled friction step has.

A step is compiled with this explicit signature and handed to the loops as a first-class function: a loop is
compiled once for all models, starts warm from the cache in a new process, and sees an edit of a model.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

STEP = types.float64(types.float64, types.float64, types.float64, types.float64[::1], types.float64[::1])
"""``force = step(dz, v, dt, state, parameters)``: advance by one increment, change ``state``, return the force.

dz [m] is the position increment of the step, v [m/s] the velocity at its end, dt [s] its length; ``state`` and
``parameters`` are as the model lays them out. The force is what friction exerts against the motion, positive
for v > 0."""

STEP_FUNCTION = types.FunctionType(STEP)

Step = Callable[[float, float, float, NDArray[np.float64], NDArray[np.float64]], float]


Function = TypeVar("Function", bound=Callable[..., object])


def compiled(signature: object) -> Callable[[Function], Function]:
    """Return a decorator that compiles a function with an explicit signature, cached on disk.

    Division by zero gives inf or nan, as in NumPy. There is no fast-math: same input, same output.
    """
    decorate: Callable[[Function], Function] = numba.njit(signature, cache=True, error_model="numpy")  # type: ignore[assignment]
    return decorate


def compiled_step(function: Step) -> Step:
    """Compile a friction step with the signature `STEP`, cached on disk."""
    return compiled(STEP)(function)
