"""The nominal model that explains the voltages of recorded circles: least squares with the plant eliminated.

Also the effect of encoder counts: its error by a parametric bootstrap (`recorded_again`), and inertia and delay without
their bias (`Instruments`); intervals of friction and plant, and warnings about undetermined parameters. An axis of
a circle test is a balance of voltages, which is prepared once and replayed many times.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from math import pi
from typing import Any, Self

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import OptimizeResult, brentq, least_squares
from scipy.sparse import csr_array
from scipy.special import ndtr, ndtri, stdtrit

from fric.arrays import Indices, Mask, Real
from fric.circles.measured import SLOWEST, AxisTrace, MeasuredCircle, low_pass, smoothed
from fric.circles.revolutions import fit_circle, steady
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import Covariance, Estimate, Interval
from fric.flaws import circle
from fric.friction import FrictionModel
from fric.friction.directed import Directed, mean_map
from fric.friction.gms import GMS
from fric.friction.stribeck import STATIC_PARAMETERS, StaticMap
from fric.notice import Notice
from fric.records.inspection import CHANGES
from fric.records.resolution import lattice_step
from fric.simulate.machine import Axis
from fric.statistics import hac_covariance, score_covariance
from fric.units import Motion, si_unit

COMPARED = 70.0
"""Corner of the filter over all voltages that are compared [Hz]. With more, the noise that encoder counts are in an
acceleration weakens what is found of inertia, and the delay makes up for it: at 100 Hz B was 0.15 % high and T_d 4 to
10 % long, at 70 Hz neither was."""
RUN_IN = 0.15  # Share of a record that is left out: friction's state where it begins is not known
BREAK_AWAY = 0.5e-6  # The motion behind a reversal is sampled `FINE` times while it covers so much [m]
FINE = 8
ROWS = 400.0  # Least rate of the compared samples [Hz]: behind the filter, samples between them add no information
LEAST, TURNED = 32, 1.5 * pi  # Samples that are compared, and angle that they cover [rad], at least
SLIDING, COARSE = 0.35, 8  # Share of the feed above which friction is replayed from every n-th sample, and n
TAPS = 3.0  # Half of the length of the filter, in periods of its corner: what is beyond is 1e-5 of it


@dataclass(frozen=True, eq=False)
class Filter:
    """The filter over what is compared, from nodes, between which friction is linear, to the samples used."""

    time: Real  # time, used, nodes: as those of a `VoltageRecord`
    used: Mask
    nodes: Indices

    @cached_property
    def matrix(self) -> csr_array:
        """Its weights, shape (samples used, nodes)."""
        from scipy.signal import sosfiltfilt

        n, rate = len(self.time), 1.0 / float(self.time[1] - self.time[0])
        half = min(int(TAPS * rate / COMPARED), (n - 1) // 2)
        pulse = np.zeros(2 * half + 1)
        pulse[half] = 1.0
        taps = sosfiltfilt(low_pass(COMPARED, rate), pulse, padtype=None)
        rows = np.flatnonzero(self.used)
        columns = np.clip(rows[:, None] + np.arange(-half, half + 1), 0, n - 1)
        ends = np.arange(len(rows) + 1) * len(taps)
        smoothing = csr_array((np.tile(taps / taps.sum(), len(rows)), columns.ravel(), ends), shape=(len(rows), n))
        before = np.clip(np.searchsorted(self.nodes, np.arange(n), side="right") - 1, 0, len(self.nodes) - 2)
        share = (np.arange(n) - self.nodes[before]) / (self.nodes[before + 1] - self.nodes[before])
        between = csr_array(
            (np.stack([1 - share, share], 1).ravel(), np.stack([before, before + 1], 1).ravel(), 2 * np.arange(n + 1)),
            shape=(n, len(self.nodes)),
        )
        return smoothing @ between


@dataclass(frozen=True)
class VoltageRecord:
    """One axis of one circle test, made ready to be replayed."""

    time: Real  # Even sample instants [s], shape (n,)
    position: Real  # position, velocity: the motion [m], [m/s], without the encoder's steps, shape (n,)
    velocity: Real
    inertia: Real  # Acceleration behind the filter of what is compared [m/s²], shape (n,)
    damping: Real  # Velocity behind it [m/s], shape (n,)
    voltage: CubicSpline  # The control voltage behind the same filter, as a function of time
    used: Mask  # Samples that are compared, evenly spaced, shape (n,)
    nodes: Indices  # Samples of which friction is replayed: all near a reversal, few in sliding, shape (k,)
    revolution: Indices  # Revolution that a sample is of; -1 outside whole revolutions at steady feed, shape (n,)
    angle: Real  # Angle on the circle [rad], shape (n,)
    raw: tuple[Real, ...]  # What was recorded at even instants: time, reference, position, voltage, each of shape (N,)
    whole: Real  # The motion at these instants [m], shape (N,)
    test: MeasuredCircle  # test, axis: the circle test, and the name of the axis
    axis: str
    filter: Filter  # The filter over what is compared, which all records at these samples share

    @property
    def sampled(self) -> float:
        """Time between the samples as they were recorded [s]."""
        return float(self.raw[0][1] - self.raw[0][0])

    @property
    def rate(self) -> float:
        """Samples a second that are compared [Hz]."""
        first, second = np.flatnonzero(self.used)[:2]
        return 1.0 / float(self.time[second] - self.time[first])

    @property
    def quarter(self) -> int:
        """Of how many samples that are compared a quarter of a period of the filter's corner is."""
        return max(int(self.rate / (8 * COMPARED)), 1)

    @cached_property
    def _motion(self) -> tuple[Real, ...]:
        return tuple(np.ascontiguousarray(part[self.nodes]) for part in (self.time, self.position, self.velocity))

    def friction(self, model: FrictionModel) -> Real:
        """Return the friction of a model along the motion behind the filter [N], at the samples used."""
        return np.asarray(self.filter.matrix @ model.replay(*self._motion))

    def delayed(self, T_d: float) -> Real:
        """Return the control voltage as it acts, a delay later [V], at the samples used."""
        return np.asarray(self.voltage(self.time[self.used] - T_d))

    def repeating(self, rest: Real) -> float | None:
        """Return the root mean square of what does not repeat of a residual at the samples used; None of one turn."""
        revolution, angle = self.revolution[self.used], self.angle[self.used] % (2 * pi)
        if len(complete := [n for n in np.unique(revolution) if n >= 0]) < 2:
            return None
        bins = min(int(np.count_nonzero(revolution == complete[0])), 7200) // 2
        means = []
        for n in complete:
            cell = (angle[revolution == n] / (2 * pi) * bins).astype(int) % bins
            number = np.bincount(cell, minlength=bins)
            with np.errstate(invalid="ignore", divide="ignore"):
                means.append(np.bincount(cell, rest[revolution == n], bins) / number)
        return float(np.sqrt(np.nanmean(np.diff(np.array(means), axis=0) ** 2) / 2))


