"""The machine file, ``fric: machine/1``, spreads, and the uncertainty of what was identified of a machine."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf, pi
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, ValidationInfo, model_validator

from fric.control import block_type
from fric.documents.base import AxisDocument, Document, FilePart, Part, Physical, Quantity, filed, in_units
from fric.documents.controller import (
    BlockDocument,
    ControllerDocument,
    ControllerPart,
    ObserverDocument,
    ObserverPart,
    block_values,
)
from fric.documents.fields import AxisName, known, refused, said
from fric.documents.friction import FrictionDocument
from fric.documents.plant import PlantDocument, PlantPart, plant_part
from fric.documents.schemes import LeadGiven, lead_of
from fric.documents.yaml import read_document, read_tree, write_document
from fric.drive.plant import Plant, hold_delay
from fric.drive.sensing import Encoder
from fric.errors import FricError, found_in, require_known
from fric.estimate import Covariance, Estimate
from fric.flaws import flaw_of
from fric.flaws.files import GAINS_DESIGNED
from fric.flaws.prediction import INTERVAL_OPEN, NOT_DRAWN, PREDICTION_WIDENED, PRESLIDING_UNKNOWN
from fric.friction import FrictionModel, model_type
from fric.friction.directed import Directed
from fric.friction.stribeck import StaticMap
from fric.notice import Notice, once
from fric.plausibility import Finding, of_friction, of_plant, settled
from fric.records.preparation import WINDOWS
from fric.simulate.machine import Axis, Machine, NominalFriction, Published
from fric.simulate.reality.flaws import NONE, Reality, SecondMass
from fric.simulate.spread import Distribution, Intervals, Spread, check_spreads, closed_intervals, friction_intervals
from fric.statistics import reach
from fric.units import Motion, parse
from fric.verb import Kind, verb


def _from_file(document: type[Document], inline: type[Part] | None = None) -> BeforeValidator:
    """Return a validator that reads what is given as the name of a file, relative to the machine's.

    ``inline`` is the alternative to the name, by default the document without its head.
    """

    def read(given: Any, info: ValidationInfo) -> Any:
        return read_document((info.context or {})["folder"] / given, document) if isinstance(given, str) else given

    return BeforeValidator(read, json_schema_input_type=str | (inline or document | dict[str, Any]))


class EncoderPart(Physical):
    """An encoder: its resolution."""

    resolution: Annotated[Quantity, "position"] = Field(description="one step; 0 for a position that is not quantised")


class NoisePart(Physical):
    """Noise of the logged channels."""

    force: Annotated[Quantity, "force"] = Field(description="root mean square of the force channel's noise")


class FeedforwardPart(Physical):
    """The friction that the controller believes."""

    gain: Annotated[Quantity | None, "ratio"] = said("share of the nominal friction that is fed forward; 1 if left out")
    lead: LeadGiven = said(
        "lead of the feedforward of friction and inverse model, as '0.6 ms'; auto for the delay T_d of "
        "the nominal plant; none if left out"
    )
    friction: Annotated[FrictionDocument | None, _from_file(FrictionDocument)] = said(
        "a friction file, or its sections; the machine's own friction where left out"
    )


class AxisPart(Part):
    """One axis: each part given here, or as the name of a file beside this one."""

    motion: Motion = "linear"
    plant: Annotated[PlantPart, _from_file(PlantDocument, PlantPart)]
    nominal: Annotated[PlantPart | None, _from_file(PlantDocument, PlantPart)] = said(
        "the nominal plant, as identified; the true one where left out"
    )
    controller: Annotated[ControllerPart, _from_file(ControllerDocument, ControllerPart)]
    observer: Annotated[ObserverPart | None, _from_file(ObserverDocument, ObserverPart)] = None
    encoder: EncoderPart | None = said("not quantised where left out")
    noise: NoisePart | None = said("none where left out")
    friction: Annotated[FrictionDocument, _from_file(FrictionDocument)] = Field(
        description="the friction that the axis has: a friction file, or its sections"
    )
    feedforward: FeedforwardPart = Field(default_factory=FeedforwardPart)
    blocks: dict[str, Annotated[BlockDocument | dict[str, Quantity], _from_file(BlockDocument)]] = said(
        "parameters of further control blocks by name, or a block file each; by default as the block is "
        "designed for the axis",
        dict,
    )
    second_mass: FilePart[SecondMass] | None = said("one rigid mass where left out")
    reality: FilePart[Reality] | None = said("flaws of logs and guideway; none where left out")

    def parts(self) -> dict[str, Any]:
        """Return its parts by key, including the feedforward."""
        return dict(self) | {f"feedforward.{key}": part for key, part in self.feedforward}


class PublishedPart(Physical):
    """Glitches that were published for this machine."""

    radius: Annotated[Quantity, "position"]
    velocity: Annotated[Quantity, "velocity"]
    glitch: dict[str, Quantity] = Field(description="glitch by scheme")
    source: str = ""

    @model_validator(mode="after")
    def _units_fit(self) -> Self:
        self.published()
        return self

    def published(self) -> Published:
        """Return what was published, in SI."""
        values = self.values("linear")
        glitches = {name: float(given.si("position", "linear")) for name, given in self.glitch.items()}
        return Published(values["radius"], values["velocity"], glitches)


class MachineDocument(Document, type="machine"):
    """A machine file: axes with plant, controller, observer, encoder, true and nominal friction."""

    name: str = ""
    like: str = said("a machine file with the same axes, apart from the keys given here", "")
    axes: dict[AxisName, AxisPart]
    published: list[PublishedPart] = said("glitches to compare with", list)

    @model_validator(mode="before")
    @classmethod
    def _friction_is_of_its_axis(cls, given: Any) -> Any:
        """Fill in the head of friction within the machine file."""
        if not isinstance(given, dict) or not isinstance(given.get("axes"), dict):
            return given

        def headed(part: Any, head: dict[str, str]) -> Any:
            friction = part.get("friction") if isinstance(part, dict) else None
            return {**part, "friction": head | friction} if isinstance(friction, dict) else part

        axes = dict(given["axes"])
        for name, axis in axes.items():
            if isinstance(axis, dict):
                head = {"fric": FrictionDocument.type_name(), "axis": str(name), "motion": axis.get("motion", "linear")}
                axis = headed(axis, head)
                if "feedforward" in axis:
                    axis = {**axis, "feedforward": headed(axis["feedforward"], head)}
                axes[name] = axis
        return {**given, "axes": axes}

    @model_validator(mode="before")  # pydantic takes the last of these first
    @classmethod
    def _starts_from_another(cls, given: Any, info: ValidationInfo) -> Any:
        """Fill in values from the machine file that this one is based on."""
        if not isinstance(given, dict) or not isinstance(given.get("like"), str):
            return given
        start = read_document((info.context or {})["folder"] / given["like"], cls)
        changed = given.get("axes", {})
        if not isinstance(changed, dict) or not all(isinstance(part, dict) for part in changed.values()):
            return given
        axes = {name: dict(part) for name, part in start.axes.items()}
        return {**given, "axes": axes | {name: axes.get(name, {}) | part for name, part in changed.items()}}

    @model_validator(mode="after")
    def _parts_are_of_their_axis(self) -> Self:
        for name, axis in self.axes.items():
            for key, part in axis.parts().items():
                where = f"axes.{name}.{key}"
                if isinstance(part, AxisDocument | FrictionDocument) and not part.belongs(name, axis.motion):
                    raise ValueError(
                        f"{where}: the file is of the {part.motion} axis {part.axis}, "
                        f"and this is the {axis.motion} axis {name}\n"
                        "Name the file of this axis."
                    )
                if isinstance(part, Physical):
                    part.estimates(axis.motion, where)
        return self

    def machine(self) -> Machine:
        """Return the machine in SI."""
        axes = {name: _axis(name, part) for name, part in self.axes.items()}
        return Machine(self.name, axes, tuple(part.published() for part in self.published), warnings=self.passed_on())

    def passed_on(self) -> tuple[Notice, ...]:
        """Return the doubts of the axes' files, each once."""
        parts = (part for axis in self.axes.values() for part in axis.parts().values() if isinstance(part, Document))
        return tuple(dict.fromkeys([*super().passed_on(), *(notice for part in parts for notice in part.passed_on())]))


