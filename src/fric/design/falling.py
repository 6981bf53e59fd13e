"""Whether a loop holds the falling branch of the Stribeck curve, and gains with which it does.

Behind a reversal an axis passes slowly through speeds at which friction falls. Around a speed v a small error of speed
changes friction by ``δF = -s'(v)/(1 + s(v)/C·jω)·δv`` (eqs. (2) and (4), s(v)/C the lag of GMS), and the loop answers a
force with the speed ``H = jω·G/(K_f·(1 + L))``. Both feed each other: the error grows by itself where

    W(jω) = -s'(v)/(1 + jω·s(v)/C)·jω·G/(K_f·(1 + L))

goes around 1 (Nyquist). An oscillation grows from below the encoder's resolution, for any feedforward: at 10 mm/s by e⁵
and more on the machines with the largest errors. The inverse of the largest real W is the factor by which friction may
fall more steeply.
"""

from dataclasses import replace
from itertools import product

import numpy as np

from fric.control import ControlBlock
from fric.control.cascade import Cascade
from fric.control.inverse_model import DisturbanceObserver
from fric.design.observer import PEAK_SENSITIVITY, WholeLoop
from fric.design.perturbation import model_perturbation
from fric.drive.plant import Plant
from fric.friction.gms import GMS

SPEEDS = 12  # Speeds at which the margin is looked for, from a twentieth to four times v_s
MARGIN = 1.25  # By what factor friction may fall more steeply than was identified, with gains that are designed
GAINS = ((1.0, 1.2, 1.4, 1.6, 1.8), (1.0, 0.6, 0.35), (1.0, 0.8, 0.6), (1.0, 2.0), (1.0, 0.75, 0.5))
"""What is tried, as factors: K_p, K_i over K_p, K_v, corner of the velocity filter, cutoff of the observer."""
FASTEST = 0.25  # Largest corner of the velocity filter, of the sampling rate


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
