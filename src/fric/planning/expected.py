"""The intervals that planned experiments will give: the identification itself, on records simulated at the prior.

The information of the records is the Fisher information of their fits: the same records, residuals, weights and models.
They are simulated several times on the axis as known beforehand, with different noise and different places between two
encoder counts, and identified each time; the results are the geometric mean and the range of the half-widths.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, inf, isfinite

import numpy as np

from fric.columns import PRESLIDING
from fric.documents.friction import FrictionDocument, gms_tree, static_tree
from fric.documents.plant import PlantDocument, plant_tree
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.prediction import PLAN_ACCURACY, PLAN_LEFT_OVER, PLAN_NOT_ENOUGH, PLAN_PLANT_UNSURE
from fric.friction.stribeck import STATIC_PARAMETERS
from fric.identify.gms.identify import identify_gms
from fric.identify.plant.identify import identify_plant
from fric.identify.static_map.identify import identify_static
from fric.log import Log
from fric.notice import Notice
from fric.planning.choose import choose
from fric.simulate.experiment import Trial, runs_of
from fric.simulate.machine import Axis
from fric.simulate.plan import Expected, Limits, Planned
from fric.simulate.reality.flaws import NONE

DRAWS, FEW = 9, 3
"""Runs of a plan that are identified: the range of nine includes the next in 80 % of cases, that of three in 50 %. Few
are those of an axis with a second mass or flaws: each takes five times as long."""
PLACES = 64.0  # Encoder counts over which the start of a record is spread: the hunting of a slow axis depends on it
ACCURACY = 1e-10  # Largest error of the position by the integration [m]: 0.01 N of a stiffness of 100 N/µm
NOTABLE = 1.2  # Widening by unmodelled friction above which it is reported
MOST_TIMES = 16  # Largest factor of the usual number of strokes, cycles or periods

IDENTIFIED_BY = {
    "constant-velocity": (*STATIC_PARAMETERS, "offset"), "presliding-sine": ("alpha", "k"),
    "sliding-sine": ("C",), "frequency-response": ("A", "B", "T_d", "K_f", "force_lag"),
}  # fmt: skip
"""The parameters that each kind of record determines."""
Wanted = Mapping[str, tuple[float, bool]]  # Requested half-width by parameter, and whether it is relative to the value


@dataclass(frozen=True)
class Expectation:
    """Expected intervals of an axis from planned records."""

    parameters: Mapping[str, Expected]  # By name, ``k_2`` being that of the second block
    blocks: int | None  # Number of slip blocks that the identification finds; None where there is no GMS model
    notices: tuple[Notice, ...]  # What cannot be expected of these records


def identified(logs: Sequence[Log], blocks: int | None = None) -> Iterator[PlantDocument | FrictionDocument]:
    """Yield plant, static map and GMS model of the records of an axis, each if there are records for it."""
    plant = static = None
    of_kind = {kind: [log for log in logs if log.kind == kind] for kind in {log.kind for log in logs}}
    if responses := of_kind.get("frequency-response"):
        plant = PlantDocument.model_validate(plant_tree(identify_plant(responses), responses))
        yield plant
    known = None if plant is None else plant.plant(logs[0].motion)
    if strokes := of_kind.get("constant-velocity"):
        error = 0.0 if plant is None else plant.damping_error(logs[0].motion)
        # in one form in all runs: half-widths of a run with delta free and a run without have no mean
        fit = identify_static(strokes, plant=known, delta=1.0, over_position="off", damping_error=error)
        static = FrictionDocument.model_validate(static_tree(fit, strokes))
        yield static
    if of_kind.keys() & PRESLIDING:
        sines = [log for log in logs if log.kind in {*PRESLIDING, "sliding-sine"}]
        forward, backward = (None, None) if static is None else static.maps()
        found = identify_gms(sines, static=forward, negative=backward, plant=known, blocks=blocks, places=1)
        yield FrictionDocument.model_validate(gms_tree(found, sines, static))


def half_widths(documents: Sequence[PlantDocument | FrictionDocument]) -> dict[str, tuple[float, float, str]]:
    """Return value, half-width of the 95 % interval (infinite if open) and unit by parameter, in SI."""
    found = {}
    for document in documents:
        if isinstance(document, FrictionDocument):
            sections = [document.estimates(section) for section in document.sections()]
        else:
            parts = [document, *([document.second_mass] if document.second_mass is not None else [])]
            sections = [part.estimates(document.motion) for part in parts]
        for name, value, (low, high), unit in (element for section in sections for element in _elements(section)):
            found[name] = value, high - value if low == 0 else 0.5 * (high - low), unit  # at its bound it has one side
    return found


def _elements(section: Mapping[str, Estimate]) -> Iterator[tuple[str, float, tuple[float, float], str]]:
    """Yield name, value, interval and unit of each number that has an interval; of a vector each element's."""
    for name, estimate in section.items():
        if estimate.ci95 is not None:
            values, limits = np.ravel(estimate.value).tolist(), np.reshape(estimate.ci95, (-1, 2)).tolist()
            names = [f"{name}_{n}" for n in range(1, len(values) + 1)] if isinstance(estimate.value, tuple) else [name]
            for key, value, (low, high) in zip(names, values, limits, strict=True):
                yield key, value, (low, high), estimate.unit


def typical(halves: Sequence[float]) -> float:
    """Return the geometric mean of half-widths, or their median if any is open.

    An interval may have one of two sizes, depending on a test within the identification: a median of few runs would
    pick one by chance.
    """
    closed = bool(np.all(np.isfinite(halves))) and min(halves) > 0
    return float(np.exp(np.mean(np.log(halves))) if closed else np.median(halves))


