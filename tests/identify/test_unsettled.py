"""Strokes that end before the friction has settled: eq. (5) with a small C."""

from __future__ import annotations

import numpy as np
import pytest

from fric.friction.stribeck import StaticMap
from fric.identify.static_map.identify import StaticFit, identify_static
from fric.identify.static_map.points import stroke_points
from fric.log import Log
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


@pytest.mark.parametrize(("C", "gravity"), [(700.0, 0.0), (1000.0, 0.0), (1000.0, 40.0)])
def test_what_is_left_of_the_settling_is_taken_off_and_told(C: float, gravity: float) -> None:
    fits = [identify_static(strokes(seed, C, gravity=gravity)) for seed in range(8)]
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
    fit = identify_static(logs)
    assert not {"strokes-unsettled", "strokes-settling"} & {w.code for w in fit.warnings}
    assert [p.force for p in fit.points] == [p.force for p in stroke_points(logs)[0]]


def test_a_force_over_position_is_no_settling() -> None:
    logs = session(1, cogging=6.0)
    fit = identify_static(logs, over_position="off")
    assert [p.force for p in fit.points] == [p.force for p in stroke_points(logs)[0]]
