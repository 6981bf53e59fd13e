"""The block file: ``fric: block/1``, the parameters of one control block on one axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Self

from pydantic import Field, GetJsonSchemaHandler, model_validator

from fric.control import block_type, blocks
from fric.control.cascade import Cascade
from fric.documents.base import OfAxis
from fric.documents.controller import ControllerPart
from fric.documents.provenance import provenance
from fric.documents.quantity import Quantity, in_units, quantities
from fric.errors import FricError
from fric.estimate import Estimate
from fric.log import Record
from fric.notice import Notice
from fric.units import Motion, si_unit

if TYPE_CHECKING:
    from fric.design.blocks import BlockDesign


def block_values(name: str, given: Mapping[str, Any], motion: Motion, where: str) -> dict[str, float]:
    """Return the parameters of a control block in SI.

    Raises FricError: When there is no such block, or a value is out of its bounds.
    Raises ValueError: When a parameter is not known, or of the wrong unit: with the mend.
    """
    block = block_type(name)
    raw = {key: value.model_dump() if isinstance(value, Quantity) else value for key, value in given.items()}
    found = quantities(raw, {one.name: one.dimension for one in block.parameters}, motion, where)
    values = {key: float(estimate) for key, estimate in found.items()}
    block.check(values)
    return values


class BlockDocument(OfAxis):
    """A block file: a control block of one axis with its parameters, and the margins that it was designed for."""

    type: ClassVar[str] = "block"

    block: str = Field(description="the control block: what it is called in a scheme")
    parameters: dict[str, Quantity] = Field(
        default_factory=dict, description="its parameters; what is left out is as the block is designed"
    )
    reason: str = Field("", description="why the parameters are as they are")
    controller: ControllerPart | None = Field(None, description="the cascade that it was designed together with")
    margins: dict[str, Any] = Field(default_factory=dict, description="margins of the whole loop, at the plant's input")

    @model_validator(mode="after")
    def _parameters_fit(self) -> Self:
        try:
            self.values()
        except FricError as error:
            raise ValueError(f"{error.what}\n{error.hint}") from None
        return self

    def values(self) -> dict[str, float]:
        """Return the parameters that are given, in SI."""
        return block_values(self.block, self.parameters, self.motion, "parameters")

    @classmethod
    def __get_pydantic_json_schema__(cls, core: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return the schema with every block, and its parameters with unit and meaning."""
        schema: dict[str, Any] = handler.resolve_ref_schema(handler(core))
        schema["properties"]["block"]["enum"] = list(blocks())
        schema["allOf"] = [
            {
                "if": {"properties": {"block": {"const": name}}},
                "then": {
                    "properties": {
                        "parameters": {
                            "properties": {
                                one.name: {"description": f"{one.doc} [{si_unit(one.dimension, 'linear')}]"}
                                for one in block.parameters
                            },
                            "additionalProperties": False,
                        }
                    }
                },
            }
            for name, block in blocks().items()
        ]
        return schema


def block_tree(
    design: BlockDesign,
    axis: str,
    motion: Motion,
    logs: Sequence[Record] = (),
    warnings: Sequence[Notice] = (),
    cascade: Cascade | None = None,
) -> dict[str, Any]:
    """Return a control block with the margins of the loop as a block document."""
    block, margins = design.block, {} if design.margins is None else {"input": design.margins.as_dict()}
    return {
        "fric": BlockDocument.type_name(),
        "axis": axis,
        "motion": motion,
        "block": block.name,
        "parameters": _given(in_units(vars(block), {one.name: one.dimension for one in block.parameters}, motion)),
        "reason": design.reason,
        **({} if cascade is None else {"controller": _given(ControllerPart.of(cascade, motion))}),
        "margins": margins,
        "warnings": list(warnings),
        "provenance": provenance(logs),
    }


def _given(values: Mapping[str, Estimate]) -> dict[str, Any]:
    return {name: {"value": float(value), "unit": value.unit} for name, value in values.items()}
