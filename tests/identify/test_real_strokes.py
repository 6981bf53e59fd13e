"""Strokes as real drives make them: a fall that only the slowest show, swings, ripples, gravity, no stroke at all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fric.drive.plant import Plant
from fric.friction.stribeck import StaticMap
from fric.identify.static_map.identify import StaticFit, identify_static
from fric.identify.static_map.points import Asked
from fric.log import Log
from fric.notice import Notice
from tests.chance import fewest, most
from tests.identify.constant_velocity import TABLE_1, both_directions, stroke
from tests.turns import in_turns

MASS = 121.0


def codes(fit: StaticFit) -> dict[str, str]:
    return {w.code: w.severity for w in fit.warnings if isinstance(w, Notice)}


def limits(fit: StaticFit, name: str) -> tuple[float, float]:
    assert fit.static is not None
    low, high = fit.static.estimates[name].ci95  # type: ignore[misc]
    return low, high  # type: ignore[return-value]


def swung(v: float, rng: np.random.Generator, *, swing: float, frequency: float = 4.0, friction: StaticMap) -> Log:
    """Return a stroke whose velocity swings by so much (rms over mean); the force holds friction and inertia."""
    n, rate = 4000, 1000.0
    t = np.arange(n) / rate
    w, phase = 2 * np.pi * frequency, rng.uniform(0, 2 * np.pi)
    depth = np.sqrt(2) * swing
    speed = v * (1 + depth * np.sin(w * t + phase))
    z = v * (t - depth * (np.cos(w * t + phase) - np.cos(phase)) / w)
    inertia = MASS * v * depth * w * np.cos(w * t + phase)
    g = np.exp(-((np.abs(speed) / friction.v_s) ** friction.delta))
    F = np.sign(speed) * (friction.F_c + (friction.F_s - friction.F_c) * g) + friction.sigma * speed + inertia
    z = np.round(z / 0.25e-6) * 0.25e-6
    return Log(t, z, force=F + rng.normal(0, 1.0, n), kind="constant-velocity", name=f"{1e3 * v:.3g} mm/s")


SLOW = np.geomspace(0.1e-3, 30e-3, 14)


def test_a_fall_that_only_the_two_slowest_of_one_direction_show_is_kept() -> None:
    """Forward strokes reach into the fall, backward ones don't: none stands off, and the fall is found."""
    map_ = StaticMap(F_c=80.0, F_s=120.0, v_s=0.6e-3, delta=1.0, sigma=100.0)
    rng = np.random.default_rng(1)
    fast = np.geomspace(4e-3, 40e-3, 12)
    speeds = np.concatenate([[0.3e-3, 0.8e-3], fast, -fast])
    fit = identify_static([stroke(v, rng, friction=map_, noise=0.005) for v in speeds], Asked())
    assert fit.static is not None
    assert not fit.static.standing_off
    assert float(fit.static.estimates["F_s"]) == pytest.approx(120, rel=0.01)
    assert float(fit.static.estimates["F_c"]) == pytest.approx(80, rel=0.01)


few_and_many = pytest.mark.parametrize("draws", [4, pytest.param(20, marks=pytest.mark.long(15))])
"""Of statistics a few draws at once, and as many as tell a share in the tests' long part."""


@few_and_many
@pytest.mark.parametrize("sigma", in_turns([400.0, 3000.0], [400.0]))
def test_coulomb_plus_viscous_friction_is_told_as_such(sigma: float, draws: int) -> None:
    """Where nothing falls, F_c is no 0 with a v_s of the fastest stroke, but that of the simpler map.

    A draw in twenty may see a fall, and is passed over. Chance of failing: below one in a thousand.
    """
    map_ = StaticMap(F_c=60.0, F_s=60.0, v_s=1e-3, sigma=sigma)
    covered = 0
    for seed in range(draws):
        rng = np.random.default_rng([seed, 2])
        logs = [stroke(v, rng, friction=map_) for v in both_directions(np.geomspace(2e-3, 60e-3, 8))]
        logs = [replace(log, force=log.force + rng.normal(0, 0.5)) for log in logs]
        fit = identify_static(logs, Asked())
        assert fit.static is not None
        if fit.static.problem.fall:
            continue
        assert fit.static.estimates["F_s"].assumed
        assert fit.static.estimates["v_s"].assumed
        assert codes(fit)["fall-not-seen"] == "doubt"
        low, high = limits(fit, "F_c")
        covered += low <= 60.0 <= high
    assert covered >= fewest(draws, 0.9)
    assert "Coulomb plus viscous" in identify_static(logs, Asked(form="coulomb")).method
    forced = identify_static(logs, Asked(form="stribeck"))
    assert forced.static is not None
    assert forced.static.problem.fall


