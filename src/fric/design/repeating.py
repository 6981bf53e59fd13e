r"""Whether what a block learns of one period shrinks in the next.

A block that repeats gives ``v[n] = -Σ h_z[k]·z[n-N-k] - Σ h_u[k]·u[n-N-k]``, N the period. With the loop without it,
of sensitivity S, v moves the voltage by S·v and the position by G·S·v. So from one period to the next v is multiplied
by::

    l = -(H_z·G + H_u/z)·S

and dies out at every frequency, however long the period, where |l| < 1. H_z and H_u come from the impulse responses
of its compiled step (`fric.control.probe`), of a short period with the same share of a sample: a delay by whole
samples does not change |l|. K. Inoue, Practical design of repetitive control systems, Proc. IEEE CDC 1990.
"""

from dataclasses import replace

import numpy as np

from fric.arrays import Complex
from fric.control.base import ControlBlock, Setting
from fric.control.probe import impulses
from fric.design.loop import SampledLoop
from fric.reference import Reference

SHORT = 160
"""Samples of the short period."""


def learned_share(block: ControlBlock, loop: SampledLoop, setting: Setting) -> tuple[float, float]:
    r"""Return the largest |l|, and the frequency [Hz] at which it is.

    block: A block that repeats.
    loop: The loop without it; it must be stable.
    setting: What the block is packed for.
    Raises FricError: When the motion does not repeat.
    """
    if setting.reference is None or not setting.reference.period:
        block.packed(setting)  # which tells what is missing
        raise ValueError("a block that repeats did without a period")
    sampling = setting.sampling
    period = (SHORT + setting.reference.period * sampling % 1.0) / sampling
    still = Reference(sampling, *(np.zeros(2) for _ in range(3)), period=period)
    short = replace(setting, reference=still, position=0.0, seen=0.0)
    f = np.geomspace(0.5, 0.999 * loop.nyquist, 1500)
    z = np.exp(2j * np.pi * f / sampling)

    def response(*inputs: str) -> Complex:
        h = impulses(block, short, inputs, 2 * SHORT, 2 * SHORT)
        return np.asarray(np.exp(-2j * np.pi * np.outer(f / sampling, np.arange(len(h)))) @ h)

    share = np.abs((response("measured") * loop.G(f) + response("input", "control") / z) / (1.0 + loop.input(f)))
    worst = int(np.argmax(share))
    return float(share[worst]), float(f[worst])
