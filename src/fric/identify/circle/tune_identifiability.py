"""What recorded circles cannot tell of friction and plant, and what in them is not as it should be."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from fric.notice import Notice

if TYPE_CHECKING:
    from fric.identify.circle.measured import MeasuredCircle
    from fric.identify.circle.tune_fit import Fitted
    from fric.simulate.machine import Axis

APART = 3.0
"""Ratio of the feeds of two circles from which they tell different things."""
LATE = 0.25
"""Relative distance of the delay found from that believed, from which it is told."""
ALIKE = 0.3
"""Distance of two blocks' slip displacements, in the logarithm, below which they are not told apart."""
MISFIT = 3.0
"""Times the noise that a result may leave."""


def identifiability_warnings(
    axis: Axis, tests: Sequence[MeasuredCircle], before: Fitted, found: Fitted
) -> Iterator[Notice]:
    """Yield what the circles leave open, and what the fit shows of them.

    Parameters
    ----------
    axis
        The axis as it was believed.
    tests
        The circle tests.
    before, found
        What belief and result leave of the voltages.
    """
    feeds = sorted(test.feed for test in tests)
    if feeds[-1] < APART * feeds[0]:
        fast = f"{feeds[-1] * 1e3:g} mm/s"
        slow = feeds[-1] < 0.03
        missing = (
            "the delay, the inertia and how friction falls with speed above it: T_d may be off by half"
            if slow
            else "v_s, delta and C, which show where a reversal is slow, and the weakest blocks"
        )
        yield Notice(
            f"axis {axis.name}: all circles are at about {fast}, and do not tell {missing}. Record one fast and one "
            "slow circle, as at 100 and 10 mm/s",
            "one-feed", "doubt",
        )  # fmt: skip
    T_d, nominal = found.balance.coordinates.delay(found.x), found.balance.coordinates.T_d
    if T_d > (1 + LATE) * nominal or T_d < (1 - LATE) * nominal:
        later = "late against" if T_d > nominal else "ahead of"
        yield Notice(
            f"axis {axis.name}: the position is {later} the voltage: the delay is {T_d * 1e3:.2f} ms, and "
            f"{nominal * 1e3:.2f} ms were believed. Where the log itself shifts position and voltage, by a sample of "
            f"{found.balance.records[0].sampled * 1e3:.3g} ms or so, that is in it too: the lead is wrong by as much",
            "position-late" if T_d > nominal else "position-early", "doubt",
        )  # fmt: skip
    noise = found.noise()
    if noise is not None and found.rms > MISFIT * noise:
        yield Notice(
            f"axis {axis.name}: {found.rms * 1e3:.2f} mV of the voltage are left, and {noise * 1e3:.2f} mV of it do "
            "not repeat: friction differs in shape from GMS (with position, direction or time), or the log has a flaw",
            "circle-misfit", "doubt",
        )  # fmt: skip
    side = found.balance.coordinates.sides(found.x)
    if "side" in found.balance.coordinates.names:
        yield Notice(
            f"axis {axis.name}: friction is {abs(side):.1%} higher in the {'positive' if side > 0 else 'negative'} "
            "direction of motion: each has its own map",
            "direction", "note",
        )  # fmt: skip
    model = found.balance.coordinates.friction(found.x)
    slips = [alpha / k for alpha, k in zip(model.alpha, model.k, strict=True)]
    alike = [
        f"{i} and {j}"
        for i, j in combinations(range(1, len(slips) + 1), 2)
        if abs(np.log(slips[i - 1] / slips[j - 1])) < ALIKE
    ]
    if alike and any(name.startswith("alpha") for name in found.balance.coordinates.names):
        yield Notice(
            f"axis {axis.name}: blocks {', '.join(alike)} slip at about one displacement, and circles do not tell what "
            "each of them has: alpha and k of both together hold, their own values and intervals do not",
            "blocks-alike", "note",
        )  # fmt: skip
    bounds = np.minimum(6.0 * found.balance.coordinates.priors, 3.5)
    at_end = [
        name
        for name, value, bound in zip(found.balance.coordinates.names, found.x, bounds, strict=True)
        if abs(value) > 0.97 * bound
    ]
    if at_end:
        yield Notice(
            f"axis {axis.name}: {', '.join(at_end)} ran to the end of where it was searched: what is believed is far "
            "off, or the circles do not tell it",
            "tuned-at-bound", "doubt",
        )  # fmt: skip
