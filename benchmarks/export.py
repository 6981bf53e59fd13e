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

CALLS, ROUNDS = 1_000_000, 32
TIMED = """
#define _POSIX_C_SOURCE 199309L
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "gms.c"

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static int compared(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The time of each call, made some rounds long from the state that it met, less that of the clock itself: the mean of
   its faster half, as a clock may count in 10 ns. What the computer does besides is taken out, what the call's data
   make of its way through the code is left. */
void timed(int n, int rounds, const double *dz, const double *v, double dt, double *state, const double *parameters,
           int states, double *nanoseconds)
{
    double clock = 1e9, found[64], taken[64];
    volatile double kept = 0.0;
    for (int i = 0; i < 10000; i++) {
        double start = now(), took = now() - start;
        clock = took < clock ? took : clock;
    }
    for (int i = 0; i < n; i++) {
        for (int round = 0; round < rounds; round++) {
            memcpy(found, state, sizeof(double) * (size_t)states);
            double start = now();
            kept = step(dz[i], v[i], dt, found, parameters, 4);
            taken[round] = now() - start - clock;
        }
        qsort(taken, (size_t)rounds, sizeof(double), compared);
        nanoseconds[i] = 0.0;
        for (int round = 0; round < rounds / 2; round++)
            nanoseconds[i] += taken[round] / (rounds / 2);
        memcpy(state, found, sizeof(double) * (size_t)states);
    }
    (void)kept;
}
"""


def _calls() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Increments and velocities of random calls: speeds over five decades, counts of an encoder with their raw first
    differences, and increments that have nothing to do with the velocity, as no motion has."""
    rng = np.random.default_rng(0)
    v, other = (rng.choice([1e-4, 1e-3, 1e-2, 0.1, 0.5], CALLS) * rng.standard_normal(CALLS) for _ in range(2))
    counts = 0.25e-6 * rng.integers(-40, 41, CALLS)
    return {"random speeds": (v / 4000, v), "random encoder steps": (counts, 4000 * counts),
            "increments against velocities": (other / 4000, v)}  # fmt: skip


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
        timed.argtypes = [*[ctypes.c_int] * 2, array, array, ctypes.c_double, array, array, ctypes.c_int, array]
        for calls, (dz, v) in _calls().items():
            nanoseconds, rest = np.empty(CALLS), MODEL.initial_state()
            timed(CALLS, ROUNDS, dz, v, 1 / 4000, rest, MODEL.packed(), rest.size, nanoseconds)
            median, worst = float(np.median(nanoseconds)), float(nanoseconds.max())
            told = f"{worst / median:.1f} ({worst:.0f} / {median:.0f} ns)"
            rows.append((f"longest of {CALLS:,} calls / their median, {calls}", told, "at most 3"))
    return rows