@few_and_many
def test_swings_over_a_falling_curve_do_not_lift_it(draws: int) -> None:
    """16 % (rms) between 0.3 and 1.2 mm/s: F_s stays within its interval, and the swing is measured and said.

    Chance of failing: below one in a thousand for each of three numbers, which go together.
    """
    covered = {"F_c": 0, "F_s": 0, "v_s": 0}
    for seed in range(draws):
        rng = np.random.default_rng([seed, 3])
        logs = [
            swung(v, rng, swing=0.35 if 0.3e-3 < abs(v) < 1.2e-3 else 1e-4, friction=TABLE_1)
            for v in both_directions(SLOW)
        ]
        fit = identify_static(logs, Asked())
        swings = [p.swing for p in fit.points if 0.3e-3 < abs(p.velocity) < 1.2e-3]
        assert swings == pytest.approx([0.35] * len(swings), rel=0.15)
        for name in covered:
            low, high = limits(fit, name)
            covered[name] += low <= getattr(TABLE_1, name) <= high
    assert codes(fit)["strokes-swing"] == "note"
    assert min(covered.values()) >= fewest(draws), covered


def test_a_stroke_that_ripples_too_much_for_a_steady_stretch_is_used() -> None:
    rng = np.random.default_rng(5)
    rippling = swung(2e-3, rng, swing=0.3, frequency=0.75, friction=TABLE_1)
    logs = [stroke(v, rng) for v in both_directions(SLOW)]
    fit = identify_static([*logs, rippling], Asked())
    assert any(p.record == rippling.name for p in fit.points)
    assert "records-without-stroke" not in codes(fit)


def test_records_that_give_no_stroke_are_listed_with_their_reasons() -> None:
    rng = np.random.default_rng(6)
    logs = [stroke(v, rng) for v in both_directions(SLOW)]
    t = np.arange(3000) / 1000
    force = rng.normal(50, 1, 3000)
    others = [
        Log(t, np.round(1e-6 * t / 0.25e-6) * 0.25e-6, force=force, kind="constant-velocity", name="creeps"),
        Log(t, 1e-3 * t**2, force=force, kind="constant-velocity", name="speeds up"),
        Log(t, 1e-3 * np.sin(2 * t), force=force, kind="constant-velocity", name="to and fro"),
    ]
    fit = identify_static([*logs, *others], Asked())
    (told,) = [w for w in fit.warnings if isinstance(w, Notice) and w.code == "records-without-stroke"]
    for words in (
        "3 of 31 records",
        "creeps (it moves by",
        "speeds up (its speed goes from",
        "to and fro (it moves to",
    ):
        assert words in told, words


def test_gravity_survives_each_direction() -> None:
    """60 N of gravity are the offset of both directions, not a Coulomb friction of 130 and 10 N."""
    rng = np.random.default_rng(7)
    weight = StaticMap(F_c=70.0, F_s=90.0, v_s=2e-3, sigma=100.0)
    logs = [stroke(v, rng, friction=weight, offset=60.0) for v in both_directions(SLOW)]
    fit = identify_static(logs, Asked(direction="each"))
    assert fit.static is not None
    assert fit.negative is not None
    for one in (fit.static, fit.negative):
        assert float(one.estimates["offset"]) == pytest.approx(60.0, abs=0.5)
        low, high = one.estimates["F_c"].ci95  # type: ignore[misc]
        assert low < 70 < high  # type: ignore[operator]
    assert codes(fit)["offset-shared"] == "note"
    v = np.array([5e-3, 20e-3])
    np.testing.assert_allclose(fit.static.predict(v)[0], weight.steady_state(v) + 60, rtol=0.01)


