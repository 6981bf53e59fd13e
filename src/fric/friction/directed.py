"""Any model on a static map, on a guideway whose two directions have a map each."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from fric.arrays import Real
from fric.friction.base import FrictionModel, Wrapped
from fric.friction.stribeck import OnStaticMap, StaticMap
from fric.kernels.inner import address_of, step_at
from fric.kernels.signatures import Step, compiled_step


@compiled_step
def _step(dz: float, v: float, dt: float, state: Real, parameters: Real) -> float:
    """Advance the inner model with the parameters of this direction.

    ``parameters`` is the address of the inner step, its parameters for the positive direction, and as many for the
    negative direction; ``state`` is the inner model's.
    """
    size = (parameters.size - 1) // 2
    inner = step_at(parameters[0])
    if dz < 0.0 or (dz == 0.0 and v < 0.0):
        force: float = inner(dz, v, dt, state, parameters[1 + size :])
    else:
        force = inner(dz, v, dt, state, parameters[1 : 1 + size])
    return force


@dataclass(frozen=True)
class Directed(Wrapped):
    """A friction model with the level ``s_+(v)`` forwards and ``s_-(v)`` backwards, and viscous friction likewise.

    A friction file with ``static_negative`` gives each of its models in this form; a force that both directions
    share (gravity, the bias of an amplifier) is the ``offset``, and no friction.

    model: The model with the static map of the positive direction: a `StaticMap`, or a model with a static map.
    negative: Static map of the negative direction.
    """

    negative: StaticMap

    step: ClassVar[Step] = _step

    @property
    def backward(self) -> FrictionModel:
        """The model with the static map of the negative direction."""
        if isinstance(self.model, OnStaticMap):
            return replace(self.model, static=self.negative)
        return self.negative

    def steady_state(self, v: Real | float) -> Real:
        """Return the friction force [N] after a long time at constant velocity v [m/s]."""
        v = np.asarray(v, float)
        return np.where(v < 0, self.backward.steady_state(v), self.model.steady_state(v))

    @property
    def layout(self) -> str:
        """The order of `packed`."""
        return "[address of the model's step, its parameters forwards, its parameters backwards]"

    def packed(self) -> Real:
        """Return the parameters as `layout` says."""
        return np.array([address_of(type(self.model).step), *self.model.packed(), *self.backward.packed()])


def directed(model: FrictionModel, negative: StaticMap | None) -> FrictionModel:
    """Return a model with another static map backwards; the model itself where either lacks such a map."""
    on_map = isinstance(model, StaticMap | OnStaticMap)
    return Directed(model, negative) if negative is not None and on_map else model


def mean_map(static: StaticMap, negative: StaticMap | None) -> StaticMap:
    """Return the static map half way between those of the two directions."""
    if negative is None:
        return static
    halves = {p.name: 0.5 * (getattr(static, p.name) + getattr(negative, p.name)) for p in StaticMap.parameters}
    return StaticMap(**halves)
