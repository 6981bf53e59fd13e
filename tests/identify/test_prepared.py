"""One prepared record for every replay: each of them sees the same force at the same instant."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import fric
from fric.documents.friction import PreparedPart
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import Estimate
from fric.identify.replay.replay_fit import identify_by_replay
from fric.log import Log
from fric.records.prepared import prepared
from fric.simulate.experiment import experiment
from tests.identify.presliding import PAPER, identify_gms, record

MACHINE = Path(__file__).parents[2] / "configs/xy-table.yaml"
GIVEN = {p.name: Estimate(getattr(PAPER, p.name), "") for p in PAPER.parameters}


@cache
def logged():
    axis = fric.read_machine(MACHINE).axes["x"]
    return axis, [log for kind in ("presliding-sine", "sliding-sine") for log in experiment(axis, kind)]


@pytest.mark.long(3)
def test_identify_gms_and_the_replay_fit_find_one_attraction_parameter():
    """The replay fit did not delay the force by T_d, and gave C 10531 (10411…10653) where the truth is 10000."""
    axis, logs = logged()
    by_curve = identify_gms(logs, static=PAPER, plant=axis.plant, blocks=3)
    by_replay = identify_by_replay(
        "gms", prepared(logs, axis.plant), static=GIVEN, blocks=3, start=by_curve.model
    ).estimates["gms"]["C"]
    for C in (by_curve.C, by_replay):
        low, high = C.ci95
        assert low < 1e4 < high
        assert high / low < 1.2
    assert float(by_replay) == pytest.approx(float(by_curve.C), rel=5e-3)


def test_what_was_prepared_is_data():
    axis, logs = logged()
    small, _, sliding = prepared(logs, axis.plant)
    assert small.done.delay == axis.plant.T_d
    assert small.done.encoder == pytest.approx(0.25e-6)
    told = PreparedPart.of(sliding.in_sliding().done, "linear")
    assert told["mass"] == Estimate(axis.plant.M, "kg")
    assert told["own"] == ("offset", "damping")
    assert 0 < told["inertia_share"] < 1
    assert PreparedPart.of(prepared(logs[:1])[0].done, "linear")["own"] == ("offset",)
    assert "mass" not in PreparedPart.of(prepared(logs[:1])[0].done, "linear")


def test_the_force_acts_where_the_plant_says():
    """A mass on a sine: the drive's force, earlier by the delay, is all inertia, and nothing is left of it."""
    plant = Plant(A=3.0, B=5.0, T_d=2e-3, K_f=500.0)
    t = np.arange(4000) * 1e-3
    z, v, a = (1e-3 * w * f(20 * t) for w, f in ((1, np.sin), (20, np.cos), (-400, np.sin)))
    acting = plant.M * a + plant.damping * v
    early = np.interp(t + plant.T_d, t, acting)
    for log in (Log(t, z, force=early), Log(t, z, input=early / plant.K_f)):
        (one,) = prepared([log], plant)
        assert np.abs(one.force[50:-50]).max() < 2e-3 * np.abs(acting).max()
    assert prepared([Log(t, z, input=early)], plant)[0].done.source == "input"
    with pytest.raises(FricError, match="no force was logged"):
        prepared([Log(t, z, input=early)])


def test_cycles_and_their_parts_are_what_is_resampled():
    (one,) = prepared([record(15e-6, cycles=5)])
    cycles = np.unique(one.cycle[one.used])
    assert len(cycles) in {4, 5}
    counts = np.bincount(one.phase[one.used])
    assert len(counts) == 32
    assert counts.min() > 0.2 * counts.mean()
    (line,) = prepared([Log(np.arange(1000.0), np.arange(1000.0) ** 1.5, force=np.linspace(1.0, 2.0, 1000))])
    assert len(np.unique(line.cycle[line.used])) == 10


def test_channels_aligned_to_a_sample_widen_what_depends_on_it():
    log = record(60e-6, frequency=1.0, cycles=6, dt=2e-3)
    ready = prepared([log])
    exact = [replace(one, done=replace(one.done, timing=0.0)) for one in ready]
    fits = [identify_by_replay("gms", one, static=GIVEN, blocks=2) for one in (ready, exact)]
    for widths in zip(*(np.diff(np.log(fit.estimates["gms"]["k"].ci95)).ravel() for fit in fits), strict=True):
        assert widths[0] > widths[1]
    assert float(fits[0].estimates["gms"]["k"].value[0]) == pytest.approx(fits[1].estimates["gms"]["k"].value[0])
