"""Strokes that end before the friction has settled: eq. (5) with a small C."""

from __future__ import annotations

import numpy as np
import pytest

from fric.friction import FrictionModel
from fric.friction.gms import GMS
from fric.friction.lugre import LuGre
from fric.friction.stribeck import StaticMap
from fric.identify.static_map.identify import StaticFit, identify_static
from fric.identify.static_map.points import Asked, stroke_points
from fric.log import Log
from fric.records.over_strokes import over_time
from fric.records.segments import steady_segments
from tests.chance import fewest
from tests.identify.constant_velocity import both_directions
from tests.identify.test_flaws import session

MAP = StaticMap(F_c=80.0, F_s=115.0, v_s=1.8e-3, delta=1.0, sigma=120.0)
SPEEDS = np.array([0.2, 0.5, 1, 2, 4, 8, 14, 20, 30]) * 1e-3


def strokes(seed: int, C: float, *, duration: float = 0.3, gravity: float = 0.0) -> list[Log]:
    """Return strokes that follow ``F' = C·(1 - F/s(v))`` from break-away on, and are even a tenth of a second later."""
    rng, found = np.random.default_rng(seed), []
    for v in both_directions(SPEEDS):
        lasting = max(duration, 0.5e-3 / abs(v))
        t = np.arange(int(4000 * lasting)) / 4000
        late = float(MAP.steady_state(abs(v))) - MAP.sigma * abs(v)
        friction = late + (MAP.F_s - late) * np.exp(-(t + 0.1) * C / late) + MAP.sigma * abs(v)
        force = np.sign(v) * friction + gravity + rng.standard_normal(len(t))
        position = np.round((v * t + rng.uniform(0, 1e-6)) / 1e-7) * 1e-7
        found.append(Log(t, position, force=force, kind="constant-velocity", name=f"{1e3 * v:g}"))
    return found


def holds(fit: StaticFit) -> dict[str, bool]:
    return {name: one.ci95[0] <= getattr(MAP, name) <= one.ci95[1]
            for name, one in fit.static.estimates.items() if name in {"F_c", "F_s", "v_s"}}  # fmt: skip


@pytest.mark.parametrize(
    ("C", "gravity"),
    [
        pytest.param(700.0, 0.0, marks=pytest.mark.long(3)),
        pytest.param(1000.0, 0.0, marks=pytest.mark.long(3)),
        (1000.0, 40.0),
    ],
)
def test_what_is_left_of_the_settling_is_taken_off_and_told(C: float, gravity: float) -> None:
    fits = [identify_static(strokes(seed, C, gravity=gravity), Asked()) for seed in range(8)]
    held = [one for fit in fits for one in holds(fit).values()]
    assert sum(held) >= fewest(24)  # chance of failing: one in a thousand
    off = [float(fit.static.estimates["F_c"]) / MAP.F_c - 1 for fit in fits]
    assert abs(np.median(off)) < 0.004
    plain = [abs(p.force - gravity) for p in stroke_points(strokes(0, C, gravity=gravity))[0] if p.velocity > 6e-3]
    assert min(plain) > 80.9  # what a stroke's mean shows: MAP has 81.4 at most, less of it
    for fit in fits:
        notice = next(w for w in fit.warnings if w.code == "strokes-settling")
        assert notice.severity == ("doubt" if C == 700.0 else "note")


def test_strokes_that_have_settled_are_left_alone() -> None:
    logs = strokes(1, 9600.0)
    fit = identify_static(logs, Asked())
    assert "strokes-settling" not in {w.code for w in fit.warnings}
    assert [p.force for p in fit.points] == [p.force for p in stroke_points(logs)[0]]


def test_a_force_over_position_is_no_settling() -> None:
    logs = session(1, cogging=6.0)
    fit = identify_static(logs, Asked(over_position="off"))
    assert [p.force for p in fit.points] == [p.force for p in stroke_points(logs)[0]]


def after_a_reversal(v: float, friction: FrictionModel, rng: np.random.Generator, cogging: float = 0.0) -> Log:
    """Return a stroke of three to eight seconds that begins with the contact loaded the other way."""
    t = np.arange(0.0, min(max(3.0, 0.03 / abs(v)), 8.0), 2e-3)
    velocity = np.append(-np.sign(v) * np.full(500, 2e-3), v * np.clip(t / 0.1, 0.0, 1.0))
    z = np.cumsum(velocity) * 2e-3
    force = friction.replay(np.arange(len(z)) * 2e-3, z, velocity) + cogging * np.sin(2 * np.pi * z / 0.011)
    force = force[500:] + rng.standard_normal(len(t))
    position = np.round(z[500:] / 1e-7) * 1e-7
    return Log(t, position, force=force, kind="constant-velocity", name=f"{1e3 * v:g}")


def test_strokes_that_end_before_the_axis_slides_are_left_out() -> None:
    """An Iwan spectrum up to 1.5 mm: half of its strokes never slide; F_c was 82.8 without any fall, and is 80."""
    slip = np.geomspace(1e-6, 1.5e-3, 20)
    iwan = GMS(MAP, (0.05,) * 20, tuple(0.05 * MAP.F_s / slip), 3e3)
    rng = np.random.default_rng(1)
    fit = identify_static(
        [after_a_reversal(v, iwan, rng) for v in both_directions(np.geomspace(2e-5, 3e-2, 8))], Asked()
    )
    for name, error in (("F_c", 0.4), ("F_s", 1.0)):
        assert abs(float(fit.static.estimates[name]) - getattr(MAP, name)) < error
    found = {one.code: one for one in fit.warnings}
    assert len(found["strokes-in-presliding"].values["speeds"]) >= 6
    assert "force-drifts" not in found


@pytest.mark.parametrize(("seed", "slowest"), [(0, 1e-4), (1, 3e-4)])
def test_what_a_law_does_to_strokes_of_a_speed_is_no_drift(seed: int, slowest: float) -> None:
    """LuGre with 4 N of cogging: the force rose within strokes by 12 and by 36 % a minute, *wrong*."""
    lugre, rng = LuGre(MAP, sigma_0=2e6, sigma_1=1e3), np.random.default_rng(seed)
    logs = [after_a_reversal(v, lugre, rng, 4.0) for v in both_directions(np.geomspace(slowest, 3e-2, 8))]
    assert over_time([(log, segment) for log in logs for segment in steady_segments(log)]) is None
