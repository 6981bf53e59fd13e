"""Files of control blocks: ``fric: controller/1``, ``observer/1`` and ``block/1``."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field, GetJsonSchemaHandler, model_validator

from fric.control import block_type, blocks
from fric.control.cascade import Cascade
from fric.control.inverse_model import DisturbanceObserver
from fric.control.q_filter import Q_FILTERS, QFilter
from fric.documents.base import AxisDocument, FilePart, OfAxis, Part, Physical, Quantity, quantities, single
from fric.documents.fields import refused, said
from fric.units import Motion, si_unit


class ControllerPart(FilePart[Cascade]):
    """The cascade of one axis: position P, velocity PI, velocity by first difference and low-pass."""

    @classmethod
    def of(cls, given: object, motion: Motion) -> dict[str, Any]:
        """Return the cascade for a file; full feedforward, the default, is left out."""
        known = super().of(given, motion)
        return {name: item for name, item in known.items() if not name.endswith("_feedforward") or float(item) != 1.0}


class MarginsPart(Part):
    """Margins of a loop, without infinite values."""

    phase_margin: Quantity | None = None
    gain_margin: Quantity | None = None
    gain_reduction: Quantity | None = said("largest admissible reduction of the gain")
    peak_sensitivity: Quantity | None = None
    crossover: Quantity | None = None
    phase_crossover: Quantity | None = None
    peak_frequency: Quantity | None = said("where the sensitivity peaks")
    bandwidth: Quantity | None = None


class ControllerDocument(AxisDocument, ControllerPart, type="controller"):
    """A controller file: the cascade of one axis, and the margins it was designed for."""

    margins: dict[str, MarginsPart] = said("margins of velocity loop, position loop, plant input", dict)


class ObserverPart(Physical):
    """A disturbance observer ``d̂ = Q·(G_n⁻¹·z - u_t)``, ``G_n = B/(s·(s + A))``."""

    filter: str = said("the filter Q: binomial2 to 4, butterworth2 and 3, umeno-hori", "binomial2")
    cutoff: Annotated[Quantity, "frequency"] = Field(description="corner frequency 1/(2*pi*tau) of Q [Hz]")
    A: Annotated[Quantity | None, "rate"] = said("damping of the nominal plant [1/s]; the plant's where left out")
    B: Annotated[Quantity | None, "acceleration per input"] = said(
        "gain of the nominal plant; the plant's where left out"
    )

    @model_validator(mode="after")
    def _has_a_filter(self) -> Self:
        with refused("cutoff" if self.filter in Q_FILTERS else "filter"):
            self.q_filter()
        return self

    def q_filter(self) -> QFilter:
        """Return the filter Q."""
        return QFilter(self.filter, float(self.cutoff.si("frequency", "linear")))

    def observer(self, motion: Motion, A: float, B: float) -> DisturbanceObserver:
        """Return the observer in SI; A and B are those of the plant, taken where the file gives none."""
        values = {"A": A, "B": B} | self.values(motion)
        return DisturbanceObserver(self.q_filter(), values["A"], values["B"])


class LimitPart(Part):
    """Limit of Q by a rule; without a cutoff if that rule allows no Q."""

    cutoff: Quantity | None = None
    bandwidth: Quantity | None = None
    frequency: Quantity | None = said("where the rule binds")
    Delta: Quantity | None = said("size of the perturbation there")
    peak_sensitivity: Quantity | None = None

    @model_validator(mode="after")
    def _of_one_number(self) -> Self:
        single({name: given for name, given in self if given is not None})
        return self


class ObserverDocument(AxisDocument, ObserverPart, type="observer"):
    """An observer file: the filter Q of one axis, and the limit and margins it was designed for."""

    bandwidth: Quantity | None = said("where |Q| has fallen by 3 dB [Hz]; follows from the cutoff")
    reason: str = said("why the cutoff is as it is", "")
    limits: dict[Literal["robust", "sensitive"], LimitPart] = said(
        "limits of Q by eq. (8) and by peak sensitivity", dict
    )
    margins: dict[str, MarginsPart] = said("margins of the whole loop, at the plant's input", dict)


def block_values(name: str, given: Mapping[str, Any], motion: Motion, where: str) -> dict[str, float]:
    """Return the parameters of a control block in SI.

    Raises FricError: When there is no such block, or a value is out of its bounds.
    Raises ValueError: When a parameter is not known, or has the wrong unit, with what to do.
    """
    block = block_type(name)
    raw = {key: value.model_dump() if isinstance(value, Quantity) else value for key, value in given.items()}
    found = quantities(raw, {parameter.name: parameter.dimension for parameter in block.parameters}, motion, where)
    values = {key: float(estimate) for key, estimate in single(found).items()}
    block.check(values)
    return values


class BlockDocument(OfAxis, type="block"):
    """A block file: a control block of one axis with its parameters, and the margins that it was designed for."""

    block: str = Field(description="the control block: what it is called in a scheme")
    parameters: dict[str, Quantity] = said("its parameters; by default as the block is designed", dict)
    reason: str = said("why the parameters are as they are", "")
    controller: ControllerPart | None = said("the cascade that it was designed together with")
    margins: dict[str, MarginsPart] = said("margins of the whole loop, at the plant's input", dict)

    @model_validator(mode="after")
    def _parameters_fit(self) -> Self:
        with refused():
            self.values()
        return self

    def values(self) -> dict[str, float]:
        """Return the parameters that are given, in SI."""
        return block_values(self.block, self.parameters, self.motion, "parameters")

    @classmethod
    def __get_pydantic_json_schema__(cls, core: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return the schema with every block, and its parameters with unit and meaning."""
        schema: dict[str, Any] = handler.resolve_ref_schema(handler(core))
        schema["properties"]["block"]["enum"] = list(blocks())
        schema["allOf"] = []
        for name, block in blocks().items():
            known = {p.name: {"description": f"{p.doc} [{si_unit(p.dimension, 'linear')}]"} for p in block.parameters}
            parameters = {"properties": known, "additionalProperties": False}
            of_block = {"properties": {"block": {"const": name}}}
            schema["allOf"].append({"if": of_block, "then": {"properties": {"parameters": parameters}}})
        return schema
