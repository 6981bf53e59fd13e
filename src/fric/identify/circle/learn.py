"""A repeated contour learned in simulation, round after round."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import pi

import numpy as np

from fric.arrays import Real
from fric.contour import circularity
from fric.control.feedforward import friction_feedforward, inverse_model
from fric.control.scheme import OBSERVER, Scheme
from fric.errors import FricError
from fric.identify.circle.measured_inverse import Learning, next_feedforward
from fric.identify.circle.model_shape import LEARNED, wrong_shape
from fric.notice import Notice
from fric.reference import Reference
from fric.reference import circle as circle_reference
from fric.simulate.axis import Trace, run_axis
from fric.simulate.circle import Circle, CircleRun
from fric.simulate.contour_run import pair, require_voltage
from fric.simulate.machine import Axis, Machine

ACCURACY = 1e-9
"""To what the simulated plant is integrated [m]."""
OTHERS = ((1.0, 0.5), (2 / 3, 1.0))
"""Circles to which what was learned is carried over, where it does not serve: shares of radius and feed."""
VOLT = 1e-6
"""Step of the learned voltage [V], below that of any converter: filters' last bits do not enter the next circle."""
GAINS = 0.9
"""Share of the first glitch from which on learning has gained nothing."""


@dataclass(frozen=True)
class Round:
    """One round: what was fed forward, and what it left.

    Parameters
    ----------
    run
        The circle.
    feedforward
        Voltage against friction by axis [V], shape (n,).
    """

    run: CircleRun
    feedforward: Mapping[str, Real]


@dataclass(frozen=True)
class Learned:
    """A contour that was learned in simulation.

    Parameters
    ----------
    machine
        The machine.
    how
        How it was learned.
    rounds
        The rounds, the first of which feeds forward what the controllers believe.
    carried
        What the last feedforward leaves of other circles, by angle: radius, feed [m], [m/s], and glitch [m].
    warnings
        What the user should know.
    """

    machine: Machine
    how: Learning
    rounds: tuple[Round, ...]
    carried: tuple[tuple[float, float, float], ...]
    warnings: tuple[Notice, ...]

    @property
    def glitches(self) -> list[float]:
        """Glitch of each round [m]."""
        return [one.run.circularity.glitch for one in self.rounds]


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
    names = pair(machine)
    axes = {name: machine.axes[name] for name in names}
    watched = observer and all(axis.observer is not None for axis in axes.values())
    scheme = Scheme("learned", "learned", blocks=(OBSERVER,) if watched else ())
    references = _references(test, axes)
    for name, axis in axes.items():
        require_voltage(axis, references[name])
    feedforward = {name: _nominal_friction(axes[name], reference) for name, reference in references.items()}
    modelled = all("gms" in axis.nominal_friction.models for axis in axes.values())
    found: list[Round] = []
    for n in range(rounds + 1):
        run = _run(axes, references, scheme, test, feedforward)
        run = replace(run, scheme=_named(scheme, n, modelled))
        found.append(Round(run, dict(feedforward)))
        done()
        if n < rounds:
            feedforward = {
                name: _learned(axis, references[name], run.traces[name], feedforward[name], how)
                for name, axis in axes.items()
            }
    carried = []
    for of_radius, of_feed in OTHERS:
        other = replace(test, radius=test.radius * of_radius, feed=test.feed * of_feed)
        carried.append((other.radius, other.feed, _carried(axes, found[-1], references, other, scheme)))
        done()
    best, worst = found[-1].run.circularity.glitch, max(glitch for *_, glitch in carried)
    warnings = [_for_one_circle(best, carried)]
    if worst <= 1.2 * best:
        warnings = []
    warnings += wrong_shape((one.run.scheme, one.run.circularity.glitch) for one in found)
    glitches = [one.run.circularity.glitch for one in found]
    if glitches[-1] > 1.5 * min(glitches):
        text = (
            f"the glitch has risen again, from {min(glitches) * 1e6:.2f} to {glitches[-1] * 1e6:.2f} µm: what does not "
            "repeat is learned too. Stop earlier, or lower the share or the bandwidth"
        )
        warnings.append(Notice(text, "learning-diverges", "doubt"))
    elif glitches[-1] > GAINS * glitches[0]:
        text = (
            f"learning leaves {glitches[-1] * 1e6:.2f} µm of {glitches[0] * 1e6:.2f}: what is left is noise and "
            "counts, or grows by itself where the loop does not hold friction that falls with speed (fric tune tells "
            "that, and --loop designs gains that hold it)"
        )
        warnings.append(Notice(text, "learning-gains-nothing", "doubt"))
    return Learned(machine, how, tuple(found), tuple(carried), tuple(warnings))


def circles_to_learn(rounds: int) -> int:
    """Return how many circles `learn` runs; for a progress bar."""
    return rounds + 1 + len(OTHERS)


def _for_one_circle(best: float, carried: list[tuple[float, float, float]]) -> Notice:
    others = ", ".join(
        f"{glitch * 1e6:.2f} µm at {feed * 1e3:.4g} mm/s on {radius * 1e3:.4g} mm" for radius, feed, glitch in carried
    )
    return Notice(
        f"what was learned is for this circle alone: it leaves {best * 1e6:.2f} µm there, and carried over {others}",
        "learned-for-one-circle",
        "note",
    )


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
