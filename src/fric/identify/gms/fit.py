"""An identified GMS model, with what it was seen in."""

from dataclasses import dataclass

import numpy as np

from fric.estimate import Covariance, Estimate
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.identify.gms.cycles import HysteresisCycles
from fric.identify.gms.knots import Blocks, Choice
from fric.identify.gms.virgin_curve import VirginCurve
from fric.identify.replay.measured import Replay
from fric.notice import Notice
from fric.units import Motion


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
    curve, hysteresis, blocks
        The measured virgin curve, the records it is from, and the piecewise-linear fit.
    choice
        How the number of blocks was chosen; None where the user said it.
    asked
        Number of blocks that the user asked for; None where it was left to the criterion.
    knots_given, refined
        True where the user gave the knots; where the parameters are from replay.
    records
        Each record, measured against replayed.
    covariance
        How the parameters err together; None where they were not refined by replay.
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
    hysteresis: tuple[HysteresisCycles, ...]
    blocks: Blocks
    choice: Choice | None
    asked: int | None
    knots_given: bool
    refined: bool
    records: tuple[Replay, ...]
    covariance: Covariance | None
    warnings: tuple[Notice, ...]

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
        refined = ", refined by replay of all records" if self.refined else ""
        return f"{start}{refined}; intervals by leaving out cycles, and by misfit that comes again"
