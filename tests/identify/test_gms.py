"""`identify_gms`: the machine is known, so is what must come out."""

from dataclasses import replace

import numpy as np
import pytest

import fric
from fric import FricError
from fric.drive.plant import Plant
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.identify.gms.identify import assumed_C
from fric.log import Log
from tests.identify.presliding import APART, PAPER, TABLE_1, identify_gms, pair, record, rms_error

SLIDING = {"frequency": 2.0, "mean": 1e-3, "cycles": 12, "kind": "sliding-sine", "dt": 1e-3}


def told(fit, code):
    return [warning for warning in fit.warnings if warning.code == code]


def inside(true, intervals):
    return [low <= value <= high for value, (low, high) in zip(true, intervals, strict=True)]


def test_blocks_well_apart_come_out_within_one_per_cent():
    fit = identify_gms(pair(APART, step=0.0, noise=0.0), static=PAPER)
    assert len(fit.blocks) == 4  # chosen by the criterion
    assert fit.alpha.value == pytest.approx(APART.alpha, rel=0.01)
    assert fit.k.value == pytest.approx(APART.k, rel=0.01)
    assert float(fit.alpha_sum) == pytest.approx(1.0, abs=2e-3)


def test_table_1_through_an_encoder():
    fit = identify_gms(pair(seed=1), static=PAPER)
    assert rms_error(fit.model) < 0.5
    assert len(fit.blocks) == 3
    assert fit.choice is not None
    assert "blocks: another lowers" in fit.choice.reason
    assert sum(fit.model.alpha) == pytest.approx(1.0, abs=1e-12)
    assert (np.diff(fit.model.slip_displacements) > 0).all()
    assert fit.rmse == pytest.approx(1.0, rel=0.1)  # the noise, and nothing else
    assert told(fit, "first-block-unresolved")
    (assumed,) = told(fit, "C-assumed")
    assert (float(assumed.values["C"]), fit.C.assumed) == (10e3, True)


@pytest.mark.parametrize("motion", ["linear/A", "rotary"])
def test_the_assumed_C_follows_the_unit_of_the_force(motion):
    """10 kN/s became 10 kA/s: a contact of 2 A then yielded a hundred times faster than one of 100 N."""
    for size in (1.0, 0.02):
        static = replace(PAPER, F_c=size * PAPER.F_c, F_s=size * PAPER.F_s)
        assert assumed_C(static, motion) == pytest.approx(size * assumed_C(PAPER, motion), rel=0.05)
    assert assumed_C(PAPER, "linear") == pytest.approx(assumed_C(PAPER, motion), rel=0.3)


def test_blocks_that_slip_alike_are_found_when_they_are_asked_for():
    fit = identify_gms(pair(step=0.0, noise=0.0), static=PAPER, blocks=4)
    assert fit.alpha.value[1:3] == pytest.approx(np.array([0.170, 0.227]) / 1.002, rel=0.02)


def test_blocks_that_would_have_no_stiffness_are_told():
    one = GMS(PAPER, (1.0,), (33e6,), 1e4)
    fit = identify_gms([record(60e-6, one, step=0.0, noise=0.0)], static=PAPER, blocks=6, refined=False)
    assert len(fit.blocks) == len(fit.k.value) < 6
    assert told(fit, "fewer-blocks")


def test_the_paper_s_way_by_knots():
    knots = [0.9e-6, 26e-6, 54e-6]
    fit = identify_gms(pair(step=0.0, noise=0.0), static=PAPER, knots=knots, refined=False)
    V = TABLE_1.virgin_curve(np.array(knots))
    slopes = np.diff(V, prepend=0.0) / np.diff(knots, prepend=0.0)
    assert fit.k.value == pytest.approx(slopes - np.append(slopes[1:], 0.0), rel=0.05)
    assert fit.blocks.displacement == pytest.approx(knots)
    with pytest.raises(FricError, match="beyond the virgin curve"):
        identify_gms(pair(), static=PAPER, knots=[1e-6, 1e-3])


