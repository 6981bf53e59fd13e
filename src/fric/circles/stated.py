"""The voltage that a stated controller gives along a recorded motion, beside the one that was recorded."""

from dataclasses import dataclass, replace

import numpy as np

from fric.arrays import Real
from fric.control.base import Setting
from fric.control.cascade import Cascade
from fric.drive.plant import LinearPlant
from fric.flaws.circle import ADDED_VOLTAGE_FOUND, CONTROLLER_DIFFERS, FEEDFORWARD_FOUND
from fric.kernels.block import Commands, Sample
from fric.log import Log
from fric.notice import Notice
from fric.statistics import robust_deviation

FED = 0.7
"""How much less a controller that feeds forward must miss the recorded voltage, to be taken for one."""
ALIKE = 0.06
"""Share of the fed back voltage by which a stated controller may miss it."""
GAIN = 0.1
"""By how much a gain may differ [1], where another one would explain what is missed."""
WINDOW = 0.01
"""Time over which means of a recorded voltage and of a stated one are compared [s]."""
TRIED, CLEAR = tuple(np.geomspace(0.25, 4.0, 17)), 0.8
"""Gains that are tried, over the stated ones, and what they may leave at most of what these leave."""
QUIET = 0.25
"""Share of what a controller misses in all, up to which its median is: the rest comes in pulses, and is added."""
ABOVE = 6.0
"""Times the spread of quiet samples above which a voltage is an added one."""


@dataclass(frozen=True)
class StatedController:
    """A recorded voltage beside that of the stated controller."""

    # recorded, given: both [V], shape (n,); the constant in which they differ, an integral that had begun before, is
    # taken out
    recorded: Real
    given: Real
    added: Real | None  # What was added to the controller's output [V], shape (n,); None where nothing is seen
    # What is left between them, without what was added, over the recorded voltage less what is fed forward [1]
    apart: float
    # K_p, K_i: gains that the recorded voltage shows, over the stated ones [1]; None for a gain that is stated as 0
    K_p: float
    K_i: float | None
    explained: float  # What even these leave, over the same [1]
    missed: float  # What is left between both in the median [V], whatever was added

    @property
    def as_stated(self) -> bool:
        """Whether the controller is as it was stated: it misses little, and no other gains would miss half of it."""
        other = max(abs(gain - 1.0) for gain in (self.K_p, self.K_i) if gain is not None) > GAIN
        return self.apart <= ALIKE and not (other and self.explained < 0.5 * self.apart)

    def describe(self) -> str:
        """Return what differs, in a sentence."""
        gains = f"K_p is {self.K_p:.2f} times" + ("" if self.K_i is None else f", K_i {self.K_i:.2f} times")
        alike = (
            "" if abs(self.K_p - (self.K_i or self.K_p)) > GAIN else " (as another K_v or a scaled voltage shows too)"
        )
        why = f"; it shows that {gains} what is stated{alike}" if self.explained < 0.5 * self.apart else ""
        return f"The stated controller misses the recorded voltage by {self.apart:.0%} of what is fed back{why}"


def stated_voltage(
    cascade: Cascade, plant: LinearPlant, reference: Real, measured: Real, rate: float, *, ahead: bool
) -> tuple[Real, Real, Real]:
    """Return what a controller gives along a recorded motion [V], (n,): all, its proportional part, its integral part.

    cascade: The controller.
    plant: The plant of its inverse model.
    reference, measured: Reference, and position as the encoder tells it [m], shape (n,).
    rate: Samples a second [Hz].
    ahead: Whether velocity and inverse model of the reference are fed forward.
    """
    own = replace(cascade, sampling=rate)
    velocity = np.gradient(reference, 1 / rate) if ahead else np.zeros(len(reference))
    acceleration = np.gradient(velocity, 1 / rate)
    seen = float(2 * measured[0] - measured[1])
    start = (float(measured[1]) - float(measured[0])) * rate
    ready = own.ready(Setting(plant, own, position=float(measured[0]), velocity=start, seen=seen))
    state, rows = ready.state.copy(), np.zeros((len(Commands._fields), 1))
    volts = np.array(
        [
            ready.step(Sample(r, v, a, z, 0.0, 0.0, 0.0, 0.0), 0, rows, state, ready.parameters)
            for r, v, a, z in zip(reference, velocity, acceleration, measured, strict=True)
        ]
    )
    # volts[n] = K_p·e[n] + K_i·T·Σe: the error follows from the volts, and both parts from that
    each, inverse = own.K_i / rate, 1.0 / (own.K_p + own.K_i / rate)
    error, total = np.empty(len(volts)), 0.0
    for n, u in enumerate(volts):
        error[n] = (u - each * total) * inverse
        total += error[n]
    proportional = own.K_p * error
    model = (acceleration + plant.A * velocity) / plant.B if ahead else np.zeros(len(volts))
    return volts + model, proportional, volts - proportional


