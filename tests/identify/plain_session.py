"""Sessions of records of an axis under P-PI control, drawn and integrated without code of fric.

The axis is a mass with damping behind a delayed voltage, its friction one of four laws by semi-implicit Euler steps of
a sixteenth of a sample: GMS (eqs. 3 and 4), LuGre, a spectrum of elements that yield one by one (Iwan), and LuGre with
cogging. A session is a response while it slides, strokes at constant speed, two slow sines and a sine in sliding.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numba
import numpy as np
from numpy.typing import NDArray

from fric.log import Log

Array = NDArray[np.float64]
STEPS = 16
LAWS = "gms", "lugre", "iwan", "cogging"


@dataclass(frozen=True)
class Axis:
    """An axis, its friction and its controller [SI]."""

    A: float
    B: float
    K_f: float
    T_d: float
    law: str
    F_c: float
    F_s: float
    v_s: float
    sigma: float
    C: float
    alpha: Array
    slip: Array  # of each block [m]
    offset: float
    cogging: float
    pitch: float
    K_v: float
    K_p: float
    K_i: float
    corner: float  # of the velocity filter [Hz]
    rate: float
    count: float
    jitter: float  # noise of the position [m]
    force_step: float
    force_noise: float

    @property
    def steady(self) -> bool:
        """Whether the loop damps the spring of the contact, outdoes the fall of friction, and hardly shows counts."""
        mass, w = self.K_f / self.B, float(np.sqrt(np.sum(self.alpha / self.slip) * self.F_s * self.B / self.K_f))
        lag = w * self.T_d + np.arctan(w / (2 * np.pi * self.corner))
        ripple = 0.4 * self.count * self.rate * -np.expm1(-2 * np.pi * self.corner / self.rate) * self.K_p * self.K_f
        return bool(
            ripple < 0.2 * self.F_c and lag < 1.1 and (self.F_s - self.F_c) / self.v_s < 0.5 * self.K_p * self.B * mass
        )

    @property
    def truth(self) -> dict[str, float]:
        """What is identified: the response shows all that is viscous, and the map what of it is not the drive's."""
        h = 1.0 / self.rate / STEPS  # a step of the plant, by half of which the position is early
        late = round((self.T_d - 0.5 / self.rate) / h) * h + 0.5 / self.rate - 0.5 * h
        decays = -np.log1p(-self.A * h) / h + self.sigma * self.B / self.K_f  # of the axis as it is integrated
        told = {"A": decays, "T_d": late, "K_f": self.K_f}
        told |= {"F_c": self.F_c, "F_s": self.F_s, "v_s": self.v_s, "offset": self.offset}
        return told | ({"C": self.C} if self.law == "gms" else {})


def drawn(rng: np.random.Generator, law: str = "gms") -> Axis:
    """Return an axis that does not hunt, and whose first block slips over eight counts or more."""
    while not (axis := _drawn(rng, law)).steady:
        pass
    return axis


def _drawn(rng: np.random.Generator, law: str) -> Axis:
    mass, K_f = 20.0 * 15.0 ** rng.uniform(), rng.uniform(60, 700)
    F_c = rng.uniform(0.08, 0.25) * K_f
    F_s = F_c * rng.uniform(1.15, 1.6)
    count = float(rng.choice([0.02e-6, 0.05e-6, 0.1e-6]))
    n = {"gms": int(rng.integers(2, 5)), "iwan": 24}.get(law, 1)
    alpha = np.sort(rng.dirichlet(np.full(n, 4.0)))[::-1]
    if law == "iwan":
        alpha = np.full(n, 1.0 / n)
    last = rng.uniform(15e-6, 60e-6)
    slip = np.geomspace(max(count * rng.uniform(8, 20), last / 60), last, n) if n > 1 else np.array([last / 4])
    if law == "iwan":
        slip = np.linspace(0.02, 1.0, n) * last
    B, rate = K_f / mass, float(rng.choice([2000.0, 4000.0]))
    w = 2 * np.pi * rng.uniform(18, 40)
    K_p = w / B
    return Axis(
        rng.uniform(3, 30), B, K_f, rng.uniform(0.6, 2.0) / rate + rng.uniform(0, 0.5e-3), law, F_c, F_s,
        10 ** rng.uniform(-3.3, -2.3), rng.uniform(0.1, 2.0) * F_c, F_c * 10 ** rng.uniform(1.5, 2.5), alpha, slip,
        rng.normal(0, 0.03) * F_c, 0.02 * F_c if law == "cogging" else 0.0, 20e-3, w / rng.uniform(3, 5), K_p,
        K_p * w / rng.uniform(5, 12), rng.uniform(400, 900), rate, count, count * rng.uniform(0.05, 0.4),
        float(rng.choice([0.0, 2e-4, 1e-3])) * K_f, F_c * 10 ** rng.uniform(-3.0, -1.7),
    )  # fmt: skip


