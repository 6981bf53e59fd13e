"""The parameters of a controller, refitted to recorded circles, and the next circle that is predicted with them.

The difference of friction in a measured circle from a machine's model is part of every drawn machine (`LeftOver`); with
a belief that was tuned the next circle is predicted (`next_circles`); `distrusts` collects the reasons against an
interval; `tune` refits friction, plant and delay.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from math import exp, floor, log10
from types import MappingProxyType
from zlib import crc32

import numpy as np
from scipy.ndimage import uniform_filter1d

from fric.arrays import Real
from fric.circles import tune_fit
from fric.circles.gains import against_stated, lags, stated_voltage
from fric.circles.measured import MeasuredCircle, measured_from_run
from fric.circles.revolutions import fit_circle, revolutions, steady
from fric.circles.tune_fit import Balance, FittedBalance, TunedAxis, VoltageRecord, fit, recorded_again, refined
from fric.contour import QUADRANTS, circularity, of_axes
from fric.control.scheme import OBSERVER, PAPER_SCHEMES, Scheme
from fric.design.cascade import falling_margin, hold_falling
from fric.drive.plant import Plant, hold_delay
from fric.errors import FricError
from fric.estimate import Estimate, as_filed
from fric.flaws import circle as flaws
from fric.flaws import flaw_of
from fric.flaws.channel import FOREIGN_COMPENSATION
from fric.flaws.circle import CIRCLE_DRIFTS, CIRCLE_MISFIT, TUNED_IN_PART, TUNING_NO_BETTER, TUNING_REFUSED
from fric.flaws.files import GAINS_DESIGNED
from fric.flaws.prediction import CIRCLE_ELSEWHERE, NO_MEASURED_CIRCLE
from fric.friction import FrictionModel
from fric.friction.directed import KNEE, Completed, Directed, directed, since_reversal, travels
from fric.notice import Notice, once
from fric.records.flaws import clock_flaws, timing
from fric.simulate.axis import run_axis
from fric.simulate.contour_run import ACCURACY, PLACES, Chance, Circle, run_circle
from fric.simulate.machine import Axis, Machine, NominalFriction
from fric.simulate.spread import Spread, draw_machine
from fric.units import si_unit

SHARE = 0.2  # Relative difference (95 %) of the residual force along another motion


@dataclass(frozen=True)
class LeftOver:
    """Measured circles, to which machines are completed.

    The balance of voltages along the measured motion leaves a residual force, for any parameters of the model. Over the
    travel since the last reversal it is part of the machine: a level that has changed, the friction at the reversals of
    this circle, cogging, directions that differ. Machines then differ in how friction changes from the measured motion
    to that of another scheme.
    """

    records: Mapping[str, tuple[VoltageRecord, ...]]  # By axis, the circles as balances of voltages
    tests: tuple[MeasuredCircle, ...]  # The circle tests
    seed: int = 0  # Of the change of the residual force along another motion

    @classmethod
    def of(cls, tests: Sequence[MeasuredCircle], machine: Machine, axes: Sequence[str], seed: int = 0) -> "LeftOver":
        """Return the data of circle tests for some axes of a machine, with reference and position of each.

        Where the voltage was not recorded, and no compensation was on, it is what the machine's controller gives along
        the recorded motion.
        """
        given = {name: [_with_voltage(test, machine.axes[name]) for test in tests] for name in axes}
        records = {name: tuple(tune_fit.voltage_record(test, name) for test in part) for name, part in given.items()}
        return cls(records, tuple(tests), seed)

    def __call__(self, machine: Machine, index: int | None = None) -> Machine:
        """Return a machine completed by the residual force of its model on the circles.

        index: Its number among those drawn, each of which has another share of the residual force; exactly the measured
            force where it is not given.
        """
        axes = dict(machine.axes)
        for name, records in self.records.items():
            axis, share = axes[name], 1.0
            if index is not None:
                key = np.random.SeedSequence(self.seed, spawn_key=(index, crc32(f"left over {name}".encode())))
                share = exp(SHARE / 1.96 * np.random.default_rng(key).standard_normal())
            axes[name] = replace(axis, friction=completed(axis.friction, [_left(log, axis) for log in records], share))
        return replace(machine, axes=axes)

    def seen(self, circle: Circle) -> dict[str, dict[str, float]]:
        """Return the measured glitch at each quadrant of a circle of this radius and feed [m], by scheme."""
        return {
            test.scheme or "a": dict(zip(QUADRANTS, measured_quadrants(test), strict=True)) for test in self.tests
            if np.allclose((test.radius, test.feed), (circle.radius, circle.feed), rtol=0.01)
        }  # fmt: skip


SPAN = 21  # Number of neighbouring travels whose mean residual force is kept, whatever its noise: 6 mm


def _recurring(sums: Real, counts: Real, grid: Real) -> Real:
    """Return the part of mean forces [N] that recurs from turn to turn, shape (2, n): a Wiener filter beyond the knee.

    sums, counts: Sum of the forces [N] and their number, by direction and turn, shape (2, turns, n).
    grid: Travels [m], between which the means are interpolated over their root, shape (n,).
    """
    count, turns = np.maximum(counts.sum(axis=1), 1), np.count_nonzero(counts, axis=1)
    mean = sums.sum(axis=1) / count
    apart = np.sum(counts * (sums / np.maximum(counts, 1) - mean[:, np.newaxis]) ** 2, axis=1) / count
    noise = np.sum(apart * turns / np.maximum(turns - 1, 1)) / max(np.count_nonzero(turns > 1), 1)
    for row in range(2):
        if (met := turns[row] > 0).any():
            mean[row] = np.interp(np.sqrt(grid), np.sqrt(grid[met]), mean[row, met])
    local = uniform_filter1d(mean, SPAN)
    power = uniform_filter1d((mean - local) ** 2, SPAN)
    kept = np.maximum(1.0 - noise / np.maximum(turns, 1) / np.maximum(power, 1e-300), 0.0)
    mean[:, KNEE:] = (local + kept * (mean - local))[:, KNEE:]
    return mean


def completed(friction: FrictionModel, left: Sequence[tuple[VoltageRecord, Real]], share: float = 1.0) -> Completed:
    """Return a friction model with its mean residual force in records, over the travel since the last reversal.

    Only what recurs from turn to turn is kept: noise of a voltage would make the loop swing. Between travels that were
    met it is interpolated over their root: so it rises with time near a reversal of a circle.

    left: Records, each with the residual force of the model at the samples used [N].
    """
    grid = travels(2 * max(record.test.radius for record, _ in left))
    turns = []
    for record, force in left:
        turn = record.revolution[record.used]
        direction, travel = np.array(since_reversal(record.position))[:, record.used]
        nearest = np.searchsorted(0.5 * (grid[1:] + grid[:-1]), travel)
        for of in (turn == n for n in np.unique(turn[turn >= 0])):
            alike = [of & (direction == sign) for sign in (1.0, -1.0)]
            turns.append([[np.bincount(nearest[at], w, len(grid)) for w in (force[at], None)] for at in alike])
    sums, counts = np.reshape(turns, (-1, 2, 2, len(grid))).transpose(2, 1, 0, 3)
    sides = share * _recurring(sums, counts, grid)
    # rounded to a share of the largest: of 0.2 mN even the sixth digit is one of the last bits of forces of 100 N
    decimals = 5 - floor(log10(max(np.abs(sides).max(), 1e-300)))
    return as_filed(Completed(friction, *map(tuple, np.round(sides, decimals))))


def _with_voltage(test: MeasuredCircle, axis: Axis) -> MeasuredCircle:
    test = test.of_effort({axis.name: axis.motion})
    trace = test.axes.get(axis.name)
    if trace is None or trace.input is not None or trace.reference is None or test.scheme not in ("", "a"):
        return test
    rate = (len(trace.time) - 1) / float(trace.time[-1] - trace.time[0])
    given = stated_voltage(axis.cascade, axis.nominal or axis.plant, trace.reference, trace.position, rate).given
    return replace(test, axes={**test.axes, axis.name: replace(trace, input=given)})


def _left(record: VoltageRecord, axis: Axis) -> tuple[VoltageRecord, Real]:
    """Return a record along its refined motion, and the residual force of a machine [N], at the samples used."""
    plant, replayed = axis.plant, _replayed(record, axis, axis.friction)
    used = replayed.used
    m, a = 1.0 / plant.B, plant.A / plant.B
    voltage = replayed.delayed(plant.T_d) - m * replayed.inertia[used] - a * replayed.damping[used]
    return replayed, plant.K_f * voltage - replayed.friction(axis.friction) - axis.constant_load


def _replayed(record: VoltageRecord, axis: Axis, friction: FrictionModel) -> VoltageRecord:
    """Return a record along the motion that an axis refines, with a friction model."""
    plant = axis.plant
    linear = 1.0 / plant.B, plant.A / plant.B, axis.constant_load / plant.K_f
    return refined(record, friction, plant.T_d, linear, plant.K_f)


SMEARED = 4.0
"""Uncertainty that the residual adds to the glitch, over the residual's effect on it: a filter of 70 Hz, the mean over
strokes and travels, and an axis that breaks away in a jump reduce the residual. Of 18 machines with other laws of
friction all 70 next circles are within their intervals then; they left 2.9 times what the model alone predicts
(median), 1.3 times what is predicted with it. A circle without compensation, whose reversals jump, needs 3.6."""
DIFFERS, MORE = 1.5, 0.15e-6  # Ratio to, and excess over, the model's prediction [m] that show another law of friction


@dataclass(frozen=True)
class CircleForecast:
    """Prediction of a circle under one scheme."""

    feed: float  # feed, radius: the circle [m/s], [m]
    radius: float
    scheme: str
    chance: Chance  # Its largest glitch at each place between two counts [m]
    ci95: tuple[float, float]  # Its range [m]
    model: Chance  # The same as `chance`, with the identified friction alone
    other_law: bool = False  # Whether the residual makes the glitch larger than model and encoder explain

    @property
    def glitch(self) -> float:
        """Its largest glitch, the median over places [m]."""
        return self.chance.median

    @property
    def alone(self) -> float:
        """The same with the identified friction alone [m]."""
        return self.model.median


def next_circles(
    tests: Sequence[MeasuredCircle], tuned: Mapping[str, TunedAxis], done: Callable[[], object] = lambda: None
) -> list[CircleForecast]:
    """Return the predictions of schemes (c) and (f) on the recorded circles, with the new nominal parameters.

    The machine is assumed to be that of the tuning, and the residual of the recorded voltages to be a part of its
    friction, over the travel since the last reversal: a difference from the model recurs on the next circle. Each
    circle is run at several places between two counts, and the median counts. The interval is that of machines drawn
    from the covariance of what was found, each at another place. Above, it is wider by `SMEARED` times the effect of
    the residual, which the filter reduces.
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
                chance, alone = _chance(test, whole, scheme), _chance(test, true, scheme)
                drawn = [_glitch(test, draw, scheme, place) for place, draw in enumerate(draws)]
            except FricError:  # no stable loop, or more voltage than there is
                continue
            around = [*chance.values, *alone.values, *drawn]
            # the ends of a few draws lie inside the interval
            width = 0.3 * (max(around) - min(around)) + step / 4
            high = max(around) + width + SMEARED * max(chance.median - alone.median, 0.0)
            ci95 = max(min(around) - width, 0.0), high
            other = _exceeds(chance, alone) and _exceeds(chance, _of_the_encoder(test, n, tuned, scheme, again))
            found.append(CircleForecast(test.feed, test.radius, scheme.name, chance, ci95, alone, other))
            done()
    return found


