"""Properties of a real axis beyond eq. (1) and a friction model, each off by default."""

from dataclasses import dataclass, field
from math import inf
from typing import Annotated, ClassVar, dataclass_transform

from fric.errors import FricError, require_known
from fric.verb import require_within, typed


@dataclass_transform(frozen_default=True)
class Bounded:
    """A flaw, a frozen dataclass whose numbers have bounds, which it states beside its name in files."""

    _bounds: ClassVar[tuple[str, bool, tuple[str, ...], str]]

    def __init_subclass__(
        cls, of: str, *, signed: bool = False, positive: tuple[str, ...] = (), share: str = ""
    ) -> None:
        cls._bounds = of, signed, positive, share
        dataclass(frozen=True)(cls)

    def __post_init__(self) -> None:
        of, signed, positive, share = self._bounds
        form, part = ("(-{0}, {0})", "(-1, 1)") if signed else ("[0, {0})", "[0, 1)")
        hints = {name: getattr(hint, "__metadata__", ()) for name, hint in type(self).__annotations__.items()}
        ranges = {name: form.format("1e3" if "ratio" in kind else "1e15") for name, kind in hints.items() if kind}
        ranges |= dict.fromkeys(positive, "(0, inf]") | ({share: part} if share else {})
        require_within(self, of, **ranges)


class Cogging(Bounded, of="cogging", signed=True, positive=("pitch",)):
    """A force of the motor over position.

    It is ``force·sin(2π·z/pitch + phase)``, against positive motion.
    """

    force: Annotated[float, "force"]  #: Amplitude [N]
    pitch: Annotated[float, "position"]  #: Period [m]
    phase: Annotated[float, "angle"] = 0.0  #: Phase at position 0 [rad]


class Wave(Bounded, of="waves", signed=True, positive=("pitch",), share="amplitude"):
    """A wave of the friction's level over position.

    The level varies by the factor ``1 + amplitude·sin(2π·z/pitch + phase)``.
    """

    amplitude: Annotated[float, "ratio"]  #: Relative amplitude [1]
    pitch: Annotated[float, "position"]  #: Period [m]
    phase: Annotated[float, "angle"] = 0.0  #: Phase at position 0 [rad]


class Direction(Bounded, of="direction", positive=("level",)):
    """Friction of the negative direction, over that of the positive direction."""

    level: Annotated[float, "ratio"] = 1.0  #: Of F_c and F_s [1]
    viscous: Annotated[float, "ratio"] = 1.0  #: Of sigma [1]


class Dwell(Bounded, of="dwell", positive=("time", "distance")):
    """Static friction that grows with the age of the contact: F_s·(1 + growth·ln(1 + age/time)).

    The age θ follows the ageing law of rate-and-state friction, ``dθ/dt = 1 - θ·|v|/distance`` (A. Ruina, Journal of
    Geophysical Research 88, 1983, p. 10359): at rest it is the time of rest, in sliding ``distance/|v|``.
    """

    growth: Annotated[float, "ratio"]  #: Growth for each factor e of the age [1]
    time: Annotated[float, "time"]  #: Age from which it counts [s]
    distance: Annotated[float, "position"]  #: Sliding that renews the contact [m]


class Drift(Bounded, of="drift", signed=True, positive=("time",)):
    """A factor that changes from 1 to 1 + amount.

    It does so while the machine runs, as ``1 + amount·(1 - exp(-t/time))``.
    """

    amount: Annotated[float, "ratio"]  #: Its final value, less 1 [1]
    time: Annotated[float, "time"]  #: Time constant, from the first experiment of a session [s]

    def __post_init__(self) -> None:
        super().__post_init__()
        require_within(self, "drift", amount="(-1, 1e3)")


class ForceChannel(Bounded, of="force", positive=("filter",)):
    """What the drive makes of the force before it logs it."""

    lag: Annotated[float, "time"] = 0.0  #: Time by which it is late against position and voltage [s]
    filter: Annotated[float, "frequency"] = inf  #: Corner of a first-order low-pass [Hz], at the controller's rate
    step: Annotated[float, "force"] = 0.0  #: Step in which it is logged, as one of the motor's current [N]