def voltage_record(test: MeasuredCircle, name: str, like: VoltageRecord | None = None) -> VoltageRecord:
    """Return one axis of a circle test, ready to be replayed.

    The reference is exact, so only the tracking error is smoothed: ``z = r - LP(r - z_m)`` with a Butterworth filter
    of second order at 200 Hz, there and back.

    like: A record of this axis along the same reference at the same instants, whose samples and angles are then used.
    """
    from scipy.signal import decimate, sosfiltfilt

    t, r, z_m, u, sampling = test.driven(name, "tuning")
    # how fine the motion behind a reversal is: its time over the first half micrometre
    along = (2 * BREAK_AWAY * test.radius) ** 0.5 / test.feed
    every = max(1, int(min(sampling / SLOWEST, sampling * along / FINE)))
    rate = sampling / every
    thin = t[::every]
    angle, revolution, used = _seen(test, thin, name) if like is None else (like.angle, like.revolution, like.used)
    rate_of = np.gradient(z_m, t)  # behind the filter of the comparison, noise included: no motion is removed
    a = np.gradient(rate_of, t)
    a[1:-1] = (z_m[2:] - 2 * z_m[1:-1] + z_m[:-2]) * sampling**2
    sections = low_pass(COMPARED, rate)
    z, v = smoothed(t, r, r - z_m)

    def compared(values: Real) -> Real:
        return np.asarray(sosfiltfilt(sections, decimate(values, every, ftype="fir") if every > 1 else values))

    inertia, damping, voltage = (compared(values)[: len(thin)] for values in (a, rate_of, u))
    smooth = np.ascontiguousarray(z[::every]), np.ascontiguousarray(v[::every])
    spline = CubicSpline(thin, voltage)
    if like is not None:
        return replace(
            like, position=smooth[0], velocity=smooth[1], inertia=inertia, damping=damping, voltage=spline,
            raw=(t, r, z_m, u), whole=z, test=test,
        )  # fmt: skip
    slides = np.abs(np.gradient(r, t))[::every] > SLIDING * test.feed
    nodes = np.flatnonzero(~slides | (np.arange(len(thin)) % COARSE == 0) | (np.arange(len(thin)) == len(thin) - 1))
    return VoltageRecord(
        thin, *smooth, inertia, damping, spline, used, nodes, revolution, angle, (t, r, z_m, u), z, test, name,
        Filter(thin, used, nodes),
    )  # fmt: skip


def refined(
    record: VoltageRecord, model: FrictionModel, T_d: float, plant: tuple[float, float, float], K_f: float
) -> VoltageRecord:
    """Return a record whose motion is known above the smoothing filter too, from the balance of the voltages.

    Smoothing removes the fast motion after a reversal, and friction replayed along the rest sets in late. What the
    filter removes is restored from ``z̈ = (u(t - T_d) - a·ż - o - F/K_f)/m``, twice integrated.

    model, T_d, plant, K_f: What was found so far; the plant as m [V·s²/m], a [V·s/m] and the offset [V].
    """
    t, r, z_m, u = record.raw
    every = round((record.time[1] - record.time[0]) / (t[1] - t[0]))
    velocity = np.gradient(record.whole, t)
    m, a, offset = plant
    late = np.interp(t - T_d, t, u)
    acceleration = (late - a * velocity - offset - model.replay(t, record.whole, velocity) / K_f) / m
    z, v = smoothed(t, r, r - z_m, np.gradient(np.gradient(r, t), t) - acceleration)
    position, velocity = (np.ascontiguousarray(x[::every]) for x in (z, v))
    return replace(record, position=position, velocity=velocity, whole=z)


def _seen(test: MeasuredCircle, t: Real, axis: str) -> tuple[Real, Indices, Mask]:
    """Return angle and revolution at even instants, and at which of them voltages are compared."""
    first, second = test.together()
    x, y = first.asked, second.asked
    a, b, _ = fit_circle(x, y)
    whole = np.unwrap(np.arctan2(y - b, x - a))
    inside = steady(first.time, whole)
    began, ended = first.time[inside.start], first.time[inside.stop - 1]
    angle, end = np.interp(t, first.time, whole), whole[inside.stop - 1]
    back, count = np.abs(end - angle) / (2 * pi), int(np.abs(end - whole[inside.start]) / (2 * pi) + 1e-3)
    within = (t >= began) & (t <= ended) & (back < count)
    revolution = np.where(within, np.floor(back).astype(int), -1).astype(np.intp)
    rate = 1.0 / float(t[1] - t[0])
    edge = int(rate / COMPARED * 4)
    used = (t >= first.time[0]) & (t <= ended) & (t - t[0] >= RUN_IN * (t[-1] - t[0]))
    used[:edge] = used[-edge:] = False
    used &= np.arange(len(t)) % max(int(rate / ROWS), 1) == 0
    if np.count_nonzero(used) < LEAST or np.ptp(angle[used]) < TURNED:
        raise FricError(
            "too little of the circle is left behind its run-in to tune by", where=f"{test.where}, axis {axis}",
            hint="Record two revolutions at steady feed.",
        )  # fmt: skip
    return angle, revolution, used


FOUR = ("level", "stiffness", "C", "T_d")  # The parameters tuned first
FALL = ("ratio", "v_s", "delta")  # Those of the fall of friction with speed
PRIORS = {  # Prior standard deviations of the coordinates' logarithms about their nominal values
    "level": 0.5, "stiffness": 1.0, "C": 2.0, "T_d": 0.15, "ratio": 0.3, "v_s": 0.7, "delta": 0.3, "side": 0.2,
    "alpha": 0.4, "k": 0.7,
}  # fmt: skip


