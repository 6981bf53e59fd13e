"""The exported part of a machine (an axis under a scheme), targets that write it, their templates and manifest."""

import hashlib
import io
import re
import zipfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

import fric
from fric.arrays import Real
from fric.control.base import ControlBlock, Setting
from fric.control.scheme import Scheme
from fric.documents.base import warned
from fric.documents.machine_files import sections_of
from fric.errors import FricError
from fric.export.templates import render as render
from fric.export.templates import wrapped as wrapped
from fric.export.translate.program import Program
from fric.export.translate.reader import Entry, read_program
from fric.friction import FrictionModel
from fric.friction.directed import Directed
from fric.friction.stribeck import StaticMap
from fric.notice import Notice
from fric.reference import Reference
from fric.simulate.axis import blocks_of, setting_of
from fric.simulate.machine import Machine
from fric.units import Motion, si_unit

Files = Mapping[str, str | bytes]
LARGEST = {  # Limits of values [m, m/s, m/s², s, N, V; rad, N·m] beyond which an exported step reports a fault
    "position": 1e4, "velocity": 1e3, "acceleration": 1e6, "time": 1.0, "force": 1e9, "voltage": 1e6, "gain": 1e3,
}  # fmt: skip
Role = Literal["compensation", "machine"]
ROLES: tuple[Role, ...] = get_args(Role)


def archived(files: Mapping[str, bytes]) -> bytes:
    """Return files by name as a ZIP archive without a time stamp: equal content gives equal bytes."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), content)
    return packed.getvalue()


def remark(text: str) -> str:
    """Return a text as a comment of any language, without characters that could end the comment or a line."""
    return " ".join("".join(c if c.isascii() and (c.isalnum() or c in "_.,:+-=<>") else " " for c in text).split())


def identifier(text: str) -> str:
    """Return a text as an identifier of any language: letters, digits and single underscores."""
    return re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_").lower() or "axis"


@dataclass(frozen=True)
class ExportedPart:
    """The exported part of an axis: its controller under a scheme, or the machine itself.

    ::

        friction [V] = gain·F(r + lead·ṙ + lead²/2·r̈, ṙ + lead·r̈)/K_f
        model    [V] = (r̈ + A·(ṙ + lead·r̈))/B
        axis         = z̈ = B·u(t - delay) - A·ż - (F(z) + load)/M

    A controller has no preview of its reference, but it has the reference's velocity and acceleration: they carry it
    over the lead. On a circle of 30 mm at 100 mm/s, 0.65 ms ahead, that is right to 0.05 nm.
    """

    role: Role  # the controller with its nominal models, or the axis with its true friction, to try a controller on
    machine: str
    axis: str
    motion: Motion
    scheme: str
    friction: FrictionModel | None  # fed forward, or the true friction of the axis; None without feedforward
    K_f: float  # force constant [N/V]
    A: float  # damping [1/s]
    B: float  # acceleration per volt [m/(s²·V)]
    sampling: float  # rate of the controller [Hz]
    limit: float  # its largest voltage [V]
    resolution: float  # the encoder's step [m]
    gain: float = 1.0  # share of the friction that is fed forward
    lead: float = 0.0  # of the feedforward [s]
    delay: float = 0.0  # transport delay of the axis [s]
    load: float = 0.0  # constant force against positive motion [N]
    velocity_filter: float = 500.0  # corner of the low-pass behind the first difference of the encoder [Hz]
    K_p: float = float("nan")  # gain of the speed controller [V·s/m]
    K_i: float = float("nan")  # [V/m]
    blocks: tuple["BlockPart", ...] = ()  # the scheme's, besides the controller

    @property
    def parameters(self) -> NDArray[Any]:
        """The friction model's parameters as arguments of its step."""
        packed = self.model.packed()
        if isinstance(self.model, Directed):
            packed[0] = 0.0  # where a step lies in this process
        return packed

    @property
    def initial_state(self) -> NDArray[Any]:
        """The friction model's state at rest."""
        return self.model.initial_state()

    @property
    def model(self) -> FrictionModel:
        """The friction model; raise a `FricError` without feedforward of friction."""
        if self.friction is None:
            what = f"scheme {self.scheme} feeds no friction forward, and there is nothing to export"
            raise FricError(what, hint="Choose a scheme with friction: `scheme='c'` or `scheme='f'`.")
        return self.friction

    @property
    def step(self) -> str:
        """Name of the friction model's step in the program."""
        return f"{self.model.name}_step"

    @property
    def program(self) -> Program:
        """The steps of friction model and blocks as a program; raise a `FricError` with the reason if that fails."""
        model = self.model
        inner = type(model.model).step if isinstance(model, Directed) else None
        entries = [Entry(self.step, type(model).step, self.initial_state.size, self.parameters.size, inner)]
        entries += [Entry(block.name, block.step, block.state.size, block.parameters.size) for block in self.blocks]
        names = [f"friction model '{model.name}'", *(f"block '{block.title}'" for block in self.blocks)]
        for what, entry in zip(names, entries, strict=True):
            try:
                read_program(entry)
            except FricError as error:
                raise FricError(f"{what} {error}") from None
        return read_program(*entries)


@dataclass(frozen=True)
class BlockPart:
    """A control block of a scheme, packed for an axis."""

    title: str  # Its name in schemes
    kind: str  # ``observer``: its voltage is subtracted; ``feedforward``: it is added
    step: Any  # Its compiled step
    parameters: NDArray[Any]  # As the step reads them
    state: NDArray[Any]  # State of an axis at rest at 0
    per_position: NDArray[Any]  # Change of the state per metre of the commanded start position
    per_measured: NDArray[Any]  # The same of the measured start position

    @property
    def name(self) -> str:
        """Its name as an identifier."""
        return self.title.replace("-", "_")

    @property
    def begins(self) -> list[tuple[int, float, str]]:
        """Where the state depends on the start: index, change per metre, and the position that it is of."""
        signals = {"position": self.per_position, "measured": self.per_measured}
        return [(int(i), change[i], name) for name, change in signals.items() for i in np.flatnonzero(change)]


