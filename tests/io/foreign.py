"""Logs as others write them: a table of axes with names in five languages or none, units or none, in any order."""

from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import h5py
import numpy as np
from scipy.io import savemat
from scipy.signal import lfilter

NAMES = {
    "en": {"time": "Time", "position": "Actual position", "velocity": "Actual velocity", "reference": "Position demand",
           "force": "Motor torque", "current": "Motor current", "command": "Velocity command", "bus": "DC bus voltage",
           "error": "Following error", "acceleration": "Acceleration command", "temperature": "Motor temp"},
    "de": {"time": "Zeit", "position": "Lageistwert", "velocity": "Istdrehzahl", "reference": "Lagesollwert",
           "force": "Drehmoment", "current": "Strom", "command": "Sollgeschwindigkeit", "bus": "Zwischenkreisspannung",
           "error": "Schleppabstand", "acceleration": "Sollbeschleunigung", "temperature": "Temperatur"},
    "it": {"time": "tempo", "position": "posizione", "velocity": "velocità", "reference": "riferimento posizione",
           "force": "coppia motore", "current": "corrente", "command": "riferimento velocità", "bus": "tensione bus",
           "error": "errore", "acceleration": "accelerazione", "temperature": "temperatura"},
    "fr": {"time": "temps", "position": "position mesurée", "velocity": "vitesse mesurée",
           "reference": "consigne position", "force": "couple moteur", "current": "courant",
           "command": "consigne vitesse", "bus": "tension bus",
           "error": "écart", "acceleration": "consigne accélération", "temperature": "température"},
    "es": {"time": "tiempo", "position": "posición", "velocity": "velocidad", "reference": "consigna posición",
           "force": "par motor", "current": "corriente", "command": "consigna velocidad", "bus": "tensión bus",
           "error": "error", "acceleration": "aceleración", "temperature": "temperatura"},
}  # fmt: skip
UNITS = {
    "linear": [("mm", 1e-3, "mm/s", 1e-3), ("m", 1.0, "m/s", 1.0), ("mm", 1e-3, "mm/min", 1e-3 / 60),
               ("um", 1e-6, "mm/s", 1e-3), ("mm", 1e-3, "m/min", 1.0 / 60)],
    "rotary": [("rad", 1.0, "rad/s", 1.0), ("deg", np.pi / 180, "deg/s", np.pi / 180),
               ("deg", np.pi / 180, "rpm", np.pi / 30), ("rev", 2 * np.pi, "rpm", np.pi / 30),
               ("rad", 1.0, "rpm", np.pi / 30)],
}  # fmt: skip
DRIVE = {"A": 1.0, "%": 12.0, "mA": 1e3}
"""Units of a current, and how much of one an ampere is."""


@dataclass
class Truth:
    """What the columns of a foreign log are: by axis and channel the column, and by column its unit."""

    axes: list[dict[str, int]]
    units: dict[int, str]
    motions: list[str]
    stated: bool
    period: float = 0.0  # Of a log without time
    unsure: set[int] = field(default_factory=set)


@dataclass
class Foreign:
    """A foreign log: names of its columns, values, and the truth."""

    names: list[str]
    units: list[str]
    values: np.ndarray
    truth: Truth
    named: bool
    stated: bool


def motion(rng: np.random.Generator, t: np.ndarray, rotary: bool) -> tuple[np.ndarray, ...]:
    """Return position, velocity and acceleration that are asked for: moves there and back, a sine, or random moves."""
    span, n, dt = t[-1], len(t), t[1] - t[0]
    travel = rng.uniform(3.0, 30.0) if rotary else rng.uniform(0.02, 0.4)
    kind = rng.choice(["strokes", "sine", "moves"], p=[0.5, 0.2, 0.3])
    if kind == "sine":
        w = 2 * np.pi * rng.integers(2, 6) / span
        v = travel * w * np.cos(w * t) * (1 + 0.3 * np.sin(0.37 * w * t))
    else:
        legs = int(rng.integers(4, 10))
        edges = np.linspace(0, n, legs + 1).astype(int)
        v = np.zeros(n)
        for k, (a, b) in enumerate(pairwise(edges)):
            speed = travel / (span / legs) * rng.uniform(0.3, 1.0) * (-1) ** k if kind == "strokes" else (
                travel / (span / legs) * rng.uniform(-1.0, 1.0))  # fmt: skip
            v[a + (b - a) // 12 : b - (b - a) // 12] = speed
        ramp = max(int(n / legs / rng.uniform(5, 14)), 3)
        window = np.hanning(ramp + 2)
        v = np.convolve(v, window / window.sum(), "same")
    p = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * dt)])
    return p, v, np.gradient(v, dt)


