"""A servo axis with GMS friction on circles, slow and plain: no code of fric, against which tuning is tried.

The friction is eqs. (3) and (4) of the paper by semi-implicit Euler steps of a sixteenth of a sample; the controller
runs at its own rate: a proportional position loop around a PI velocity loop, the inverse of the plant that it believes,
the friction that it believes, replayed along the reference, and an observer with a second-order binomial filter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

T = 2.5e-4
"""Sample of the controller [s]."""
STEPS = 16


@dataclass(frozen=True)
class Belief:
    """What a controller believes: plant, friction with its share fed forward, and how far ahead [s]."""

    A: float
    B: float
    K_f: float
    T_d: float
    friction: np.ndarray  # F_c, F_s, v_s, delta, sigma, C, then alpha, then k
    gain: float = 1.0
    lead: float = 0.0


@dataclass(frozen=True)
class PlainAxis:
    """An axis as it is, and its controller: gains, corner of the velocity filter [Hz] and of the observer (0: none)."""

    A: float
    B: float
    K_f: float
    T_d: float
    friction: np.ndarray
    believed: Belief
    K_v: float
    K_p: float
    K_i: float
    velocity_filter: float = 500.0
    observer: float = 0.0
    count: float = 0.25e-6


def motion(t: np.ndarray, radius: float, feed: float, quarter: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position, velocity and acceleration of a circle from rest; a quarter of a turn apart for the two axes."""
    ramp = 0.25
    s = np.clip(t / ramp, 0.0, 1.0)
    rate = feed / radius * np.where(t < ramp, s**3 * (10 - 15 * s + 6 * s**2), 1.0)
    change = feed / radius * np.where(t < ramp, 30 * s**2 * (1 - s) ** 2 / ramp, 0.0)
    angle = feed / radius * np.where(t < ramp, ramp * (2.5 * s**4 - 3 * s**5 + s**6), t - ramp / 2) - quarter
    r = radius * np.cos(angle)
    return r, -radius * np.sin(angle) * rate, -r * rate**2 - radius * np.sin(angle) * change


@numba.njit(cache=False)
def _friction_step(F, slips, F_c, F_s, v_s, delta, C, alpha, k, v, before, h):
    level = F_c + (F_s - F_c) * np.exp(-((abs(v) / v_s) ** delta))
    if v * before < 0.0:
        slips[:] = False
    total, way = 0.0, 1.0 if v >= 0.0 else -1.0
    for i in range(len(alpha)):
        if slips[i]:
            F[i] += way * min(C * (alpha[i] - way * F[i] / level), k[i] * abs(v)) * h
        else:
            F[i] += k[i] * v * h
            if way * F[i] >= alpha[i] * level:
                F[i], slips[i] = way * alpha[i] * level, True
        total += F[i]
    return total


@numba.njit(cache=False)
def _replayed(friction, r, v, h):
    n = (len(friction) - 6) // 2
    alpha, k = friction[6 : 6 + n], friction[6 + n :]
    F, slips, out, last = np.zeros(n), np.zeros(n, np.bool_), np.zeros(len(r)), 0.0
    for j in range(1, len(r)):
        for m in range(4):
            w = v[j - 1] + (v[j] - v[j - 1]) * (m + 1) / 4
            total = _friction_step(
                F, slips, friction[0], friction[1], friction[2], friction[3], friction[5], alpha, k, w, last, h / 4
            )
            last = w if w != 0.0 else last
        out[j] = total + friction[4] * v[j]
    return out


