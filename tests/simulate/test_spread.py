from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest, loguniform, norm, uniform

from fric.documents.machine_files import read_machine
from fric.errors import FricError
from fric.friction import models
from fric.friction.rolling import Rolling
from fric.simulate.intervals import draw_within
from fric.simulate.machine import Machine
from fric.simulate.spread import DEFAULT_SPREADS, Spread, check_spreads, draw_machine, known_spreads

MACHINE = read_machine(Path("configs/xy-table.yaml"))
ONE = replace(MACHINE, axes={"x": MACHINE.axes["x"]})


def factors(name: str, spread: Spread, machines: int = 400) -> np.ndarray:
    return np.array([draw_machine(ONE, i, seed=1, spreads={name: spread})[1][f"x.{name}"] for i in range(machines)])


@pytest.mark.parametrize(
    ("spread", "law"),
    [
        (Spread(0.7, 1.3), uniform(0.7, 0.6)),
        (Spread(0.3, 2.0, "log-uniform"), loguniform(0.3, 2.0)),
        (Spread(0.8, 1.2, "normal"), norm(1.0, 0.2 / 1.96)),
    ],
)
def test_factors_follow_their_distribution(spread, law):
    assert kstest(factors("level", spread), law.cdf).pvalue > 0.01


def test_the_limits_of_a_log_normal_factor_are_its_95_percent_interval():
    found = np.log(factors("stiffness", Spread(0.25, 4.0, "log-normal")))
    assert kstest(found, norm(0.0, np.log(4.0) / 1.96).cdf).pvalue > 0.01
    assert min(factors("level", Spread(0.01, 1.99, "normal"))) > 0  # 2.4 % would be below zero, and are drawn again


def test_axes_machines_and_parameters_are_independent():
    drawn = [draw_machine(MACHINE, i)[1] for i in range(400)]
    names = sorted(drawn[0])
    assert names == sorted(f"{axis}.{name}" for axis in "xy" for name in DEFAULT_SPREADS)
    table = np.array([[one[name] for name in names] for one in drawn])
    correlation = np.corrcoef(table.T) - np.eye(len(names))
    assert np.abs(correlation).max() < 4 / np.sqrt(400)
    serial = [np.corrcoef(column[1:], column[:-1])[0, 1] for column in table.T]
    assert np.abs(serial).max() < 4 / np.sqrt(400)


def test_a_machine_is_the_same_whatever_else_is_drawn():
    several = {"level": DEFAULT_SPREADS["level"], "M": Spread(0.9, 1.1)}
    for i in (0, 7):
        alone = draw_machine(MACHINE, i, seed=3, spreads={"level": DEFAULT_SPREADS["level"]})[1]
        beside = draw_machine(MACHINE, i, seed=3, spreads=several)[1]
        assert alone == {name: value for name, value in beside.items() if name.endswith("level")}
    assert draw_machine(MACHINE, 0, seed=3)[1] != draw_machine(MACHINE, 0, seed=4)[1]
    assert draw_machine(MACHINE, 0) == draw_machine(MACHINE, 0)


def test_a_child_seed_is_that_of_numpy_s_spawn():
    first, second = np.random.SeedSequence(5).spawn(2)
    assert second.generate_state(2).tolist() == np.random.SeedSequence(5, spawn_key=(1,)).generate_state(2).tolist()
    assert first.generate_state(2).tolist() != second.generate_state(2).tolist()


def test_what_is_drawn_is_true_and_what_is_believed_stays():
    drawn, _ = draw_machine(MACHINE, 0)
    for name, axis in drawn.axes.items():
        before = MACHINE.axes[name]
        assert axis.plant != before.plant
        assert axis.friction != before.friction
        assert axis.nominal == before.plant
        assert (axis.believed, axis.observer, axis.cascade) == (before.believed, before.observer, before.cascade)


def test_the_force_constant_moves_the_same_mass_and_the_mass_leaves_the_force():
    plant = MACHINE.axes["x"].plant
    motor = draw_machine(ONE, 0, spreads={"K_f": Spread(1.1, 1.1)})[0].axes["x"].plant
    assert motor.K_f == pytest.approx(1.1 * plant.K_f)
    assert (motor.M, motor.damping) == pytest.approx((plant.M, plant.damping))
    table = draw_machine(ONE, 0, spreads={"M": Spread(2, 2)})[0].axes["x"].plant
    assert (table.M, table.damping, table.K_f) == pytest.approx((2 * plant.M, plant.damping, plant.K_f))