def foreign(seed: int) -> Foreign:
    """Return the foreign log of a seed."""
    rng = np.random.default_rng(seed)
    axes = int(rng.choice([1, 1, 1, 1, 2, 3, 6]))
    dt = float(rng.choice([1e-4, 2.5e-4, 5e-4, 1e-3, 1e-3, 2e-3, 4e-3, 1e-2]))
    n = int(rng.integers(3000, 7000))
    t = np.arange(n) * dt
    language = rng.choice([*NAMES, "none"], p=[0.16] * 5 + [0.2])
    stated = bool(rng.random() < 0.5)
    clock = rng.choice(["s", "ms", "us", "none"], p=[0.5, 0.3, 0.1, 0.1])
    columns: list[tuple[str, str, np.ndarray, str, int]] = []  # channel, unit, values, name, axis
    if clock != "none":
        scale = {"s": 1.0, "ms": 1e3, "us": 1e6}[clock]
        columns.append(("time", clock, np.round(t * scale, 9) + rng.choice([0.0, 5.0 * dt * scale]), "time", 0))
    motions = []
    with_position, with_velocity = rng.random() < 0.95, rng.random() < 0.75
    with_velocity = with_velocity or not with_position
    with_reference, with_command = rng.random() < 0.6, rng.random() < 0.3
    current = rng.random() < 0.6
    force_unit = str(rng.choice(list(DRIVE))) if current else "N"
    extras = [name for name in ("bus", "error", "acceleration", "temperature") if rng.random() < 0.35]
    for axis in range(1, axes + 1):
        rotary = bool(rng.random() < 0.5)
        motions.append("rotary" if rotary else "linear")
        p_unit, p_si, v_unit, v_si = UNITS[motions[-1]][rng.integers(5)]
        asked, speed, accel = motion(rng, t, rotary)
        lag = max(rng.uniform(1.0, 20.0) * dt, 2e-3)
        b = 1 - np.exp(-dt / lag)
        actual = lfilter([b], [1, b - 1], asked)
        v = np.gradient(actual, dt)
        a = np.gradient(lfilter([0.3], [1, -0.7], v), dt)
        step = np.ptp(actual) / 2.0 ** rng.integers(13, 20)
        position = np.round(actual / step) * step
        top = np.abs(v).max()
        velocity = v + rng.normal(0, 0.004 * top, n)
        coulomb = rng.uniform(0.5, 3.0)
        inertia = coulomb * rng.uniform(0.1, 2.0) / (np.abs(a).max() + 1e-12)
        force = coulomb * np.tanh(v / (0.01 * top)) + inertia * a + rng.uniform(0.1, 1.0) * coulomb * v / top
        force = force + rng.normal(0, 0.05 * coulomb, n) + rng.uniform(-0.3, 0.3) * coulomb
        force = force + 0.2 * coulomb * np.sin(2 * np.pi * actual / (np.ptp(actual) / 7.3))
        unit = force_unit if current else ("N*m" if rotary else "N")
        gain = DRIVE.get(unit, rng.uniform(1.0, 50.0)) * rng.choice([1.0, 1.0, -1.0])
        if with_position:
            columns.append(("position", p_unit, position / p_si, "position", axis))
        if with_velocity:
            columns.append(("velocity", v_unit, velocity / v_si, "velocity", axis))
        columns.append(("force", unit, force * gain, "current" if current else "force", axis))
        if with_reference and with_position:
            columns.append(("reference", p_unit, asked / p_si, "reference", axis))
        if with_command:
            columns.append(("", v_unit, speed / v_si, "command", axis))
        if "error" in extras and with_position:
            columns.append(("", p_unit, (asked - position) / p_si, "error", axis))
        if "acceleration" in extras:
            columns.append(("", f"{p_unit}/s^2", accel / p_si, "acceleration", axis))
    if "bus" in extras:
        columns.append(("", "V", 560 + rng.normal(0, 1.5, n), "bus", 0))
    if "temperature" in extras:
        columns.append(("", "degC", 40 + np.arange(n) * 1e-3 // 0.1 * 0.1, "temperature", 0))
    rest = columns[1:] if clock != "none" else columns
    order = rng.permutation(len(rest))
    columns = [*columns[: len(columns) - len(rest)], *(rest[k] for k in order)]
    digits = int(rng.integers(5, 9))
    values = np.array([[float(f"{one:.{digits}g}") for one in column[2]] if column[0] != "time" else column[2]
                       for column in columns]).T  # fmt: skip
    letters = "xyzabc"
    tags = [f" {letters[k]}" for k in range(6)] if rng.random() < 0.5 else [f" {k + 1}" for k in range(6)]
    names = []
    for _, _, _, name, axis in columns:
        tag = tags[axis - 1] if axes > 1 and axis else ""
        names.append("" if language == "none" else NAMES[language][name] + tag)
    truth = Truth(
        [{c[0]: k for k, c in enumerate(columns) if c[0] and c[4] == axis} for axis in range(1, axes + 1)],
        {k: c[1] for k, c in enumerate(columns)}, motions, stated, 0.0 if clock != "none" else dt,
    )  # fmt: skip
    return Foreign(names, [c[1] for c in columns], values, truth, language != "none", stated and language != "none")


def write(log: Foreign, folder: Path, seed: int) -> Path:
    """Write a foreign log as text of some delimiter, or as .mat of some nesting; the columns keep their order."""
    rng = np.random.default_rng(seed + 10_000)
    form = rng.choice(["text", "mat", "mat73"], p=[0.7, 0.2, 0.1])
    heads = [f"{name} [{unit}]" if log.stated else name for name, unit in zip(log.names, log.units, strict=True)]
    if form == "text" or not log.named:
        delimiter, decimal = [(",", "."), (";", ","), ("\t", "."), (";", ".")][rng.integers(4)]
        rows = [] if not log.named else [delimiter.join(heads)]
        rows += [delimiter.join(f"{one:.10g}" for one in row).replace(".", decimal) for row in log.values]
        path = folder / f"{seed}.{rng.choice(['csv', 'txt', 'dat'])}"
        path.write_text("\n".join(rows) + "\n", encoding=str(rng.choice(["utf-8", "latin-1"])))
        return path
    path = folder / f"{seed}.mat"
    columns = {"".join(c if c.isascii() and c.isalnum() else "_" for c in name): log.values[:, k]
               for k, name in enumerate(log.names)}  # fmt: skip
    if form == "mat":
        nest = [columns, {"data": columns}, {"run": {"signals": columns}}][rng.integers(3)]
        savemat(path, nest, long_field_names=True)
        return path
    with h5py.File(path, "w", userblock_size=512) as file:
        group = file.create_group("log") if rng.random() < 0.5 else file
        for name, values in columns.items():
            group.create_dataset(name, data=values[None, :])
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM")
    return path
