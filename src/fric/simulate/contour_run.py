"""Contours under a scheme: circles, paths by points, recorded references; what remains of them, and chance in a run.

A slow loop hunts from count to count: a change of 1e-15 in the gain of a drive becomes a whole count of its encoder
within a revolution at 10 mm/s. So a glitch is the median of several runs, between which position 0 lies elsewhere
between two counts (`Machine.placed`). Runs that are compared are made at the same places.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import floor, inf, pi
from typing import Any, ClassVar, Generic, Literal, Self, TypedDict, TypeVar, Unpack

import numpy as np

from fric.arrays import Real
from fric.contour import Circularity, ContourError, Figures, beside, circularity, contour_error
from fric.control.feedforward import inverse_model
from fric.control.scheme import Scheme
from fric.errors import FricError
from fric.flaws.prediction import NO_REVERSAL, NOT_LINEAR, SATURATES
from fric.notice import Notice
from fric.reference import SAMPLE_BYTES, Reference, circle, cubic_spline, instants, refuse_long, smooth_step
from fric.series import LARGEST, keep
from fric.simulate.axis import Trace, run_axis
from fric.simulate.machine import Axis, Machine
from fric.units import rotates
from fric.verb import require_within

PLACES, FEWER = 5, 3
"""Places between counts for a run that depends on them, and a run longer than `LONG`: odd, so the median is one."""
LONG = 1_000_000  # Samples of all axes
SLOW = 0.03  # Feed below which every run depends on counts [m/s]
ACCURACY = 5e-9  # Largest integration error of runs that depend on counts [m]; counts move a position by ten times that
MOST_KEPT = 500_000  # Samples of all axes from which on the runs at other places are not kept
WIDTH = {PLACES: 4.2, FEWER: 6.9}  # Half of the interval over the standard deviation, by the number of values
Left = TypeVar("Left", bound=Circularity | ContourError)
Followed = TypeVar("Followed", bound="Circle | PointPath | RecordedPath")
SHARPEST = np.pi / 4  # Largest turn from one chord of a path to the next [rad]: more is a corner
REPEATED = 1e-9  # Share of the length of a path within which points are the same
RAMP = 0.1  # Time in which the feed rises from rest, and falls to it [s]


@dataclass(frozen=True)
class Chance:
    """A figure at each place: its median, and the interval in which 95 % of further runs lie.

    The median ± 4.2 standard deviations of five values, or ± 6.9 of three: around normal values this holds 95 % of
    further ones with a confidence of 90 %, and 98 % and 97 % of them in the mean. It is a tolerance interval (Hahn and
    Meeker, Statistical Intervals, chapter 4), with the median as its centre. The range of five holds two of three.
    """

    values: tuple[float, ...]  # The figure at each place; a single figure where it does not depend on counts
    least: float = -inf  # What it cannot be less than: 0 for a magnitude

    @property
    def median(self) -> float:
        """The median."""
        return float(np.median(self.values))

    @property
    def half(self) -> float:
        """Half of the interval; 0 for one value alone."""
        width = WIDTH.get(len(self.values), WIDTH[FEWER])  # another number is of a file that was not written here
        return width * float(np.std(self.values, ddof=1)) if len(self.values) > 1 else 0.0

    @property
    def low(self) -> float:
        """Lower end of the interval."""
        return max(self.median - self.half, self.least)

    @property
    def high(self) -> float:
        """Upper end of the interval."""
        return self.median + self.half

    def __sub__(self, other: "Chance") -> "Chance":
        """Return the difference, place by place; what does not depend on counts is the same at all."""
        return Chance(tuple(np.subtract(self.values, other.values).tolist()))

    def text(self, scale: float = 1e6, digits: int = 1) -> str:
        """Return the median as text, with half of the interval where that is more than the last digit: ``1.5±0.2``.

        Of a peak that points outwards at one place and inwards at another, the magnitude: ``±1.5±0.2``.
        """
        size = Chance(tuple(map(abs, self.values)), 0.0)
        large = size.median * scale >= 10 ** (1 - digits)
        if large and min(self.values) < 0.0 < max(self.values) and 2.0 * size.half < min(self.half, size.median):
            return f"±{size.text(scale, digits)}"
        more = f"±{self.half * scale:.{digits}f}" if self.shown(scale, digits) else ""
        return f"{self.median * scale:.{digits}f}{more}"

    def shown(self, scale: float = 1e6, digits: int = 1) -> bool:
        """Return whether half of the interval is more than the last digit that is written."""
        return self.half * scale >= 0.5 * 10**-digits


class How(TypedDict, total=False):
    """How a contour is run."""

    only: str | None  # Name of the one axis that is simulated, while the other follows its reference exactly
    halvings: int  # How often every step of the plant is halved, to see that this changes nothing
    accuracy: float  # Largest error of positions by integration [m], with counts `ACCURACY` at best; 0: last digits
    places: int  # Number of places for a run that depends on counts; 1 for the machine as given
    schemes: int  # Number of schemes whose traces are kept together


@dataclass(frozen=True, eq=False)
class ContourRun(ABC, Generic[Followed, Left]):
    """Result of one scheme on a contour: where it depends on counts, the run of the median glitch over places."""

    scheme: Scheme  # The compensation scheme
    test: Followed  # The contour
    traces: Mapping[str, Trace]  # What each axis that is simulated recorded, by its name
    contour: Left  # Result of the scheme
    warnings: tuple[Notice, ...] = ()  # What the user should know
    places: tuple[Figures, ...] = ()  # Its errors at each place between two counts; empty where one run is enough

    @classmethod
    @abstractmethod
    def judged(
        cls, test: Followed, references: Sequence[Reference], motion: Sequence[Real]
    ) -> tuple[Left, tuple[Notice, ...]]:
        """Return what is left of a contour along the true positions of both axes [m], and warnings about it."""

    @classmethod
    def run(cls, machine: Machine, scheme: Scheme, test: Followed, **how: Unpack[How]) -> Self:
        """Follow a contour with two axes of a machine, x and y of the contour, under one scheme.

        A run that depends on the counts of encoders is that of the median glitch, with the errors of all places. It
        depends on them below `SLOW`, and where its glitch is less than a count.
        """
        only, places = how.get("only"), how.get("places", PLACES)
        halvings, accuracy = how.get("halvings", 0), how.get("accuracy", 0.0)
        names = pair(machine, only)
        moved = [machine.axis(only).name] if only else [name for name in names if name in machine.axes]
        references = test.references(machine.axes[moved[0]].cascade.sampling)
        asked = dict(zip(names, references, strict=True))
        perfect = machine.axes[moved[0]].cascade.followed

        def once(subject: Machine, accuracy: float) -> Any:
            traces = {
                name: run_axis(subject.axes[name], asked[name], scheme, halvings=halvings, accuracy=accuracy)
                for name in moved
            }
            motion = [traces[name].position if name in traces else perfect(asked[name].position) for name in names]
            contour, more = cls.judged(test, references, motion)
            return cls(scheme, test, traces, contour, run_warnings(scheme, traces) + more)

        for name in moved:
            require_voltage(machine.axes[name], asked[name])
        count = max(machine.axes[name].encoder.resolution for name in moved)
        rough = max(accuracy, ACCURACY)
        slow = test.feed < SLOW and count > 0.0 and places > 1
        sampling, samples = references[0].sampling, len(references[0].position)
        refuse_long(samples / sampling, sampling, len(moved), how.get("schemes", 1))
        if samples * len(moved) > LONG:
            places = min(places, FEWER)
        first: Self = once(machine, rough if slow else accuracy)
        if places == 1 or not (slow or 0.0 < first.contour.glitch < count):
            return first
        runs, found = {0: first}, [figures(first.contour)]
        del first
        for n in range(1, places):
            if samples * len(moved) > MOST_KEPT:  # so many are not kept: that of the median is made once more
                runs.clear()
            runs[n] = once(machine.placed(n / places), rough)
            found.append(figures(runs[n].contour))
        if (middle := sorted(range(places), key=lambda n: found[n].glitch)[places // 2]) not in runs:
            runs.clear()
            runs[middle] = once(machine.placed(middle / places) if middle else machine, rough)
        return replace(runs[middle], places=tuple(found))

    def chance(self, name: Literal["glitch", "rms", "range", "oscillation"] = "glitch") -> Chance:
        """Return one of the figures of the contour with its chance [m]."""
        return Chance(tuple(getattr(place, name) for place in self.places or (self.contour,)), 0.0)

    @property
    def glitches(self) -> tuple[Chance, ...]:
        """The signed glitch at each reversal [m]."""
        return tuple(map(Chance, zip(*(place.glitches for place in self.places or (self.contour,)), strict=True)))


def figures(contour: Circularity | ContourError) -> Figures:
    """Return the reported numbers of a contour."""
    return Figures(*(getattr(contour, name) for name in Figures._fields))


def pair(machine: Machine, only: str | None = None, *, both: bool = False) -> tuple[str, str]:
    """Return the names of the two axes that make a circle: ``x`` and ``y``, or the first two.

    A machine of one linear axis runs it with another that follows its reference exactly, and is not in the machine; so
    is any other axis that is run alone.
    """
    if only and (alone := machine.axis(only)).name not in (usual := pair(machine)):
        if rotates(alone.motion):
            raise FricError(f"axis {alone.name} turns: it makes no circle", hint=f"Say {' or '.join(usual)}.")
        return beside(alone.name)
    if len(linear := [name for name, axis in machine.axes.items() if not rotates(axis.motion)]) < 1 + both:
        what = f"this takes {'two linear axes' if both else 'a linear axis'}"
        raise FricError(f"{what}, and the machine has {len(linear) or 'none'}", hint="Add another to its file.")
    if len(linear) == 1:
        return beside(linear[0])
    names = ("x", "y") if {"x", "y"} <= set(linear) else tuple(linear[:2])
    first, second = names
    if len({machine.axes[name].cascade.sampling for name in names}) > 1:
        hint = "Give both the same sampling."
        raise FricError(f"the controllers of {first} and {second} sample at different rates", hint=hint)
    return first, second


def require_voltage(axis: Axis, reference: Reference) -> None:
    """Refuse a motion that asks for more voltage than the drive has: plant and friction along the reference."""
    against = (axis.friction.steady_state(reference.velocity) + axis.constant_load) / axis.plant.K_f
    if (needed := float(np.abs(inverse_model(axis.plant, reference) + against).max())) > axis.cascade.limit:
        what = f"axis {axis.name} saturates: the motion needs {needed:.3g} V, and its limit is {axis.cascade.limit:g} V"
        raise FricError(what, hint="Lower the feed, or widen the contour.")


def run_warnings(scheme: Scheme, traces: Mapping[str, Trace]) -> tuple[Notice, ...]:
    """Return what to know of a run: a voltage that was limited, a loop that no poles judge."""
    clipped = {name: trace.saturated / len(trace.time) for name, trace in traces.items() if trace.saturated}
    warnings = [SATURATES.found(f"axis {name}", share=share) for name, share in clipped.items()]
    if names := scheme.not_linear:
        warnings.append(NOT_LINEAR.found(blocks=list(names)))
    return tuple(warnings)


def reduction(run: ContourRun[Any, Any], runs: Sequence[ContourRun[Any, Any]]) -> float | None:
    """Return the reduction of the glitch by a scheme against the run without compensation; None where there is none."""
    bare = next((other.contour.glitch for other in runs if other.scheme.bare), 0.0)
    return None if not bare or run.contour.glitch == bare else 1 - run.contour.glitch / bare


@dataclass(frozen=True)
class Circle:
    """A circular test."""

    radius: float = 0.03  # Radius [m]
    feed: float = 0.1  # Speed along the circle [m/s]
    revolutions: int = 2  # Revolutions at full feed; the last is evaluated
    direction: int = 1  # 1 counter-clockwise, -1 clockwise

    def __post_init__(self) -> None:
        require_within(self, "the circle", radius="(0, inf)", feed="(0, inf)", revolutions="(0, inf)")

    def references(self, sampling: float) -> tuple[Reference, Reference]:
        """Return the motion of both axes, sampled at a rate [Hz]."""
        return _references(self, sampling)


@lru_cache(maxsize=4)
def _references(test: Circle, sampling: float) -> tuple[Reference, Reference]:
    """Return the motion of both axes, which schemes and machines share."""
    return circle(test.radius, test.feed, test.revolutions, sampling, direction=test.direction)


class CircleRun(ContourRun[Circle, Circularity]):
    """What one scheme makes of a circle: radial error and glitches of the last revolution."""

    @classmethod
    def judged(
        cls, test: Circle, references: Sequence[Reference], motion: Sequence[Real]
    ) -> tuple[Circularity, tuple[Notice, ...]]:
        """Return the radial error of the last revolution."""
        return circularity(motion[0], motion[1], test.radius), ()

    @property
    def circle(self) -> Circle:
        """The circle."""
        return self.test

    @property
    def circularity(self) -> Circularity:
        """Result of the scheme."""
        return self.contour


def run_circle(machine: Machine, scheme: Scheme, test: Circle | None = None, **how: Unpack[How]) -> CircleRun:
    """Run a circle on two axes of a machine under one scheme.

    test: The circle; that of the paper, 30 mm at 100 mm/s, where it is not given.
    """
    return CircleRun.run(machine, scheme, test or Circle(), **how)


@dataclass(frozen=True)
class CircleGrid:
    """What is run on each of many circles; a circle by its number, radius by radius."""

    machine: Machine  # The machine
    schemes: tuple[Scheme, ...]  # The compensation schemes
    feeds: tuple[float, ...]  # feeds, radii: feeds [m/s] and radii [m] of the circles, in all combinations
    radii: tuple[float, ...]
    accuracy: float  # Largest error of a glitch by the integration [m]

    def __post_init__(self) -> None:
        require_within(self, "the integration", accuracy="[0, 1e-4]")
        if not (self.feeds and self.radii):
            raise FricError("there is no circle to run", hint="Give feeds and radii, as '5 … 200 mm/s'.")

    def __len__(self) -> int:
        return len(self.feeds) * len(self.radii)

    @property
    def memory(self) -> float:
        """Memory of the longest circle while it is simulated [byte]."""
        axes = [axis for name, axis in self.machine.axes.items() if name in pair(self.machine)]
        samples = 2 * pi * max(self.radii) / min(self.feeds) * max(axis.cascade.sampling for axis in axes)
        return len(axes) * samples * SAMPLE_BYTES

    def circle(self, index: int) -> Circle:
        """Return a circle by its number."""
        row, column = divmod(index, len(self.feeds))
        return Circle(self.radii[row], self.feeds[column], revolutions=1)

    def not_run(self, index: int) -> "Cell":
        """Return the cell of a circle that was never begun."""
        return Cell(self.circle(index), np.full(len(self.schemes), np.nan), {})

    def __call__(self, index: int) -> "Cell":
        """Run all schemes on one circle; a scheme that cannot run has no glitch, but a reason."""
        cell = self.not_run(index)
        for n, scheme in enumerate(self.schemes):
            try:
                run = run_circle(self.machine, scheme, cell.circle, accuracy=self.accuracy)
                cell.glitches[n] = run.circularity.glitch
            except FricError as error:
                cell.failures[scheme.name] = error.what
        return cell


@dataclass(frozen=True)
class Cell:
    """Result of schemes on one circle: glitch by scheme [m], nan with the reason where a scheme could not run."""

    circle: Circle
    glitches: Real
    failures: dict[str, str]


@dataclass(frozen=True)
class CircleMap:
    """Results of schemes on all circles."""

    grid: CircleGrid  # What was run
    cells: Sequence[Cell]  # One a circle, in their order

    @property
    def glitches(self) -> Real:
        """Glitch by scheme, radius and feed [m], shape (schemes, radii, feeds); nan where a scheme could not run."""
        shape = (len(self.grid.radii), len(self.grid.feeds), len(self.grid.schemes))
        return np.moveaxis(np.array([cell.glitches for cell in self.cells]).reshape(shape), 2, 0)

    def of(self, scheme: str) -> Real:
        """Return the glitch of a scheme by radius and feed [m]."""
        return np.asarray(self.glitches[[other.name for other in self.grid.schemes].index(scheme)])

    def pairs(self) -> dict[str, tuple[Scheme, Scheme]]:
        """Return the pairs of schemes that show the gain of GMS over a static map, and of an observer over none."""
        found = {}
        for scheme in self.grid.schemes:
            for other in self.grid.schemes:
                alike = scheme.controller == other.controller
                if alike and scheme.blocks == other.blocks and (scheme.friction, other.friction) == ("gms", "static"):
                    found[f"gms over static ({scheme.name} against {other.name})"] = (scheme, other)
                if alike and scheme.friction == other.friction and scheme.observer and not other.blocks:
                    found[f"observer ({scheme.name} against {other.name})"] = (scheme, other)
        return found

    def less(self, scheme: Scheme, other: Scheme) -> Real:
        """Return the reduction of the glitch against another scheme, by radius and feed [m]; negative where worse."""
        return np.asarray(self.of(other.name) - self.of(scheme.name))


@dataclass(frozen=True, eq=False)
class PointPath:
    """A path through points, followed at a constant feed.

    A cubic spline over the length of the chords runs through the points; a path that ends where it began is closed
    smoothly.

    x, y: The points [m], each of shape (n,).
    feed: Speed along the path [m/s].
    Raises FricError: When there are fewer than four points, the path has a corner or is too short for its feed.
    """

    x: Real
    y: Real
    feed: float
    full: ClassVar[float] = 1 - 1e-6  # Share of the feed above which it is full

    def __post_init__(self) -> None:
        keep(self, {"x": "position", "y": "position"}, "", least=1)
        require_within(self, "the path", feed=f"(0, {LARGEST['velocity']}]")
        if len(self.points) < 4:
            raise FricError(f"the path has {len(self.points)} different points", hint="Give four points or more.")
        chords = np.diff(self.points, axis=0)
        heading = np.unwrap(np.arctan2(chords[:, 1], chords[:, 0]))
        corner = int(np.argmax(np.abs(np.diff(heading))))
        if abs(heading[corner + 1] - heading[corner]) > SHARPEST:
            x, y = self.points[corner + 1] * 1e3
            hint = "No drive follows it at constant feed: round it with more points."
            raise FricError(f"the path has a corner at x = {x:g} mm, y = {y:g} mm", hint=hint)

    @property
    def points(self) -> Real:
        """The points without repetitions, nearer than `REPEATED` of the path to the point before [m], shape (n, 2)."""
        points = np.column_stack([self.x, self.y])
        chords = np.hypot(*np.diff(points, axis=0).T)
        return points[np.concatenate([[True], chords > REPEATED * chords.sum()])]

    def references(self, sampling: float) -> tuple[Reference, Reference]:
        """Return the motion of both axes, from rest to rest, sampled at a rate [Hz]."""
        points = self.points
        knots = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        if closed := np.allclose(points[0], points[-1], rtol=0, atol=REPEATED * knots[-1]):
            points = np.vstack([points[:-1], points[:1]])
        spline = cubic_spline(knots, points, "periodic" if closed else "natural")
        # the length of the spline, by the speed along it between closely spaced parameters
        fine = np.linspace(0.0, knots[-1], 50 * len(knots))
        middle = np.hypot(*spline((fine[1:] + fine[:-1]) / 2, 1).T)
        ends = np.hypot(*spline(fine, 1).T)
        length = np.concatenate([[0.0], np.cumsum(np.diff(fine) * (ends[1:] + 4 * middle + ends[:-1]) / 6)])
        if (cruise := length[-1] / self.feed - RAMP) <= 0:
            hint = "Lower the feed, or give a longer path."
            raise FricError(f"a path of {length[-1] * 1e3:.3g} mm is too short for {self.feed * 1e3:g} mm/s", hint=hint)
        t = instants(cruise + 2 * RAMP, sampling, more=1, axes=2)
        up, up_travel, up_slope, _ = smooth_step(t / RAMP)
        down, down_travel, down_slope, _ = smooth_step((t - cruise - RAMP) / RAMP)
        travelled = np.minimum(self.feed * RAMP * (up_travel - down_travel), length[-1])
        speed, change = self.feed * (up - down), self.feed / RAMP * (up_slope - down_slope)
        at = cubic_spline(length, fine, "not-a-knot")(travelled)
        first, second = spline(at, 1), spline(at, 2)
        rate = np.hypot(*first.T)[:, np.newaxis]
        tangent = first / rate
        bend = (second - tangent * np.sum(tangent * second, axis=1, keepdims=True)) / rate**2
        position, velocity = spline(at), tangent * speed[:, np.newaxis]
        motion = (position, velocity, bend * speed[:, np.newaxis] ** 2 + tangent * change[:, np.newaxis])
        x, y = (Reference(sampling, *(np.ascontiguousarray(part[:, n]) for part in motion)) for n in (0, 1))
        return x, y


@dataclass(frozen=True, eq=False)
class RecordedPath:
    """A recorded reference: it is followed as it was commanded, with its instants.

    Between its samples it is a cubic spline, whose derivatives are velocity and acceleration.

    Raises FricError: When there are fewer than ten samples, the motion does not begin at rest, or `fric.series.keep`
        raises.
    """

    time: Real  # Sample instants [s], strictly increasing, shape (n,)
    x: Real  # x, y: reference of the axes [m], each of shape (n,)
    y: Real
    full: ClassVar[float] = 0.98  # As of a `PointPath`

    def __post_init__(self) -> None:
        keep(self, {"time": "time", "x": "position", "y": "position"}, "", least=10)
        steps = np.hypot(np.diff(self.x), np.diff(self.y)) / np.diff(self.time)
        if not steps.max() > 0:
            raise FricError("the reference does not move")
        if steps[0] > 0.02 * steps.max():
            hint = "Record it from rest: so the axes begin."
            raise FricError(f"the reference begins at {steps[0] * 1e3:.3g} mm/s", hint=hint)

    @cached_property
    def feed(self) -> float:
        """The speed that is held the longest [m/s]: the median of all that is above half of the largest."""
        speed = np.hypot(np.gradient(self.x, self.time), np.gradient(self.y, self.time))
        return float(np.median(speed[speed > 0.5 * speed.max()]))

    def references(self, sampling: float) -> tuple[Reference, Reference]:
        """Return the motion of both axes, sampled at a rate [Hz]."""
        span = self.time[-1] - self.time[0]
        refuse_long(span, sampling, axes=2)
        t = np.arange(floor(span * sampling + 1e-6) + 1) / sampling + self.time[0]
        along = (cubic_spline(self.time, values, "not-a-knot") for values in (self.x, self.y))
        x, y = (Reference(sampling, *(np.ascontiguousarray(of(t, order)) for order in (0, 1, 2))) for of in along)
        return x, y


class PathRun(ContourRun[PointPath | RecordedPath, ContourError]):
    """Result of one scheme on a path: contour error and glitches, where the feed is full."""

    @classmethod
    def judged(
        cls, test: PointPath | RecordedPath, references: Sequence[Reference], motion: Sequence[Real]
    ) -> tuple[ContourError, tuple[Notice, ...]]:
        """Return the distance from the path where the feed is full."""
        parts = ("position", "velocity")
        asked, velocity = (np.column_stack([getattr(reference, part) for reference in references]) for part in parts)
        full = np.hypot(*velocity.T) > test.full * test.feed
        error = contour_error(asked[full], velocity[full], np.column_stack(motion)[full], references[0].sampling)
        return error, () if error.reversals else (NO_REVERSAL.found(),)


def run_path(machine: Machine, scheme: Scheme, path: PointPath | RecordedPath, **how: Unpack[How]) -> PathRun:
    """Follow a path with two axes of a machine under one scheme; arguments and errors as `run_circle`."""
    return PathRun.run(machine, scheme, path, **how)
