"""From logged records to friction along a motion: which records, what is taken off, which samples."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from fric.errors import FricError
from fric.identify.loops.gms_fit import Shares
from fric.identify.loops.loops import Loops
from fric.identify.loops.refine_gms import Measured
from fric.identify.records.force_lag import acting_force
from fric.identify.records.motion import Motion, smooth_motion
from fric.identify.records.turns import reversals

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.drive.plant import Plant
    from fric.log import Log

PARTS = 16
"""Parts of a stroke in which what the model misses is taken for one."""


def sorted_by_kind(logs: Sequence[Log]) -> tuple[list[Log], list[Log]]:
    """Return the pre-sliding records and those in sliding."""
    presliding = [log for log in logs if log.kind == "presliding-sine"]
    if not presliding:
        presliding = [log for log in logs if log.kind in {None, "motion"}]
    if not presliding:
        raise FricError(
            "there is no pre-sliding record among the logs",
            mend="Log slow sines of small amplitude, and ingest them with --kind presliding-sine.",
        )
    return presliding, [log for log in logs if log.kind == "sliding-sine"]


def taken_off(log: Log, plant: Plant | None) -> tuple[Motion, NDArray[np.float64], Shares]:
    """Return the motion of a record, its friction force, and what was taken off: ``F = K_f·u - M·z̈ - M·A·ż``.

    The force is taken as it acts, see `fric.identify.records.force_lag`.
    """
    position = log.require("position", "the virgin curve")
    force = log.require("force", "the virgin curve")
    try:
        motion = smooth_motion(log.time, position)
    except FricError as error:
        raise error.at(log.where) from None
    if plant is None:
        return motion, force, Shares(log.name)
    acting = acting_force(log.time, force, plant.force_delay)
    inertia, damping = plant.M * motion.acceleration, plant.damping * motion.velocity
    size = 0.5 * float(np.quantile(acting, 0.99) - np.quantile(acting, 0.01))
    parts = [float(np.quantile(np.abs(part), 0.99)) / size for part in (inertia, damping)]
    return motion, acting - inertia - damping, Shares(log.name, *parts)


def cycled(loops: Loops) -> Measured:
    """Return a pre-sliding record for replay: used from the first reversal of the chosen cycles to the last."""
    n = len(loops.force)
    first, last = loops.cycles
    start = loops.turns[2 * (first - 1)]
    whole = (len(loops.turns) - 1) // 2
    stop = n if last == whole and first == 1 else int(loops.turns[2 * last])
    used = np.zeros(n, dtype=bool)
    used[start:stop] = True
    period = np.minimum(np.searchsorted(loops.turns[::2], np.arange(n), side="right"), whole)
    last_turn = loops.turns[np.clip(np.searchsorted(loops.turns, np.arange(n), side="right") - 1, 0, None)]
    way = 0.5 * np.abs(loops.motion.position - loops.motion.position[last_turn])
    return Measured(
        loops.name, loops.motion, loops.force, used, period, np.ones((n, 1)), way, _parts(way, loops.motion.velocity)
    )


def in_sliding(name: str, motion: Motion, force: NDArray[np.float64], plant_given: bool) -> Measured:
    """Return a record in sliding for replay: the frictional lag is out of phase with the velocity.

    What the static map may be off by, and damping that no plant took off, is in phase: the record adds an offset and a
    slope over velocity of its own. Without a plant it adds the inertia too.
    """
    v = motion.velocity
    turns = reversals(v, threshold=0.3 * float(np.ptp(v)))
    if len(turns) < 5:
        raise FricError(
            "the velocity changes over fewer than two cycles",
            where=f"record '{name}'",
            mend="Log five cycles or more of a sine about a mean speed, for C.",
        )
    n = len(v)
    used = np.zeros(n, dtype=bool)
    used[turns[0] : turns[-1]] = True
    if (v[used] > 0).any() and (v[used] < 0).any():
        raise FricError(
            "the motion turns, and C is told by sliding in one direction",
            where=f"record '{name}'",
            mend="Raise the mean speed above the amplitude of the velocity.",
        )
    columns = [np.ones(n), v] if plant_given else [np.ones(n), v, motion.acceleration]
    own = np.column_stack([column / max(np.abs(column).max(), 1e-300) for column in columns])
    period = np.searchsorted(turns[::2], np.arange(n), side="right")
    return Measured(name, motion, force, used, period, own, np.full(n, np.inf), _parts(v, motion.acceleration))


def _parts(progress: NDArray[np.float64], sense: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return which part of a cycle each sample is in: sixteenths of the samples by progress, in either sense."""
    limits = np.quantile(progress, np.arange(1, PARTS) / PARTS)
    return np.asarray(np.searchsorted(limits, progress) + PARTS * (sense > 0))
