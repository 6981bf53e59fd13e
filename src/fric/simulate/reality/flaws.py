"""Properties of a real axis beyond eq. (1) and a friction model, each off by default."""

from dataclasses import dataclass, field
from typing import Annotated

from fric.errors import FricError
from fric.simulate.reality.parts import (
    Clock,
    Cogging,
    Direction,
    Drift,
    Dwell,
    ForceChannel,
    Interpolation,
    NoiseColour,
    Wave,
    not_negative,
    positive,
)


@dataclass(frozen=True)
class Excitation:
    """How the multisine of a frequency response is made.

    lines: Frequencies.
    lowest: First frequency; all are its multiples [Hz].
    highest: Last frequency [Hz].
    mean: Mean speed [m/s].
    peak: Peak speed of the multisine; half the mean where left out [m/s].
    """

    lines: int
    lowest: Annotated[float, "frequency"]
    highest: Annotated[float, "frequency"]
    mean: Annotated[float, "velocity"] = 30e-3
    peak: Annotated[float, "velocity"] = 0.0


@dataclass(frozen=True)
class Reality:
    """Properties of the axis beyond the model: simulated in logs and circles, never in nominal models.

    force: resolution, lag and clipping of the logged force
    clock: jitter and lost samples of the log
    noise: how the noise of the log is coloured
    encoder: error of the encoder between two of its lines
    cogging: forces of the motor over position
    waves: waves of the friction's level over position
    direction: by what friction differs in the negative direction
    gravity: a constant force against positive motion [N]
    dwell: by what friction at rest rises with time
    friction: drift of the level of friction
    force_constant: drift of the motor's force per volt; the drive keeps its first value
    multisine: excitation of the frequency response
    """

    force: ForceChannel = field(default_factory=ForceChannel)
    clock: Clock = field(default_factory=Clock)
    noise: NoiseColour | None = None
    encoder: Interpolation | None = None
    cogging: tuple[Cogging, ...] = ()
    waves: tuple[Wave, ...] = ()
    direction: Direction = field(default_factory=Direction)
    gravity: Annotated[float, "force"] = 0.0
    dwell: Dwell | None = None
    friction: Drift | None = None
    force_constant: Drift | None = None
    multisine: Excitation | None = None

    def __post_init__(self) -> None:
        if sum(abs(wave.amplitude) for wave in self.waves) >= 1.0:
            raise FricError("the waves of the friction together reach 1", hint="Some per cent are usual.")

    @property
    def moves_friction(self) -> bool:
        """Whether the friction depends on more than the state of the model."""
        return any(getattr(self, name) != getattr(NONE, name) for name in _OF_FRICTION)


@dataclass(frozen=True)
class SecondMass:
    """A table on a spring behind the motor, instead of one rigid mass.

    mass: Of the table, a part of the moving mass [kg].
    stiffness: Of the spring [N/m].
    damping: Beside the spring [N·s/m].
    backlash: Play from flank to flank [m].
    encoder: Where it is: motor or table.
    friction: Where it acts: motor or table.
    """

    mass: Annotated[float, "mass"]
    stiffness: Annotated[float, "stiffness"]
    damping: Annotated[float, "viscous"] = 0.0
    backlash: Annotated[float, "position"] = 0.0
    encoder: str = "motor"
    friction: str = "table"

    def __post_init__(self) -> None:
        not_negative(self, "second_mass")
        positive(self, "second_mass", "mass", "stiffness")
        for name in ("encoder", "friction"):
            if getattr(self, name) not in {"motor", "table"}:
                raise FricError(
                    f"second_mass: the {name} is on the '{getattr(self, name)}'",
                    hint="It is on the motor or the table.",
                )


_OF_FRICTION = ("cogging", "waves", "direction", "dwell", "friction")
NONE = Reality()
