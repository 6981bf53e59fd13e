"""Two encoders of an axis, at the motor and at the load: lost motion and stiffness of the transmission."""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from fric.arrays import Indices, Real
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.channel import TWO_ENCODERS
from fric.log import Log
from fric.notice import Notice
from fric.records.motion import find_reversals
from fric.records.segments import SHORTEST
from fric.statistics import jackknife
from fric.units import si_unit

Encoder = Literal["motor", "load"]  # The encoder whose position is that of the axis
AFTER = 0.1  # Share of a stroke after a reversal that is left out, in which the transmission takes up its backlash
STROKES = 3  # Least number of strokes
BESIDE = 3  # Distance in samples at which the force has independent noise


@dataclass(frozen=True)
class Transmission:
    """Properties of a transmission from the difference of two encoders: ``z_m - z_l = c + e·z_m + s·h/2``, and with
    force ``… + F/K``.

    Here s is the direction. The stiffness uses the whole force: inertia and friction of the motor do not pass through
    the transmission, which is softer by their share of the force.

    lost_motion: width h of the hysteresis between both encoders, backlash and wind-up together [m]
    stiffness: force over wind-up, at most; null where force and direction do not separate [N/m]
    wind_up: difference over the range of the force (1 % to 99 %), at least; null likewise [m]
    """

    lost_motion: Estimate
    stiffness: Estimate | None = None
    wind_up: Estimate | None = None


def transmission_of(log: Log) -> Transmission | None:
    """Return the transmission by two encoders of a record; None without both, or without strokes in both directions."""
    if log.position is None or log.load_position is None:
        return None
    z, turns = log.position, find_reversals(log.position)
    edges = np.array([0, *turns, len(z) - 1])
    whole = [(a, b) for a, b in pairwise(edges) if b - a >= SHORTEST]
    stroke, sense = np.full(len(z), -1), np.zeros(len(z))
    for n, (a, b) in enumerate(whole):
        stroke[a:b][np.abs(z[a:b] - z[a]) > AFTER * abs(z[b] - z[a])] = n
        sense[a:b] = np.sign(z[b] - z[a])
    used = stroke >= 0
    label = stroke[used]
    if len(np.unique(label)) < STROKES or len(np.unique(sense[used])) < 2:
        return None
    unit, difference = log.unit("position"), (z - log.load_position)[used]
    span = float(np.ptp(z)) or 1.0
    columns = np.column_stack([np.ones(len(label)), z[used] / span, 0.5 * sense[used]])

    values, half = _fitted(columns, columns, difference, label)
    lost = Estimate.around(float(values[2]), unit, float(half[2]))
    if log.force is None or not np.ptp(log.force[used]):
        return Transmission(lost)
    size = float(np.ptp(log.force[used]))
    force = log.force / size
    beside = 0.5 * (np.roll(force, BESIDE) + np.roll(force, -BESIDE))  # without the noise of the sample
    instruments = np.column_stack([columns, beside[used]])
    values, half = _fitted(np.column_stack([columns, force[used]]), instruments, difference, label)
    yields, sure = float(values[3]), float(half[3])
    if not sure < 0.5 * yields:  # of friction alone, force and direction are one
        return Transmission(lost)
    stiff = Estimate(size / yields, si_unit("stiffness", log.motion), (size / (yields + sure), size / (yields - sure)))
    low, high = np.quantile(log.force, [0.01, 0.99])
    share = float(high - low) / size
    return Transmission(lost, stiff, Estimate.around(share * yields, unit, share * sure))


def _fitted(basis: Real, instruments: Real, values: Real, label: Indices) -> tuple[Real, Real]:
    """Return coefficients by two-stage least squares, and half their 95 % intervals by the jackknife over strokes.

    Noise of the force would bias its coefficient towards 0: the force at neighbouring samples is the instrument.
    """
    stage = instruments @ np.linalg.lstsq(instruments, basis, rcond=1e-12)[0]
    found = np.asarray(np.linalg.lstsq(stage, values, rcond=1e-12)[0])
    return found, np.asarray(np.sqrt(np.diag(jackknife(stage, values - basis @ found, label))))


def two_encoders(log: Log) -> Notice | None:
    """Return the notice on two encoders of a record, and on the encoder used for friction."""
    if log.load_position is None:
        return None
    found = transmission_of(log)
    return TWO_ENCODERS.found(log.where, lost=found and found.lost_motion, stiffness=found and found.stiffness)


def by_encoder(log: Log, encoder: Encoder) -> Log:
    """Return a record with the position of the motor's encoder, unchanged, or with that of the load's.

    Raises FricError: When the load's is requested, and the record has none.
    """
    if encoder == "motor":
        return log
    if log.load_position is None:
        raise FricError(
            "there is no load_position, the load's encoder", where=log.where,
            hint="Map its column to `load_position`, or take the motor's encoder.",
        )  # fmt: skip
    return replace(log, position=log.load_position, load_position=None, velocity=None)