@dataclass(frozen=True)
class BalanceCoordinates:
    """Coordinates about a friction model and a delay."""

    model: GMS  # The nominal friction
    T_d: float  # The nominal delay [s]
    # Coordinates that are free: of `FOUR`, ``ratio`` (excess of F_s over F_c), ``v_s``, ``delta``, ``alpha_i``,
    # ``k_i``, ``side`` (the level of the positive direction over that of the negative direction)
    names: tuple[str, ...] = FOUR
    side: float = 0.0  # What ``side`` is nominally, as a logarithm

    @classmethod
    def of(cls, nominal: FrictionModel, T_d: float) -> Self:
        """Return the four coordinates about a nominal GMS model, which may have a map for each direction."""
        model = gms_of(nominal)
        if isinstance(nominal, Directed):
            static, other = model.static, nominal.negative
            return cls(replace(model, static=mean_map(static, other)), T_d, side=float(np.log(static.F_c / other.F_c)))
        return cls(model, T_d)

    def full(self) -> Self:
        """Return the coordinates of the whole shape."""
        model = self.model
        blocks = range(1, len(model.alpha) + 1)
        shape = FALL if model.static.F_s > model.static.F_c else ()
        alphas = tuple(f"alpha_{n}" for n in blocks) if len(model.alpha) > 1 else ()
        return replace(self, names=("level", "C", "T_d", *shape, *alphas, *(f"k_{n}" for n in blocks)))

    def sided(self) -> Self:
        """Return the coordinates, and the difference between the directions."""
        return replace(self, names=(*self.names, "side"))

    @property
    def priors(self) -> Real:
        """Standard deviations of the coordinates, shape (p,)."""
        return np.array([PRIORS.get(name) or PRIORS[name.rpartition("_")[0]] for name in self.names])

    @property
    def bounds(self) -> Real:
        """Bounds of the search for each coordinate, shape (p,)."""
        return np.minimum(6.0 * self.priors, 3.5)

    def delay(self, x: Real) -> float:
        """Return the delay at a point [s]."""
        return self.T_d * self._factor(x, "T_d")

    def sides(self, x: Real) -> float:
        """Return the logarithm of the ratio of the levels, positive over negative direction, at a point."""
        return self.side + self._value(x, "side")

    def directed(self, x: Real) -> FrictionModel:
        """Return the friction at a point, with a map for each direction where they differ."""
        model, half = self.friction(x), 0.5 * self.sides(x)
        if half == 0.0:
            return model
        static = model.static
        levels = (float(np.exp(sign * half)) for sign in (1.0, -1.0))
        up, down = (replace(static, F_c=static.F_c * level, F_s=static.F_s * level) for level in levels)
        return Directed(replace(model, static=up), down)

    def friction(self, x: Real) -> GMS:
        """Return the friction at a point, the mean of both directions."""
        m = self.model
        static, level = m.static, self._factor(x, "level")
        F_c, F_s = static.F_c * level, static.F_s * level
        if "ratio" in self.names:  # of what F_s exceeds F_c by
            F_s = F_c * (1 + (static.F_s / static.F_c - 1) * self._factor(x, "ratio"))
        v_s, delta = static.v_s * self._factor(x, "v_s"), static.delta * self._factor(x, "delta")
        k = tuple(value * self._factor(x, "stiffness", f"k_{n}") for n, value in enumerate(m.k, start=1))
        alpha = [value * self._factor(x, f"alpha_{n}") for n, value in enumerate(m.alpha, start=1)]
        shares, C = tuple(value / sum(alpha) for value in alpha), m.C * level * self._factor(x, "C")
        return GMS(static=replace(static, F_c=F_c, F_s=F_s, v_s=v_s, delta=delta), alpha=shares, k=k, C=C)

    def moved(self, other: "BalanceCoordinates", x: Real) -> Real:
        """Return the point in these coordinates for a point in others about the same nominal model."""
        of_all = 0.0 if "stiffness" in self.names else other._value(x, "stiffness")
        return np.array([other._value(x, name) + of_all * name.startswith("k_") for name in self.names])

    def _value(self, x: Real, name: str) -> float:
        return float(x[self.names.index(name)]) if name in self.names else 0.0

    def _factor(self, x: Real, *names: str) -> float:
        return float(np.exp(sum(self._value(x, name) for name in names)))


def gms_of(friction: FrictionModel) -> GMS:
    """Return the GMS model of a friction, which may have a map for each direction."""
    model = friction.model if isinstance(friction, Directed) else friction
    if not isinstance(model, GMS):
        raise FricError(f"the nominal friction is {model.name}, and circles tune a GMS model")
    return model


def parameters(model: GMS) -> dict[str, float | tuple[float, ...]]:
    """Return the parameters of a friction model by name, SI."""
    static = {name: getattr(model.static, name) for name in STATIC_PARAMETERS}
    return {**static, "alpha": model.alpha, "k": model.k, "C": model.C}


STARTS = ((0.74, 1.0), (0.5, 2.7), (1.2, 0.22))  # Stiffness and C at which the search begins, over the nominal values
RESTS = 1e-4  # Relative change of the squares, and move in the logarithm, below which a search ends
STEP = 4e-3  # Step of the derivatives, in the logarithm
NOISE = 0.5e-3  # Least standard deviation of a residual relative to the priors [V]


