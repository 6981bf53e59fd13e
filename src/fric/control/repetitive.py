"""A repetitive controller: each sample gets the voltage that the same place of the contour needed one period ago.

::

    w[n] = (h∗(u_t - u_m))[n - N] + (g∗e)[n - N + T_d/T_s],   g = (h″ + A·h′)/B,   e = r - z

u_m is the inverse model's voltage, h a Gaussian that has fallen by 3 dB at the cutoff, over ±24 samples: the voltage
of the last period is kept, and the position error is added as the voltage that would have corrected it,
taken T_d ahead. Nothing is learned above the cutoff. From one period to the next, without friction, w is multiplied
by ``h·(1 - G/G_n)/(1 + G·K)``, which is small where the plant is known (`fric.design.loop`). Both signals are kept
for N + 64 samples, N the period of the contour: the filters look back at what is older than one period, and a memory
of N alone would have overwritten it. E. D. Tung, G. Anwar, M. Tomizuka, Low velocity friction compensation and
feedforward solution based on repetitive control, J. Dyn. Syst. Meas. Control 115 (1993) 279-284.
"""

from dataclasses import dataclass
from math import ceil, pi, sqrt
from typing import Annotated

import numpy as np

from fric.arrays import Real
from fric.control.base import ControlBlock, Setting
from fric.errors import FricError
from fric.exact import each
from fric.friction.base import Parameter
from fric.kernels.block import MODEL, Sample, compiled_block
from fric.kernels.elementary import exp, log

HALF = 24
TAPS = 2 * HALF + 1
ROOM = 64
HEAD = 3


@compiled_block
def _step(sample: Sample, n: int, rows: Real, state: Real, parameters: Real) -> float:
    whole, ahead = int(parameters[0]), int(parameters[1])
    size = (state.size - 1) // 2
    count = int(state[0])
    if count > 0:
        state[1 + (count - 1) % size] = sample.control - rows[MODEL, n - 1] if n > 0 else sample.control
    state[1 + size + count % size] = sample.reference - sample.measured
    learned = 0.0
    oldest = count - whole - HALF
    if oldest >= parameters[2]:
        at, other = oldest % size, (oldest + ahead) % size
        for i in range(TAPS):
            learned += parameters[HEAD + i] * state[1 + at] + parameters[HEAD + TAPS + i] * state[1 + size + other]
            at += 1
            if at == size:
                at = 0
            other += 1
            if other == size:
                other = 0
    state[0] = count + 1
    return -learned


@dataclass(frozen=True)
class Repetitive(ControlBlock):
    """The repetitive controller.

    cutoff: Where what is learned has fallen by 3 dB [Hz].
    """

    name = "repetitive"
    kind = "observer"
    linear = True
    repeats = True
    asks = "position, voltage as limited less the friction feedforward, period of the contour; two memories of N + 64"
    step = _step

    cutoff: Annotated[float, Parameter("frequency", 60.0, 400.0, "what is learned ends here", typical=150.0)]

    def period(self, setting: Setting) -> float:
        """Return the period of the motion in samples."""
        period = 0.0 if setting.reference is None else setting.reference.period * setting.sampling
        if period == 0.0:
            hint = "Take it for circles of two revolutions."
            raise FricError("a repetitive controller needs a motion that repeats", hint=hint)
        if period < 2 * ROOM:
            what = f"the motion repeats after {period:.0f} samples, and the filters are {TAPS} long"
            raise FricError(what, hint="Move slower.")
        return period

    def filters(self, setting: Setting, late: float, lead: float) -> tuple[Real, Real]:
        """Return h and g at ±24 samples about an instant some shares of a sample late, (49,) each."""
        T, width = setting.T_s, sqrt(log(2.0)) / (2.0 * pi * self.cutoff)
        out = []
        for order, share in ((0, late), (1, lead)):
            t = (np.arange(TAPS) - HALF - share) * T  # how much younger than the middle a value is
            h = each(exp, -0.5 * (t / width) ** 2)
            h *= 1.0 / h.sum()
            if order:  # derivatives in time of a signal that is smoothed by h
                first, second = t / width**2 * h, (t**2 / width**2 - 1.0) / width**2 * h
                h = (second + setting.plant.A * first) / setting.plant.B
            out.append(h)
        return out[0], out[1]

    def packed(self, setting: Setting) -> Real:
        """Return whole samples of the period and of the delay, and both filters, oldest value first."""
        period, delay = self.period(setting), setting.plant.T_d * setting.sampling
        whole, begins = int(period), 0.0 if setting.reference is None else setting.reference.begins * setting.sampling
        ahead = int(np.floor(delay))
        # the instant one period ago lies a share before sample n - whole; the error is taken T_d later
        h, g = self.filters(setting, -(period - whole), delay - ahead - (period - whole))
        return np.concatenate([[whole, ahead, ceil(begins)], h, g])

    def initial_state(self, setting: Setting) -> Real:
        """Return the number of samples so far, and empty memories."""
        return np.zeros(1 + 2 * (int(self.period(setting)) + ROOM))
