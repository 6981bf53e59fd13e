"""Tune: intervals where the shape was kept, and where it was fitted

The machines of `configs/spread-shape.yaml` differ in shape (shares, stiffnesses, F_s/F_c, v_s, delta, sigma). Here they
differ in turns by as much as there, by a third, a tenth and a thirtieth of it (in the logarithm).

Where the shape differs little, `tune` keeps it and fits four parameters. The intervals still hold the whole shape.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from typing import Any

from benchmarks._machines import Study
from benchmarks._tuned import CONFIGS, FAST, MACHINES, SLOW, driven, errors_of, recorded, share
from fric.circles.tune import tune_axis
from fric.documents.machine_files import read_machine, read_spreads
from fric.simulate.spread import draw_machine

SHAPE = ("alpha", "k", "F_s", "v_s", "delta", "sigma")
"""Spreads of the shape of friction."""
DIFFERS = (1.0, 1 / 3, 1 / 10, 1 / 30)
"""How much the shapes of machines differ in turns, as a power of the factors of the file."""


def axes_of(seed: int, index: int) -> dict[str, Any]:
    """Tune the axes of a machine; return what was kept of their shapes, and the errors in half-widths."""
    power = DIFFERS[index % len(DIFFERS)]
    spreads = {
        name: replace(one, low=one.low**power, high=one.high**power) if name in SHAPE else one
        for name, one in read_spreads(CONFIGS / "spread-shape.yaml").items()
    }
    machine = draw_machine(read_machine(CONFIGS / "xy-table.yaml"), index, seed=seed, spreads=spreads)[0]
    tests = [recorded(machine, driven(machine, "f", test), None) for test in (FAST, SLOW)]
    found = {name: tune_axis(axis, tests) for name, axis in machine.axes.items()}
    return {"kept": {name: not axis.full for name, axis in found.items()}, "errors": errors_of(machine, found)}


def run(study: Study) -> list[tuple[str, str, str]]:
    """Tune machines."""
    done = study.run(axes_of, [(study.seed, n) for n in range(study.number(MACHINES))])
    held: dict[tuple[str, str], list[bool]] = defaultdict(list)
    for (_, index), one in zip(done.tasks, done.found, strict=True):
        for key, error in one["errors"].items():
            axis, name = key.split()
            kept = "kept" if one["kept"][axis] else "fitted"
            for group in (kept, f"{kept}, shape by 1/{round(1 / DIFFERS[index % len(DIFFERS)])}"):
                held[group, name].append(abs(error) <= 1)
    return [
        done.row(),
        *((f"{group}: {name}", share(inside), "90 to 98 %") for (group, name), inside in sorted(held.items())
          if "by" not in group or name in ("F_c", "F_s")),
    ]  # fmt: skip
