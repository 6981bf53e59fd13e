"""Eq. (1) as a sampling controller sees it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fric.arrays import Complex, Real
from fric.drive.plant import LinearPlant


@dataclass(frozen=True)
class SampledPlant:
    """Eq. (1) behind a zero-order hold, sampled: x[n+1] = Phi x[n] + late·u[n−whole−1] + early·u[n−whole]."""

    Phi: Real  # State matrix of [position, velocity], shape (2, 2)
    late: Real  # late, early: the effect of the older and of the newer of two inputs on a sample, each of shape (2,)
    early: Real
    whole: int  # Whole samples of transport delay

    @classmethod
    def of(cls, plant: LinearPlant, sampling: float) -> SampledPlant:
        """Return the plant sampled at a rate [Hz]; raise `FricError` where T_d is shorter than half a sample."""
        T_s = 1.0 / sampling
        delay = plant.transport_delay(sampling)
        whole = int(delay / T_s + 1e-9)
        share = max(delay - whole * T_s, 0.0)
        Phi, _ = plant.held(T_s)
        Phi_early, early = plant.held(T_s - share)
        _, late = plant.held(share)
        moved = Phi_early[:, 0] * late[0] + Phi_early[:, 1] * late[1]  # sums in this order, on every processor
        return cls(Phi, moved, early, whole)

    def response(self, frequency: Real, sampling: float) -> Complex:
        """Return Z/U from sample to sample [m/V], shape (n,), at frequencies [Hz], shape (n,)."""
        step = np.expm1(2j * np.pi * np.asarray(frequency, float) / sampling)  # z − 1, exact at low frequencies
        z = 1.0 + step
        position, velocity = (self.early[i] + self.late[i] / z for i in (0, 1))
        kept = 1.0 - self.Phi[1, 1]
        return np.asarray(z**-self.whole * (position + self.Phi[0, 1] * velocity / (step + kept)) / step)
