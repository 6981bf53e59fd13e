"""The sections ``reality`` and ``second_mass`` of an axis in a machine file: flaws, each off where it is left out."""

from typing import Any, ClassVar

from pydantic import Field

from fric.documents.base import Physical, Quantity
from fric.estimate import Estimate
from fric.simulate.reality.flaws import Excitation, Reality, SecondMass
from fric.simulate.reality.parts import (
    Clock,
    Cogging,
    ColouredNoise,
    Direction,
    Drift,
    Dwell,
    ForceChannel,
    Interpolation,
    Wave,
)
from fric.units import Motion


class ForceChannelPart(Physical):
    """What the drive makes of the force before it logs it."""

    dimensions: ClassVar[dict[str, str]] = {"lag": "time", "filter": "frequency", "step": "force"}

    lag: Quantity | None = Field(None, description="time by which it is late against position and voltage")
    filter: Quantity | None = Field(None, description="corner of a first-order low-pass")
    step: Quantity | None = Field(None, description="step in which it is logged, as one of the motor's current")


class ClockPart(Physical):
    """When samples are taken."""

    dimensions: ClassVar[dict[str, str]] = {"jitter": "time", "lost": "ratio", "position": "time", "input": "time"}

    jitter: Quantity | None = Field(None, description="standard deviation of the instants")
    lost: Quantity | None = Field(None, description="share of the samples that is lost")
    position: Quantity | None = Field(None, description="time by which the position is logged late")
    input: Quantity | None = Field(None, description="time by which the voltage is logged late")
    stamped: bool = Field(True, description="whether the time that is logged tells jitter and loss")


class NoiseColourPart(Physical):
    """Noise of the logged force that remembers."""

    dimensions: ClassVar[dict[str, str]] = {"force": "force", "corner": "frequency"}

    force: Quantity = Field(description="root mean square")
    corner: Quantity = Field(description="corner of the low-pass that it is behind")


class InterpolationPart(Physical):
    """Sub-divisional error of the encoder."""

    dimensions: ClassVar[dict[str, str]] = {"error": "position", "pitch": "position", "phase": "angle"}

    error: Quantity = Field(description="amplitude")
    pitch: Quantity = Field(description="pitch of the scale's lines")
    phase: Quantity | None = Field(None, description="phase at position 0")


class CoggingPart(Physical):
    """A force of the motor over position."""

    dimensions: ClassVar[dict[str, str]] = {"force": "force", "pitch": "position", "phase": "angle"}

    force: Quantity = Field(description="amplitude")
    pitch: Quantity = Field(description="period")
    phase: Quantity | None = Field(None, description="phase at position 0")


class WavePart(Physical):
    """A wave of the friction's level over position."""

    dimensions: ClassVar[dict[str, str]] = {"amplitude": "ratio", "pitch": "position", "phase": "angle"}

    amplitude: Quantity = Field(description="relative amplitude")
    pitch: Quantity = Field(description="period")
    phase: Quantity | None = Field(None, description="phase at position 0")


class DirectionPart(Physical):
    """Friction of the negative direction, over that of the positive one."""

    dimensions: ClassVar[dict[str, str]] = {"level": "ratio", "viscous": "ratio"}

    level: Quantity | None = Field(None, description="of F_c and F_s")
    viscous: Quantity | None = Field(None, description="of sigma")


class DwellPart(Physical):
    """Static friction that grows with the age of the contact: F_s·(1 + growth·ln(1 + age/time))."""

    dimensions: ClassVar[dict[str, str]] = {"growth": "ratio", "time": "time", "distance": "position"}

    growth: Quantity = Field(description="growth for each factor e of the age")
    time: Quantity = Field(description="age from which it counts")
    distance: Quantity = Field(description="sliding that renews the contact")