@dataclass(frozen=True)
class Balance:
    """Voltages of one axis over some circles: ``W[u(t - T_d)] = m·W[z̈] + a·W[ż] + o + W[F]/K_f``.

    The plant's m = 1/B and a = A/B, and an offset o of each circle, are linear and eliminated.
    """

    records: tuple[VoltageRecord, ...]  # The circles
    coordinates: BalanceCoordinates  # What is searched
    K_f: float  # Force constant that the controller believes [N/V]: it is not separable from friction, so it is kept

    @cached_property
    def samples(self) -> list[slice]:
        """The samples of each circle, of all that are compared."""
        ends = np.cumsum([0, *(np.count_nonzero(record.used) for record in self.records)]).tolist()
        return [slice(*both) for both in pairwise(ends)]

    @cached_property
    def weights(self) -> Real:
        """Weight of each sample, so that every circle has equal weight, shape (n,)."""
        lengths = np.array([part.stop - part.start for part in self.samples])
        return np.repeat(np.sqrt(lengths.sum() / len(lengths) / lengths), lengths)

    @property
    def alike(self) -> float:
        """Number of neighbouring samples behind the filter per independent value."""
        return max(float(np.mean([record.rate for record in self.records])) / (2 * COMPARED), 1.0)

    @cached_property
    def columns(self) -> Real:
        """Acceleration, velocity and the offsets of all circles, weighed, shape (n, 2 + circles)."""
        found = np.zeros((len(self.weights), 2 + len(self.records)))
        for n, (record, part) in enumerate(zip(self.records, self.samples, strict=True)):
            found[part, 0], found[part, 1] = record.inertia[record.used], record.damping[record.used]
            found[part, 2 + n] = 1.0
        return self.weights[:, None] * found

    def friction(self, x: Real) -> Real:
        """Return the voltage of friction, weighed, at a point, shape (n,)."""
        model = self.coordinates.directed(x)
        return self.weights / self.K_f * np.concatenate([record.friction(model) for record in self.records])

    def voltage(self, T_d: float) -> Real:
        """Return the control voltage as it acts a delay later, weighed, shape (n,)."""
        return self.weights * np.concatenate([record.delayed(T_d) for record in self.records])

    @cached_property
    def _last(self) -> dict[tuple[float, ...], tuple[Real, Real]]:
        """The parts at the last point."""
        return {}

    def _parts(self, x: Real) -> tuple[Real, Real]:
        """Return the voltage, and that of friction, at a point; those of the last point are kept."""
        if (point := tuple(x)) not in self._last:
            self._last.clear()
            self._last[point] = self.voltage(self.coordinates.delay(x)), self.friction(x)
        return self._last[point]

    def left(self, x: Real) -> Real:
        """Return the voltage less that of friction, weighed."""
        voltage, friction = self._parts(x)
        return voltage - friction

    def derivatives(self, x: Real) -> Real:
        """Return the derivatives of `left`, shape (n, p)."""
        voltage, friction = self._parts(x)
        found = np.empty((len(voltage), len(x)))
        for n, name in enumerate(self.coordinates.names):
            moved = x.copy()
            moved[n] += STEP
            if name == "T_d":
                found[:, n] = (self.voltage(self.coordinates.delay(moved)) - voltage) / STEP
            else:
                found[:, n] = (friction - self.friction(moved)) / STEP
        return found


@dataclass(frozen=True)
class FittedBalance:
    """Result of a search."""

    balance: Balance  # What was balanced
    x: Real  # The point found, shape (p,)
    plant: Real  # m [V·s²/m], a [V·s/m], and the offset of each circle [V]
    residual: Real  # What is left at each sample used, circle after circle, not weighed [V]
    gradient: Real  # Its derivatives by x, then by the plant's parameters, shape (n, p + 2 + circles)

    @property
    def rms(self) -> float:
        """Root mean square of the residual, every circle with equal weight [V]."""
        return float(np.sqrt(np.mean([np.mean(part**2) for part in self.parts()])))

    def parts(self) -> list[Real]:
        """Return the residual of each circle [V]."""
        return [self.residual[part] for part in self.balance.samples]

    def truth(self, n: int) -> tuple[FrictionModel, float, tuple[float, float, float], float]:
        """Return friction, delay, (m, a, offset) and K_f of the n-th circle's balance, as arguments of `refined`."""
        coordinates, (m, a, *offsets) = self.balance.coordinates, self.plant.tolist()
        return coordinates.directed(self.x), coordinates.delay(self.x), (m, a, offsets[n]), self.balance.K_f

    def noise(self) -> float | None:
        """Return the rms of the part that does not repeat from turn to turn [V]; None if no circle shows it."""
        repeats = (record.repeating(part) for record, part in zip(self.balance.records, self.parts(), strict=True))
        known = [repeating for repeating in repeats if repeating is not None]
        return float(np.sqrt(np.mean(np.square(known)))) if known else None


def fit(balance: Balance, starts: Sequence[Real], sigma: float = NOISE, most: int = 12) -> FittedBalance:
    """Return the least-squares point of a balance with its priors, linear parameters projected out.

    starts: Points to start from, each of shape (p,); all are searched coarsely, and the best to the end.
    sigma: Standard deviation of a sample relative to the priors [V].
    """
    priors, bounds = balance.coordinates.priors, balance.coordinates.bounds
    basis = np.linalg.qr(balance.columns)[0]
    scale = 1.0 / (max(sigma, NOISE) * np.sqrt(balance.alike))

    def free(values: Real) -> Real:
        return np.asarray(scale * (values - basis @ (basis.T @ values)))

    def residual(x: Real) -> Real:
        return np.concatenate([free(balance.left(x)), x / priors])

    def gradient(x: Real) -> Real:
        return np.vstack([free(balance.derivatives(x)), np.diag(1.0 / priors)])

    def fine(x: Real, most: int) -> OptimizeResult:
        start = np.clip(x, -0.99 * bounds, 0.99 * bounds)
        return least_squares(residual, start, gradient, (-bounds, bounds), ftol=RESTS, xtol=RESTS, max_nfev=most)

    best = min((fine(x, most if len(starts) == 1 else 7) for x in starts), key=lambda solution: solution.cost)
    return at(balance, best.x if len(starts) == 1 else fine(best.x, most).x)


def at(balance: Balance, x: Real, plant: Real | None = None) -> FittedBalance:
    """Return the residual at a point, with the plant that fits best there, or with given m and a (offsets fitted)."""
    left, columns = balance.left(x), balance.columns
    if plant is None:
        linear = np.linalg.lstsq(columns, left, rcond=None)[0]
        gradient = np.hstack([balance.derivatives(x), -columns])
    else:
        offsets = np.linalg.lstsq(columns[:, 2:], left - columns[:, :2] @ plant, rcond=None)[0]
        linear, gradient = np.concatenate([plant, offsets]), -columns
    residual = (left - columns @ linear) / balance.weights
    return FittedBalance(balance, x, np.asarray(linear, float), residual, gradient / balance.weights[:, None])


DRAWS = 8  # Number of simulated repetitions of each circle
ENCODER_DRAWS = 3  # The same, for the part of a residual due to the encoder
SHAPE = 1.6
"""Residual of four parameters over noise and encoder effects, above which the full shape is fitted. Where the shape is
right they leave 1.1 to 1.4 times as much, where it is not 4 to 16. Below it is a tie: four are simpler."""


def recorded_again(found: FittedBalance, draws: int = DRAWS) -> list[Real]:
    """Return the residuals of circles recorded again with the result as their truth [V], each (n,).

    The motion behind encoder counts is known to a part of a count, with the same error in every revolution: no scatter
    of residuals shows what repeats. So the motion, the friction and the plant that were found are recorded again, with
    the encoder at other places between two counts, and the error is that of a fit to these records.
    """
    rng, balance, x = np.random.default_rng(0), found.balance, found.x
    left = []
    for _ in range(draws):
        records = []
        for n, record in enumerate(balance.records):
            records.append(refined(voltage_record(_once_more(found, n, rng), record.axis, record), *found.truth(n)))
        once = replace(balance, records=tuple(records))
        rest = once.voltage(balance.coordinates.delay(x)) - once.friction(x) - once.columns @ found.plant
        left.append(rest / balance.weights)
    return left


