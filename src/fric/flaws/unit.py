"""Units: what no drive can be, by physics, is most often a unit that was taken for another.

Each bound is generous: from a micro-tribometer (µN, or rad) to an axis of 10 t nothing real comes near it.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from fric.flaws.base import Flaw

Limits = tuple[float, float]
LIFT = "`with fric.lifted():`"  # How a user accepts a value beyond the bound


@dataclass(frozen=True)
class Bound:
    """The range in which a quantity of every real drive lies."""

    what: str  # The quantity, in words
    dimension: str  # Its dimension, see `fric.units`
    linear: Limits  # Least and greatest value of a linear axis in SI
    rotary: Limits  # The same of a rotary axis
    reason: str  # Why nothing real is beyond
    units: str  # What to check


BOUNDS: Mapping[str, Bound] = {
    name: Bound(**row | {kind: tuple(row[kind]) for kind in ("linear", "rotary")})
    for name, row in tomllib.loads(Path(__file__).with_name("bounds.toml").read_text("utf-8")).items()
}

IMPLAUSIBLE: Mapping[str, Flaw] = {  # Their mend is of the error: a warning has another, or none
    name: Flaw(
        f"implausible-{name}", "wrong", f"{bound.what} is {{value}}: {bound.reason}.",
        f"Look at the units of {bound.units}; where it is so, say {LIFT}.",
    )
    for name, bound in BOUNDS.items()
}  # fmt: skip
UNUSUAL: Mapping[str, Flaw] = {
    name: Flaw(
        f"unusual-{name}", "doubt", f"{BOUNDS[name].what} is {{value}}, and few machines are below {{usual}}.",
        f"Is the unit of {BOUNDS[name].units} right? If it is, lift the bound by {LIFT}.",
    )
    for name in ("friction", "speed", "sampling")
}  # fmt: skip
