"""A second mass on a spring behind the motor, as a frequency response shows it."""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from fric.arrays import Complex, Real
from fric.drive.plant import LinearPlant
from fric.verb import require_within

Encoder = Literal["motor", "table"]


@dataclass(frozen=True)
class Resonance:
    """A table on a spring behind the motor, relative to the rigid axis of eq. (1), which holds at low frequency.

    With the shares m_1 = 1 - ratio and m_2 = ratio of the moving mass, spring and damper ``k = ω²·m_1·m_2``,
    ``c = 2·ζ·ω·m_1·m_2`` (ω: the free resonance), and the drive's damping A at the motor,

        Z_1/U = B·(m_2·s² + c·s + k) / D,  Z_2/U = B·(c·s + k) / D,
        D = s·((m_1·s + A)·(m_2·s² + c·s + k) + m_2·s·(c·s + k))

    frequency: free resonance ω/2π of the two masses [Hz]
    ratio: mass of the table over that of both; assumed where the encoder is there [1]
    damping: damping ratio ζ of the resonance [1]
    encoder: where the encoder is: the position is that of the motor (Z_1) or of the table (Z_2)
    """

    frequency: Annotated[float, "frequency"]
    ratio: Annotated[float, "ratio"]
    damping: Annotated[float, "ratio"]
    encoder: Encoder = "motor"

    def __post_init__(self) -> None:
        require_within(self, "the second mass", frequency="(0, inf)", ratio="(0, 1)", damping="[0, inf)")

    def factor(self, A: float, frequency: Real) -> Complex:
        """Return the factor of the second mass on Z/U of eq. (1) with this A [1/s], at frequencies [Hz], shape (n,)."""
        s = 2j * np.pi * np.asarray(frequency, float)
        omega, m1, m2 = 2 * np.pi * self.frequency, 1 - self.ratio, self.ratio
        link = m1 * m2 * omega * (omega + 2 * self.damping * s)
        table = m2 * s**2 + link
        above = table if self.encoder == "motor" else link
        return np.asarray(above * (s + A) / ((m1 * s + A) * table + m2 * s * link))

    def response(self, plant: LinearPlant, frequency: Real, hold: float | None) -> Complex:
        """Return Z/U [m/V], continuous, or from sample to sample behind a zero-order hold.

        The images of a sampled response are far above the resonance, where the factor is 1/m_1 of the motor and 0 of
        the table: they are taken from the rigid axis, which is sampled exactly.

        hold: Sampling rate of the hold [Hz], None for the continuous response.
        """
        factor = self.factor(plant.A, frequency)
        if hold is None:
            return plant.response(frequency) * factor
        far = 1 / (1 - self.ratio) if self.encoder == "motor" else 0.0
        base = np.sinc(np.asarray(frequency) / hold) * plant.response(frequency)
        return far * plant.response(frequency, hold) + (factor - far) * base
