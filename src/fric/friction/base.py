"""The friction model: parameters with units and bounds, a steady state, and one compiled step."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, replace
from functools import cache
from inspect import get_annotations
from math import nan
from typing import Any, ClassVar, Literal, Self, get_origin

import numpy as np

from fric.arrays import Real
from fric.errors import FricError
from fric.estimate import GAIN, Estimate
from fric.kernels.replay import replay
from fric.kernels.signatures import Step
from fric.series import real, require_rising
from fric.verb import refused, require_numbers


@dataclass(frozen=True)
class Parameter:
    """A parameter of a model or a control block; it annotates the field, for files, fits and error messages."""

    dimension: str  # Its dimension, see `fric.units`
    lower: float = 0.0  # lower, upper: physical bounds in SI
    upper: float = float("inf")
    doc: str = ""  # Its description in one line
    typical: float | tuple[float, ...] = nan  # Of a linear feed drive [SI], else the field's default: where fits begin
    held: bool = False  # True where a fit supposes its typical value, within a factor of two, unless it is freed
    at_least: str = ""  # Name of the parameter that bounds this parameter from below in a fit
    shares: bool = False  # True where the values of the blocks sum to 1
    name: str = ""  # The paper's symbol: that of the field, also the key in files
    per_block: bool = False  # True where there is one value per slip block: the field is a tuple

    def bound(self, holder: str, *values: float) -> None:
        """Refuse values [SI] beyond the bounds; ``holder`` names the model or block that has them."""
        if wrong := [value for value in values if not self.lower <= value <= self.upper]:
            what = f"{self.name} of '{holder}' is {wrong[0]:g}, but {self.doc} lies between {self.lower:g} and"
            raise FricError(f"{what} {self.upper:g}", hint="Look at the number and its unit.")


Property = Literal["bounded", "passive", "pre-sliding", "non-local memory", "no creep", "frictional lag"]
"""What a model may claim, and is then held to by the tests that all models share (tests/friction/test_properties.py).

bounded
    Without its viscous part, the force is never above F_s, at any motion and any time step.
passive
    Over any motion, fast or slow, with waits, no more energy can be drawn from it than went in.
pre-sliding
    From rest it gives way like a spring, and breaks away at F_s.
non-local memory
    Minor loops close, and leave no trace; a branch after a reversal is the virgin curve stretched by two (Masing).
no creep
    A load that vibrates below break-away does not make it creep.
frictional lag
    In sliding, the force is higher while the speed rises than while it falls.

