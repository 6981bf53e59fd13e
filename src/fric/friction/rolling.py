"""GMS friction on a real guideway: a level that varies as the balls pass."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from typing import Annotated, Any, ClassVar

import numpy as np

from fric.arrays import Real
from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction.base import Parameter, Property
from fric.friction.gms import GMS
from fric.kernels.elementary import sin
from fric.kernels.signatures import Step, compiled_step

_gms_step = GMS.step


@compiled_step
def _step(dz: float, v: float, dt: float, state: Real, parameters: Real) -> float:
    waves = int(parameters[0])
    gms = 1 + 3 * waves  # where the GMS parameters begin
    size = parameters.size - gms
    state[0] += dz
    level = 1.0
    for i in range(waves):
        amplitude, pitch, phase = parameters[1 + 3 * i], parameters[2 + 3 * i], parameters[3 + 3 * i]
        level += amplitude * sin(2.0 * pi * state[0] / pitch + phase)
    here = state[1 : 1 + size]  # the GMS parameters as they hold at this place
    for i in range(size):
        here[i] = parameters[gms + i]
    here[0] *= level
    here[1] *= level
    return _gms_step(dz, v, dt, state[1 + size :], here)


@dataclass(frozen=True)
class Rolling(GMS):
    """A GMS model whose Stribeck level depends on the position.

    ``s(v, z) = {1 + Σ_j amplitude_j·sin(2π·z/pitch_j + phase_j)}·s(v)``, with z from where the run begins; what
    follows from s(v) is eqs. (3) to (5). Rolling elements that enter and leave the loaded zone vary the friction of a
    guideway with the pitch of the elements, by some per cent.

    In a friction file it is the section ``rolling`` beside ``static`` and ``gms``.

    static, alpha, k, C: As in `GMS`.
    amplitude, pitch, phase: Relative amplitude [1], period along the stroke [m] and phase [rad] of each wave, each of
        shape (waves,).
    Raises FricError: When the waves differ in length, together reach 1, or have no positive pitch.
    """

    amplitude: Annotated[tuple[float, ...], Parameter("ratio", upper=1.0, doc="relative size along the stroke")] = ()
    pitch: Annotated[tuple[float, ...], Parameter("position", doc="period along the stroke")] = ()
    phase: Annotated[tuple[float, ...], Parameter("angle", lower=float("-inf"), doc="phase where the run begins")] = ()

    name: ClassVar[str] = "rolling"
    properties: ClassVar[frozenset[Property]] = frozenset({"passive", "pre-sliding", "no creep", "frictional lag"})
    step: ClassVar[Step] = _step
    identified: ClassVar[bool] = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if not len(self.amplitude) == len(self.pitch) == len(self.phase):
            raise FricError("amplitude, pitch and phase of 'rolling' differ in length", hint="Give one each per wave.")
        if sum(map(abs, self.amplitude)) >= 1 or any(pitch <= 0 for pitch in self.pitch):
            hint = "Some per cent are usual."
            raise FricError("the amplitudes of 'rolling' reach 1, or a pitch is not positive", hint=hint)

    @classmethod
    def declared(cls) -> dict[str, tuple[Parameter, ...]]:
        """Return the parameters of the GMS model, and the waves."""
        return {**GMS.declared(), **super().declared()}

    @classmethod
    def fields_from(cls, sections: Mapping[str, Mapping[str, Estimate]]) -> dict[str, Any]:
        """Return the fields that a friction file gives: its waves and its GMS model."""
        return {**GMS.fields_from(sections), **super(GMS, cls).fields_from(sections)}

    @property
    def even(self) -> GMS:
        """The GMS model without waves."""
        return GMS(self.static, self.alpha, self.k, self.C)

    @property
    def layout(self) -> str:
        """The order of `packed`."""
        return "[waves, (amplitude, pitch, phase) of each wave, GMS parameters]"

    def packed(self) -> Real:
        """Return the parameters as `layout` says."""
        waves = np.column_stack([self.amplitude, self.pitch, self.phase]).ravel()
        return np.array([len(self.amplitude), *waves, *self.even.packed()])

    def initial_state(self) -> Real:
        """Return ``[z, the GMS parameters at z, GMS state]`` of a relaxed contact."""
        return np.array([0.0, *self.even.packed(), *super().initial_state()])
