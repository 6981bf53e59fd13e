"""A cascade whose gains follow the stiffness of the friction since the last reversal of the reference.

After a reversal every slip block of the believed friction sticks: the drive stands against a spring. Block i slips
after a way of ``2·alpha_i·F_s/k_i`` (Masing's rule), so that a distance x from the reversal the stiffness is::

    K(x) = Σ k_i  over the blocks with  x/4 < 2·alpha_i·F_s/k_i,      share(x) = min(1, sqrt(K(x)/M)/corner)
    u    = K_p·(1 + proportional·share)·error + ∫ K_i·(1 + integral·share)·error,   error as that of the cascade

A drive on a spring is no double integrator: below the spring's natural frequency sqrt(K/M) its phase does not fall to
-180°, and the integral may be as much stronger there. The corner, 0.4 of the velocity loop's crossover B·K_p, is
where the phase is needed. Where the blocks have slipped the gains are those of the cascade. The way counts a quarter:
on 40 drawn machines, some of them softer than is believed, gains that fall back at once leave 5.5 µm at the 95th
percentile, with the quarter 3.1, and with less no less. Not linear. T. Tjahjowidodo, F. Al-Bender, H. Van Brussel, W.
Symens, Friction characterization and compensation in electro-mechanical systems, J. Sound and Vibration 308 (2007)
632-646.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

from fric.control.base import ControlBlock, Setting
from fric.drive.sensing import low_pass_pole
from fric.errors import FricError
from fric.friction.base import Parameter
from fric.kernels.block import Sample, compiled_block

if TYPE_CHECKING:
    from numpy.typing import NDArray

SEEN, FILTERED, INTEGRAL, PENDING, TURNED, HEADING, LEVEL = range(7)
HEAD = 8
SOFTER = 4.0
"""By how much softer the friction may be than is believed: the gains stay for a way that is as much longer."""


@compiled_block
def _step(
    sample: Sample, n: int, rows: NDArray[np.float64], state: NDArray[np.float64], parameters: NDArray[np.float64]
) -> float:
    K_v, K_p, per_sample, pole, T_s = parameters[0], parameters[1], parameters[2], parameters[3], parameters[4]
    proportional, integral, smooth = parameters[5], parameters[6], parameters[7]
    if sample.excess == 0.0 or sample.excess * state[PENDING] < 0.0:
        state[INTEGRAL] += state[PENDING]
    state[FILTERED] = pole * state[FILTERED] + (1.0 - pole) * (sample.measured - state[SEEN]) / T_s
    state[SEEN] = sample.measured
    if sample.velocity * state[HEADING] < 0.0 or state[HEADING] == 0.0:
        state[TURNED] = sample.reference
    if sample.velocity != 0.0:
        state[HEADING] = 1.0 if sample.velocity > 0.0 else -1.0
    away, share = abs(sample.reference - state[TURNED]), 0.0
    for i in range((parameters.size - HEAD) // 2):
        if away < parameters[HEAD + 2 * i]:
            share = parameters[HEAD + 2 * i + 1]
            break
    state[LEVEL] += smooth * (share - state[LEVEL])
    error = K_v * (sample.reference - sample.measured) + sample.velocity - state[FILTERED]
    state[PENDING] = per_sample * (1.0 + integral * state[LEVEL]) * error
    volts: float = K_p * (1.0 + proportional * state[LEVEL]) * error + state[INTEGRAL] + state[PENDING]
    return volts


@dataclass(frozen=True)
class GainScheduled(ControlBlock):
    """The cascade with scheduled gains.

    Parameters
    ----------
    proportional, integral
        By which share of themselves K_p and K_i are larger while the friction is stiff [1].
    """

    name = "gain-scheduled"
    kind = "controller"
    linear = False
    asks = "the position, a velocity from its first difference, the reference's reversals; seven states"
    parameters = (
        Parameter("proportional", "ratio", 1e-3, 20.0, doc="what is added to K_p while friction is stiff", typical=0.3),
        Parameter("integral", "ratio", 0.0, 100.0, doc="what is added to K_i while friction is stiff", typical=5.0),
    )
    tuned = "proportional"
    step = _step

    proportional: float
    integral: float

    @classmethod
    def tuned_to(cls, value: float, setting: Setting) -> Self:
        """Return the block with what is added to K_p, and twelve times as much added to K_i."""
        return cls(value, 12.0 * value)

    def schedule(self, setting: Setting) -> NDArray[np.float64]:
        """Return how far from a reversal each share ends, and the share [m], [1], shape (blocks, 2).

        Raises
        ------
        FricError
            When the controller believes in no friction with slip blocks.
        """
        model = setting.models.get("gms") or setting.models.get("maxwell_slip")
        if model is None:
            raise FricError(
                "the gains of 'gain-scheduled' follow the friction's slip blocks, and the controller believes in none",
                hint="Identify them: fric identify gms.",
            )
        alpha, k = np.array(model.alpha), np.array(model.k)  # type: ignore[attr-defined]
        ends = SOFTER * 2.0 * alpha * float(model.static.F_s) / k  # type: ignore[attr-defined]
        order = np.argsort(ends)
        stiffness = np.cumsum(k[order][::-1])[::-1]
        frequency = np.sqrt(stiffness * setting.plant.B / setting.K_f)
        corner = 0.4 * setting.plant.B * setting.cascade.K_p
        return np.column_stack([ends[order], np.minimum(1.0, frequency / corner)])

    def packed(self, setting: Setting) -> NDArray[np.float64]:
        """Return the cascade's gains, what is added to them, and the schedule."""
        own = setting.cascade
        pole = low_pass_pole(own.velocity_filter, own.sampling)
        smooth = 1.0 - low_pass_pole(own.velocity_filter / 5.0, own.sampling)
        head = [own.K_v, own.K_p, own.K_i * own.T_s, pole, own.T_s, self.proportional, self.integral, smooth]
        return np.concatenate([head, self.schedule(setting).ravel()])

    def initial_state(self, setting: Setting) -> NDArray[np.float64]:
        """Return the cascade's state, and a reference that turns where it begins."""
        return np.array([setting.seen, setting.velocity, 0.0, 0.0, setting.position, 0.0, 1.0])
