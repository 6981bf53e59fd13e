"""A sliding-mode controller with a boundary layer and an integral surface, in place of the cascade.

::

    s = ė + 2·slope·e + slope²·∫e,   e = r - z
    u = (2·slope·ė + slope²·e)/B + reach·sat(s/layer)

On the surface s = 0 the error dies out as (D + slope)²·∫e = 0, for any disturbance; outside the layer the
voltage ``reach`` drives it there, inside the sign is a straight line, against chattering. What the inverse model
gives along the reference, (r̈ + A·ṙ)/B, is added by the loop: with both u is the equivalent control and the reaching
law. The velocity is the first difference behind the cascade's low-pass, and the integral waits while the voltage is
limited. It is linear inside the layer only, and is designed there. J.-J. Slotine, W. Li, Applied
Nonlinear Control, 1991, section 7; Z. Jamaludin, H. Van Brussel, J. Swevers, Design and comparison of cascade and
sliding mode control, 2007.
"""

from dataclasses import dataclass
from typing import Annotated, Self

import numpy as np

from fric.arrays import Real
from fric.control.base import ControlBlock, Setting
from fric.drive.sensing import low_pass_pole
from fric.friction.base import Parameter
from fric.kernels.block import Sample, compiled_block

SEEN, FILTERED, INTEGRAL, PENDING = range(4)


@compiled_block
def _step(sample: Sample, n: int, rows: Real, state: Real, parameters: Real) -> float:
    slope, reaching, layer, B, pole, T_s, share = (
        parameters[0], parameters[1], parameters[2], parameters[3], parameters[4], parameters[5], parameters[6]
    )  # fmt: skip
    if sample.excess == 0.0 or sample.excess * state[PENDING] < 0.0:
        state[INTEGRAL] += state[PENDING]
    state[FILTERED] = pole * state[FILTERED] + (1.0 - pole) * (sample.measured - state[SEEN]) / T_s
    state[SEEN] = sample.measured
    e, rate = sample.reference - sample.measured, share * sample.velocity - state[FILTERED]
    state[PENDING] = T_s * e
    s = rate + 2.0 * slope * e + slope * slope * (state[INTEGRAL] + state[PENDING])
    drive: float = (2.0 * slope * rate + slope * slope * e) / B + reaching * min(max(s / layer, -1.0), 1.0)
    return drive


@dataclass(frozen=True)
class SlidingMode(ControlBlock):
    """The sliding-mode controller.

    gain: Slope of the line in the layer, reach over layer [V·s/m].
    slope: Slope of the surface: how fast the error dies out on it [1/s].
    reach: Voltage outside the layer [V].
    """

    name = "sliding-mode"
    kind = "controller"
    linear = False
    asks = "the position, a velocity from its first difference, four states"
    tuned = "gain"
    step = _step

    gain: Annotated[float, Parameter("velocity gain", 1e-3, 1e6, "slope of the line in the layer", typical=80.0)]
    slope: Annotated[float, Parameter("rate", 0.1, 1e4, "slope of the sliding surface", typical=80.0)]
    reach: Annotated[float, Parameter("input", 1e-6, 1e6, "voltage outside the layer", typical=1.0)]

    @classmethod
    def designed(cls, setting: Setting) -> Self:
        """Return the controller for the cascade's speed, with a reach of three times the nominal friction.

        The surface is a fifth of the crossover of the velocity loop that the gain makes, B·gain; without friction that
        is fed forward the reach is a third of the limit.
        """
        return cls.tuned_to(setting.cascade.K_p, setting)

    @classmethod
    def tuned_to(cls, value: float, setting: Setting) -> Self:
        """Return the controller with a slope of the line in the layer, and its surface."""
        reaching = setting.cascade.limit / 3.0
        if setting.friction is not None:
            reaching = 3.0 * abs(float(setting.friction.steady_state(1e-6))) / setting.K_f
        return cls(value, setting.plant.B * value / 5.0, float(min(reaching, 1e3)))

    def packed(self, setting: Setting) -> Real:
        """Return surface, reaching law and velocity filter."""
        cascade = setting.cascade
        pole = low_pass_pole(cascade.velocity_filter, cascade.sampling)
        given = self.slope, self.reach, self.reach / self.gain, setting.plant.B, pole, setting.T_s
        return np.array([*given, cascade.velocity_feedforward])

    def initial_state(self, setting: Setting) -> Real:
        """Return the position one sample ago, the filtered velocity, the integral and what is to join it."""
        return np.array([setting.seen, setting.velocity, 0.0, 0.0])