@numba.njit(cache=True)
def _run(plant, friction, gains, r, v_r, added, jitter, drift):
    A, B, K_f, delay, offset, cogging, pitch = plant
    law, F_c, F_s, v_s, sigma, C = friction[:6]
    n = (len(friction) - 6) // 2
    alpha, k = friction[6 : 6 + n], friction[6 + n :]
    K_v, K_p, K_i, pole, count, T = gains
    F, slips = np.zeros(n), np.zeros(n, np.bool_)
    seen, volts = np.zeros(len(r)), np.zeros(len(r))
    h = T / STEPS
    late = round(delay / h)
    z, v, last, filtered, integral = r[0], 0.0, 0.0, 0.0, 0.0
    for j in range(len(r)):
        seen[j] = np.floor((z + jitter[j]) / count + 0.5) * count
        filtered = pole * filtered + (1 - pole) * (seen[j] - seen[max(j - 1, 0)]) / T
        error = K_v * (r[j] - seen[j]) + v_r[j] - filtered
        integral += K_i * T * error
        volts[j] = K_p * error + integral + added[j]
        for m in range(STEPS):
            back = j * STEPS + m - late
            acts = volts[back // STEPS] if back >= 0 else 0.0
            level = (F_c + (F_s - F_c) * np.exp(-abs(v) / v_s)) * drift[j]
            total, way = 0.0, 1.0 if v >= 0.0 else -1.0
            if law == 1.0:  # LuGre: an implicit step of the bristle
                F[0] = (F[0] + k[0] * v * h) / (1.0 + k[0] * abs(v) * h / level)
                total = F[0]
            else:
                if v * last < 0.0:
                    slips[:] = False
                for i in range(n):
                    if law == 2.0:
                        most = alpha[i] * level
                        F[i] = min(max(F[i] + k[i] * v * h, -most), most)
                    elif slips[i]:
                        F[i] += way * min(C * (alpha[i] - way * F[i] / level), k[i] * abs(v)) * h
                    else:
                        F[i] += k[i] * v * h
                        if way * F[i] >= alpha[i] * level:
                            F[i], slips[i] = way * alpha[i] * level, True
                    total += F[i]
            last = v if v != 0.0 else last
            total += sigma * v + offset + cogging * np.sin(2 * np.pi * z / pitch)
            v += h * (B * acts - A * v - total * B / K_f)
            z += h * v
    return seen, volts


def run(
    axis: Axis, rng: np.random.Generator, r: Array, v: Array, name: str, kind: str, *,
    added: Array | None = None, skip: int = 0, every: int = 1, drift: Array | None = None,
) -> Log:  # fmt: skip
    """Return the log of a motion, from a sample on, at a fraction of the controller's rate."""
    n, T = len(r), 1.0 / axis.rate
    k = axis.alpha * axis.F_s / axis.slip
    friction = np.array([
        float({"gms": 0, "iwan": 2}.get(axis.law, 1)), axis.F_c, axis.F_s, axis.v_s, axis.sigma, axis.C, *axis.alpha, *k
    ])  # fmt: skip
    plant = axis.A, axis.B, axis.K_f, axis.T_d - T / 2, axis.offset, axis.cogging, axis.pitch
    pole = np.exp(-2 * np.pi * axis.corner * T)
    gains = axis.K_v, axis.K_p, axis.K_i, pole, axis.count, T
    extra = np.zeros(n) if added is None else added
    jitter, changes = axis.jitter * rng.standard_normal(n), np.ones(n) if drift is None else drift
    seen, volts = _run(plant, friction, gains, r, v, extra, jitter, changes)
    force = axis.K_f * volts + axis.force_noise * rng.standard_normal(n)
    if axis.force_step:
        force = np.rint(force / axis.force_step) * axis.force_step
    some = slice(skip, None, every)
    return Log(np.arange(n)[some] * T, seen[some], force=force[some], input=volts[some], name=name, kind=kind)


def stroke(speed: float, lasting: float, rate: float, ramp: float = 0.1) -> tuple[Array, Array]:
    """Return a stroke forth, a rest and the stroke back: position and velocity."""
    up, at, rest = (np.linspace(0, 1, round(ramp * rate)), np.ones(round(lasting * rate)), np.zeros(round(0.1 * rate)))
    half = speed * np.concatenate([rest, up, at, up[::-1], rest])
    v = np.concatenate([half, -half])
    return np.cumsum(v) / rate, v


def strokes(axis: Axis, rng: np.random.Generator, drift: float = 0.0) -> list[Log]:
    """Return a record a speed, most of 4096 samples."""
    reach, logs, clock = 6.0 * float(axis.slip[-1]), [], 0.0
    speeds = np.geomspace(0.1 * axis.v_s, min(20 * axis.v_s, 0.06), int(rng.integers(9, 15)))
    for n, speed in enumerate(rng.permutation(speeds), 1):
        r, v = stroke(speed, max(1.6, reach / speed + 0.4), axis.rate)
        every = max(1, len(r) // 4096)
        changes = 1.0 + drift * (clock + np.arange(len(r)) / axis.rate)
        log = run(axis, rng, r, v, f"stroke-{n:02d}", "constant-velocity", every=every, drift=changes)
        logs.append(replace(log, time=log.time + clock))
        clock += len(r) / axis.rate + 1.0
    return logs


def sines(axis: Axis, rng: np.random.Generator) -> list[Log]:
    """Return cycles that slip in part, and cycles that slide."""
    logs = []
    for n, (share, frequency) in enumerate(((0.4, 0.2), (8.0, 0.1)), 1):
        t = np.arange(0.0, 6.0 / frequency, 1.0 / axis.rate)
        w, a = 2 * np.pi * frequency, share * float(axis.slip[-1])
        ramp = np.minimum(t * frequency, 1.0)
        r, v = a * ramp * np.sin(w * t), a * ramp * w * np.cos(w * t)
        skip = round(axis.rate / frequency)
        every = max(1, (len(r) - skip) // 4096)
        logs.append(run(axis, rng, r, v, f"sine-{n}", "presliding-sine", skip=skip, every=every))
    return logs


def sliding(axis: Axis, rng: np.random.Generator) -> Log:
    """Return a sine of the speed about a mean."""
    frequency, mean = 4.0, 2.0 * axis.v_s
    t = np.arange(0.0, 16.0 / frequency, 1.0 / axis.rate)
    w = 2 * np.pi * frequency
    r, v = mean * (t - 0.6 * np.sin(w * t) / w), mean * (1 - 0.6 * np.cos(w * t))
    log = run(axis, rng, r, v, "sliding", "sliding-sine", skip=round(2 * axis.rate / frequency), every=2)
    return replace(log, time=log.time - log.time[0])


def response(axis: Axis, rng: np.random.Generator) -> Log:
    """Return eight periods of a multisine on the voltage while the axis slides at 40 mm/s."""
    period = round(axis.rate / 2)
    lines = np.unique(np.rint(np.geomspace(1, 0.1 * axis.rate / 2, 40)))
    w, phase = 2 * np.pi * 2 * lines, rng.uniform(0, 2 * np.pi, len(lines))
    t = np.arange(9 * period) / axis.rate
    lead = round(0.4 * axis.rate)
    u = np.array(
        [np.abs(1j * f * (1j * f + axis.A)) / f / axis.B * np.cos(f * t + p) for f, p in zip(w, phase, strict=True)]
    )
    speed = np.abs(sum(np.cos(f * t[:period] + p) for f, p in zip(w, phase, strict=True))).max()
    added = np.concatenate([np.zeros(lead), 0.015 / speed * u.sum(axis=0)])
    v = 0.04 * np.minimum(np.arange(len(added)) / (0.2 * axis.rate), 1.0)
    log = run(axis, rng, np.cumsum(v) / axis.rate, v, "response", "frequency-response", added=added, skip=lead + period)
    return replace(log, time=log.time - log.time[0])


def session(axis: Axis, rng: np.random.Generator) -> Mapping[str, list[Log]]:
    """Return the records of an axis by what they identify."""
    return {
        "plant": [response(axis, rng)],
        "static": strokes(axis, rng),
        "gms": [*sines(axis, rng), sliding(axis, rng)],
    }
