"""The sampled loop of one axis, as frequency responses and as one state matrix.

::

    r ──>(+)── K_v ──>(+)── C ──>(+)──> u ──> G ──┬──> z
          ^-           ^-         ^-              │
          │            D ─────────┼───────────────┤      velocity: first difference and low-pass
          │                       d̂ <── F, −Q·u ──┤      disturbance observer, where there is one
          └───────────────────────────────────────┘

with z = e^{jωT_s} throughout:

- C = K_p + K_i T_s z/(z − 1): the integral holds the error of the sample it acts in;
- D = (1 − p)/(1 − p z⁻¹) · (1 − z⁻¹)/T_s, p = exp(−2π·corner·T_s);
- G: eq. (1) behind a zero-order hold, exact, with the transport delay T_d − T_s/2 (the hold is the other half sample);
- F = Q·G_n⁻¹ and Q as the observer's difference equations have them.

The same loop runs, with friction and limits, in `fric.kernels.loop`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fric.drive.sampled import SampledPlant
from fric.drive.sensing import low_pass_pole

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.compensation.disturbance_observer import DifferenceEquation, DiscreteObserver, DisturbanceObserver
    from fric.drive.cascade import Cascade
    from fric.drive.plant import LinearPlant

    Real = NDArray[np.float64]
    Response = NDArray[np.complex128]


@dataclass(frozen=True)
class SampledLoop:
    """The loop of one axis.

    Parameters
    ----------
    plant
        Eq. (1) of the axis.
    cascade
        Its controller.
    observer
        Its disturbance observer, where it has one.

    Raises
    ------
    FricError
        When the plant's delay is shorter than the hold of the controller, or the observer does not fit the sampling.
    """

    plant: LinearPlant
    cascade: Cascade
    observer: DisturbanceObserver | None = None

    @property
    def nyquist(self) -> float:
        """Half the sampling rate [Hz]."""
        return self.cascade.sampling / 2

    @cached_property
    def sampled(self) -> SampledPlant:
        """The plant, sampled."""
        return SampledPlant.of(self.plant, self.cascade.sampling)

    @cached_property
    def filters(self) -> DiscreteObserver:
        """The observer's difference equations."""
        if self.observer is None:
            raise ValueError("this loop has no observer")
        return self.observer.discrete(self.cascade.sampling)

    def G(self, frequency: Real) -> Response:
        """Return the plant from sample to sample [m/V]."""
        return self.sampled.response(frequency, self.cascade.sampling)

    def C(self, frequency: Real) -> Response:
        """Return the velocity controller [V·s/m]."""
        step = np.expm1(2j * np.pi * np.asarray(frequency, float) * self.cascade.T_s)
        return np.asarray(self.cascade.K_p + self.cascade.K_i * self.cascade.T_s * (1.0 + step) / step)

    def D(self, frequency: Real) -> Response:
        """Return the velocity's first difference and low-pass [1/s]."""
        step = np.expm1(2j * np.pi * np.asarray(frequency, float) * self.cascade.T_s)
        p = low_pass_pole(self.cascade.velocity_filter, self.cascade.sampling)
        return np.asarray((1.0 - p) / (step + 1.0 - p) * step / self.cascade.T_s)

    def velocity(self, frequency: Real, G: Response | None = None) -> Response:
        """Return the open velocity loop L = C·G·D; with a measured G [m/V] where one is given."""
        return self.C(frequency) * (self.G(frequency) if G is None else G) * self.D(frequency)

    def position(self, frequency: Real, G: Response | None = None) -> Response:
        """Return the open position loop L = K_v·C·G/(1 + C·G·D), the velocity loop closed."""
        CG = self.C(frequency) * (self.G(frequency) if G is None else G)
        return self.cascade.K_v * CG / (1.0 + CG * self.D(frequency))

    def input(self, frequency: Real, G: Response | None = None) -> Response:
        """Return the loop opened at the plant's input, L = G·(C·(D + K_v) + F)/(1 − Q): all that feeds back at once."""
        feedback = self.C(frequency) * (self.D(frequency) + self.cascade.K_v)
        if self.observer is not None:
            F = self.filters.inverse.response(frequency, self.cascade.sampling)
            Q = self.filters.low_pass.response(frequency, self.cascade.sampling)
            feedback = (feedback + F) / (1.0 - Q)
        return (self.G(frequency) if G is None else G) * feedback

    def state_matrix(self, position_loop: bool = True) -> Real:
        """Return the matrix that takes the closed loop's state from sample to sample, reference at rest.

        Without the position loop it is that of the velocity loop alone. The state is position, velocity, the inputs
        on their way, position one sample ago, filtered velocity, the integral, and the memories of the observer.
        """
        cascade, plant = self.cascade, self.sampled
        order = self.filters.inverse.a.size - 1 if self.observer else 0
        sizes = [2, plant.whole + 1, 1, 1, int(cascade.K_i > 0), order, order]
        x = np.eye(sum(sizes))  # every unit state at once, one a column
        motion, inputs, seen, filtered, integral, inverse, low_pass = np.split(x, np.cumsum(sizes)[:-1])

        z = motion[:1]
        p = low_pass_pole(cascade.velocity_filter, cascade.sampling)
        filtered = p * filtered + (1.0 - p) * (z - seen) / cascade.T_s
        error = -filtered - (cascade.K_v * z if position_loop else 0.0)
        integral = integral + cascade.T_s * error
        u = cascade.K_p * error + cascade.K_i * integral.sum(axis=0)
        if self.observer is not None:
            drive, inverse = _advance(self.filters.inverse, inverse, z)
            u = u - (drive - low_pass[:1])
            _, low_pass = _advance(self.filters.low_pass, low_pass, u)
        inputs = np.vstack([u, inputs])  # newest first
        motion = plant.Phi @ motion + np.outer(plant.early, inputs[-2]) + np.outer(plant.late, inputs[-1])
        return np.vstack([motion, inputs[:-1], z, filtered, integral, inverse, low_pass])

    def poles(self) -> Response:
        """Return the eigenvalues of the closed loop, largest first."""
        eigenvalues = np.linalg.eigvals(self.state_matrix()).astype(complex)
        return eigenvalues[np.argsort(-np.abs(eigenvalues))]

    @property
    def stable(self) -> bool:
        """True when every eigenvalue of the closed loop lies inside the unit circle."""
        return bool(np.abs(self.poles()[0]) < 1.0)

    @property
    def velocity_stable(self) -> bool:
        """True when the velocity loop is stable by itself: without position loop and observer."""
        alone = SampledLoop(self.plant, self.cascade).state_matrix(position_loop=False)
        # Nothing feeds the position back: what the loop sees of it is the step since the last sample. With that step
        # in place of the position one sample ago, the position itself, an integrator, falls out of the state.
        seen = 3 + self.sampled.whole
        alone[seen] = alone[0]
        alone[:, seen] *= -1.0
        return bool(np.abs(np.linalg.eigvals(alone[1:, 1:])).max() < 1.0)


def _advance(equation: DifferenceEquation, memory: Real, x: Real) -> tuple[Real, Real]:
    """Return output and memory of a difference equation after one sample (direct form II, transposed)."""
    y = equation.b[0] * x + memory[:1]
    shifted = np.vstack([memory[1:], np.zeros_like(x)])
    return y, shifted + np.outer(equation.b[1:], x) - np.outer(equation.a[1:], y)