def _axis(name: str, part: AxisPart) -> Axis:
    motion = part.motion
    with found_in(f"axis {name}"):
        cascade = part.controller.in_si(motion)
        plant = _after_its_hold(part.plant, motion, cascade.sampling)
        believed = part.feedforward.friction or part.friction
        gain = part.feedforward.values(motion).get("gain", 1.0)
        nominal = _after_its_hold(part.nominal, motion, cascade.sampling) if part.nominal else None
        G_n, friction = nominal or plant, true_friction(part.friction)
        return Axis(
            name=name, motion=motion, plant=plant, cascade=cascade, friction=friction, load=part.friction.load(),
            nominal_friction=NominalFriction(nominal_models(believed), gain, lead_of(part.feedforward.lead) or 0.0),
            nominal=nominal, observer=part.observer.observer(motion, G_n.A, G_n.B) if part.observer else None,
            encoder=Encoder(part.encoder.values(motion)["resolution"] if part.encoder else 0.0),
            force_noise=part.noise.values(motion)["force"] if part.noise else 0.0,
            reality=part.reality.in_si(motion) if part.reality else NONE,
            blocks={key: _block(name, key, given, motion) for key, given in part.blocks.items()},
            second_mass=part.second_mass.in_si(motion) if part.second_mass else spring_of(part.plant, friction, motion),
        )  # fmt: skip