@dataclass(frozen=True)
class Target:
    """A language or a controller that a part can be exported to."""

    name: str  # Its name on the command line
    doc: str  # Its output in one line
    files: Callable[..., Files]  # Returns the files of a part by name; takes the options that the target knows
    options: frozenset[str] = field(default_factory=frozenset)  # Names of the options that it knows
    parts: tuple[str, ...] = ("compensation",)  # The part of an axis that it exports: ``compensation``, ``machine``
    friction: str | None = None  # The only friction model that it holds, and then no blocks; None where it holds any


def compensation_of(machine: Machine, name: str, scheme: Scheme) -> ExportedPart:
    """Return the controller of an axis under a scheme, with its nominal models."""
    axis = machine.axis(name)
    if scheme.joint:
        what = f"scheme {scheme.name} designs the cascade of axis {name} anew, and a cascade is not exported"
        hint = "Take the gains of 'fric design block --joint' into the machine file, and 'joint' out of the scheme."
        raise FricError(what, hint=hint)
    setting = setting_of(axis, scheme, Reference(axis.cascade.sampling, *np.zeros((3, 1))))
    controller, *others = blocks_of(axis, scheme, setting)
    if controller.name != axis.cascade.name:
        puts = f"scheme {scheme.name} puts '{controller.name}' in place of the controller"
        what = f"{puts}, and fric exports what is added to a controller"
        raise FricError(what, hint="Choose a scheme whose controller is the cascade.")
    nominal, cascade = axis.nominal or axis.plant, axis.cascade
    if (friction := setting.friction) is None and others:
        friction = StaticMap(F_c=0.0, F_s=0.0, v_s=1.0)  # nothing is fed forward; the blocks are
    return ExportedPart(
        "compensation", machine.name, name, axis.motion, remark(scheme.name), friction, nominal.K_f, nominal.A,
        nominal.B, cascade.sampling, cascade.limit, axis.encoder.resolution, setting.gain, setting.lead,
        K_p=cascade.K_p, K_i=cascade.K_i, blocks=tuple(_block(block, setting) for block in others),
    )  # fmt: skip


def machine_of(machine: Machine, name: str) -> ExportedPart:
    """Return an axis with its true friction, as a plant to try a controller on."""
    axis = machine.axis(name)
    plant, cascade = axis.plant, axis.cascade
    return ExportedPart(
        "machine", machine.name, name, axis.motion, "", axis.friction, plant.K_f, plant.A, plant.B, cascade.sampling,
        cascade.limit, axis.encoder.resolution, delay=plant.transport_delay(cascade.sampling), load=axis.load,
        velocity_filter=cascade.velocity_filter,
    )  # fmt: skip


def _block(block: ControlBlock, setting: Setting) -> BlockPart:
    def at(position: float, seen: float) -> Real:
        return block.initial_state(replace(setting, position=position, seen=seen))

    rest = at(0.0, 0.0)
    slopes = at(1.0, 0.0) - rest, at(0.0, 1.0) - rest
    return BlockPart(block.name, block.kind, type(block).step, block.packed(setting), rest, *slopes)


def axis_values(part: ExportedPart) -> dict[str, dict[str, Any]]:
    """Return the numbers of plant, controller and feedforward by name, each with its unit."""
    unit, force, of_input = (si_unit(name, part.motion) for name in ("position", "force", "input"))
    values = {
        "sampling": (part.sampling, "Hz"), "limit": (part.limit, of_input), "lead": (part.lead, "s"),
        "gain": (part.gain, "1"), "K_f": (part.K_f, si_unit("force per input", part.motion)), "A": (part.A, "1/s"),
        "B": (part.B, si_unit("acceleration per input", part.motion)), "resolution": (part.resolution, unit),
    }  # fmt: skip
    if part.role == "machine":
        values |= {"delay": (part.delay, "s"), "load": (part.load, force)}
        values |= {"velocity_filter": (part.velocity_filter, "Hz")}
    return {name: {"value": None if v == float("inf") else v, "unit": unit} for name, (v, unit) in values.items()}


def manifest(
    target: str, part: ExportedPart, files: Files, *, notices: Iterable[Notice], sources: Iterable[Mapping[str, str]]
) -> dict[str, Any]:
    """Return the content of manifest.json: SI values with their units, a digest of each file and of each source."""
    coded = {name: text.encode() if isinstance(text, str) else text for name, text in files.items()}
    head = {"fric": "export/1", "version": fric.__version__, "target": target, "part": part.role}
    head |= {name: getattr(part, name) for name in ("machine", "axis", "motion", "scheme")}
    friction = {"model": part.model.name} | friction_values(part.model, part.motion)
    blocks = [{"name": b.title, "kind": b.kind, "parameters": b.parameters.tolist()} for b in part.blocks]
    held = {"parameters": axis_values(part), "friction": friction, "blocks": blocks}
    digests = {name: hashlib.sha256(content).hexdigest() for name, content in coded.items()}
    return head | held | {"files": digests, "sources": list(sources)} | warned(notices)


def friction_values(model: FrictionModel, motion: Motion) -> dict[str, Any]:
    """Return the parameters of a model by section and name, each with its unit."""
    sections = sections_of(model, motion).items()
    return {section: {name: estimate.as_dict() for name, estimate in values.items()} for section, values in sections}
