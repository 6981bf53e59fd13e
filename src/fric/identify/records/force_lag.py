"""A force that is logged at another instant than it acts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def acting_force(time: NDArray[np.float64], force: NDArray[np.float64], delay: float) -> NDArray[np.float64]:
    """Return the force that acts at each sample, where what is logged acts later by a delay.

    Between samples it is interpolated, at the ends it is held. This is the one place where a lag of the force is
    undone.

    Parameters
    ----------
    time, force
        Instants [s] and logged force [N], each of shape (n,).
    delay
        By how much later the logged force acts [s], `fric.drive.plant.Plant.force_delay`; negative where it is
        logged late.
    """
    if delay == 0.0:
        return force
    return np.asarray(np.interp(time, time + delay, force))
