"""How fast `fric --help` answers, against importing typer alone."""

from __future__ import annotations

import subprocess
import sys
from time import perf_counter

ROUNDS = 15


def _seconds(command: list[str]) -> float:
    start = perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return perf_counter() - start


def run() -> list[tuple[str, str, str]]:
    """Time both in fresh processes, in turn; the fastest of several rounds counts."""
    typer = [sys.executable, "-c", "import typer"]
    rows = []
    for words, target in ((["--help"], "≤ 2.2"), (["identify", "static", "--help"], "≤ 2.5")):
        pairs = [(_seconds([sys.executable, "-m", "fric", *words]), _seconds(typer)) for _ in range(ROUNDS)]
        fric, baseline = (min(column) for column in zip(*pairs, strict=True))
        told = f"{fric / baseline:.2f} ({1e3 * fric:.0f} ms)"
        rows.append((f"fric {' '.join(words)} / python -c 'import typer'", told, target))
    return rows
