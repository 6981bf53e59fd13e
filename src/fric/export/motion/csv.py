"""Motions as text columns: time, position, velocity, acceleration; and the voltage that is added, sample by sample."""

from collections.abc import Mapping

import numpy as np

from fric.export.motion.base import Dialect, Move
from fric.units import rotates

ROWS = 2048
"""Rows of a motion at most; of a longer one, one sample in so many is taken."""


def csv_files(move: Move) -> Mapping[str, str]:
    """Return the motion in SI, from 0 on as the plan has it; and the voltage at the controller's own rate."""
    m, unit = move.reference, "m" if not rotates(move.motion) else "rad"
    every = -(-len(m) // ROWS)
    head = f"time [s],position [{unit}],velocity [{unit}/s],acceleration [{unit}/s^2]"
    columns = np.column_stack([m.time, m.position, m.velocity, m.acceleration])[::every]
    files = {f"{move.name}.csv": _text(head, columns)}
    if move.excitation is not None:
        files[f"{move.name}-voltage.csv"] = _text("time [s],voltage [V]", np.column_stack([m.time, move.excitation]))
    return files


def _text(head: str, columns: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> str:
    return "\n".join([head, *(",".join(f"{value:.9g}" for value in row) for row in columns)]) + "\n"


CSV = Dialect("csv", "columns of time, position, velocity, acceleration in SI", csv_files)
