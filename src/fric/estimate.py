"""A number that leaves fric: its unit, and how sure it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

Value = float | tuple[float, ...]
Interval = tuple[float, float]


@dataclass(frozen=True)
class Estimate:
    """An identified or given value in SI units, with its 95 % interval where there is one.

    Parameters
    ----------
    value
        The value, or one value per slip block.
    unit
        SI unit as written in files (``N``, ``m/s``, ``N*s/m``, ``1``).
    ci95
        95 % interval ``(low, high)``; for a vector one per element. None where it was not identified.
    fixed
        True where the value was set by the user and not fitted.
    assumed
        True where the data could not tell the value and a default was taken.
    source
        Where a value given by hand comes from.
    """

    value: Value
    unit: str
    ci95: Interval | tuple[Interval, ...] | None = None
    fixed: bool = False
    assumed: bool = False
    source: str = ""

    def __float__(self) -> float:
        if isinstance(self.value, tuple):
            raise TypeError(f"{len(self.value)} values in {self.unit} are not one number")
        return float(self.value)

    def as_dict(self) -> dict[str, Any]:
        """Return the mapping that stands in a YAML or JSON document; what is unset is left out."""
        entry: dict[str, Any] = {"value": self.value, "unit": self.unit}
        if self.ci95 is not None:
            entry["ci95"] = self.ci95
        entry |= {flag: True for flag in ("fixed", "assumed") if getattr(self, flag)}
        if self.source:
            entry["source"] = self.source
        return entry
