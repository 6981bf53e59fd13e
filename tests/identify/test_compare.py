"""Models compared on what none was fitted to: the right one wins where there is one, and else nobody does."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import fric
from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction import models
from fric.identify.replay import compare
from fric.identify.replay.compare import (
    Score,
    compare_models,
    near_reversals,
    presliding_length,
    split_by_cycles,
    split_by_folds,
    split_by_record,
)
from fric.identify.replay.replay_fit import identify_by_replay
from fric.io.hdf5 import read_logs
from fric.log import Log
from fric.records.inspection import inspect, too_coarse
from fric.records.prepared import prepared
from tests.identify import presliding
from tests.identify.virtual_logs import logs_of

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def records():
    return prepared(logs_of(models()["lugre"].typical(), 11))


def test_a_model_that_is_not_known_is_refused_before_any_is_fitted(records, monkeypatch):
    """Twenty seconds of fits went before it."""
    monkeypatch.setattr(compare, "identify_by_replay", lambda *_, **__: pytest.fail("a fit"))
    with pytest.raises(FricError, match="no friction model 'foo'"):
        compare_models(["lugre", "foo"], records, split_by_folds(records, 3))


def test_a_map_that_is_given_is_not_fitted_among_all_models(records, monkeypatch):
    """Every comparison with a given map ended, after twenty seconds, in "every parameter of static is given"."""
    compared = []
    monkeypatch.setattr(compare, "compare_models", lambda names, *_, **__: compared.extend(names) or 1 / 0)
    given = fric.StaticMap(60.0, 90.0, 0.002, 1.0, 100.0)
    for static, left_out in ((None, set()), (given, {"static"})):
        compared.clear()
        with pytest.raises(ZeroDivisionError):
            fric.compare(records[0].log, static=static)
        assert {name for name, model in models().items() if model.identified} - {*compared} == left_out


def test_each_sample_is_scored_by_a_fit_to_others(records):
    for splits in (split_by_folds(records, 3), split_by_cycles(records, 1), split_by_record(records, ["small"])):
        for split in splits:
            fitted = np.concatenate([mask & record.used for record, mask in zip(records, split, strict=True)])
            assert 0 < fitted.sum() < sum(record.used.sum() for record in records)
    for record, *fitted in zip(records, *split_by_folds(records, 3), strict=True):
        np.testing.assert_array_equal(np.sum([record.used & ~mask for mask in fitted], axis=0), record.used)


def test_the_model_that_made_the_logs_wins(records):
    comparison = compare_models(["dahl", "static", "lugre"], records, split_by_folds(records, 2))
    assert comparison.winner == "lugre"
    assert [score.name for score in comparison.scores] == ["lugre", "dahl", "static"]
    assert comparison.scores[0].rms == pytest.approx(1.0, rel=0.1)
    assert comparison.scores[0].bits > comparison.scores[1].bits


@pytest.mark.long(2)
def test_models_that_are_the_same_there_have_no_winner():
    """Without a Stribeck effect and without damping, LuGre is Dahl's model."""
    records = prepared(logs_of(models()["dahl"].typical(), 12))
    comparison = compare_models(["dahl", "lugre"], records, split_by_folds(records, 2))
    assert comparison.winner is None
    lead, error = next(iter(comparison.leads.values()))
    assert 0.0 <= lead < error


def test_a_model_that_leaves_no_less_than_coulomb_and_viscous_friction_is_no_winner():
    """Records of strokes whose friction has no memory: what a dynamic model adds is noise."""
    rng = np.random.default_rng(4)
    t = np.arange(6000) / 100.0
    position = 0.05 * np.sin(0.6 * t) + 0.01 * np.sin(2.1 * t)
    velocity = 0.03 * np.cos(0.6 * t) + 0.021 * np.cos(2.1 * t)
    force = 20.0 * np.sign(velocity) + 300.0 * velocity + 2.0 + rng.normal(0.0, 1.0, len(t))
    records = prepared([Log(t, position=position, force=force, kind="motion")])
    comparison = compare_models(["dahl", "lugre"], records, split_by_folds(records, 2))
    plain = {one.name: one for one in comparison.baselines}
    assert comparison.winner is None
    assert plain["Coulomb and viscous"].rms == pytest.approx(1.0, rel=0.1)
    assert plain["Coulomb and viscous"].rms < 0.2 * plain["constant force"].rms
    lead, error = comparison.leads["Coulomb and viscous"]
    assert not lead > error


@pytest.mark.parametrize("names", [["lugre"], pytest.param(["dahl", "lugre", "gms"], marks=pytest.mark.long(10))])
def test_of_start_stop_strokes_at_25_hz_no_dynamic_model_is_the_winner(names):
    """The axis is through pre-sliding between two samples: a dynamic model was named that left more than the map."""
    rng, rest = np.random.default_rng(0), np.zeros(3000)
    ramp, speeds = np.linspace(0.0, 1.0, 200), rng.choice([2e-3, 5e-3, 1e-2, 2e-2], 12)
    one = np.concatenate([rest, ramp, np.ones(4000), ramp[::-1]])
    v = np.outer(speeds * np.tile([1.0, -1.0], 6), one).ravel()
    t, z = np.arange(len(v)) / 5000.0, np.cumsum(v) / 5000.0
    force, some = presliding.APART.replay(t, z, v) + rng.standard_normal(len(v)), slice(None, None, 200)
    records = prepared([Log(t[some], position=np.rint(z[some] / 1e-6) * 1e-6, force=force[some], kind="motion")])
    static = {
        name: Estimate(float(getattr(presliding.PAPER, name)), "") for name in ("F_c", "F_s", "v_s", "delta", "sigma")
    }
    found = compare_models(names, records, split_by_folds(records, 2), static=static)
    assert found.winner is None
    assert {one.name: one for one in found.baselines}["static map"].rms < 1.1 * found.scores[0].rms


