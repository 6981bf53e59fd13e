"""What was found in a record: over time, in frequency, or in a table of forces and velocities."""

from dataclasses import dataclass

import numpy as np

from fric.columns import FORCE_VELOCITY, Kind
from fric.estimate import Estimate
from fric.identify.records.recognition import Sine
from fric.identify.records.segments import Segment
from fric.log import ForceVelocity, FrequencyResponse
from fric.notice import Notice

SPEEDS = 5
"""Speeds that a map takes at least: as many as it has parameters, and one more."""


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
        The velocities of the segments, those within three per cent as one [m/s].
    sine
        The sine that the motion follows, where it does.
    reversals
        Samples at which the motion reverses.
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


@dataclass(frozen=True)
class ResponseInspection:
    """What a record in frequency holds.

    Parameters
    ----------
    name, source, axis, motion
        As in `FrequencyResponse`.
    points
        How many frequencies.
    low, high
        Lowest and highest frequency [Hz].
    coherence
        Least coherence; None where none was measured.
    uses
        What the record is good for and what not.
    kind, stated
        As in `Inspection`: such a record is a frequency response.
    """

    name: str
    source: str
    axis: str
    motion: str
    points: int
    low: float
    high: float
    coherence: float | None
    uses: tuple[Use, ...]
    kind: Kind = "frequency-response"
    stated: bool = True


@dataclass(frozen=True)
class TableInspection:
    """What a table of mean forces at velocities holds.

    Parameters
    ----------
    name, source, axis, motion
        As in `ForceVelocity`.
    points
        How many rows that move.
    directions
        Directions of motion that there are: 1 or 2.
    slowest, fastest
        Least and greatest speed [m/s].
    weakest, strongest
        Least and greatest size of a force [N].
    columns
        The columns that there are.
    uses
        What the record is good for and what not.
    kind, stated, warnings
        As in `Inspection`.
    """

    name: str
    source: str
    axis: str
    motion: str
    points: int
    directions: int
    slowest: float
    fastest: float
    weakest: float
    strongest: float
    columns: tuple[str, ...]
    uses: tuple[Use, ...]
    kind: Kind = FORCE_VELOCITY
    stated: bool = True
    warnings: tuple[Notice, ...] = ()


def inspect_response(record: FrequencyResponse) -> ResponseInspection:
    """Return what a measured frequency response holds."""
    frequency = record.frequency
    coherence = None if record.coherence is None else float(np.min(record.coherence))
    decades = float(np.log10(frequency[-1] / frequency[0])) if len(frequency) > 1 and frequency[0] > 0 else 0.0
    good = len(frequency) >= 8 and decades >= 1.0
    why = f"{len(frequency)} frequencies over {decades:.1f} decades" + (
        "" if good else ": 8 over one decade are needed"
    )
    return ResponseInspection(
        record.name, record.source, record.axis, record.motion, len(frequency), float(frequency.min()),
        float(frequency.max()), coherence, (Use("plant", good, why),),
    )  # fmt: skip


def inspect_table(record: ForceVelocity) -> TableInspection:
    """Return what a table of forces and velocities holds, and whether a map can be fitted to it."""
    moving = record.velocity != 0.0
    v, F = record.velocity[moving], record.force[moving]
    speeds = np.unique(np.round(np.abs(v), 12))
    directions = len(np.unique(np.sign(v)))
    good = len(speeds) > 1
    why = f"{len(speeds)} speeds in {'both directions' if directions == 2 else 'one direction'}"
    why += "" if len(speeds) >= SPEEDS else f": a map takes {SPEEDS}, here or with other records"
    found = []
    if directions == 1:
        text = "only one direction is in the table: an offset cannot be told from Coulomb friction"
        found.append(Notice(text, "one-direction", "doubt"))
    size = np.abs(F) if len(F) else np.zeros(1)
    ends = (float(speeds.min()), float(speeds.max())) if len(speeds) else (0.0, 0.0)
    return TableInspection(
        record.name, record.source, record.axis, record.motion, len(v), directions, *ends, float(size.min()),
        float(size.max()), tuple(record.columns()), (Use("static", good, why),), warnings=tuple(found),
    )  # fmt: skip
