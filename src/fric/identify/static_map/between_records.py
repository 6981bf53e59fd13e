"""How the level of friction and the offset vary from record to record: a mixed model beside the map.

The force of stroke i of record r is ``F_i = F̂(v_i) + u_r·f(v_i) + o_r + e_i``, F̂ being the map with offset and damping
and f its friction; the record's level u and offset o are normal about zero. By Henderson's equations (1950) weighted
least squares on the forces without what is predicted of their record, together with how that prediction errs, is
generalised least squares: the map is that of the mean over records, and its intervals know how few these are.
"""

from collections.abc import Sequence

import numpy as np
from scipy.special import chdtrc, stdtrit

from fric.arrays import Real
from fric.estimate import Estimate
from fric.flaws.drift import RECORDS_VARY
from fric.identify.static_map.map_fit import solved
from fric.identify.static_map.points import SpeedPoint
from fric.identify.static_map.stribeck_fit import Solution, StribeckProblem
from fric.identify.static_map.strokes import Correction, Strokes
from fric.statistics import mixed_model

FEWEST = 3
"""Strokes of a record, at two speeds or more, from which on its level is seen beside the map."""
BY_CHANCE = 1e-3
"""Probability with which records of one friction scatter so, under which it is said that they differ."""
OF_TWO = 0.05
"""The same of two records, over which nothing is widened: a single difference hardly tells what the next will be."""


def between_records(strokes: Strokes) -> Correction | None:
    """Take off what is predicted of each record's level and offset, and allow for how these vary."""
    names = _told(strokes.points)
    if len(names) < 2:
        return None
    fitted, _ = solved(strokes, strokes.offset)
    problem, solution = fitted.problem, fitted.solution
    member = np.array([[point.of_record == name for name in names] for point in strokes.points], float)
    kinds = [member * _friction(problem, solution, strokes.velocity)[:, np.newaxis]]
    if problem.with_offset:
        kinds.append(member)
    residual, columns = problem.F - problem.model(solution.theta), problem.jacobian(solution.theta)
    found = mixed_model(residual, columns, fitted.own, [one[fitted.kept] for one in kinds])
    chance = float(chdtrc(len(kinds), found.likelier))
    if not found.deviations.any() or (len(names) == 2 and chance > OF_TWO):
        return None
    effects = np.hstack(kinds)
    points = [point.less(by) for point, by in zip(strokes.points, effects @ found.predicted, strict=True)]
    together = float(stdtrit(len(names) - 1, 0.975)) * (effects @ found.errors).T
    level, offset = (*found.deviations, 0.0)[:2]
    scatter = {"level": Estimate(float(level), "1"), "offset": strokes.asked.of(offset, "force")}
    notices = []
    if chance < BY_CHANCE:
        by = [f"friction by {level:.1%}", f"the offset by {strokes.asked.says(offset, 'force', 2)}"][: len(kinds)]
        order = [f"{1.0 + one:.3f} of the friction" for one in found.predicted[: len(names)]]
        notices.append(RECORDS_VARY.found(by=by, order=order))
    return Correction(points=points, together=together, notices=notices, between_records=scatter)


def _told(points: Sequence[SpeedPoint]) -> list[str]:
    """Return the records, in the order of the strokes' times, whose level is seen beside the map."""
    speeds: dict[str, list[float]] = {}
    for point in points:
        speeds.setdefault(point.of_record, []).append(abs(point.velocity))
    return sorted(name for name, v in speeds.items() if len(v) >= FEWEST and max(v) > 1.5 * min(v))


def _friction(problem: StribeckProblem, solution: Solution, v: Real) -> Real:
    """Return the force of friction without its viscous part at velocities [N], shape (n,)."""
    theta, columns = solution.theta, problem.jacobian(solution.theta, v)
    found = np.zeros(len(v))
    for name in ("F_c", "F_s"):
        if name in problem.free:
            found += theta[name] * columns[:, problem.free.index(name)]
    return found