def against_stated(
    cascade: Cascade, plant: LinearPlant, reference: Real, measured: Real, voltage: Real, rate: float, *, ahead: bool
) -> StatedController:
    """Hold a recorded voltage against that of the stated controller, and find what was added to it.

    A wrong gain misses wherever its part is; what was added to the output is in pulses that no gain makes, and the
    controller is between. Gains are those of both parts of the stated voltage that make most of the recorded one.

    cascade, plant, reference, measured, rate, ahead: As in `stated_voltage`.
    voltage: The recorded voltage [V], shape (n,).
    """
    given, proportional, integral = stated_voltage(cascade, plant, reference, measured, rate, ahead=ahead)
    rest = voltage - (given - proportional - integral)
    parts = np.column_stack([proportional, *([integral] if cascade.K_i > 0 else [])])
    seen, seen_parts = _smooth(rest, rate), np.column_stack([_smooth(part, rate) for part in parts.T])
    size = max(float(np.std(seen)), 1e-12)
    gains, constant = _gains(seen, seen_parts, 1e-3 * size)
    difference = voltage - given
    difference = difference - float(np.median(difference))
    missed = robust_deviation(difference)
    left = seen - seen_parts @ gains - constant
    spread = robust_deviation(left)
    swing, added = float(np.std(left)), None
    if spread < QUIET * swing and spread < ALIKE * size < swing:
        added = np.where(np.abs(left) > max(ABOVE * spread, 1e-3 * size), difference, 0.0)
        kept = added == 0.0
        difference, left = difference * kept, left * kept
    return StatedController(
        voltage, voltage - difference - (0.0 if added is None else added), added,
        float(np.std(_smooth(difference, rate))) / size, float(gains[0]),
        float(gains[1]) if cascade.K_i > 0 else None, float(np.std(left)) / size, missed,
    )  # fmt: skip


def _smooth(values: Real, rate: float) -> Real:
    """Return means over `WINDOW`, of fewer samples at the ends: noise of the log alone is all but gone."""
    window = np.ones(min(max(int(WINDOW * rate), 1), len(values)))
    return np.convolve(values, window, mode="same") / np.convolve(np.ones(len(values)), window, mode="same")


def _gains(rest: Real, parts: Real, least: float) -> tuple[Real, float]:
    """Return by how much each part of a controller's output is in what was recorded, and a constant [V].

    What was added to the output is in few samples, but where the controller answers it: least squares would take it for
    a gain. So of `TRIED` gains those are taken that leave most samples within `ABOVE` times what is left in the median,
    the stated ones unless others leave far more, and least squares go over these samples.
    """
    tried = [np.ones(parts.shape[1])]
    for size in TRIED:
        tried += [
            np.full(parts.shape[1], size),
            *(np.where(row, size, 1.0) for row in np.eye(parts.shape[1], dtype=bool)),
        ]
    rests = [rest - parts @ gains for gains in tried]
    rests = [one - np.median(one) for one in rests]
    scale = ABOVE * max(min(map(robust_deviation, rests)), least)
    losses = [float(np.mean(np.minimum((one / scale) ** 2, 1.0))) for one in rests]
    best = int(np.argmin(losses))
    near = np.abs(rests[best if losses[best] < CLEAR * losses[0] else 0]) < scale
    columns, found = np.column_stack([parts, np.ones(len(rest))]), np.append(tried[0], 0.0)
    for _ in range(3):
        if np.count_nonzero(near) < len(rest) // 2:
            near = np.ones(len(rest), bool)
        found, *_ = np.linalg.lstsq(columns[near], rest[near], rcond=None)
        near = np.abs(rest - columns @ found) < scale
    return found[:-1], float(found[-1])


def controller_behind(
    log: Log, plant: LinearPlant, cascade: Cascade, reference: Real, voltage: Real, rate: float
) -> tuple[bool, Real, tuple[Notice, ...]]:
    """Return whether a controller feeds forward, what was added to its output [V], and what is told of both.

    log: The record, with a position.
    plant, cascade: The identified plant and the stated controller.
    reference, voltage: Recorded reference [m] and voltage [V], each of shape (n,).
    rate: Its sampling [Hz].
    """
    measured, given = log.require("position", "a validation"), log.added
    own = voltage - (0.0 if given is None else given)
    plain, fed = (
        against_stated(cascade, plant, reference, measured, own, rate, ahead=ahead) for ahead in (False, True)
    )
    ahead = fed.missed < FED * plain.missed
    held, warnings = fed if ahead else plain, []
    if ahead:
        warnings.append(FEEDFORWARD_FOUND.found(log.where))
    added = np.zeros(len(voltage)) if given is None else given
    if held.added is not None:
        added = added + held.added
        share, most = float(np.mean(held.added != 0.0)), float(np.abs(held.added).max())
        warnings.append(ADDED_VOLTAGE_FOUND.found(log.where, share=share, most=most))
    if not held.as_stated:
        warnings.append(CONTROLLER_DIFFERS.found(log.where, how=held.describe(), friction=True))
    return ahead, added, tuple(warnings)
