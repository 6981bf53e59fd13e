"""What a validation reads and tells: the friction of a plant or friction file, and the scores as a document."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from fric.documents.provenance import provenance
from fric.log import Log
from fric.units import si_unit

if TYPE_CHECKING:
    from fric.simulate.validation import Validation


def validation_tree(validations: Sequence[Validation], logs: Sequence[Log]) -> dict[str, Any]:
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
    return {"validations": records, "provenance": provenance(logs)}
