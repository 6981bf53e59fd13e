"""The nominal model that explains the voltages of recorded circles: least squares with the plant eliminated.

Also the effect of encoder counts: its error by a parametric bootstrap (`recorded_again`), and inertia and delay without
their bias (`Instruments`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from fric.arrays import Real
from fric.circles.measured import AxisTrace, MeasuredCircle, low_pass
from fric.circles.voltage import COMPARED, VoltageRecord, refined, voltage_record
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import Covariance, Estimate
from fric.friction import FrictionModel
from fric.friction.directed import Directed, mean_map
from fric.friction.gms import GMS
from fric.friction.stribeck import STATIC_PARAMETERS, StaticMap
from fric.notice import Notice
from fric.records.resolution import lattice_step
from fric.simulate.machine import Axis

FOUR = ("level", "stiffness", "C", "T_d")
"""The parameters tuned first."""
PRIORS = {"level": 0.5, "stiffness": 1.0, "C": 2.0, "T_d": 0.15, "ratio": 0.3, "v_s": 0.7, "delta": 0.3, "side": 0.2}
"""Prior standard deviations of the coordinates' logarithms about their nominal values."""
PRIOR_ALPHA, PRIOR_K = 0.4, 0.7


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
    def of(cls, nominal: FrictionModel, T_d: float) -> BalanceCoordinates:
        """Return the four coordinates about a nominal model, which may have a map for each direction.

        Raises FricError: When it is no GMS model.
        """
        model = gms_of(nominal)
        if isinstance(nominal, Directed):
            static, other = model.static, nominal.negative
            return cls(replace(model, static=mean_map(static, other)), T_d, side=float(np.log(static.F_c / other.F_c)))
        return cls(model, T_d)

    def full(self) -> BalanceCoordinates:
        """Return the coordinates of the whole shape."""
        model = self.model
        blocks = range(1, len(model.alpha) + 1)
        shape = ("ratio", "v_s", "delta") if model.static.F_s > model.static.F_c else ()
        alphas = tuple(f"alpha_{n}" for n in blocks) if len(model.alpha) > 1 else ()
        return replace(self, names=("level", "C", "T_d", *shape, *alphas, *(f"k_{n}" for n in blocks)))

    def sided(self) -> BalanceCoordinates:
        """Return the coordinates, and the difference between the directions."""
        return replace(self, names=(*self.names, "side"))

    @property
    def priors(self) -> Real:
        """Standard deviations of the coordinates, shape (p,)."""
        return np.array(
            [PRIOR_ALPHA if n.startswith("alpha") else PRIOR_K if n.startswith("k_") else PRIORS[n] for n in self.names]
        )

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
        up, down = (_scaled(model.static, float(np.exp(sign * half))) for sign in (1.0, -1.0))
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

    def moved(self, other: BalanceCoordinates, x: Real) -> Real:
        """Return the point in these coordinates for a point in others about the same nominal model."""
        found = np.zeros(len(self.names))
        for n, name in enumerate(self.names):
            found[n] = other._value(x, name)
            if name.startswith("k_") and "stiffness" not in self.names:
                found[n] += other._value(x, "stiffness")
        return found

    def _value(self, x: Real, name: str) -> float:
        return float(x[self.names.index(name)]) if name in self.names else 0.0

    def _factor(self, x: Real, *names: str) -> float:
        return float(np.exp(sum(self._value(x, name) for name in names)))


def gms_of(friction: FrictionModel) -> GMS:
    """Return the GMS model of a friction, which may have a map for each direction.

    Raises FricError: When it is no GMS model.
    """
    model = friction.model if isinstance(friction, Directed) else friction
    if not isinstance(model, GMS):
        raise FricError(f"the nominal friction is {model.name}, and circles tune a GMS model")
    return model


def _scaled(static: StaticMap, level: float) -> StaticMap:
    return replace(static, F_c=static.F_c * level, F_s=static.F_s * level)


