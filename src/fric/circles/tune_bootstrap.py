"""How far a tuning is off where what it found is recorded again: a parametric bootstrap over what the encoder shows.

The motion behind encoder counts is known to a part of a count, and errs alike in every revolution: no scatter of
residuals tells what repeats. So the motion, the friction and the plant that were found are recorded again, with the
encoder elsewhere between two counts, and the error is what the fit makes of what these records leave at their truth.
"""

from dataclasses import replace

import numpy as np

from fric.arrays import Real
from fric.circles.measured import AxisTrace, MeasuredCircle
from fric.circles.tune_fit import Fitted
from fric.circles.voltage import VoltageRecord, refined, voltage_record
from fric.friction import FrictionModel
from fric.records.resolution import lattice_step

DRAWS = 8
"""How often each circle is recorded again."""
FEW = 3
"""The same, to tell what the encoder explains of a residual."""
SHAPE = 1.6
"""Times what noise and encoder explain that four parameters may leave; above it the full shape is fitted. Where the
shape is right they leave 1.1 to 1.4 times as much, where it is not 4 to 16. Below it is a tie: four are simpler."""


def recorded_again(found: Fitted, draws: int = DRAWS) -> list[Real]:
    """Return what circles that are recorded again leave at what was found, which is their truth [V], each (n,)."""
    rng, balance, x = np.random.default_rng(0), found.balance, found.x
    weights = np.repeat(balance.weights, [len(part) for part in found.parts()])
    left = []
    for _ in range(draws):
        records = []
        for n, record in enumerate(balance.records):
            again = voltage_record(_once_more(found, n, rng), record.axis, record)
            records.append(refined(again, *_truth(found, n)))
        once = replace(balance, records=tuple(records))
        left.append((once.voltage(x) - once.friction(x) - once.columns() @ found.plant) / weights)
    return left


def explained(found: Fitted) -> float:
    """Return the root mean square that noise and encoder explain of a fit's residual [V]: the larger of both.

    Noise is what does not repeat from turn to turn, and the encoder's share what circles leave that are recorded again.
    """
    again = [replace(found, residual=left).rms for left in recorded_again(found, FEW)]
    return max(found.noise() or 0.0, float(np.sqrt(np.mean(np.square(again)))))


def _truth(found: Fitted, n: int) -> tuple[FrictionModel, float, tuple[float, float, float], float]:
    coordinates = found.balance.coordinates
    plant = (float(found.plant[0]), float(found.plant[1]), float(found.plant[2 + n]))
    return coordinates.directed(found.x), coordinates.delay(found.x), plant, found.balance.K_f


def _once_more(found: Fitted, n: int, rng: np.random.Generator) -> MeasuredCircle:
    """Return a circle test as the machine that was found records it along the motion that was found."""
    record: VoltageRecord = found.balance.records[n]
    model, T_d, (m, a, offset), K_f = _truth(found, n)
    t, r, z_m, _ = record.raw
    z, period = record.whole, record.sampled
    velocity = np.gradient(z, t)
    acceleration = np.gradient(velocity, t)
    acceleration[1:-1] = (z[2:] - 2 * z[1:-1] + z[:-2]) / period**2
    acts = m * acceleration + a * velocity + offset + model.replay(t, z, velocity) / K_f
    # an encoder without counts, or with errors besides, errs as much as one with counts of this step
    step, phase = lattice_step(z_m) or float(np.sqrt(12.0) * np.std(z_m - z)), rng.uniform()
    seen = (np.round(z / step + phase) - phase) * step if step > 0 else z
    trace = AxisTrace(t, seen, r, np.interp(t + T_d, t, acts))
    return replace(record.test, axes={**record.test.axes, record.axis: trace})
