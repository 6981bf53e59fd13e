"""Identified numbers of a document as groups of rows: symbol, plain name, value, unit, interval, and how they err."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from fric.documents.friction import FrictionDocument
from fric.documents.plant import PlantDocument
from fric.documents.quantity import Quantity
from fric.estimate import Covariance, estimate_rows
from fric.report.report_input import Item
from fric.results.names import plain_names
from fric.units import readable, significant

TITLES = {
    "static": "static map, eq. (2)",
    "static_negative": "static map of the negative direction",
    "at_speed": "friction at one speed",
    "gms": "GMS model, eqs. (3) to (5)",
    "plant": "plant, eq. (1)",
    "controller": "controller",
    "observer": "disturbance observer",
    "motion": "rigid axis along the motion: mass and frictions",
}
FIT = (("rmse", "rms of the residual"), ("r2", "R²"), ("points", "points"), ("method", "method"))
MATTERS = 0.9
"""Size of a correlation from which it is told: two numbers of which one can stand in for the other."""


@dataclass(frozen=True)
class Row:
    """One number: symbol, plain name, value, unit, and its interval or what else is known of it."""

    symbol: str
    name: str
    value: str
    unit: str
    interval: str


@dataclass(frozen=True)
class Group:
    """Numbers of one section of a document."""

    title: str
    source: str
    rows: Sequence[Row]
    fit: Sequence[tuple[str, str]]
    correlations: Sequence[str] = ()


def groups_of(item: Item) -> Iterator[Group]:
    """Yield what a document tells: its sections, and the rigid axis that a motion gave."""
    document = item.document
    for section, estimates in item.sections().items():
        fit = document.fit_of(section) if isinstance(document, FrictionDocument) else getattr(document, "fit", None)
        shown = [(title, _fit_value(value)) for key, title in FIT if (value := getattr(fit, key, None)) is not None]
        block = getattr(fit, "covariance", None)
        related = correlations(block.covariance()) if block is not None and section != "plant" else ()
        rows = _rows({name: one.as_dict() for name, one in estimates.items()})
        yield Group(TITLES.get(section, section), item.source, rows, shown, related)
    fit = item.tree.get("fit") or {}
    if isinstance(document, PlantDocument) and fit.get("parameters"):
        words = [("points", str(fit["points"]))] if fit.get("points") else []
        if fit.get("relative_error"):
            words.append(("left of the force", f"{100 * fit['relative_error']['value']:.2f} %"))
        block = document.fit.covariance if document.fit else None
        related = correlations(block.covariance()) if block is not None else ()
        yield Group(TITLES["motion"], item.source, _rows(fit["parameters"]), words, related)


def _rows(entries: Mapping[str, Mapping[str, Any]]) -> list[Row]:
    rows = estimate_rows(entries)
    names = plain_names(row[0] for row in rows)
    return [
        Row(symbol, name, value, unit, interval)
        for (symbol, value, interval, unit), name in zip(rows, names, strict=True)
    ]


def _fit_value(value: Any) -> str:
    if isinstance(value, Quantity):
        return readable(float(value.value), value.unit)  # type: ignore[arg-type]
    return significant(value, 4) if isinstance(value, float) else str(value)


def correlations(covariance: Covariance) -> list[str]:
    """Return the pairs of parameters whose correlation is `MATTERS` or more, the closest first."""
    found = []
    for i, j in combinations(range(len(covariance.names)), 2):
        size = covariance.matrix[i][i] * covariance.matrix[j][j]
        if size > 0 and abs(r := covariance.matrix[i][j] / size**0.5) >= MATTERS:
            found.append((abs(r), f"{covariance.names[i]} and {covariance.names[j]} ({r:+.3f})".replace("-", "−")))
    return [text for _, text in sorted(found, reverse=True)]