def test_C_comes_from_a_record_in_sliding():  # of 10 kN/s: the next test
    model = GMS(PAPER, TABLE_1.alpha, TABLE_1.k, 3e3)
    fit = identify_gms([*pair(model), record(60e-6, model, **SLIDING)], static=PAPER)
    assert float(fit.C) == pytest.approx(3e3, rel=0.2)
    low, high = fit.C.ci95
    assert low < 3e3 < high
    assert not fit.C.assumed


def test_the_plant_is_taken_off_and_its_share_told():
    plant = Plant(A=28.57, B=4.526, T_d=0.0, K_f=548.0)
    settings = {"mass": plant.M, "damping": plant.damping}
    logs = [*pair(**settings), record(60e-6, **SLIDING, **settings)]
    fit = identify_gms(logs, static=PAPER, plant=plant)
    assert rms_error(fit.model) < 0.5
    low, high = fit.C.ci95
    assert low < 1e4 < high
    large = fit.records[1].record.done
    assert large.damping_share == pytest.approx(plant.damping * 283e-6 / 158, rel=0.1)
    assert not told(fit, "sine-too-fast")
    # the same loop at 12 Hz: M·A·w² is 31 N of 165 at most, and of less where the force is not at its level
    fast = record(45e-6, frequency=12.0, cycles=20, dt=2e-4, **settings)
    (warning,) = told(identify_gms([fast], static=PAPER, plant=plant, blocks=2), "sine-too-fast")
    assert 31 / 165 < warning.values["share"] < 0.3


def test_an_offset_is_absorbed():
    without, with_offset = (
        identify_gms([record(60e-6, offset=offset)], static=PAPER, blocks=4) for offset in (0.0, 5.0)
    )
    assert with_offset.alpha.value == pytest.approx(without.alpha.value, rel=1e-4)
    assert with_offset.k.value == pytest.approx(without.k.value, rel=1e-4)


def test_without_a_static_map_the_plateau_stands_in():
    flat = GMS(StaticMap(150.0, 150.0, 1e-3), APART.alpha, tuple(150 / 165 * k for k in APART.k), 1e4)
    fit = identify_gms(pair(flat))
    assert fit.static.F_c == fit.static.F_s == pytest.approx(150.0, rel=2e-3)
    assert rms_error(fit.model, flat) < 0.5
    assert told(fit, "no-static-map")


def test_a_loop_that_never_saturates_says_what_is_missing():
    fit = identify_gms([record(15e-6)], static=PAPER)
    (warning,) = told(fit, "never-saturates")
    assert 0.0 < float(warning.values["missing"]) < 165.0
    assert rms_error(fit.model, reach=15e-6) < 0.5
    assert sum(fit.model.alpha) == pytest.approx(1.0)
    (blind,) = told(identify_gms([record(15e-6)]), "never-slides")
    assert blind.severity == "wrong"


def test_a_level_that_changed_is_told_and_taken_out():
    weak = GMS(StaticMap(94.5, 148.5, 1e-3, 1.0, 40.0), TABLE_1.alpha, TABLE_1.k, 1e4)
    fit = identify_gms(pair(weak), static=PAPER)
    assert float(fit.alpha_sum) == pytest.approx(0.9, abs=0.005)
    assert told(fit, "level-differs")
    assert sum(fit.model.alpha) == pytest.approx(1.0)


def test_cycles_held_out_are_replayed():
    fit = identify_gms(pair(cycles=7), static=PAPER, cycles=(1, 3), blocks=4)
    for one in fit.records:
        assert one.held_out.any()
        assert not (one.held_out & one.record.used).any()
        assert one.rmse_held_out == pytest.approx(1.0, rel=0.15)


def test_one_block_is_a_model_too():
    one = GMS(PAPER, (1.0,), (33e6,), 1e4)  # slips at 5 µm
    fit = identify_gms([record(60e-6, one)], static=PAPER)
    assert fit.alpha.value == (1.0,)
    assert fit.k.value == pytest.approx(one.k, rel=0.01)


def test_what_cannot_be_used_is_said():
    with pytest.raises(FricError, match="no pre-sliding record"):
        identify_gms([record(60e-6, **SLIDING)])
    with pytest.raises(FricError, match="no whole cycle"):
        identify_gms([record(15e-6, cycles=0)])
    with pytest.raises(FricError, match="steps of the encoder, too few"):
        identify_gms([record(0.6e-6, noise=0.1)], static=PAPER)


