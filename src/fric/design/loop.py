"""The sampled loop of one axis, as frequency responses and as one state matrix; its margins and peak sensitivity.

::

    r ──> controller ──>(+)──> u ──> G ──┬──> z
             ^           ^-              │
             │           d̂ <── u, z ─────┤      observers, where there are any
             └───────────────────────────┘

with z = e^{jωT_s} throughout. G is eq. (1) behind a zero-order hold, exact, with the transport delay T_d − T_s/2 (the
hold is the other half sample). Controller and observers are probed from their compiled steps (`fric.control.probe`):
the loop that is judged here is the loop that runs, with friction and limits, in `fric.kernels.loop`. With the cascade
(`fric.control.cascade`) the response from reference to voltage is K_v·C, that from position to voltage -C·(K_v + D), C
being the velocity controller and D the velocity's filter.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import floor, log10
from typing import Any

import numpy as np

from fric.arrays import Complex, Real
from fric.control.base import ControlBlock, Setting
from fric.control.cascade import Cascade
from fric.control.probe import Probed, impulses, probed
from fric.drive.plant import LinearPlant, SampledPlant
from fric.reference import Reference

LAST_VOLTAGE = ("input", "control")  # Inputs for the voltage one sample ago; without friction feedforward equal
SHORT = 160  # Samples of the short period
OpenLoop = Callable[[Real], Complex]
DECADES, POINTS = 5, 1500


@dataclass(frozen=True)
class SampledLoop:
    """The loop of one axis.

    Raises FricError: When the plant's delay is shorter than the hold of the controller, or a block does not suit the
        sampling.
    """

    plant: LinearPlant  # Eq. (1) of the axis.
    cascade: Cascade  # Its controller, and the sampling
    blocks: tuple[ControlBlock, ...] = ()  # Its further blocks; a block that is not linear is linearised around rest
    controller: ControlBlock | None = None  # The block in place of the cascade, if any
    setting: Setting | None = None  # What the blocks are packed for; the plant of the axis where not given

    @property
    def nyquist(self) -> float:
        """Half the sampling rate [Hz]."""
        return self.cascade.sampling / 2

    @cached_property
    def sampled(self) -> SampledPlant:
        """The plant, sampled."""
        return SampledPlant.of(self.plant, self.cascade.sampling)

    @cached_property
    def _parts(self) -> list[tuple[float, Probed]]:
        """The controller, and each further block, with its sign in the control voltage."""
        setting = self.setting or Setting(self.plant, self.cascade)
        signs = [1.0, *(-1.0 if block.kind == "observer" else 1.0 for block in self.blocks)]
        blocks = [self.controller or self.cascade, *self.blocks]
        return [(sign, probed(block, setting)) for sign, block in zip(signs, blocks, strict=True)]

    def _gives(self, inputs: Sequence[str], frequency: Real) -> Complex:
        return self._parts[0][1].response(inputs, frequency, self.cascade.sampling)

    def G(self, frequency: Real) -> Complex:
        """Return the plant from sample to sample [m/V]."""
        return self.sampled.response(frequency, self.cascade.sampling)

    def velocity(self, frequency: Real, G: Complex | None = None) -> Complex:
        """Return the open velocity loop, L = C·G·D with the cascade; with a measured G [m/V] where given.

        The position loop is open where the reference follows the position.
        """
        return -self._gives(("reference", "measured"), frequency) * (self.G(frequency) if G is None else G)

    def position(self, frequency: Real, G: Complex | None = None) -> Complex:
        """Return the open position loop, L = K_v·C·G/(1 + C·G·D) with the cascade, the velocity loop closed."""
        G = self.G(frequency) if G is None else G
        return self._gives(("reference",), frequency) * G / (1.0 + self.velocity(frequency, G))

    def input(self, frequency: Real, G: Complex | None = None) -> Complex:
        """Return the loop opened at the plant's input: all that feeds back at once.

        With observers of the position by F and of the voltage by Q it is L = G·(C·(D + K_v) + F)/(1 − Q).
        """
        before = np.exp(-2j * np.pi * np.asarray(frequency, float) / self.cascade.sampling)
        feedback, kept = np.zeros(before.shape, complex), np.ones(before.shape, complex)
        for sign, block in self._parts:
            feedback -= sign * block.response(("measured",), frequency, self.cascade.sampling)
            B, D = block.columns(LAST_VOLTAGE)
            if B.any() or D:
                kept -= sign * block.response(LAST_VOLTAGE, frequency, self.cascade.sampling) * before
        return np.asarray((self.G(frequency) if G is None else G) * feedback / kept)

    def state_matrix(self, position_loop: bool = True) -> Real:
        """Return the matrix that takes the closed loop's state from sample to sample, reference at rest.

        Without the position loop it is that of the velocity loop alone: the reference follows the position. The state
        is position, velocity, the inputs on their way, the newest first, and the states of the blocks.
        """
        plant, seen = self.sampled, ("measured",) if position_loop else ("measured", "reference")
        sizes = [2, plant.whole + 1, *(len(block.C) for _, block in self._parts)]
        x = np.eye(sum(sizes))  # every unit state at once, one a column
        motion, inputs, *memories = np.split(x, np.cumsum(sizes)[:-1])
        u, after = np.zeros(len(x)), []
        for n, ((sign, block), memory) in enumerate(zip(self._parts, memories, strict=True)):
            change = block.A @ memory
            for names, source in (("measured",) if n else seen, motion[0]), (LAST_VOLTAGE, inputs[0]):
                B, D = block.columns(names)
                change = change + np.outer(B, source)
                u = u + sign * D * source
            u = u + sign * (block.C @ memory)
            after.append(change)
        inputs = np.vstack([u, inputs])
        motion = plant.Phi @ motion + np.outer(plant.early, inputs[-2]) + np.outer(plant.late, inputs[-1])
        return np.vstack([motion, inputs[:-1], *after])

    def poles(self) -> Complex:
        """Return the eigenvalues of the closed loop, largest first."""
        eigenvalues = np.linalg.eigvals(self.state_matrix()).astype(complex)
        return eigenvalues[np.argsort(-np.abs(eigenvalues))]

    @property
    def stable(self) -> bool:
        """True when every eigenvalue of the closed loop lies inside the unit circle."""
        return bool(np.abs(self.poles()[0]) < 1.0)

    @property
    def velocity_stable(self) -> bool:
        """True when the velocity loop is stable by itself: without position loop and observers.

        Nothing feeds the position back: it is an integrator, with an eigenvalue at 1, which does not count.
        """
        alone = SampledLoop(self.plant, self.cascade, (), self.controller, self.setting)
        eigenvalues = np.linalg.eigvals(alone.state_matrix(position_loop=False))
        return bool(np.abs(np.delete(eigenvalues, np.argmin(np.abs(eigenvalues - 1.0)))).max() < 1.0)


def learned_share(block: ControlBlock, loop: SampledLoop, setting: Setting) -> tuple[float, float]:
    r"""Return how much of what a block learns of a period is left in the next, and the frequency [Hz] where most is.

    A block that repeats gives ``v[n] = -Σ h_z[k]·z[n-N-k] - Σ h_u[k]·u[n-N-k]``, N the period. With the loop without
    it, of sensitivity S, v moves the voltage by S·v and the position by G·S·v. So from one period to the next v is
    multiplied by::

        l = -(H_z·G + H_u/z)·S

    and dies out at every frequency, however long the period, where |l| < 1. H_z and H_u come from the impulse responses
    of its compiled step (`fric.control.probe`), of a short period with the same share of a sample: a delay by whole
    samples does not change |l|. K. Inoue, Practical design of repetitive control systems, Proc. IEEE CDC 1990.

    Raises FricError: When the motion does not repeat.
    """
    block.packed(setting)  # raises the error of what is missing
    assert setting.reference is not None
    sampling = setting.sampling
    period = (SHORT + setting.reference.period * sampling % 1.0) / sampling
    still = Reference(sampling, *(np.zeros(2) for _ in range(3)), period=period)
    short = replace(setting, reference=still, position=0.0, seen=0.0)
    f = np.geomspace(0.5, 0.999 * loop.nyquist, 1500)
    z = np.exp(2j * np.pi * f / sampling)

    def response(*inputs: str) -> Complex:
        h = impulses(block, short, inputs, 2 * SHORT, 2 * SHORT)
        return np.asarray(np.exp(-2j * np.pi * np.outer(f / sampling, np.arange(len(h)))) @ h)

    share = np.abs((response("measured") * loop.G(f) + response("input", "control") / z) / (1.0 + loop.input(f)))
    worst = int(np.argmax(share))
    return float(share[worst]), float(f[worst])


@dataclass(frozen=True)
class Margins:
    """How far an open loop L of a stable closed loop is from −1.

    What a loop does not have (no crossover, no bandwidth below half the sampling rate) is infinite.
    """

    crossover: float  # Frequency of the gain crossover that has the phase margin [Hz]
    phase_margin: float  # Smallest phase lag that would bring the loop to the edge of stability [rad]
    phase_crossover: float  # Frequency of the phase crossover that has the gain margin [Hz]
    gain_margin: float  # Smallest factor on the gain above 1 that would do so
    gain_reduction: float  # Largest factor below 1 that would do so; 0 where the gain may fall at will
    peak_sensitivity: float  # M_s = max |1/(1 + L)|; 1/M_s is the distance of L from −1
    peak_frequency: float  # Frequency at which it is [Hz]
    bandwidth: float  # First frequency at which |L/(1 + L)| has fallen by 3 dB [Hz]

    def as_dict(self) -> dict[str, Any]:
        """Return the margins as a document has them, in degrees and decibels; what is infinite is left out."""
        text: dict[str, tuple[float, str]] = {"phase_margin": (float(np.degrees(self.phase_margin)), "deg")}
        for name in ("gain_margin", "gain_reduction", "peak_sensitivity"):
            text[name] = (decibel(gain) if (gain := getattr(self, name)) else float("inf"), "dB")
        for name in ("crossover", "phase_crossover", "peak_frequency", "bandwidth"):
            text[name] = (getattr(self, name), "Hz")
        return {name: {"value": value, "unit": unit} for name, (value, unit) in text.items() if np.isfinite(value)}


@dataclass(frozen=True)
class Loop:
    """An open loop: its description, its response, its margins."""

    title: str  # What figures and tables call it
    response: OpenLoop  # L at frequencies [Hz], shape (n,)
    margins: Margins  # Its margins


def decibel(ratio: float) -> float:
    """Return a ratio of amplitudes in dB."""
    return float(20 * np.log10(ratio))


def rounded_down(value: float) -> str:
    """Return a positive number cut, not rounded, to four digits: what is named as allowed must be allowed."""
    return f"{cut(value, 4):.4g}"


def border(holds: Callable[[float], bool], inside: float, outside: float, precision: float = 1e-8) -> float:
    """Return the last admissible value between an admissible value and one beyond, to a relative precision."""
    while abs(outside / inside - 1.0) > precision:
        middle = float(np.sqrt(inside * outside))
        inside, outside = (middle, outside) if holds(middle) else (inside, middle)
    return float(inside)


def cut(value: float, digits: int = 3) -> float:
    """Return a value with some digits, rounded down; 0 stays 0."""
    scale = 10.0 ** (digits - 1 - floor(log10(value))) if value > 0 else 1.0
    return floor(value * scale) / scale


def grid(nyquist: float) -> Real:
    """Return the frequencies [Hz] on which crossovers are looked for: five decades up to half the sampling rate."""
    return np.geomspace(nyquist * 10.0**-DECADES, nyquist, POINTS)


def margins(loop: OpenLoop, nyquist: float) -> Margins:
    """Return the margins of an open loop, crossovers refined by root finding.

    loop: L at frequencies [Hz], shape (n,).
    nyquist: Half the sampling rate [Hz].
    """
    f = grid(nyquist)
    L = loop(f)

    def at(frequency: float) -> complex:
        return complex(loop(np.array([frequency]))[0])

    crossovers = _roots(f, np.log(np.abs(L)), lambda frequency: float(np.log(abs(at(frequency)))))
    phases = [(abs(float(np.angle(-at(root)))), root) for root in crossovers]
    phase_margin, crossover = min(phases, default=(np.inf, np.inf))

    turning = [root for root in _roots(f, L.imag, lambda frequency: at(frequency).imag) if at(root).real < 0]
    edge = [nyquist] if L[-1].real < 0 and abs(L[-1].imag) < 1e-9 * abs(L[-1]) else []
    gains = [(1.0 / abs(at(root)), root) for root in {*turning, *edge}]
    gain_margin, phase_crossover = min((pair for pair in gains if pair[0] >= 1.0), default=(np.inf, np.inf))
    gain_reduction = max((gain for gain, _ in gains if gain < 1.0), default=0.0)

    peak_frequency, peak = _peak(f, 1.0 / np.abs(1.0 + L), lambda frequency: 1.0 / abs(1.0 + at(frequency)))

    def closed(frequency: float) -> float:
        return float(np.log(abs(at(frequency) / (1.0 + at(frequency))) * np.sqrt(2.0)))

    falls = _roots(f, np.log(np.abs(L / (1.0 + L)) * np.sqrt(2.0)), closed)
    return Margins(
        crossover, phase_margin, phase_crossover, gain_margin, gain_reduction, peak, peak_frequency,
        falls[0] if falls else float("inf"),
    )  # fmt: skip


def _roots(f: Real, values: Real, function: Callable[[float], float]) -> list[float]:
    """Return the roots between grid points of opposite sign, the ends of the grid left out."""
    from scipy.optimize import brentq  # not at the start: simulations need no margins, and it takes 0.1 s

    places = np.flatnonzero(np.sign(values[:-2]) * np.sign(values[1:-1]) < 0)
    return [float(brentq(function, f[i], f[i + 1], xtol=1e-10 * f[i], rtol=1e-13)) for i in places]


def _peak(f: Real, values: Real, function: Callable[[float], float]) -> tuple[float, float]:
    """Return place and height of the highest point, refined between its neighbours on the grid."""
    from scipy.optimize import minimize_scalar

    top = int(np.argmax(values))
    ends = np.log(f[max(top - 1, 0)]), np.log(f[min(top + 1, f.size - 1)])
    found = minimize_scalar(lambda x: -function(np.exp(x)), bounds=ends, method="bounded", options={"xatol": 1e-9})
    refined = -float(found.fun)
    return (float(np.exp(found.x)), refined) if refined > values[top] else (float(f[top]), float(values[top]))
