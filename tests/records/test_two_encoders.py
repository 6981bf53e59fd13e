"""Two encoders: lost motion and stiffness of the transmission, and which of them friction is identified on."""

import numpy as np
import pytest

import fric
from fric.log import Log
from fric.records.flaws import foreign_compensation, transmission_of
from fric.records.inspection import inspect
from tests.chance import fewest

MACHINES = {"ball screw": (2e8, 2e-6, 80.0, 150.0), "rack": (3e7, 25e-6, 200.0, 400.0), "belt": (4e6, 0.0, 30.0, 20.0)}
"""Stiffness [N/m], play [m], friction of the load [N] and mass [kg]."""
OWN = 0.25
"""Mass of the motor over that of the load."""


def played(z: np.ndarray, width: float) -> np.ndarray:
    """Return what is driven with a play: it rests while the driving side crosses the gap."""
    out, at = np.empty_like(z), z[0]
    for n, x in enumerate(z):
        at = min(max(at, x - 0.5 * width), x + 0.5 * width)
        out[n] = at
    return out


def drawn(name: str, seed: int, fast: float = 1.0) -> tuple[Log, float, float]:
    """Return a log of a motion to and fro with both encoders, the lost motion and the force over the wind-up."""
    K, play, friction, mass = MACHINES[name]
    rng = np.random.default_rng([seed, len(name)])
    t, rate = np.arange(8000) / 1e3, fast * rng.uniform(0.8, 1.5)
    z = 0.02 * np.sin(2 * np.pi * rate * t) * (1 + 0.3 * np.sin(0.7 * t))
    carried = played(z, play)
    sense, acceleration = np.sign(np.gradient(carried)), np.gradient(np.gradient(z, t), t)
    sense = np.where(sense == 0.0, np.sign(np.gradient(z)), sense)
    through = friction * sense + mass * acceleration
    force = through + OWN * mass * acceleration + 0.02 * friction * rng.normal(size=len(t))
    noise = 1e-7 * rng.normal(size=len(t))
    count = 10 ** rng.uniform(-8, -6.5)
    load = np.round((carried - through / K + noise) / count) * count
    log = Log(t, np.round(z / count) * count, force=force, load_position=load, name="run")
    return log, play + 2.0 * friction / K, K * (1.0 + OWN)


@pytest.mark.long(2)
def test_lost_motion_and_stiffness_are_found_with_the_encoder_that_friction_is_identified_on(tmp_path):
    log, lost, stiffness = drawn("rack", 0)
    found = transmission_of(log)
    assert float(found.lost_motion) == pytest.approx(lost, rel=0.1)
    assert float(found.stiffness) == pytest.approx(stiffness, rel=0.1)
    (notice,) = [warning for warning in inspect(log).warnings if warning.code == "two-encoders"]
    assert "identified by the motor's encoder" in notice
    assert "lost motion" in repr(fric.inspect(log))
    motor, load = fric.identify_plant(log, method="motion"), fric.identify_plant(log, method="motion", encoder="load")
    assert motor.document["fit"] != load.document["fit"]
    with pytest.raises(fric.FricError, match="no load_position"):
        fric.identify_plant(Log(log.time, log.position, force=log.force), method="motion", encoder="load")


@pytest.mark.parametrize("on", ["position", "load_position"])
def test_lost_motion_is_no_kick_of_a_compensation_whichever_encoder_the_loop_is_closed_on(on):
    """The other encoder jumps by the lost motion at each reversal, which no reference asks for."""
    rng, t = np.random.default_rng(3), np.arange(8000) / 1e3
    for lag in (0.0, 2e-3):
        reference, followed = (0.02 * np.sin(2 * np.pi * (t - late)) for late in (0.0, lag))
        other = followed + (1 if on == "load_position" else -1) * 10e-6 * np.sign(np.cos(2 * np.pi * (t - lag)))
        motor, load = (other, followed) if on == "load_position" else (followed, other)
        motor, load = (np.round((x + 1e-7 * rng.normal(size=len(t))) / 1e-6) * 1e-6 for x in (motor, load))
        assert foreign_compensation(Log(t, motor, reference=reference, load_position=load)) is None


def test_without_acceleration_friction_and_direction_are_one():
    log, lost, _ = drawn("rack", 0, fast=0.03)
    found = transmission_of(log)
    assert float(found.lost_motion) == pytest.approx(lost, rel=0.05)
    assert found.stiffness is None


@pytest.mark.long(60)
@pytest.mark.parametrize("name", MACHINES)
def test_intervals_hold_the_truth(name):
    """Each of 95 %, over 40 draws of every machine; a right one fails in less than 1e-3 of draws."""
    held = []
    for seed in range(40):
        log, lost, stiffness = drawn(name, seed)
        found = transmission_of(log)
        pairs = ((found.lost_motion, lost), (found.stiffness, stiffness))
        held.append([low <= true <= high for (low, high), true in ((pair.ci95, true) for pair, true in pairs)])
    assert np.sum(held, axis=0).min() >= fewest(40, 0.95)
