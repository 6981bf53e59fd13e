"""A plan: limits of an axis, the experiments that are to be made inside them, and their expected intervals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np

from fric.errors import FricError
from fric.reference import Reference
from fric.simulate.circle import Circle
from fric.simulate.experiment import Trial, trials_of_kind
from fric.simulate.machine import Axis

Setting = float | int | tuple[float, ...]

APPROACH = 20.0  # Time that the begin of a motion is approached in, from the other end of the stroke [s]


@dataclass(frozen=True)
class Limits:
    """What an axis may do.

    stroke: length that it may travel [m]
    feed: largest speed [m/s]
    acceleration: largest acceleration [m/s²]
    """

    stroke: Annotated[float, "position"]
    feed: Annotated[float, "velocity"]
    acceleration: Annotated[float, "acceleration"]

    def __post_init__(self) -> None:
        for name in ("stroke", "feed", "acceleration"):
            if not 0 < getattr(self, name) < float("inf"):
                raise FricError(f"a {name} of {getattr(self, name):g} leaves no room for an experiment")

    @property
    def approach(self) -> float:
        """Speed with which the begin of a motion is approached: over the whole stroke in `APPROACH` or so."""
        return min(0.5 * self.feed, self.stroke / APPROACH)

    def broken_by(self, motion: Reference) -> str:
        """Return which limit a motion breaks; empty where it keeps all of them."""
        used = (np.ptp(motion.position), np.abs(motion.velocity).max(), np.abs(motion.acceleration).max())
        names = ("stroke", "feed", "acceleration")
        return next((name for name, item in zip(names, used, strict=True) if item > getattr(self, name)), "")


@dataclass(frozen=True)
class Planned:
    """One experiment of a plan.

    kind: A kind of record, or ``circle``.
    settings: Its settings, as `fric.simulate.experiment` takes them, in SI.
    why: Its purpose.
    """

    kind: str
    settings: Mapping[str, Setting]
    why: str

    def trials(self, axis: Axis) -> list[Trial]:
        """Return the motion of the axis, one trial a record; a circle has two axes, and no trial."""
        settings: dict[str, Any] = dict(self.settings)
        return [] if self.kind == "circle" else trials_of_kind(axis, self.kind, **settings)

    def changed(self, **settings: Setting) -> Planned:
        """Return the experiment with other settings."""
        return replace(self, settings={**self.settings, **settings})


@dataclass(frozen=True)
class Expected:
    """Expected interval of one parameter from planned records."""

    value: float  # Its median identified value [SI]
    # Half the width of its 95 % interval [SI], the geometric mean of several runs; infinite where most set no limit
    half_width: float
    unit: str  # SI unit
    between: tuple[float, float]  # The least and the largest of them


@dataclass(frozen=True, eq=False)
class Plan:
    """The experiments to run, and the intervals expected of them.

    axis: The axis as known beforehand.
    limits: What it may do.
    planned, lasting: The experiments, and how long each lasts [s].
    expected: Expected intervals, by parameter.
    """

    axis: Axis
    limits: Limits
    planned: Sequence[Planned]
    lasting: Sequence[float]
    expected: Mapping[str, Expected]


@dataclass(frozen=True)
class CandidateRecord:
    """One more record."""

    planned: Planned  # The experiment
    lasting: float  # How long it lasts [s]
    half_width: float  # Half the 95 % interval of the predicted glitch with it [m]
    # Scatter of it with other noise, and other places between two encoder counts [m]
    scatter: float


@dataclass(frozen=True)
class Narrowing:
    """What the glitch is not known for, and what narrows it."""

    half_width: float  # Half the 95 % interval of the predicted glitch so far [m]
    # Share of its variance that is due to each parameter with its covariances [1]; they sum to 1
    shares: Mapping[str, float]
    # Records by the expected interval, the best first; of those that differ by less than they scatter the shortest
    candidates: tuple[CandidateRecord, ...]
    test: Circle  # The circle
    scheme: str  # Name of the compensation