class Clock(Bounded, of="clock", share="lost"):
    """Instants of the samples."""

    jitter: Annotated[float, "time"] = 0.0  #: Standard deviation of the instants [s], around even ones
    lost: Annotated[float, "ratio"] = 0.0  #: Share of the samples that is lost at random [1]
    position: Annotated[float, "time"] = 0.0  #: Time by which the position is logged late [s], against the clock
    input: Annotated[float, "time"] = 0.0  #: Time by which the voltage is logged late [s], against the clock
    stamped: bool = True  #: Whether the logged time shows jitter and loss. Else it is evenly spaced.


class NoiseColour(Bounded, of="noise", positive=("corner",)):
    """Noise of the logged force that remembers.

    It is white noise behind a first-order low-pass.
    """

    force: Annotated[float, "force"]  #: Root mean square [N]
    corner: Annotated[float, "frequency"]  #: Corner of the low-pass that it is behind [Hz]


class Interpolation(Bounded, of="encoder", signed=True, positive=("pitch",)):
    """Sub-divisional error of the encoder.

    Its reading is ``z + error·sin(2π·z/pitch + phase)``, in whole steps.
    """

    error: Annotated[float, "position"]  #: Amplitude [m]
    pitch: Annotated[float, "position"]  #: Pitch of the scale's lines [m]
    phase: Annotated[float, "angle"] = 0.0  #: Phase at position 0 [rad]


@typed
class Excitation(Bounded, of="multisine", positive=("lowest", "highest")):
    """How the multisine of a frequency response is made."""

    lines: int  #: Frequencies
    lowest: Annotated[float, "frequency"]  #: First frequency; all are its multiples [Hz]
    highest: Annotated[float, "frequency"]  #: Last frequency [Hz]
    mean: Annotated[float, "velocity"] = 30e-3  #: Mean speed [m/s]
    peak: Annotated[float, "velocity"] = 0.0  #: Peak speed of the multisine; half the mean where left out [m/s]


@typed
class Reality(Bounded, of="reality", signed=True):
    """Properties of the axis beyond the model: simulated in logs and circles, never in nominal models."""

    force: ForceChannel = field(default_factory=ForceChannel)  #: Resolution, lag and clipping of the logged force
    clock: Clock = field(default_factory=Clock)  #: Jitter and lost samples of the log
    noise: NoiseColour | None = None  #: How the noise of the log is coloured
    encoder: Interpolation | None = None  #: Error of the encoder between two of its lines
    cogging: tuple[Cogging, ...] = ()  #: Forces of the motor over position
    waves: tuple[Wave, ...] = ()  #: Waves of the friction's level over position
    direction: Direction = field(default_factory=Direction)  #: By what friction differs in the negative direction
    gravity: Annotated[float, "force"] = 0.0  #: A constant force against positive motion [N]
    dwell: Dwell | None = None  #: By what friction at rest rises with time
    friction: Drift | None = None  #: Drift of the level of friction
    force_constant: Drift | None = None  #: Drift of the motor's force per volt; the drive keeps its first value
    multisine: Excitation | None = None  #: Excitation of the frequency response

    def __post_init__(self) -> None:
        super().__post_init__()
        if sum(abs(wave.amplitude) for wave in self.waves) >= 1.0:
            raise FricError("the waves of the friction together reach 1", hint="Some per cent are usual.")

    @property
    def moves_friction(self) -> bool:
        """Whether the friction depends on more than the state of the model."""
        return any(getattr(self, name) != getattr(NONE, name) for name in _OF_FRICTION)


class SecondMass(Bounded, of="second_mass", positive=("mass", "stiffness")):
    """A table on a spring behind the motor, instead of one rigid mass."""

    mass: Annotated[float, "mass"]  #: Of the table, a part of the moving mass [kg]
    stiffness: Annotated[float, "stiffness"]  #: Of the spring [N/m]
    damping: Annotated[float, "viscous"] = 0.0  #: Beside the spring [N·s/m]
    backlash: Annotated[float, "position"] = 0.0  #: Play from flank to flank [m]
    encoder: str = "motor"  #: Where it is: motor or table
    friction: str = "table"  #: Where it acts: motor or table

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("encoder", "friction"):
            require_known(getattr(self, name), ("motor", "table"), f"{name} of second_mass is", "It is on")


_OF_FRICTION = ("cogging", "waves", "direction", "dwell", "friction")
NONE = Reality()
