"""Tuning from recorded circles: the truth is found, logs may be poor, and what is no better is refused."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fric
from fric.circles.measured import AxisTrace, MeasuredCircle, measured_from_run
from fric.circles.tune import (
    CircleForecast,
    better_ahead,
    cautious,
    law_warnings,
    loop_warnings,
    measured_glitch,
    next_circles,
    tune,
    tune_axis,
    worse_ahead,
)
from fric.circles.tune_fit import (
    Balance,
    BalanceCoordinates,
    at,
    fit,
    groups_alike,
    instrumented,
    refined,
    timing_warnings,
    tuned_estimates,
    voltage_record,
)
from fric.control.scheme import PAPER_SCHEMES
from fric.documents.circle_findings import write_tuned
from fric.documents.machine_files import read_machine
from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction.directed import Completed, travels
from fric.simulate.contour_run import Chance, Circle, run_circle
from fric.simulate.spread import draw_machine

ROOT = Path(__file__).parents[2]
F = PAPER_SCHEMES["f"]


@pytest.fixture(scope="module")
def drawn():
    return draw_machine(fric.read_machine(ROOT / "configs/xy-table.yaml"), 3)[0]


def recorded(machine, *tests: Circle):
    """Circles as a machine records them: each is one draw of what hangs on encoder counts."""
    tests = tests or (Circle(feed=0.1), Circle(feed=0.01))
    runs = (run_circle(machine, F, test, accuracy=1e-8, places=1) for test in tests)
    return [measured_from_run(run) for run in runs]


@pytest.fixture(scope="module")
def circles(drawn):
    return recorded(drawn, Circle(feed=0.1), Circle(feed=0.01, revolutions=1))


@pytest.fixture(scope="module")
def tuned(drawn, circles):
    return tune(drawn, circles)


def glitches(machine, **changed):
    return run_circle(machine, F, Circle(**changed), accuracy=1e-8).chance().median


def test_two_circles_leave_a_tenth_of_the_glitch(drawn, tuned):
    assert glitches(drawn) > 2e-6
    assert glitches(tuned.machine) < 0.5e-6
    assert glitches(tuned.machine, feed=0.01, revolutions=1) < 1.1e-6
    assert glitches(tuned.machine, feed=0.03) < 0.6e-6


@pytest.mark.long(20)
def test_the_axis_that_a_machine_has_is_tuned_from_circles_of_two(drawn, circles, tuned):
    """A machine of one axis and circles of two were refused."""
    alone = tune(replace(drawn, axes={"x": drawn.axes["x"]}), circles)
    assert list(alone.axes) == ["x"]
    assert alone.axes["x"].nominal.T_d == pytest.approx(tuned.axes["x"].nominal.T_d, rel=1e-6)
    assert all(circle.glitch < 1e-6 for circle in alone.predicted)


def test_what_is_found_is_what_the_machine_has(drawn, tuned):
    for name, one in tuned.axes.items():
        true, scale = drawn.axes[name], one.nominal.K_f / drawn.axes[name].plant.K_f
        assert pytest.approx(true.plant.B, rel=0.01) == one.nominal.B
        assert pytest.approx(true.plant.A, rel=0.01) == one.nominal.A
        assert one.nominal.T_d == pytest.approx(true.plant.T_d, rel=0.25)
        assert float(one.estimates.static["F_c"]) == pytest.approx(scale * true.friction.static.F_c, rel=2e-3)
        assert one.estimates.gms["k"].value[0] == pytest.approx(scale * true.friction.k[0], rel=0.15)
        assert one.improves
        assert one.after.rms < 0.1 * one.before.rms


@pytest.mark.long(9)
def test_how_sure_a_parameter_is_does_not_hang_on_what_was_kept_of_the_shape(drawn, monkeypatch):
    axis, tests = drawn.axes["x"], recorded(drawn)
    kept = tune_axis(axis, tests)
    monkeypatch.setattr("fric.circles.tune_fit.SHAPE", 0.0)
    whole = tune_axis(axis, tests)
    assert whole.full
    assert not kept.full
    for key in ("F_c", "F_s", "v_s", "delta"):
        (low, high), (below, above) = (one.estimates.static[key].ci95 for one in (kept, whole))
        true = getattr(axis.friction.static, key) * (kept.nominal.K_f / axis.plant.K_f if key[0] == "F" else 1.0)
        assert low <= true <= high
        assert below <= true <= above
        assert 0.5 < np.log(high / low) / np.log(above / below) < 2.0  # 1.67 of F_c, both within 0.02 %


def test_the_prediction_holds_the_next_circle(tuned):
    for ahead in tuned.predicted:
        seen = run_circle(tuned.machine, PAPER_SCHEMES[ahead.scheme], Circle(feed=ahead.feed), accuracy=1e-8)
        low, high = ahead.ci95
        assert low <= seen.chance().median <= high


def test_what_a_model_leaves_over_at_the_reversals_is_met_again(circles, tuned):
    """A force over the travel since the reversal that no parameter explains: told, and within the interval."""
    grid = travels(0.06)
    bump = 0.04 * np.exp(-2 * np.log(grid / 20e-6) ** 2)  # of the level, around 20 µm
    axes, true = {}, {}
    for name, one in tuned.axes.items():
        force = bump * float(one.estimates.static["F_s"])
        whole, record = Completed(one.friction, tuple(force), tuple(-force)), one.after.balance.records[0]
        parts = one.after.parts()
        parts[0] = parts[0] + (record.friction(whole) - record.friction(one.friction)) / one.nominal.K_f
        axes[name] = replace(one, after=replace(one.after, residual=np.concatenate(parts)))
        true[name] = replace(one.axis, friction=whole, plant=one.nominal)
    told = next_circles(circles[:1], axes)
    machine = replace(tuned.machine, axes=true)
    for one in told:
        seen = run_circle(machine, PAPER_SCHEMES[one.scheme], Circle(), accuracy=1e-8).chance().median
        assert one.ci95[0] <= seen <= one.ci95[1]
        assert one.alone < 0.5 * seen
        assert one.glitch == pytest.approx(seen, rel=0.4)
    assert [warning.code for warning in law_warnings(told)] == ["law-differs"]
    assert not law_warnings(tuned.predicted)


def plain_friction(t: np.ndarray, r: np.ndarray, model, around: int) -> tuple[np.ndarray, np.ndarray]:
    """GMS around a reversal as differential equations, eqs. (3) and (4), by solve_ivp."""
    v = np.gradient(r, t)
    s, alpha, k = model.static, np.array(model.alpha), np.array(model.k)
    turn = np.flatnonzero(np.diff(np.sign(v)) != 0)[-3] + 1

    def level(now):
        return s.F_c + (s.F_s - s.F_c) * np.exp(-((abs(np.interp(now, t, v)) / s.v_s) ** s.delta))

    samples = np.arange(turn - around, turn + around)
    direction = np.sign(v[samples[0]])
    loads, slips, forces = direction * alpha * level(t[samples[0]]), np.ones(len(k), bool), []
    fine = np.interp(np.arange(0, len(samples) - 1 + 1e-9, 0.2), np.arange(len(samples)), t[samples])
    for a, b in pairwise(fine):
        if np.sign(np.interp((a + b) / 2, t, v)) != direction:
            direction, slips = -direction, np.zeros(len(k), bool)

        def rate(now, load, slips=slips, direction=direction):
            speed = np.interp(now, t, v)
            slide = np.minimum(model.C * (alpha - direction * load / level(now)), k * abs(speed))
            return np.where(slips, direction * slide, k * speed)

        loads = solve_ivp(rate, (a, b), loads, rtol=1e-6, atol=1e-5).y[:, -1]
        slips = slips | (direction * loads >= alpha * level(b))
        forces.append(loads.sum() + s.sigma * np.interp(b, t, v))
    return samples[1:], np.array(forces)[4::5]


def test_the_replay_agrees_with_friction_that_is_solved_as_a_differential_equation(drawn, circles):
    trace, model = circles[0].axes["x"], drawn.axes["x"].friction
    samples, forces = plain_friction(trace.time, trace.reference, model, 160)
    replayed = model.replay(trace.time, trace.reference, np.gradient(trace.reference, trace.time))[samples]
    # a block that breaks away within a sample does so at its end in the plain solution: k·|v|·T_s too far at most
    assert np.abs(replayed - forces).max() < 0.03 * np.abs(forces).max()
    assert np.abs(replayed - forces)[-60:].max() < 0.003 * np.abs(forces).max()


def test_with_the_truth_nothing_is_left(drawn, circles):
    axis = drawn.axes["x"]
    records = tuple(voltage_record(test, "x") for test in circles)
    truth = BalanceCoordinates.of(axis.friction, axis.plant.T_d)
    plant = np.array([1 / axis.plant.B, axis.plant.A / axis.plant.B])
    left = at(Balance(records, truth, axis.plant.K_f), np.zeros(4), plant)
    assert left.rms < 5e-3
    wrong = at(Balance(records, truth, axis.plant.K_f), np.array([0.2, 0.0, 0.0, 0.0]), plant)
    assert wrong.rms > 4 * left.rms


def poor(test: MeasuredCircle, rng: np.random.Generator) -> MeasuredCircle:
    """A log at 1 kHz with steps of 5 mV, noise of 20 mV and an encoder that ripples by 0.1 µm."""
    axes = {}
    for name, trace in test.axes.items():
        few = trace.part(slice(0, None, 4))
        ripple = 0.1e-6 * np.sin(2 * np.pi * few.position / 20e-6)
        noisy = few.input + rng.normal(0, 0.02, len(few.input))
        axes[name] = AxisTrace(few.time, few.position + ripple, few.reference, np.round(noisy / 5e-3) * 5e-3)
    return replace(test, axes=axes)


@pytest.mark.long(7)
def test_a_poor_log_serves_too(drawn, circles):
    rng = np.random.default_rng(0)
    found = tune(drawn, [poor(test, rng) for test in circles])
    assert glitches(found.machine) < 0.6e-6
    assert glitches(found.machine, feed=0.01) < 1.5e-6


def late(test):
    axes = {
        name: replace(trace, position=np.interp(trace.time - 0.5e-3, trace.time, trace.position))
        for name, trace in test.axes.items()
    }
    return replace(test, axes=axes)


@pytest.mark.long(3)
def test_a_position_that_is_late_is_told(drawn, circles):
    axis = drawn.axes["x"]
    found = tune_axis(axis, [late(test) for test in circles])
    assert "position-late" in {warning.code for warning in found.warnings}
    low, high = found.estimates.plant["T_d"].ci95
    assert low <= axis.plant.T_d + 0.5e-3 <= high


@pytest.mark.long(40)
def test_a_position_that_is_late_is_told_by_most_poor_logs(drawn, circles):
    """Of eight seeds."""
    axis, told, held = drawn.axes["x"], 0, 0
    for seed in range(8):
        rng = np.random.default_rng(seed)
        found = tune_axis(axis, [poor(late(test), rng) for test in circles])
        low, high = found.estimates.plant["T_d"].ci95
        told += "position-late" in {warning.code for warning in found.warnings}
        held += low <= axis.plant.T_d + 0.5e-3 <= high
    assert told >= 5
    assert held >= 7


@pytest.mark.long(25)
def test_friction_over_position_is_no_delay(tmp_path):
    """Of ten rigs on a circle of one feed; less than 8 of intervals of 95 % by a chance of 1e-3.

    When this was written 20 of 20 held the delay, of 14 nine where the interval was that of the residual alone.
    """
    text, rng, held = Path("configs/virtual-rig.yaml").read_text(), np.random.default_rng(3), 0
    waves = re.search(r" +rolling:\n(?: +\w+: \{.*\n){3}", text)[0]
    (tmp_path / "even.yaml").write_text(text.replace(waves, ""))
    even = read_machine(tmp_path / "even.yaml").axes["x"]
    for _ in range(10):
        moved = re.sub(r"phase: \{value: \[[^]]*\]", f"phase: {{value: {rng.uniform(-3.1, 3.1, 3).tolist()}", text)
        (tmp_path / "rig.yaml").write_text(moved)
        run = run_circle(read_machine(tmp_path / "rig.yaml"), PAPER_SCHEMES["a"], Circle(0.03, 0.1, 2), only="x")
        found = tune_axis(even, [measured_from_run(run)])
        low, high = found.estimates.plant["T_d"].ci95
        held += low <= even.plant.T_d <= high
    assert held >= 8


@pytest.mark.parametrize(
    ("interval", "codes"),
    [
        ((0.7, 1.3), ["position-late"]),
        ((0.6, 1.4), []),
        ((0.66, 0.9), []),
        ((0.3, 0.6), ["position-early"]),
        ((0.2, 0.7), []),
    ],
)
def test_a_shift_is_told_only_where_the_interval_of_the_delay_says_so_too(drawn, circles, interval, codes):
    axis = drawn.axes["x"]
    records = (voltage_record(circles[0], "x"),)
    found = at(Balance(records, BalanceCoordinates.of(axis.friction, 0.65e-3), axis.plant.K_f), np.zeros(4))
    low, high = (limit * 1e-3 for limit in interval)
    told = timing_warnings(axis, found, Estimate((low + high) / 2, "s", (low, high)))
    assert [one.code for one in told] == codes


@pytest.mark.parametrize(("which", "word"), [(0, "v_s"), pytest.param(1, "T_d", marks=pytest.mark.long(4))])
def test_one_circle_says_what_it_cannot_tell(drawn, circles, which, word):
    (told,) = [w for w in tune_axis(drawn.axes["x"], [circles[which]]).warnings if w.code == "one-feed"]
    assert word in told


def test_what_is_no_better_is_refused(drawn, circles):
    # the truth is believed already, and the log is of another axis' voltage: noise
    rng = np.random.default_rng(1)
    axes = {name: replace(trace, input=rng.normal(0, 0.5, len(trace.time))) for name, trace in circles[0].axes.items()}
    found = tune(drawn, [replace(circles[0], axes=axes)])
    refused = [name for name, one in found.axes.items() if not one.improves]
    for name in refused:
        assert found.machine.axes[name] is drawn.axes[name]
    assert refused or glitches(found.machine) <= glitches(drawn)


def test_a_better_fit_that_is_no_machine_is_refused_for_that(drawn, circles, tuned, monkeypatch):
    """It was said to be worse: 2.5 mA were left, and 3.8 before."""
    found = iter([replace(axis, improves=False) for axis in tuned.axes.values()])
    monkeypatch.setattr("fric.circles.tune.tune_axis", lambda *_: next(found))
    again = tune(drawn, circles)
    assert all(axis.after.rms < axis.before.rms for axis in again.axes.values())
    codes = {warning.code for warning in again.warnings}
    assert "tuning-refused" in codes
    assert "tuning-no-better" not in codes


@pytest.mark.long(4)
def test_directions_with_own_levels_are_found(drawn):
    from fric.friction.directed import Directed

    axis = drawn.axes["x"]
    static = axis.friction.static
    other = replace(static, F_c=0.93 * static.F_c, F_s=0.93 * static.F_s)
    sided = replace(drawn, axes={**drawn.axes, "x": replace(axis, friction=Directed(axis.friction, other))})
    tests = recorded(sided)
    found = tune_axis(sided.axes["x"], tests)
    assert isinstance(found.friction, Directed)
    ratio = found.friction.negative.F_c / found.friction.model.static.F_c
    assert ratio == pytest.approx(0.93, abs=0.01)
    assert "direction" in {warning.code for warning in found.warnings}


@pytest.mark.long(5)
def test_friction_that_falls_while_a_circle_runs_is_told(tuned):
    machine = fric.read_machine(ROOT / "configs/reality/drift.yaml")
    tests = recorded(machine)
    found = tune(machine, tests)
    (told,) = [warning for warning in found.warnings if warning.code == "circle-drifts"]
    # -15 % with 60 s, of which the circle at 10 mm/s takes 38: 7 %
    assert (told.where, told.severity) == ("axis x", "doubt")
    assert told.values["change"] == pytest.approx(-0.07, abs=0.01)
    assert "circle-drifts" not in {warning.code for warning in tuned.warnings}
    # what is believed leaves 0.9 µm at 100 mm/s, and the mean over the circles would leave no less
    assert "tuning-refused" in {warning.code for warning in found.warnings}


@pytest.mark.long(60)
def test_instruments_take_off_what_counts_pull_the_delay_by():
    """By 12 machines, both axes of each: in the mean the delay is nearer the truth.

    It is 1.9 % shorter in the mean, and no longer on any of the 12.
    """
    table, pulled = fric.read_machine(ROOT / "configs/xy-table.yaml"), []
    for seed in range(12):
        machine = draw_machine(table, seed, seed=21)[0]
        seen, both = recorded(machine), []
        for name, axis in machine.axes.items():
            records = tuple(voltage_record(test, name) for test in seen)
            truth = BalanceCoordinates.of(axis.friction, axis.plant.T_d)
            K_f, plant = axis.plant.K_f, (1 / axis.plant.B, axis.plant.A / axis.plant.B, 0.0)
            finer = tuple(refined(one, axis.friction, axis.plant.T_d, plant, K_f) for one in records)
            found = fit(Balance(finer, truth, K_f), [np.zeros(4)])
            both.append([one.x[truth.names.index("T_d")] for one in (found, instrumented(instrumented(found)))])
        pulled.append(np.mean(both, axis=0))
    plain, moved = np.transpose(pulled)
    assert abs(moved.mean()) < abs(plain.mean())
    assert np.count_nonzero(moved <= plain) >= 10


@pytest.mark.long(2)
def test_intervals_hold_the_truth_of_blocks_that_slip_alike(drawn, circles):
    axis = drawn.axes["x"]
    full = BalanceCoordinates.of(axis.friction, axis.plant.T_d).full()
    records = tuple(voltage_record(test, "x") for test in circles)
    found = fit(Balance(records, full, axis.plant.K_f), [np.zeros(len(full.names))])
    assert [1, 2] in groups_alike(found)  # 27.5 and 25.9 µm
    m, a = found.plant[:2]
    plant = fric.Plant(A=float(a / m), B=float(1 / m), T_d=full.delay(found.x), K_f=axis.plant.K_f)
    estimates = tuned_estimates(found, plant, axis.motion)
    for key in ("alpha", "k"):
        for n, (low, high) in enumerate(estimates.gms[key].ci95):
            assert low <= getattr(axis.friction, key)[n] <= high
            assert (high > 2.0 * low) == (n in (1, 2))


def test_files_of_a_tuning_are_a_machine_again(drawn, tuned, tmp_path):
    files = write_tuned(tuned, ROOT / "configs/xy-table.yaml", tmp_path / "tuned")
    assert {path.name for path in files} == {"machine.yaml", "x.yaml", "x-plant.yaml", "y.yaml", "y-plant.yaml"}
    machine = fric.read_machine(tmp_path / "tuned" / "machine.yaml")
    for name, axis in machine.axes.items():
        new = tuned.machine.axes[name]
        assert axis.nominal_friction.lead == "auto"
        assert axis.nominal_friction.gain == 1.0
        assert axis.nominal.T_d == pytest.approx(new.nominal.T_d, rel=1e-4)
        assert pytest.approx(new.nominal.B, rel=1e-4) == axis.observer.B
        np.testing.assert_allclose(
            axis.nominal_friction.models["gms"].k, new.nominal_friction.models["gms"].k, rtol=1e-4
        )
    known = fric.read_identified(tmp_path / "tuned" / "machine.yaml")
    assert {"F_c", "k_1", "T_d", "B"} <= set(known.intervals["x"])
    with pytest.raises(FricError, match="exists"):
        write_tuned(tuned, ROOT / "configs/xy-table.yaml", tmp_path / "tuned")


@pytest.mark.long(20)
def test_a_loop_that_does_not_hold_falling_friction_is_designed_anew(tmp_path):
    machine = draw_machine(fric.read_machine(ROOT / "configs/xy-table.yaml"), 13)[0]
    tests = recorded(machine)
    held = tune(machine, tests, loop=True)
    assert [name for name, one in held.axes.items() if one.loop] == ["y"]
    one, own = held.axes["y"], machine.axes["y"]
    before = replace(one, axis=replace(one.axis, cascade=own.cascade, observer=own.observer), loop=False)
    assert [warning.code for warning in loop_warnings({"y": before})] == ["falling-friction"]
    # over places, exact knowledge leaves 0.90 ± 0.84 µm in the loop that is there, and the new one 1.22 ± 0.4 of a draw
    assert glitches(held.machine, feed=0.01) < 1.6e-6
    assert glitches(held.machine) < 0.5e-6
    write_tuned(held, ROOT / "configs/xy-table.yaml", tmp_path / "held")
    axis, made = fric.read_machine(tmp_path / "held" / "machine.yaml").axes["y"], held.machine.axes["y"]
    assert pytest.approx(made.cascade.K_p, rel=1e-4) == axis.cascade.K_p
    assert axis.observer.q.cutoff == pytest.approx(made.observer.q.cutoff)
    # in the loop that is there errors grow, furthest where the axis is ahead of its friction: less is fed forward
    shy = cautious(before)
    assert shy.axis.nominal_friction.gain < 1 == before.axis.nominal_friction.gain
    assert cautious(one) is one
    write_tuned(replace(held, axes={**held.axes, "y": shy}), ROOT / "configs/xy-table.yaml", tmp_path / "shy")
    read = fric.read_machine(tmp_path / "shy" / "machine.yaml")
    assert read.axes["y"].nominal_friction.gain == shy.axis.nominal_friction.gain
    assert read.axes["x"].nominal_friction.gain == 1


@pytest.mark.long(40)
def test_what_is_fed_less_leaves_less_where_a_loop_does_not_hold_falling_friction():
    """Over 48 circles with reversals elsewhere between two counts: of 32, 0.99 ± 0.05 µm whole and 0.80 ± 0.04 less."""
    machine = draw_machine(fric.read_machine(ROOT / "configs/xy-table.yaml"), 13)[0]
    tests = recorded(machine)
    held = tune(machine, tests, loop=True)
    one, own = held.axes["y"], machine.axes["y"]
    before = replace(one, axis=replace(one.axis, cascade=own.cascade, observer=own.observer), loop=False)
    subjects = (
        replace(held.machine, axes={**held.machine.axes, "y": what.axis}) for what in (before, cautious(before))
    )
    whole, less = (
        np.mean([one.glitch for one in run_circle(subject, F, Circle(feed=0.01), accuracy=1e-8, places=48).places])
        for subject in subjects
    )
    assert less < whole


def test_a_circle_is_worse_where_it_should_be_by_more_than_chance(circles, tuned):
    seen, count = measured_glitch(circles[1]), 0.25e-6

    def ahead(glitch):
        chance = Chance((glitch,) * 5)
        return [CircleForecast(0.01, 0.03, scheme, chance, (0.0, 2 * glitch), chance) for scheme in "cf"]

    def again(share):
        return lambda n: Chance(tuple(seen * (1 + share * np.linspace(-1, 1, 5))))

    assert seen > 2 * count
    assert not worse_ahead(circles, ahead(0.9 * seen), again(0.0), count)
    assert "recorded again" in worse_ahead(circles, ahead(1.1 * seen), again(0.0), count)
    assert not worse_ahead(circles, ahead(1.1 * seen), again(0.1), count)  # it may be so again
    assert not worse_ahead(circles, ahead(1.1 * seen), again(0.0), 1.2 * seen)  # below a count nothing is told apart
    assert worse_ahead(circles, ahead(0.9 * seen), again(0.0), count, doubtful=True)  # its upper end is what counts
    assert not worse_ahead(circles, tuned.predicted, again(0.0), count)
    assert better_ahead(circles, ahead(0.5 * seen), again(0.1))
    assert not better_ahead(circles, ahead(0.95 * seen), again(0.1))  # it may be so again


@pytest.mark.long(8)
def test_what_helps_one_feed_is_kept_where_the_other_would_be_worse(drawn, circles, tuned, monkeypatch):
    """Where the whole is said to make a circle worse, what matters to slow ones stays as it was believed."""
    said = iter(["the next circle may be worse"])
    monkeypatch.setattr(
        "fric.circles.tune.worse_ahead", lambda *told, **also: next(said, "") or worse_ahead(*told, **also)
    )
    found = tune(drawn, circles)
    assert {"tuned-in-part", "tuning-refused"} & {one.code for one in found.warnings} == {"tuned-in-part"}
    for name, axis in drawn.axes.items():
        kept, whole = (one.machine.axes[name].nominal_friction.models["gms"] for one in (found, tuned))
        believed = axis.nominal_friction.models["gms"]
        assert kept.static.F_c == pytest.approx(whole.static.F_c, rel=1e-3)
        assert kept.k[0] == pytest.approx(whole.k[0], rel=1e-3)
        of_level, before, after = (one.C / one.static.F_c for one in (kept, believed, whole))
        assert of_level == pytest.approx(before, rel=1e-4)
        assert of_level != pytest.approx(after, rel=0.05)
    assert glitches(found.machine) < 0.5 * glitches(drawn)


def test_a_ball_bar_does_not_tune(drawn):
    bar = MeasuredCircle(0.1, 0.1, 1, angle=np.linspace(0, 13, 1000), deviation=np.zeros(1000))
    with pytest.raises(FricError, match="ball bar"):
        tune(drawn, [bar])


def test_a_log_whose_clock_is_wrong_is_refused_and_told(drawn, circles):
    def lossy(test):
        kept = np.random.default_rng(2).uniform(size=len(test.axes["x"].time)) > 0.01
        axes = {}
        for name, trace in test.axes.items():
            few = {key: values[kept] for key, values in trace.channels().items()}
            axes[name] = AxisTrace(**(few | {"time": trace.time[: kept.sum()]}))  # it is counted on
        return replace(test, axes=axes)

    found = tune(replace(drawn, axes={"x": drawn.axes["x"]}), [lossy(circles[0])])
    assert {"samples-lost", "tuning-refused"} <= {warning.code for warning in found.warnings}
    assert not found.improves
    assert found.machine.axes["x"] is drawn.axes["x"]


def test_a_circle_that_is_given_twice_is_refused():
    """It was counted as two independent circles."""
    circle = Path(__file__).parents[2] / "data/circle.h5"
    with pytest.raises(FricError, match="given twice"):
        fric.tune("virtual-rig", circle, circle)
