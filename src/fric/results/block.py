"""A designed control block."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from fric.control import ControlBlock, Setting, block_type
from fric.design.blocks import BlockDesign, JointDesign, design_jointly
from fric.design.blocks import design_block as find_block
from fric.design.cascade import design_cascade
from fric.documents.controller import BlockDocument, block_parts
from fric.documents.machine_files import nominal_models
from fric.documents.plant import PlantDocument
from fric.errors import FricError
from fric.estimate import elements
from fric.flaws.response import CONTROLLER_BY_DEFAULT
from fric.friction import FrictionModel
from fric.notice import Notice
from fric.results.design import Design, perturbation_of
from fric.results.given_models import cascade_of, document_of, friction_of
from fric.results.kinds import ControllerLike, FrictionLike, LogLike, PlantLike, Quantity, RecordName
from fric.results.observer import measured_record
from fric.results.text import Piece, Table, named
from fric.units import parse_gain, readable
from fric.verb import Kind, verb


@dataclass(frozen=True, eq=False, repr=False)
class BlockResult(Design, schema=BlockDocument, of="content"):
    """A designed control block."""

    design: BlockDesign  # The block, and its loop
    joint: JointDesign | None = None  # The cascade, if it was designed together with the block

    @property
    def belief(self) -> ControlBlock:
        """The block."""
        return self.design.block

    def parts(self) -> dict[str, Any]:
        """Return the parameters of the block, and the cascade that it was designed with."""
        return block_parts(self.design, self.motion, None if self.joint is None else self.joint.cascade)

    def report(self) -> list[Piece]:
        """Return the parameters, the margins, and what the block requires of a controller."""
        block, tree = self.design.block, self.document
        rows = [
            (parameter.name, readable(float(given["value"]), given["unit"]), parameter.doc)
            for parameter in block.parameters
            if (given := tree["parameters"].get(parameter.name))
        ]
        found: list[Piece] = [
            f"{block.name}  of the kind {block.kind}, {self.design.reason}",
            Table(["parameter", "value", "what it is"], rows),
        ]
        return [*found, *self._cascade(), *([self.margins()] if tree["margins"] else []), f"it asks for: {block.asks}"]

    def _cascade(self) -> list[Piece]:
        if self.joint is None:
            return []
        after, before = self.joint.compliance
        rows = [
            (name, readable(float(given["value"]), given["unit"]))
            for name, given in self.document["controller"].items()
            if name not in {"sampling", "limit"}
        ]
        text = f"with this cascade a step of friction moves the axis {before / after:.1f} times less than without both"
        return [named(["cascade", "value"], rows), text]


@verb
def design_block(
    name: Annotated[str, Kind(metavar="NAME")],
    plant: PlantLike,
    log: LogLike | None = None,
    *,
    friction: FrictionLike | None = None,
    controller: ControllerLike | None = None,
    peak_sensitivity: Annotated[Quantity, "gain"] = "6 dB",
    record: RecordName | None = None,
    joint: bool = False,
) -> BlockResult:
    """Design a control block of an axis from its plant, its friction and a measured response.

    A block that feeds back is made as fast as the peak sensitivity of the whole loop allows, with the measured
    response; a nonlinear block is linearised around rest. A feedforward block is fitted to the friction.

    Parameters
    ----------
    name
        The control block, by its name in schemes; list shows all.
    plant
        The plant, eq. (1): A, B, T_d. Its file or its result.
    log
        A frequency response, or a record to take it from. Without it only the plant's delay limits the block.
    friction
        The friction that was identified. Its file or its result.
    joint
        Design the gains of the cascade together with the block. The stiffest loop within the peak sensitivity is
        sought.

    Raises
    ------
    FricError
        When there is no such block, or the loop exceeds the peak sensitivity even with the block at its slowest.
    """
    kind = block_type(name)
    if name in {"cascade", "inverse-model"}:
        other = "controller" if name == "cascade" else "observer"
        raise FricError(f"'{name}' has a design of its own", hint=f"Use fric design {other}.")
    document = document_of(PlantDocument, plant)
    axis, motion, linear = document.axis, document.motion, document.linear(document.motion)
    warnings: list[Notice] = []
    cascade = cascade_of(controller, axis, motion, "plant")
    if cascade is None:
        cascade = design_cascade(linear).cascade
        warnings.append(CONTROLLER_BY_DEFAULT.found())
    models: Mapping[str, FrictionModel] = {}
    K_f, spans = float("nan"), dict[str, tuple[float, float]]()
    if (given := friction_of(friction, axis, motion)) is not None:
        models, K_f = nominal_models(given), document.plant(motion).K_f
        spans = _spans(given.tree())
    logs, Delta = [], None
    if log is not None:
        logs = [measured_record(log, record, (axis, motion))]
        Delta, seen = perturbation_of(logs[0], document)
        warnings += seen
    allowed = parse_gain(peak_sensitivity)
    if not allowed > 1:
        raise FricError("no loop has a peak sensitivity of 0 dB or less", hint="Give one above 0 dB.")
    setting = Setting(linear, cascade, friction=models.get("gms"), models=models, K_f=K_f, spans=spans)
    if joint:
        both = design_jointly(kind, setting, peak_sensitivity=allowed, perturbation=Delta)
        return BlockResult(both.block, axis, motion, warnings, logs, joint=both)
    design = find_block(kind, setting, peak_sensitivity=allowed, perturbation=Delta)
    return BlockResult(design, axis, motion, warnings, logs)


def _spans(friction: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    """Return the closed 95 % intervals of what was identified, over their values, by name."""
    spans = {}
    for name, value, interval, _ in elements({**friction.get("static", {}), **friction.get("gms", {})}):
        low, high = interval or (None, None)
        if low is not None and high is not None and value > 0 and low > 0:
            spans[name] = (low / value, high / value)
    return spans
