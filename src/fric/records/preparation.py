"""What was made of a record before a replay, as data."""

from dataclasses import dataclass, field
from typing import Annotated, Literal

from fric.drive.plant import Plant
from fric.estimate import STAYS

Own = Literal["offset", "damping", "mass"]
"""What a record adds of its own: a constant force, a force over the velocity, and one over the acceleration."""

DIMENSIONS: dict[Own, str] = {"offset": "force", "damping": "viscous", "mass": "mass"}
"""The dimension of the coefficient of each (see `fric.units`)."""


@dataclass(frozen=True)
class Preparation:
    """What was made of a record before the replay, as data.

    source: the channel that the force is from; input times the force constant
    delay: by how much later the force acts than it is logged; negative where it is logged late [s]
    timing: how surely force and position belong to one instant, standard deviation [s]
    encoder: the encoder's step; 0 where none is visible [m]
    mass: mass whose inertia was taken off [kg]
    damping: the drive's own linear damping, taken off [N·s/m]
    inertia_share: size of the inertia (99 % quantile) relative to the logged force
    damping_share: size of the drive's damping (99 % quantile) relative to the logged force
    own: what the record adds of its own, fitted beside the model
    every: one sample of so many was taken
    plant: that was used; None where none is known
    """

    source: Literal["force", "input"]
    delay: Annotated[float, "time"]
    timing: Annotated[float, "time"]
    encoder: Annotated[float, "position"]
    mass: Annotated[float | None, "mass"] = None
    damping: Annotated[float | None, "viscous"] = None
    inertia_share: float | None = None
    damping_share: float | None = None
    own: tuple[Own, ...] = ("offset",)
    every: int = 1
    plant: Plant | None = field(default=None, metadata=STAYS)
