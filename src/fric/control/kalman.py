"""A Kalman filter that estimates the disturbance: position, velocity, and a voltage that wanders.

::

    x = [z, ż, d],   z̈ = B·(u_t(t - T_d) + d) - A·ż,   d[n+1] = d[n] + w[n],   measured = z + e

with the plant sampled exactly, the delay of the voltage included (`fric.drive.plant`). The gains are those of the
steady state (discrete algebraic Riccati equation). With white w and e, and A small beside the cutoff, the filter's
poles are those of a third-order Butterworth filter of angular frequency ``ω = (B·sqrt(q/r))^(1/3)``, q and r the
intensities of w and e: so the cutoff determines q/r, and is the design parameter. Lampaert, Swevers, Al-Bender,
Comparison of model and non-model based friction compensation techniques in the neighbourhood of pre-sliding friction,
Proc. ACC 2004.
"""

from dataclasses import dataclass
from math import pi
from typing import Annotated

import numpy as np

from fric.arrays import Real
from fric.control.base import ControlBlock, Setting
from fric.drive.plant import SampledPlant
from fric.exact import riccati
from fric.friction.base import Parameter
from fric.kernels.block import Sample, compiled_block

OWN = 3  # States before those of the delayed voltages: position, velocity and disturbance


@compiled_block
def _step(sample: Sample, n: int, rows: Real, state: Real, parameters: Real) -> float:
    delayed = state.size - OWN
    for i in range(delayed - 1, 0, -1):
        state[OWN + i] = state[OWN + i - 1]
    state[OWN] = sample.control
    newer, older = state[OWN + delayed - 2], state[OWN + delayed - 1]
    z = state[0] + parameters[0] * state[1] + parameters[2] * newer + parameters[4] * older + parameters[6] * state[2]
    v = parameters[1] * state[1] + parameters[3] * newer + parameters[5] * older + parameters[7] * state[2]
    error = sample.measured - z
    state[0] = z + parameters[8] * error
    state[1] = v + parameters[9] * error
    state[2] += parameters[10] * error
    estimate: float = state[2]
    return estimate


@dataclass(frozen=True)
class Kalman(ControlBlock):
    """The Kalman filter as a disturbance observer.

    cutoff: Angular frequency of its Butterworth poles over 2π [Hz].
    """

    name = "kalman"
    kind = "observer"
    linear = True
    asks = "position, voltage as limited less the friction feedforward, delay; 3 states and the voltages on their way"
    tuned = "cutoff"
    step = _step

    cutoff: Annotated[float, Parameter("frequency", 1.0, 300.0, "cutoff of the estimate", typical=40.0)]

    def sampled(self, setting: Setting) -> tuple[SampledPlant, Real]:
        """Return the sampled plant, and the change of position and velocity in one sample by a disturbance of 1 V."""
        return SampledPlant.of(setting.plant, setting.sampling), setting.plant.held(setting.T_s)[1]

    def gains(self, setting: Setting) -> Real:
        """Return the steady gains from the error of the predicted position to position, velocity, disturbance, (3,)."""
        plant, pushed = self.sampled(setting)
        Phi = [[*row, push] for row, push in zip(plant.Phi.tolist(), pushed.tolist(), strict=True)] + [[0.0, 0.0, 1.0]]
        # q over r, both per sample; z in units in which the Riccati equation is well scaled
        ratio = ((2 * pi * self.cutoff) ** 3 / setting.plant.B * setting.T_s) ** 2
        scale = [1.0, setting.T_s, setting.T_s**2 * setting.plant.B]
        back = [[Phi[j][i] * scale[j] / scale[i] for j in range(3)] for i in range(3)]
        measured, noise = ([[float(i == j == number) for j in range(3)] for i in range(3)] for number in (0, 2))
        noise[2][2] = ratio * scale[2] ** 2
        P = riccati(back, measured, noise)
        return np.array([row[0] / (P[0][0] + 1.0) / unit for row, unit in zip(P, scale, strict=True)])

    def packed(self, setting: Setting) -> Real:
        """Return the sampled plant and the gains."""
        plant, pushed = self.sampled(setting)
        return np.concatenate([plant.Phi[:, 1], plant.early, plant.late, pushed, self.gains(setting)])

    def initial_state(self, setting: Setting) -> Real:
        """Return position, velocity, no disturbance, and no voltages on their way."""
        return np.array([setting.seen, setting.velocity, 0.0, *np.zeros(self.sampled(setting)[0].whole + 2)])
