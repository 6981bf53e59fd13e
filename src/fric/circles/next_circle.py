"""What the next circle should show with a belief that was tuned, and between what."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from fric.arrays import Real
from fric.circles.left_over import completed
from fric.circles.measured import MeasuredCircle
from fric.circles.revolutions import fit_circle
from fric.circles.tune_bootstrap import recorded_again
from fric.circles.tuned import TunedAxis
from fric.contour import circularity
from fric.control.scheme import PAPER_SCHEMES, Scheme
from fric.drive.plant import Plant, hold_delay
from fric.errors import FricError
from fric.estimate import Estimate, as_filed
from fric.flaws.circle import LAW_DIFFERS
from fric.notice import Notice
from fric.reference import Reference
from fric.simulate.axis import run_axis
from fric.simulate.chance import ACCURACY, PLACES, Chance
from fric.simulate.circle import Circle
from fric.simulate.machine import Axis, Machine

SMEARED = 4.0
"""Times what is left over adds to a glitch that it may add besides: behind a filter of 70 Hz, in the mean over strokes
and travels, and where an axis breaks away in a jump, it is told smaller than it is. Of 18 machines with other laws of
friction all 70 next circles are within their intervals so; they left 2.9 times what the model alone predicts (median),
1.3 times what is predicted with it. One that was recorded without compensation, whose reversals jump, takes 3.6."""
DIFFERS, MORE = 1.5, 0.15e-6
"""Times, and by how much more than, what the model alone predicts [m], from which another law of friction is told."""


@dataclass(frozen=True)
class NextCircle:
    """What one scheme should leave of a circle."""

    # feed, radius: the circle [m/s], [m]
    feed: float
    radius: float
    scheme: str  # The scheme
    chance: Chance  # Its largest glitch at each place between two counts [m]
    ci95: tuple[float, float]  # Between what it lies [m]
    model: Chance  # The same as `chance`, if friction were what was found and nothing besides
    # Whether what is left over makes more of the circle than the model, and than the encoder explains
    other_law: bool = False

    @property
    def glitch(self) -> float:
        """Its largest glitch, the median over places [m]."""
        return self.chance.median

    @property
    def alone(self) -> float:
        """The same, if friction were what was found and nothing besides [m]."""
        return self.model.median


def next_circles(
    tests: Sequence[MeasuredCircle], tuned: Mapping[str, TunedAxis], done: Callable[[], object] = lambda: None
) -> list[NextCircle]:
    """Return what schemes (c) and (f) should leave of the circles that were recorded, with the new nominal parameters.

    The machine is taken to be what tuning found, and what that leaves of the recorded voltages is of its friction, over
    the travel since the last reversal: where the law differs from the model, the next circle meets that again.
    Each circle is run at several places between two counts, and the median counts.
    The interval is that of machines drawn from the covariance of what was found, each at another place.
    Above it is wider by `SMEARED` times what is left over adds, which behind the filter is told smaller than it is.

    tests: The circle tests that were tuned with.
    tuned: The axes of the circle, by name.
    done: Called after each circle.
    """
    found = []
    rng = np.random.default_rng(0)
    names = list(tuned)[:2]
    draws = [{name: _drawn(tuned[name], rng) for name in names} for _ in range(PLACES)]
    observers = all(tuned[name].axis.observer is not None for name in names)
    true = {name: _true(tuned[name]) for name in names}
    step = max(tuned[name].axis.encoder.resolution for name in names)
    again = cache(lambda name: recorded_again(tuned[name].after, PLACES))
    for n, test in enumerate(tests):
        whole = {name: _completed(tuned[name], n) for name in names}
        for scheme in (PAPER_SCHEMES[name] for name in ("cf" if observers else "c")):
            try:
                own, alone = _chance(test, whole, scheme), _chance(test, true, scheme)
                drawn = [_glitch(test, one, scheme, place) for place, one in enumerate(draws)]
            except FricError:  # no stable loop, or more voltage than there is
                continue
            around = [*own.values, *alone.values, *drawn]
            # the ends of a few draws lie inside the interval
            width = 0.3 * (max(around) - min(around)) + step / 4
            high = max(around) + width + SMEARED * max(own.median - alone.median, 0.0)
            ci95 = max(min(around) - width, 0.0), high
            other = _exceeds(own, alone) and _exceeds(own, _of_the_encoder(test, n, tuned, scheme, again))
            found.append(NextCircle(test.feed, test.radius, scheme.name, own, ci95, alone, other))
            done()
    return found


def law_warnings(predicted: Sequence[NextCircle]) -> list[Notice]:
    """Return that friction differs from the model, where what is left over makes more of a circle than the model."""
    more = [one for one in predicted if one.other_law]
    if not more:
        return []
    worst = max(more, key=lambda one: one.glitch - one.alone)
    alone, glitch, most = (Estimate(one, "m") for one in (worst.alone, worst.glitch, worst.ci95[1]))
    feed = Estimate(worst.feed, "m/s")
    return [LAW_DIFFERS.found(scheme=worst.scheme, feed=feed, alone=alone, glitch=glitch, most=most)]


def _exceeds(one: Chance, other: Chance) -> bool:
    """Tell whether a glitch is clearly larger than another: in the median, and at each place (a sign test, 1/32)."""
    larger = one.median > max(DIFFERS * other.median, other.median + MORE)
    return larger and all(difference > 0 for difference in (one - other).values)


def _of_the_encoder(
    test: MeasuredCircle, n: int, tuned: Mapping[str, TunedAxis], scheme: Scheme, again: Callable[[str], list[Real]]
) -> Chance:
    """Return what machines leave of the n-th circle whose friction is that of the model, and which record it again.

    What the encoder does not show is left over too, and is added to friction as what another law leaves. ``again``
    gives what an axis leaves over where its circles are recorded again, see `recorded_again`.
    """
    glitches = []
    for place in range(PLACES):
        axes = {
            name: _completed(replace(one, after=replace(one.after, residual=again(name)[place])), n)
            for name, one in tuned.items()
        }
        glitches.append(_glitch(test, axes, scheme, place))
    return Chance(tuple(glitches), 0.0)


def recorded_once_more(
    test: MeasuredCircle, n: int, before: Mapping[str, Axis], tuned: Mapping[str, TunedAxis]
) -> Chance:
    """Return what a circle leaves that is recorded again, with what controllers believed before [m].

    test, n: The circle that was recorded, and its number.
    before, tuned: Its axes as they were, and what was found of them.
    """
    axes = {}
    for name, one in tuned.items():
        true, old = _completed(one, n), before[name]
        nominal = old.nominal or old.plant
        axes[name] = replace(old, plant=true.plant, friction=true.friction, load=true.load, nominal=nominal)
    known = test.scheme in PAPER_SCHEMES
    found = []
    for scheme in [test.scheme] if known else "fca":
        try:
            found.append(_chance(test, axes, PAPER_SCHEMES[scheme]))
        except FricError:  # an axis without observer, or a loop that the plant found does not leave stable
            continue
    seen = measured_glitch(test)
    return min(found, key=lambda one: abs(one.median - seen), default=Chance((seen,), 0.0))


def _true(tuned: TunedAxis) -> Axis:
    """Return the axis as it truly is, if what was found holds."""
    load = float(np.mean(tuned.after.plant[2:])) * tuned.nominal.K_f
    return replace(tuned.axis, plant=tuned.nominal, friction=as_filed(tuned.friction), load=as_filed(load))


def _drawn(tuned: TunedAxis, rng: np.random.Generator) -> Axis:
    """Return an axis that is true with what tuning leaves open."""
    true = _true(tuned)
    if tuned.estimates is None:
        return true
    coordinates, covariance = tuned.after.balance.coordinates, tuned.estimates.coordinates
    values, vectors = np.linalg.eigh(covariance)
    root = vectors @ (np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T)  # no sign of an eigenvector is in it
    x = tuned.after.x + root @ rng.standard_normal(len(values))
    x = np.clip(x, tuned.after.x - 1.5, tuned.after.x + 1.5)
    plant = true.plant
    late = max(coordinates.delay(x), hold_delay(true.cascade.sampling))
    return replace(
        true, friction=as_filed(coordinates.directed(x)), plant=as_filed(Plant(plant.A, plant.B, late, plant.K_f))
    )


def _chance(test: MeasuredCircle, axes: Mapping[str, Axis], scheme: Scheme) -> Chance:
    """Return the glitch of a circle at each place between two counts [m]."""
    return Chance(tuple(_glitch(test, axes, scheme, place) for place in range(PLACES)), 0.0)


def _glitch(test: MeasuredCircle, axes: Mapping[str, Axis], scheme: Scheme, place: int) -> float:
    """Return the glitch of one circle, at one of `PLACES` places between two counts [m]."""
    machine = Machine("", dict(axes)).placed(place / PLACES)
    references = _references(test, next(iter(axes.values())).cascade.sampling)
    measured = [
        run_axis(axis, reference, scheme, accuracy=ACCURACY).position
        for axis, reference in zip(machine.axes.values(), references, strict=True)
    ]
    return circularity(measured[0], measured[1], test.radius).glitch


def _references(test: MeasuredCircle, sampling: float) -> tuple[Reference, Reference]:
    return Circle(test.radius, test.feed, 1, test.direction).references(sampling)


def _completed(tuned: TunedAxis, n: int) -> Axis:
    """Return the axis as it truly is where what was found leaves of the n-th circle is of its friction, by travel."""
    true, after = _true(tuned), tuned.after
    left = tuned.nominal.K_f * after.parts()[n]
    return replace(true, friction=completed(true.friction, [(after.balance.records[n], left)]))


def worse_ahead(
    tests: Sequence[MeasuredCircle],
    predicted: Sequence[NextCircle],
    again: Callable[[int], Chance],
    count: float,
    *,
    doubtful: bool = False,
) -> str:
    """Return that the next circle should be worse than the recorded one, for messages; empty where it should not.

    The recorded circle is one draw, and what it would leave again lies about it by the scatter of the machine that was
    found. A glitch below a count is none to be avoided.

    tests: The circle tests.
    predicted: What the next circles should show, for each the better scheme counts.
    again: Gives what the n-th circle leaves that is recorded again, with what controllers believed before [m].
    count: A count of the encoders [m].
    doubtful: Whether friction of this shape does not explain the circles: only the upper end of a prediction counts
        then.
    """
    for n, test in enumerate(tests):
        seen = measured_glitch(test)
        ahead = [one for one in predicted if (one.feed, one.radius) == (test.feed, test.radius)]
        expected = min((one.ci95[1] if doubtful else one.glitch for one in ahead), default=0.0)
        if expected <= max(seen, count):
            continue
        once_more = again(n)
        if expected > seen + once_more.half and (doubtful or expected > once_more.median):
            return (
                f"the next circle at {test.feed * 1e3:g} mm/s may have a glitch of {expected * 1e6:.2f} µm, and the "
                f"recorded one has {seen * 1e6:.2f}, up to {(seen + once_more.half) * 1e6:.2f} when it is "
                "recorded again"
            )
    return ""


def better_ahead(
    tests: Sequence[MeasuredCircle], predicted: Sequence[NextCircle], again: Callable[[int], Chance]
) -> bool:
    """Tell whether a next circle should be better than the recorded one by more than chance; arguments as above."""
    for n, test in enumerate(tests):
        seen, once_more = measured_glitch(test), again(n)
        ahead = [one.glitch for one in predicted if (one.feed, one.radius) == (test.feed, test.radius)]
        if ahead and min(ahead) < min(seen, once_more.median) - once_more.half:
            return True
    return False


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
