"""Choice of the records to take of an axis: speeds, sines, a multisine and circles, from prior knowledge.

After a first identification, that is the further record that would narrow a predicted glitch most. To first order the
glitch varies by ``gᵀ·Σ·g``: g are its derivatives over the uncertain parameters of the friction (the controller
believes the estimates), Σ their covariance. One more record adds its Fisher information, ``Σ' = (Σ⁻¹ + I)⁻¹``: that of
the residuals, weights and models of the fits, at the last result.

The intervals that planned experiments will give are those of the identification itself, on records simulated at the
prior. The information of the records is the Fisher information of their fits: the same records, residuals, weights and
models. They are simulated several times on the axis as known beforehand, with different noise and different places
between two encoder counts, and identified each time; the results are the geometric mean and the range of the
half-widths.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, exp, floor, inf, log, log10, pi, sqrt
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from fric.arrays import Real
from fric.columns import PRESLIDING
from fric.control.scheme import Scheme
from fric.documents.base import FilePart
from fric.documents.friction import FrictionDocument, gms_tree, static_tree
from fric.documents.machine_files import read_machine
from fric.documents.plant import PlantDocument, plant_tree
from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.estimate import NORMAL_97_5, Covariance, elements
from fric.flaws.prediction import PLAN_ACCURACY, PLAN_LEFT_OVER, PLAN_NOT_ENOUGH, PLAN_PLANT_UNSURE, PLAN_TYPICAL
from fric.friction import FrictionModel
from fric.friction.directed import Directed
from fric.friction.gms import GMS
from fric.friction.stribeck import STATIC_PARAMETERS, OnStaticMap, StaticMap
from fric.identify.gms.hunting import Hunting
from fric.identify.gms.identify import identify_gms
from fric.identify.gms.virgin_curve import find_cycles
from fric.identify.plant.identify import identify_plant
from fric.identify.replay.replay_fit import replay_information
from fric.identify.replay.replay_search import Ranges, search_ranges
from fric.identify.static_map.identify import identify_static
from fric.identify.static_map.points import Asked, stroke_points
from fric.identify.static_map.stribeck_fit import StribeckProblem
from fric.log import Log
from fric.notice import Notice
from fric.plausibility import of_plant, settled
from fric.records.inspection import FINE
from fric.records.prepared import prepared
from fric.records.resolution import lattice_step
from fric.reference import multisine
from fric.search import ranked
from fric.simulate import experiment
from fric.simulate.contour_run import Circle, run_circle
from fric.simulate.experiment import Expected, Limits, Narrowing, Planned, Setting
from fric.simulate.machine import Axis, Machine, NominalFriction
from fric.simulate.reality.flaws import NONE
from fric.units import readable, rotates, si_unit

TYPICAL = "xy-table"  # The bundled machine that is used where none is given
REST = 10  # Least number of samples with an unchanged encoder position at rest
Drawn = tuple[list[PlantDocument | FrictionDocument], dict[tuple[bool, int], Notice]]
"""What a run of planned records gives, and why its identification ended, by how far it came."""


def prior_axis(
    machine: Machine | None = None, axis: str = "x", friction: FrictionDocument | None = None,
    plant: PlantDocument | None = None, like: Sequence[Log] = (),
) -> tuple[Axis, list[Notice]]:  # fmt: skip
    """Return an axis as known, and the substitutes for what is not known: a typical machine where none is given.

    like: A typical log, for force noise and encoder step.
    """
    notices: list[Notice] = []
    name = axis if friction is None else friction.axis
    if machine is None:
        found = replace(read_machine(TYPICAL).axis("x"), name=name)
        notices.append(PLAN_TYPICAL.found(machine=TYPICAL, like=bool(like)))
    else:
        found = machine.axis(name)
    for document, what in ((friction, "friction"), (plant, "plant")):
        if document is not None and not document.belongs(document.axis, found.motion):
            raise FricError(f"the {what} is of a {document.motion} axis, and axis {name} of the machine is not",
                            hint="Give the machine with `machine=`.")  # fmt: skip
    if friction is not None:
        found = replace(found, friction=_friction(friction, found))
    if plant is not None:
        found = replace(found, plant=plant.plant(found.motion))
    return _logged_like(found, like) if like else found, notices


def _friction(known: FrictionDocument, axis: Axis) -> Any:
    """Return the model of a friction file; a static map alone gets the machine's pre-sliding, scaled to the map."""
    names = known.model_names()
    if names:
        return known.friction("gms" if "gms" in names else names[0])
    static, model = known.friction("static"), _forward(axis)
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
    """Return the axis with the force noise and the encoder of a log. While the encoder does not change, white noise of
    the force is the log's, as the loop adds none: ``var(ΔΔF) = 6·σ²``. A log without rests is used as a whole.
    """
    second, whole = list[Real](), list[Real]()
    for record in (record for record in logs if record.force is not None):
        white = np.diff(record.require("force", "its noise"), 2)
        whole.append(white)
        if record.position is not None and len(white) > REST:
            moved = np.append(0, np.cumsum(np.diff(record.position) != 0))
            still = moved[REST:] == moved[:-REST]
            second.append(white[: len(still)][still])
    found = np.concatenate(second or whole or [np.zeros(0)])
    if len(found) < REST:
        found = np.concatenate(whole or [found])
    if len(found) < REST:
        hint = "Give one with samples at rest."
        raise FricError("the log has no force that tells its noise", where=logs[0].where, hint=hint)
    steps = [step for log in logs if log.position is not None and (step := lattice_step(log.position))]
    axis = replace(axis, force_noise=float(np.sqrt(np.mean(found**2) / 6.0)))
    return replace(axis, encoder=Encoder(float(np.median(steps)))) if steps else axis


