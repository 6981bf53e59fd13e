"""How files give the lead of a feedforward: ``auto``, or a time as in ``"0.6 ms"``."""

from typing import Literal

from fric.control.scheme import Lead
from fric.documents.quantity import Quantity

LeadGiven = Quantity | Literal["auto"] | None


def lead_of(given: LeadGiven) -> Lead | None:
    """Return a lead in seconds, or ``auto``; None where none is given."""
    return given if given is None or given == "auto" else float(given.si("time", "linear"))
