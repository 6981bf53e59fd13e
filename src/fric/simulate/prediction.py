"""What a prediction of a circle knows, and what it does not: the glitch of each scheme, and why not to trust it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from fric.contour import QUADRANTS
from fric.notice import Notice

if TYPE_CHECKING:
    from fric.estimate import Interval


@dataclass(frozen=True)
class Predicted:
    """What one scheme should leave of a circle.

    Parameters
    ----------
    scheme
        Its name.
    glitch
        Median of the largest glitch over the machines that were drawn [m].
    ci95
        Between what it lies on 95 % of them, the encoder's step taken in [m].
    under
        What it stays under on 95 % of them [m].
    quadrants
        Interval of the signed glitch at each quadrant [m].
    axes
        Interval of the largest glitch at the two reversals of each axis that was run [m].
    unstable
        Share of the machines on which the scheme's loop is not stable [1].
    distrust
        Why this scheme's interval must not be trusted, besides what holds for all schemes.
    """

    scheme: str
    glitch: float
    ci95: Interval
    under: float
    quadrants: Mapping[str, Interval]
    axes: Mapping[str, Interval]
    unstable: float = 0.0
    distrust: tuple[Notice, ...] = ()


@dataclass(frozen=True)
class Prediction:
    """What schemes should leave of one circle, on machines drawn from all that is open about one.

    Parameters
    ----------
    radius, feed
        The circle [m], [m/s].
    axes
        The axes that were run; another follows its reference exactly.
    machines
        Machines that were drawn.
    resolution
        Step of the coarsest encoder [m]: no smaller difference is seen.
    schemes
        By scheme.
    widened
        By axis, what widened the intervals beyond those of the parameters.
    measured
        Measured circles that every machine was made to agree with.
    distrust
        Why no interval must be trusted; empty where all may be.
    """

    radius: float
    feed: float
    axes: tuple[str, ...]
    machines: int
    resolution: float
    schemes: Mapping[str, Predicted]
    widened: Mapping[str, tuple[Notice, ...]] = field(default_factory=dict)
    measured: tuple[str, ...] = ()
    distrust: tuple[Notice, ...] = ()

    def why_not(self, scheme: str) -> tuple[Notice, ...]:
        """Return why the interval of a scheme must not be trusted; nothing where it may be."""
        own = self.schemes[scheme].distrust if scheme in self.schemes else ()
        return tuple(dict.fromkeys([*self.distrust, *own]))

    def trusted(self, scheme: str) -> bool:
        """Tell whether the interval of a scheme may be trusted."""
        return scheme in self.schemes and not self.why_not(scheme)

    def as_dict(self) -> dict[str, Any]:
        """Return the prediction as a plain document, for programs; every number in SI."""
        return {
            "radius": self.radius,
            "feed": self.feed,
            "axes": list(self.axes),
            "machines": self.machines,
            "resolution": self.resolution,
            "measured": list(self.measured),
            "schemes": {
                name: {
                    "glitch": one.glitch, "ci95": list(one.ci95), "under": one.under,
                    "quadrants": {key: list(limits) for key, limits in one.quadrants.items()},
                    "axes": {key: list(limits) for key, limits in one.axes.items()},
                    "unstable": one.unstable, "trusted": self.trusted(name),
                    "why": [why.as_dict() for why in self.why_not(name)],
                }
                for name, one in self.schemes.items()
            },
            "widened": {axis: [why.as_dict() for why in told] for axis, told in self.widened.items()},
            "distrust": [why.as_dict() for why in self.distrust],
        }  # fmt: skip


def prediction_of(tree: Mapping[str, Any]) -> Prediction:
    """Return the prediction that `Prediction.as_dict` wrote."""

    def notices(given: Any) -> tuple[Notice, ...]:
        return tuple(Notice(one["text"], one["code"], one["severity"]) for one in given)

    def limits(given: Mapping[str, Any]) -> dict[str, Interval]:
        return {key: (float(low), float(high)) for key, (low, high) in given.items()}

    general = notices(tree["distrust"])
    schemes = {
        name: Predicted(
            name, float(one["glitch"]), limits({"": one["ci95"]})[""], float(one["under"]),
            limits({key: one["quadrants"][key] for key in QUADRANTS if key in one["quadrants"]}), limits(one["axes"]),
            float(one["unstable"]), tuple(why for why in notices(one["why"]) if why not in general),
        )
        for name, one in tree["schemes"].items()
    }  # fmt: skip
    return Prediction(
        float(tree["radius"]), float(tree["feed"]), tuple(tree["axes"]), int(tree["machines"]),
        float(tree["resolution"]), schemes, {axis: notices(told) for axis, told in tree["widened"].items()},
        tuple(tree["measured"]), general,
    )  # fmt: skip