def explained(found: FittedBalance) -> float:
    """Return the rms of a fit's residual due to noise (what does not repeat) or to the encoder [V], the larger."""
    again = [replace(found, residual=left).rms for left in recorded_again(found, ENCODER_DRAWS)]
    return max(found.noise() or 0.0, float(np.sqrt(np.mean(np.square(again)))))


def _once_more(found: FittedBalance, n: int, rng: np.random.Generator) -> MeasuredCircle:
    """Return a circle test as the identified machine records it along the identified motion."""
    record: VoltageRecord = found.balance.records[n]
    model, T_d, (m, a, offset), K_f = found.truth(n)
    t, r, z_m, _ = record.raw
    z, period = record.whole, record.sampled
    velocity = np.gradient(z, t)
    acceleration = np.gradient(velocity, t)
    acceleration[1:-1] = (z[2:] - 2 * z[1:-1] + z[:-2]) / period**2
    acts = m * acceleration + a * velocity + offset + model.replay(t, z, velocity) / K_f
    # an encoder without counts, or with other errors, has the error of an encoder with counts of this step
    step, phase = lattice_step(z_m) or float(np.sqrt(12.0) * np.std(z_m - z)), rng.uniform()
    seen = (np.round(z / step + phase) - phase) * step if step > 0 else z
    trace = AxisTrace(t, seen, r, np.interp(t + T_d, t, acts))
    return replace(record.test, axes={**record.test.axes, record.axis: trace})


SMOOTHED = 40.0  # Corner of the filter over the instruments [Hz]: at 50 Hz 1 % of T_d are left, below 40 too little
GROWN = 1.02  # Largest residual of instruments over that of least squares: with more, they are too weak


@dataclass(frozen=True)
class Instruments:
    """Instruments about a fit, and their weights: inertia and delay without the bias from encoder counts.

    Counts are noise in z̈, and the loop makes voltage of them: regressors and residual share it, and least squares
    takes it for less inertia and more delay (median 0.05 % of B and 4 % of T_d on drawn machines). Instruments Z that
    do not hold it leave nothing of that: ``Zᵀ·r = 0`` in place of ``Jᵀ·r = 0`` (Söderström and Stoica, Instrumental
    variable methods for system identification, 1983). Here Z is J with the columns of z̈ and of T_d smoothed further:
    counts are noise whose power rises with the fifth power of the corner, and the motion lies below.
    """

    Z: Real  # Z, J: instruments and derivatives, every circle with equal weight, shape (n, p + 2 + circles)
    J: Real
    prior: Real  # Curvature of the priors, shape (p + 2 + circles,)
    power: float  # Variance of an independent sample [V²]

    @classmethod
    def of(cls, found: FittedBalance) -> Self:
        """Return the instruments about a fit."""
        from scipy.signal import sosfiltfilt

        balance, p = found.balance, len(found.x)
        J = balance.weights[:, None] * found.gradient
        Z, shared = J.copy(), [balance.coordinates.names.index("T_d"), p]
        for record, part in zip(balance.records, balance.samples, strict=True):
            Z[part, shared] = sosfiltfilt(low_pass(SMOOTHED, record.rate), J[part][:, shared], axis=0)
        power = max(found.rms, NOISE) ** 2 * balance.alike
        prior = np.zeros(J.shape[1])
        prior[:p] = power / balance.coordinates.priors**2
        return cls(Z, J, prior, power)

    def error(self, residual: Real) -> Real:
        """Return the errors of coordinates and plant for a weighted residual of the truth, shape (n,)."""
        return self.solved(self.Z.T @ residual)

    def solved(self, scores: Real) -> Real:
        """Return ``-(ZᵀJ + P)⁻¹`` times scores."""
        crossed = self.Z.T @ self.J + np.diag(self.prior)
        size = np.sqrt(np.diag(self.J.T @ self.J) + self.prior)
        size[size == 0] = 1.0
        scaled = np.linalg.lstsq(crossed / np.outer(size, size), -(scores.T / size).T, rcond=1e-12)[0]
        return np.asarray((scaled.T / size).T)


def instrumented(found: FittedBalance) -> FittedBalance:
    """Return a fit moved to where its instruments leave no residual; unchanged if they are too weak."""
    p, balance, weights = len(found.x), found.balance, found.balance.weights
    step = Instruments.of(found).error(weights * found.residual)
    x, plant = found.x + step[:p], found.plant + step[p:]
    moved = replace(found, x=x, plant=plant, residual=(balance.left(x) - balance.columns @ plant) / weights)
    if not moved.rms < GROWN * found.rms or np.any(np.abs(x) > balance.coordinates.bounds):
        return found
    return replace(moved, gradient=np.hstack([balance.derivatives(x), -balance.columns]) / weights[:, None])


def whole(found: FittedBalance) -> tuple[FittedBalance, Real]:
    """Return a fit in the coordinates of the whole shape, and how far off a fit of the whole shape is, to first order.

    The choice between four parameters and the whole shape may depend on little, and the intervals must not depend on
    it. The point is the one found; the residual is that of the step to the fit of the whole shape: the additional
    residual of four parameters is no noise. The step is of coordinates and plant, shape (p + 2 + circles,).
    """
    kept = found.balance.coordinates
    shape = kept.full().sided() if "side" in kept.names else kept.full()
    if shape.names == kept.names:
        return found, np.zeros(len(found.x) + len(found.plant))
    balance = replace(found.balance, coordinates=shape)
    x = shape.moved(kept, found.x)
    slopes = balance.derivatives(x) / balance.weights[:, None]
    lifted = replace(found, balance=balance, x=x, gradient=np.hstack([slopes, found.gradient[:, len(kept.names) :]]))
    step = Instruments.of(lifted).error(balance.weights * lifted.residual)
    return replace(lifted, residual=lifted.residual + lifted.gradient @ step), step


