"""Told before a run: whether the loop of an axis is stable, and by what margin it is not."""

from collections.abc import Sequence
from dataclasses import replace
from math import log10

import numpy as np

from fric.control import ControlBlock, Setting
from fric.design.loop import SampledLoop
from fric.design.repeating import learned_share
from fric.errors import FricError
from fric.simulate.machine import Axis

GAINS = np.geomspace(0.95, 1e-3, 140)
"""Gains at which a loop that is not stable is tried anew, 0.43 dB apart."""

EDGE = 1.0 + 1e-7
"""Largest eigenvalue that is let pass: an axis that is left alone drifts at 1, and rounding decides on which side."""


def require_stable(axis: Axis, setting: Setting, controller: ControlBlock, blocks: Sequence[ControlBlock] = ()) -> None:
    """Raise a `FricError` with the gain margin where the loop of an axis, without friction, is not stable.

    Parameters
    ----------
    axis
        The axis, with its true plant.
    setting
        What its controller believes.
    controller, blocks
        The blocks of its scheme. Where one of them is not linear the loop has no poles, and is not judged.

    Raises
    ------
    FricError
        When an eigenvalue of the sampled loop is outside the unit circle.
    """
    inside = tuple(block for block in blocks if block.in_loop() and not block.repeats)
    if not all(block.linear for block in (controller, *inside)):
        return
    loop = SampledLoop(axis.plant, axis.cascade, inside, controller, setting)
    largest = float(abs(loop.poles()[0]))
    if largest < EDGE:
        for block in blocks:
            if block.repeats:
                require_learning(axis, block, loop, setting)
        return
    part = "with its observer " if any(block.kind == "observer" for block in blocks) else ""
    stable_at = (gain for gain in GAINS if replace(loop, plant=replace(axis.plant, B=axis.plant.B * gain)).stable)
    gain = next(stable_at, None)
    margin = f"its gain margin is {20 * log10(gain):.1f} dB" if gain else "at no gain"
    raise FricError(
        f"the loop of axis {axis.name} {part}is not stable: {margin} (largest eigenvalue {largest:.4f} a sample)",
        hint="Lower the gains or the observer's cutoff; fric design finds values that hold.",
    )


def require_learning(axis: Axis, block: ControlBlock, loop: SampledLoop, setting: Setting) -> None:
    """Raise a `FricError` where what a block learns of one period does not shrink in the next."""
    share, frequency = learned_share(block, loop, setting)
    if share >= 1.0:
        raise FricError(
            f"what '{block.name}' learns on axis {axis.name} grows from period to period, by {share:.3g} at "
            f"{frequency:.4g} Hz",
            hint="Lower its cutoff, or identify the plant again: the one that is believed is not the axis' own.",
        )
