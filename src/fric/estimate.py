"""A number in results: value, unit and 95 % interval."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from math import exp, floor, hypot, inf, isinf, log, log10
from typing import Any, Literal, Self, TypeVar

from fric.errors import FricError
from fric.units import prefixed, significant
from fric.verb import WORDS, is_number, refused, require_numbers

STAYS = {"leaves": False}  # Metadata of a dataclass's field that documents leave out

NORMAL_97_5 = 1.959963984540054  # The 97.5 % quantile of the standard normal distribution
TWOFOLD = log(2.0) / NORMAL_97_5  # Standard deviation of the logarithm of a shape factor that a fit supposes
GAIN = 1e15  # Magnitude in SI that no parameter of a drive reaches: beyond it loops overflow, and limits say nothing
LEAST = 1e-30  # Magnitude in SI below which no quantity of a machine is, but 0: sums of squares of it underflow
OPEN = 14.0  # Half-width of an interval of a logarithm that is no limit: a factor of a million to either side
Value = float | tuple[float, ...]
Interval = tuple[float, float]
T = TypeVar("T")


@dataclass(frozen=True)
class Estimate:
    """An identified or given value in SI units, with its 95 % interval, if any.

    value: The value, or one value per slip block.
    unit: SI unit as written in files (``N``, ``m/s``, ``N*s/m``, ``1``).
    ci95: 95 % interval ``(low, high)``; for a vector one per element. An infinite limit, written as null, is not
        determined by the data. None where the value was not identified.
    fixed: True where the value was set by the user and not fitted.
    assumed: True where the data do not determine the value and a default was taken.
    source: Where a value given by hand comes from.
    Raises FricError: Where the value is no number, or the interval does not fit it.
    """

    value: Value
    unit: str
    ci95: Interval | tuple[Interval, ...] | None = None
    fixed: bool = False
    assumed: bool = False
    source: str = ""

    def __post_init__(self) -> None:
        values = self.value if isinstance(self.value, tuple) else None
        object.__setattr__(self, "ci95", _closed(self.ci95))
        require_numbers(self, ("value",), () if values is None else ("value",))
        for name, kind in (("unit", str), ("source", str), ("fixed", bool), ("assumed", bool)):
            if not isinstance(getattr(self, name), kind):
                raise refused("Estimate", f"{name} as {WORDS[kind]}", getattr(self, name))
        pairs: Any = (self.ci95,) if values is None else self.ci95
        if self.ci95 is not None and [*map(_is_interval, pairs)] != [True] * len((0.0,) if values is None else values):
            raise FricError("ci95 does not fit the value", hint="Give [low, high], low first, one such pair per value.")

    @classmethod
    def around(cls, value: float, unit: str, half_width: float, *, source: str = "") -> Self:
        """Return a value with a 95 % interval of the same half-width, without its sign, to either side."""
        return cls(value, unit, (value - abs(half_width), value + abs(half_width)), source=source)

    @classmethod
    def around_log(cls, value: float, unit: str, half_width: float) -> Self:
        """Return a value with a 95 % interval that is symmetric in the logarithm of its size."""
        factor = exp(half_width) if half_width < OPEN else inf
        low, high = sorted((value / factor, value * factor))
        return cls(value, unit, (low, high))

    @property
    def limits(self) -> Interval:
        """Ends of the 95 % interval of a number; infinite without an interval."""
        low, high = self.ci95 or (-inf, inf)
        return float(low), float(high)  # type: ignore[arg-type]

    @property
    def half_width(self) -> float:
        """Half the width of the 95 % interval of a number; 0 without an interval."""
        low, high = self.limits if self.ci95 else (0.0, 0.0)
        return 0.5 * (high - low)

    @property
    def note(self) -> str:
        """Whether it was fixed or assumed, in words."""
        return ", ".join(flag for flag in ("fixed", "assumed") if getattr(self, flag))

    def __str__(self) -> str:
        rows = [row[1:4] for row in estimate_rows({"": self})]
        return "; ".join(f"{value} {unit} ({limits})" if limits else f"{value} {unit}" for value, limits, unit in rows)

    def __float__(self) -> float:
        if isinstance(self.value, tuple):
            hint = "Give one number with its unit."
            raise FricError(f"a list of {len(self.value)} where one value is expected", hint=hint)
        return float(self.value)

    @classmethod
    def read(cls, entry: Mapping[str, Any]) -> Self:
        """Return the estimate of a mapping made by `as_dict`."""
        get: Any = entry.get
        value = tuple(get("value")) if isinstance(get("value"), list) else get("value")
        return cls(value, get("unit"), get("ci95"), get("fixed", False), get("assumed", False))

    def as_dict(self) -> dict[str, Any]:
        """Return the mapping for a YAML or JSON document, without unset fields."""
        entry: dict[str, Any] = {"value": self.value, "unit": self.unit}
        if self.ci95 is not None:
            entry["ci95"] = _open_ended(self.ci95)
        entry |= {flag: True for flag in ("fixed", "assumed") if getattr(self, flag)}
        if self.source:
            entry["source"] = self.source
        return entry


def as_filed(value: T) -> T:
    """Return numbers as a file of fric holds them, with six digits; also those in lists, mappings and dataclasses.

    Simulations start from these, with or without a file between: the last bits of a fit depend on the processor, and
    decide in a closed loop on which side of an encoder count a position falls.
    """
    found: Any = value
    if isinstance(value, float):
        found = float(f"{value:.6g}")
    elif isinstance(value, tuple | list):
        found = (list if isinstance(value, list) else tuple)(map(as_filed, value))
    elif isinstance(value, Mapping):
        found = {key: as_filed(item) for key, item in value.items()}
    elif is_dataclass(value) and not isinstance(value, type):
        found = replace(value, **{f.name: as_filed(getattr(value, f.name)) for f in fields(value) if f.init})
    return found


Scale = Literal["linear", "log", "logit"]  # Of a covariance: the value, its logarithm, or ``log(p/(1 - p))`` of a share


@dataclass(frozen=True)
class Covariance:
    """Covariance of parameters that were identified together.

    names: The parameters; ``k_2`` belongs to the second block.
    scales: The scale of the covariance, by parameter.
    matrix: The covariance, rows in the order of the names, in SI.
    """

    names: tuple[str, ...]
    scales: tuple[Scale, ...]
    matrix: tuple[tuple[float, ...], ...]

    @classmethod
    def of(cls, names: Iterable[str], matrix: Iterable[Iterable[float]], scale: Scale | Sequence[Scale]) -> Self:
        """Return a covariance, with a common or each parameter's scale, without those whose interval is open."""
        names, rows = tuple(names), [tuple(map(float, row)) for row in matrix]
        scales = (scale,) * len(names) if isinstance(scale, str) else tuple(scale)
        kept = [n for n, scale in enumerate(scales) if scale == "linear" or not 4.0 * rows[n][n] > OPEN**2]
        return cls(
            tuple(names[n] for n in kept), tuple(scales[n] for n in kept),
            tuple(tuple(rows[n][m] for m in kept) for n in kept),
        )  # fmt: skip


