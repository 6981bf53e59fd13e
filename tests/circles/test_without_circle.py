"""What is predicted of clean machines without any circle holds what a simulator without code of fric does on one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fric
from fric.documents.machine_files import MachineDocument
from fric.documents.yaml import write_document
from tests.chance import fewest
from tests.circles.plain_machine import motion
from tests.identify.plain_session import Axis, drawn, run, session

FEED = 0.1


def identified(axes: dict[str, Axis], rng: np.random.Generator, folder: Path):
    """Return the machine that the logs of each axis give, with the controllers as stated."""
    made = {}
    for name, axis in axes.items():
        logs = {of: [replace(log, axis=name) for log in some] for of, some in session(axis, rng).items()}
        plant, static, friction = (folder / f"{part}-{name}.yaml" for part in ("plant", "static", "friction"))
        fric.identify_plant(*logs["plant"]).save(plant)
        fric.identify_static(*logs["static"], plant=plant).save(static)
        fric.identify_gms(*logs["gms"], plant=plant, static=static).save(friction)
        gains = {
            "K_v": (axis.K_v, "1/s"), "K_p": (axis.K_p, "V*s/m"), "K_i": (axis.K_i, "V/m"), "limit": (1e3, "V"),
            "velocity_filter": (axis.corner, "Hz"), "sampling": (axis.rate, "Hz"),
        }  # fmt: skip
        controller = {
            key: {"value": float(value), "unit": unit, "source": "stated"} for key, (value, unit) in gains.items()
        }
        resolution = {"value": float(axis.count), "unit": "m", "source": "stated"}
        made[name] = {
            "motion": "linear", "plant": plant.name, "friction": friction.name, "controller": controller,
            "encoder": {"resolution": resolution},
        }  # fmt: skip
    write_document(folder / "machine.yaml", {"fric": MachineDocument.type_name(), "name": "clean", "axes": made})
    return fric.read_identified(folder / "machine.yaml")


def glitch(axes: dict[str, Axis], known, rng: np.random.Generator, radius: float) -> float:
    """Return the largest glitch of the last turn, whose inverse is that of the identified plant [m]."""
    rate, at = next(iter(axes.values())).rate, []
    t = np.arange(0.0, 0.25 + 2.1 * 2 * np.pi * radius / FEED, 1.0 / rate)
    for quarter, (name, axis) in zip((0.0, np.pi / 2), axes.items(), strict=True):
        of, off = known.machine.axes[name].plant, axis.count * rng.uniform()
        r, v, _ = motion(t, radius, FEED, quarter)
        _, ahead, changes = motion(t + of.T_d, radius, FEED, quarter)
        at.append(run(axis, rng, r + off, v, name, "motion", added=(changes + of.A * ahead) / of.B).position - off)
    x, y = (one[-int(2 * np.pi * radius / FEED * rate) :] for one in at)
    near = np.abs((np.arctan2(y, x) + np.pi / 4) % (np.pi / 2) - np.pi / 4) <= np.pi / 6
    rho = np.hypot(x, y)
    return float(np.abs(rho - np.median(rho))[near].max())


@pytest.mark.long(300)
def test_without_a_circle_what_is_predicted_of_clean_machines_holds_what_they_do(tmp_path: Path) -> None:
    """Of 13, 5 were above their intervals by 0.1 to 0.3 µm. Fails in under one of a thousand (`tests/chance.py`)."""
    done = []
    for seed in range(16):
        rng = np.random.default_rng([seed, 29])
        axes = {"x": drawn(rng), "y": drawn(rng)}
        while axes["y"].rate != axes["x"].rate:
            axes["y"] = drawn(rng)
        radius, folder = float(rng.uniform(0.015, 0.03)), tmp_path / f"{seed}"
        folder.mkdir()
        known = identified(axes, rng, folder)
        found = fric.circle(known, "a", velocity=FEED, radius=radius, machines=32, workers=1, seed=seed)
        low, high = found.prediction.schemes["a"].ci95
        done.append((low, float(np.median([glitch(axes, known, rng, radius) for _ in range(3)])), high))
    assert sum(low <= by <= high for low, by, high in done) >= fewest(len(done)), done
