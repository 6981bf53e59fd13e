"""Reading of an encoder: the position of the body that it is on, with a sub-divisional error, in whole steps."""

from typing import NamedTuple

import numpy as np
from numba import types

from fric.arrays import Real
from fric.kernels.elementary import sin
from fric.kernels.plant import numba_type
from fric.kernels.signatures import ARRAY, compiled


class Sensing(NamedTuple):
    """Errors of the encoder of an axis; none by default."""

    error: float = 0.0  # m, amplitude of the sub-divisional error
    wave: float = 0.0  # rad/m, 2π over the pitch of the scale
    phase: float = 0.0  # rad, at position 0
    spring: float = 0.0  # 0 for one rigid mass; with two masses 1 where the encoder is on the motor, 2 on the table
    shift: float = 0.0  # m, distance of its counts below whole steps of the position


FAULTLESS = Sensing()
SENSING = numba_type(Sensing, types.float64)


@compiled(types.float64(types.float64, types.float64, SENSING), makes_arrays=False)
def reading(z: float, resolution: float, sensing: Sensing) -> float:
    """Return the reading of a position [m] by an encoder of a resolution [m] (0 for none)."""
    if sensing.error != 0.0:
        z += sensing.error * sin(sensing.wave * z + sensing.phase)
    if resolution > 0.0:
        return np.rint((z + sensing.shift) / resolution) * resolution - sensing.shift
    return z


@compiled(types.void(ARRAY, types.float64, SENSING), makes_arrays=False)
def read(z: Real, resolution: float, sensing: Sensing) -> None:
    """Replace positions [m], shape (n,), by the `reading` of each."""
    for n in range(z.size):
        z[n] = reading(z[n], resolution, sensing)
