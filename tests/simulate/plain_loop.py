"""The closed loop once more, slow and plain, written apart from the kernel: the oracle of its tests.

The controller is Python at its own rate; its observer is discretised by SciPy in state space. Between two changes of
the voltage the plant and every slip block of the GMS model are one ordinary differential equation, solved by
`solve_ivp` from event to event: the motion reverses, or a block breaks away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.signal import cont2discrete

from fric.drive.sensing import Encoder
from fric.friction.gms import GMS
from fric.reference import Reference
from fric.simulate.machine import Axis


@dataclass
class Body:
    """A mass on a guideway with GMS friction."""

    axis: Axis
    friction: GMS
    z: float
    v: float = 0.0
    F: np.ndarray = field(init=False)
    slips: np.ndarray = field(init=False)
    direction: float = 1.0

    def __post_init__(self) -> None:
        self.F = np.zeros(len(self.friction.k))
        self.slips = np.zeros(len(self.friction.k), bool)

    def level(self, v: float) -> float:
        m = self.friction.static
        return m.F_c + (m.F_s - m.F_c) * math.exp(-((abs(v) / m.v_s) ** m.delta))

    def rate(self, _: float, y: np.ndarray, u: float) -> np.ndarray:
        v, F = y[1], y[2:]
        alpha, k = np.array(self.friction.alpha), np.array(self.friction.k)
        load = self.direction * F
        slip = self.direction * np.minimum(self.friction.C * (alpha - load / self.level(v)), k * abs(v))
        total = F.sum() + self.friction.static.sigma * v + self.axis.load
        plant = self.axis.plant
        acceleration = plant.B * u - plant.A * v - total * plant.B / plant.K_f
        return np.concatenate([[v, acceleration], np.where(self.slips, slip, k * v)])

    def move(self, u: float, duration: float) -> None:
        """Advance by a time at a constant voltage."""
        t = 0.0
        while duration - t > 1e-13:
            events = []

            def turns(_: float, y: np.ndarray, u: float) -> float:
                return float(y[1])

            turns.terminal, turns.direction = True, -self.direction  # type: ignore[attr-defined]
            events.append(turns)
            stuck = np.flatnonzero(~self.slips)
            for i in stuck:

                def breaks(_: float, y: np.ndarray, u: float, i: int = int(i)) -> float:
                    return float(self.direction * y[2 + i] - self.friction.alpha[i] * self.level(y[1]))

                breaks.terminal, breaks.direction = True, 1.0  # type: ignore[attr-defined]
                events.append(breaks)
            start = np.concatenate([[self.z, self.v], self.F])
            run = solve_ivp(
                self.rate, (t, duration), start, args=(u,), events=events, method="DOP853", rtol=1e-9, atol=1e-13
            )
            t, end = float(run.t[-1]), run.y[:, -1]
            self.z, self.v, self.F = float(end[0]), float(end[1]), end[2:]
            if len(run.t_events[0]):
                acceleration = self.rate(t, end, u)[1]
                self.v, self.direction = 0.0, math.copysign(1.0, acceleration)
                self.slips[:] = False
                self.v = self.direction * 1e-15
            for i, found in zip(stuck, run.t_events[1:], strict=True):
                self.slips[i] |= bool(len(found))


class Filter:
    """A transfer function in s, advanced sample by sample in state space."""

    def __init__(self, numerator: list[float], denominator: list[float], T: float, method: str) -> None:
        self.A, self.B, self.C, self.D, _ = cont2discrete(
            _controllable(numerator, denominator), T, "bilinear" if method == "tustin" else method
        )
        self.x = np.zeros(len(self.A))

    def output(self, u: float = 0.0) -> float:
        return float((self.C @ self.x).item() + self.D.item() * u)

    def push(self, u: float) -> None:
        self.x = self.A @ self.x + self.B[:, 0] * u


def _controllable(numerator: list[float], denominator: list[float]) -> tuple[np.ndarray, ...]:
    a = np.array(denominator) / denominator[0]
    order = len(a) - 1
    b = np.concatenate([np.zeros(order + 1 - len(numerator)), np.array(numerator) / denominator[0]])
    A = np.vstack([-a[1:], np.eye(order)[:-1]])
    return A, np.eye(order)[:, :1], (b[1:] - b[0] * a[1:])[np.newaxis], np.array([[b[0]]])


def counted(encoder: Encoder, z: Any) -> Any:
    """Return a position, or several, by an encoder that rounds them to whole steps."""
    step = encoder.resolution
    return np.rint((z + encoder.shift) / step) * step - encoder.shift if step else z


def plain_loop(
    axis: Axis, reference: Reference, friction_voltage: np.ndarray, *, observer: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return position and voltage at the controller's samples."""
    plant, c, T = axis.plant, axis.cascade, 1.0 / axis.cascade.sampling
    assert isinstance(axis.friction, GMS)
    body = Body(axis, axis.friction, float(reference.position[0]))
    filtered, integral, seen = 0.0, 0.0, counted(axis.encoder, float(reference.position[0]))
    if observer:
        assert axis.observer is not None
        tau = 1.0 / (2 * math.pi * axis.observer.q.cutoff)
        lag = [tau**2, 2 * tau, 1.0]
        inverse, low_pass = (
            Filter([1 / plant.B, plant.A / plant.B, 0.0], lag, T, "tustin"),
            Filter([1.0], lag, T, "zoh"),
        )
    pole = math.exp(-2 * math.pi * c.velocity_filter * T)
    delay = plant.T_d - T / 2
    whole, share = int(delay // T), delay % T
    positions, voltages = [], []
    for n, r in enumerate(reference.position):
        z = counted(axis.encoder, body.z)
        filtered = pole * filtered + (1 - pole) * (z - seen) / T
        seen = z
        error = c.K_v * (r - z) + reference.velocity[n] - filtered
        integral += c.K_i * T * error
        u = c.K_p * error + integral + (reference.acceleration[n] + plant.A * reference.velocity[n]) / plant.B
        if observer:
            x = z - reference.position[0]
            u -= inverse.output(x) - low_pass.output()
            inverse.push(x)
            low_pass.push(u)
        u += friction_voltage[n]
        assert abs(u) < c.limit
        positions.append(body.z)
        voltages.append(u)
        for age, duration in ((whole + 1, share), (whole, T - share)):
            body.move(voltages[n - age] if n >= age else 0.0, duration)
    return np.array(positions), np.array(voltages)
