"""Design of the cascade P/PI by gain and phase margin of the sampled open loops.

The gains are to hold the falling branch of the Stribeck curve, too. Behind a reversal an axis passes slowly through
speeds at which friction falls. Around a speed v a small error of speed changes friction by ``δF = -s'(v)/(1 +
s(v)/C·jω)·δv`` (eqs. (2) and (4), s(v)/C the lag of GMS), and the loop answers a force with the speed ``H =
jω·G/(K_f·(1 + L))``. Both feed each other: the error grows by itself where

    W(jω) = -s'(v)/(1 + jω·s(v)/C)·jω·G/(K_f·(1 + L))

goes around 1 (Nyquist). An oscillation grows from below the encoder's resolution, for any feedforward: at 10 mm/s by e⁵
and more on the machines with the largest errors. The inverse of the largest real W is the factor by which friction may
fall more steeply.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product
from math import inf, isfinite, pi, radians
from typing import Literal

import numpy as np

from fric.control import ControlBlock
from fric.control.cascade import Cascade
from fric.control.inverse_model import DisturbanceObserver
from fric.design.loop import Loop, Margins, SampledLoop, border, decibel, margins, rounded_down
from fric.design.observer import PEAK_SENSITIVITY, WholeLoop, model_perturbation
from fric.drive.plant import LinearPlant, Plant
from fric.errors import FricError
from fric.friction.gms import GMS

LOWEST = 1e-4  # Least corner of the velocity filter, and least crossover, over the sampling rate
TRIED = 40  # crossovers or gains tried across the range, before the border is refined
SPEEDS = 12  # Speeds at which the margin is looked for, from a twentieth to four times v_s
MARGIN = 1.25  # By what factor friction may fall more steeply than was identified, with gains that are designed
GAINS = ((1.0, 1.2, 1.4, 1.6, 1.8), (1.0, 0.6, 0.35), (1.0, 0.8, 0.6), (1.0, 2.0), (1.0, 0.75, 0.5))
"""What is tried, as factors: K_p, K_i over K_p, K_v, corner of the velocity filter, cutoff of the observer."""
FASTEST = 0.25  # Largest corner of the velocity filter, of the sampling rate


@dataclass(frozen=True)
class Requirement:
    """The margins that velocity loop and position loop must have."""

    phase_margin: float = radians(60.0)  # Phase margin [rad]
    gain_margin: float = 10 ** (13.8 / 20)  # Gain margin, a factor above 1

    def __post_init__(self) -> None:
        if not (0 < self.phase_margin < pi and 1 < self.gain_margin < inf):
            what = f"{np.degrees(self.phase_margin):.3g}° and {decibel(self.gain_margin):.3g} dB are not margins"
            raise FricError(what, hint="Give a phase margin between 0° and 180°, and a gain margin above 0 dB.")

    def met(self, found: Margins) -> bool:
        """Return whether the margins are met, to nine digits."""
        nearly = 1 - 1e-9
        return found.phase_margin >= self.phase_margin * nearly and found.gain_margin >= self.gain_margin * nearly


@dataclass(frozen=True)
class CascadeDesign:
    """A cascade with the margins of its loops."""

    plant: LinearPlant  # plant, cascade: the axis and its controller
    cascade: Cascade
    velocity: Margins  # Of the open velocity loop C·G·D
    position: Margins  # Of the open position loop, with the velocity loop closed
    input: Margins  # Margins at the plant's input, where both loops are opened at once

    def loops(self) -> dict[str, Loop]:
        """Return the open loops with their margins, by name."""
        loop = SampledLoop(self.plant, self.cascade)
        return {
            "velocity": Loop("velocity loop", loop.velocity, self.velocity),
            "position": Loop("position loop", loop.position, self.position),
            "input": Loop("plant input", loop.input, self.input),
        }


def assess_cascade(plant: LinearPlant, cascade: Cascade) -> CascadeDesign:
    """Return the margins of a cascade; they mean something only for a stable loop."""
    loop = SampledLoop(plant, cascade)
    for stable, name in ((loop.velocity_stable, "velocity"), (loop.stable, "position")):
        if not stable:
            raise FricError(f"the {name} loop is unstable with {_gains(cascade)}", hint="Lower the gains.")
    velocity, position, whole = (margins(L, loop.nyquist) for L in (loop.velocity, loop.position, loop.input))
    return CascadeDesign(plant, cascade, velocity, position, whole)


def design_cascade(
    plant: LinearPlant, requirement: Requirement | None = None, *, sampling: float = 4000.0,
    velocity_filter: float = 500.0, limit: float = inf, corner_ratio: float = 10.0, separation: float = 3.0,
    crossover: float | None = None,
) -> CascadeDesign:  # fmt: skip
    """Return the fastest cascade whose velocity loop and position loop have the required margins.

    The rule: the corner of the PI, K_i/(2π K_p), is ``1/corner_ratio`` of the velocity loop's crossover f_c; f_c
    is the highest at which the velocity loop has the margins; K_v = 2π f_c/``separation``, or the largest below it
    with which the position loop has them too. For both axes of the paper the gain margin decides; f_c is 60 Hz.

    requirement: The margins; 60° and 13.8 dB where not given.
    Others are those of `fric.design_controller`, in SI.
    Raises FricError: When no cascade of this form has the margins, or that with the given crossover: with the nearest.
    """
    asked = requirement or Requirement()
    for name, value in (("corner ratio", corner_ratio), ("separation", separation)):
        if not 1 <= value <= 1e4:
            raise FricError(f"a {name} of {value:g} makes no cascade", hint=f"Give a {name} from 1 to 10 000.")

    if velocity_filter < LOWEST * sampling:
        what = f"a velocity filter of {velocity_filter:g} Hz lets no velocity through at {sampling:g} samples a second"
        raise FricError(what, hint=f"Give {LOWEST * sampling:g} Hz or more.")

    def with_crossover(f_c: float) -> Cascade:
        rate = 2 * pi * f_c
        shape = Cascade(rate / separation, 1.0, rate / corner_ratio, velocity_filter, sampling, limit)
        gain = 1.0 / float(abs(SampledLoop(plant, shape).velocity(np.array([f_c]))[0]))
        return replace(shape, K_p=gain, K_i=gain * rate / corner_ratio)

    crossovers = np.geomspace(sampling * LOWEST, sampling * 0.45, TRIED)
    if crossover is None:
        found = _largest(lambda f_c: _holds(plant, with_crossover(f_c), asked, "velocity"), crossovers)
        if found is None:
            raise _infeasible(plant, [with_crossover(f_c) for f_c in crossovers], asked, "velocity")
        return assess_cascade(plant, _position_gain(plant, with_crossover(found), asked))
    if not 0 < crossover < sampling / 2:
        hint = "Give one between 0 and half the sampling rate."
        raise FricError(f"a crossover of {crossover:g} Hz does not fit a sampling rate of {sampling:g} Hz", hint=hint)
    return _checked(plant, asked, with_crossover, crossovers, crossover)


def check_cascade(plant: LinearPlant, cascade: Cascade, requirement: Requirement | None = None) -> CascadeDesign:
    """Return the design of a given cascade, if its loops are stable and have the margins.

    Raises FricError: When they have not: with the nearest gains that have, K_i/K_p kept.
    """

    def scaled(factor: float) -> Cascade:
        return replace(cascade, K_p=cascade.K_p * factor, K_i=cascade.K_i * factor)

    return _checked(plant, requirement or Requirement(), scaled, np.geomspace(1e-3, 1e3, TRIED), 1.0)


def _checked(
    plant: LinearPlant, asked: Requirement, made: Callable[[float], Cascade], tried: np.ndarray, wanted: float
) -> CascadeDesign:
    """Return the design of a cascade that a value makes, or raise with what it misses and the nearest that holds."""
    try:
        design = assess_cascade(plant, made(wanted))
    except FricError as error:
        complaint = error.what
    else:
        missed = [
            f"the {name} loop has a phase margin of {np.degrees(found.phase_margin):.1f}° and a gain margin of "
            f"{decibel(found.gain_margin):.1f} dB"
            for name, found in (("velocity", design.velocity), ("position", design.position))
            if not asked.met(found)
        ]
        if not missed:
            return design
        complaint = f"{' and '.join(missed)}, where {_wanted(asked)} are asked"
    none = "No gains of this ratio hold; ask for smaller margins, or for a lower corner of the PI."
    nearest = _nearest(lambda value: _holds(plant, made(value), asked, "velocity"), tried, wanted)
    held = None if nearest is None else _position_gain(plant, made(nearest), asked)
    raise FricError(complaint, hint=f"The nearest that holds is {_gains(held, rounded_down)}." if held else none)


def _holds(plant: LinearPlant, cascade: Cascade, asked: Requirement, name: Literal["velocity", "position"]) -> bool:
    """Return whether the velocity loop, or the position loop, is stable and has the margins."""
    loop = SampledLoop(plant, cascade)
    if not (loop.stable if name == "position" else loop.velocity_stable):
        return False
    found = margins(getattr(loop, name), loop.nyquist)
    return asked.met(found) and (isfinite(found.crossover) or (name == "velocity" and cascade.K_i == 0))


def _position_gain(plant: LinearPlant, cascade: Cascade, asked: Requirement) -> Cascade:
    """Return the cascade with its K_v, or with the largest below it for which the position loop has the margins."""
    tried = np.geomspace(1e-3 * cascade.K_v, cascade.K_v, TRIED)
    K_v = _largest(lambda K_v: _holds(plant, replace(cascade, K_v=K_v), asked, "position"), tried)
    if K_v is None:
        slower = [replace(cascade, K_v=cascade.K_v * factor) for factor in np.geomspace(1e-3, 1.0, TRIED)]
        raise _infeasible(plant, slower, asked, "position")
    return replace(cascade, K_v=K_v)


def _largest(holds: Callable[[float], bool], tried: np.ndarray) -> float | None:
    """Return the largest value that holds, between those tried; None where none does."""
    for n in range(tried.size - 1, -1, -1):
        if holds(tried[n]):
            return float(tried[n]) if n == tried.size - 1 else border(holds, tried[n], tried[n + 1])
    return None


def _nearest(holds: Callable[[float], bool], tried: np.ndarray, wanted: float) -> float | None:
    """Return the value that holds nearest to the wanted value, by their ratio; None where none holds."""
    if holds(wanted):
        return wanted
    found = next(filter(holds, sorted(tried, key=lambda value: abs(np.log(value / wanted)))), None)
    return None if found is None else border(holds, found, wanted)


def _infeasible(plant: LinearPlant, tried: list[Cascade], asked: Requirement, name: str) -> FricError:
    """Return the error with the possible margins: those of the tried cascade with the largest phase margin."""
    best: tuple[float, float] = (0.0, 1.0)
    for cascade in tried:
        if (loop := SampledLoop(plant, cascade)).velocity_stable and (name == "velocity" or loop.stable):
            found = margins(getattr(loop, name), loop.nyquist)
            if isfinite(found.phase_margin):
                best = max(best, (found.phase_margin, found.gain_margin))
    phase, gain = np.degrees(best[0]), decibel(best[1])
    hint = f"The nearest that holds is a phase margin of {phase:.1f}° with a gain margin of {gain:.1f} dB."
    what = f"no gain gives the {name} loop {_wanted(asked)}"
    return FricError(what, hint=hint if best[0] else "No gain makes it stable.")


def _wanted(asked: Requirement) -> str:
    return f"{np.degrees(asked.phase_margin):.3g}° and {decibel(asked.gain_margin):.3g} dB"


def _gains(cascade: Cascade, text: Callable[[float], str] = "{:.4g}".format) -> str:
    K_i = text(cascade.K_i) if cascade.K_i else "0"
    return f"K_p {text(cascade.K_p)}, K_i {K_i}, K_v {text(cascade.K_v)} (SI)"


def falling_margin(plant: Plant, cascade: Cascade, friction: GMS, blocks: tuple[ControlBlock, ...] = ()) -> float:
    """Return by what factor friction may fall more steeply before errors grow by themselves; below 1 they do.

    blocks: Further linear blocks in the loop, as a disturbance observer.
    """
    loop = WholeLoop(plant, cascade, model_perturbation(plant, cascade.sampling / 2))
    f, static = loop.f, friction.static
    turning = 2j * np.pi * f
    answer = turning * loop.G * loop.correction / (1.0 + loop.response(blocks)(f)) / plant.K_f
    v = static.v_s * np.geomspace(0.05, 4.0, SPEEDS)
    steepness = -(static.level(1.01 * v) - static.level(0.99 * v)) / (0.02 * v)
    largest = 0.0
    for steep, level in zip(steepness, static.level(v), strict=True):
        W = steep * answer / (1.0 + turning * level / friction.C)
        crossed = np.flatnonzero(np.diff(np.sign(W.imag)) != 0)
        share = W.imag[crossed] / (W.imag[crossed] - W.imag[crossed + 1])
        real = W.real[crossed] + share * (W.real[crossed + 1] - W.real[crossed])
        largest = max(largest, float(real.max(initial=0.0)))
    return 1.0 / largest if largest > 0 else float("inf")


def hold_falling(
    plant: Plant, cascade: Cascade, friction: GMS, observer: DisturbanceObserver | None = None
) -> tuple[Cascade, DisturbanceObserver | None]:
    """Return cascade and observer with the smallest change of their gains that holds the falling branch by `MARGIN`.

    The peak sensitivity of the whole loop stays within its limit. Unchanged where they hold the branch already;
    where none of `GAINS` does, those with the largest margin.
    """
    Delta = model_perturbation(plant, cascade.sampling / 2)
    fastest = max(FASTEST * cascade.sampling, cascade.velocity_filter)
    tried = sorted(product(*GAINS), key=lambda factors: sum(np.log(factor) ** 2 for factor in factors))
    best, most = (cascade, observer), 0.0
    for gain, integral, position, corner, cutoff in tried:
        other = replace(
            cascade, K_p=cascade.K_p * gain, K_i=cascade.K_i * gain * integral, K_v=cascade.K_v * position,
            velocity_filter=min(cascade.velocity_filter * corner, fastest),
        )  # fmt: skip
        if observer is None and cutoff != 1.0:
            continue
        watch = observer and replace(observer, q=replace(observer.q, cutoff=cutoff * observer.q.cutoff))
        blocks = (watch,) if watch else ()
        margin = falling_margin(plant, other, friction, blocks)
        if margin > most and (most == 0.0 or WholeLoop(plant, other, Delta).peak(blocks) <= PEAK_SENSITIVITY):
            best, most = (other, watch), margin
            if most >= MARGIN:
                break
    return best
