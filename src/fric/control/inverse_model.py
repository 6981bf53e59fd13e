"""The inverse-model disturbance observer of Section 4.2, and the two difference equations that the loop runs.

                      u_ff (friction feedforward)
                      ↓
    u_c ──→(+)──→ ───(+)──→ limit ──→ drive ──→ z
           ↑−      u_t (= limited voltage − u_ff)  │
           │        ↓                              │
           └─ d̂ ←─(+)←── −Q(z) ← u_t              │
                    ↑                              │
                    └──── Q·G_n⁻¹(z) ←─────────────┘

The observer does not see the friction feedforward: one that does takes the compensated friction for a disturbance
that it has to undo, and compensates it twice. It sees the voltage as limited: while the drive saturates, d̂ follows
what the drive was given and not what was asked of it, so it does not wind up.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Self

import numpy as np
from numba import types

from fric.arrays import Complex, Real
from fric.control.base import ControlBlock, Setting
from fric.control.q_filter import QFilter
from fric.errors import FricError
from fric.friction.base import Parameter
from fric.kernels.block import ARRAY, Sample, compiled_block
from fric.kernels.signatures import compiled


@compiled(types.float64(ARRAY, ARRAY, ARRAY, types.float64), makes_arrays=False)
def filtered(b: Real, a: Real, memory: Real, x: float) -> float:
    """Advance a difference equation by one sample (direct form II, transposed)."""
    y: float = b[0] * x + memory[0]
    last = memory.size - 1
    for i in range(last):
        memory[i] = b[i + 1] * x - a[i + 1] * y + memory[i + 1]
    memory[last] = b[last + 1] * x - a[last + 1] * y
    return y


@compiled_block
def _step(sample: Sample, n: int, rows: Real, state: Real, parameters: Real) -> float:
    order = (state.size - 1) // 2
    size = order + 1
    inverse, low_pass = state[1:size], state[size:]
    filtered(parameters[2 * size : 3 * size], parameters[3 * size :], low_pass, sample.control)
    position = sample.measured - state[0]
    estimate: float = filtered(parameters[:size], parameters[size : 2 * size], inverse, position) - low_pass[0]
    return estimate


@dataclass(frozen=True)
class DifferenceEquation:
    """A causal filter y[n] = Σ b_i x[n−i] − Σ_{i≥1} a_i y[n−i], with a_0 = 1.

    Parameters
    ----------
    b, a
        Coefficients of falling age, of one length.
    """

    b: Real
    a: Real

    def response(self, frequency: Real, sampling: float) -> Complex:
        """Return the frequency response, shape (n,), at frequencies [Hz], shape (n,), for a sampling rate [Hz]."""
        z = np.exp(2j * np.pi * np.asarray(frequency, float) / sampling)
        return np.polyval(self.b, z) / np.polyval(self.a, z)


@dataclass(frozen=True)
class DiscreteObserver:
    """The observer as the loop runs it: d̂[n] = inverse(z)[n] − low_pass(u_t)[n].

    Both start at zero. ``inverse`` has no gain at rest (its b sums to 0), so it is fed the position less the
    position at the start. ``low_pass`` has b_0 = 0: d̂[n] needs u_t up to sample n−1 alone, there is no algebraic loop.

    Parameters
    ----------
    inverse
        Q·G_n⁻¹, from position [m] to voltage [V].
    low_pass
        Q, from voltage [V] to voltage [V].
    """

    inverse: DifferenceEquation
    low_pass: DifferenceEquation


@dataclass(frozen=True)
class DisturbanceObserver(ControlBlock):
    """An inverse-model disturbance observer, d̂ = Q·(G_n⁻¹ z − u_t), with G_n = B/(s(s + A)) (Section 4.2).

    Parameters
    ----------
    q
        The filter Q.
    A, B
        The nominal plant G_n, eq. (1) without its delay [1/s], [m/(s²·V)].

    Raises
    ------
    FricError
        When A is negative or B is not positive: G_n has no stable inverse.
    """

    name = "inverse-model"
    kind = "observer"
    linear = True
    asks = "the position, the voltage as limited less the friction feedforward, five states"
    parameters = (
        Parameter("A", "rate", doc="damping of the nominal plant"),
        Parameter("B", "acceleration per input", doc="gain of the nominal plant"),
    )
    step = _step

    q: QFilter
    A: float
    B: float

    def __post_init__(self) -> None:
        if not (self.A >= 0 and self.B > 0):
            raise FricError(
                f"the nominal plant with A = {self.A:g} 1/s and B = {self.B:g} m/(s²·V) has no stable inverse",
                hint="Give an A of 0 or more and a positive B.",
            )

    @classmethod
    def designed(cls, setting: Setting) -> Self:
        """Return the observer with the paper's Q, 60 Hz, and the nominal plant."""
        return cls(QFilter(), setting.plant.A, setting.plant.B)

    def packed(self, setting: Setting) -> Real:
        """Return the coefficients of both difference equations."""
        both = self.discrete(setting.sampling)
        return np.concatenate([both.inverse.b, both.inverse.a, both.low_pass.b, both.low_pass.a])

    def initial_state(self, setting: Setting) -> Real:
        """Return the position that the axis begins at, and the memories of both difference equations."""
        return np.concatenate([[setting.position], np.zeros(2 * len(self.q.poles))])

    def discrete(self, sampling: float) -> DiscreteObserver:
        """Return the difference equations of both filters for a sampling rate [Hz].

        Q on u_t is discretised exactly: the voltage is held from sample to sample, and the zero-order-hold
        equivalent of Q is what the continuous filter makes of it. Q·G_n⁻¹ on the position, which is a sampled
        continuous signal, is discretised by Tustin's rule s = (2/T_s)(z − 1)/(z + 1), root by root. Both are causal
        and proper.

        Raises
        ------
        FricError
            When the cutoff of Q is not below half the sampling rate, or so far below it that the coefficients do not
            hold the poles any more.
        """
        return _discrete(self.q, self.A, self.B, sampling)


