"""What was found in a record in time."""

from dataclasses import asdict, dataclass, replace
from typing import Any

from fric.columns import Kind
from fric.estimate import Estimate
from fric.identify.records.recognition import Sine
from fric.identify.records.segments import Segment
from fric.notice import Notice


@dataclass(frozen=True)
class Use:
    """Whether a record is good for an identification, and why."""

    purpose: str
    good: bool
    why: str


@dataclass(frozen=True)
class Channel:
    """What a channel holds, in its SI unit.

    Parameters
    ----------
    unit
        Its SI unit.
    low, high
        Least and greatest value; None where there is no number at all.
    step
        Step of the lattice that its values lie on; None where there is none.
    not_a_number
        Samples that are no number.
    clipped
        Samples at which a force or an input is stuck at its extreme.
    """

    unit: str
    low: float | None
    high: float | None
    step: float | None = None
    not_a_number: int = 0
    clipped: int = 0


@dataclass(frozen=True)
class Gap:
    """Missing samples: the time before them [s], and how many sampling intervals long the gap is."""

    time: float
    intervals: float


@dataclass(frozen=True)
class Inspection:
    """What a record in time holds.

    Parameters
    ----------
    name, source, axis, motion, dropped
        As in `Log`.
    kind, stated
        The experiment it is, and whether the record says so (else it is recognised).
    samples, duration
        How many samples, and the time from the first to the last [s].
    sampling, jitter
        Sampling rate [Hz] by the median interval, and the standard deviation of the intervals [s], gaps left out.
    channels
        By name, what each channel holds.
    gaps
        Where samples are missing.
    segments
        At constant velocity, see `Segment`.
    speeds
        The velocities of the stretches, those within three per cent as one [m/s].
    sine
        The sine that the motion follows, where it does.
    reversals
        Samples at which the motion turns round.
    rise
        Share of the stroke that the force takes to come up after a reversal, see `force_rise`.
    excites
        Whether the motion tells mass, viscous and Coulomb friction apart.
    slope
        Least slope of the branches between reversals relative to their mean, see `branch_slope`; None without force.
    energy
        Energy lost per cycle [J] with its 95 % interval, of the logged force; None without cycles.
    uses
        What the record is good for and what not.
    warnings
        What is amiss with its clock, its encoder, its strokes.
    """

    name: str
    source: str
    axis: str
    motion: str
    kind: Kind
    stated: bool
    samples: int
    duration: float
    sampling: float | None
    jitter: float
    channels: dict[str, Channel]
    gaps: tuple[Gap, ...] = ()
    segments: tuple[Segment, ...] = ()
    speeds: tuple[float, ...] = ()
    sine: Sine | None = None
    reversals: tuple[int, ...] = ()
    rise: float | None = None
    excites: bool = False
    slope: float | None = None
    energy: Estimate | None = None
    uses: tuple[Use, ...] = ()
    dropped: int = 0
    warnings: tuple[Notice, ...] = ()

    @property
    def encoder_step(self) -> float | None:
        """Step of the position encoder [m]; None where the position is not quantised, or not logged."""
        return self.channels["position"].step if "position" in self.channels else None

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain numbers in SI, lists and strings, as JSON takes it."""
        segments = [
            {"start": s.start, "stop": s.stop, "velocity": s.velocity, "velocity_se": s.velocity_se}
            | {"settled": s.settled}
            for s in self.segments
        ]
        fields = asdict(replace(self, segments=(), warnings=()))
        fields |= {"warnings": list(map(str, self.warnings))}
        fields |= {"warnings_coded": [warning.as_dict() for warning in self.warnings]}
        fields["reversals"] = list(fields.pop("reversals"))
        del fields["segments"]
        fields["energy"] = None if self.energy is None else self.energy.as_dict()
        return fields | {"stretches": segments, "encoder_step": self.encoder_step}
