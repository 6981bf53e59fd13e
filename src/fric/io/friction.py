"""Between identified friction and the friction file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction.stribeck import StaticMap
from fric.identify.loops.gms_fit import GMSFit
from fric.identify.strokes.map_fit import MapFit
from fric.identify.strokes.static import StaticFit
from fric.io.documents.friction import FrictionDocument
from fric.io.of_axis import read_of_axis
from fric.io.provenance import provenance
from fric.io.yaml import plain, read_tree
from fric.log import Log
from fric.units import Motion, si_unit


def static_tree(fit: StaticFit, logs: Sequence[Log]) -> dict[str, Any]:
    """Return the friction document of an identified static map, ready to be written or printed."""
    force = si_unit("force", fit.motion)
    tree: dict[str, Any] = {"fric": FrictionDocument.type_name(), "axis": fit.axis, "motion": fit.motion}
    quality: dict[str, Any] = {"points": len(fit.points), "method": fit.method}
    if fit.static is not None:
        tree["static"] = _section(fit.static)
        quality |= _quality(fit.static, force)
    if fit.negative is not None:
        tree["static_negative"] = _section(fit.negative)
        quality["negative"] = _quality(fit.negative, force)
    if fit.at_speed:
        tree["at_speed"] = {name: estimate.as_dict() for name, estimate in fit.at_speed.items()}
    return tree | {"fit": quality, "warnings": list(fit.warnings), "provenance": provenance(logs)}


def _section(fit: MapFit) -> dict[str, Any]:
    return {name: estimate.as_dict() for name, estimate in fit.estimates.items()}


def _quality(fit: MapFit, unit: str) -> dict[str, Any]:
    return {
        "rmse": Estimate(fit.rmse, unit).as_dict(),
        "r2": fit.r2,
        "between_strokes": Estimate(fit.between, unit).as_dict(),
        "left_out": len(fit.left_out),
    }


@dataclass(frozen=True)
class GivenStatic:
    """A static map from a friction file, and what of the file is carried over.

    Parameters
    ----------
    static
        The map; the mean of the two directions where each has its own.
    carried
        The sections of the file as they stand in it.
    """

    static: StaticMap
    carried: dict[str, Any]


def read_friction(path: Path, *, axis: str, motion: Motion) -> FrictionDocument:
    """Read the friction file of one axis.

    Raises
    ------
    FricError
        When it is no friction file, or of another axis or motion.
    """
    return read_of_axis(path, FrictionDocument, axis=axis, motion=motion)


def read_static(path: Path, *, axis: str, motion: Motion) -> GivenStatic:
    """Read the static map of one axis from a friction file.

    Raises
    ------
    FricError
        When the file is no friction file, is of another axis, or holds no static map.
    """
    document = read_friction(path, axis=axis, motion=motion)
    names = [name for name in ("static", "static_negative") if getattr(document, name)]
    if not names:
        raise FricError(
            "holds no static map", where=str(path), mend="Make one with `fric identify static`, or leave --static out."
        )
    sections = [document.estimates(name) for name in names]
    values = {
        p.name: sum(float(section[p.name]) for section in sections) / len(sections)
        for p in StaticMap.parameters
        if p.name in sections[0]
    }
    try:
        static = StaticMap(**values)
    except (FricError, TypeError) as error:
        raise FricError(f"static: {error}", where=str(path)) from None
    tree = plain(read_tree(Path(path)))
    kept = ("static", "static_negative", "fit", "provenance") + (() if "gms" in tree else ("warnings",))
    return GivenStatic(static, {name: tree[name] for name in kept if name in tree})


def gms_tree(fit: GMSFit, logs: Sequence[Log], given: GivenStatic | None = None) -> dict[str, Any]:
    """Return the friction document of an identified GMS model, the static map carried over."""
    force = si_unit("force", fit.motion)
    carried = dict(given.carried) if given else {"static": _plateau(fit)}
    before = carried.pop("provenance", None)
    warnings = [*carried.pop("warnings", []), *fit.warnings]
    records = []
    for record in fit.records:
        entry: dict[str, Any] = {
            "record": record.name,
            "kind": record.kind,
            "rmse": Estimate(record.rmse, force).as_dict(),
        }
        if record.rmse_held_out is not None:
            entry["rmse_held_out"] = Estimate(record.rmse_held_out, force).as_dict()
        share = next((one for one in fit.shares if one.name == record.name), None)
        if share is not None and share.inertia is not None:
            entry |= {"inertia_share": share.inertia, "damping_share": share.damping}
        records.append(entry)
    quality: dict[str, Any] = {
        "rmse": Estimate(fit.rmse, force).as_dict(),
        "alpha_sum": fit.alpha_sum.as_dict(),
        "virgin_curve_rmse": Estimate(fit.curve_rmse, force).as_dict(),
        "blocks": fit.reason,
        "method": fit.method,
        "records": records,
    }
    tree: dict[str, Any] = {"fric": FrictionDocument.type_name(), "axis": fit.axis, "motion": fit.motion} | carried
    tree["gms"] = {"alpha": fit.alpha.as_dict(), "k": fit.k.as_dict(), "C": fit.C.as_dict()}
    made = provenance(logs) | ({"static": before} if before else {})
    return tree | {"gms_fit": quality, "warnings": warnings, "provenance": made}


def _plateau(fit: GMSFit) -> dict[str, Any]:
    """Return the static map that stands in where none was given: F_c = F_s, and nothing viscous."""
    units = {p.name: si_unit(p.dimension, fit.motion) for p in StaticMap.parameters}
    limits = fit.alpha_sum.ci95
    level = fit.static.F_s
    interval = None if limits is None else (float(limits[0]) * level, float(limits[1]) * level)  # type: ignore[arg-type]
    section = {
        "F_c": Estimate(level, units["F_c"], interval, assumed=True),
        "F_s": Estimate(level, units["F_s"], interval),
        "v_s": Estimate(fit.static.v_s, units["v_s"], assumed=True),
        "delta": Estimate(fit.static.delta, units["delta"], assumed=True),
        "sigma": Estimate(fit.static.sigma, units["sigma"], assumed=True),
    }
    return {name: estimate.as_dict() for name, estimate in section.items()}