def law_warnings(predicted: Sequence[CircleForecast]) -> list[Notice]:
    """Return a warning where the residual makes a glitch larger than the model predicts."""
    if not (more := [circle for circle in predicted if circle.other_law]):
        return []
    worst = max(more, key=lambda circle: circle.glitch - circle.alone)
    alone, glitch, most = (Estimate(value, "m") for value in (worst.alone, worst.glitch, worst.ci95[1]))
    feed = Estimate(worst.feed, "m/s")
    return [flaws.LAW_DIFFERS.found(scheme=worst.scheme, feed=feed, alone=alone, glitch=glitch, most=most)]


def _exceeds(chance: Chance, other: Chance) -> bool:
    """Return whether a glitch is clearly larger than another: in the median, and at each place (a sign test, 1/32)."""
    larger = chance.median > max(DIFFERS * other.median, other.median + MORE)
    return larger and all(difference > 0 for difference in (chance - other).values)


def _of_the_encoder(
    test: MeasuredCircle, n: int, tuned: Mapping[str, TunedAxis], scheme: Scheme, again: Callable[[str], list[Real]]
) -> Chance:
    """Return the glitches of the n-th circle with residuals that `again` gives, of machines that are as the model: of
    the error of the encoder, too, which is added to friction in the same way.
    """
    glitches = []
    for place in range(PLACES):
        axes = {
            name: _completed(replace(axis, after=replace(axis.after, residual=again(name)[place])), n)
            for name, axis in tuned.items()
        }
        glitches.append(_glitch(test, axes, scheme, place))
    return Chance(tuple(glitches), 0.0)


