"""The circular test: two axes, one scheme, and what remains of the circle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from fric.contour import Circularity, ContourError, circularity
from fric.control.feedforward import inverse_model
from fric.errors import FricError
from fric.notice import Notice
from fric.reference import Reference, circle
from fric.simulate.axis import Trace, run_axis

if TYPE_CHECKING:
    from fric.control.scheme import Scheme
    from fric.simulate.machine import Axis, Machine


@dataclass(frozen=True)
class Circle:
    """A circular test.

    Parameters
    ----------
    radius
        Radius [m].
    feed
        Speed along the circle [m/s].
    revolutions
        Revolutions at full feed; the last one is looked at.
    direction
        1 counter-clockwise, -1 clockwise.

    Raises
    ------
    FricError
        When radius, feed or revolutions are not positive.
    """

    radius: float = 0.03
    feed: float = 0.1
    revolutions: int = 2
    direction: int = 1

    def __post_init__(self) -> None:
        for name in ("radius", "feed", "revolutions"):
            if not getattr(self, name) > 0:
                raise FricError(f"the {name} of the circle is {getattr(self, name):g}", mend="Give a positive value.")


@dataclass(frozen=True)
class CircleRun:
    """What one scheme makes of a circle.

    Parameters
    ----------
    scheme
        The compensation scheme.
    circle
        The test.
    traces
        What each axis recorded, by its name; an axis that is not simulated follows its reference exactly.
    circularity
        Radial error and glitches of the last revolution.
    warnings
        What the user should know: a drive that saturates.
    """

    scheme: Scheme
    circle: Circle
    traces: Mapping[str, Trace]
    circularity: Circularity
    warnings: tuple[str, ...] = ()

    @property
    def contour(self) -> Circularity:
        """What the scheme leaves of the circle: its circularity."""
        return self.circularity


class ContourRun(Protocol):
    """What circles and paths have in common: a scheme, and what it leaves."""

    @property
    def scheme(self) -> Scheme:
        """The scheme."""

    @property
    def contour(self) -> Circularity | ContourError:
        """What it leaves of the contour."""


def run_circle(
    machine: Machine,
    scheme: Scheme,
    test: Circle | None = None,
    *,
    only: str | None = None,
    halvings: int = 0,
    accuracy: float = 0.0,
) -> CircleRun:
    """Run a circle on two axes of a machine under one scheme.

    Parameters
    ----------
    machine
        The machine; its first two axes are x and y of the circle.
    scheme
        The compensation scheme.
    test
        The circle; that of the paper, 30 mm at 100 mm/s, where it is not given.
    only
        Name of the one axis that is simulated, while the other follows its reference exactly.
    halvings
        How often every step of the plant is halved, to see that this changes nothing.
    accuracy
        By how much the integration of the plant may move a position [m]; 0 for the last digits.

    Raises
    ------
    FricError
        When the machine has no two linear axes at one controller rate, the feed asks for more voltage than a drive
        has, or a run is not possible.
    """
    test = test or Circle()
    first, second = pair(machine)
    sampling = machine.axes[first].cascade.sampling
    references = dict(zip((first, second), _references(test, sampling), strict=True))
    moved = [machine.axis(only).name] if only else [first, second]
    for name in moved:
        require_voltage(machine.axes[name], references[name])
    traces = {
        name: run_axis(machine.axes[name], references[name], scheme, halvings=halvings, accuracy=accuracy)
        for name in moved
    }
    x, y = (traces[name].position if name in traces else references[name].position for name in (first, second))
    return CircleRun(scheme, test, traces, circularity(x, y, test.radius), run_warnings(scheme, traces))


@lru_cache(maxsize=4)
def _references(test: Circle, sampling: float) -> tuple[Reference, Reference]:
    """Return the motion of both axes, which schemes and machines share."""
    return circle(test.radius, test.feed, test.revolutions, sampling, direction=test.direction)


def pair(machine: Machine) -> tuple[str, str]:
    """Return the names of the two axes that make a circle: ``x`` and ``y``, or the first two.

    Raises
    ------
    FricError
        When there are no two linear axes with controllers at one rate.
    """
    linear = [name for name, axis in machine.axes.items() if axis.motion == "linear"]
    names = ("x", "y") if {"x", "y"} <= set(linear) else tuple(linear[:2])
    if len(names) < 2:
        raise FricError(
            f"a circle needs two linear axes, and the machine has {len(linear)}", mend="Add the second to its file."
        )
    first, second = names
    rates = {machine.axes[name].cascade.sampling for name in names}
    if len(rates) > 1:
        raise FricError(
            f"the controllers of {first} and {second} sample at different rates", mend="Give both the same sampling."
        )
    return first, second


def require_voltage(axis: Axis, reference: Reference) -> None:
    """Refuse a motion that asks for more voltage than the drive has: plant and friction along the reference.

    Raises
    ------
    FricError
        When it does.
    """
    against = (axis.friction.steady_state(reference.velocity) + axis.constant_load) / axis.plant.K_f
    needed = float(np.abs(inverse_model(axis.plant, reference) + against).max())
    if needed > axis.cascade.limit:
        raise FricError(
            f"axis {axis.name} saturates: the motion needs {needed:.3g} V, and its limit is {axis.cascade.limit:g} V",
            mend="Lower the feed, or widen the contour.",
        )


def run_warnings(scheme: Scheme, traces: Mapping[str, Trace]) -> tuple[str, ...]:
    """Return what to know of a run: a voltage that was limited, a loop that no poles judge."""
    told = [
        Notice(
            f"axis {name} saturates in {trace.saturated / len(trace.time):.1%} of the samples: "
            "the feed asks for more voltage than its limit",
            "saturates",
        )
        for name, trace in traces.items()
        if trace.saturated
    ]
    if names := scheme.not_linear:
        text = f"{' and '.join(names)} is not linear: stability was not judged by poles, only by this run"
        told.append(Notice(text, "not-linear", "note"))
    return tuple(told)


def reduction(run: ContourRun, runs: Sequence[ContourRun]) -> float | None:
    """Return by how much a scheme lowers the glitch against the run without compensation; None where there is none."""
    bare = next((other.contour.glitch for other in runs if other.scheme.bare), 0.0)
    return None if not bare or run.contour.glitch == bare else 1 - run.contour.glitch / bare


def circle_document(runs: Sequence[CircleRun]) -> dict[str, Any]:
    """Return what schemes leave of one circle as a plain document, for programs."""
    test = runs[0].circle
    schemes = {}
    for run in runs:
        found = run.circularity
        schemes[run.scheme.name] = {
            "title": run.scheme.title,
            "glitch": found.glitch,
            "quadrants": list(found.quadrants),
            "radial_rms": found.rms,
            "radial_range": found.range,
            "warnings": list(run.warnings),
        }
    return {"velocity": test.feed, "radius": test.radius, "direction": test.direction, "schemes": schemes}
