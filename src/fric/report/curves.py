"""What the figures of a report are drawn from: curves with bands from documents, points and loops from logs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from fric.documents.fit import Fit
from fric.documents.friction import FrictionDocument
from fric.documents.plant import PlantDocument, PlantPart
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.friction.gms import GMS
from fric.identify.gms.cycles import Loops, find_loops
from fric.identify.gms.virgin_curve import VirginCurve, virgin_curve
from fric.identify.records.prepared import prepared
from fric.identify.strokes.static import identify_static, steady_points
from fric.log import Log

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.estimate import Estimate
    from fric.identify.strokes.map_fit import MapFit, SpeedPoint
    from fric.report.material import Item, Material

SAME = 0.02
"""Share of its interval by which a number may differ that a file rounds, and that is fitted again."""

LOOP_POINTS = 1500
"""Points of a loop that are drawn."""


@dataclass(frozen=True, eq=False)
class Band:
    """A curve with its 95 % band: shape (n,) each."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Loop:
    """A pre-sliding loop: displacement [m], measured force (None without a log) and that of the model [N]."""

    name: str
    position: NDArray[np.float64]
    measured: NDArray[np.float64] | None
    model: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FrictionCurves:
    """What can be drawn of the friction of one axis.

    Parameters
    ----------
    maps
        The static map of both directions (``both``), or of each (``positive``, ``negative``), force over speed in the
        direction of motion.
    points
        Measured strokes, with the offset of the force channel taken off.
    fitted
        True where the map's band is that of its fit to these strokes, made again; else it is from the intervals alone.
    virgin
        The virgin curve of the GMS model.
    measured_virgin
        That of the logs.
    knots
        Slip displacement of each block [m] and the force there [N].
    loops
        Pre-sliding loops.
    notes
        Why something is not drawn.
    """

    maps: Mapping[str, Band]
    points: tuple[SpeedPoint, ...] = ()
    fitted: bool = False
    virgin: Band | None = None
    measured_virgin: VirginCurve | None = None
    knots: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
    loops: tuple[Loop, ...] = ()
    notes: tuple[str, ...] = ()


def friction_curves(material: Material, item: Item) -> FrictionCurves:
    """Return what can be drawn of a friction document: alone, and with the logs of its axis."""
    sections = item.sections()
    static = {name: content for name, content in sections.items() if name in {"static", "static_negative"}}
    logs = [
        log for log in material.records if isinstance(log, Log) and (log.axis, log.motion) == (item.axis, item.motion)
    ]
    strokes = [log for log in logs if log.kind == "constant-velocity"]
    waves = [log for log in logs if log.kind == "presliding-sine"]
    assert isinstance(item.document, FrictionDocument)
    plant, notes = _plant(material, item, item.document.fit_of("static")) if strokes else (None, [])
    points: tuple[SpeedPoint, ...] = ()
    if static and strokes and not notes:
        offset = float(sections["static"]["offset"]) if "offset" in sections["static"] else 0.0
        found = steady_points(strokes, plant=plant)
        points = tuple(replace(point, force=point.force - offset) for point in found)
    maps = {_direction(name, static): map_band(one, _speeds(one, points)) for name, one in static.items()}
    again = _fitted_again(static["static"], strokes, plant) if points and len(static) == 1 else None
    if again is not None:
        maps = {"both": _band_of_fit(again, _speeds(static["static"], points))}
    if "gms" not in sections:
        return FrictionCurves(maps, points, again is not None, notes=tuple(notes))
    model = GMS.from_sections(sections)
    plant, without = _plant(material, item, item.document.fit_of("gms")) if waves else (None, [])
    notes = list(dict.fromkeys(notes + without))
    loops, curve = ((), None) if without else _measured(waves, plant, model)
    reach = 1.6 * float(model.slip_displacements.max())
    reach = max(reach, float(curve.displacement[-1])) if curve is not None else reach
    knots = np.sort(model.slip_displacements)
    return FrictionCurves(
        maps, points, again is not None, virgin_band(sections, reach), curve, (knots, model.virgin_curve(knots)),
        loops or model_loops(model), tuple(notes),
    )  # fmt: skip


def _direction(name: str, static: Mapping[str, object]) -> str:
    return "both" if len(static) == 1 else "negative" if name.endswith("negative") else "positive"


def _plant(material: Material, item: Item, fit: Fit) -> tuple[Plant | None, list[str]]:
    """Return the plant whose part is taken off the logged force, as it was when the friction was identified."""
    if not fit.taken_off:
        return None, []
    given = material.of("plant", item.axis)
    part: PlantPart | None = fit.plant
    if part is None and given is not None and isinstance(given.document, PlantDocument):
        part = given.document  # of a file that does not tell the plant yet
    if part is None:
        return None, [
            "The logs are not drawn: the drive's own damping was taken off before the friction was identified. "
            "Give the plant file too."
        ]
    try:
        return part.plant(item.motion), []
    except FricError as error:
        return None, [f"The logs are not drawn, because the plant does not tell enough: {error.what}."]


def _speeds(static: Mapping[str, Estimate], points: Sequence[SpeedPoint]) -> NDArray[np.float64]:
    """Return the speeds [m/s] at which a map is drawn: those that were measured, or around the Stribeck velocity."""
    v_s = float(static["v_s"])
    if points:
        seen = np.abs([point.velocity for point in points])
        return np.geomspace(seen.min() / 2, seen.max() * 1.05, 240)
    return np.geomspace(v_s / 30, v_s * 100, 240)


