"""How files give the lead of a feedforward: ``auto``, or a time as in ``"0.6 ms"``."""

from typing import Literal

from fric.control.scheme import Lead
from fric.documents.quantity import Quantity
from fric.errors import FricError

LeadGiven = Quantity | Literal["auto"] | None


def lead_of(given: LeadGiven) -> Lead | None:
    """Return a lead in seconds, or ``auto``; None where none is given.

    Raises
    ------
    FricError
        When it is no time, or negative.
    """
    if given is None or given == "auto":
        return given
    lead = float(given.si("time", "linear"))
    if lead < 0.0:
        raise FricError(f"the lead of the feedforward is {lead:g} s", hint="Give 0 or more, or auto.")
    return lead