MARGIN = 0.99  # Share of stroke, feed and acceleration that a plan uses, which leaves room for rounding in a program
SLOPE = 1.875  # Largest slope of `fric.reference.smooth_step`: the acceleration of a ramp is this times speed over time
FALL = (0.05, 4.0)  # Speeds in v_s between which the Stribeck fall is sampled: eq. (2) is 95 % and 2 % of its rise
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
    """
    more, makers = times or {}, _RECORDS | ({"presliding-sine": _micro_steps} if micro_steps else {})
    records = (made(axis, limits, more.get(kind, 1)) for kind, made in makers.items())
    found = (*records, *_circles(limits))
    for record in found:
        for trial in record.trials(axis):
            if broken := limits.broken_by(trial.reference):
                value = readable(getattr(limits, broken), si_unit(FilePart[Limits].dimensions[broken], axis.motion))
                hint = f"Allow more {broken}, or a faster or softer axis."
                raise FricError(f"the {broken} of {value} leaves no room for '{trial.name}'", hint=hint)
    return found


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
        speed = readable(static.v_s, si_unit("velocity", axis.motion))
        what = f"the fall of friction at {speed} is not between what the encoder resolves and the feed"
        raise FricError(what, hint="Allow a higher feed, or give another prior.")
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
        "amplitudes": 2 * tuple(_rounded(a) for a in amplitudes), "frequency": _rounded(frequency), "cycles": 3 * times,
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
    highest, lasting = _rounded(min(500.0, sampling / 8)), 1.1 + (periods + 1) / lowest
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

ASSUMED = {"C": log(10.0) / NORMAL_97_5}  # Standard deviation of an assumed parameter's logarithm: C to a factor of ten
SURE = 0.4  # Relative uncertainty of a further record's information: half-widths of simulated ones are good to 20 %
LARGEST = 0.5  # Largest step of a logarithm or logit in which a derivative is taken
FORCE_ERROR = 1e-3  # Least error of the mean force of a stroke, as a share: no channel is known better


def narrowing(
    machine: Machine, axis: Axis, limits: Limits, covariances: Sequence[Covariance], between: float, scheme: Scheme,
    advance: Callable[[], object] = lambda: None,
) -> Narrowing:  # fmt: skip
    """Return how a further record would narrow the predicted glitch of an axis.

    axis: The axis at the last result: its friction is the GMS model that was identified.
    covariances: Covariances of the parameters of its static map and of its GMS model, as in its friction file.
    between: Standard deviation of strokes beyond their noise [N].
    """
    model = axis.friction
    if not isinstance(model, GMS):
        hint = "Identify one with `fric identify gms`; `fric plan --friction` says which records that takes."
        raise FricError("planning needs a GMS model with a common map for both directions", hint=hint)
    known, planned = _known_of(covariances, model), choose(axis, limits)
    circle = next(record for record in planned if record.kind == "circle").settings
    test = Circle(float(circle["radius"]), float(circle["feed"]))  # type: ignore[arg-type]
    slopes = _slopes(machine, axis, model, known, scheme, test, advance)
    names, S = list(known.deviation), known.matrix
    half = NORMAL_97_5 * _deviation(slopes, S)
    worst = slopes[int(np.argmax(np.einsum("qi,ij,qj->q", slopes, S, slopes)))]
    shares = worst * (S @ worst) / max(float(worst @ S @ worst), 1e-300)
    found = []
    experiments = [part for record in planned for part in _parts(record)]
    logs = [list(experiment.logs_of(axis, part.trials(axis), 1)) for part in experiments]
    ranges = search_ranges(prepared([log for each in logs for log in each if "sine" in str(log.kind)], axis.plant))
    for part, made in zip(experiments, logs, strict=True):
        advance()
        try:
            I = _information(made, axis, model, known, between, ranges)  # noqa: E741 - Fisher's
        except FricError:  # of this loop it shows nothing: where friction falls, it stops in a sine in sliding
            continue
        least, after, most = (
            NORMAL_97_5 * _deviation(slopes, np.asarray(np.linalg.inv(np.linalg.inv(S) + share * I), float))
            for share in (1 + SURE, 1.0, 1 - SURE)
        )
        lasting = sum(len(trial.reference) for trial in part.trials(axis)) / axis.cascade.sampling
        found.append(experiment.CandidateRecord(part, lasting, after, 0.5 * (most - least)))
    of_each = dict(zip(names, map(float, shares), strict=True))
    return Narrowing(half, of_each, by_what_they_leave(found), test, scheme.name)


def by_what_they_leave(candidates: Sequence[experiment.CandidateRecord]) -> tuple[experiment.CandidateRecord, ...]:
    """Return candidates, the best first; among those that differ by less than their scatter, the shortest first."""
    ordered = sorted(candidates, key=lambda candidate: candidate.lasting)
    order = ranked([candidate.half_width for candidate in ordered], [candidate.scatter for candidate in ordered])
    return tuple(ordered[n] for n in order)


def _parts(record: Planned) -> Iterator[Planned]:
    """Yield the candidates of an experiment: slow and fast strokes, each sine alone; a circle is no candidate."""
    if record.kind == "constant-velocity":
        speeds = record.settings["speeds"]
        assert isinstance(speeds, tuple)
        half = 2 * len(speeds) // 3
        yield replace(record.changed(speeds=speeds[:half]), why="strokes through the Stribeck fall")
        if speeds[half:]:
            yield replace(record.changed(speeds=speeds[half:]), why="strokes beyond the fall")
    elif record.kind == "presliding-sine":
        amplitudes = record.settings["amplitudes"]
        assert isinstance(amplitudes, tuple)
        for amplitude in dict.fromkeys(amplitudes):
            yield replace(record.changed(amplitudes=(amplitude,)), why="a slow sine before sliding")
    elif record.kind == "sliding-sine":
        yield replace(record, why="a sine in sliding")


@dataclass(frozen=True)
class _Known:
    """The uncertain parameters by name: deviations of each alone, on a linear scale or not, and the covariance."""

    deviation: dict[str, float]  # Where all others are known: shares that add up to nearly 1 move by less than 1 - sum
    linear: frozenset[str]
    matrix: Real


def _known_of(covariances: Sequence[Covariance], model: GMS) -> _Known:
    """Return the covariance of the parameters; the last share follows from the others."""
    last = f"alpha_{len(model.alpha)}"
    names: list[str] = []
    linear: set[str] = set()
    blocks = []
    for given in covariances:
        kept = [n for n, name in enumerate(given.names) if name != last and given.matrix[n][n] > 0]
        names += [given.names[n] for n in kept]
        linear |= {given.names[n] for n in kept if given.scales[n] == "linear"}
        blocks.append(np.array(given.matrix)[np.ix_(kept, kept)])
    for name, deviation in ASSUMED.items():
        if name not in names:
            names.append(name)
            blocks.append(np.array([[deviation**2]]))
    matrix = block_diag(*blocks)
    size = np.sqrt(np.diag(matrix))
    alone = size * np.maximum(np.diag(np.linalg.pinv(matrix / np.outer(size, size), hermitian=True)), 1.0) ** -0.5
    return _Known(dict(zip(names, map(float, alone), strict=True)), frozenset(linear), matrix)


def _deviation(slopes: Real, covariance: Real) -> float:
    """Return the largest standard deviation of the quadrants' glitches [m]."""
    return float(np.sqrt(max(np.einsum("qi,ij,qj->q", slopes, covariance, slopes))))


