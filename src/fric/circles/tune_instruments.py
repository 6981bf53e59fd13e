"""Inertia and delay without what encoder counts pull them by: instrumental variables.

Counts are noise in z̈, and the loop makes voltage of them: regressors and residual share it, and least squares takes
it for less inertia and more delay (median 0.05 % of B and 4 % of T_d on drawn machines). Instruments Z that do not hold
it leave nothing of that: ``Zᵀ·r = 0`` in place of ``Jᵀ·r = 0`` (Söderström and Stoica, Instrumental variable methods
for system identification, 1983). Here Z is J with the columns of z̈ and of T_d smoothed further: counts are noise whose
power rises with the fifth power of the corner, and the motion lies below.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fric.arrays import Real
from fric.circles.motion import low_pass
from fric.circles.tune_fit import NOISE, Fitted, Search
from fric.circles.voltage import COMPARED

SMOOTHED = 40.0
"""Corner of the filter over the instruments [Hz]: at 50 Hz 1 % of T_d are left, below 40 they tell too little."""
GROWN = 1.02
"""Times what least squares leave that instruments may leave at most: with more they are too weak."""


@dataclass(frozen=True)
class Instruments:
    """Instruments about a fit, and what they weigh."""

    # Z, J: instruments and derivatives, every circle counting alike, shape (n, p + 2 + circles)
    Z: Real
    J: Real
    weights: Real  # Weight of each sample, shape (n,)
    prior: Real  # Curvature of the priors, shape (p + 2 + circles,)
    power: float  # Variance of a sample that stands for itself [V²]

    @classmethod
    def of(cls, found: Fitted) -> Instruments:
        """Return the instruments about a fit."""
        from scipy.signal import sosfiltfilt

        coordinates, p = found.balance.coordinates, len(found.x)
        parts = found.parts()
        weights = np.repeat(found.balance.weights, [len(part) for part in parts])
        J = weights[:, None] * found.gradient
        Z, start = J.copy(), 0
        shared = [coordinates.names.index("T_d"), p]
        for record, part in zip(found.balance.records, parts, strict=True):
            own = slice(start, start + len(part))
            Z[own, shared] = sosfiltfilt(low_pass(SMOOTHED, record.rate), J[own][:, shared], axis=0)
            start += len(part)
        rate = float(np.mean([record.rate for record in found.balance.records]))
        power = max(found.rms, NOISE) ** 2 * max(rate / (2 * COMPARED), 1.0)
        prior = np.zeros(J.shape[1])
        prior[:p] = power / coordinates.priors**2
        return cls(Z, J, weights, prior, power)

    def error(self, residual: Real) -> Real:
        """Return how far coordinates and plant are found off where the truth leaves a residual [V], shape (n,)."""
        return self.solved(self.Z.T @ (self.weights * residual))

    def solved(self, scores: Real) -> Real:
        """Return ``-(ZᵀJ + P)⁻¹`` times scores."""
        crossed = self.Z.T @ self.J + np.diag(self.prior)
        size = np.sqrt(np.diag(self.J.T @ self.J) + self.prior)
        size[size == 0] = 1.0
        scaled = np.linalg.lstsq(crossed / np.outer(size, size), -(scores.T / size).T, rcond=1e-12)[0]
        return np.asarray((scaled.T / size).T)


def instrumented(found: Fitted) -> Fitted:
    """Return a fit moved to where its instruments see no residual; as it is, where they tell too little for that."""
    p, search = len(found.x), Search(found.balance, NOISE)
    of = Instruments.of(found)
    step = of.error(found.residual)
    x, plant = found.x + step[:p], found.plant + step[p:]
    left = search.left(x) - search.columns @ plant
    moved = replace(found, x=x, plant=plant, residual=left / of.weights)
    if not moved.rms < GROWN * found.rms or np.any(np.abs(x) > found.balance.coordinates.bounds):
        return found
    gradient = np.hstack([search.derivatives(x), -search.columns])
    return replace(moved, gradient=gradient / of.weights[:, None])


def whole(found: Fitted) -> Fitted:
    """Return a fit in the coordinates of the whole shape: the point found, and what the whole shape leaves from there.

    Whether four parameters or the whole shape is kept may hang on little, and how sure the parameters are must not hang
    on that. What is left is that of the step of the whole shape's fit, to first order: what four parameters leave
    besides is no noise.
    """
    kept = found.balance.coordinates
    shape = kept.full().sided() if "side" in kept.names else kept.full()
    if shape.names == kept.names:
        return found
    balance = replace(found.balance, coordinates=shape)
    x, weights = shape.moved(kept, found.x), np.repeat(balance.weights, [len(part) for part in found.parts()])
    own = Search(balance, NOISE).derivatives(x) / weights[:, None]
    lifted = replace(found, balance=balance, x=x, gradient=np.hstack([own, found.gradient[:, len(kept.names) :]]))
    step = Instruments.of(lifted).error(lifted.residual)
    return replace(lifted, residual=lifted.residual + lifted.gradient @ step)
