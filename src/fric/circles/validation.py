"""A recorded motion replayed by the identified axis: in closed loop, in open loop from the input, and inversely.

::

    closed    recorded reference ──> the drive's controller ──(+ added)──> plant and friction ──> motion, force
    open      recorded input ────────────────────────────────────────────────> plant and friction ──> motion
    inverse   recorded motion ──> M·z̈ + M·A·ż + friction + load ──> force
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from fric.arrays import Real
from fric.circles.gains import controller_behind
from fric.control.base import Setting
from fric.control.cascade import Cascade
from fric.drive.plant import Plant, hold_delay
from fric.errors import FricError
from fric.friction import FrictionModel
from fric.kernels.block import Commands
from fric.kernels.loop import Board, closed_loop
from fric.kernels.plant import PlantConstants
from fric.log import Log
from fric.notice import Notice
from fric.records.flaws import even_sampling
from fric.records.motion import Conditioning, filtered_motion, thinned
from fric.records.prepared import acting_force, drive_force, prepared

Loop = Literal["closed", "open", "inverse"]

LEAD = 0.05  # Time span for the initial velocity of the record [s]


@dataclass(frozen=True)
class Compared:
    """One signal, measured and simulated."""

    measured: Real  # measured, simulated: both, shape (n,)
    simulated: Real
    relative: float  # ``‖measured - simulated‖/‖measured‖`` [1]
    rms: float  # Root mean square of the difference, in the signal's unit


@dataclass(frozen=True)
class Validation:
    """A record and its simulation by the identified axis."""

    loop: Loop  # ``closed``, ``open`` or ``inverse``
    log: Log  # The record
    friction: FrictionModel  # The friction model
    # ``position`` [m], ``velocity`` [m/s], ``acceleration`` [m/s²] and, in closed loop, ``force`` [N]. Velocity and
    # acceleration are those of the position, both measured and simulated: central differences behind a zero-phase
    # fourth-order Butterworth filter.
    signals: dict[str, Compared]
    cutoff: float  # Its corner [Hz]
    worst: tuple[int, int]  # First and last sample of the second with the largest force (in open loop, velocity) error
    warnings: tuple[Notice, ...] = ()  # What the record shows of controller and voltage


def validate_closed_loop(
    log: Log, plant: Plant, cascade: Cascade, friction: FrictionModel, load: float = 0.0
) -> Validation:
    """Return the simulated response of the identified axis to a recorded reference, with the controller of the drive.

    Velocity and inverse model are fed forward only where the recorded voltage shows that they were. A voltage that was
    added to the controller's output (channel ``added``, or pulses of the record beyond that output) is added again.
    There is a warning if the stated controller does not produce the recorded voltage: friction is not the cause. The
    axis begins where the record does, at its velocity; the controller's integral and the friction begin at rest.

    log: A record with position, reference, and force or input, sampled at the controller's rate.
    plant, cascade, friction: The identified axis and its controller; ``K_i`` of 0 is a P/PD controller.
    Raises FricError: When a channel is missing, the record is sampled at another rate, or the simulation runs away.
    """
    reference = log.require("reference", "a closed-loop replay")
    rate = even_sampling(log)
    if abs(rate / cascade.sampling - 1) > 1e-3:
        what = f"the record is sampled at {rate:g} Hz and the controller runs at {cascade.sampling:g} Hz"
        hint = "Log at the controller's rate; without `controller=` the friction alone is replayed."
        raise FricError(what, where=log.where, hint=hint)
    force = _driven(log, plant)
    recorded = log.input if log.input is not None else force / plant.K_f
    ahead, added, warnings = controller_behind(log, plant, cascade, reference, recorded, rate)
    position, voltage = _run(log, rate, plant, cascade, friction, load, reference, added, ahead=ahead)
    pairs, corner = _motions(log, rate, position)
    found = _scored("closed", log, friction, pairs | {"force": (force, plant.K_f * voltage)}, corner, rate)
    return replace(found, warnings=warnings)


def validate_inverse(log: Log, plant: Plant, friction: FrictionModel, load: float = 0.0) -> Validation:
    """Return the force that the identified axis needs along a recorded motion, behind the published filter.

    The force cross-test of one record by another's parameters (Janot, Gautier, Brunot 2019): position filtered forwards
    and backwards, central differences, both forces decimated in the same way, as `fric identify plant` does.

    plant, friction, load: As in `validate_closed_loop`; with a T_d of 0 if it was not measured.
    """
    rate = even_sampling(log)
    settings = Conditioning.of(rate)
    (record,) = prepared([log], plant, filters=[settings])
    asked = record.replay(friction) + record.taken_off + load
    measured, simulated = (thinned(force[record.used], settings.decimation) for force in (record.drive, asked))
    return _scored("inverse", log, friction, {"force": (measured, simulated)}, settings.cutoff, rate, settings)


def validate_open_loop(log: Log, plant: Plant, friction: FrictionModel, load: float = 0.0) -> Validation:
    """Return the response of the identified axis to the measured input alone; errors of the model accumulate."""
    rate = even_sampling(log)
    voltage = log.input if log.input is not None else _driven(log, plant) / plant.K_f
    position, _ = _run(log, rate, plant, None, friction, load, log.require("position", "a validation"), voltage)
    return _scored("open", log, friction, *_motions(log, rate, position), rate)


def _driven(log: Log, plant: Plant) -> Real:
    """Return the drive's force at the instant of its voltage [N], shape (n,)."""
    force, _, lag = drive_force(log, plant)
    return acting_force(log.time, force, -lag)