def _after_its_hold(part: PlantPart, motion: Motion, sampling: float) -> Plant:
    """Return a plant, of which an assumed delay holds the half sample of its controller."""
    plant = part.plant(motion)
    return replace(plant, T_d=max(plant.T_d, hold_delay(sampling))) if part.T_d.assumed else plant


def _block(axis: str, name: str, given: BlockDocument | dict[str, Quantity], motion: Motion) -> dict[str, float]:
    if not isinstance(given, BlockDocument):
        try:
            return block_values(name, given, motion, f"blocks.{name}")
        except ValueError as error:
            what, _, hint = str(error).partition("\n")
            raise FricError(what, hint=hint) from None
    if (given.block, given.axis, given.motion) != (name, axis, motion):
        what = f"blocks.{name}: the file is the block '{given.block}' of the {given.motion} axis {given.axis}"
        raise FricError(what, hint=f"Name the file of '{name}' on this axis.")
    return given.values()


def spring_of(plant: PlantPart, friction: FrictionModel, motion: Motion) -> SecondMass | None:
    """Return the second mass in a plant file; None without one, or if friction has no memory."""
    if not isinstance(plant, PlantDocument) or plant.second_mass is None or not friction.initial_state().size:
        return None
    seen, all_of = plant.second_mass.in_si(motion), plant.plant(motion).M
    omega, reduced = 2 * pi * seen.frequency, all_of * seen.ratio * (1 - seen.ratio)
    damping = 2 * seen.damping * omega * reduced
    return SecondMass(all_of * seen.ratio, omega**2 * reduced, damping, encoder=seen.encoder)


def true_friction(document: FrictionDocument) -> FrictionModel:
    """Return the richest model of a friction file: the last that builds upon the others."""
    given = document.model_names()
    for name in ("rolling", "gms", *given, "static"):
        if name in given or (name == "static" and document.static):
            return document.friction(name)
    raise FricError(f"there is no friction model for axis {document.axis}", hint="Give 'static' and 'gms'.")


@verb
def read_friction(path: Path | str, model: str | None = None) -> FrictionModel:
    """Read the friction model of a friction file, for verbs and for the feedforward of `Machine.with_belief`.

    path: The friction file.
    model: Its name, as ``static``; else the model that is based on the others.
    Raises FricError: When the file does not read, or holds no such model.
    """
    document = read_document(Path(path), FrictionDocument)
    return true_friction(document) if model is None else document.friction(model)


@verb
def write_machine(machine: Machine, path: Path | str, *, force: bool = False) -> None:
    """Write a machine as one file, which `fric.read_machine` and the command line read; `fric.Machine.save` does so.

    Numbers have six digits. The place of an encoder's counts is not written, for no drive knows it.

    path: The file.
    Raises FricError: When an axis has a friction that no file holds, as one completed by a measured circle.
    """
    axes = {name: _filed(axis) for name, axis in machine.axes.items()}
    content: dict[str, Any] = {"name": machine.name, "axes": axes}
    if machine.published:
        content["published"] = [
            in_units({"radius": test.radius, "velocity": test.feed}, PublishedPart.dimensions, "linear")
            | {"glitch": {name: Estimate(value, "m") for name, value in test.glitches.items()}}
            for test in machine.published
        ]
    write_document(Path(path), MachineDocument.made(content, notices=machine.warnings).tree(), force=force)


