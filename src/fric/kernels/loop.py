"""The closed loop of one axis: controller at its rate, and between its samples the plant with its true friction.

::

    r, ṙ, r̈ ──> controller ──>(+)──>(+)──> limit ──> delay ──> plant with friction ──┬──> z
                               ^     ^                                               │
             inverse model ────┘     ├──── friction feedforward                      │
                                     └──(-)── observers <──── encoder <──────────────┘

Controller, feedforward and observers are control blocks (`fric.kernels.block`), and each sees all signals of a sample.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import types

from fric.arrays import Real
from fric.kernels.block import BLOCK_FUNCTION, FRICTION, MODEL, BlockStep, Commands, Sample, absent
from fric.kernels.elementary import expm1
from fric.kernels.plant import ORDERS, PLANT, Instant, PlantConstants, advance, effective_times, numba_type
from fric.kernels.second_mass import ELONGATION
from fric.kernels.sensing import FAULTLESS, SENSING, Sensing, reading
from fric.kernels.signatures import ARRAY, STEP_FUNCTION, TABLE, Step, compiled

BLOCKS = 4  # Blocks that a loop has room for: the controller, and three more
MOST_WORK, MOST_A_SAMPLE = 20_000_000, 100  # Friction steps at most, more per sample: 10 to 40 usual, 500 if too stiff
CONTROLLER, FEEDFORWARD, OBSERVER = range(3)  # What a block is there for
_ARRAYS = types.UniTuple(ARRAY, BLOCKS)  # type: ignore[no-untyped-call]


class Board(NamedTuple):
    """What lies between the blocks and the drive."""

    T_s: float  # s, sampling of the controller
    limit: float  # V, of the control voltage
    resolution: float  # m, one encoder step; 0 for none


class Block(NamedTuple):
    """A control block as the loop runs it."""

    step: BlockStep
    role: int  # CONTROLLER, FEEDFORWARD or OBSERVER
    state: Real  # that it begins with
    parameters: Real


NONE = Block(absent, FEEDFORWARD, np.zeros(0), np.zeros(0))


class Traces(NamedTuple):
    """What the loop writes down, one value a controller sample."""

    position: Real  # m, true: of the table, where there is one on a spring; NaN from where a run is given up
    sensed: Real  # m, true, of the body that the encoder is on
    measured: Real  # m, by the encoder
    velocity: Real  # m/s, true
    input: Real  # V, as it leaves the controller
    friction: Real  # N
    feedforward: Real  # V, against friction
    disturbance: Real  # V, the observers' estimate


@compiled(
    types.int64(
        STEP_FUNCTION,
        ARRAY,
        ARRAY,
        PLANT,
        numba_type(Board, types.float64),
        *[BLOCK_FUNCTION] * BLOCKS,
        types.UniTuple(types.int64, BLOCKS + 1),  # type: ignore[no-untyped-call]
        _ARRAYS,
        _ARRAYS,
        TABLE,
        types.int64,
        types.UniTuple(types.float64, 2),  # type: ignore[no-untyped-call]
        types.UniTuple(TABLE, 2),  # type: ignore[no-untyped-call]
        types.int64,
        SENSING,
        numba_type(Traces, ARRAY),
    )
)
def _closed_loop(  # noqa: PLR0913 - compiled: Numba takes arrays, not objects
    step: Step, state: Real, parameters: Real, plant: PlantConstants, board: Board, controller: BlockStep,
    first: BlockStep, second: BlockStep, third: BlockStep, roles: tuple[int, ...], states: tuple[Real, ...],
    given: tuple[Real, ...], rows: Real, late: int, lengths: tuple[float, float], effective: tuple[Real, Real],
    halvings: int, sensing: Sensing, trace: Traces,
) -> int:  # fmt: skip
    z = rows[0, 0] + plant.ahead
    v, F = plant.v_0, step(0.0, plant.v_0, 0.0, state, parameters)
    count, u, control, excess, estimate = roles[BLOCKS], 0.0, 0.0, 0.0, 0.0
    saturated, depth, work = 0, halvings, 0
    ends, states_ahead = np.empty((ORDERS, 3)), np.empty((ORDERS, state.size))

    for n in range(rows.shape[1]):
        # --- control blocks
        table = z - state[ELONGATION] if sensing.spring > 0.0 else z
        sensed = table if sensing.spring > 1.0 else z
        measured = reading(sensed, board.resolution, sensing)
        sample = Sample(rows[0, n], rows[1, n], rows[2, n], measured, u, control, excess, estimate)
        volts = controller(sample, n, rows, states[0], given[0])
        ahead, estimate = rows[FRICTION, n], 0.0
        for k in range(1, count):
            block = first if k == 1 else second if k == 2 else third
            out = block(sample, n, rows, states[k], given[k])
            if roles[k] == OBSERVER:
                estimate += out
            else:
                ahead += out
        wanted = volts + rows[MODEL, n] + ahead - estimate
        u = min(max(wanted, -board.limit), board.limit)
        control, excess = u - ahead, wanted - u
        if u != wanted:
            saturated += 1
        trace.position[n], trace.sensed[n], trace.measured[n], trace.velocity[n] = table, sensed, measured, v
        trace.input[n], trace.friction[n] = u, F
        trace.feedforward[n], trace.disturbance[n] = ahead, estimate

        B = plant.B
        if plant.drift != 0.0:
            B *= 1.0 - plant.drift * expm1(-(plant.began + n * board.T_s) / plant.warming)

        # --- plant: within a sample its input changes once, where the last share of the delay ends
        for part in range(2):
            if lengths[part] > 0.0:
                sent = n - late - 1 + part
                driven = (B * trace.input[sent] if sent >= 0 else 0.0) - plant.load / plant.M
                now, depth, spent = advance(
                    step, state, parameters, plant, Instant(0.0, v, F), driven, lengths[part], effective[part],
                    halvings, depth, ends, states_ahead,
                )  # fmt: skip
                z, v, F, work = z + now.z, now.v, now.F, work + spent
        if work > MOST_WORK + MOST_A_SAMPLE * n:
            trace.position[n:] = np.nan
            break
    return saturated


def parts_of_a_sample(plant: PlantConstants, T_s: float) -> tuple[int, tuple[float, float]]:
    """Return the whole samples of the delay, and the parts of a sample before and after its last share ends [s]."""
    late, share = divmod(plant.delay / T_s + 1e-9, 1.0)
    share = max(share - 1e-9, 0.0) if share > 2e-9 else 0.0
    return int(late), (share * T_s, (1.0 - share) * T_s)


def closed_loop(  # noqa: PLR0913 - what the compiled loop takes
    step: Step, state: Real, parameters: Real, plant: PlantConstants, board: Board, blocks: Sequence[Block],
    command: Commands, halvings: int = 0, sensing: Sensing = FAULTLESS,
) -> tuple[Traces, int]:  # fmt: skip
    """Return the traces of a run, and the number of samples in saturation.

    step, state, parameters: The true friction: its compiled step, its state (changed in place), its parameters.
    plant, board: The axis, and what lies before its drive.
    blocks: The controller, and up to three more blocks.
    halvings: How often every step of the plant is halved, to see that this changes nothing.
    """
    plant, board = PlantConstants(*map(float, plant)), Board(*map(float, board))
    late, lengths = parts_of_a_sample(plant, board.T_s)
    trace = Traces(*(np.empty_like(command.position) for _ in Traces._fields))
    four = [*blocks, *[NONE] * (BLOCKS - len(blocks))]
    controller, first, second, third = (block.step for block in four)
    saturated: int = _closed_loop(
        step, state, parameters, plant, board, controller, first, second, third,
        (*(block.role for block in four), len(blocks)), tuple(block.state.copy() for block in four),
        tuple(block.parameters for block in four), np.array(command), late, lengths,
        (effective_times(plant, lengths[0]), effective_times(plant, lengths[1])), halvings,
        Sensing(*map(float, sensing)), trace,
    )  # fmt: skip
    return trace, saturated
