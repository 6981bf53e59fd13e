"""Refinement: the GMS step replayed along the measured motion, fitted to the measured force, all records at once.

The parameters are those that the data determine one by one, each free of bounds: the logarithms of the slip
displacements, of the ratios of the blocks' limits, of the level where it shows, and of C where a record in sliding
gives it. What each record adds of its own (an offset; in sliding also a slope over velocity, and over acceleration
where no plant is known) enters linearly and is projected out (variable projection: Golub, Pereyra 1973).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import least_squares, nnls
from scipy.special import stdtrit

from fric.friction.gms import GMS
from fric.identify.loops.gms_parameters import Parametrisation
from fric.identify.loops.knots import Blocks

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.friction.stribeck import StaticMap
    from fric.identify.records.motion import Motion

STEP = 1e-4
"""Step of the difference quotients, in logarithms: far above rounding, far below what the data resolve."""

Residual = Callable[..., "NDArray[np.float64]"]


@dataclass(frozen=True)
class Measured:
    """One record to be replayed.

    Parameters
    ----------
    name
        Name of the record.
    motion, force
        The motion, and the friction force along it [N], shape (n,).
    used
        Samples that are fitted, shape (n,).
    period
        Number of the cycle each sample belongs to, shape (n,): the cycles are what is resampled.
    own
        Columns that the record adds of its own, shape (n, m), the first of ones.
    way
        Half of the way since the last reversal [m], infinite in sliding, shape (n,).
    phase
        Number of the part of a cycle each sample belongs to, shape (n,): what the model misses comes again there.
    """

    name: str
    motion: Motion
    force: NDArray[np.float64]
    used: NDArray[np.bool_]
    period: NDArray[np.intp]
    own: NDArray[np.float64]
    way: NDArray[np.float64]
    phase: NDArray[np.intp]

    def replayed(self, model: GMS) -> NDArray[np.float64]:
        """Return the force of the model along the motion [N], shape (n,)."""
        return model.replay(self.motion.time, self.motion.position, self.motion.velocity)

    def fitted(self, model: GMS) -> NDArray[np.float64]:
        """Return the replayed force with what the record adds of its own [N], shape (n,)."""
        replayed = self.replayed(model)
        own, *_ = np.linalg.lstsq(self.own[self.used], (self.force - replayed)[self.used], rcond=None)
        return np.asarray(replayed + self.own @ own)

    def spread(self, model: GMS) -> NDArray[np.float64]:
        """Return the standard deviation of each residual [N] at the samples used: ``σ² = σ_F² + (σ_z·dF/dz)²``.

        What is left of the encoder's steps in the motion is magnified by the stiffness of the blocks that stick
        (effective variance: Orear, Am. J. Phys. 50 (1982) 912). σ_F and σ_z are fitted to the squared residuals.
        """
        residual = (self.force - self.fitted(model))[self.used]
        sticking = self.way[self.used][:, None] < model.slip_displacements
        stiffness = sticking @ np.asarray(model.k)
        size = max(float(stiffness.max()), 1e-300)
        squares = np.column_stack([np.ones(len(residual)), (stiffness / size) ** 2])
        parts, _ = nnls(squares, residual**2)
        floor = 1e-12 * model.static.F_s**2
        return np.asarray(np.sqrt(np.maximum(squares @ parts, max(0.01 * float(np.mean(residual**2)), floor))))


@dataclass(frozen=True)
class _Weighted:
    """A record with the weights of its samples, and an orthonormal basis of what it adds of its own."""

    record: Measured
    weight: NDArray[np.float64]
    basis: NDArray[np.float64]

    @classmethod
    def of(cls, record: Measured, weight: NDArray[np.float64]) -> _Weighted:
        return cls(record, weight, np.asarray(np.linalg.qr(record.own[record.used] * weight[:, None])[0]))

    def residual(self, model: GMS) -> NDArray[np.float64]:
        """Return weighted measured minus replayed force, less what the record adds of its own."""
        rest = (self.record.force - self.record.replayed(model))[self.record.used] * self.weight
        return np.asarray(rest - self.basis @ (self.basis.T @ rest))


@dataclass(frozen=True)
class Refined:
    """The parameters that replay best, and how sure they are.

    Parameters
    ----------
    parametrisation, x
        The parameters.
    resampled
        The parameters with each cycle left out in turn, shape (cycles, p).
    misfit
        The parameters with each part of the cycle a little heavier in turn, shape (parts, p); empty without a replay.
    """

    parametrisation: Parametrisation
    x: NDArray[np.float64]
    resampled: NDArray[np.float64]
    misfit: NDArray[np.float64]

    def intervals(self) -> NDArray[np.float64]:
        """Return 95 % intervals of `Parametrisation.quantities`, shape (q, 2).

        The wider of two: the jackknife over the cycles tells how the drive repeats, and the infinitesimal jackknife
        over the parts of a cycle (the sandwich of White 1982) how much the model misses in the same place each time.
        """
        shape = self.parametrisation
        value = shape.quantities(self.x)
        limits = jackknife(value, np.array([shape.quantities(x) for x in self.resampled]))
        if len(self.misfit) < 2:
            return limits
        moved = np.array([shape.quantities(x) for x in self.misfit]) - value
        reach = stdtrit(len(moved) - 1, 0.975) * np.sqrt(np.sum(moved**2, axis=0))
        reach = np.maximum(reach, 0.5 * (limits[:, 1] - limits[:, 0]))
        return np.stack([value - reach, value + reach], axis=1)

    @property
    def model(self) -> GMS:
        """The model at the level of the records."""
        return self.parametrisation.model(self.x)


def jackknife(value: NDArray[np.float64], left_out: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return 95 % intervals from estimates with one cycle left out each, by Student's t.

    A percentile bootstrap of five cycles covers some 80 %, not 95; the jackknife with t of the number of cycles less
    one does.

    Parameters
    ----------
    value
        The estimates from all cycles, shape (q,).
    left_out
        Those without one cycle each, shape (cycles, q).
    """
    count = len(left_out)
    if count < 2:
        return np.full((len(value), 2), np.nan)
    error = np.sqrt((count - 1) / count * np.sum((left_out - left_out.mean(axis=0)) ** 2, axis=0))
    reach = stdtrit(count - 1, 0.975) * error
    return np.stack([value - reach, value + reach], axis=1)


