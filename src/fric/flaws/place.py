"""Place: what the force does along the axis."""

from typing import Any

from fric.flaws.base import Flaw, by_size
from fric.notice import Severity

REMOVED = 0.05
"""Share of friction up to which what is taken off leaves nothing to do: by so much a prediction is widened beyond."""


def _severity(f: Any) -> Severity:
    if f.taken_off:  # what is left of it is in the intervals
        return "note" if float(f.varies) <= REMOVED * abs(f.level) else "doubt"
    return by_size(float(f.varies), f.level, f.half_width)


# fmt: off
FORCE_OVER_POSITION = Flaw("force-over-position", _severity,
    "Force depends on position: {varies:2} over {length:2} (cogging, cable{either:, friction|}?).",
    "{taken_off:Removed; nothing to do.|Log each speed over the same whole stroke: the map is of these places.}",
    widens={"level": 0.05}, circle_settles=True)
FRICTION_OVER_POSITION = Flaw("friction-over-position", _severity,
    "Friction depends on position: {varies:2} over {length:2} (rollers, alignment?).",
    "{taken_off:Removed; nothing to do.|Log each speed over the same whole stroke: the map is of these places.}",
    widens={"level": 0.05}, circle_settles=True)
FORCE_ALONG_AXIS = Flaw("force-along-axis", "note", "The force rises by {rises} over {length} of the axis (spring, "
    "cable, tilt): it is taken off, and the offset is that at {middle}.")
