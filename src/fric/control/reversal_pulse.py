"""Friction compensation of commercial controls: a table over velocity, and a pulse where the reference reverses.

::

    u = sign(v)·(table(v) + p) + ∫p·sign(v)/integral dt,   p = amplitude(a)·exp(-(t - t_0)/decay)

The table gives a voltage for twenty velocities, straight lines between, as TwinCAT's friction compensation; at a
reversal it goes from one sign to the other over its first entry. The pulse is that of SINUMERIK's friction
compensation (Siemens, Function manual monitoring and compensating, K3): its amplitude rises with the acceleration a
at the reversal, a share of it for each of three accelerations, and dies out with the decay. Both are fitted to a
friction model that was identified: the table to its steady state, the pulse to the difference between its replay along
circles and the table.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Self

import numpy as np

from fric.arrays import Real
from fric.control.base import ControlBlock, Setting
from fric.errors import FricError
from fric.estimate import as_filed
from fric.exact import each, geometric
from fric.friction import FrictionModel
from fric.friction.base import Parameter
from fric.kernels.block import AHEAD_VELOCITY, Sample, compiled_block
from fric.kernels.elementary import exp, log
from fric.reference import circle

ENTRIES = 20
HEAD = 10
ACCELERATIONS = (0.003, 0.03, 0.33)  # Accelerations at fitted reversals [m/s²]: circles of 30 mm at 10, 30, 100 mm/s


@compiled_block
def _step(sample: Sample, n: int, rows: Real, state: Real, parameters: Real) -> float:
    v = rows[AHEAD_VELOCITY, n]
    if v * state[0] < 0.0:
        rate = abs(v - state[2]) / parameters[6]
        straight = parameters[7] > 0.0
        at = rate if straight else log(max(rate, 1e-12))
        if at <= parameters[0]:
            state[1] = parameters[3] * (at / parameters[0] if straight else 1.0)
        elif at >= parameters[2]:
            state[1] = parameters[5]
        else:
            k = 0 if at <= parameters[1] else 1
            share = (at - parameters[k]) / (parameters[k + 1] - parameters[k])
            state[1] = (1.0 - share) * parameters[3 + k] + share * parameters[4 + k]
    else:
        state[1] *= parameters[8]
    if v != 0.0:
        state[0] = 1.0 if v > 0.0 else -1.0
    state[2] = v
    state[3] += parameters[9] * state[0] * state[1]
    speed, i = abs(v), 0
    while i < ENTRIES - 1 and parameters[HEAD + i] < speed:
        i += 1
    x_0, y_0 = (parameters[HEAD + i - 1], parameters[HEAD + ENTRIES + i - 1]) if i > 0 else (0.0, 0.0)
    x_1, y_1 = parameters[HEAD + i], parameters[HEAD + ENTRIES + i]
    volts: float = state[0] * (y_0 + (y_1 - y_0) * min((speed - x_0) / (x_1 - x_0), 1.0) + state[1]) + state[3]
    return volts


@dataclass(frozen=True)
class ReversalPulse(ControlBlock):
    """The table over velocity and the pulse at a reversal.

    slow, middle, fast: Amplitude of the pulse at each of `ACCELERATIONS` [V], straight lines over the logarithm
        between; negative where friction builds up more slowly than in the table.
    decay: Time in which the pulse falls to 1/e [s].
    slow_at, middle_at, fast_at: The accelerations of those amplitudes [m/s²].
    straight: 1 for straight lines over the acceleration itself, from none at rest, as SINUMERIK's adaptive
        characteristic.
    integral: Integral time of the controller that the pulse goes through [s]; 0 where it is added to the voltage.
    table: Share of the table that is added [1].
    """

    name = "reversal-pulse"
    kind = "feedforward"
    linear = False
    asks = "the reference alone: its velocity and reversals; a table of twenty voltages, four states"
    step = _step

    slow: Annotated[float, Parameter("input", -1e5, 1e5, "amplitude at a slow reversal", typical=0.0)]
    middle: Annotated[float, Parameter("input", -1e5, 1e5, "amplitude at a middling reversal", typical=0.0)]
    fast: Annotated[float, Parameter("input", -1e5, 1e5, "amplitude at a fast reversal", typical=0.0)]
    decay: Annotated[float, Parameter("time", 1e-4, 10.0, "decay of the pulse", typical=0.01)]
    slow_at: Annotated[float, Parameter("acceleration", 1e-6, 1e3, "acceleration of a slow one")] = ACCELERATIONS[0]
    middle_at: Annotated[float, Parameter("acceleration", 1e-6, 1e3, "of a middling one")] = ACCELERATIONS[1]
    fast_at: Annotated[float, Parameter("acceleration", 1e-6, 1e3, "of a fast one")] = ACCELERATIONS[2]
    straight: Annotated[float, Parameter("ratio", 0.0, 1.0, "1: lines over the acceleration, not its logarithm")] = 0.0
    integral: Annotated[float, Parameter("time", 0.0, 1e3, "integral time of a controller before the voltage")] = 0.0
    table: Annotated[float, Parameter("ratio", 0.0, 1.0, "share of the table")] = 1.0

    @classmethod
    def designed(cls, setting: Setting) -> Self:
        """Return the pulse that fits the friction that the controller believes in."""
        pulse = fitted(nominal_friction(setting, cls.name), setting.sampling)
        slow, middle, fast = (setting.gain / setting.K_f * value for value in pulse[:3])
        return cls(slow, middle, fast, pulse[3])

    def packed(self, setting: Setting) -> Real:
        """Return accelerations or logarithms, amplitudes, T_s, straight, decay and integral in a sample, table."""
        v, T_s = geometric(1e-4, 1.0, ENTRIES), setting.T_s
        table = np.zeros(ENTRIES)
        if self.table > 0:
            model = nominal_friction(setting, self.name)
            table = self.table * setting.gain / setting.K_f * np.asarray(model.steady_state(v))
        at = np.array([self.slow_at, self.middle_at, self.fast_at])
        knots = at if self.straight else each(log, at)
        gathers = T_s / self.integral if self.integral > 0 else 0.0
        head = [*knots, self.slow, self.middle, self.fast, T_s, self.straight, exp(-T_s / self.decay), gathers]
        return np.concatenate([head, v, table])

    def initial_state(self, setting: Setting) -> Real:
        """Return a reference that has not moved, and no pulse."""
        return np.zeros(4)


def nominal_friction(setting: Setting, name: str) -> FrictionModel:
    """Return the richest friction that the controller believes in; raise a `FricError` where it believes in none."""
    for model in ("gms", "static", *setting.models):
        if model in setting.models:
            return setting.models[model]
    what = f"'{name}' goes by the friction that was identified, and the controller believes in none"
    raise FricError(what, hint="Identify it: fric identify gms.")


@lru_cache(maxsize=16)
def fitted(model: FrictionModel, sampling: float) -> tuple[float, float, float, float]:
    """Return amplitude [N] at each acceleration and decay [s] that come nearest to a model's replay along circles."""
    parts = []
    for rate in ACCELERATIONS:
        motion = circle(0.03, float(np.sqrt(rate * 0.03)), 1, sampling)[0]
        reversal = int(np.flatnonzero(np.diff(np.sign(motion.velocity[1:])) != 0)[1]) + 2  # the second is at full feed
        window = slice(reversal, reversal + int(0.04 * sampling))
        F = model.replay(motion.time, motion.position, motion.velocity)[window]
        heading = np.sign(motion.velocity[window])
        parts.append(heading * F - np.asarray(model.steady_state(np.abs(motion.velocity[window]))))
    t = np.arange(len(parts[0])) / sampling
    scale = float(np.abs(parts[-1]).max()) or 1.0

    def misfit(x: Real) -> Real:
        return np.asarray(x[0] * np.exp(-t / exp(x[1])) - parts[-1] / scale)

    # a single decay serves all reversals: that of the fast reversal, where the spike is
    from scipy.optimize import least_squares

    found = least_squares(misfit, [-1.0, log(0.01)], bounds=([-5.0, -8.0], [5.0, 1.0]))
    pulse = np.exp(-t / exp(found.x[1]))
    fitting = (float(pulse @ part / (pulse @ pulse)) for part in parts)
    # friction turns from one level to the other
    slow, middle, fast = (min(max(value, -scale), scale) for value in fitting)
    return as_filed((slow, middle, fast, exp(found.x[1])))