def circle_again(test: MeasuredCircle, n: int, before: Mapping[str, Axis], tuned: Mapping[str, TunedAxis]) -> Chance:
    """Return the glitch of a circle that is recorded again, with the former models of the controllers [m]."""
    axes = {}
    for name, axis in tuned.items():
        true, old = _completed(axis, n), before[name]
        nominal = old.nominal or old.plant
        axes[name] = replace(old, plant=true.plant, friction=true.friction, load=true.load, nominal=nominal)
    found = []
    for scheme in [test.scheme] if test.scheme in PAPER_SCHEMES else "fca":
        with suppress(FricError):  # an axis without observer, or a loop that the plant found does not leave stable
            found.append(_chance(test, axes, PAPER_SCHEMES[scheme]))
    seen = measured_glitch(test)
    return min(found, key=lambda chance: abs(chance.median - seen), default=Chance((seen,), 0.0))


def _true(tuned: TunedAxis) -> Axis:
    """Return the axis with the identified parameters as its true ones."""
    load = float(np.mean(tuned.after.plant[2:])) * tuned.nominal.K_f
    return replace(tuned.axis, plant=as_filed(tuned.nominal), friction=as_filed(tuned.friction), load=as_filed(load))


def _drawn(tuned: TunedAxis, rng: np.random.Generator) -> Axis:
    """Return an axis drawn from the uncertainty of the tuning."""
    true = _true(tuned)
    if tuned.estimates is None:
        return true
    coordinates, covariance = tuned.after.balance.coordinates, tuned.estimates.coordinates
    values, vectors = np.linalg.eigh(covariance)
    root = vectors @ (np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T)  # no sign of an eigenvector is in it
    x = np.clip(tuned.after.x + root @ rng.standard_normal(len(values)), tuned.after.x - 1.5, tuned.after.x + 1.5)
    plant = replace(true.plant, T_d=max(coordinates.delay(x), hold_delay(true.cascade.sampling)))
    return replace(true, friction=as_filed(coordinates.directed(x)), plant=as_filed(plant))


def _chance(test: MeasuredCircle, axes: Mapping[str, Axis], scheme: Scheme) -> Chance:
    """Return the glitch of a circle at each place between two counts [m]."""
    return Chance(tuple(_glitch(test, axes, scheme, place) for place in range(PLACES)), 0.0)


def _glitch(test: MeasuredCircle, axes: Mapping[str, Axis], scheme: Scheme, place: int) -> float:
    """Return the glitch of one circle, at one of `PLACES` places between two counts [m]."""
    machine = Machine("", dict(axes)).placed(place / PLACES)
    turn = Circle(test.radius, test.feed, 1, test.direction)
    measured = [
        run_axis(machine.axes[name], reference, scheme, accuracy=ACCURACY).position if name in axes
        else reference.position
        for name, reference in zip(test.names, turn.references(next(iter(axes.values())).cascade.sampling), strict=True)
    ]  # fmt: skip
    return circularity(measured[0], measured[1], test.radius).glitch


