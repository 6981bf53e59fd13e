"""Corrections of errors in the forces of strokes, a function each, in the order of their use.

Each looks for its effect and returns the force to subtract from the strokes, its error, and warnings; or None if the
strokes do not show the effect. Only corrections in the table are made.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import compress
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import chdtrc, stdtrit

from fric.arrays import Mask, Real
from fric.estimate import Estimate
from fric.flaws.base import SMALL
from fric.flaws.channel import FORCE_COARSE
from fric.flaws.drift import RECORDS_VARY
from fric.flaws.static_map import FORCE_ALONG_AXIS, STICKS, STROKES_SETTLING, STROKES_SWING
from fric.identify.static_map.map_fit import FEWEST, predicts_better, solved, weighted_rms
from fric.identify.static_map.points import Correction, SpeedPoint, Strokes, average, force_step, logs_of_strokes
from fric.identify.static_map.stribeck_fit import StribeckProblem
from fric.log import Log
from fric.records.over_strokes import PLACES, SURE, along_axis, over_place
from fric.records.preparation import WINDOWS
from fric.records.resolution import lattice_step
from fric.records.segments import Segment
from fric.statistics import DIFFERENT, OF_TWO, mixed_model, reach, sandwich

RECORDS = 8  # Least number of records of a single speed each whose levels are separable from the map
_LEVELS = ("F_c", "F_s")
FEW_STROKES = 3  # Least number of strokes of a record, at two speeds or more, to separate its level from the map
FINER = 4  # Number of cells of the travel for the evaluation of places
CELLS, LONG = 512, 16  # Cells of the travel for what is left over position, and cells of a stroke that shows it
BATCHES, SAMPLES = 96, 24  # Number of batches of a stroke, and its least number of samples
UNLIKE = 2.0  # Chi-squared per degree of freedom above which the strokes do not settle by eq. (5)
GAIN = 20.0  # Least reduction of chi-squared by a settling, beyond its parameters
VISIBLE = 0.5  # Error in standard errors of a stroke's mean above which it is corrected
RISING = 0.1  # Largest rise of a force as a share of the correction: after break-away forces fall


def between_records(strokes: Strokes) -> Correction | None:
    """Remove the predicted level and offset of each record, and allow for their variation.

    The force of stroke i of record r is ``F_i = F̂(v_i) + u_r·f(v_i) + o_r + e_i``, F̂ being the map with offset and
    damping and f its friction; the record's level u and offset o are normal about zero. By Henderson's equations
    (1950), weighted least squares of the forces less the prediction of their record, with its error, is generalised
    least squares: the map is that of the mean over records, and intervals depend on their number.
    """
    of = [point.of_record for point in strokes.points]
    names, one_speed = _told(of, strokes.velocity)
    if within := len(names) < 2:
        of = _windows(strokes)
        names, one_speed = sorted(set(of)), False
        if not names:
            return None
    fitted, _ = solved(strokes, strokes.offset)
    problem, solution = fitted.problem, fitted.solution
    member = np.array([[name == other for other in names] for name in of], float)
    columns = problem.jacobian(solution.theta)
    levels = {
        name: level for name in _LEVELS if name in problem.free
        if (level := solution.theta[name] * columns[:, [problem.free.index(name)]]).any()
    }  # fmt: skip
    if not levels:  # of a friction that the strokes do not show
        return None
    if not within:
        levels = {"friction": np.sum(list(levels.values()), axis=0)}
    kinds = [*(member * level for level in levels.values()), *[member] * problem.with_offset]
    found = mixed_model(problem.F - problem.model(solution.theta), columns, fitted.deviation, kinds)
    chance = float(chdtrc(len(kinds), found.likelier))
    count, friction = len(names), float(np.mean(np.abs(np.sum(list(levels.values()), axis=0))))
    sizes = np.array([1.0] * len(levels) + [friction] * problem.with_offset)
    reaches = sizes * [reach(*of, count) for of in zip(found.measured / sizes, found.error / sizes, strict=True)]
    beyond = np.maximum(reaches**2 - (1.96 * found.error) ** 2, 0.0)  # what the map's error does not hold
    if within and chance > DIFFERENT:
        return None
    effects = np.hstack(kinds)
    points = [point.less(by) for point, by in zip(strokes.points, effects @ found.predicted, strict=True)]
    t = np.sqrt(beyond) / np.maximum(found.deviations, 1e-300) * (found.deviations > 0.0)
    apart = np.sqrt(np.maximum(beyond - (t * found.deviations) ** 2, 0.0) / count)
    mean = np.column_stack([by * kind.sum(axis=1) for by, kind in zip(apart, kinds, strict=True)])
    together = np.hstack([np.repeat(t, count) * effects @ found.errors, mean]).T
    vary, offset = found.deviations[: len(levels)], (*found.deviations, 0.0)[len(levels)]
    level, bias = found.measured[: len(levels)].max(), (*found.measured, 0.0)[len(levels)]
    scatter = {"level": Estimate(float(level), "1"), "offset": strokes.asked.of(bias, "force")}
    scatter = scatter if count > 2 or chance < OF_TWO else {}
    notices = []
    if chance < DIFFERENT:
        by = [f"{name} by {size:.1%}" for name, size in zip(levels, vary, strict=True)]
        by += [f"the offset by {strokes.asked.says(offset, 'force', 2)}"] * problem.with_offset
        most = int(vary.argmax())
        shares = found.predicted[most * len(names) : (most + 1) * len(names)]
        order = [f"{1.0 + share:.3f} of {'the ' * (not within)}{list(levels)[most]}" for share in shares]
        notices.append(
            RECORDS_VARY.found(by=by, order=order, one_speed=one_speed, within=within, motions=False, scatter=1.0)
        )
    return Correction(points=points, together=together, notices=notices, between_records=scatter)


def _windows(strokes: Strokes) -> list[str]:
    """Return the window in time of each stroke of a single record; none if windows do not share all speeds."""
    speed, order = np.abs(strokes.velocity), np.argsort([point.start for point in strokes.points], kind="stable")
    parts = np.array_split(order, WINDOWS)
    alone = len({point.of_record for point in strokes.points}) == 1 and len(order) >= WINDOWS * FEWEST
    if not alone or any(
        1.5 * speed.min() < speed[part].min() or 1.5 * speed[part].max() < speed.max() for part in parts
    ):
        return []
    return [f"{number}" for _, number in sorted((n, k) for k, part in enumerate(parts) for n in part)]


def _told(of: Sequence[str], v: Real) -> tuple[list[str], bool]:
    """Return the records in order of time whose level is separable from the map, and whether each holds one speed.

    Records of a single speed show their level if all are such and exceed the number of the map's parameters: by the
    common deviation of their strokes from a curve.
    """
    speeds: dict[str, list[float]] = {}
    for name, speed in zip(of, np.abs(v), strict=True):
        speeds.setdefault(name, []).append(speed)
    enough = {name: v for name, v in speeds.items() if len(v) >= FEW_STROKES}
    several = sorted(name for name, v in enough.items() if max(v) > 1.5 * min(v))
    return several or (sorted(enough) if len(enough) >= RECORDS else []), not several


def place(strokes: Strokes) -> Correction | None:
    """Remove forces that recur over position, if held-out strokes are then predicted better.

    All strokes have equal weights here. A slow stroke covers a short piece of the axis and deviates if friction varies
    over position; a smaller weight due to this deviation would hide the cause.
    """
    asked, tried = strokes.asked.over_position, dict[str, float]()
    few = len(strokes.stretches.with_position) < FEWEST
    if asked == "off" or few or (asked == "auto" and strokes.stretches.place is None):
        return None
    profile = Profile(strokes)
    if asked == "auto":
        raw, placed = (
            solved(replace(strokes, points=points), strokes.offset, alike=True)[1]
            for points in (strokes.points, profile.held_out(strokes.points))
        )
        weight, as_logged, without = raw.weight, raw.errors[raw.form], placed.errors[placed.form]
        again = "force over position"
        if not predicts_better(weight, as_logged, without):
            return Correction(tried={f"without {again}": weighted_rms(weight, without)})
        tried = {f"with {again}": weighted_rms(weight, as_logged)}
    points, together = profile.taken_off(strokes.points)
    return Correction(points=points, together=together, tried=tried)


class Profile:
    """Forces over position from the strokes.

    Along stroke i the force is ``F_i(z) = m_i + c(z) + w(z)·m_i/|m|``, |m| being the median of all: c is a force over
    position, w friction over position, both zero in the mean over the travel that strokes cover. A slow stroke is at a
    single place, where c and w are an error of its mean; the long strokes determine them.
    """

    def __init__(self, strokes: Strokes) -> None:
        self.numbers, points = list(strokes.stretches.with_position), strokes.points
        stretches = strokes.stretches.with_position.values()
        travels = [log.require("position", "a force over position")[s.start : s.stop] for log, s in stretches]
        low, high = min(z.min() for z in travels), max(z.max() for z in travels)
        edges = np.linspace(low, high, FINER * PLACES + 1)
        level = float(np.median([abs(points[number].force) for number in self.numbers])) or 1.0
        normal, right, self._means = [], [], []
        covered = np.zeros(PLACES + 1)
        for number, (log, segment), z in zip(self.numbers, stretches, travels, strict=True):
            cell = np.clip(np.digitize(z, edges) - 1, 0, len(edges) - 2)
            count = np.bincount(cell, minlength=len(edges) - 1)
            there = np.flatnonzero(count)
            force = np.bincount(cell, log.require("force", "it")[segment.start : segment.stop])[there] / count[there]
            at = (0.5 * (edges[there] + edges[there + 1]) - low) / (high - low) * PLACES
            hat = np.maximum(0.0, 1.0 - np.abs(at[:, np.newaxis] - np.arange(PLACES + 1)))
            both = np.hstack([hat, hat * points[number].force / level])
            weight = count[there] / count.sum()
            self._means.append(weight @ both)
            # each place has the same weight: a slow stroke has more samples there, and the same profile
            around = both - weight @ both
            normal.append(around.T @ around)
            right.append(around.T @ (force - weight @ force))
            covered += hat.sum(axis=0)
        self._normal, self._right = np.array(normal), np.array(right)
        middle = covered / covered.sum()
        zero = np.zeros_like(middle)
        self._zero = np.array([np.append(middle, zero), np.append(zero, middle)])

    def means(self, without: int | None = None) -> Real:
        """Return the error of each stroke's mean by the profile [N], from all strokes or all but one, shape (n,)."""
        normal, right = self._normal.sum(axis=0), self._right.sum(axis=0)
        if without is not None:
            normal, right = normal - self._normal[without], right - self._right[without]
        size = float(np.trace(normal)) / len(normal)
        bound = 1e-3 * size * np.eye(len(normal)) + 1e3 * size * self._zero.T @ self._zero
        return np.asarray(np.array(self._means) @ np.linalg.solve(normal + bound, right))

    def held_out(self, points: Sequence[SpeedPoint]) -> list[SpeedPoint]:
        """Return the points without the effect of the profile of all other strokes on each."""
        return self._without(points, np.array([self.means(n)[n] for n in range(len(self.numbers))]))

    def taken_off(self, points: Sequence[SpeedPoint]) -> tuple[list[SpeedPoint], Real]:
        """Return the points without the effect of the profile on each, and its error, by leaving out each stroke.

        The errors [N], shape (strokes, n), are directions in which the forces of all points move together: the sum of
        their squares is that of half a 95 % interval.
        """
        n, by = len(self.numbers), self.means()
        each = np.array([self.means(k) for k in range(n)])
        errors = np.zeros((n, len(points)))
        errors[:, self.numbers] = np.sqrt((n - 1) / n) * (each - each.mean(axis=0))
        return self._without(points, by, np.linalg.norm(errors, axis=0)), float(stdtrit(n - 1, 0.975)) * errors

    def _without(self, points: Sequence[SpeedPoint], by: Real, errors: Real | None = None) -> list[SpeedPoint]:
        found = list(points)
        for number, size in zip(self.numbers, by, strict=True):
            point = points[number]
            error = float(np.hypot(point.standard_error, 0.0 if errors is None else errors[number]))
            found[number] = replace(
                point, force=point.force - float(size), standard_error=error, over_position=float(size)
            )
        return found


