"""What is held against records, as `--json` prints it: ``fric: comparison/1``, ``halves/1`` and ``validation/1``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from fric.documents.base import Document
from fric.documents.generated import PartOf
from fric.documents.quantity import Known, Part, Quantity
from fric.estimate import Estimate
from fric.identify.halves import Halved
from fric.log import Log
from fric.notice import Notice
from fric.units import si_unit

if TYPE_CHECKING:
    from fric.circles.validation import Validation
    from fric.identify.replay.compare import Comparison


class ScoredRecord(Part):
    """Residuals of one record, over the samples that were scored."""

    rms: float
    rms_near_reversals: Known
    samples: int


class Score(Part):
    """How one model predicts samples that it was not fitted to."""

    rms: float
    rms_near_reversals: Known
    rms_fitted: float
    parameters: int
    bits: float = Field(description="description length that the model saves")
    bits_per_parameter: float
    ns_per_step: float
    records: dict[str, ScoredRecord]
    estimates: dict[str, dict[str, Quantity]] = Field(description="by section and name, of the first fit")


class Plain(Part):
    """What is left without a dynamic model, of the same samples."""

    rms: float
    rms_near_reversals: Known
    parameters: int


class Lead(Part):
    """By how much the best model leads another; no error where it cannot be told."""

    lead: float
    error: Known


class ComparisonDocument(Document):
    """Friction models on samples that none of them was fitted to, as `--json` prints them."""

    type: ClassVar[str] = "comparison"

    axis: str
    unit: str = Field(description="of every rms")
    winner: str | None
    models: dict[str, Score]
    baselines: dict[str, Plain]
    leads: dict[str, Lead]
    presliding: dict[str, Quantity] = Field(description="displacement over which friction builds up, by record")


def comparison_tree(comparison: Comparison) -> dict[str, Any]:
    """Return the figures of a comparison, ready to be printed."""
    motion = comparison.records[0].log.motion
    force, length = si_unit("force", motion), si_unit("position", motion)
    models = {}
    for score in comparison.scores:
        by_record = {}
        for record, rest, near in zip(comparison.records, score.residual, comparison.near, strict=True):
            known = np.isfinite(rest)
            if known.any():
                by_record[record.log.name] = {
                    "rms": float(np.sqrt(np.mean(rest[known] ** 2))),
                    "rms_near_reversals": _rms(rest[known & near]),
                    "samples": int(known.sum()),
                }
        models[score.name] = {
            "rms": score.rms,
            "rms_near_reversals": score.rms_near,
            "rms_fitted": score.rms_fitted,
            "parameters": score.parameters,
            "bits": score.bits,
            "bits_per_parameter": score.bits_per_parameter,
            "ns_per_step": score.nanoseconds,
            "records": by_record,
            "estimates": score.fits[0].estimates,
        }
    leads = {name: {"lead": lead, "error": error} for name, (lead, error) in comparison.leads.items()}
    logs = [record.log for record in comparison.records]
    content = {
        "axis": logs[0].axis,
        "unit": force,
        "winner": comparison.winner,
        "models": models,
        "baselines": {
            one.name: {"rms": one.rms, "rms_near_reversals": one.rms_near, "parameters": one.parameters}
            for one in comparison.baselines
        },
        "leads": leads,
        "presliding": {
            log.name: Estimate(value, length) for log, value in zip(logs, comparison.presliding, strict=True)
        },
    }
    return ComparisonDocument.made(content, notices=comparison.warnings, logs=logs).tree()


def _rms(values: np.ndarray[Any, np.dtype[np.float64]]) -> float | None:
    return float(np.sqrt(np.mean(values**2))) if len(values) else None


class HalvedPart(PartOf[Halved]):
    """A parameter of two halves of the records."""

    half_widths: float


class HalvesDocument(Document):
    """How far halves of the records are apart, each identified alone."""

    type: ClassVar[str] = "halves"

    axis: str
    within: float
    found: list[HalvedPart]
    untold: dict[str, str]


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
            name: {"relative": compared.relative, "rms": compared.rms, "unit": si_unit(name, log.motion)}
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
