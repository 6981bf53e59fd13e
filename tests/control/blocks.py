"""An axis, a motion and every control block on it, for the tests that all blocks share."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from fric.control import ControlBlock, Setting, blocks
from fric.control.scheme import Scheme
from fric.documents.machine_files import read_machine
from fric.kernels.block import Commands, Sample
from fric.reference import circle
from fric.simulate.axis import _loop_arguments, setting_of

AXIS = read_machine(Path("configs/xy-table.yaml")).axis("x")
MOTION = circle(2e-3, 0.02, 3, 4000.0)[0]
"""Three revolutions with the acceleration of 0.2 m/s² at a reversal."""
SCHEME = Scheme("c", "", friction="gms")
SETTING = setting_of(AXIS, SCHEME, MOTION)
ROWS = np.array(_loop_arguments(AXIS, MOTION, SCHEME)[-1])
INPUTS = len(Sample._fields)


@cache
def every_block() -> dict[str, ControlBlock]:
    """Return each block as it is designed for the axis."""
    return {name: kind.designed(SETTING) for name, kind in blocks().items()}


class Running:
    """A block that is run sample by sample."""

    def __init__(self, block: ControlBlock, setting: Setting = SETTING, rows: np.ndarray = ROWS) -> None:
        ready = block.ready(setting)
        self.step, self.state, self.parameters, self.rows = ready.step, ready.state.copy(), ready.parameters, rows

    def __call__(self, given: np.ndarray, n: int) -> float:
        return self.step(Sample(*given), n, self.rows, self.state, self.parameters)


def along(block: ControlBlock, given: np.ndarray, rows: np.ndarray = ROWS) -> np.ndarray:
    """Return what a block gives in each sample of a series of samples, shape (n, inputs)."""
    running = Running(block, rows=rows)
    return np.array([running(one, n) for n, one in enumerate(given)])


def no_commands(samples: int) -> np.ndarray:
    """Return the rows of an axis of which nothing is asked."""
    return np.zeros((len(Commands._fields), samples))