def test_a_model_that_leaves_more_than_a_map_near_reversals_is_no_winner(monkeypatch):
    """Dahl's was named for what it gains between them."""
    t = np.arange(6000) / 100.0
    position, velocity = 0.05 * np.sin(0.6 * t), 0.03 * np.cos(0.6 * t)
    near = np.abs(position) > 0.0495
    noise = np.random.default_rng(4).normal(0.0, 1.0, len(t)) * np.where(near, 0.1, 1.0)
    log = Log(t, position=position, force=20.0 * np.sign(velocity) + noise, kind="motion")
    (record,) = prepared([log])
    replaced = SimpleNamespace(independent=100.0, warnings=(), model=None)

    def winner(left: float) -> str | None:
        residual = (np.where(near, left, 0.3),)
        score = Score("dahl", 2, residual, *compare._sizes(residual, (near,)), (replaced,), 0.3, 1.0)
        monkeypatch.setattr(compare, "_scored", lambda *_: score)
        monkeypatch.setattr(compare, "_with_bits", lambda found, _: found)
        monkeypatch.setattr(compare, "record_notices", lambda *_: [])
        monkeypatch.setattr(compare, "near_reversals", lambda *_: near)
        return compare_models(["dahl"], [record], split_by_folds([record], 2)).winner

    assert winner(0.01) == "dahl"
    assert winner(0.5) is None


def test_moments_at_which_the_drive_is_off_are_not_compared(records):
    log = records[0].log
    rest = np.arange(1, 401) * float(np.median(np.diff(log.time)))
    after = Log(
        np.append(log.time, log.time[-1] + rest), position=np.append(log.position, np.full(400, log.position[-1])),
        force=np.append(log.force, np.zeros(400)), kind=log.kind, name=log.name,
    )  # fmt: skip
    (off,) = prepared([after])
    assert not off.used[-400:].any()
    assert off.used[: len(log)].sum() >= 0.99 * records[0].used.sum()
    found = identify_by_replay("dahl", [off], static=None)
    assert "drive-off" in {one.code for one in found.warnings}


def test_presliding_length_of_an_exponential_hysteresis():
    """Dahl: the force turns from -F_c to F_c as exp(-z·sigma_0/F_c), by nine tenths after ln(10)·F_c/sigma_0."""
    model = models()["dahl"].typical()
    record = prepared(logs_of(model, 1, noise=0.0, motions=("large",)))[0]
    expected = np.log(10.0) * model.F_c / model.sigma_0
    step = np.abs(np.diff(record.motion.position)).max()
    assert presliding_length(record) == pytest.approx(expected, abs=step)
    near = near_reversals(record, expected)
    assert near[record.reversals].all()
    assert not near_reversals(replace(record, reversals=record.reversals[:0]), expected).any()


@pytest.mark.long
def test_bundled_loops_of_the_rig_tell_slip_blocks_from_a_single_bristle():
    """GMS and Leuven under a third of LuGre's error on the 15 and 450 µm loops; the static map worst at reversals."""
    records = prepared(read_logs([ROOT / "data/presliding-sine.h5"]))
    names = ["static", "lugre", "leuven", "gms"]
    comparison = compare_models(names, records, split_by_cycles(records, 2))
    scores = {score.name: score for score in comparison.scores}
    assert scores["gms"].rms < scores["lugre"].rms / 3
    assert scores["leuven"].rms < scores["lugre"].rms / 3
    assert max(scores.values(), key=lambda score: score.rms_near).name == "static"


def test_a_split_that_leaves_nothing_is_refused(records):
    with pytest.raises(FricError, match="no record 'x'"):
        split_by_record(records, ["x"])
    with pytest.raises(FricError, match="none is left to score"):
        split_by_record(records, ["small", "large", "fast"])
    with pytest.raises(FricError, match="cycles"):
        split_by_cycles(records, 30)
    with pytest.raises(FricError, match="folds"):  # the verb holds what a split of one fold needs
        fric.compare(records[0].log, folds=1)


@pytest.mark.long(3)
def test_what_records_cannot_tell_is_judged_once_and_as_inspect_and_a_fit_do():
    logs = [presliding.record(amplitude, cycles=8) for amplitude in (0.6e-6, 200e-6)]
    ready = prepared(logs)
    assert too_coarse(ready[1:]) == []
    comparison = compare_models(["dahl", "static"], ready, split_by_cycles(ready, 4))
    (told,) = [one for one in comparison.warnings if getattr(one, "code", "") == "encoder-too-coarse"]
    assert told.severity == "wrong"
    assert "2.4 steps" in told or "2.0 steps" in told
    (of_fit,) = [one for one in identify_by_replay("dahl", ready).warnings if one.code == "encoder-too-coarse"]
    assert of_fit == told
    uses = {use.purpose: use for use in inspect(logs[0]).uses}
    assert not uses["gms"].good
