"""An identified GMS model, with what it was seen in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fric.estimate import Estimate
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.identify.loops.knots import Blocks, Choice
from fric.identify.loops.loops import Loops
from fric.identify.loops.virgin_curve import VirginCurve
from fric.units import Motion

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Shares:
    """What inertia and linear damping take of the force of a record; None where no plant is known.

    Parameters
    ----------
    name
        Name of the record.
    inertia, damping
        Size of each (99 % quantile) relative to that of the logged force.
    """

    name: str
    inertia: float | None = None
    damping: float | None = None


@dataclass(frozen=True)
class Replayed:
    """One record, measured against replayed.

    Parameters
    ----------
    name, kind
        Name of the record, and ``presliding`` or ``sliding``.
    time, position
        Instants [s] and motion [m], shape (n,).
    measured, replayed
        Friction force [N]: what is left of the logged one, and the model's along the motion, shape (n,).
    used
        Samples that the fit used, shape (n,).
    held_out
        Samples after the chosen cycles, which the fit did not see, shape (n,).
    """

    name: str
    kind: str
    time: NDArray[np.float64]
    position: NDArray[np.float64]
    measured: NDArray[np.float64]
    replayed: NDArray[np.float64]
    used: NDArray[np.bool_]
    held_out: NDArray[np.bool_]

    @property
    def rmse(self) -> float:
        """Residual over the samples used [N]."""
        return float(np.sqrt(np.mean((self.measured - self.replayed)[self.used] ** 2)))

    @property
    def rmse_held_out(self) -> float | None:
        """Residual over the samples that the fit did not see [N]; None where there are none."""
        if not self.held_out.any():
            return None
        return float(np.sqrt(np.mean((self.measured - self.replayed)[self.held_out] ** 2)))


@dataclass(frozen=True)
class GMSFit:
    """An identified GMS model, and what it was seen in.

    Parameters
    ----------
    axis, motion
        The axis.
    static
        The static map whose F_s is the unit of alpha; F_c = F_s at the plateau where none was given.
    static_given
        False where the plateau stands in for a static map.
    alpha, k, C
        The parameters, one value a block in the order of slip displacements.
    alpha_sum
        Σ alpha before it was normalised: the level of the records relative to the static map.
    curve, loops, blocks
        The measured virgin curve, the records it is from, and the piecewise-linear fit.
    choice
        How the number of blocks was chosen; None where the user said it.
    asked
        Number of blocks that the user asked for; None where it was left to the criterion.
    knots_given, refined
        True where the user gave the knots; where the parameters are from replay.
    records
        Each record, measured against replayed.
    shares
        What inertia and linear damping take of the force, by record.
    warnings
        What the data cannot tell.
    """

    axis: str
    motion: Motion
    static: StaticMap
    static_given: bool
    alpha: Estimate
    k: Estimate
    C: Estimate
    alpha_sum: Estimate
    curve: VirginCurve
    loops: tuple[Loops, ...]
    blocks: Blocks
    choice: Choice | None
    asked: int | None
    knots_given: bool
    refined: bool
    records: tuple[Replayed, ...]
    shares: tuple[Shares, ...]
    warnings: tuple[str, ...]

    @property
    def model(self) -> GMS:
        """The model as it is written: alpha sums to 1, and F_s is that of the static map."""
        assert isinstance(self.alpha.value, tuple)
        assert isinstance(self.k.value, tuple)
        return GMS(self.static, self.alpha.value, self.k.value, float(self.C))

    @property
    def rmse(self) -> float:
        """Residual over all samples used [N]."""
        rest = [(one.measured - one.replayed)[one.used] for one in self.records]
        return float(np.sqrt(np.mean(np.concatenate(rest) ** 2)))

    @property
    def curve_rmse(self) -> float:
        """Misfit of the model to the measured virgin curve, over equal steps of displacement [N]."""
        z = np.linspace(0.0, float(self.curve.displacement[-1]), 501)[1:]
        level = float(self.alpha_sum) if self.static_given else 1.0
        found = Blocks(np.asarray(self.k.value), self.model.slip_displacements * level)
        return float(np.sqrt(np.mean((self.curve(z) - found(z)) ** 2)))

    @property
    def reason(self) -> str:
        """Why there are as many blocks as there are, in one sentence."""
        count = len(self.blocks)
        if self.choice is not None:
            return self.choice.reason
        if self.asked in {None, count}:
            return f"{count} blocks, as the user said"
        return f"{count} blocks: of the {self.asked} that were asked for, the others would have no stiffness"

    @property
    def method(self) -> str:
        """How it was found, in one line."""
        start = (
            "concave piecewise-linear virgin curve" if self.choice or not self.knots_given else "eq. (6) at given knots"
        )
        return (
            start + (", refined by replay of all records" if self.refined else "") + "; intervals by leaving out cycles"
        )
