"""A cascade whose gains, and whose integral, follow the stiffness of the friction since the last reversal.

After a reversal of the reference every slip block of the nominal friction sticks: the drive works against a spring.
Block i slips after a travel of ``2·alpha_i·F_s/k_i`` (Masing's rule). A distance x from the reversal::

    K(x)   = Σ k_i  over the blocks with  x/4 < 2·alpha_i·F_s/k_i,      share(x) = min(1, sqrt(K(x)/M)/corner)
    phi(x) = Σ alpha_i·min(1, x·k_i/(2·alpha_i·F_s))
    dI     = K_i·(1 + integral·share)·error·dt + carried·(I_before - I_turned)·dphi
    u      = K_p·(1 + proportional·share)·error + I,   error as that of the cascade

Gains: a drive on a spring is no double integrator. Below the spring's natural frequency sqrt(K/M) its phase does not
fall to -180°, and the integral may be as much stronger there. The corner, 0.4 of the velocity loop's crossover B·K_p,
is where the phase is needed. Where the blocks have slipped the gains are those of the cascade. For the gains the travel
counts a quarter: the friction may be softer than nominal. T. Tjahjowidodo, F. Al-Bender, H. Van Brussel, W. Symens,
Friction characterization and compensation in electro-mechanical systems, J. Sound and Vibration 308 (2007) 632-646.

Integral: its value at the end of a stroke, I_turned, is the sliding friction that is not fed forward, and the load. The
load stays, the share phi of the friction has changed its sign. The target is known: the stroke before, in the direction
that begins now, ended at the integral I_before. A reset of the integral, as that of J. C. Clegg, A nonlinear integrator
for servomechanisms, Trans. AIEE 77 (1958) 41-42, takes the load with it. The integral is carried over after strokes
that are longer than the whole schedule. After a shorter stroke, what was carried over is taken back.

Gains and phi depend on the reference alone: along a given reference the loop is linear and periodic, and its
multipliers over a period show whether it is stable (tests/control/test_gain_scheduled.py). As a block it is not linear.
"""

from dataclasses import dataclass
from typing import Annotated, Any, Self

import numpy as np

from fric.arrays import Real
from fric.control.base import ControlBlock, Setting
from fric.errors import FricError
from fric.friction.base import Parameter, Wrapped
from fric.friction.maxwell_slip import MaxwellSlip
from fric.kernels.block import Sample, compiled_block

SEEN, FILTERED, INTEGRAL, PENDING, TURNED, HEADING, LEVEL, BEFORE, ALONG, HANDED, DONE = range(11)
HEAD = 9
SOFTER = 4.0  # Factor by which the friction may be softer than nominal: the gains act over a travel longer by it


@compiled_block
def _step(sample: Sample, n: int, rows: Real, state: Real, parameters: Real) -> float:
    K_v, K_p, per_sample, pole, T_s = parameters[0], parameters[1], parameters[2], parameters[3], parameters[4]
    ahead, proportional, integral, carried = parameters[5], parameters[6], parameters[7], parameters[8]
    if sample.excess == 0.0 or sample.excess * state[PENDING] < 0.0:
        state[INTEGRAL] += state[PENDING]
    state[FILTERED] = pole * state[FILTERED] + (1.0 - pole) * (sample.measured - state[SEEN]) / T_s
    state[SEEN] = sample.measured
    if sample.velocity * state[HEADING] < 0.0 or state[HEADING] == 0.0:
        state[HANDED] *= -state[DONE]
        if abs(sample.reference - state[TURNED]) > parameters[parameters.size - 3]:
            opposite = state[ALONG] * state[HEADING] < 0.0
            state[HANDED] = carried * (state[BEFORE] - state[INTEGRAL]) if opposite else 0.0
            state[BEFORE], state[ALONG] = state[INTEGRAL], state[HEADING]
        state[TURNED], state[DONE] = sample.reference, 0.0
    if sample.velocity != 0.0:
        state[HEADING] = 1.0 if sample.velocity > 0.0 else -1.0
    away, share, turned = abs(sample.reference - state[TURNED]), 0.0, 0.0
    for i in range(parameters.size - 3, HEAD - 1, -3):
        if away < parameters[i]:
            share = parameters[i + 1]
        turned += parameters[i + 2] * min(1.0, SOFTER * away / parameters[i])
    state[INTEGRAL] += state[HANDED] * (turned - state[DONE])
    state[DONE] = turned
    state[LEVEL] = pole * state[LEVEL] + (1.0 - pole) * share
    error = K_v * (sample.reference - sample.measured) + ahead * sample.velocity - state[FILTERED]
    state[PENDING] = per_sample * (1.0 + integral * state[LEVEL]) * error
    volts: float = K_p * (1.0 + proportional * state[LEVEL]) * error + state[INTEGRAL] + state[PENDING]
    return volts


@dataclass(frozen=True)
class GainScheduled(ControlBlock):
    """The cascade with scheduled gains.

    proportional, integral: By which share of themselves K_p and K_i are larger while the friction is stiff [1].
    carried: Share of the change between two reversals that the integral is handed over at the next [1].
    """

    name = "gain-scheduled"
    kind = "controller"
    linear = False
    asks = "the position, a velocity from its first difference, the reference's reversals; eleven states"
    tuned = "proportional"
    step = _step

    proportional: Annotated[
        float, Parameter("ratio", 1e-3, 20.0, "what is added to K_p while friction is stiff", typical=0.3)
    ]
    integral: Annotated[
        float, Parameter("ratio", 0.0, 100.0, "what is added to K_i while friction is stiff", typical=5.0)
    ]
    carried: Annotated[float, Parameter("ratio", 0.0, 1.0, "what is handed over of the integral", typical=0.85)]

    @classmethod
    def tuned_to(cls, value: float, setting: Setting) -> Self:
        """Return the block with what is added to K_p, and twelve times as much added to K_i."""
        return cls(value, 12.0 * value, 0.85)

    def schedule(self, setting: Setting) -> Real:
        """Return how far from a reversal each share ends, the share, and alpha [m], [1], [1], shape (blocks, 3)."""
        model: Any = setting.models.get("gms") or setting.models.get("maxwell_slip")
        if model is None:
            raise FricError(
                "the gains of 'gain-scheduled' follow the friction's slip blocks, and the controller believes in none",
                hint="Identify them: fric identify gms.",
            )
        while isinstance(model, Wrapped):
            model = model.model
        W = np.array(model.W) if isinstance(model, MaxwellSlip) else model.static.F_s * np.array(model.alpha)
        if not W.any():
            raise FricError("no slip block takes a force", hint="Identify the friction again: fric identify gms.")
        k, W = np.array(model.k)[W > 0.0], W[W > 0.0]
        ends = SOFTER * 2.0 * W / k
        order = np.argsort(ends)
        stiffness = np.cumsum(k[order][::-1])[::-1]
        frequency = np.sqrt(stiffness * setting.plant.B / setting.K_f)
        corner = 0.4 * setting.plant.B * setting.cascade.K_p
        return np.column_stack([ends[order], np.minimum(1.0, frequency / corner), W[order] / W.sum()])

    def packed(self, setting: Setting) -> Real:
        """Return the cascade's gains, what is added to them, and the schedule."""
        cascade, added = setting.cascade.packed(setting), [self.proportional, self.integral, self.carried]
        return np.concatenate([cascade, added, self.schedule(setting).ravel()])

    def initial_state(self, setting: Setting) -> Real:
        """Return the cascade's state, and a reference that reverses where it begins."""
        return np.array([setting.seen, setting.velocity, 0.0, 0.0, setting.position, 0.0, 1.0, *(4 * [0.0])])