def _slopes(
    machine: Machine, axis: Axis, model: GMS, known: _Known, scheme: Scheme, test: Circle, advance: Callable[[], object]
) -> Real:
    """Return the derivatives of this axis' two glitches over the parameters, shape (2, p), by central differences: of
    nanometres, which would show the counts of an encoder, so that it is left out.
    """
    place = list(machine.axes).index(axis.name)
    nominal = NominalFriction({"gms": model, "static": model.static}, 1.0, axis.nominal_friction.lead)
    rows = []
    for name, deviation in known.deviation.items():
        step = deviation if name in known.linear else min(deviation, LARGEST)
        sides, moved = [], []
        for side in (1.0, -1.0):
            true, by = _moved(model, name, side * step, linear=name in known.linear)
            subject = replace(axis, friction=true, nominal_friction=nominal, encoder=Encoder())
            changed = replace(machine, axes={**machine.axes, axis.name: subject})
            run = run_circle(changed, scheme, test, only=axis.name, accuracy=experiment.ACCURACY)
            sides.append(np.array(run.circularity.quadrants)[[place, place + 2]])
            moved.append(by)
            advance()
        rows.append((sides[0] - sides[1]) / (moved[0] - moved[1]) if moved[0] != moved[1] else np.zeros(2))
    return np.array(rows).T


