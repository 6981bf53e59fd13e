"""The plant file: ``fric: plant/1``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from fric.documents.base import AxisDocument
from fric.documents.generated import FilePart
from fric.documents.quantity import CovarianceBlock, Part, Physical, Quantity, known
from fric.drive.plant import LinearPlant, Plant, hold_delay
from fric.drive.resonance import Resonance
from fric.errors import FricError
from fric.estimate import Covariance, Estimate
from fric.friction import FrictionModel
from fric.friction.directed import directed
from fric.friction.stribeck import StaticMap
from fric.log import Record
from fric.units import Motion, si_unit

if TYPE_CHECKING:
    from fric.identify.plant.response_fit import FrictionInfluence, PlantFit, ResponseFit
    from fric.identify.plant.rigid_body import MotionFit


class PlantPart(Physical):
    """The plant of eq. (1), ``B·e^(-s·T_d)/(s·(s + A))``."""

    A: Annotated[Quantity, "rate"] = Field(description="linear damping of the drive [1/s]")
    B: Annotated[Quantity | None, "acceleration per input"] = Field(
        None, description="acceleration per volt [m/(s^2*V)]; left out where no input was logged"
    )
    T_d: Annotated[Quantity, "time"] = Field(
        description="delay of the measured response, half a sample of hold included [s]"
    )
    K_f: Annotated[Quantity | None, "force per input"] = Field(
        None, description="force constant [N/V]; left out where no force was logged"
    )
    force_lag: Annotated[Quantity | None, "time"] = Field(
        None, description="lag of the logged force behind the voltage, at low frequency [s]"
    )
    force_filter: Annotated[Quantity | None, "frequency"] = Field(
        None, description="corner of the first-order filter within the lag [Hz]; left out if not visible"
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
                hint="Identify the plant again from a log with input, or with `force_constant=`.",
            )
        return values

    def plant(self, motion: Motion) -> Plant:
        """Return the plant in SI.

        Raises FricError: When B or K_f is not given, or a value is not physical.
        """
        values = self._with_B(motion)
        if "K_f" not in values:
            raise FricError(
                "the force constant K_f is not given",
                hint="Add 'K_f: {value: 548, unit: N/V}' from the drive's data sheet, or identify it with a force log.",
            )
        values.pop("force_filter", None)
        return Plant(**values)

    def damping_error(self, motion: Motion) -> float:
        """Return half the 95 % interval of the drive's damping K_f·A/B [N·s/m], of A's interval; 0 without it."""
        known = self.estimates(motion)
        limits = known["A"].ci95
        if limits is None or not {"B", "K_f"} <= known.keys():
            return 0.0
        low, high = limits
        return 0.5 * (float(high) - float(low)) * float(known["K_f"]) / float(known["B"])  # type: ignore[arg-type]


class ResponseFitPart(Part):
    """Result of a single frequency response."""

    record: str
    estimate: str = Field("", description="how the response was measured")
    averages: float | None = Field(None, description="independent averages, periods of an excitation")
    lines: int
    left_out: int
    lowest: Quantity
    highest: Quantity
    chi2: float
    misfit: Quantity = Field(description="relative residual of eq. (1) beyond noise")
    velocity_rms: Quantity | None = None
    A: Quantity
    B: Quantity
    T_d: Quantity


class FrictionSeen(Part):
    """Influence of Coulomb friction on the responses."""

    compared: bool = Field(description="true where two amplitudes were logged")
    seen: bool
    gain: Quantity | None = None
    F_c_over_M: Quantity | None = None


class FittedParameter(Quantity):
    """A parameter of a fit to a motion, with its deviation as if residuals were independent."""

    deviation: float | None = None


class PlantFitPart(Part):
    """How well the plant fits: the responses, or the motion, that it was identified from."""

    method: str = ""
    points: int | None = None
    chi2: float | None = None
    misfit: Quantity | None = Field(None, description="what eq. (1) leaves of the responses beyond noise, relative")
    sampling: Quantity | None = None
    hold_delay: Quantity | None = None
    transport_delay: Quantity | None = None
    responses: list[ResponseFitPart] | None = None
    friction: FrictionSeen | None = None
    channel: Literal["force", "input"] | None = None
    relative_error: Quantity | None = Field(None, description="relative residual of the force with the rigid axis")
    condition_number: float | None = None
    autocorrelation: float | None = None
    cutoff: Quantity | None = None
    decimation: int | None = None
    border: int | None = None
    parameters: dict[str, FittedParameter] | None = Field(None, description="M, F_v, F_c, offset of the rigid axis")
    covariance: CovarianceBlock | None = Field(None, description="covariance of the parameters")


class SecondMassPart(FilePart[Resonance]):
    """A table on a spring behind the motor, from the response."""


class PlantDocument(AxisDocument, PlantPart):
    """A plant file: eq. (1) of one axis."""

    type: ClassVar[str] = "plant"

    second_mass: SecondMassPart | None = Field(None, description="a second mass; left out if not visible")
    fit: PlantFitPart | None = Field(None, description="quality of the fit")

    def lowest(self, record: str) -> float:
        """Return the lowest frequency of a record's response [Hz]; 0 if not known."""
        responses = (self.fit.responses if self.fit else None) or ()
        return next(
            (
                float(response.lowest.si("frequency", self.motion))
                for response in responses
                if response.record == record
            ),
            0.0,
        )

    def coulomb(self) -> tuple[FrictionModel, float]:
        """Return the Coulomb friction and the load [N] identified with the plant from a motion.

        Viscous friction is a part of A, and not included here. Where each direction has F_c and F_v, A holds the mean
        of F_v, and the difference of a direction is its sigma; half the difference of F_c is the load, since a constant
        force and a Coulomb friction that differs by direction are the same in sliding.

        Raises FricError: When the plant was not identified from a motion.
        """
        given = (self.fit.parameters if self.fit else None) or {}
        found = {name: parameter for name, parameter in given.items() if name.startswith(("F_c", "F_v", "offset"))}
        values = {
            name: float(parameter.si("viscous" if name.startswith("F_v") else "force", self.motion))
            for name, parameter in found.items()
        }
        levels = [value for name, value in values.items() if name.startswith("F_c")]
        if not levels:
            raise FricError(
                "the plant file holds no Coulomb friction",
                hint="Give a friction file with `friction=`, or identify the plant from an ordinary motion.",
            )
        level = sum(levels) / len(levels)
        load = values.get("offset", 0.0)
        if "F_c_positive" not in values:
            return StaticMap(F_c=level, F_s=level, v_s=1e-3), load
        load = 0.5 * (values["F_c_positive"] - values["F_c_negative"])
        more = 0.5 * (values["F_v_positive"] - values["F_v_negative"])
        forward, backward = (StaticMap(F_c=level, F_s=level, v_s=1e-3, sigma=sigma) for sigma in (more, -more))
        return directed(forward, backward), load


