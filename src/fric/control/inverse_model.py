"""The inverse-model disturbance observer of Section 4.2, and the two difference equations that the loop runs.

                      u_ff (friction feedforward)
                      ↓
    u_c ──→(+)──→ ───(+)──→ limit ──→ drive ──→ z
           ↑−      u_t (= limited voltage − u_ff)  │
           │        ↓                              │
           └─ d̂ ←─(+)←── −Q(z) ← u_t              │
                    ↑                              │
                    └──── Q·G_n⁻¹(z) ←─────────────┘

The observer does not see the friction feedforward: otherwise it would take the compensated friction for a disturbance
and compensate it twice. It sees the limited voltage: while the drive saturates, d̂ follows the voltage that the drive
receives and not the requested voltage, so it does not wind up.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import prod
from typing import Annotated, Self

import numpy as np
from numba import types

from fric.arrays import Real
from fric.control.base import ControlBlock, Setting
from fric.control.q_filter import QFilter
from fric.errors import FricError
from fric.exact import convolved, exponentials, matrix_exponential, polynomial, product
from fric.friction.base import Parameter
from fric.kernels.block import Sample, compiled_block
from fric.kernels.signatures import ARRAY, compiled
from fric.verb import refused, require_within


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
    size = (state.size - 1) // 2 + 1
    inverse, low_pass = state[1:size], state[size:]
    filtered(parameters[2 * size : 3 * size], parameters[3 * size :], low_pass, sample.control)
    position = sample.measured - state[0]
    estimate: float = filtered(parameters[:size], parameters[size : 2 * size], inverse, position) - low_pass[0]
    return estimate


@dataclass(frozen=True)
class DifferenceEquation:
    """A causal filter y[n] = Σ b_i x[n−i] − Σ_{i≥1} a_i y[n−i], with a_0 = 1."""

    b: Real  # b, a: coefficients of falling age, of one length
    a: Real


@dataclass(frozen=True)
class DiscreteObserver:
    """The observer as the loop runs it: d̂[n] = inverse(z)[n] − low_pass(u_t)[n].

    Both start at zero. ``inverse`` has no gain at rest (its b sums to 0), so it is fed the position less the
    position at the start. ``low_pass`` has b_0 = 0: d̂[n] needs u_t up to sample n−1 alone, there is no algebraic loop.
    """

    inverse: DifferenceEquation  # Q·G_n⁻¹, from position [m] to voltage [V]
    low_pass: DifferenceEquation  # Q, from voltage [V] to voltage [V]


@dataclass(frozen=True)
class DisturbanceObserver(ControlBlock):
    """An inverse-model disturbance observer, d̂ = Q·(G_n⁻¹ z − u_t), with G_n = B/(s(s + A)) (Section 4.2).

    q: The filter Q.
    A, B: The nominal plant G_n, eq. (1) without its delay [1/s], [m/(s²·V)].
    Raises FricError: When A is negative or B is not positive: G_n has no stable inverse.
    """

    name = "inverse-model"
    kind = "observer"
    linear = True
    asks = "the position, the voltage as limited less the friction feedforward, five states"
    step = _step

    q: QFilter
    A: Annotated[float, Parameter("rate", doc="damping of the nominal plant")]
    B: Annotated[float, Parameter("acceleration per input", doc="gain of the nominal plant")]

    def __post_init__(self) -> None:
        if not isinstance(self.q, QFilter):
            raise refused("DisturbanceObserver", "q as a QFilter", self.q)
        require_within(self, "the nominal plant", A="[0, inf)", B="(0, inf)")  # else it has no stable inverse

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

        Raises FricError: When the cutoff of Q is not below half the sampling rate, or so far below it that the
            coefficients do not hold the poles any more.
        """
        return _discrete(self.q, self.A, self.B, sampling)


@lru_cache(maxsize=64)
def _discrete(q: QFilter, A: float, B: float, sampling: float) -> DiscreteObserver:
    if not q.cutoff < sampling / 2:
        hint = "Choose a cutoff below half the sampling rate."
        raise FricError(f"a cutoff of {q.cutoff:g} Hz does not fit a sampling rate of {sampling:g} Hz", hint=hint)
    poles, zeros = q.poles.tolist(), q.zeros.tolist()
    # n equal poles are found from rounded coefficients to the n-th root of the rounding
    lowest = 10 * np.finfo(float).eps ** (1 / len(poles)) * sampling / (2 * np.pi)
    if q.cutoff < lowest:
        what = f"a cutoff of {q.cutoff:g} Hz is too low for {q.name} at a sampling rate of {sampling:g} Hz"
        raise FricError(what, hint=f"Choose a cutoff above {lowest:.2g} Hz.")
    unit_gain = (prod(-pole for pole in poles) / prod(-zero for zero in zeros)).real
    inverse = _tustin([*zeros, 0.0, -A], poles, unit_gain / B, sampling)
    return DiscreteObserver(inverse=inverse, low_pass=_held(zeros, poles, sampling))


def _tustin(zeros: Sequence[complex], poles: Sequence[complex], gain: float, sampling: float) -> DifferenceEquation:
    """Discretise gain·Π(s − zero)/Π(s − pole) by Tustin's rule, root by root."""
    c = 2 * sampling
    b: list[complex] = [gain]
    for zero in zeros:
        b = convolved(b, [c - zero, -(c + zero)])
    for pole in poles:
        b = [value / (c - pole) for value in b]
    for _ in range(len(poles) - len(zeros)):
        b = convolved(b, [1.0, 1.0])
    return DifferenceEquation(_real(b), _real(polynomial((c + pole) / (c - pole) for pole in poles)))


def _held(zeros: Sequence[complex], poles: Sequence[complex], sampling: float) -> DifferenceEquation:
    """Discretise Π(s − zero)/Π(s − pole), scaled to gain 1 at rest, exactly for an input held from sample to sample."""
    order, scale = len(poles), abs(poles[0])  # time in units of 1/scale: no huge entries in the matrix
    denominator = _real(polynomial(pole / scale for pole in poles)).tolist()
    numerator = [0.0] * (order - 1 - len(zeros)) + _real(polynomial(zero / scale for zero in zeros)).tolist()
    unit = scale / sampling  # of the companion matrix, with the input as a last state that is held
    held = [[*(-unit * value for value in denominator[1:]), unit]]
    held += [[unit * float(j == i) for j in range(order)] + [0.0] for i in range(order - 1)]
    step = matrix_exponential([*held, [0.0] * (order + 1)])[:order]
    a = _real(polynomial(exponentials(pole / sampling for pole in poles))).tolist()
    Phi, state, pulse = [row[:order] for row in step], [[row[order]] for row in step], [0.0]
    for _ in range(order):
        pulse.append(product([numerator], state)[0][0])
        state = product(Phi, state)
    b = [value.real for value in convolved(a, pulse)[: order + 1]]
    share = sum(a) / sum(b)
    return DifferenceEquation(np.array([value * share for value in b]), np.array(a))


def _real(values: Sequence[complex]) -> Real:
    """Return the real parts of coefficients whose roots come in conjugate pairs, shape (n,)."""
    return np.array([value.real for value in values])
