"""The signature of every compiled control block, and the signals of a sample that a block sees.

A block is compiled with this explicit signature and handed to the loop as a first-class function, as a friction step
is (`fric.kernels.signatures`): the loop is compiled once for all blocks.
"""

from collections.abc import Callable
from typing import NamedTuple

from numba import types

from fric.arrays import Real
from fric.kernels.signatures import ARRAY, TABLE, Function, compiled, first_class


class Sample(NamedTuple):
    """What a block sees in one sample of the controller."""

    reference: float  # m
    velocity: float  # m/s, of the reference
    acceleration: float  # m/s², of the reference
    measured: float  # m, position as the encoder measures it
    input: float  # V, of the last sample, as limited
    control: float  # V, of the last sample: the input less the friction feedforward
    excess: float  # V, the part of the last sample's voltage that the limit cut; 0 where it did not
    estimate: float  # V, subtracted by the observers from the voltage of the last sample


class Commands(NamedTuple):
    """The commands to the axis, one value a controller sample: rows of a table that a block may look ahead in."""

    position: Real  # m
    velocity: Real  # m/s
    acceleration: Real  # m/s²
    model: Real  # V, inverse-model feedforward
    friction: Real  # V, friction feedforward, which no observer sees
    ahead_position: Real  # m, the reference a lead later
    ahead_velocity: Real  # m/s


POSITION, VELOCITY, ACCELERATION, MODEL, FRICTION, AHEAD_POSITION, AHEAD_VELOCITY = range(len(Commands._fields))
"""The rows of the table, in the order of `Commands`."""

BLOCK = types.float64(
    types.NamedUniTuple(types.float64, len(Sample._fields), Sample),  # type: ignore[no-untyped-call]
    types.int64,
    TABLE,
    ARRAY,
    ARRAY,
)
"""``volts = step(sample, n, rows, state, parameters)``: the output of a block in sample n; it changes ``state``.

``rows[ROW, n + m]`` is the command m samples later (`Commands`). All that a block keeps is in ``state``. What the
volts do depends on the kind: a controller's are the control voltage, a feedforward's are added to it unseen by the
observers, and an observer's, its estimate of the disturbance, are subtracted from it."""

BLOCK_FUNCTION = types.FunctionType(BLOCK)

BlockStep = Callable[[Sample, int, Real, Real, Real], float]


def compiled_block(function: Function) -> Function:
    """Compile the step of a control block with the signature `BLOCK`, cached on disk; it makes no arrays."""
    return first_class(function, compiled(BLOCK, makes_arrays=False)(function), BLOCK)


@compiled_block
def absent(sample: Sample, n: int, rows: Real, state: Real, parameters: Real) -> float:
    """Return 0: the step of the loop where there is no block."""
    return 0.0
