"""Halves of the records, identified separately: whether intervals cover the differences of repeated measurements."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from math import hypot, inf
from typing import Literal

import numpy as np

from fric.arrays import Mask
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.static_map import FORCE_OVER_POSITION
from fric.identify.plant.identify import identify_motion
from fric.identify.static_map.identify import identify_static
from fric.identify.static_map.points import Asked, stroke_points
from fric.log import ForceVelocity, Log
from fric.records.recognition import kind_of

SPEEDS_ALIKE = 6.0  # Ratio of the slowest, and of the fastest, strokes up to which two halves determine the same map
LEAST = 200  # Least number of samples of half a motion
Fit = Callable[[], Mapping[str, Estimate]]


@dataclass(frozen=True)
class Halved:
    """A parameter of two halves of the records."""

    by: str  # By what they were halved
    parameter: str  # Its name
    first: Estimate  # Of the first half
    second: Estimate  # Of the second half

    @property
    def half_widths(self) -> float:
        """Their difference over the half-width of its 95 % interval [1]: 95 of 100 are below 1."""
        return abs(float(self.first) - float(self.second)) / hypot(self.first.half_width, self.second.half_width)


@dataclass(frozen=True)
class Halves:
    """Differences between halves of the records of an axis."""

    axis: str  # Name of the axis
    found: tuple[Halved, ...]  # Each parameter of each halving
    untold: Mapping[str, str]  # Reasons why a halving shows nothing, by its name

    @property
    def within(self) -> float:
        """Share of the parameters whose halves differ by less than a half-width [1]: 0.95 where intervals hold."""
        return float(np.mean([halved.half_widths <= 1.0 for halved in self.found])) if self.found else float("nan")

    @property
    def conclusion(self) -> str:
        """A sentence on how many halves agree, and which differ most."""
        count = len(self.found)
        text = f"{round(self.within * count)} of {count} values agree within their 95 % intervals"
        far = max(self.found, key=lambda halved: halved.half_widths)
        apart = f"; {far.parameter}, halved by {far.by}, differs most: by {far.half_widths:.1f} times the interval"
        return text + apart * (far.half_widths > 1.0)


def halves(logs: Sequence[Log], plant: Plant | None = None) -> Halves:
    """Identify halves of the records separately, split by time, alternately, by record, direction and place.

    Of strokes it is the static map, each stroke with the error of its mean; of motions mass and friction of the rigid
    axis.
    """
    kinds = [kind_of(log) for log in logs]
    strokes = [log for log, kind in zip(logs, kinds, strict=True) if kind == "constant-velocity"]
    motions = [log for log, kind in zip(logs, kinds, strict=True) if kind == "motion"]
    found: list[Halved] = []
    untold: dict[str, str] = {}
    pairs = [*(_of_strokes(strokes, plant) if strokes else ()), *(_of_motions(motions) if motions else ())]
    for by, first, second in pairs:
        try:
            half, other = first(), second()
        except FricError as error:
            untold[by] = error.what
            continue
        found += [
            Halved(by, name, half[name], other[name]) for name in half.keys() & other.keys()
            if all(0.0 < estimate.half_width < inf for estimate in (half[name], other[name]))
        ]  # fmt: skip
    if not found:
        why = "; ".join(dict.fromkeys(untold.values())) or "there are neither strokes nor motions"
        hint = "Give strokes at constant velocity, or motions."
        raise FricError(f"no halves can be compared: {why}", where=logs[0].where if logs else "", hint=hint)
    order = list(dict.fromkeys(halved.by for halved in found))
    return Halves(logs[0].axis, tuple(sorted(found, key=lambda of: (order.index(of.by), of.parameter))), untold)


def _of_strokes(logs: Sequence[Log], plant: Plant | None) -> Iterator[tuple[str, Fit, Fit]]:
    points, _ = stroke_points(logs, plant=plant)
    names = [log.name for log in logs]
    points.sort(key=lambda point: (names.index(point.record), point.start))
    whole = identify_static(logs, Asked(logs[0].motion, plant, delta=1.0, direction="both"))
    offset = float(whole.static.estimates["offset"]) if whole.static is not None else 0.0

    def fit(chosen: Mask, load: float | None = None) -> Fit:
        def made() -> Mapping[str, Estimate]:
            reach = [(abs(velocity[some]).min(), abs(velocity[some]).max()) for some in (chosen, ~chosen) if some.any()]
            if len(reach) < 2 or any(max(ends) > SPEEDS_ALIKE * min(ends) for ends in zip(*reach, strict=True)):
                raise FricError("one half has other speeds than the other")
            table = ForceVelocity(
                velocity[chosen], force[chosen], error=error[chosen], axis=logs[0].axis, motion=logs[0].motion,
                name="half",
            )  # fmt: skip
            found = identify_static([table], Asked(table.motion, delta=1.0, direction="both", load=load)).static
            return {} if found is None else found.estimates

        return made

    velocity, force, error = np.array([(point.velocity, point.force, point.standard_error) for point in points]).T
    number, of_record = np.arange(len(points)), np.array([names.index(point.record) for point in points])
    speed = np.argsort(np.argsort(velocity))
    forward = velocity > 0
    yield "time", fit(2 * number < len(points)), fit(2 * number >= len(points))
    yield "alternation", fit(speed // 2 % 2 == 0), fit(speed // 2 % 2 == 1)
    if len(names) > 1:
        yield "record", fit(of_record % 2 == 0), fit(of_record % 2 == 1)
    if forward.any() and not forward.all():
        yield "direction", fit(forward, offset), fit(~forward, offset)
    if all(log.position is not None for log in logs):
        stretches = [point.stretch for point in points if point.stretch is not None]
        place = np.array([float(np.mean(log.require("position", "a place")[s.start : s.stop])) for log, s in stretches])
        low = place < float(np.median(place))
        yield "place", fit(low), fit(~low)


def _of_motions(logs: Sequence[Log]) -> Iterator[tuple[str, Fit, Fit]]:
    each = cache(lambda: identify_motion(logs, direction="each"))

    def fit(some: Sequence[Log]) -> Fit:
        def made() -> Mapping[str, Estimate]:
            place: Literal["none"] | None = None
            with suppress(FricError):  # halves of what does not depend on the place do not either
                if all(warning.code != FORCE_OVER_POSITION.code for warning in each().warnings):
                    place = "none"
            return identify_motion(some, place=place).estimates

        return made

    def side(name: str) -> Fit:
        def made() -> Mapping[str, Estimate]:
            found = each().estimates
            return {key.removesuffix(name): estimate for key, estimate in found.items() if key.endswith(name)}

        return made

    if long := [log for log in logs if len(log) >= 2 * LEAST]:
        first = [log.slice(0, len(log) // 2) for log in long]
        yield "time", fit(first), fit([log.slice(len(log) // 2, len(log)) for log in long])
    if len(logs) > 1:
        yield "record", fit(logs[::2]), fit(logs[1::2])
    yield "direction", side("_positive"), side("_negative")