def anywhere(axis: Axis, trials: Sequence[Trial], seed: int) -> list[Trial]:
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
        for name, _, (low, high), _ in _elements(known.estimates(section)) if most > 1.0 else ():
            if name in parameters:
                found[name] = min(max(0.5 * (high - low) / parameters[name].half_width, 1.0), most)
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
        name: 0.5 * (high - low) * np.sqrt(size)
        for name, _, (low, high), _ in _elements(document.estimates(document.motion))
        if size > 0 and np.isfinite(high - low) and high > low
    }


def expected(
    axis: Axis,
    planned: Sequence[Planned],
    advance: Callable[..., object],
    draws: int = DRAWS,
    known: FrictionDocument | None = None,
    plant: PlantDocument | None = None,
) -> Expectation:
    """Return the intervals that planned records of an axis will give.

    axis: The axis as known beforehand, with the noise and the encoder of its logs.
    draws: Number of runs and identifications.
    known, plant: Files of the axis, which hold the residuals of its friction models and the scatter of its response.
    """
    trials = [trial for record in planned for trial in record.trials(axis)]
    blocks: int | None = None
    found: list[dict[str, tuple[float, float, str]]] = []
    notices: list[Notice] = []
    documents: list[FrictionDocument] = []
    plants: list[PlantDocument] = []
    for seed in range(1, draws + 1):
        logs = []
        for trial, run in runs_of(axis, anywhere(axis, trials, seed), ACCURACY):
            logs.append(trial.log(axis, run, seed))
            advance()
        results: list[PlantDocument | FrictionDocument] = []
        try:
            for result in identified(logs, blocks):
                results.append(result)
        except FricError as error:
            notices.append(PLAN_NOT_ENOUGH.found(why=error.what))
        last = results[-1] if results else None
        if isinstance(last, FrictionDocument) and last.section("gms") and blocks is None:
            blocks = len(last.estimates("gms")["k"].value)  # type: ignore[arg-type]
        if isinstance(last, FrictionDocument) and last.section("static"):
            documents.append(last)
        plants += [result for result in results if isinstance(result, PlantDocument)]
        found.append(half_widths(results))
        advance()
    parameters = {}
    for name in (name for name in found[0] if all(name in mapping for mapping in found)):
        values, half, units = zip(*(mapping[name] for mapping in found), strict=True)
        middle = typical(half)
        parameters[name] = Expected(float(np.median(values)), middle, units[0], (min(half), max(half)))
    wider = {} if known is None else widening(known, parameters, documents)
    scattered = {} if plant is None else scattering(plant, plants)
    for name, factor in (wider | {n: f for n, f in scattered.items() if n in parameters}).items():
        one = parameters[name]
        least, most = one.between
        parameters[name] = replace(one, half_width=factor * one.half_width, between=(factor * least, factor * most))
    if uncertain := [name for name, factor in wider.items() if factor > NOTABLE]:
        notices.append(PLAN_LEFT_OVER.found(names=uncertain))
    if plant is None and {"A", "B"} & parameters.keys() and {"F_c", "F_s"} & set(uncertain):
        notices.append(PLAN_PLANT_UNSURE.found())
    return Expectation(parameters, blocks, tuple(dict.fromkeys(notices)))


def planned_for(
    axis: Axis,
    limits: Limits,
    wanted: Wanted,
    advance: Callable[..., object],
    draws: int | None = None,
    known: FrictionDocument | None = None,
    plant: PlantDocument | None = None,
    *,
    micro_steps: bool = False,
) -> tuple[tuple[Planned, ...], Expectation]:
    """Return the experiments for the requested half-widths, as far as possible, and the expected intervals.

    wanted: Requested half-width by parameter, and whether it is relative to the value.
    Others as in `choose` and `expected`.
    """
    times: dict[str, int] = {}
    draws = draws or (DRAWS if axis.second_mass is None and axis.reality == NONE else FEW)
    while True:
        planned = choose(axis, limits, times, micro_steps=micro_steps)
        found = expected(axis, planned, advance, draws, known, plant)
        more = more_records(wanted, found, times)
        if more == times:
            missed = [PLAN_ACCURACY.found(name=name, lack=lack, times=MOST_TIMES)
                      for name, lack in lacks(wanted, found) if lack > 1.0]  # fmt: skip
            return planned, replace(found, notices=(*missed, *found.notices))
        times = more


def lacks(wanted: Wanted, found: Expectation) -> Iterator[tuple[str, float]]:
    """Yield the ratio of expected to requested half-width of each requested parameter; of blocks the worst."""
    for name, (target, relative) in wanted.items():
        of = [parameter for key, parameter in found.parameters.items() if name in (key, key.rpartition("_")[0])]
        ratios = (one.half_width / (target * (abs(one.value) if relative else 1.0)) for one in of)
        yield name, max(ratios, default=inf)


def more_records(wanted: Wanted, found: Expectation, times: Mapping[str, int]) -> dict[str, int]:
    """Return the factor of the number of strokes, cycles or periods: a half-width falls with its root."""
    more = dict(times)
    for name, lack in lacks(wanted, found):
        kind = next(kind for kind, names in IDENTIFIED_BY.items() if name in names)
        if lack > 1.0:
            needed = times.get(kind, 1) * lack**2 if isfinite(lack) else MOST_TIMES
            more[kind] = max(more.get(kind, 1), min(ceil(needed), MOST_TIMES))
    return more
