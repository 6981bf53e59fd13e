"""The table of docs/models.md on recovery: `python -m docs.model_coverage [SEEDS]` measures it and writes it there.

Each model is fitted to noisy logs that it made of itself, as in tests/identify/test_recovery.py, over more seeds. With
a second number, as in `python -m docs.model_coverage 400 0.5`, the noise remembers that share of the sample before;
this is printed alone, without the column that holds for white noise.
"""

from __future__ import annotations

import os
import sys
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from pathlib import Path

import numpy as np

from tests.identify.recovery import FITTED, Recovery, recover

PAGE = Path(__file__).parent / "models.md"
BEGIN, END = "<!-- recovery -->\n", "<!-- end of recovery -->\n"
SEEDS, PART = 2000, 50


def measured(name: str, seeds: int, memory: float, pool: ProcessPoolExecutor) -> Recovery:
    """Return the recovery of a model's parameters over seeds from 0 on, fitted in parts."""
    each = [range(n, min(n + PART, seeds)) for n in range(0, seeds, PART)]
    parts = list(pool.map(recover, repeat(name), each, repeat(memory)))
    errors, linear = (np.concatenate([getattr(part, of) for part in parts]) for of in ("errors", "linear"))
    return Recovery(parts[0].labels, errors, linear)


def row(model: str, parameter: str, share: float, right: float, bias: float, width: float) -> str:
    """Return one row of the table."""
    return f"| {model} | {parameter} | {share:.3f} | {right:.3f} | {bias:+.2f} | {width:.2f} |"


def main() -> None:
    """Measure the table, and write it into the page."""
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else SEEDS
    memory = float(sys.argv[2]) if len(sys.argv) > 2 else 0.0
    head = (f"{seeds} seeds", "parameter", "share", "without luck", "bias", "rms error")
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for name in FITTED:
            found = measured(name, seeds, memory, pool)
            right = found.without_luck[0] if not memory else np.full(len(found.labels), np.nan)
            told = found.shares, right, found.biases, found.widths
            lines.append(row(f"`{name}`", "all", *(float(np.mean(of)) for of in told)))
            lines += map(row, repeat(""), found.labels, *told)
            print(*lines[-1 - len(found.labels) :], sep="\n", flush=True)
    if memory:
        return
    before, rest = PAGE.read_text().split(BEGIN)
    after = rest.split(END)[1]
    PAGE.write_text(before + BEGIN + "\n".join(lines) + "\n" + END + after)


if __name__ == "__main__":
    main()
