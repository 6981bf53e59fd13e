"""What a record holds that is a table already: a measured frequency response, or mean forces at velocities."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fric.columns import FORCE_VELOCITY, Kind
from fric.identify.records.inspected import Use
from fric.log import ForceVelocity, FrequencyResponse
from fric.notice import Notice

SPEEDS = 5
"""Speeds that a map takes at least: as many as it has parameters, and one more."""


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

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain numbers in SI, lists and strings, as JSON takes it."""
        return asdict(self)


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

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain numbers in SI, lists and strings, as JSON takes it."""
        fields = asdict(self) | {"warnings": list(map(str, self.warnings))}
        return fields | {"warnings_coded": [warning.as_dict() for warning in self.warnings]}


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
