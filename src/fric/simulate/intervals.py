"""Drawing what is true from what was identified: estimates with their 95 % intervals, which err together."""

from collections.abc import Callable, Container, Iterable, Mapping
from math import exp, inf, log
from typing import Any

import numpy as np

from fric.estimate import Covariance, Estimate
from fric.friction import FrictionModel, Parameter
from fric.friction.directed import Directed

Intervals = Mapping[str, tuple[float, float]]
"""95 % intervals by parameter; ``negative.F_c`` is of the negative direction, ``k_2`` of the second block."""

NORMAL_97_5 = 1.959963984540054
"""The 97.5 % quantile of the standard normal distribution."""


def normals(
    covariances: Iterable[Covariance], drawn: Container[str], normal: Callable[[str], float]
) -> dict[str, float]:
    """Return a standard normal number for each parameter that a covariance tells of, correlated as that tells.

    covariances: How parameters err together, block by block.
    drawn: Parameters that are drawn from their intervals; the others of a block are passed over.
    normal: Gives an independent standard normal number for a name: the numbers do not depend on the order of the names.
    """
    found: dict[str, float] = {}
    for block in covariances:
        kept = [n for n, name in enumerate(block.names) if name in drawn and block.matrix[n][n] > 0]
        matrix = np.array(block.matrix)[np.ix_(kept, kept)]
        size = np.sqrt(np.diag(matrix))
        values, vectors = np.linalg.eigh(matrix / np.outer(size, size))
        root = (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T  # of all roots, the one without an order
        mixed = root @ [normal(block.names[n]) for n in kept]
        found |= {block.names[n]: float(z) for n, z in zip(kept, mixed, strict=True)}
    return found


def draw_within(value: float, interval: tuple[float, float], lower: float, normal: float) -> float:
    """Draw a value whose median is the estimate and whose 2.5 and 97.5 % quantiles are the interval's limits.

    Half a normal distribution stands on either side of the estimate, each as wide as its side of the interval says:
    an interval need not be symmetric. A parameter that is positive by its nature, and whose interval is, is drawn so
    in its logarithm; of one whose interval passes its bound, what lies beyond is put on the bound.

    value: The estimate.
    interval: Its 95 % interval, both limits finite, around the value.
    lower: The parameter's lower bound; 0 where it is positive by its nature.
    normal: A standard normal number; correlated with those of other parameters where they err together (`normals`).
    """
    low, high = interval
    z = normal / NORMAL_97_5
    if lower > -inf and low > 0:
        return value * exp(z * (log(high / value) if z > 0 else log(value / low)))
    return max(value + z * (high - value if z > 0 else value - low), lower)


def declared_parameters(model: FrictionModel) -> list[Parameter]:
    """Return the parameters of a model and of those that it builds upon, without those of its static map."""
    classes = [vars(base) for base in reversed(type(model).__mro__)]
    return [parameter for own in classes for parameter in own.get("parameters", ()) if hasattr(model, parameter.name)]


def friction_intervals(
    model: FrictionModel, sections: Mapping[str, Mapping[str, Estimate]]
) -> tuple[dict[str, tuple[float, float]], list[str]]:
    """Return the intervals of a friction model's parameters, and the names of those that cannot be drawn from.

    model: The model that the sections give.
    sections: The sections of a friction file.
    """
    found: dict[str, tuple[float, float]] = {}
    refused: list[str] = []
    one = model.model if isinstance(model, Directed) else model
    parts = (("", one), ("", getattr(one, "static", None)), ("negative.", getattr(model, "negative", None)))
    for prefix, part in parts:
        if part is None:
            continue
        own = [vars(base)["name"] for base in type(part).__mro__ if "name" in vars(base)]
        names = ["static_negative"] if prefix else own
        for parameter in declared_parameters(part):
            given = (sections[name].get(parameter.name) for name in names if name in sections)
            estimate = next((one for one in given if one is not None), None)
            if estimate is not None:
                closed, open_ended = closed_intervals(prefix + parameter.name, estimate)
                found |= closed
                refused += open_ended
    return found, refused


def closed_intervals(name: str, estimate: Estimate) -> tuple[dict[str, tuple[float, float]], list[str]]:
    """Return an estimate's intervals by name, one per element of a vector, and the names of those that are open.

    An interval that does not hold its value is none to draw from either.
    """
    if estimate.ci95 is None:
        return {}, []
    vector = isinstance(estimate.value, tuple)
    values: Any = estimate.value if vector else (estimate.value,)
    limits: Any = estimate.ci95 if vector else (estimate.ci95,)
    found, refused = {}, []
    for n, (value, (low, high)) in enumerate(zip(values, limits, strict=True), 1):
        own = f"{name}_{n}" if vector else name
        if -inf < low <= value <= high < inf:
            found[own] = (low, high)
        else:
            refused.append(own)
    return found, refused
