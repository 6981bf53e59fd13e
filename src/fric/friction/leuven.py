"""The Leuven model in its integrated form: slip blocks behind a sliding surface (Lampaert, Swevers, Al-Bender 2002)."""

from dataclasses import dataclass
from math import copysign
from typing import Annotated, ClassVar

import numpy as np
from numba import types

from fric.arrays import Real
from fric.friction.base import Parameter, Property
from fric.friction.stribeck import OnBlocks, stribeck_level
from fric.kernels.elementary import expm1, log1p, power
from fric.kernels.increments import reversal
from fric.kernels.signatures import Step, compiled, compiled_step

_FLOAT, _ARRAY = types.float64, types.float64[::1]
FINEST = 0.02  # Change of F_h/s in one substep; a step that changes it by less is taken whole


@compiled(_FLOAT(_FLOAT, _ARRAY, _ARRAY), makes_arrays=False)
def _move(dz: float, state: Real, parameters: Real) -> float:
    """Move the blocks by dz, and return the sum of their forces."""
    F_s, blocks = parameters[1], state.size - 2
    force = 0.0
    for i in range(blocks):
        W = parameters[7 + i] * F_s
        state[2 + i] = min(max(state[2 + i] + parameters[7 + blocks + i] * dz, -W), W)
        force += state[2 + i]
    return force


@compiled(_FLOAT(_FLOAT, _FLOAT, _ARRAY, _ARRAY), makes_arrays=False)
def _advance(dx: float, s: float, state: Real, parameters: Real) -> float:
    """Advance the hysteresis by a motion dx without reversal at a level s, and return its force.

    ``dz/dx = 1 - sign(r)·|r|^n`` with ``r = F_h·sign(dx)/s``. Between two breaks of a block this is one equation in r,
    and each substep solves it linearised about its start (exponential Euler: second order, stable for any stiffness).
    A substep does not cross r = 1, where what moves the blocks vanishes.
    """
    F_s, n, blocks = parameters[1], parameters[6], state.size - 2
    direction, left = copysign(1.0, dx), abs(dx)
    force = _move(0.0, state, parameters)
    while left > 0.0:
        r = direction * force / s
        steep = power(abs(r), n - 1.0)
        rate = 1.0 - steep * r  # dz/d|x|
        if abs(1.0 - r) < 1e-12:
            break
        towards = direction * copysign(1.0, rate)
        K, slips = 0.0, np.inf  # the stiffness of the blocks that stick, and the travel until the next block slips
        for i in range(blocks):
            k, room = parameters[7 + blocks + i], parameters[7 + i] * F_s - towards * state[2 + i]
            if room > 1e-12 * F_s:
                K += k
                slips = min(slips, room / k)
        if K == 0.0:
            break
        decay = n * steep * K / s  # the rate falls as exp(-decay·|x|)
        dz = abs(rate) * (left if decay * left < 1e-9 else -expm1(-decay * left) / decay)
        bound = min(FINEST * s / K, slips)
        if r > 0.0:
            bound = min(bound, abs(1.0 - r) * s / K)
        if dz <= bound:
            left = 0.0
        else:
            dz, x = bound, decay * bound / abs(rate)
            left -= dz / abs(rate) if x < 1e-9 else -log1p(-x) / decay
        force = _move(towards * dz, state, parameters)
    return force


@compiled_step
def _step(dz: float, v: float, dt: float, state: Real, parameters: Real) -> float:
    F_c, F_s, v_s, delta, sigma = parameters[0], parameters[1], parameters[2], parameters[3], parameters[4]
    sigma_1, n = parameters[5], parameters[6]
    s_0, s = stribeck_level(state[0], F_c, F_s, v_s, delta), stribeck_level(v, F_c, F_s, v_s, delta)
    before, _ = reversal(state[0], v, dt)
    if before != 0.0:
        _advance(before, 0.5 * (s_0 + F_s), state, parameters)
        s_0 = F_s
    force = _advance(dz - before, 0.5 * (s_0 + s), state, parameters)
    state[0], state[1] = v, force
    r = force / s
    return force + sigma_1 * (v - abs(v) * copysign(power(abs(r), n), r)) + sigma * v


@dataclass(frozen=True)
class Leuven(OnBlocks):
    """The Leuven model, integrated form: Maxwell-slip hysteresis in a state z that follows the motion x.

    ====== ======================================================================
    state  ``dz/dt = v·(1 - sign(r)·|r|^n)`` with ``r = F_h(z)/s(v)``
    force  ``F = F_h(z) + sigma_1·dz/dt + sigma·v``
    blocks ``dF_i/dz = k_i`` while ``|F_i| < alpha_i·F_s``, and ``F_h = Σ F_i``
    ====== ======================================================================

    where s(v) is the Stribeck curve of eq. (2) with the sign of v. These are the two changes of Lampaert, Swevers and
    Al-Bender (IEEE TAC 47, 2002) to the model of Swevers, Al-Bender, Ganseman and Prajogo (IEEE TAC 45, 2000): the
    hysteresis force itself is in r, so that F is continuous, and it is made of slip blocks instead of a stack of
    reversals.

    F_h has non-local memory in z exactly, and in x as far as z follows x: below break-away the two part by the share
    ``|r|^n``, so that minor loops close, and a vibrating load does not creep, the better the larger n is and the
    further the load is from break-away. The level is that of the middle of a step. Only without
    sigma_1 is it passive, as LuGre.

    static: The static map: F_c, F_s, v_s, delta, sigma.
    alpha: Each block's share of F_s, shape (N,), Σ alpha = 1 [1].
    k: Each block's stiffness, shape (N,) [N/m].
    sigma_1: Damping of the asperities [N·s/m].
    n: How sharp the transition to sliding is [1].
    Raises FricError: When alpha is negative or does not sum to 1, when k is not positive, or the lengths differ.
    """

    sigma_1: Annotated[float, Parameter("viscous", doc="damping of the asperities", typical=1e3)] = 0.0
    n: Annotated[float, Parameter("ratio", lower=1.0, upper=100.0, doc="sharpness of the transition to sliding")] = 20.0

    name: ClassVar[str] = "leuven"
    properties: ClassVar[frozenset[Property]] = frozenset({"pre-sliding", "frictional lag"})
    step: ClassVar[Step] = _step

    def initial_state(self) -> Real:
        """Return ``[v, F_h, F_1 … F_N]`` at rest."""
        return np.zeros(2 + len(self.alpha))