def one_place(strokes: Strokes) -> Correction | None:
    """Allow for forces over position that `place` leaves: all slow strokes may be at one place of them.

    As in `Profile`, strokes share c + w in one direction and c - w in the other, and differ in their noise. So the mean
    product of the residuals of two long strokes, at places that are h apart, is the covariance γ(h) of what they share;
    the means of strokes i and k, whose shares of the places are p_i and p_k, have the covariance p_i·γ·p_k. If the
    directions do not meet, either may be all of it.
    """
    stretches = strokes.stretches.with_position
    if strokes.asked.over_position == "off" or not stretches or any(point.over_position for point in strokes.points):
        return None
    cut = [(log.require("position", "it")[s.start : s.stop], log.require("force", "it")[s.start : s.stop])
           for log, s in stretches.values()]  # fmt: skip
    edges = np.linspace(min(z.min() for z, _ in cut), max(z.max() for z, _ in cut), CELLS + 1)
    rest, seen = np.zeros((2, len(cut), CELLS))
    shares = np.zeros((len(strokes.points), CELLS))
    for n, (number, (z, F)) in enumerate(zip(stretches, cut, strict=True)):
        cell = np.clip(np.digitize(z, edges) - 1, 0, CELLS - 1)
        count = np.bincount(cell, minlength=CELLS)
        shares[number] = count / count.sum()
        if len(there := np.flatnonzero(count)) >= LONG:
            mean = np.bincount(cell, F, CELLS)[there] / count[there]
            rest[n, there], seen[n, there] = mean - np.polyval(np.polyfit(there, mean, 1), there), 1.0
    ahead = np.array([strokes.points[number].velocity > 0.0 for number in stretches])
    back, zero = ~ahead, CELLS - 1
    same, alike, noise = (_lagged(x, ahead, ahead) + _lagged(x, back, back) for x in (rest, seen, rest**2))
    if same[zero] <= SURE * (2.0 * noise[zero]) ** 0.5:
        return None
    across, meet = (_lagged(x, ahead, back) + _lagged(x, back, ahead) for x in (rest, seen))
    gamma, other = same / np.maximum(alike, 1.0), across / np.maximum(meet, 1.0)
    known = meet[zero] > 0.5 * alike[zero]
    apart = zero + np.subtract.outer(np.arange(CELLS), np.arange(CELLS))
    together = []
    for sign, size in ((1.0, 1.0), (-1.0, strokes.force / strokes.size)):  # forces, and friction, over position
        shared = 0.5 * (gamma + sign * other) if known else gamma
        values, vectors = np.linalg.eigh(shares @ shared[apart] @ shares.T)
        together.append(1.96 * (vectors * np.sqrt(np.maximum(values, 0.0))).T * size)
    return Correction(together=np.vstack(together))


