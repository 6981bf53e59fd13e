"""The closed loop against C at -O2, the whole table of six schemes as a command, and python-control's LSODA."""

from __future__ import annotations

import ctypes
import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

from benchmarks._exported import shared_library, write_step
from fric.control.scheme import NONE, PAPER_SCHEMES, Scheme
from fric.documents.machine_files import read_machine
from fric.documents.schemes import read_schemes
from fric.drive.sensing import low_pass_pole
from fric.kernels.loop import closed_loop, parts_of_a_sample
from fric.kernels.plant import LASTING, TOLERANCE, WEIGHTS, effective_times
from fric.kernels.signatures import compiled_step
from fric.reference import circle
from fric.simulate.axis import _loop_arguments, run_axis

MACHINE = Path(__file__).parents[1] / "configs/xy-table.yaml"
AXIS = read_machine(MACHINE).axis("x")
GMS_STEP = type(AXIS.friction).step
REFERENCE = circle(0.03, 0.1, 2, AXIS.cascade.sampling)[0]


def _best(
    functions: list[Callable[[], object]], rounds: int = 25, clock: Callable[[], float] = perf_counter
) -> list[float]:
    """Return the shortest time of each, run in turn."""
    times = []
    for _ in range(rounds):
        row = []
        for function in functions:
            start = clock()
            function()
            row.append(clock() - start)
        times.append(row)
    return [float(seconds) for seconds in np.min(times, axis=0)]


def _loops(folder: str, scheme: str) -> tuple[Callable[[], np.ndarray], Callable[[], np.ndarray]]:
    """Return the same run here and in C; each gives the position."""
    write_step(AXIS.friction, Path(folder) / "gms.c")
    library = shared_library(Path(__file__).with_suffix(".c"), folder=Path(folder))
    run = ctypes.CDLL(str(library)).closed_loop
    array = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
    run.argtypes = [
        array, array, ctypes.c_int, array, array, ctypes.c_long, *[array] * 4, ctypes.c_long, *[array] * 4,
        ctypes.c_long, *[array] * 3, ctypes.c_double, ctypes.c_long, *[array] * 6,
    ]  # fmt: skip
    step, state, parameters, plant, board, blocks, command = _loop_arguments(AXIS, REFERENCE, PAPER_SCHEMES[scheme])
    cascade = AXIS.cascade
    pole = low_pass_pole(cascade.velocity_filter, cascade.sampling)
    control_c = np.array([cascade.K_v, cascade.K_p, cascade.K_i, pole, *board])
    filters, order = [np.zeros(1)] * 4, 0
    if len(blocks) > 1:
        both = AXIS.observer.discrete(cascade.sampling)
        filters, order = [both.inverse.b, both.inverse.a, both.low_pass.b, both.low_pass.a], both.inverse.b.size - 1
    plant_c, n = np.array(plant[:5]), len(REFERENCE)
    asked = [command.position, command.velocity, command.model, command.friction]
    late, lengths = parts_of_a_sample(plant, board.T_s)
    effective = np.concatenate([effective_times(plant, length) for length in lengths])

    def here() -> np.ndarray:
        return closed_loop(step, state.copy(), parameters, plant, board, blocks, command)[0].position

    def in_c() -> np.ndarray:
        traces = [np.empty(n) for _ in range(6)]
        run(
            state.copy(), parameters, len(AXIS.friction.alpha), plant_c, control_c, order, *filters, n, *asked,
            late, np.array(lengths), effective, WEIGHTS, TOLERANCE, LASTING, *traces,
        )  # fmt: skip
        return traces[0]

    assert np.abs(in_c() - here()).max() < 1e-6 * AXIS.encoder.resolution
    return here, in_c


@compiled_step
def _counted(dz: float, v: float, dt: float, state: np.ndarray, parameters: np.ndarray) -> float:
    parameters[-1] += 1.0
    force: float = GMS_STEP(dz, v, dt, state, parameters[:-1])
    return force


