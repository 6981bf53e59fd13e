"""The plant file: ``fric: plant/1``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from fric.documents.base import AxisDocument, Physical, Quantity
from fric.documents.of_axis import read_of_axis
from fric.documents.provenance import provenance
from fric.documents.yaml import read_document
from fric.drive.plant import LinearPlant, Plant
from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction import FrictionModel
from fric.friction.stribeck import StaticMap
from fric.log import FrequencyResponse, Log
from fric.units import Motion, si_unit

if TYPE_CHECKING:
    from fric.identify.dynamics.plant import FrictionInfluence, PlantFit, ResponseFit
    from fric.identify.dynamics.rigid_body import MotionFit


class PlantPart(Physical):
    """The plant of eq. (1), ``B·e^(-s·T_d)/(s·(s + A))``."""

    dimensions: ClassVar[dict[str, str]] = {
        "A": "rate",
        "B": "acceleration per input",
        "T_d": "time",
        "K_f": "force per input",
        "force_lag": "time",
        "force_filter": "frequency",
    }

    A: Quantity = Field(description="linear damping of the drive [1/s]")
    B: Quantity | None = Field(
        None, description="acceleration per volt [m/(s^2*V)]; left out where no input was logged"
    )
    T_d: Quantity = Field(description="delay of the measured response, half a sample of hold included [s]")
    K_f: Quantity | None = Field(None, description="force constant [N/V]; left out where no force was logged")
    force_lag: Quantity | None = Field(
        None, description="by how much the force is logged later than the voltage, at low frequency [s]"
    )
    force_filter: Quantity | None = Field(
        None, description="corner of the first-order filter that is part of the lag [Hz]; left out where none is seen"
    )

    def linear(self, motion: Motion) -> LinearPlant:
        """Return eq. (1) in SI, without a force scale; a value that is missing or not physical raises a `FricError`."""
        values = self._with_B(motion)
        return LinearPlant(values["A"], values["B"], values["T_d"])

    def _with_B(self, motion: Motion) -> dict[str, float]:
        values = self.values(motion)
        if "B" not in values:
            raise FricError(
                "the acceleration per volt B is not given",
                mend="Identify the plant again from a log with input, or with --force-constant.",
            )
        return values

    def plant(self, motion: Motion) -> Plant:
        """Return the plant in SI.

        Raises
        ------
        FricError
            When B or K_f is not given, or a value is not physical.
        """
        values = self._with_B(motion)
        if "K_f" not in values:
            raise FricError(
                "the force constant K_f is not given",
                mend="Add 'K_f: {value: 548, unit: N/V}' from the drive's data sheet, or identify it with a force log.",
            )
        values.pop("force_filter", None)
        return Plant(**values)


class PlantDocument(AxisDocument, PlantPart):
    """A plant file: eq. (1) of one axis."""

    type: ClassVar[str] = "plant"

    fit: dict[str, Any] = Field(default_factory=dict, description="how well the plant fits the response")


def read_plant(path: Path, *, axis: str, motion: Motion) -> Plant:
    """Read the plant of one axis, eq. (1), in SI.

    Raises
    ------
    FricError
        When the file is no plant, of another axis or motion, or lacks a value.
    """
    document = read_of_axis(path, PlantDocument, axis=axis, motion=motion)
    try:
        return document.plant(motion)
    except FricError as error:
        raise error.at(str(path)) from None


def plant_tree(fit: PlantFit | MotionFit, records: Sequence[Log | FrequencyResponse]) -> dict[str, Any]:
    """Return the plant document of an identified plant, ready to be written or printed.

    Parameters
    ----------
    fit
        What `identify_plant` or `identify_motion` found.
    records
        The records that it was found from.
    """
    from fric.identify.dynamics.rigid_body import MotionFit  # with SciPy's signal processing: not for who reads a plant

    estimates, quality = (
        (fit.plant, _of_motion(fit)) if isinstance(fit, MotionFit) else (fit.estimates, _of_responses(fit))
    )
    head: dict[str, Any] = {"fric": PlantDocument.type_name(), "axis": fit.axis, "motion": fit.motion}
    values = {name: estimates[name].as_dict() for name in PlantPart.dimensions if name in estimates}
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


def coulomb_of_plant(path: Path, *, motion: Motion) -> tuple[FrictionModel, float]:
    """Return the Coulomb friction and the load [N] that `fric identify plant` found beside the plant in a motion.

    Its viscous friction is in A, hence there is none here. Where F_c was found for each direction, their mean is taken.

    Raises
    ------
    FricError
        When the plant was not identified from a motion.
    """
    found = read_document(path, PlantDocument).fit.get("parameters", {})
    values = {name: float(Quantity.model_validate(_bare(entry)).si("force", motion)) for name, entry in found.items()
              if name.startswith(("F_c", "offset"))}  # fmt: skip
    levels = [value for name, value in values.items() if name.startswith("F_c")]
    if not levels:
        raise FricError(
            "holds no Coulomb friction", where=str(path),
            mend="Give a friction file with --friction, or identify the plant from an ordinary motion.",
        )  # fmt: skip
    level = sum(levels) / len(levels)
    load = values.get("offset", 0.0)
    if "F_c_positive" in values:
        load = 0.5 * (values["F_c_positive"] - values["F_c_negative"])
    return StaticMap(F_c=level, F_s=level, v_s=1e-3), load


def _bare(entry: dict[str, Any]) -> dict[str, Any]:
    return {"value": entry["value"], "unit": entry["unit"]}
