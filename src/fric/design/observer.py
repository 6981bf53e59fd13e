"""The disturbance observer: how far Q may reach by what the nominal plant leaves out, eqs. (7) and (8), and by Ms."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from fric.arrays import Complex, Real
from fric.control import ControlBlock, Setting
from fric.control.cascade import Cascade
from fric.control.inverse_model import DisturbanceObserver
from fric.control.q_filter import QFilter
from fric.design.loop import Loop, Margins, OpenLoop, SampledLoop, border, decibel, grid, margins, rounded_down
from fric.drive.plant import LinearPlant
from fric.errors import FricError
from fric.flaws.response import RESPONSE_BEGINS, RESPONSE_ENDS, RESPONSE_WITHOUT_CONFIDENCE
from fric.log import FrequencyResponse
from fric.notice import Notice
from fric.verb import require_within

CIRCLE_95 = float(np.sqrt(-2 * np.log(0.05)))  # Radius of 95 % of a complex normal error over its parts' deviation
SURE = 0.5
"""Radius below which a line without any perturbation has |Delta| and its confidence below 1: |Delta| is in it, too."""
Blocks = tuple[ControlBlock, ...]
PEAK_SENSITIVITY = 10 ** (6 / 20)
TRIED = 50  # cutoffs tried on the way up, before the border is refined


@dataclass(frozen=True)
class StructuralMode:
    """A structural mode that eq. (1) does not have: it takes G to G·(1 + share·s²/(s² + 2ζωs + ω²))."""

    frequency: float  # ω/2π [Hz]
    damping: float  # ζ, below 1
    share: float = 1.0  # Mobility over that of the rigid body, at the encoder: positive where it and motor are in phase

    def __post_init__(self) -> None:
        require_within(self, "the resonance", frequency="(0, inf)", damping="(0, 1)")
        if not self.share:
            raise FricError("the share of a resonance is 0", hint="Give another, or leave the resonance out.")

    def response(self, frequency: Real) -> Complex:
        """Return share·s²/(s² + 2ζωs + ω²) at frequencies [Hz], shape (n,)."""
        s = 1j * np.asarray(frequency, float) / self.frequency
        return np.asarray(self.share * s**2 / (s**2 + 2 * self.damping * s + 1))


@dataclass(frozen=True)
class Perturbation:
    """Delta = (G_m − G_n)/G_n, eq. (7), of an axis: measured, or of a model with what is known to be unmodelled."""

    frequency: Real  # Frequencies [Hz], increasing, shape (n,)
    Delta: Complex  # The perturbation of G_n = B/(s(s + A)), shape (n,)
    radius: Real  # Radius of the 95 % confidence circle of Delta, shape (n,); 0 for a model
    ratio: Complex  # G_m over eq. (1) with its delay, shape (n,): dynamics not modelled, without delay and hold.
    measured: bool  # True where it comes from a measured response

    @property
    def size(self) -> Real:
        """|Delta| with its confidence taken in, shape (n,)."""
        return np.abs(self.Delta) + self.radius

    def sure(self) -> "Perturbation":
        """Return it by the lines alone that are known well, to `SURE` of G_n."""
        kept, names = self.radius < SURE, ("frequency", "Delta", "radius", "ratio")
        return replace(self, **{name: getattr(self, name)[kept] for name in names})

    def correction(self, frequency: Real) -> Complex:
        """Return ``ratio`` between its frequencies, linearly; 1 beyond them. Shape (n,)."""
        if not self.frequency.size:
            return np.ones(np.shape(frequency), complex)
        real = np.interp(frequency, self.frequency, self.ratio.real, left=1.0, right=1.0)
        return real + 1j * np.interp(frequency, self.frequency, self.ratio.imag, left=0.0, right=0.0)


def model_perturbation(plant: LinearPlant, nyquist: float, resonances: Sequence[StructuralMode] = ()) -> Perturbation:
    """Return Delta of a model: the plant's delay, and resonances where some are known.

    plant: Eq. (1), of which G_n is all but the delay.
    nyquist: Highest frequency [Hz].
    resonances: Structural modes that eq. (1) does not have.
    """
    f = np.geomspace(nyquist * 1e-4, nyquist, 20_000)
    for mode in resonances:  # a peak is 2ζ wide
        around = mode.frequency * (1 + mode.damping * np.linspace(-10, 10, 2001))
        f = np.union1d(f, around[(around > 0) & (around < nyquist)])
    ratio = np.ones(f.size, np.complex128)
    for mode in resonances:
        ratio += mode.response(f)
    return Perturbation(f, ratio * np.exp(-2j * np.pi * f * plant.T_d) - 1.0, np.zeros(f.size), ratio, measured=False)


def measured_perturbation(
    response: FrequencyResponse, plant: LinearPlant, averages: int = 1, sampling: float | None = None,
    lowest: float = 0.0, deviating: Sequence[float] = (),
) -> Perturbation:  # fmt: skip
    """Return Delta from a measured response.

    response: The measured response Z/U, hold of the controller's output included.
    plant: Eq. (1) as it was fitted; its A and B are those of G_n.
    averages: Records that the coherence was averaged over.
    sampling: Sampling rate [Hz] of a response that was measured from sample to sample of the controller, hold and
        images in it; None for a response in continuous time.
    lowest: Lowest frequency at which the response shows the plant [Hz]: lines below it, and those below the first
        reliable line, are left out.
    deviating: Frequencies of further lines that do not show it [Hz].
    """
    f = response.frequency
    G_m = response.magnitude * np.exp(1j * response.phase)
    s = 2j * np.pi * f
    G_n = plant.B / (s * (s + plant.A))
    deviation = response.relative_deviation(averages)
    radius = CIRCLE_95 * (np.zeros(f.size) if deviation is None else deviation) * np.abs(G_m / G_n)
    sure = np.flatnonzero((radius < SURE) & (f >= lowest * (1 - 1e-9)))
    if sure.size:  # below the first reliable line, where friction hides the response, it does not show the plant
        kept = (f >= f[sure[0]]) & ~np.isclose(f[:, np.newaxis], np.array(deviating, float), rtol=1e-4).any(axis=1)
        f, G_m, G_n, radius = (values[kept] for values in (f, G_m, G_n, radius))
    return Perturbation(f, G_m / G_n - 1.0, radius, G_m / plant.response(f, sampling), measured=True)


@dataclass(frozen=True)
class RobustLimit:
    """How far Q may reach by eq. (8)."""

    q: QFilter | None  # Q at the limit; None where no frequency limits it
    frequency: float  # The frequency that limits it [Hz]
    size: float  # |Delta| there, with its confidence


def robust_limit(perturbation: Perturbation, filter: str = "binomial2") -> RobustLimit:
    """Return the largest Q for which |T·Delta| ≤ 1 at every frequency, eq. (8), and no smaller Q exceeds it either.

    For the nominal plant T = Q: the inner loop L = Q/(1 − Q) gives T = L/(1 + L) = Q, for any shape. At a
    frequency f with |Delta| = D > 1/max|Q| the condition is f ≥ r·cutoff, where r is the last place, in units of the
    cutoff, with |Q(r)| = 1/D; the limit is the smallest f/r of all.

    perturbation: Delta with its confidence.
    """
    shape = QFilter(filter, 1.0)
    r = np.geomspace(1e-3, 1e3, 6001)
    magnitude = np.abs(shape.response(r))
    top = float(r[int(np.argmax(magnitude))])
    level = 1.0 / np.maximum(perturbation.size, 1e-300)
    if not (bound := level < magnitude.max()).any():
        return RobustLimit(None, inf, float(perturbation.size.max()))
    f, level = perturbation.frequency[bound], level[bound]
    low, high = np.full(f.size, top), np.full(f.size, 1e6)  # |Q| falls from its top on
    for _ in range(100):
        middle = np.sqrt(low * high)
        above = np.abs(shape.response(middle)) > level
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    at = int(np.argmin(f / high))
    return RobustLimit(QFilter(filter, float(f[at] / high[at])), float(f[at]), float(1.0 / level[at]))


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
        with_it = Loop("with observer", whole.response((self.observer,)), self.input)
        return {"input": with_it, "without": Loop("without observer", whole.response(), self.without)}


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
        if not (loop := self.sampled(blocks)).stable:
            return inf
        L = loop.input(self.f, self.G)
        true = L * self.correction
        winding = np.unwrap(np.angle((1 + true) / (1 + L)))
        return inf if abs(winding[-1] - winding[0]) > np.pi else float((1.0 / np.abs(1.0 + true)).max())


def design_observer(
    plant: LinearPlant, cascade: Cascade, filter: str = "binomial2", *, cutoff: float | None = None,
    peak_sensitivity: float = PEAK_SENSITIVITY, perturbation: Perturbation | None = None,
) -> ObserverDesign:  # fmt: skip
    """Return the observer with the largest Q that both limits allow, or with a given Q that they allow.

    The limits: |T·Delta| ≤ 1 at every frequency (eq. (8)), and a peak sensitivity of the whole loop, in which cascade
    and observer are opened at the plant's input together.

    cutoff: Cutoff of Q [Hz], where it is given instead of sought.
    peak_sensitivity: Largest M_s of the whole loop, a factor above 1.
    perturbation: Delta, measured or of a model; the plant's delay alone where not given.
    Raises FricError: When the loop misses the peak sensitivity without an observer, or a given cutoff is beyond a
        limit: with the nearest that holds.
    """
    Delta = perturbation or model_perturbation(plant, cascade.sampling / 2)
    whole = WholeLoop(plant, cascade, Delta)
    if (without := whole.peak()) > peak_sensitivity:
        raise _too_sensitive(whole, without, peak_sensitivity)
    robust = robust_limit(Delta, filter)
    sensitive = _sensitive_limit(whole, filter, peak_sensitivity)
    limits = {
        f"eq. (8), |T·Delta| ≤ 1, at {robust.frequency:.4g} Hz": robust.q,
        f"the peak sensitivity of the whole loop, {decibel(peak_sensitivity):.3g} dB": sensitive,
    }
    if not (bounds := {why: q.cutoff for why, q in limits.items() if q is not None}):
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
    """Return the error of a loop too sensitive by itself: of its controller, or of a response known badly."""
    Delta = whole.perturbation
    if Delta.measured and WholeLoop(whole.plant, whole.cascade, Delta.sure()).peak() <= asked:
        f, radius = Delta.frequency, Delta.radius
        at = int(np.argmax(np.where(radius < SURE, 0.0, np.abs(1.0 / (1.0 + whole.response()(f))))))
        return FricError(
            f"the response does not tell whether the loop keeps {decibel(asked):.3g} dB: at {f[at]:.4g} Hz it is known "
            f"to {radius[at]:.0%} of G_n alone, and the loop is within that where it is known better",
            hint="Measure it again with more amplitude or more periods there, or leave these lines out.",
        )
    text = "is unstable" if without == inf else f"has a peak sensitivity of {decibel(without):.1f} dB"
    what = f"the loop {text} without any observer; a peak of {decibel(asked):.3g} dB was asked for"
    return FricError(what, hint="Lower the gains of the controller, or ask for a larger peak sensitivity.")


def _sensitive_limit(whole: WholeLoop, filter: str, peak_sensitivity: float) -> QFilter | None:
    """Return the largest Q up to which every smaller one keeps the peak sensitivity too."""
    A, B, sampling = whole.plant.A, whole.plant.B, whole.cascade.sampling

    def keeps(cutoff: float) -> bool:
        return whole.peak((DisturbanceObserver(QFilter(filter, cutoff), A, B),)) <= peak_sensitivity

    tried = np.geomspace(2.5e-4 * sampling, 0.45 * sampling, TRIED)
    if (limit := largest_that_keeps(keeps, tried)) == 0.0:
        what = f"an observer of {tried[0]:.3g} Hz already misses the peak sensitivity that is asked"
        raise FricError(what, hint="Lower the gains of the controller, or ask for a larger peak sensitivity.")
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
