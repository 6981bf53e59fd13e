"""A map for each direction: carried through replay, identification, feedforward, circle and validation."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fric
from fric.control.feedforward import friction_feedforward
from fric.control.scheme import choose_schemes
from fric.documents.friction import FrictionDocument
from fric.friction import models
from fric.friction.directed import Directed, mean_map
from fric.friction.stribeck import StaticMap
from fric.identify.gms.identify import identify_gms
from fric.log import Log
from fric.reference import sine
from fric.simulate.contour_run import Circle, run_circle
from tests.identify.presliding import APART, PAPER

BACK = replace(PAPER, F_c=126.0, F_s=198.0, sigma=60.0)
BOTH = Directed(APART, BACK)


def swing(amplitude, frequency=0.1, cycles=5, dt=4e-3):
    t = np.arange(0.0, (cycles + 0.3) / frequency, dt)
    return t, amplitude * np.sin(2 * np.pi * frequency * t)


def test_each_direction_settles_on_its_own_map():
    for model in models().values():
        typical = model.typical()
        if not hasattr(typical, "static") and not isinstance(typical, StaticMap):
            continue
        both = Directed(typical, BACK)
        for speed, static in ((2e-3, getattr(typical, "static", typical)), (-2e-3, BACK)):
            t = np.linspace(0.0, 10.0, 20_001)
            assert both.replay(t, speed * t)[-1] == pytest.approx(float(static.steady_state(speed)), rel=2e-3)


def test_with_one_map_twice_it_is_the_model():
    t, z = swing(100e-6)
    for model in (APART, models()["lugre"].typical(), models()["leuven"].typical()):
        np.testing.assert_array_equal(Directed(model, model.static).replay(t, z), model.replay(t, z))


def test_a_friction_file_with_two_maps_gives_every_model_both_of_them():
    given = {
        name: {p.name: {"value": getattr(static, p.name), "unit": unit} for p, unit in
               zip(StaticMap.parameters, ("N", "N", "m/s", "1", "N*s/m"), strict=True)}
        for name, static in (("static", PAPER), ("static_negative", BACK))
    }  # fmt: skip
    gms = {"alpha": {"value": APART.alpha, "unit": "1"}, "k": {"value": APART.k, "unit": "N/m"},
           "C": {"value": APART.C, "unit": "N/s"}}  # fmt: skip
    document = FrictionDocument.model_validate({"fric": "friction/1", "axis": "x", **given, "gms": gms})
    found = document.friction("gms")
    assert found.negative == BACK
    assert found.model.static == PAPER
    assert found.model.alpha == pytest.approx(APART.alpha)
    static = document.friction("static")
    assert static.steady_state(-1.0) == BACK.steady_state(-1.0)
    fed = friction_feedforward(static, sine(1e-3, 1.0, 2, 1000.0), 500.0)
    fed = fed[len(fed) // 2 :]
    assert fed.min() < -1.15 * np.quantile(fed, 0.99)


def test_identify_gms_finds_the_blocks_behind_two_maps():
    """With the mean of the two maps, half of what the directions differ by would be taken for an offset."""
    rng = np.random.default_rng(3)
    logs = []
    for amplitude in (15e-6, 450e-6):
        t, z = swing(amplitude)
        force = BOTH.replay(t, z) + 12.0 + rng.standard_normal(len(t))
        logs.append(Log(t, position=z, force=force, kind="presliding-sine", name=f"{amplitude * 1e6:g} um"))
    fit = identify_gms(logs, static=PAPER, negative=BACK)
    assert fit.rmse == pytest.approx(1.0, rel=0.1)
    assert len(fit.blocks) == 4
    assert fit.alpha.value == pytest.approx(APART.alpha, abs=0.01)
    assert fit.k.value[:3] == pytest.approx(APART.k[:3], rel=0.05)
    assert fit.curve.level == pytest.approx(mean_map(PAPER, BACK).F_s, rel=0.01)
    two, one = Directed(fit.model, BACK), replace(fit.model, static=mean_map(PAPER, BACK))
    two = replace(two, model=replace(fit.model, static=PAPER))
    offsets = [
        [r.record.record_part(r.record.force - r.record.replay(model))[0] for r in fit.records] for model in (two, one)
    ]
    assert offsets[0] == pytest.approx([12.0, 12.0], abs=0.3)
    assert offsets[1][1] == pytest.approx(12.0 - 16.5, abs=1.5)


def test_a_circle_feels_the_direction():
    machine = fric.read_machine(Path(__file__).parents[2] / "configs/xy-table.yaml")
    axis = machine.axes["x"]
    circle = Circle(radius=10e-3, feed=50e-3)

    def quadrants(friction):
        with_it = replace(machine, axes={**machine.axes, "x": replace(axis, friction=friction)})
        return np.abs(run_circle(with_it, choose_schemes("a")[0], circle).circularity.quadrants)

    one, two = quadrants(axis.friction), quadrants(Directed(axis.friction, BACK))
    known = np.isfinite(one)
    assert (two[known] > 1.02 * one[known]).any()