def _filed(axis: Axis) -> dict[str, Any]:
    """Return an axis by the keys of its part of a machine file."""
    motion, nominal, observer = axis.motion, axis.nominal_friction, axis.observer
    friction = _sections([axis.friction], axis)
    if axis.load:
        friction["static"] = friction.get("static", {}) | in_units({"offset": axis.load}, {"offset": "force"}, motion)
    if any(name != model.name or name == "rolling" for name, model in nominal.models.items()):
        raise FricError(f"axis {axis.name}: no file holds {', '.join(nominal.models)} under these names")
    lead = nominal.lead if nominal.lead == "auto" else f"{nominal.lead!r} s"
    believed = {"gain": nominal.gain, "lead": lead, "friction": _sections(nominal.models.values(), axis)}
    blocks = {
        name: in_units(given, {value.name: value.dimension for value in block_type(name).parameters}, motion)
        for name, given in axis.blocks.items()
    }
    return known(
        motion=motion, plant=plant_part(axis.plant, motion), nominal=axis.nominal and plant_part(axis.nominal, motion),
        controller=ControllerPart.of(axis.cascade, motion), observer=observer
        and in_units(vars(observer) | vars(observer.q), ObserverPart.dimensions, motion) | {"filter": observer.q.name},
        encoder=EncoderPart.of(axis.encoder, motion),
        noise=in_units({"force": axis.force_noise}, NoisePart.dimensions, motion), friction=friction,
        feedforward=believed, blocks=blocks or None, second_mass=axis.second_mass and filed(axis.second_mass, motion),
        reality=None if axis.reality == NONE else filed(axis.reality, motion),
    )  # fmt: skip


def sections_of(model: FrictionModel, motion: Motion) -> dict[str, dict[str, Estimate]]:
    """Return the parameters of a friction model by the sections of a friction file."""
    if isinstance(model, Directed):
        return sections_of(model.model, motion) | {"static_negative": sections_of(model.negative, motion)["static"]}
    parts = {name: part for name, part in vars(model).items() if isinstance(part, FrictionModel)}
    return {
        section: in_units(vars(parts.get(section, model)), {p.name: p.dimension for p in of}, motion)
        for section, of in type(model).declared().items()
    }


def _sections(given: Iterable[FrictionModel], axis: Axis) -> dict[str, dict[str, Estimate]]:
    """Return friction models of an axis as the sections of one friction file."""
    found: dict[str, dict[str, Estimate]] = {}
    for model in given:
        kind = type(model.model if isinstance(model, Directed) else model)
        if model_type(model.name) is not kind:
            hint = "Give the axis a model with parameters, as `fric.GMS`, by `dataclasses.replace`."
            raise FricError(f"axis {axis.name}: no file holds the friction {kind.__name__}", hint=hint)
        for section, values in sections_of(model, axis.motion).items():
            if found.setdefault(section, values) != values:
                what = f"axis {axis.name}: its controller knows several '{section}', and a file holds one"
                raise FricError(what, hint="Give it models on one static map, by `machine.with_belief`.")
    return found


def nominal_models(document: FrictionDocument) -> dict[str, FrictionModel]:
    """Return every model of a friction file that a controller can feed forward, by name."""
    names = (["static"] if document.static else []) + [name for name in document.model_names() if name != "rolling"]
    return {name: document.friction(name) for name in names}


NOMINAL_DOCUMENTS: dict[str, type[AxisDocument | FrictionDocument | BlockDocument]] = {
    kind.type: kind for kind in (PlantDocument, ControllerDocument, ObserverDocument, FrictionDocument, BlockDocument)
}
"""Nominal parts of an axis that can be given as a file, by document type."""


