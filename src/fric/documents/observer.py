"""The observer file: ``fric: observer/1``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import log10
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field

from fric.control.inverse_model import DisturbanceObserver
from fric.control.q_filter import QFilter
from fric.documents.base import AxisDocument
from fric.documents.controller import MarginsPart
from fric.documents.quantity import Part, Physical, Quantity
from fric.estimate import Estimate
from fric.log import Record
from fric.notice import Notice
from fric.units import Motion, si_unit

if TYPE_CHECKING:
    from fric.design.observer import ObserverDesign


class ObserverPart(Physical):
    """A disturbance observer ``d̂ = Q·(G_n⁻¹·z - u_t)``, ``G_n = B/(s·(s + A))``."""

    filter: str = Field("binomial2", description="the filter Q: binomial2 to 4, butterworth2 and 3, umeno-hori")
    cutoff: Annotated[Quantity, "frequency"] = Field(description="corner frequency 1/(2*pi*tau) of Q [Hz]")
    A: Annotated[Quantity | None, "rate"] = Field(
        None, description="damping of the nominal plant [1/s]; the plant's where left out"
    )
    B: Annotated[Quantity | None, "acceleration per input"] = Field(
        None, description="gain of the nominal plant; the plant's where left out"
    )

    def observer(self, motion: Motion, A: float, B: float) -> DisturbanceObserver:
        """Return the observer in SI; A and B are those of the plant, taken where the file gives none.

        Raises FricError: When there is no such filter, or its cutoff is not positive.
        """
        values = self.values(motion)
        q = QFilter(self.filter, values.pop("cutoff"))
        return DisturbanceObserver(q, **{"A": A, "B": B, **values})


class LimitPart(Part):
    """How far Q may reach by one rule; without a cutoff where that rule allows no Q at all."""

    cutoff: Quantity | None = None
    bandwidth: Quantity | None = None
    frequency: Quantity | None = Field(None, description="where the rule binds")
    Delta: Quantity | None = Field(None, description="size of the perturbation there")
    peak_sensitivity: Quantity | None = None


class ObserverDocument(AxisDocument, ObserverPart):
    """An observer file: the filter Q of one axis, and the limit and margins it was designed for."""

    type: ClassVar[str] = "observer"

    bandwidth: Quantity | None = Field(None, description="where |Q| has fallen by 3 dB [Hz]; follows from the cutoff")
    reason: str = Field("", description="why the cutoff is as it is")
    limits: dict[Literal["robust", "sensitive"], LimitPart] = Field(
        default_factory=dict, description="limits of Q by eq. (8) and by peak sensitivity"
    )
    margins: dict[str, MarginsPart] = Field(
        default_factory=dict, description="margins of the whole loop, at the plant's input"
    )


def observer_tree(
    design: ObserverDesign,
    axis: str,
    motion: Motion,
    logs: Sequence[Record] = (),
    notices: Iterable[Notice] = (),
) -> dict[str, Any]:
    """Return an observer with its limits and margins as an observer document."""
    observer, robust = design.observer, design.robust
    limits: dict[str, Any] = {"robust": {}, "sensitive": {"peak_sensitivity": _decibel(design.peak_sensitivity)}}
    for name, q in (("robust", robust.q), ("sensitive", design.sensitive)):
        if q is not None:
            limits[name] |= {"cutoff": Estimate(q.cutoff, "Hz"), "bandwidth": Estimate(q.bandwidth, "Hz")}
    if robust.q is not None:
        limits["robust"] |= {"frequency": Estimate(robust.frequency, "Hz"), "Delta": Estimate(robust.size, "1")}
    content = {
        "axis": axis,
        "motion": motion,
        "filter": observer.q.name,
        "cutoff": Estimate(observer.q.cutoff, "Hz", assumed=design.assumed),
        "bandwidth": Estimate(observer.q.bandwidth, "Hz", assumed=design.assumed),
        "A": Estimate(observer.A, si_unit("rate", motion)),
        "B": Estimate(observer.B, si_unit("acceleration per input", motion)),
        "reason": design.reason,
        "limits": limits,
        "margins": {name: loop.margins.as_dict() for name, loop in design.loops().items()},
    }
    return ObserverDocument.made(content, notices=[*notices, *design.warnings], logs=logs).tree()


def _decibel(ratio: float) -> Estimate:
    return Estimate(20 * log10(ratio), "dB")
