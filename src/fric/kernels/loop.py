"""The closed loop of one axis: controller at its own rate, plant with true friction at a fine step.

::

    r, ṙ ──> cascade ──>(+)──>(+)──> limit ──> delay ──> plant with friction ──┬──> z
                         ^     ^                                               │
       inverse model ────┘     ├──── friction feedforward                      │
                               └──(-)── observer <──── encoder <───────────────┘
"""

from __future__ import annotations

from math import copysign, exp, expm1
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from fric.kernels.signatures import STEP_FUNCTION, Step, compiled

_ARRAY = types.float64[::1]


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


class ControlConstants(NamedTuple):
    """The cascade and what it sees."""

    K_v: float  # 1/s
    K_p: float  # V·s/m
    K_i: float  # V/m
    pole: float  # of the velocity filter
    T_s: float  # s
    limit: float  # V
    resolution: float  # m, one encoder step; 0 for none


class Commands(NamedTuple):
    """What is asked of the axis, one value a controller sample."""

    position: NDArray[np.float64]  # m
    velocity: NDArray[np.float64]  # m/s
    model: NDArray[np.float64]  # V, inverse-model feedforward
    friction: NDArray[np.float64]  # V, friction feedforward, which the observer does not see


class ObserverFilters(NamedTuple):
    """The observer as two difference equations ``y[n] = Σ b[i]·x[n-i] - Σ a[i]·y[n-i]``, a[0] = 1; empty for none.

    Q·G_n⁻¹ acts on the measured position; Q, without direct term, on the control voltage of the samples before.
    """

    position_b: NDArray[np.float64]
    position_a: NDArray[np.float64]
    voltage_b: NDArray[np.float64]
    voltage_a: NDArray[np.float64]


class Traces(NamedTuple):
    """What the loop writes down, one value a controller sample."""

    position: NDArray[np.float64]  # m, true
    measured: NDArray[np.float64]  # m, by the encoder
    velocity: NDArray[np.float64]  # m/s, true
    input: NDArray[np.float64]  # V, as it leaves the controller
    friction: NDArray[np.float64]  # N
    disturbance: NDArray[np.float64]  # V, the observer's estimate


@compiled(types.float64(_ARRAY, _ARRAY, _ARRAY, types.float64))
def _filtered(b: NDArray[np.float64], a: NDArray[np.float64], memory: NDArray[np.float64], x: float) -> float:
    """Advance a difference equation by one sample (direct form II, transposed)."""
    y: float = b[0] * x + memory[0]
    last = memory.size - 1
    for i in range(last):
        memory[i] = b[i + 1] * x - a[i + 1] * y + memory[i + 1]
    memory[last] = b[last + 1] * x - a[last + 1] * y
    return y


def _numba_type(group: Any, of: types.Type) -> types.Type:
    """Return the type of a group of constants or of arrays, as the compiler sees it."""
    return types.NamedUniTuple(of, len(group._fields), group)  # type: ignore[no-untyped-call]


