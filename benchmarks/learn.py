"""Learn

`fric learn` repeats a circle of 30 mm on machines of `configs/spread.yaml`. At 100 mm/s it learns whole rounds up to
200 Hz, at 10 mm/s halves of rounds up to 100 Hz. Twenty rounds show that nothing grows again.

What was learned is also tried by angle at half the feed, and on two thirds of the radius. At 100 mm/s it does not
transfer.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks._machines import Study, spread_of
from fric.circles.learn import learn
from fric.documents.bundled import folder
from fric.documents.machine_files import read_machine, read_spreads
from fric.simulate.contour_run import Circle
from fric.simulate.spread import draw_machine

ROUNDS = 20
MACHINES = 4
"""Machines where nothing else is asked for; what is written down takes 200."""


def learned(seed: int, index: int) -> dict[str, Any]:
    """Learn on one machine, at both feeds."""
    configs = folder("configs")
    machine = read_machine(configs / "xy-table.yaml")
    machine = draw_machine(machine, index, seed=seed, spreads=read_spreads(configs / "spread.yaml"))[0]
    found: dict[str, Any] = {}
    for feed in (0.1, 0.01):
        one = learn(machine, Circle(feed=feed), ROUNDS)
        found[f"{feed * 1e3:g}"] = {
            "glitches": one.glitches, "carried": [glitch for *_, glitch in one.carried],
            "told": [warning.code for warning in one.warnings],
        }  # fmt: skip
    return found


def run(study: Study) -> list[tuple[str, str, str]]:
    """Learn on machines."""
    ran = study.run(learned, [(study.seed, n) for n in range(study.number(MACHINES))])
    found, rows = ran.found, [ran.row()]
    for feed, rounds, target in (("100", (1, 2, 3), {2: "p95 ≤ 0.9"}), ("10", (2, 5), {5: "p95 ≤ 2"})):
        if not found:
            break
        label = f"{feed} mm/s"
        glitches = np.array([one[feed]["glitches"] for one in found])
        rows.append((f"{label}: (f) before", spread_of(glitches[:, 0]), ""))
        for n in rounds:
            rows.append((f"{label}: learned from {n}", spread_of(glitches[:, n]), target.get(n, "")))
        early, late = glitches[:, 5:11].max(axis=1), glitches[:, -5:].max(axis=1)
        rows.append((f"{label}: the worst of rounds 5 to 10", spread_of(early), ""))
        rows.append((f"{label}: the worst of rounds {ROUNDS - 4} to {ROUNDS}", spread_of(late), ""))
        grown = int(np.sum((late > 2 * early) | (late > glitches[:, 0]) & (late > 2e-6)))
        rows.append((f"{label}: twice that of rounds 5 to 10, or above 2 µm and what it began with", str(grown), "0"))
        for n, what in enumerate(("at half the feed", "on two thirds of the radius")):
            carried = [one[feed]["carried"][n] for one in found]
            rows.append((f"{label}: carried over, {what}", spread_of(carried), "it does not transfer"))
        told = sum("learned-for-one-circle" in one[feed]["told"] for one in found)
        rows.append((f"{label}: warned that it does not transfer", f"{told} of {len(found)}", ""))
    return rows
