"""Identification of the static friction map, eq. (2), from records at constant velocity (Section 3.1.1)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import sqrt
from typing import Literal

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Real
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import Estimate
from fric.identify.records.flaws import record_flaws, stroke_flaws
from fric.identify.records.over_strokes import OverPlace, over_place
from fric.identify.records.segments import Segment
from fric.identify.static_map.averages import Average
from fric.identify.static_map.forms import directions_predict
from fric.identify.static_map.identifiability import damping_warning, directions_differ, identifiability_warnings
from fric.identify.static_map.map_fit import Form, MapFit, ShapeFactor, SpeedPoint, Weights, fit_map, solved
from fric.identify.static_map.over_position import OverPosition, steady_strokes, without_places, without_slope
from fric.identify.static_map.points import rounded_by, stroke_points
from fric.identify.static_map.unsettled import settled_points
from fric.log import ForceVelocity, Log
from fric.notice import Notice
from fric.threads import one_blas_thread
from fric.units import Motion, readable, si_unit

Direction = Literal["auto", "both", "each"]


@dataclass(frozen=True)
class StaticFit:
    """What `identify_static` found.

    Parameters
    ----------
    axis, motion
        The axis.
    points
        Every steady stroke.
    static
        The map of both directions, or of the positive one; None where one speed alone was logged.
    negative
        The negative direction's own map where each direction was asked for.
    at_speed
        Where one speed alone was logged: ``velocity`` and ``force`` there.
    warnings
        What the data cannot tell.
    method
        How the fit was made, in words.
    plant
        The plant whose damping was taken off; None where nothing was.
    """

    axis: str
    motion: Motion
    points: tuple[SpeedPoint, ...]
    static: MapFit | None
    negative: MapFit | None
    at_speed: Mapping[str, Estimate]
    warnings: tuple[str, ...]
    method: str
    plant: Plant | None = None


@one_blas_thread()
def identify_static(
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

    Parameters
    ----------
    records
        Records of one axis, each with one or many strokes, and tables of mean forces at velocities.
    plant
        Where given, the drive's own linear damping ``K_f·(A/B)·v`` is taken off the force first.
    delta
        Stribeck shape factor [1], ``free`` to fit it, or ``auto``: 1, or free where that predicts better.
    direction
        ``both``: one map and an offset; ``each``: a map for each direction, and the offset that both share; ``auto``
        for each where they differ by more than chance and 1 %, and that predicts held-out strokes better.
    over_position
        ``on``: take off the mean of each stroke what comes again at its places; ``off``: do not; ``auto`` for what
        predicts held-out strokes better. A force that rises along the axis is taken off unless ``off``.
    weights
        ``error``: by standard error and scatter between strokes; ``equal``: every stroke the same.
    average
        ``robust`` (Huber) or ``median`` force of a segment.
    form
        ``coulomb`` for Coulomb plus viscous friction, ``stribeck`` for eq. (2), ``auto`` for the one of them that
        predicts strokes better that are held out.
    load
        The offset [N] where it is known, as the weight of a vertical axis; fitted where not given.
    damping_error
        Half the 95 % interval of the plant's damping K_f·A/B [N·s/m]; the intervals allow for it.

    Raises
    ------
    FricError
        When there is no steady stroke, or there are too few speeds for the parameters.
    """
    points, missing = stroke_points(records, average=average, plant=plant)
    level, slope = without_slope(records, points, over_position)
    if slope is not None:
        records, (points, missing) = level, stroke_points(level, average=average, plant=plant)
    logs = [record for record in records if not isinstance(record, ForceVelocity)]
    forces = np.array([point.force for point in points])
    if np.ptp(forces) <= 1e-9 * np.abs(forces).max(initial=0.0):
        raise FricError(
            f"every stroke took the same force, {readable(float(forces[0]), si_unit('force', logs[0].motion))}",
            where=records[0].source, hint="Is it the right column? Friction changes its sign with the direction.",
        )  # fmt: skip
    amiss = record_flaws(logs, "static") + missing
    axis, motion = records[0].axis, records[0].motion
    speeds = {round(abs(p.velocity), 12) for p in points}
    if np.ptp(np.abs([p.velocity for p in points])) <= 0.02 * max(speeds):
        at_speed, warning = _one_speed(points, motion)
        method = f"mean of the strokes; average {average}"
        return StaticFit(axis, motion, tuple(points), None, None, at_speed, (*amiss, warning), method, plant)

    strokes = steady_strokes(logs, points)
    place = over_place([(log, segment) for _, log, segment in strokes])
    unsettled = _unsettled(points, motion)
    points, settling, settles = settled_points(points, strokes, average, motion)
    damping = plant.damping if plant else 0.0
    fitting = partial(
        fit_map, delta=delta, weights=weights, motion=motion, form=form, damping=damping, damping_error=damping_error
    )
    points, together, other = without_places(
        points, strokes, place, over_position, partial(solved, delta=delta, weights=weights, form=form, damping=damping,
                                                       offset=load or 0.0), load is None,
    )  # fmt: skip
    moved = None if slope is None else slope.together(points, strokes)
    together = np.vstack([one for one in (settling, together, moved, _rounded(points)) if one is not None])
    warnings = amiss + ([] if slope is None else [slope.notice(motion)]) + (list[str](settles) or unsettled)
    positive, backward = [p for p in points if p.velocity > 0], [p for p in points if p.velocity < 0]
    if direction == "each" and not (positive and backward):
        raise FricError(
            "only one direction was measured", hint="Log strokes in both directions, or use --direction both."
        )
    known = None if load is None else Estimate(load, si_unit("force", motion), fixed=True)
    negative = None
    fit = fitting(
        points, with_offset=bool(positive and backward) and known is None, offset=load or 0.0, together=together,
    )  # fmt: skip
    fit.held_out.also |= other
    forms = fit.held_out
    differ = directions_differ(fit, motion)
    predicts = direction != "both" and directions_predict(fit.problem, fit.solution, fit.held_out, damping)
    if direction == "each" or (direction == "auto" and differ and predicts):
        shared = known or fit.estimates["offset"]
        text = (
            f"what both directions share, {readable(float(shared), si_unit('force', motion))}, is the offset (gravity, "
            "the bias of an amplifier) and no friction: strokes cannot tell it from a Coulomb friction that differs "
            "between the directions; give --load where you know it"
        )
        if load is None:  # where more than the level differs, the level will too
            warnings.append(Notice(text, "offset-shared", "wrong" if differ else "note"))
        mirrored = [replace(p, velocity=-p.velocity, force=-p.force) for p in backward]
        forward = np.array([p.velocity > 0 for p in points])
        fit, negative = (
            _with_shared(
                fitting(
                    own, with_offset=False, offset=sense * float(shared),
                    together=None if together is None else sense * together[:, forward == (sense > 0)],
                ),
                shared,
            )
            for own, sense in ((positive, 1.0), (mirrored, -1.0))
        )  # fmt: skip
        for name, one in (("positive", fit), ("negative", negative)):
            notices = identifiability_warnings(one, motion)
            warnings += (Notice(f"{name} direction: {text}", text.code, text.severity) for text in notices)
    else:
        if not (positive and backward) and load is None:
            warnings.append(Notice(
                "only one direction was measured: an offset of the force channel cannot be told from Coulomb "
                "friction, and 0 is assumed. Log strokes in both directions.", "one-direction", "doubt",
            ))  # fmt: skip
        elif plant is None and load is None and _median_force(positive) < _median_force(backward):
            warnings.append(Notice(
                "forward strokes took less force than backward ones: by these signs friction drives the axis, and "
                "this map means nothing. Turn the force's `sign:` in the mapping and ingest again.",
                "force-turned", "wrong",
            ))  # fmt: skip
        if known is not None:
            fit = replace(fit, estimates=dict(fit.estimates) | {"offset": known})
        if plant is not None:
            warnings += damping_warning(fit, plant, motion, damping_error)
        warnings += identifiability_warnings(fit, motion)
    warnings += _flaws(strokes, place, fit, taken_off=any(p.over_position for p in points))
    method = (
        f"{fit.describe_form(motion, forms)}; separable least squares; weights {weights}; average {average}; "
        f"direction {'each' if negative else 'both'}"
        + ("; what comes again at the same places taken off" if any(p.over_position for p in points) else "")
        + "; 95 % intervals by profile likelihood"
    )
    return StaticFit(axis, motion, tuple(points), fit, negative, {}, tuple(warnings), method, plant)


