"""A comparison of friction models as a document."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from fric.documents.provenance import provenance
from fric.estimate import Estimate
from fric.units import si_unit

if TYPE_CHECKING:
    from fric.identify.replay.compare import Comparison


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
            "rms_near_reversals": None if np.isnan(score.rms_near) else score.rms_near,
            "rms_fitted": score.rms_fitted,
            "parameters": score.parameters,
            "bits": score.bits,
            "bits_per_parameter": score.bits_per_parameter,
            "ns_per_step": score.nanoseconds,
            "records": by_record,
            "estimates": {
                section: {name: estimate.as_dict() for name, estimate in estimates.items()}
                for section, estimates in score.fits[0].estimates.items()
            },
        }
    leads = {
        name: {"lead": lead, "error": None if np.isinf(error) else error}
        for name, (lead, error) in comparison.leads.items()
    }
    return {
        "unit": force,
        "axis": comparison.records[0].log.axis,
        "winner": comparison.winner,
        "models": models,
        "leads": leads,
        "presliding": {
            record.log.name: Estimate(value, length).as_dict()
            for record, value in zip(comparison.records, comparison.presliding, strict=True)
        },
        "warnings": list(comparison.warnings),
        "provenance": provenance([record.log for record in comparison.records]),
    }


def _rms(values: np.ndarray[Any, np.dtype[np.float64]]) -> float | None:
    return float(np.sqrt(np.mean(values**2))) if len(values) else None
