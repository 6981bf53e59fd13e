"""What a real axis has beyond the models, in its logs, its friction and its motor: a class a flaw."""

from dataclasses import dataclass, fields
from math import inf

from fric.errors import FricError


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
        positive(self, "cogging", "pitch")


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
        positive(self, "waves", "pitch")
        below_one(self, "waves", "amplitude")


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
        positive(self, "direction", "level")
        not_negative(self, "direction")

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
        not_negative(self, "dwell")
        positive(self, "dwell", "time", "distance")


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
        positive(self, "drift", "time")
        if not self.amount > -1.0:
            raise FricError(f"the amount of a drift is {self.amount:g}", hint="Give more than -100 %.")


def not_negative(flaw: object, name: str) -> None:
    """Raise `FricError` where a number of a flaw is negative."""
    for field in fields(flaw):  # type: ignore[arg-type]
        value = getattr(flaw, field.name)
        if isinstance(value, float) and not value >= 0.0:
            raise FricError(f"{name}: {field.name} is {value:g}", hint="Give zero or a positive value.")


def positive(flaw: object, name: str, *which: str) -> None:
    """Raise `FricError` where one of these fields is not positive."""
    for field in which:
        if not getattr(flaw, field) > 0.0:
            raise FricError(f"{name}: {field} is {getattr(flaw, field):g}", hint="Give a positive value.")


def below_one(flaw: object, name: str, field: str) -> None:
    """Raise `FricError` where a share is not below 1."""
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
        not_negative(self, "force")
        positive(self, "force", "filter")


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
        not_negative(self, "clock")
        below_one(self, "clock", "lost")


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
        not_negative(self, "noise")
        positive(self, "noise", "corner")


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
        positive(self, "encoder", "pitch")
