"""Choice of the records to take of an axis: speeds, sines, a multisine and circles, from prior knowledge."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import floor, log10, pi, sqrt
from typing import Any

import numpy as np

from fric.arrays import Real
from fric.documents.friction import FrictionDocument
from fric.documents.machine_files import read_machine
from fric.documents.plant import PlantDocument
from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.flaws.prediction import PLAN_TYPICAL
from fric.friction import FrictionModel
from fric.friction.directed import Directed
from fric.friction.stribeck import OnStaticMap, StaticMap
from fric.log import Log
from fric.notice import Notice
from fric.records.inspection import FINE
from fric.records.resolution import lattice_step
from fric.reference import multisine
from fric.simulate.machine import Axis, Machine
from fric.simulate.plan import Limits, Planned, Setting
from fric.units import readable, rotates, si_unit

TYPICAL = "xy-table"  # The bundled machine that is used where none is given
REST = 10  # Least number of samples with an unchanged encoder position at rest


def prior_axis(
    machine: Machine | None = None,
    axis: str = "x",
    friction: FrictionDocument | None = None,
    plant: PlantDocument | None = None,
    like: Sequence[Log] = (),
) -> tuple[Axis, list[Notice]]:
    """Return an axis as known, and the substitutes for what is not known: a typical machine where none is given.

    like: A typical log, for force noise and encoder step.
    Raises FricError: When the machine has no such axis, or a file is of another motion.
    """
    notices: list[Notice] = []
    name = axis if friction is None else friction.axis
    if machine is None:
        found = replace(read_machine(TYPICAL).axis("x"), name=name)
        notices.append(PLAN_TYPICAL.found(machine=TYPICAL, like=bool(like)))
    else:
        found = machine.axis(name)
    if friction is not None:
        if friction.motion != found.motion:
            raise FricError(f"the friction is of a {friction.motion} axis, and axis {name} of the machine is not",
                            hint="Give the machine with `machine=`.")  # fmt: skip
        found = replace(found, friction=_friction(friction, found))
    if plant is not None:
        found = replace(found, plant=plant.plant(found.motion))
    return _logged_like(found, like) if like else found, notices


def _friction(known: FrictionDocument, axis: Axis) -> Any:
    """Return the model of a friction file; a static map alone gets the machine's pre-sliding, scaled to the map."""
    names = known.model_names()
    if names:
        return known.friction("gms" if "gms" in names else names[0])
    static = known.friction("static")
    model = _forward(axis)
    forward = static.model if isinstance(static, Directed) else static
    if not (isinstance(model, OnStaticMap) and isinstance(forward, StaticMap) and hasattr(model, "k")):
        return static
    k = tuple(item * forward.F_s / model.static.F_s for item in model.k)
    whole = replace(model, static=forward, k=k)  # type: ignore[call-arg]
    return Directed(whole, static.negative) if isinstance(static, Directed) else whole


def _forward(axis: Axis) -> FrictionModel:
    """Return the friction of the positive direction."""
    return axis.friction.model if isinstance(axis.friction, Directed) else axis.friction


def _logged_like(axis: Axis, logs: Sequence[Log]) -> Axis:
    """Return the axis with the force noise and the encoder of a log.

    While the encoder does not change, the loop adds nothing to the force: white noise there is that of the log. It is
    taken from second differences, ``var(ΔΔF) = 6·σ²``. A log without rests is used as a whole.
    """
    second: list[Real] = []
    whole: list[Real] = []
    for log in (log for log in logs if log.force is not None):
        white = np.diff(log.require("force", "its noise"), 2)
        whole.append(white)
        if log.position is not None and len(white) > REST:
            moved = np.append(0, np.cumsum(np.diff(log.position) != 0))
            still = moved[REST:] == moved[:-REST]
            second.append(white[: len(still)][still])
    found = np.concatenate(second or whole or [np.zeros(0)])
    if len(found) < REST:
        found = np.concatenate(whole or [found])
    if len(found) < REST:
        raise FricError("the log has no force that tells its noise", where=logs[0].where)
    steps = [step for log in logs if log.position is not None and (step := lattice_step(log.position))]
    axis = replace(axis, force_noise=float(np.sqrt(np.mean(found**2) / 6.0)))
    return replace(axis, encoder=Encoder(float(np.median(steps)))) if steps else axis