def _moved(model: GMS, name: str, by: float, *, linear: bool) -> tuple[GMS, float]:
    """Return the model with a parameter moved on its scale, and the step within the bounds."""
    if name == "offset":
        return model, by
    if linear:
        value = getattr(model.static, name)
        low = {"F_s": model.static.F_c, "F_c": 0.0}.get(name, 0.0 if name == "sigma" else 1e-3 * value)
        moved = min(max(value + by, low), model.static.F_s if name == "F_c" else float("inf"))
        return replace(model, static=replace(model.static, **{name: moved})), moved - value
    symbol, _, number = name.partition("_")
    if symbol == "C":
        return replace(model, C=model.C * exp(by)), by
    n = int(number) - 1
    if symbol == "k":
        return replace(model, k=tuple(k * exp(by) if i == n else k for i, k in enumerate(model.k))), by
    before, last = model.alpha[n], model.alpha[-1]
    share = min(1 / (1 + (1 / before - 1) * exp(-by)), before + 0.999 * last)  # what it gains the last block loses
    alpha = [share if i == n else a for i, a in enumerate(model.alpha)]
    alpha[-1] = before + last - share
    return replace(model, alpha=tuple(alpha)), log(share / (1 - share)) - log(before / (1 - before))


def _information(logs: Sequence[Log], axis: Axis, model: GMS, known: _Known, between: float, ranges: Ranges) -> Real:
    """Return the information of one record over all parameters, shape (p, p)."""
    names = list(known.deviation)
    if logs[0].kind == "constant-velocity":
        points, _ = stroke_points(logs, plant=axis.plant)
        v, F, error = np.array([(p.velocity, p.force, p.standard_error) for p in points]).T
        static = model.static
        error = np.maximum(np.hypot(error, between), FORCE_ERROR * np.abs(F))  # a simulated stroke has no noise
        problem = StribeckProblem(
            v, F, error, None if "delta" in names else static.delta,
            "offset" in names, "F_s" in names,
        )  # fmt: skip
        theta = {name: getattr(static, name) for name in STATIC_PARAMETERS}
        J = problem.jacobian(theta) / problem.standard_error[:, None]
        of, found = problem.free, J.T @ J
    else:
        ready, slides = prepared(logs, axis.plant), logs[0].kind == "sliding-sine"
        records = [record.in_sliding() if slides else find_cycles(record).for_replay() for record in ready]
        of, found = replay_information(records, model, ranges, Hunting(axis.plant))
    at = [names.index(name) for name in of if name in names]
    kept = [n for n, name in enumerate(of) if name in names]
    information = np.zeros((len(names), len(names)))
    information[np.ix_(at, at)] = found[np.ix_(kept, kept)]
    return information