def _run(  # noqa: PLR0913 - one closed loop for three ways of validation
    log: Log, rate: float, plant: Plant, cascade: Cascade | None, friction: FrictionModel, load: float, reference: Real,
    model: Real, *, ahead: bool = False,
) -> tuple[Real, Real]:  # fmt: skip
    """Return position [m] and voltage [V] of a run that begins as the record does."""
    measured = log.require("position", "a validation")
    state, zeros = friction.initial_state(), np.zeros(len(log))
    first = min(max(int(LEAD * rate), 4), len(log))
    start = np.polynomial.Polynomial.fit(log.time[:first], measured[:first], 2)
    origin = log.time[0]
    z_0, v_0 = float(start(origin)), float(start.deriv()(origin))
    blocks = []
    if cascade is not None:
        controller = replace(cascade, sampling=rate, velocity_feedforward=1.0)
        blocks.append(controller.ready(Setting(plant, controller, position=z_0, velocity=v_0, seen=z_0 - v_0 / rate)))
    asked = np.ascontiguousarray(reference)
    velocity = acceleration = zeros
    delay = plant.transport_delay(rate) if plant.T_d >= hold_delay(rate) else 0.0
    if ahead:
        velocity = np.gradient(asked, 1 / rate)
        acceleration = np.gradient(velocity, 1 / rate)
        model = model + (acceleration + plant.A * velocity) / plant.B
    traces, _ = closed_loop(
        type(friction).step, state, friction.packed(),
        PlantConstants(
            plant.A, plant.B, plant.M, load, delay, float(state.size == 0), float(start(origin) - reference[0]), v_0,
        ),
        Board(1 / rate, float("inf") if cascade is None else cascade.limit, 0.0), blocks,
        Commands(asked, velocity, acceleration, np.ascontiguousarray(model), zeros, asked, velocity),
    )  # fmt: skip
    if not np.isfinite(traces.position[-1]):
        raise FricError("the simulated axis runs away", where=log.where, hint="Look at the controller's gains.")
    return traces.position, traces.input


Pairs = dict[str, tuple[Real, Real]]  # Signals, measured and simulated, by name


def _motions(log: Log, rate: float, position: Real) -> tuple[Pairs, float]:
    """Return position, velocity and acceleration, and the corner of the filter behind the last two [Hz]."""
    z = log.require("position", "a validation"), position
    settings = replace(Conditioning.of(rate), border=0, decimation=0)
    measured, simulated = (filtered_motion(replace(log, position=array), settings) for array in z)
    v, a = (measured.velocity, simulated.velocity), (measured.acceleration, simulated.acceleration)
    return {"position": z, "velocity": v, "acceleration": a}, settings.cutoff


def _scored(
    loop: Loop, log: Log, friction: FrictionModel, pairs: Pairs, cutoff: float, rate: float,
    thinned_by: Conditioning | None = None,
) -> Validation:  # fmt: skip
    """Return the differences of signals, and the second with the largest error of force, or else of velocity."""
    signals = {name: _difference(*pair) for name, pair in pairs.items()}
    decisive = signals["force" if "force" in signals else "velocity"]
    begin, every = (thinned_by.border, thinned_by.decimation) if thinned_by else (0, 1)
    squares = np.cumsum(np.append(0.0, (decisive.measured - decisive.simulated) ** 2))
    width = max(1, min(round(rate / every), len(squares) - 1))  # a sample of a log slower than a second
    first = int(np.argmax(squares[width:] - squares[:-width]))
    worst = begin + every * first, min(begin + every * (first + width), len(log))
    return Validation(loop, log, friction, signals, cutoff, worst)


def _difference(measured: Real, simulated: Real) -> Compared:
    error = measured - simulated
    size = float(np.linalg.norm(measured))
    relative = float(np.linalg.norm(error)) / size if size > 0 else float("inf")
    return Compared(measured, simulated, relative, float(np.sqrt(np.mean(error**2))))