MARGIN = 0.99  # Share of stroke, feed and acceleration that a plan uses, which leaves room for rounding in a program
SLOPE = 1.875  # Largest slope of `fric.reference.smooth_step`: the acceleration of a ramp is this times speed over time
FALL = (0.05, 4.0)
"""Speeds in v_s between which the Stribeck fall is sampled: eq. (2) is 95 % and 2 % of its rise there."""
COUNTS = 200.0  # Encoder counts per second above which a drive runs evenly, without hunting between counts
BETWEEN = 0.382
"""Shift of each period of an excitation against the period before, as a share of a count.

With whole counts an encoder would round each period in the same way, and the rounding would not average out; with this
share, of the golden section, each period lies between those before it.
"""
SLIPS = 8.0  # Amplitude of a pre-sliding sine over the largest slip displacement (the paper's 450 µm over 54 µm)
STEPS = 30  # Micro-steps from end to end of a staircase; together 2.5 times the largest slip displacement
UNKNOWN_SLIP = 54e-6  # Largest slip displacement where no model is known: the paper's [m]


def choose(
    axis: Axis, limits: Limits, times: Mapping[str, int] | None = None, *, micro_steps: bool = False
) -> tuple[Planned, ...]:
    """Return the experiments that identify an axis, from what is known of it.

    times: Factor of the number of strokes, cycles or periods, by kind of record.
    micro_steps: A staircase in place of the sines before sliding.
    Raises FricError: When the limits leave no room for one of them.
    """
    more, makers = times or {}, _RECORDS | ({"presliding-sine": _micro_steps} if micro_steps else {})
    records = (made(axis, limits, more.get(kind, 1)) for kind, made in makers.items())
    found = (*records, *_circles(limits))
    for record in found:
        for trial in record.trials(axis):
            if broken := limits.broken_by(trial.reference):
                value = readable(getattr(limits, broken), si_unit(_DIMENSIONS[broken], axis.motion))
                raise FricError(
                    f"the {broken} of {value} leaves no room for '{trial.name}'",
                    hint=f"Allow more {broken}, or a faster or softer axis.",
                )
    return found


_DIMENSIONS = {"stroke": "position", "feed": "velocity", "acceleration": "acceleration"}


def durations(axis: Axis, planned: Sequence[Planned]) -> Iterator[float]:
    """Yield the duration of each experiment [s]."""
    for record in planned:
        if record.kind == "circle":
            s = {name: float(value) for name, value in record.settings.items() if not isinstance(value, tuple)}
            yield 2 * (2 * pi * s["revolutions"] + pi) * s["radius"] / s["feed"]
        else:
            yield sum(len(trial.reference) for trial in record.trials(axis)) / axis.cascade.sampling


def _known(axis: Axis) -> tuple[StaticMap, float]:
    """Return the known static map, and the largest displacement at which a block slips [m]."""
    model = _forward(axis)
    static = model.static if isinstance(model, OnStaticMap) else model
    if not isinstance(static, StaticMap):
        raise FricError(f"the friction of axis {axis.name} has no static map to plan from")
    slip = getattr(model, "slip_displacements", None)
    return static, UNKNOWN_SLIP if slip is None else float(np.max(slip))


def _ramp(speed: float, limits: Limits) -> float:
    return max(0.1, _rounded(SLOPE * speed / (MARGIN * limits.acceleration), up=True))


def _rounded(value: float, *, up: bool = False) -> float:
    """Return a value rounded down to three digits (up: rounded up)."""
    size = 10.0 ** (floor(log10(value)) - 2)
    return float(f"{(floor(value / size + 1e-9) + (up and value % size > 1e-9 * size)) * size:.3g}")


def _strokes(axis: Axis, limits: Limits, times: int) -> Planned:
    static, slip = _known(axis)
    stroke, top = MARGIN * limits.stroke, MARGIN * limits.feed
    while (ramp := _ramp(top, limits)) and top * (ramp + 0.2) > stroke:
        top *= 0.9
    lasting = min(1.0, (stroke - top * ramp) / top)
    slow = max(FALL[0] * static.v_s, COUNTS * axis.encoder.resolution)
    fall = min(FALL[1] * static.v_s, top)
    if not slow < fall:
        raise FricError(
            f"the fall of friction at {readable(static.v_s, si_unit('velocity', axis.motion))} is not between what the "
            "encoder resolves and the feed", hint="Allow a higher feed, or give another prior.",
        )  # fmt: skip
    speeds = [*np.geomspace(slow, fall, 10), *(np.geomspace(fall, top, 6)[1:] if top > 1.2 * fall else ())]
    distance = min(max(SLIPS * slip, 0.5e-3 if not rotates(axis.motion) else SLIPS * slip), 0.5 * stroke)
    settings: dict[str, Setting] = {
        "speeds": tuple(_rounded(float(v)) for v in speeds), "distance": _rounded(distance),
        "lasting": _rounded(lasting), "ramp": ramp, "repeats": times,
    }  # fmt: skip
    return Planned("constant-velocity", settings, "F_c, F_s, v_s, sigma, offset: both sides of the Stribeck fall")


