"""Between an identified plant and the plant file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fric.estimate import Estimate
from fric.identify.dynamics.plant import FrictionInfluence, PlantFit, ResponseFit
from fric.identify.dynamics.rigid_body import MotionFit
from fric.io.documents.plant import PlantDocument
from fric.io.provenance import provenance
from fric.log import FrequencyResponse, Log
from fric.units import Motion, si_unit


def plant_tree(fit: PlantFit | MotionFit, records: Sequence[Log | FrequencyResponse]) -> dict[str, Any]:
    """Return the plant document of an identified plant, ready to be written or printed.

    Parameters
    ----------
    fit
        What `identify_plant` or `identify_motion` found.
    records
        The records that it was found from.
    """
    estimates, quality = (
        (fit.estimates, _of_responses(fit)) if isinstance(fit, PlantFit) else (fit.plant, _of_motion(fit))
    )
    head: dict[str, Any] = {"fric": PlantDocument.type_name(), "axis": fit.axis, "motion": fit.motion}
    values = {name: estimates[name].as_dict() for name in ("A", "B", "T_d", "K_f") if name in estimates}
    return head | values | {"fit": quality, "warnings": list(fit.warnings), "provenance": provenance(records)}


def _of_responses(fit: PlantFit) -> dict[str, Any]:
    found: dict[str, Any] = {
        "method": "frequency response: weighted least squares on log magnitude and phase",
        "points": int(sum(np.count_nonzero(response.used) for response in fit.responses)),
        "chi2": fit.solution.chi2,
        "misfit": Estimate(fit.solution.misfit, "1").as_dict(),
    }
    if fit.hold is not None:
        found["sampling"] = Estimate(fit.hold, "Hz").as_dict()
        found["hold_delay"] = Estimate(0.5 / fit.hold, "s").as_dict()
    found["transport_delay"] = fit.transport.as_dict()
    found["responses"] = [_response(response, fit.motion) for response in fit.responses]
    found["friction"] = _friction(fit.friction, fit.motion)
    return found


def _response(fit: ResponseFit, motion: Motion) -> dict[str, Any]:
    measured, half = fit.measured, fit.solution.half_widths()
    A, log_B, T_d = (float(v) for v in fit.solution.values[:3])
    f = measured.table.frequency[fit.used]
    B = float(np.exp(log_B))
    parts = {
        "A": Estimate(A, si_unit("rate", motion), (A - half[0], A + half[0])),
        "B": Estimate(B, si_unit("acceleration per input", motion), (B * np.exp(-half[1]), B * np.exp(half[1]))),
        "T_d": Estimate(T_d, "s", (T_d - half[2], T_d + half[2])),
    }
    found: dict[str, Any] = {
        "record": measured.table.name,
        "estimate": measured.told,
        "lines": len(f),
        "left_out": int(np.count_nonzero(~fit.used)),
        "lowest": Estimate(float(f.min()), "Hz").as_dict(),
        "highest": Estimate(float(f.max()), "Hz").as_dict(),
        "chi2": fit.solution.chi2,
        "misfit": Estimate(fit.solution.misfit, "1").as_dict(),
    }
    if measured.speed is not None:
        found["velocity_rms"] = Estimate(measured.speed, si_unit("velocity", motion)).as_dict()
    return found | {name: _plain(estimate) for name, estimate in parts.items()}


def _friction(friction: FrictionInfluence, motion: Motion) -> dict[str, Any]:
    length = si_unit("position", motion)
    found: dict[str, Any] = {"compared": friction.compared, "seen": friction.differs}
    if not np.any(np.isnan(friction.gains)):
        found["gain"] = Estimate(tuple(float(g) for g in friction.gains), f"s/{length}").as_dict()
    if friction.coulomb is not None:
        found["F_c_over_M"] = friction.coulomb.as_dict()
    return found


def _of_motion(fit: MotionFit) -> dict[str, Any]:
    return {
        "method": "motion: least squares on zero-phase filtered, decimated signals",
        "channel": fit.channel,
        "points": len(fit.measured),
        "relative_error": Estimate(fit.relative_error, "1").as_dict(),
        "condition_number": fit.condition_number,
        "autocorrelation": fit.autocorrelation,
        "sampling": Estimate(fit.sampling, "Hz").as_dict(),
        "cutoff": Estimate(fit.conditioning.cutoff, "Hz").as_dict(),
        "decimation": fit.conditioning.decimation,
        "border": fit.conditioning.border,
        "parameters": {
            name: estimate.as_dict() | {"deviation": fit.deviation[name]} for name, estimate in fit.estimates.items()
        },
    }


def _plain(estimate: Estimate) -> dict[str, Any]:
    """Return an estimate with floats of Python's own, which YAML and JSON can hold."""
    low, high = estimate.ci95 or (0.0, 0.0)
    return Estimate(float(estimate), estimate.unit, (float(low), float(high))).as_dict()  # type: ignore[arg-type]
