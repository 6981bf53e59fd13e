"""The friction file: ``fric: friction/1``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

from pydantic import ConfigDict, Field, model_validator

from fric.documents.base import OfAxis, Quantity, quantities
from fric.documents.of_axis import read_of_axis
from fric.documents.provenance import provenance
from fric.documents.yaml import plain, read_tree
from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction import FrictionModel, models
from fric.friction.stribeck import StaticMap
from fric.log import Log
from fric.units import Motion, parse, si_unit

if TYPE_CHECKING:
    from fric.identify.loops.gms_fit import GMSFit
    from fric.identify.replay.replay_fit import ReplayFit
    from fric.identify.strokes.map_fit import MapFit
    from fric.identify.strokes.static import StaticFit


class FrictionDocument(OfAxis):
    """A friction file: the static map, and any other model under its own name."""

    model_config = ConfigDict(extra="allow", frozen=True)
    type: ClassVar[str] = "friction"

    static: dict[str, Quantity] | None = Field(None, description="F_c, F_s, v_s, delta, sigma, offset of eq. (2)")
    static_negative: dict[str, Quantity] | None = Field(None, description="the negative direction's own values")
    at_speed: dict[str, Quantity] | None = Field(
        None, description="velocity and force where one speed alone was logged"
    )
    fit: dict[str, Any] = Field(default_factory=dict, description="how well the static map fits")

    @model_validator(mode="after")
    def _models_are_known(self) -> Self:
        for name in self.model_extra or {}:
            if name not in models() and name.removesuffix("_fit") not in models():
                raise ValueError(f"'{name}' is not a friction model\nKnown are {', '.join(models())}.")
        self.estimates("static") if self.static else None
        return self

    def estimates(self, section: str) -> dict[str, Estimate]:
        """Return the parameters of one section (``static``, ``gms``, …) in SI."""
        name = section.removesuffix("_negative")
        given = getattr(self, section, None) or (self.model_extra or {}).get(section)
        if not given:
            raise FricError(f"there is no '{section}' in the friction of axis {self.axis}")
        dimensions = {p.name: p.dimension for p in models()[name].parameters}
        if name == "static":
            dimensions["offset"] = "force"
        raw = {key: value.model_dump() if isinstance(value, Quantity) else value for key, value in given.items()}
        return quantities(raw, dimensions, self.motion, section)

    def fit_of(self, model: str) -> dict[str, Any]:
        """Return how well a model fitted, as its identification told it; empty where it was not identified."""
        return self.fit if model == "static" else dict((self.model_extra or {}).get(f"{model}_fit", {}))

    def sections(self) -> list[str]:
        """Return the names of the sections that hold parameters: the static map's, and those of other models."""
        given = {key for key in ("static", "static_negative") if getattr(self, key)}
        return sorted(given | set(self.model_extra or {}) & set(models()))

    def friction(self, name: str) -> FrictionModel:
        """Return one friction model of this file (``static``, ``gms``, …) with the parameters given here."""
        sections = {key: self.estimates(key) for key in self.sections()}
        return models()[name].from_sections(sections)


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
