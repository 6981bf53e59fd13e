"""Identification of the GMS model (Section 3.2.1): from pre-sliding records to alpha, k and C."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fric.errors import FricError
from fric.estimate import Estimate, Interval
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.identify.loops.gms_fit import GMSFit, Replayed
from fric.identify.loops.gms_parameters import Parametrisation
from fric.identify.loops.gms_records import cycled, in_sliding, sorted_by_kind, taken_off
from fric.identify.loops.gms_warnings import told
from fric.identify.loops.knots import (
    MOST_BLOCKS,
    Blocks,
    Choice,
    blocks_from_knots,
    choose_blocks,
    fit_blocks,
    fit_without_cycles,
)
from fric.identify.loops.loops import Loops, find_loops
from fric.identify.loops.refine_gms import Measured, Refined, refine
from fric.identify.loops.virgin_curve import VirginCurve, virgin_curve
from fric.threads import one_blas_thread
from fric.units import Motion, si_unit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.drive.plant import Plant
    from fric.log import Log

ASSUMED_C = 1e4
"""Attraction parameter [N/s] where no record in sliding tells it: a lag s/C of 10 to 16 ms for Table 1."""
UNTOLD = float(np.log(10.0))
"""Half width of the interval of log C from which on the sliding record does not tell it: a factor of ten."""


@one_blas_thread()
def identify_gms(
    logs: Sequence[Log],
    *,
    static: StaticMap | None = None,
    plant: Plant | None = None,
    blocks: int | None = None,
    most_blocks: int = MOST_BLOCKS,
    knots: Sequence[float] | None = None,
    refined: bool = True,
    cycles: tuple[int, int] | None = None,
) -> GMSFit:
    """Identify alpha, k and C of the GMS model.

    The virgin curve is taken from the pre-sliding records, its knots give the blocks by eq. (6), and a replay of the
    GMS step along the measured motion refines them. C is fitted where a ``sliding-sine`` record is among the logs.

    Parameters
    ----------
    logs
        Records of one axis. Those of kind ``presliding-sine`` are used; where there are none, those of kind
        ``motion`` or of no kind.
    static
        The static map; without it the plateau gives F_c = F_s.
    plant
        The plant, whose inertia and linear damping are taken off the force.
    blocks
        Number of blocks; None leaves it to the information criterion.
    most_blocks
        Number of blocks that the criterion may choose.
    knots
        Displacements of the knots [m] (the paper's way): eq. (6) is solved for them.
    refined
        Whether to refine by replay.
    cycles
        First and last cycle of the pre-sliding records to fit, from 1; what is after them is held out.

    Raises
    ------
    FricError
        When no record has whole cycles, an amplitude is under three encoder steps, a channel was not logged, or the
        knots do not suit the curve.
    """
    presliding, sliding = sorted_by_kind(logs)
    taken = [taken_off(log, plant) for log in presliding]
    loops = [
        find_loops(log.name, motion, force, cycles) for log, (motion, force, _) in zip(presliding, taken, strict=True)
    ]
    curve = virgin_curve(loops, static)
    if static is not None and not curve.saturates:
        curve = replace(curve, level=static.F_s)
    unit = si_unit("force", presliding[0].motion)
    choice, found, without = _blocks(curve, blocks, most_blocks, knots, unit)
    base = static or StaticMap(found.limit.sum(), found.limit.sum(), 1e-3)

    measured = [cycled(one) for one in loops]
    slides = [taken_off(log, plant) for log in sliding] if static is not None else []
    with_C = refined and bool(slides)
    measured_sliding = [
        in_sliding(log.name, motion, force, plant is not None)
        for log, (motion, force, _) in zip(sliding, slides, strict=False)
    ]
    with_level = curve.saturates
    shape = Parametrisation(base, len(found), with_level, with_C, ASSUMED_C)
    lag = _alignment(measured_sliding, base, plant) if with_C else 0.0
    if refined:
        records = [*measured, *measured_sliding]
        fit = refine(records, found, base, C=ASSUMED_C, with_C=with_C, with_level=with_level)
        if with_C and not _reach_of_C(fit, lag) < UNTOLD:  # the sliding record does not tell C
            fit = refine(records, found, base, C=ASSUMED_C, with_C=False, with_level=with_level)
    else:
        fit = Refined(shape, shape.pack(found), np.array([shape.pack(one) for one in without]), np.empty((0, 0)))
    alpha, k, C, level = _estimates(fit, presliding[0].motion, lag)
    if static is None:
        base = replace(base, F_c=base.F_c * float(level), F_s=base.F_s * float(level))
        level = _relative(level)
    shares = tuple(share for _, _, share in [*taken, *slides])
    replays = [
        *(_replayed(one, record, fit.model, cycles) for one, record in zip(loops, measured, strict=True)),
        *(_replayed(None, record, fit.model, None) for record in measured_sliding),
    ]
    result = GMSFit(
        presliding[0].axis, presliding[0].motion, base, static is not None, alpha, k, C, level, curve, tuple(loops),
        found, choice, blocks, knots is not None, refined, tuple(replays), shares, (),
    )  # fmt: skip
    return replace(result, warnings=tuple(told(result, sliding_logged=bool(sliding), plant_given=plant is not None)))


def _blocks(
    curve: VirginCurve, count: int | None, most: int, knots: Sequence[float] | None, unit: str
) -> tuple[Choice | None, Blocks, list[Blocks]]:
    """Return how the number of blocks was chosen, the blocks, and the blocks without each cycle in turn."""
    if knots is not None:
        at = np.asarray(knots, float)
        if at[-1] > curve.displacement[-1]:
            raise FricError(
                f"the last knot is beyond the virgin curve, which ends at {curve.displacement[-1] * 1e6:.3g} µm",
                mend="Choose knots within it, or add a record of larger amplitude.",
            )
        found = blocks_from_knots(at, curve(at))
        without = []
        for other in curve.without_cycles():
            try:
                without.append(blocks_from_knots(at, other(at)))
            except FricError:  # without this cycle the curve is not concave at the knots
                without.append(found)
        return None, found, without
    choice = choose_blocks(curve, most, unit=unit) if count is None else None
    found = choice.blocks if choice else fit_blocks(curve, count or 1)
    return choice, found, fit_without_cycles(curve, found)


def _alignment(records: Sequence[Measured], static: StaticMap, plant: Plant | None) -> float:
    """Return by how much 1/C is uncertain because force and position are sampled together to within a sample.

    C is told by a lag s/C. The channels of a log are aligned to ±dt/2, evenly spread, which no number of cycles shows:
    the 95 % half width of 1/C is ``1.96·dt/√12`` over s. Without a plant the delay of the drive is not known either:
    that is twice as much.
    """
    dt = min(float(np.median(np.diff(record.motion.time))) for record in records)
    level = float(np.mean([static.level(record.motion.velocity[record.used]).mean() for record in records]))
    return (1.96 if plant else 3.92) * dt / np.sqrt(12.0) / level


def _estimates(fit: Refined, motion: Motion, lag: float) -> tuple[Estimate, Estimate, Estimate, Estimate]:
    """Return alpha, k and C with their intervals, and the level of the records; 1/C is uncertain by ``lag`` besides."""
    shape, x = fit.parametrisation, fit.x
    count = shape.count
    alpha_ci: tuple[Interval, ...] | None = None
    k_ci: tuple[Interval, ...] | None = None
    C_ci: Interval | None = None
    level_ci: Interval | None = None
    if len(fit.resampled) > 1:
        limits = fit.intervals()
        with np.errstate(over="ignore"):
            alpha_ci = tuple(_interval(1.0 / (1.0 + np.exp(-pair))) for pair in limits[:count])
            k_ci = tuple(_interval(np.exp(pair)) for pair in limits[count : 2 * count])
            if shape.with_level:
                level_ci = _interval(np.exp(limits[-2]))
            if shape.with_C:
                reach = _reach_of_C(fit, lag)
                C_ci = _interval(shape.attraction(x) * np.exp([-reach, reach]))
    alpha = Estimate(tuple(float(a) for a in shape.alpha(x)), "1", alpha_ci)
    k = Estimate(tuple(float(one) for one in shape.stiffness(x)), si_unit("stiffness", motion), k_ci)
    C = Estimate(shape.attraction(x), si_unit("force rate", motion), C_ci, assumed=not shape.with_C)
    return alpha, k, C, Estimate(shape.level(x), "1", level_ci)


def _reach_of_C(fit: Refined, lag: float) -> float:
    """Return half the width of the interval of log C; infinite where the cycles do not bound it."""
    spread = 0.5 * float(np.ptp(fit.intervals()[-1])) if len(fit.resampled) > 1 else 0.0
    reach = float(np.hypot(spread, lag * fit.parametrisation.attraction(fit.x)))
    return reach if np.isfinite(reach) else np.inf


def _relative(level: Estimate) -> Estimate:
    """Return a level relative to itself: the plateau is the static map."""
    if level.ci95 is None:
        return Estimate(1.0, level.unit)
    low, high = level.ci95
    assert isinstance(low, float)
    assert isinstance(high, float)
    return Estimate(1.0, level.unit, (low / float(level), high / float(level)))


def _interval(limits: NDArray[np.float64]) -> Interval:
    return float(limits[0]), float(limits[1])


def _replayed(loops: Loops | None, record: Measured, model: GMS, cycles: tuple[int, int] | None) -> Replayed:
    held_out = np.zeros(len(record.force), dtype=bool)
    if loops is not None and cycles is not None:
        held_out[np.flatnonzero(record.used)[-1] + 1 :] = True
    return Replayed(
        record.name, "sliding" if loops is None else "presliding", record.motion.time, record.motion.position,
        record.force, record.fitted(model), record.used, held_out,
    )  # fmt: skip
