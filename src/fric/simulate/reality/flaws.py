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

    force: Amplitude [N].
    pitch: Period [m].
    phase: Phase at position 0 [rad].
    """

    force: Annotated[float, "force"]
    pitch: Annotated[float, "position"]
    phase: Annotated[float, "angle"] = 0.0


class Wave(Bounded, of="waves", signed=True, positive=("pitch",), share="amplitude"):
    """A wave of the friction's level over position.

    The level varies by the factor ``1 + amplitude·sin(2π·z/pitch + phase)``.

    amplitude: Relative amplitude [1].
    pitch: Period [m].
    phase: Phase at position 0 [rad].
    """

    amplitude: Annotated[float, "ratio"]
    pitch: Annotated[float, "position"]
    phase: Annotated[float, "angle"] = 0.0


class Direction(Bounded, of="direction", positive=("level",)):
    """Friction of the negative direction, over that of the positive direction.

    level: Of F_c and F_s [1].
    viscous: Of sigma [1].
    """

    level: Annotated[float, "ratio"] = 1.0
    viscous: Annotated[float, "ratio"] = 1.0


class Dwell(Bounded, of="dwell", positive=("time", "distance")):
    """Static friction that grows with the age of the contact: F_s·(1 + growth·ln(1 + age/time)).

    The age θ follows the ageing law of rate-and-state friction, ``dθ/dt = 1 - θ·|v|/distance`` (A. Ruina, Journal of
    Geophysical Research 88, 1983, p. 10359): at rest it is the time of rest, in sliding ``distance/|v|``.

    growth: Growth for each factor e of the age [1].
    time: Age from which it counts [s].
    distance: Sliding that renews the contact [m].
    """

    growth: Annotated[float, "ratio"]
    time: Annotated[float, "time"]
    distance: Annotated[float, "position"]


class Drift(Bounded, of="drift", signed=True, positive=("time",)):
    """A factor that changes from 1 to 1 + amount.

    It does so while the machine runs, as ``1 + amount·(1 - exp(-t/time))``.

    amount: Its final value, less 1 [1].
    time: Time constant, from the first experiment of a session [s].
    """

    amount: Annotated[float, "ratio"]
    time: Annotated[float, "time"]

    def __post_init__(self) -> None:
        super().__post_init__()
        require_within(self, "drift", amount="(-1, 1e3)")


class ForceChannel(Bounded, of="force", positive=("filter",)):
    """What the drive makes of the force before it logs it.

    lag: Time by which it is late against position and voltage [s].
    filter: Corner of a first-order low-pass [Hz], at the controller's rate.
    step: Step in which it is logged, as one of the motor's current [N].
    """

    lag: Annotated[float, "time"] = 0.0
    filter: Annotated[float, "frequency"] = inf
    step: Annotated[float, "force"] = 0.0


class Clock(Bounded, of="clock", share="lost"):
    """Instants of the samples.

    jitter: Standard deviation of the instants [s], around even ones.
    lost: Share of the samples that is lost at random [1].
    position: Time by which the position is logged late [s], against the clock.
    input: Time by which the voltage is logged late [s], against the clock.
    stamped: Whether the logged time shows jitter and loss. Else it is evenly spaced.
    """

    jitter: Annotated[float, "time"] = 0.0
    lost: Annotated[float, "ratio"] = 0.0
    position: Annotated[float, "time"] = 0.0
    input: Annotated[float, "time"] = 0.0
    stamped: bool = True


class NoiseColour(Bounded, of="noise", positive=("corner",)):
    """Noise of the logged force that remembers.

    It is white noise behind a first-order low-pass.

    force: Root mean square [N].
    corner: Corner of the low-pass that it is behind [Hz].
    """

    force: Annotated[float, "force"]
    corner: Annotated[float, "frequency"]


class Interpolation(Bounded, of="encoder", signed=True, positive=("pitch",)):
    """Sub-divisional error of the encoder.

    Its reading is ``z + error·sin(2π·z/pitch + phase)``, in whole steps.

    error: Amplitude [m].
    pitch: Pitch of the scale's lines [m].
    phase: Phase at position 0 [rad].
    """

    error: Annotated[float, "position"]
    pitch: Annotated[float, "position"]
    phase: Annotated[float, "angle"] = 0.0


@typed
class Excitation(Bounded, of="multisine", positive=("lowest", "highest")):
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


@typed
class Reality(Bounded, of="reality", signed=True):
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
        super().__post_init__()
        if sum(abs(wave.amplitude) for wave in self.waves) >= 1.0:
            raise FricError("the waves of the friction together reach 1", hint="Some per cent are usual.")

    @property
    def moves_friction(self) -> bool:
        """Whether the friction depends on more than the state of the model."""
        return any(getattr(self, name) != getattr(NONE, name) for name in _OF_FRICTION)


class SecondMass(Bounded, of="second_mass", positive=("mass", "stiffness")):
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
        super().__post_init__()
        for name in ("encoder", "friction"):
            require_known(getattr(self, name), ("motor", "table"), f"{name} of second_mass is", "It is on")


_OF_FRICTION = ("cogging", "waves", "direction", "dwell", "friction")
NONE = Reality()
