"""A repeated contour learned in simulation, round after round.

What does not repeat hangs on where position 0 lies between two counts of an encoder. So a contour is learned at several
places, each from its own rounds, and their medians are printed and judged.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import pi

import numpy as np

from fric.arrays import Real
from fric.circles.measured_inverse import Learning, next_feedforward
from fric.circles.model_shape import LEARNED, wrong_shape
from fric.contour import circularity
from fric.control.feedforward import friction_feedforward, inverse_model
from fric.control.scheme import OBSERVER, Scheme
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.circle import LEARNED_FOR_ONE_CIRCLE, LEARNING_DIVERGES, LEARNING_GAINS_NOTHING
from fric.notice import Notice
from fric.reference import Reference
from fric.reference import circle as circle_reference
from fric.simulate.axis import Trace, run_axis
from fric.simulate.chance import ACCURACY, PLACES
from fric.simulate.circle import Circle, CircleRun
from fric.simulate.contour_run import figures, pair, require_voltage
from fric.simulate.machine import Axis, Machine

OTHERS = ((1.0, 0.5), (2 / 3, 1.0))
"""Circles to which what was learned is carried over, where it does not serve: shares of radius and feed."""
VOLT = 1e-6
"""Step of the learned voltage [V], below that of any converter: filters' last bits do not enter the next circle."""
GAINS = 0.9
"""Share of the first glitch from which on learning has gained nothing."""


@dataclass(frozen=True)
class Round:
    """One round: what was fed forward, and what it left."""

    run: CircleRun  # The circle
    feedforward: Mapping[str, Real]  # Voltage against friction by axis [V], shape (n,)


@dataclass(frozen=True)
class Learned:
    """A contour that was learned in simulation."""

    machine: Machine  # The machine
    how: Learning  # How it was learned
    # The rounds at the place of the median last one, the first of which feeds forward what the controllers believe;
    # each run knows what it leaves at all places
    rounds: tuple[Round, ...]
    # What the last feedforward leaves of other circles, by angle: radius, feed [m], [m/s], and median glitch [m]
    carried: tuple[tuple[float, float, float], ...]
    warnings: tuple[Notice, ...]  # What the user should know

    @property
    def circle(self) -> Circle:
        """The circle that was learned."""
        return self.rounds[0].run.circle

    @property
    def glitches(self) -> list[float]:
        """Glitch of each round, the median over places [m]."""
        return [one.run.chance().median for one in self.rounds]


def learn(
    machine: Machine,
    test: Circle,
    rounds: int,
    how: Learning | None = None,
    *,
    observer: bool = True,
    done: Callable[[], object] = lambda: None,
) -> Learned:
    """Learn a circle in simulation, from the friction that the controllers believe, or from nothing where it is none.

    Parameters
    ----------
    machine
        The machine; its nominal plants are what is learned with.
    test
        The circle.
    rounds
        How often the circle is learned from.
    how
        How; by the feed where not given.
    observer
        Whether the disturbance observer is on, where all axes have one.
    done
        Called after each circle; there are `circles_to_learn`.

    Raises
    ------
    FricError
        When there are no rounds, or the machine cannot run the circle.
    """
    if rounds < 1:
        raise FricError(f"{rounds} rounds are none to learn from", hint="Give 1 or more.")
    how = how or Learning.at(test.feed)
    names = pair(machine, both=True)
    axes = {name: machine.axes[name] for name in names}
    watched = observer and all(axis.observer is not None for axis in axes.values())
    scheme = Scheme("learned", "learned", blocks=(OBSERVER,) if watched else ())
    references = _references(test, axes)
    for name, axis in axes.items():
        require_voltage(axis, references[name])
    modelled = all("gms" in axis.nominal_friction.models for axis in axes.values())
    counts = any(axis.encoder.resolution > 0 for axis in axes.values())
    places = [machine.placed(n / PLACES).axes for n in range(PLACES if counts else 1)]
    fed = {name: _nominal_friction(axis, references[name]) for name, axis in axes.items()}
    feedforwards = [fed] * len(places)
    learned: list[list[Round]] = [[] for _ in places]
    for n in range(rounds + 1):
        for own, placed, fed in zip(learned, places, feedforwards, strict=True):
            run = _run({name: placed[name] for name in names}, references, scheme, test, fed)
            own.append(Round(replace(run, scheme=_named(scheme, n, modelled)), dict(fed)))
        done()
        if n < rounds:
            feedforwards = [
                {
                    name: _learned(axis, references[name], own[-1].run.traces[name], own[-1].feedforward[name], how)
                    for name, axis in axes.items()
                }
                for own in learned
            ]
    carried = []
    for of_radius, of_feed in OTHERS:
        other = replace(test, radius=test.radius * of_radius, feed=test.feed * of_feed)
        glitches = [
            _carried({name: placed[name] for name in names}, own[-1], references, other, scheme)
            for own, placed in zip(learned, places, strict=True)
        ]
        carried.append((other.radius, other.feed, float(np.median(glitches))))
        done()
    found = _middle(learned)
    chances = [one.run.chance() for one in found]
    best, worst = chances[-1].median, max(glitch for *_, glitch in carried)
    warnings = [] if worst <= 1.2 * best else [_for_one_circle(best, carried)]
    warnings += wrong_shape((one.run.scheme, chance.median) for one, chance in zip(found, chances, strict=True))
    least = min(chances, key=lambda one: one.median)
    if best > 1.5 * least.median and all(rise > 0 for rise in (chances[-1] - least).values):
        warnings.append(LEARNING_DIVERGES.found(least=least.text(digits=2), last=chances[-1].text(digits=2)))
    elif best > GAINS * chances[0].median:
        first, last = (chances[n].text(digits=2) for n in (0, -1))
        warnings.append(LEARNING_GAINS_NOTHING.found(last=last, first=first))
    return Learned(machine, how, tuple(found), tuple(carried), tuple(warnings))


