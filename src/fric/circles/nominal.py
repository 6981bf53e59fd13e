"""The nominal parameters of an axis, as coordinates in which it is tuned: logarithms about the nominal parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fric.arrays import Real
from fric.errors import FricError
from fric.friction import FrictionModel
from fric.friction.directed import Directed, mean_map
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap

FOUR = ("level", "stiffness", "C", "T_d")
"""What is tuned first."""
PRIORS = {"level": 0.5, "stiffness": 1.0, "C": 2.0, "T_d": 0.15, "ratio": 0.3, "v_s": 0.7, "delta": 0.3, "side": 0.2}
"""How far a coordinate may be from the nominal value: one standard deviation of its logarithm."""
PRIOR_ALPHA, PRIOR_K = 0.4, 0.7


@dataclass(frozen=True)
class Coordinates:
    """Coordinates about a friction model and a delay."""

    model: GMS  # The nominal friction
    T_d: float  # The nominal delay [s]
    # Coordinates that are free: of `FOUR`, ``ratio`` (what F_s exceeds F_c by), ``v_s``, ``delta``, ``alpha_i``,
    # ``k_i``, ``side`` (the level of the positive direction over that of the negative one)
    names: tuple[str, ...] = FOUR
    side: float = 0.0  # What ``side`` is nominally, as a logarithm

    @classmethod
    def of(cls, nominal: FrictionModel, T_d: float) -> Coordinates:
        """Return the four coordinates about a nominal model, which may have a map for each direction.

        Raises FricError: When it is no GMS model.
        """
        model = nominal.model if isinstance(nominal, Directed) else nominal
        if not isinstance(model, GMS):
            raise FricError(f"the nominal friction is {model.name}, and circles tune a GMS model")
        if isinstance(nominal, Directed):
            own, other = model.static, nominal.negative
            return cls(replace(model, static=mean_map(own, other)), T_d, side=float(np.log(own.F_c / other.F_c)))
        return cls(model, T_d)

    def full(self) -> Coordinates:
        """Return the coordinates of the whole shape."""
        model = self.model
        blocks = range(1, len(model.alpha) + 1)
        shape = ("ratio", "v_s", "delta") if model.static.F_s > model.static.F_c else ()
        alphas = tuple(f"alpha_{n}" for n in blocks) if len(model.alpha) > 1 else ()
        return replace(self, names=("level", "C", "T_d", *shape, *alphas, *(f"k_{n}" for n in blocks)))

    def sided(self) -> Coordinates:
        """Return the coordinates, and the difference between the directions."""
        return replace(self, names=(*self.names, "side"))

    @property
    def priors(self) -> Real:
        """Standard deviations of the coordinates, shape (p,)."""
        return np.array(
            [PRIOR_ALPHA if n.startswith("alpha") else PRIOR_K if n.startswith("k_") else PRIORS[n] for n in self.names]
        )

    @property
    def bounds(self) -> Real:
        """How far a coordinate is searched at most, shape (p,)."""
        return np.minimum(6.0 * self.priors, 3.5)

    def delay(self, x: Real) -> float:
        """Return the delay at a point [s]."""
        return self.T_d * float(np.exp(self._value(x, "T_d")))

    def sides(self, x: Real) -> float:
        """Return the logarithm of the positive direction's level over that of the negative one, at a point."""
        return self.side + self._value(x, "side")

    def directed(self, x: Real) -> FrictionModel:
        """Return the friction at a point, with a map for each direction where they differ."""
        model, half = self.friction(x), 0.5 * self.sides(x)
        if half == 0.0:
            return model
        up, down = (_scaled(model.static, float(np.exp(sign * half))) for sign in (1.0, -1.0))
        return Directed(replace(model, static=up), down)

    def friction(self, x: Real) -> GMS:
        """Return the friction at a point, the mean of both directions."""
        m = self.model
        level = float(np.exp(self._value(x, "level")))
        static = m.static
        F_c = static.F_c * level
        if "ratio" in self.names:  # of what F_s exceeds F_c by
            F_s = F_c * (1 + (static.F_s / static.F_c - 1) * float(np.exp(self._value(x, "ratio"))))
        else:
            F_s = static.F_s * level
        changed = replace(
            static, F_c=F_c, F_s=F_s, v_s=static.v_s * float(np.exp(self._value(x, "v_s"))),
            delta=static.delta * float(np.exp(self._value(x, "delta"))),
        )  # fmt: skip
        stiffness = self._value(x, "stiffness")
        k = tuple(value * float(np.exp(stiffness + self._value(x, f"k_{n}"))) for n, value in enumerate(m.k, start=1))
        alpha = [value * float(np.exp(self._value(x, f"alpha_{n}"))) for n, value in enumerate(m.alpha, start=1)]
        C = m.C * level * float(np.exp(self._value(x, "C")))
        return GMS(static=changed, alpha=tuple(value / sum(alpha) for value in alpha), k=k, C=C)

    def moved(self, other: Coordinates, x: Real) -> Real:
        """Return the point of these coordinates that is at a point of others about the same nominal model."""
        found = np.zeros(len(self.names))
        for n, name in enumerate(self.names):
            found[n] = other._value(x, name)
            if name.startswith("k_") and "stiffness" not in self.names:
                found[n] += other._value(x, "stiffness")
        return found

    def _value(self, x: Real, name: str) -> float:
        return float(x[self.names.index(name)]) if name in self.names else 0.0


def _scaled(static: StaticMap, level: float) -> StaticMap:
    return replace(static, F_c=static.F_c * level, F_s=static.F_s * level)


def parameters(model: GMS) -> dict[str, float | tuple[float, ...]]:
    """Return the parameters of a friction model by name, SI."""
    static = model.static
    return {
        "F_c": static.F_c, "F_s": static.F_s, "v_s": static.v_s, "delta": static.delta, "sigma": static.sigma,
        "alpha": model.alpha, "k": model.k, "C": model.C,
    }  # fmt: skip
