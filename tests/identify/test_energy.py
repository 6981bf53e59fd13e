"""What the energy of cycles tells of a record: that it drifts, or that a contact was unloaded for a while."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import fric
from fric.log import Log


def cycles(level: np.ndarray, noise: float = 0.3, seed: int = 1) -> Log:
    """Coulomb friction of a level that may change, on a slow sine of 1 mm: 4·amplitude·level is lost per cycle."""
    t = np.arange(len(level)) * 0.02
    z = 1e-3 * np.sin(2 * np.pi * 0.1 * t)
    force = level * np.tanh(np.gradient(z, t) / 2e-5) + noise * np.random.default_rng(seed).standard_normal(len(t))
    return Log(t, 1e-7 * np.round(z / 1e-7), force=force, kind="presliding-sine")


def told(log: Log) -> dict[str, dict[str, Any]]:
    return {one["code"]: one["values"] for one in fric.inspect(log).document["records"][0]["warnings_coded"]}


def test_cycles_that_are_alike_are_told_nothing_of_and_their_energy_is_that_of_coulomb() -> None:
    for seed in range(8):
        found = fric.inspect(cycles(np.full(6000, 50.0), seed=seed)).document["records"][0]
        assert not {"energy-drifts", "energy-in-one-segment"} & {one["code"] for one in found["warnings_coded"]}
        low, high = found["energy"]["ci95"]
        assert found["energy"]["value"] == pytest.approx(4e-3 * 50.0, rel=0.03)
        assert low < found["energy"]["value"] < high


def test_a_contact_that_was_unloaded_for_a_while_is_told_with_its_time() -> None:
    level = np.full(6000, 50.0)
    level[4500:] = 20.0  # from 90 s on
    found = told(cycles(level))["energy-in-one-segment"]
    assert 80.0 < found["begin"] < 100.0
    assert found["elsewhere"] == {"value": pytest.approx(0.2, rel=0.01), "unit": "J"}  # 4 mm times 50 N
    assert 0.08 < found["there"]["value"] < 0.12  # 80 mJ, and the cycle that it began in


def test_a_drift_is_told_with_its_size() -> None:
    found = told(cycles(np.linspace(50.0, 55.0, 6000)))["energy-drifts"]
    assert found["change"] == pytest.approx(0.095 * 9 / 10, abs=0.015)


def test_cycles_of_other_amplitudes_are_not_compared() -> None:
    log = cycles(np.full(6000, 50.0))
    grown = replace(log, position=log.position * np.linspace(1.0, 2.0, len(log)))
    assert not {"energy-drifts", "energy-in-one-segment"} & set(told(grown))
