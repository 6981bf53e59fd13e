"""Strokes of one axis on their way to a map: the arguments, their points, and the corrections of these."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, Self

import numpy as np

from fric.arrays import Real
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.static_map import STROKES_IN_PRESLIDING
from fric.identify.static_map.points import Average, SpeedPoint, slid, stroke_points
from fric.identify.static_map.stribeck_fit import StribeckProblem
from fric.log import ForceVelocity, Log
from fric.notice import Notice
from fric.records.over_strokes import OverPlace, over_place
from fric.records.segments import Segment
from fric.units import Motion, readable, si_unit

Direction = Literal["auto", "both", "each"]
Form = Literal["auto", "coulomb", "stribeck"]
OverPosition = Literal["auto", "off", "on"]
ShapeFactor = float | Literal["auto", "free"]
Weights = Literal["error", "equal"]


@dataclass(frozen=True)
class Asked:
    """The arguments of `identify_static`, by their names."""

    motion: Motion = "linear"
    plant: Plant | None = None
    delta: ShapeFactor = "auto"
    direction: Direction = "auto"
    over_position: OverPosition = "auto"
    weights: Weights = "error"
    average: Average = "robust"
    form: Form = "auto"
    load: float | None = None
    damping_error: float = 0.0

    @property
    def damping(self) -> float:
        """The plant's damping, which was subtracted from the forces [N·s/m]."""
        return self.plant.damping if self.plant else 0.0

    def of(self, value: float, dimension: str) -> Estimate:
        """Return a value with its unit of this axis."""
        return Estimate(float(value), si_unit(dimension, self.motion))

    def says(self, value: float, dimension: str, digits: int = 3) -> str:
        """Return a value for people, in the unit of this axis."""
        return readable(value, si_unit(dimension, self.motion), digits)


class Stretches(dict[int, tuple[Log, Segment]]):
    """Record and steady segment of the strokes that do not swing, by the number of the point."""

    @classmethod
    def of(cls, points: Sequence[SpeedPoint], logs: Sequence[Log]) -> Self:
        """Return the stretches of points; none where records share a name."""
        unique = len({log.name for log in logs}) == len(logs)
        return cls({n: p.stretch for n, p in enumerate(points) if unique and p.stretch is not None and not p.swing})

    @property
    def with_position(self) -> dict[int, tuple[Log, Segment]]:
        """Those whose position was logged."""
        return {n: pair for n, pair in self.items() if pair[0].position is not None}

    @cached_property
    def place(self) -> OverPlace | None:
        """What the force shows at the same places again."""
        return over_place(list(self.values()))


Into = Callable[[StribeckProblem, Sequence[SpeedPoint]], StribeckProblem]
"""A change of the problem that is fitted to points."""


@dataclass(frozen=True)
class Correction:
    """What one thing that bends the forces of strokes does to them, and to the problem that is fitted to them."""

    points: Sequence[SpeedPoint] | None = None  # The points without it; None where they do not change
    records: Sequence[Log | ForceVelocity] | None = None  # The records without it, if subtracted from each sample
    together: Callable[["Strokes"], Real] | Real | None = None
    """Directions in which its error moves the forces of all points [N], half widths, shape (m, n)."""
    notices: Sequence[Notice] = ()  # Its warnings
    tried: Mapping[str, float] = field(default_factory=dict)  # Error at held-out strokes [N] of what was not taken
    into: Into | None = None  # What it changes of the problem
    between_records: Mapping[str, Estimate] = field(default_factory=dict)
    """Standard deviation of the level [1] and the offset [N] of records."""


@dataclass(frozen=True)
class Strokes:
    """The strokes of an axis, as the corrections have left them."""

    asked: Asked
    records: Sequence[Log | ForceVelocity]
    points: Sequence[SpeedPoint]
    stretches: Stretches
    together: Real  # Correlated errors of the forces of all points [N], half widths, shape (m, n)
    notices: tuple[Notice, ...] = ()
    tried: Mapping[str, float] = field(default_factory=dict)  # Errors at held-out strokes [N] of what was tried
    into: tuple[Into, ...] = ()
    between_records: Mapping[str, Estimate] = field(default_factory=dict)

    @classmethod
    def of(cls, records: Sequence[Log | ForceVelocity], asked: Asked) -> Self:
        """Return the strokes of records; raise FricError when there is none, or all took the same force."""
        points, notices = stroke_points(records, average=asked.average, plant=asked.plant)
        points, ended = slid(points)
        if ended:
            speeds = [asked.of(v, "velocity") for v in dict.fromkeys(point.velocity for point in ended)]
            notices.append(STROKES_IN_PRESLIDING.found(speeds=speeds))
        found = replace(cls.at(points, asked, records), notices=tuple(notices))
        force = found.force
        if np.ptp(force) <= 1e-9 * np.abs(force).max(initial=0.0):
            raise FricError(
                f"every stroke took the same force, {asked.says(float(force[0]), 'force')}", where=records[0].source,
                hint="Is it the right column? Friction changes its sign with the direction.",
            )  # fmt: skip
        return found

    @classmethod
    def at(cls, points: Sequence[SpeedPoint], asked: Asked, records: Sequence[Log | ForceVelocity] = ()) -> Self:
        """Return the strokes of points that are known."""
        logs = [record for record in records if isinstance(record, Log)]
        return cls(asked, records, points, Stretches.of(points, logs), np.empty((0, len(points))))

    @property
    def logs(self) -> list[Log]:
        """The records in time."""
        return [record for record in self.records if isinstance(record, Log)]

    @property
    def velocity(self) -> Real:
        """Of each point [m/s], signed, shape (n,)."""
        return np.array([point.velocity for point in self.points])

    @property
    def force(self) -> Real:
        """Of each point [N], signed, shape (n,)."""
        return np.array([point.force for point in self.points])

    @property
    def size(self) -> float:
        """Median size of the forces [N]."""
        return float(np.median(np.abs(self.force)))

    @property
    def one_speed(self) -> bool:
        """Whether all points have the same speed, so that there is no map."""
        speed = np.abs(self.velocity)
        return bool(np.ptp(speed) <= 0.02 * speed.max())

    @property
    def both_directions(self) -> bool:
        """Whether strokes of both directions were measured."""
        return len(np.unique(np.sign(self.velocity))) == 2

    @property
    def offset(self) -> float | None:
        """The offset [N] where it is not fitted, which takes strokes of both directions."""
        return None if self.both_directions and self.asked.load is None else self.asked.load or 0.0

    def without(self, found: Correction) -> Self:
        """Return the strokes with a correction made."""
        made = self if found.records is None else type(self).of(found.records, self.asked)
        together = found.together(made) if callable(found.together) else found.together
        return replace(
            made, points=made.points if found.points is None else found.points,
            together=self.together if together is None else np.vstack([self.together, together]),
            notices=(*made.notices, *found.notices), tried={**self.tried, **found.tried},
            into=self.into if found.into is None else (*self.into, found.into),
            between_records={**self.between_records, **found.between_records},
        )  # fmt: skip

    def one_way(self, sense: float) -> Self:
        """Return the strokes of one direction, the negative direction mirrored."""
        chosen = self.velocity * sense > 0
        points = [
            replace(p, velocity=sense * p.velocity, force=sense * p.force)
            for p, item in zip(self.points, chosen, strict=True) if item
        ]  # fmt: skip
        return replace(self, points=points, together=sense * self.together[:, chosen])
