"""The force constant from strokes at constant velocity, where no record of a response has force and input both.

While the velocity is constant the motor's force and its voltage are, and by how much one is logged later than the other
does not matter: over the steady segments of all strokes

    mean force = K_f·(mean input) + offset

The offset is what the drive adds to either channel. A line that the means do not keep to is told: a force that is
measured behind the friction of the drive, or an input that saturates, is not proportional to the voltage.
"""

from collections.abc import Sequence

import numpy as np
from scipy.special import stdtrit

from fric.estimate import Estimate
from fric.flaws.channel import FORCE_NOT_PROPORTIONAL
from fric.log import Log
from fric.notice import Notice
from fric.records.segments import steady_segments
from fric.units import Motion, si_unit

FEWEST = 4
"""Steady segments that a line through their means takes at least."""

BENT = 0.02
"""Share of the range of the means by which they may lie off their line."""


def steady_force_constant(logs: Sequence[Log], motion: Motion) -> tuple[Estimate | None, tuple[Notice, ...]]:
    """Return K_f [N/V] as the slope of mean force over mean input of steady segments, and what the user should know.

    logs: Strokes at constant velocity; those without force or input have no part in it.
    motion: Motion of the axis.
    Returns none where fewer than `FEWEST` segments are steady, or all have one voltage.
    """
    both = [log for log in logs if log.force is not None and log.input is not None]
    means = [
        (float(np.mean(log.input[one.start : one.stop])), float(np.mean(log.force[one.start : one.stop])))  # type: ignore[index]
        for log in both
        for one in steady_segments(log)
    ]
    u, F = np.array(means, float).reshape(-1, 2).T
    if len(u) < FEWEST or np.ptp(u) == 0.0:
        return None, ()
    level = u - u.mean()
    slope = float(level @ F / (level @ level))
    off = F - F.mean() - slope * level
    error = float(np.sqrt(off @ off / (len(u) - 2) / (level @ level)))
    half_width = float(stdtrit(len(u) - 2, 0.975)) * error
    source = f"mean force over mean input of {len(u)} steady segments"
    found = Estimate.around(slope, si_unit("force per input", motion), half_width, source=source)
    share = float(np.sqrt(off @ off / len(u))) / float(np.ptp(F))
    if share <= BENT:
        return found, ()
    return found, (FORCE_NOT_PROPORTIONAL.found(segments=len(u), off=share),)
