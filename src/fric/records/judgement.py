"""Information of a record on friction, judged in common for `inspect`, every `identify` and `compare`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Indices, Mask, Real
from fric.estimate import Estimate
from fric.flaws.channel import ENCODER_TOO_COARSE
from fric.flaws.drift import ENERGY_DRIFTS, ENERGY_IN_ONE_SEGMENT
from fric.notice import Notice

if TYPE_CHECKING:
    from fric.records.prepared import Prepared

STEPS = 3.0  # Least amplitude in encoder steps to show pre-sliding
RESOLVED = 4.0  # Least distance in encoder steps of a knot from the reversal, and from the previous knot
SAMPLES = 3  # Least number of samples after a reversal that show a stiffness
SATURATED = 0.05  # Least slope of a branch, relative to its mean slope, under which it has reached its plateau
RISES = 0.2  # The same for logged branches, which include viscous friction: above it they surely have no plateau
CONDITION = 1e3  # Condition number up to which a motion separates mass, viscous and Coulomb friction


@dataclass(frozen=True)
class Identifiability:
    """Information of several records on friction, together."""

    slides: bool  # False where the force rises up to every reversal, so that no branch ever slides
    slope: float  # Least slope of the branches that come nearest to a plateau, relative to their mean slope
    peak: float  # Largest friction force: half of its swing between reversals [N]
    resolved: float  # Shortest travel after a reversal that is seen [m]: a count, and that in `SAMPLES` samples


def identifiability_of(records: Sequence[Prepared]) -> Identifiability:
    """Return the information of prepared records on friction."""
    slopes, peaks, resolved = [], [], []
    for record in records:
        reversals = record.reversals[record.reversals < len(record.force)]
        if record.slides or len(reversals) < 2:
            slopes.append(0.0)
            continue
        z, force = record.motion.position, record.force - _inertia(record)
        slopes.append(branch_slope(z, force, reversals))
        peaks.append(0.5 * float(np.median([np.ptp(force[a : b + 1]) for a, b in pairwise(reversals)])))
        resolved.append(max(record.motion.step, resolved_travel(z, reversals)))
    slope = min(slopes, default=0.0)
    return Identifiability(slope < RISES, slope, max(peaks, default=0.0), min(resolved, default=0.0))


def _inertia(record: Prepared) -> Real | float:
    """Return the inertia [N], shape (n,), of a record with a fitted mass: it rises like a stiffness.

    By least squares of the force on acceleration, sign of the velocity, velocity and an offset. A stiffness would give
    a negative mass, and is excluded.
    """
    m = record.motion
    if "mass" not in record.done.own:
        return 0.0
    basis = np.column_stack([m.acceleration, np.sign(m.velocity), m.velocity, np.ones_like(m.time)])[record.used]
    size = np.abs(basis).max(axis=0, initial=1e-300)
    mass, coulomb, *_ = np.linalg.lstsq(basis / size, record.force[record.used], rcond=None)[0] / size
    return m.acceleration * mass if mass > 0.0 < coulomb else 0.0


def too_coarse(records: Sequence[Prepared]) -> list[Notice]:
    """Return the records whose encoder is too coarse for their motion, judged as by `inspect`, with warnings."""
    found = []
    for record in records:
        z = record.motion.position
        inside = record.reversals[record.reversals < len(z)]
        if record.slides or not record.motion.step:
            continue
        strokes = np.abs(np.diff(z[inside])) if len(inside) > 2 else np.ptp(z)  # so small that no reversal is seen
        steps = 0.5 * float(np.median(strokes)) / record.motion.step
        if steps < STEPS:
            found.append(ENCODER_TOO_COARSE.found(f"record '{record.name}'", steps=steps))
    return found


def branch_slope(position: Real, force: Real, reversals: Indices) -> float:
    """Return the least slope of the branches between reversals, relative to their mean slope; see `least_slope`.

    The branches are averaged over the share of their travel, in fiftieths. A branch starts with the force at the end of
    the branch before: its first samples may have risen already.
    """
    grid = (np.arange(50) + 0.5) / 50
    branches, before = [], None
    for a, b in pairwise(reversals):
        z, F = position[a : b + 1], force[a : b + 1]
        travel = np.maximum.accumulate(np.abs(z - z[0]))
        end = float(np.mean(F[-max(len(F) // 20, 1) :]))
        if before is not None and end != before and len(z) >= 8 and travel[-1] > 0:
            branches.append(np.interp(grid, travel / travel[-1], (F - before) / (end - before)))
        before = end
    return least_slope(grid, np.mean(branches, axis=0)) if branches else 0.0


def least_slope(displacement: Real, force: Real) -> float:
    """Return the least slope of any fifth of a curve's outer half, relative to its mean slope [1].

    A concave curve is flattest at its end. If the Stribeck effect is not divided out, the force rises again as the
    motion slows down, which is not a stiffness.
    """
    slopes = []
    for start in np.linspace(0.5, 0.8, 7):
        part = (displacement >= start * displacement[-1]) & (displacement <= (start + 0.2) * displacement[-1])
        if part.sum() > 2:
            slopes.append(float(np.polyfit(displacement[part] - displacement[-1], force[part], 1)[0]))
    return float(min(slopes, default=np.inf) * displacement[-1] / force[-1])


def resolved_travel(position: Real, reversals: Indices) -> float:
    """Return the travel of the axis in `SAMPLES` samples after a reversal, the median of all [m]."""
    after = np.minimum(reversals + SAMPLES, len(position) - 1)
    return float(np.median(np.abs(position[after] - position[reversals])))


def excites(time: Real, position: Real) -> bool:
    """Return whether a motion separates mass, viscous and Coulomb friction and an offset.

    Position is averaged over pieces of 10 ms or five samples, so that encoder steps do not count as acceleration.
    """
    dt = float(np.median(np.diff(time)))
    width = max(round(0.01 / dt), 5)
    count = len(position) // width
    if count < 32:
        return False
    z = position[: count * width].reshape(count, width).mean(axis=1)
    v = np.gradient(z, width * dt)
    columns = np.column_stack([np.gradient(v, width * dt), v, np.sign(v), np.ones_like(v)])
    size = np.linalg.norm(columns, axis=0)
    both = (v > 0.1 * np.abs(v).max()).any() and (v < -0.1 * np.abs(v).max()).any()
    return bool(both and (size > 0).all() and np.linalg.cond(columns / size) < CONDITION)


def cycle_energies(position: Real, force: Real, reversals: Indices) -> Real:
    """Return the energy lost in each whole cycle of two strokes, ``∮F·dz`` [J], shape (cycles,).

    position, force: The motion [m] and the force along it [N], each of shape (n,).
    reversals: Samples at which the motion reverses.
    """
    work = np.append(0.0, np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(position)))
    ends = reversals[::2]
    return np.asarray(np.diff(work[ends])) if len(ends) > 1 else np.zeros(0)


def energy_per_cycle(energies: Real) -> Estimate | None:
    """Return the mean energy of cycles with its 95 % interval by Student's t; None for fewer than two cycles."""
    if len(energies) < 2:
        return None
    mean, n = float(energies.mean()), len(energies)
    half = float(stdtrit(n - 1, 0.975) * energies.std(ddof=1) / np.sqrt(n))
    return Estimate.around(mean, "J", half)


