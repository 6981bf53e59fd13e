"""The force of the drive as it was logged, and as it acts: at another instant."""

from typing import Literal, NamedTuple

import numpy as np

from fric.arrays import Real
from fric.drive.plant import Plant
from fric.log import Log


def acting_force(time: Real, force: Real, delay: float) -> Real:
    """Return the force that acts at each sample, where what is logged acts later by a delay.

    Between samples it is interpolated, at the ends it is held. This is the one place where a lag of the force is
    undone.

    time, force: Instants [s] and logged force [N], each of shape (n,).
    delay: By how much later the logged force acts [s], ``T_d - force_lag`` of a plant; negative where it is logged
        late.
    """
    if delay == 0.0:
        return force
    return np.asarray(np.interp(time, time + delay, force))


class Drive(NamedTuple):
    """How what was logged comes to act on the axis, where no plant is known that tells it.

    Parameters
    ----------
    K_f
        Force constant [N/V]; None where it is not known.
    T_d
        By how much later than the voltage that makes it a force acts [s].
    force_lag
        By how much later than that voltage it is logged [s].
    """

    K_f: float | None = None
    T_d: float = 0.0
    force_lag: float = 0.0


def drive_force(log: Log, drive: Plant | Drive) -> tuple[Real, Literal["force", "input"], float]:
    """Return the force of the drive as it was logged [N], shape (n,), the channel it is from, and its lag [s].

    log: A record with a force, or with an input where the force constant is known.
    drive: The plant, or what is known of it: a logged force lags the voltage that makes it.
    Raises FricError: When there is neither.
    """
    if log.force is None and drive.K_f is not None and log.input is not None:
        return drive.K_f * log.input, "input", 0.0
    return log.require("force", "a replay"), "force", drive.force_lag
