"""Replay of a four-block GMS, against the same step in C at -O2; and the first call in a new process."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np

from benchmarks._exported import shared_library, write_step
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap

STEPS = 50_000
MODEL = GMS(
    StaticMap(F_c=105.0, F_s=165.0, v_s=1e-3, delta=1.0, sigma=40.0),
    alpha=tuple(a / 1.002 for a in (0.566, 0.227, 0.170, 0.039)),
    k=(99.94e6, 1.364e6, 1.081e6, 0.119e6),
)
MOTIONS = {"15 um at 0.1 Hz": (15e-6, 0.2 * np.pi), "30 mm circle at 100 mm/s": (30e-3, 100 / 30)}

FIRST_CALL = """
from time import perf_counter
import numba, numpy as np
imported = perf_counter()
from benchmarks.gms import MODEL
loaded = perf_counter()
time = np.linspace(0.0, 1.0, 1001)
MODEL.replay(time, 1e-3 * np.sin(time))
print(perf_counter() - imported, perf_counter() - loaded)
"""


def _in_c(folder: str) -> Callable[..., None] | None:
    if shutil.which("cc") is None:
        return None
    source = Path(folder) / "gms.c"
    write_step(MODEL, source)
    library = shared_library(source, folder=Path(folder))
    array = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
    replay = ctypes.CDLL(str(library)).replay
    replay.argtypes = [ctypes.c_long, *[array] * 5, ctypes.c_int, array]
    replay.restype = None
    return replay


def _best(function: Callable[[], object], other: Callable[[], object], rounds: int = 100) -> tuple[float, float]:
    """Return the shortest time of each, run in turn, so that both see the same machine."""
    times = []
    for _ in range(rounds):
        start = perf_counter()
        function()
        middle = perf_counter()
        other()
        times.append((middle - start, perf_counter() - middle))
    best = np.min(times, axis=0)
    return float(best[0]), float(best[1])


def _replays(c_replay: Callable[..., None]) -> list[tuple[str, str, str]]:
    rows = []
    for name, (amplitude, omega) in MOTIONS.items():
        time = np.arange(STEPS) * 1e-4
        position, velocity = amplitude * np.sin(omega * time), amplitude * omega * np.cos(omega * time)
        in_c, parameters = np.empty(STEPS), MODEL.packed()

        def baseline(args=(position, velocity, time), parameters=parameters, force=in_c) -> None:
            c_replay(STEPS, *args, MODEL.initial_state(), parameters, len(MODEL.alpha), force)

        def ours(args=(time, position, velocity)) -> np.ndarray:
            return MODEL.replay(*args)

        baseline()
        np.testing.assert_allclose(ours(), in_c, rtol=0, atol=1e-9)
        seconds, in_c_seconds = _best(ours, baseline)
        measured = f"{seconds / in_c_seconds:.2f} ({seconds / STEPS * 1e9:.0f} / {in_c_seconds / STEPS * 1e9:.0f} ns)"
        rows.append((f"replay of a four-block GMS, {name} / the exported C at -O2", measured, "at most 1.2"))
    return rows


def _in_new_process(code: str) -> str:
    root = Path(__file__).parents[1]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(root), *sys.path])}
    return subprocess.run(
        [sys.executable, "-c", code], env=environment, check=True, capture_output=True, text=True
    ).stdout


def run() -> list[tuple[str, str, str]]:
    """Time the replay against C where there is a compiler, and the first call with a warm cache."""
    with tempfile.TemporaryDirectory() as folder:
        c_replay = _in_c(folder)
        rows = [("replay / C", "skipped: there is no cc", "at most 1.2")] if c_replay is None else _replays(c_replay)
    runs = [[float(seconds) for seconds in _in_new_process(FIRST_CALL).split()] for _ in range(8)]
    loading, call = np.min(runs, axis=0)
    rows.append(("first call in a new process, warm cache", f"{call:.3f} s", "under 0.5 s"))
    rows.append(
        ("  and with the start of the compiler and the loading of the cache", f"{loading:.2f} s", "under 0.5 s")
    )
    return rows
