"""The closed loop of one axis: controller at its own rate, and between its samples the plant with its true friction.

::

    r, ṙ ──> cascade ──>(+)──>(+)──> limit ──> delay ──> plant with friction ──┬──> z
                         ^     ^                                               │
       inverse model ────┘     ├──── friction feedforward                      │
                               └──(-)── observer <──── encoder <───────────────┘
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from fric.kernels.plant import ARRAY, ORDERS, PLANT, TABLE, Instant, PlantConstants, advance, numba_type, reaches
from fric.kernels.second_mass import STRETCH
from fric.kernels.sensing import FAULTLESS, SENSING, Sensing, reading
from fric.kernels.signatures import STEP_FUNCTION, Step, compiled


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

    position: NDArray[np.float64]  # m, true: of the table, where there is one on a spring
    sensed: NDArray[np.float64]  # m, true, of what the encoder is on
    measured: NDArray[np.float64]  # m, by the encoder
    velocity: NDArray[np.float64]  # m/s, true
    input: NDArray[np.float64]  # V, as it leaves the controller
    friction: NDArray[np.float64]  # N
    disturbance: NDArray[np.float64]  # V, the observer's estimate


@compiled(types.float64(ARRAY, ARRAY, ARRAY, types.float64))
def _filtered(b: NDArray[np.float64], a: NDArray[np.float64], memory: NDArray[np.float64], x: float) -> float:
    """Advance a difference equation by one sample (direct form II, transposed)."""
    y: float = b[0] * x + memory[0]
    last = memory.size - 1
    for i in range(last):
        memory[i] = b[i + 1] * x - a[i + 1] * y + memory[i + 1]
    memory[last] = b[last + 1] * x - a[last + 1] * y
    return y


@compiled(
    types.int64(
        STEP_FUNCTION,
        ARRAY,
        ARRAY,
        PLANT,
        numba_type(ControlConstants, types.float64),
        numba_type(ObserverFilters, ARRAY),
        numba_type(Commands, ARRAY),
        types.int64,
        types.UniTuple(types.float64, 2),  # type: ignore[no-untyped-call]
        types.UniTuple(TABLE, 2),  # type: ignore[no-untyped-call]
        types.int64,
        SENSING,
        numba_type(Traces, ARRAY),
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
    late: int,
    lengths: tuple[float, float],
    reach: tuple[NDArray[np.float64], NDArray[np.float64]],
    halvings: int,
    sensing: Sensing,
    trace: Traces,
) -> int:
    z = command.position[0] + plant.ahead
    origin = z  # the observer is at rest where the run begins
    seen = reading(z - plant.v_0 * control.T_s, control.resolution, sensing)
    v, F = plant.v_0, step(0.0, plant.v_0, 0.0, state, parameters)
    filtered_v, integral = plant.v_0, 0.0
    with_observer = observer.position_b.size > 0
    position_memory, voltage_memory = (
        np.zeros(max(observer.position_b.size - 1, 1)),
        np.zeros(max(observer.voltage_b.size - 1, 1)),
    )
    saturated, depth = 0, halvings
    ends, states = np.empty((ORDERS, 3)), np.empty((ORDERS, state.size))

    for n in range(command.position.size):
        # --- controller
        table = z - state[STRETCH] if sensing.spring > 0.0 else z
        sensed = table if sensing.spring > 1.0 else z
        measured = reading(sensed, control.resolution, sensing)
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
        trace.position[n], trace.sensed[n], trace.measured[n], trace.velocity[n] = table, sensed, measured, v
        trace.input[n], trace.friction[n], trace.disturbance[n] = u, F, estimate

        B = plant.B
        if plant.drift != 0.0:
            B *= 1.0 - plant.drift * np.expm1(-(plant.began + n * control.T_s) / plant.warming)

        # --- plant: within a sample its input changes once, where the last share of the delay ends
        for part in range(2):
            if lengths[part] > 0.0:
                sample = n - late - 1 + part
                driven = (B * trace.input[sample] if sample >= 0 else 0.0) - plant.load / plant.M
                now, depth = advance(
                    step, state, parameters, plant, Instant(0.0, v, F), driven, lengths[part], reach[part], halvings,
                    depth, ends, states,
                )  # fmt: skip
                z, v, F = z + now.z, now.v, now.F
    return saturated


def parts_of_a_sample(plant: PlantConstants, control: ControlConstants) -> tuple[int, tuple[float, float]]:
    """Return the whole samples of the delay, and the parts of a sample before and after its last share ends [s]."""
    late, share = divmod(plant.delay / control.T_s + 1e-9, 1.0)
    share = max(share - 1e-9, 0.0) if share > 2e-9 else 0.0
    return int(late), (share * control.T_s, (1.0 - share) * control.T_s)


def closed_loop(
    step: Step,
    state: NDArray[np.float64],
    parameters: NDArray[np.float64],
    plant: PlantConstants,
    control: ControlConstants,
    observer: ObserverFilters,
    command: Commands,
    halvings: int = 0,
    sensing: Sensing = FAULTLESS,
) -> tuple[Traces, int]:
    """Return the traces of a run, and the number of samples in saturation.

    Parameters
    ----------
    step, state, parameters
        The true friction: its compiled step, its state (changed in place), its parameters.
    plant, control, observer, command
        The axis, its controller, and what is asked of it.
    halvings
        How often every step of the plant is halved, to see that this changes nothing.
    sensing
        What is amiss with its encoder.
    """
    plant, control = PlantConstants(*map(float, plant)), ControlConstants(*map(float, control))
    late, lengths = parts_of_a_sample(plant, control)
    trace = Traces(*(np.empty_like(command.position) for _ in Traces._fields))
    saturated: int = _closed_loop(
        step, state, parameters, plant, control, observer, command, late, lengths,
        (reaches(plant, lengths[0]), reaches(plant, lengths[1])), halvings, Sensing(*map(float, sensing)), trace,
    )  # fmt: skip
    return trace, saturated
