"""The nominal parameters of a controller, refitted to recorded circles: friction, plant, delay."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from fric.circles import tune_fit
from fric.circles.measured import MeasuredCircle
from fric.circles.next_circle import (
    CircleForecast,
    better_ahead,
    law_warnings,
    next_circles,
    recorded_once_more,
    worse_ahead,
)
from fric.circles.tune_fit import Balance, FittedBalance, TunedAxis, fit
from fric.design.cascade import falling_margin, hold_falling
from fric.drive.plant import Plant, hold_delay
from fric.errors import FricError
from fric.estimate import Estimate, as_filed
from fric.flaws import circle
from fric.flaws.channel import FOREIGN_COMPENSATION
from fric.flaws.circle import CIRCLE_DRIFTS, CIRCLE_MISFIT, TUNED_IN_PART, TUNING_NO_BETTER, TUNING_REFUSED
from fric.friction import FrictionModel
from fric.friction.directed import Directed, directed
from fric.notice import Notice
from fric.records.flaws import clock_flaws, timing
from fric.simulate.machine import Axis, Machine, NominalFriction
from fric.units import si_unit

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
    cascade, observer = hold_falling(
        axis.nominal, axis.axis.cascade, tune_fit.gms_of(axis.friction), axis.axis.observer
    )
    return replace(axis, axis=replace(axis.axis, cascade=cascade, observer=observer), loop=True)


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
            yield circle.LOOP_DESIGNED.found(f"axis {name}", margin=margin, observer=observer, fed=share, **gains)
        elif margin < UNHELD:
            yield circle.FALLING_FRICTION.found(f"axis {name}", margin=margin, fed=fed, design=margin < GROWS)


GAIN = 0.97  # Largest share of four parameters' residual that the full shape may leave, to be chosen
DISPLACED = 0.5e-6  # Largest error of the position by a jittering clock [m]: more exceeds the error to compensate
AGAIN, RESTS = 3, 0.01
"""Largest number of refinements of motion and fit, and the change of the logarithms at which they end."""
FEWER = (
    ("level", "stiffness", "alpha", "k"), ("level", "C", "ratio", "v_s", "delta"), ("level",),
)  # fmt: skip
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
        raise FricError(
            f"the controller of axis {axis.name} believes no GMS model, which tuning starts from",
            hint="Identify one: fric identify gms, and name it under feedforward in the machine file.",
        )
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
            compared = tune_fit.at(replace(found.balance, records=other.balance.records), found.x)
            if other.rms < GAIN * compared.rms:
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
    estimates = tune_fit.tuned_estimates(found, plant, axis.motion)
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
        once_more = cache(lambda n: recorded_once_more(tests[n], n, before, found))
        count = max(axis.encoder.resolution for axis in before.values())
        why = worse_ahead(tests, predicted, once_more, count, doubtful=doubtful)
        if why and not doubtful:
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
        if not tuned.improves and not why:
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