DRAWS, SLOW_DRAWS = 7, 3
"""Runs of a plan that are identified: the range of seven includes the next in 75 % of cases, that of three in 50 %. Few
are those of an axis with a second mass or flaws, which take five times as long, and of records that last long."""
LASTING = 100.0  # Time of an axis' records from which on few runs are identified [s]
PLACES = 64.0  # Encoder counts over which the start of a record is spread: the hunting of a slow axis depends on it
NOTABLE = 1.2  # Widening by unmodelled friction above which it is reported
MOST_TIMES = 16  # Largest factor of the usual number of strokes, cycles or periods
HOPELESS = 4.0  # Factor of the records needed over those at most, from which on none are added: they miss by half of it

IDENTIFIED_BY = {  # The parameters that each kind of record determines
    "constant-velocity": (*STATIC_PARAMETERS, "offset"), "presliding-sine": ("alpha", "k"),
    "sliding-sine": ("C",), "frequency-response": ("A", "B", "T_d", "K_f", "force_lag"),
}  # fmt: skip
KIND_OF = {name: kind for kind, names in IDENTIFIED_BY.items() for name in names}
Wanted = Mapping[str, tuple[float, bool]]  # Requested half-width by parameter, and whether it is relative to the value


@dataclass(frozen=True)
class Expectation:
    """Expected intervals of an axis from planned records."""

    parameters: Mapping[str, Expected]  # By name, ``k_2`` being that of the second block
    blocks: int | None  # Number of slip blocks that the identification finds; None where there is no GMS model
    notices: tuple[Notice, ...]  # What cannot be expected of these records


def identified(logs: Sequence[Log], blocks: int | None = None) -> Iterator[PlantDocument | FrictionDocument]:
    """Yield plant, static map and GMS model of the records of an axis, each if there are records for it."""
    plant = static = known = None
    of_kind = {kind: [log for log in logs if log.kind == kind] for kind in {log.kind for log in logs}}
    if responses := of_kind.get("frequency-response"):
        plant = PlantDocument.model_validate(plant_tree(identify_plant(responses), responses))
        known = plant.plant(logs[0].motion)
        settled(of_plant(known, logs[0].motion))
        yield plant
    if strokes := of_kind.get("constant-velocity"):
        error = 0.0 if plant is None else plant.damping_error(logs[0].motion)
        # in one form in all runs: half-widths of a run with delta free and a run without have no mean
        asked = Asked(logs[0].motion, known, delta=1.0, over_position="off", damping_error=error)
        static = FrictionDocument.model_validate(static_tree(identify_static(strokes, asked), strokes))
        yield static
    if of_kind.keys() & PRESLIDING:
        sines = [log for log in logs if log.kind in {*PRESLIDING, "sliding-sine"}]
        forward, backward = (None, None) if static is None else static.maps()
        fit = identify_gms(sines, static=forward, negative=backward, plant=known, blocks=blocks, places=1, on_time=True)
        yield FrictionDocument.model_validate(gms_tree(fit, sines, static))


