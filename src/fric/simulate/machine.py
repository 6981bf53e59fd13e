"""The machine that is simulated: its axes, each with its true properties and the nominal models of its controller."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import isclose
from pathlib import Path
from typing import Any, Protocol, Self, TypeAlias

import fric
from fric.control.cascade import Cascade
from fric.control.inverse_model import DisturbanceObserver
from fric.control.scheme import Lead, require_feedforward
from fric.drive.plant import Plant
from fric.drive.sensing import Encoder
from fric.errors import FricError, require_known, require_name
from fric.estimate import as_filed
from fric.friction import FrictionModel
from fric.notice import Notice
from fric.simulate.reality.flaws import NONE, Reality, SecondMass
from fric.units import Motion
from fric.verb import require_within, typed


class HoldsBelief(Protocol):
    """A result that holds what a controller can believe."""

    @property
    def belief(self) -> FrictionModel | Mapping[str, FrictionModel] | Plant | Cascade | DisturbanceObserver:
        """The friction models, plant, cascade or observer that was found."""


Belief: TypeAlias = FrictionModel | Mapping[str, FrictionModel] | Plant | Cascade | DisturbanceObserver | HoldsBelief
"""What the controller of an axis can believe."""


@typed
@dataclass(frozen=True)
class NominalFriction:
    """The friction that a controller feeds forward."""

    models: Mapping[str, FrictionModel] = field(default_factory=dict)  # By name, as a scheme asks for them
    gain: float = 1.0  # Share of the nominal friction that is fed forward [1]
    lead: Lead = 0.0  # Of the feedforward of friction and inverse model [s]; ``auto`` for T_d, when the drive answers

    def __post_init__(self) -> None:
        require_feedforward(self.gain, self.lead)


@typed
@dataclass(frozen=True, repr=False)
class Axis:
    """One axis of a machine.

    name, motion: Its name, and whether it is linear or rotary.
    plant: Eq. (1).
    cascade: Its controller.
    friction: The friction that it has.
    load: A constant force against positive motion: gravity, or the bias of an amplifier [N].
    nominal_friction: The friction that its controller believes.
    nominal: The plant that its controller believes: in the inverse model, and from friction to voltage. The true plant
        where not given.
    observer: Its disturbance observer, for the schemes that use one.
    blocks: Parameters of further control blocks in SI, by the block's name; what is not given is as the block is
        designed.
    encoder: Its encoder.
    force_noise: Noise of a logged force sample, root mean square [N].
    reality: Its properties beyond the model, in its logs and in its motion; they are not known to a controller.
    second_mass: Its table on a spring, where it is no rigid body.
    """

    name: str
    plant: Plant
    cascade: Cascade
    friction: FrictionModel
    load: float = 0.0
    nominal_friction: NominalFriction = field(default_factory=NominalFriction)
    nominal: Plant | None = None
    observer: DisturbanceObserver | None = None
    encoder: Encoder = field(default_factory=Encoder)
    force_noise: float = 0.0
    blocks: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    motion: Motion = "linear"
    reality: Reality = NONE
    second_mass: SecondMass | None = None

    def __post_init__(self) -> None:
        require_name(self.name)
        require_within(self, f"axis {self.name}", load="(-1e9, 1e9)", force_noise="[0, 1e9)")

    def __repr__(self) -> str:
        plant = ", ".join(f"{name} {getattr(self.plant, name):.5g}" for name in ("A", "B", "T_d", "K_f"))
        known = ", ".join(self.nominal_friction.models) or "none"
        return f"axis {self.name}: plant {plant} (SI); friction {self.friction.name}, nominal friction {known}"

    def believing(self, given: Belief) -> Self:
        """Return the axis with other nominal models of its controller, as in `Machine.with_belief`."""
        if (of := getattr(given, "axis", self.name)) != self.name:
            raise FricError(f"axis {self.name} was given what is known of axis {of}")
        known: object = as_filed(getattr(given, "belief", given))
        if isinstance(known, FrictionModel):
            known = {known.name: known}
        if isinstance(known, Mapping) and all(isinstance(item, FrictionModel) for item in known.values()):
            return replace(self, nominal_friction=replace(self.nominal_friction, models=known))
        kinds: dict[str, type] = {"nominal": Plant, "cascade": Cascade, "observer": DisturbanceObserver}
        if name := next((name for name, kind in kinds.items() if isinstance(known, kind)), ""):
            return replace(self, **{name: known})  # type: ignore[arg-type]
        hint = "Give a friction model, plant, cascade, observer, or a result; a file by read_machine."
        raise FricError(f"axis {self.name} takes a result, model or plant, and no {type(given).__name__}", hint=hint)

    def lead(self, asked: Lead | None = None) -> float:
        """Return the lead of the feedforward of its controller [s], as requested or as it is set."""
        lead = self.nominal_friction.lead if asked is None else asked
        return (self.nominal or self.plant).T_d if lead == "auto" else lead

    def placed(self, place: float) -> Self:
        """Return the axis with position 0 elsewhere between two counts of its encoder, from 0 to 1."""
        return replace(self, encoder=replace(self.encoder, place=place))

    @property
    def constant_load(self) -> float:
        """The load, and gravity where it is a flaw that is not known to a controller [N]."""
        return self.load + self.reality.gravity


@dataclass(frozen=True)
class Published:
    """What others measured on this machine in a circular test."""

    radius: float  # Radius of the circle [m]
    feed: float  # Feed [m/s]
    glitches: Mapping[str, float]  # Glitch by scheme [m]


@typed
@dataclass(frozen=True, repr=False)
class Machine:
    """A machine: axes by name.

    name: What the machine is.
    axes: Its axes.
    published: What is known of its circles.
    warnings: What the files that it was read from warn of.
    origin: How it was read, as arguments of `fric.read_machine`; empty where it was not.
    """

    name: str
    axes: Mapping[str, Axis]
    published: tuple[Published, ...] = ()
    warnings: tuple[Notice, ...] = ()
    origin: Mapping[str, Any] = field(default_factory=dict, compare=False)

    def __repr__(self) -> str:
        return "\n".join([self.name, *(f"  {axis}" for axis in self.axes.values())])

    def is_nominal(self, models: Iterable[str | None], axes: Iterable[str]) -> bool:
        """Return whether controllers know the axes exactly: the plant, and friction but for its gain.

        models: Friction models that are fed forward, by name; None for none.
        axes: Names of the axes.
        """
        wanted = [name for name in models if name is not None]

        def exact(axis: Axis) -> bool:
            true = (axis.friction, getattr(axis.friction, "static", None))
            known = all(axis.nominal_friction.models.get(name) in true for name in wanted)
            return known and axis.reality == NONE and axis.second_mass is None and axis.nominal in (None, axis.plant)

        return all(exact(self.axis(name)) for name in axes)

    def axis(self, name: str) -> Axis:
        """Return an axis by its name; raise a `FricError` that names those there are."""
        require_known(name, self.axes, "the machine has no axis", "Its axes are")
        return self.axes[name]

    def with_belief(self, **beliefs: Belief | Sequence[Belief]) -> Self:
        """Return the machine with other models in its controllers; its true axes do not change.

        beliefs: By axis: a friction model (or several by name) to feed forward, a nominal plant, a cascade, a
            disturbance observer, or a result with one of these; several in a list.
        Raises FricError: When there is no such axis, a result is of another axis, or it is none of these.
        """
        axes = dict(self.axes)
        for name, given in beliefs.items():
            axis = self.axis(name)
            several: Sequence[Any] = given if isinstance(given, list | tuple) else [given]
            for item in several:
                axis = axis.believing(item)
            axes[name] = axis
        return replace(self, axes=axes)

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write the machine as one file, which `fric.read_machine` and the command line read (`fric.write_machine`).

        Intervals are not written: to draw machines from them, keep the files that were identified.
        """
        fric.write_machine(self, path, force=force)

    def placed(self, place: float) -> Self:
        """Return the machine with another place of position 0 between two counts of its encoders, from 0 to 1.

        The n-th axis lies at n times the place, less whole counts: multiples of 1/5 put every axis on each of five
        places once, and no two axes on the same places together.
        """
        axes = {name: axis.placed(n * place % 1.0) for n, (name, axis) in enumerate(self.axes.items(), 1)}
        return replace(self, axes=axes)

    def published_glitches(self, radius: float, feed: float) -> Mapping[str, float]:
        """Return the published glitches by scheme [m] for a circle; empty where there are none."""
        near = partial(isclose, rel_tol=1e-6)
        same = (test for test in self.published if near(test.radius, radius) and near(test.feed, feed))
        return next((test.glitches for test in same), {})
