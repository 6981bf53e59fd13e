"""Which one more record narrows the glitch: against the fits' own covariance, and against the record taken."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import logit

import fric
from fric.documents.machine_files import read_machine
from fric.estimate import Covariance
from fric.friction.gms import GMS
from fric.identify.gms.hunting import Hunting
from fric.identify.gms.virgin_curve import find_cycles
from fric.identify.replay.replay_fit import replay_information
from fric.identify.replay.replay_search import search_ranges
from fric.planning.choose import _known_of, _moved, by_what_they_leave, choose, identified, prior_axis
from fric.records.prepared import prepared
from fric.simulate.experiment import CandidateRecord, Limits, Planned, runs_of

LIMITS = Limits(0.3, 0.1, 5.0)


@cache
def first():
    """An axis, its plan, the records of it, and what they give."""
    axis, _ = prior_axis(read_machine("xy-table"))
    planned = choose(axis, LIMITS)
    logs = [t.log(axis, run, 3) for t, run in runs_of(axis, [t for one in planned for t in one.trials(axis)])]
    return axis, planned, logs, list(identified(logs))


@pytest.mark.long(5)
def test_information_of_all_sines_is_that_of_the_fit_to_them() -> None:
    axis, _, logs, (*_, gms) = first()
    model = gms.friction("gms")
    sines = [log for log in logs if "sine" in log.kind]
    *cycled, slides = prepared(sines, axis.plant)
    records = [*(find_cycles(one).for_replay() for one in cycled), slides.in_sliding()]
    names, information = replay_information(records, model, search_ranges(records), Hunting(axis.plant))
    told = gms.fit_of("gms").covariance.covariance()
    at = [told.names.index(name) for name in names]
    assert set(told.names) - set(names) == {f"alpha_{len(model.alpha)}"}
    by_fit = np.sqrt(np.diag(np.array(told.matrix)[np.ix_(at, at)]))
    by_information = np.sqrt(np.diag(np.linalg.inv(information)))
    ratio = by_information / by_fit
    # both are good to 20 %
    assert abs(np.log(np.median(ratio))) < np.log(1.44), dict(zip(names, ratio, strict=True))
    # at another level; and the fit counts what it misses of a motion as an error, which moves k_3 to 0.43
    assert np.all(np.abs(np.log(ratio)) < np.log(2.5)), dict(zip(names, ratio, strict=True))


def test_a_record_is_blind_for_what_it_does_not_show() -> None:
    axis, _ = prior_axis(read_machine("xy-table"))
    model = axis.friction
    trials = [trial for one in choose(axis, LIMITS) for trial in one.trials(axis) if "sine" in trial.kind]
    sines = prepared([trial.log(axis, run, 3) for trial, run in runs_of(axis, trials)], axis.plant)
    (slides,) = (one.in_sliding() for one in sines if one.log.kind == "sliding-sine")
    names, information = replay_information([slides], model, search_ranges(sines))
    told = np.diag(information)
    assert told[names.index("C")] > 0
    assert told[names.index("k_1")] < 1e-6 * told[names.index("C")]


@pytest.mark.long(9)
def test_the_record_that_is_said_to_narrow_most_narrows_a_file_that_lacks_it(tmp_path: Path) -> None:
    """Without a sine in sliding C is assumed, to a factor of ten: that sine comes first, and does what is said."""
    _, _, logs, (plant, static, _) = first()
    without = fric.identify_gms(*(log for log in logs if log.kind == "presliding-sine"), static=static, plant=plant)
    without.save(tmp_path / "without.yaml")
    found = fric.plan_next(tmp_path / "without.yaml", machine="xy-table")
    told = found.document["narrowing"]
    best = told["records"][0]
    assert best["kind"] == "sliding-sine"
    assert max(told["shares"], key=told["shares"].get) == "C"
    assert sum(told["shares"].values()) == pytest.approx(1.0)
    assert best["half_width"]["value"] < 0.8 * told["half_width"]["value"]
    left = [one["half_width"]["value"] for one in told["records"]]
    assert best["half_width"]["value"] < 1.2 * min(left)  # what half-widths of simulated records are good to
    assert max(left) <= told["half_width"]["value"] * (1 + 1e-9)
    found.save(tmp_path / "next")
    more = fric.experiment("xy-table", plan=tmp_path / "next", seed=9)
    sines = [log for log in logs if log.kind == "presliding-sine"]
    again = fric.identify_gms(*sines, *more, static=static, plant=plant)
    again.save(tmp_path / "with.yaml")
    after = fric.plan_next(tmp_path / "with.yaml", machine="xy-table").document["narrowing"]["half_width"]["value"]
    assert after == pytest.approx(best["half_width"]["value"], rel=0.5)


@given(share=st.floats(1e-4, 0.1), by=st.floats(-0.5, 0.5))
def test_a_moved_share_leaves_the_last_block_something(share: float, by: float) -> None:
    """Of 0.56, 0.40 and 0.04 the second may err by 0.04 alone: moved up by that, no share was left for the third."""
    model = replace(GMS.typical(), alpha=(0.58 - share, 0.42, share), k=(1e8, 2e6, 1e5))
    moved, step = _moved(model, "alpha_2", by, linear=False)
    assert moved.alpha[-1] > 0.0
    assert step == pytest.approx(logit(moved.alpha[1]) - logit(0.42), abs=1e-9)
    assert 0.0 <= step / by <= 1.0 + 1e-9 if abs(by) > 1e-6 else abs(step) <= 1e-6


def test_parameters_are_moved_by_what_they_may_err_if_the_others_are_known() -> None:
    """Two shares that add up to nearly 1 err by 0.14 of a logit each, and against each other by a fifth of it."""
    matrix = 0.14**2 * np.array([[1.0, -0.98, 0.0], [-0.98, 1.0, 0.0], [0.0, 0.0, 1.0]])
    stated = Covariance(("alpha_1", "alpha_2", "k_1"), ("logit", "logit", "log"), matrix)
    known = _known_of([stated], replace(GMS.typical(), alpha=(0.56, 0.40, 0.04), k=(1e8, 2e6, 1e5)))
    assert known.deviation["alpha_1"] == pytest.approx(0.14 * np.sqrt(1 - 0.98**2))
    assert known.deviation["k_1"] == pytest.approx(0.14)


def test_a_file_without_gms_is_refused_with_what_to_do() -> None:
    with pytest.raises(fric.FricError, match="fric plan --friction"):
        fric.plan_next("tests/documents/before/static.yaml")


def test_of_records_that_narrow_alike_the_shorter_one_is_first() -> None:
    strokes, sine, swing = (
        CandidateRecord(Planned("circle", {}, why), lasting, half_width, scatter)
        for why, lasting, half_width, scatter in (
            ("strokes", 70.0, 9.0, 0.1),
            ("sine", 60.0, 6.0, 0.5),
            ("swing", 6.0, 6.5, 0.5),
        )
    )
    assert by_what_they_leave([strokes, sine, swing]) == (swing, sine, strokes)
    surer = replace(swing, scatter=0.1), replace(sine, scatter=0.1)
    assert by_what_they_leave([strokes, *surer]) == (*surer[::-1], strokes)