@dataclass(frozen=True)
class TunedEstimates:
    """Friction and plant with their 95 % intervals."""

    static: dict[str, Estimate]  # static, negative, gms, plant: parameters by name, ``offset`` in the static map
    negative: dict[str, Estimate] | None  # Map of the negative direction, where each has one
    gms: dict[str, Estimate]
    plant: dict[str, Estimate]
    covariance: Covariance  # Covariance of the logarithms of the fitted parameters
    coordinates: Real  # Covariance of the coordinates that were searched, shape (p, p)

    def at(self, friction: FrictionModel) -> Self:
        """Return the estimates with another nominal friction, in which differing values are marked as fixed."""
        negative, model = friction.negative if isinstance(friction, Directed) else None, gms_of(friction)

        def fixed(section: dict[str, Estimate], values: Mapping[str, Any]) -> dict[str, Estimate]:
            return {
                name: estimate if np.allclose(estimate.value, values.get(name, estimate.value), 1e-5)
                else Estimate(values[name], estimate.unit, fixed=True)
                for name, estimate in section.items()
            }  # fmt: skip

        static, gms = fixed(self.static, vars(model.static)), fixed(self.gms, vars(model))
        free = {name for name, estimate in (static | gms).items() if not estimate.fixed}
        kept = [n for n, name in enumerate(self.covariance.names) if name in free or name.rpartition("_")[0] in free]
        rows = np.array(self.covariance.matrix)[np.ix_(kept, kept)]
        return replace(
            self, static=static, gms=gms,
            negative=None if self.negative is None else fixed(self.negative, vars(negative)),
            covariance=Covariance.of([self.covariance.names[n] for n in kept], rows, "log"),
        )  # fmt: skip


@dataclass(frozen=True)
class TunedAxis:
    """Result of circles for one axis."""

    axis: Axis  # The axis with its new nominal parameters; as it was, where these are refused
    friction: FrictionModel  # friction, nominal: the friction and the plant that were found
    nominal: Plant
    before: FittedBalance  # before, after: residual of the recorded voltages with nominal and tuned parameters
    after: FittedBalance
    estimates: TunedEstimates | None  # Both with their intervals; None where the result is no machine
    full: bool  # Whether the full shape was fitted
    improves: bool  # Whether the result is better than the nominal parameters
    warnings: tuple[Notice, ...]  # Warnings: what the circles do not determine
    loop: bool = False  # Whether its loop was redesigned

    @property
    def parameters(self) -> dict[str, Estimate]:
        """Friction and plant by name, with their intervals; empty where the result is no machine."""
        return {} if (found := self.estimates) is None else {**found.static, **found.gms, **found.plant}


FEEDS_APART = 3.0  # Ratio of the feeds of two circles above which they hold different information
LATE = 0.25  # Relative deviation of the delay from the nominal one that gives a warning, where its interval excludes it
BLOCKS_ALIKE = 0.5
"""Distance of two slip displacements (logarithm) below which the residual has several minima, alpha and k ± 20 %."""
MISFIT = 3.0  # Largest residual of a result over the noise
AT_BOUND = 0.97  # Share of a bound of the search above which a parameter counts as at it
SMALL_STEP = 1e-4  # Step of derivatives between parameters and coordinates, in the logarithm
SEEN = 0.08  # Uncertainty of a block's slip, as a share of an encoder step
OPEN = 7.0  # Half of an interval of a logarithm above which the data set no limit: a factor of a thousand
OF = {p.name: p.dimension for p in (*StaticMap.parameters, *GMS.parameters)}  # Dimensions of the parameters


def identifiability_warnings(axis: Axis, tests: Sequence[MeasuredCircle], found: FittedBalance) -> Iterator[Notice]:
    """Yield the warnings about undetermined parameters of an axis and about the fit."""
    where, volt, feeds = f"axis {axis.name}", si_unit("input", axis.motion), sorted(test.feed for test in tests)
    if feeds[-1] < FEEDS_APART * feeds[0]:
        missing = (
            "delay, inertia and how friction falls with speed above it (T_d may be off by half)" if feeds[-1] < 0.03
            else "v_s, delta, C and the weakest blocks, which show where a reversal is slow"
        )  # fmt: skip
        yield circle.ONE_FEED.found(where, feed=Estimate(feeds[-1], "m/s"), missing=missing)
    # the effect of encoder counts repeats from turn to turn, and is no misfit
    if (noise := found.noise()) is not None and found.rms > MISFIT * noise and found.rms > SHAPE * explained(found):
        yield circle.CIRCLE_MISFIT.found(where, left=Estimate(found.rms, volt), noise=Estimate(noise, volt))
    yield from _drifts(axis, found)
    if "side" in (coordinates := found.balance.coordinates).names:
        side = coordinates.sides(found.x)
        yield circle.DIRECTION.found(where, side=abs(side), positive=side > 0)
    over = np.abs(found.x) / coordinates.bounds
    if at_end := [name for name, share in zip(coordinates.names, over, strict=True) if share > AT_BOUND]:
        yield circle.TUNED_AT_BOUND.found(where, names=at_end)


def timing_warnings(axis: Axis, found: FittedBalance, T_d: Estimate) -> Iterator[Notice]:
    """Yield the warning that position and voltage are shifted, if the interval of the delay shows it."""
    nominal = found.balance.coordinates.T_d
    low, high = (float(limit) for limit in np.ravel(T_d.ci95 or (T_d.value, T_d.value)))
    if abs(float(T_d) - nominal) > LATE * nominal and not low <= nominal <= high:
        flaw = circle.POSITION_LATE if float(T_d) > nominal else circle.POSITION_EARLY
        delay, least, most, believed = (Estimate(value, "s") for value in (float(T_d), low, high, nominal))
        yield flaw.found(f"axis {axis.name}", delay=delay, low=least, high=most, nominal=believed)


def _drifts(axis: Axis, found: FittedBalance) -> Iterator[Notice]:
    """Yield the circles in which the level of friction drifts: by a line in time besides the fit's parameters."""
    balance = found.balance
    J, residual = balance.weights[:, None] * found.gradient, balance.weights * found.residual
    level = J[:, balance.coordinates.names.index("level")]
    for record, part in zip(balance.records, balance.samples, strict=True):
        time, along = record.time[record.used], np.zeros(len(level))
        along[part] = level[part] * (time - time.mean()) / np.ptp(time)
        apart = along - J @ np.linalg.lstsq(J, along, rcond=1e-9)[0]
        change = -float(apart @ residual / (apart @ apart))
        thin = slice(part.start, part.stop, record.quarter)
        rest = residual + change * apart  # the drift itself is no error of it
        half = 2.0 * float(np.sqrt(hac_covariance(apart[thin, None], rest[thin])[0, 0]))
        if abs(change) > max(half, CHANGES):
            feed = Estimate(record.test.feed, "m/s")
            yield circle.CIRCLE_DRIFTS.found(f"axis {axis.name}", change=change, size=abs(change), half=half, feed=feed)