def circles_to_learn(rounds: int) -> int:
    """Return how many circles `learn` runs; for a progress bar."""
    return rounds + 1 + len(OTHERS)


def _middle(learned: Sequence[Sequence[Round]]) -> list[Round]:
    """Return the rounds at the place of the median last one, whose runs know what each leaves at all places."""
    if len(learned) == 1:
        return list(learned[0])
    order = np.argsort([own[-1].run.circularity.glitch for own in learned], kind="stable")
    return [
        replace(one, run=replace(one.run, places=tuple(figures(own[n].run.contour) for own in learned)))
        for n, one in enumerate(learned[order[len(order) // 2]])
    ]


def _for_one_circle(best: float, carried: list[tuple[float, float, float]]) -> Notice:
    others = ", ".join(
        f"{glitch * 1e6:.2f} µm at {feed * 1e3:.4g} mm/s on {radius * 1e3:.4g} mm" for radius, feed, glitch in carried
    )
    return LEARNED_FOR_ONE_CIRCLE.found(best=Estimate(best, "m"), others=others)


def _references(test: Circle, axes: Mapping[str, Axis]) -> dict[str, Reference]:
    sampling = next(iter(axes.values())).cascade.sampling
    both = circle_reference(test.radius, test.feed, test.revolutions, sampling, direction=test.direction)
    return dict(zip(axes, both, strict=True))


def _run(
    axes: Mapping[str, Axis],
    references: Mapping[str, Reference],
    scheme: Scheme,
    test: Circle,
    feedforward: Mapping[str, Real],
) -> CircleRun:
    traces = {
        name: run_axis(axis, references[name], scheme, against=feedforward[name], accuracy=ACCURACY)
        for name, axis in axes.items()
    }
    x, y = (trace.position for trace in traces.values())
    return CircleRun(scheme, test, traces, circularity(x, y, test.radius))


def _named(scheme: Scheme, n: int, modelled: bool) -> Scheme:
    """Return a scheme as it is recorded for a round: what it feeds forward, and what it was learned from."""
    if n == 0:
        return replace(scheme, name="round-00", title="before", friction="gms" if modelled else None)
    return replace(scheme, name=f"round-{n:02d}", title=f"learned from {n} circle{'s' * (n > 1)}", friction=LEARNED)


def _nominal_friction(axis: Axis, reference: Reference) -> Real:
    """Return the voltage against friction that a controller feeds forward before anything is learned [V], (n,)."""
    model = axis.nominal_friction.models.get("gms")
    if model is None:
        return np.zeros(len(reference))
    plant = axis.nominal or axis.plant
    return friction_feedforward(model, reference.ahead(axis.lead()), plant.K_f, axis.nominal_friction.gain)


def _learned(axis: Axis, reference: Reference, trace: Trace, before: Real, how: Learning) -> Real:
    plant = axis.nominal or axis.plant
    model = inverse_model(plant, reference.ahead(axis.lead()))
    error = trace.reference - trace.measured
    learned = next_feedforward(trace.time, error, trace.input, model, before, plant, how)
    return np.rint(learned / VOLT) * VOLT


def _carried(
    axes: Mapping[str, Axis], last: Round, references: Mapping[str, Reference], other: Circle, scheme: Scheme
) -> float:
    """Return the glitch of another circle with what was learned, taken over by the angle [m]."""
    new = _references(other, axes)
    old_angle, new_angle = (
        np.unwrap(np.arctan2(y.position, x.position)) for x, y in (references.values(), new.values())
    )
    latest = np.abs(old_angle[-1] - old_angle) <= 2 * pi
    carried = {}
    for name, voltage in last.feedforward.items():
        order = np.argsort(old_angle[latest] % (2 * pi))
        known, values = (old_angle[latest] % (2 * pi))[order], voltage[latest][order]
        carried[name] = np.interp(new_angle % (2 * pi), known, values, period=2 * pi)
    try:
        return _run(axes, new, scheme, other, carried).circularity.glitch
    except FricError:
        return float("nan")
