"""What is exported, and what a target makes of it: files by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from fric.errors import FricError
from fric.export.translate.program import Program
from fric.export.translate.reader import read_program

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.friction import FrictionModel

LARGEST_POSITION, LARGEST_VELOCITY, LARGEST_ACCELERATION = 1e4, 1e3, 1e6
"""Beyond these [m, m/s, m/s²; rad alike] a command is absurd, and an exported step reports a fault."""


Role = Literal["compensation", "machine"]


@dataclass(frozen=True)
class Part:
    """What of one axis is exported: what its controller does under one scheme, or the axis as it is.

    ::

        friction [V] = gain·F(r + lead·ṙ + lead²/2·r̈, ṙ + lead·r̈)/K_f
        model    [V] = (r̈ + A·(ṙ + lead·r̈))/B
        axis         = z̈ = B·u(t - delay) - A·ż - (F(z) + load)/M

    A controller has no preview of its reference, but it has the reference's velocity and acceleration: they carry it
    over the lead. On a circle of 30 mm at 100 mm/s, 0.65 ms ahead, that is right to 0.05 nm.

    Parameters
    ----------
    role
        ``compensation`` for what a controller does, with what it believes; ``machine`` for the axis with its true
        friction, as a plant to try a controller on.
    machine, axis, motion
        Where it belongs.
    scheme
        Name of the scheme.
    friction
        The friction that is fed forward, or that the axis has; None where none is fed forward.
    K_f, A, B
        The plant: force constant [N/V], damping [1/s], acceleration per volt [m/(s²·V)].
    sampling, limit, resolution
        Rate of the controller [Hz], its largest voltage [V], the encoder's step [m].
    gain
        Share of the friction that is fed forward.
    lead
        By how much the feedforward is ahead [s].
    delay
        Transport delay of the axis [s].
    load
        Constant force against positive motion [N].
    velocity_filter
        Corner of the low-pass behind the first difference of the encoder [Hz].
    """

    role: Role
    machine: str
    axis: str
    motion: str
    scheme: str
    friction: FrictionModel | None
    K_f: float
    A: float
    B: float
    sampling: float
    limit: float
    resolution: float
    gain: float = 1.0
    lead: float = 0.0
    delay: float = 0.0
    load: float = 0.0
    velocity_filter: float = 500.0

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
