"""The gains of a cascade, from a circle on which reference, position and voltage of an axis were recorded."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fric.arrays import Real
from fric.circles.measured import MeasuredCircle
from fric.circles.motion import even
from fric.control.cascade import Cascade
from fric.drive.sensing import low_pass_pole
from fric.errors import FricError
from fric.estimate import Estimate

NAMES = ("K_v", "K_p", "K_i", "velocity_filter")
UNITS = ("1/s", "V*s/m", "V/m", "Hz")
START = 0.1
"""Share of a record that is left out: the filter's state where it begins is not known."""
SLOWEST = 900.0
"""Samples a second at least [Hz]."""
CORNERS = (0.02, 0.05, 0.12, 0.25)
"""Corners of the velocity filter that a search begins from, over the sampling rate."""
EXPLAINED = 0.9
"""Share of the voltage beyond what is fed forward that gains must explain, to be taken for those of the controller."""


@dataclass(frozen=True)
class FoundController:
    """A controller that a recorded voltage shows.

    cascade: the controller
    estimates: its gains with their 95 % intervals
    explained: share of the voltage beyond what is fed forward that it explains [1]
    """

    cascade: Cascade
    estimates: Mapping[str, Estimate]
    explained: float


def controller_of(test: MeasuredCircle, name: str) -> FoundController:
    """Return the cascade that gives the recorded voltage of an axis.

    ``u = K_p·e + K_i·∫e`` with ``e = K_v·(r - z) - ż`` of the filtered velocity, beside what is fed forward: any sum of
    the reference, its velocity, its acceleration and a constant, which is fitted and taken off. Position gain and
    integral time change places without a change of this sum; of both orders that is taken whose integral of the
    velocity of the reference, where that is fed forward, is the recorded one.

    test: The circle, without compensation of friction.
    name: Name of the axis.
    Raises FricError: When reference or voltage were not recorded, compensation was on, or no cascade gives this
        voltage.
    """
    trace, where = test.axis(name), f"{test.where}, axis {name}"
    if trace.reference is None or trace.input is None or test.scheme not in ("", "a"):
        raise FricError(
            "the controller's gains take a circle with reference and voltage, without compensation", where=where
        )
    t, (r, z, u) = even(trace.time, trace.reference, trace.position, trace.input)
    rate = 1.0 / float(t[1] - t[0])
    if rate < SLOWEST:
        raise FricError(f"the circle was recorded at {rate:.3g} Hz", where=where, hint=f"Record it at {SLOWEST:g} Hz.")
    fit = _Fit(r, z, u, rate)
    found, covariance = fit.best()
    explained = 1.0 - float(np.sum(fit.rest(found) ** 2)) / max(float(np.sum(fit.without**2)), 1e-300)
    values = dict(zip(NAMES, np.exp(found).tolist(), strict=True))
    if explained < EXPLAINED:
        raise FricError(
            f"no cascade gives the recorded voltage: the best explains {explained:.0%} of it", where=where,
            hint="Give the controller's gains.",
        )  # fmt: skip
    half = 1.96 * np.sqrt(np.diag(covariance))
    estimates = {
        key: Estimate(values[key], unit, (values[key] * float(np.exp(-h)), values[key] * float(np.exp(h))))
        for key, unit, h in zip(NAMES, UNITS, half, strict=True)
    }
    return FoundController(Cascade(**values, sampling=rate), estimates, explained)