def groups_alike(found: FittedBalance) -> list[list[int]]:
    """Return groups of blocks that slip at about the same displacement, counted from 0."""
    if not any(name.startswith("alpha") for name in found.balance.coordinates.names):
        return []
    model = found.balance.coordinates.friction(found.x)
    slips = np.log(np.array(model.alpha) / np.array(model.k))
    groups: list[list[int]] = []
    for n in map(int, np.argsort(slips)):
        if groups and slips[n] - slips[groups[-1][-1]] < BLOCKS_ALIKE:
            groups[-1].append(n)
        else:
            groups.append([n])
    return [sorted(group) for group in groups if len(group) > 1]


def merged(found: FittedBalance) -> FittedBalance | None:
    """Return a fit with its residual, and its derivatives where blocks that slip together have the same displacement.

    There the blocks are not separable, and the distance that the fit found is noise. None where none slip together.
    """
    if not (groups := groups_alike(found)):
        return None
    names, x = found.balance.coordinates.names, found.x.copy()
    model = found.balance.coordinates.friction(found.x)
    for group in groups:
        slip = sum(model.alpha[n] for n in group) / sum(model.k[n] for n in group)
        for n in group:
            x[names.index(f"k_{n + 1}")] += np.log(model.alpha[n] / model.k[n] / slip)
    return replace(at(found.balance, x), residual=found.residual)


def tuned_estimates(found: FittedBalance, plant: Plant, motion: Motion, *, unexplained: bool = False) -> TunedEstimates:
    """Return the result with intervals due to noise, correlated in any way, and to the encoder.

    Where the shape was kept, either it or a fit of the whole shape is right, at equal odds: an interval holds 95 % of
    both. A shape that is off by little moves F_c by several half-widths before it shows in the residual.

    unexplained: Whether the model does not explain circles of one feed: friction over position then moves their delay
        by twice what the residual tells (`tests/circles/test_tune.py`).
    """
    left = recorded_again(found)
    kept, of_kept = _covariance(found, left), _logarithms(found)[0]
    coordinates, halves_kept = kept[0][: len(found.x), : len(found.x)], _half_widths(of_kept, *kept)
    found, step = whole(found)
    covariance, errors = _covariance(found, left)
    names = found.balance.coordinates.names
    p, quantile = len(found.x), float(stdtrit(len(left), 0.975))
    slope, labels = _logarithms(found)
    spread, halves = slope @ covariance @ slope.T, _half_widths(slope, covariance, errors)
    # blocks that slip together are only separable by where they were found: use the information where they do not
    if (at_one := merged(found)) is not None:
        halves = np.maximum(halves, _half_widths(slope, *_covariance(at_one, left)))
    moved = slope @ step
    either = dict(zip(labels, zip(halves_kept if step.any() else halves, moved, halves, strict=True), strict=True))

    def within(name: str, value: float) -> Interval:
        factor = 2.0 if unexplained and name == "T_d" else 1.0
        of_kept, moves, half = (factor * float(part) for part in either[name])
        if half + abs(moves) > OPEN:
            return 0.0, np.inf
        low, high = (_of_either(of_kept, moves, half, level) for level in (0.025, 0.975))
        return value * float(np.exp(low)), value * float(np.exp(high))

    fitted = {name for name, (*_, half) in either.items() if half > 1e-9}
    sections: dict[str, Estimate] = {}
    for name, value in parameters(found.balance.coordinates.friction(found.x)).items():
        keys, known = _labels(name, value), not fitted.isdisjoint(_labels(name, value))
        limits = tuple(map(within, keys, value)) if isinstance(value, tuple) else within(name, value)
        sections[name] = Estimate(value, si_unit(OF[name], motion), limits if known else None, fixed=not known)
    offsets, K_f = found.plant[2:], found.balance.K_f
    error = quantile * float(np.sqrt(covariance[p + 2, p + 2] / len(offsets) + np.var(offsets))) * K_f
    load = float(np.mean(offsets)) * K_f
    static = {name: sections[name] for name in STATIC_PARAMETERS}
    negative = None
    if side := found.balance.coordinates.sides(found.x):
        variance = covariance[names.index("side"), names.index("side")] if "side" in names else 0.0
        wider = quantile * float(np.sqrt(variance)) / 2
        levels = {name: static[name] for name in ("F_c", "F_s")}
        apart = (side / 2, -side / 2)
        static, negative = (static | {n: _scaled(level, half, wider) for n, level in levels.items()} for half in apart)
    static["offset"] = Estimate.around(load, si_unit("force", motion), error)
    gms = {name: sections[name] for name in ("alpha", "k", "C")}
    of_plant = {
        "A": Estimate(plant.A, "1/s", within("A", plant.A) if plant.A > 0 else None),
        "B": Estimate(plant.B, si_unit("acceleration per input", motion), within("B", plant.B)),
        "T_d": Estimate(plant.T_d, "s", within("T_d", plant.T_d)),
        "K_f": Estimate(plant.K_f, si_unit("force per input", motion), fixed=True),
    }
    of_friction = [n for n, label in enumerate(labels) if label not in ("A", "B", "T_d") and label in fitted]
    spread += np.outer(moved, moved)
    joint = Covariance.of([labels[n] for n in of_friction], spread[np.ix_(of_friction, of_friction)], "log")
    return TunedEstimates(static, negative, gms, of_plant, joint, coordinates)


def _half_widths(along: Real, covariance: Real, errors: Real) -> Real:
    """Return half-widths of 95 % intervals along directions (rows), for a covariance with the mean square of errors.

    Student's t has the degrees of freedom of Satterthwaite (An approximate distribution of estimates of variance
    components, 1946): those of the circles recorded again, times the square of the variance over their part of it.
    """
    variance = np.maximum(np.sum(along @ covariance * along, axis=1), 0.0)
    drawn = np.mean((along @ errors.T) ** 2, axis=1)
    part = np.divide(drawn, variance, out=np.ones_like(drawn), where=variance > 0)
    return np.asarray(stdtrit(len(errors) / np.clip(part, 1e-3, 1.0) ** 2, 0.975) * np.sqrt(variance))


