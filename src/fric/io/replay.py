"""Between models fitted by replay and the friction file."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction import models
from fric.identify.replay.replay_fit import ReplayFit
from fric.io.documents.friction import FrictionDocument
from fric.io.provenance import provenance
from fric.units import Motion, parse, si_unit


def parse_parameters(model: str, given: Iterable[str], motion: Motion) -> dict[str, float]:
    """Return parameters given as ``NAME=VALUE``, in SI.

    Raises
    ------
    FricError
        When there is no such parameter, or the unit does not fit.
    """
    declared = {p.name: p for parameters in models()[model].declared().values() for p in parameters}
    found = {}
    for text in given:
        name, _, value = text.partition("=")
        if name not in declared:
            raise FricError(f"{model} has no parameter '{name}'", mend=f"It has {', '.join(declared)}.")
        found[name] = parse(value, declared[name].dimension, motion)
    return found


def replay_tree(fit: ReplayFit, kept: FrictionDocument | None = None) -> dict[str, Any]:
    """Return the friction document of a model fitted by replay, ready to be written or printed.

    Parameters
    ----------
    fit
        The fit.
    kept
        The file that its static map is from: its sections stay.
    """
    tree: dict[str, Any] = {"fric": FrictionDocument.type_name(), "axis": fit.axis, "motion": fit.motion}
    if kept is not None:
        given = kept.model_dump(exclude={"fric", "axis", "motion", "warnings", "provenance"}, exclude_defaults=True)
        tree |= given
    name = fit.model.name
    for section, estimates in fit.estimates.items():
        if section == name or kept is None:
            tree[section] = {key: estimate.as_dict() for key, estimate in estimates.items()}
    force, mass = si_unit("force", fit.motion), si_unit("mass", fit.motion)
    records = []
    for record, own in zip(fit.records, fit.own, strict=True):
        told: dict[str, Any] = {"record": record.log.name, "offset": Estimate(own[0], force).as_dict()}
        if len(own) > 1:
            told["mass"] = Estimate(own[1], mass).as_dict()
        records.append(told)
    tree[f"{name}_fit"] = {
        "rmse": Estimate(fit.rmse, force).as_dict(),
        "r2": fit.r2,
        "samples": sum(int(record.used.sum()) for record in fit.records),
        "method": "replay along the measured motion; CRS2, then least squares; intervals by Newey and West",
        "records": records,
    }
    logs = [record.log for record in fit.records]
    return tree | {"warnings": list(fit.warnings), "provenance": provenance(logs)}
