"""Design of the disturbance observer: how far Q may reach, by eq. (8) and by the peak sensitivity of the whole loop."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

import numpy as np

from fric.arrays import Real
from fric.control import ControlBlock, Setting
from fric.control.cascade import Cascade
from fric.control.inverse_model import DisturbanceObserver
from fric.control.q_filter import QFilter
from fric.design.loop import SampledLoop
from fric.design.margins import Loop, Margins, OpenLoop, border, decibel, grid, margins, rounded_down
from fric.design.perturbation import SURE, Perturbation, RobustLimit, model_perturbation, robust_limit
from fric.drive.plant import LinearPlant
from fric.errors import FricError
from fric.flaws.response import RESPONSE_BEGINS, RESPONSE_ENDS, RESPONSE_WITHOUT_CONFIDENCE
from fric.notice import Notice

Blocks = tuple[ControlBlock, ...]

PEAK_SENSITIVITY = 10 ** (6 / 20)
TRIED = 50  # cutoffs tried on the way up, before the border is refined


@dataclass(frozen=True)
class ObserverDesign:
    """A disturbance observer, the two limits of its Q, and the margins of the whole loop with it."""

    plant: LinearPlant
    cascade: Cascade
    observer: DisturbanceObserver
    perturbation: Perturbation  # Delta, which eq. (8) was applied to
    robust: RobustLimit  # The limit of eq. (8)
    sensitive: QFilter | None  # The largest Q with which the whole loop keeps the peak sensitivity; None for no limit
    peak_sensitivity: float  # What was asked of M_s
    input: Margins  # input, without: margins at the plant's input, with the observer and without
    without: Margins
    reason: str  # What limits Q
    warnings: tuple[Notice, ...] = ()  # Warnings: what the response does not determine
    assumed: bool = False  # True where Q relies on a mode that was not measured

    def loops(self) -> dict[str, Loop]:
        """Return the whole loop with its margins, with and without the observer, by name."""
        whole = WholeLoop(self.plant, self.cascade, self.perturbation)
        return {
            "input": Loop("with observer", whole.response((self.observer,)), self.input),
            "without": Loop("without observer", whole.response(), self.without),
        }


class WholeLoop:
    """The loop opened at the plant's input; the part of Delta beyond the plant's delay multiplies the sampled plant.

    Arguments are those of `SampledLoop`, and Delta.
    """

    def __init__(
        self, plant: LinearPlant, cascade: Cascade, perturbation: Perturbation,
        controller: ControlBlock | None = None, setting: Setting | None = None,
    ) -> None:  # fmt: skip
        self.plant, self.cascade, self.perturbation = plant, cascade, perturbation
        self.controller, self.setting = controller, setting
        unmodelled = perturbation.frequency[perturbation.ratio != 1.0]
        nyquist = cascade.sampling / 2
        self.f = np.union1d(grid(nyquist), unmodelled[unmodelled < nyquist])
        self.G, self.correction = SampledLoop(plant, cascade).G(self.f), perturbation.correction(self.f)

    def sampled(self, blocks: Blocks) -> SampledLoop:
        """Return the loop of eq. (1)."""
        return SampledLoop(self.plant, self.cascade, blocks, self.controller, self.setting)

    def response(self, blocks: Blocks = ()) -> OpenLoop:
        """Return the open loop with further blocks as a function of the frequencies [Hz]."""
        loop = self.sampled(blocks)
        return lambda f: loop.input(f) * self.perturbation.correction(f)

    def margins(self, blocks: Blocks = ()) -> Margins:
        """Return the margins with further blocks."""
        return margins(self.response(blocks), self.cascade.sampling / 2)

    def peak(self, blocks: Blocks = ()) -> float:
        """Return the peak sensitivity with further blocks; infinite where the loop is unstable.

        The loop of eq. (1) is stable when its eigenvalues are. That of the true plant is too when (1 + L_true)/(1 + L)
        does not wind around 0, for what is unmodelled is stable by itself.
        """
        loop = self.sampled(blocks)
        if not loop.stable:
            return inf
        L = loop.input(self.f, self.G)
        true = L * self.correction
        winding = np.unwrap(np.angle((1 + true) / (1 + L)))
        if abs(winding[-1] - winding[0]) > np.pi:
            return inf
        return float((1.0 / np.abs(1.0 + true)).max())


def design_observer(
    plant: LinearPlant,
    cascade: Cascade,
    filter: str = "binomial2",
    *,
    cutoff: float | None = None,
    peak_sensitivity: float = PEAK_SENSITIVITY,
    perturbation: Perturbation | None = None,
) -> ObserverDesign:
    """Return the observer with the largest Q that both limits allow, or with a given Q that they allow.

    The limits: |T·Delta| ≤ 1 at every frequency (eq. (8)), and a peak sensitivity of the whole loop, in which cascade
    and observer are opened at the plant's input together.

    cutoff: Cutoff of Q [Hz], where it is given instead of sought.
    peak_sensitivity: Largest M_s of the whole loop, a factor above 1.
    perturbation: Delta, measured or of a model; the plant's delay alone where not given.
    Raises FricError: When the loop misses the peak sensitivity without an observer, or a given cutoff is beyond a
        limit: with the nearest that holds.
    """
    nyquist = cascade.sampling / 2
    Delta = perturbation or model_perturbation(plant, nyquist)
    whole = WholeLoop(plant, cascade, Delta)
    without = whole.peak()
    if without > peak_sensitivity:
        raise _too_sensitive(whole, without, peak_sensitivity)
    robust = robust_limit(Delta, filter)
    sensitive = _sensitive_limit(whole, filter, peak_sensitivity)
    limits = {
        f"eq. (8), |T·Delta| ≤ 1, at {robust.frequency:.4g} Hz": robust.q,
        f"the peak sensitivity of the whole loop, {decibel(peak_sensitivity):.3g} dB": sensitive,
    }
    bounds = {why: q.cutoff for why, q in limits.items() if q is not None}
    if not bounds:
        raise FricError(
            "nothing limits Q: the response shows no unmodelled dynamics, and the loop is insensitive at every cutoff",
            hint="Give the cutoff.",
        )
    why = min(bounds, key=bounds.__getitem__)
    if cutoff is None:
        q, reason = QFilter(filter, bounds[why]), f"limited by {why}"
    else:
        q, reason = QFilter(filter, cutoff), f"given; the limit is {bounds[why]:.4g} Hz by {why}"
        if cutoff > bounds[why] * (1 + 1e-6):
            hint = f"The nearest that holds is {rounded_down(bounds[why])} Hz."
            raise FricError(f"a cutoff of {cutoff:.4g} Hz is beyond the limit by {why}", hint=hint)
    observer = DisturbanceObserver(q, plant.A, plant.B)
    return ObserverDesign(
        plant, cascade, observer, Delta, robust, sensitive, peak_sensitivity,
        whole.margins((observer,)), whole.margins(), reason, _warnings(Delta, q),
    )  # fmt: skip


def _too_sensitive(whole: WholeLoop, without: float, asked: float) -> FricError:
    """Return the error of a loop that is too sensitive without an observer: of its controller, or of the response.

    The controller is blamed where the response is known well; where it is not, nothing is known of the loop.
    """
    Delta = whole.perturbation
    if Delta.measured and WholeLoop(whole.plant, whole.cascade, Delta.sure()).peak() <= asked:
        f, radius = Delta.frequency, Delta.radius
        loop = np.abs(1.0 / (1.0 + whole.response()(f)))
        at = int(np.argmax(np.where(radius < SURE, 0.0, loop)))
        return FricError(
            f"the response does not tell whether the loop keeps {decibel(asked):.3g} dB: at {f[at]:.4g} Hz it is known "
            f"to {radius[at]:.0%} of G_n alone, and the loop is within that where it is known better",
            hint="Measure it again with more amplitude or more periods there, or leave these lines out.",
        )
    text = "is unstable" if without == inf else f"has a peak sensitivity of {decibel(without):.1f} dB"
    return FricError(
        f"the loop {text} without any observer, where {decibel(asked):.3g} dB is asked",
        hint="Lower the gains of the controller, or ask for a larger peak sensitivity.",
    )


def _sensitive_limit(whole: WholeLoop, filter: str, peak_sensitivity: float) -> QFilter | None:
    """Return the largest Q up to which every smaller one keeps the peak sensitivity too."""
    A, B, sampling = whole.plant.A, whole.plant.B, whole.cascade.sampling

    def keeps(cutoff: float) -> bool:
        return whole.peak((DisturbanceObserver(QFilter(filter, cutoff), A, B),)) <= peak_sensitivity

    tried = np.geomspace(2.5e-4 * sampling, 0.45 * sampling, TRIED)
    limit = largest_that_keeps(keeps, tried)
    if limit == 0.0:
        raise FricError(
            f"an observer of {tried[0]:.3g} Hz already misses the peak sensitivity that is asked",
            hint="Lower the gains of the controller, or ask for a larger peak sensitivity.",
        )
    return None if limit == inf else QFilter(filter, limit)


def largest_that_keeps(keeps: Callable[[float], bool], tried: Real, precision: float = 1e-6) -> float:
    """Return the largest value up to which every smaller one keeps a limit: 0 where none does, infinity where all do.

    tried: Values on the way up, rising, before the border is refined to a relative precision.
    """
    below = 0.0
    for above in map(float, tried):
        if not keeps(above):
            break
        below = above
    else:
        return inf
    return border(keeps, below, above, precision) if below else 0.0


def _warnings(Delta: Perturbation, q: QFilter) -> tuple[Notice, ...]:
    found = []
    if Delta.measured:
        first, last = Delta.frequency[0], Delta.frequency[-1]
        if last < 4 * q.bandwidth:
            found.append(RESPONSE_ENDS.found(last=last, bandwidth=q.bandwidth))
        if not Delta.radius.any():
            found.append(RESPONSE_WITHOUT_CONFIDENCE.found())
        if first > q.bandwidth:
            found.append(RESPONSE_BEGINS.found(first=first))
    return tuple(found)