def _lagged(x: Real, some: Mask, others: Mask) -> Real:
    """Return the sum of the products at all lags of rows of x, of two different strokes each, shape (2·n - 1,)."""
    found = np.correlate(x[some].sum(axis=0), x[others].sum(axis=0), "full")
    return np.asarray(found - sum(np.correlate(row, row, "full") for row in x[some & others]))


class _Stroke(NamedTuple):
    number: int
    time: Real  # Since it is at constant velocity, of batches [s]
    force: Real  # Means of batches over their standard error [1]
    error: float  # That standard error [N]
    level: float  # Friction [N]
    late: Real  # Time of the samples of which the point is the mean [s]

    def shape(self, log_C: float) -> Real:
        """Return the fall along these samples, starting from 1."""
        return np.asarray(np.exp(-self.late * np.exp(log_C) / self.level))

    def off(self, log_C: float) -> float:
        """Return the effect of the fall on the mean of those samples [N]."""
        return self.fall(log_C)[0] * float(np.mean(self.shape(log_C)))

    def fall(self, log_C: float) -> tuple[float, float]:
        """Return the fall from the beginning to the level, and its standard error [N]."""
        shape = np.exp(-self.time * np.exp(log_C) / self.level)
        around = shape - shape.mean()
        power = max(float(around @ around), 1e-12)
        fall = float(around @ self.force) / power
        return fall * self.error, self.error / power**0.5


