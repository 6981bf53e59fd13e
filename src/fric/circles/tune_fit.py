"""The belief that explains the voltages of recorded circles: least squares with the plant eliminated."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fric.arrays import Real
from fric.circles.nominal import Coordinates
from fric.circles.voltage import COMPARED, VoltageRecord

STARTS = ((0.74, 1.0), (0.5, 2.7), (1.2, 0.22))
"""Stiffness and C, as shares of the nominal values, at which the search begins."""
LONGEST = 0.7
"""Longest step of the search, in the logarithm."""
STEP = 4e-3
"""Step of the derivatives, in the logarithm."""
NOISE = 0.5e-3
"""Voltage that a residual is weighed against the priors with, at least [V]."""


@dataclass(frozen=True)
class Balance:
    """Voltages of one axis over some circles: ``W[u(t - T_d)] = m·W[z̈] + a·W[ż] + o + W[F]/K_f``.

    The plant's m = 1/B and a = A/B, and an offset o of each circle, are linear and eliminated.
    """

    records: tuple[VoltageRecord, ...]  # The circles
    coordinates: Coordinates  # What is searched
    K_f: float  # Force constant that the controller believes [N/V]: friction and it are not told apart, so it is kept

    @property
    def weights(self) -> Real:
        """Weight of a sample of each circle, so that every circle counts alike, shape (circles,)."""
        lengths = np.array([np.count_nonzero(record.used) for record in self.records], float)
        return np.sqrt(lengths.sum() / len(lengths) / lengths)

    def columns(self) -> Real:
        """Return acceleration, velocity and the offsets of all circles, weighed, shape (n, 2 + circles)."""
        rows = []
        for n, (record, weight) in enumerate(zip(self.records, self.weights, strict=True)):
            own = np.zeros((np.count_nonzero(record.used), len(self.records)))
            own[:, n] = 1.0
            rows.append(weight * np.column_stack([record.inertia[record.used], record.damping[record.used], own]))
        return np.vstack(rows)

    def friction(self, x: Real) -> Real:
        """Return the voltage of friction, weighed, at a point, shape (n,)."""
        model = self.coordinates.directed(x)
        parts = [w / self.K_f * r.friction(model) for r, w in zip(self.records, self.weights, strict=True)]
        return np.concatenate(parts)

    def voltage(self, x: Real) -> Real:
        """Return the control voltage as it acts, weighed, at a point, shape (n,)."""
        T_d = self.coordinates.delay(x)
        return np.concatenate([w * r.delayed(T_d) for r, w in zip(self.records, self.weights, strict=True)])


@dataclass(frozen=True)
class Fitted:
    """What a search found."""

    balance: Balance  # What was balanced
    x: Real  # The point found, shape (p,)
    plant: Real  # m [V·s²/m], a [V·s/m], and the offset of each circle [V]
    residual: Real  # What is left at each sample used, circle after circle, not weighed [V]
    gradient: Real  # Its derivatives by x, then by the plant's parameters, shape (n, p + 2 + circles)

    @property
    def rms(self) -> float:
        """Root mean square of what is left, every circle counting alike [V]."""
        return float(np.sqrt(np.mean([np.mean(part**2) for part in self.parts()])))

    def parts(self) -> list[Real]:
        """Return what is left of each circle [V]."""
        lengths = [int(np.count_nonzero(record.used)) for record in self.balance.records]
        return np.split(self.residual, np.cumsum(lengths)[:-1])

    def noise(self) -> float | None:
        """Return the root mean square of what does not repeat from turn to turn [V]; None where no circle tells it."""
        known = [
            own
            for record, part in zip(self.balance.records, self.parts(), strict=True)
            if (own := record.repeating(part)) is not None
        ]
        return float(np.sqrt(np.mean(np.square(known)))) if known else None


class Search:
    """Residuals and derivatives of a balance, with what is linear projected out."""

    def __init__(self, balance: Balance, sigma: float) -> None:
        self.balance = balance
        self.columns = balance.columns()
        self.basis = np.linalg.qr(self.columns)[0]
        rate = float(np.mean([record.rate for record in balance.records]))
        # neighbouring samples behind the filter are alike: the residual counts as so many independent values
        self.scale = 1.0 / (sigma * np.sqrt(max(rate / (2 * COMPARED), 1.0)))
        self.priors = balance.coordinates.priors
        self._last: tuple[bytes, Real] | None = None
        self._late: tuple[float, Real] | None = None

    def left(self, x: Real) -> Real:
        """Return the voltage less that of friction, weighed."""
        return self._voltage(x) - self._friction(x)

    def _voltage(self, x: Real) -> Real:
        T_d = self.balance.coordinates.delay(x)
        if self._late is None or self._late[0] != T_d:
            self._late = (T_d, self.balance.voltage(x))
        return self._late[1]

    def _friction(self, x: Real) -> Real:
        key = x.tobytes()
        if self._last is None or self._last[0] != key:
            self._last = (key, self.balance.friction(x))
        return self._last[1]

    def cost(self, x: Real) -> float:
        """Return half the sum of the squared residuals and priors, in units of their standard deviation."""
        left = self.scale * self.left(x)
        along = self.basis.T @ left
        return 0.5 * float(left @ left - along @ along + np.sum((x / self.priors) ** 2))

    def derivatives(self, x: Real) -> Real:
        """Return the derivatives of `left`."""
        balance, voltage, friction = self.balance, self._voltage(x), self._friction(x)
        found = np.empty((len(voltage), len(x)))
        for n, name in enumerate(balance.coordinates.names):
            moved = x.copy()
            moved[n] += STEP
            if name == "T_d":
                found[:, n] = (balance.voltage(moved) - voltage) / STEP
            else:
                found[:, n] = (friction - balance.friction(moved)) / STEP
        return found

    def normal(self, x: Real) -> tuple[Real, Real]:
        """Return the gradient of `cost`, and its second derivatives by Gauss and Newton."""
        left, J = self.scale * self.left(x), self.scale * self.derivatives(x)
        along = self.basis.T @ J
        gradient = J.T @ left - along.T @ (self.basis.T @ left) + x / self.priors**2
        return gradient, J.T @ J - along.T @ along + np.diag(1.0 / self.priors**2)


def fit(balance: Balance, starts: Sequence[Real], sigma: float = NOISE, most: int = 12) -> Fitted:
    """Return the least-squares point of a balance with its priors, from the best of some starts.

    balance: What is balanced.
    starts: Points to start from, each of shape (p,); all are searched coarsely, and the best to the end.
    sigma: Standard deviation that a sample is weighed against the priors with [V].
    most: Steps at most.
    """
    search = Search(balance, max(sigma, NOISE))
    few = most if len(starts) == 1 else 7
    best = min((_searched(search, np.asarray(x, float), few) for x in starts), key=search.cost)
    return at(balance, best if len(starts) == 1 else _searched(search, best, most))


def _searched(search: Search, x: Real, steps: int) -> Real:
    """Return the point that so many steps of Levenberg and Marquardt lead to within the bounds."""
    bounds = search.balance.coordinates.bounds
    x = np.clip(x, -0.99 * bounds, 0.99 * bounds)
    damping, cost = 1e-2, search.cost(x)
    gradient, curvature = search.normal(x)
    for _ in range(steps):
        damped = curvature + damping * np.diag(np.diag(curvature))
        further = np.clip(x + np.clip(np.linalg.solve(damped, -gradient), -LONGEST, LONGEST), -bounds, bounds)
        new = search.cost(further)
        if new < cost:
            fallen, moved = cost - new, np.abs(further - x).max()
            x, cost, damping = further, new, max(damping / 8, 1e-7)
            if fallen < max(1e-4 * cost, 0.05) or moved < 1e-4:
                break
            gradient, curvature = search.normal(x)
        elif np.abs(further - x).max() < 1e-4:
            break
        else:
            damping *= 10
    return x


def at(balance: Balance, x: Real, plant: Real | None = None) -> Fitted:
    """Return what is left at a point, with the plant that fits best there, or with one that is given (its offsets fit).

    balance: What is balanced.
    x: The point, shape (p,).
    plant: m [V·s²/m] and a [V·s/m] that are kept.
    """
    search = Search(balance, NOISE)
    left, columns = search.left(x), search.columns
    if plant is None:
        linear = np.linalg.lstsq(columns, left, rcond=None)[0]
        gradient = np.hstack([search.derivatives(x), -columns])
    else:
        offsets = np.linalg.lstsq(columns[:, 2:], left - columns[:, :2] @ plant, rcond=None)[0]
        linear, gradient = np.concatenate([plant, offsets]), -columns
    lengths = [int(np.count_nonzero(record.used)) for record in balance.records]
    weights = np.repeat(balance.weights, lengths)
    return Fitted(
        balance, x, np.asarray(linear, float), (left - columns @ linear) / weights, gradient / weights[:, None]
    )