@pytest.mark.parametrize("count", [2, pytest.param(6, marks=pytest.mark.long(6))])
def test_a_plant_that_holds_the_viscous_friction_raises_no_alarm(count: int) -> None:
    """A of a response is drive and guideway together: sigma is 0, and only a damping beyond the strokes' is wrong."""
    plant = Plant(A=20.0, B=3.0, T_d=0.6e-3, K_f=210.0)
    quiet, loud = 0, 0
    for seed in range(count):
        rng = np.random.default_rng([seed, 8])
        friction = replace(TABLE_1, sigma=plant.damping)
        logs = [stroke(v, rng, friction=friction) for v in both_directions(SLOW)]
        quiet += "damping-too-large" in codes(identify_static(logs, Asked(plant=plant)))
        loud += codes(identify_static(logs, Asked(plant=replace(plant, A=30.0)))).get("damping-too-large") == "wrong"
    assert quiet == 0
    assert loud == count


def test_directions_that_differ_are_told_and_a_stated_load_parts_them_from_an_offset() -> None:
    rng = np.random.default_rng(9)
    forth, back = StaticMap(80.0, 115.0, 1.8e-3, 1.0, 120.0), StaticMap(68.0, 98.0, 1.8e-3, 1.0, 157.0)
    logs = [stroke(v, rng, friction=forth if v > 0 else back) for v in both_directions(SLOW)]
    assert codes(identify_static(logs, Asked(direction="both")))["directions-differ"] == "wrong"
    assert identify_static(logs, Asked()).negative is not None  # each has its own map where that predicts better
    assert codes(identify_static(logs, Asked(direction="each")))["offset-shared"] == "wrong"
    fit = identify_static(logs, Asked(direction="each", load=0.0))
    assert fit.static is not None
    assert fit.negative is not None
    assert "wrong" not in codes(fit).values()
    for one, truth in ((fit.static, forth), (fit.negative, back)):
        assert one.estimates["offset"].fixed
        for name in ("F_c", "F_s", "sigma"):
            low, high = one.estimates[name].ci95  # type: ignore[misc]
            slack = 0.02 * (high - low)  # type: ignore[operator]
            assert low - slack <= getattr(truth, name) <= high + slack  # type: ignore[operator]


@pytest.mark.parametrize("draws", [4, pytest.param(12, marks=pytest.mark.long(10))])
def test_directions_that_are_alike_raise_no_alarm(draws: int) -> None:
    """One in two hundred may be told to differ; more than this are in one of a thousand such tests."""
    told = 0
    for seed in range(draws):
        rng = np.random.default_rng([seed, 10])
        fit = identify_static([stroke(v, rng) for v in both_directions(SLOW)], Asked())
        told += "directions-differ" in codes(fit) or fit.negative is not None
    assert told <= most(draws, 0.005)


def test_the_error_of_the_plant_s_damping_is_in_the_intervals() -> None:
    """A damping that is off by its own error leaves F_c and sigma in intervals that know of it."""
    plant = Plant(A=20.0, B=3.0, T_d=0.6e-3, K_f=210.0)
    off = replace(plant, A=19.6)
    rng = np.random.default_rng(11)
    friction = replace(TABLE_1, sigma=100.0 + plant.damping)
    logs = [stroke(v, rng, friction=friction, noise=0.003) for v in both_directions(SLOW)]
    blind, knowing = (identify_static(logs, Asked(plant=off, damping_error=e)) for e in (0.0, 0.5 * plant.M))
    assert limits(blind, "sigma")[0] > 100.0
    low, high = limits(knowing, "sigma")
    assert low < 100.0 < high
    for name in ("F_c", "F_s", "v_s"):
        assert np.ptp(limits(knowing, name)) >= np.ptp(limits(blind, name))
