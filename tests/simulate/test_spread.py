from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest, loguniform, norm, uniform

from fric.documents.machine_files import read_machine
from fric.errors import FricError
from fric.estimate import Covariance
from fric.friction import models
from fric.friction.directed import Directed
from fric.friction.rolling import Rolling
from fric.friction.stribeck import StaticMap
from fric.identify.static_map.map_fit import fit_map
from fric.identify.static_map.points import Asked, SpeedPoint, Strokes
from fric.simulate.machine import Machine
from fric.simulate.spread import (
    DEFAULT_SPREADS,
    Spread,
    check_spreads,
    draw_machine,
    draw_within,
    known_spreads,
    normals,
)

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
        assert (axis.nominal_friction, axis.observer, axis.cascade) == (
            before.nominal_friction,
            before.observer,
            before.cascade,
        )


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
            typical = Directed(typical, replace(typical.static, F_c=80.0))
        machine = Machine("", {"x": replace(ONE.axes["x"], friction=typical)})
        drawn = draw_machine(machine, 0, spreads={"level": Spread(1.5, 1.5)})[0].axes["x"].friction
        v = np.array([-0.5, -1e-4, 1e-4, 0.5])
        forward = getattr(typical, "model", typical)
        viscous = getattr(getattr(forward, "static", forward), "sigma") * v  # noqa: B009
        np.testing.assert_allclose(drawn.steady_state(v) - viscous, 1.5 * (typical.steady_state(v) - viscous))
    gms = draw_machine(ONE, 0, spreads={"stiffness": Spread(2, 2)})[0].axes["x"].friction
    before = ONE.axes["x"].friction
    np.testing.assert_allclose(gms.virgin_curve(1e-7), 2 * before.virgin_curve(1e-7))  # all blocks stick
    np.testing.assert_allclose(gms.virgin_curve(1e-3), before.virgin_curve(1e-3))  # all slip


@given(
    st.floats(0.1, 10), st.floats(1.001, 3), st.floats(1.001, 3), st.sampled_from([0.0, float("-inf")])
)  # fmt: skip
def test_half_of_the_draws_lie_to_either_side_and_the_limits_are_quantiles(value, below, above, lower):
    low, high = value / below, value * above
    assert draw_within(value, (low, high), lower, 0.0) == pytest.approx(value)
    assert draw_within(value, (low, high), lower, norm.ppf(0.025)) == pytest.approx(low)
    assert draw_within(value, (low, high), lower, norm.ppf(0.975)) == pytest.approx(high)


def test_draws_from_intervals_have_them_as_quantiles_and_respect_bounds():
    generator = np.random.default_rng(0)
    skew = np.array([draw_within(10.0, (9.0, 14.0), 0.0, z) for z in generator.standard_normal(4000)])
    assert np.quantile(skew, [0.025, 0.5, 0.975]) == pytest.approx([9.0, 10.0, 14.0], rel=0.02)
    through_zero = np.array([draw_within(1.0, (-1.0, 3.0), 0.0, z) for z in generator.standard_normal(2000)])
    assert through_zero.min() == 0.0
    assert np.mean(through_zero == 0.0) == pytest.approx(norm.cdf(-0.98), abs=0.03)


def test_a_block_whose_interval_holds_zero_is_drawn_in_every_machine():
    """A stiffness of 0 was drawn, which no model takes: the scheme "could not run on 1 of 24 machines"."""
    machine = read_machine(Path("configs/xy-table.yaml"))
    last = machine.axes["x"].friction.k[-1]
    intervals = {"x": {f"k_{len(machine.axes['x'].friction.k)}": (0.0, 20.0 * last)}}
    drawn = [draw_machine(machine, n, intervals=intervals)[0].axes["x"].friction.k[-1] for n in range(40)]
    assert min(drawn) > 0.0
    assert max(drawn) > 5.0 * last


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


@pytest.mark.parametrize("exchanged", [False, True])
def test_gains_are_drawn_along_what_a_slow_log_shows_of_them(exchanged):
    """Every machine had the gains of the file, whatever the interval of K_p: 60 to 110 were 83.7 V·s/m."""
    gains = ONE.axes["x"].cascade
    other = replace(gains, K_v=gains.K_i / gains.K_p, K_i=gains.K_p * gains.K_v)  # they sum and multiply to the same
    gains = other if exchanged else gains
    one = replace(ONE, axes={"x": replace(ONE.axes["x"], cascade=gains)})
    total, product = gains.K_p * gains.K_v + gains.K_i, gains.K_v * gains.K_i
    most = total**2 / 4.0 / product  # beyond it no cascade has both

    def drawn(limits):
        known = {"x": {"K_p": limits} if limits else {"F_c": (104.0, 106.0)}}
        return [draw_machine(one, n, spreads={}, intervals=known)[0].axes["x"].cascade for n in range(60)]

    within = drawn((60.0, 110.0))
    assert max(one.K_p for one in within) < most
    assert np.ptp([one.K_p for one in within]) > 30.0
    for found in within:
        assert found.K_p * found.K_v + found.K_i == pytest.approx(total, rel=1e-9)
        assert found.K_v * found.K_i == pytest.approx(product, rel=1e-9)
    beyond = [one for one in drawn((60.0, 300.0)) if one.K_p > most]
    assert beyond
    assert min(min(one.K_v, one.K_i) for one in beyond) > 0.0
    assert {(one.K_v, one.K_p, one.K_i) for one in drawn(None)} == {(gains.K_v, gains.K_p, gains.K_i)}
    for found in drawn((gains.K_p, gains.K_p)):
        assert (found.K_v, found.K_i) == pytest.approx((gains.K_v, gains.K_i), rel=1e-9)