class _Shared(NamedTuple):
    log_C: float
    half: float  # Half its 95 % interval
    scale: float  # Residuals over their standard error, 1 at least


def settling(strokes: Strokes) -> Correction | None:
    """Remove the remaining settling from the means of strokes, with a common C.

    After a change of velocity friction follows eq. (5): while all blocks slip, ``F - s(v)`` falls by
    ``exp(-t·C/s(v))``. Each stroke is fitted by a separate level and fall. The error of the correction is that of C,
    and the difference to one settling time for all strokes. If the strokes do not settle by eq. (5), or have settled,
    nothing is changed.
    """
    points, known = strokes.points, _batched(strokes)
    shared = _shared(known) if known else None
    if shared is None:
        return None
    number = np.array([stroke.number for stroke in known])
    taken = np.array([stroke.off(shared.log_C) for stroke in known])
    worth = np.abs(taken) > VISIBLE * np.array([points[n].standard_error for n in number])
    rises = np.array([points[n].force for n in number]) * taken < 0.0
    if not worth.any() or np.sum(np.abs(taken)[worth & rises]) > RISING * np.sum(np.abs(taken)[worth]):
        return None
    found = list(points)
    for stroke in compress(known, worth):
        found[stroke.number] = _settled(strokes, stroke, shared)
    together = np.zeros((2, len(points)))
    together[:, number] = worth * _errors(known, taken, shared)
    of, largest = strokes.asked.of, float(np.max(np.abs(taken[worth])))
    speeds = np.abs(strokes.velocity[number[worth]])
    notice = STROKES_SETTLING.found(
        strokes=int(worth.sum()), most=of(largest, "force"), share=largest / strokes.size,
        slowest=of(speeds.min(), "velocity"), fastest=of(speeds.max(), "velocity"),
        C=of(float(np.exp(shared.log_C)), "force rate"),
    )  # fmt: skip
    return Correction(points=found, together=together, notices=[notice])