def _completed(tuned: TunedAxis, n: int) -> Axis:
    """Return the axis whose friction includes the residual of the n-th circle, by travel."""
    true, after = _true(tuned), tuned.after
    left = tuned.nominal.K_f * after.parts()[n]
    return replace(true, friction=completed(true.friction, [(after.balance.records[n], left)]))


def worse_ahead(
    tests: Sequence[MeasuredCircle], predicted: Sequence[CircleForecast], again: Callable[[int], Chance], count: float,
    *, doubtful: bool = False,
) -> str:  # fmt: skip
    """Return the reason to expect a worse next circle than the recorded one; empty if there is none.

    The recorded circle is a single draw, and its repetition scatters as the identified machine does. A glitch below an
    encoder count is acceptable.

    predicted: What the next circles should show, for each the better scheme counts.
    again: Gives the glitch of the n-th circle, recorded again with the former models of the controllers [m].
    count: A count of the encoders [m].
    doubtful: Whether friction of this shape does not explain the circles: then only upper ends of predictions count.
    """
    for n, test in enumerate(tests):
        seen, ahead = measured_glitch(test), _of(test, predicted)
        expected = min((circle.ci95[1] if doubtful else circle.glitch for circle in ahead), default=0.0)
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
    tests: Sequence[MeasuredCircle], predicted: Sequence[CircleForecast], again: Callable[[int], Chance]
) -> bool:
    """Return whether a next circle should be better than the recorded by more than chance; arguments as above."""
    for n, test in enumerate(tests):
        once_more, ahead = again(n), [circle.glitch for circle in _of(test, predicted)]
        if ahead and min(ahead) < min(measured_glitch(test), once_more.median) - once_more.half:
            return True
    return False


def _of(test: MeasuredCircle, predicted: Sequence[CircleForecast]) -> list[CircleForecast]:
    return [circle for circle in predicted if (circle.feed, circle.radius) == (test.feed, test.radius)]


def measured_quadrants(test: MeasuredCircle) -> tuple[float, float, float, float]:
    """Return the glitch of a circle that was measured at +x, +y, -x and -y [m], around its centre, at steady feed."""
    first, second = test.together()
    a, b, _ = fit_circle(first.asked, second.asked)
    angle = np.unwrap(np.arctan2(second.asked - b, first.asked - a))
    inside = steady(first.time, angle)  # without its run-out, where a reversal is at another feed
    inside = inside if np.ptp(angle[inside]) >= 2 * np.pi else slice(None)
    return circularity(first.position[inside] - a, second.position[inside] - b, test.radius).quadrants


def measured_glitch(test: MeasuredCircle) -> float:
    """Return the largest glitch of a circle that was measured [m]."""
    return max(map(abs, measured_quadrants(test)))


GLITCH_APART, SHARE_APART = 5e-7, 0.03  # Largest error of a completed machine in a measured glitch: [m], as a share
FARTHEST, TELLING, LATER = 4e-4, 2.0, 0.1
"""Most shift of the delay [s], least gain in a circle's voltages by it, and its least share of the delay."""
SOFTER, STIFFER = Spread(0.5, 0.5), Spread(2.0, 2.0)  # Factors of the logs' stiffness, which shifts as a delay does
OTHER_FEED = 2.0  # Ratio of feeds, and of radii, beyond which a measured circle predicts little of another


def distrusts(
    machine: Machine, notices: Iterable[Notice], tests: Sequence[MeasuredCircle], records: Sequence[VoltageRecord],
    circle: Circle, gains: Mapping[str, float] = MappingProxyType({}),
) -> tuple[Notice, ...]:  # fmt: skip
    """Return the reasons why no interval of a prediction is valid; empty if all are.

    machine: The machine at the estimates, completed by the tests where there are any.
    tests, records: Measured circles, and their axes as balances of voltages. Where one has no voltage, its friction is
        found with the stated gains: it agrees with any.
    gains: By axis, half the interval of K_p over K_p: a glitch is as uncertain.
    """
    wrong = [item for item in notices if item.severity == "wrong" and not (tests and flaw_of(item).circle_settles)]
    measured = [] if tests else [NO_MEASURED_CIRCLE.found()]
    seen = _of_circles(machine, tests, records, circle, gains)
    return once([*measured, *wrong, *unknown_gains(notices, tests), *seen])


def unknown_gains(notices: Iterable[Notice], tests: Sequence[MeasuredCircle]) -> Iterator[Notice]:
    """Yield the axes with designed gains whose circle has no voltage: such a circle agrees with any gains."""
    for name in sorted({text.where.removeprefix("axis ") for text in notices if text.code == GAINS_DESIGNED.code}):
        if any(name in test.axes and test.axes[name].input is None for test in tests):
            yield flaws.GAINS_UNKNOWN.found(f"axis {name}")


