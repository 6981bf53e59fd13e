"""Friction whose two directions differ: a step around another model's, with parameters for either direction."""

from fric.arrays import Real
from fric.kernels.inner import step_at
from fric.kernels.signatures import compiled_step


@compiled_step
def directed_step(dz: float, v: float, dt: float, state: Real, parameters: Real) -> float:
    """Advance the inner model with the parameters of this direction.

    ``parameters`` is the address of the inner step, its parameters for the positive direction, and as many for the
    negative one; ``state`` is the inner model's.
    """
    own = (parameters.size - 1) // 2
    inner = step_at(parameters[0])
    if dz < 0.0 or (dz == 0.0 and v < 0.0):
        force: float = inner(dz, v, dt, state, parameters[1 + own :])
    else:
        force = inner(dz, v, dt, state, parameters[1 : 1 + own])
    return force
