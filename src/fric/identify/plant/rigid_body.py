"""Mass, viscous and Coulomb friction from an ordinary motion, without special excitation."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Literal

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Real
from fric.drive.plant import hold_delay
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.channel import K_F_MISSING
from fric.flaws.drift import RECORDS_VARY
from fric.flaws.response import (
    A_HOLDS_VISCOUS,
    CHANGES_BETWEEN,
    NOT_PHYSICAL,
    T_D_ASSUMED,
    VISCOUS_BY_DIRECTION,
)
from fric.identify.plant.force_constant import against_mass
from fric.identify.plant.force_constant import force_constant as slope_of_force
from fric.log import Log
from fric.notice import Notice
from fric.records.flaws import even_sampling, evened, record_flaws
from fric.records.inspection import CONDITION
from fric.records.motion import BANDWIDTH, Conditioning, kept, shows_mass, thinned
from fric.records.prepared import Drive, Prepared, prepared
from fric.statistics import DIFFERENT, Between, between_records, hac_covariance
from fric.units import Motion, readable, si_unit

UNLIKE = 0.05  # Share of the viscous friction by which directions differ from their mean, above which it is warned of
REST = 0.05  # Share of the largest speed below which the axis rests or creeps, and the force does not show friction
RESTS = 0.1  # Share of such samples above which they are left out; without a filter they always are
FEWEST = 30  # Least number of samples of a fit


@dataclass(frozen=True)
class MotionFit:
    """A rigid axis fitted to its motion: ``force = M·z̈ + F_v·ż + F_c·sign(ż) + offset``."""

    axis: str  # axis, motion: name and motion of the axis
    motion: Motion
    # ``force``, or ``input`` where no force was logged and no force constant given: then M, F_v, F_c and offset are in
    # volts (per m/s², per m/s)
    channel: Literal["force", "input"]
    # M, F_v, F_c and offset; or M and F_v, F_c of either direction. Intervals allow for correlated residuals.
    estimates: dict[str, Estimate]
    # Standard deviation of each by ordinary least squares, for independent residuals
    deviation: dict[str, float]
    plant: dict[str, Estimate]  # A, B, T_d of eq. (1), and K_f where it is known.
    relative_error: float  # ``‖residual‖/‖force‖`` [1]
    condition_number: float  # Of the observation matrix
    autocorrelation: float  # Of neighbouring residuals, after decimation
    sampling: float  # sampling, conditioning: sampling rate [Hz] and filters of the first record
    conditioning: Conditioning
    # time, measured, fitted: decimated samples: instants [s], and logged and fitted force, each of shape (n,)
    time: Real
    measured: Real
    fitted: Real
    warnings: tuple[Notice, ...] = ()  # Warnings: what the data do not determine


def identify_motion(
    logs: Sequence[Log],
    *,
    direction: Literal["both", "each"] = "both",
    force_constant: float | None = None,
    delay: float | None = None,
    cutoff: float | None = None,
    decimation: int | None = None,
    border: int | None = None,
    mass: float | None = None,
) -> MotionFit:
    """Fit a rigid axis to motions by least squares on zero-phase filtered, decimated signals.

    The inverse dynamic model of Janot, Gautier and Brunot (Nonlinear System Identification Benchmarks, 2019):
    the position is filtered forwards and backwards, differentiated by central differences, and each column of the
    observation matrix is decimated like the force. Where the rate would put the filter's corner into the motion there
    is no filter; many rests, and samples between which the speed changes, are left out.

    logs: Records of one axis, each with a force or an input; instants that jitter are made even.
    direction: Common F_v, F_c and an offset, or F_v and F_c for each direction (an offset is then half their
        difference).
    force_constant: K_f [N/V]; with it an input is used as force.
    delay: T_d [s], which a motion does not show; by default half a sample. If given, it is the delay of the force after
        its voltage.
    cutoff, decimation, border: See `Conditioning`; chosen from the sampling rate where not given.
    Raises FricError: When neither force nor input was logged, the sampling is uneven, or the motion does not separate
        the terms.
    """
    motion, flaws = logs[0].motion, record_flaws(logs, "plant")
    logs, clocks = zip(*map(evened, logs), strict=True)
    channel: Literal["force", "input"] = (
        "force" if all(log.force is not None for log in logs) or force_constant is not None else "input"
    )
    rates = [even_sampling(log) for log in logs]
    settings = [Conditioning.of(rate, cutoff, decimation, border) for rate in rates]
    scale = slope_of_force(logs, force_constant, motion)
    scaled = force_constant is not None
    served = [
        replace(log, force=None) if channel == "input" or (scaled and log.input is not None) else log for log in logs
    ]
    settings = [replace(s, cutoff=0.0) if cutoff is None and s.cutoff < 5 * BANDWIDTH else s for s in settings]
    records = prepared(served, drive=Drive(force_constant or 1.0, delay or 0.0, scale.shift), filters=settings)
    shown = [_in_motion(record, s) for record, s in zip(records, settings, strict=True)]
    settings = [
        s if record.used[s.border :].all() else replace(s, decimation=1)
        for record, s in zip(shown, settings, strict=True)
    ]
    names = ("M", "F_v", "F_c", "offset") if direction == "both" else ("M", *_EACH)
    X = np.vstack([_observations(record, s, direction) for record, s in zip(shown, settings, strict=True)])
    forces = [thinned(record.drive[record.used], s.decimation) for record, s in zip(shown, settings, strict=True)]
    times = [record.log.time[record.used] for record in shown]
    times = [t[kept(len(t), s.decimation)] for t, s in zip(times, settings, strict=True)]
    y, time = np.concatenate(forces), np.concatenate(times)
    if len(y) < FEWEST or not any(shows_mass(record.motion, record.used) for record in shown):
        what = f"at {max(rates):.3g} Hz the speed changes between samples, and the mass is not seen"
        raise FricError(what, where=logs[0].where, hint="Log ten samples or more of each start and stop.")
    _refuse_rank(X, names, logs[0])

    values = np.asarray(np.linalg.lstsq(X, y, rcond=None)[0], float)
    residual = y - X @ values
    spread = np.std(residual, ddof=1)
    deviation = spread * np.sqrt(np.diag(np.linalg.inv(X.T @ X)))
    lengths = [len(force) for force in forces]
    covariance = hac_covariance(X, residual, lengths)
    quantile = float(stdtrit(len(y) - len(values), 0.975))
    ends = np.cumsum(lengths)[:-1]
    between = between_records(np.split(X, ends), np.split(residual, ends), quantile)
    if between is not None:
        covariance = covariance + between.covariance

    half = quantile * np.sqrt(np.diag(covariance))
    units = [_unit(name, channel, motion) for name in names]
    estimates = {
        name: Estimate.around(float(v), unit, float(h))
        for name, v, h, unit in zip(names, values, half, units, strict=True)
    }

    K_f = scale.K_f
    plant = scale.estimates() | _plant(
        np.asarray(values, float), covariance, quantile, direction, channel, K_f, delay, max(rates), motion
    )
    lag = float(residual[1:] @ residual[:-1] / (residual @ residual))
    return MotionFit(
        logs[0].axis, motion, channel, estimates, dict(zip(names, map(float, deviation), strict=True)), plant,
        float(np.linalg.norm(residual) / np.linalg.norm(y)), float(np.linalg.cond(X)), lag, rates[0], settings[0],
        time, y, X @ values,
        (*_varies(between, estimates), *_directions(X, y, lengths, estimates),
         *_warnings(records, settings[0].border, estimates, K_f, delay),
         *scale.warnings, *against_mass(plant, mass, motion), *chain(*clocks), *flaws),
    )  # fmt: skip


_EACH = ("F_v_positive", "F_c_positive", "F_v_negative", "F_c_negative")


def _in_motion(record: Prepared, settings: Conditioning) -> Prepared:
    """Return a record without the samples at rest, where they are many or no filter blurs them."""
    speed = np.abs(record.motion.velocity)
    moving = speed >= REST * speed[record.used].max(initial=0.0)
    return record.restricted(moving) if not settings.cutoff or moving[record.used].mean() < 1.0 - RESTS else record


def _observations(record: Prepared, settings: Conditioning, direction: str) -> Real:
    v, acceleration = record.motion.velocity[record.used], record.motion.acceleration[record.used]
    if direction == "both":
        terms = [acceleration, v, np.sign(v), np.ones_like(v)]
    else:
        forth, back = (v > 0) + 0.5 * (v == 0), (v < 0) + 0.5 * (v == 0)
        terms = [acceleration, v * forth, np.sign(v) * forth, v * back, np.sign(v) * back]
    return np.column_stack([thinned(np.asarray(term, float), settings.decimation) for term in terms])


def _refuse_rank(X: Real, names: Sequence[str], log: Log) -> None:
    """Refuse a motion along which two terms are collinear, for any units of the columns."""
    size = np.linalg.norm(X, axis=0)
    dead = [name for name, norm in zip(names, size, strict=True) if norm == 0]
    if dead:
        raise FricError(
            f"the motion does not excite {', '.join(dead)}", where=log.where, hint="Log a motion in both directions."
        )
    if np.linalg.cond(X / size) > CONDITION:
        raise FricError(
            "the motion does not separate mass, viscous and Coulomb friction",
            where=log.where,
            hint="Log a motion in both directions, with changing speed and acceleration.",
        )


def _unit(name: str, channel: str, motion: Motion) -> str:
    dimension = "mass" if name == "M" else "viscous" if name.startswith("F_v") else "force"
    if channel == "force":
        return si_unit(dimension, motion)
    length = si_unit("position", motion)
    return {"mass": f"V*s^2/{length}", "viscous": f"V*s/{length}", "force": "V"}[dimension]


def _plant(  # noqa: PLR0913 - what a motion tells and what is given besides
    values: Real, covariance: Real, quantile: float, direction: str, channel: str,
    K_f: Estimate | None, delay: float | None, sampling: float, motion: Motion,
) -> dict[str, Estimate]:  # fmt: skip
    """Return A = F_v/M, B = K_f/M, and their intervals by the delta method."""
    M, viscous = values[0], np.zeros(len(values))  # the mean of the directions
    viscous[[1] if direction == "both" else [1, 3]] = 1.0 if direction == "both" else 0.5
    A = float(viscous @ values / M)
    gradient = viscous / M
    gradient[0] = -A / M
    half = quantile * float(np.sqrt(gradient @ covariance @ gradient))
    found = {"A": Estimate.around(A, si_unit("rate", motion), half)}
    k = 1.0 if channel == "input" else None if K_f is None else float(K_f)
    if k is not None:
        B = float(k / M)
        relative = quantile * float(np.sqrt(covariance[0, 0])) / abs(float(M))
        if channel == "force" and K_f is not None and isinstance(K_f.ci95, tuple):
            relative = float(np.hypot(relative, K_f.half_width / k))
        found["B"] = Estimate.around(B, si_unit("acceleration per input", motion), B * relative)
    unit = si_unit("time", motion)
    found["T_d"] = (
        Estimate(hold_delay(sampling), unit, assumed=True) if delay is None else Estimate(delay, unit, fixed=True)
    )
    if K_f is not None:
        found["K_f"] = K_f
    return found


def _directions(X: Real, y: Real, lengths: Sequence[int], estimates: Mapping[str, Estimate]) -> Iterator[Notice]:
    """Warn that viscous friction differs by direction: ``F_v·ż + d·|ż|`` has F_v + d forwards and F_v - d backwards."""
    if "F_v" not in estimates:
        return
    more = np.column_stack([X, np.abs(X[:, 1])])
    if np.linalg.cond(more / np.linalg.norm(more, axis=0)) > CONDITION:
        return
    values = np.linalg.lstsq(more, y, rcond=None)[0]
    error = float(np.sqrt(hac_covariance(more, y - more @ values, lengths)[-1, -1]))
    mean, by = float(values[1]), float(values[-1])
    if abs(by) > max(float(stdtrit(len(y) - len(values), 1 - DIFFERENT / 2)) * error, UNLIKE * abs(mean)):
        unit = estimates["F_v"].unit
        yield VISCOUS_BY_DIRECTION.found(forward=Estimate(mean + by, unit), backward=Estimate(mean - by, unit))


def _varies(between: Between | None, estimates: Mapping[str, Estimate]) -> Iterator[Notice]:
    """Warn about differences of records that chance does not explain."""
    if between is not None and between.chance < DIFFERENT:
        units = [estimate.unit for estimate in estimates.values()]
        by = [
            f"{name} by {readable(float(size), unit, 2)}"
            for name, size, unit in zip(estimates, between.deviations, units, strict=True) if size > 0.0
        ]  # fmt: skip
        masses = [readable(float(estimates["M"]) + float(off), units[0], 4) for off in between.off[:, 0]]
        yield RECORDS_VARY.found(by=by, order=[f"M {mass}" for mass in masses], one_speed=False, within=False)


def _warnings(
    records: Sequence[Prepared], border: int, estimates: dict[str, Estimate], K_f: Estimate | None, delay: float | None
) -> Iterator[Notice]:
    hidden = [float(np.mean(~record.used[border:])) for record in records]
    if any(hidden):
        yield CHANGES_BETWEEN.found(share=max(hidden))
    for name, estimate in estimates.items():
        if (name == "M" or name.startswith(("F_v", "F_c"))) and float(estimate) <= 0:
            yield NOT_PHYSICAL.found(name=name, value=estimate)
    yield A_HOLDS_VISCOUS.found()
    if delay is None:
        yield T_D_ASSUMED.found()
    if K_f is None:
        yield K_F_MISSING.found()
