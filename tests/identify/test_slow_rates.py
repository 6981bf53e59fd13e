"""Logs so slow that the speed changes between samples: friction is right, and what is not seen is not stated."""

import numpy as np
import pytest

from fric.errors import FricError
from fric.friction.lugre import LuGre
from fric.friction.stribeck import StaticMap
from fric.identify.plant.identify import identify_motion
from fric.identify.replay.replay_fit import identify_by_replay
from fric.log import Log
from fric.records.prepared import prepared

M, F_V, F_C = 4.0, 6.6, 3.3


def moves(rate: float, ramp: float, seed: int = 1, rest: int = 450) -> Log:
    """Return moves to and fro at four speeds, with ramps of a duration [s] and rests [ms] that hold some force."""
    r = np.random.default_rng(seed)
    dt = 1e-3
    v, held = [np.zeros(300)], [np.zeros(300)]
    for k in range(24):
        top, n, m = r.choice([0.02, 0.05, 0.1, 0.2]) * (-1) ** k, round(ramp / dt), int(r.integers(1500, 2500))
        v += [np.concatenate([np.linspace(0, top, n), np.full(m, top), np.linspace(top, 0, n), np.zeros(rest)])]
        held += [np.full(len(v[-1]), np.sign(top) * r.uniform(0.2, 0.9) * F_C)]
    velocity = np.concatenate(v)
    position, acceleration = np.cumsum(velocity) * dt, np.gradient(velocity, dt)
    friction = np.where(velocity == 0.0, np.concatenate(held), F_C * np.sign(velocity))
    force = M * acceleration + F_V * velocity + friction + r.normal(0.0, 0.05, len(velocity))
    every = slice(None, None, round(1.0 / (rate * dt)))
    time = np.arange(len(velocity)) * dt
    return Log(name="a", axis="x", kind="motion", time=time[every], position=np.round(position, 6)[every],
               force=force[every])  # fmt: skip


@pytest.mark.parametrize("rate", [10.0, 20.0])
def test_a_motion_whose_starts_are_between_samples_gives_its_friction_and_no_mass(rate: float) -> None:
    log = moves(rate, 0.06)
    with pytest.raises(FricError, match="the mass is not seen"):
        identify_motion([log])
    F_c = identify_by_replay("lugre", prepared([log])).estimates["static"]["F_c"]
    assert float(F_c) == pytest.approx(F_C, rel=0.02)
    assert F_c.ci95[0] < F_C < F_c.ci95[1]


@pytest.mark.parametrize("rate", [100.0, 200.0])
def test_the_mass_of_a_slow_log_is_not_that_of_a_filter(rate: float) -> None:
    found = identify_motion([moves(rate, 0.3)]).estimates
    assert float(found["M"]) == pytest.approx(M, rel=0.01)
    assert float(found["F_c"]) == pytest.approx(F_C, rel=0.01)


@pytest.mark.parametrize("rate", [200.0, 1000.0])
def test_friction_of_an_axis_that_rests_most_of_the_time_is_not_drawn_towards_zero(rate: float) -> None:
    """At rest it holds any force up to F_c: in 69 % of the samples, and F_c was said to be too small by that."""
    log = moves(rate, 0.3, rest=5800)
    assert np.mean(np.diff(log.position) == 0.0) == pytest.approx(0.69, abs=0.02)
    found = identify_motion([log]).estimates
    assert float(found["F_c"]) == pytest.approx(F_C, rel=0.01)
    assert found["F_c"].ci95[0] < F_C < found["F_c"].ci95[1]


def test_what_a_motion_hides_between_few_samples_is_not_taken_for_friction() -> None:
    """At 20 Hz, beside rests: F_c was 3.2 % low, F_v 1.5 % high, and nothing was said."""
    r, position = np.random.default_rng(5), [np.zeros(300)]
    for _ in range(30):
        goal, n = r.uniform(-0.5, 0.5), int(1e3 * r.uniform(0.8, 2.0))
        s = np.arange(1, n + 1) / n
        position += [(goal - position[-1][-1]) * s**3 * (10 - 15 * s + 6 * s**2) + position[-1][-1], np.full(300, goal)]
    z = np.concatenate(position)
    t = 1e-3 * np.arange(len(z))
    v = np.gradient(z, t)
    law = LuGre(StaticMap(F_c=F_C, F_s=1.2 * F_C, v_s=0.05, sigma=F_V), sigma_0=200 * F_C, sigma_1=15.4)
    force = M * np.gradient(v, t) + law.replay(t, z, v) + r.normal(0.0, 0.02, len(t))
    some = slice(int(r.integers(50)), None, 50)
    fit = identify_by_replay("lugre", prepared([Log(t[some], position=z[some], force=force[some], kind="motion")]))
    assert [notice.code for notice in fit.warnings] == ["changes-between"]
    for name, true in (("F_c", F_C), ("sigma", F_V)):
        low, high = fit.estimates["static"][name].ci95
        assert 0.99 * true < low < true < high < 1.01 * true, name
