"""One contour under one scheme: what circles, paths and recorded references have in common, and chance in a run.

A slow loop hunts from count to count: a change of 1e-15 in the gain of a drive becomes a whole count of its encoder
within a revolution at 10 mm/s. So a glitch is the median of several runs, between which position 0 lies elsewhere
between two counts (`Machine.placed`). Runs that are compared are made at the same places.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any, Generic, Literal, Protocol, Self, TypedDict, TypeVar

import numpy as np

from fric.arrays import Real
from fric.contour import Circularity, ContourError, Figures, beside
from fric.control.feedforward import inverse_model
from fric.control.scheme import Scheme
from fric.errors import FricError
from fric.flaws.prediction import NOT_LINEAR, SATURATES
from fric.notice import Notice
from fric.reference import Reference
from fric.simulate.axis import Trace, run_axis
from fric.simulate.machine import Axis, Machine
from fric.units import rotates

PLACES = 5
"""Places between two counts at which a run that depends on them is made: an odd number, so that the median is a run."""
SLOW = 0.03  # Feed below which every run depends on counts [m/s]
ACCURACY = 5e-9
"""Largest error of the integration of runs that depend on counts [m]; counts move a position by ten times that."""
WIDTH = 4.2  # Half of the interval over the standard deviation, for `PLACES` values


@dataclass(frozen=True)
class Chance:
    """A figure at each place: its median, and the interval in which 95 % of further runs lie.

    The median ± 4.2 standard deviations: around five normal values this holds 95 % of further ones with a confidence of
    90 %, and 98 % of them in the mean. It is a tolerance interval (Hahn and Meeker, Statistical Intervals, chapter 4),
    with the median as its centre. The range of the five holds two of three.
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
        return WIDTH * float(np.std(self.values, ddof=1)) if len(self.values) > 1 else 0.0

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
        """Return the median as text, with half of the interval where that is more than the last digit: ``1.5±0.2``."""
        more = f"±{self.half * scale:.{digits}f}" if self.shown(scale, digits) else ""
        return f"{self.median * scale:.{digits}f}{more}"

    def shown(self, scale: float = 1e6, digits: int = 1) -> bool:
        """Return whether half of the interval is more than the last digit that is written."""
        return self.half * scale >= 0.5 * 10**-digits


Left = TypeVar("Left", bound=Circularity | ContourError)


class ContourLike(Protocol):
    """A contour that two axes follow."""

    @property
    def feed(self) -> float:
        """Speed along the contour [m/s]."""

    def references(self, sampling: float) -> tuple[Reference, Reference]:
        """Return the motion of both axes, sampled at a rate [Hz]."""


Followed = TypeVar("Followed", bound=ContourLike)


class How(TypedDict, total=False):
    """How a contour is run."""

    only: str | None  # Name of the one axis that is simulated, while the other follows its reference exactly
    halvings: int  # How often every step of the plant is halved, to see that this changes nothing
    # Largest error of a position by the integration of the plant [m]; 0 for the last digits. A run that depends on
    # counts is integrated to `ACCURACY` at best
    accuracy: float
    places: int  # Number of places for a run that depends on counts; 1 for the machine as given


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
    def run(
        cls,
        machine: Machine,
        scheme: Scheme,
        test: Followed,
        *,
        only: str | None = None,
        halvings: int = 0,
        accuracy: float = 0.0,
        places: int = PLACES,
    ) -> Self:
        """Follow a contour with two axes of a machine, x and y of the contour, under one scheme.

        A run that depends on the counts of encoders is that of the median glitch, with the errors of all places. It
        depends on them below `SLOW`, and where its glitch is less than a count.

        Raises FricError: When the machine has no two linear axes at one controller rate, the feed asks for more voltage
            than a drive has, or a run is not possible.
        """
        names = pair(machine)
        moved = [machine.axis(only).name] if only else [name for name in names if name in machine.axes]
        references = test.references(machine.axes[moved[0]].cascade.sampling)
        asked = dict(zip(names, references, strict=True))

        def once(subject: Machine, accuracy: float) -> Any:
            traces = {
                name: run_axis(subject.axes[name], asked[name], scheme, halvings=halvings, accuracy=accuracy)
                for name in moved
            }
            motion = [traces[name].position if name in traces else asked[name].position for name in names]
            contour, more = cls.judged(test, references, motion)
            return cls(scheme, test, traces, contour, run_warnings(scheme, traces) + more)

        for name in moved:
            require_voltage(machine.axes[name], asked[name])
        count = max(machine.axes[name].encoder.resolution for name in moved)
        rough = max(accuracy, ACCURACY)
        slow = test.feed < SLOW and count > 0.0 and places > 1
        first: Self = once(machine, rough if slow else accuracy)
        if places == 1 or not (slow or 0.0 < first.contour.glitch < count):
            return first
        runs = [first, *(once(machine.placed(n / places), rough) for n in range(1, places))]
        middle = sorted(runs, key=lambda run: run.contour.glitch)[places // 2]
        return replace(middle, places=tuple(figures(run.contour) for run in runs))

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


def pair(machine: Machine, *, both: bool = False) -> tuple[str, str]:
    """Return the names of the two axes that make a circle: ``x`` and ``y``, or the first two.

    A machine of one linear axis runs it with another that follows its reference exactly, and is not in the machine.

    both: Whether it must have two.
    Raises FricError: When there is no linear axis, or the controllers of two have different rates.
    """
    linear = [name for name, axis in machine.axes.items() if not rotates(axis.motion)]
    if len(linear) < 1 + both:
        raise FricError(
            f"this takes {'two linear axes' if both else 'a linear axis'}, and the machine has {len(linear) or 'none'}",
            hint="Add it to the machine's file.",
        )
    if len(linear) == 1:
        return beside(linear[0])
    names = ("x", "y") if {"x", "y"} <= set(linear) else tuple(linear[:2])
    first, second = names
    rates = {machine.axes[name].cascade.sampling for name in names}
    if len(rates) > 1:
        raise FricError(
            f"the controllers of {first} and {second} sample at different rates", hint="Give both the same sampling."
        )
    return first, second


def require_voltage(axis: Axis, reference: Reference) -> None:
    """Refuse a motion that asks for more voltage than the drive has: plant and friction along the reference.

    Raises FricError: When it does.
    """
    against = (axis.friction.steady_state(reference.velocity) + axis.constant_load) / axis.plant.K_f
    needed = float(np.abs(inverse_model(axis.plant, reference) + against).max())
    if needed > axis.cascade.limit:
        raise FricError(
            f"axis {axis.name} saturates: the motion needs {needed:.3g} V, and its limit is {axis.cascade.limit:g} V",
            hint="Lower the feed, or widen the contour.",
        )


def run_warnings(scheme: Scheme, traces: Mapping[str, Trace]) -> tuple[Notice, ...]:
    """Return what to know of a run: a voltage that was limited, a loop that no poles judge."""
    warnings = [
        SATURATES.found(f"axis {name}", share=trace.saturated / len(trace.time))
        for name, trace in traces.items()
        if trace.saturated
    ]
    if names := scheme.not_linear:
        warnings.append(NOT_LINEAR.found(blocks=list(names)))
    return tuple(warnings)


def reduction(run: ContourRun[Any, Any], runs: Sequence[ContourRun[Any, Any]]) -> float | None:
    """Return the reduction of the glitch by a scheme against the run without compensation; None where there is none."""
    bare = next((other.contour.glitch for other in runs if other.scheme.bare), 0.0)
    return None if not bare or run.contour.glitch == bare else 1 - run.contour.glitch / bare
