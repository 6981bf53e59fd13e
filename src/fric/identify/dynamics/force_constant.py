"""The force constant: what force one volt makes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from fric.estimate import Estimate
from fric.identify.dynamics.covariance import hac_covariance
from fric.units import Motion, si_unit

if TYPE_CHECKING:
    from fric.log import Log


def force_constant(logs: Sequence[Log], given: float | None, motion: Motion) -> Estimate | None:
    """Return K_f [N/V]: as given, or the slope of force over input where a record has both; None where none has.

    Parameters
    ----------
    logs
        Records of one axis.
    given
        K_f [N/V], where the user knows it.
    motion
        Motion of the axis.
    """
    unit = si_unit("force per input", motion)
    if given is not None:
        return Estimate(given, unit, fixed=True)
    pairs = [(log.input, log.force) for log in logs if log.input is not None and log.force is not None]
    if not pairs:
        return None
    u, F = (np.concatenate(columns) for columns in zip(*pairs, strict=True))
    X = np.column_stack([u, np.ones_like(u)])
    if np.ptp(u) == 0:
        return None
    slope, offset = np.linalg.lstsq(X, F, rcond=None)[0]
    residual = F - slope * u - offset
    half = 0.0
    if np.any(residual):
        half = 1.96 * float(np.sqrt(hac_covariance(X, residual, [len(p[0]) for p in pairs])[0, 0]))
    return Estimate(float(slope), unit, (float(slope) - half, float(slope) + half))
