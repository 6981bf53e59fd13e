"""The cycles of a pre-sliding record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fric.errors import FricError
from fric.identify.records.motion import Motion
from fric.identify.records.turns import reversals

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Loops:
    """A pre-sliding record: its motion, its friction force, and its cycles.

    Parameters
    ----------
    name
        Name of the record.
    motion
        What moved between the encoder's counts.
    force
        Friction force [N], inertia and linear damping taken off where a plant is known, shape (n,).
    turns
        Samples at which the motion turns, shape (m,).
    cycles
        Number of the first and last cycle (from 1) that the identification uses.
    """

    name: str
    motion: Motion
    force: NDArray[np.float64]
    turns: NDArray[np.intp]
    cycles: tuple[int, int]

    @property
    def amplitude(self) -> float:
        """Half of the median stroke [m]."""
        return 0.5 * float(np.median(np.abs(np.diff(self.motion.position[self.turns]))))

    def chosen(self) -> list[tuple[int, int, int]]:
        """Return start, turn and end of the cycles that are used, as samples."""
        whole = [(self.turns[n], self.turns[n + 1], self.turns[n + 2]) for n in range(0, len(self.turns) - 2, 2)]
        return [(int(a), int(b), int(c)) for a, b, c in whole[self.cycles[0] - 1 : self.cycles[1]]]


def find_loops(name: str, motion: Motion, force: NDArray[np.float64], cycles: tuple[int, int] | None = None) -> Loops:
    """Find the cycles of a record: from one reversal to the next but one.

    Parameters
    ----------
    name, motion, force
        See `Loops`.
    cycles
        The first and the last cycle to use, counted from 1; all where not given.

    Raises
    ------
    FricError
        When there is no whole cycle, the chosen ones do not exist, or the amplitude is under three encoder steps.
    """
    span = float(np.ptp(motion.position))
    turns = reversals(motion.position, threshold=0.3 * span) if span > 0 else np.zeros(0, np.intp)
    count = max((len(turns) - 1) // 2, 0)
    if count == 0:
        raise FricError(
            f"no whole cycle is in it ({len(turns)} reversals)",
            where=f"record '{name}'",
            mend="Log two cycles or more of a slow sine.",
        )
    first, last = cycles or (1, count)
    if first > count:
        raise FricError(
            f"cycle {first} was asked for, and there are {count}",
            where=f"record '{name}'",
            mend="Choose --cycles anew.",
        )
    loops = Loops(name, motion, force, turns, (first, min(last, count)))
    if loops.amplitude < 3.0 * motion.step:
        raise FricError(
            f"the amplitude is {loops.amplitude / motion.step:.1f} steps of the encoder, too few to see the friction",
            where=f"record '{name}'",
            mend="Log a larger amplitude: ten steps or more.",
        )
    return loops
