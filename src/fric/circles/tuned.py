"""What circles say of an axis, and how sure it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fric.arrays import Real
from fric.circles.tune_fit import Fitted
from fric.drive.plant import Plant
from fric.estimate import Covariance, Estimate
from fric.friction import FrictionModel
from fric.friction.directed import Directed
from fric.friction.gms import GMS
from fric.notice import Notice
from fric.simulate.machine import Axis


@dataclass(frozen=True)
class TunedEstimates:
    """Friction and plant with their 95 % intervals."""

    # static, negative, gms, plant: parameters by name; ``offset`` is among those of the static map. ``negative`` is the
    # map of the negative direction, where it has its own.
    static: dict[str, Estimate]
    negative: dict[str, Estimate] | None
    gms: dict[str, Estimate]
    plant: dict[str, Estimate]
    covariance: Covariance  # How the parameters that were fitted err together, in their logarithms
    coordinates: Real  # Covariance of the coordinates that were searched, shape (p, p)

    def at(self, friction: FrictionModel) -> TunedEstimates:
        """Return the estimates where a controller believes another friction: what differs is fixed there."""
        negative = friction.negative if isinstance(friction, Directed) else None
        model = friction.model if isinstance(friction, Directed) else friction
        assert isinstance(model, GMS)  # what circles tune

        def fixed(section: dict[str, Estimate], values: Mapping[str, Any]) -> dict[str, Estimate]:
            return {
                name: one if np.allclose(one.value, values.get(name, one.value), 1e-5)
                else Estimate(values[name], one.unit, fixed=True)
                for name, one in section.items()
            }  # fmt: skip

        static, gms = fixed(self.static, vars(model.static)), fixed(self.gms, vars(model))
        free = {name for name, one in (static | gms).items() if not one.fixed}
        kept = [n for n, name in enumerate(self.covariance.names) if name in free or name.rpartition("_")[0] in free]
        rows = np.array(self.covariance.matrix)[np.ix_(kept, kept)]
        return replace(
            self, static=static, gms=gms,
            negative=None if self.negative is None else fixed(self.negative, vars(negative)),
            covariance=Covariance.of([self.covariance.names[n] for n in kept], rows, "log"),
        )  # fmt: skip


@dataclass(frozen=True)
class TunedAxis:
    """What circles say of one axis.

    Parameters
    ----------
    axis
        The axis with its new nominal parameters; as it was, where these are refused.
    friction, nominal
        The friction and the plant that were found.
    before, after
        What nominal and tuned parameters leave of the recorded voltages.
    estimates
        Both with their intervals; None where the result is no machine.
    full
        Whether the full shape was fitted.
    improves
        Whether the result is better than the nominal parameters.
    warnings
        What the circles cannot tell.
    loop
        Whether its loop was designed anew.
    """

    axis: Axis
    friction: FrictionModel
    nominal: Plant
    before: Fitted
    after: Fitted
    estimates: TunedEstimates | None
    full: bool
    improves: bool
    warnings: tuple[Notice, ...]
    loop: bool = False

    @property
    def parameters(self) -> dict[str, Estimate]:
        """Friction and plant by name, with their intervals; nothing where the result is no machine."""
        found = self.estimates
        return {} if found is None else {**found.static, **found.gms, **found.plant}
