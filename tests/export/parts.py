"""Parts to export, and the motions along which an exported step must agree with the library's."""

from __future__ import annotations

import ctypes
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from fric.control.scheme import Scheme
from fric.documents.machine_files import read_machine
from fric.documents.schemes import read_schemes
from fric.export.base import ExportedPart, Role, compensation_of
from fric.export.c import c_files
from fric.friction import FrictionModel, models
from fric.friction.directed import Directed
from fric.friction.stribeck import StaticMap
from fric.reference import circle
from fric.simulate.axis import run_axis

SAMPLING = 4000.0
SAMPLES = 60_000  # both reversals of the circle at 10 mm/s
MACHINE = Path(__file__).parents[2] / "configs/xy-table.yaml"
SCHEMES = read_schemes(MACHINE.parent / "literature.yaml")
EXPORTED = ("c", "d", "f", "kalman-gms", "two-dof")
"""Schemes with every block that can be exported, and with the friction alone."""
NOT_EXPORTED = {
    "pulse": "reads 'rows'", "adaptive": "reads 'n'", "repetitive": "needs a motion that repeats",
    "sliding": "in place of the controller", "scheduled": "in place of the controller",
}  # fmt: skip
"""Schemes with every other block, and the reason that is given."""
REFUSED = {"leuven": "depends on the data", "rolling": "controllers do not have"}
"""Friction models that no controller's program can hold, and the reason that is given. All others must be exported."""


def part(model: FrictionModel, role: Role = "compensation", lead: float = 0.65e-3) -> ExportedPart:
    return ExportedPart(
        role, "a machine", "x", "linear", "f", model, K_f=548.0, A=28.57, B=4.526, sampling=SAMPLING, limit=10.0,
        resolution=0.25e-6, gain=0.73, lead=lead, delay=0.525e-3,
    )  # fmt: skip


def scheme_part(scheme: str | Scheme = "f", axis: str = "x") -> ExportedPart:
    chosen = SCHEMES[scheme] if isinstance(scheme, str) else scheme
    return compensation_of(read_machine(MACHINE), axis, chosen)


DIRECTED = {"static by direction": "static", "gms by direction": "gms", "lugre by direction": "lugre"}
"""Models with a map of their own backwards."""


def exportable() -> list[str]:
    return [*(name for name in models() if name not in REFUSED), *DIRECTED]


def typical(name: str) -> FrictionModel:
    """A typical friction model by its name; by direction, with less and narrower friction backwards."""
    if name not in DIRECTED:
        return models()[name].typical()
    return Directed(typical(DIRECTED[name]), StaticMap(F_c=80.0, F_s=131.0, v_s=2e-3, delta=1.4, sigma=25.0))


@cache
def motions(samples: int = SAMPLES) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Increments [m] and velocities [m/s] of the paper's circle at both feeds, a sine with dwells, a random walk.

    The walk is in encoder steps, its velocity what a controller makes of them: a first difference behind 500 Hz; and
    once more the raw difference: it brings blocks back to just where they broke away.
    """
    t = np.arange(samples) / SAMPLING
    sine = 15e-6 * np.sin(2 * np.pi * np.minimum(t % 4.0, 3.0))
    smooth = {f"{feed} mm/s": 0.03 * np.sin(feed / 30 * t) for feed in (100, 10)} | {"sine with dwell": sine}
    made = {name: (np.diff(z, prepend=z[0]), np.gradient(z, 1 / SAMPLING)) for name, z in smooth.items()}
    steps = np.random.default_rng(0).integers(-3, 4, samples) * 0.25e-6
    pole, v, filtered = np.exp(-2 * np.pi * 500 / SAMPLING), 0.0, np.empty(samples)
    for n, step in enumerate(steps):
        v = pole * v + (1 - pole) * step * SAMPLING
        filtered[n] = v
    return made | {"random steps": (steps, filtered), "raw random steps": (steps, steps * SAMPLING)}


def replayed(model: FrictionModel, dz: np.ndarray, v: np.ndarray, *, begins: bool = False) -> np.ndarray:
    """Forces [N] of the library's step; the first sample takes no time where the motion begins with it."""
    state, parameters, step = model.initial_state(), model.packed(), type(model).step
    dt = np.full(len(dz), 1 / SAMPLING)
    dt[0] *= not begins
    rows = zip(dz.tolist(), v.tolist(), dt.tolist(), strict=True)
    return np.array([step(*row, state, parameters) for row in rows])