def _rounded(points: Sequence[SpeedPoint]) -> Real:
    """Return how coarse steps of the force put strokes off together [N], half widths, shape (2, n).

    All by one amount, and the slow ones against the fast ones; none where the force came in no such steps.
    """
    force = np.array([point.force for point in points])
    along = np.argsort(np.argsort([abs(point.velocity) for point in points])) / (0.5 * (len(points) - 1)) - 1.0
    return rounded_by(points) * np.sign(force) * np.array([np.ones_like(along), along])


def _median_force(points: Sequence[SpeedPoint]) -> float:
    return float(np.median([p.force for p in points]))


def _with_shared(fit: MapFit, offset: Estimate) -> MapFit:
    """Return a direction's map with the shared offset, its error in that of the levels."""
    wider = _wider(fit, offset.half_width)
    return replace(wider, estimates=dict(wider.estimates) | {"offset": offset})


def _wider(fit: MapFit, half: float) -> MapFit:
    """Return a map whose levels may all be off by as much [N] besides."""
    estimates = dict(fit.estimates)
    for name in ("F_c", "F_s"):
        one = fit.estimates[name]
        if one.ci95 is not None:
            below, above = float(one) - float(one.ci95[0]), float(one.ci95[1]) - float(one)  # type: ignore[arg-type]
            limits = (float(one) - float(np.hypot(below, half)), float(one) + float(np.hypot(above, half)))
            estimates[name] = replace(one, ci95=limits)
    return replace(fit, estimates=estimates)


