"""A linear block as matrices, found by probing its compiled step: no block describes itself twice."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from fric.arrays import Complex, Mask, Real
from fric.control.base import ControlBlock, Setting
from fric.kernels.block import BlockStep, Commands, Sample


@dataclass(frozen=True, eq=False)
class Probed:
    """A linear block: ``x[n+1] = A·x[n] + B·w[n]``, ``volts[n] = C·x[n] + D·w[n]``, w as in `Sample`.

    States that no input reaches, or that reach no output, are left out.
    """

    A: Real  # A, B, C, D: shapes (n, n), (n, inputs), (n,), (inputs,), the inputs in the order of `Sample`
    B: Real
    C: Real
    D: Real

    def columns(self, inputs: Sequence[str]) -> tuple[Real, float]:
        """Return B and D for some inputs alone, added up: they move together."""
        chosen = [Sample._fields.index(name) for name in inputs]
        return self.B[:, chosen].sum(axis=1), float(self.D[chosen].sum())

    @cached_property
    def _triangular(self) -> tuple[Complex, Complex]:
        if not self.A.size:
            return np.zeros((0, 0), complex), np.zeros((0, 0), complex)
        from scipy.linalg import schur  # not at the start: a contour needs no response, and it takes 0.1 s

        T, U = schur(self.A, output="complex")
        return T, U

    def response(self, inputs: Sequence[str], frequency: Real, sampling: float) -> Complex:
        """Return volts over the inputs, which move together, at frequencies [Hz], shape (n,)."""
        z = np.exp(2j * np.pi * np.asarray(frequency, float) / sampling)
        T, b, c, D = _driven(self, tuple(inputs))
        each = (slice(None), *(np.newaxis,) * z.ndim)
        x = np.empty((len(b), *z.shape), complex)
        for i in reversed(range(len(b))):  # backwards through (z - T)·x = b
            x[i] = (b[i] + np.sum(T[i, i + 1 :][each] * x[i + 1 :], axis=0)) / (z - T[i, i])
        return np.asarray(D + np.sum(c[each] * x, axis=0))


@lru_cache(maxsize=256)
def _driven(block: Probed, inputs: tuple[str, ...]) -> tuple[Complex, Complex, Complex, float]:
    """Return the triangular form of a block that some inputs drive together: T, b, c and D."""
    B, D = block.columns(inputs)
    T, U = block._triangular
    return T, U.conj().T @ B, block.C @ U, D


def probed(block: ControlBlock, setting: Setting) -> Probed:
    """Return the matrices of a block: the response of its step to each unit state and each unit input.

    They describe a linear block completely and exactly. A block that is not linear is linearised around rest, from
    states and inputs of 1e-6.

    Raises ValueError: When the block repeats, or is linear and gives something from nothing.
    """
    if block.repeats:
        raise ValueError(f"the block '{block.name}' repeats: it has as many states as the motion has samples")
    ready = block.ready(setting if block.linear else replace(setting, position=0.0, velocity=0.0, seen=0.0))
    rest = np.zeros(ready.state.size) if block.linear else ready.state
    return _probed(ready.step, ready.parameters.tobytes(), rest.tobytes(), 1.0 if block.linear else 1e-6)


def impulses(block: ControlBlock, setting: Setting, inputs: Sequence[str], wait: int, samples: int) -> Real:
    """Return the output of a linear block [V] over ``samples`` samples after 1 in some of its inputs, shape (samples,).

    ``wait`` are the samples of rest before, in which a block that repeats fills its memory.
    """
    step, _, state, parameters = block.ready(setting)
    state, rows = state.copy(), np.zeros((len(Commands._fields), wait + samples))
    hit = Sample(*(float(name in inputs) for name in Sample._fields))
    still = Sample(*[0.0] * len(hit))
    out = [step(hit if n == wait else still, n, rows, state, parameters) for n in range(wait + samples)]
    return np.array(out[wait:])


@lru_cache(maxsize=64)
def _probed(step: BlockStep, packed: bytes, at: bytes, unit: float) -> Probed:
    parameters, rest, rows = np.frombuffer(packed).copy(), np.frombuffer(at), np.zeros((len(Commands._fields), 1))
    size, inputs = rest.size, len(Sample._fields)

    def after(state: Real, given: Real) -> tuple[Real, float]:
        moved = rest + unit * state
        out = step(Sample(*(unit * given)), 0, rows, moved, parameters)
        return (moved - rest) / unit, out / unit

    if after(np.zeros(size), np.zeros(inputs))[1] != 0.0:
        raise ValueError("the step gives something from nothing")
    A, B, C, D = np.empty((size, size)), np.empty((size, inputs)), np.empty(size), np.empty(inputs)
    for n, array in enumerate(np.eye(size)):
        A[:, n], C[n] = after(array, np.zeros(inputs))
    for n, array in enumerate(np.eye(inputs)):
        B[:, n], D[n] = after(np.zeros(size), array)
    kept = _reached(A != 0.0, np.any(B != 0.0, axis=1)) & _reached(A.T != 0.0, C != 0.0)
    return Probed(A[np.ix_(kept, kept)], B[kept], C[kept], D)


def _reached(leads: Mask, start: Mask) -> Mask:
    """Return which states are reached from some, where ``leads[i, j]`` says that state j leads to state i."""
    reached = start
    while True:
        further = reached | (leads @ reached)
        if np.array_equal(further, reached):
            return reached
        reached = further