def _of_either(half_kept: float, moved: float, half: float, level: float) -> float:
    """Return a quantile of an error that is, at equal odds, normal about 0 or about another estimate, by half-widths of
    95 %, of which that about 0 may be 0, as where a parameter was kept.
    """
    centres, deviations = np.array([0.0, moved]), np.maximum([half_kept, half], 1e-12) / ndtri(0.975)
    if np.ptp(ends := centres + deviations * ndtri(level)) == 0:
        return float(ends[0])
    return float(brentq(lambda x: np.mean(ndtr((x - centres) / deviations)) - level, ends.min(), ends.max()))


def _scaled(estimate: Estimate, shift: float, wider: float) -> Estimate:
    """Return an estimate times e to the power of a shift, its interval wider by a share."""
    value, *limits = (float(number) * float(np.exp(shift)) for number in (estimate, *np.ravel(estimate.ci95 or ())))
    ci95 = (limits[0] * (1 - wider), limits[1] * (1 + wider)) if limits else None
    return replace(estimate, value=value, ci95=ci95)


def _covariance(about: FittedBalance, left: list[Real]) -> tuple[Real, Real]:
    """Return the covariance of coordinates and plant about a point, (p + 2 + circles,) square, and errors by counts.

    Samples are thinned to four a period of the filter's corner: samples between them add no information. Scores are
    correlated (autoregressions), and the priors add their variance. Delay, inertia and A, which the whole circle
    determines, take the memory of their own error, ``(ZᵀJ + P)⁻¹·z·r``: that of their scores, in which C and the level
    have a part, is three times as wide on poor logs. For the level both fail: by its scores, with what reversals leave
    open of the fall of friction, F_c is off by 0.25 half-widths (rms), by its own error at the fall that was found by
    0.95. It takes their geometric mean, by which it is 0.5, as with Student's t. The error from the encoder is added.
    """
    instruments, weights, p = Instruments.of(about), about.balance.weights, len(about.x)
    rows, residuals = [], []
    for record, part in zip(about.balance.records, about.balance.samples, strict=True):
        chosen, more = slice(part.start, part.stop, record.quarter), np.sqrt(record.quarter)  # fewer samples weigh more
        rows.append(more * instruments.Z[chosen])
        residuals.append(more * (weights * about.residual)[chosen])
    Z, lengths = np.vstack(rows), list(map(len, rows))

    def remembered(regressors: Real) -> Real:  # circles that are recorded again show what recurs in each turn
        scale = np.linalg.norm(regressors, axis=0)
        scale[scale == 0] = 1.0
        long_run = score_covariance(regressors / scale, np.concatenate(residuals), lengths, most=1.0)
        return np.asarray(np.outer(scale, scale) * long_run)

    covariance = instruments.solved(instruments.solved(remembered(Z)).T)
    names, late = about.balance.coordinates.names, about.balance.coordinates.names.index("T_d")
    level, rest = names.index("level"), [n for n in range(Z.shape[1]) if n >= p or names[n] not in FALL]
    held = replace(instruments, Z=instruments.Z[:, rest], J=instruments.J[:, rest], prior=instruments.prior[rest])
    each = [held.solved(Z[:, rest].T)[rest.index(level)], *instruments.solved(Z.T)[[late, p, p + 1]]]
    along, ratio = [level, late, p, p + 1], np.ones(len(covariance))
    by_itself = np.diag(remembered(np.column_stack(each)))
    ratio[along] = np.sqrt(np.minimum(by_itself / np.diag(covariance)[along], 1.0))
    ratio[level] **= 0.5
    covariance = covariance * np.outer(ratio, ratio)
    covariance += instruments.solved(instruments.solved(np.diag(instruments.power * instruments.prior)).T)
    errors = _beyond(about, left) * np.array([instruments.error(weights * array) for array in left])
    covariance += errors.T @ errors / len(errors)
    covariance[:p, :p] += np.diag(_of_the_encoder(about))
    return np.asarray(covariance), errors


def _beyond(about: FittedBalance, left: list[Real]) -> float:
    """Return the ratio of the repeating part of the residual to that of circles recorded again.

    At least 1. A larger ratio is not due to the encoder step: the encoder ripples, or friction has another shape.
    """
    again = float(np.sqrt(np.mean([replace(about, residual=array).rms ** 2 for array in left])))
    repeats = max(about.rms**2 - (about.noise() or 0.0) ** 2, 0.0) ** 0.5
    return max(1.0, repeats / again) if again > 0 else 1.0


def _of_the_encoder(found: FittedBalance) -> Real:
    """Return variances of the stiffnesses' logarithms by the encoder's resolution of a slip, shape (p,)."""
    coordinates = found.balance.coordinates
    model = coordinates.friction(found.x)
    step = max(lattice_step(record.raw[2]) or 0.0 for record in found.balance.records)
    shares = [SEEN * step * k / (alpha * model.static.F_s) for alpha, k in zip(model.alpha, model.k, strict=True)]
    by_name = {f"k_{n}": share for n, share in enumerate(shares, 1)} | {"stiffness": shares[int(np.argmax(model.k))]}
    return np.array([by_name.get(name, 0.0) ** 2 for name in coordinates.names])


def _logarithms(found: FittedBalance) -> tuple[Real, list[str]]:
    """Return derivatives of the parameters' logarithms by coordinates and plant, and the parameters' names."""
    coordinates, p, point = found.balance.coordinates, len(found.x), np.append(found.x, found.plant)

    def all_of(point: Real) -> Real:
        model, (m, a) = parameters(coordinates.friction(point[:p])), point[p : p + 2]
        flat = np.concatenate([np.atleast_1d(np.asarray(value, float)) for value in model.values()])
        tail = [max(a / m, 1e-12), 1 / m, coordinates.delay(point[:p])]
        return np.log(np.maximum(np.concatenate([flat, tail]), 1e-300))

    here = all_of(point)
    slope = np.zeros((len(here), len(point)))
    for n in range(p + 2):
        moved, step = point.copy(), SMALL_STEP * (max(abs(point[n]), 1e-9) if n >= p else 1.0)
        moved[n] += step
        slope[:, n] = (all_of(moved) - here) / step
    named = parameters(coordinates.friction(found.x)).items()
    return slope, [*(label for name, value in named for label in _labels(name, value)), "A", "B", "T_d"]


def _labels(name: str, value: float | tuple[float, ...]) -> list[str]:
    """Return the name of a parameter, as ``k_1`` where each block has it."""
    return [f"{name}_{n}" for n in range(1, len(value) + 1)] if isinstance(value, tuple) else [name]