def plant_part(plant: Plant, motion: Motion) -> PlantPart:
    """Return a plant as data of a document."""
    return PlantPart.model_validate(PlantPart.of(plant, motion))


def plant_tree(fit: PlantFit | MotionFit, records: Sequence[Record]) -> dict[str, Any]:
    """Return the plant document of an identified plant, ready to be written or printed.

    fit: What `identify_plant` or `identify_motion` found.
    records: The records that it was found from.
    """
    from fric.identify.plant.rigid_body import MotionFit  # with SciPy's signal processing: not for who reads a plant

    estimates, text = (
        (fit.plant, _of_motion(fit)) if isinstance(fit, MotionFit) else (fit.estimates, _of_responses(fit))
    )
    content: dict[str, Any] = {"axis": fit.axis, "motion": fit.motion, "fit": text}
    content |= {name: estimates[name] for name in PlantPart.dimensions if name in estimates}
    if not isinstance(fit, MotionFit) and fit.second_mass is not None:
        second = {name: estimate.as_dict() for name, estimate in fit.second_mass.items()}
        content["second_mass"] = second | {"encoder": fit.solution.form.encoder}
    return PlantDocument.made(content, notices=fit.warnings, logs=records).tree()


def _of_responses(fit: PlantFit) -> dict[str, Any]:
    hold = fit.hold
    return known(
        method="frequency response: weighted least squares on log magnitude and phase",
        points=int(sum(np.count_nonzero(response.used) for response in fit.responses)), chi2=fit.solution.chi2,
        misfit=Estimate(fit.solution.misfit, "1"), sampling=None if hold is None else Estimate(hold, "Hz"),
        hold_delay=None if hold is None else Estimate(hold_delay(hold), "s"), transport_delay=fit.transport,
        responses=[_response(response, fit.motion) for response in fit.responses],
        friction=_friction(fit.friction, fit.motion),
        covariance=Covariance.of(("A", "B", "T_d"), fit.solution.covariance[:3, :3], ("linear", "log", "linear")),
    )  # fmt: skip


def _response(fit: ResponseFit, motion: Motion) -> dict[str, Any]:
    measured, speed = fit.measured, fit.measured.speed
    f = measured.table.frequency[fit.used]
    return known(
        record=measured.table.name, estimate=measured.description, averages=measured.averages or None, lines=len(f),
        left_out=int(np.count_nonzero(~fit.used)), lowest=Estimate(float(f.min()), "Hz"),
        highest=Estimate(float(f.max()), "Hz"), chi2=fit.solution.chi2, misfit=Estimate(fit.solution.misfit, "1"),
        velocity_rms=None if speed is None else Estimate(speed, si_unit("velocity", motion)),
        **fit.solution.estimates(motion),
    )  # fmt: skip


def _friction(friction: FrictionInfluence, motion: Motion) -> dict[str, Any]:
    gains = None if np.any(np.isnan(friction.gains)) else tuple(float(g) for g in friction.gains)
    return known(
        compared=friction.compared,
        seen=friction.differs,
        gain=None if gains is None else Estimate(gains, f"s/{si_unit('position', motion)}"),
        F_c_over_M=friction.coulomb,
    )


def _of_motion(fit: MotionFit) -> dict[str, Any]:
    deviations = {name: {"deviation": deviation} for name, deviation in fit.deviation.items()}
    return {
        "method": "motion: least squares on zero-phase filtered, decimated signals", "channel": fit.channel,
        "points": len(fit.measured), "relative_error": Estimate(fit.relative_error, "1"),
        "condition_number": fit.condition_number, "autocorrelation": fit.autocorrelation,
        "sampling": Estimate(fit.sampling, "Hz"), "cutoff": Estimate(fit.conditioning.cutoff, "Hz"),
        "decimation": fit.conditioning.decimation, "border": fit.conditioning.border,
        "parameters": {name: {**estimate.as_dict(), **deviations[name]} for name, estimate in fit.estimates.items()},
    }  # fmt: skip