@compiled(
    types.int64(
        STEP_FUNCTION,
        _ARRAY,
        _ARRAY,
        _numba_type(PlantConstants, types.float64),
        _numba_type(ControlConstants, types.float64),
        _numba_type(ObserverFilters, _ARRAY),
        _numba_type(Commands, _ARRAY),
        types.int64,
        _numba_type(Traces, _ARRAY),
    )
)
def _closed_loop(
    step: Step,
    state: NDArray[np.float64],
    parameters: NDArray[np.float64],
    plant: PlantConstants,
    control: ControlConstants,
    observer: ObserverFilters,
    command: Commands,
    substeps: int,
    trace: Traces,
) -> int:
    # The delay is a number of whole samples and a share of one. Within a sample the plant's input changes once,
    # where that share ends, and the plant's steps are laid so that one of them begins there.
    whole = int(plant.delay / control.T_s + 1e-9)
    share = max(plant.delay / control.T_s - whole, 0.0)
    before = 0 if share < 1e-9 else max(1, int(substeps * share + 0.5))
    after = max(1, substeps - before)
    lengths = (share * control.T_s / max(before, 1), (1.0 - share) * control.T_s / after)
    counts = (before, after)

    z = command.position[0] + plant.ahead
    origin, seen = z, z - plant.v_0 * control.T_s  # the observer is at rest where the run begins
    if control.resolution > 0.0:
        seen = np.rint(seen / control.resolution) * control.resolution
    v, a, h_before, F = plant.v_0, 0.0, 0.0, 0.0
    filtered_v, integral = plant.v_0, 0.0
    with_observer = observer.position_b.size > 0
    position_memory, voltage_memory = (
        np.zeros(max(observer.position_b.size - 1, 1)),
        np.zeros(max(observer.voltage_b.size - 1, 1)),
    )
    saturated = 0

    for n in range(command.position.size):
        # --- controller
        measured = z
        if control.resolution > 0.0:
            measured = np.rint(z / control.resolution) * control.resolution
        filtered_v = control.pole * filtered_v + (1.0 - control.pole) * (measured - seen) / control.T_s
        seen = measured
        error = control.K_v * (command.position[n] - measured) + command.velocity[n] - filtered_v
        step_of_integral = control.K_i * control.T_s * error
        estimate = 0.0
        if with_observer:
            estimate = (
                _filtered(observer.position_b, observer.position_a, position_memory, measured - origin)
                - voltage_memory[0]
            )
        wanted = control.K_p * error + integral + step_of_integral + command.model[n] + command.friction[n] - estimate
        u = min(max(wanted, -control.limit), control.limit)
        if u == wanted:
            integral += step_of_integral
        else:  # the integral waits, unless it leads out of saturation
            saturated += 1
            if (wanted - u) * step_of_integral < 0.0:
                integral += step_of_integral
        if with_observer:
            _filtered(observer.voltage_b, observer.voltage_a, voltage_memory, u - command.friction[n])
        trace.position[n], trace.measured[n], trace.velocity[n] = z, measured, v
        trace.input[n], trace.friction[n], trace.disturbance[n] = u, F, estimate

        # --- plant: position at half steps, where friction acts; velocity at whole steps (second order)
        for part in range(2):
            sample = n - whole - 1 + part
            driven = (plant.B * trace.input[sample] if sample >= 0 else 0.0) - plant.load / plant.M
            h = lengths[part]
            decay = exp(-plant.A * h)
            reach = -expm1(-plant.A * h) / plant.A if plant.A > 0.0 else h
            for _ in range(counts[part]):
                half = 0.5 * h
                free = decay * v + reach * driven
                z += half * v
                dz, dt = (0.5 * h_before + half) * v, 0.5 * h_before + half
                v_middle = v + half * a
                if plant.set_valued == 0.0:
                    F = step(dz, v_middle, dt, state, parameters)
                    moved = free - reach * F / plant.M
                else:  # friction may stop the body within the step, and hold it up to its level; it never turns it
                    course = v if v != 0.0 else copysign(1e-300, free)
                    F = step(dz, v_middle if v_middle * course > 0.0 else course, dt, state, parameters)
                    moved = free - reach * F / plant.M
                    if moved * course <= 0.0:
                        moved, F = 0.0, free * plant.M / reach
                a = (moved - v) / h
                v = moved
                z += half * v
                h_before = h
    return saturated


def closed_loop(
    step: Step,
    state: NDArray[np.float64],
    parameters: NDArray[np.float64],
    plant: PlantConstants,
    control: ControlConstants,
    observer: ObserverFilters,
    command: Commands,
    substeps: int,
) -> tuple[Traces, int]:
    """Return the traces of a run, and the number of samples in saturation.

    Parameters
    ----------
    step, state, parameters
        The true friction: its compiled step, its state (changed in place), its parameters.
    plant, control, observer, command
        The axis, its controller, and what is asked of it.
    substeps
        Plant steps a controller sample.
    """
    plant, control = PlantConstants(*map(float, plant)), ControlConstants(*map(float, control))
    trace = Traces(*(np.empty_like(command.position) for _ in Traces._fields))
    saturated: int = _closed_loop(step, state, parameters, plant, control, observer, command, substeps, trace)
    return trace, saturated
