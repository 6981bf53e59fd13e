"""Between identified friction and the friction file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fric.estimate import Estimate
from fric.identify.map_fit import MapFit
from fric.identify.static import StaticFit
from fric.io.documents.friction import FrictionDocument
from fric.io.provenance import provenance
from fric.log import Log
from fric.units import si_unit


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
    }
