"""A number that leaves fric: its unit, and how sure it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isinf
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
        95 % interval ``(low, high)``; for a vector one per element. An infinite limit is one that the data do not
        set, written as null. None where the value was not identified.
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
            entry["ci95"] = _open_ended(self.ci95)
        entry |= {flag: True for flag in ("fixed", "assumed") if getattr(self, flag)}
        if self.source:
            entry["source"] = self.source
        return entry


def _open_ended(limits: Any) -> Any:
    """Return the limits with null for infinity, which JSON cannot hold."""
    if isinstance(limits, tuple):
        return [_open_ended(limit) for limit in limits]
    return None if isinf(limits) else limits


def estimate_rows(section: Mapping[str, Mapping[str, Any]]) -> list[tuple[str, str, str, str]]:
    """Return the parameters of a document's section as rows for people: name, value, interval, unit."""
    rows = []
    for name, entry in section.items():
        flags = [flag for flag in ("fixed", "assumed") if entry.get(flag)]
        interval = f"{_limits(entry['ci95'])}" if "ci95" in entry else ", ".join(flags)
        rows.append((name, _digits(entry["value"]), interval, str(entry["unit"])))
    return rows


def _digits(value: Any) -> str:
    if value is None:
        return "open"
    return ", ".join(_digits(v) for v in value) if isinstance(value, list | tuple) else f"{value:.4g}"


def _limits(interval: Any) -> str:
    if isinstance(interval[0], list | tuple):
        return "; ".join(_limits(pair) for pair in interval)
    return f"{_digits(interval[0])} … {_digits(interval[1])}"
