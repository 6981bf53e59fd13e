"""A fleet made by the rig: drawn machines at two dates; some have more Coulomb friction at the second."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

import numpy as np

from fric.documents.machine_files import read_machine
from fric.io.hdf5 import write_logs
from fric.simulate.experiment import constant_velocity
from fric.simulate.spread import draw_machine

DATES = ("2026-01-10", "2026-07-10")
RISE = 1.15
SPEEDS = tuple(float(v) for v in np.geomspace(0.2e-3, 60e-3, 12))


def make_fleet(folder: Path, machines: int, drifted: Collection[int], seed: int = 0) -> None:
    """Write ``folder/machine/date/x.h5``: strokes of each machine at both dates."""
    nominal = read_machine(Path("xy-table"))
    for n in range(machines):
        axis = draw_machine(nominal, n, seed=seed)[0].axis("x")
        for m, date in enumerate(DATES):
            static = axis.friction.static
            if m and n in drifted:
                static = replace(static, F_c=RISE * static.F_c)
            there = replace(axis, friction=replace(axis.friction, static=static))
            logs = constant_velocity(
                there, seed=1000 * seed + 2 * n + m + 1, speeds=SPEEDS, distance=0.3e-3, lasting=0.3, samples=1024
            )
            place = folder / f"machine-{n:03d}" / date
            place.mkdir(parents=True)
            write_logs(place / "x.h5", logs)