def _of_circles(
    machine: Machine, tests: Sequence[MeasuredCircle], records: Sequence[VoltageRecord], circle: Circle,
    gains: Mapping[str, float] = MappingProxyType({}),
) -> Iterator[Notice]:  # fmt: skip
    for test in tests:
        for name in test.names:
            second = machine.axes[name].second_mass if name in machine.axes else None
            if second is not None and second.encoder == "motor" and test.instrument in ("encoders", ""):
                yield flaws.TABLE_UNSEEN.found(f"axis {name}")
        yield from _disagreement(machine, test, gains)
    for record in records:
        yield from _delay(machine.axes[record.axis], record)
        yield from _controller(machine.axes[record.axis], record)
    if tests:
        feeds = [max(circle.feed / test.feed, test.feed / circle.feed) for test in tests]
        radii = [max(circle.radius / test.radius, test.radius / circle.radius) for test in tests]
        if min(feeds) > OTHER_FEED or min(radii) > OTHER_FEED:
            yield CIRCLE_ELSEWHERE.found()


def _disagreement(machine: Machine, test: MeasuredCircle, gains: Mapping[str, float]) -> Iterator[Notice]:
    """Yield the warnings where even the machine completed by a circle does not reproduce its glitches."""
    if (scheme := PAPER_SCHEMES.get(test.scheme or "a")) is None:
        return
    try:
        run = run_circle(machine, scheme, Circle(test.radius, test.feed, 2, test.direction))
        whole = None if {*test.names} <= machine.axes.keys() or test.is_ball_bar else revolutions(test)
    except FricError as error:
        yield flaws.CIRCLE_CANNOT_RUN.found(test.where, why=error.what)
        return
    judged = of_axes(test.names, machine.axes)
    seen, expected = measured_quadrants(test), tuple(glitch.median for glitch in run.glitches)
    if whole is not None:
        expected = measured_quadrants(whole.beside(measured_from_run(run), run.traces))
    share = SHARE_APART + max((gains.get(name, 0.0) for name in test.names), default=0.0)
    off = {
        name: (value, other) for name, value, other in zip(QUADRANTS, seen, expected, strict=True)
        if name in judged and not np.isclose(value, other, rtol=share, atol=GLITCH_APART)
    }  # fmt: skip
    if off:
        microns = {name: (f"{a * 1e6:+.1f}", f"{b * 1e6:+.1f}") for name, (a, b) in off.items()}
        glitches = "; ".join(f"{name} {a} µm measured, {b} µm simulated" for name, (a, b) in microns.items())
        yield flaws.COMPLETED_DISAGREES.found(test.where, glitches=glitches)


def _delay(axis: Axis, record: VoltageRecord) -> Iterator[Notice]:
    """Yield the warnings where a delay other than that of the logs explains a circle's voltages far better.

    For each delay the voltage is balanced by inertia, damping, a constant and friction (nominal, softer, stiffer), each
    with a fitted factor: friction that has changed is no delay.
    """
    plant = axis.plant
    model = axis.friction.model if isinstance(axis.friction, Completed) else axis.friction
    replayed = _replayed(record, axis, model)
    used = replayed.used
    alone = Machine("", {axis.name: replace(axis, friction=model)})
    others = [draw_machine(alone, 0, spreads={"stiffness": spread})[0].axes[axis.name] for spread in (SOFTER, STIFFER)]
    frictions = [replayed.friction(model) for model in (model, *(other.friction for other in others))]
    parts = [replayed.inertia[used], replayed.damping[used], np.ones(np.count_nonzero(used)), *frictions]
    basis = np.linalg.qr(np.column_stack(parts))[0]

    def left(delay: float) -> float:
        voltage = replayed.delayed(delay)
        return float(np.sqrt(np.mean((voltage - basis @ (basis.T @ voltage)) ** 2)))

    tried = plant.T_d + np.linspace(-FARTHEST, FARTHEST, 41)
    best = min(tried[tried >= 0], key=left)
    if left(plant.T_d) > TELLING * left(best) and abs(best - plant.T_d) > LATER * plant.T_d:
        seen = Estimate(float(best), "s")
        yield flaws.DELAY_DIFFERS.found(f"axis {axis.name}", plant=Estimate(plant.T_d, "s"), circle=seen)


def _controller(axis: Axis, record: VoltageRecord) -> Iterator[Notice]:
    """Yield the warnings where the recorded voltage is not that of the stated controller without compensation.

    Its inverse model may be of another plant than that identified since: that is no wrong gain. Nor is a share of the
    reference, to which the integral sums up the least error of K_v or of the instant of a sample.
    """
    if record.test.scheme not in ("", "a"):
        return
    t, reference, measured, voltage = record.raw
    rate, velocity = 1 / record.sampled, np.gradient(reference, t)
    lag = float(velocity @ (reference - measured) / max(velocity @ velocity, 1e-300))
    late = lags(axis.cascade, lag, f"axis {axis.name}") if axis.cascade.K_i else []
    yield from (notice for notice in late if notice.severity == "wrong")
    stated = stated_voltage(axis.cascade, axis.nominal or axis.plant, reference, measured, rate)
    if (held := against_stated(axis.cascade, stated, voltage, rate)).as_stated:
        return
    fed = np.column_stack([velocity, np.gradient(velocity, t), np.ones(len(t)), reference])
    share, *_ = np.linalg.lstsq(fed, held.recorded - held.given, rcond=None)
    if not against_stated(axis.cascade, stated, voltage - fed @ share, rate).as_stated:
        yield flaws.CONTROLLER_DIFFERS.found(f"axis {axis.name}", how=held.describe(), friction=False)


def observers_distrust(schemes: Sequence[Scheme], notices: Iterable[Notice]) -> Mapping[str, tuple[Notice, ...]]:
    """Return, for each scheme with an observer, the reason not to trust it: the response was not measured."""
    why = tuple(notice for notice in notices if flaw_of(notice).no_response)
    return {scheme.name: why for scheme in schemes if OBSERVER in scheme.blocks and why}


