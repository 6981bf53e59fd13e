"""Whether a prediction of a circle may be trusted: warnings of the files, and what a measured circle says."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from fric.arrays import Real
from fric.circles.measured import MeasuredCircle
from fric.circles.next_circle import measured_quadrants
from fric.circles.stated import StatedController, against_stated
from fric.circles.voltage import VoltageRecord, refined
from fric.contour import QUADRANTS, of_axes
from fric.control.scheme import OBSERVER, PAPER_SCHEMES, Scheme
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws import circle as flaws
from fric.flaws import flaw_of
from fric.flaws.prediction import CIRCLE_ELSEWHERE, NO_MEASURED_CIRCLE
from fric.friction.completed import Completed
from fric.notice import Notice, once
from fric.simulate.circle import Circle, run_circle
from fric.simulate.machine import Axis, Machine
from fric.simulate.spread import Spread, draw_machine

APART, SHARE_APART = 5e-7, 0.03
"""By how much a completed machine may miss a glitch that was measured [m], and as a share of it."""
FARTHEST, TELLING, LATER = 4e-4, 2.0, 0.1
"""How far from the plant's another delay is looked for [s], how much better it must explain a circle's voltages, and by
what share of the delay it must differ."""
SOFTER, STIFFER = Spread(0.5, 0.5), Spread(2.0, 2.0)
"""Friction whose stiffness is not that of the logs, which shifts a reversal as a delay does."""
OTHER_FEED = 2.0
"""Ratio of feeds, and of radii, beyond which a measured circle tells little of another."""


def distrusts(
    machine: Machine,
    notices: Iterable[Notice],
    tests: Sequence[MeasuredCircle],
    records: Sequence[VoltageRecord],
    circle: Circle,
) -> tuple[Notice, ...]:
    """Return why no interval of a prediction must be trusted; nothing where all may be.

    machine: The machine at the estimates, completed by the tests where there are any.
    notices: What its files warn of.
    tests: Measured circles.
    records: Their axes as balances of voltages.
    circle: The circle that is predicted.
    """
    return once([*_of_files(notices, bool(tests)), *_of_circles(machine, tests, records, circle)])


def _of_files(notices: Iterable[Notice], measured: bool) -> Iterator[Notice]:
    if not measured:
        yield NO_MEASURED_CIRCLE.found()
    for notice in notices:
        if notice.severity == "wrong" and not (measured and flaw_of(notice).circle_settles):
            yield notice


def _of_circles(
    machine: Machine, tests: Sequence[MeasuredCircle], records: Sequence[VoltageRecord], circle: Circle
) -> Iterator[Notice]:
    for test in tests:
        for name in test.names:
            second = machine.axes[name].second_mass if name in machine.axes else None
            if second is not None and second.encoder == "motor" and test.instrument in ("encoders", ""):
                yield flaws.TABLE_UNSEEN.found(f"axis {name}")
        yield from _disagreement(machine, test)
    for record in records:
        yield from _delay(machine.axes[record.axis], record)
        yield from _controller(machine.axes[record.axis], record)
    if tests:
        feeds = [max(circle.feed / test.feed, test.feed / circle.feed) for test in tests]
        radii = [max(circle.radius / test.radius, test.radius / circle.radius) for test in tests]
        if min(feeds) > OTHER_FEED or min(radii) > OTHER_FEED:
            yield CIRCLE_ELSEWHERE.found()


def _disagreement(machine: Machine, test: MeasuredCircle) -> Iterator[Notice]:
    """Yield what is wrong where even the machine that was completed by a circle does not show its glitches."""
    scheme = PAPER_SCHEMES.get(test.scheme or "a")
    if scheme is None:
        return
    try:
        run = run_circle(machine, scheme, Circle(test.radius, test.feed, 2, test.direction))
    except FricError as error:
        yield flaws.CIRCLE_CANNOT_RUN.found(test.where, why=error.what)
        return
    judged = of_axes(test.names, machine.axes)
    seen, expected = measured_quadrants(test), [one.median for one in run.glitches]
    off = {
        name: (one, other)
        for name, one, other in zip(QUADRANTS, seen, expected, strict=True)
        if name in judged and not np.isclose(one, other, rtol=SHARE_APART, atol=APART)
    }
    if off:
        microns = {name: (f"{a * 1e6:+.1f}", f"{b * 1e6:+.1f}") for name, (a, b) in off.items()}
        glitches = "; ".join(f"{name} {a} µm measured, {b} µm simulated" for name, (a, b) in microns.items())
        yield flaws.COMPLETED_DISAGREES.found(test.where, glitches=glitches)


def _delay(axis: Axis, record: VoltageRecord) -> Iterator[Notice]:
    """Yield what is wrong where another delay than that of the logs explains a circle's voltages far better.

    For each delay the voltage is balanced by inertia, damping, a constant and friction (as it is, softer, stiffer),
    each times what fits: friction that has changed is no delay.
    """
    plant = axis.plant
    model = axis.friction.model if isinstance(axis.friction, Completed) else axis.friction
    own = refined(record, model, plant.T_d, (1 / plant.B, plant.A / plant.B, axis.constant_load / plant.K_f), plant.K_f)
    used = own.used
    alone = Machine("", {axis.name: replace(axis, friction=model)})
    others = [draw_machine(alone, 0, spreads={"stiffness": one})[0].axes[axis.name] for one in (SOFTER, STIFFER)]
    frictions = [own.friction(one) for one in (model, *(other.friction for other in others))]
    parts = [own.inertia[used], own.damping[used], np.ones(np.count_nonzero(used)), *frictions]
    basis = np.linalg.qr(np.column_stack(parts))[0]

    def left(delay: float) -> float:
        voltage = own.delayed(delay)
        return float(np.sqrt(np.mean((voltage - basis @ (basis.T @ voltage)) ** 2)))

    tried = plant.T_d + np.linspace(-FARTHEST, FARTHEST, 41)
    best = min(tried[tried >= 0], key=left)
    if left(plant.T_d) > TELLING * left(best) and abs(best - plant.T_d) > LATER * plant.T_d:
        yield flaws.DELAY_DIFFERS.found(
            f"axis {axis.name}", plant=Estimate(plant.T_d, "s"), circle=Estimate(float(best), "s")
        )


def _controller(axis: Axis, record: VoltageRecord) -> Iterator[Notice]:
    """Yield what is wrong where the recorded voltage is not what the stated controller gives, without compensation.

    Its inverse model may be of another plant than the one that was identified since: that is no wrong gain.
    """
    if record.test.scheme not in ("", "a"):
        return
    t, reference, measured, voltage = record.raw
    from_file = axis.nominal or axis.plant

    def against(volts: Real) -> StatedController:
        return against_stated(axis.cascade, from_file, reference, measured, volts, 1 / record.sampled, ahead=True)

    held = against(voltage)
    if held.as_stated:
        return
    velocity = np.gradient(reference, t)
    fed = np.column_stack([velocity, np.gradient(velocity, t), np.ones(len(t))])
    share, *_ = np.linalg.lstsq(fed, held.recorded - held.given, rcond=None)
    if not against(voltage - fed @ share).as_stated:
        yield flaws.CONTROLLER_DIFFERS.found(f"axis {axis.name}", how=held.describe(), friction=False)


def observers_distrust(schemes: Sequence[Scheme], notices: Iterable[Notice]) -> Mapping[str, tuple[Notice, ...]]:
    """Return by scheme with an observer why it must not be trusted: the response was not measured."""
    why = tuple(notice for notice in notices if flaw_of(notice).no_response)
    return {scheme.name: why for scheme in schemes if OBSERVER in scheme.blocks and why}
