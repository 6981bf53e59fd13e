"""The plant file: ``fric: plant/1``."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field

from fric.documents.base import AxisDocument, CovarianceBlock, FilePart, Physical, Quantity, Written
from fric.documents.fields import of, said
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
    from fric.identify.plant.identify import MotionFit, PlantFit, ResponseFit

METHODS = (
    "frequency response: weighted least squares on log magnitude and phase",
    "motion: least squares on zero-phase filtered, decimated signals",
)


class PlantPart(Physical):
    """The plant of eq. (1), ``B·e^(-s·T_d)/(s·(s + A))``."""

    A: Annotated[Quantity, "rate"] = Field(description="linear damping of the drive [1/s]")
    B: Annotated[Quantity | None, "acceleration per input"] = said(
        "acceleration per input [m/(s^2*V)]; left out where no input was logged"
    )
    T_d: Annotated[Quantity, "time"] = Field(
        description="delay of the measured response, half a sample of hold included [s]"
    )
    K_f: Annotated[Quantity | None, "force per input"] = said(
        "force constant [N/V]; left out where no force was logged"
    )
    force_lag: Annotated[Quantity | None, "time"] = said(
        "lag of the logged force behind the voltage, at low frequency [s]"
    )
    force_filter: Annotated[Quantity | None, "frequency"] = said(
        "corner of the first-order filter within the lag [Hz]; left out if not visible"
    )

    def linear(self, motion: Motion) -> LinearPlant:
        """Return eq. (1) in SI, without a force scale; a value that is missing or not physical raises a `FricError`."""
        values = self._with_B(motion)
        return LinearPlant(values["A"], values["B"], values["T_d"])

    def _with_B(self, motion: Motion) -> dict[str, float]:
        if "B" not in (values := self.values(motion)):
            hint = "Identify the plant again from a log with input, or with `force_constant=`."
            raise FricError("the acceleration per input B is not given", hint=hint)
        return values

    def plant(self, motion: Motion) -> Plant:
        """Return the plant in SI."""
        if "K_f" not in (values := self._with_B(motion)):
            hint = "Add 'K_f: {value: 548, unit: N/V}' from the drive's data sheet, or identify it with a force log."
            raise FricError("the force constant K_f is not given", hint=hint)
        values.pop("force_filter", None)
        return Plant(**values)

    def damping_error(self, motion: Motion) -> float:
        """Return half the 95 % interval of the drive's damping K_f·A/B [N·s/m], of A's interval; 0 without it."""
        known = self.estimates(motion)
        if not {"B", "K_f"} <= known.keys():
            return 0.0
        return known["A"].half_width * float(known["K_f"]) / float(known["B"])


def _solved(name: str) -> Callable[["ResponseFit"], Estimate]:
    return lambda fit: fit.solution.estimates(fit.measured.table.motion)[name]


class ResponseFitPart(Written):
    """Result of a single frequency response."""

    record: str = of("measured.table.name")
    estimate: str = of("measured.description", "how the response was measured", "")
    averages: float | None = of(
        lambda fit: fit.measured.averages or None, "independent averages, periods of an excitation", None
    )
    lines: int = of(lambda fit: np.count_nonzero(fit.used))
    left_out: int = of(lambda fit: np.count_nonzero(~fit.used))
    deviating: tuple[Quantity, ...] | None = of(
        lambda fit: tuple(Estimate(f, "Hz") for f in fit.stand_off) or None, "of these, lines that deviate", None
    )
    lowest: Quantity = of(lambda fit: fit.measured.table.frequency[fit.used].min(), unit="Hz")
    highest: Quantity = of(lambda fit: fit.measured.table.frequency[fit.used].max(), unit="Hz")
    chi2: float = of("solution.chi2")
    misfit: Quantity = of("solution.misfit", "relative residual of eq. (1) beyond noise", unit="1")
    velocity_rms: Quantity | None = of(
        lambda fit: fit.measured.speed and Estimate(fit.measured.speed, si_unit("velocity", fit.measured.table.motion)),
        default=None,
    )
    A: Quantity = of(_solved("A"))
    B: Quantity = of(_solved("B"))
    T_d: Quantity = of(_solved("T_d"))


class FrictionSeen(Written):
    """Influence of Coulomb friction on the responses."""

    compared: bool = of("friction.compared", "true where two amplitudes were logged")
    seen: bool = of("friction.differs")
    gain: Quantity | None = of(
        lambda fit: None if np.isnan(gains := tuple(map(float, fit.friction.gains))).any()
        else Estimate(gains, f"s/{si_unit('position', fit.motion)}"), default=None,
    )  # fmt: skip
    F_c_over_M: Quantity | None = of("friction.coulomb", default=None)


class FittedParameter(Quantity):
    """A parameter of a fit to a motion, with its deviation as if residuals were independent."""

    deviation: float | None = None


class PlantFitPart(Written):
    """How well the plant fits: the responses, or the motion, that it was identified from."""

    method: str = of(lambda fit: METHODS[hasattr(fit, "deviation")], default="")
    points: int | None = of(
        lambda fit: (
            len(fit.measured)
            if hasattr(fit, "measured")
            else sum(np.count_nonzero(response.used) for response in fit.responses)
        ),
        default=None,
    )
    chi2: float | None = of("solution.chi2", default=None)
    misfit: Quantity | None = of(
        "solution.misfit", "what eq. (1) leaves of the responses beyond noise, relative", None, unit="1"
    )
    sampling: Quantity | None = of(lambda fit: getattr(fit, "sampling", None) or fit.hold, None, None, unit="Hz")
    hold_delay: Quantity | None = of(lambda fit: fit.hold and hold_delay(fit.hold), default=None, unit="s")
    transport_delay: Quantity | None = of("transport", default=None)
    responses: list[ResponseFitPart] | None = None
    friction: FrictionSeen | None = of(lambda fit: fit.friction and fit, default=None)
    channel: Literal["force", "input"] | None = None
    relative_error: Quantity | None = of(
        "relative_error", "relative residual of the force with the rigid axis", None, unit="1"
    )
    condition_number: float | None = None
    autocorrelation: float | None = None
    cutoff: Quantity | None = of("conditioning.cutoff", default=None, unit="Hz")
    decimation: int | None = of("conditioning.decimation", default=None)
    border: int | None = of("conditioning.border", default=None)
    parameters: dict[str, FittedParameter] | None = of(
        lambda fit: {
            name: {**fit.estimates[name].as_dict(), "deviation": deviation} for name, deviation in fit.deviation.items()
        },
        "M, F_v, F_c, offset of the rigid axis", None,
    )  # fmt: skip
    covariance: CovarianceBlock | None = of(
        lambda fit: Covariance.of(("A", "B", "T_d"), fit.solution.covariance[:3, :3], ("linear", "log", "linear")),
        "covariance of the parameters", None,
    )  # fmt: skip


class SecondMassPart(FilePart[Resonance]):
    """A table on a spring behind the motor, from the response."""


class PlantDocument(AxisDocument, PlantPart, type="plant"):
    """A plant file: eq. (1) of one axis."""

    second_mass: SecondMassPart | None = said("a second mass; left out if not visible")
    fit: PlantFitPart | None = said("quality of the fit")

    def lines(self, record: str) -> tuple[float, list[float]]:
        """Return the lowest frequency of a record's response, 0 if not known, and those of deviating lines [Hz]."""
        for response in (self.fit.responses if self.fit else None) or ():
            if response.record == record:
                seen = [float(f.si("frequency", self.motion)) for f in (response.lowest, *(response.deviating or ()))]
                return seen[0], seen[1:]
        return 0.0, []

    def coulomb(self) -> tuple[FrictionModel, float]:
        """Return the Coulomb friction and the load [N] identified with the plant from a motion.

        Viscous friction is a part of A, and not included here. Where each direction has F_c and F_v, A holds the mean
        of F_v, and the difference of a direction is its sigma; half the difference of F_c is the load, since a constant
        force and a Coulomb friction that differs by direction are the same in sliding.
        """
        given = (self.fit.parameters if self.fit else None) or {}
        found = {name: parameter for name, parameter in given.items() if name.startswith(("F_c", "F_v", "offset"))}
        kinds = {name: "viscous" if name.startswith("F_v") else "force" for name in found}
        values = {name: float(parameter.si(kinds[name], self.motion)) for name, parameter in found.items()}
        if not (levels := [value for name, value in values.items() if name.startswith("F_c")]):
            hint = "Give a friction file with `friction=`, or identify the plant from an ordinary motion."
            raise FricError("the plant file holds no Coulomb friction", hint=hint)
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


def plant_tree(fit: "PlantFit | MotionFit", records: Sequence[Record]) -> dict[str, Any]:
    """Return the plant document of a plant that was identified from records, ready to be written or printed."""
    of_responses: Any = fit if hasattr(fit, "responses") else None
    estimates: Any = of_responses.estimates if of_responses else fit.plant
    content = {name: estimates[name] for name in PlantPart.dimensions if name in estimates}
    content |= {"axis": fit.axis, "motion": fit.motion, "fit": fit}
    if of_responses and of_responses.second_mass is not None:
        content["second_mass"] = of_responses.second_mass | {"encoder": of_responses.solution.form.encoder}
    return PlantDocument.made(content, notices=fit.warnings, logs=records).tree()