LEARNED = "learned"  # Name of the friction model of a scheme that feeds forward what was learned
CLEARLY = 0.6  # Largest share of the glitch under the best model that is left after learning, for it to judge the model


def wrong_shape(circles: Iterable[tuple[Scheme, float]]) -> list[Notice]:
    """Return a warning if learning leaves clearly less of a circle than every model with pre-sliding.

    Learning needs no friction model. If it leaves `CLEARLY` less than a model tuned to circles, the shape of the model
    does not fit the machine's friction.

    circles: Schemes, and the glitch of each on the circle [m].
    """
    circles = list(circles)
    learned = [glitch for scheme, glitch in circles if scheme.friction == LEARNED]
    modelled = [glitch for scheme, glitch in circles if scheme.friction not in {None, "static", LEARNED}]
    if not learned or not modelled or not min(learned) < CLEARLY * min(modelled):
        return []
    return [flaws.MODEL_SHAPE.found(learned=Estimate(min(learned), "m"), model=Estimate(min(modelled), "m"))]


def wrong_shape_measured(tests: Iterable[MeasuredCircle]) -> list[Notice]:
    """Return the same for measured circles, grouped by radius and feed; they state the active scheme."""
    known = {**PAPER_SCHEMES, LEARNED: Scheme(LEARNED, LEARNED, friction=LEARNED)}
    alike = defaultdict(list)
    for test in tests:
        if test.scheme in known and not test.is_ball_bar:
            alike[test.radius, test.feed].append((known[test.scheme], measured_glitch(test)))
    return [notice for circles in alike.values() for notice in wrong_shape(circles)]


GROWS = 0.8
"""Margin of the falling branch below which a loop is redesigned: above it, errors grow by less than e² as an axis
passes at 10 mm/s, and stiffer gains would cost as much by encoder noise."""
UNHELD, CAUTION, LEAST = 0.9, 0.09, 0.97
"""Margin below which less than the whole friction is fed forward, the reduction per missing margin, and the least share
that is fed forward. An axis that is pushed ahead of its friction runs away from it, an axis that lags sticks: of 46
machines of 200 that lack margin, exact knowledge leaves 11 to 13 with more than 1.1 µm at 10 mm/s, and 4 to 6 with a
tenth less for each margin missing. That costs 0.1 µm at 100 mm/s with an observer, 0.3 without."""


def _margin(tuned: TunedAxis) -> float:
    blocks = () if tuned.axis.observer is None else (tuned.axis.observer,)
    return falling_margin(tuned.nominal, tuned.axis.cascade, tune_fit.gms_of(tuned.friction), blocks)


def holds(axis: TunedAxis) -> bool:
    """Return whether the loop of a tuned axis is stable against its falling friction."""
    return _margin(axis) >= GROWS


def cautious(axis: TunedAxis) -> TunedAxis:
    """Return a tuned axis with reduced feedforward if its friction falls more steeply than the loop can stabilise."""
    if not axis.improves or (missing := UNHELD - _margin(axis)) <= 0.0:
        return axis
    fed = replace(axis.axis.nominal_friction, gain=round(max(1.0 - CAUTION * missing, LEAST), 4))
    return replace(axis, axis=replace(axis.axis, nominal_friction=fed))


def holding(axis: TunedAxis) -> TunedAxis:
    """Return a tuned axis whose cascade and observer stabilise its falling friction; unchanged if they already do."""
    if not axis.improves or holds(axis):
        return axis
    cascade, watch = hold_falling(axis.nominal, axis.axis.cascade, tune_fit.gms_of(axis.friction), axis.axis.observer)
    return replace(axis, axis=replace(axis.axis, cascade=cascade, observer=watch), loop=True)


def loop_warnings(axes: Mapping[str, TunedAxis]) -> Iterator[Notice]:
    """Yield the warnings about loops that falling friction destabilises, and about their redesign."""
    for name, axis in axes.items():
        if not axis.improves:
            continue
        cascade, margin, fed = axis.axis.cascade, _margin(axis), axis.axis.nominal_friction.gain
        if axis.loop:
            observer = None if axis.axis.observer is None else axis.axis.observer.q.cutoff
            gains = {"K_p": cascade.K_p, "K_i": cascade.K_i, "K_v": cascade.K_v, "filter": cascade.velocity_filter}
            share = 0.0 if fed == 1.0 else fed
            yield flaws.LOOP_DESIGNED.found(f"axis {name}", margin=margin, observer=observer, fed=share, **gains)
        elif margin < UNHELD:
            yield flaws.FALLING_FRICTION.found(f"axis {name}", margin=margin, fed=fed, design=margin < GROWS)


GAIN = 0.97  # Largest share of four parameters' residual that the full shape may leave, to be chosen
DISPLACED = 0.5e-6  # Largest error of the position by a jittering clock [m]: more exceeds the error to compensate
AGAIN, RESTS = 3, 0.01  # Most refinements of motion and fit, and change of the logarithms at which they end
FEWER = (("level", "stiffness", "alpha", "k"), ("level", "C", "ratio", "v_s", "delta"), ("level",))
"""Parts of the identified friction to keep, if all of it should make a circle worse: all but its fall with speed, which
matters where a circle is slow; all but the stiffness, which matters where it is fast; only the level."""
MISFIT = "the residual is not friction of this shape"
GROWING = "falling friction destabilises the loop (`loop=True` designs new gains)"