class _Fit:
    """The recorded voltage beside that of a cascade, of which what is fed forward is taken off."""

    def __init__(self, r: Real, z: Real, u: Real, rate: float) -> None:
        self.rate, self.r, self.z, self.used = rate, r, z, slice(int(START * len(r)), None)
        velocity = np.gradient(r, 1 / rate)
        fed = np.column_stack([np.ones(len(r)), r, velocity, np.gradient(velocity, 1 / rate)])[self.used]
        size = np.abs(fed).max(axis=0)
        self.basis = np.linalg.qr(fed / np.where(size > 0, size, 1.0))[0]
        self.fed, self.u = fed, u[self.used]
        self.without = self._off(self.u)

    def _off(self, values: Real) -> Real:
        """Return values without what is fed forward."""
        return np.asarray(values - self.basis @ (self.basis.T @ values))

    def volts(self, log_values: Real) -> Real:
        """Return what a cascade gives without anything fed forward [V]."""
        from scipy.signal import lfilter

        K_v, K_p, K_i, corner = np.exp(log_values)
        pole = low_pass_pole(float(corner), self.rate)
        first = np.diff(self.z, prepend=2 * self.z[0] - self.z[1]) * self.rate
        seen = lfilter([1.0 - pole], [1.0, -pole], first, zi=[pole * first[0]])[0]
        error = K_v * (self.r - self.z) - seen
        return np.asarray(K_p * error + K_i / self.rate * np.cumsum(error))[self.used]

    def rest(self, log_values: Real) -> Real:
        """Return what a cascade leaves of the recorded voltage [V], beside what is fed forward."""
        return self.without - self._off(self.volts(log_values))

    def best(self) -> tuple[Real, Real]:
        """Return the logarithms of the gains, and how they err."""
        from scipy.optimize import least_squares

        tried = []
        for corner in CORNERS:
            start = np.append(self._linear(corner * self.rate), np.log(corner * self.rate))
            tried.append(least_squares(self.rest, start, x_scale=0.1, max_nfev=30))
        best = min(tried, key=lambda one: one.cost)
        found, other = best.x, best.x.copy()
        other[[0, 2]] = found[2] - found[1], found[0] + found[1]  # K_v and K_i/K_p in each other's place
        found = min((found, other), key=self._apart)
        rest, jacobian = self.rest(found), np.asarray(best.jac, float)
        alike = _alike(rest)
        return found, np.linalg.pinv(jacobian.T @ jacobian) * float(np.mean(rest**2)) * alike

    def _linear(self, corner: float) -> Real:
        """Return the logarithms of K_v, K_p and K_i that a fit linear in the sums of gains begins from."""
        error = self.r - self.z
        pole = low_pass_pole(corner, self.rate)
        from scipy.signal import lfilter

        rate_of = lfilter([1.0 - pole], [1.0, -pole], np.diff(error, prepend=error[0]) * self.rate)
        parts = np.column_stack([rate_of, error, np.cumsum(error) / self.rate])[self.used]
        D, P, integral = np.linalg.lstsq(
            np.column_stack([self._off(part) for part in parts.T]), self.without, rcond=None
        )[0]
        D = max(abs(float(D)), 1e-9)
        roots = np.abs(np.roots([1.0, -P / D, integral / D]))
        high, low = max(float(roots.max()), 1e-3), max(float(roots.min()), 1e-3)
        return np.log([high, D, low * D])

    def _apart(self, log_values: Real) -> float:
        """Return what is left with the velocity of the reference through the loop's integral [V²], or without."""
        _, _, K_i, _ = np.exp(log_values)
        others = np.linalg.qr(self.fed[:, [0, 2, 3]] / np.abs(self.fed[:, [0, 2, 3]]).max(axis=0))[0]
        rests = [self.u - self.volts(log_values) - share * K_i * self.fed[:, 1] for share in (0.0, 1.0)]
        return min(float(np.sum((one - others @ (others.T @ one)) ** 2)) for one in rests)


def _alike(rest: Real) -> float:
    """Return how many neighbouring samples tell as much as one."""
    n = len(rest)
    spectrum = np.abs(np.fft.rfft(rest - rest.mean(), 2 * n)) ** 2
    likeness = np.fft.irfft(spectrum)[:n]
    likeness = likeness / max(float(likeness[0]), 1e-300)
    ends = np.flatnonzero(likeness < 0)
    return 1.0 + 2.0 * float(np.sum(likeness[1 : ends[0] if ends.size else n]))