@verb
def read_machine(
    path: Path | str, *, nominal_files: Annotated[Iterable[str], Kind(list[str], "AXIS=FILE.yaml")] = (),
    gain: float | None = None, lead: Annotated[float | str | None, "time"] = None,
    friction_model: Annotated[str | None, Kind(metavar="NAME")] = None,
) -> Machine:  # fmt: skip
    """Read a machine file, and the files that it names.

    path: The machine file.
    friction_model: Friction model of the machine, of those in its file; by default the richest.
    Raises FricError: When a file does not read, a value is missing, of the wrong unit or not physical, or a part is of
        another axis.
    """
    nominal_files = tuple(nominal_files)
    ahead: Any = parse(lead, "time") if isinstance(lead, str) and lead != "auto" else lead
    document = read_machine_document(path, nominal_files)
    with found_in(str(path)):
        machine = document.machine()
        axes = dict(machine.axes)
        if friction_model is not None:
            for name, part in document.axes.items():
                axes[name] = replace(axes[name], friction=part.friction.friction(friction_model))
    instead = known(gain=gain, lead=ahead)
    for name, axis in axes.items():
        axes[name] = replace(axis, nominal_friction=replace(axis.nominal_friction, **instead))
    designed = [
        GAINS_DESIGNED.found(f"axis {name}") for name, part in document.axes.items()
        if isinstance(part.controller, ControllerDocument) and part.controller.margins
    ]  # fmt: skip
    doubtful = settled(finding for axis in axes.values() for finding in _of_axis(axis, str(path)))
    origin: dict[str, Any] = {"path": str(path), "nominal_files": list(nominal_files), "friction_model": friction_model}
    rigid = [
        PRESLIDING_UNKNOWN.found(f"axis {name}") for name, part in document.axes.items()
        if part.friction.fit is not None and not part.friction.model_names()
    ]  # fmt: skip
    warnings = (*machine.warnings, *doubtful, *designed, *rigid)
    return replace(machine, axes=axes, origin=origin | instead, warnings=warnings)


def _of_axis(axis: Axis, where: str) -> Iterator[Finding]:
    """Yield the quantities of an axis with physical bounds: both plants, all frictions with the mass, the sampling."""
    where = f"{where}, axis {axis.name}"
    for plant in filter(None, (axis.plant, axis.nominal)):
        yield from of_plant(plant, axis.motion, where)
    for model in (axis.friction, *axis.nominal_friction.models.values()):
        for part in (model.model, model.backward) if isinstance(model, Directed) else (model,):
            static = part if isinstance(part, StaticMap) else getattr(part, "static", None)
            if static is not None:
                yield from of_friction(static, axis.motion, axis.plant.M, where)
    yield Finding("sampling", axis.cascade.sampling, axis.motion, where)


def read_machine_document(path: Path | str, nominal_files: Iterable[str] = ()) -> MachineDocument:
    """Read a machine file as a document, with the files that its controllers use instead in their places."""
    document = read_document(path, MachineDocument)
    axes = dict(document.axes)
    for given in nominal_files:
        name, equals, file = given.partition("=")
        if not equals:
            hint = f"Write it as {next(iter(axes))}={given}."
            raise FricError(f"'{given}' does not say which axis it is for", hint=hint)
        require_known(name, axes, "the machine has no axis", "Its axes are")
        kind, part = _nominal_document(Path(file))
        if not part.belongs(name, axes[name].motion):
            which = f"is the {kind} of the {part.motion} axis {part.axis}"
            what = f"{which}, and axis {name} of the machine is {axes[name].motion}"
            raise FricError(what, where=file, hint=f"Give the {kind} file of this axis.")
        if isinstance(part, BlockDocument):
            update: dict[str, object] = {"blocks": axes[name].blocks | {part.block: part}}
            if part.controller is not None:
                update["controller"] = part.controller
        elif kind == "friction":
            update = {"feedforward": axes[name].feedforward.model_copy(update={"friction": part})}
        else:
            update = {"nominal" if kind == "plant" else kind: part}
        axes[name] = axes[name].model_copy(update=update)
    return document.model_copy(update={"axes": axes})


def axis_notices(document: MachineDocument, name: str) -> tuple[Notice, ...]:
    """Return the notices of the files of an axis of a machine, each once."""
    parts = document.axes[name].parts().values() if name in document.axes else ()
    text = [notice for part in parts if isinstance(part, Document) for notice in part.notices()]
    return tuple(dict.fromkeys([*document.notices(), *text]))