def test_a_sine_in_sliding_that_reverses_is_left_out_and_said():
    """It ended the identification of a whole session, whose circle is such a sine."""
    turning = record(400e-6, **{**SLIDING, "mean": 1e-4})
    fit, without = (identify_gms(logs, static=PAPER) for logs in ([*pair(), turning], pair()))
    assert (fit.alpha, fit.k, fit.C) == (without.alpha, without.k, without.C)
    (left_out,) = [notice for notice in fit.warnings if notice.code == "record-left-out"]
    assert "the motion reverses" in str(left_out)


def test_the_same_logs_give_the_same_digits():
    first, second = (identify_gms([record(15e-6)], static=PAPER) for _ in range(2))
    assert first.alpha == second.alpha
    assert first.k == second.k


@pytest.mark.long
def test_intervals_cover_the_truth():
    two = GMS(PAPER, (0.7, 0.3), (20e6, 3e6), 1e4)  # 5.8 and 16.5 µm
    hits = []
    for seed in range(40):
        log = record(60e-6, two, frequency=0.5, cycles=6, dt=2e-3, step=0.05e-6, noise=2.0, seed=seed)
        fit = identify_gms([log], static=PAPER, blocks=2)
        hits += [*inside(two.alpha, fit.alpha.ci95), *inside(two.k, fit.k.ci95)]
    assert 0.88 <= np.mean(hits) <= 1.0


@pytest.mark.long
def test_machines_of_all_kinds():
    # 1 to 6 blocks, 1 to 1000 N, any speed, encoder and noise: the curve is right to a few noise levels of its mean
    rng = np.random.default_rng(5)
    for _ in range(10):
        count, F_s = int(rng.integers(1, 7)), 10 ** rng.uniform(0, 3)
        static = StaticMap(F_s * rng.uniform(0.5, 1), F_s, 10 ** rng.uniform(-3.5, -2), rng.uniform(0.6, 2), F_s / 2)
        slip = np.sort(10 ** rng.uniform(-6.3, -4.3, count))
        alpha = rng.dirichlet(2 * np.ones(count))
        true = GMS(static, tuple(alpha), tuple(alpha * F_s / slip), 30 * F_s)
        reach, frequency = slip[-1] * rng.uniform(1.5, 8), 10 ** rng.uniform(-1.5, 0)
        step, noise = 10 ** rng.uniform(-8, -7), F_s * 10 ** rng.uniform(-3, -1.5)
        logs = [
            record(amplitude, true, frequency=frequency, dt=1 / frequency / 2000, step=step, noise=noise)
            for amplitude in sorted({max(5 * slip[0], 20 * step), reach})
        ]
        fit = identify_gms(logs, static=static)
        assert rms_error(fit.model, true, reach) < max(0.01 * F_s, noise)


@pytest.mark.long
def test_six_seeds_through_an_encoder():  # twenty in closed loop: test_gms_in_closed_loop.py
    for seed in range(6):
        fit = identify_gms(pair(seed=seed), static=PAPER)
        assert rms_error(fit.model) < 1.0
        assert len(fit.blocks) == 3


def test_a_stroke_that_is_taken_for_a_sine_is_left_out_and_said() -> None:
    """It cost the whole identification: two good records are enough."""
    good = fric.read("data/presliding-sine.h5")
    slow = next(log for log in fric.read("data/constant-velocity.h5"))
    half = len(slow.time) // 2  # there, and not back
    stroke = Log(slow.time[:half], position=slow.position[:half], force=slow.force[:half], kind="presliding-sine")
    with_it, without = (fric.identify_gms(*logs, refine=False) for logs in ([stroke, *good], good))
    (told,) = (one for one in with_it.warnings if one.code == "record-left-out")
    assert "no whole cycle" in told
    assert with_it.document["gms"] == without.document["gms"]
    with pytest.raises(FricError, match="no whole cycle"):
        fric.identify_gms(stroke)
