"""A record replayed by the axis that made it comes out as it was; by another one, it does not."""

from dataclasses import replace

import numpy as np
import pytest

from fric.control.cascade import Cascade
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.friction import models
from fric.friction.stribeck import StaticMap
from fric.log import Log
from fric.simulate.validation import validate_closed_loop, validate_open_loop

PLANT = Plant(A=2.0, B=0.4, T_d=0.5e-3, K_f=35.0)
CASCADE = Cascade(K_v=160.0, K_p=240.0, K_i=0.0, velocity_filter=500.0, sampling=1000.0)
LUGRE = models()["lugre"](StaticMap(20.0, 25.0, 5e-3, 1.0, 5.0), 1e6, 100.0)


@pytest.fixture(scope="module")
def log():
    """A record made by the axis itself, that begins in motion."""
    time = np.arange(5300) * 1e-3
    reference = 0.05 * (1 - np.cos(2 * np.pi * 0.5 * time))
    given = Log(time=time, position=reference, reference=reference, input=np.zeros_like(time))
    made = validate_closed_loop(given, PLANT, CASCADE, LUGRE, load=-3.0)
    position, force = made.signals["position"].simulated, made.signals["force"].simulated
    return replace(given, position=position, input=force / PLANT.K_f).slice(1300, 5300)


def test_the_axis_that_made_a_record_replays_it(log):
    closed = validate_closed_loop(log, PLANT, CASCADE, LUGRE, load=-3.0)
    assert closed.signals["position"].relative < 1e-5
    assert closed.signals["force"].relative < 0.02
    opened = validate_open_loop(log, PLANT, LUGRE, load=-3.0)
    assert opened.signals["velocity"].relative < 0.01
    assert "force" not in opened.signals


def test_a_wrong_axis_is_seen(log):
    right = validate_closed_loop(log, PLANT, CASCADE, LUGRE, load=-3.0)
    coulomb = validate_closed_loop(log, PLANT, CASCADE, StaticMap(20.0, 20.0, 1e-3), load=-3.0)
    heavy = validate_closed_loop(log, replace(PLANT, B=0.9 * PLANT.B), CASCADE, LUGRE, load=-3.0)
    assert coulomb.signals["force"].relative > 2 * right.signals["force"].relative
    assert heavy.signals["force"].relative > 0.05


def test_worst_second_holds_the_largest_error(log):
    bumped = replace(log, input=log.input + 0.5 * (np.abs(log.time - 3.5) < 0.2))
    first, stop = validate_closed_loop(bumped, PLANT, CASCADE, LUGRE, load=-3.0).worst
    assert log.time[first] <= 3.301 < 3.699 <= log.time[stop - 1]
    assert stop - first == 1000


def test_a_record_that_does_not_suit_is_refused(log):
    with pytest.raises(FricError, match="no reference"):
        validate_closed_loop(replace(log, reference=None), PLANT, CASCADE, LUGRE)
    with pytest.raises(FricError, match="sampled at 1000 Hz"):
        validate_closed_loop(log, PLANT, replace(CASCADE, sampling=4000.0), LUGRE)
    with pytest.raises(FricError, match="no position"):
        validate_open_loop(replace(log, position=None, velocity=log.position), PLANT, LUGRE)
