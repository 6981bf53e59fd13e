"""The models that the shared tests run: every model of the package at its typical values, and some GMS models more."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fric.friction import FrictionModel, models
from fric.friction.gms import GMS
from fric.friction.stribeck import OnStaticMap, StaticMap

if TYPE_CHECKING:
    from fric.friction.base import Property

PAPER = StaticMap(F_c=105.0, F_s=165.0, v_s=1e-3, delta=1.0, sigma=40.0)
TABLE_1 = GMS(
    PAPER,
    alpha=tuple(a / 1.002 for a in (0.566, 0.227, 0.170, 0.039)),
    k=(99.94e6, 1.364e6, 1.081e6, 0.119e6),
    C=1e4,
)


def ten_blocks() -> GMS:
    """Return a model of ten blocks in no order, with a slow lag and a shape factor other than 1."""
    rng = np.random.default_rng(10)
    static = StaticMap(F_c=80.0, F_s=100.0, v_s=2e-3, delta=1.7, sigma=300.0)
    return GMS(static, tuple(rng.dirichlet(np.ones(10))), tuple(10 ** rng.uniform(5, 8, 10)), C=500.0)


INSTANCES: dict[str, FrictionModel] = {name: model.typical() for name, model in models().items()} | {
    "gms of Table 1": TABLE_1,
    "gms of one block": GMS(PAPER, (1.0,), (1e7,)),
    "gms of ten blocks": ten_blocks(),
    "gms without Stribeck effect": replace(TABLE_1, static=StaticMap(120.0, 120.0, 1e-3)),
}


def with_property(*claimed: Property) -> list[str]:
    """Return the names of the instances whose model claims all these properties."""
    return [name for name, model in INSTANCES.items() if model.properties.issuperset(claimed)]


def static_of(model: FrictionModel) -> StaticMap:
    """Return the static map of a model; where it has none, the one without Stribeck effect that it settles on."""
    if isinstance(model, StaticMap | OnStaticMap):
        return model if isinstance(model, StaticMap) else model.static
    level = float(model.steady_state(1e-300))
    return StaticMap(F_c=level, F_s=level, v_s=1e-3, sigma=getattr(model, "sigma", 0.0))


def with_viscous(model: FrictionModel, sigma: float) -> FrictionModel:
    """Return a model with another viscous friction."""
    return replace(
        model,
        **({"static": replace(model.static, sigma=sigma)} if isinstance(model, OnStaticMap) else {"sigma": sigma}),
    )


def without_weakening(model: FrictionModel) -> FrictionModel:
    """Return a model whose friction does not fall with speed."""
    return (
        replace(model, static=replace(model.static, F_c=model.static.F_s)) if isinstance(model, OnStaticMap) else model
    )


def stiffness_of(model: FrictionModel) -> float:
    """Return the slope of the virgin curve at its start [N/m], measured."""
    z = 1e-12
    return float(slowly(model, np.array([0.0, z]))[1]) / z


def slowly(model: FrictionModel, position: np.ndarray) -> np.ndarray:
    """Return the force along a path so slow that the Stribeck level is F_s, by one step a year."""
    time = 3e7 * np.arange(position.size)
    return model.replay(time, position, np.gradient(position, time) if position.size > 1 else np.zeros(1))