def _is_interval(given: Any) -> bool:
    """Return whether it is a pair of limits, of which the lower is not above the upper."""
    if not (isinstance(given, tuple) and len(given) == 2):
        return False
    numbers = [limit for limit in given if limit is not None]
    return all(map(is_number, numbers)) and not (len(numbers) == 2 and numbers[0] > numbers[1])


def _closed(limits: Any) -> Any:
    """Return the limits with infinity for null, and for what no parameter of a drive reaches; turned ones stay so."""
    if isinstance(limits, list | tuple) and len(limits) == 2 and all(x is None or is_number(x) for x in limits):
        if None not in limits and limits[0] > limits[1]:
            return tuple(limits)
        return tuple(end if x is None or abs(x) > GAIN else x for x, end in zip(limits, (-inf, inf), strict=True))
    return tuple(map(_closed, limits)) if isinstance(limits, list | tuple) else limits


def _open_ended(limits: Any) -> Any:
    """Return the limits with null for infinity, which JSON cannot hold."""
    return [_open_ended(limit) for limit in limits] if isinstance(limits, tuple) else None if isinf(limits) else limits


def estimate_rows(section: Mapping[str, Estimate | Mapping[str, Any]]) -> list[tuple[str, str, str, str]]:
    """Return estimates, or the parameters of a document's section, as rows for people: name, value, interval, unit.

    Value and interval have the same unit, with the prefix that suits the larger of them, and as many digits as the
    interval justifies. A vector has one row an element, all in one unit.
    """
    rows = []
    for name, entry in (dict(section) | moving_mass(section)).items():
        parts = [*elements({name: entry})]
        size = max((_size(float(estimate), estimate.ci95) for _, estimate in parts), default=0.0)
        for key, estimate in parts:
            scale, unit = prefixed(size, estimate.unit)
            shown, text = in_digits(float(estimate), estimate.ci95, scale)
            rows.append((key, shown, ", ".join(filter(None, (text, estimate.note))), unit))
    return rows


