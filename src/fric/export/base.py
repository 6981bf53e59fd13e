"""What is exported, and what a target makes of it: files by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from fric.errors import FricError
from fric.export.translate.program import Program
from fric.export.translate.reader import read_program

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.friction import FrictionModel
    from fric.simulate.machine import Axis

LARGEST_POSITION, LARGEST_VELOCITY, LARGEST_ACCELERATION = 1e4, 1e3, 1e6
"""Beyond these [m, m/s, m/s²; rad alike] a command is absurd, and an exported step reports a fault."""


@dataclass(frozen=True)
class Part:
    """What one scheme does on one axis, with all that a controller needs to do it.

    ::

        friction [V] = gain·F(r + lead·ṙ + lead²/2·r̈, ṙ + lead·r̈)/K_f
        model    [V] = (r̈ + A·(ṙ + lead·r̈))/B

    A controller has no preview of its reference, but it has the reference's velocity and acceleration: they carry it
    over the lead. On a circle of 30 mm at 100 mm/s, 0.65 ms ahead, that is right to 0.05 nm.

    Parameters
    ----------
    machine, axis, motion
        Where it belongs.
    scheme
        Name of the scheme.
    friction
        The friction that is fed forward; None where none is.
    gain
        Share of it.
    K_f
        Force constant [N/V].
    A, B
        The nominal plant [1/s], [m/(s²·V)].
    lead
        By how much the feedforward is ahead [s].
    sampling
        Rate of the controller [Hz].
    limit
        Largest voltage [V].
    resolution
        The encoder's step [m].
    """

    machine: str
    axis: str
    motion: str
    scheme: str
    friction: FrictionModel | None
    gain: float
    K_f: float
    A: float
    B: float
    lead: float
    sampling: float
    limit: float
    resolution: float

    @property
    def parameters(self) -> NDArray[Any]:
        """The friction model's parameters as its step reads them."""
        return self.model.packed()

    @property
    def initial_state(self) -> NDArray[Any]:
        """The friction model's state at rest."""
        return self.model.initial_state()

    @property
    def model(self) -> FrictionModel:
        """The friction model; raise a `FricError` where none is fed forward."""
        if self.friction is None:
            raise FricError(
                f"scheme {self.scheme} feeds no friction forward, and there is nothing to export",
                mend="Choose a scheme with friction: --scheme c or --scheme f.",
            )
        return self.friction

    @property
    def program(self) -> Program:
        """The friction model's step as a program; raise a `FricError` with the reason where it cannot be one."""
        model = self.model
        sizes = {"state": self.initial_state.size, "parameters": self.parameters.size}
        try:
            return read_program(type(model).step, f"{model.name}_step", **sizes)
        except FricError as error:
            raise FricError(f"friction model '{model.name}' {error}") from None


Files = Mapping[str, str | bytes]


@dataclass(frozen=True)
class Target:
    """A language or a controller that a part can be exported to.

    Parameters
    ----------
    name
        What it is called on the command line.
    doc
        One line on what it writes.
    files
        Returns the files of a part by name; takes the options that the target knows.
    options
        Names of the options that it knows.
    parts
        What of an axis it exports: ``compensation``, ``machine``.
    """

    name: str
    doc: str
    files: Callable[..., Files]
    options: frozenset[str] = field(default_factory=frozenset)
    parts: tuple[str, ...] = ("compensation",)


def lead_of(axis: Axis) -> float:
    """Return by how much the feedforward of an axis is ahead of its reference [s]."""
    return float(getattr(axis, "lead", 0.0) or 0.0)