All models, without claiming it, are odd, dissipate over cycles of a few harmonics, settle on their steady state, and
hold at rest.
"""


class Parametrised(ABC):
    """What has parameters: fields that a `Parameter` annotates, those of base classes without a name, too."""

    name: ClassVar[str]
    parameters: ClassVar[tuple[Parameter, ...]] = ()

    def __init_subclass__(cls) -> None:
        if "parameters" in vars(cls):
            raise TypeError(f"{cls.__name__}: annotate fields with their Parameter, in place of a table `parameters`")
        declared = tuple(
            replace(mark, name=name, typical=getattr(cls, name, nan) if mark.typical is nan else mark.typical,
                    per_block=get_origin(hint.__origin__) is tuple)
            for name, hint in get_annotations(cls, eval_str=True).items()
            for mark in getattr(hint, "__metadata__", ()) if isinstance(mark, Parameter)
        )  # fmt: skip
        cls.parameters = declared if "name" in vars(cls.__base__) else (*cls.parameters, *declared)


class FrictionModel(Parametrised):
    """A friction model. Each is a frozen dataclass whose fields are its parameters, in one file.

    A subclass states its `name` (also its key in friction files), the `Parameter` of each field, the `properties` it
    claims, its compiled `step` (see `fric.kernels.signatures`) and the state in which the step begins.
    """

    properties: ClassVar[frozenset[Property]]
    step: ClassVar[Step]
    identified: ClassVar[bool] = True  # False for a model that is simulated only, and that no `fric identify` looks for

    def __post_init__(self) -> None:
        require_numbers(self, *_names(type(self)))
        for name in _names(type(self))[1]:  # given as an array, say, whose truth is not that of a tuple
            object.__setattr__(self, name, tuple(map(float, getattr(self, name))))
        for parameter in self.parameters:  # a step of a fit may leave the bounds; what is read from a file lies within
            value = getattr(self, parameter.name)
            if not all(abs(number) <= GAIN for number in (value if parameter.per_block else (value,))):
                raise FricError(f"{parameter.name} of '{self.name}' is no {parameter.doc}", hint="Give it in SI units.")

    @classmethod
    def declared(cls) -> dict[str, tuple[Parameter, ...]]:
        """Return the parameters that determine this model, by their section of a friction file."""
        return {cls.name: cls.parameters}

    @classmethod
    def from_sections(cls, sections: Mapping[str, Mapping[str, Estimate]]) -> Self:
        """Return the model that the sections of a friction file (``static``, ``gms``, …) give, all in SI.

        Raises FricError: When the model's section, or one of its parameters that has no default, is not there.
        """
        return cls(**cls.fields_from(sections))

    @classmethod
    def fields_from(cls, sections: Mapping[str, Mapping[str, Estimate]]) -> dict[str, Any]:
        """Return the fields of this model from the section with its name."""
        section = sections.get(cls.name, {})
        optional = {field.name for field in fields(cls) if field.default is not MISSING}  # type: ignore[arg-type]
        wanted = {parameter.name for parameter in cls.parameters}
        missing = [p.name for p in cls.parameters if p.name not in section and p.name not in optional]
        if missing:
            hint = f"fric identify {cls.name} finds it."
            raise FricError(f"the friction has no {', '.join(missing)} in '{cls.name}'", hint=hint)
        given = {key: estimate.value for key, estimate in section.items() if key in wanted}
        for p in cls.parameters:
            value = given.get(p.name, ())
            values = value if isinstance(value, tuple) else (value,)
            if p.per_block:
                given |= {p.name: values} if values else {}
            elif isinstance(given.get(p.name), tuple):
                raise FricError(f"{p.name} of '{cls.name}' has several values, and there is one", hint=f"{p.doc}.")
            p.bound(cls.name, *values)
        return given

    @classmethod
    def typical(cls) -> Self:
        """Return the model with its parameters' typical values."""
        sections = cls.declared().items()
        return cls.from_sections({name: {p.name: Estimate(p.typical, "") for p in of} for name, of in sections})

    def steady_state(self, v: Real | float) -> Real:
        """Return the friction force [N] after a long time at constant velocity v [m/s], of any shape."""
        if not np.isfinite(v := real(v, "steady_state", "v")).all():
            raise refused("steady_state", "v as finite velocities", v)
        return self.sliding_force(v)

    @abstractmethod
    def sliding_force(self, v: Real) -> Real:
        """Return the force of `steady_state`."""

    def packed(self) -> Real:
        """Return the parameters as the step reads them: numbers, then the values of all blocks, in their order."""
        numbers = [getattr(self, p.name) for p in self.parameters if not p.per_block]
        return np.array([*numbers, *(value for p in self.parameters if p.per_block for value in getattr(self, p.name))])

    @property
    def layout(self) -> str:
        """The order of `packed`, as in ``[F_c, sigma, k_1 … k_N]``."""
        of = [sorted(parameters, key=lambda p: p.per_block) for parameters in self.declared().values()]
        names = (f"{p.name}_1 … {p.name}_N" if p.per_block else p.name for parameters in of for p in parameters)
        return f"[{', '.join(names)}]"

    @abstractmethod
    def initial_state(self) -> Real:
        """Return the state of a relaxed contact, at rest and without force."""

    def replay(self, time: Real, position: Real, velocity: Real | None = None, state: Real | None = None) -> Real:
        """Return the friction force [N], shape (n,), along a motion, by the compiled step.

        time, position: The motion [s], [m], each of shape (n,).
        velocity: Velocity at each sample [m/s], shape (n,); central differences of the position where not given.
        state: State at the first sample, changed in place to that at the last; relaxed where it is not given.
        """
        time, position = real(time, "replay", "time"), real(position, "replay", "position")
        v = position if velocity is None else real(velocity, "replay", "velocity")
        if not time.shape == position.shape == v.shape == (max(time.size, 3 if velocity is None else 1),):
            raise refused("replay", "a value a sample, of three at least where there is no velocity,", position)
        if velocity is None:
            require_rising(time, "replay")
            v = np.gradient(position, time, edge_order=2)
        begin = self.initial_state()
        state = begin if state is None else state
        if getattr(state, "shape", None) != begin.shape or state.dtype != begin.dtype or not state.flags.carray:
            raise refused("replay", "state as initial_state gives it", state)
        return replay(type(self).step, position, v, time, state, self.packed())


@dataclass(frozen=True)
class Wrapped(FrictionModel):
    """A friction model around another, whose name it bears; it is simulated only.

    model: The model within.
    """

    model: FrictionModel

    properties: ClassVar[frozenset[Property]] = frozenset()
    identified: ClassVar[bool] = False

    @property
    def name(self) -> str:  # type: ignore[override]
        """The name of the model within."""
        return self.model.name

    def sliding_force(self, v: Real) -> Real:
        """Return the force of the model within."""
        return self.model.sliding_force(v)

    def initial_state(self) -> Real:
        """Return the state of the model within at rest."""
        return self.model.initial_state()


@cache
def _names(model: type[FrictionModel]) -> tuple[tuple[str, ...], frozenset[str]]:
    """Return the names of a model's parameters, and of those that have a value a block."""
    return tuple(p.name for p in model.parameters), frozenset(p.name for p in model.parameters if p.per_block)
