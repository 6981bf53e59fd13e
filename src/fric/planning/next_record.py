"""The further record that would narrow a predicted glitch most, after a first identification.

To first order the glitch varies by ``gᵀ·Σ·g``: g are its derivatives over the uncertain parameters of the friction (the
controller believes the estimates), Σ their covariance. One more record adds its Fisher information, ``Σ' = (Σ⁻¹ +
I)⁻¹``: that of the residuals, weights and models of the fits, at the last result.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import exp, log

import numpy as np
from scipy.linalg import block_diag

from fric.arrays import Real
from fric.choice import ranked
from fric.control.scheme import Scheme
from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.estimate import Covariance
from fric.friction.gms import GMS
from fric.friction.stribeck import STATIC_PARAMETERS
from fric.identify.gms.hunting import Hunting
from fric.identify.gms.virgin_curve import find_cycles
from fric.identify.replay.replay_fit import replay_information
from fric.identify.replay.replay_search import Ranges, search_ranges
from fric.identify.static_map.points import stroke_points
from fric.identify.static_map.stribeck_fit import StribeckProblem
from fric.log import Log
from fric.planning.choose import choose
from fric.records.prepared import prepared
from fric.simulate.circle import Circle, run_circle
from fric.simulate.experiment import logs_of
from fric.simulate.machine import Axis, Machine, NominalFriction
from fric.simulate.plan import CandidateRecord, Limits, Narrowing, Planned

NORMAL = 1.959963984540054  # Half a 95 % interval in standard deviations
ASSUMED = {"C": log(10.0) / NORMAL}  # Standard deviation of the logarithm of an assumed parameter: C to a factor of ten
SURE = 0.4  # Relative uncertainty of a further record's information: half-widths of simulated ones are good to 20 %
LARGEST = 0.5  # Largest step of a logarithm or logit in which a derivative is taken


def narrowing(
    machine: Machine,
    axis: Axis,
    limits: Limits,
    covariances: Sequence[Covariance],
    between: float,
    scheme: Scheme,
    advance: Callable[[], object] = lambda: None,
) -> Narrowing:
    """Return how a further record would narrow the predicted glitch of an axis.

    axis: The axis at the last result: its friction is the GMS model that was identified.
    covariances: Covariances of the parameters of its static map and of its GMS model, as in its friction file.
    between: Standard deviation of strokes beyond their noise [N].
    Raises FricError: When the friction is no GMS model of both directions, or a record cannot be made.
    """
    model = axis.friction
    if not isinstance(model, GMS):
        raise FricError(
            "planning needs a GMS model with a common map for both directions",
            hint="Identify one with `fric identify gms`; `fric plan --friction` says which records that takes.",
        )
    known = _known(covariances, model)
    planned = choose(axis, limits)
    circle = next(record for record in planned if record.kind == "circle").settings
    test = Circle(float(circle["radius"]), float(circle["feed"]))  # type: ignore[arg-type]
    slopes = _slopes(machine, axis, model, known, scheme, test, advance)
    names, S = list(known.deviation), known.matrix
    half = NORMAL * _deviation(slopes, S)
    worst = slopes[int(np.argmax(np.einsum("qi,ij,qj->q", slopes, S, slopes)))]
    shares = worst * (S @ worst) / max(float(worst @ S @ worst), 1e-300)
    found = []
    experiments = [part for record in planned for part in _parts(record)]
    logs = [list(logs_of(axis, experiment.trials(axis), 1)) for experiment in experiments]
    sines = [log for each in logs for log in each if "sine" in str(log.kind)]
    ranges = search_ranges(prepared(sines, axis.plant))
    for experiment, made in zip(experiments, logs, strict=True):
        advance()
        I = _information(made, axis, model, known, between, ranges)  # noqa: E741 - Fisher's
        least, after, most = (
            NORMAL * _deviation(slopes, np.asarray(np.linalg.inv(np.linalg.inv(S) + share * I), float))
            for share in (1 + SURE, 1.0, 1 - SURE)
        )
        lasting = sum(len(trial.reference) for trial in experiment.trials(axis)) / axis.cascade.sampling
        found.append(CandidateRecord(experiment, lasting, after, 0.5 * (most - least)))
    return Narrowing(
        half, dict(zip(names, map(float, shares), strict=True)), by_what_they_leave(found), test, scheme.name
    )


def by_what_they_leave(candidates: Sequence[CandidateRecord]) -> tuple[CandidateRecord, ...]:
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
        for amplitude in amplitudes:
            yield replace(record.changed(amplitudes=(amplitude,)), why="a slow sine before sliding")
    elif record.kind == "sliding-sine":
        yield replace(record, why="a sine in sliding")


@dataclass(frozen=True)
class _Known:
    """The uncertain parameters by name: standard deviations, on a linear scale or not, and the covariance."""

    deviation: dict[str, float]
    linear: frozenset[str]
    matrix: Real


def _known(covariances: Sequence[Covariance], model: GMS) -> _Known:
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
    return _Known(dict(zip(names, np.sqrt(np.diag(matrix)), strict=True)), frozenset(linear), matrix)


def _deviation(slopes: Real, covariance: Real) -> float:
    """Return the largest standard deviation of the quadrants' glitches [m]."""
    return float(np.sqrt(max(np.einsum("qi,ij,qj->q", slopes, covariance, slopes))))