def test_level_and_stiffness_reach_every_model_and_both_directions():
    for model in models().values():
        typical = model.typical()
        if isinstance(typical, Rolling):
            typical = replace(typical, negative=replace(typical.static, F_c=80.0))
        machine = Machine("", {"x": replace(ONE.axes["x"], friction=typical)})
        drawn = draw_machine(machine, 0, spreads={"level": Spread(1.5, 1.5)})[0].axes["x"].friction
        v = np.array([-0.5, -1e-4, 1e-4, 0.5])
        viscous = getattr(getattr(typical, "static", typical), "sigma") * v  # noqa: B009
        np.testing.assert_allclose(drawn.steady_state(v) - viscous, 1.5 * (typical.steady_state(v) - viscous))
    gms = draw_machine(ONE, 0, spreads={"stiffness": Spread(2, 2)})[0].axes["x"].friction
    before = ONE.axes["x"].friction
    np.testing.assert_allclose(gms.virgin_curve(1e-7), 2 * before.virgin_curve(1e-7))  # all blocks stick
    np.testing.assert_allclose(gms.virgin_curve(1e-3), before.virgin_curve(1e-3))  # all slip


@given(
    st.floats(0.1, 10), st.floats(1.001, 3), st.floats(1.001, 3), st.sampled_from([0.0, float("-inf")])
)  # fmt: skip
def test_half_of_the_draws_lie_to_either_side_and_the_limits_are_quantiles(value, below, above, lower):
    class At:
        def __init__(self, z):
            self.z = z

        def standard_normal(self):
            return self.z

    low, high = value / below, value * above
    assert draw_within(value, (low, high), lower, At(0.0)) == pytest.approx(value)
    assert draw_within(value, (low, high), lower, At(norm.ppf(0.025))) == pytest.approx(low)
    assert draw_within(value, (low, high), lower, At(norm.ppf(0.975))) == pytest.approx(high)


def test_draws_from_intervals_have_them_as_quantiles_and_respect_bounds():
    generator = np.random.default_rng(0)
    skew = np.array([draw_within(10.0, (9.0, 14.0), 0.0, generator) for _ in range(4000)])
    assert np.quantile(skew, [0.025, 0.5, 0.975]) == pytest.approx([9.0, 10.0, 14.0], rel=0.02)
    through_zero = np.array([draw_within(1.0, (-1.0, 3.0), 0.0, generator) for _ in range(2000)])
    assert through_zero.min() == 0.0
    assert np.mean(through_zero == 0.0) == pytest.approx(norm.cdf(-0.98), abs=0.03)


def test_intervals_replace_spreads_and_shares_of_blocks_sum_to_one():
    gms = ONE.axes["x"].friction
    intervals = {"x": {"F_c": (100.0, 110.0), "F_s": (100.0, 230.0), "B": (4.4, 4.6), "k_2": (1e6, 2e6)}}
    intervals["x"] |= {f"alpha_{n}": (0.8 * a, 1.2 * a) for n, a in enumerate(gms.alpha, 1)}
    found = [draw_machine(ONE, i, intervals=intervals) for i in range(300)]
    for machine, drawn in found:
        axis = machine.axes["x"]
        assert axis.friction.static.F_c == drawn["x.F_c"]
        assert axis.friction.static.F_s >= axis.friction.static.F_c
        assert sum(axis.friction.alpha) == pytest.approx(1.0, abs=1e-12)
        assert axis.friction.k[1] == drawn["x.k_2"]
        assert axis.friction.k[0] == pytest.approx(gms.k[0] * drawn["x.stiffness"])
        assert drawn["x.B"] == axis.plant.B  # as identified, whatever the force constant is
        assert axis.plant.K_f == pytest.approx(548 * drawn["x.K_f"])
        assert "x.level" not in drawn
    F_c = [drawn["x.F_c"] for _, drawn in found]
    assert np.quantile(F_c, [0.025, 0.975]) == pytest.approx([100, 110], abs=2)


@pytest.mark.parametrize("limits", [(0.0, 1.0), (1.3, 0.7), (-1.0, 1.0), (1.0, float("inf"))])
def test_factors_are_positive_and_in_order(limits):
    with pytest.raises(FricError, match="is no spread"):
        Spread(*limits)


def test_names_that_nothing_has_are_told():
    check_spreads(dict.fromkeys(known_spreads(), Spread(1, 1)))
    with pytest.raises(FricError, match="'F_d' is nothing that can be spread"):
        check_spreads({"F_d": Spread(0.7, 1.3)})
