"""The exported step in C: against the compiled step of the library, and how much its time varies from call to call."""

from __future__ import annotations

import ctypes
import shutil
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np

from benchmarks._exported import shared_library, write_step
from benchmarks.gms import MODEL, MOTIONS, STEPS

CALLS, ROUNDS = 1_000_000, 15
TIMED = """
#define _POSIX_C_SOURCE 199309L
#include <time.h>
#include "gms.c"

/* The shortest time of each call over some rounds of the same calls: what the computer does besides is taken out. */
void timed(int n, int rounds, const double *dz, const double *v, double dt, double *state, const double *parameters,
           int states, const double *rest, double *nanoseconds)
{
    for (int round = 0; round < rounds; round++) {
        for (int i = 0; i < states; i++)
            state[i] = rest[i];
        for (int i = 0; i < n; i++) {
            struct timespec a, b;
            clock_gettime(CLOCK_MONOTONIC, &a);
            step(dz[i], v[i], dt, state, parameters, 4);
            clock_gettime(CLOCK_MONOTONIC, &b);
            double took = 1e9 * (double)(b.tv_sec - a.tv_sec) + (double)(b.tv_nsec - a.tv_nsec);
            if (round == 0 || took < nanoseconds[i])
                nanoseconds[i] = took;
        }
    }
}
"""


def run() -> list[tuple[str, str, str]]:
    """Time the exported step of a four-block GMS."""
    if not shutil.which("cc"):
        return [("exported C / compiled step", "skipped: there is no cc", "at most 1.0")]
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_step(MODEL, folder / "gms.c")
        (folder / "timed.c").write_text(TIMED)
        array = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
        replay = ctypes.CDLL(str(shared_library(folder / "gms.c", folder=folder, level="-O3"))).replay
        replay.argtypes, replay.restype = [ctypes.c_long, *[array] * 5, ctypes.c_int, array], None
        for motion, (amplitude, omega) in MOTIONS.items():
            time = np.arange(STEPS) * 1e-4
            position, velocity = amplitude * np.sin(omega * time), amplitude * omega * np.cos(omega * time)
            force, parameters, best = np.empty(STEPS), MODEL.packed(), [np.inf, np.inf]
            for _ in range(60):
                start = perf_counter()
                replay(STEPS, position, velocity, time, MODEL.initial_state(), parameters, 4, force)
                middle = perf_counter()
                MODEL.replay(time, position, velocity)
                best = [min(best[0], middle - start), min(best[1], perf_counter() - middle)]
            told = f"{best[0] / best[1]:.2f} ({best[0] / STEPS * 1e9:.0f} / {best[1] / STEPS * 1e9:.0f} ns)"
            rows.append((f"exported C at -O3 of a four-block GMS, {motion} / the compiled step", told, "at most 1.0"))
        timed = ctypes.CDLL(str(shared_library(folder / "timed.c", folder=folder, level="-O3"))).timed
        timed.argtypes = (
            [ctypes.c_int] * 2 + [array] * 2 + [ctypes.c_double] + [array] * 2 + [ctypes.c_int] + [array] * 2
        )
        rng = np.random.default_rng(0)
        v = rng.choice([1e-4, 1e-3, 1e-2, 0.1, 0.5], CALLS) * rng.standard_normal(CALLS)
        nanoseconds, rest = np.empty(CALLS), MODEL.initial_state()
        timed(CALLS, ROUNDS, v / 4000, v, 1 / 4000, rest.copy(), MODEL.packed(), rest.size, rest, nanoseconds)
        median, worst = float(np.median(nanoseconds)), float(nanoseconds.max())
        told = f"{worst / median:.1f} ({worst:.0f} / {median:.0f} ns)"
        rows.append(
            (f"longest of {CALLS:,} random calls / their median, the clock's own time included", told, "at most 3")
        )
    return rows
