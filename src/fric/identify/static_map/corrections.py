"""What bends the forces of strokes, and what is done about it: one function a correction, in the order of their use.

Each looks for what it corrects, and returns what it takes off the strokes, how that errs, and what to say of it; or
None where the strokes do not show it. A correction that is not in the table is not made.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from fric.arrays import Real
from fric.flaws.base import SMALL
from fric.flaws.place import FORCE_ALONG_AXIS
from fric.flaws.static_map import STICKS, STROKES_SWING
from fric.identify.static_map.between_records import between_records
from fric.identify.static_map.place import place
from fric.identify.static_map.points import SpeedPoint, force_step, logs_of_strokes, rounded_by
from fric.identify.static_map.settling import settling
from fric.identify.static_map.stribeck_fit import StribeckProblem
from fric.identify.static_map.strokes import Correction, Strokes
from fric.log import Log
from fric.records.flaws import coarse_force
from fric.records.over_strokes import along_axis, over_place


def slope(strokes: Strokes) -> Correction | None:
    """Take a force that rises along the axis off the records.

    Slow strokes stay at one end of the way that fast ones cover: the rise would be taken for friction over speed.
    Where more than a slope comes again at the same places, all is left to `place`.
    """
    stretches = list(strokes.stretches.with_position.values())
    if strokes.asked.over_position == "off" or (found := along_axis(stretches)) is None:
        return None
    rises, half = found
    ways = [log.require("position", "a slope")[segment.onset : segment.stop] for log, segment in stretches]
    low, high = min(float(way.min()) for way in ways), max(float(way.max()) for way in ways)
    if over_place(stretches) is not None or abs(rises) * (high - low) < SMALL * strokes.size:
        return None
    middle = 0.5 * (low + high)
    records = [
        one if not isinstance(one, Log) or one.position is None or one.force is None
        else replace(one, force=one.force - rises * (one.position - middle))
        for one in strokes.records
    ]  # fmt: skip

    def together(level: Strokes) -> Real:
        moved = np.zeros((1, len(level.points)))
        for number, (log, segment) in level.stretches.with_position.items():
            at = log.require("position", "a slope")[segment.start : segment.stop]
            moved[0, number] = half * (float(at.mean()) - middle)
        return moved

    of, over = strokes.asked.of, high - low
    values = {"rises": of(rises * over, "force"), "length": of(over, "position"), "middle": of(middle, "position")}
    return Correction(records=records, together=together, notices=[FORCE_ALONG_AXIS.found(**values)])


def swing(strokes: Strokes) -> Correction | None:
    """Average the map over the velocities of strokes that swing."""
    swings = [p for p in strokes.points if p.swing]
    if not swings:
        return None

    def into(problem: StribeckProblem, points: Sequence[SpeedPoint]) -> StribeckProblem:
        size = np.array([point.swing for point in points])
        return replace(problem, swing=size) if problem.fall and np.any(size > 0) else problem

    speeds = [strokes.asked.of(v, "velocity") for v in sorted(abs(p.velocity) for p in swings)]
    most = max(p.swing for p in swings)
    found = {"strokes": len(swings), "most": most, "slowest": speeds[0], "fastest": speeds[-1]}
    return Correction(into=into, notices=[STROKES_SWING.found(**found, sticks=most > STICKS)])


def rounding(strokes: Strokes) -> Correction | None:
    """Allow for coarse steps of the force: they put off all strokes by one amount, and the slow against the fast."""
    by, points = rounded_by(strokes.points), strokes.points
    if by == 0.0 or len(points) < 2:
        return None
    along = np.argsort(np.argsort(np.abs(strokes.velocity))) / (0.5 * (len(points) - 1)) - 1.0
    together = by * np.sign(strokes.force) * np.array([np.ones_like(along), along])
    logs = logs_of_strokes(strokes.records)
    notices = coarse_force(force_step(logs), strokes.logs[0]) if by > SMALL * strokes.size else []
    return Correction(together=together, notices=notices)


def damping(strokes: Strokes) -> Correction | None:
    """Fit the forces with the plant's damping in them: a sigma below 0 then costs nothing, where it was too much."""
    by = strokes.asked.damping

    def into(problem: StribeckProblem, points: Sequence[SpeedPoint]) -> StribeckProblem:
        return replace(problem, F=problem.F + by * problem.v)

    return Correction(into=into) if by else None


Look = Callable[[Strokes], Correction | None]

AT_ANY_SPEED: Mapping[str, Look] = {"slope": slope, "swing": swing, "rounding": rounding}
"""What is corrected where a single speed was logged, too."""

OF_A_MAP: Mapping[str, Look] = {
    "damping": damping, "settling": settling, "place": place, "between records": between_records,
}  # fmt: skip
"""What is corrected before a map is fitted."""


def corrected(strokes: Strokes, corrections: Mapping[str, Look]) -> Strokes:
    """Return the strokes with each correction made that they show."""
    for look in corrections.values():
        if (found := look(strokes)) is not None:
            strokes = strokes.without(found)
    return strokes
