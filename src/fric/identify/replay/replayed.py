"""Records made ready for replay: the motion behind the encoder's counts, the friction force, what may be scored."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fric.errors import FricError
from fric.identify.records.motion import Motion, smooth_motion
from fric.identify.records.resolution import noise_level
from fric.identify.records.turns import reversals

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.drive.plant import Plant
    from fric.friction import FrictionModel
    from fric.identify.replay.coordinates import Ranges
    from fric.log import Log

MOST = 400_000
"""Samples of all records together that a fit replays; of more, one in so many is taken."""


@dataclass(frozen=True)
class Replayed:
    """One record to replay a model along.

    Parameters
    ----------
    log
        The record.
    motion
        Its motion, without the encoder's steps.
    force
        Friction force [N], shape (n,): inertia and linear damping are taken off where a plant is given.
    used
        Samples that are compared, shape (n,). What comes before the first reversal is not among them, since the
        state in which the record begins is not known.
    own
        What the record adds of its own, shape (n, m): an offset (amplifier bias, gravity), and inertia where the
        record is an ordinary motion and no plant is given.
    turns
        Samples at which the motion turns, shape (r,).
    """

    log: Log
    motion: Motion
    force: NDArray[np.float64]
    used: NDArray[np.bool_]
    own: NDArray[np.float64]
    turns: NDArray[np.intp]

    def replay(self, model: FrictionModel) -> NDArray[np.float64]:
        """Return the force of a model along the motion [N], shape (n,)."""
        return model.replay(self.motion.time, self.motion.position, self.motion.velocity)

    def own_part(self, rest: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the coefficients of ``own`` that explain most of a force (n,), by least squares, shape (m,)."""
        return np.asarray(np.linalg.lstsq(self.own[self.used], rest[self.used], rcond=None)[0])

    @cached_property
    def _basis(self) -> NDArray[np.float64]:
        """An orthonormal basis of ``own`` at the samples used."""
        return np.asarray(np.linalg.qr(self.own[self.used])[0])

    def residual(self, model: FrictionModel) -> NDArray[np.float64]:
        """Return measured minus replayed force at the samples used, less what the record adds of its own."""
        rest = (self.force - self.replay(model))[self.used]
        return np.asarray(rest - self._basis @ (self._basis.T @ rest))

    def restricted(self, used: NDArray[np.bool_]) -> Replayed:
        """Return the record with fewer samples compared; the replay still runs through all of them."""
        return replace(self, used=self.used & used)

    def trimmed(self) -> Replayed:
        """Return the record up to the last sample that is compared."""
        return self._cut(slice(None, int(np.flatnonzero(self.used)[-1]) + 1))

    def _cut(self, cut: slice) -> Replayed:
        m = self.motion
        motion = Motion(m.time[cut], m.position[cut], m.velocity[cut], m.acceleration[cut], m.step)
        turns = self.turns // (cut.step or 1)
        return Replayed(
            self.log, motion, self.force[cut], self.used[cut], self.own[cut], turns[turns < len(motion.time)]
        )

    def thinned(self, every: int) -> Replayed:
        """Return the record with one sample in so many: increments of position add up, so nothing is lost of them."""
        if every <= 1:
            return self
        return self._cut(slice(None, None, every))


def replayed(logs: Sequence[Log], plant: Plant | None = None) -> tuple[Replayed, ...]:
    """Return records ready for replay.

    Parameters
    ----------
    logs
        Records of one axis with a force, or with an input where a plant gives the force constant.
    plant
        The plant, whose inertia and linear damping are taken off.

    Raises
    ------
    FricError
        When a record has no force, holds a value that is no number, or does not move.
    """
    if not logs:
        raise FricError("there is no record", mend="Name a log with a force.")
    if len({(log.axis, log.motion) for log in logs}) > 1:
        told = ", ".join(sorted({log.axis for log in logs}))
        raise FricError(f"the records are of several axes ({told})", mend="Identify one axis at a time.")
    records = tuple(_replayed(log, plant) for log in logs)
    every = -(-sum(len(record.log) for record in records) // MOST)
    return tuple(record.thinned(every) for record in records)


def _replayed(log: Log, plant: Plant | None) -> Replayed:
    if log.force is None and plant is not None and log.input is not None:
        force = plant.K_f * log.input
    else:
        force = log.require("force", "a replay")
    position = log.position
    if position is None:
        assert log.velocity is not None  # a Log holds one of them
        v = log.velocity
        position = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(log.time))])
    for channel, values in (("force", force), ("position", position)):
        if not np.isfinite(values).all():
            raise FricError(
                f"the {channel} is no number at sample {int(np.argmin(np.isfinite(values)))}",
                where=log.where,
                mend="Ingest the log again with --bad-cells drop.",
            )
    try:
        motion = smooth_motion(log.time, position)
    except FricError as error:
        raise error.at(log.where) from None
    columns = [np.ones(len(log))]
    if plant is not None:
        force = force - plant.M * motion.acceleration - plant.damping * motion.velocity
    elif log.kind == "motion":
        columns.append(motion.acceleration)
    turns = reversals(position)
    used = np.ones(len(log), dtype=bool)
    if len(turns) > 1:
        used[: turns[0]] = False
    else:
        used[np.abs(position - position[0]) < 0.02 * np.ptp(position)] = False
    return Replayed(log, motion, np.asarray(force, float), used, np.column_stack(columns), turns)


def search_ranges(records: Sequence[Replayed]) -> Ranges:
    """Return, by dimension, between which values the records could show a parameter at all.

    Forces up to twice that logged, velocities up to three times the fastest, lengths from the encoder's step or
    noise (but at least 1e-4 of the stroke) to the stroke, and what is made of these.
    """
    force = max(float(np.quantile(np.abs(r.force[r.used] - np.median(r.force[r.used])), 0.99)) for r in records)
    speeds = np.concatenate([np.abs(r.motion.velocity[r.used]) for r in records])
    fastest = float(np.quantile(speeds, 0.99))
    strokes = [float(np.ptp(r.motion.position)) for r in records]
    stroke = max(strokes)
    grain = [
        max(r.motion.step, 4.0 * noise_level(r.log.position)) if r.log.position is not None else 0.0 for r in records
    ]
    finest = min(max(g, 1e-4 * s) for g, s in zip(grain, strokes, strict=True))
    duration = max(float(r.motion.time[-1] - r.motion.time[0]) for r in records)
    dt = min(float(np.median(np.diff(r.motion.time))) for r in records)
    if not (force > 0 and fastest > 0):
        raise FricError("the records hold no force or no motion", where=records[0].log.where)
    return {
        "force": (0.01 * force, 2.0 * force),
        "velocity": (1e-4 * fastest, 3.0 * fastest),
        "viscous": (0.0, 100.0 * force / fastest),
        "position": (finest, stroke),
        "stiffness": (0.1 * force / stroke, 2.0 * force / finest),
        "force rate": (force / duration, force / dt),
        "rate": (1.0 / duration, 1.0 / dt),
        "frequency": (1.0 / duration, 0.5 / dt),
        "time": (dt, duration),
    }
