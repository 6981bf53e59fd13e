"""GMS friction on a real guideway: two directions that differ, and a level that varies as the balls pass."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sin
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from fric.errors import FricError
from fric.friction.base import Parameter, Property
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.kernels.signatures import Step, compiled_step

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from fric.estimate import Estimate

_gms_step = GMS.step


@compiled_step
def _step(dz: float, v: float, dt: float, state: NDArray[np.float64], parameters: NDArray[np.float64]) -> float:
    waves = int(parameters[0])
    gms = 6 + 3 * waves  # where the GMS parameters begin, after the negative direction's map
    own = parameters.size - gms
    state[0] += dz
    level = 1.0
    for i in range(waves):
        amplitude, pitch, phase = parameters[6 + 3 * i], parameters[7 + 3 * i], parameters[8 + 3 * i]
        level += amplitude * sin(2.0 * pi * state[0] / pitch + phase)
    here = state[1 : 1 + own]  # the GMS parameters as they hold at this place and in this direction
    negative = dz < 0.0 or (dz == 0.0 and v < 0.0)
    for i in range(5):
        here[i] = parameters[1 + i] if negative else parameters[gms + i]
    here[0] *= level
    here[1] *= level
    return _gms_step(dz, v, dt, state[1 + own :], here)


@dataclass(frozen=True)
class Rolling(GMS):
    """A GMS model whose Stribeck level depends on the direction and on the place along the stroke.

    ``s(v, z) = {1 + Σ_j amplitude_j·sin(2π·z/pitch_j + phase_j)}·s_±(v)``, with z from where the run begins; what
    follows from s(v) is eqs. (3) to (5). Rolling elements that enter and leave the loaded zone vary the friction of a
    guideway with the pitch of the elements, by some per cent; and its two directions are seldom alike.

    It stands in a friction file as ``rolling`` beside ``static``, ``gms`` and, where the directions differ,
    ``static_negative``.

    Parameters
    ----------
    static, alpha, k, C
        As in `GMS`; the static map is that of the positive direction.
    negative
        Static map of the negative direction; None where it is that of the positive one.
    amplitude, pitch, phase
        Relative amplitude [1], period along the stroke [m] and phase [rad] of each wave, each of shape (waves,).

    Raises
    ------
    FricError
        When the waves differ in length, together reach 1, or have no positive pitch.
    """

    negative: StaticMap | None = None
    amplitude: tuple[float, ...] = ()
    pitch: tuple[float, ...] = ()
    phase: tuple[float, ...] = ()

    name: ClassVar[str] = "rolling"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter(
            "amplitude", "ratio", upper=1.0, doc="relative amplitude along the stroke", per_block=True, typical=()
        ),
        Parameter("pitch", "position", doc="period along the stroke", per_block=True, typical=()),
        Parameter("phase", "angle", lower=float("-inf"), doc="phase where the run begins", per_block=True, typical=()),
    )
    properties: ClassVar[frozenset[Property]] = frozenset({"passive", "pre-sliding", "no creep", "frictional lag"})
    step: ClassVar[Step] = _step
    identified: ClassVar[bool] = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if not len(self.amplitude) == len(self.pitch) == len(self.phase):
            raise FricError("amplitude, pitch and phase of 'rolling' differ in length", mend="Give one each per wave.")
        if sum(map(abs, self.amplitude)) >= 1 or any(pitch <= 0 for pitch in self.pitch):
            raise FricError(
                "the amplitudes of 'rolling' reach 1, or a pitch is not positive", mend="Some per cent are usual."
            )

    @classmethod
    def fields_from(cls, sections: Mapping[str, Mapping[str, Estimate]]) -> dict[str, Any]:
        """Return the fields that a friction file gives: its waves, its GMS model, and both static maps."""
        negative = sections.get("static_negative")
        return {
            **GMS.fields_from(sections),
            **super(GMS, cls).fields_from(sections),
            "negative": StaticMap.from_sections({"static": negative}) if negative else None,
        }

    @classmethod
    def typical_fields(cls) -> dict[str, Any]:
        """Return the fields of `typical`: those of GMS, on a guideway without waves."""
        return {**GMS.typical_fields(), **super(GMS, cls).typical_fields()}

    def steady_state(self, v: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Return the force [N] at velocity v [m/s], averaged along the stroke."""
        v = np.asarray(v, float)
        return np.where(v < 0, (self.negative or self.static).steady_state(v), self.static.steady_state(v))

    def packed(self) -> NDArray[np.float64]:
        """Return ``[waves, negative map, (amplitude, pitch, phase) of each wave, GMS parameters]``."""
        waves = np.column_stack([self.amplitude, self.pitch, self.phase]).ravel()
        return np.array([len(self.amplitude), *(self.negative or self.static).packed(), *waves, *super().packed()])

    def initial_state(self) -> NDArray[np.float64]:
        """Return ``[z, the GMS parameters as they hold at z, GMS state]`` of a relaxed contact."""
        return np.array([0.0, *super().packed(), *super().initial_state()])
