"""Identification of the static friction map, eq. (2), from records at constant velocity (Section 3.1.1).

The data pass from records to points (one per stroke), corrections of these, the fit, directions and notices.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isinf, log, sqrt

import numpy as np
from scipy.special import chdtrc, fdtrc, stdtrit

from fric.arrays import Real
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws import static_map as flaws
from fric.flaws.channel import FORCE_TURNED, ONE_DIRECTION
from fric.flaws.drift import DIRECTIONS_DIFFER, FRICTION_AGES, OFFSET_SHARED
from fric.flaws.static_map import ONE_SPEED
from fric.identify.static_map.corrections import corrected
from fric.identify.static_map.map_fit import MapFit, each_direction, explained, fit_map, widened
from fric.identify.static_map.points import Asked, SpeedPoint, Strokes
from fric.identify.static_map.stribeck_fit import StribeckProblem
from fric.log import ForceVelocity, Log
from fric.notice import Notice
from fric.process import one_blas_thread
from fric.records.flaws import record_flaws, stroke_flaws
from fric.records.over_strokes import REPEATED
from fric.statistics import robust_deviation, smoother_than_noise
from fric.units import Motion, si_unit

TAKEN = 0.05  # Tolerance of the plant's damping, as a share, before the strokes contradict it
DIFFERENT = 1e-3  # Probability by chance below which directions count as different
MISSED = 0.005  # Common error of a map in both directions at a speed (rms) over the force above which it is warned of
PAIRS, ALIKE = 6, 0.2  # Least number of speeds with several strokes, each way, and most scatter of their ratios
SEEN = 0.5  # Least share of the fall from F_s to F_c above the slowest stroke for strokes to determine F_s


@dataclass(frozen=True)
class StaticFit:
    """Result of `identify_static`."""

    axis: str
    motion: Motion
    points: tuple[SpeedPoint, ...]  # Every steady stroke
    static: MapFit | None  # The map of both directions, or of the positive; None where only one speed was logged
    negative: MapFit | None  # The map of the negative direction where each direction has a map
    at_speed: Mapping[str, Estimate]  # Where one speed alone was logged: ``velocity`` and ``force`` there
    warnings: tuple[Notice, ...]  # Warnings: what the data do not determine
    method: str  # How the fit was made, in words
    plant: Plant | None = None  # The plant whose damping was subtracted; None where none was
    between_records: Mapping[str, Estimate] = field(default_factory=dict)  # Deviation: ``level`` [1], ``offset`` [N]
    over_position: Estimate | None = None  # Standard deviation of friction over position [N], if strokes agree on it


@one_blas_thread()
def identify_static(records: Sequence[Log | ForceVelocity], asked: Asked) -> StaticFit:
    """Identify the static friction map, eq. (2), from strokes at constant velocity.

    Each steady segment gives one point: velocity, robust mean force, standard error. Strokes scatter beyond their
    noise (temperature, lubrication, place); the variance between them is estimated with the map and added to the
    variance of each point, so that weights and intervals include it. Intervals are by profile likelihood.

    Raises FricError: When there is no steady stroke, or there are too few speeds for the parameters.
    """
    strokes = corrected(Strokes.of(records, asked))
    amiss = record_flaws(strokes.logs, "static", asked.plant)
    if strokes.one_speed:
        return _at_one_speed(strokes, amiss)
    if asked.direction == "each" and not strokes.both_directions:
        hint = "Log strokes in both directions, or use `direction='both'`."
        raise FricError("only one direction was measured", hint=hint)
    fit = fit_map(strokes, strokes.offset)
    fit, split = _directions_predict(fit)
    tried = fit.held_out
    fit, negative, notices = _each_direction(strokes, fit) if split else _both_directions(strokes, fit)
    taken_off = any(point.over_position for point in strokes.points)
    method = f"{fit.describe_form(tried)}; separable least squares; weights {asked.weights}; average {asked.average}; "
    method += f"direction {'each' if split else 'both'}{'; force over position removed' if taken_off else ''}"
    method += "; 95 % intervals by profile likelihood"
    half = min(fit.estimates[name].half_width for name in ("F_c", "offset") if name in fit.estimates)
    level, pairs = float(np.median(np.abs(fit.problem.F))), list(strokes.stretches.values())
    place = strokes.stretches.place
    scattered = any(notice.code == flaws.STROKES_SCATTER.code for notice in notices)
    varies = stroke_flaws(pairs, place, force=level, half_width=half, taken_off=taken_off, scattered=scattered)
    warnings = (*amiss, *strokes.notices, *notices, *varies)
    return StaticFit(
        records[0].axis, asked.motion, tuple(strokes.points), fit, negative, {}, warnings, method, asked.plant,
        strokes.between_records, asked.of(place.most_friction, "force") if place and place.friction else None,
    )  # fmt: skip


def _directions_predict(fit: MapFit) -> tuple[MapFit, bool]:
    """Return the map with the prediction errors of a map for each direction, and whether to use such maps."""
    asked = fit.asked
    errors = None if asked.direction == "both" else each_direction(fit.problem, fit.solution, asked.damping)
    if errors is not None:
        fit = replace(fit, held_out=fit.held_out.entered("each", errors))
    predicts = errors is not None and fit.held_out.better("each") and bool(directions_differ(fit))
    return fit, asked.direction == "each" or predicts


def _both_directions(strokes: Strokes, fit: MapFit) -> tuple[MapFit, None, list[Notice]]:
    asked, v, force = strokes.asked, strokes.velocity, strokes.force
    notices, known = [*damping_notices(fit), *map_notices(fit)], fit.estimates
    if asked.load is not None:
        fit = replace(fit, estimates={**known, "offset": replace(asked.of(asked.load, "force"), fixed=True)})
    elif not strokes.both_directions:  # the load may have either sign, so that it bounds neither level
        notices.insert(0, ONE_DIRECTION.found(level=known["F_c"]))
        apart = {name: replace(known[name], ci95=(0.0, np.inf)) for name in ("F_c", "F_s")}
        fit = replace(fit, estimates={**known, **apart})
    elif asked.plant is None and np.median(force[v > 0]) < np.median(force[v < 0]):
        notices.insert(0, FORCE_TURNED.found())
    return fit, None, notices


def _each_direction(strokes: Strokes, fit: MapFit) -> tuple[MapFit, MapFit, list[Notice]]:
    """Return the map of each direction, with the offset of both, and warnings."""
    asked, notices = strokes.asked, list[Notice]()
    shared = fit.estimates["offset"]
    if asked.load is not None:
        shared = replace(asked.of(asked.load, "force"), fixed=True)
    else:  # where more than the level differs, the level will too
        differ = bool(directions_differ(fit))
        notices.append(OFFSET_SHARED.found(offset=asked.of(float(shared), "force"), differ=differ))
    maps: list[MapFit] = []
    for name, sense in (("positive", 1.0), ("negative", -1.0)):
        found = fit_map(strokes.one_way(sense), sense * float(shared))
        wider = {
            level: widened(found.estimates[level], lambda half: float(np.hypot(half, shared.half_width)))
            for level in ("F_c", "F_s")
        }
        maps.append(replace(found, estimates={**found.estimates, **wider, "offset": shared}))
        notices += (notice.at(f"{name} direction") for notice in map_notices(maps[-1]))
    return maps[0], maps[1], notices


def _at_one_speed(strokes: Strokes, amiss: Sequence[Notice]) -> StaticFit:
    asked, sign = strokes.asked, np.sign(strokes.velocity)
    F = strokes.force * sign
    error: Real = np.array([point.standard_error for point in strokes.points])
    speed = float(np.mean(np.abs(strokes.velocity)))
    half = 1.96 * (float(np.sqrt(np.sum(error**2))) / len(F))
    if len(F) > 1:
        half = max(half, float(stdtrit(len(F) - 1, 0.975)) * float(np.std(F, ddof=1)) / sqrt(len(F)))
    half = float(np.hypot(half, strokes.rounded))
    force = Estimate.around(float(np.mean(F)), si_unit("force", asked.motion), half)
    velocity = asked.of(speed, "velocity")
    warnings = (*amiss, *strokes.notices, ONE_SPEED.found(speed=velocity))
    return StaticFit(
        strokes.records[0].axis, asked.motion, tuple(strokes.points), None, None,
        {"velocity": velocity, "force": force}, warnings, f"mean of the strokes; average {asked.average}", asked.plant,
    )  # fmt: skip


def map_notices(fit: MapFit) -> Iterator[Notice]:
    """Return the warnings about undetermined parameters of a fitted map."""
    for look in (_fall, _ageing, _strokes, _scatter, directions_differ, _misfit):
        yield from look(fit)


def _slowest(fit: MapFit) -> Estimate:
    return fit.asked.of(np.abs(fit.problem.v).min(), "velocity")


def _fall(fit: MapFit) -> Iterator[Notice]:
    """Warn if the strokes do not show the fall of friction with speed."""
    of, slowest, theta = fit.asked.of, _slowest(fit), fit.solution.theta
    speed, flat = float(slowest), theta["F_s"] <= theta["F_c"] * (1 + 1e-9)
    ends = [limit for name in ("F_s", "v_s") for limit in fit.estimates[name].ci95 or (0.0,)]
    if not fit.problem.fall:
        if "stribeck" in fit.held_out.errors:
            plain, falling = (of(fit.held_out[form], "force") for form in ("coulomb", "stribeck"))
            yield flaws.FALL_NOT_SEEN.found(slowest=slowest, plain=plain, falling=falling)
        return
    if flat or any(limit == 0.0 or isinf(limit) for limit in ends):  # type: ignore[arg-type]
        yield flaws.FALL_OPEN.found(slowest=slowest)
    elif (seen := float(np.exp(-((speed / theta["v_s"]) ** theta["delta"])))) < SEEN:
        lowest = of(float(fit.static_map.level(speed)), "force")
        yield flaws.F_S_EXTRAPOLATED.found(below=1 - seen, slowest=slowest, lowest=lowest)
    if not flat and theta["F_c"] <= 0.0:
        yield flaws.F_C_AT_BOUND.found()


def _ageing(fit: MapFit) -> Iterator[Notice]:
    """Warn that F_s grows with the time of contact."""
    if (rise := fit.held_out.ages) is not None:
        plain, ageing = (fit.asked.of(fit.held_out[form], "force") for form in ("stribeck", "ages"))
        more = fit.asked.of(rise * log(10.0), "force")
        yield FRICTION_AGES.found(rise=more, slowest=_slowest(fit), ageing=ageing, plain=plain)


def _strokes(fit: MapFit) -> Iterator[Notice]:
    """Name the strokes with reduced weight."""
    if fit.standing_off:
        most = max(by for _, by in fit.standing_off)
        share = most / float(np.median(np.abs(fit.problem.F)))
        named = [f"{point.record} ({fit.asked.says(point.velocity, 'velocity')})" for point, _ in fit.standing_off]
        yield flaws.STROKES_STAND_OFF.found(strokes=named, most=fit.asked.of(most, "force"), share=share)


def _scatter(fit: MapFit) -> Iterator[Notice]:
    """Return the warning about scatter of strokes beyond their noise, unless single strokes explain it."""
    problem = fit.problem
    values = problem.standard_error**2 - fit.between**2  # of each stroke's noise, which may be small beside the scatter
    single = float(np.sum(fit.residual**2 / values)) if values.min() > 0 else np.inf
    if fit.between and chdtrc(problem.degrees_of_freedom, single) < 0.01:
        share = fit.between / float(np.median(np.abs(problem.F)))
        spread, large, levels = fit.asked.of(fit.between, "force"), share > flaws.SCATTERED, _levels(problem)
        yield flaws.STROKES_SCATTER.found(spread=spread, share=share, large=large, levels=levels, two=levels > 1.0)


def _levels(problem: StribeckProblem) -> float:
    """Return the ratio of the forces of strokes of the same velocities if it is the same for all; else 1."""
    found = []
    for way in (problem.v > 0, problem.v < 0):
        order = np.argsort(problem.v[way])
        v, F = problem.v[way][order], np.abs(problem.F[way][order])
        parts = np.split(F, np.flatnonzero(np.diff(v) > REPEATED * np.abs(v[1:])) + 1)
        ratios = np.log([part.max() / part.min() for part in parts if len(part) > 1])
        if len(ratios) < PAIRS or robust_deviation(ratios - np.median(ratios)) > ALIKE * np.median(ratios):
            return 1.0
        found.append(float(np.median(ratios)))
    return float(np.exp(np.mean(found)))


def _misfit(fit: MapFit) -> Iterator[Notice]:
    """Warn if the residuals are not noise."""
    problem = fit.problem
    smooth = smoother_than_noise((fit.residual / problem.standard_error)[np.argsort(problem.v)], -2.33)
    missed = 0.0 if smooth else _missed_both_ways(fit)
    if fit.rmse > 1e-6 * float(np.abs(problem.F).max()) and (smooth or missed):
        yield flaws.RESIDUALS_FOLLOW_SPEED.found(smooth=smooth, missed=fit.asked.of(missed, "force"))


def _missed_both_ways(fit: MapFit) -> float:
    """Return the common deviation from the map of strokes of a speed in both directions (rms) [N]; 0 if it is small, or
    if the directions differ by as much. Half the sum of their residuals is the error of the map, half the difference
    does not repeat. With few speeds tests of neighbours fail: of ten speeds, a wave of the residuals has two or three.
    """
    problem = fit.problem
    aside = np.isin(problem.v, [point.velocity for point, _ in fit.standing_off])
    steady = ~(explained(problem, fit.solution.theta, fit.residual) | aside)  # which are noted
    v, r = problem.v[steady], (np.sign(problem.v) * fit.residual)[steady]
    if (forward := v > 0).all() or not forward.any():
        return 0.0
    apart = np.abs(np.log(-v[~forward] / v[forward][:, None]))
    paired = apart.min(axis=1) < REPEATED
    there, back = r[forward][paired], r[~forward][apart.argmin(axis=1)[paired]]
    if (n := len(there) - len(problem.free)) < 2:
        return 0.0
    missed, rest = (float(np.mean((there + sign * back) ** 2)) / 4 for sign in (1.0, -1.0))
    little = missed < (MISSED * float(np.median(np.abs(problem.F)))) ** 2
    return 0.0 if little or fdtrc(n, len(there) - 1, missed / max(rest, 1e-300)) > DIFFERENT else missed**0.5


def directions_differ(fit: MapFit) -> Sequence[Notice]:
    """Warn if the directions differ by more than an offset: half their sum then changes with speed."""
    problem, v = fit.problem, np.abs(fit.problem.v)
    if (n := len(v) - len(problem.free) - 2) < 4 or len(np.unique(np.sign(problem.v))) < 2:
        return []
    even = np.column_stack([v, np.exp(-v / fit.solution.theta["v_s"]), np.ones_like(v)])
    even, r = even / problem.standard_error[:, None], fit.residual / problem.standard_error
    J = problem.jacobian(fit.solution.theta) / problem.standard_error[:, None]
    size = np.linalg.norm(J, axis=0)
    Q, _ = np.linalg.qr(J[:, size > 0] / size[size > 0])
    rest = r - Q @ (Q.T @ r)
    even = even - Q @ (Q.T @ even)
    found = np.linalg.lstsq(even, rest, rcond=1e-6)[0]
    left = rest - even @ found
    ratio = 0.5 * float(rest @ rest - left @ left) / max(float(left @ left) / n, 1e-300)
    most = float(np.max(np.abs(even @ found * problem.standard_error)))
    if fdtrc(2, n, ratio) > DIFFERENT or most < 0.01 * float(np.median(np.abs(problem.F))):
        return []
    return [DIRECTIONS_DIFFER.found(by=fit.asked.of(2 * most, "force"))]


def damping_notices(fit: MapFit) -> Sequence[Notice]:
    """Return a warning if a plant removed more than the damping of the drive, or all viscous friction with it.

    A response shows the sum of both in A; sigma is then the remainder, which is 0 within its error and the plant's.
    """
    problem, theta, asked = fit.problem, fit.solution.theta, fit.asked
    if asked.plant is None or theta["sigma"] > 0 or "sigma" not in problem.free:
        return []
    by_force = problem.inverse(fit.solution)[problem.free.index("sigma")]
    short = -theta["sigma"] - float(by_force @ (fit.residual / problem.standard_error))
    error = float(np.hypot(2 * np.linalg.norm(by_force), asked.damping_error))
    damping = asked.of(asked.damping, "viscous")
    if short > max(error, TAKEN * asked.damping):
        return [flaws.DAMPING_TOO_LARGE.found(damping=damping, beyond=asked.of(short, "viscous"))]
    return [flaws.SIGMA_IN_A.found(damping=damping)]
