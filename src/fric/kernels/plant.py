"""The plant under a constant input: carriage, linear damping and true friction, integrated until nothing changes.

An encoder makes a closed loop sensitive. Where an error moves the position across the edge of a count, that count
changes, and with it every later count. So the error of the integration is kept to the last digits of the
position: a step of second order is taken in one part, in two, in three … and extrapolated. Where more parts go on
changing the result, the motion has a corner (a block breaks away, the motion reverses, friction stops it), and the step
is halved down to it.

With a tolerance (`velocity_tolerance`), a step in one part is accepted where the change of its force moves the velocity
by less than the tolerance: almost everywhere.

Extrapolation: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, section II.9.
"""

from math import copysign, factorial
from typing import Any, NamedTuple

import numpy as np
from numba import types

from fric.arrays import Real
from fric.kernels.elementary import expm1
from fric.kernels.signatures import ARRAY, STEP_FUNCTION, TABLE, Step, compiled

ORDERS = 6  # Ways in which a step is taken at most: in one part, in two … in six
DEPTH = 16  # How often a step is halved at most
WORK = 400  # Friction steps after which steps are longer again before the input changes: friction nowhere smooth
TOLERANCE = 4e-14  # Largest change of the velocity [m/s, rad/s] with the number of parts, unless less is required
ROUNDING = 1e-14  # The same relative to the velocity: the sum of many roundings
LASTING = 20  # For how many inputs an error of the friction force is taken to push, before the loop holds against it


class PlantConstants(NamedTuple):
    """The plant ``z̈ = B·u(t - delay) - A·ż - (F + load)/M``."""

    A: float  # 1/s
    B: float  # m/(s²·V)
    M: float  # kg
    load: float  # N, constant
    delay: float  # s, the transport delay alone
    set_valued: float  # 1 where the friction has no memory: it holds a body at rest by itself
    ahead: float = 0.0  # m, where the axis begins, from where the reference does
    v_0: float = 0.0  # m/s, velocity that it begins with
    tolerance: float = TOLERANCE  # m/s, largest change of the velocity with the number of parts
    drift: float = 0.0  # final acceleration per volt over the initial, less 1
    warming: float = 1.0  # s, time constant of that
    began: float = 0.0  # s, since it began to


class Instant(NamedTuple):
    """State of the plant without the state of the friction."""

    z: float  # m, since the input changed
    v: float  # m/s
    F: float  # N


def numba_type(group: Any, of: types.Type) -> types.Type:
    """Return the type of a group of constants or of arrays, as the compiler sees it."""
    return types.NamedUniTuple(of, len(group._fields), group)  # type: ignore[no-untyped-call]


PLANT, INSTANT = numba_type(PlantConstants, types.float64), numba_type(Instant, types.float64)


def _weights() -> Real:
    """Return in row k the weights of the results in 1, 2 … k+1 parts that cancel the errors in h², h³ … h^(k+1).

    With ``n = k + 1`` parts at most, that of the result in j parts is the rational number
    ``(-1)^(n-j)·2·j^n/(n·(n + 1)·(j - 1)!·(n - j)!)``, rounded once: the compiler freezes it into its cache.
    """
    weights = np.zeros((ORDERS, ORDERS))
    for k in range(ORDERS):
        n = k + 1
        for j in range(1, n + 1):
            weights[k, j - 1] = (-1) ** (n - j) * 2 * j**n / (n * (n + 1) * factorial(j - 1) * factorial(n - j))
    return weights


WEIGHTS = _weights()


def velocity_tolerance(accuracy: float, stiffness: float, T_s: float) -> float:
    """Return the error of the velocity in a step that moves a closed loop by no more than an accuracy [m/s].

    An error ``e`` in each of the two parts of a sample is an acceleration ``2·e/T_s``, against which the loop holds
    with its stiffness: ``accuracy = (2·e/T_s)/stiffness``.

    accuracy: Of the position in the loop [m]; 0 for the last digits.
    stiffness: Acceleration by which the loop answers a position error, ``K_v·K_p·B`` [1/s²].
    T_s: Sampling period of the controller [s].
    """
    return max(TOLERANCE, 0.5 * accuracy * stiffness * T_s)


def effective_times(plant: PlantConstants, length: float) -> Real:
    """Return how far a unit acceleration brings the velocity in each step that `advance` may take.

    ``(1 - exp(-A·h))/A`` for ``h = length/2^depth/parts``, shape (DEPTH + 1, ORDERS) [s].
    """
    h = length / 2.0 ** np.arange(DEPTH + 1)[:, np.newaxis] / np.arange(1, ORDERS + 1)
    return -np.vectorize(expm1, "d")(-plant.A * h) / plant.A if plant.A > 0.0 else h


