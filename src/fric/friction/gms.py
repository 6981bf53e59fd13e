"""The generalized Maxwell-slip (GMS) model, eqs. (3) to (5) of the paper."""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numba import types

from fric.errors import FricError
from fric.friction.base import Parameter, Property
from fric.friction.blocks import OnBlocks
from fric.friction.stribeck import stribeck_level
from fric.kernels.increments import relax, turn
from fric.kernels.signatures import Step, compiled, compiled_step

if TYPE_CHECKING:
    from numpy.typing import NDArray


_FLOAT, _ARRAY = types.float64, types.float64[::1]


@compiled(types.void(_FLOAT, _FLOAT, _FLOAT, _FLOAT, _FLOAT, _ARRAY, _ARRAY), makes_arrays=False)
def _advance(
    dz: float,
    direction: float,
    dt: float,
    s_0: float,
    s_1: float,
    state: NDArray[np.float64],
    parameters: NDArray[np.float64],
) -> None:
    """Advance all blocks by a motion without reversal, while the level goes linearly from s_0 to s_1."""
    C, blocks = parameters[5], (parameters.size - 6) // 2
    left, pull = relax(s_0, s_1, C, dt)
    for i in range(blocks):
        alpha, k = parameters[6 + i], parameters[6 + blocks + i]
        u = direction * state[2 + i]
        if state[2 + blocks + i] == direction:
            u = left * u + alpha * pull
        elif dz != 0.0:
            stretched = u + k * abs(dz)
            before, after = alpha * s_0 - u, alpha * s_1 - stretched
            if before > 0.0 and after > 0.0:
                u = stretched
                state[2 + blocks + i] = 0.0
            else:
                if before > 0.0:  # it breaks away inside the step, where its load meets alpha·s
                    x = before / (before - after)
                    s_x = s_0 + x * (s_1 - s_0)
                    left_x, pull_x = relax(s_x, s_1, C, (1.0 - x) * dt)
                    u = alpha * (left_x * s_x + pull_x)
                else:
                    u = left * u + alpha * pull
                state[2 + blocks + i] = direction
        state[2 + i] = direction * u


@compiled_step
def _step(dz: float, v: float, dt: float, state: NDArray[np.float64], parameters: NDArray[np.float64]) -> float:
    F_c, F_s, v_s, delta, sigma = parameters[0], parameters[1], parameters[2], parameters[3], parameters[4]
    blocks = (parameters.size - 6) // 2
    v_0, s_0 = state[0], state[1]
    s_1 = stribeck_level(v, F_c, F_s, v_s, delta)
    overshoot, before = turn(v_0, v, dt)
    if before > 0.0:
        _advance(overshoot, copysign(1.0, v_0), before, s_0, F_s, state, parameters)
        dz, dt, s_0 = dz - overshoot, dt - before, F_s
    if dz != 0.0 or v != 0.0:
        _advance(dz, copysign(1.0, dz if dz != 0.0 else v), dt, s_0, s_1, state, parameters)
    state[0], state[1] = v, s_1
    force = sigma * v
    for i in range(blocks):
        force += state[2 + i]
        if v == 0.0:
            state[2 + blocks + i] = 0.0
    return force


@dataclass(frozen=True)
class GMS(OnBlocks):
    """The generalized Maxwell-slip model: N blocks on springs, dragged side by side, eqs. (3) to (5).

    ===== ============================================== =========================================
    stick ``dF_i/dt = k_i·v``                            until ``F_i`` reaches ``alpha_i·s(v)``
    slip  ``dF_i/dt = C·(alpha_i·sign(v) - F_i/|s(v)|)`` until the motion turns or stops
    ===== ============================================== =========================================

    and ``F = Σ F_i + sigma·v``, where s(v) is the Stribeck curve of eq. (2) with the sign of v.

    The springs are driven by position increments, and the sign of an increment is the direction of motion; the
    velocity enters s(v), the viscous part, and where inside a step the motion turns. So an encoder that flickers by
    one count makes a small elastic excursion, and the force does not drift. A step in which the motion turns or a
    block breaks away is split there; slip is integrated to second order in the step (see `relax`).

    Eq. (4) is taken as printed. Where s(v) rises while the motion all but stops, it lets a slipping block load its
    spring by time alone: a cycle of about the length of a slip displacement, fast there and back with a wait of many
    lags s/C at the ends, can give energy back. At a constant level, and on slow cycles, the model is passive.

    Parameters
    ----------
    static
        The static map: F_c, F_s, v_s, delta, sigma.
    alpha
        Each block's share of s(v), shape (N,), Σ alpha = 1 [1].
    k
        Each block's stiffness, shape (N,) [N/m].
    C
        Attraction parameter: how fast a slipping block follows s(v) [N/s].

    Raises
    ------
    FricError
        When alpha is negative or does not sum to 1, when k or C is not positive, or the lengths differ.
    """

    C: float = 1e4

    name: ClassVar[str] = "gms"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        *OnBlocks.block_parameters,
        Parameter("C", "force rate", doc="attraction parameter", typical=1e4),
    )
    properties: ClassVar[frozenset[Property]] = frozenset(
        {"bounded", "pre-sliding", "non-local memory", "no creep", "frictional lag"}
    )
    step: ClassVar[Step] = _step

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.C > 0:
            raise FricError("C of gms must be positive")

    def packed(self) -> NDArray[np.float64]:
        """Return ``[F_c, F_s, v_s, delta, sigma, C, alpha_1 … alpha_N, k_1 … k_N]``."""
        return np.array([*self.static.packed(), self.C, *self.alpha, *self.k])

    def initial_state(self) -> NDArray[np.float64]:
        """Return ``[v, |s(v)|, F_1 … F_N, phase_1 … phase_N]`` at rest.

        v and s are those at the last sample; a phase is 0 where the block sticks, and else the direction of its slip.
        """
        return np.array([0.0, self.static.F_s, *np.zeros(2 * len(self.alpha))])
