"""A prediction of a circle: the glitch of each scheme, and reasons not to trust it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf

import numpy as np

from fric.arrays import Real
from fric.contour import QUADRANTS
from fric.estimate import STAYS, Interval
from fric.flaws.prediction import SCHEME_UNSTABLE
from fric.notice import Notice
from fric.simulate.contour_run import pair
from fric.simulate.processes import MonteCarlo


@dataclass(frozen=True)
class Predicted:
    """Prediction of one scheme on machines drawn from the uncertainty of the identified machine."""

    glitch: float  #: Median of the largest glitch over the machines that were drawn [m]
    ci95: Interval  #: Its range on 95 % of them, the encoder's step included; null where a loop is not stable [m]
    under: float  #: What 95 % of the machines stay under [m]
    quadrants: Mapping[str, Interval]  #: 95 % interval of the signed glitch [m]
    #: 95 % interval of the largest glitch at the two reversals of an axis that was run [m]
    axes: Mapping[str, Interval]
    unstable: float = 0.0  #: Share of the machines on which the loop is not stable
    why: tuple[Notice, ...] = field(default=(), metadata=STAYS)  #: Why it must not be trusted
    #: Which of these reasons hold for this scheme alone
    distrust: tuple[Notice, ...] = field(default=(), metadata=STAYS)

    @property
    def trusted(self) -> bool:
        """Whether it may be trusted."""
        return not self.why


@dataclass(frozen=True)
class Prediction:
    """Predictions of schemes on the circle, and whether they may be trusted."""

    radius: float  #: radius, feed: the circle [m], [m/s]
    feed: float
    axes: tuple[str, ...]  #: That were run; another follows its reference exactly
    machines: int  #: That were drawn
    resolution: float  #: Step of the coarsest encoder: no smaller difference is seen [m]
    measured: tuple[str, ...]  #: Measured circles that every machine was made to agree with
    schemes: Mapping[str, Predicted]  #: By name
    #: By axis, what widened the intervals beyond those of the parameters
    widened: Mapping[str, tuple[Notice, ...]] = field(default_factory=dict)
    distrust: tuple[Notice, ...] = ()  #: Why no interval must be trusted

    def trusted(self, scheme: str) -> bool:
        """Return whether the interval of a scheme may be trusted."""
        return scheme in self.schemes and self.schemes[scheme].trusted


ENDS = 0.1  # Relative error of the distance of two quantiles, for the small number of machines drawn
UNSTABLE = 0.05  # Largest share of machines with an unstable loop, for a trusted interval


def predicted(
    many: MonteCarlo, *, widened: Mapping[str, tuple[Notice, ...]] | None = None, measured: Sequence[str] = (),
    distrust: Sequence[Notice] = (), of_schemes: Mapping[str, Sequence[Notice]] | None = None,
    seen: Mapping[str, Mapping[str, float]] | None = None,
) -> Prediction:  # fmt: skip
    """Return the predictions of schemes on a circle, from the machines drawn from what was identified.

    seen: By scheme and quadrant, the glitch that was measured on this circle [m]: the intervals hold it, for no
        machine that is drawn has all of a real one.
    of_schemes: Reasons not to trust a single scheme, by scheme.
    """
    study = many.study
    names = pair(study.machine, study.only)
    axes = (study.only,) if study.only else tuple(name for name in names if name in study.machine.axes)
    step = 0.0  # the largest error of an encoder
    for name in axes:
        off = study.discrepancies.get(name, {}).get("resolution")
        step = max(step, study.machine.axes[name].encoder.resolution * (off.high if off else 1.0))
    schemes = {}
    for n, scheme in enumerate(study.schemes):
        ran = many.quadrants[np.isfinite(many.glitches[:, n]), n]
        failed = 1 - len(ran) / len(many)
        why = list((of_schemes or {}).get(scheme.name, ()))
        if failed > UNSTABLE:
            why.append(SCHEME_UNSTABLE.found(scheme=scheme.name, share=failed))
        ran = ran if len(ran) else np.full((1, 4), np.inf)
        size = np.abs(ran)
        glitch = size.max(axis=1)
        ends = {name: size[:, k::2].max(axis=1) for k, name in enumerate(names) if name in axes}
        was = (seen or {}).get(scheme.name, {})
        largest = {name: sorted(abs(was[q]) for q in QUADRANTS[k::2] if was)[-1:] for k, name in enumerate(names)}
        most = sorted(size for name in axes for size in largest[name])[-1:]
        low, high = _between(glitch, step, most)
        under = max(min(_quantile(glitch, 0.95) + step / 2, high), *most, 0.0)
        of_axes = {name: _between(size, step, largest[name]) for name, size in ends.items()}
        schemes[scheme.name] = Predicted(
            float(np.median(glitch)), (max(low, 0.0), high), under,
            {name: _between(ran[:, k], step, [was[name]] if was else []) for k, name in enumerate(QUADRANTS)},
            {name: (max(low, 0.0), high) for name, (low, high) in of_axes.items()},
            failed, tuple(dict.fromkeys([*distrust, *why])), tuple(why),
        )  # fmt: skip
    return Prediction(
        study.circle.radius, study.circle.feed, axes, len(many), step, tuple(measured), schemes, dict(widened or {}),
        tuple(distrust),
    )  # fmt: skip


def _between(values: Real, step: float, seen: Sequence[float] = ()) -> Interval:
    """Return the 95 % interval of drawn values, at least an encoder step wide, that holds what was seen."""
    if not np.all(np.isfinite(values)):
        return inf, inf
    low, high = (_quantile(values, share) for share in (0.025, 0.975))
    more = ENDS * (high - low) + step / 2
    return min(low - more, *seen, inf), max(high + more, *seen, -inf)


def _quantile(values: Real, share: float) -> float:
    return float(np.quantile(values, share)) if np.all(np.isfinite(values)) else inf
