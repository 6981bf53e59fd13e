"""The sampled loop of one axis, as frequency responses and as one state matrix.

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

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fric.arrays import Complex, Real
from fric.control.base import ControlBlock, Setting
from fric.control.cascade import Cascade
from fric.control.probe import Probed, impulses, probed
from fric.drive.plant import LinearPlant, SampledPlant
from fric.reference import Reference

LAST_VOLTAGE = ("input", "control")
"""Inputs of a block for the voltage one sample ago; without friction feedforward both are equal."""


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
    def _main(self) -> Probed:
        return probed(self.controller or self.cascade, self._setting)

    @cached_property
    def _others(self) -> list[tuple[float, Probed]]:
        """Each further block with its sign in the control voltage."""
        return [(-1.0 if block.kind == "observer" else 1.0, probed(block, self._setting)) for block in self.blocks]

    @property
    def _setting(self) -> Setting:
        return self.setting or Setting(self.plant, self.cascade)

    def _gives(self, inputs: Sequence[str], frequency: Real) -> Complex:
        return self._main.response(inputs, frequency, self.cascade.sampling)

    def G(self, frequency: Real) -> Complex:
        """Return the plant from sample to sample [m/V]."""
        return self.sampled.response(frequency, self.cascade.sampling)

    def velocity(self, frequency: Real, G: Complex | None = None) -> Complex:
        """Return the open velocity loop, L = C·G·D with the cascade; with a measured G [m/V] where given.

        The position loop is open where the reference follows the position.
        """
        held = self._gives(("reference", "measured"), frequency)
        return -held * (self.G(frequency) if G is None else G)

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
        for sign, block in ((1.0, self._main), *self._others):
            feedback -= sign * block.response(("measured",), frequency, self.cascade.sampling)
            if block.sees(LAST_VOLTAGE):
                kept -= sign * block.response(LAST_VOLTAGE, frequency, self.cascade.sampling) * before
        return np.asarray((self.G(frequency) if G is None else G) * feedback / kept)

    def state_matrix(self, position_loop: bool = True) -> Real:
        """Return the matrix that takes the closed loop's state from sample to sample, reference at rest.

        Without the position loop it is that of the velocity loop alone: the reference follows the position. The state
        is position, velocity, the inputs on their way, the newest first, and the states of the blocks.
        """
        plant, seen = self.sampled, ("measured",) if position_loop else ("measured", "reference")
        parts = [(1.0, self._main, seen), *((sign, block, ("measured",)) for sign, block in self._others)]
        sizes = [2, plant.whole + 1, *(len(block.C) for _, block, _ in parts)]
        x = np.eye(sum(sizes))  # every unit state at once, one a column
        motion, inputs, *memories = np.split(x, np.cumsum(sizes)[:-1])
        u, after = np.zeros(len(x)), []
        for (sign, block, followed), memory in zip(parts, memories, strict=True):
            change = block.A @ memory
            for names, source in ((followed, motion[0]), (LAST_VOLTAGE, inputs[0])):
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
        others = np.delete(eigenvalues, np.argmin(np.abs(eigenvalues - 1.0)))
        return bool(np.abs(others).max() < 1.0)


SHORT = 160  # Samples of the short period


def learned_share(block: ControlBlock, loop: SampledLoop, setting: Setting) -> tuple[float, float]:
    r"""Return how much of what a block learns of a period is left in the next, and the frequency [Hz] where most is.

    A block that repeats gives ``v[n] = -Σ h_z[k]·z[n-N-k] - Σ h_u[k]·u[n-N-k]``, N the period. With the loop without
    it, of sensitivity S, v moves the voltage by S·v and the position by G·S·v. So from one period to the next v is
    multiplied by::

        l = -(H_z·G + H_u/z)·S

    and dies out at every frequency, however long the period, where |l| < 1. H_z and H_u come from the impulse responses
    of its compiled step (`fric.control.probe`), of a short period with the same share of a sample: a delay by whole
    samples does not change |l|. K. Inoue, Practical design of repetitive control systems, Proc. IEEE CDC 1990.

    block: A block that repeats.
    setting: What the block is packed for.
    Raises FricError: When the motion does not repeat.
    """
    if setting.reference is None or not setting.reference.period:
        block.packed(setting)  # which raises the error of what is missing
        raise ValueError("a block that repeats did without a period")
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
