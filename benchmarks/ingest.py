"""Ingest of a long CSV against `pandas.read_csv` alone on the same file, and the memory it takes.

The size is FRIC_BENCH_CSV_MB (200); each measurement is a process of its own, in FRIC_BENCH_REPEAT (3) pairs.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

BLOCK = 100_000

PANDAS = """
import sys, time, pandas
start = time.perf_counter()
frame = pandas.read_csv(sys.argv[1])
print(time.perf_counter() - start, len(frame))
"""

INGEST = """
import sys, time, pathlib, fric, fric.io.ingest, fric.io.readers.text
start = time.perf_counter()
done = fric.ingest(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), force=True)
print(time.perf_counter() - start, done.samples)
"""


def write_log(path: Path, size: int) -> None:
    """Write a drive's log at 4 kHz of about `size` bytes: an encoder of 0.25 µm, a force with noise."""
    rng = np.random.default_rng(1)
    with path.open("w") as file:
        file.write("time [s],position [um],velocity [mm/s],force [N]\n")
        for start in range(0, size, 44 * BLOCK):
            t = (np.arange(BLOCK) + start // 44) / 4000
            x, v = 1e4 * np.sin(t), 10 * np.cos(t)
            f = 105 * np.sign(v) + rng.normal(size=BLOCK)
            columns = np.round(x / 0.25) * 0.25, v, f
            rows = (f"{a:.6f},{b:.2f},{c:.6f},{d:.6f}\n" for a, b, c, d in zip(t, *columns, strict=True))
            file.writelines(rows)


def measured(program: str, *arguments: Path) -> tuple[float, int, int]:
    """Return seconds, samples and peak resident bytes of a program in a process of its own."""
    with tempfile.TemporaryFile("w+") as told:
        running = subprocess.Popen([sys.executable, "-c", program, *map(str, arguments)], stdout=told)
        _, status, usage = os.wait4(running.pid, 0)
        running.returncode = os.waitstatus_to_exitcode(status)
        if running.returncode:
            raise SystemExit(f"a benchmark ended with status {running.returncode}")
        told.seek(0)
        seconds, samples = told.read().split()
    return float(seconds), int(samples), usage.ru_maxrss * 1024


def run() -> list[tuple[str, str, str]]:
    """Measure throughput and memory, the two programs in turns."""
    size = int(float(os.environ.get("FRIC_BENCH_CSV_MB", "200")) * 1e6)
    repeat = int(os.environ.get("FRIC_BENCH_REPEAT", "3"))
    with tempfile.TemporaryDirectory() as folder:
        log, output = Path(folder) / "log.csv", Path(folder) / "log.h5"
        write_log(log, size)
        megabytes = log.stat().st_size / 1e6
        rounds = [(measured(PANDAS, log), measured(INGEST, log, output)) for _ in range(repeat)]
        written = output.stat().st_size / 1e6
    pandas, ingest = (min(times) for times in zip(*rounds, strict=True))
    if pandas[1] != ingest[1]:
        raise SystemExit(f"pandas read {pandas[1]} samples, ingest {ingest[1]}")
    ratio = max(a[0] / b[0] for a, b in rounds)
    what = f"CSV of {megabytes:.0f} MB"
    return [
        (f"{what}: pandas.read_csv alone, throughput", f"{megabytes / pandas[0]:.0f} MB/s", "the baseline"),
        (f"{what}: fric ingest, throughput", f"{megabytes / ingest[0]:.0f} MB/s", ""),
        (f"{what}: ingest over pandas, throughput, best of {repeat} pairs", f"{ratio:.2f}", "≥ 0.6"),
        (f"{what}: pandas.read_csv alone, peak memory", f"{pandas[2] / 1e6:.0f} MB", "grows with the file"),
        (f"{what}: fric ingest, peak memory", f"{max(b[2] for _, b in rounds) / 1e6:.0f} MB", "< 400 MB at 2 GB"),
        (f"{what}: log file written", f"{written:.0f} MB", ""),
    ]
