"""A designed controller."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from math import inf
from pathlib import Path
from typing import Annotated, Any, Literal

from fric.circles.gains import FoundController, controller_of, controller_of_logs
from fric.control.cascade import Cascade
from fric.design.cascade import CascadeDesign, Requirement, check_cascade, design_cascade
from fric.documents.controller import ControllerDocument, ControllerPart
from fric.documents.plant import PlantDocument
from fric.errors import FricError
from fric.log import Log
from fric.results.base import Figure, Identified
from fric.results.design import Design
from fric.results.given import in_si, logs_of, positive, quantity
from fric.results.given_models import circles_of, document_of
from fric.results.kinds import AxisName, CircleLike, LogLike, PlantLike, Quantity, SchemeName
from fric.results.text import Piece, parameters, plain_names
from fric.units import parse_gain, readable
from fric.verb import Kind, verb


@dataclass(frozen=True, eq=False, repr=False)
class GainsResult(Identified):
    """The cascade identified from a recorded voltage."""

    found: FoundController  # The controller, and the intervals of its gains
    axis: str  # Name of the axis

    @property
    def belief(self) -> Cascade:
        """The cascade."""
        return self.found.cascade

    @cached_property
    def document(self) -> dict[str, Any]:
        """The controller file."""
        content: dict[str, Any] = {"axis": self.axis, "motion": "linear"}
        content |= {**ControllerPart.of(self.found.cascade, "linear"), **self.found.estimates}
        return ControllerDocument.made(content).tree()

    def sections(self) -> dict[str, dict[str, dict[str, Any]]]:
        """Return the gains as the file holds them."""
        return {"controller": {name: self.document[name] for name in self.found.estimates}}

    def report(self) -> list[Piece]:
        """Return the gains, and how much of the voltage they explain."""
        where = f"{self.found.where}: {self.found.explained:.2%} of the voltage explained"
        return [parameters(self.sections()["controller"]), where]


@verb
def identify_controller(
    *records: Annotated[LogLike | CircleLike, Kind(Path, "FILE")],
    axis: AxisName = "x",
    scheme: SchemeName | None = None,
) -> GainsResult:
    """Identify the gains of an axis' controller from a circle, or a log in closed loop.

    It needs reference, position and voltage. Of circles the first is used, of logs the one that determines the gains
    best.

    Parameters
    ----------
    records
        A circle test without compensation of friction, or log files.

    Raises
    ------
    FricError
        When a channel is missing, or no cascade reproduces the recorded voltage.
    """
    logs, circles = list[Any](), list[Any]()
    for given in records:
        (logs if _is_log(given) else circles).append(given)
    if tests := circles_of(circles, scheme):
        return GainsResult(controller_of(tests[0], axis), axis)
    if not logs:
        raise FricError("there is no circle test", hint="Record one with reference, position and voltage.")
    of_axis = [log for log in logs_of(logs) if log.axis == axis]
    if not of_axis:
        raise FricError(f"no log is of axis {axis}", hint="Say which axis it is of (`axis=`).")
    return GainsResult(controller_of_logs(of_axis), axis)


def _is_log(given: Any) -> bool:
    """Return whether records of a log are given, or their file."""
    if isinstance(given, str | Path):
        from fric.io.recognise import recognise  # with HDF5, which a design needs not

        return recognise(Path(given)) == "log/1"
    first = given
    while isinstance(first, Iterable) and not isinstance(first, str):
        first = next(iter(first), None)
    return isinstance(first, Log)


@dataclass(frozen=True, eq=False, repr=False)
class ControllerResult(Design, schema=ControllerDocument, of="content"):
    """A designed, or checked, cascade."""

    design: CascadeDesign  # The cascade and its loops

    @property
    def belief(self) -> Cascade:
        """The cascade."""
        return self.design.cascade

    def parts(self) -> dict[str, Any]:
        """Return the gains of the cascade."""
        return ControllerPart.of(self.design.cascade, self.motion)

    def report(self) -> list[Piece]:
        """Return gains and margins."""
        names, given = ("K_p", "K_i", "K_v"), self.parts()
        gains = (
            f"{name}  {readable(float(given[name]), given[name].unit, 4)}  {plain}"
            for name, plain in zip(names, plain_names(names), strict=True)
        )
        return [*gains, self.margins()]

    def brief(self) -> str:
        """Return the gains."""
        given = self.parts()
        return ", ".join(f"{name} {readable(float(given[name]), given[name].unit)}" for name in ("K_v", "K_p", "K_i"))

    def figure(self) -> Figure:
        """Return the loops."""
        return self.loops_figure(self.design.cascade.sampling / 2)


@verb
def design_controller(
    plant: PlantLike,
    *,
    phase_margin: Annotated[Quantity, "angle"] = "60 deg",
    gain_margin: Annotated[Quantity, "gain"] = "13.8 dB",
    sampling: Annotated[Quantity, "frequency"] = "4 kHz",
    velocity_filter: Annotated[Quantity, "frequency"] = "500 Hz",
    limit: Annotated[Quantity | None, "input"] = None,
    corner_ratio: float = 10.0,
    separation: float = 3.0,
    crossover: Annotated[Quantity | None, "frequency"] = None,
    K_p: Annotated[Quantity | None, "velocity gain"] = None,
    K_i: Annotated[Quantity | None, "position gain"] = None,
    K_v: Annotated[Quantity | None, "rate"] = None,
    view: Literal["bode", "nyquist", "nichols"] = "bode",
) -> ControllerResult:
    """Design the cascade P/PI of an axis by gain and phase margin of its sampled loops.

    The velocity loop's crossover is the highest at which it has both margins; the corner of its PI is 1/10 of it, and
    K_v/2π a third, or less where the position loop needs it. A design that is unstable or misses its margins is
    refused, with the nearest valid design.

    Parameters
    ----------
    plant
        The plant, eq. (1): A, B, T_d. Its file or its result.
    phase_margin
        Least phase margin of velocity and position loop.
    gain_margin
        Least gain margin of velocity and position loop. A number is a factor.
    sampling
        Sampling rate of the controller.
    velocity_filter
        Corner of the low-pass on the velocity.
    limit
        Saturation of the control voltage.
    corner_ratio
        Ratio of the velocity loop's crossover to the corner of its PI.
    separation
        Least ratio of the velocity loop's crossover to K_v/2π.
    crossover
        Crossover of the velocity loop; by default the highest possible.
    K_p
        Velocity gain: given with K_i and K_v, the gains are checked, not designed.
    K_i
        Integral gain of the velocity loop, as '3156 V/m'.
    K_v
        Position gain, as '126 1/s'.
    view
        What the figure shows.

    Raises
    ------
    FricError
        When a design is unstable or misses its margins; the message has the nearest valid design.
    """
    document = document_of(PlantDocument, plant)
    motion, linear = document.motion, document.linear(document.motion)
    asked = Requirement(in_si(phase_margin, "angle"), parse_gain(gain_margin))
    rate, low_pass = positive(sampling, "frequency"), positive(velocity_filter, "frequency")
    largest = inf if limit is None else in_si(limit, "input")
    gains = {"rate": K_v, "velocity gain": K_p, "position gain": K_i}
    if any(gain is not None for gain in gains.values()):
        if None in gains.values() or crossover is not None:
            raise FricError("gains are checked all together", hint="Give `K_p=`, `K_i=`, `K_v=`, and no `crossover=`.")
        v, p, i = (in_si(gain or 0.0, kind, motion) for kind, gain in gains.items())
        design = check_cascade(linear, Cascade(v, p, i, low_pass, rate, largest), asked)
    else:
        design = design_cascade(
            linear,
            asked,
            sampling=rate,
            velocity_filter=low_pass,
            limit=largest,
            corner_ratio=corner_ratio,
            separation=separation,
            crossover=quantity(crossover, "frequency"),
        )
    return ControllerResult(design, document.axis, motion, document.passed_on(), view=view)