@numba.njit(cache=False)
def _run(A, B, K_f, delay, friction, gains, watch, count, place, r, v_r, forward, against, T):
    n = (len(friction) - 6) // 2
    alpha, k = friction[6 : 6 + n], friction[6 + n :]
    F, slips = np.zeros(n), np.zeros(n, np.bool_)
    K_v, K_p, K_i, corner = gains
    seen, volts, true = np.zeros(len(r)), np.zeros(len(r)), np.zeros(len(r))
    z, v, last, filtered, integral = r[0], 0.0, 0.0, 0.0, 0.0
    pole, h = np.exp(-2 * np.pi * corner * T), T / STEPS
    late = round(delay / h)  # plant's steps between a voltage and its effect
    A_n, B_n, cutoff = watch
    w = 2 * np.pi * cutoff
    lag, once, twice, given, told = np.exp(-w * T), 0.0, 0.0, 0.0, 0.0
    for j in range(len(r)):
        true[j] = z
        seen[j] = (np.floor(z / count + place + 0.5) - place) * count
        filtered = pole * filtered + (1 - pole) * (seen[j] - seen[max(j - 1, 0)]) / T
        error = K_v * (r[j] - seen[j]) + v_r[j] - filtered
        integral += K_i * T * error
        u = K_p * error + integral + forward[j]
        if cutoff > 0.0:  # d = Q·(z̈ + A·ż)/B - Q·u with Q = w²/(s + w)², two lags
            x = seen[j] - r[0]
            once += (1 - lag) * (x - once)
            twice += (1 - lag) * (once - twice)
            u -= (w * w * (x - 2 * once + twice) + A_n * w * (once - twice)) / B_n - told
            given += (1 - lag) * (u - given)
            told += (1 - lag) * (given - told)
        volts[j] = min(max(u + against[j], -10.0), 10.0)  # the observer sees what friction feedforward leaves
        for m in range(STEPS):
            back = j * STEPS + m - late
            acts = volts[back // STEPS] if back >= 0 else 0.0
            force = _friction_step(
                F, slips, friction[0], friction[1], friction[2], friction[3], friction[5], alpha, k, v, last, h
            )
            last = v if v != 0.0 else last
            v += h * (B * acts - A * v - (force + friction[4] * v) * B / K_f)
            z += h * v
    return true, seen, volts


def circle(
    axis: PlainAxis, quarter: float, radius: float, feed: float, *, turns: float = 2.1, place: float = 0.0
) -> dict[str, np.ndarray]:
    """Return what one axis records of a circle: time, reference, measured and true position [m], voltage [V]."""
    t = np.arange(0.0, 0.25 + turns * 2 * np.pi * radius / feed, T)
    r, v, _ = motion(t, radius, feed, quarter)
    told = axis.believed
    ahead, rate, change = motion(np.maximum(t + told.lead, 0.0), radius, feed, quarter)
    forward = (change + told.A * rate) / told.B
    against = told.gain * _replayed(told.friction, ahead, rate, T) / told.K_f
    gains = axis.K_v, axis.K_p, axis.K_i, axis.velocity_filter
    watch = told.A, told.B, axis.observer
    true, seen, volts = _run(
        axis.A, axis.B, axis.K_f, axis.T_d - T / 2, axis.friction, gains, watch, axis.count, place, r, v, forward,
        against, T,
    )  # fmt: skip
    return {"time": t, "reference": r, "position": seen, "true": true, "input": volts}


def glitch(x: np.ndarray, y: np.ndarray, radius: float, feed: float) -> float:
    """Return the largest glitch of the last turn: of the radius less its median, within 30° of a reversal [m]."""
    last = slice(-int(2 * np.pi * radius / feed / T), None)
    angle, rho = np.arctan2(y[last], x[last]), np.hypot(x[last], y[last])
    near = np.abs((angle + np.pi / 4) % (np.pi / 2) - np.pi / 4) <= np.pi / 6
    return float(np.abs(rho - np.median(rho))[near].max())


def drawn(rng: np.random.Generator) -> PlainAxis:
    """Return a clean axis with odd parameters, whose controller believes it nearly as it is.

    Its encoder shows how friction sets in: the first block slips over four counts or more.
    """
    mass, K_f = rng.uniform(20, 150), rng.uniform(120, 700)
    F_c = rng.uniform(0.1, 0.25) * K_f
    n = int(rng.integers(3, 5))
    alpha = np.sort(rng.dirichlet(np.full(n, 4.0)))[::-1]
    count = float(rng.choice([0.1e-6, 0.25e-6]))
    slip = np.geomspace(count * rng.uniform(5, 10), rng.uniform(30e-6, 80e-6), n) * rng.uniform(0.8, 1.25, n)
    F_s = F_c * rng.uniform(1.1, 1.5)
    scalars = F_c, F_s, rng.uniform(1e-3, 4e-3), rng.uniform(0.8, 1.5), rng.uniform(0.05, 0.3) * F_c, F_c * 100
    friction = np.concatenate([scalars, alpha, alpha * F_s / slip])
    A, B, T_d = rng.uniform(10, 40), K_f / mass, rng.uniform(0.5e-3, 0.9e-3)
    believed = Belief(A, B * rng.uniform(0.97, 1.03), K_f, T_d * rng.uniform(0.9, 1.1), friction, rng.uniform(0.9, 1.0))
    w = 2 * np.pi * rng.uniform(35, 55)
    K_p = w / B
    return PlainAxis(
        A, B, K_f, T_d, friction, believed, K_v=w / 3, K_p=K_p, K_i=K_p * w / 10,
        velocity_filter=rng.uniform(400, 700), observer=rng.uniform(35, 55) if rng.uniform() < 0.5 else 0.0,
        count=count,
    )  # fmt: skip
