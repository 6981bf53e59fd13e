"""A record, measured against replayed."""

from dataclasses import dataclass

import numpy as np

from fric.arrays import Mask, Real
from fric.estimate import Estimate
from fric.records.energy import cycle_energies, energy_per_cycle
from fric.records.prepared import Prepared


@dataclass(frozen=True)
class Replay:
    """One record, measured against replayed."""

    record: Prepared  # The record as it was prepared; its ``used`` are the samples that the fit used
    replayed: Real  # The model's force along the motion, with what the record adds of its own [N], shape (n,)
    held_out: Mask  # Samples after the chosen cycles, which the fit did not see, shape (n,)
    own: Real  # What the record adds of its own, in the order of its `Preparation.own`, shape (m,)

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
        """Friction force: what is left of the logged one [N], shape (n,)."""
        return self.record.force

    @property
    def used(self) -> Mask:
        """Samples that the fit used, shape (n,)."""
        return self.record.used

    @property
    def energy(self) -> Estimate | None:
        """Energy lost per cycle [J], of all whole cycles from the first that the fit used; None in sliding."""
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
        """Residual over the samples that the fit did not see [N]; None where there are none."""
        return self._rms(self.held_out) if self.held_out.any() else None

    def _rms(self, chosen: Mask) -> float:
        return float(np.sqrt(np.mean((self.measured - self.replayed)[chosen] ** 2)))
