"""The control block: parameters with units and bounds, a compiled step, and the data that it is packed for."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, ClassVar, Literal, Self

import numpy as np

from fric.arrays import Real
from fric.drive.plant import LinearPlant
from fric.errors import require_known
from fric.estimate import GAIN
from fric.friction import FrictionModel
from fric.friction.base import Parameter, Parametrised
from fric.kernels.block import BlockStep
from fric.kernels.loop import CONTROLLER, FEEDFORWARD, OBSERVER, Block
from fric.reference import Reference
from fric.verb import require_within

Kind = Literal["controller", "feedforward", "observer"]
"""controller
    Gives the control voltage in place of the cascade; a scheme has one.
feedforward
    Gives a voltage against friction ahead of the motion, which no observer sees.
observer
    Gives an estimate of the disturbance as a voltage, which is subtracted from the control voltage.
"""

ROLES = {"controller": CONTROLLER, "feedforward": FEEDFORWARD, "observer": OBSERVER}


@dataclass(frozen=True, eq=False)
class Setting:
    """What a block is packed for: the axis as its controller knows it, and the motion that it begins."""

    plant: LinearPlant  # The nominal plant
    cascade: "CascadeGains"  # The axis' cascade: with it sampling and limit
    friction: FrictionModel | None = None  # The friction that the scheme feeds forward; None for none
    models: Mapping[str, FrictionModel] = field(default_factory=dict)  # All that the controller believes in, by name
    gain: float = 1.0  # Share of the friction that is fed forward [1]
    lead: float = 0.0  # Lead of the feedforward [s]
    K_f: float = float("nan")  # Force constant that the controller believes [N/V]
    reference: Reference | None = None  # The reference; None where none is known yet
    position: float = 0.0  # Where the axis begins [m]
    velocity: float = 0.0  # How fast it is there [m/s]
    seen: float = 0.0  # Reading of the encoder one sample before [m]
    resolution: float = 0.0  # One step of the encoder [m]; 0 for none
    # 95 % intervals of friction's parameters, as ``F_c`` or ``k_2``, over their values [1], where identified
    spans: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def span(self, names: str) -> tuple[float, float] | None:
        """Return the widest span of the parameters whose names begin so; None where none was identified."""
        found = [span for name, span in self.spans.items() if name.startswith(names)]
        return (min(low for low, _ in found), max(high for _, high in found)) if found else None

    @property
    def sampling(self) -> float:
        """Sampling of the controller [Hz]."""
        return self.cascade.sampling

    @property
    def T_s(self) -> float:
        """Sampling period [s]."""
        return self.cascade.T_s


@dataclass(frozen=True)
class ControlBlock(Parametrised):
    """A control block. Each is a frozen dataclass, in one file, with its equations, their source and a compiled step.

    A subclass states its `name` (its key in files), its `kind`, the `Parameter` of each field, whether it is `linear`,
    what it `asks` of a controller, its compiled `step` (see `fric.kernels.block`), and how it is packed for the step.
    """

    kind: ClassVar[Kind]
    linear: ClassVar[bool]
    """True where the step is linear in sample and state: then the loop is judged by its poles and margins, which come
    from probing the step. A block that is not linear is not gated by poles."""
    asks: ClassVar[str]  # What it asks of a controller, in a few words: signals, memory, look-ahead
    step: ClassVar[BlockStep]
    feeds_back: ClassVar[bool] = False
    """True for a feedforward that depends on the measured motion, and so affects stability as the other kinds do."""
    repeats: ClassVar[bool] = False
    """True where its output depends on the previous period of the motion alone. It has too many poles to list; its loop
    is judged by whether its output shrinks from period to period (`fric.design.loop`)."""
    tuned: ClassVar[str] = ""
    """Name of the parameter that is made as large as the margins of the whole loop allow (`fric.design.blocks`)."""

    @classmethod
    def in_loop(cls) -> bool:
        """Return whether it matters to stability."""
        return cls.kind != "feedforward" or cls.feeds_back

    @classmethod
    def designed(cls, setting: Setting) -> Self:
        """Return the block for an axis whose files give none; with its parameters' typical values if not refined."""
        return cls(**{parameter.name: parameter.typical for parameter in cls.parameters})

    @classmethod
    def tuned_to(cls, value: float, setting: Setting) -> Self:
        """Return the block with a value of its tuned parameter, and the others as designed for that."""
        return replace(cls.designed(setting), **{cls.tuned: value})

    @classmethod
    def check(cls, values: Mapping[str, float]) -> None:
        """Raise a `FricError` where a name is not known, or a value [SI] is out of its bounds."""
        known = {parameter.name: parameter for parameter in cls.parameters}
        for name, value in values.items():
            require_known(name, known, f"the block '{cls.name}' has no", "It has")
            known[name].bound(cls.name, value)

    @classmethod
    def from_values(cls, values: Mapping[str, float], setting: Setting) -> Self:
        """Return the block that values by name [SI] give; what is not given is as in `designed`.

        Raises FricError: When a name is not known, or a value is out of its bounds.
        """
        cls.check(values)
        return cls(**values) if len(values) == len(cls.parameters) else replace(cls.designed(setting), **values)

    @abstractmethod
    def packed(self, setting: Setting) -> Real:
        """Return the parameters as the compiled step reads them."""

    @abstractmethod
    def initial_state(self, setting: Setting) -> Real:
        """Return the state of an axis that has been at rest, or at its velocity, until it begins."""

    def ready(self, setting: Setting) -> Block:
        """Return the block as the loop runs it."""
        state, parameters = (np.ascontiguousarray(made(setting), float) for made in (self.initial_state, self.packed))
        return Block(type(self).step, ROLES[self.kind], state, parameters)


@dataclass(frozen=True)
class CascadeGains(ControlBlock):
    """The gains of an axis' cascade, which other blocks are designed for; see `fric.control.cascade.Cascade`."""

    K_v: Annotated[float, "rate", Parameter("rate", doc="position gain")]
    K_p: Annotated[float, "velocity gain", Parameter("velocity gain", doc="proportional velocity gain")]
    K_i: Annotated[float, "position gain", Parameter("position gain", doc="integral velocity gain")]
    velocity_filter: Annotated[float, "frequency", Parameter("frequency", doc="corner of the low-pass on the velocity")]
    sampling: Annotated[float, "frequency"]
    limit: Annotated[float, "input"] = float("inf")
    velocity_feedforward: Annotated[float, "ratio"] = 1.0
    acceleration_feedforward: Annotated[float, "ratio"] = 1.0

    def __post_init__(self) -> None:
        gains = dict.fromkeys(("K_v", "K_p", "velocity_filter", "sampling"), f"[{1 / GAIN}, {GAIN}]")
        shares = dict.fromkeys(("velocity_feedforward", "acceleration_feedforward"), "[0, 2]")
        others = {"K_i": f"[0, {GAIN}]", "limit": "(0, inf]", **shares}
        require_within(self, "the controller", **gains, **others)

    @property
    def T_s(self) -> float:
        """Sampling period [s]."""
        return 1.0 / self.sampling

    @property
    def model_share(self) -> float:
        """Share of the inverse model that is fed forward [1]."""
        return self.velocity_feedforward * self.acceleration_feedforward
