"""How fast a cascade is designed in a fresh process, against importing python-control alone."""

from __future__ import annotations

import subprocess
import sys
from time import perf_counter

ROUNDS = 5
DESIGN = """
from fric.design.cascade import design_cascade
from fric.design.observer import design_observer
from fric.drive.plant import LinearPlant
plant = LinearPlant(28.57, 4.526, 0.65e-3)
"""
WORK = DESIGN + "design_observer(plant, design_cascade(plant).cascade)"


def _seconds(code: str) -> float:
    start = perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True)
    return perf_counter() - start


def run() -> list[tuple[str, str, str]]:
    """Time them in fresh processes, in turn; the fastest of several rounds counts."""
    rounds = [(_seconds(DESIGN), _seconds(WORK), _seconds("import control")) for _ in range(ROUNDS)]
    imported, designed, baseline = (min(column) for column in zip(*rounds, strict=True))
    return [
        ("import fric.design / import control", f"{imported / baseline:.2f} ({1e3 * imported:.0f} ms)", "≤ 0.6"),
        (
            "cascade and observer designed, imports included / import control",
            f"{designed / baseline:.2f} ({1e3 * designed:.0f} ms)",
            "≤ 1",
        ),
    ]
