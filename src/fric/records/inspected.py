"""What was found in a record: over time, in frequency, or in a table of forces and velocities."""

from dataclasses import dataclass
from typing import Any, Literal, Self

import numpy as np

from fric.columns import FORCE_VELOCITY, Kind
from fric.estimate import Estimate
from fric.flaws.channel import ONE_DIRECTION
from fric.log import ForceVelocity, FrequencyResponse, Record
from fric.notice import Notice
from fric.records.recognition import Sine
from fric.records.segments import Segment
from fric.units import Motion

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

    unit: its SI unit
    low, high: least and greatest value
    step: of the lattice that its values lie on
    clipped: samples at which a force or an input is stuck at its extreme
    """

    unit: str
    low: float
    high: float
    step: float | None
    clipped: int = 0


@dataclass(frozen=True)
class Gap:
    """Missing samples.

    time: before them [s]
    intervals: sampling intervals that the gap is long
    """

    time: float
    intervals: float


@dataclass(frozen=True, kw_only=True)
class InspectedRecord:
    """What every record tells.

    kind: the experiment that it is
    stated: whether the record says so, else it is recognised
    uses: what it is good for, and what not
    warnings: what is amiss with its clock, its encoder, its strokes
    """

    name: str
    source: str
    axis: str
    motion: Motion
    kind: Kind
    stated: bool
    uses: tuple[Use, ...] = ()
    warnings: tuple[Notice, ...] = ()

    @classmethod
    def of(cls, record: Record, **found: Any) -> Self:
        """Return what was found in a record, of that name, source and axis."""
        return cls(name=record.name, source=record.source, axis=record.axis, motion=record.motion, **found)


@dataclass(frozen=True, kw_only=True)
class Inspection(InspectedRecord):
    """What a record in time holds.

    duration: from the first sample to the last [s]
    sampling: by the median interval [Hz]
    jitter: standard deviation of the sampling intervals, gaps left out [s]
    channels: by name, what each holds
    gaps: where samples are missing
    stretches: at constant velocity
    speeds: of the stretches, those within three per cent as one [m/s]
    sine: that the motion follows, where it does
    reversals: samples at which the motion reverses
    rise: share of the stroke that the force takes to come up after a reversal
    excites: whether the motion tells mass, viscous and Coulomb friction apart
    slope: least slope of the branches between reversals, over their mean; null without force
    energy: lost per cycle of the logged force; null without cycles
    dropped: samples that were left out when the record was ingested
    """

    samples: int
    duration: float
    sampling: float | None
    jitter: float
    channels: dict[str, Channel]
    gaps: tuple[Gap, ...] = ()
    stretches: tuple[Segment, ...] = ()
    speeds: tuple[float, ...] = ()
    sine: Sine | None = None
    reversals: tuple[int, ...] = ()
    rise: float | None = None
    excites: bool = False
    slope: float | None = None
    energy: Estimate | None = None
    dropped: int = 0

    @property
    def encoder_step(self) -> float | None:
        """Step of the position encoder [m]; None where the position is not quantised, or not logged."""
        return self.channels["position"].step if "position" in self.channels else None


@dataclass(frozen=True, kw_only=True)
class ResponseInspection(InspectedRecord):
    """What a measured frequency response holds.

    points: frequencies
    low: [Hz]
    high: [Hz]
    coherence: the least; null where none was measured
    """

    points: int
    low: float
    high: float
    coherence: float | None


@dataclass(frozen=True, kw_only=True)
class TableInspection(InspectedRecord):
    """What a table of mean forces at velocities holds.

    points: rows that move
    directions: of motion that there are
    slowest, fastest: speed [m/s]
    weakest, strongest: size of a force [N]
    columns: that there are
    """

    points: int
    directions: Literal[0, 1, 2]
    slowest: float
    fastest: float
    weakest: float
    strongest: float
    columns: tuple[str, ...]


def inspect_response(record: FrequencyResponse) -> ResponseInspection:
    """Return what a measured frequency response holds."""
    frequency = record.frequency
    coherence = None if record.coherence is None else float(np.min(record.coherence))
    decades = float(np.log10(frequency[-1] / frequency[0])) if len(frequency) > 1 and frequency[0] > 0 else 0.0
    good = len(frequency) >= 8 and decades >= 1.0
    why = f"{len(frequency)} frequencies over {decades:.1f} decades" + (
        "" if good else ": 8 over one decade are needed"
    )
    return ResponseInspection.of(
        record, kind="frequency-response", stated=True, uses=(Use("plant", good, why),), points=len(frequency),
        low=float(frequency.min()), high=float(frequency.max()), coherence=coherence,
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
    found = (ONE_DIRECTION.found(),) if directions == 1 else ()
    size = np.abs(F) if len(F) else np.zeros(1)
    slowest, fastest = (float(speeds.min()), float(speeds.max())) if len(speeds) else (0.0, 0.0)
    return TableInspection.of(
        record, kind=FORCE_VELOCITY, stated=True, uses=(Use("static", good, why),), warnings=found,
        points=len(v), directions=directions, slowest=slowest, fastest=fastest, weakest=float(size.min()),
        strongest=float(size.max()), columns=tuple(record.columns()),
    )  # fmt: skip
