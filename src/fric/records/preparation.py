"""Data on how a record was prepared for a replay, as in files, which are read without the preparing module."""

from dataclasses import dataclass, field
from typing import Annotated, Literal

from fric.drive.plant import Plant
from fric.estimate import STAYS

Own = Literal["offset", "damping", "mass"]
"""Fitted terms of a single record: a constant force, and forces proportional to velocity and acceleration."""
DIMENSIONS: dict[Own, str] = {"offset": "force", "damping": "viscous", "mass": "mass"}
"""The dimension of the coefficient of each (see `fric.units`)."""
WINDOWS = 4  # Number of windows in time of a single record whose levels are compared


@dataclass(frozen=True)
class Preparation:
    """Data on how a record was prepared for the replay.

    source: the channel that the force is from; input times the force constant
    delay: delay of the action of the force after its log [s]; negative where it is logged late
    timing: standard deviation of the lag between force and position [s]
    encoder: the encoder's step; 0 where none is visible [m]
    mass: mass whose inertia was subtracted [kg]
    damping: linear damping of the drive, subtracted [N·s/m]
    inertia_share: size of the inertia (99 % quantile) relative to the logged force
    damping_share: size of the drive's damping (99 % quantile) relative to the logged force
    own: terms of the record, fitted beside the model
    every: every n-th sample was taken
    plant: that was used; None where none is known
    starts: whether the samples show how the motion starts and stops
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
    starts: bool = field(default=True, metadata=STAYS)
