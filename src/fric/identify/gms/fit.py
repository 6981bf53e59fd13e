"""An identified GMS model, with the records that it was identified from."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fric.arrays import Mask, Real
from fric.estimate import Covariance, Estimate
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.identify.gms.knots import Blocks, Choice
from fric.identify.gms.virgin_curve import HysteresisCycles, VirginCurve
from fric.notice import Notice
from fric.records.judgement import cycle_energies, energy_per_cycle
from fric.records.prepared import Prepared
from fric.units import Motion


@dataclass(frozen=True)
class Replay:
    """One record, measured against replayed."""

    record: Prepared  # The record as it was prepared; its ``used`` are the samples that the fit used
    replayed: Real  # The model's force along the motion, with the terms of the record [N], shape (n,)
    held_out: Mask  # Samples after the chosen cycles, which the fit did not see, shape (n,)
    own: Real  # Coefficients of the terms of the record, in the order of `Preparation.own`, shape (m,)

    @property
    def name(self) -> str:
        """Name of the record."""
        return self.record.name

    @property
    def kind(self) -> str:
        """``presliding`` or ``sliding``."""
        return "sliding" if self.record.slides else "presliding"

    @property
    def time(self) -> Real:
        """Instants [s], shape (n,)."""
        return self.record.motion.time

    @property
    def position(self) -> Real:
        """Motion [m], shape (n,)."""
        return self.record.motion.position

    @property
    def measured(self) -> Real:
        """Friction force: the logged force less inertia and damping [N], shape (n,)."""
        return self.record.force

    @property
    def used(self) -> Mask:
        """Samples that the fit used, shape (n,)."""
        return self.record.used

    @property
    def energy(self) -> Estimate | None:
        """Energy lost per cycle [J], over all whole cycles from the first one in the fit; None in sliding."""
        if self.record.slides:
            return None
        reversals = self.record.reversals[self.record.reversals >= int(np.argmax(self.used))]
        return energy_per_cycle(cycle_energies(self.position, self.measured, reversals))

    @property
    def rmse(self) -> float:
        """Residual over the samples used [N]."""
        return self._rms(self.used)

    @property
    def rmse_held_out(self) -> float | None:
        """Residual over held-out samples [N]; None without any."""
        return self._rms(self.held_out) if self.held_out.any() else None

    def _rms(self, chosen: Mask) -> float:
        return float(np.sqrt(np.mean((self.measured - self.replayed)[chosen] ** 2)))


@dataclass(frozen=True)
class GMSFit:
    """An identified GMS model, and the records that it was identified from."""

    axis: str  # axis, motion: the axis
    motion: Motion
    static: StaticMap  # The static map whose F_s is the unit of alpha; F_c = F_s at the plateau where none was given
    static_given: bool  # False where the plateau replaces a static map
    alpha: Estimate  # alpha, k, C: the parameters, one value a block in the order of slip displacements
    k: Estimate
    C: Estimate
    alpha_sum: Estimate  # Σ alpha before it was normalised: the level of the records relative to the static map
    # curve, hysteresis, blocks: the measured virgin curve, the records it is from, and the piecewise-linear fit
    curve: VirginCurve
    hysteresis: tuple[HysteresisCycles, ...]
    blocks: Blocks
    choice: Choice | None  # How the number of blocks was chosen; None where the user gave it
    asked: int | None  # Number of blocks that the user requested; None where the criterion chose it
    knots_given: bool  # knots_given, refined: true where the user gave the knots; where the parameters are from replay
    refined: bool
    records: tuple[Replay, ...]  # Each record, measured against replayed
    covariance: Covariance | None  # Covariance of the parameters; None where they were not refined by replay
    # Standard deviation of the ``level`` [1] and the ``offset`` [N] of records, where seen
    between_records: Mapping[str, Estimate]
    warnings: tuple[Notice, ...]  # Warnings: what the data do not determine

    @property
    def model(self) -> GMS:
        """The model for output: alpha sums to 1, and F_s is that of the static map."""
        assert isinstance(self.alpha.value, tuple)
        assert isinstance(self.k.value, tuple)
        return GMS(self.static, self.alpha.value, self.k.value, float(self.C))

    @property
    def rmse(self) -> float:
        """Residual over all samples used [N]."""
        rest = [(record.measured - record.replayed)[record.used] for record in self.records]
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
        """Reason for the number of blocks, in a sentence."""
        count = len(self.blocks)
        if self.choice is not None:
            return self.choice.reason
        if self.asked in {None, count}:
            return f"{count} blocks, as the user said"
        return f"{count} blocks: of the {self.asked} that were asked for, the others would have no stiffness"

    @property
    def method(self) -> str:
        """Method of identification, in a line."""
        start = (
            "concave piecewise-linear virgin curve" if self.choice or not self.knots_given else "eq. (6) at given knots"
        )
        refined = ", refined by replay of all records" if self.refined else ""
        return f"{start}{refined}; intervals by leaving out cycles, and by misfit that comes again"
