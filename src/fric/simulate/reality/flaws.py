"""What a real axis has beyond eq. (1) and one friction model: a class a flaw, each off by default."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import inf

from fric.errors import FricError


def _not_negative(flaw: object, name: str) -> None:
    for field in fields(flaw):  # type: ignore[arg-type]
        value = getattr(flaw, field.name)
        if isinstance(value, float) and not value >= 0.0:
            raise FricError(f"{name}: {field.name} is {value:g}", hint="Give zero or a positive value.")


def _positive(flaw: object, name: str, *which: str) -> None:
    for field in which:
        if not getattr(flaw, field) > 0.0:
            raise FricError(f"{name}: {field} is {getattr(flaw, field):g}", hint="Give a positive value.")


def _below_one(flaw: object, name: str, field: str) -> None:
    if not abs(getattr(flaw, field)) < 1.0:
        raise FricError(f"{name}: {field} is {getattr(flaw, field):g}", hint="Give a share below 1.")


@dataclass(frozen=True)
class ForceChannel:
    """What a drive makes of the force before it logs it.

    Parameters
    ----------
    lag
        Time by which the logged force is late against position and voltage [s].
    filter
        Corner of the drive's first-order low-pass on it, at the controller's rate [Hz].
    step
        Step in which it is logged, as one of the motor's current [N].
    """

    lag: float = 0.0
    filter: float = inf
    step: float = 0.0

    def __post_init__(self) -> None:
        _not_negative(self, "force")
        _positive(self, "force", "filter")


@dataclass(frozen=True)
class Clock:
    """When a trace takes its samples, and which of them are lost.

    Parameters
    ----------
    jitter
        Standard deviation of the instants of the samples around even ones [s].
    lost
        Share of the samples that is lost, here and there [1].
    position, input
        Time by which position and voltage are logged late, each against the clock [s].
    stamped
        Whether the time that is logged tells jitter and loss; else it is counted on evenly.
    """

    jitter: float = 0.0
    lost: float = 0.0
    position: float = 0.0
    input: float = 0.0
    stamped: bool = True

    def __post_init__(self) -> None:
        _not_negative(self, "clock")
        _below_one(self, "clock", "lost")


@dataclass(frozen=True)
class ColouredNoise:
    """Noise of the logged force that remembers: white noise behind a first-order low-pass.

    Parameters
    ----------
    force
        Its root mean square [N].
    corner
        Corner of the low-pass [Hz].
    """

    force: float
    corner: float

    def __post_init__(self) -> None:
        _not_negative(self, "noise")
        _positive(self, "noise", "corner")


@dataclass(frozen=True)
class Interpolation:
    """Sub-divisional error of an encoder: it tells ``z + error·sin(2π·z/pitch + phase)``, in whole steps.

    Parameters
    ----------
    error
        Amplitude [m].
    pitch
        Pitch of the scale's lines [m].
    phase
        Phase at position 0 [rad].
    """

    error: float
    pitch: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        _positive(self, "encoder", "pitch")


@dataclass(frozen=True)
class Cogging:
    """A force of the motor over position, ``force·sin(2π·z/pitch + phase)``, against positive motion.

    Parameters
    ----------
    force
        Amplitude [N].
    pitch
        Period [m].
    phase
        Phase at position 0 [rad].
    """

    force: float
    pitch: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        _positive(self, "cogging", "pitch")


@dataclass(frozen=True)
class Wave:
    """A level of friction that varies over position, by the factor ``1 + amplitude·sin(2π·z/pitch + phase)``.

    Parameters
    ----------
    amplitude
        Relative amplitude [1].
    pitch
        Period [m].
    phase
        Phase at position 0 [rad].
    """

    amplitude: float
    pitch: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        _positive(self, "waves", "pitch")
        _below_one(self, "waves", "amplitude")


@dataclass(frozen=True)
class Direction:
    """Friction of the negative direction, over that of the positive one.

    Parameters
    ----------
    level
        Of F_c and F_s [1].
    viscous
        Of sigma [1].
    """

    level: float = 1.0
    viscous: float = 1.0

    def __post_init__(self) -> None:
        _positive(self, "direction", "level")
        _not_negative(self, "direction")

    @property
    def is_none(self) -> bool:
        """Whether the directions are alike."""
        return self == Direction()


@dataclass(frozen=True)
class Dwell:
    """Static friction that grows with the age θ of the contact: ``F_s·(1 + growth·ln(1 + θ/time))``.

    The age follows the ageing law of rate-and-state friction, ``dθ/dt = 1 - θ·|v|/distance`` (A. Ruina, Journal of
    Geophysical Research 88, 1983, p. 10359): at rest it is the time of rest, in sliding ``distance/|v|``.

    Parameters
    ----------
    growth
        Growth for each factor e of the age [1].
    time
        Age from which it counts [s].
    distance
        Sliding that renews the contact [m].
    """

    growth: float
    time: float
    distance: float

    def __post_init__(self) -> None:
        _not_negative(self, "dwell")
        _positive(self, "dwell", "time", "distance")


@dataclass(frozen=True)
class Drift:
    """A factor that goes from 1 to ``1 + amount`` while the machine runs, ``1 + amount·(1 - exp(-t/time))``.

    Parameters
    ----------
    amount
        Where it goes, less 1 [1].
    time
        Time constant [s]; t counts from the first experiment of a session.
    """

    amount: float
    time: float

    def __post_init__(self) -> None:
        _positive(self, "drift", "time")
        if not self.amount > -1.0:
            raise FricError(f"the amount of a drift is {self.amount:g}", hint="Give more than -100 %.")


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

    force: ForceChannel = ForceChannel()
    clock: Clock = Clock()
    noise: ColouredNoise | None = None
    encoder: Interpolation | None = None
    cogging: tuple[Cogging, ...] = ()
    waves: tuple[Wave, ...] = ()
    direction: Direction = Direction()
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
        _not_negative(self, "second_mass")
        _positive(self, "second_mass", "mass", "stiffness")
        for name in ("encoder", "friction"):
            if getattr(self, name) not in {"motor", "table"}:
                raise FricError(
                    f"second_mass: the {name} is on the '{getattr(self, name)}'",
                    hint="It is on the motor or the table.",
                )


_OF_FRICTION = ("cogging", "waves", "direction", "dwell", "friction")
NONE = Reality()