class DriftPart(Physical):
    """A factor that goes from 1 to 1 + amount."""

    dimensions: ClassVar[dict[str, str]] = {"amount": "ratio", "time": "time"}

    amount: Quantity = Field(description="where it goes, less 1")
    time: Quantity = Field(description="time constant, from the first experiment of a session")


class ExcitationPart(Physical):
    """How the multisine of a frequency response is made."""

    dimensions: ClassVar[dict[str, str]] = {
        "lowest": "frequency", "highest": "frequency", "mean": "velocity", "peak": "velocity",
    }  # fmt: skip

    lines: int = Field(description="frequencies")
    lowest: Quantity = Field(description="first frequency; all are its multiples")
    highest: Quantity = Field(description="last frequency")
    mean: Quantity | None = Field(None, description="mean speed")
    peak: Quantity | None = Field(None, description="peak speed of the multisine; half the mean where left out")


class RealityPart(Physical):
    """What the axis has beyond the model: simulated in logs and circles, never part of what a controller believes."""

    dimensions: ClassVar[dict[str, str]] = {"gravity": "force"}

    force: ForceChannelPart | None = None
    clock: ClockPart | None = None
    noise: NoiseColourPart | None = None
    encoder: InterpolationPart | None = None
    cogging: list[CoggingPart] = Field(default_factory=list)
    waves: list[WavePart] = Field(default_factory=list)
    direction: DirectionPart | None = None
    gravity: Quantity | None = Field(None, description="a constant force against positive motion")
    dwell: DwellPart | None = None
    friction: DriftPart | None = Field(None, description="drift of the level of friction")
    force_constant: DriftPart | None = Field(None, description="drift of what the motor gives for a volt")
    multisine: ExcitationPart | None = None

    def estimates(self, motion: Motion, where: str = "") -> dict[str, Estimate]:
        """Return gravity, once every other flaw has been looked at too; raise ValueError with the mend on a misfit."""
        for name in _PARTS:
            for n, part in enumerate(_several(getattr(self, name))):
                part.estimates(motion, f"{where}.{name}" + (f".{n}" if isinstance(getattr(self, name), list) else ""))
        return super().estimates(motion, where)

    def reality(self, motion: Motion) -> Reality:
        """Return the flaws in SI; raise a `FricError` where one is not physical."""
        found: dict[str, Any] = {}
        for name, flaw in _PARTS.items():
            given = getattr(self, name)
            made = tuple(
                flaw(**part.values(motion), **part.model_dump(include={"stamped", "lines"})) for part in _several(given)
            )
            if made:
                found[name] = made if isinstance(given, list) else made[0]
        return Reality(**found | self.values(motion))


_PARTS: dict[str, Any] = {
    "force": ForceChannel, "clock": Clock, "noise": ColouredNoise, "encoder": Interpolation, "cogging": Cogging,
    "waves": Wave, "direction": Direction, "dwell": Dwell, "friction": Drift, "force_constant": Drift,
    "multisine": Excitation,
}  # fmt: skip


def _several(part: Any) -> list[Any]:
    return part if isinstance(part, list) else [] if part is None else [part]


class SecondMassPart(Physical):
    """A table on a spring behind the motor, instead of one rigid mass."""

    dimensions: ClassVar[dict[str, str]] = {
        "mass": "mass", "stiffness": "stiffness", "damping": "viscous", "backlash": "position",
    }  # fmt: skip

    mass: Quantity = Field(description="of the table, a part of the moving mass")
    stiffness: Quantity = Field(description="of the spring")
    damping: Quantity | None = Field(None, description="beside the spring")
    backlash: Quantity | None = Field(None, description="play from flank to flank")
    encoder: str = Field("motor", description="where it is: motor or table")
    friction: str = Field("table", description="where it acts: motor or table")

    def second_mass(self, motion: Motion) -> SecondMass:
        """Return it in SI; raise a `FricError` where it is not physical."""
        return SecondMass(**self.values(motion), encoder=self.encoder, friction=self.friction)
