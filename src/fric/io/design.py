"""Between a design and its controller or observer file."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, log10
from typing import Any

from fric.design.cascade import CascadeDesign
from fric.design.observer import ObserverDesign
from fric.errors import FricError
from fric.io.documents.controller import ControllerDocument, ControllerPart
from fric.io.documents.observer import ObserverDocument
from fric.io.provenance import provenance
from fric.log import FrequencyResponse, Log
from fric.units import Motion, si_unit


def refuse_other_axis(what: str, of: tuple[str, Motion], wanted: tuple[str, Motion], where: str) -> None:
    """Raise when a file is of another axis, (name, motion), than the plant that is designed for."""
    if of != wanted:
        raise FricError(
            f"is the {what} of the {of[1]} axis {of[0]}, and the plant is of the {wanted[1]} axis {wanted[0]}",
            where=where,
            mend=f"Give the {what} of the axis that is designed for.",
        )


def controller_tree(design: CascadeDesign, axis: str, motion: Motion) -> dict[str, Any]:
    """Return a cascade with its margins as a controller document."""
    values = {name: getattr(design.cascade, name) for name in ControllerPart.dimensions}
    return {
        "fric": ControllerDocument.type_name(),
        "axis": axis,
        "motion": motion,
        **{
            name: {"value": value, "unit": si_unit(ControllerPart.dimensions[name], motion)}
            for name, value in values.items()
            if isfinite(value)
        },
        "margins": {name: loop.margins.as_dict() for name, loop in design.loops().items()},
        "warnings": [],
        "provenance": provenance(),
    }


def observer_tree(
    design: ObserverDesign, axis: str, motion: Motion, logs: Sequence[Log | FrequencyResponse] = ()
) -> dict[str, Any]:
    """Return an observer with its limits and margins as an observer document."""
    observer = design.observer
    limits: dict[str, Any] = {"robust": {}, "sensitive": {"peak_sensitivity": _decibel(design.peak_sensitivity)}}
    for name, q in (("robust", design.robust.q), ("sensitive", design.sensitive)):
        if q is not None:
            limits[name] |= {"cutoff": _hertz(q.cutoff), "bandwidth": _hertz(q.bandwidth)}
    if design.robust.q is not None:
        limits["robust"] |= {
            "frequency": _hertz(design.robust.frequency), "Delta": {"value": design.robust.size, "unit": "1"}
        }  # fmt: skip
    return {
        "fric": ObserverDocument.type_name(),
        "axis": axis,
        "motion": motion,
        "filter": observer.q.name,
        "cutoff": _hertz(observer.q.cutoff),
        "bandwidth": _hertz(observer.q.bandwidth),
        "A": {"value": observer.A, "unit": si_unit("rate", motion)},
        "B": {"value": observer.B, "unit": si_unit("acceleration per input", motion)},
        "reason": design.reason,
        "limits": limits,
        "margins": {name: loop.margins.as_dict() for name, loop in design.loops().items()},
        "warnings": list(design.warnings),
        "provenance": provenance(logs),
    }


def _hertz(value: float) -> dict[str, Any]:
    return {"value": value, "unit": "Hz"}


def _decibel(ratio: float) -> dict[str, Any]:
    return {"value": 20 * log10(ratio), "unit": "dB"}