@compiled(INSTANT(STEP_FUNCTION, ARRAY, ARRAY, PLANT, INSTANT, *[types.float64] * 3), makes_arrays=False)
def _step(
    friction: Step, state: Real, parameters: Real, plant: PlantConstants, start: Instant, driven: float, h: float,
    effective: float,
) -> Instant:  # fmt: skip
    """Take a step of second order (Verlet's in velocity form); damping and input are exact, friction is a trapezoid."""
    v, F, push = start.v, start.F, effective / plant.M
    free = v + effective * (driven - plant.A * v)
    if plant.set_valued == 0.0:
        ahead = free - push * F
    else:  # friction without memory stops a body, holds it up to its level, and never reverses it
        course = v if v != 0.0 else free
        if v == 0.0:
            F = friction(0.0, copysign(1e-300, free), h, state, parameters)
        ahead = free - push * F
        if not ahead * course > 0.0:
            travel = 0.5 * h * v * v / (v - ahead) if v != 0.0 else 0.0
            return Instant(start.z + travel, 0.0, free / push)
    dz = 0.5 * h * (v + ahead)
    F_1 = friction(dz, ahead, h, state, parameters)
    return Instant(start.z + dz, free - (0.5 * push) * (F + F_1), F_1)


@compiled(types.float64(TABLE, types.int64, types.int64), makes_arrays=False)
def _extrapolated(results: Real, k: int, i: int) -> float:
    """Return the limit of column i of the results in 1, 2 … k+1 parts as the parts get small."""
    last: float = results[k, i]
    change = 0.0
    for j in range(k):
        change += WEIGHTS[k, j] * (results[j, i] - last)
    return last + change


_RESULT = types.Tuple((INSTANT, types.int64, types.int64))  # type: ignore[no-untyped-call]


@compiled(
    _RESULT(
        STEP_FUNCTION, ARRAY, ARRAY, PLANT, INSTANT, types.float64, types.float64, TABLE, types.int64, types.int64,
        TABLE, TABLE,
    ),
    makes_arrays=False,
)  # fmt: skip
def advance(  # noqa: PLR0913 - compiled: Numba takes numbers, not objects
    friction: Step, state: Real, parameters: Real, plant: PlantConstants, now: Instant, driven: float, length: float,
    effective: Real, halvings: int, depth: int, ends: Real, states: Real,
) -> tuple[Instant, int, int]:  # fmt: skip
    """Advance the plant over a length of time, in steps of length/2^depth; return where it is, the depth, and the work.

    friction, state, parameters: The true friction: its compiled step, its state (changed in place), its parameters.
    plant, now: The plant, and where it is.
    driven: Acceleration by input and load [m/s²], constant.
    length: Time [s].
    effective: See `effective_times`.
    halvings: How often the coarsest step is halved; the tolerance is that of steps which are all as much shorter.
    depth: To begin with, as it was at the end of the last call.
    ends, states: Room for the results in each number of parts, shapes (ORDERS, 3) and (ORDERS, n).
    """
    tolerance, lasting = plant.tolerance / 8.0**halvings, LASTING * length / plant.M
    coarse, at, whole, work = plant.tolerance > TOLERANCE, 0, 1 << DEPTH, 0
    while at < whole:
        h = length / (1 << depth)
        allowed = tolerance + ROUNDING * (abs(now.v) + lasting * abs(now.F))
        best, apart, k = now, np.inf, 0
        for k in range(ORDERS):
            last, trial = now, states[k]
            for i in range(state.size):
                trial[i] = state[i]
            for _ in range(k + 1):
                last = _step(friction, trial, parameters, plant, last, driven, h / (k + 1), effective[depth, k])
            ends[k, 0], ends[k, 1], ends[k, 2] = last.z, last.v, last.F
            end = Instant(_extrapolated(ends, k, 0), _extrapolated(ends, k, 1), _extrapolated(ends, k, 2))
            before = apart
            if k > 0:
                apart = max(abs(end.v - best.v), lasting * abs(end.F - best.F))
            elif coarse:  # from where a step of first order ends, which takes the force as it was
                apart = 0.5 * effective[depth, 0] / plant.M * abs(end.F - now.F)
            best, work = end, work + k + 1
            if apart <= allowed or (k > 1 and apart > 0.25 * before):
                break
        smooth = apart <= allowed
        if not smooth and depth < DEPTH and work < WORK:
            depth += 1
            continue
        now = best if smooth else last
        for i in range(state.size):
            if k == 0:  # a single part
                state[i] = states[0, i]
                continue
            # what differs by half between two numbers of parts is no magnitude: a flag, or a load that changes sign
            change = abs(states[k, i] - states[k - 1, i])
            steady = smooth and 0.0 < change < 0.5 * abs(states[k, i])
            state[i] = _extrapolated(states, k, i) if steady else states[k, i]
        at += whole >> depth
        easy = (smooth and k < 3) or (work >= WORK and depth > 3)
        if easy and depth > halvings and at % (whole >> (depth - 1)) == 0:
            depth -= 1
    return now, depth, work
