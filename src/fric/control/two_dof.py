"""The robust motion controller with two degrees of freedom: an observer that waits for the drive as long as it takes.

::

    d̂ = Q·(G_n⁻¹·z - e^(-s·(T_d - T_s/2))·u_t),   Q = (3·τ·s + 1)/(τ·s + 1)³,   τ = 1/(2π·cutoff)

Q is the Q_31 of Umeno and Hori: 1 - Q is of second order at rest, so that a ramp of disturbance leaves no error. The
voltage is delayed as in the drive before it is compared with that from the position, interpolated between samples:
without that, the difference of both is an error of phase that limits Q. The other degree of freedom, the inverse model
along the reference, is the feedforward that every scheme has. T. Umeno, Y. Hori, Robust speed control of DC servomotors
using modern two degrees-of-freedom controller design, IEEE Trans. Ind. Electron. 38 (1991) 363-368; J. Yi, M. Tomizuka,
ACC 1999.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from fric.arrays import Real
from fric.control.base import ControlBlock, Setting
from fric.control.inverse_model import DisturbanceObserver, filtered
from fric.control.q_filter import QFilter
from fric.friction.base import Parameter
from fric.kernels.block import Sample, compiled_block

ORDER = 3
SIZE = ORDER + 1


@compiled_block
def _step(sample: Sample, n: int, rows: Real, state: Real, parameters: Real) -> float:
    inverse, low_pass, delayed = state[1:SIZE], state[SIZE : SIZE + ORDER], state[SIZE + ORDER :]
    for i in range(delayed.size - 1, 0, -1):
        delayed[i] = delayed[i - 1]
    delayed[0] = sample.control
    share, last = parameters[4 * SIZE], delayed.size - 1
    late = (1.0 - share) * delayed[last - 1] + share * delayed[last]
    filtered(parameters[2 * SIZE : 3 * SIZE], parameters[3 * SIZE : 4 * SIZE], low_pass, late)
    position = sample.measured - state[0]
    estimate: float = filtered(parameters[:SIZE], parameters[SIZE : 2 * SIZE], inverse, position) - low_pass[0]
    return estimate


@dataclass(frozen=True)
class TwoDegrees(ControlBlock):
    """The observer of Umeno and Hori, matched to the delay.

    cutoff: Corner frequency 1/(2π·τ) of Q [Hz].
    """

    name = "two-dof"
    kind = "observer"
    linear = True
    asks = "position, voltage as limited less the friction feedforward, delay; 7 states and the voltages on their way"
    tuned = "cutoff"
    step = _step

    cutoff: Annotated[float, Parameter("frequency", 1.0, 300.0, "corner of Q", typical=40.0)]

    def late(self, setting: Setting) -> tuple[int, float]:
        """Return whole samples and share of the nominal transport delay."""
        whole, share = divmod(setting.plant.transport_delay(setting.sampling) * setting.sampling + 1e-9, 1.0)
        return int(whole), max(share - 1e-9, 0.0)

    def packed(self, setting: Setting) -> Real:
        """Return the coefficients of both difference equations, and the share of a sample of the delay."""
        observer = DisturbanceObserver(QFilter("umeno-hori", self.cutoff), setting.plant.A, setting.plant.B)
        return np.append(observer.packed(setting), self.late(setting)[1])

    def initial_state(self, setting: Setting) -> Real:
        """Return where the axis begins, both memories, and the voltages on their way."""
        return np.array([setting.seen, *np.zeros(2 * ORDER + self.late(setting)[0] + 2)])
