"""Processor time of a start: `fric --help` against importing typer alone, and the six-scheme table in seconds."""

from __future__ import annotations

import os
import sys

ROUNDS = 15
TABLE_ROUNDS = 5

TYPER = ["-c", "import typer"]


def _seconds(words: list[str]) -> float:
    """Return the processor time of a process [s], which does not depend on what runs beside it as its duration does."""
    given = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    silent = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
    pid = os.posix_spawn(sys.executable, [sys.executable, *words], given, file_actions=silent)
    _, status, used = os.wait4(pid, 0)
    assert status == 0, words
    return used.ru_utime + used.ru_stime


def _fastest(commands: list[list[str]], rounds: int) -> list[float]:
    """Return the least time of each command, in turn, after a first one that fills the caches."""
    timed = [[_seconds(words) for words in commands] for _ in range(rounds + 1)][1:]
    return [min(column) for column in zip(*timed, strict=True)]


def run() -> list[tuple[str, str, str]]:
    """Time each in fresh processes, in turn; the fastest of several rounds counts."""
    helps = ["--help"], ["identify", "static", "--help"]
    *starts, typer = _fastest([["-m", "fric", *words] for words in helps] + [TYPER], ROUNDS)
    rows = [
        (f"fric {' '.join(words)} / python -c 'import typer'", f"{one / typer:.2f} ({1e3 * one:.0f} ms)", target)
        for words, one, target in zip(helps, starts, ("≤ 2.0", "≤ 2.5"), strict=True)
    ]
    table, floor = _fastest([["-m", "fric", "simulate", "circle", "xy-table"], ["-c", "import numba"]], TABLE_ROUNDS)
    return [*rows, ("six schemes, a whole process", f"{table:.2f} s ({floor:.2f} s to import Numba)", "≤ 1.0 s")]
