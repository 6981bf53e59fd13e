"""The parameters of a GMS model as a fit wants them: free of bounds, each determined by the data by itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fric.friction.gms import GMS
from fric.identify.loops.knots import Blocks

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.friction.stribeck import StaticMap


@dataclass(frozen=True)
class Parametrisation:
    """From unbounded logarithms to a GMS model.

    Parameters
    ----------
    static
        The static map.
    count
        Number of blocks.
    with_level
        True where the level of friction in the records is fitted: it then scales F_c and F_s.
    with_C
        True where C is fitted; else it is ``C``.
    C
        Attraction parameter [N/s] to start from, or to keep.
    """

    static: StaticMap
    count: int
    with_level: bool
    with_C: bool
    C: float

    def pack(self, blocks: Blocks) -> NDArray[np.float64]:
        """Return the unbounded parameters of some blocks."""
        limit = blocks.limit
        level = np.log(limit.sum() / self.static.F_s)
        return np.concatenate(
            [
                np.log(blocks.displacement),
                np.log(limit[:-1] / limit[-1]),
                [level] if self.with_level else [],
                [np.log(self.C)] if self.with_C else [],
            ]
        )

    def level(self, x: NDArray[np.float64]) -> float:
        """Return the level of the records relative to the static map: the raw Σ alpha."""
        return float(np.exp(x[2 * self.count - 1])) if self.with_level else 1.0

    def alpha(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return alpha, which sums to 1."""
        ratio = np.exp(np.append(x[self.count : 2 * self.count - 1], 0.0))
        return np.asarray(ratio / ratio.sum())

    def attraction(self, x: NDArray[np.float64]) -> float:
        """Return C [N/s]."""
        return float(np.exp(x[-1])) if self.with_C else self.C

    def stiffness(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return k [N/m]."""
        return np.asarray(self.alpha(x) * self.static.F_s * self.level(x) / np.exp(x[: self.count]))

    def model(self, x: NDArray[np.float64]) -> GMS:
        """Return the model at the level of the records."""
        level = self.level(x)
        static = type(self.static)(
            F_c=self.static.F_c * level,
            F_s=self.static.F_s * level,
            v_s=self.static.v_s,
            delta=self.static.delta,
            sigma=self.static.sigma,
        )
        return GMS(static, tuple(self.alpha(x)), tuple(self.stiffness(x)), self.attraction(x))

    def quantities(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return what intervals are wanted of: logit alpha, log k, log level, log C."""
        alpha = np.clip(self.alpha(x), 1e-15, 1.0 - 1e-15)  # a single block has alpha = 1
        logit = np.log(alpha) - np.log1p(-alpha)
        return np.concatenate([logit, np.log(self.stiffness(x)), [np.log(self.level(x)), np.log(self.attraction(x))]])
