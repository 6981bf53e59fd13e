"""What the friction and the motor of a real axis have beyond one friction model: a class a flaw."""

from dataclasses import dataclass

from fric.errors import FricError
from fric.simulate.reality.checks import below_one, not_negative, positive


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
