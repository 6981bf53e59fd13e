"""Place: what the force does along the axis."""

from typing import Any

from fric.flaws.base import Flaw, by_size
from fric.notice import Severity


def _severity(f: Any) -> Severity:
    return by_size(float(f.varies), f.level, f.half_width)


# fmt: off
FORCE_OVER_POSITION = Flaw("force-over-position", _severity,
    "Force depends on position: {varies} over {length} (cogging, cable, balance{either:, or friction|}). The map "
    "{taken_off:is the mean over all places|holds where each speed was logged}.",
    "Log each speed over the same whole stroke, and take that force off.", widens={"level": 0.05}, circle_settles=True)
FRICTION_OVER_POSITION = Flaw("friction-over-position", _severity,
    "Friction depends on position: {varies} over {length} (rollers, alignment, preload). The map {taken_off:is the "
    "mean over all places|holds where each speed was logged}.", "Log each speed over the same whole stroke.",
    widens={"level": 0.05}, circle_settles=True)
FORCE_ALONG_AXIS = Flaw("force-along-axis", "note", "The force rises by {rises} over {length} of the axis (spring, "
    "cable, tilt): it is taken off, and the offset is that at {middle}.")
