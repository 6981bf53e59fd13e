"""Design of a control block, alone or with the cascade, up to the limit of the peak sensitivity of the whole loop."""

from dataclasses import dataclass, replace
from math import inf, log

import numpy as np

from fric.arrays import Real
from fric.control import ControlBlock, Setting
from fric.control.cascade import Cascade
from fric.design.loop import Loop, Margins, OpenLoop, cut, decibel
from fric.design.observer import PEAK_SENSITIVITY, Perturbation, WholeLoop, largest_that_keeps, model_perturbation
from fric.errors import FricError
from fric.search import minimised

TRIED = 25
GAINS = (0.25, 6.0)  # How much K_p and K_i together, and K_v, may differ from those of the present cascade, as factors
FILTER = 1.0  # Largest corner of the velocity filter over the sampling rate: there it is the plain first difference
STEPS = 160  # Loops that are tried; with twice as many J falls by less than 1 % on the axes of the paper
PERIOD = 2.0  # Time between two like reversals of the disturbance [s]
STEEPNESS = 30.0  # What a peak sensitivity that is too large by a share costs, in the logarithm of J


@dataclass(frozen=True)
class BlockDesign:
    """A control block, and the margins of the whole loop with it, opened at the plant's input."""

    block: ControlBlock  # The block
    margins: Margins | None  # Margins with it, around rest where it is not linear; None without feedback or margins
    reason: str  # Reason for its parameters
    response: OpenLoop | None = None  # The open loop as a function of the frequencies [Hz], where it has margins

    def __post_init__(self) -> None:
        self.block.check({parameter.name: getattr(self.block, parameter.name) for parameter in self.block.parameters})

    def loops(self) -> dict[str, Loop]:
        """Return the whole loop with its margins, if any."""
        if self.margins is None or self.response is None:
            return {}
        title = f"with {self.block.name}" + ("" if self.block.linear else ", around rest")
        return {"input": Loop(title, self.response, self.margins)}


def design_block(
    kind: type[ControlBlock], setting: Setting, *, peak_sensitivity: float = PEAK_SENSITIVITY,
    perturbation: Perturbation | None = None,
) -> BlockDesign:  # fmt: skip
    """Return a control block for an axis as its controller knows it.

    The tuned parameter of a controller or an observer is the largest up to which every smaller one keeps the peak
    sensitivity. A block that is not linear is judged around rest, where its gains are largest. Other blocks design
    themselves from plant and friction.

    peak_sensitivity: Largest M_s of the whole loop, a factor above 1.
    perturbation: Delta, measured; that of the plant's delay alone where not given.
    Raises FricError: When the loop misses the peak sensitivity at the smallest value already.
    """
    if not kind.tuned:
        return BlockDesign(kind.designed(setting), None, "from plant, friction and motion")
    Delta = perturbation or model_perturbation(setting.plant, setting.sampling / 2)
    cascade = Cascade.designed(setting)

    def keeps(value: float) -> bool:
        loop, blocks = loop_with(kind.tuned_to(value, setting), cascade, Delta, setting)
        return loop.peak(blocks) <= peak_sensitivity

    tuned = next(parameter for parameter in kind.parameters if parameter.name == kind.tuned)
    found = largest_that_keeps(keeps, np.geomspace(tuned.lower, tuned.upper, TRIED), 1e-4)
    text = f"the peak sensitivity of the whole loop, {decibel(peak_sensitivity):.3g} dB"
    if found == 0.0:
        hint = "Lower the gains of the controller, or ask for a larger peak sensitivity."
        raise FricError(f"'{kind.name}' misses {text}, at the smallest {kind.tuned} already", hint=hint)
    value, reason = cut(min(found, 1e300)), f"limited by {text}"
    if found == inf:
        value, reason = tuned.upper, "limited by no margin, but by its bound"
    loop, blocks = loop_with(block := kind.tuned_to(value, setting), cascade, Delta, setting)
    return BlockDesign(block, loop.margins(blocks), reason, loop.response(blocks))


def loop_with(
    block: ControlBlock, cascade: Cascade, Delta: Perturbation, setting: Setting
) -> tuple[WholeLoop, tuple[ControlBlock, ...]]:
    """Return the whole loop with a block as its controller, or else the blocks to go with it."""
    controller, blocks = (block, ()) if block.kind == "controller" else (None, (block,))
    return WholeLoop(setting.plant, cascade, Delta, controller, setting), blocks


@dataclass(frozen=True)
class JointDesign:
    """A control block, and the cascade that it was designed with."""

    cascade: Cascade  # The cascade
    block: BlockDesign  # The block and its margins
    compliance: tuple[float, float]  # J of the loop, and that of the cascade that was there without the block [m/V]


