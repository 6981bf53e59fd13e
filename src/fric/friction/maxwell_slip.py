"""The Maxwell-slip model: Coulomb blocks on springs, side by side, without a Stribeck curve (Iwan 1966)."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numba import types

from fric.arrays import Real
from fric.errors import FricError
from fric.friction.base import FrictionModel, Parameter, Property
from fric.kernels.increments import reversal
from fric.kernels.signatures import Step, compiled, compiled_step

_FLOAT, _ARRAY = types.float64, types.float64[::1]


@compiled(_FLOAT(_FLOAT, _ARRAY, _ARRAY), makes_arrays=False)
def _advance(dz: float, state: Real, parameters: Real) -> float:
    """Advance all blocks by a motion without reversal, and return the sum of their forces; exact."""
    blocks = state.size - 1
    force = 0.0
    for i in range(blocks):
        W, k = parameters[1 + i], parameters[1 + blocks + i]
        state[1 + i] = min(max(state[1 + i] + k * dz, -W), W)
        force += state[1 + i]
    return force


@compiled_step
def _step(dz: float, v: float, dt: float, state: Real, parameters: Real) -> float:
    before, _ = reversal(state[0], v, dt)
    if before != 0.0:
        _advance(before, state, parameters)
    state[0] = v
    return _advance(dz - before, state, parameters) + parameters[0] * v


@dataclass(frozen=True)
class MaxwellSlip(FrictionModel):
    """N Coulomb blocks on springs, side by side: hysteresis with non-local memory, the same at every speed.

    ``dF_i/dz = k_i`` while ``|F_i| < W_i``, then ``F_i = W_i·sign(v)``, and ``F = Σ F_i + sigma·v``; integrated
    exactly. It is the GMS model without Stribeck curve and frictional lag. (W. D. Iwan, Journal of Applied Mechanics
    33, 1966; for friction: Goldfarb and Celanovic, 1997.)

    W: Force at which each block slips, shape (N,) [N]; their sum is the Coulomb friction.
    k: Each block's stiffness, shape (N,) [N/m].
    sigma: Viscous friction [N·s/m].
    Raises FricError: When a W is negative, a k is not positive, or the lengths differ.
    """

    W: Annotated[
        tuple[float, ...], Parameter("force", doc="force at which the block slips", typical=(60.0, 30.0, 10.0))
    ]
    k: Annotated[tuple[float, ...], Parameter("stiffness", doc="stiffness of the block", typical=(1e8, 2e6, 2e5))]
    sigma: Annotated[float, Parameter("viscous", doc="viscous friction", typical=40.0)] = 0.0

    name: ClassVar[str] = "maxwell_slip"
    properties: ClassVar[frozenset[Property]] = frozenset(
        {"bounded", "passive", "pre-sliding", "non-local memory", "no creep"}
    )
    step: ClassVar[Step] = _step

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.W or len(self.W) != len(self.k):
            hint = "Give one of each for every block."
            raise FricError(f"maxwell_slip has {len(self.W)} W and {len(self.k)} k", hint=hint)
        if not (min(self.W) >= 0 and all(k > 0 for k in self.k)):
            raise FricError("W of maxwell_slip must not be negative, and k must be positive")

    def sliding_force(self, v: Real) -> Real:
        """Return ``Σ W_i·sign(v) + sigma·v`` [N] at velocity v [m/s]."""
        return sum(self.W) * np.sign(v) + self.sigma * v

    def initial_state(self) -> Real:
        """Return ``[v, F_1 … F_N]`` at rest."""
        return np.zeros(1 + len(self.W))
