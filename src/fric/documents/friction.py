"""The friction file: ``fric: friction/1``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal, Self

from pydantic import model_validator

from fric.documents.base import CovarianceBlock, FilePart, OfAxis, Part, Quantity, nested, quantities
from fric.documents.fields import known, refused, said
from fric.documents.plant import PlantPart, plant_part
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import Covariance, Estimate
from fric.friction import FrictionModel, model_type, models
from fric.friction.directed import directed
from fric.friction.stribeck import StaticMap
from fric.log import Log, Record
from fric.notice import Notice
from fric.plausibility import Finding, settled
from fric.records.preparation import Preparation
from fric.units import Motion, si_unit

if TYPE_CHECKING:
    from fric.identify.gms.identify import GMSFit
    from fric.identify.replay.replay_fit import ReplayFit
    from fric.identify.static_map.identify import StaticFit
    from fric.identify.static_map.map_fit import MapFit

SCATTER = {"level": "ratio", "offset": "force", "mass": "mass"}


class PreparedPart(FilePart[Preparation]):
    """Preparation of a record for the replay of a model."""

    own: list[str] = said("terms of the record that are fitted beside the model", list)


class FitRecord(Part):
    """A record that a model was fitted to."""

    record: str
    kind: str | None = None
    rmse: Quantity | None = said("measured less replayed force")
    energy: Quantity | None = said("energy lost per cycle")
    rmse_held_out: Quantity | None = said("the same over held-out cycles")
    inertia_share: float | None = said("size of the inertia relative to the logged force")
    damping_share: float | None = said("size of the drive's damping relative to the logged force")
    prepared: PreparedPart | None = None
    offset: Quantity | None = said("constant force of this record alone")
    damping: Quantity | None = said("force over velocity that was fitted beside the friction")
    mass: Quantity | None = said("mass that was fitted beside the friction")


class Fit(Part):
    """Quality of a fit, its records, and their preparation."""

    method: str = ""
    plant: PlantPart | None = said("the plant whose part was subtracted from the logged force")
    taken_off: list[Literal["damping", "inertia"]] | None = said(
        "parts of the plant subtracted from the logged force; may be empty"
    )
    rmse: Quantity | None = None
    r2: float | None = said("share of the force's variance that is explained")
    points: int | None = said("strokes")
    samples: int | None = None
    between_strokes: Quantity | None = said("scatter of strokes beyond their own noise")
    between_records: dict[Literal["level", "offset", "mass"], Quantity] | None = said(
        "standard deviation of the level, the offset and the mass from record to record"
    )
    over_position: Quantity | None = said("standard deviation of friction over position")
    left_out: int | None = said("number of strokes that deviate from all others, and weigh less")
    negative: Fit | None = said("the same of the negative direction's own map")
    alpha_sum: Quantity | None = said("sum of alpha before it was normalised")
    virgin_curve_rmse: Quantity | None = None
    blocks: str | None = said("reason for the number of slip blocks")
    records: list[FitRecord] | None = None
    covariance: CovarianceBlock | None = said("covariance of the parameters")

    @model_validator(mode="before")
    @classmethod
    def _of_an_older_file(cls, given: Any) -> Any:
        """Convert the words of files before `taken_off` into data."""
        if not isinstance(given, Mapping) or "taken_off" in given:
            return given
        records = given.get("records")
        held = records if isinstance(records, list) else ()
        ready = [record.get("prepared", record) for record in held if isinstance(record, Mapping)]
        if any(isinstance(item, Mapping) and "inertia_share" in item for item in ready):
            return {**given, "taken_off": ["inertia", "damping"]}
        if "drive damping taken off" in str(given.get("method", "")):
            return {**given, "taken_off": ["damping"]}
        return given


class FrictionDocument(OfAxis, type="friction", extra="allow"):
    """A friction file: the static map, and any other model under its name, each with its fit."""

    static: dict[str, Quantity] | None = said("F_c, F_s, v_s, delta, sigma, offset of eq. (2)")
    static_negative: dict[str, Quantity] | None = said("the negative direction's own values")
    at_speed: dict[str, Quantity] | None = said("velocity and force if only one speed was logged")
    fit: Fit | None = said("how well the static map fits")

    @model_validator(mode="before")
    @classmethod
    def _models_are_known(cls, given: Any) -> Any:
        """Check the sections of models, and the data of their fits, against the known models."""
        if not isinstance(given, Mapping):
            return given
        typed = dict(given)
        for name in given.keys() - cls.model_fields.keys():
            if model_type(name.removesuffix("_fit")) is None:
                raise ValueError(f"'{name}' is not a friction model\nKnown are {', '.join(models())}.")
            typed[name] = nested(Fit if name.endswith("_fit") else dict[str, Quantity], given[name], name)
        return typed

    @model_validator(mode="after")
    def _parameters_fit(self) -> Self:
        for name in self.sections():
            self.estimates(name)
            fit, where = self.fit_of(name), f"{name}: between_records"
            found = quantities(fit.between_records or {}, SCATTER, self.motion, where)
            if fit.plant is not None:
                fit.plant.values(self.motion)
            with refused(where):
                settled(Finding(f"scatter-{of}", float(size), self.motion) for of, size in found.items())
        for name in ("static", *self.model_names()) if self.static else ():  # without a map they are parts
            with refused(name):
                self.friction(name)
        return self

    @classmethod
    def json_schema(cls) -> dict[str, Any]:
        """Return the JSON Schema, with a section for each friction model that there is."""
        schema = super().json_schema()
        for name, model in models().items():
            if name == "static":
                continue
            units = {p.name: f"{p.doc} [{si_unit(p.dimension, 'linear')}]" for p in model.parameters}
            schema["properties"] |= {
                name: {
                    "type": "object", "description": str(model.__doc__).partition("\n")[0],
                    "properties": {p: {"$ref": "#/$defs/Quantity", "description": text} for p, text in units.items()},
                    "additionalProperties": False,
                },
                f"{name}_fit": {"$ref": "#/$defs/Fit", "description": f"how well {name} fits"},
            }  # fmt: skip
        return schema | {"additionalProperties": False}

    def section(self, name: str) -> dict[str, Quantity]:
        """Return the parameters of a section (``static``, ``gms``, …) as in the file; empty without it."""
        return getattr(self, name, None) or {}

    def estimates(self, section: str) -> dict[str, Estimate]:
        """Return the parameters of one section (``static``, ``gms``, …) in SI."""
        if not (given := self.section(section)):
            hint = f"Identify it, or take one of {', '.join(self.sections())}."
            raise FricError(f"there is no '{section}' in the friction of axis {self.axis}", hint=hint)
        if section == "at_speed":
            return quantities(given, {"velocity": "velocity", "force": "force"}, self.motion, section)
        name = section.removesuffix("_negative")
        dimensions = {p.name: p.dimension for p in model.parameters} if (model := model_type(name)) else {}
        if name == "static":
            dimensions["offset"] = "force"
        return quantities(given, dimensions, self.motion, section)

    def fit_of(self, section: str) -> Fit:
        """Return the data of the fit of a section; nothing where it was not identified."""
        if section == "static_negative" and self.fit is not None and self.fit.negative is not None:
            return self.fit.negative
        of_map = section in {"static", "static_negative", "at_speed"} and not hasattr(self, f"{section}_fit")
        return getattr(self, "fit" if of_map else f"{section}_fit", None) or Fit.model_validate({})

    def covariances(self) -> Iterator[Covariance]:
        """Yield the covariance of the parameters of each section, with the names by which they are drawn."""
        for section in self.sections():
            block = self.fit_of(section).covariance if section != "at_speed" else None
            if block is not None:
                found = block.covariance()
                prefix = "negative." if section == "static_negative" else ""
                yield replace(found, names=tuple(prefix + name for name in found.names))

    def model_names(self) -> list[str]:
        """Return the models beside the static map, in the order of the file."""
        return [name for name in self.model_extra or {} if model_type(name)]

    def sections(self) -> list[str]:
        """Return the names of the sections that hold parameters: those of the static map, then of other models."""
        return [name for name in ("static", "static_negative", "at_speed") if getattr(self, name)] + self.model_names()

    def friction(self, name: str) -> FrictionModel:
        """Return a friction model of this file (``static``, …), with a map for each direction if it has them."""
        sections = {key: self.estimates(key) for key in self.sections()}
        if (model := model_type(name)) is None:
            raise FricError(f"there is no friction model '{name}'", hint=f"There are {', '.join(models())}.")
        return directed(model.from_sections(sections), self.backward())

    def maps(self) -> tuple[StaticMap, StaticMap | None]:
        """Return the static map, and that of the negative direction, where each direction has a map."""
        if not self.section("static"):
            hint = "Make one with `fric identify static`, or leave `static=` out."
            raise FricError(f"the friction of axis {self.axis} holds no static map", hint=hint)
        return StaticMap.from_sections({"static": self.estimates("static")}), self.backward()

    def found_with(self, model: str | None) -> tuple[FrictionModel, float]:
        """Return a model, by default the only one, and the load [N] of the axis that it was identified with.

        It is the mean offset of the records that the model was fitted to by replay; else that of the static map.
        """
        found = self.model_names()
        if model is None:
            model = found[0] if len(found) == 1 else "static" if not found else None
        if model is None:
            raise FricError(f"the friction file holds {', '.join(found)}", hint="Name one with `model=`.")
        records = self.fit_of(model).records or ()
        offsets = [float(r.offset.si("force", self.motion)) for r in records if r.offset is not None]
        return self.friction(model), sum(offsets) / len(offsets) if offsets else self.load()

    def load(self) -> float:
        """Return the constant force [N] identified with the static map; 0 without any."""
        static = self.estimates("static") if self.static else {}
        return float(static["offset"]) if "offset" in static else 0.0

    def backward(self) -> StaticMap | None:
        """Return the static map of the negative direction, where each direction has a map."""
        return StaticMap.from_sections({"static": self.estimates("static_negative")}) if self.static_negative else None


def static_tree(fit: StaticFit, logs: Sequence[Record]) -> dict[str, Any]:
    """Return the friction document of an identified static map, ready to be written or printed."""
    force = si_unit("force", fit.motion)
    content: dict[str, Any] = {"axis": fit.axis, "motion": fit.motion}
    text: dict[str, Any] = {"points": len(fit.points), "method": fit.method} | _used(fit.plant, fit.motion, "damping")
    if fit.static is not None:
        content["static"] = fit.static.estimates
        text |= _quality(fit.static, force)
        text |= known(between_records=fit.between_records or None, over_position=fit.over_position)
    if fit.negative is not None:
        content["static_negative"] = fit.negative.estimates
        text["negative"] = _quality(fit.negative, force)
    if fit.at_speed:
        content["at_speed"] = fit.at_speed
    return FrictionDocument.made(content | {"fit": text}, notices=fit.warnings, logs=logs).tree()


def _used(plant: Plant | None, motion: Motion, *taken: str) -> dict[str, Any]:
    """Return the data on the plant that a fit used."""
    return {"taken_off": []} if plant is None else {"plant": plant_part(plant, motion), "taken_off": taken}


def _quality(fit: MapFit, unit: str) -> dict[str, Any]:
    return {
        "rmse": Estimate(fit.rmse, unit), "r2": fit.r2, "between_strokes": Estimate(fit.between, unit),
        "left_out": len(fit.standing_off), "covariance": fit.covariance,
    }  # fmt: skip


def gms_tree(fit: GMSFit, logs: Sequence[Log], given: FrictionDocument | None = None) -> dict[str, Any]:
    """Return the friction document of an identified GMS model, the static map carried over."""
    force = si_unit("force", fit.motion)
    records = []
    for record in fit.records:
        held_out = None if record.rmse_held_out is None else Estimate(record.rmse_held_out, force)
        left = {"rmse": Estimate(record.rmse, force), "energy": record.energy, "rmse_held_out": held_out}
        ready = PreparedPart.of(record.record.done, fit.motion)
        records.append(known(record=record.name, kind=record.kind, **left, prepared=ready))
    text: dict[str, Any] = {"rmse": Estimate(fit.rmse, force), "alpha_sum": fit.alpha_sum}
    text |= {"virgin_curve_rmse": Estimate(fit.curve_rmse, force), "blocks": fit.reason, "method": fit.method}
    text |= {"records": records} | _used(fit.records[0].record.done.plant, fit.motion, "inertia", "damping")
    text |= known(covariance=fit.covariance, between_records=fit.between_records or None)
    static = given.content("static", "static_negative", "fit") if given else {"static": _plateau(fit)}
    content = {"axis": fit.axis, "motion": fit.motion} | static
    content |= {"gms": {"alpha": fit.alpha, "k": fit.k, "C": fit.C}, "gms_fit": text}
    return _built_upon(given, content, fit.warnings, logs)


def _built_upon(
    static: FrictionDocument | None, content: Mapping[str, Any], notices: Sequence[Notice], logs: Sequence[Log]
) -> dict[str, Any]:
    """Return the document of a model that builds upon a static map: it carries over the warnings of that file."""
    known = () if static is None or static.model_names() else static.notices()  # else they are not of the map alone
    before = [notice.at("", carried=True) for notice in known]
    also = {"static": static.provenance.model_dump()} if static is not None and static.provenance else {}
    return FrictionDocument.made(content, notices=[*before, *notices], logs=logs, also=also).tree()


def _plateau(fit: GMSFit) -> dict[str, Estimate]:
    """Return the default static map: F_c = F_s, without viscous friction."""
    units = {p.name: si_unit(p.dimension, fit.motion) for p in StaticMap.parameters}
    level, (low, high) = fit.static.F_s, fit.alpha_sum.limits
    interval = None if fit.alpha_sum.ci95 is None else (low * level, high * level)
    held = {name: getattr(fit.static, name) for name in ("v_s", "delta", "sigma")}
    F_c, F_s = Estimate(level, units["F_c"], interval, assumed=True), Estimate(level, units["F_s"], interval)
    return {"F_c": F_c, "F_s": F_s} | {name: Estimate(value, units[name], assumed=True) for name, value in held.items()}


def replay_tree(fit: ReplayFit, kept: FrictionDocument | None = None) -> dict[str, Any]:
    """Return the friction document of a model fitted by replay, ready to be written or printed.

    kept: The file that its static map is from: its sections stay.
    """
    name, force = fit.model.name, si_unit("force", fit.motion)
    content: dict[str, Any] = {"axis": fit.axis, "motion": fit.motion} | ({} if kept is None else kept.content())
    content |= {key: section for key, section in fit.estimates.items() if key == name or kept is None}
    samples = sum(int(record.used.sum()) for record in fit.records)
    method = "replay along the measured motion; CRS2, least squares; intervals by autoregressions, and cycles"
    records = [
        {"record": record.log.name, "prepared": PreparedPart.of(record.done, fit.motion), **values}
        for record, values in zip(fit.records, fit.own_estimates, strict=True)
    ]
    text = {"rmse": Estimate(fit.rmse, force), "r2": fit.r2, "samples": samples, "method": method, "records": records}
    text |= {"covariance": fit.covariance} | _used(fit.records[0].done.plant, fit.motion, "inertia", "damping")
    content[f"{name}_fit"] = text | known(between_records=fit.between_records or None)
    return _built_upon(kept, content, fit.warnings, [record.log for record in fit.records])
