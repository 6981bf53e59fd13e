"""Place: what the force does along the axis."""

from typing import Any

from fric.flaws.base import Flaw, by_size
from fric.notice import Severity


def _severity(f: Any) -> Severity:
    return by_size(float(f.varies), f.level, f.half_width)


# fmt: off
FORCE_OVER_POSITION = Flaw("force-over-position", _severity,
    "Force depends on position: it varies by {varies} over {length} (cogging, a cable, gravity of a balance{either:, "
    "or friction over position|}). The map {taken_off:is the mean over all these places|holds where each speed was "
    "logged}.", "Log each speed over the same whole stroke, and take that force off.",
    widens={"level": 0.05}, circle_settles=True)
FRICTION_OVER_POSITION = Flaw("friction-over-position", _severity,
    "Friction depends on position: it varies by {varies} over {length} (rolling elements, alignment, preload). The "
    "map {taken_off:is the mean over all these places|holds where each speed was logged}.",
    "Log each speed over the same whole stroke.", widens={"level": 0.05}, circle_settles=True)
FORCE_ALONG_AXIS = Flaw("force-along-axis", "note",
    "The force rises along the axis by {rises} over {length}, as a spring, a cable, a balance or a tilt makes it: it "
    "is taken off, and the offset is that at {middle}.")