def _nominal_document(file: Path) -> tuple[str, AxisDocument | FrictionDocument | BlockDocument]:
    tree = read_tree(file)
    kind = str(tree.get("fric", "") if hasattr(tree, "get") else "").partition("/")[0]
    if kind not in NOMINAL_DOCUMENTS:
        what = f"is not a file that a controller uses: its first line says 'fric: {kind}'"
        hint = f"Give one of {', '.join(NOMINAL_DOCUMENTS)}."
        raise FricError(what if kind else "is not a file of fric", where=str(file), hint=hint)
    return kind, read_document(file, NOMINAL_DOCUMENTS[kind])


class SpreadPart(Part):
    """The factor by which a parameter of a drawn machine differs from that of the nominal machine."""

    distribution: Distribution = said("of the factor, or of its logarithm", "uniform")
    factor: Quantity = Field(
        description="limits [low, high] of the factor; its 95 % interval where the distribution is normal or log-normal"
    )

    def spread(self) -> Spread:
        """Return the spread."""
        limits = self.factor.si("ratio", "linear")
        if not isinstance(limits.value, tuple) or len(limits.value) != 2:
            raise FricError("a spread has a lower and an upper factor", hint="Give them as value: [0.7, 1.3].")
        return Spread(*limits.value, self.distribution, limits.source)


class SpreadDocument(Document, type="spread"):
    """A spread file: which parameters of the true machine are drawn around the nominal values, and how widely."""

    spreads: dict[str, SpreadPart] = Field(
        description="by level (every friction force), stiffness (every stiffness), load, M, or a parameter's name"
    )

    @model_validator(mode="after")
    def _names_and_factors_fit(self) -> Self:
        for name, part in self.spreads.items():
            with refused(f"spreads.{name}"):
                check_spreads({name: part.spread()})
        return self


@verb
def read_spreads(path: Path | str) -> dict[str, Spread]:
    """Read spreads by name from a spread file."""
    return {name: part.spread() for name, part in read_document(path, SpreadDocument).spreads.items()}


CROSSED = 50.0  # Frequency at which a misfit of the response counts as a phase error [Hz]: about a feed drive's loop
OPEN = 2.0  # Factor to either side that bounds a parameter whose interval is open, or does not contain its estimate
AT_LEAST = 1e-3  # Errors below this share are neglected
FORM: Mapping[str, float] = {"k": 0.1, "alpha": 0.05, "C": 0.2, "v_s": 0.1, "T_d": 0.05, "B": 0.01}
"""Least difference of a real axis from a model of a few blocks and a single mass."""


def discrepancies(
    friction: FrictionDocument, plant: PlantPart, undrawn: Sequence[str] = ()
) -> tuple[dict[str, Spread], tuple[Notice, ...]]:
    """Return the factors of additional differences of the true axis from the parameters of its files, and the reasons.

    friction: Its friction file: strokes that scatter, sines at another level than strokes, blocks that miss the virgin
        curve.
    plant: Its plant file: the residual of eq. (1).
    undrawn: Parameters whose interval cannot be drawn from.
    """
    shares = dict(FORM)
    reasons: list[Notice] = []
    delay = float(plant.estimates(friction.motion)["T_d"])
    for name, share, why in (*_of_friction(friction), *_beyond_the_plant(plant, delay), *_of_warnings(friction, plant)):
        if share >= AT_LEAST:
            shares[name] = (shares.get(name, 0.0) ** 2 + share**2) ** 0.5
            reasons.append(PREDICTION_WIDENED.found(name=name, share=share, why=why))
    spreads = {name: Spread(1 / (1 + share), 1 + share, "log-normal") for name, share in shares.items()}
    for name in undrawn:
        if name != "offset":
            spreads[name] = Spread(1 / OPEN, OPEN, "log-normal")
            reasons.append(INTERVAL_OPEN.found(name=name, low=1 / OPEN, high=OPEN))
    return spreads, once(reasons)


Found = Iterator[tuple[str, float, str]]


