"""The Dahl model: a spring that yields as it nears the Coulomb force (AIAA Journal 14, 1976)."""

from dataclasses import dataclass
from math import copysign
from typing import Annotated, ClassVar

import numpy as np
from numba import types

from fric.arrays import Real
from fric.friction.base import FrictionModel, Parameter, Property
from fric.kernels.elementary import exp, log1p, power
from fric.kernels.increments import reversal
from fric.kernels.signatures import Step, compiled, compiled_step

_FLOAT = types.float64


@compiled(_FLOAT(_FLOAT, _FLOAT, _FLOAT, _FLOAT, _FLOAT), makes_arrays=False)
def _advance(F: float, dz: float, F_c: float, sigma_0: float, n: float) -> float:
    """Return the force after a motion dz without reversal: the exact solution, for any n and any dz, of
    ``dw/d|z| = -sigma_0/F_c·w^n`` with ``w = 1 - F·sign(dz)/F_c``.
    """
    direction = copysign(1.0, dz)
    w = max(1.0 - direction * F / F_c, 0.0)
    if dz == 0.0 or w == 0.0:
        return F
    x = sigma_0 / F_c * abs(dz) * power(w, n - 1.0)
    if abs(n - 1.0) < 1e-9:
        w *= exp(-x)
    elif (n - 1.0) * x <= -1.0:  # n < 1: the force saturates after a finite travel
        w = 0.0
    else:
        w *= exp(-log1p((n - 1.0) * x) / (n - 1.0))
    return direction * F_c * (1.0 - w)


@compiled_step
def _step(dz: float, v: float, dt: float, state: Real, parameters: Real) -> float:
    F_c, sigma_0, n, sigma = parameters[0], parameters[1], parameters[2], parameters[3]
    before, _ = reversal(state[0], v, dt)
    F = _advance(state[1], before, F_c, sigma_0, n)
    F = _advance(F, dz - before, F_c, sigma_0, n)
    state[0], state[1] = v, F
    return F + sigma * v


@dataclass(frozen=True)
class Dahl(FrictionModel):
    """The model of P. R. Dahl: the stiffness falls to zero as the force nears the Coulomb level, at any speed.

    ``dF_0/dz = sigma_0·(1 - F_0·sign(v)/F_c)^n`` and ``F = F_0 + sigma·v``; integrated exactly.

    It has neither a Stribeck curve nor a break-away force above F_c. A minor loop does not close, and under a load
    that vibrates below F_c it creeps. The viscous part is not Dahl's; it is here so that sliding can be compared.

    F_c: Coulomb friction [N].
    sigma_0: Stiffness at rest [N/m].
    n: Shape of the transition: 1 exponential, below 1 brittle, above 1 ductile [1].
    sigma: Viscous friction [N·s/m].
    """

    F_c: Annotated[float, Parameter("force", doc="Coulomb friction", typical=100.0)]
    sigma_0: Annotated[float, Parameter("stiffness", doc="stiffness at rest", typical=5e7)]
    n: Annotated[float, Parameter("ratio", upper=5.0, doc="shape of the transition", held=True)] = 1.0
    sigma: Annotated[float, Parameter("viscous", doc="viscous friction", typical=40.0)] = 0.0

    name: ClassVar[str] = "dahl"
    properties: ClassVar[frozenset[Property]] = frozenset({"bounded", "passive", "pre-sliding"})
    step: ClassVar[Step] = _step

    def sliding_force(self, v: Real) -> Real:
        """Return ``F_c·sign(v) + sigma·v`` [N] at velocity v [m/s]."""
        return self.F_c * np.sign(v) + self.sigma * v

    def initial_state(self) -> Real:
        """Return ``[v, F_0]`` at rest."""
        return np.zeros(2)
