"""The generalized Maxwell-slip (GMS) model, eqs. (3) to (5) of the paper."""

from dataclasses import dataclass
from math import copysign
from typing import Annotated, ClassVar, NamedTuple

import numpy as np
from numba import types

from fric.arrays import Real
from fric.friction.base import Parameter, Property
from fric.friction.stribeck import OnBlocks, stribeck_level
from fric.kernels.increments import relax, reversal, shares
from fric.kernels.signatures import Step, compiled, compiled_step
from fric.verb import require_within


class _Course(NamedTuple):
    """A motion without reversal, over which speed and Stribeck level go linearly in time."""

    travel: float  # m
    dt: float  # s
    v_0: float  # m/s, without sign
    v_1: float
    s_0: float  # N
    s_1: float


_FLOAT, _ARRAY = types.float64, types.float64[::1]
_COURSE = types.NamedUniTuple(_FLOAT, len(_Course._fields), _Course)  # type: ignore[no-untyped-call]

_EDGE = 1e-5
"""Share of its break-away within which a block slips where that moves away: a block that comes back to just where it
broke away, as along counts, would else slip or stick by the last digit; where s(v) rises the two are far apart."""


@compiled(_FLOAT(*[_FLOAT] * 6, _COURSE), makes_arrays=False)
def _slipped(u: float, alpha: float, k: float, C: float, left: float, pull: float, course: _Course) -> float:
    """Return the load u of a slipping block after a course: ``du/dt = min(C·(alpha - u/s), k·|v|)``.

    It is split where the other rate is the smaller; ``left`` and ``pull`` are the relaxation over the whole course.
    """
    relaxed, stretched = left * u + alpha * pull, u + k * course.travel
    load = min(relaxed, stretched)
    excess_0 = C * (alpha * course.s_0 - u) - k * course.v_0 * course.s_0  # of relaxation over stretching, times s
    reached = stretched if excess_0 > 0.0 else relaxed
    excess_1 = C * (alpha * course.s_1 - reached) - k * course.v_1 * course.s_1
    if (excess_0 > 0.0) != (excess_1 > 0.0):
        x = excess_0 / (excess_0 - excess_1)
        v_x, s_x = (1.0 - x) * course.v_0 + x * course.v_1, (1.0 - x) * course.s_0 + x * course.s_1
        loads = excess_0 > 0.0  # it is stretched first, and then relaxes
        share = 1.0 - x if loads else x
        elongation = 0.5 * k * ((course.v_0 if loads else course.v_1) + v_x) * (1.0 - share) * course.dt
        left, pull = relax(s_x if loads else course.s_0, course.s_1 if loads else s_x, C, share * course.dt)
        end = left * (u + elongation if loads else u) + alpha * pull
        load = min(load, end if loads else end + elongation)
    return load


@compiled(types.void(_FLOAT, _COURSE, _ARRAY, _ARRAY), makes_arrays=False)
def _advance(direction: float, course: _Course, state: Real, parameters: Real) -> None:
    """Advance all blocks by a course in a direction."""
    C, blocks = parameters[5], (parameters.size - 6) // 2
    left, pull = relax(course.s_0, course.s_1, C, course.dt)
    s_high, vs_low = max(course.s_0, course.s_1), min(course.v_0 * course.s_0, course.v_1 * course.s_1)
    for i in range(blocks):
        alpha, k = parameters[6 + i], parameters[6 + blocks + i]
        u = direction * state[2 + i]
        stretched = u + k * course.travel
        if state[2 + blocks + i] == direction:
            relaxed = left * u + alpha * pull
            if C * (alpha * s_high - min(u, relaxed)) < k * vs_low:  # the usual case, for speed: it is never stretched
                u = min(relaxed, stretched)
            else:
                u = _slipped(u, alpha, k, C, left, pull, course)
        elif course.travel > 0.0:
            before, after = alpha * course.s_0 - u, alpha * course.s_1 - stretched
            if after > 0.0 and before > min(_EDGE * alpha * course.s_0, after):
                u = stretched
                state[2 + blocks + i] = 0.0
            else:
                if before > 0.0 and after <= 0.0:  # it breaks away inside the course, where its load meets alpha·s
                    x, s_1 = before / (before - after), course.s_1
                    rest, s_x = (1.0 - x) * course.dt, (1.0 - x) * course.s_0 + x * s_1
                    left_x, mean = shares(s_x, s_1, C, rest)
                    u = alpha * (s_1 + mean * (s_x - s_1))  # relaxed from alpha·s
                    if C * (alpha * s_1 - u) > k * course.v_1 * s_1:
                        v_x = (1.0 - x) * course.v_0 + x * course.v_1
                        pull_x = (mean - left_x) * s_x + (1.0 - mean) * s_1
                        then = _Course(0.5 * (v_x + course.v_1) * rest, rest, v_x, course.v_1, s_x, s_1)
                        u = _slipped(alpha * s_x, alpha, k, C, left_x, pull_x, then)
                    u = min(u, stretched)
                else:
                    u = _slipped(u, alpha, k, C, left, pull, course)
                state[2 + blocks + i] = direction
        state[2 + i] = direction * u