def along_a_run(scheme: str) -> tuple[list[dict[str, float]], np.ndarray]:
    """What a controller asks and sees along a simulated circle, and what the compensation adds to its voltage."""
    axis = read_machine(MACHINE).axis("x")
    reference = circle(0.03, 0.1, 1, axis.cascade.sampling)[0]
    run = run_axis(axis, reference, SCHEMES[scheme])
    model = (reference.acceleration + axis.plant.A * reference.velocity) / axis.plant.B
    added = model + run.feedforward - run.disturbance
    control = run.input - added  # nothing saturates
    assert not run.saturated
    before = np.append(0.0, run.input[:-1])
    rows = zip(
        reference.position, reference.velocity, reference.acceleration, run.measured, control, before, strict=True
    )
    names = ("position", "velocity", "acceleration", "measured", "control", "input")
    return [dict(zip(names, map(float, row), strict=True)) for row in rows], added


STRICT = [
    "-std=c99",
    "-O2",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-pedantic",
    "-Wconversion",
    "-Wshadow",
    "-Wdouble-promotion",
]

INPUTS = ("position", "velocity", "acceleration", "measured", "control", "input", "share")


class InC:
    """An exported part, compiled and called."""

    def __init__(self, one: ExportedPart, folder: Path, *, single: bool = False, compiler: str = "cc") -> None:
        files = c_files(one, single=single)
        for name, text in files.items():
            (folder / name).write_text(str(text))
        (self.name,) = (name[:-2] for name in files if name.endswith(".c"))
        real = "float" if single else "double"
        driver = f"""
#include "{self.name}.c"
void forces(int n, const double *dz, const double *v, double dt, double *force);
void forces(int n, const double *dz, const double *v, double dt, double *force) {{
    {self.name}_t self;
    {self.name}_reset(&self{", 0" if one.role == "machine" else ""});
    for (int i = 0; i < n; ++i)
        force[i] = (double){self.name}_friction(&self, ({real})dz[i], ({real})v[i], ({real})dt);
}}
int size(void);
int size(void) {{ return (int)sizeof({self.name}_t); }}
bool fault(const {self.name}_t *self);
bool fault(const {self.name}_t *self) {{ return self->fault; }}
"""
        if one.role == "machine":
            driver += f"""
void positions(int n, const double *volts, double dt, double *position);
void positions(int n, const double *volts, double dt, double *position) {{
    {self.name}_t self;
    {self.name}_reset(&self, 0);
    for (int i = 0; i < n; ++i) {{
        {self.name}_step(&self, ({real})volts[i], ({real})dt);
        position[i] = (double)self.position;
    }}
}}
"""
        (folder / "driver.c").write_text(driver)
        library = folder / f"{self.name}{single}.so"
        words = [compiler, *STRICT, "-shared", "-fPIC", str(folder / "driver.c"), "-o", str(library), "-lm"]
        subprocess.run(words, check=True)
        self.library = ctypes.CDLL(str(library))
        self.real: Any = ctypes.c_float if single else ctypes.c_double
        self.memory = ctypes.create_string_buffer(self.library.size())
        self.library.fault.restype = ctypes.c_bool

    def forces(self, dz: np.ndarray, v: np.ndarray) -> np.ndarray:
        array = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
        self.library.forces.argtypes = [ctypes.c_int, array, array, ctypes.c_double, array]
        force = np.empty(len(dz))
        self.library.forces(len(dz), np.ascontiguousarray(dz), np.ascontiguousarray(v), 1 / SAMPLING, force)
        return force

    def positions(self, volts: np.ndarray) -> np.ndarray:
        """Positions of a machine [m] from rest, each after a sample of the voltage [V]."""
        array = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
        self.library.positions.argtypes = [ctypes.c_int, array, ctypes.c_double, array]
        position = np.empty(len(volts))
        self.library.positions(len(volts), np.ascontiguousarray(volts), 1 / SAMPLING, position)
        return position

    def reset(self, *position: float) -> None:
        getattr(self.library, f"{self.name}_reset")(self.memory, *(self.real(one) for one in position))

    @property
    def fault(self) -> bool:
        return bool(self.library.fault(self.memory))

    def step(self, dt: float = 1 / SAMPLING, **inputs: float) -> float:
        """One sample of a compensation; inputs that are not given are 0, the share is 1."""
        step = getattr(self.library, f"{self.name}_step")
        step.restype = self.real
        fields = [(name, ctypes.c_double if name == "position" else self.real) for name in INPUTS]
        kind = type("Inputs", (ctypes.Structure,), {"_fields_": fields})
        given = kind(**({"share": 1.0} | inputs))
        return float(step(self.memory, ctypes.byref(given), self.real(dt)))