def tune_axis(axis: Axis, tests: Sequence[MeasuredCircle], done: Callable[[], object] = lambda: None) -> TunedAxis:
    """Refit the nominal parameters of an axis' controller to recorded circles.

    Per axis ``W[u(t - T_d)] = m·W[z̈] + a·W[ż] + o + W[F(z)]/K_f`` with W a low-pass of 70 Hz, zero phase; m, a and an
    offset of each circle are linear. First the level of friction, its stiffness, C and T_d are searched; then, if the
    residual exceeds noise and encoder effects, F_s/F_c, v_s, delta, each alpha and each k, and a level for each
    direction, each kept if it explains more. In each case the intervals are those of the whole shape.
    """
    if "gms" not in axis.nominal_friction.models:
        what = f"the controller of axis {axis.name} believes no GMS model, which tuning starts from"
        hint = "Identify one: fric identify gms, and name it under feedforward in the machine file."
        raise FricError(what, hint=hint)
    nominal = axis.nominal or axis.plant
    records = tuple(tune_fit.voltage_record(test, axis.name) for test in tests)
    few = tune_fit.BalanceCoordinates.of(axis.nominal_friction.models["gms"], nominal.T_d)
    gain = float(np.log(axis.nominal_friction.gain)) if axis.nominal_friction.gain > 0 else 0.0
    start = np.array([gain, 0.0, 0.0, 0.0])
    before = tune_fit.at(Balance(records, few, nominal.K_f), start, np.array([1 / nominal.B, nominal.A / nominal.B]))
    starts = [start + np.array([0.0, np.log(stiffness), np.log(C), 0.0]) for stiffness, C in tune_fit.STARTS]
    found = fit(Balance(records, few, nominal.K_f), starts)
    done()
    found, full = _again(found), False
    done()
    if found.plant[0] > 0 and found.rms > tune_fit.SHAPE * tune_fit.explained(found):
        for shape in (few.full(), None):
            richer = shape or found.balance.coordinates.sided()
            start = richer.moved(found.balance.coordinates, found.x)
            other = _again(fit(replace(found.balance, coordinates=richer), [start], found.rms))
            if other.rms < GAIN * tune_fit.at(replace(found.balance, records=other.balance.records), found.x).rms:
                found, full = other, full or shape is not None
    for _ in range(AGAIN if found.plant[0] > 0 else 0):
        found = tune_fit.instrumented(found)
    done()
    coordinates = found.balance.coordinates
    friction, T_d = coordinates.directed(found.x), coordinates.delay(found.x)
    m, a = found.plant[:2]
    warnings = list(tune_fit.identifiability_warnings(axis, tests, found))
    if not (m > 0 and T_d >= hold_delay(axis.cascade.sampling)):  # no machine
        return TunedAxis(axis, friction, nominal, before, found, None, full, False, tuple(warnings))
    plant = Plant(A=max(float(a / m), 0.0), B=float(1 / m), T_d=T_d, K_f=nominal.K_f)
    unexplained = {flaws.ONE_FEED.code, CIRCLE_MISFIT.code} <= {warning.code for warning in warnings}
    estimates = tune_fit.tuned_estimates(found, plant, axis.motion, unexplained=unexplained)
    warnings += tune_fit.timing_warnings(axis, found, estimates.plant["T_d"])
    improves = found.rms < before.rms
    new = with_belief(axis, friction, plant) if improves else axis
    return TunedAxis(new, friction, plant, before, found, estimates, full, improves, tuple(warnings))


def with_belief(axis: Axis, friction: FrictionModel, plant: Plant) -> Axis:
    """Return an axis with a nominal friction and plant, as a file holds them: feedforward with lead, and observer."""
    friction, plant = as_filed(friction), as_filed(plant)
    static = directed(tune_fit.gms_of(friction).static, friction.negative if isinstance(friction, Directed) else None)
    models = {**axis.nominal_friction.models, "static": static, "gms": friction}
    observer = None if axis.observer is None else replace(axis.observer, A=plant.A, B=plant.B)
    return replace(axis, nominal_friction=NominalFriction(models, 1.0, "auto"), nominal=plant, observer=observer)


def in_part(axis: TunedAxis, before: Axis, names: Sequence[str]) -> TunedAxis:
    """Return a tuned axis with some coordinates of the identified friction, and the plant, as nominal models."""
    coordinates = axis.after.balance.coordinates
    kept = np.array([name.rpartition("_")[0] in names or name in (*names, "T_d", "side") for name in coordinates.names])
    friction = as_filed(coordinates.directed(np.where(kept, axis.after.x, 0.0)))
    assert axis.estimates is not None  # of what is improved
    part = replace(axis, axis=with_belief(before, friction, axis.nominal), estimates=axis.estimates.at(friction))
    return cautious(part)


def _again(found: FittedBalance) -> FittedBalance:
    """Return the fit along the motion that it resolves more finely; each time the delay's error falls to a fifth."""
    for _ in range(AGAIN):
        if not found.plant[0] > 0:
            break
        finer = tuple(tune_fit.refined(record, *found.truth(n)) for n, record in enumerate(found.balance.records))
        again = fit(replace(found.balance, records=finer), [found.x], found.rms, 5)
        moved, found = np.abs(again.x - found.x).max(), again
        if moved < RESTS:
            break
    return found


