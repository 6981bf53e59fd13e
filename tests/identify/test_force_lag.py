"""K_f and the lag of a logged force: told from the response, whatever the force is late by."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest

from fric.drive.plant import Plant
from fric.identify.plant.identify import force_scale, identify_plant
from fric.log import Log
from fric.notice import Notice
from fric.records.prepared import acting_force, prepared
from tests.chance import fewest
from tests.identify.flawed_axis import RATE, Machine, run, shaken
from tests.identify.test_rigid_body import motion
from tests.turns import in_turns

RUBBING = Machine(F_c=40.0, F_s=60.0)


def codes(warnings: tuple[str, ...]) -> dict[str, str]:
    return {w.code: w.severity for w in warnings if isinstance(w, Notice)}


@pytest.mark.parametrize(
    ("lag", "corner"), in_turns(product((0, 2, 4), (0.0, 300.0, 800.0)), [(0, 300.0), (2, 800.0), (4, 0.0)])
)
@pytest.mark.parametrize("how", [{}, {"mean": 0.0, "swing": 2e-3, "count": 15}], ids=["in motion", "at rest"])
def test_the_force_constant_and_the_lag_of_a_late_force(lag: int, corner: float, how: dict[str, Any]) -> None:
    """K_f within 1 %, the lag within 0.1 sample; the low-frequency lag of a filter behind a hold is T_f + T_s/2."""
    log = shaken(RUBBING, seed=lag, force_lag=lag, force_filter=corner, force_step=0.5, **how)
    found = force_scale([log], None, "linear")
    assert found.K_f is not None
    assert found.lag is not None
    assert float(found.K_f) == pytest.approx(RUBBING.K_f, rel=2e-3)
    late = lag + (RATE / (2 * np.pi * corner) + 0.5 if corner else 0.0)
    assert float(found.lag) * RATE == pytest.approx(late, abs=0.05)
    assert (found.filter is not None) == (corner > 0)
    if found.filter is not None:
        assert float(found.filter) == pytest.approx(corner, rel=0.02)
    assert ("force-lags" in codes(found.warnings)) == (late > 0)
    assert "dead-zone" not in codes(found.warnings)


@pytest.mark.parametrize("lag", [0.0, 3.0])
@pytest.mark.parametrize("dead", [0.02, 0.2])
def test_a_dead_zone_of_the_drive_is_told_by_its_size(dead: float, lag: float) -> None:
    """One of 30 mV beside 0.6 V (rms) gave K_f 174.0 (173.5 to 174.4) for 180, and B, without a word."""
    log = shaken(RUBBING, seed=3, force_lag=lag, force_step=0.5, mean=0.0, swing=2e-3, count=15)
    assert log.input is not None
    share = dead * float(np.std(log.input))
    found = force_scale([replace(log, input=log.input + share * np.sign(log.input))], None, "linear")
    (notice,) = (w for w in found.warnings if isinstance(w, Notice) and w.code == "dead-zone")
    assert notice.severity == "wrong"
    number, unit = str(notice).split("±")[1].split()[:2]
    assert float(number) * {"V": 1.0, "mV": 1e-3}[unit] == pytest.approx(share, rel=0.1)


@pytest.mark.parametrize("corner", [60.0, 150.0, 300.0])
def test_a_filter_of_the_force_is_no_dead_zone(corner: float) -> None:
    """What is late of a filtered force went for a jump at the input's sign, where the input is no Gaussian noise."""
    machine = replace(RUBBING, F_s=1.5 * RUBBING.F_c)
    log = shaken(machine, seed=1, force_filter=corner, force_lag=1.0, mean=0.0, swing=2e-3, count=15)
    assert "dead-zone" not in codes(force_scale([log], None, "linear").warnings)


