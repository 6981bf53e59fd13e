"""The LuGre model: bristles that bend and slip (Canudas de Wit, Olsson, Åström, Lischinsky, IEEE TAC 40, 1995)."""

from dataclasses import dataclass
from math import copysign
from typing import Annotated, ClassVar

import numpy as np

from fric.arrays import Real
from fric.friction.base import Parameter, Property
from fric.friction.stribeck import OnStaticMap, stribeck_level
from fric.kernels.increments import relax, reversal
from fric.kernels.signatures import Step, compiled_step


@compiled_step
def _step(dz: float, v: float, dt: float, state: Real, parameters: Real) -> float:
    F_c, F_s, v_s, delta, sigma = parameters[0], parameters[1], parameters[2], parameters[3], parameters[4]
    sigma_0, sigma_1 = parameters[5], parameters[6]
    s_0, F = state[1], state[2]
    s_1 = stribeck_level(v, F_c, F_s, v_s, delta)
    before, _ = reversal(state[0], v, dt)
    if before != 0.0:
        left, pull = relax(s_0, F_s, sigma_0, abs(before))
        F = left * F + copysign(pull, before)
        dz, s_0 = dz - before, F_s
    left, pull = relax(s_0, s_1, sigma_0, abs(dz))
    F = left * F + copysign(pull, dz)
    state[0], state[1], state[2] = v, s_1, F
    return F + sigma_1 * (v - abs(v) * F / s_1) + sigma * v


@dataclass(frozen=True)
class LuGre(OnStaticMap):
    """The LuGre model: one elastic bristle deflection ζ that relaxes towards the Stribeck level.

    ``dζ/dt = v - sigma_0·|v|/s(v)·ζ`` and ``F = sigma_0·ζ + sigma_1·dζ/dt + sigma·v``, with s(v) of eq. (2).

    In the path z the first equation is linear, ``d(sigma_0·ζ)/d|z| = sigma_0·(1 - sigma_0·ζ·sign(v)/|s(v)|)``, and is
    solved in closed form over each increment (see `fric.kernels.increments.relax`). So a stiffness of 1e8 N/m at
    100 mm/s, where one step of 0.1 ms is eight relaxation lengths, is as stable and as cheap as a low stiffness.

    What it lacks: it has one state only, so a minor loop does not close and a branch depends on its start alone;
    and under a load that vibrates below break-away it creeps. Only without sigma_1 is it passive: with
    much of it, a load above a level that has fallen makes the damping push along the motion (Barabanov and
    Ortega, IEEE TAC 45, 2000).

    static: The static map: F_c, F_s, v_s, delta, sigma.
    sigma_0: Stiffness of the bristles [N/m].
    sigma_1: Damping of the bristles [N·s/m].
    """

    sigma_0: Annotated[float, Parameter("stiffness", doc="stiffness of the bristles", typical=5e7)]
    sigma_1: Annotated[float, Parameter("viscous", doc="damping of the bristles", typical=1e3)] = 0.0

    name: ClassVar[str] = "lugre"
    properties: ClassVar[frozenset[Property]] = frozenset({"pre-sliding", "frictional lag"})
    step: ClassVar[Step] = _step

    def initial_state(self) -> Real:
        """Return ``[v, |s(v)|, sigma_0·ζ]`` at rest."""
        return np.array([0.0, self.static.F_s, 0.0])
