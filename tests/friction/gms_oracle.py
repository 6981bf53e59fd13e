"""The GMS equations solved a second time, in plain Python: stick and slip by `solve_ivp` with its events."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from math import exp

import numpy as np
from scipy.integrate import solve_ivp

from fric.friction.gms import GMS

Motion = Callable[[float], float]


def force(
    model: GMS, z: Motion, v: Motion, turns: list[float], time: np.ndarray, *, as_printed: bool = False
) -> np.ndarray:
    """Return the force of a relaxed contact along a motion that turns at the given times.

    Each block is on its own, since the motion is given. From turn to turn it sticks, ``F = F_0 + k·(z - z_0)``, until
    the event ``|F| = alpha·|s(v)|``, and then follows the differential equation of slip, with the load limited by
    the way, or as eq. (4) is printed.
    """
    m = model.static

    def s(v: float) -> float:
        return m.F_c + (m.F_s - m.F_c) * exp(-((abs(v) / m.v_s) ** m.delta))

    def speed(t: float) -> float:
        return float(v(t))

    total = np.array([m.sigma * v(t) for t in time])
    edges = [time[0], *turns, time[-1]]
    for alpha, k in zip(model.alpha, model.k, strict=True):
        F = 0.0
        for start, end in pairwise(edges):
            sign = float(np.sign(v(0.5 * (start + end))))
            inside = (time >= start) & (time <= end) if end == time[-1] else (time >= start) & (time < end)

            def reaches(t: float, F: np.ndarray, sign=sign, alpha=alpha) -> float:
                return sign * float(F[0]) - alpha * s(speed(t))

            def slip(t: float, F: np.ndarray, sign=sign, alpha=alpha, k=k) -> list[float]:
                now = speed(t)
                rate = model.C * (alpha - sign * float(F[0]) / s(now))
                return [sign * (rate if as_printed else min(rate, k * abs(now)))]

            reaches.terminal, reaches.direction = True, 1.0  # type: ignore[attr-defined]
            tight = {"rtol": 1e-10, "atol": 1e-10, "max_step": (end - start) / 200, "dense_output": True}
            stick = solve_ivp(
                lambda t, F, k=k: [k * speed(t)], (start, end), [F], events=reaches, method="DOP853", **tight
            )
            here = inside & (time <= stick.t[-1])
            total[here] += stick.sol(time[here])[0] if here.any() else 0.0
            F = stick.y[0, -1]
            if stick.status == 1 and stick.t[-1] < end:
                sliding = solve_ivp(slip, (stick.t[-1], end), [F], method="DOP853", **tight)
                here = inside & (time > stick.t[-1])
                total[here] += sliding.sol(time[here])[0] if here.any() else 0.0
                F = sliding.y[0, -1]
    return total
