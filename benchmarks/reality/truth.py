"""What each `identify` should find: the effective truth, as it can be seen in the logs of a session."""

from __future__ import annotations

from collections.abc import Sequence
from math import expm1, log1p, pi

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from benchmarks.reality.session import SPEEDS, Session
from fric.drive.sensing import low_pass_pole
from fric.friction.gms import GMS
from fric.simulate.machine import Axis
from fric.simulate.reality.flaws import Cogging, Drift, Wave

Real = NDArray[np.float64]


def drifted(drift: Drift | None, time: float) -> float:
    """Return the factor of a drift at a time."""
    return 1.0 - drift.amount * expm1(-time / drift.time) if drift is not None else 1.0


def waved(waves: Sequence[Wave | Cogging], session: Session, kind: str) -> float:
    """Return the mean of waves over the travel of the records of a kind, a place as often as it was passed."""
    travels = [np.linspace(log.position.min(), log.position.max(), 1001) for log in session.logs[kind]]
    length = [float(np.ptp(z)) for z in travels]
    sizes = [wave.amplitude if isinstance(wave, Wave) else wave.force for wave in waves]
    means = [
        sum(size * np.sin(2 * pi * z / wave.pitch + wave.phase).mean() for size, wave in zip(sizes, waves, strict=True))
        for z in travels
    ]
    return float(np.average(means, weights=length))


def model_of(axis: Axis) -> GMS:
    """Return the friction of an axis without its flaws."""
    assert isinstance(axis.friction, GMS)
    return axis.friction


def plant_truth(session: Session) -> dict[str, float]:
    """Return what a response shows of the plant: A holds viscous friction, T_d by how much the position is late."""
    axis, flaws = session.axis, session.axis.reality
    faded = drifted(flaws.force_constant, session.middle("frequency-response"))
    lag = flaws.force.lag - flaws.clock.input
    if np.isfinite(flaws.force.filter):
        p = low_pass_pole(flaws.force.filter, axis.cascade.sampling)
        lag += p / (1.0 - p) * axis.cascade.T_s
    return {
        "A": axis.plant.A + model_of(axis).static.sigma / axis.plant.M,
        "B": axis.plant.B * faded,
        "T_d": axis.plant.T_d + flaws.clock.position - flaws.clock.input,
        "K_f": axis.plant.K_f,
        "force_lag": lag,
    }


def steady_force(session: Session, v: Real) -> Real:
    """Return the mean force that is logged in steady sliding [N], damping of the drive included."""
    axis, flaws, static = session.axis, session.axis.reality, model_of(session.axis).static
    time = session.middle("constant-velocity")
    back, speed = v < 0, np.abs(v)
    level = drifted(flaws.friction, time) * np.where(back, flaws.direction.level, 1.0)
    level *= 1.0 + waved(flaws.waves, session, "constant-velocity")
    aged = np.ones_like(v)
    if flaws.dwell is not None:
        aged += flaws.dwell.growth * np.log1p(flaws.dwell.distance / speed / flaws.dwell.time)
    stribeck = static.F_c + (static.F_s * aged - static.F_c) * np.exp(-((speed / static.v_s) ** static.delta))
    viscous = static.sigma * np.where(back, flaws.direction.viscous, 1.0) + axis.plant.damping
    force = np.sign(v) * level * stribeck + viscous * v + load_of(session)
    return force / drifted(flaws.force_constant, time)


def load_of(session: Session) -> float:
    """Return the load on the axis, with the mean of the force over the places of the strokes [N]."""
    return session.axis.constant_load + waved(session.axis.reality.cogging, session, "constant-velocity")


def static_truth(session: Session, damping: float, direction: int = 0) -> dict[str, float]:
    """Return eq. (2) with an offset, fitted to the mean force at the speeds of the strokes.

    Parameters
    ----------
    session
        The session.
    damping
        What is taken off the force before the map is fitted [N·s/m].
    direction
        1 or -1 for the map of one direction, whose offset is the constant load; 0 for that of both.
    """
    v = np.concatenate([SPEEDS, -np.array(SPEEDS)]) if not direction else direction * np.array(SPEEDS)
    load = load_of(session) if direction else 0.0
    F = steady_force(session, v) - damping * v - load

    def misfit(x: Real) -> Real:
        F_c, rise, v_s, sigma, offset = x
        offset *= not direction
        return (np.sign(v) * (F_c + rise * np.exp(-np.abs(v) / (1e-3 * v_s))) + sigma * v + offset - F) / np.abs(F)

    static = model_of(session.axis).static
    start, lower = (
        [static.F_c, static.F_s - static.F_c, 1e3 * static.v_s, 1.0, 0.0],
        [0.0, 0.0, 1e-2, -damping, -np.inf],
    )
    F_c, rise, v_s, sigma, offset = least_squares(misfit, start, x_scale=[10, 10, 1, 100, 1], bounds=(lower, np.inf)).x
    return {"F_c": F_c, "F_s": F_c + rise, "v_s": 1e-3 * v_s, "sigma": max(sigma, 0.0), "offset": load + offset}


def gms_truth(session: Session) -> dict[str, float]:
    """Return what the sine in sliding should show."""
    return {"C": model_of(session.axis).C}


def virgin_truth(session: Session, z: Real) -> Real:
    """Return the virgin curve that the sines in pre-sliding should show [N]: the mean of both directions."""
    axis, flaws = session.axis, session.axis.reality
    time = session.middle("presliding-sine")
    level = drifted(flaws.friction, time) * (1.0 + flaws.direction.level) / 2.0
    level *= 1.0 + waved(flaws.waves, session, "presliding-sine")
    if flaws.dwell is not None:  # at the mean speed of the smaller sine, 15 µm at 0.2 Hz
        level *= 1.0 + flaws.dwell.growth * log1p(flaws.dwell.distance / 12e-6 / flaws.dwell.time)
    blocks = model_of(axis)
    limits = np.asarray(blocks.alpha) * blocks.static.F_s * level
    second = axis.second_mass
    springs = second is not None and second.encoder == "motor" and second.friction == "table"
    if springs and second is not None:  # the encoder sees the spring stretch by what the friction takes
        fine = np.linspace(0.0, float(z.max()), 20_001)
        whole = np.clip(np.multiply.outer(fine, np.asarray(blocks.k)), -limits, limits).sum(axis=-1)
        force = np.interp(z, fine + whole / second.stiffness, whole)
    else:
        force = np.clip(np.multiply.outer(z, np.asarray(blocks.k)), -limits, limits).sum(axis=-1)
    return np.asarray(force) / drifted(flaws.force_constant, time)