def _presliding(axis: Axis, limits: Limits, times: int) -> Planned:
    static, slip = _known(axis)
    large = min(SLIPS * slip, 0.25 * MARGIN * limits.stroke)
    small = max(slip / 4, 20 * axis.encoder.resolution)
    amplitudes = (small, large) if small < large / 3 else (large,)
    frequency = min(0.1, 0.28 * static.v_s / (2 * pi * large))
    settings: dict[str, Setting] = {
        "amplitudes": tuple(_rounded(a) for a in amplitudes), "frequency": _rounded(frequency), "cycles": 5 * times,
    }  # fmt: skip
    why = "alpha, k: the first blocks from the small sine, the last from the large one, slower than the Stribeck fall"
    return Planned("presliding-sine", settings, why)


def _micro_steps(axis: Axis, limits: Limits, times: int) -> Planned:
    _, slip = _known(axis)
    step = min(max(2.5 * slip / STEPS, FINE * axis.encoder.resolution), 0.5 * limits.stroke / STEPS)
    ramp = max(0.25, 2.5 * sqrt(step / limits.acceleration))  # its speed rises and falls by `smooth_step`
    settings: dict[str, Setting] = {
        "step": _rounded(step), "steps": STEPS, "loops": 1 + 3 * times, "ramp": _rounded(ramp, up=True), "dwell": 0.25,
    }  # fmt: skip
    return Planned("micro-steps", settings, "alpha, k: small steps up and down, for a drive without slow sines")


def _sliding(axis: Axis, limits: Limits, times: int) -> Planned:
    static, _ = _known(axis)
    rate = getattr(_forward(axis), "C", 0.0) / (2 * pi * static.F_s)
    frequency = _rounded(float(np.clip(0.4 * rate, 1.0, 10.0))) if rate else 4.0
    # two periods before and two behind are ramps of the mean; the swing adds its acceleration
    length, cycles = MARGIN * limits.stroke, 20 * times
    mean = min(2 * static.v_s, 0.4 * MARGIN * limits.feed, length * frequency / (cycles + 3))
    mean = min(mean, MARGIN * limits.acceleration / (2 * pi * frequency * 0.75 + SLOPE * frequency))
    settings: dict[str, Setting] = {
        "mean": _rounded(mean), "swing": _rounded(0.75 * mean), "frequency": frequency, "cycles": cycles,
    }  # fmt: skip
    return Planned("sliding-sine", settings, "C: friction lags a speed that swings about v_s")


def _response(axis: Axis, limits: Limits, times: int) -> Planned:
    lowest, periods, sampling = 2.0, 10, axis.cascade.sampling
    highest = _rounded(min(500.0, sampling / 8))
    lasting = 1.1 + (periods + 1) / lowest
    mean = min(0.3 * limits.feed, MARGIN * limits.stroke / (lasting + 0.2), 30e-3 if not rotates(axis.motion) else 3.0)
    ramp = _ramp(mean, limits)
    mean = min(mean, MARGIN * limits.stroke / (lasting + ramp))
    lines = lowest * np.unique(np.rint(np.geomspace(1, highest / lowest, 60)))
    shaken = multisine(lines, 1.0, round(sampling / lowest), sampling, np.random.default_rng([0, 0]))
    peak = min(0.5 * mean, MARGIN * limits.acceleration / float(np.abs(shaken.acceleration).max()))
    mean, count = _rounded(mean), axis.encoder.resolution
    if count:  # a few counts a second slower
        mean = (floor(mean / lowest / count + 1e-6) - 1 + BETWEEN) * count * lowest
    settings: dict[str, Setting] = {
        "mean": mean, "peaks": (_rounded(peak),) * times, "lowest": lowest, "highest": highest, "lines": 60,
        "periods": periods, "ramp": ramp,
    }  # fmt: skip
    why = "A, B, T_d, K_f, and the limits of observer and loop: a multisine on the voltage, sliding in one direction"
    return Planned("frequency-response", settings, why)


def _circles(limits: Limits) -> Iterator[Planned]:
    radius = _rounded(min(30e-3, 0.5 * MARGIN * limits.stroke))
    fast = _rounded(MARGIN * min(limits.feed, sqrt(0.9 * limits.acceleration * radius)))
    for feed, why in ((fast, "for validation: the error with compensation"), (_rounded(fast / 10), "the same, slowly")):
        settings: dict[str, Setting] = {"radius": radius, "feed": feed, "revolutions": 2}
        yield Planned("circle", settings, why)


_RECORDS: dict[str, Callable[[Axis, Limits, int], Planned]] = {
    "constant-velocity": _strokes, "presliding-sine": _presliding, "sliding-sine": _sliding,
    "frequency-response": _response,
}  # fmt: skip