def drift(values: Real) -> tuple[float, float]:
    """Return the change of values along their regression line from first to last, and half its 95 % interval."""
    n = len(values)
    at = (np.arange(n) - 0.5 * (n - 1)) / max(n - 1, 1)
    slope = float(at @ values / (at @ at))
    rest = values - values.mean() - slope * at
    error = float(np.sqrt(rest @ rest / (n - 2) / (at @ at)))
    return slope, float(stdtrit(n - 2, 0.975)) * error


CHANGES = 0.03  # Least change of the energy per cycle over a record that gives a warning, as a share
STANDS_OFF = 0.1  # Least deviation of the energy of cycles from the others that gives a warning, as a share


def energy_warnings(energies: Real, ends: Real) -> list[Notice]:
    """Return the warnings from the energies of equal cycles of a record: outlying cycles in one segment, or a drift.

    ends: Instants at which the cycles begin, and the last cycle ends [s], shape (n + 1,).
    """
    if len(energies) < 4:
        return []
    usual = float(np.median(energies))
    off = np.flatnonzero(np.abs(energies - usual) > STANDS_OFF * abs(usual))
    spread = float(np.median(np.abs(energies - usual)))
    off = off[np.abs(energies[off] - usual) > 6 * spread]
    if len(off) and len(off) < 0.5 * len(energies) and off[-1] - off[0] + 1 == len(off):
        there, elsewhere = float(energies[off].mean()), float(np.delete(energies, off).mean())
        span = {"begin": float(ends[off[0]]), "end": float(ends[off[-1] + 1])}
        return [ENERGY_IN_ONE_SEGMENT.found(there=Estimate(there, "J"), elsewhere=Estimate(elsewhere, "J"), **span)]
    change, half = drift(energies)
    if abs(change) <= max(half, CHANGES * abs(usual)):
        return []
    return [ENERGY_DRIFTS.found(change=change / usual, half=half / abs(usual))]


def energy_changes(record: Prepared, modelled: Real, seen: Mask) -> Iterator[Notice]:
    """Yield the warnings about changes during a record, by the ratio of its cycles' energy to that of a model.

    modelled: The model's force along the motion [N], shape (n,).
    seen: Samples whose cycles count, shape (n,).
    """
    motion, reversals = record.motion, record.reversals
    reversals = reversals[seen[np.minimum(reversals, len(seen) - 1)]]
    measured, replayed = (cycle_energies(motion.position, force, reversals) for force in (record.force, modelled))
    usual = float(np.sum(replayed)) / max(len(replayed), 1)
    for notice in energy_warnings(measured / replayed * usual, motion.time[reversals[::2]]):
        yield notice.at(f"record '{record.name}'")
