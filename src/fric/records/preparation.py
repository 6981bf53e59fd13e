"""Data on how a record was prepared for a replay, as in files, which are read without the preparing module."""

from dataclasses import dataclass, field
from typing import Annotated, Literal

from fric.drive.plant import Plant
from fric.estimate import STAYS

Own = Literal["offset", "damping", "mass"]  # Fitted terms of a record: constant, and over velocity and acceleration
DIMENSIONS: dict[Own, str] = {"offset": "force", "damping": "viscous", "mass": "mass"}  # Dimension of its coefficient
WINDOWS = 4  # Number of windows in time of a single record whose levels are compared


@dataclass(frozen=True)
class Preparation:
    """Data on how a record was prepared for the replay."""

    source: Literal["force", "input"]  #: The channel that the force is from; input times the force constant
    #: Delay of the action of the force after its log [s]; negative where it is logged late
    delay: Annotated[float, "time"]
    timing: Annotated[float, "time"]  #: Standard deviation of the lag between force and position [s]
    encoder: Annotated[float, "position"]  #: The encoder's step; 0 where none is visible [m]
    mass: Annotated[float | None, "mass"] = None  #: Mass whose inertia was subtracted [kg]
    damping: Annotated[float | None, "viscous"] = None  #: Linear damping of the drive, subtracted [N·s/m]
    inertia_share: float | None = None  #: Size of the inertia (99 % quantile) relative to the logged force
    damping_share: float | None = None  #: Size of the drive's damping (99 % quantile) relative to the logged force
    own: tuple[Own, ...] = ("offset",)  #: Terms of the record, fitted beside the model
    every: int = 1  #: Every n-th sample was taken
    plant: Plant | None = field(default=None, metadata=STAYS)  #: That was used; None where none is known
    starts: bool = field(default=True, metadata=STAYS)  #: Whether the samples show how the motion starts and stops
