"""The exported part of a machine, and targets, which make files of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from numpy.typing import NDArray

from fric.errors import FricError
from fric.export.translate.program import Program
from fric.export.translate.reader import Entry, read_program
from fric.friction import FrictionModel
from fric.friction.directed import Directed
from fric.units import Motion

LARGEST = {
    "position": 1e4, "velocity": 1e3, "acceleration": 1e6, "time": 1.0, "force": 1e9, "voltage": 1e6, "gain": 1e3,
}  # fmt: skip
"""Beyond these [m, m/s, m/s², s, N, V; rad, N·m] a value is absurd, and an exported step reports a fault."""


Role = Literal["compensation", "machine"]


@dataclass(frozen=True)
class Part:
    """The exported part of one axis: its controller under one scheme, or the machine itself.

    ::

        friction [V] = gain·F(r + lead·ṙ + lead²/2·r̈, ṙ + lead·r̈)/K_f
        model    [V] = (r̈ + A·(ṙ + lead·r̈))/B
        axis         = z̈ = B·u(t - delay) - A·ż - (F(z) + load)/M

    A controller has no preview of its reference, but it has the reference's velocity and acceleration: they carry it
    over the lead. On a circle of 30 mm at 100 mm/s, 0.65 ms ahead, that is right to 0.05 nm.

    role: ``compensation`` for the controller, with its nominal models; ``machine`` for the axis with its true friction,
        as a plant to try a controller on.
    machine, axis, motion: Where it belongs.
    scheme: Name of the scheme.
    friction: The friction that is fed forward, or that the axis has; None where none is fed forward.
    K_f, A, B: The plant: force constant [N/V], damping [1/s], acceleration per volt [m/(s²·V)].
    sampling, limit, resolution: Rate of the controller [Hz], its largest voltage [V], the encoder's step [m].
    gain: Share of the friction that is fed forward.
    lead: Lead of the feedforward [s].
    delay: Transport delay of the axis [s].
    load: Constant force against positive motion [N].
    velocity_filter: Corner of the low-pass behind the first difference of the encoder [Hz].
    K_p, K_i: Gains of the speed controller [V·s/m], [V/m].
    blocks: The scheme's control blocks besides the controller.
    """

    role: Role
    machine: str
    axis: str
    motion: Motion
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
    K_p: float = float("nan")
    K_i: float = float("nan")
    blocks: tuple[BlockPart, ...] = ()

    @property
    def parameters(self) -> NDArray[Any]:
        """The friction model's parameters as its step reads them."""
        packed = self.model.packed()
        if isinstance(self.model, Directed):
            packed[0] = 0.0  # where a step lies in this process
        return packed

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
                hint="Choose a scheme with friction: `scheme='c'` or `scheme='f'`.",
            )
        return self.friction

    @property
    def step(self) -> str:
        """What the friction model's step is called in the program."""
        return f"{self.model.name}_step"

    @property
    def program(self) -> Program:
        """The steps of friction model and blocks as a program; raise a `FricError` with the reason where that fails."""
        model = self.model
        inner = type(model.model).step if isinstance(model, Directed) else None
        entries = [Entry(self.step, type(model).step, self.initial_state.size, self.parameters.size, inner)]
        entries += [Entry(block.name, block.step, block.state.size, block.parameters.size) for block in self.blocks]
        names = [f"friction model '{model.name}'", *(f"block '{block.title}'" for block in self.blocks)]
        for what, entry in zip(names, entries, strict=True):
            try:
                read_program(entry)
            except FricError as error:
                raise FricError(f"{what} {error}") from None
        return read_program(*entries)


@dataclass(frozen=True)
class BlockPart:
    """A control block of a scheme, packed for an axis."""

    title: str  # Its name in schemes
    kind: str  # ``observer``: its voltage is subtracted; ``feedforward``: it is added
    step: Any  # Its compiled step
    parameters: NDArray[Any]  # As the step reads them
    state: NDArray[Any]  # State of an axis at rest at 0
    # per_position, per_measured: change of the state per metre of the commanded, and of the measured start position
    per_position: NDArray[Any]
    per_measured: NDArray[Any]

    @property
    def name(self) -> str:
        """Its name as languages take it."""
        return self.title.replace("-", "_")


Files = Mapping[str, str | bytes]


@dataclass(frozen=True)
class Target:
    """A language or a controller that a part can be exported to."""

    name: str  # Its name on the command line
    doc: str  # Its output in one line
    files: Callable[..., Files]  # Returns the files of a part by name; takes the options that the target knows
    options: frozenset[str] = field(default_factory=frozenset)  # Names of the options that it knows
    parts: tuple[str, ...] = ("compensation",)  # The part of an axis that it exports: ``compensation``, ``machine``
