"""The cycles of a pre-sliding record."""

from dataclasses import dataclass, replace

import numpy as np

from fric.arrays import Indices, Real
from fric.errors import FricError
from fric.records.judgement import STEPS
from fric.records.motion import Motion
from fric.records.prepared import Prepared
from fric.records.reversals import find_reversals

PARTS = 16
"""Parts of a stroke in which two of them are compared."""
UNLIKE, LOADED = 3.0, 0.01
"""By how much the first stroke is unlike the next where a record begins loaded: times as much as later strokes, and
share of the range of the force."""


@dataclass(frozen=True)
class HysteresisCycles:
    """A pre-sliding record and its cycles."""

    record: Prepared  # The record as it was prepared
    reversals: Indices  # Samples at which the motion reverses, shape (m,)
    cycles: tuple[int, int]  # Number of the first and last cycle (from 1) that the identification uses
    loaded: bool = False  # Whether the contact was loaded where it begins: its first stroke is left out

    @property
    def name(self) -> str:
        """Name of the record."""
        return self.record.name

    @property
    def motion(self) -> Motion:
        """What moved between the encoder's counts."""
        return self.record.motion

    @property
    def force(self) -> Real:
        """Friction force [N], inertia and linear damping taken off where a plant is known, shape (n,)."""
        return self.record.force

    @property
    def amplitude(self) -> float:
        """Half of the median stroke [m]."""
        return 0.5 * float(np.median(np.abs(np.diff(self.motion.position[self.reversals]))))

    def chosen(self) -> list[tuple[int, int, int]]:
        """Return start, reversal and end of the cycles that are used, as samples."""
        whole = [
            (self.reversals[n], self.reversals[n + 1], self.reversals[n + 2])
            for n in range(0, len(self.reversals) - 2, 2)
        ]
        return [(int(a), int(b), int(c)) for a, b, c in whole[self.cycles[0] - 1 : self.cycles[1]]]

    def for_replay(self) -> Prepared:
        """Return the record as it is compared: from the first reversal of the chosen cycles to their last."""
        n, (first, last) = len(self.force), self.cycles
        whole = (len(self.reversals) - 1) // 2
        used = np.zeros(n, dtype=bool)
        used[self.reversals[2 * (first - 1)] : n if (first, last) == (1, whole) else self.reversals[2 * last]] = True
        return replace(self.record, used=used, reversals=self.reversals)


def _begins_loaded(record: Prepared, reversals: Indices) -> bool:
    """Say whether the first stroke of a record is unlike the next in its direction, where later strokes repeat.

    A contact that comes to rest loaded is so where a record begins. Until each block has slipped, or has not along a
    whole stroke, the force depends on that; from the second reversal on it shows as a constant at most.
    """
    if len(reversals) < 5:
        return False
    z, F = record.motion.position, record.force
    travel = float(np.min(np.abs(np.diff(z[reversals[:5]]))))
    edges = np.linspace(0.0, travel * (1.0 + 1e-9), PARTS + 1)

    def unlike(n: int) -> float:
        """Return by how much two strokes of one direction differ, but for a constant [N]."""
        along = []
        for begin, end in ((reversals[m], reversals[m + 1]) for m in (n, n + 2)):
            part = np.clip(np.digitize(np.abs(z[begin:end] - z[begin]), edges) - 1, 0, PARTS - 1)
            count = np.bincount(part, minlength=PARTS)
            along.append(np.bincount(part, F[begin:end], PARTS) / np.where(count, count, np.nan))
        apart = along[1] - along[0]
        return float(np.sqrt(np.nanmean((apart - np.nanmean(apart)) ** 2)))

    return unlike(0) > max(UNLIKE * unlike(1), LOADED * float(np.ptp(F[reversals[1] : reversals[4]])))


def find_cycles(record: Prepared, cycles: tuple[int, int] | None = None) -> HysteresisCycles:
    """Find the cycles of a record: from one reversal to the next but one.

    record: The record.
    cycles: The first and the last cycle to use, counted from 1; all where not given.
    Raises FricError: When there is no whole cycle, the chosen ones do not exist, or the amplitude is under three
        encoder steps.
    """
    motion, where = record.motion, record.log.where
    span = float(np.ptp(motion.position))
    reversals = find_reversals(motion.position, threshold=0.3 * span) if span > 0 else np.zeros(0, np.intp)
    count = max((len(reversals) - 1) // 2, 0)
    if count == 0:
        raise FricError(
            f"no whole cycle is in it ({len(reversals)} reversals)",
            where=where,
            hint="Log two cycles or more of a slow sine.",
        )
    loaded = cycles is None and _begins_loaded(record, reversals)
    if loaded:
        reversals = reversals[1:]
        count = (len(reversals) - 1) // 2
    first, last = cycles or (1, count)
    if first > count:
        raise FricError(
            f"cycle {first} was asked for, and there are {count}",
            where=where,
            hint="Choose `cycles=` anew.",
        )
    hysteresis = HysteresisCycles(record, reversals, (first, min(last, count)), loaded)
    if hysteresis.amplitude < STEPS * motion.step:
        raise FricError(
            f"the amplitude is {hysteresis.amplitude / motion.step:.1f} steps of the encoder, "
            "too few to see the friction",
            where=where,
            hint="Log a larger amplitude: ten steps or more.",
        )
    return hysteresis
