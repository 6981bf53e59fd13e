"""Comparisons with records, as `--json` prints them: ``fric: comparison/1``, ``halves/1`` and ``validation/1``."""

from operator import itemgetter
from typing import Any

import numpy as np
from pydantic import Field

from fric.arrays import Real
from fric.documents.base import Document, Part, PartOf, Quantity, Written
from fric.documents.fields import Known, of, read_off
from fric.estimate import Estimate
from fric.identify.halves import Halved
from fric.statistics import rms
from fric.units import si_unit


class ScoredRecord(Part):
    """Residuals of a record over the scored samples."""

    rms: float
    rms_near_reversals: Known
    samples: int


class Plain(Written):
    """Residuals of the same samples without a dynamic model."""

    rms: float
    rms_near_reversals: Known = of("rms_near")
    parameters: int


class ScorePart(Written):
    """Errors of a model at held-out samples."""

    rms: float
    rms_near_reversals: Known = of("rms_near")
    rms_fitted: float
    parameters: int
    bits: float = Field(description="description length that the model saves")
    bits_per_parameter: float
    ns_per_step: float = of("nanoseconds")
    records: dict[str, ScoredRecord]
    estimates: dict[str, dict[str, Quantity]] = of(
        lambda item: item.fits[0].estimates, "by section and name, of the first fit"
    )


class Lead(Written):
    """Lead of the best model over another; without an error if that is not known."""

    lead: float = of(itemgetter(0))
    error: Known = of(itemgetter(1))


def _scored(found: Any, residual: tuple[Real, ...]) -> dict[str, Any]:
    """Return the residual of each scored record, by its name."""
    return {
        record.log.name: {"rms": rms(rest), "rms_near_reversals": rms(rest[near]), "samples": count}
        for record, rest, near in zip(found.records, residual, found.near, strict=True)
        if (count := int(np.isfinite(rest).sum()))
    }


class ComparisonDocument(Document, type="comparison"):
    """Friction models on held-out samples, as `--json` prints them."""

    axis: str = of(lambda found: found.records[0].log.axis)
    unit: str = of(lambda found: si_unit("force", found.records[0].log.motion), "of every rms")
    winner: str | None
    models: dict[str, ScorePart] = of(lambda found: {
        score.name: read_off(ScorePart, score, {"records"}) | {"records": _scored(found, score.residual)}
        for score in found.scores
    })  # fmt: skip
    baselines: dict[str, Plain] = of(lambda found: {baseline.name: baseline for baseline in found.baselines})
    leads: dict[str, Lead]
    presliding: dict[str, Quantity] = of(lambda found: {
        record.log.name: Estimate(value, si_unit("position", record.log.motion))
        for record, value in zip(found.records, found.presliding, strict=True)
    }, "displacement over which friction builds up, by record")  # fmt: skip


class HalvedPart(PartOf[Halved]):
    """A parameter of two halves of the records."""

    half_widths: float


class HalvesDocument(Document, type="halves"):
    """Differences between halves of the records, each identified separately."""

    axis: str
    within: float
    found: list[HalvedPart]
    untold: dict[str, str]


class SignalPart(Part):
    """Difference of a signal of the replay from the recorded signal."""

    relative: float = Field(description="norm of the difference over that of the recorded signal")
    rms: float
    unit: str


class ValidatedRecord(Written):
    """A record, replayed in a loop."""

    record: str = of("log.name")
    loop: str
    friction: str = of("friction.name")
    signals: dict[str, SignalPart] = of(lambda record: {
        name: {"relative": compared.relative, "rms": compared.rms, "unit": si_unit(name, record.log.motion)}
        for name, compared in record.signals.items()
    })  # fmt: skip
    filter: Quantity = of("cutoff", unit="Hz")
    worst_second: list[float] = of(
        lambda item: [float(item.log.time[item.worst[0]]), float(item.log.time[item.worst[1] - 1])],
        "begin and end of the second with the largest error [s]",
    )


class ValidationDocument(Document, type="validation"):
    """Recorded motions replayed by the identified axis, as `--json` prints them."""

    validations: list[ValidatedRecord]
