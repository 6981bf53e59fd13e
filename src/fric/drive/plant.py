"""The plant of one axis, eq. (1) of the paper."""

from dataclasses import dataclass, fields
from math import pi

import numpy as np

from fric.arrays import Complex, Real
from fric.errors import FricError
from fric.estimate import GAIN
from fric.kernels.elementary import exp, expm1
from fric.series import largest, real, require_plausible
from fric.verb import require_within

CURRENT_LOOP = 500.0  # Bandwidth that is assumed of a current loop [Hz]: that of slow servo drives
OF_EFFORT = 0.5 / (pi * CURRENT_LOOP) + 0.5 / 4000.0  # Delay assumed of an effort [s]: its loop, half a held sample
MOST_SAMPLES = 400  # Samples that a delay is at most: each is a state of the loop, whose eigenvalues take their cube


def hold_delay(sampling: float) -> float:
    """Return the delay [s] of a zero-order hold at a rate [Hz], half a sample: a lower bound of T_d."""
    return 0.5 / sampling


@dataclass(frozen=True)
class LinearPlant:
    """A mass with linear damping, driven by a voltage through a delay, eq. (1): ``B·e^(-s·T_d) / (s·(s + A))``.

    A: Linear damping of the drive itself (back-EMF, eddy currents) [1/s].
    B: Acceleration per volt [m/(s²·V)].
    T_d: Delay that is seen in the measured response [s]; half a sample of it is the hold of the controller's output.
    Raises FricError: When a value is not positive (A and T_d may be zero).
    """

    A: float
    B: float
    T_d: float

    def __post_init__(self) -> None:
        signs = {"A": "[0", "T_d": "[0", "force_lag": f"[{-GAIN}"}
        ranges = {field.name: f"{signs.get(field.name, f'[{1 / GAIN}')}, {GAIN}]" for field in fields(self)}
        require_within(self, "the plant", **ranges)

    def transport_delay(self, sampling: float) -> float:
        """Return the delay of eq. (1) without the hold of a controller that samples at ``sampling`` [Hz], in s.

        Raises FricError: When T_d is shorter than half a sample, or the rate is none.
        """
        if not 0 < sampling <= largest("frequency"):
            raise FricError(f"the sampling is {sampling:g} Hz", hint="Give the rate of the controller.")
        if self.T_d * sampling > MOST_SAMPLES:
            samples = f"{self.T_d * sampling:.3g} samples at {sampling:g} Hz"
            what = f"the delay T_d of {self.T_d:g} s is {samples}, and {MOST_SAMPLES} are at most"
            raise FricError(what, hint="Look at T_d and at the sampling.")
        delay = self.T_d - hold_delay(sampling)
        if delay < -1e-12:
            what = f"the delay T_d of {self.T_d:g} s is shorter than half a sample ({hold_delay(sampling):g} s)"
            hint = "T_d is what a measured response shows, the hold of the controller's output included."
            raise FricError(what, hint=hint)
        return max(delay, 0.0)

    def response(self, frequency: Real, hold: float | None = None) -> Complex:
        """Return Z/U [m/V] at frequencies [Hz], shape (n,); with a hold [Hz], from sample to sample behind it, exactly.

        An axis is held by no spring, and has no response at 0 Hz.

        The hold's half sample is in T_d, and only the rest of it is transport; the other effects of hold and sampling
        (2.6 % of magnitude at an eighth of the sampling rate) are in the response.
        """
        f = real(frequency, "response", "frequency")
        require_plausible("frequency", f, "frequency", "response")
        if not f.all():
            raise FricError("an axis is held by no spring, and has no response at 0 Hz", hint="Begin above 0 Hz.")
        if hold is not None:
            return SampledPlant.of(self, hold).response(f, hold)
        s = 2j * np.pi * f
        return np.asarray(self.B * np.exp(-s * self.T_d) / (s * (s + self.A)))

    def held(self, T: float) -> tuple[Real, Real]:
        """Return Phi (2, 2) and Gamma (2,) of the plant without delay, exact for an input held over T [s].

        ``[z, ż](t + T) = Phi·[z, ż](t) + Gamma·u``
        """
        x = self.A * T
        if x < 1e-3:  # the closed forms cancel; the next term of the series is below 1e-13
            once = T * (1 - x / 2 * (1 - x / 3 * (1 - x / 4)))
            twice = T * T / 2 * (1 - x / 3 * (1 - x / 4 * (1 - x / 5)))
        else:
            once = -expm1(-x) / self.A
            twice = (T - once) / self.A
        return np.array([[1.0, once], [0.0, exp(-x)]]), self.B * np.array([twice, once])


@dataclass(frozen=True)
class Plant(LinearPlant):
    """The plant with its force scale: ``z̈ = B·u(t - T_d) - A·ż - (F + load)/M`` with friction and a constant load.

    A, B, T_d: As in `LinearPlant`.
    K_f: Force constant [N/V].
    force_lag: Lag of the logged force behind the voltage that makes it [s].
    """

    K_f: float
    force_lag: float = 0.0

    @property
    def M(self) -> float:
        """Moving mass ``K_f/B`` [kg]."""
        return self.K_f / self.B

    @property
    def damping(self) -> float:
        """Linear damping ``M·A`` [N·s/m]: part of a force logged at constant velocity besides friction."""
        return self.M * self.A


@dataclass(frozen=True)
class SampledPlant:
    """Eq. (1) behind a zero-order hold, sampled: x[n+1] = Phi x[n] + late·u[n−whole−1] + early·u[n−whole]."""

    Phi: Real  # State matrix of [position, velocity], shape (2, 2)
    late: Real  # late, early: the effect of the older and of the newer of two inputs on a sample, each of shape (2,)
    early: Real
    whole: int  # Whole samples of transport delay

    @classmethod
    def of(cls, plant: LinearPlant, sampling: float) -> "SampledPlant":
        """Return the plant sampled at a rate [Hz]; raise `FricError` where T_d is shorter than half a sample."""
        delay, T_s = plant.transport_delay(sampling), 1.0 / sampling
        whole = int(delay / T_s + 1e-9)
        share = max(delay - whole * T_s, 0.0)
        Phi, _ = plant.held(T_s)
        Phi_early, early = plant.held(T_s - share)
        _, late = plant.held(share)
        moved = Phi_early[:, 0] * late[0] + Phi_early[:, 1] * late[1]  # sums in this order, on every processor
        return cls(Phi, moved, early, whole)

    def response(self, frequency: Real, sampling: float) -> Complex:
        """Return Z/U from sample to sample [m/V], shape (n,), at frequencies [Hz], shape (n,)."""
        step = np.expm1(2j * np.pi * np.asarray(frequency, float) / sampling)  # z − 1, exact at low frequencies
        z = 1.0 + step
        position, velocity = (self.early[i] + self.late[i] / z for i in (0, 1))
        kept = 1.0 - self.Phi[1, 1]
        return np.asarray(z**-self.whole * (position + self.Phi[0, 1] * velocity / (step + kept)) / step)