def _errors(known: list[_Stroke], taken: Real, shared: _Shared) -> Real:
    """Return the errors of the correction [N]: by C, and by a common C of strokes, half widths, shape (2, n)."""
    step = min(shared.half, 0.3)
    up, down = (np.array([stroke.off(shared.log_C + by) for stroke in known]) for by in (step, -step))
    alike = [stroke._replace(level=float(np.median([other.level for other in known]))) for stroke in known]
    other = _shared(alike)  # one time for all, as a filter or a creep has it
    apart = 0.0 * taken if other is None else np.array([stroke.off(other.log_C) for stroke in alike]) - taken
    return np.array([(up - down) * shared.half / (2 * step), apart])


def _settled(strokes: Strokes, stroke: _Stroke, shared: _Shared) -> SpeedPoint:
    """Return the point of a stroke without its remaining settling."""
    point, (log, segment) = strokes.points[stroke.number], strokes.stretches[stroke.number]
    force = log.require("force", "the friction map")[segment.start : segment.stop]
    fall, error = stroke.fall(shared.log_C)
    mean = average(force - fall * stroke.shape(shared.log_C), strokes.asked.average)
    error *= shared.scale * float(np.mean(stroke.shape(shared.log_C)))
    error = float(np.linalg.norm([mean.standard_error, error, point.rounding]))
    settled = point.force + mean.value - average(force, strokes.asked.average).value
    return replace(point, force=settled, standard_error=error, settled=False)