def _flaws(
    strokes: Sequence[tuple[int, Log, Segment]], place: OverPlace | None, fit: MapFit, *, taken_off: bool
) -> list[Notice]:
    """Return what is amiss with the strokes, held against the map that was fitted to them."""
    half = min(fit.estimates[name].half_width for name in ("F_c", "offset") if name in fit.estimates)
    level = float(np.median(np.abs(fit.problem.F)))
    both = [(log, segment) for _, log, segment in strokes]
    return stroke_flaws(both, place, force=level, half_width=half, taken_off=taken_off)


def _unsettled(points: Sequence[SpeedPoint], motion: Motion) -> list[str]:
    speeds = dict.fromkeys(readable(p.velocity, si_unit("velocity", motion)) for p in points if not p.settled)
    if not speeds:
        return []
    text = f"the force had not settled by half of the strokes at {', '.join(speeds)}: log longer strokes."
    return [Notice(text, "strokes-unsettled", "doubt")]


def _one_speed(points: Sequence[SpeedPoint], motion: Motion) -> tuple[dict[str, Estimate], str]:
    sign = np.sign([p.velocity for p in points])
    F, error = np.array([(p.force, p.standard_error) for p in points]).T * np.array([sign, np.ones_like(sign)])
    speed = float(np.mean(np.abs([p.velocity for p in points])))
    value = float(np.mean(F))
    within = float(np.sqrt(np.sum(error**2))) / len(F)
    across = float(np.std(F, ddof=1)) / sqrt(len(F)) if len(F) > 1 else 0.0
    half = max(1.96 * within, float(stdtrit(len(F) - 1, 0.975)) * across if len(F) > 1 else 0.0)
    half = float(np.hypot(half, rounded_by(points)))
    at_speed = {
        "velocity": Estimate(speed, si_unit("velocity", motion)),
        "force": Estimate.around(value, si_unit("force", motion), half),
    }
    words = readable(speed, si_unit("velocity", motion))
    text = f"one speed alone was logged ({words}): the friction there is given, and no map."
    return at_speed, Notice(text, "one-speed", "doubt")
