"""What the next circle should show with a belief that was tuned, and between what."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import pi

import numpy as np

from fric.arrays import Real
from fric.contour import circularity
from fric.control.scheme import PAPER_SCHEMES, Scheme
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.identify.circle.measured import MeasuredCircle
from fric.identify.circle.revolutions import fit_circle
from fric.identify.circle.tuned import TunedAxis
from fric.reference import circle
from fric.simulate.axis import run_axis
from fric.simulate.machine import Axis

DRAWS = 6
"""Machines that are drawn from what tuning leaves open."""
ACCURACY = 1e-8
"""To what the simulated plant is integrated [m]."""


@dataclass(frozen=True)
class NextCircle:
    """What one scheme should leave of a circle.

    Parameters
    ----------
    feed, radius
        The circle [m/s], [m].
    scheme
        The scheme.
    glitch
        Its largest glitch [m].
    ci95
        Between what [m].
    """

    feed: float
    radius: float
    scheme: str
    glitch: float
    ci95: tuple[float, float]


def next_circles(
    tests: Sequence[MeasuredCircle], tuned: Mapping[str, TunedAxis], done: Callable[[], object] = lambda: None
) -> list[NextCircle]:
    """Return what schemes (c) and (f) should leave of the circles that were recorded, once more, with the new belief.

    The machine is taken to be what tuning found. The interval is that of machines drawn from the covariance of what
    was found, and of a part of the encoder's step; to above it is widened by what a circle with (c) shows where what
    tuning left of the recorded voltage (the mean of the revolutions, as far as it is more than noise) disturbs it too.

    Parameters
    ----------
    tests
        The circle tests that were tuned with.
    tuned
        The axes of the circle, by name.
    done
        Called after each circle.
    """
    found = []
    rng = np.random.default_rng(0)
    names = list(tuned)[:2]
    draws = [{name: _drawn(tuned[name], rng) for name in names} for _ in range(DRAWS)]
    observers = all(tuned[name].axis.observer is not None for name in names)
    true = {name: _true(tuned[name]) for name in names}
    step = max(tuned[name].axis.encoder.resolution for name in names)
    for n, test in enumerate(tests):
        bare = PAPER_SCHEMES["c"]
        try:
            own = _glitch(test, true, bare)
            more = max(_glitch(test, true, bare, {name: _left_over(n, tuned[name]) for name in names}) - own, 0.0)
        except FricError:  # no stable loop, or more voltage than there is
            continue
        for scheme in (bare, *([PAPER_SCHEMES["f"]] if observers else [])):
            try:
                own = _glitch(test, true, scheme)
                around = [own, *(_glitch(test, drawn, scheme) for drawn in draws)]
            except FricError:
                continue
            # the ends of a few draws lie inside the interval
            width = 0.3 * (max(around) - min(around)) + step / 4
            limits = max(min(around) - width, 0.0), max(around) + width + more
            found.append(NextCircle(test.feed, test.radius, scheme.name, own, limits))
            done()
    return found


def _true(tuned: TunedAxis) -> Axis:
    """Return the axis as it truly is, if what was found holds."""
    load = float(np.mean(tuned.after.plant[2:])) * tuned.nominal.K_f
    return replace(tuned.axis, plant=tuned.nominal, friction=tuned.friction, load=load)


def _drawn(tuned: TunedAxis, rng: np.random.Generator) -> Axis:
    """Return an axis that is true with what tuning leaves open."""
    true = _true(tuned)
    if tuned.estimates is None:
        return true
    coordinates, covariance = tuned.after.balance.coordinates, tuned.estimates.coordinates
    values, vectors = np.linalg.eigh(covariance)
    x = tuned.after.x + vectors @ (np.sqrt(np.maximum(values, 0.0)) * rng.standard_normal(len(values)))
    x = np.clip(x, tuned.after.x - 1.5, tuned.after.x + 1.5)
    plant = true.plant
    late = max(coordinates.delay(x), 0.5 / true.cascade.sampling)
    return replace(true, friction=coordinates.belief(x), plant=Plant(plant.A, plant.B, late, plant.K_f))


def _glitch(
    test: MeasuredCircle, axes: Mapping[str, Axis], scheme: Scheme, left: Mapping[str, _LeftOver] | None = None
) -> float:
    """Return the glitch of one circle [m], with what tuning left as a disturbance where it is given."""
    sampling = next(iter(axes.values())).cascade.sampling
    references = circle(test.radius, test.feed, 1, sampling, direction=test.direction)
    angle = np.unwrap(np.arctan2(references[1].position, references[0].position))
    measured = []
    for (name, axis), reference in zip(axes.items(), references, strict=True):
        excitation = None
        if left is not None:
            early = round(axis.plant.T_d * sampling)
            voltage = left[name](angle)
            excitation = -np.concatenate([voltage[early:], np.full(early, voltage[-1])])
        measured.append(run_axis(axis, reference, scheme, excitation=excitation, accuracy=ACCURACY).position)
    return circularity(measured[0], measured[1], test.radius).glitch


@dataclass(frozen=True)
class _LeftOver:
    """What tuning left of the voltage on a circle, the mean of its revolutions [V], by angle [rad]."""

    angle: Real
    voltage: Real

    def __call__(self, angle: Real) -> Real:
        return np.interp(angle % (2 * pi), self.angle, self.voltage, period=2 * pi)


def _left_over(n: int, tuned: TunedAxis) -> _LeftOver:
    record, part = tuned.after.balance.records[n], tuned.after.parts()[n]
    steady = record.revolution[record.used] >= 0
    if not steady.any():
        return _LeftOver(np.array([0.0]), np.array([0.0]))
    own = (record.angle[record.used][steady] % (2 * pi)) / (2 * pi)
    bins = 720
    cell = (own * bins).astype(int) % bins
    mean = np.bincount(cell, part[steady], bins) / np.maximum(np.bincount(cell, minlength=bins), 1)
    noise, rms = record.repeating(part) or 0.0, float(np.sqrt(np.mean(part**2)))
    share = float(np.sqrt(max(rms**2 - noise**2, 0.0))) / max(rms, 1e-12)
    return _LeftOver((np.arange(bins) + 0.5) * 2 * pi / bins, share * mean)


def worse_ahead(tests: Sequence[MeasuredCircle], predicted: Sequence[NextCircle], *, trusted: bool) -> str:
    """Return that the next circle may be worse than the recorded one, for messages; empty where it should not.

    Parameters
    ----------
    tests
        The circle tests that were tuned with.
    predicted
        What the next circles should show, for each the better scheme counts.
    trusted
        Whether the prediction itself is held against the recorded glitch, or the upper end of its interval.
    """
    for test in tests:
        seen = measured_glitch(test)
        ahead = [one for one in predicted if (one.feed, one.radius) == (test.feed, test.radius)]
        expected = [one.glitch if trusted else one.ci95[1] for one in ahead]
        if expected and min(expected) > seen:
            return (
                f"the next circle at {test.feed * 1e3:g} mm/s may have a glitch of {min(expected) * 1e6:.2f} µm, and "
                f"the recorded one has {seen * 1e6:.2f}"
            )
    return ""


def measured_quadrants(test: MeasuredCircle) -> tuple[float, float, float, float]:
    """Return the glitch of a circle that was measured at +x, +y, -x and -y [m], around its own centre."""
    first, second = test.together()
    a, b, _ = fit_circle(
        first.position if first.reference is None else first.reference,
        second.position if second.reference is None else second.reference,
    )
    return circularity(first.position - a, second.position - b, test.radius).quadrants


def measured_glitch(test: MeasuredCircle) -> float:
    """Return the largest glitch of a circle that was measured [m]."""
    return max(map(abs, measured_quadrants(test)))
