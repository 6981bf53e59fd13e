"""A mass on each friction model, pushed by a load: break-away and creep."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from numba import types

from fric.friction import FrictionModel
from fric.kernels.signatures import STEP_FUNCTION, compiled
from tests.friction.instances import INSTANCES, static_of, with_property, without_weakening
from tests.turns import in_turns

MASS = 121.0
_ARRAY = types.float64[::1]


@compiled(types.void(STEP_FUNCTION, types.float64, types.float64, _ARRAY, _ARRAY, _ARRAY, _ARRAY))
def _push(step, mass, dt, load, state, parameters, position):
    z = v = friction = 0.0
    for n in range(load.size):
        v += dt * (load[n] - friction) / mass
        z += dt * v
        friction = step(dt * v, v, dt, state, parameters)
        position[n] = z


def push(model: FrictionModel, load: np.ndarray, dt: float) -> np.ndarray:
    """Return the position [m] of a mass at rest that is pushed by a load [N]."""
    position = np.empty(load.size)
    _push(type(model).step, MASS, dt, load, model.initial_state(), model.packed(), position)
    return position


PRESLIDING = with_property("pre-sliding")


@pytest.mark.parametrize(
    ("name", "weakening"),
    in_turns(product(PRESLIDING, (True, False)), [(name, n % 2 == 0) for n, name in enumerate(PRESLIDING)]),
)
def test_break_away_load_does_not_depend_on_the_step(name, weakening):
    """It is F_s; or less where friction falls with speed, and the mass on the last soft spring runs away before.

    That running away is an oscillation that grows, whose phase is a matter of luck.
    """
    model = INSTANCES[name] if weakening else without_weakening(INSTANCES[name])
    m = static_of(model)
    broke_away = {}
    for dt in (2e-5, 1e-4, 5e-4):
        time = np.arange(0.0, 20.0, dt)
        load = m.F_s * np.minimum(0.8 * time, 0.8 + (time - 1.0) / 75)
        position = push(model, load, dt)
        broke_away[dt] = load[np.argmax(np.gradient(position, dt) > 1e-3)]
    assert m.F_c <= broke_away[2e-5] < 1.01 * m.F_s
    for dt in (1e-4, 5e-4):
        assert broke_away[dt] == pytest.approx(broke_away[2e-5], rel=0.02 if weakening else 1e-4)


@pytest.mark.parametrize("name", with_property("no creep"))
@pytest.mark.parametrize(("mean", "swing"), in_turns([(0.0, 0.7), (0.5, 0.4), (-0.7, 0.2)], [(0.5, 0.4)]))
def test_a_vibrating_load_below_break_away_does_not_creep(name, mean, swing):
    m, dt, per_cycle = static_of(INSTANCES[name]), 1e-4, 2000
    cycles = 500  # in all 1e6 steps
    vibration = np.sin(2 * np.pi * np.arange(cycles * per_cycle) / per_cycle)
    ramp = np.minimum(np.arange(vibration.size) / (10 * per_cycle), 1.0)
    position = push(INSTANCES[name], ramp * m.F_s * (mean + swing * vibration), dt).reshape(cycles, per_cycle)
    excursion = np.ptp(position[-1])
    drift = position[-10:].mean() - position[50:60].mean()
    assert abs(drift) < 1e-3 * excursion