def step_compliance(loop: WholeLoop, blocks: tuple[ControlBlock, ...] = ()) -> float:
    """Return J, how far a disturbance that steps by 1 V moves the axis at most [m/V]."""
    order = np.arange(1, int(loop.cascade.sampling / 2 * PERIOD), 2)
    f = order / PERIOD
    G = loop.sampled(()).G(f) * loop.perturbation.correction(f)
    harmonics = np.zeros(4 * order.size + 1, complex)
    harmonics[order] = G / (1.0 + loop.response(blocks)(f)) * 4.0 / (np.pi * order) / 2j
    return float(np.abs(np.fft.irfft(harmonics) * 2 * (harmonics.size - 1)).max()) / 2.0


def design_jointly(
    kind: type[ControlBlock], setting: Setting, *, peak_sensitivity: float = PEAK_SENSITIVITY,
    perturbation: Perturbation | None = None,
) -> JointDesign:  # fmt: skip
    r"""Return block and cascade that leave the least J within a peak sensitivity of the whole loop.

    A block that is designed for a cascade that is there takes what margin the cascade left. Designed together, both
    share it: what counts is how far the axis moves where friction changes its sign. In one period P, long after which
    nothing is left of it, a disturbance of 1 V reverses twice ::

        d(t) = Σ 4/(π·n)·sin(2π·n·t/P),  n odd,      z(t) = Σ 4/(π·n)·Im(G/(1 + L)·e^(2πj·n·t/P)),      J = max |z|/2

    with G and L as in `fric.design.loop`, up to half the sampling rate: J is the peak after a step of 1 V. It falls
    where the gains rise, and the peak sensitivity M_s of the whole loop, with the delay of the plant or its measured
    response in it, ends that.

    Searched are four logarithms: of K_p and K_i together, of K_v, of the corner of the velocity filter, and of what is
    tuned of the block. The block is then designed anew for the cascade that was found (`design_block`), so that every
    smaller value of it keeps the peak sensitivity too.

    kind: An observer or a controller with a parameter that is tuned.
    Raises FricError: When the block does not feed back, or no loop keeps the peak sensitivity.
    """
    if not kind.tuned or kind.kind == "feedforward":
        raise FricError(f"'{kind.name}' does not feed back", hint="Design it alone, not jointly with the cascade.")
    cascade, Delta = Cascade.designed(setting), perturbation or model_perturbation(setting.plant, setting.sampling / 2)
    tuned = next(parameter for parameter in kind.parameters if parameter.name == kind.tuned)

    def cascade_at(x: Real) -> Cascade:
        gain, position, corner = np.exp(x[:3])
        return replace(
            cascade, K_p=cascade.K_p * gain, K_i=cascade.K_i * gain, K_v=cascade.K_v * position,
            velocity_filter=cascade.velocity_filter * corner,
        )  # fmt: skip

    def cost(x: Real) -> float:
        here = replace(setting, cascade=(chosen := cascade_at(x)))
        whole, blocks = loop_with(kind.tuned_to(float(np.exp(x[3])), here), chosen, Delta, here)
        peak = whole.peak(blocks)
        if not np.isfinite(peak):
            return 1e3
        return log(step_compliance(whole, blocks)) + STEEPNESS * max(0.0, log(peak / peak_sensitivity))

    edge = log(max(FILTER * cascade.sampling / cascade.velocity_filter, 1.0))
    low = np.array([log(GAINS[0]), log(GAINS[0]), log(0.5), log(tuned.lower)])
    high = np.array([log(GAINS[1]), log(GAINS[1]), max(edge, log(0.6)), log(tuned.upper)])
    start = np.array([0.0, 0.0, max(edge, log(0.6)) - 0.05, log(_first(kind, setting, peak_sensitivity, Delta))])
    start, step = np.clip(start, low + 1e-9, high - 1e-9), np.array([0.4, 0.3, -0.2, 0.4])
    found = minimised("LN_SBPLX", cost, start, low, high, initial_step=step, maxeval=STEPS, xtol_abs=2e-3)
    chosen, names = cascade_at(found), ("K_p", "K_i", "K_v", "velocity_filter")
    chosen = replace(chosen, **{name: cut(float(getattr(chosen, name))) for name in names})  # rounded down
    block = design_block(kind, replace(setting, cascade=chosen), peak_sensitivity=peak_sensitivity, perturbation=Delta)
    whole, blocks = loop_with(block.block, chosen, Delta, replace(setting, cascade=chosen))
    before = step_compliance(WholeLoop(setting.plant, cascade, Delta))
    return JointDesign(chosen, block, (step_compliance(whole, blocks), before))


def _first(kind: type[ControlBlock], setting: Setting, peak_sensitivity: float, Delta: Perturbation) -> float:
    """Return what is tuned of the block for the cascade that is there; the typical value where none keeps M_s."""
    try:
        block = design_block(kind, setting, peak_sensitivity=peak_sensitivity, perturbation=Delta).block
    except FricError:
        return next(float(np.max(parameter.typical)) for parameter in kind.parameters if parameter.name == kind.tuned)
    return float(getattr(block, kind.tuned))
