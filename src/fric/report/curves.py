"""What the figures of a report are drawn from: curves with bands from documents, points and cycles from logs."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from fric.arrays import Real
from fric.columns import PRESLIDING
from fric.documents.friction import Fit, FrictionDocument
from fric.documents.plant import PlantDocument, PlantPart
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import Covariance, Estimate
from fric.figures.gms import ReplayedCycle
from fric.figures.style import Band
from fric.friction.gms import GMS
from fric.friction.stribeck import STATIC_PARAMETERS, StaticMap
from fric.identify.gms.virgin_curve import HysteresisCycles, VirginCurve, find_cycles, virgin_curve
from fric.identify.static_map.identify import stroke_forces
from fric.identify.static_map.points import SpeedPoint
from fric.log import ForceVelocity, Log
from fric.records.prepared import prepared
from fric.report.collect import Item, ReportInput
from fric.units import rotates

CYCLE_POINTS = 1500
"""Points of a cycle that are drawn."""


@dataclass(frozen=True, eq=False)
class FrictionCurves:
    """What can be drawn of the friction of one axis."""

    maps: Mapping[str, Band]  # ``both``, or ``positive`` and ``negative``: force over speed in the direction of motion
    points: tuple[SpeedPoint, ...] = ()  # measured strokes, the offset of the force channel taken off
    fitted: bool = False  # whether the map's band is by the covariance of its fit, not by the intervals alone
    virgin: Band | None = None  # of the GMS model
    measured_virgin: VirginCurve | None = None  # of the logs
    knots: tuple[Real, Real] | None = None  # slip displacement of each block [m], and the force there [N]
    hysteresis: tuple[ReplayedCycle, ...] = ()
    notes: tuple[str, ...] = ()  # why something is not drawn


def friction_curves(inputs: ReportInput, item: Item) -> FrictionCurves:
    """Return what can be drawn of a friction document: alone, and with the logs of its axis."""
    sections = item.sections()
    static = {name: content for name, content in sections.items() if name in {"static", "static_negative"}}
    logs = [
        log for log in inputs.records if isinstance(log, Log) and (log.axis, log.motion) == (item.axis, item.motion)
    ]
    tables = [
        record
        for record in inputs.records
        if isinstance(record, ForceVelocity) and (record.axis, record.motion) == (item.axis, item.motion)
    ]
    strokes: list[Log | ForceVelocity] = [*(log for log in logs if log.kind == "constant-velocity"), *tables]
    waves = [log for log in logs if log.kind in PRESLIDING]
    assert isinstance(item.document, FrictionDocument)
    plant, notes = _plant(inputs, item, item.document.fit_of("static")) if strokes else (None, [])
    points: tuple[SpeedPoint, ...] = ()
    if static and strokes and not notes:
        offset = float(sections["static"]["offset"]) if "offset" in sections["static"] else 0.0
        found = stroke_forces(strokes, item.motion, plant)
        points = tuple(replace(point, force=point.force - offset) for point in found)
    together = {name: block.covariance() for name in static if (block := item.document.fit_of(name).covariance)}
    maps = {
        _direction(name, static): map_band(mapping, _speeds(mapping, points), together.get(name))
        for name, mapping in static.items()
    }
    if "gms" not in sections:
        return FrictionCurves(maps, points, bool(together), notes=tuple(notes))
    model = GMS.from_sections(sections)
    plant, without = _plant(inputs, item, item.document.fit_of("gms")) if waves else (None, [])
    notes = list(dict.fromkeys(notes + without))
    hysteresis, curve = ((), None) if without else _measured(waves, plant, model)
    longest = 1.6 * float(model.slip_displacements.max())
    longest = max(longest, float(curve.displacement[-1])) if curve is not None else longest
    knots = np.sort(model.slip_displacements)
    return FrictionCurves(
        maps, points, bool(together), virgin_band(sections, longest), curve, (knots, model.virgin_curve(knots)),
        hysteresis or model_cycles(model), tuple(notes),
    )  # fmt: skip


def _direction(name: str, static: Mapping[str, object]) -> str:
    return "both" if len(static) == 1 else "negative" if name.endswith("negative") else "positive"


def _plant(inputs: ReportInput, item: Item, fit: Fit) -> tuple[Plant | None, list[str]]:
    """Return the plant whose part is taken off the logged force, as it was when the friction was identified."""
    if not fit.taken_off:
        return None, []
    given = inputs.of("plant", item.axis)
    part: PlantPart | None = fit.plant
    if part is None and given is not None and isinstance(given.document, PlantDocument):
        part = given.document  # of a file that does not name the plant yet
    if part is None:
        return None, [
            "The logs are not drawn: the drive's own damping was taken off before the friction was identified. "
            "Give the plant file too."
        ]
    try:
        return part.plant(item.motion), []
    except FricError as error:
        return None, [f"The logs are not drawn, because the plant does not tell enough: {error.what}."]


def _speeds(static: Mapping[str, Estimate], points: Sequence[SpeedPoint]) -> Real:
    """Return the speeds [m/s] at which a map is drawn: those that were measured, or around the Stribeck velocity."""
    v_s = float(static["v_s"])
    if points:
        seen = np.abs([point.velocity for point in points])
        return np.geomspace(seen.min() / 2, seen.max() * 1.05, 240)
    return np.geomspace(v_s / 30, v_s * 100, 240)


def map_band(static: Mapping[str, Estimate], speed: Real, covariance: Covariance | None = None) -> Band:
    """Return the static map, eq. (2), over speed [m/s], with a band of 95 %.

    By the covariance of its parameters, where the file holds it. Else they are moved to the limits of their intervals
    one by one, and the effects are added in quadrature: the parameters are correlated, so that band is too wide.
    """
    values = {name: float(static[name]) for name in STATIC_PARAMETERS if name in static}

    def force(changed: Mapping[str, float]) -> Real:
        return StaticMap(**{**values, **changed}).steady_state(speed)

    if covariance is None:
        return Band(speed, *_in_quadrature(force, {name: static[name] for name in values}))
    kept = [n for n, name in enumerate(covariance.names) if name in values]
    matrix = np.array(covariance.matrix)[np.ix_(kept, kept)]
    steps = 1e-3 * np.sqrt(np.diag(matrix))
    moved = [
        (force({name: values[name] + step}) - force({name: values[name] - step})) / (2 * step) if step else 0.0 * speed
        for name, step in zip((covariance.names[n] for n in kept), steps, strict=True)
    ]
    half = _quantile(static, covariance) * np.sqrt(np.einsum("in,ij,jn->n", moved, matrix, moved))
    middle = force({})
    return Band(speed, middle, middle - half, middle + half)


def _quantile(static: Mapping[str, Estimate], covariance: Covariance) -> float:
    """Return how many deviations half an interval is wide, by that of the offset, or of F_c: 2 of many strokes."""
    name = "offset" if "offset" in covariance.names else "F_c"
    low, high = static[name].ci95 or (-inf, inf)
    deviation = covariance.matrix[covariance.names.index(name)][covariance.names.index(name)] ** 0.5
    width = high - low if isinstance(low, float) and isinstance(high, float) else inf
    return float(np.clip(0.5 * width / deviation, 1.96, 4.0)) if deviation > 0 else 1.96


def virgin_band(sections: Mapping[str, Mapping[str, Estimate]], longest: float) -> Band:
    """Return the virgin curve ``Σ min(k_i·z, alpha_i·F_s)`` up to a displacement [m], with its band as `map_band`."""
    model = GMS.from_sections(sections)
    knots = model.slip_displacements
    z = np.unique(np.concatenate([np.geomspace(0.02 * knots.min(), longest, 300), knots[knots <= longest]]))
    alpha, k, F_s = sections["gms"]["alpha"], sections["gms"]["k"], sections["static"]["F_s"]
    single: dict[str, Estimate] = {"F_s": F_s}
    for name, vector, given in (("alpha", alpha, model.alpha), ("k", k, model.k)):
        intervals = vector.ci95 or (None,) * len(given)
        for n, (value, interval) in enumerate(zip(given, intervals, strict=True)):
            single[f"{name}_{n}"] = replace(vector, value=value, ci95=interval)  # type: ignore[arg-type]

    def force(changed: Mapping[str, float]) -> Real:
        limit = np.array([changed.get(f"alpha_{n}", a) for n, a in enumerate(model.alpha)])
        limit = limit / limit.sum() * changed.get("F_s", model.static.F_s)
        stiffness = np.array([changed.get(f"k_{n}", value) for n, value in enumerate(model.k)])
        return np.asarray(np.minimum(stiffness * z[:, np.newaxis], limit).sum(axis=1))

    return Band(z, *_in_quadrature(force, single))


def _in_quadrature(
    force: Callable[[Mapping[str, float]], Real], parameters: Mapping[str, Estimate]
) -> tuple[Real, Real, Real]:
    """Return a curve and its limits; a limit that the data do not set moves nothing."""
    middle = force({})
    below, above = np.zeros_like(middle), np.zeros_like(middle)
    for name, estimate in parameters.items():
        limits: tuple[float, ...] = tuple(estimate.ci95) if estimate.ci95 is not None else ()  # type: ignore[arg-type]
        moved = [force({name: limit}) - middle for limit in limits if abs(limit) != inf]
        if moved:
            above += np.maximum(np.max(moved, axis=0), 0.0) ** 2
            below += np.minimum(np.min(moved, axis=0), 0.0) ** 2
    return middle, middle - np.sqrt(below), middle + np.sqrt(above)


def model_cycles(model: GMS) -> tuple[ReplayedCycle, ...]:
    """Return slow cycles of a GMS model: small cycles inside its pre-sliding, and a cycle that slides at its ends."""
    longest = float(model.slip_displacements.max())
    hysteresis = []
    for share in (0.25, 0.5, 1.5):
        time = np.linspace(0.0, 2.25, 3 * CYCLE_POINTS)
        position = share * longest * np.sin(2 * np.pi * time)
        # so slow that the level is F_s throughout
        force = model.replay(time * 1e6, position, np.gradient(position, time * 1e6))
        last = time >= 1.25
        hysteresis.append(
            ReplayedCycle(f"amplitude {share:g} times the pre-sliding", position[last][::3], None, force[last][::3])
        )
    return tuple(hysteresis)


def _measured(
    waves: Sequence[Log], plant: Plant | None, model: GMS
) -> tuple[tuple[ReplayedCycle, ...], VirginCurve | None]:
    """Return the cycles that were measured with the model replayed along them, and the virgin curve in them."""
    found: list[HysteresisCycles] = []
    hysteresis = []
    for log in waves:
        cycle = find_cycles(prepared([log], plant)[0])
        motion, force = cycle.motion, cycle.force
        found.append(cycle)
        replayed = model.replay(log.time, motion.position, motion.velocity)
        start = int(cycle.reversals[0])  # the state before the first reversal is not known
        every = max(1, (len(force) - start) // CYCLE_POINTS)
        part = slice(start, None, every)
        middle = 0.5 * float(motion.position.max() + motion.position.min())
        hysteresis.append(ReplayedCycle(log.name, motion.position[part] - middle, force[part], replayed[part]))
    return tuple(hysteresis), (virgin_curve(found, model.static) if found else None)


def presliding(inputs: ReportInput) -> float | None:
    """Return the largest slip displacement of the GMS models that were given [m]; None where there is none."""
    displacements = []
    for item in inputs.items:
        sections = item.sections() if item.kind == "friction" else {}
        if "gms" in sections and "static" in sections and not rotates(item.motion):
            displacements.append(float(GMS.from_sections(sections).slip_displacements.max()))
    return max(displacements, default=None)
