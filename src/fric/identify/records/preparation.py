"""What was made of a record before a replay, as data."""

from dataclasses import dataclass
from typing import Literal

from fric.drive.plant import Plant

Own = Literal["offset", "damping", "mass"]
"""What a record adds of its own: a constant force, a force over the velocity, and one over the acceleration."""

DIMENSIONS: dict[Own, str] = {"offset": "force", "damping": "viscous", "mass": "mass"}
"""The dimension of the coefficient of each (see `fric.units`)."""


@dataclass(frozen=True)
class Preparation:
    """What was made of a record before the replay, as data.

    Parameters
    ----------
    source
        The channel that the force is from: ``force``, or ``input`` times the force constant.
    delay
        By how much later the force acts than it is logged [s]; negative where it is logged late.
    timing
        How surely force and position belong to one instant, as a standard deviation [s].
    encoder
        The encoder's step [m]; 0 where none is visible.
    plant
        The plant that was used; None where none is known.
    mass, damping
        Inertia [kg] and the drive's own linear damping [N·s/m] that were taken off; None where no plant is known.
    inertia_share, damping_share
        Size of each (99 % quantile) relative to that of the force.
    own
        What the record adds of its own, and the fit finds beside the model.
    every
        One sample of so many was taken.
    """

    source: Literal["force", "input"]
    delay: float
    timing: float
    encoder: float
    mass: float | None = None
    damping: float | None = None
    inertia_share: float | None = None
    damping_share: float | None = None
    own: tuple[Own, ...] = ("offset",)
    every: int = 1
    plant: Plant | None = None
