"""Any model on a guideway with a map for each direction, and with the residual force of a measured circle."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from fric.arrays import Real
from fric.exact import each
from fric.friction.base import FrictionModel, Wrapped
from fric.friction.stribeck import OnStaticMap, StaticMap
from fric.kernels.elementary import exp
from fric.kernels.inner import address_of, step_at
from fric.kernels.left_over import AHEAD, TravelGrid, left_over_step, travels_along
from fric.kernels.signatures import Step, compiled_step
from fric.series import real

PLAY = 1e-6  # Travel back that makes a reversal [m]: fluctuations by encoder counts are smaller
KNEE, RATIO, STEP_BEYOND = 28, 0.25, 3e-4  # Points a ratio ``e^RATIO`` apart, up to 1 mm, distance of later ones [m]


@compiled_step
def _step(dz: float, v: float, dt: float, state: Real, parameters: Real) -> float:
    """Advance the inner model, whose ``state`` it is, with this direction's parameters: ``parameters`` is the address
    of its step, its parameters for the positive direction, and as many for the negative direction.
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
        return replace(self.model, static=self.negative) if isinstance(self.model, OnStaticMap) else self.negative

    def sliding_force(self, v: Real) -> Real:
        """Return the friction force [N] after a long time at constant velocity v [m/s]."""
        v = real(v, "sliding_force", "v")
        return np.where(v < 0, self.backward.sliding_force(v), self.model.sliding_force(v))

    @property
    def layout(self) -> str:
        """The order of `packed`."""
        return "[address of the model's step, its parameters forwards, its parameters backwards]"

    def packed(self) -> Real:
        """Return the parameters as `layout` says."""
        return np.array([address_of(type(self.model).step), *self.model.packed(), *self.backward.packed()])


def directed(model: FrictionModel, negative: StaticMap | None) -> FrictionModel:
    """Return a model with another static map backwards; the model itself where either lacks such a map."""
    return Directed(model, negative) if negative is not None and isinstance(model, StaticMap | OnStaticMap) else model


def mean_map(static: StaticMap, negative: StaticMap | None) -> StaticMap:
    """Return the static map half way between those of the two directions."""
    if negative is None:
        return static
    halves = {p.name: 0.5 * (getattr(static, p.name) + getattr(negative, p.name)) for p in StaticMap.parameters}
    return StaticMap(**halves)


def travels(longest: float) -> Real:
    """Return the travels since a reversal at which the force is given [m], up to the longest."""
    near = PLAY * each(exp, RATIO * np.arange(KNEE + 1.0))
    return np.append(near, near[-1] + STEP_BEYOND * np.arange(1, max(int((longest - near[-1]) / STEP_BEYOND), 0) + 2))


def since_reversal(position: Real) -> tuple[Real, Real]:
    """Return direction (1, -1; 0 before the first motion) and travel since the last reversal [m], shape (n,) each."""
    found = np.zeros((2, len(position)))
    travels_along(np.ascontiguousarray(position), PLAY, found)
    return found[0], found[1]


@dataclass(frozen=True)
class Completed(Wrapped):
    """A friction model, and an added force ``r(s, direction)`` over the travel s since the last reversal.

    With the residual of a measured motion it explains that motion for any parameters of the model. Since pre-sliding,
    cogging and a level that varies with position all depend on the travel, it also predicts another motion.

    model: The model.
    forwards, backwards: The added force [N], at the first of `travels`.
    """

    forwards: tuple[float, ...]
    backwards: tuple[float, ...]

    step: ClassVar[Step] = left_over_step

    def packed(self) -> Real:
        """Return ``[address of the model's step, grid, force forwards, force backwards, the model's parameters]``."""
        grid = TravelGrid(address_of(type(self.model).step), len(self.forwards), PLAY, KNEE, RATIO, STEP_BEYOND)
        return np.array([*grid, *self.forwards, *self.backwards, *self.model.packed()])

    def initial_state(self) -> Real:
        """Return the state at rest, before any travel."""
        return np.concatenate([np.zeros(AHEAD), super().initial_state()])
