"""What a validation reads and tells: the friction of a plant or friction file, and the scores as a document."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fric.drive.cascade import Cascade
from fric.errors import FricError
from fric.friction import FrictionModel
from fric.friction.stribeck import StaticMap
from fric.io.documents.base import Quantity
from fric.io.documents.controller import ControllerDocument
from fric.io.documents.friction import FrictionDocument
from fric.io.documents.plant import PlantDocument
from fric.io.of_axis import read_of_axis
from fric.io.provenance import provenance
from fric.io.yaml import read_document
from fric.log import Log
from fric.simulate.validation import Validation
from fric.units import Motion, si_unit


def read_cascade(path: Path, *, axis: str, motion: Motion) -> Cascade:
    """Read the controller of one axis.

    Raises
    ------
    FricError
        When the file is no controller, or of another axis or motion.
    """
    document = read_of_axis(path, ControllerDocument, axis=axis, motion=motion)
    try:
        return document.cascade(motion)
    except FricError as error:
        raise error.at(str(path)) from None


def coulomb_of_plant(path: Path, *, motion: Motion) -> tuple[FrictionModel, float]:
    """Return the Coulomb friction and the load [N] that `fric identify plant` found beside the plant in a motion.

    Its viscous friction is in A, hence there is none here. Where F_c was found for each direction, their mean is taken.

    Raises
    ------
    FricError
        When the plant was not identified from a motion.
    """
    found = read_document(path, PlantDocument).fit.get("parameters", {})
    values = {name: float(Quantity.model_validate(_plain(entry)).si("force", motion)) for name, entry in found.items()
              if name.startswith(("F_c", "offset"))}  # fmt: skip
    levels = [value for name, value in values.items() if name.startswith("F_c")]
    if not levels:
        raise FricError(
            "holds no Coulomb friction", where=str(path),
            mend="Give a friction file with --friction, or identify the plant from an ordinary motion.",
        )  # fmt: skip
    level = sum(levels) / len(levels)
    load = values.get("offset", 0.0)
    if "F_c_positive" in values:
        load = 0.5 * (values["F_c_positive"] - values["F_c_negative"])
    return StaticMap(F_c=level, F_s=level, v_s=1e-3), load


def _plain(entry: dict[str, Any]) -> dict[str, Any]:
    return {"value": entry["value"], "unit": entry["unit"]}


def friction_and_load(
    path: Path, model: str | None, record: str, *, axis: str, motion: Motion
) -> tuple[FrictionModel, float]:
    """Return a model of a friction file, and the offset [N] that it was identified with.

    That of the record itself, where the model was fitted to it by replay; else that of the static map.

    Raises
    ------
    FricError
        When the file holds several models and none is named, or does not hold the one named.
    """
    document = read_of_axis(path, FrictionDocument, axis=axis, motion=motion)
    extra = document.model_extra or {}
    found = [name for name in extra if not name.endswith("_fit") and name != "provenance"]
    if model is None:
        model = found[0] if len(found) == 1 else "static" if not found else None
    if model is None:
        raise FricError(f"holds {', '.join(found)}", where=str(path), mend="Name one with --model.")
    friction = document.friction(model)
    fits = extra.get(f"{model}_fit", {}).get("records", [])
    own = next((entry["offset"] for entry in fits if entry.get("record") == record), None)
    if own is not None:
        return friction, float(Quantity.model_validate(own).si("force", motion))
    static = document.estimates("static") if document.static else {}
    return friction, float(static["offset"]) if "offset" in static else 0.0


def validation_tree(validations: Sequence[Validation], logs: Sequence[Log]) -> dict[str, Any]:
    """Return the scores of validations, ready to be printed."""
    records = []
    for validation in validations:
        log = validation.log
        first, stop = validation.worst
        signals = {
            name: {
                "relative": compared.relative,
                "rms": compared.rms,
                "unit": si_unit(name, log.motion),
            }
            for name, compared in validation.signals.items()
        }
        records.append(
            {
                "record": log.name,
                "loop": validation.loop,
                "friction": validation.friction.name,
                "signals": signals,
                "filter": {"value": validation.cutoff, "unit": "Hz"},
                "worst_second": [float(log.time[first]), float(log.time[stop - 1])],
            }
        )
    return {"validations": records, "provenance": provenance(logs)}