def _shared(known: list[_Stroke]) -> _Shared | None:
    """Return the C of all strokes; None if they do not settle by eq. (5), or have settled."""
    longest = float(np.log(max(stroke.time[-1] / stroke.level for stroke in known)))
    counts = np.array([len(stroke.time) for stroke in known])
    begins = np.append(0, np.cumsum(counts[:-1]))
    rate = np.concatenate([stroke.time / stroke.level for stroke in known])
    force = np.concatenate([stroke.force for stroke in known])
    centred = force - np.repeat(np.add.reduceat(force, begins) / counts, counts)

    def residuals(log_C: float) -> Real:
        """Return the residuals of falls as `_Stroke.fall`, of all strokes one after the other [1]."""
        shape = np.exp(-rate * np.exp(log_C))
        around = shape - np.repeat(np.add.reduceat(shape, begins) / counts, counts)
        power = np.maximum(np.add.reduceat(around**2, begins), 1e-12)
        return centred - np.repeat(np.add.reduceat(around * force, begins) / power, counts) * around

    def cost(log_C: float) -> float:
        return float(np.sum(residuals(log_C) ** 2))

    grid = np.linspace(-1.0, 4.6, 36) - longest  # falls that take nearly three strokes, down to a hundredth of one
    if (nearest := int(np.argmin([cost(item) for item in grid]))) == 0:
        return None
    near = float(grid[nearest])
    log_C = float(minimize_scalar(cost, bounds=(near - 0.16, near + 0.16), method="bounded").x)
    left = residuals(log_C)
    freedom = max(len(left) - 2 * len(known) - 1, 1)
    chi2 = max(float(left @ left) / freedom, 1.0)
    if chi2 > UNLIKE or (float(centred @ centred) - float(left @ left)) / chi2 < GAIN + 2 * len(known):
        return None
    gradient = (residuals(log_C + 1e-3) - residuals(log_C - 1e-3)) / 2e-3
    plain = chi2 * float(stdtrit(freedom, 0.975)) ** 2 / max(float(gradient @ gradient), 1e-12)
    among = float(sandwich(gradient[:, np.newaxis], left, np.repeat(np.arange(len(known)), counts))[0, 0])
    return _Shared(log_C, max(plain, among) ** 0.5, chi2**0.5)


