"""What a prediction of a circle knows, and what it does not: the glitch of each scheme, and why not to trust it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from fric.arrays import Real
from fric.contour import QUADRANTS
from fric.estimate import Interval
from fric.notice import Notice
from fric.simulate.contour_run import pair

if TYPE_CHECKING:
    from fric.simulate.monte_carlo import MonteCarlo, Study

SETTLED = frozenset(
    {
        "force-over-position",
        "friction-over-position",
        "directions-differ",
        "force-drifts",
        "level-differs",
        "strokes-unsettled",
        "F_c-at-bound",
    }
)
"""Warnings of friction's level, which a measured circle settles: every drawn machine has the level of that one."""


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
                    "glitch": _known(one.glitch), "ci95": list(map(_known, one.ci95)), "under": _known(one.under),
                    "quadrants": {key: list(map(_known, limits)) for key, limits in one.quadrants.items()},
                    "axes": {key: list(map(_known, limits)) for key, limits in one.axes.items()},
                    "unstable": one.unstable, "trusted": self.trusted(name),
                    "why": [why.as_dict() for why in self.why_not(name)],
                }
                for name, one in self.schemes.items()
            },
            "widened": {axis: [why.as_dict() for why in reasons] for axis, reasons in self.widened.items()},
            "distrust": [why.as_dict() for why in self.distrust],
        }  # fmt: skip


def _known(value: float) -> float | None:
    return value if isfinite(value) else None


ENDS = 0.1
"""Share of the distance of two quantiles by which they lie too near, of so few machines as are drawn."""
UNSTABLE = 0.05
"""Share of the machines on which a scheme's loop may be unstable before its interval is not trusted."""


def predicted(
    many: MonteCarlo,
    *,
    widened: Mapping[str, tuple[Notice, ...]] | None = None,
    measured: Sequence[str] = (),
    distrust: Sequence[Notice] = (),
    of_schemes: Mapping[str, Sequence[Notice]] | None = None,
) -> Prediction:
    """Return what schemes should leave of a circle, of the machines that were drawn from what was identified.

    Parameters
    ----------
    many
        The machines that were run.
    widened, measured, distrust
        As in `Prediction`.
    of_schemes
        By scheme, why it alone must not be trusted.
    """
    study = many.study
    names = pair(study.machine)
    axes = (study.only,) if study.only else names
    step = max(_step(study, name) for name in axes)
    schemes = {}
    for n, scheme in enumerate(study.schemes):
        ran = many.quadrants[np.isfinite(many.glitches[:, n]), n]
        failed = 1 - len(ran) / len(many)
        why = list((of_schemes or {}).get(scheme.name, ()))
        if failed > UNSTABLE or not len(ran):
            text = f"scheme {scheme.name} is not stable on {failed:.0%} of the machines that agree with what is known"
            why.append(Notice(text, "scheme-unstable", "wrong"))
        if not len(ran):
            ran = np.full((1, 4), np.inf)
        size = np.abs(ran)
        glitch = size.max(axis=1)
        ends = {name: size[:, k::2].max(axis=1) for k, name in enumerate(names) if name in axes}
        low, high = _between(glitch, step)
        schemes[scheme.name] = Predicted(
            scheme.name, float(np.median(glitch)), (max(low, 0.0), high), min(_quantile(glitch, 0.95) + step / 2, high),
            {name: _between(ran[:, k], step) for k, name in enumerate(QUADRANTS)},
            {name: (max(found[0], 0.0), found[1]) for name, found in ((a, _between(s, step)) for a, s in ends.items())},
            failed, tuple(why),
        )  # fmt: skip
    return Prediction(
        study.circle.radius, study.circle.feed, axes, len(many), step, schemes, dict(widened or {}), tuple(measured),
        tuple(distrust),
    )  # fmt: skip


def _step(study: Study, name: str) -> float:
    """Return by how much the encoder of an axis may tell its position wrong [m]."""
    off = study.discrepancies.get(name, {}).get("resolution")
    return study.machine.axes[name].encoder.resolution * (off.high if off else 1.0)


def _between(values: Real, step: float) -> Interval:
    """Return the 95 % interval of what was drawn, a step of the encoder wide at least."""
    if not np.all(np.isfinite(values)):
        return inf, inf
    low, high = (_quantile(values, share) for share in (0.025, 0.975))
    more = ENDS * (high - low) + step / 2
    return low - more, high + more


def _quantile(values: Real, share: float) -> float:
    return float(np.quantile(values, share)) if np.all(np.isfinite(values)) else inf


def prediction_of(tree: Mapping[str, Any]) -> Prediction:
    """Return the prediction that `Prediction.as_dict` wrote."""

    def notices(given: Any) -> tuple[Notice, ...]:
        return tuple(map(Notice.of, given))

    def limits(given: Mapping[str, Any]) -> dict[str, Interval]:
        return {key: (number(low), number(high)) for key, (low, high) in given.items()}

    def number(given: float | None) -> float:
        return inf if given is None else float(given)

    general = notices(tree["distrust"])
    schemes = {
        name: Predicted(
            name, number(one["glitch"]), limits({"": one["ci95"]})[""], number(one["under"]),
            limits({key: one["quadrants"][key] for key in QUADRANTS if key in one["quadrants"]}), limits(one["axes"]),
            float(one["unstable"]), tuple(why for why in notices(one["why"]) if why not in general),
        )
        for name, one in tree["schemes"].items()
    }  # fmt: skip
    return Prediction(
        float(tree["radius"]), float(tree["feed"]), tuple(tree["axes"]), int(tree["machines"]),
        float(tree["resolution"]), schemes, {axis: notices(reasons) for axis, reasons in tree["widened"].items()},
        tuple(tree["measured"]), general,
    )  # fmt: skip
