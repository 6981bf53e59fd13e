"""A designed controller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any, Literal

from fric.control.cascade import Cascade
from fric.design.cascade import CascadeDesign, Requirement, check_cascade, design_cascade
from fric.documents.controller import ControllerPart, controller_tree
from fric.documents.plant import PlantDocument
from fric.errors import FricError
from fric.notice import Notice
from fric.results.design import Design
from fric.results.given import in_si, quantity
from fric.results.given_models import document_of
from fric.results.names import plain_names
from fric.results.text import Piece
from fric.units import Motion, parse_gain, readable
from fric.verb import verb

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False)
class ControllerResult(Design):
    """A designed, or checked, cascade.

    Parameters
    ----------
    design
        The cascade and its loops.
    of, motion
        Name and motion of the axis.
    view
        What the figure shows: ``bode``, ``nyquist`` or ``nichols``.
    description
        What the plant's file warns of.
    """

    design: CascadeDesign
    of: str
    motion: Motion
    view: str = "bode"
    description: Sequence[Notice] = ()

    @property
    def belief(self) -> Cascade:
        """The cascade."""
        return self.design.cascade

    @cached_property
    def document(self) -> dict[str, Any]:
        """The controller file."""
        return controller_tree(self.design, self.of, self.motion, self.description)

    def report(self) -> list[Piece]:
        """Return gains and margins."""
        names, given = ("K_p", "K_i", "K_v"), ControllerPart.of(self.design.cascade, self.motion)
        gains = (
            f"{name}  {readable(float(given[name]), given[name].unit, 4)}  {plain}"
            for name, plain in zip(names, plain_names(names), strict=True)
        )
        return [*gains, self.margins()]

    def figure(self) -> Figure:
        """Return the loops."""
        return self.loops_figure(self.design.cascade.sampling / 2)


@verb
def design_controller(
    plant: Any,
    *,
    phase_margin: float | str = "60 deg",
    gain_margin: float | str = "13.8 dB",
    sampling: float | str = "4 kHz",
    velocity_filter: float | str = "500 Hz",
    limit: float | str | None = None,
    corner_ratio: float = 10.0,
    separation: float = 3.0,
    crossover: float | str | None = None,
    gains: tuple[float | str | None, float | str | None, float | str | None] | None = None,
    view: Literal["bode", "nyquist", "nichols"] = "bode",
) -> ControllerResult:
    """Design the cascade P/PI of an axis by gain and phase margin of its sampled loops.

    The velocity loop's crossover is the highest at which it has both margins; the corner of its PI is 1/10 of it, and
    K_v/2π a third, or less where the position loop needs it.

    Parameters
    ----------
    plant
        The plant of eq. (1): its file or its result.
    phase_margin, gain_margin
        That velocity and position loop have at least [rad], [1]; a text such as "60 deg" or "13.8 dB".
    sampling, velocity_filter
        Of the controller, and the corner of the low-pass on the velocity [Hz].
    limit
        Saturation of the control voltage [V].
    corner_ratio, separation
        Crossover of the velocity loop over the corner of its PI, and over K_v/2π at least [1].
    crossover
        Of the velocity loop [Hz]; the highest where it is not given.
    gains
        K_v [1/s], K_p [V·s/m] and K_i [V/m] to check instead of seeking them.
    view
        What the figure shows.

    Raises
    ------
    FricError
        When a design is unstable or misses its margins: with the nearest that holds.
    """
    document = document_of("design_controller", PlantDocument, plant)
    motion, linear = document.motion, document.linear(document.motion)
    asked = Requirement(in_si(phase_margin, "angle"), parse_gain(gain_margin))
    rate, low_pass = in_si(sampling, "frequency"), in_si(velocity_filter, "frequency")
    largest = inf if limit is None else in_si(limit, "input")
    if gains is not None:
        if None in gains or crossover is not None:
            raise FricError("gains are checked all together", hint="Give --K_p, --K_i and --K_v, and no --crossover.")
        dimensions = ("rate", "velocity gain", "position gain")
        v, p, i = (in_si(gain or 0.0, kind, motion) for gain, kind in zip(gains, dimensions, strict=True))
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
    return ControllerResult(design, document.axis, motion, view, document.passed_on())
