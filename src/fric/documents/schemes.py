"""The schemes file, ``fric: schemes/1``; and how files give a lead: ``auto``, or a time as in ``"0.6 ms"``."""

from pathlib import Path
from typing import Literal, Self

from pydantic import model_validator

from fric.control.scheme import Lead, Scheme
from fric.documents.base import Document, Part, Quantity
from fric.documents.fields import refused, said
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.units import LARGEST_PEAK, parse_gain
from fric.verb import verb

LeadGiven = Quantity | Literal["auto"] | None


def lead_of(given: LeadGiven) -> Lead | None:
    """Return a lead in seconds, or ``auto``; None if not given."""
    return given if given is None or given == "auto" else float(given.si("time", "linear"))


class SchemePart(Part):
    """A compensation scheme: the friction that is fed forward, the controller, and further control blocks."""

    title: str = ""
    friction: str | None = said("friction model to feed forward: static, gms, …; none if left out")
    observer: bool = said("true where the axis' disturbance observer is on", False)
    gain: float | None = said("gain of the feedforward; the machine's where left out")
    lead: LeadGiven = said("lead of the feedforward; the machine's where left out")
    controller: str = said("the control block in place of the cascade", "cascade")
    peak_sensitivity: Quantity | None = said(
        "largest M_s of blocks without a value in their files, in dB; 6 dB if left out"
    )
    joint: bool = said("true where the cascade's gains are designed together with the block that feeds back", False)
    blocks: list[str] = said("further control blocks: observers, feedforward", list)

    @model_validator(mode="after")
    def _blocks_fit(self) -> Self:
        with refused():
            self.scheme("new")
        return self

    def scheme(self, name: str) -> Scheme:
        """Return the scheme."""
        return Scheme.of({"name": name, **self.model_dump(), "lead": lead_of(self.lead), **self._peak()})

    def _peak(self) -> dict[str, float]:
        if self.peak_sensitivity is None:
            return {}
        given, unit = self.peak_sensitivity.value, self.peak_sensitivity.unit
        if isinstance(given, list) or unit not in {"dB", "1"}:
            raise FricError("peak_sensitivity is not a gain", hint="Write it as '6 dB'.")
        return {"peak_sensitivity": parse_gain(f"{given} dB" if unit == "dB" else given, 1.0, LARGEST_PEAK)}


class SchemesDocument(Document, type="schemes"):
    """A schemes file: compensation schemes by name."""

    schemes: dict[str, SchemePart]


@verb
def read_schemes(path: Path | str) -> dict[str, Scheme]:
    """Read compensation schemes by name from a schemes file."""
    return {name: part.scheme(name) for name, part in read_document(path, SchemesDocument).schemes.items()}
