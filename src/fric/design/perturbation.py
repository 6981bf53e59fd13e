"""What the nominal plant leaves out: the multiplicative perturbation Delta of eq. (7), and how far it lets Q reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from fric.arrays import Complex, Real
from fric.control.q_filter import QFilter
from fric.drive.plant import LinearPlant
from fric.errors import FricError
from fric.log import FrequencyResponse

CIRCLE_95 = float(np.sqrt(-2 * np.log(0.05)))
"""Radius of the circle that holds 95 % of a complex normal error, over the deviation of its real and imaginary part."""
SURE = 0.5
"""Radius below which a line without any perturbation has |Delta| and its confidence below 1: |Delta| is in it, too."""


@dataclass(frozen=True)
class StructuralMode:
    """A structural mode that eq. (1) does not have: it takes G to G·(1 + share·s²/(s² + 2ζωs + ω²)).

    Raises FricError: When it is no damped resonance.
    """

    frequency: float  # ω/2π [Hz]
    damping: float  # ζ, below 1
    # Mobility over that of the rigid body, at the encoder: positive where encoder and motor move in phase
    share: float = 1.0

    def __post_init__(self) -> None:
        if not (self.frequency > 0 and 0 < self.damping < 1 and self.share != 0):
            raise FricError(
                f"{self.frequency:g} Hz with damping {self.damping:g} and share {self.share:g} is no resonance",
                hint="Give a positive frequency, a damping between 0 and 1, and a share other than 0.",
            )

    def response(self, frequency: Real) -> Complex:
        """Return share·s²/(s² + 2ζωs + ω²) at frequencies [Hz], shape (n,)."""
        s = 1j * np.asarray(frequency, float) / self.frequency
        return np.asarray(self.share * s**2 / (s**2 + 2 * self.damping * s + 1))


@dataclass(frozen=True)
class Perturbation:
    """Delta = (G_m − G_n)/G_n, eq. (7), of an axis: measured, or of a model with what is known to be unmodelled."""

    frequency: Real  # Frequencies [Hz], increasing, shape (n,)
    Delta: Complex  # The perturbation of G_n = B/(s(s + A)), shape (n,)
    radius: Real  # Radius of the 95 % confidence circle of Delta, shape (n,); 0 for a model
    ratio: Complex  # G_m over eq. (1) with its delay, shape (n,): dynamics not modelled, without delay and hold.
    measured: bool  # True where it comes from a measured response

    @property
    def size(self) -> Real:
        """|Delta| with its confidence taken in, shape (n,)."""
        return np.abs(self.Delta) + self.radius

    def sure(self) -> Perturbation:
        """Return it by the lines alone that are known well, to `SURE` of G_n."""
        kept = self.radius < SURE
        parts = (self.frequency[kept], self.Delta[kept], self.radius[kept], self.ratio[kept])
        return Perturbation(*parts, measured=self.measured)

    def correction(self, frequency: Real) -> Complex:
        """Return ``ratio`` between its frequencies, linearly; 1 beyond them. Shape (n,)."""
        if not self.frequency.size:
            return np.ones(np.shape(frequency), complex)
        real = np.interp(frequency, self.frequency, self.ratio.real, left=1.0, right=1.0)
        return real + 1j * np.interp(frequency, self.frequency, self.ratio.imag, left=0.0, right=0.0)


def model_perturbation(plant: LinearPlant, nyquist: float, resonances: Sequence[StructuralMode] = ()) -> Perturbation:
    """Return Delta of a model: the plant's delay, and resonances where some are known.

    plant: Eq. (1), of which G_n is all but the delay.
    nyquist: Highest frequency [Hz].
    resonances: Structural modes that eq. (1) does not have.
    """
    f = np.geomspace(nyquist * 1e-4, nyquist, 20_000)
    for mode in resonances:  # a peak is 2ζ wide
        around = mode.frequency * (1 + mode.damping * np.linspace(-10, 10, 2001))
        f = np.union1d(f, around[(around > 0) & (around < nyquist)])
    ratio = np.ones(f.size, np.complex128)
    for mode in resonances:
        ratio += mode.response(f)
    Delta = ratio * np.exp(-2j * np.pi * f * plant.T_d) - 1.0
    return Perturbation(f, Delta, np.zeros(f.size), ratio, measured=False)


def measured_perturbation(
    response: FrequencyResponse,
    plant: LinearPlant,
    averages: int = 1,
    sampling: float | None = None,
    lowest: float = 0.0,
) -> Perturbation:
    """Return Delta from a measured response.

    response: The measured response Z/U, hold of the controller's output included.
    plant: Eq. (1) as it was fitted; its A and B are those of G_n.
    averages: Records that the coherence was averaged over.
    sampling: Sampling rate [Hz] of a response that was measured from sample to sample of the controller, hold and
        images in it; None for a response in continuous time.
    lowest: Lowest frequency at which the response shows the plant [Hz]: lines below it, and those below the first
        reliable line, are left out.
    """
    f = response.frequency
    G_m = response.magnitude * np.exp(1j * response.phase)
    s = 2j * np.pi * f
    G_n = plant.B / (s * (s + plant.A))
    deviation = response.relative_deviation(averages)
    radius = CIRCLE_95 * (np.zeros(f.size) if deviation is None else deviation) * np.abs(G_m / G_n)
    sure = np.flatnonzero((radius < SURE) & (f >= lowest * (1 - 1e-9)))
    if sure.size:  # below the first reliable line, where friction hides the response, it does not show the plant
        f, G_m, G_n, radius = (values[sure[0] :] for values in (f, G_m, G_n, radius))
    expected = plant.response(f, sampling)
    return Perturbation(f, G_m / G_n - 1.0, radius, G_m / expected, measured=True)


@dataclass(frozen=True)
class RobustLimit:
    """How far Q may reach by eq. (8)."""

    q: QFilter | None  # Q at the limit; None where no frequency limits it
    frequency: float  # The frequency that limits it [Hz]
    size: float  # |Delta| there, with its confidence


def robust_limit(perturbation: Perturbation, filter: str = "binomial2") -> RobustLimit:
    """Return the largest Q for which |T·Delta| ≤ 1 at every frequency, eq. (8), and no smaller Q exceeds it either.

    For the nominal plant T = Q: the inner loop L = Q/(1 − Q) gives T = L/(1 + L) = Q, for any shape. At a
    frequency f with |Delta| = D > 1/max|Q| the condition is f ≥ r·cutoff, where r is the last place, in units of the
    cutoff, with |Q(r)| = 1/D; the limit is the smallest f/r of all.

    perturbation: Delta with its confidence.
    """
    shape = QFilter(filter, 1.0)
    r = np.geomspace(1e-3, 1e3, 6001)
    magnitude = np.abs(shape.response(r))
    top = float(r[int(np.argmax(magnitude))])
    level = 1.0 / np.maximum(perturbation.size, 1e-300)
    bound = level < magnitude.max()
    if not bound.any():
        return RobustLimit(None, inf, float(perturbation.size.max()))
    f, level = perturbation.frequency[bound], level[bound]
    low, high = np.full(f.size, top), np.full(f.size, 1e6)  # |Q| falls from its top on
    for _ in range(100):
        middle = np.sqrt(low * high)
        above = np.abs(shape.response(middle)) > level
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    at = int(np.argmin(f / high))
    return RobustLimit(QFilter(filter, float(f[at] / high[at])), float(f[at]), float(1.0 / level[at]))
