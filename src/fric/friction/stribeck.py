"""The static friction map, eq. (2) of the paper, and what the models that settle on it share."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import copysign
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from numba import types

from fric.arrays import Real
from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction.base import FrictionModel, Parameter, Property
from fric.kernels.elementary import exp, power
from fric.kernels.signatures import Step, compiled, compiled_step
from fric.series import real
from fric.verb import refused


@compiled(types.float64(types.float64, types.float64, types.float64))
def stribeck_share(v: float, v_s: float, delta: float) -> float:
    """Return ``exp(-|v/v_s|^delta)`` [1], the share of F_s - F_c that is left at velocity v."""
    x = abs(v / v_s)
    if delta != 1.0:
        x = power(x, delta)
    return exp(-x) if x < 40.0 else 0.0  # beyond, the last digit of F_c does not change


@compiled(types.float64(types.float64, types.float64, types.float64, types.float64, types.float64))
def stribeck_level(v: float, F_c: float, F_s: float, v_s: float, delta: float) -> float:
    """Return |s(v)| [N], the Stribeck curve without its sign and without the viscous part."""
    return F_c + (F_s - F_c) * stribeck_share(v, v_s, delta)


@compiled(types.float64[::1](types.float64[::1], types.float64, types.float64))
def _shares(v: Real, v_s: float, delta: float) -> Real:
    found = np.empty_like(v)
    for n in range(len(v)):
        found[n] = stribeck_share(v[n], v_s, delta)
    return found


def stribeck_shares(v: Real | float, v_s: float, delta: float) -> Real:
    """Return `stribeck_share` at velocities v [m/s] of any shape."""
    given = real(v, "the Stribeck curve", "v")
    return _shares(given.ravel(), v_s, delta).reshape(given.shape)


@compiled_step
def _step(dz: float, v: float, dt: float, state: Real, parameters: Real) -> float:
    F_c, F_s, v_s, delta, sigma = parameters[0], parameters[1], parameters[2], parameters[3], parameters[4]
    if v == 0.0:
        return 0.0
    return copysign(stribeck_level(v, F_c, F_s, v_s, delta), v) + sigma * v


@dataclass(frozen=True)
class StaticMap(FrictionModel):
    """Coulomb, Stribeck and viscous friction in steady sliding, eq. (2).

    ``F(v) = {F_c + (F_s - F_c)·exp(-|v/v_s|^delta) + sigma·|v|}·sign(v)``

    At v = 0 the map has no value; here it is 0, half way between the two directions.

    F_c, F_s: Coulomb and static friction [N].
    v_s: Stribeck velocity [m/s].
    delta: Stribeck shape factor [1].
    sigma: Viscous friction [N·s/m].
    """

    F_c: Annotated[float, Parameter("force", doc="Coulomb friction", typical=100.0)]
    F_s: Annotated[float, Parameter("force", doc="static friction", typical=150.0, at_least="F_c")]
    v_s: Annotated[float, Parameter("velocity", doc="Stribeck velocity", typical=1e-3)]
    delta: Annotated[float, Parameter("ratio", lower=0.1, upper=4.0, doc="Stribeck shape factor", held=True)] = 1.0
    sigma: Annotated[float, Parameter("viscous", doc="viscous friction", typical=40.0)] = 0.0

    name: ClassVar[str] = "static"
    properties: ClassVar[frozenset[Property]] = frozenset({"bounded", "passive"})
    step: ClassVar[Step] = _step

    def level(self, v: Real | float) -> Real:
        """Return |s(v)| [N], the Stribeck curve without sign and without the viscous part."""
        return np.asarray(self.F_c + (self.F_s - self.F_c) * stribeck_shares(v, self.v_s, self.delta))

    def sliding_force(self, v: Real) -> Real:
        """Return the force of eq. (2) [N] at velocity v [m/s]."""
        v = real(v, "sliding_force", "v")
        return np.sign(v) * self.level(v) + self.sigma * v

    def initial_state(self) -> Real:
        """Return an empty state: the map has no memory."""
        return np.zeros(0)


STATIC_PARAMETERS = tuple(parameter.name for parameter in StaticMap.parameters)  # F_c, F_s, v_s, delta and sigma


@dataclass(frozen=True)
class OnStaticMap(FrictionModel):
    """A dynamic model whose steady state is a static map; its file has a ``static`` section, too.

    static: The static map that the model settles on at constant velocity.
    """

    static: StaticMap

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.static, StaticMap):
            raise refused(type(self).__name__, "static as a StaticMap", self.static)

    @classmethod
    def declared(cls) -> dict[str, tuple[Parameter, ...]]:
        """Return the parameters that determine this model, those of the static map first."""
        return {**StaticMap.declared(), **super().declared()}

    @classmethod
    def fields_from(cls, sections: Mapping[str, Mapping[str, Estimate]]) -> dict[str, Any]:
        """Return the fields that a friction file gives, the static map among them."""
        return {"static": StaticMap.from_sections(sections), **super().fields_from(sections)}

    def packed(self) -> Real:
        """Return ``[F_c, F_s, v_s, delta, sigma]`` of the static map, then the parameters of the model."""
        return np.append(self.static.packed(), super().packed())

    def sliding_force(self, v: Real) -> Real:
        """Return the force of the static map [N] at velocity v [m/s]."""
        return self.static.sliding_force(v)


@dataclass(frozen=True)
class OnBlocks(OnStaticMap):
    """A model of N slip blocks that carry shares of the Stribeck level.

    static: The static map: F_c, F_s, v_s, delta, sigma.
    alpha: Each block's share, shape (N,), Σ alpha = 1 [1].
    k: Each block's stiffness, shape (N,) [N/m].
    Raises FricError: When alpha is negative or does not sum to 1, when k is not positive, or the lengths differ.
    """

    alpha: Annotated[
        tuple[float, ...],
        Parameter("ratio", 0.0, 1.0, "share of the Stribeck level", typical=(0.6, 0.3, 0.1), shares=True),
    ]
    k: Annotated[tuple[float, ...], Parameter("stiffness", doc="stiffness of the block", typical=(1e8, 2e6, 2e5))]

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.alpha or len(self.alpha) != len(self.k):
            hint = "Give one of each for every block."
            raise FricError(f"{self.name} has {len(self.alpha)} alpha and {len(self.k)} k", hint=hint)
        if not (min(self.alpha) >= 0 and abs(sum(self.alpha) - 1) <= 1e-5):  # six digits each
            shares = ", ".join(f"{a:g}" for a in self.alpha)
            what = f"alpha of {self.name} is {shares}, which sums to {sum(self.alpha):g}"
            raise FricError(what, hint="The shares of the blocks are 0 or more and sum to 1.")
        if not all(k > 0 for k in self.k):
            raise FricError(f"k of {self.name} must be positive")

    @classmethod
    def from_sections(cls, sections: Mapping[str, Mapping[str, Estimate]]) -> Self:
        """Return the model that a friction file gives, with alpha normalised where it is rounded.

        A sum of alpha within 1 % of 1 is rounding (Table 1 of the paper sums to 1.002); more is refused.
        """
        fields = cls.fields_from(sections)
        total = sum(fields["alpha"])
        if abs(total - 1) <= 0.01:
            fields["alpha"] = tuple(a / total for a in fields["alpha"])
        return cls(**fields)

    @property
    def slip_displacements(self) -> Real:
        """Displacement from rest at which each block slips, ``alpha_i·F_s/k_i`` [m], shape (N,)."""
        return np.asarray(self.alpha) * self.static.F_s / np.asarray(self.k)

    def virgin_curve(self, z: Real | float) -> Real:
        """Return the force [N] of a relaxed contact that is slowly moved by z [m], ``Σ min(k_i·z, alpha_i·F_s)``."""
        path = real(z, "virgin_curve", "z")[..., np.newaxis]
        limit = np.asarray(self.alpha) * self.static.F_s
        return np.asarray(np.clip(np.asarray(self.k) * path, -limit, limit).sum(axis=-1))
