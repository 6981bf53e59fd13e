"""The manifest beside exported files, for programs: their content, their inputs, and warnings."""

import hashlib
import json
from collections.abc import Iterable, Mapping
from typing import Any

import fric
from fric.documents.base import warned
from fric.errors import clean
from fric.export.base import Files, Part
from fric.friction import FrictionModel
from fric.friction.directed import Directed
from fric.notice import Notice
from fric.units import Motion, rotates, si_unit


def manifest(
    target: str, part: Part, files: Files, *, notices: Iterable[Notice], sources: Iterable[Mapping[str, str]]
) -> dict[str, Any]:
    """Return the content of manifest.json: SI values with their units, a digest of each file and of each source."""
    unit = "rad" if rotates(part.motion) else "m"
    values = {
        "sampling": (part.sampling, "Hz"), "limit": (part.limit, "V"), "lead": (part.lead, "s"),
        "gain": (part.gain, "1"), "K_f": (part.K_f, si_unit("force per input", part.motion)), "A": (part.A, "1/s"),
        "B": (part.B, f"{unit}/(s^2*V)"), "resolution": (part.resolution, unit),
    }  # fmt: skip
    if part.role == "machine":
        values |= {
            "delay": (part.delay, "s"),
            "load": (part.load, si_unit("force", part.motion)),
            "velocity_filter": (part.velocity_filter, "Hz"),
        }
    digests = {
        name: hashlib.sha256(content.encode() if isinstance(content, str) else content).hexdigest()
        for name, content in files.items()
    }
    return {
        "fric": "export/1",
        "version": fric.__version__,
        "target": target,
        "part": part.role,
        "machine": part.machine,
        "axis": part.axis,
        "motion": part.motion,
        "scheme": part.scheme,
        "parameters": {name: _quantity(value, unit) for name, (value, unit) in values.items()},
        "friction": friction_values(part.model, part.motion),
        "blocks": [{"name": b.title, "kind": b.kind, "parameters": b.parameters.tolist()} for b in part.blocks],
        "files": digests,
        "sources": list(sources),
        **warned(notices),
    }


def manifest_text(content: Mapping[str, Any]) -> str:
    """Return a manifest as JSON."""
    return clean(json.dumps(content, ensure_ascii=False, indent=2, allow_nan=False)) + "\n"


def friction_values(model: FrictionModel, motion: Motion) -> dict[str, Any]:
    """Return the parameters of a model by section and name, each with its unit."""
    if isinstance(model, Directed):
        backwards = friction_values(model.negative, motion)["static"]
        return friction_values(model.model, motion) | {"static_negative": backwards}
    found: dict[str, Any] = {"model": model.name}
    parts = {name: value for name, value in vars(model).items() if isinstance(value, FrictionModel)}
    holders: dict[str, Any] = {model.name: model} | parts
    for section, parameters in type(model).declared().items():
        holder = holders.get(section, model)
        found[section] = {p.name: _quantity(getattr(holder, p.name), si_unit(p.dimension, motion)) for p in parameters}
    return found


def _quantity(value: Any, unit: str) -> dict[str, Any]:
    if isinstance(value, tuple):
        return {"value": list(value), "unit": unit}
    return {"value": None if value == float("inf") else value, "unit": unit}
