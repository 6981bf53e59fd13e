"""What of records, static maps and plants is held against the bounds of physics."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import nan
from typing import TYPE_CHECKING

from fric.drive.plant import Plant
from fric.log import Log
from fric.plausibility.bounds import Finding
from fric.units import Motion

if TYPE_CHECKING:
    from fric.friction.stribeck import StaticMap

TOGETHER = 0.99
"""Correlation of position and reference from which on one follows the other."""


def of_logs(logs: Sequence[Log], plant: Plant | None = None) -> Iterator[Finding]:
    """Yield what can be held against physics in records: speed, rate, and whether their channels agree.

    logs: Records of one axis.
    plant: The plant, whose force constant the force is held against.
    """
    import numpy as np  # `fric --help` need not

    squares = np.zeros(2)
    for log in logs:
        if len(log) < 16:
            continue
        motion, where = log.motion, log.where
        yield Finding("sampling", 1.0 / float(np.median(np.diff(log.time))), motion, where)
        yield Finding("speed", _speed(log), motion, where)
        if log.velocity is not None and log.position is not None:
            step = min(8, len(log) // 4)
            moved = log.position[step:] - log.position[:-step]
            between = np.append(0.0, np.cumsum(0.5 * (log.velocity[1:] + log.velocity[:-1]) * np.diff(log.time)))
            travel = between[step:] - between[:-step]
            if np.any(travel) and np.any(moved):
                ratio = float(np.sqrt((moved @ moved) / (travel @ travel)))
                yield Finding("travel", ratio, motion, where)
        if log.position is not None and log.reference is not None and np.ptp(log.reference) and np.ptp(log.position):
            yield Finding("following", float(np.ptp(log.position) / np.ptp(log.reference)), motion, where)
            z, asked = (log.position - log.position.mean()), (log.reference - log.reference.mean())
            both, of_z, of_asked = z @ asked, z @ z, asked @ asked
            if both**2 > TOGETHER**2 * of_z * of_asked:
                yield Finding("scale", float(abs(both) / of_asked), motion, where)
        if log.force is not None and log.input is not None:
            squares += [float(log.force @ log.force), float(log.input @ log.input)]
    if squares.all():
        ratio = float(np.sqrt(squares[0] / squares[1]))
        yield Finding("force-per-input", ratio, logs[0].motion, logs[0].source)
        if plant is not None:
            yield Finding("force-constant", ratio / plant.K_f, logs[0].motion, logs[0].source)


def _speed(log: Log) -> float:
    """Return the greatest speed of a record but for a hundredth of its samples; NaN where neither channel tells."""
    import numpy as np

    if log.velocity is not None:
        return float(np.quantile(np.abs(log.velocity), 0.99))
    if log.position is None or len(log) < 4:
        return nan
    step = min(8, len(log) // 4)
    return float(
        np.quantile(np.abs(log.position[step:] - log.position[:-step]) / (log.time[step:] - log.time[:-step]), 0.99)
    )


def of_friction(static: StaticMap, motion: Motion, mass: float | None = None, where: str = "") -> Iterator[Finding]:
    """Yield what can be held against physics in a static map, and in its size beside the mass that it moves."""
    level = max(abs(static.F_s), abs(static.F_c))
    yield Finding("friction", level, motion, where, usual=0.5)
    if mass:
        yield Finding("friction-over-mass", level / mass, motion, where)
        yield Finding("viscous-over-mass", abs(static.sigma) / mass, motion, where)


def of_strokes(logs: Sequence[Log]) -> Iterator[Finding]:
    """Yield the longest travel, and the greatest speed, of the records that sliding friction is identified from."""
    import numpy as np

    strokes = []
    for log in logs:
        if log.position is not None:
            strokes.append((float(np.ptp(log.position)), log))
        elif log.velocity is not None:
            strokes.append((float(np.abs(log.velocity[1:]) @ np.diff(log.time)), log))
    if strokes:
        travel, log = max(strokes, key=lambda one: one[0])
        yield Finding("stroke", travel, log.motion, log.where)
        yield Finding("speed", max(_speed(log) for _, log in strokes), log.motion, log.where, usual=5e-4)


def of_amplitudes(logs: Sequence[Log]) -> Iterator[Finding]:
    """Yield the amplitudes of pre-sliding sines, and how often they were sampled."""
    import numpy as np

    for log in logs:
        if log.kind == "presliding-sine" and log.position is not None:
            yield Finding("amplitude", 0.5 * float(log.position.max() - log.position.min()), log.motion, log.where)
            yield Finding("sampling", 1.0 / float(np.median(np.diff(log.time))), log.motion, log.where, usual=3.0)


def of_level(logs: Sequence[Log], F_s: float) -> Iterator[Finding]:
    """Yield the force of records beside the break-away force [N] of a static map that they are replayed with."""
    swings = [0.5 * float(log.force.max() - log.force.min()) for log in logs if log.force is not None]
    if swings and F_s > 0.0:
        yield Finding("level", max(swings) / F_s, logs[0].motion, logs[0].where)


def of_shares(shares: Iterable[tuple[Log, float | None, float | None]]) -> Iterator[Finding]:
    """Yield how much of the force of each record inertia and damping are, where a plant tells: record and shares."""
    for log, *both in shares:
        for name, share in zip(("inertia", "damping"), both, strict=True):
            if share is not None:
                yield Finding(name, share, log.motion, log.where)


def of_plant(plant: Plant, motion: Motion, where: str = "") -> Iterator[Finding]:
    """Yield what can be held against physics in a plant."""
    for name, value in (("A", plant.A), ("B", plant.B), ("T_d", plant.T_d), ("mass", plant.M)):
        yield Finding(name, value, motion, where)