def _batched(strokes: Strokes) -> list[_Stroke]:
    points = strokes.points
    levels = [[p.force for p in points if p.velocity * sense > 0] for sense in (1, -1)]
    offset = sum(float(np.median(level)) for level in levels) / 2 if all(levels) else 0.0
    found = []
    for number, (log, segment) in strokes.stretches.items():
        if (n := segment.stop - segment.onset) < SAMPLES:
            continue
        each = max(n // BATCHES, 1)
        first = segment.stop - n // each * each
        force = log.require("force", "the friction map")[first : segment.stop].reshape(-1, each).mean(axis=1)
        since = log.time[segment.onset]
        time = log.time[first : segment.stop].reshape(-1, each).mean(axis=1) - since
        error = float(np.std(np.diff(force))) / 2**0.5
        level = abs(points[number].force - offset)
        if error > 0.0 and level > 0.0:
            late = log.time[segment.start : segment.stop] - since
            found.append(_Stroke(number, time, force / error, error, level, late))
    return found


def slope(strokes: Strokes) -> Correction | None:
    """Remove a force that rises along the axis from the records.

    Slow strokes stay at one end of the travel of fast strokes, so the rise would look like a dependence of friction on
    speed. `place` corrects further variation over position.
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
        record if not isinstance(record, Log) or record.position is None or record.force is None
        else replace(record, force=record.force - rises * (record.position - middle))
        for record in strokes.records
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
    if not (swings := [p for p in strokes.points if p.swing]):
        return None

    def into(problem: StribeckProblem, points: Sequence[SpeedPoint]) -> StribeckProblem:
        size = np.array([point.swing for point in points])
        return replace(problem, swing=size) if problem.fall and np.any(size > 0) else problem

    each = sorted(abs(p.velocity) for p in swings)
    slowest, fastest = (strokes.asked.says(v, "velocity") for v in (each[0], each[-1]))
    most = max(p.swing for p in swings)
    speeds = f"from {slowest} to {fastest}" if slowest != fastest else f"at {fastest}"
    found = {"strokes": len(swings), "most": most, "speeds": speeds, "sticks": most > STICKS}
    return Correction(into=into, notices=[STROKES_SWING.found(**found, several=len(swings) > 1)])


def counts(strokes: Strokes) -> Correction | None:
    """Mark strokes that move by a whole number of counts a sample: all samples are at one place between two counts."""

    def into(problem: StribeckProblem, points: Sequence[SpeedPoint]) -> StribeckProblem:
        strobed = np.array([point.stretch is not None and _moves_by_counts(*point.stretch) for point in points])
        return replace(problem, strobed=strobed) if strobed.any() else problem

    return Correction(into=into)


def _moves_by_counts(log: Log, segment: Segment) -> bool:
    step = None if log.position is None else lattice_step(log.position)
    moved = abs(segment.velocity) * float(np.median(np.diff(log.time))) / step if step else 0.0
    return moved > 0.5 and abs(moved - round(moved)) * len(segment) < 1.0


def rounding(strokes: Strokes) -> Correction | None:
    """Allow for coarse steps of the force: they shift all strokes together, and the slow against the fast."""
    by, points = strokes.rounded, strokes.points
    if by == 0.0 or len(points) < 2:
        return None
    along = np.argsort(np.argsort(np.abs(strokes.velocity))) / (0.5 * (len(points) - 1)) - 1.0
    together = by * np.sign(strokes.force) * np.array([np.ones_like(along), along])
    step = strokes.asked.of(force_step(logs_of_strokes(strokes.records)), "force")
    return Correction(together=together, notices=[FORCE_COARSE.found(step=step)] * (by > SMALL * strokes.size))


def damping(strokes: Strokes) -> Correction | None:
    """Fit the forces including the plant's damping, so that sigma may be below 0 if that was too large."""
    by = strokes.asked.damping

    return Correction(into=lambda problem, _: replace(problem, F=problem.F + by * problem.v)) if by else None


Look = Callable[[Strokes], Correction | None]

AT_ANY_SPEED: Mapping[str, Look] = {
    "slope": slope, "swing": swing, "rounding": rounding, "counts": counts,
}  # fmt: skip
"""Corrections for any number of speeds."""

OF_A_MAP: Mapping[str, Look] = {
    "damping": damping, "settling": settling, "place": place, "one place": one_place,
    "between records": between_records,
}  # fmt: skip
"""Further corrections before a map is fitted."""


def corrected(strokes: Strokes) -> Strokes:
    """Return the strokes with all corrections that they show."""
    for table in (AT_ANY_SPEED, OF_A_MAP):
        for look in table.values() if table is AT_ANY_SPEED or not strokes.one_speed else ():
            if (found := look(strokes)) is not None:
                strokes = strokes.without(found)
    return strokes
