"""The walk-through of docs/new-correction.md is true: a zero that walks is taken off, other strokes are left alone."""

import re
from pathlib import Path

import numpy as np
import pytest

from fric.identify.static_map import corrections
from fric.identify.static_map.identify import identify_static
from fric.identify.static_map.points import Asked, SpeedPoint, Strokes
from fric.log import ForceVelocity

PAGE = (Path(__file__).parents[2] / "docs/new-correction.md").read_text("utf-8")
F_C, F_S = 50.0, 80.0


def strokes(seed: int, walk: float) -> Strokes:
    """Return strokes of ten seconds at twelve speeds of a sensor whose zero walks by ``walk`` [N/s]."""
    rng = np.random.default_rng(seed)
    v = np.outer(np.geomspace(1e-4, 0.05, 12), [1.0, -1.0]).ravel()
    begin = 10.0 * rng.permutation(len(v))
    force = np.sign(v) * (F_C + (F_S - F_C) * np.exp(-np.abs(v) / 2e-3)) + 100.0 * v
    force += walk * (begin + 5.0) + 0.1 * rng.standard_normal(len(v))
    made = [SpeedPoint(a, b, 0.1, 1000, "run", t, t + 10.0) for a, b, t in zip(v, force, begin, strict=True)]
    return Strokes.at(made, Asked(delta=1.0, direction="both", form="stribeck"))


@pytest.fixture
def walking_zero():
    (code,) = re.findall(r"^```python\n(.*?)^```", PAGE, flags=re.MULTILINE | re.DOTALL)
    names = dict(vars(corrections))
    exec(code, names)
    return names["walking_zero"]


def test_a_walk_is_taken_off_within_its_error(walking_zero):
    given = strokes(1, 0.05)
    made = given.without(walking_zero(given))
    less = np.array([a.force - b.force for a, b in zip(given.points, made.points, strict=True)])
    t = np.array([point.start for point in given.points])
    assert np.polyfit(t, less, 1)[0] == pytest.approx(0.05, abs=0.003)
    assert made.together.shape == (1, len(t))


def test_strokes_without_a_walk_are_left_alone(walking_zero):
    """Chance of failing: three of 20 beyond 4 standard errors of t with 18 degrees are below 1e-6."""
    assert sum(walking_zero(strokes(seed, 0.0)) is not None for seed in range(20)) <= 2


def test_the_table_makes_it_for_a_map(walking_zero, monkeypatch):
    seen = []
    monkeypatch.setitem(corrections.OF_A_MAP, "walking zero", lambda found: seen.append(len(found.points)) or None)
    v = np.outer([-1.0, 1.0], np.geomspace(1e-4, 0.05, 8)).ravel()
    F = np.sign(v) * (F_C + 30.0 * np.exp(-np.abs(v) / 2e-3))
    identify_static([ForceVelocity(v, F, error=np.full(16, 0.1), name="run")], Asked(delta=1.0))
    assert seen
