"""The cascade controller of one axis: position P, velocity PI."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from fric.arrays import Real
from fric.control.base import CascadeGains, Setting
from fric.drive.sensing import low_pass_pole
from fric.kernels.block import Sample, compiled_block

SEEN, FILTERED, INTEGRAL, PENDING = range(4)


@compiled_block
def _step(sample: Sample, n: int, rows: Real, state: Real, parameters: Real) -> float:
    K_v, K_p, per_sample, pole, T_s, share = (
        parameters[0], parameters[1], parameters[2], parameters[3], parameters[4], parameters[5]
    )  # fmt: skip
    if sample.excess == 0.0 or sample.excess * state[PENDING] < 0.0:
        state[INTEGRAL] += state[PENDING]  # where the voltage is limited the integral waits, unless it leads out
    state[FILTERED] = pole * state[FILTERED] + (1.0 - pole) * (sample.measured - state[SEEN]) / T_s
    state[SEEN] = sample.measured
    error = K_v * (sample.reference - sample.measured) + share * sample.velocity - state[FILTERED]
    state[PENDING] = per_sample * error
    volts: float = K_p * error + state[INTEGRAL] + state[PENDING]
    return volts


@dataclass(frozen=True)
class Cascade(CascadeGains):
    """Position P, velocity PI, with velocity and inverse-model feedforward (Fig. 6 of the paper).

    ::

        r ──┬─────────────────────────── d/dt ─┐        ┌── (z̈_r + A·ż_r)/B + friction feedforward
            │                                  v        v
            └──>(+)── K_v ───────────────────>(+)─ PI ─>(+)──> limit ──> u
                 ^-                            ^-
                 z                             ż  (first difference and low-pass of z)

    Against wind-up the integral waits while the voltage is limited, unless it leads out of the limit.

    K_v: position gain [1/s]
    K_p: proportional velocity gain [V*s/m]
    K_i: integral velocity gain [V/m]
    velocity_filter: corner of the low-pass on the velocity, a first difference [Hz]
    sampling: of the controller [Hz]
    limit: saturation of the control voltage; none where left out [V]
    velocity_feedforward: share of the reference velocity and of the inverse model that is fed forward: 0 of a drive
        whose velocity feedforward is off, which lags by 1/K_v [1]
    acceleration_feedforward: what is left of that share for the inverse model: 0 of a drive that feeds forward the
        velocity alone [1]

    Raises FricError: When a value is not positive (K_i may be zero).
    """

    name = "cascade"
    kind = "controller"
    linear = True
    asks = "the position, a velocity from its first difference, four states"
    step = _step

    def followed(self, reference: Real) -> Real:
        """Return the motion of a perfect axis, ``(K_v + share·s)/(K_v + s)`` times a reference that begins at rest.

        reference: Position [m], shape (n,).
        """
        from scipy.signal import lfilter

        each, share = 0.5 * self.K_v * self.T_s, self.velocity_feedforward
        late = lfilter([each, each], [1.0 + each, each - 1.0], reference - reference[0]) + reference[0]
        return np.asarray(reference if share == 1.0 else share * reference + (1.0 - share) * late)

    @classmethod
    def designed(cls, setting: Setting) -> Self:
        """Return the cascade of the axis."""
        return cls(**vars(setting.cascade))

    def packed(self, setting: Setting) -> Real:
        """Return the parameters as the compiled step reads them."""
        pole = low_pass_pole(self.velocity_filter, self.sampling)
        return np.array([self.K_v, self.K_p, self.K_i * self.T_s, pole, self.T_s, self.velocity_feedforward])

    def initial_state(self, setting: Setting) -> Real:
        """Return the position one sample ago, the filtered velocity, the integral and what is to join it."""
        return np.array([setting.seen, setting.velocity, 0.0, 0.0])
