"""Micro-steps: a staircase up and down before sliding, recognised, and enough for the virgin curve. Logs too slow."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

import fric
from fric.drive.sensing import Encoder
from fric.friction.gms import GMS
from fric.identify.gms.virgin_curve import find_cycles, virgin_curve
from fric.log import Log
from fric.planning.choose import choose
from fric.records.inspection import FINE, inspect
from fric.records.prepared import prepared
from fric.records.recognition import fitted_staircase, kind_of
from fric.reference import sine, staircase, strokes
from fric.results.given_models import machine_of
from fric.simulate.experiment import Limits, experiment
from tests.identify.presliding import APART, PAPER, TABLE_1, record

SLIP, SHARE = np.geomspace(0.6e-6, 85e-6, 10), np.array([20, 16, 13, 11, 10, 9, 8, 6, 4, 3]) / 100
TEN = GMS(PAPER, tuple(SHARE), tuple(SHARE * PAPER.F_s / SLIP), C=1e4)
MACHINES = {"base": TABLE_1, "xy-table": APART, "coloured-noise": TEN}


@lru_cache(2)
def drawn(name: str, seed: int) -> tuple[Log, GMS]:
    """Return the log of a machine with its friction: blocks up to 20 % off, a micro-step of 13 to 100 counts."""
    rng = np.random.default_rng([seed, len(name)])
    axis, model = machine_of(name).axis("x"), MACHINES[name]
    model = replace(model, k=tuple(k * rng.uniform(0.8, 1.2) for k in model.k))
    step = 1e-6 * rng.uniform(0.7, 2.0)
    count = step / float(np.exp(rng.uniform(np.log(13.0), np.log(100.0))))
    axis = replace(axis, friction=model, encoder=Encoder(count))
    (log,) = experiment(axis, "micro-steps", seed=seed, step=step)
    return replace(log, kind=None), model


def off(log: Log, model: GMS) -> float:
    """Return by how much the virgin curve is off at most, over the half loop, from half a step on."""
    stairs = fitted_staircase(log.reference)
    curve = virgin_curve([find_cycles(prepared([log])[0])], PAPER)
    z = np.linspace(0.5 * stairs.step, float(curve.displacement[-1]), 200)
    true = model.virgin_curve(z)
    return float(np.abs(curve(z) - true).max() / true[-1])


def use(log: Log, purpose: str = "gms"):
    return next(one for one in inspect(log).uses if one.purpose == purpose)


@pytest.mark.parametrize("asked", [True, False])
def test_a_staircase_is_recognised_and_tells_the_virgin_curve(asked):
    log, model = drawn("base", 0)
    found = inspect(log if asked else replace(log, reference=None))
    assert found.kind == "micro-steps"
    assert len(found.reversals) == 7  # four loops, the last of which ends where it began
    assert use(log).good
    assert off(log, model) < 0.02


@pytest.mark.long(400)
@pytest.mark.parametrize("name", MACHINES)
def test_the_curve_is_within_two_per_cent_where_it_is_said_to_be_good(name):
    """Of 40 machines of each kind of friction; a rate of misses of 2 % has more than five of 40 in 3e-4 of draws."""
    errors = []
    for seed in range(40):
        log, model = drawn(name, seed)
        assert inspect(log).kind == "micro-steps"
        errors += [off(log, model)] if use(log).good else []
    assert len(errors) >= 35
    assert np.mean(np.array(errors) > 0.02) <= 5 / 40
    assert np.median(errors) < 0.015


def test_steps_of_few_counts_are_not_good_for_a_curve():
    (log,) = experiment(machine_of("xy-table").axis("x"), "micro-steps", loops=2)  # 1 um on an encoder of 0.25 um
    assert not use(log).good
    assert "4.0 steps of the encoder" in use(log).why
    assert f"{FINE:.0f} are needed" in use(log).why


def positions(rng):
    yield sine(15e-6, 0.1, 4, 500.0).position
    yield strokes(1e-3, 5e-3, 500.0).position
    yield np.cumsum(rng.normal(size=5000)) * 1e-6
    yield 20e-6 * np.arcsin(np.sin(np.arange(5000) / 200.0))
    yield np.repeat([0.0, 1e-3, 0.0, 1e-3, 0.0, 1e-3, 0.0, 1e-3] * 3, 200)  # there and back, and no flight


def test_other_motions_are_no_staircase():
    rng = np.random.default_rng(3)
    for z in positions(rng):
        for count in (0.0, 1e-7, 1e-6):
            seen = np.round(z / count) * count if count else z + 1e-8 * rng.normal(size=len(z))
            assert fitted_staircase(seen) is None


def test_a_staircase_has_its_steps_and_derivatives():
    made = staircase(1e-6, 5, 2, 1000.0, ramp=0.1, dwell=0.2)
    assert made.position.max() == pytest.approx(5e-6)
    assert abs(made.position[-1]) < 1e-12
    found = fitted_staircase(made.position)
    assert found.step == pytest.approx(1e-6)
    assert len(found.reversals) == 3
    assert np.gradient(made.position, 1e-3) == pytest.approx(made.velocity, abs=2e-7)
    assert np.gradient(made.velocity, 1e-3) == pytest.approx(made.acceleration, abs=2e-5)
    with pytest.raises(fric.FricError, match="no step"):
        staircase(0.0, 5, 2, 1000.0)


def test_large_steps_are_no_micro_steps():
    """Ten millimetres a step: friction has come up within the first hundredth of each flight."""
    log, _ = drawn("base", 0)
    assert kind_of(log) == "micro-steps"
    F = np.sign(np.gradient(np.round(log.reference, 7))) * 80.0
    assert kind_of(replace(log, position=1e4 * log.position, reference=1e4 * log.reference, force=F)) != "micro-steps"


def test_a_plan_has_a_staircase_in_place_of_sines():
    axis, limits = machine_of("xy-table").axis("x"), Limits(0.3, 0.1, 5.0)
    planned = {one.kind: one for one in choose(axis, limits, micro_steps=True)}
    assert "presliding-sine" not in planned
    settings = planned["micro-steps"].settings
    assert settings["step"] >= FINE * axis.encoder.resolution
    assert settings["step"] * settings["steps"] > 2.0 * 54e-6  # a flight goes through the last block of both directions
    (trial,) = planned["micro-steps"].trials(axis)
    assert not limits.broken_by(trial.reference)


@pytest.mark.parametrize("rate", [2.0, 10.0])
def test_a_log_too_slow_is_not_good_for_gms(rate):
    """A production move of 5 mm: between two samples it goes further than pre-sliding lasts; the drive filters."""
    fine = record(5e-3, frequency=0.02, cycles=6, dt=1e-3, step=1e-6)
    kept = slice(None, None, int(1e3 / rate))
    pole = np.exp(-1e-3 / 0.5)
    force = np.convolve(fine.force, (1 - pole) * pole ** np.arange(4000))[: len(fine)]
    log = Log(fine.time[kept], position=fine.position[kept], force=force[kept])
    assert not use(log).good
    assert use(record(15e-6, dt=4e-3)).good