def _of_friction(friction: FrictionDocument) -> Found:
    static = friction.estimates("static") if friction.static else {}
    fit = friction.fit_of("static")
    level = float(static["F_c"]) if "F_c" in static else 0.0
    if level > 0 and fit.between_strokes is not None:
        why = "strokes of one speed scatter so much beyond their own noise"
        yield "level", 1.96 * _number(fit.between_strokes) / level, why
    elif level > 0 and fit.rmse is not None:
        yield "level", 1.96 * _number(fit.rmse) / level, "the static map misses the strokes by so much"
    if level > 0 and fit.over_position is not None:
        yield "level", 1.96 * _number(fit.over_position) / level, "friction differs so much from place to place"
    if varies := level_of_next_record(friction):
        yield "level", varies, "friction differs so much from record to record"
    if (blocks := friction.fit_of("gms")).alpha_sum is not None:
        limits: Any = blocks.alpha_sum.ci95 or [blocks.alpha_sum.value]
        apart = max(abs(float(limit) - 1.0) for limit in limits if limit is not None)
        yield "level", apart, "the sines show another level than the strokes"
    rise = float(static["F_s"]) if "F_s" in static else 0.0
    if rise > 0 and blocks.virgin_curve_rmse is not None:
        share = 1.96 * _number(blocks.virgin_curve_rmse) / rise
        count = max(len(friction.estimates("gms")["alpha"].value), 1) if "alpha" in friction.section("gms") else 1  # type: ignore[arg-type]
        yield "k", 2.0 * share * count, "the blocks miss the virgin curve"
        yield "alpha", share * count, "the blocks miss the virgin curve"


def level_of_next_record(friction: FrictionDocument) -> float:
    """Return half the 95 % interval of the level of the next record [1], beyond the error of the mean.

    It is the `reach` of the deviation of their levels; a single record has four windows.
    """
    made = friction.provenance.model_dump() if friction.provenance else {}
    strokes = len({log.get("record") for log in (made.get("static") or made).get("logs", ())})
    found = []
    for name in ("static", *friction.model_names()):
        fit = friction.fit_of(name)
        count = len(fit.records) if fit.records else strokes
        deviation = _number((fit.between_records or {}).get("level"))
        found.append(reach(deviation, 0.0, count if count > 1 else WINDOWS) if deviation else 0.0)
    return max(found)


def _beyond_the_plant(plant: PlantPart, delay: float) -> Found:
    fit = plant.fit if isinstance(plant, PlantDocument) else None
    if fit is not None and fit.misfit is not None:
        share, why = _number(fit.misfit), "eq. (1) leaves so much of the measured response"
        late = min(share / (2 * pi * CROSSED * max(delay, 1e-4)), 1.0)
        yield "B", share, why
        yield "T_d", late, "eq. (1) leaves so much of the response's phase"
        yield "A", min(3.0 * share, 1.0), why
    elif fit is not None and fit.relative_error is not None:
        share, why = _number(fit.relative_error), "the rigid axis leaves so much of the force of an ordinary motion"
        yield "B", share, why
        yield "A", min(3.0 * share, 1.0), why
        yield "T_d", 0.3, "an ordinary motion hardly shows the delay"


def _of_warnings(friction: FrictionDocument, plant: PlantPart) -> Found:
    parts = [friction, *([plant] if isinstance(plant, PlantDocument) else [])]
    coded = {notice.code: notice for part in parts for notice in part.notices() if notice.severity != "note"}
    return (
        (name, float(text.values.get(share, 0.0)) if isinstance(share, str) else share, str(text))
        for text in coded.values() for name, share in flaw_of(text).widens.items()
    )  # fmt: skip


def _number(given: Quantity | None) -> float:
    value: Any = None if given is None else given.value
    return float(value) if isinstance(value, int | float) and abs(value) < inf else 0.0


KNOWN_GAIN = 0.02  # Relative half-width of K_p up to which it is not drawn: the loop is that of its gains
NO_INTERVAL = "no parameter has a 95 % interval"


@dataclass(frozen=True)
class IdentifiedMachine:
    """An identified machine."""

    machine: Machine  # The machine, true to the estimates
    intervals: Mapping[str, Intervals]  # By axis and parameter: those that include their estimate and are closed
    covariances: Mapping[str, Sequence[Covariance]]  # By axis, covariance of these parameters, where the files hold it
    discrepancies: Mapping[str, Mapping[str, Spread]]  # Factors by axis, from misfit and warnings
    widened: Mapping[str, tuple[Notice, ...]]  # By axis, why
    warnings: tuple[Notice, ...]  # Which parameters cannot be drawn from their interval
    gains: Mapping[str, float] = field(default_factory=dict)  # By axis, half the interval of K_p over K_p

    def drawn(self) -> dict[str, Any]:
        """Return the uncertainty that a study draws its machines from."""
        return {"intervals": self.intervals, "covariances": self.covariances, "discrepancies": self.discrepancies}