def _slopes(
    machine: Machine, axis: Axis, model: GMS, known: _Known, scheme: Scheme, test: Circle, advance: Callable[[], object]
) -> Real:
    """Return the derivatives of this axis' two glitches over the parameters, shape (2, p), by central differences.

    The encoder is left out: differences of nanometres would show its counts.
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
            run = run_circle(replace(machine, axes={**machine.axes, axis.name: subject}), scheme, test, only=axis.name)
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
        high = model.static.F_s if name == "F_c" else float("inf")
        moved = min(max(value + by, low), high)
        return replace(model, static=replace(model.static, **{name: moved})), moved - value
    symbol, _, number = name.partition("_")
    if symbol == "C":
        return replace(model, C=model.C * exp(by)), by
    n = int(number) - 1
    if symbol == "k":
        return replace(model, k=tuple(k * exp(by) if i == n else k for i, k in enumerate(model.k))), by
    share = 1 / (1 + (1 / model.alpha[n] - 1) * exp(-by))
    alpha = [share if i == n else a for i, a in enumerate(model.alpha)]
    alpha[-1] = 1 - sum(alpha[:-1])
    return replace(model, alpha=tuple(alpha)), by


def _information(logs: Sequence[Log], axis: Axis, model: GMS, known: _Known, between: float, ranges: Ranges) -> Real:
    """Return the information of one record over all parameters, shape (p, p)."""
    names = list(known.deviation)
    if logs[0].kind == "constant-velocity":
        points, _ = stroke_points(logs, plant=axis.plant)
        v, F, error = np.array([(p.velocity, p.force, p.standard_error) for p in points]).T
        static = model.static
        problem = StribeckProblem(
            v, F, np.hypot(error, between), None if "delta" in names else static.delta,
            "offset" in names, "F_s" in names,
        )  # fmt: skip
        theta = {name: getattr(static, name) for name in STATIC_PARAMETERS}
        J = problem.jacobian(theta) / problem.standard_error[:, None]
        of, found = problem.free, J.T @ J
    else:
        ready = prepared(logs, axis.plant)
        slides = logs[0].kind == "sliding-sine"
        records = [record.in_sliding() if slides else find_cycles(record).for_replay() for record in ready]
        of, found = replay_information(records, model, ranges, Hunting(axis.plant))
    at = [names.index(name) for name in of if name in names]
    kept = [n for n, name in enumerate(of) if name in names]
    information = np.zeros((len(names), len(names)))
    information[np.ix_(at, at)] = found[np.ix_(kept, kept)]
    return information
