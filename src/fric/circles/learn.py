"""A repeated contour learned round by round: from recorded rounds, and in simulation.

Results depend on the place of position 0 between two encoder counts. So a contour is learned at several places, each
with separate rounds, and their medians are reported and judged.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import pi

import numpy as np

from fric.arrays import Real
from fric.circles.measured import MeasuredCircle, low_pass
from fric.circles.tune import LEARNED, wrong_shape
from fric.contour import Figures, circularity
from fric.control.feedforward import friction_feedforward, inverse_model
from fric.control.scheme import OBSERVER, Scheme
from fric.drive.plant import LinearPlant
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws import circle as flaws
from fric.notice import Notice
from fric.reference import Reference, refuse_long
from fric.simulate.axis import run_axis
from fric.simulate.contour_run import ACCURACY, MOST_KEPT, PLACES, Circle, CircleRun, figures, pair, require_voltage
from fric.simulate.machine import Axis, Machine
from fric.units import readable, si_unit

FAST = 0.05  # Feed above which the whole correction is learned, up to 200 Hz; below it half of it, up to 100 Hz [m/s]


@dataclass(frozen=True)
class Learning:
    """How a round is learned."""

    share: float  # Share of the correction of a round that is applied, γ [1]
    bandwidth: float  # Corner of the low-pass, which leaves out what does not repeat [Hz]

    @classmethod
    def at(cls, feed: float, share: float | None = None, bandwidth: float | None = None) -> "Learning":
        """Return the settings of learning at a feed [m/s], with defaults for those not given."""
        default = cls(1.0, 200.0) if feed >= FAST else cls(0.5, 100.0)
        made = cls(default.share if share is None else share, default.bandwidth if bandwidth is None else bandwidth)
        if not (0 < made.share <= 1 and made.bandwidth > 0):
            hint = "The share lies above 0 and up to 1, the bandwidth above 0."
            raise FricError(f"a share of {made.share:g} at {made.bandwidth:g} Hz is nothing to learn with", hint=hint)
        return made


def next_feedforward(
    t: Real, error: Real, voltage: Real, model: Real, before: Real, plant: LinearPlant, how: Learning
) -> Real:
    """Return the voltage that the next round should feed forward against friction [V], shape (n,).

    ``w ← (1 - γ)·w + γ·(LP[u](t) + LP[(ë + A·ė)/B](t + T_d) - u_model(t))`` with e the tracking error: the voltage of
    this round, and its error. Neither a friction model nor a controller model is needed.

    t: Even sample instants [s].
    error, voltage: Reference less position as measured [m], and control voltage [V], of this round, each of shape (n,).
    model: Voltage of the inverse model that the controller feeds forward [V], shape (n,).
    before: Voltage that this round fed forward against friction [V], shape (n,).
    """
    from scipy.signal import sosfiltfilt

    dt = float(t[1] - t[0])
    if not 1.0 <= how.bandwidth * dt * len(t) < 0.5 * len(t):
        what = f"{how.bandwidth:g} Hz are not between one period of the record and half its sampling"
        raise FricError(what, hint="Learn up to a few hundred Hz.")
    sections = low_pass(how.bandwidth, 1 / dt)
    rate = np.gradient(sosfiltfilt(sections, error), t)
    missing = (np.gradient(rate, t) + plant.A * rate) / plant.B
    needed = sosfiltfilt(sections, voltage) + np.interp(t + plant.T_d, t, missing)
    return np.asarray((1 - how.share) * before + how.share * (needed - model))


@dataclass(frozen=True)
class LearnedFeedforward:
    """The feedforward of the next round of a measured circle."""

    circle: MeasuredCircle  # The circle that was learned, which it is for
    how: Learning  # How it was learned
    time: Mapping[str, Real]  # Instants [s], by axis, each of shape (n,)
    reference: Mapping[str, Real]  # Reference [m]
    voltage: Mapping[str, Real]  # Voltage against friction [V]
    warnings: tuple[Notice, ...]  # What the user should know


def learn_from(
    test: MeasuredCircle, machine: Machine, how: Learning, before: Mapping[str, Real] | None = None
) -> LearnedFeedforward:
    """Return the feedforward of the next round from a measured circle.

    machine: The machine, whose nominal plants are taken.
    before: By axis, the feedforward against friction in this round [V], shape (n,); none where not given.
    """
    time, wanted, voltage = {}, {}, {}
    for name in test.names:
        (t, r, z, u), axis = test.require(name, "learning"), machine.axis(name)
        plant = axis.nominal or axis.plant
        last = np.zeros(len(t)) if before is None else before.get(name, np.zeros(0))
        if len(last) != len(t):
            raise FricError(
                f"what axis {name} fed forward has {len(last)} samples, and the circle {len(t)}", where=test.where,
                hint="Give the file that this very circle was run with.",
            )  # fmt: skip
        ahead = np.interp(t + axis.lead(), t, r)
        model = (np.gradient(np.gradient(ahead, t), t) + plant.A * np.gradient(ahead, t)) / plant.B
        time[name], wanted[name] = t, r
        voltage[name] = next_feedforward(t, r - z, u, model, last, plant, how)
        if (most := float(np.abs(voltage[name]).max())) > axis.cascade.limit:
            fed, limit = (readable(value, si_unit("input", axis.motion)) for value in (most, axis.cascade.limit))
            what = f"axis {name} would feed {fed} forward, and its limit is {limit}"
            raise FricError(what, where=test.where, hint="Is the nominal plant that of this machine?")
    beside = (flaws.NOTHING_FED_BEFORE.found(share=how.share),) if how.share < 1 and before is None else ()
    return LearnedFeedforward(test, how, time, wanted, voltage, (flaws.LEARNED_FROM_ONE_CIRCLE.found(), *beside))


OTHERS = ((1.0, 0.5), (2 / 3, 1.0))  # Circles to try the learned voltage on: shares of radius and feed
VOLT = 1e-6  # Step of the learned voltage [V], below any converter's: rounding errors of filters do not propagate
Fed = Mapping[str, Real]  # Voltage against friction by axis [V], shape (n,)
GAINS = 0.9  # Share of the first glitch above which learning has no effect


@dataclass(frozen=True)
class Learned:
    """A contour that was learned in simulation."""

    machine: Machine
    how: Learning
    rounds: tuple[CircleRun, ...]  # Of the place with the median last glitch, with errors at all; first the models' own
    # Other circles with the last feedforward, by angle: radius, feed [m], [m/s], and median glitch [m]
    carried: tuple[tuple[float, float, float], ...]
    warnings: tuple[Notice, ...]  # What the user should know

    @property
    def circle(self) -> Circle:
        """The circle that was learned."""
        return self.rounds[0].circle

    @property
    def glitches(self) -> list[float]:
        """Glitch of each round, the median over places [m]."""
        return [run.chance().median for run in self.rounds]


def learn(
    machine: Machine, test: Circle, rounds: int, how: Learning | None = None, *, observer: bool = True,
    done: Callable[[], object] = lambda: None,
) -> Learned:  # fmt: skip
    """Learn a circle in simulation, from the friction that the controllers believe, or from none.

    machine: The machine; its nominal plants are what is learned with.
    rounds, how: How often the circle is learned from, and how; by the feed where not given.
    observer: Whether the disturbance observer is on, where all axes have one.
    Raises FricError: When the machine cannot run the circle.
    """
    how = how or Learning.at(test.feed)
    axes = {name: machine.axes[name] for name in pair(machine, both=True)}
    watched = observer and all(axis.observer is not None for axis in axes.values())
    scheme = Scheme("learned", "learned", blocks=(OBSERVER,) if watched else ())
    references = _references(test, axes)
    for name, axis in axes.items():
        require_voltage(axis, references[name])
    modelled = all("gms" in axis.nominal_friction.models for axis in axes.values())
    counts = any(axis.encoder.resolution > 0 for axis in axes.values())
    placed = [machine.placed(n / PLACES).axes for n in range(PLACES if counts else 1)]
    places = [{name: every[name] for name in axes} for every in placed]
    sampling, samples = next(iter(axes.values())).cascade.sampling, len(next(iter(references.values())))
    longest = max(of_radius / of_feed for of_radius, of_feed in OTHERS)
    refuse_long(samples / sampling, sampling, len(axes), 2 * (rounds + 2), longest)
    fed: list[list[Fed]] = [
        [{name: _nominal_friction(axis, references[name]) for name, axis in axes.items()}] for _ in places
    ]
    judged, runs = [list[Figures]() for _ in places], dict[tuple[int, int], CircleRun]()
    for n in range(rounds + 1):
        for p, here in enumerate(places):
            run = _run(here, scheme, test, fed[p][n])
            judged[p].append(figures(run.contour))
            if samples * len(axes) * rounds < MOST_KEPT:  # else those that are reported are made once more
                runs[p, n] = run
            if n < rounds:
                fed[p].append(_learned(axes, references, run, fed[p][n], how))
        done()
    carried = []
    for of_radius, of_feed in OTHERS:
        other = replace(test, radius=test.radius * of_radius, feed=test.feed * of_feed)
        glitches = [_carried(here, past[-1], references, other, scheme) for here, past in zip(places, fed, strict=True)]
        carried.append((other.radius, other.feed, float(np.median(glitches))))
        done()
    p, found = sorted(range(len(places)), key=lambda p: judged[p][-1].glitch)[len(places) // 2], list[CircleRun]()
    for n, errors in enumerate(zip(*judged, strict=True)):
        run = runs.get((p, n)) or _run(places[p], scheme, test, fed[p][n])
        found.append(replace(run, scheme=_named(scheme, n, modelled), places=errors if len(places) > 1 else ()))
    chances = [run.chance() for run in found]
    best, warnings = chances[-1].median, []
    if not max(glitch for *_, glitch in carried) <= 1.2 * best:
        others = ", ".join(f"{g * 1e6:.2f} µm at {feed * 1e3:.4g} mm/s on {r * 1e3:.4g} mm" for r, feed, g in carried)
        warnings.append(flaws.LEARNED_FOR_ONE_CIRCLE.found(best=Estimate(best, "m"), others=others))
    warnings += wrong_shape((run.scheme, chance.median) for run, chance in zip(found, chances, strict=True))
    least = min(chances, key=lambda chance: chance.median)
    if best > 1.5 * least.median and all(rise > 0 for rise in (chances[-1] - least).values):
        warnings.append(flaws.LEARNING_DIVERGES.found(least=least.text(digits=2), last=chances[-1].text(digits=2)))
    elif best > GAINS * chances[0].median:
        first, last = (chances[n].text(digits=2) for n in (0, -1))
        warnings.append(flaws.LEARNING_GAINS_NOTHING.found(last=last, first=first))
    return Learned(machine, how, tuple(found), tuple(carried), tuple(warnings))


def _references(test: Circle, axes: Mapping[str, Axis]) -> dict[str, Reference]:
    return dict(zip(axes, test.references(next(iter(axes.values())).cascade.sampling), strict=True))


def _run(axes: Mapping[str, Axis], scheme: Scheme, test: Circle, feedforward: Fed) -> CircleRun:
    references = _references(test, axes).items()
    traces = {
        name: run_axis(axes[name], r, scheme, against=feedforward[name], accuracy=ACCURACY) for name, r in references
    }
    x, y = (trace.position for trace in traces.values())
    return CircleRun(scheme, test, traces, circularity(x, y, test.radius))


def _named(scheme: Scheme, n: int, modelled: bool) -> Scheme:
    """Return the scheme recorded for a round: its feedforward, and the rounds that it was learned from."""
    if n == 0:
        return replace(scheme, name="round-00", title="before", friction="gms" if modelled else None)
    return replace(scheme, name=f"round-{n:02d}", title=f"learned from {n} circle{'s' * (n > 1)}", friction=LEARNED)


def _nominal_friction(axis: Axis, reference: Reference) -> Real:
    """Return the friction feedforward of a controller before learning [V], (n,)."""
    if (model := axis.nominal_friction.models.get("gms")) is None:
        return np.zeros(len(reference))
    plant = axis.nominal or axis.plant
    return friction_feedforward(model, reference.ahead(axis.lead()), plant.K_f, axis.nominal_friction.gain)


def _learned(
    axes: Mapping[str, Axis], references: Mapping[str, Reference], run: CircleRun, before: Fed, how: Learning
) -> Fed:
    found = {}
    for name, axis in axes.items():
        plant, trace = axis.nominal or axis.plant, run.traces[name]
        model = axis.cascade.model_share * inverse_model(plant, references[name].ahead(axis.lead()))
        error = trace.reference - trace.measured
        learned = next_feedforward(trace.time, error, trace.input, model, before[name], plant, how)
        found[name] = np.rint(learned / VOLT) * VOLT
    return found


def _carried(
    axes: Mapping[str, Axis], last: Fed, references: Mapping[str, Reference], other: Circle, scheme: Scheme
) -> float:
    """Return the glitch of another circle with the learned voltage, transferred by the angle [m]."""
    new = _references(other, axes)
    angle, new_angle = (np.unwrap(np.arctan2(y.position, x.position)) for x, y in (references.values(), new.values()))
    latest = np.abs(angle[-1] - angle) <= 2 * pi
    carried = {}
    for name, voltage in last.items():
        order = np.argsort(angle[latest] % (2 * pi))
        known, values = (angle[latest] % (2 * pi))[order], voltage[latest][order]
        carried[name] = np.interp(new_angle % (2 * pi), known, values, period=2 * pi)
    try:
        return _run(axes, scheme, other, carried).circularity.glitch
    except FricError:
        return float("nan")