def half_widths(documents: Sequence[PlantDocument | FrictionDocument]) -> dict[str, tuple[float, float, str]]:
    """Return value, half-width of the 95 % interval (infinite if open) and unit by parameter, in SI."""
    found = {}
    for document in documents:
        if isinstance(document, FrictionDocument):
            sections = [document.estimates(section) for section in document.sections()]
        else:
            parts = [document, *([document.second_mass] if document.second_mass is not None else [])]
            sections = [part.estimates(document.motion) for part in parts]
        for name, estimate in (element for section in sections for element in elements(section)):
            if estimate.ci95 is not None:
                value, (low, high) = float(estimate), estimate.limits  # at its bound an interval has one side
                found[name] = value, high - value if low == 0 else estimate.half_width, estimate.unit
    return found


def typical(halves: Sequence[float]) -> float:
    """Return the geometric mean of half-widths, or their median if any is open.

    An interval may have one of two sizes, depending on a test within the identification: a median of few runs would
    pick one by chance.
    """
    closed = bool(np.all(np.isfinite(halves))) and min(halves) > 0
    return float(np.exp(np.mean(np.log(halves))) if closed else np.median(halves))


def anywhere(axis: Axis, trials: Sequence[experiment.Trial], seed: int) -> list[experiment.Trial]:
    """Return trials that begin at different places between the counts of the axis' encoder."""
    places = np.random.default_rng([seed, 1]).uniform(0.0, PLACES * axis.encoder.resolution, len(trials))
    return [
        replace(trial, reference=replace(trial.reference, position=trial.reference.position + place))
        for trial, place in zip(trials, places, strict=True)
    ]


def left_over(known: FrictionDocument) -> dict[str, float]:
    """Return the residuals of fits [N], by section: of the static map between strokes, of GMS in the virgin curve."""
    static, gms = known.fit_of("static"), known.fit_of("gms")
    between = static.between_strokes if static.between_strokes and static.between_strokes.value else static.rmse
    given = {"static": between, "gms": gms.virgin_curve_rmse}
    return {name: float(quantity.si("force", known.motion)) for name, quantity in given.items() if quantity is not None}


def widening(
    known: FrictionDocument, parameters: Mapping[str, Expected], simulated: Sequence[FrictionDocument]
) -> dict[str, float]:
    """Return the factor that widens expected intervals for unmodelled friction of a drive, 1 or more.

    A fit of the drive has larger residuals than any fit of the simulated axis where its friction differs from the
    model; these recur and do not average out: the half-width is then the known half-width. The factor is at most the
    ratio of the residuals, since a half-width from few strokes is wide because of their number.
    """
    left = [left_over(document) for document in simulated]
    found = {}
    for section, rest in left_over(known).items():
        rests = [mapping[section] for mapping in left if section in mapping]
        usual = typical(rests) if rests and rest > max(rests) else 0.0
        most = rest / usual if usual else 1.0
        for name, estimate in elements(known.estimates(section)) if most > 1.0 else ():
            if name in parameters:
                found[name] = min(max(estimate.half_width / parameters[name].half_width, 1.0), most)
    return found


def scattering(known: PlantDocument, found: Sequence[PlantDocument]) -> dict[str, float]:
    """Return the factor of the plant's intervals from a drive's response over those of the simulated axis.

    Other effects of its friction, over position or time, differ from period to period, and no simulation of its model
    has them. Half-widths are compared for a response of one size and one period. A single record shows its scatter only
    to within the differences between simulated records: the logarithm δ of the factor is shrunk to ``δ·(1 - s²/δ²)``,
    and to 0 where it is less than their deviation s (the positive part of James and Stein's).
    """
    before, *others = (_sureness(document) for document in (known, *found))
    factors = {}
    for name in before.keys() & set.intersection(*map(set, others)) if others else ():
        usual = np.log([mapping[name] for mapping in others])
        larger = float(np.log(before[name]) - np.mean(usual))
        if larger > (deviation := float(np.std(usual))):
            factors[name] = float(np.exp(larger * (1.0 - (deviation / larger) ** 2)))
    return factors