def moving_mass(section: Mapping[str, Estimate | Mapping[str, Any]]) -> dict[str, Estimate]:
    """Return what an axis moves, K_f/B, where both were identified and K_f is in newtons: what a drawing says, too.

    The errors of the two are taken as independent.
    """
    known = dict(elements({name: section[name] for name in ("K_f", "B") if name in section}))
    seen = [entry for entry in known.values() if entry.half_width and float(entry) > 0.0]
    turns = len(seen) == 2 and known["B"].unit.startswith("rad")
    if len(seen) < 2 or not known["K_f"].unit.startswith("N*m/" if turns else "N/"):  # a torque moves a slide by a lead
        return {}
    mass = float(known["K_f"]) / float(known["B"])
    width = mass * hypot(*(entry.half_width / float(entry) for entry in seen))
    return {"K_f/B": Estimate(mass, "kg·m²" if turns else "kg", (mass - width, mass + width) if width < inf else None)}


def elements(section: Mapping[str, Estimate | Mapping[str, Any]]) -> Iterator[tuple[str, Estimate]]:
    """Yield name and estimate of each parameter, or of a document's section; of a vector each element's."""
    for name, entry in section.items():
        found = entry if isinstance(entry, Estimate) else Estimate.read(entry)
        if not isinstance(found.value, tuple):
            yield name, found
            continue
        intervals: Any = found.ci95 or (None,) * len(found.value)
        for n, (value, interval) in enumerate(zip(found.value, intervals, strict=True), start=1):
            yield f"{name}_{n}", replace(found, value=value, ci95=interval)


DIGITS = 8  # Largest number of digits of a value


def _size(value: float, interval: Any) -> float:
    """Return the size that sets the prefix of a value and its interval: the value, or a tenth of a far limit.

    Of an interval that holds both signs, the far limit.
    """
    far = max((abs(limit) for limit in interval or () if not isinf(limit)), default=0.0)
    if interval and min(interval) < 0.0 < max(interval):
        return far or abs(value)
    return abs(value) if far < 300.0 * abs(value) else 0.1 * far


def in_digits(value: float, interval: Any, scale: float = 1.0) -> tuple[str, str]:
    """Return a value and its interval as text, to two digits of the interval's width; an infinite limit is open."""
    limits = [limit for limit in interval or () if not isinf(limit)]
    width = scale * (max(limits) - min(limits)) if len(limits) == 2 else 0.0
    if not width > 0:
        text = " … ".join("open" if limit not in limits else significant(limit * scale, 4) for limit in interval or ())
        return significant(value * scale, 4), text
    whole = floor(log10(max(map(abs, limits)) * scale)) if any(limits) else 0
    decimals = min(max(0, 1 - floor(log10(width))), max(0, DIGITS - 1 - whole), 9)
    return f"{value * scale:.{decimals}f}", " … ".join(f"{limit * scale:.{decimals}f}" for limit in limits)
