"""Holding maps: recognised with an uneven clock or none, split into friction and load, and nothing else is one."""

from dataclasses import replace

import numpy as np
import pytest

import fric
from fric.automatic.run import auto
from fric.log import Log
from fric.records.holding import holding_map, is_holding_map
from fric.records.recognition import kind_of
from tests.chance import fewest, most

MACHINES = {
    "motor": (0.02, 0.0, 0.05, 7, 6.28),
    "vertical": (40.0, 300.0, 5.0, 3, 0.4),
    "cable": (8.0, -3.0, 6.0, 1, 0.8),
}
"""Friction at rest, constant load and amplitude of what varies [N or N·m], its waves over the length, the length."""


def drawn(name: str, seed: int) -> Log:
    """Return holding forces at 24 to 200 places there and back, once or twice, as events bring them."""
    friction, load, amplitude, waves, length = MACHINES[name]
    rng = np.random.default_rng([seed, len(name)])
    places = int(rng.integers(24, 200))
    z = np.linspace(0.0, length, places) + length / places * rng.uniform(-0.2, 0.2, places) * (seed % 2)
    z, sense = np.tile(np.concatenate([z, z[::-1]]), 1 + seed % 3), np.repeat([1.0, -1.0], places)
    sense = np.tile(sense, 1 + seed % 3)
    z = z + 0.005 * length / places * rng.normal(size=len(z))
    force = load + amplitude * np.sin(2 * np.pi * waves * z / length) + friction * sense
    force += 0.1 * friction * rng.normal(size=len(z))
    time = np.cumsum(0.3 + rng.exponential(0.5, len(z)))
    return Log(time, z, force=force, name="map", motion="rotary" if name == "motor" else "linear")


def sampled(seed: int) -> Log:
    """Return a motion that is sampled on its way: at an uneven rate, with stamps that jitter, slowly, or coarsely."""
    rng = np.random.default_rng(seed)
    n, kind = int(rng.integers(100, 3000)), seed % 4
    time = np.cumsum(rng.choice([1e-3, 15.6e-3], n) if kind == 0 else 0.05 + rng.exponential(0.05, n))
    z = 0.05 * np.arcsin(np.sin(rng.uniform(0.2, 2.0) * time + rng.uniform(0, 6.0)))
    count = 10 ** rng.uniform(-6, -4)
    if kind == 1:
        time = time + 0.02 * rng.uniform(size=n)
    if kind == 2:
        time, z = np.arange(n, dtype=float), 0.05 * np.arcsin(np.sin(rng.uniform(0.01, 0.3) * np.arange(n)))
    if kind == 3:
        count = 5e-4
    z = np.round(z / count) * count
    return Log(time, z, force=50.0 * np.sign(np.gradient(z)) + rng.normal(size=n))


def test_friction_and_load_are_said_by_inspect_and_auto(tmp_path):
    log = drawn("vertical", 3)
    found = fric.inspect(log)
    (inspection,) = found.found
    assert inspection.kind == "holding-map"
    assert float(inspection.holding.level) == pytest.approx(40.0, rel=0.05)
    assert float(inspection.holding.load) == pytest.approx(300.0, rel=0.02)
    assert inspection.holding.varies == pytest.approx(5.0 / np.sqrt(2), rel=0.4)
    assert "friction at rest" in repr(found)
    rows = [f"{1e3 * z:.5f},{F:.4f}" for z, F in zip(log.position, log.force, strict=True)]
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs/map.csv").write_text("\n".join(["position [mm],force [N]", *rows, ""]))
    with pytest.raises(fric.FricError, match="holding-map"):
        fric.ingest(tmp_path / "logs/map.csv", output=tmp_path / "log.h5")
    result = auto(tmp_path / "logs", output=tmp_path / "found")
    (notice,) = [notice for notice in result.warnings if notice.code == "holding-map"]
    assert float(notice.values["level"]) == pytest.approx(40.0, rel=0.05)


@pytest.mark.parametrize("name", MACHINES)
def test_maps_are_recognised_and_intervals_hold_the_truth(name):
    friction, *_ = MACHINES[name]
    seen, held = [], []
    for seed in range(40):
        log = drawn(name, seed)
        seen.append(
            kind_of(log) == "holding-map" and is_holding_map(replace(log, time=np.arange(len(log), dtype=float)))
        )
        low, high = holding_map(log).level.ci95
        held.append(low <= friction <= high)
    assert sum(seen) >= fewest(40, 0.95)
    assert sum(held) >= fewest(40, 0.95)


def test_places_there_and_back_may_differ():
    """A map of 180 places there and 170 others back was a motion, with a viscous friction."""
    seen = 0
    for seed in range(20):
        rng = np.random.default_rng(seed)
        z = np.concatenate([np.sort(rng.uniform(0.0, 0.4, 60)), np.sort(rng.uniform(0.0, 0.4, 50))[::-1]])
        force = 0.3 + np.repeat([1.1, -1.1], [60, 50]) + 0.03 * rng.normal(size=110)
        log = Log(np.cumsum(rng.uniform(0.4, 2.5, 110)), z, force=force, name="map")
        seen += is_holding_map(log)
        assert float(holding_map(log).level) == pytest.approx(1.1, rel=0.02)
    assert seen >= fewest(20, 0.95)


def test_no_motion_that_is_sampled_on_its_way_is_one():
    assert sum(is_holding_map(sampled(seed)) for seed in range(120)) <= most(120, 0.01)
