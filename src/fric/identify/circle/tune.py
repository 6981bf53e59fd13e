"""What a controller believes, refitted to recorded circles: friction, plant, delay."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fric.drive.plant import Plant, hold_delay
from fric.errors import FricError
from fric.friction import FrictionModel
from fric.friction.directed import Directed, directed
from fric.friction.gms import GMS
from fric.identify.circle.measured import MeasuredCircle
from fric.identify.circle.next_circle import NextCircle, law_warnings, next_circles, worse_ahead
from fric.identify.circle.nominal import Coordinates
from fric.identify.circle.tune_bootstrap import explained
from fric.identify.circle.tune_fit import STARTS, Balance, Fitted, at, fit
from fric.identify.circle.tune_identifiability import alike_warnings, identifiability_warnings, timing_warnings
from fric.identify.circle.tune_instruments import instrumented
from fric.identify.circle.tune_intervals import tuned_estimates
from fric.identify.circle.tune_loop import cautious, holding, holds, loop_warnings
from fric.identify.circle.tuned import TunedAxis
from fric.identify.circle.voltage import refined, voltage_record
from fric.identify.records.flaws import clock_flaws
from fric.identify.records.timing import timing
from fric.notice import Notice
from fric.simulate.machine import Axis, Machine, NominalFriction

SHAPE = 1.6
"""Times what noise and encoder explain that four parameters may leave; above it the full shape is fitted. Where the
shape is right they leave 1.1 to 1.4 times as much, where it is not 4 to 16. Below it is a tie: four are simpler."""
GAIN = 0.97
"""Share of what four parameters leave that the full shape must leave at most, to be taken."""

DISPLACED = 0.5e-6
"""By how much a clock that jitters may move the position [m]: more is more than what is to be compensated."""
AGAIN, RESTS = 3, 0.01
"""How often the motion is refined and the fit repeated at most, and the move in the logarithm below which it rests."""

MISFIT = "what is left is not friction of this shape"
GROWING = "errors grow by themselves in falling friction, which the loop does not hold (--loop designs one that does)"


def tune_axis(axis: Axis, tests: Sequence[MeasuredCircle], done: Callable[[], object] = lambda: None) -> TunedAxis:
    """Refit what the controller of an axis believes to recorded circles.

    Per axis ``W[u(t - T_d)] = m·W[z̈] + a·W[ż] + o + W[F(z)]/K_f`` with W a low-pass of 70 Hz, zero phase; m, a and
    an offset of each circle are linear. First the level of friction, its stiffness, C and T_d are searched; then, where
    that leaves more than noise and encoder explain, F_s/F_c, v_s, delta, each alpha and each k, and a level for each
    direction, each kept where it explains more. Whatever was kept, the intervals are those of the whole shape.

    Parameters
    ----------
    axis
        The axis; its controller believes a GMS model.
    tests
        Circle tests with reference, position and voltage.
    done
        Called after each of `stages`.

    Raises
    ------
    FricError
        When there is no nominal GMS model, or a test lacks a channel.
    """
    if "gms" not in axis.nominal_friction.models:
        raise FricError(
            f"the controller of axis {axis.name} believes no GMS model, which tuning starts from",
            hint="Identify one: fric identify gms, and name it under feedforward in the machine file.",
        )
    nominal = axis.nominal or axis.plant
    records = tuple(voltage_record(test, axis.name) for test in tests)
    few = Coordinates.of(axis.nominal_friction.models["gms"], nominal.T_d)
    gain = float(np.log(axis.nominal_friction.gain)) if axis.nominal_friction.gain > 0 else 0.0
    start = np.array([gain, 0.0, 0.0, 0.0])
    before = at(Balance(records, few, nominal.K_f), start, np.array([1 / nominal.B, nominal.A / nominal.B]))
    starts = [start + np.array([0.0, np.log(stiffness), np.log(C), 0.0]) for stiffness, C in STARTS]
    found = fit(Balance(records, few, nominal.K_f), starts)
    done()
    found = _again(found, nominal.K_f)
    done()
    full = False
    if found.plant[0] > 0 and found.rms > SHAPE * explained(found):
        for shape in (few.full(), None):
            richer = shape or found.balance.coordinates.sided()
            start = richer.moved(found.balance.coordinates, found.x)
            other = fit(replace(found.balance, coordinates=richer), [start], found.rms)
            other = _again(other, nominal.K_f)
            compared = at(replace(found.balance, records=other.balance.records), found.x)
            if other.rms < GAIN * compared.rms:
                found, full = other, full or shape is not None
    for _ in range(AGAIN if found.plant[0] > 0 else 0):
        found = instrumented(found)
    done()
    coordinates = found.balance.coordinates
    friction, T_d = coordinates.directed(found.x), coordinates.delay(found.x)
    m, a = found.plant[:2]
    warnings = list(identifiability_warnings(axis, tests, before, found))
    physical = bool(m > 0 and T_d >= hold_delay(axis.cascade.sampling))
    if not physical:
        return TunedAxis(axis, friction, nominal, before, found, None, full, False, tuple(warnings))
    plant = Plant(A=max(float(a / m), 0.0), B=float(1 / m), T_d=T_d, K_f=nominal.K_f)
    estimates = tuned_estimates(found, plant)
    warnings += [*alike_warnings(axis, found, estimates), *timing_warnings(axis, found, estimates.plant["T_d"])]
    improves = found.rms < before.rms
    new = with_belief(axis, friction, plant) if improves else axis
    return TunedAxis(new, friction, plant, before, found, estimates, full, improves, tuple(warnings))


def with_belief(axis: Axis, friction: FrictionModel, plant: Plant) -> Axis:
    """Return an axis whose controller believes a friction and a plant: feedforward with lead, and observer."""
    model = friction.model if isinstance(friction, Directed) else friction
    assert isinstance(model, GMS)
    static = directed(model.static, friction.negative if isinstance(friction, Directed) else None)
    models = {**axis.nominal_friction.models, "static": static, "gms": friction}
    observer = None if axis.observer is None else replace(axis.observer, A=plant.A, B=plant.B)
    return replace(axis, nominal_friction=NominalFriction(models, 1.0, "auto"), nominal=plant, observer=observer)


def _again(found: Fitted, K_f: float) -> Fitted:
    """Return the fit along the motion that the fit itself tells more finely.

    Each time the delay's error falls to a fifth: it is repeated until it rests.
    """
    for _ in range(AGAIN):
        if not found.plant[0] > 0:
            break
        again = fit(_finer(found, K_f), [found.x], found.rms, 5)
        moved, found = np.abs(again.x - found.x).max(), again
        if moved < RESTS:
            break
    return found


def _finer(found: Fitted, K_f: float) -> Balance:
    """Return the balance along the motion that a fit tells more finely."""
    coordinates, (m, a) = found.balance.coordinates, (float(value) for value in found.plant[:2])
    model, T_d = coordinates.directed(found.x), coordinates.delay(found.x)
    records = tuple(
        refined(record, model, T_d, (m, a, float(found.plant[2 + n])), K_f)
        for n, record in enumerate(found.balance.records)
    )
    return replace(found.balance, records=records)


@dataclass(frozen=True)
class Tuned:
    """What circles say of a machine.

    Parameters
    ----------
    machine
        The machine with its new nominal parameters.
    axes
        What was found, by axis.
    tests
        The circles.
    predicted
        What the next circles should show; empty where the result is refused.
    warnings
        What the circles cannot tell, and what was refused.
    """

    machine: Machine
    axes: Mapping[str, TunedAxis]
    tests: tuple[MeasuredCircle, ...]
    predicted: tuple[NextCircle, ...]
    warnings: tuple[Notice, ...]

    @property
    def improves(self) -> bool:
        """Whether any axis is better than it was."""
        return any(one.improves for one in self.axes.values())


def tune(
    machine: Machine,
    tests: Sequence[MeasuredCircle],
    done: Callable[[], object] = lambda: None,
    *,
    loop: bool = False,
) -> Tuned:
    """Refit what the controllers of a machine believe to recorded circles, axis by axis.

    An axis whose result leaves more of the recorded voltages than the nominal parameters keeps these. So do all, where
    the log's clock is wrong, or the next circle should be worse than the recorded one.

    Parameters
    ----------
    machine
        The machine.
    tests
        Circle tests with reference, position and voltage of both axes; one fast and one slow are asked for.
    done
        Called as often as `steps_of_tuning` says.
    loop
        Whether loops that do not hold their falling friction are designed anew (`fric.design.falling`).

    Raises
    ------
    FricError
        When a test lacks a channel, or an axis that the machine has, or there is no nominal GMS model.
    """
    if not tests:
        raise FricError("there is no circle to tune with", hint="Record one at 100 and one at 10 mm/s.")
    names = tests[0].names
    for test in tests:
        if test.names != names or test.is_ball_bar:
            words = "a ball bar's" if test.is_ball_bar else f"of {' and '.join(test.names)}"
            raise FricError(
                f"is {words}, and tuning needs traces of {' and '.join(names)} in every test", where=test.where,
                hint="Give controller traces of the same axes.",
            )  # fmt: skip
    axes = {name: tune_axis(machine.axis(name), tests, done) for name in names}
    axes = {name: cautious(holding(one) if loop else one) for name, one in axes.items()}
    logs = [log for test in tests for log in test.logs()]
    warnings = [warning for one in axes.values() for warning in one.warnings] + clock_flaws(logs, "inspect")
    better = all(one.improves for one in axes.values())
    predicted = next_circles(tests, axes, done) if better else []
    # where friction of this shape, or one that stays, does not explain the circle, only the upper end of a prediction
    # counts; where errors grow by themselves in the loop, the largest of what was drawn
    doubtful = any(warning.code in {"circle-misfit", "friction-drifts"} for warning in warnings)
    grows = better and not all(holds(one) for one in axes.values())
    if any(clock.lost or clock.displaced > DISPLACED for clock in map(timing, logs)):
        why = "the log's clock is wrong (see above)"
    elif better and not predicted:
        why = "with what was found no stable circle can be simulated"
    else:
        why = worse_ahead(tests, predicted, lambda one: one.ci95[1] if doubtful else one.drawn if grows else one.glitch)
        if why:
            why += f": {GROWING if grows else MISFIT}"
    if why:
        text = f"{why}: the result is refused, and the nominal parameters are kept"
        warnings.append(Notice(text, "tuning-refused", "wrong"))
        axes = {name: replace(one, axis=machine.axes[name], improves=False, loop=False) for name, one in axes.items()}
        predicted = []  # what is kept shows what was recorded
    warnings += law_warnings(predicted)
    for name, one in axes.items():
        if not one.improves and not why:
            text = (
                f"axis {name}: what was found leaves {one.after.rms * 1e3:.2f} mV of the recorded voltages, and the "
                f"nominal parameters {one.before.rms * 1e3:.2f} mV: it is refused, and these are kept"
            )
            warnings.append(Notice(text, "tuning-refused", "wrong"))
    warnings += loop_warnings(axes)
    new = replace(machine, axes={**machine.axes, **{name: one.axis for name, one in axes.items()}})
    return Tuned(new, axes, tuple(tests), tuple(predicted), tuple(dict.fromkeys(warnings)))


def steps_of_tuning(tests: Sequence[MeasuredCircle]) -> int:
    """Return how often `tune` tells that it is a step further; for a progress bar."""
    return 3 * 2 + 2 * len(tests)  # of each axis three stages, and two schemes on each circle ahead