@pytest.mark.parametrize("limits", [(0.0, 1.0), (1.3, 0.7), (-1.0, 1.0), (1.0, float("inf")), (1e-9, 1e19)])
def test_factors_are_positive_and_in_order(limits):
    with pytest.raises(FricError, match=r"of the spread is|falls"):
        Spread(*limits)


def test_names_that_nothing_has_are_told():
    check_spreads(dict.fromkeys(known_spreads(), Spread(1, 1)))
    with pytest.raises(FricError, match="'F_d' is nothing that can be spread"):
        check_spreads({"F_d": Spread(0.7, 1.3)})


def test_what_was_identified_together_is_drawn_together():
    """Of a map that was fitted to strokes the force at their speeds is sure, whatever single parameters are not."""
    rng = np.random.default_rng(5)
    true = StaticMap(F_c=60.0, F_s=90.0, v_s=2e-3, sigma=120.0)
    v = np.concatenate([-np.geomspace(5e-4, 0.03, 14), np.geomspace(5e-4, 0.03, 14)])
    force = true.steady_state(v) + rng.normal(0.0, 1.0, len(v))
    points = [SpeedPoint(a, b, 1.0, 200, "log", 0.0, 1.0, True) for a, b in zip(v, force, strict=True)]
    fit = fit_map(Strokes.at(points, Asked(delta=1.0)))
    limits = {name: estimate.ci95 for name, estimate in fit.estimates.items() if estimate.ci95 is not None}
    machine = replace(ONE, axes={"x": replace(ONE.axes["x"], friction=StaticMap(**{
        name: float(fit.estimates[name]) for name in ("F_c", "F_s", "v_s", "delta", "sigma")}))})  # fmt: skip
    block, C = fit.covariance, np.array(fit.covariance.matrix)
    speed = np.array([1.5e-3, 6e-3, 0.02])

    def drawn(covariances):
        found = [draw_machine(machine, n, seed=2, spreads={}, intervals={"x": limits}, covariances=covariances)
                 for n in range(600)]  # fmt: skip
        forces = [one.axes["x"].friction.steady_state(speed) for one, _ in found]
        return np.std(forces, axis=0), {name: np.array([d[f"x.{name}"] for _, d in found]) for name in limits}

    together, values = drawn({"x": (block,)})
    alone, _ = drawn({})
    J = fit.problem.jacobian(fit.solution.theta, speed)[:, :4]
    told = np.sqrt(np.einsum("ij,jk,ik->i", J, C[:4, :4], J))
    assert together == pytest.approx(told, rel=0.25)
    assert np.all(alone[1:] > 1.8 * told[1:])
    size = np.sqrt(np.diag(C))
    expected = (C / np.outer(size, size))[0, 3]
    assert expected < -0.7
    assert np.corrcoef(values["F_c"], values["sigma"])[0, 1] == pytest.approx(expected, abs=0.08)
    for name, (low, high) in limits.items():
        assert np.quantile(values[name], [0.025, 0.975]) == pytest.approx([low, high], abs=0.12 * (high - low))


def test_correlated_draws_do_not_depend_on_the_order_of_names_or_on_what_is_not_drawn():
    matrix = np.array([[4.0, -1.5, 0.2], [-1.5, 1.0, 0.1], [0.2, 0.1, 9.0]])
    block = Covariance.of("abc", matrix, "linear")
    turned = Covariance.of("cab", matrix[np.ix_([2, 0, 1], [2, 0, 1])], "linear")
    normal = {"a": 0.3, "b": -1.2, "c": 0.7}.__getitem__
    assert normals([block], "abc", normal) == pytest.approx(normals([turned], "abc", normal))
    assert set(normals([block], "ab", normal)) == {"a", "b"}
    assert normals([block], "a", normal) == pytest.approx({"a": 0.3})
    singular = Covariance.of("ab", [[1.0, 1.0], [1.0, 1.0]], "linear")
    found = normals([singular], "ab", normal)
    assert found["a"] == pytest.approx(found["b"])