def _sureness(document: PlantDocument) -> dict[str, float]:
    """Return half-widths of a plant by name, in SI, times size and root of the number of periods of its responses."""
    parts = (document.fit and document.fit.responses) or []
    size = sum(
        (part.averages or 1.0) * float(part.velocity_rms.si("velocity", document.motion)) ** 2
        for part in parts if part.velocity_rms is not None
    )  # fmt: skip
    return {
        name: estimate.half_width * np.sqrt(size) for name, estimate in elements(document.estimates(document.motion))
        if size > 0 and 0 < estimate.half_width < inf
    }  # fmt: skip


def _drawn(
    axis: Axis, trials: Sequence[experiment.Trial], seed: int, blocks: int | None, advance: Callable[..., object],
    *, without_plant: bool,
) -> Drawn:  # fmt: skip
    logs = []
    for trial, run in experiment.runs_of(axis, anywhere(axis, trials, seed), experiment.ACCURACY):
        logs.append(trial.log(axis, run, seed))
        advance()
    results: list[PlantDocument | FrictionDocument] = []
    reasons = {}
    moving = [record for record in logs if record.kind != "frequency-response"]
    for some in (moving,) if without_plant else (logs, moving):  # the rest goes without a plant
        try:
            results.extend(identified(some, blocks) if some is logs or not results else ())
        except FricError as error:
            reasons[some is logs, len(results)] = PLAN_NOT_ENOUGH.found(why=error.what)
    advance()
    return results, reasons


def expected(
    axis: Axis, planned: Sequence[Planned], advance: Callable[..., object], draws: int = DRAWS,
    known: FrictionDocument | None = None, plant: PlantDocument | None = None, earlier: dict[int, Drawn] | None = None,
) -> Expectation:  # fmt: skip
    """Return the intervals that planned records of an axis will give.

    axis: The axis as known beforehand, with the noise and the encoder of its logs.
    draws: Number of runs and identifications.
    earlier: What earlier runs of these records gave, by seed; filled with those of this call.
    known, plant: Files of the axis, which hold the residuals of its friction models and the scatter of its response.
    """
    trials = [trial for record in planned for trial in record.trials(axis)]
    blocks: int | None = None
    found: list[dict[str, tuple[float, float, str]]] = []
    reasons: dict[tuple[bool, int], Notice] = {}  # Why an identification ended, by how far it came
    documents, plants = list[FrictionDocument](), list[PlantDocument]()
    earlier = {} if earlier is None else earlier
    for seed in range(1, draws + 1):
        if seed not in earlier:
            without = bool(found) and (True, 0) in reasons  # no plant in an earlier run: none is reported
            earlier[seed] = _drawn(axis, trials, seed, blocks, advance, without_plant=without)
        results, why = earlier[seed]
        reasons = why | reasons
        last = results[-1] if results else None
        if isinstance(last, FrictionDocument) and last.section("gms") and blocks is None:
            blocks = len(last.estimates("gms")["k"].value)  # type: ignore[arg-type]
        if isinstance(last, FrictionDocument) and last.section("static"):
            documents.append(last)
        plants += [result for result in results if isinstance(result, PlantDocument)]
        found.append(half_widths(results))
    parameters = {}
    for name in (name for name in found[0] if all(name in mapping for mapping in found)):
        values, half, units = zip(*(mapping[name] for mapping in found), strict=True)
        parameters[name] = Expected(float(np.median(values)), typical(half), units[0], (min(half), max(half)))
    notices = list(dict.fromkeys(reasons.values()))
    wider = {} if known is None else widening(known, parameters, documents)
    scattered = {} if plant is None else scattering(plant, plants)
    for name, factor in (wider | {n: f for n, f in scattered.items() if n in parameters}).items():
        was = parameters[name]
        least, most = was.between
        parameters[name] = replace(was, half_width=factor * was.half_width, between=(factor * least, factor * most))
    if uncertain := [name for name, factor in wider.items() if factor > NOTABLE]:
        notices.append(PLAN_LEFT_OVER.found(names=uncertain))
    if plant is None and {"A", "B"} & parameters.keys() and {"F_c", "F_s"} & set(uncertain):
        notices.append(PLAN_PLANT_UNSURE.found())
    return Expectation(parameters, blocks, tuple(notices))


