"""The measured inverse: what the next round of a repeated contour feeds forward, from what a round recorded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fric.arrays import Real
from fric.circles.measured import MeasuredCircle
from fric.circles.motion import low_pass
from fric.drive.plant import LinearPlant
from fric.errors import FricError
from fric.flaws.circle import LEARNED_FROM_ONE_CIRCLE, NOTHING_FED_BEFORE
from fric.notice import Notice

if TYPE_CHECKING:
    from fric.simulate.machine import Machine

FAST = 0.05
"""Feed from which a round is learned whole, over 200 Hz; below it half of it, over 100 Hz [m/s]."""


@dataclass(frozen=True)
class Learning:
    """How a round is learned."""

    share: float  # Share of what a round tells that is taken over, γ [1]
    bandwidth: float  # Corner of the low-pass, which leaves out what does not repeat [Hz]

    @classmethod
    def at(cls, feed: float, share: float | None = None, bandwidth: float | None = None) -> Learning:
        """Return how a circle at a feed [m/s] is learned, where it is not given.

        Raises FricError: When the share is not between 0 and 1, or the bandwidth not positive.
        """
        fast = feed >= FAST
        made = cls(share or (1.0 if fast else 0.5), bandwidth or (200.0 if fast else 100.0))
        if not (0 < made.share <= 1 and made.bandwidth > 0):
            raise FricError(
                f"a share of {made.share:g} at {made.bandwidth:g} Hz is nothing to learn with",
                hint="The share lies above 0 and up to 1, the bandwidth above 0.",
            )
        return made


def next_feedforward(
    t: Real,
    error: Real,
    voltage: Real,
    model: Real,
    before: Real,
    plant: LinearPlant,
    how: Learning,
) -> Real:
    """Return the voltage that the next round should feed forward against friction [V], shape (n,).

    ``w ← (1 - γ)·w + γ·(LP[u](t) + LP[(ë + A·ė)/B](t + T_d) - u_model(t))`` with e the tracking error: the voltage of
    this round, and what was missing of it. No model of friction is needed, and none of the controller.

    t: Even sample instants [s].
    error, voltage: Reference less position as measured [m], and control voltage [V], of this round, each of shape (n,).
    model: Voltage of the inverse model that the controller feeds forward [V], shape (n,).
    before: Voltage that this round fed forward against friction [V], shape (n,).
    plant: The nominal plant.
    how: How it is learned.
    """
    from scipy.signal import sosfiltfilt

    dt = float(t[1] - t[0])
    sections = low_pass(how.bandwidth, 1 / dt)
    slow = sosfiltfilt(sections, error)
    rate = np.gradient(slow, t)
    missing = (np.gradient(rate, t) + plant.A * rate) / plant.B
    needed = sosfiltfilt(sections, voltage) + np.interp(t + plant.T_d, t, missing)
    return np.asarray((1 - how.share) * before + how.share * (needed - model))


@dataclass(frozen=True)
class Table:
    """The feedforward of the next round of a measured circle."""

    test: MeasuredCircle  # The circle that it is for
    how: Learning  # How it was learned
    # time, reference, voltage: by axis: instants [s], reference [m] and voltage against friction [V], each of shape
    # (n,)
    time: Mapping[str, Real]
    reference: Mapping[str, Real]
    voltage: Mapping[str, Real]
    warnings: tuple[Notice, ...]  # What the user should know

    @property
    def circle(self) -> MeasuredCircle:
        """The circle that was learned."""
        return self.test


def learn_from(
    test: MeasuredCircle,
    machine: Machine,
    how: Learning | None = None,
    before: Mapping[str, Real] | None = None,
) -> Table:
    """Return the feedforward of the next round from a measured circle.

    test: The circle test, with reference, position and voltage.
    machine: The machine, whose nominal plants are taken.
    how: How; by the feed where not given.
    before: By axis, what this round fed forward against friction [V], shape (n,); nothing where not given.
    Raises FricError: When a channel is missing, or what was fed forward before is of another length.
    """
    how = how or Learning.at(test.feed)
    time, wanted, voltage = {}, {}, {}
    for name in test.names:
        trace, axis = test.axis(name), machine.axis(name)
        if trace.reference is None or trace.input is None:
            raise FricError(
                f"axis {name} lacks reference or voltage", where=test.where, hint="Record both beside the position."
            )
        plant = axis.nominal or axis.plant
        t, r = trace.time, trace.reference
        last = np.zeros(len(t)) if before is None else before.get(name, np.zeros(0))
        if len(last) != len(t):
            raise FricError(
                f"what axis {name} fed forward has {len(last)} samples, and the circle {len(t)}", where=test.where,
                hint="Give the file that this very circle was run with.",
            )  # fmt: skip
        ahead = np.interp(t + axis.lead(), t, r)
        model = (np.gradient(np.gradient(ahead, t), t) + plant.A * np.gradient(ahead, t)) / plant.B
        time[name], wanted[name] = t, r
        voltage[name] = next_feedforward(t, r - trace.position, trace.input, model, last, plant, how)
    warnings = [LEARNED_FROM_ONE_CIRCLE.found()]
    if how.share < 1 and before is None:
        warnings.append(NOTHING_FED_BEFORE.found(share=how.share))
    return Table(test, how, time, wanted, voltage, tuple(warnings))