def parameters(model: GMS) -> dict[str, float | tuple[float, ...]]:
    """Return the parameters of a friction model by name, SI."""
    static = {name: getattr(model.static, name) for name in STATIC_PARAMETERS}
    return {**static, "alpha": model.alpha, "k": model.k, "C": model.C}


STARTS = ((0.74, 1.0), (0.5, 2.7), (1.2, 0.22))
"""Stiffness and C, as shares of the nominal values, at which the search begins."""
RESTS = 1e-4
"""Relative change of the squares, and move in the logarithm, below which a search ends."""
STEP = 4e-3
"""Step of the derivatives, in the logarithm."""
NOISE = 0.5e-3
"""Least standard deviation of a residual relative to the priors [V]."""


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

    def columns(self) -> Real:
        """Return acceleration, velocity and the offsets of all circles, weighed, shape (n, 2 + circles)."""
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
        known = [
            repeating
            for record, part in zip(self.balance.records, self.parts(), strict=True)
            if (repeating := record.repeating(part)) is not None
        ]
        return float(np.sqrt(np.mean(np.square(known)))) if known else None


class BalanceSearch:
    """Residuals of a balance with its priors, in standard deviations, with linear parameters projected out."""

    def __init__(self, balance: Balance, sigma: float = NOISE) -> None:
        self.balance, self.priors, self.columns = balance, balance.coordinates.priors, balance.columns()
        self.basis = np.linalg.qr(self.columns)[0]
        self.scale = 1.0 / (sigma * np.sqrt(balance.alike))
        self._voltage = lru_cache(1)(balance.voltage)
        self._friction = lru_cache(1)(lambda x: balance.friction(np.array(x)))

    def _parts(self, x: Real) -> tuple[Real, Real]:
        """Return the voltage, and that of friction, weighed."""
        return self._voltage(self.balance.coordinates.delay(x)), self._friction(tuple(x))

    def left(self, x: Real) -> Real:
        """Return the voltage less that of friction, weighed."""
        voltage, friction = self._parts(x)
        return voltage - friction

    def derivatives(self, x: Real) -> Real:
        """Return the derivatives of `left`."""
        balance, (voltage, friction) = self.balance, self._parts(x)
        found = np.empty((len(voltage), len(x)))
        for n, name in enumerate(balance.coordinates.names):
            moved = x.copy()
            moved[n] += STEP
            if name == "T_d":
                found[:, n] = (balance.voltage(balance.coordinates.delay(moved)) - voltage) / STEP
            else:
                found[:, n] = (friction - balance.friction(moved)) / STEP
        return found

    def _free(self, values: Real) -> Real:
        """Return values in standard deviations, with linear parameters projected out."""
        return np.asarray(self.scale * (values - self.basis @ (self.basis.T @ values)))

    def residual(self, x: Real) -> Real:
        """Return the residual of the voltages, and the distance from the priors, in standard deviations."""
        return np.concatenate([self._free(self.left(x)), x / self.priors])

    def gradient(self, x: Real) -> Real:
        """Return the derivatives of `residual`."""
        return np.vstack([self._free(self.derivatives(x)), np.diag(1.0 / self.priors)])

    def fine(self, x: Real, most: int) -> OptimizeResult:
        """Return the least-squares point next to x within the bounds, in a bounded number of steps."""
        bounds = self.balance.coordinates.bounds
        start = np.clip(x, -0.99 * bounds, 0.99 * bounds)
        return least_squares(
            self.residual, start, self.gradient, (-bounds, bounds), ftol=RESTS, xtol=RESTS, max_nfev=most
        )


def fit(balance: Balance, starts: Sequence[Real], sigma: float = NOISE, most: int = 12) -> FittedBalance:
    """Return the least-squares point of a balance with its priors, from the best of some starts.

    balance: The balance.
    starts: Points to start from, each of shape (p,); all are searched coarsely, and the best to the end.
    sigma: Standard deviation of a sample relative to the priors [V].
    most: Steps at most.
    """
    search, few = BalanceSearch(balance, max(sigma, NOISE)), most if len(starts) == 1 else 7
    best = min((search.fine(x, few) for x in starts), key=lambda solution: solution.cost)
    return at(balance, best.x if len(starts) == 1 else search.fine(best.x, most).x)