def planned_for(
    axis: Axis, limits: Limits, wanted: Wanted, advance: Callable[..., object], draws: int | None = None,
    known: FrictionDocument | None = None, plant: PlantDocument | None = None, *, micro_steps: bool = False,
) -> tuple[tuple[Planned, ...], Expectation]:  # fmt: skip
    """Return the experiments for the requested half-widths, as far as possible, and the expected intervals.

    wanted: Requested half-width by parameter, and whether it is relative to the value.
    Others as in `choose` and `expected`.
    """
    times: dict[str, int] = {}
    before, seen = times, dict[str, float]()  # Factors and lacks of the round before
    drawn = dict[tuple[tuple[str, int], ...], dict[int, Drawn]]()
    tried, ended = list[Mapping[str, int]](), set[str]()  # All factors; kinds of which more narrow nothing
    slow = axis.second_mass is not None or axis.reality != NONE or bool(wanted)
    if draws is None:
        of_axis = () if slow else (r for r in choose(axis, limits, micro_steps=micro_steps) if r.kind != "circle")
        draws = SLOW_DRAWS if slow or sum(durations(axis, tuple(of_axis))) > LASTING else DRAWS
    runs = 1 if wanted else draws  # to see roughly how many records are needed
    while True:
        planned = choose(axis, limits, times, micro_steps=micro_steps)
        earlier = drawn.setdefault(tuple(sorted(times.items())), {})
        found = expected(axis, planned, advance, runs, known, plant, earlier)
        lacking = dict(lacks(wanted, found))
        more = more_records(wanted, found, times) | {kind: times.get(kind, 1) for kind in ended}
        for kind in times.keys() - ended:
            lacks_of = [(lack, seen[name]) for name, lack in lacking.items() if KIND_OF[name] == kind]
            if times[kind] > before.get(kind, 1) and all(last <= lack for lack, last in lacks_of):
                ended.add(kind)
                more[kind] = before.get(kind, 1)
        more = {kind: factor for kind, factor in more.items() if factor > 1}
        if more == times and runs == draws:
            missed = [
                PLAN_ACCURACY.found(
                    name=name, lack=lack,
                    records=f"{n} times the records" if (n := times.get(KIND_OF[name], 1)) > 1 else "the records",
                    reach=f"reach {lack:.2g} times the half-width asked for" if lack < inf else "give no interval",
                    end="more do not narrow it" if KIND_OF[name] in ended else "more are not tried",
                ) for name, lack in lacking.items() if lack > 1.0
            ]  # fmt: skip
            return planned, replace(found, notices=(*missed, *found.notices))
        tried.append(times)
        runs = draws if more in tried else runs
        before, seen, times = times, lacking, more


def lacks(wanted: Wanted, found: Expectation) -> Iterator[tuple[str, float]]:
    """Yield the ratio of expected to requested half-width of each requested parameter; of blocks the worst."""
    for name, (target, relative) in wanted.items():
        of = [parameter for key, parameter in found.parameters.items() if name in (key, key.rpartition("_")[0])]
        ratios = (expected.half_width / (target * (abs(expected.value) if relative else 1.0)) for expected in of)
        yield name, max(ratios, default=inf)


def more_records(wanted: Wanted, found: Expectation, times: Mapping[str, int]) -> dict[str, int]:
    """Return the factor of the number of strokes, cycles or periods: a half-width falls with its root."""
    more = dict(times)
    for name, lack in lacks(wanted, found):
        now = times.get(kind := KIND_OF[name], 1)
        if lack > 1.0 and (now * lack**2 < HOPELESS * MOST_TIMES or lack == inf):
            more[kind] = max(more.get(kind, 1), ceil(min(max(now * lack**2, 2 * now), MOST_TIMES)))
    return more
