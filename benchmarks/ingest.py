"""`fric ingest` of a long CSV against `pandas.read_csv` alone on the same file, and the memory it takes.

The size is FRIC_BENCH_CSV_MB (2000). Each measurement is a process of its own, in FRIC_BENCH_REPEAT (3) pairs; both
programs have read a small file before the clock starts, so that imports are not counted.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

import numpy as np
import pyarrow
from pyarrow import csv

BLOCK = 200_000
PANDAS = """
import sys, time, pandas
small, log, output = sys.argv[1:]
pandas.read_csv(small)
start = time.perf_counter()
pandas.read_csv(log)
print(time.perf_counter() - start)
"""
INGEST = """
import sys, time, pathlib
import fric
from fric.io.ingest import keep_freed_memory
small, log, output = map(pathlib.Path, sys.argv[1:])
keep_freed_memory()
fric.ingest(small, output=output)
start = time.perf_counter()
fric.ingest(log, output=output, force=True)
print(time.perf_counter() - start)
output.unlink()
"""


def write_log(path: Path, size: float) -> None:
    """Write a drive's log at 4 kHz of about `size` bytes: an encoder of 0.25 µm, a force with noise."""
    rng = np.random.default_rng(1)
    with path.open("wb") as file:
        start = 0
        while not start or file.tell() < size:
            t = (np.arange(BLOCK) + start) / 4000
            x, v = 1e4 * np.sin(t), 10 * np.cos(t)
            force = 105 * np.sign(v) + rng.normal(size=BLOCK)
            columns = [np.round(c, 6) for c in (t, np.round(x / 0.25) * 0.25, v, force)]
            table = pyarrow.table(columns, ["time [s]", "position [um]", "velocity [mm/s]", "force [N]"])
            csv.write_csv(table, file, csv.WriteOptions(include_header=not start))
            start += BLOCK


def measured(program: str, *arguments: Path) -> tuple[float, float]:
    """Return the seconds that a program tells last, and its peak resident memory in MB."""
    with tempfile.TemporaryFile("w+") as told:
        running = subprocess.Popen([sys.executable, "-c", program, *map(str, arguments)], stdout=told)
        _, status, usage = os.wait4(running.pid, 0)
        running.returncode = os.waitstatus_to_exitcode(status)
        if running.returncode:
            raise SystemExit(f"the benchmark ended with status {running.returncode}")
        told.seek(0)
        return float(told.read().split()[-1]), usage.ru_maxrss * 1024 / 1e6


def run() -> list[tuple[str, str, str]]:
    """Measure throughput and memory, the two programs in turns."""
    repeat = int(os.environ.get("FRIC_BENCH_REPEAT", "3"))
    with tempfile.TemporaryDirectory() as folder:
        small, log, output = (Path(folder) / name for name in ("small.csv", "log.csv", "log.h5"))
        small.write_text("time [s],position [um],velocity [mm/s],force [N]\n0,0,0,0\n1,1,1,1\n2,2,2,2\n")
        write_log(log, float(os.environ.get("FRIC_BENCH_CSV_MB", "2000")) * 1e6)
        size = log.stat().st_size / 1e6
        pairs = [(measured(PANDAS, small, log, output), measured(INGEST, small, log, output)) for _ in range(repeat)]
    pandas, ingest = zip(*pairs, strict=True)
    ratios = [alone[0] / whole[0] for alone, whole in pairs]
    what = f"CSV of {size:.0f} MB"
    return [
        (f"{what}: pandas.read_csv alone", f"{size / median(t for t, _ in pandas):.0f} MB/s", "the baseline"),
        (f"{what}: fric ingest", f"{size / median(t for t, _ in ingest):.0f} MB/s", ""),
        (f"{what}: throughput over pandas', median of {repeat} pairs", f"{median(ratios):.2f}", "≥ 0.6"),
        (f"{what}: throughput over pandas', each pair", " ".join(f"{r:.2f}" for r in ratios), ""),
        (f"{what}: peak memory of pandas.read_csv", f"{max(m for _, m in pandas):.0f} MB", "the baseline"),
        (f"{what}: peak memory of fric ingest", f"{max(m for _, m in ingest):.0f} MB", "< 400 MB at 2 GB"),
    ]
