"""What the models of several slip blocks on a static map share: the blocks' shares and stiffnesses."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from fric.arrays import Real
from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction.base import Parameter
from fric.friction.stribeck import OnStaticMap


@dataclass(frozen=True)
class OnBlocks(OnStaticMap):
    """A model of N slip blocks that carry shares of the Stribeck level.

    static: The static map: F_c, F_s, v_s, delta, sigma.
    alpha: Each block's share, shape (N,), Σ alpha = 1 [1].
    k: Each block's stiffness, shape (N,) [N/m].
    Raises FricError: When alpha is negative or does not sum to 1, when k is not positive, or the lengths differ.
    """

    alpha: tuple[float, ...]
    k: tuple[float, ...]

    block_parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter(
            "alpha",
            "ratio",
            upper=1.0,
            doc="share of the Stribeck level",
            per_block=True,
            typical=(0.6, 0.3, 0.1),
            shares=True,
        ),
        Parameter("k", "stiffness", doc="stiffness of the block", per_block=True, typical=(1e8, 2e6, 2e5)),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.alpha or len(self.alpha) != len(self.k):
            raise FricError(
                f"{self.name} has {len(self.alpha)} alpha and {len(self.k)} k", hint="Give one of each for every block."
            )
        if not (min(self.alpha) >= 0 and abs(sum(self.alpha) - 1) <= 1e-5):  # six digits each
            raise FricError(
                f"alpha of {self.name} is {', '.join(f'{a:g}' for a in self.alpha)}, which sums to {sum(self.alpha):g}",
                hint="The shares of the blocks are 0 or more and sum to 1.",
            )
        if not all(k > 0 for k in self.k):
            raise FricError(f"k of {self.name} must be positive")

    @classmethod
    def from_sections(cls, sections: Mapping[str, Mapping[str, Estimate]]) -> Self:
        """Return the model that a friction file gives, with alpha normalised where it is rounded.

        A sum of alpha within 1 % of 1 is rounding (Table 1 of the paper sums to 1.002); more is refused.
        """
        fields = cls.fields_from(sections)
        total = sum(fields["alpha"])
        if abs(total - 1) <= 0.01:
            fields["alpha"] = tuple(a / total for a in fields["alpha"])
        return cls(**fields)

    @property
    def slip_displacements(self) -> Real:
        """Displacement from rest at which each block slips, ``alpha_i·F_s/k_i`` [m], shape (N,)."""
        return np.asarray(self.alpha) * self.static.F_s / np.asarray(self.k)

    def virgin_curve(self, z: Real | float) -> Real:
        """Return the force [N] of a relaxed contact that is slowly moved by z [m], ``Σ min(k_i·z, alpha_i·F_s)``."""
        z = np.asarray(z, float)[..., np.newaxis]
        limit = np.asarray(self.alpha) * self.static.F_s
        return np.asarray(np.clip(np.asarray(self.k) * z, -limit, limit).sum(axis=-1))