@verb
def read_identified(
    path: Path | str, *, nominal_files: Iterable[str] = (), gain: float | None = None, lead: float | str | None = None,
    friction_model: str | None = None,
) -> IdentifiedMachine:  # fmt: skip
    """Read a machine file with the intervals of what was identified of it.

    What is identified of an axis is what its controller believes: the friction file given in ``nominal_files``, or that
    of its feedforward, and the nominal plant; other values, and axes without these files, are as in the machine file.
    Flaws in the machine file are not used; a second mass is, if the response shows it.

    path, nominal_files, gain, lead, friction_model: As in `fric.documents.machine_files.read_machine`.
    Raises FricError: As `read_machine`; and when no parameter has an interval.
    """
    nominal_files = tuple(nominal_files)
    machine = read_machine(path, nominal_files=nominal_files, gain=gain, lead=lead, friction_model=friction_model)
    intervals, covariances = dict[str, Intervals](), dict[str, Sequence[Covariance]]()
    beyond, widened = dict[str, Mapping[str, Spread]](), dict[str, tuple[Notice, ...]]()
    axes, warnings, gains = dict(machine.axes), [], {}
    for name, part in read_machine_document(path, nominal_files).axes.items():
        kept: Any = part.controller
        K_p = Estimate.read(kept.K_p.model_dump())
        gains[name] = K_p.half_width / max(float(K_p), 1e-300)
        identified, of_plant = part.feedforward.friction, part.nominal or part.plant
        friction = part.friction
        if identified:  # the identified friction, completed by that of the machine
            head = {"axis": friction.axis, "motion": friction.motion}
            friction = FrictionDocument.made(head | friction.content() | identified.content(*identified.sections()))
        model, axis = true_friction(friction), machine.axes[name]
        sections = {key: friction.estimates(key) for key in friction.sections()}
        found, undrawn = friction_intervals(model, sections)
        known = of_plant.estimates(part.motion)
        plant: dict[str, Estimate] = {symbol: known[symbol] for symbol in ("A", "B", "T_d", "K_f") if symbol in known}
        if "offset" in sections.get("static", {}):
            plant["offset"] = sections["static"]["offset"]
        for symbol, estimate in plant.items():
            closed, open_ended = closed_intervals(symbol, estimate)
            found |= closed
            undrawn += open_ended
        if undrawn:
            warnings.append(NOT_DRAWN.found(f"axis {name}", names=undrawn))
        if found and gains[name] > KNOWN_GAIN and K_p.ci95 and None not in K_p.ci95:
            found |= closed_intervals("K_p", kept.K_p.si("velocity gain", part.motion))[0]
        if found and (ahead := kept.acceleration_feedforward):
            found |= closed_intervals("acceleration_feedforward", ahead.si("ratio", part.motion))[0]
        if found:
            intervals[name] = found
            covariances[name] = [*(identified or part.friction).covariances()]
            if isinstance(of_plant, PlantDocument) and of_plant.fit is not None and of_plant.fit.covariance is not None:
                covariances[name] = [*covariances[name], of_plant.fit.covariance.covariance()]
            beyond[name], widened[name] = discrepancies(identified or part.friction, of_plant, undrawn)
        load = float(plant["offset"]) if "offset" in plant else axis.load
        spring = axis.second_mass if part.nominal is None else spring_of(part.nominal, model, part.motion)
        seen = axis.nominal or axis.plant
        axes[name] = replace(axis, plant=seen, friction=model, load=load, reality=NONE, second_mass=spring)
    if not intervals:
        raise FricError(
            NO_INTERVAL, where=str(path),
            hint="Give files that `fric identify` wrote: `nominal_files='x=FRICTION.yaml'`, or in the machine file.",
        )  # fmt: skip
    whole = replace(machine, axes=axes)
    return IdentifiedMachine(whole, intervals, covariances, beyond, widened, tuple(warnings), gains)


def machine_to_predict(path: Path) -> tuple[Machine, IdentifiedMachine | None]:
    """Read a machine file as an identified machine, if it has intervals."""
    try:
        found = read_identified(path)
    except FricError as error:
        if error.what != NO_INTERVAL:
            raise
        return read_machine(path), None
    return found.machine, found
