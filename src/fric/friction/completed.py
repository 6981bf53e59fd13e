"""Any model with the residual force of a measured circle, over the travel since the last reversal."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fric.arrays import Real
from fric.exact import each
from fric.friction.base import Wrapped
from fric.kernels.elementary import exp
from fric.kernels.inner import address_of
from fric.kernels.left_over import AHEAD, TravelGrid, left_over_step, travels_along
from fric.kernels.signatures import Step

PLAY = 1e-6  # Travel back that makes a reversal [m]: fluctuations by encoder counts are smaller
KNEE, RATIO, STEP_BEYOND = 28, 0.25, 3e-4
"""Points that are a ratio ``e^RATIO`` apart, up to a millimetre, and the distance of those behind [m]."""


def travels(longest: float) -> Real:
    """Return the travels since a reversal at which the force is given [m], up to the longest."""
    near = PLAY * each(exp, RATIO * np.arange(KNEE + 1.0))
    return np.append(near, near[-1] + STEP_BEYOND * np.arange(1, max(int((longest - near[-1]) / STEP_BEYOND), 0) + 2))


def since_reversal(position: Real) -> tuple[Real, Real]:
    """Return direction (1, -1; 0 before the first motion) and travel since the last reversal [m], shape (n,) each."""
    found = np.zeros((2, len(position)))
    travels_along(np.ascontiguousarray(position), PLAY, found)
    return found[0], found[1]


@dataclass(frozen=True)
class Completed(Wrapped):
    """A friction model, and an added force ``r(s, direction)`` over the travel s since the last reversal.

    With the residual of a measured motion it explains that motion for any parameters of the model. Since pre-sliding,
    cogging and a level that varies with position all depend on the travel, it also predicts another motion.

    model: The model.
    forwards, backwards: The added force [N], at the first of `travels`.
    """

    forwards: tuple[float, ...]
    backwards: tuple[float, ...]

    step: ClassVar[Step] = left_over_step

    def packed(self) -> Real:
        """Return ``[address of the model's step, grid, force forwards, force backwards, the model's parameters]``."""
        grid = TravelGrid(address_of(type(self.model).step), len(self.forwards), PLAY, KNEE, RATIO, STEP_BEYOND)
        return np.array([*grid, *self.forwards, *self.backwards, *self.model.packed()])

    def initial_state(self) -> Real:
        """Return the state at rest, before any travel."""
        return np.concatenate([np.zeros(AHEAD), super().initial_state()])