@dataclass(frozen=True)
class Tuned:
    """Result of circles for a machine."""

    machine: Machine  # The machine with its new nominal parameters
    axes: Mapping[str, TunedAxis]  # What was found, by axis
    tests: tuple[MeasuredCircle, ...]  # The circles
    predicted: tuple[CircleForecast, ...]  # What the next circles should show; empty where the result is refused
    warnings: tuple[Notice, ...]  # Warnings: what the circles do not determine, and what was refused

    @property
    def improves(self) -> bool:
        """Whether any axis is better than it was."""
        return any(axis.improves for axis in self.axes.values())


def tune(
    machine: Machine, tests: Sequence[MeasuredCircle], done: Callable[[], object] = lambda: None, *, loop: bool = False
) -> Tuned:
    """Refit the nominal parameters of a machine's controllers to recorded circles, axis by axis.

    An axis keeps its nominal parameters if they leave less of the recorded voltages than the result. All axes keep them
    if the log's clock is wrong, or the next circle should be worse than the recorded one.

    tests: Circle tests with reference, position and voltage of the machine's axes; a fast and a slow circle are
        needed. An axis that the machine does not have is assumed to follow its reference.
    loop: Whether loops that do not hold their falling friction are redesigned (`fric.design.cascade`).
    Raises FricError: When a test lacks a channel, or an axis that the machine has, or there is no nominal GMS model.
    """
    names = tests[0].names
    for test in tests:
        if test.names != names or test.is_ball_bar:
            words = "a ball bar's" if test.is_ball_bar else f"of {' and '.join(test.names)}"
            raise FricError(
                f"is {words}, and tuning needs traces of {' and '.join(names)} in every test", where=test.where,
                hint="Give controller traces of the same axes.",
            )  # fmt: skip
    before = {name: machine.axis(name) for name in names if name in machine.axes or not set(names) & set(machine.axes)}
    tests = [test.following(*(set(test.names) - set(before))) for test in tests]
    axes = {name: tune_axis(axis, tests, done) for name, axis in before.items()}
    axes = {name: cautious(holding(axis) if loop else axis) for name, axis in axes.items()}
    logs = [log for test in tests for log in test.logs()]
    warnings = [warning for axis in axes.values() for warning in axis.warnings] + trace_flaws(tests)
    better = all(axis.improves for axis in axes.values())
    predicted = next_circles(tests, axes, done) if better else []
    found = axes
    # where constant friction of this shape does not explain the circle, only the upper end of a prediction counts, and
    # it is not known which part of the result is valid
    doubtful = any(warning.code in {CIRCLE_MISFIT.code, CIRCLE_DRIFTS.code} for warning in warnings)
    if any(clock.lost or clock.displaced > DISPLACED for clock in map(timing, logs)):
        why = "the log's clock is wrong (see above)"
    elif better and not predicted:
        why = "with the result no stable circle can be simulated"
    else:
        once_more = cache(lambda n: circle_again(tests[n], n, before, found))
        count = max(axis.encoder.resolution for axis in before.values())
        if (why := worse_ahead(tests, predicted, once_more, count, doubtful=doubtful)) and not doubtful:
            for kept in FEWER:
                some = {name: in_part(axis, before[name], kept) for name, axis in axes.items()}
                ahead = next_circles(tests, some)
                if ahead and not worse_ahead(tests, ahead, once_more, count) and better_ahead(tests, ahead, once_more):
                    axes, predicted = some, ahead
                    words = "only the level of the identified friction is kept"
                    if len(kept) > 1:
                        left = "stiffnesses" if "C" in kept else "how friction falls with speed, and C"
                        words = f"all of the result is kept but {left}"
                    warnings.append(TUNED_IN_PART.found(why=why, kept=words))
                    why = ""
                    break
        if why:
            why += f": {MISFIT if all(map(holds, axes.values())) else GROWING}"
    if why:
        warnings.append(TUNING_REFUSED.found(why=why))
        axes = {name: replace(axis, axis=machine.axes[name], improves=False, loop=False) for name, axis in axes.items()}
        predicted = []  # what is kept shows what was recorded
    warnings += law_warnings(predicted)
    for name, tuned in axes.items():
        if not tuned.improves and not why and tuned.after.rms < tuned.before.rms:
            no_machine = "This circle alone gives no positive mass or no delay (record a slow one too)"
            warnings.append(TUNING_REFUSED.found(f"axis {name}", why=no_machine))
        elif not tuned.improves and not why:
            volts = si_unit("input", tuned.axis.motion)
            after, before_it = Estimate(tuned.after.rms, volts), Estimate(tuned.before.rms, volts)
            warnings.append(TUNING_NO_BETTER.found(f"axis {name}", after=after, before=before_it))
    warnings += loop_warnings(axes)
    new = replace(machine, axes={**machine.axes, **{name: axis.axis for name, axis in axes.items()}})
    return Tuned(new, axes, tuple(tests), tuple(predicted), tuple(dict.fromkeys(warnings)))


def trace_flaws(tests: Sequence[MeasuredCircle]) -> list[Notice]:
    """Return the warnings about the traces; the compensation of a scheme that is named is not foreign."""
    found = clock_flaws([log for test in tests for log in test.logs()], "inspect")
    bare = any(test.scheme in ("", "a") for test in tests)
    return [notice for notice in found if bare or notice.code != FOREIGN_COMPENSATION.code]