@lru_cache(maxsize=64)
def _discrete(q: QFilter, A: float, B: float, sampling: float) -> DiscreteObserver:
    if not q.cutoff < sampling / 2:
        raise FricError(
            f"a cutoff of {q.cutoff:g} Hz does not fit a sampling rate of {sampling:g} Hz",
            hint="Choose a cutoff below half the sampling rate.",
        )
    poles, zeros = q.poles, q.zeros
    # n equal poles are found from rounded coefficients to the n-th root of the rounding
    lowest = 10 * np.finfo(float).eps ** (1 / poles.size) * sampling / (2 * np.pi)
    if q.cutoff < lowest:
        raise FricError(
            f"a cutoff of {q.cutoff:g} Hz is too low for {q.name} at a sampling rate of {sampling:g} Hz",
            hint=f"Choose a cutoff above {lowest:.2g} Hz.",
        )
    unit_gain = float(np.real(np.prod(-poles) / np.prod(-zeros)))
    return DiscreteObserver(
        inverse=_tustin([*zeros, 0.0, -A], poles, unit_gain / B, sampling),
        low_pass=_held(zeros, poles, unit_gain, sampling),
    )


def _tustin(zeros: Sequence[complex], poles: Complex, gain: float, sampling: float) -> DifferenceEquation:
    """Discretise gain·Π(s − zero)/Π(s − pole) by Tustin's rule, root by root."""
    c = 2 * sampling
    b, a = np.array([gain + 0j]), np.array([1.0 + 0j])
    for zero in zeros:
        b = np.convolve(b, [c - zero, -(c + zero)])
    for pole in poles:
        a = np.convolve(a, [1.0, -(c + pole) / (c - pole)])
        b = b / (c - pole)
    for _ in range(len(poles) - len(zeros)):
        b = np.convolve(b, [1.0, 1.0])
    return DifferenceEquation(b.real.copy(), a.real.copy())


def _held(zeros: Complex, poles: Complex, gain: float, sampling: float) -> DifferenceEquation:
    """Discretise gain·Π(s − zero)/Π(s − pole), of gain 1 at rest, exactly for an input held from sample to sample."""
    order, scale = len(poles), abs(poles[0])  # time in units of 1/scale: a companion matrix without huge entries
    denominator = np.real(np.poly(poles / scale))
    numerator = np.zeros(order)
    numerator[order - 1 - len(zeros) :] = np.real(np.poly(zeros / scale))
    numerator *= gain * scale ** (len(zeros) - order)
    held = np.zeros((order + 1, order + 1))
    held[0, :order] = -denominator[1:]
    held[1:order, : order - 1] = np.eye(order - 1)
    held[0, order] = 1.0
    step = _exponential(held * scale / sampling)
    a = np.real(np.poly(np.exp(poles / sampling))).copy()
    state, pulse = step[:order, order], [0.0]
    for _ in range(order):
        pulse.append(float(numerator @ state))
        state = step[:order, :order] @ state
    b = np.convolve(a, pulse)[: order + 1]
    return DifferenceEquation(b * (a.sum() / b.sum()), a)


def _exponential(matrix: Real) -> Real:
    """Return e^matrix by its series around zero, squared from there: SciPy's own takes 0.1 s to import."""
    squarings = max(0, int(np.frexp(np.linalg.norm(matrix, 1))[1]) + 1)
    found = term = np.eye(len(matrix))
    for n in range(1, 17):  # 2^-16/16! is below the last digit
        term = term @ matrix / (n * 2.0**squarings)
        found = found + term
    return np.linalg.matrix_power(found, 2**squarings)