def _of_scheme(scheme: Scheme) -> tuple[Callable[[], object], float]:
    """Return a run of one scheme, its blocks designed before, and how many steps of the plant it takes."""
    step, state, parameters, *others = _loop_arguments(AXIS, REFERENCE, scheme)
    assert step is GMS_STEP
    counted = np.append(parameters, 0.0)
    closed_loop(_counted, state.copy(), counted, *others)
    return lambda: closed_loop(step, state.copy(), parameters, *others), float(counted[-1])


def _lsoda() -> tuple[Callable[[], object], float]:
    """Return a simpler loop of one axis in python-control, and its simulated time [s].

    Continuous P and PI, no delay, no encoder, no observer, friction without memory and smoothed at zero speed.
    """
    import control

    plant, cascade, static = AXIS.plant, AXIS.cascade, AXIS.friction.static

    def rate(t: float, x: np.ndarray, r: np.ndarray, params: dict[str, float]) -> list[float]:
        z, v, integral = x
        error = cascade.K_v * (r[0] - z) + r[1] - v
        u = cascade.K_p * error + cascade.K_i * integral + (r[2] + plant.A * r[1]) / plant.B
        level = static.F_c + (static.F_s - static.F_c) * np.exp(-abs(v / static.v_s))
        friction = level * np.tanh(v / 1e-4) + static.sigma * v
        return [v, plant.B * u - plant.A * v - friction / plant.M, error]

    system = control.nlsys(rate, lambda t, x, r, params: x[:1], inputs=3, outputs=1, states=3)
    motion = np.array([REFERENCE.position, REFERENCE.velocity, REFERENCE.acceleration])
    start = [REFERENCE.position[0], 0.0, 0.0]

    def simulate() -> object:
        return control.input_output_response(system, REFERENCE.time, motion, start, solve_ivp_method="LSODA")

    return simulate, float(REFERENCE.time[-1])


def run() -> list[tuple[str, str, str]]:
    """Time the loop per plant step, the command, and the other simulator per simulated second."""
    rows = []
    if shutil.which("cc"):
        with tempfile.TemporaryDirectory() as folder:
            for scheme in ("a", "f"):
                seconds, in_c = _best([*_loops(folder, scheme)])
                ours, theirs = (1e9 * one / len(REFERENCE) for one in (seconds, in_c))
                told = f"{ours / theirs:.2f} ({ours:.0f} / {theirs:.0f} ns a controller sample)"
                rows.append((f"closed loop, scheme {scheme} / the same loop in C at -O2", told, "at most 1.0"))
    else:
        rows.append(("closed loop / C", "skipped: there is no cc", "at most 1.0"))

    schemes = read_schemes(MACHINE.with_name("literature.yaml"))
    loops, steps = zip(*map(_of_scheme, schemes.values()), strict=True)
    a_step = dict(zip(schemes, np.divide(_best(list(loops), clock=process_time), steps), strict=True))
    ratios = {name: float(seconds / a_step["f"]) for name, seconds in a_step.items()}
    slowest = max(ratios, key=lambda name: ratios[name])
    told = f"{ratios[slowest]:.2f} ({slowest})"
    rows.append((f"a step of the plant, the slowest of {len(schemes)} schemes / (f)", told, "at most 1.15"))

    words = [sys.executable, "-m", "fric", "simulate", "circle", str(MACHINE), "--json"]

    def table() -> None:
        done = subprocess.run(words, check=True, capture_output=True, text=True)
        assert len(json.loads(done.stdout)["schemes"]) == 6

    table()
    (seconds,) = _best([table], rounds=5)
    rows.append(
        ("table of six schemes on two axes at 100 mm/s, process start included", f"{seconds:.2f} s", "under 1 s")
    )

    simulate, duration = _lsoda()
    ours = lambda: run_axis(AXIS, REFERENCE, NONE)  # noqa: E731
    mine, theirs = _best([ours, simulate], rounds=8)
    told = f"{theirs / mine:.0f} × ({theirs / duration * 1e3:.0f} / {mine / duration * 1e3:.1f} ms)"
    rows.append(("python-control, LSODA, a simpler loop / this loop, per simulated second", told, "at least 20 ×"))
    return rows
