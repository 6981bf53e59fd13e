"""A friction feedforward whose level and stiffness adapt to the error that an observer finds.

::

    u = level·(F_1 + F_2)/(2·K_f) + shift·(F_2 - F_1)/K_f,   both along the reference a lead ahead

F_1 and F_2 are the nominal friction, once with softer and once with stiffer slip blocks: two models run
beside each other, so that u is linear in what adapts. An observer's estimate d̂ is the remaining error, -d̂ = (required
voltage) - u behind the observer's filter Q. Each regressor goes through the same Q, and both parameters follow the
gradient, normalised, within bounds (projection), which are the intervals of what was identified where it is known::

    d(level)/dt = rate·(-d̂)·φ_l/F̂²,   d(shift)/dt = rate·(-d̂)·φ_s/mean(φ_s²)

P. A. Ioannou, J. Sun, Robust Adaptive Control, 1996, section 4.4; with friction C. Canudas de Wit, P. Lischinsky,
Adaptive friction compensation with partially known dynamic friction model, Int. J. Adaptive Control 11 (1997) 65-80.
"""

from dataclasses import dataclass, replace
from math import pi
from typing import Annotated, Self

import numpy as np

from fric.arrays import Real
from fric.control.base import ControlBlock, Setting
from fric.control.reversal_pulse import nominal_friction
from fric.errors import FricError
from fric.friction.base import Parameter
from fric.kernels.block import Sample, compiled_block
from fric.kernels.elementary import exp

SOFT, STIFF = 0.6, 1.6  # Stiffness of both models over the nominal stiffness
HEAD = 7


@compiled_block
def _step(sample: Sample, n: int, rows: Real, state: Real, parameters: Real) -> float:
    size = (parameters.size - HEAD) // 2
    at = min(n, size - 1)
    soft, stiff = parameters[HEAD + at], parameters[HEAD + size + at]
    per_level, per_shift, lowest, highest, pole = (
        parameters[0], parameters[1], parameters[2], parameters[3], parameters[4]
    )  # fmt: skip
    state[0] = min(max(state[0] - per_level * sample.estimate * state[3], lowest), highest)
    shift = state[1] - per_shift * sample.estimate * state[5]
    state[1] = min(max(shift, parameters[5] * state[0]), parameters[6] * state[0])
    mean, apart = 0.5 * (soft + stiff), stiff - soft
    state[2] = pole * state[2] + (1.0 - pole) * mean
    state[3] = pole * state[3] + (1.0 - pole) * state[2]
    state[4] = pole * state[4] + (1.0 - pole) * apart
    state[5] = pole * state[5] + (1.0 - pole) * state[4]
    volts: float = state[0] * mean + state[1] * apart
    return volts


@dataclass(frozen=True)
class Adaptive(ControlBlock):
    """The adaptive feedforward.

    rate: How fast level and stiffness follow [1/s].
    cutoff: Cutoff of the observer's Q that the regressors go through [Hz].
    lowest, highest: Bounds of the level over the nominal level that is fed forward [1].
    softest, stiffest: Bounds of the stiffness over the nominal stiffness [1].
    """

    name = "adaptive"
    kind = "feedforward"
    linear = False
    feeds_back = True
    asks = "an observer beside it, the reference a lead ahead, two friction models at once; six states"
    step = _step

    rate: Annotated[float, Parameter("rate", 1e-3, 100.0, "how fast it follows", typical=4.0)]
    cutoff: Annotated[float, Parameter("frequency", 1.0, 1000.0, "cutoff of the observer beside it", typical=60.0)]
    lowest: Annotated[float, Parameter("ratio", 0.01, 1.0, "lowest level", typical=0.5)]
    highest: Annotated[float, Parameter("ratio", 1.0, 10.0, "highest level", typical=2.0)]
    softest: Annotated[float, Parameter("ratio", SOFT, 1.0, "least stiffness", typical=SOFT)]
    stiffest: Annotated[float, Parameter("ratio", 1.0, STIFF, "largest stiffness", typical=STIFF)]

    @classmethod
    def designed(cls, setting: Setting) -> Self:
        """Return the block within the intervals of what was identified: level by F_c and F_s, stiffness by each k."""
        usual = super().designed(setting)
        bounds: dict[str, float] = {}
        for lower, upper, names in (("lowest", "highest", "F_"), ("softest", "stiffest", "k_")):
            if (span := setting.span(names)) is not None:
                bounds |= {lower: max(span[0], getattr(usual, lower)), upper: min(span[1], getattr(usual, upper))}
        return replace(usual, **bounds)

    def packed(self, setting: Setting) -> Real:
        """Return rates, bounds, the filter and both models along the reference [V]."""
        model, reference = nominal_friction(setting, self.name), setting.reference
        if reference is None or not hasattr(model, "k"):
            what = "'adaptive' follows the stiffness of slip blocks along a reference, and there is none"
            raise FricError(what, hint="Identify them: fric identify gms.")
        motion, rows = reference.ahead(setting.lead), []
        for share in (SOFT, STIFF):
            other = replace(model, k=tuple(share * k for k in model.k))  # type: ignore[type-var]
            rows.append(setting.gain / setting.K_f * other.replay(motion.time, motion.position, motion.velocity))
        mean, apart = 0.5 * (rows[0] + rows[1]), rows[1] - rows[0]
        level, shift = (max(float(np.mean(part**2)), 1e-12) for part in (mean, apart))
        pole = exp(-2 * pi * self.cutoff * setting.T_s)
        step = self.rate * setting.T_s
        middle = 0.5 * (SOFT + STIFF)  # the stiffness without a shift: half a level shifts to either model
        limits = [(limit - middle) / (STIFF - SOFT) for limit in (self.softest, self.stiffest)]
        return np.concatenate([[step / level, step / shift, self.lowest, self.highest, pole, *limits], *rows])

    def initial_state(self, setting: Setting) -> Real:
        """Return the nominal level and stiffness, and empty filters."""
        return np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
