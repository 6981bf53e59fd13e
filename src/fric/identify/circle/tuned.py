"""What circles say of an axis, and how sure it is."""

from dataclasses import dataclass

from fric.arrays import Real
from fric.drive.plant import Plant
from fric.estimate import Covariance, Estimate
from fric.friction import FrictionModel
from fric.identify.circle.tune_fit import Fitted
from fric.notice import Notice
from fric.simulate.machine import Axis


@dataclass(frozen=True)
class TunedEstimates:
    """Friction and plant with their 95 % intervals.

    Parameters
    ----------
    static, negative, gms, plant
        Parameters by name; ``offset`` is among those of the static map. ``negative`` is the map of the negative
        direction, where it has its own.
    covariance
        How the parameters that were fitted err together, in their logarithms.
    coordinates
        Covariance of the coordinates that were searched, shape (p, p).
    """

    static: dict[str, Estimate]
    negative: dict[str, Estimate] | None
    gms: dict[str, Estimate]
    plant: dict[str, Estimate]
    covariance: Covariance
    coordinates: Real


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
