"""K_f from strokes: the slope of mean force over mean voltage, whatever either is logged late by."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fric.identify.plant.identify import force_scale, steady_force_constant
from fric.log import Log
from tests.chance import fewest
from tests.identify.constant_velocity import both_directions, stroke

K_F = 210.0


def strokes(seed: int, *, noise: float = 0.0, late: int = 0, bend: float = 0.0) -> list[Log]:
    """Return strokes whose motor gives K_F newtons for a volt, beside 0.3 V; 2 mV of noise in the voltage."""
    rng, found = np.random.default_rng(seed), []
    for v in both_directions()[::3]:
        log = stroke(float(v), rng, noise=noise)
        force = np.asarray(log.force)
        voltage = force / K_F + 0.3 + 2e-3 * rng.standard_normal(len(log))
        found.append(replace(log, input=voltage, force=np.roll(force + bend * force**2, late)))
    return found


@pytest.mark.parametrize("late", [0, 40])
def test_the_slope_is_the_force_constant_however_late_the_force_is(late):
    found, warnings = steady_force_constant(strokes(1, late=late), "linear")
    assert found is not None
    assert float(found) == pytest.approx(K_F, rel=1e-3)
    assert not warnings


def test_intervals_cover():
    found = [steady_force_constant(strokes(seed, noise=0.02), "linear")[0] for seed in range(60)]
    covered = [low <= K_F <= high for one in found if one is not None for low, high in [one.ci95]]
    assert len(covered) == 60
    assert sum(covered) >= fewest(60)  # chance of failing: 7 in 10,000


def test_a_force_that_is_not_the_motor_s_is_told():
    _, warnings = steady_force_constant(strokes(1, bend=2e-3), "linear")
    assert [one.code for one in warnings] == ["force-not-proportional"]


def test_few_strokes_tell_nothing_and_what_is_given_goes_first():
    assert steady_force_constant(strokes(1)[:3], "linear") == (None, ())
    assert float(force_scale([], 200.0, "linear", strokes=strokes(1)).K_f) == 200.0
    assert float(force_scale([], None, "linear", strokes=strokes(1)).K_f) == pytest.approx(K_F, rel=1e-3)
