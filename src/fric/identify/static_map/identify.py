"""Identification of the static friction map, eq. (2), from records at constant velocity (Section 3.1.1).

The way of the data: records → points, one a stroke → corrections of these → fit → directions → notices.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import sqrt

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Real
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.channel import FORCE_TURNED, ONE_DIRECTION
from fric.flaws.drift import OFFSET_SHARED
from fric.flaws.static_map import ONE_SPEED
from fric.identify.static_map.averages import Average
from fric.identify.static_map.corrections import AT_ANY_SPEED, OF_A_MAP, corrected
from fric.identify.static_map.forms import each_direction
from fric.identify.static_map.map_fit import MapFit, fit_map, widened
from fric.identify.static_map.notices import damping_notices, directions_differ, map_notices
from fric.identify.static_map.points import SpeedPoint, rounded_by
from fric.identify.static_map.strokes import Asked, Direction, Form, OverPosition, ShapeFactor, Strokes, Weights
from fric.log import ForceVelocity, Log
from fric.notice import Notice
from fric.records.flaws import record_flaws, stroke_flaws
from fric.threads import one_blas_thread
from fric.units import Motion, si_unit


@dataclass(frozen=True)
class StaticFit:
    """What `identify_static` found."""

    axis: str
    motion: Motion
    points: tuple[SpeedPoint, ...]
    """Every steady stroke."""
    static: MapFit | None
    """The map of both directions, or of the positive one; None where one speed alone was logged."""
    negative: MapFit | None
    """The negative direction's own map where each direction has one."""
    at_speed: Mapping[str, Estimate]
    """Where one speed alone was logged: ``velocity`` and ``force`` there."""
    warnings: tuple[Notice, ...]
    """What the data cannot tell."""
    method: str
    """How the fit was made, in words."""
    plant: Plant | None = None
    """The plant whose damping was taken off; None where nothing was."""
    between_records: Mapping[str, Estimate] = field(default_factory=dict)
    """Standard deviation of the ``level`` [1] and the ``offset`` [N] of records, where these are seen."""


@one_blas_thread()
def identify_static(  # noqa: PLR0913 - the verb of its name gives each setting
    records: Sequence[Log | ForceVelocity],
    *,
    plant: Plant | None = None,
    delta: ShapeFactor = "auto",
    direction: Direction = "auto",
    over_position: OverPosition = "auto",
    weights: Weights = "error",
    average: Average = "robust",
    form: Form = "auto",
    load: float | None = None,
    damping_error: float = 0.0,
) -> StaticFit:
    """Identify the static friction map, eq. (2), from strokes at constant velocity.

    Each steady segment gives one point: velocity, robust mean force, standard error. Strokes scatter beyond their
    noise (temperature, lubrication, place); the variance between them is estimated with the map, added to each
    point's own, and so weights and intervals know it. Intervals are by profile likelihood.

    The arguments are those of `fric.identify_static`, in SI; ``damping_error`` is half the 95 % interval of the plant's
    damping K_f·A/B [N·s/m], which the intervals allow for.

    Raises
    ------
    FricError
        When there is no steady stroke, or there are too few speeds for the parameters.
    """
    motion = records[0].motion
    asked = Asked(motion, plant, delta, direction, over_position, weights, average, form, load, damping_error)
    strokes = corrected(Strokes.of(records, asked), AT_ANY_SPEED)
    _refuse_stuck_force(strokes)
    amiss = record_flaws(strokes.logs, "static")
    speed = np.abs(strokes.velocity)
    if np.ptp(speed) <= 0.02 * speed.max():
        return _at_one_speed(strokes, amiss)
    strokes = corrected(strokes, OF_A_MAP)
    if direction == "each" and not strokes.both_directions:
        hint = "Log strokes in both directions, or use `direction='both'`."
        raise FricError("only one direction was measured", hint=hint)
    fit = fit_map(strokes, strokes.offset)
    fit, split = _directions_predict(fit)
    tried = fit.held_out
    fit, negative, notices = _each_direction(strokes, fit) if split else _both_directions(strokes, fit)
    taken_off = any(point.over_position for point in strokes.points)
    method = (
        f"{fit.describe_form(tried)}; separable least squares; weights {weights}; average {average}; "
        f"direction {'each' if split else 'both'}"
        + ("; what comes again at the same places taken off" if taken_off else "")
        + "; 95 % intervals by profile likelihood"
    )
    half = min(fit.estimates[name].half_width for name in ("F_c", "offset") if name in fit.estimates)
    level, stretches = float(np.median(np.abs(fit.problem.F))), strokes.stretches
    varies = stroke_flaws(stretches.pairs, stretches.place, force=level, half_width=half, taken_off=taken_off)
    warnings = (*amiss, *strokes.notices, *notices, *varies)
    return StaticFit(
        records[0].axis, motion, tuple(strokes.points), fit, negative, {}, warnings, method, plant,
        strokes.between_records,
    )  # fmt: skip


