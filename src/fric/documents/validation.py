"""What a validation tells, as `--json` prints it: ``fric: validation/1``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import Field

from fric.documents.base import Document
from fric.documents.quantity import Part, Quantity
from fric.log import Log
from fric.notice import Notice
from fric.units import si_unit

if TYPE_CHECKING:
    from fric.circles.validation import Validation


class SignalPart(Part):
    """How far a signal of the replay is from the recorded one."""

    relative: float = Field(description="norm of the difference over that of the recorded signal")
    rms: float
    unit: str


class ValidatedRecord(Part):
    """One record, replayed in one loop."""

    record: str
    loop: str
    friction: str
    signals: dict[str, SignalPart]
    filter: Quantity
    worst_second: list[float] = Field(description="begin and end of the second with the largest error [s]")


class ValidationDocument(Document):
    """Recorded motions replayed by the identified axis, as `--json` prints them."""

    type: ClassVar[str] = "validation"

    validations: list[ValidatedRecord]


def validation_tree(
    validations: Sequence[Validation], logs: Sequence[Log], notices: Iterable[Notice] = ()
) -> dict[str, Any]:
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
    return ValidationDocument.made({"validations": records}, notices=notices, logs=logs).tree()