def test_without_periods_and_along_a_motion_it_is_the_same() -> None:
    swept = run(RUBBING, 2e-3 * np.sin(0.002 * np.arange(60_000) ** 1.3), force_lag=3.0, kind="motion")
    found = force_scale([replace(swept, reference=None)], None, "linear")
    assert float(found.K_f) == pytest.approx(RUBBING.K_f, rel=0.01)  # type: ignore[arg-type]
    assert float(found.lag) * RATE == pytest.approx(3.0, abs=0.1)  # type: ignore[arg-type]
    log = motion(seed=1)
    F = np.asarray(log.force)
    late = replace(log, input=F / 35.0, force=np.concatenate([np.full(3, F[0]), F[:-3]]))
    found = force_scale([late], None, "linear")
    sampling = (len(log) - 1) / float(log.time[-1] - log.time[0])
    assert float(found.K_f) == pytest.approx(35.0, rel=0.01)  # type: ignore[arg-type]
    assert float(found.lag) * sampling == pytest.approx(3.0, abs=0.1)  # type: ignore[arg-type]


def test_intervals_cover_where_the_force_is_noisy() -> None:
    """Chance of failing: below one in a thousand for each of the two (`tests/chance.py`)."""
    covered = np.zeros(2)
    for seed in range(40):
        log = shaken(RUBBING, seed=seed, force_lag=2.0, force_noise=20.0, periods=6, period=2000, count=25)
        found = force_scale([log], None, "linear")
        for n, (estimate, truth) in enumerate(((found.K_f, RUBBING.K_f), (found.lag, 2 / RATE))):
            low, high = estimate.ci95  # type: ignore[union-attr, misc]
            covered[n] += low <= truth <= high
    assert np.all(covered >= fewest(40)), covered


def test_records_that_differ_widen_the_interval() -> None:
    logs = [shaken(replace(RUBBING, K_f=K, B=2.5 * K / 210), seed=n) for n, K in enumerate((205.0, 210.0, 216.0))]
    low, high = force_scale(logs, None, "linear").K_f.ci95  # type: ignore[union-attr, misc]
    assert low < 206
    assert high > 215


def test_a_stated_mass_is_held_against_what_is_found() -> None:
    log = shaken(RUBBING, seed=1, force_lag=2.0)
    assert "mass-differs" not in codes(identify_plant([log], mass=RUBBING.M).warnings)
    assert codes(identify_plant([log], mass=1.3 * RUBBING.M).warnings)["mass-differs"] == "wrong"
    blind = replace(log, force=None)
    found = identify_plant([blind], mass=RUBBING.M).estimates["K_f"]
    assert float(found) == pytest.approx(RUBBING.K_f, rel=0.02)
    assert found.ci95 is not None
    assert codes(identify_plant([log], given_force_constant=300.0).warnings)["K_f-differs"] == "wrong"


def test_the_plant_takes_the_lag_off_where_friction_is_identified() -> None:
    """A sine of force that is logged late, taken off with the plant, is the sine that acts."""
    t = np.arange(8000) / 1000
    force, late = 10 * np.sin(7 * t), 3e-3
    logged = 10 * np.sin(7 * (t + 0.65e-3 - late))  # the voltage runs ahead by T_d, and is logged late
    plant = Plant(A=0.0, B=548e6, T_d=0.65e-3, K_f=548.0, force_lag=late)
    (record,) = prepared([Log(t, 1e-4 * np.sin(3 * t), force=logged)], plant)
    acting = record.force + plant.M * record.motion.acceleration
    np.testing.assert_allclose(acting[10:-10], force[10:-10], atol=0.01)
    np.testing.assert_array_equal(acting_force(t, force, 0.0), force)


def test_a_force_that_is_a_multiple_of_the_input_has_that_factor_and_no_lag() -> None:
    """The force was differenced as a position is, its input was not: 31.2 (31.0 … 31.4) for 31.5, and 0.3 samples."""
    t = np.arange(0.0, 10.0, 1e-3)
    u = (
        3.0 * np.sin(2.1 * t)
        + 2.0 * np.sign(np.sin(0.7 * t + 1.0))
        + np.random.default_rng(1).normal(0.0, 0.01, len(t))
    )
    found = force_scale([Log(t, position=np.cos(2.1 * t), input=u, force=31.5 * u, kind="motion")], None, "linear")
    assert found.K_f is not None
    assert float(found.K_f) == pytest.approx(31.5, rel=1e-9)
    assert found.shift == 0.0