def map_band(static: Mapping[str, Estimate], speed: NDArray[np.float64]) -> Band:
    """Return the static map, eq. (2), over speed [m/s], with a band from the intervals of its parameters.

    The file tells no correlation, so the parameters are moved to the limits of their intervals one by one, and what
    each does is added in quadrature.
    """
    values = {name: float(static[name]) for name in ("F_c", "F_s", "v_s", "delta", "sigma") if name in static}

    def force(changed: Mapping[str, float]) -> NDArray[np.float64]:
        given = {**values, **changed}
        level = given["F_c"] + (given["F_s"] - given["F_c"]) * np.exp(
            -((speed / given["v_s"]) ** given.get("delta", 1))
        )
        return np.asarray(level + given.get("sigma", 0.0) * speed)

    return Band(speed, *_in_quadrature(force, {name: static[name] for name in values}))


def _fitted_again(static: Mapping[str, Estimate], strokes: Sequence[Log], plant: Plant | None) -> MapFit | None:
    """Return the fit of the map to these strokes, where it is the one that the file tells of; else None.

    The file holds no covariance. The strokes do, if they are those that it was identified from.
    """
    delta = static.get("delta")
    try:
        fit = identify_static(strokes, plant=plant, delta=float(delta) if delta is not None and delta.fixed else None)
    except FricError:  # the points are drawn, whatever can be fitted to them
        return None
    if fit.static is None:
        return None
    for name, told in static.items():
        low, high = told.ci95 or (0.0, 0.0)
        width = high - low if isinstance(low, float) and isinstance(high, float) and high - low < inf else 0.0
        found = float(fit.static.estimates[name])
        if abs(found - float(told)) > SAME * width + 1e-5 * abs(found):
            return None
    return fit.static


def _band_of_fit(fit: MapFit, speed: NDArray[np.float64]) -> Band:
    force, half = fit.predict(speed)
    force = force - fit.solution.theta["offset"]
    return Band(speed, force, force - half, force + half)


def virgin_band(sections: Mapping[str, Mapping[str, Estimate]], reach: float) -> Band:
    """Return the virgin curve ``Σ min(k_i·z, alpha_i·F_s)`` up to a displacement [m], with its band as `map_band`."""
    model = GMS.from_sections(sections)
    knots = model.slip_displacements
    z = np.unique(np.concatenate([np.geomspace(0.02 * knots.min(), reach, 300), knots[knots <= reach]]))
    alpha, k, F_s = sections["gms"]["alpha"], sections["gms"]["k"], sections["static"]["F_s"]
    single: dict[str, Estimate] = {"F_s": F_s}
    for name, vector, given in (("alpha", alpha, model.alpha), ("k", k, model.k)):
        intervals = vector.ci95 or (None,) * len(given)
        for n, (value, interval) in enumerate(zip(given, intervals, strict=True)):
            single[f"{name}_{n}"] = replace(vector, value=value, ci95=interval)  # type: ignore[arg-type]

    def force(changed: Mapping[str, float]) -> NDArray[np.float64]:
        limit = np.array([changed.get(f"alpha_{n}", a) for n, a in enumerate(model.alpha)])
        limit = limit / limit.sum() * changed.get("F_s", model.static.F_s)
        stiffness = np.array([changed.get(f"k_{n}", one) for n, one in enumerate(model.k)])
        return np.asarray(np.minimum(stiffness * z[:, np.newaxis], limit).sum(axis=1))

    return Band(z, *_in_quadrature(force, single))


def _in_quadrature(
    force: Callable[[Mapping[str, float]], NDArray[np.float64]], parameters: Mapping[str, Estimate]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
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


def model_loops(model: GMS) -> tuple[Loop, ...]:
    """Return slow loops of a GMS model: small ones inside its pre-sliding, and one that slides at its ends."""
    reach = float(model.slip_displacements.max())
    loops = []
    for share in (0.25, 0.5, 1.5):
        time = np.linspace(0.0, 2.25, 3 * LOOP_POINTS)
        position = share * reach * np.sin(2 * np.pi * time)
        # so slow that the level is F_s throughout
        force = model.replay(time * 1e6, position, np.gradient(position, time * 1e6))
        last = time >= 1.25
        loops.append(Loop(f"amplitude {share:g} times the pre-sliding", position[last][::3], None, force[last][::3]))
    return tuple(loops)


def _measured(waves: Sequence[Log], plant: Plant | None, model: GMS) -> tuple[tuple[Loop, ...], VirginCurve | None]:
    """Return the loops that were measured with the model replayed along them, and the virgin curve in them."""
    found: list[Loops] = []
    loops = []
    for log in waves:
        one = find_loops(prepared([log], plant)[0])
        motion, force = one.motion, one.force
        found.append(one)
        replayed = model.replay(log.time, motion.position, motion.velocity)
        start = int(one.turns[0])  # the state before the first reversal is not known
        every = max(1, (len(force) - start) // LOOP_POINTS)
        part = slice(start, None, every)
        middle = 0.5 * float(motion.position.max() + motion.position.min())
        loops.append(Loop(log.name, motion.position[part] - middle, force[part], replayed[part]))
    return tuple(loops), (virgin_curve(found, model.static) if found else None)


def presliding(material: Material) -> float | None:
    """Return the largest slip displacement of the GMS models that were given [m]; None where there is none."""
    reaches = []
    for item in material.items:
        sections = item.sections() if item.kind == "friction" else {}
        if "gms" in sections and "static" in sections and item.motion == "linear":
            reaches.append(float(GMS.from_sections(sections).slip_displacements.max()))
    return max(reaches, default=None)