def refine(
    records: Sequence[Measured],
    blocks: Blocks,
    static: StaticMap,
    *,
    C: float,
    with_C: bool,
    with_level: bool,
) -> Refined:
    """Fit alpha, k and, where asked, C by replay, from the blocks of the virgin curve.

    Nonlinear least squares (scipy's trust region) on the residuals of all records, weighted after a first pass by
    their spread (`Measured.spread`). The estimates without one cycle each are a Gauss–Newton step from the solution.

    Parameters
    ----------
    records
        The records, replayed as they are.
    blocks
        Where to start.
    static
        The static map, whose F_s is the unit of alpha.
    C
        Attraction parameter [N/s]: the start, or kept.
    with_C, with_level
        Whether C and the level of the records are fitted.
    """
    shape = Parametrisation(static, len(blocks), with_level, with_C, C)
    x = shape.pack(blocks)
    least, most = np.full_like(x, -np.inf), np.full_like(x, np.inf)
    least[: len(blocks)], most[: len(blocks)] = _reach(records, blocks)
    x = np.clip(x, least + 1e-6, most - 1e-6)
    weights = [np.ones(int(record.used.sum())) for record in records]
    for _ in range(2):
        weighted = [_Weighted.of(record, weight) for record, weight in zip(records, weights, strict=True)]

        def residual(x: NDArray[np.float64], weighted: list[_Weighted] = weighted) -> NDArray[np.float64]:
            model = shape.model(x)
            return np.concatenate([one.residual(model) for one in weighted])

        def slope(x: NDArray[np.float64], residual: Residual = residual) -> NDArray[np.float64]:
            return _differences(residual, x)

        x = least_squares(residual, x, jac=slope, bounds=(least, most), xtol=1e-6, ftol=1e-8, gtol=1e-12, max_nfev=30).x
        model = shape.model(x)
        weights = [1.0 / record.spread(model) for record in records]
    number = np.concatenate([1000 * n + record.period[record.used] for n, record in enumerate(records)])
    order = np.argsort(shape.model(x).slip_displacements)
    rest, jacobian = residual(x), slope(x)
    resampled = [_sorted(shape, one, order) for one in _left_out(x, rest, jacobian, number)]
    part = np.concatenate([1000 * n + record.phase[record.used] for n, record in enumerate(records)])
    misfit = [_sorted(shape, one, order) for one in _heavier(x, rest, jacobian, part)]
    return Refined(shape, _sorted(shape, x, order), np.array(resampled), np.array(misfit))


def _reach(records: Sequence[Measured], blocks: Blocks) -> tuple[float, float]:
    """Return the least and the greatest slip displacement (logarithms) that the records can tell.

    Below half a step of the encoder a block is stiffer than can be seen; beyond ten times the largest amplitude it
    is softer.
    """
    step = max(record.motion.step for record in records)
    ways = [float(np.ptp(record.motion.position)) for record in records if np.isfinite(record.way).all()]
    least = max(0.5 * step, 1e-4 * min(ways))
    return float(np.log(min(least, 0.5 * blocks.displacement.min()))), float(np.log(10.0 * max(ways)))


def _differences(function: Residual, x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the Jacobian by central differences."""
    columns = []
    for n in range(len(x)):
        up, down = x.copy(), x.copy()
        up[n], down[n] = x[n] + STEP, x[n] - STEP
        columns.append((function(up) - function(down)) / (2 * STEP))
    return np.column_stack(columns)


def _left_out(
    x: NDArray[np.float64], rest: NDArray[np.float64], slope: NDArray[np.float64], number: NDArray[np.intp]
) -> list[NDArray[np.float64]]:
    """Return the parameters with each cycle left out, by one Gauss–Newton step."""
    normal, right = slope.T @ slope, slope.T @ rest
    found = []
    for cycle in np.unique(number):
        part = number == cycle
        J, r = slope[part], rest[part]
        step, *_ = np.linalg.lstsq(normal - J.T @ J, right - J.T @ r, rcond=1e-12)
        found.append(x - step)
    return found


def _heavier(
    x: NDArray[np.float64], rest: NDArray[np.float64], slope: NDArray[np.float64], number: NDArray[np.intp]
) -> list[NDArray[np.float64]]:
    """Return the parameters with each part of the cycle weighed twice, to first order."""
    normal = slope.T @ slope
    scores = [slope[number == part].T @ rest[number == part] for part in np.unique(number)]
    return [x - np.linalg.lstsq(normal, score, rcond=1e-12)[0] for score in scores]


def _sorted(shape: Parametrisation, x: NDArray[np.float64], order: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the parameters with the blocks in another order."""
    logs = np.append(x[shape.count : 2 * shape.count - 1], 0.0)[order]
    return np.concatenate([x[: shape.count][order], logs[:-1] - logs[-1], x[2 * shape.count - 1 :]])