def at(balance: Balance, x: Real, plant: Real | None = None) -> FittedBalance:
    """Return the residual at a point, with the plant that fits best there, or with a given plant (its offsets fitted).

    balance: The balance.
    x: The point, shape (p,).
    plant: m [V·s²/m] and a [V·s/m] that are kept.
    """
    search = BalanceSearch(balance)
    left, columns = search.left(x), search.columns
    if plant is None:
        linear = np.linalg.lstsq(columns, left, rcond=None)[0]
        gradient = np.hstack([search.derivatives(x), -columns])
    else:
        offsets = np.linalg.lstsq(columns[:, 2:], left - columns[:, :2] @ plant, rcond=None)[0]
        linear, gradient = np.concatenate([plant, offsets]), -columns
    residual = (left - columns @ linear) / balance.weights
    return FittedBalance(balance, x, np.asarray(linear, float), residual, gradient / balance.weights[:, None])


DRAWS = 8
"""Number of simulated repetitions of each circle."""
FEW = 3
"""The same, for the part of a residual due to the encoder."""
SHAPE = 1.6
"""Residual of four parameters over noise and encoder effects, above which the full shape is fitted. Where the shape is
right they leave 1.1 to 1.4 times as much, where it is not 4 to 16. Below it is a tie: four are simpler.
"""


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
            again = voltage_record(_once_more(found, n, rng), record.axis, record)
            records.append(refined(again, *found.truth(n)))
        once = replace(balance, records=tuple(records))
        rest = once.voltage(balance.coordinates.delay(x)) - once.friction(x) - once.columns() @ found.plant
        left.append(rest / balance.weights)
    return left


def explained(found: FittedBalance) -> float:
    """Return the rms of a fit's residual due to noise or to the encoder [V], whichever is larger.

    Noise is the part that does not repeat from turn to turn; the encoder's part is the residual of circles recorded
    again.
    """
    again = [replace(found, residual=left).rms for left in recorded_again(found, FEW)]
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


SMOOTHED = 40.0
"""Corner of the filter over the instruments [Hz]: at 50 Hz 1 % of T_d are left, below 40 they show too little."""
GROWN = 1.02
"""Largest residual of instruments over that of least squares: with more, they are too weak."""


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
    def of(cls, found: FittedBalance) -> Instruments:
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
    p, search, weights = len(found.x), BalanceSearch(found.balance), found.balance.weights
    step = Instruments.of(found).error(weights * found.residual)
    x, plant = found.x + step[:p], found.plant + step[p:]
    moved = replace(found, x=x, plant=plant, residual=(search.left(x) - search.columns @ plant) / weights)
    if not moved.rms < GROWN * found.rms or np.any(np.abs(x) > found.balance.coordinates.bounds):
        return found
    return replace(moved, gradient=np.hstack([search.derivatives(x), -search.columns]) / weights[:, None])


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
    slopes = BalanceSearch(balance).derivatives(x) / balance.weights[:, None]
    lifted = replace(found, balance=balance, x=x, gradient=np.hstack([slopes, found.gradient[:, len(kept.names) :]]))
    step = Instruments.of(lifted).error(balance.weights * lifted.residual)
    return replace(lifted, residual=lifted.residual + lifted.gradient @ step), step


@dataclass(frozen=True)
class TunedEstimates:
    """Friction and plant with their 95 % intervals."""

    # static, negative, gms, plant: parameters by name; ``offset`` is among those of the static map. ``negative`` is the
    # map of the negative direction, where each direction has a map.
    static: dict[str, Estimate]
    negative: dict[str, Estimate] | None
    gms: dict[str, Estimate]
    plant: dict[str, Estimate]
    covariance: Covariance  # Covariance of the logarithms of the fitted parameters
    coordinates: Real  # Covariance of the coordinates that were searched, shape (p, p)

    def at(self, friction: FrictionModel) -> TunedEstimates:
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
        found = self.estimates
        return {} if found is None else {**found.static, **found.gms, **found.plant}