@compiled_step
def _step(dz: float, v: float, dt: float, state: Real, parameters: Real) -> float:
    F_c, F_s, v_s, delta, sigma = parameters[0], parameters[1], parameters[2], parameters[3], parameters[4]
    blocks = (parameters.size - 6) // 2
    v_0, s_0 = state[0], state[1]
    s_1 = stribeck_level(v, F_c, F_s, v_s, delta)
    overshoot, before = reversal(v_0, v, dt)
    if before > 0.0:
        until_turn = _Course(abs(overshoot), before, abs(v_0), 0.0, s_0, F_s)
        _advance(copysign(1.0, v_0), until_turn, state, parameters)
        dz, dt, v_0, s_0 = dz - overshoot, dt - before, 0.0, F_s
    if dz != 0.0 or v != 0.0:
        course = _Course(abs(dz), dt, abs(v_0), abs(v), s_0, s_1)
        _advance(copysign(1.0, dz if dz != 0.0 else v), course, state, parameters)
    state[0], state[1] = v, s_1
    force = sigma * v
    for i in range(blocks):
        force += state[2 + i]
        if v == 0.0:
            state[2 + blocks + i] = 0.0
    return force


@dataclass(frozen=True)
class GMS(OnBlocks):
    """The generalized Maxwell-slip model: N blocks on springs, dragged side by side, eqs. (3) to (5) with one limit.

    ===== =============================================================== =========================================
    stick ``dF_i/dt = k_i·v``                                             until ``F_i`` reaches ``alpha_i·s(v)``
    slip  ``du_i/dt = min{C·(alpha_i - u_i/|s(v)|), k_i·|v|}``            until the motion reverses or stops
    ===== =============================================================== =========================================

    and ``F = Σ F_i + sigma·v``, where s(v) is the Stribeck curve of eq. (2) with the sign of v, and u_i the load of a
    block in the direction of motion, ``F_i·sign(v)``.

    The limit ``k_i·|v|`` is ours: a block that slips never loads faster than its spring is stretched. Eq. (4) as
    printed has ``C·(alpha_i - u_i/|s(v)|)`` alone. Where s(v) rises while the motion all but stops, that loads springs
    by time, without work from outside, and a fast cycle with waits at its ends gives energy back. With the limit the
    model is passive. Of the springs' energy ``E = Σ F_i²/(2·k_i)`` there is at any time

    ``F·v - dE/dt = Σ u_i·(|v| - (du_i/dt)/k_i) + sigma·v² ≥ 0``

    since the bracket is 0 in stick, and in slip both it and u_i are at least 0. A step holds this exactly, for any
    increments and velocities: ``u·|dz| ≥ u·(u - u_0)/k ≥ (u² - u_0²)/(2·k)`` with u the load at its end.

    The springs are driven by position increments, and the sign of an increment is the direction of motion; the
    velocity enters s(v), the viscous part, and where inside a step the motion reverses. So an encoder that flickers by
    one count makes a small elastic excursion, and the force does not drift. A step is split where the motion reverses,
    where a block breaks away, and where the limit sets in or ends; slip is integrated to second order in the step.

    static: The static map: F_c, F_s, v_s, delta, sigma.
    alpha: Each block's share of s(v), shape (N,), Σ alpha = 1 [1].
    k: Each block's stiffness, shape (N,) [N/m].
    C: Attraction parameter: how fast a slipping block follows s(v) [N/s].
    Raises FricError: When alpha is negative or does not sum to 1, when k or C is not positive, or the lengths differ.
    """

    C: Annotated[float, Parameter("force rate", doc="attraction parameter")] = 1e4

    name: ClassVar[str] = "gms"
    properties: ClassVar[frozenset[Property]] = frozenset(
        {"bounded", "passive", "pre-sliding", "non-local memory", "no creep", "frictional lag"}
    )
    step: ClassVar[Step] = _step

    def __post_init__(self) -> None:
        super().__post_init__()
        require_within(self, "gms", C="(0, inf)")

    def initial_state(self) -> Real:
        """Return ``[v, |s(v)|, F_1 … F_N, phase_1 … phase_N]`` at rest.

        v and s are those at the last sample; a phase is 0 where the block sticks, and else the direction of its slip.
        """
        return np.array([0.0, self.static.F_s, *np.zeros(2 * len(self.alpha))])