def stroke_forces(
    records: Sequence[Log | ForceVelocity], motion: Motion, plant: Plant | None
) -> tuple[SpeedPoint, ...]:
    """Return the points that a map is fitted to, corrected as `identify_static` does unless it is asked otherwise."""
    strokes = corrected(Strokes.of(records, Asked(motion, plant)), AT_ANY_SPEED)
    speed = np.abs(strokes.velocity)
    several = np.ptp(speed) > 0.02 * speed.max()
    return tuple((corrected(strokes, OF_A_MAP) if several else strokes).points)


def _refuse_stuck_force(strokes: Strokes) -> None:
    force = strokes.force
    if np.ptp(force) <= 1e-9 * np.abs(force).max(initial=0.0):
        raise FricError(
            f"every stroke took the same force, {strokes.asked.says(float(force[0]), 'force')}",
            where=strokes.records[0].source,
            hint="Is it the right column? Friction changes its sign with the direction.",
        )


def _directions_predict(fit: MapFit) -> tuple[MapFit, bool]:
    """Return the map with how well one for each direction predicts, and whether each direction is to have its own."""
    asked = fit.asked
    errors = None if asked.direction == "both" else each_direction(fit.problem, fit.solution, asked.damping)
    if errors is not None:
        fit = replace(fit, held_out=fit.held_out.entered("each", errors))
    predicts = errors is not None and fit.held_out.better("each") and bool(directions_differ(fit))
    return fit, asked.direction == "each" or predicts


def _both_directions(strokes: Strokes, fit: MapFit) -> tuple[MapFit, None, list[Notice]]:
    """Return the map of both directions, and what there is to say of it."""
    asked, v, force, notices = strokes.asked, strokes.velocity, strokes.force, list[Notice]()
    if not strokes.both_directions and asked.load is None:
        notices.append(ONE_DIRECTION.found())
    elif asked.plant is None and asked.load is None and np.median(force[v > 0]) < np.median(force[v < 0]):
        notices.append(FORCE_TURNED.found())
    if asked.load is not None:
        fit = replace(fit, estimates={**fit.estimates, "offset": _known(asked.load, asked.motion)})
    return fit, None, [*notices, *damping_notices(fit), *map_notices(fit)]


def _each_direction(strokes: Strokes, fit: MapFit) -> tuple[MapFit, MapFit, list[Notice]]:
    """Return the map of each direction, with the offset of both, and what there is to say of them."""
    asked, notices = strokes.asked, list[Notice]()
    shared = fit.estimates["offset"] if asked.load is None else _known(asked.load, asked.motion)
    if asked.load is None:  # where more than the level differs, the level will too
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


def _known(load: float, motion: Motion) -> Estimate:
    return Estimate(load, si_unit("force", motion), fixed=True)


def _at_one_speed(strokes: Strokes, amiss: Sequence[Notice]) -> StaticFit:
    """Return the friction at the one speed that was logged."""
    asked, sign = strokes.asked, np.sign(strokes.velocity)
    F = strokes.force * sign
    error: Real = np.array([point.standard_error for point in strokes.points])
    speed = float(np.mean(np.abs(strokes.velocity)))
    within = float(np.sqrt(np.sum(error**2))) / len(F)
    half = 1.96 * within
    if len(F) > 1:
        half = max(half, float(stdtrit(len(F) - 1, 0.975)) * float(np.std(F, ddof=1)) / sqrt(len(F)))
    half = float(np.hypot(half, rounded_by(strokes.points)))
    at_speed = {
        "velocity": Estimate(speed, si_unit("velocity", asked.motion)),
        "force": Estimate.around(float(np.mean(F)), si_unit("force", asked.motion), half),
    }
    warnings = (*amiss, *strokes.notices, ONE_SPEED.found(speed=asked.of(speed, "velocity")))
    method = f"mean of the strokes; average {asked.average}"
    first = strokes.records[0]
    return StaticFit(
        first.axis, asked.motion, tuple(strokes.points), None, None, at_speed, warnings, method, asked.plant
    )
