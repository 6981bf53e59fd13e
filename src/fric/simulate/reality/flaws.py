"""What a real axis has beyond eq. (1) and one friction model, each off by default."""

from dataclasses import dataclass, field

from fric.errors import FricError
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
    not_negative,
    positive,
)


@dataclass(frozen=True)
class Excitation:
    """How the multisine of a frequency response is made on this machine, where it is not said.

    Parameters
    ----------
    lines
        Frequencies.
    lowest, highest
        First and last frequency [Hz].
    mean, peak
        Mean speed, and peak velocity of the multisine [m/s]; half the mean where the peak is 0.
    """

    lines: int = 60
    lowest: float = 2.0
    highest: float = 500.0
    mean: float = 30e-3
    peak: float = 0.0


@dataclass(frozen=True)
class Reality:
    """The flaws of one axis; none by default.

    Parameters
    ----------
    force, clock, noise, encoder, cogging, waves, direction, dwell
        See the class of each; of cogging and waves there may be several.
    gravity
        A constant force against positive motion [N].
    friction
        Drift of the level of friction.
    force_constant
        Drift of what the motor gives for a volt, while the drive goes on with what it was.
    multisine
        How it is excited.
    """

    force: ForceChannel = field(default_factory=ForceChannel)
    clock: Clock = field(default_factory=Clock)
    noise: ColouredNoise | None = None
    encoder: Interpolation | None = None
    cogging: tuple[Cogging, ...] = ()
    waves: tuple[Wave, ...] = ()
    direction: Direction = field(default_factory=Direction)
    gravity: float = 0.0
    dwell: Dwell | None = None
    friction: Drift | None = None
    force_constant: Drift | None = None
    multisine: Excitation | None = None

    def __post_init__(self) -> None:
        if sum(abs(wave.amplitude) for wave in self.waves) >= 1.0:
            raise FricError("the waves of the friction together reach 1", hint="Some per cent are usual.")

    @property
    def moves_friction(self) -> bool:
        """Whether the friction depends on more than the model's own state."""
        return any(getattr(self, name) != getattr(NONE, name) for name in _OF_FRICTION)


@dataclass(frozen=True)
class SecondMass:
    """A table on a spring behind the motor, instead of one rigid mass.

    Parameters
    ----------
    mass
        Mass of the table, a part of the moving mass [kg].
    stiffness
        Of the spring between motor and table [N/m].
    damping
        Beside the spring [N·s/m].
    backlash
        Play of the spring, from flank to flank [m].
    encoder
        Whether the encoder is on the ``motor`` or on the ``table``.
    friction
        On which of them the friction acts.
    """

    mass: float
    stiffness: float
    damping: float = 0.0
    backlash: float = 0.0
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
