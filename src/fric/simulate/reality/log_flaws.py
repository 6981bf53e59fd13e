"""What a drive makes of a motion when it logs it: a class a flaw, each off by default."""

from dataclasses import dataclass
from math import inf

from fric.simulate.reality.checks import below_one, not_negative, positive


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
