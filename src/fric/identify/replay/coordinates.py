"""From the parameters that a model declares to the coordinates that a fit searches in, and back.

A fit knows no model: it needs only `fric.friction.base.Parameter`. A stiffness, a force or a velocity is
searched in its logarithm, a viscous coefficient linearly from zero, shares by the logarithms of their ratios, and a
parameter that is never below another by the logarithm of their ratio. The records set the range of the search.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import exp, isfinite, isnan, log
from typing import Literal

import numpy as np

from fric.arrays import Real
from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction import FrictionModel
from fric.friction.base import Parameter
from fric.friction.directed import Directed, directed
from fric.friction.stribeck import StaticMap
from fric.records.judgement import identifiability_of
from fric.records.prepared import Prepared
from fric.records.resolution import noise_level

Ranges = Mapping[str, tuple[float, float]]
"""Least and largest value in SI that the records can show, by dimension (see `fric.units`)."""

Scale = Literal["log", "linear", "ratio", "share"]

LEVEL = Parameter("level", "ratio", doc="friction level of the records relative to the static map", typical=1.0)
"""Scale of F_c and F_s of a fixed static map, if each record has a level of friction."""


@dataclass(frozen=True)
class Coordinate:
    """A direction of the search."""

    section: str  # section, parameter: the section of a friction file, and the parameter in it
    parameter: Parameter
    block: int | None  # Number of the block, from 0; None for a parameter that is one number
    # How it is searched: ``log``; ``linear``; ``ratio``, the logarithm of its ratio to `Parameter.at_least`; ``share``,
    # the logarithm of its ratio to the last block's share
    scale: Scale
    lower: float  # lower, upper: bounds of the coordinate
    upper: float

    @property
    def label(self) -> str:
        """Name for messages, as ``sigma_0`` or ``k_2``."""
        return self.parameter.name if self.block is None else f"{self.parameter.name}_{self.block + 1}"


@dataclass(frozen=True)
class Coordinates:
    """The free coordinates of a model, and its fixed values."""

    model: type[FrictionModel]  # The model
    free: tuple[Coordinate, ...]  # What is searched
    # Values in SI of the parameters that are not searched, by section and name; nan for a parameter equal to its lower
    # bound, another parameter
    held: Mapping[tuple[str, str], float]
    blocks: int  # Number of blocks of a model that has any
    negative: StaticMap | None = None  # Static map of the negative direction, where each direction has a map

    @classmethod
    def of(
        cls,
        model: type[FrictionModel],
        ranges: Ranges,
        *,
        blocks: int,
        held: Mapping[tuple[str, str], float],
        level: bool = False,
        negative: StaticMap | None = None,
    ) -> Coordinates:
        """Return the coordinates of a model with all parameters free that are not fixed, and the level if requested.

        Raises FricError: When no parameter is left to fit.
        """
        free: list[Coordinate] = []
        for section, parameters in model.declared().items():
            for p in parameters:
                if (section, p.name) in held:
                    continue
                scale, lower, upper = _searched(p, ranges)
                numbers: list[int | None] = [None] if not p.per_block else list(range(blocks - p.shares))
                free += [Coordinate(section, p, n, scale, lower, upper) for n in numbers]
        if level:
            free.append(Coordinate("static", LEVEL, None, "log", -log(5.0), log(5.0)))
        if not free:
            raise FricError(f"every parameter of {model.name} is given, and none is left to fit")
        return cls(model, tuple(free), dict(held), blocks, negative)

    @property
    def lower(self) -> Real:
        """Lower bounds, shape (p,)."""
        return np.array([c.lower for c in self.free])

    @property
    def upper(self) -> Real:
        """Upper bounds, shape (p,)."""
        return np.array([c.upper for c in self.free])

    def without(self, index: int, value: float) -> Coordinates:
        """Return the coordinates with the coordinate of a scalar parameter held at a value in SI."""
        c = self.free[index]
        held = {**self.held, (c.section, c.parameter.name): value}
        return replace(self, free=(*self.free[:index], *self.free[index + 1 :]), held=held)

    def values(self, x: Real) -> dict[str, dict[str, float | tuple[float, ...]]]:
        """Return all parameters in SI, by section and name, at a point of the search, shape (p,)."""
        given: dict[tuple[str, str], list[float]] = {}
        for c, at in zip(self.free, x, strict=True):
            given.setdefault((c.section, c.parameter.name), []).append(float(at))
        found: dict[str, dict[str, float | tuple[float, ...]]] = {}
        for section, parameters in self.model.declared().items():
            found[section] = {}
            for p in parameters:
                if (section, p.name) not in given:
                    if (section, p.name) in self.held:
                        value = self.held[section, p.name]
                        found[section][p.name] = found[section][p.at_least] if isnan(value) else value
                    elif p.shares:  # the share of a single block
                        found[section][p.name] = (1.0,)
                    continue
                at_all = given[section, p.name]
                scale = next(c.scale for c in self.free if (c.section, c.parameter.name) == (section, p.name))
                if scale == "share":
                    ratio = np.exp([*at_all, 0.0])
                    found[section][p.name] = tuple(float(r) for r in ratio / ratio.sum())
                    continue
                base = found[section].get(p.at_least, 1.0) if p.at_least else 1.0
                assert isinstance(base, float)
                out = [min(max(at if scale == "linear" else base * exp(at), p.lower), p.upper) for at in at_all]
                found[section][p.name] = tuple(out) if p.per_block else out[0]
        if ("static", LEVEL.name) in given:
            level = exp(given["static", LEVEL.name][0])
            found["static"] |= {name: level * found["static"][name] for name in ("F_c", "F_s")}  # type: ignore[operator]
            found["static"][LEVEL.name] = level
        return found

    def build(self, x: Real) -> FrictionModel:
        """Return the model at a point of the search."""
        found = self.values(x)
        sections = {s: {name: Estimate(value, "") for name, value in values.items()} for s, values in found.items()}
        return self.on_guideway(self.model.from_sections(sections), found)

    def on_guideway(self, model: FrictionModel, values: Mapping[str, Mapping[str, object]]) -> FrictionModel:
        """Return a model with the map of the negative direction, at the level of the records."""
        if self.negative is None or "static" not in values:  # a model with a fixed force has no map
            return model
        level = values["static"].get(LEVEL.name, 1.0)
        assert isinstance(level, float)
        forces = {name: level * getattr(self.negative, name) for name in ("F_c", "F_s")}
        return directed(model, replace(self.negative, **forces))

    def spread_start(self, y: Real) -> Real:
        """Return the point of a coarse search: blocks as a geometric row between two numbers.

        y: One number a scalar parameter and two a vector, each from 0 to 1 between the bounds, shape (`coarse`,).
        """
        x, take = np.empty(len(self.free)), iter(y)
        done: dict[tuple[str, str], Real] = {}
        for n, c in enumerate(self.free):
            key = c.section, c.parameter.name
            if c.block is None:
                share = next(take)
            else:
                if key not in done:
                    count = self.blocks - c.parameter.shares
                    first, last = next(take), next(take)
                    done[key] = np.linspace(first, last, count) if count > 1 else np.array([first])
                share = done[key][c.block]
            x[n] = c.lower + share * (c.upper - c.lower)
        return x

    @property
    def coarse(self) -> int:
        """Number of arguments of `spread_start`."""
        vectors = {(c.section, c.parameter.name) for c in self.free if c.block is not None}
        return sum(c.block is None for c in self.free) + 2 * len(vectors)


def coordinates_of(coordinates: Coordinates, model: FrictionModel) -> Real:
    """Return the point of the search that corresponds to a model."""
    model = model.model if isinstance(model, Directed) else model
    x = np.empty(len(coordinates.free))
    for n, c in enumerate(coordinates.free):
        owner = model if c.section == model.name else getattr(model, c.section)
        if c.parameter is LEVEL:
            x[n] = np.log(getattr(owner, "F_s") / coordinates.held["static", "F_s"])  # noqa: B009
            continue
        value = getattr(owner, c.parameter.name)
        if c.scale == "share":
            x[n] = np.log(value[c.block] / value[-1])
            continue
        value = value if c.block is None else value[c.block]
        base = getattr(owner, c.parameter.at_least) if c.parameter.at_least else 1.0
        x[n] = value if c.scale == "linear" else np.log(value / base)
    return np.asarray(np.clip(x, coordinates.lower, coordinates.upper))


def _searched(p: Parameter, ranges: Ranges) -> tuple[Scale, float, float]:
    """Return the scale of a parameter's coordinate and its bounds."""
    if p.shares:
        return "share", -log(1e3), log(1e3)
    if p.at_least:
        return "ratio", 0.0, log(5.0)
    low, high = ranges.get(p.dimension, (p.lower, p.upper))
    if not (isfinite(low) and isfinite(high)):
        size = abs(float(np.max(p.typical)))
        low, high = 1e-3 * size, 1e3 * size
    low, high = max(low, p.lower), min(high, p.upper)
    if not low < high:
        low, high = p.lower, p.upper
    if p.dimension == "viscous" or low <= 0.0 or high / low < 10.0:
        return "linear", low if p.dimension != "viscous" else max(p.lower, 0.0), high
    return "log", log(low), log(high)


def search_ranges(records: Sequence[Prepared]) -> Ranges:
    """Return the range in which the records can show a parameter, by dimension.

    Forces reach up to twice the logged force (if no branch slides, from the largest logged to twenty times that),
    velocities up to three times the fastest, lengths from the encoder's step or noise (but at least 1e-4 of the stroke)
    to the stroke, and other dimensions follow.
    """
    force = max(float(np.quantile(np.abs(r.force[r.used] - np.median(r.force[r.used])), 0.99)) for r in records)
    speeds = np.concatenate([np.abs(r.motion.velocity[r.used]) for r in records])
    fastest = float(np.quantile(speeds, 0.99))
    strokes = [float(np.ptp(r.motion.position)) for r in records]
    stroke = max(strokes)
    grain = [
        max(r.motion.step, 4.0 * noise_level(r.log.position)) if r.log.position is not None else 0.0 for r in records
    ]
    seen = identifiability_of(records)
    finest = min(max(g, 1e-4 * s) for g, s in zip(grain, strokes, strict=True))
    duration = max(float(r.motion.time[-1] - r.motion.time[0]) for r in records)
    dt = min(float(np.median(np.diff(r.motion.time))) for r in records)
    if not (force > 0 and fastest > 0):
        raise FricError("the records hold no force or no motion", where=records[0].log.where)
    return {
        "force": (0.01 * force, 2.0 * force) if seen.slides else (seen.peak, 20.0 * force),
        "velocity": (1e-4 * fastest, 3.0 * fastest),
        "viscous": (0.0, 100.0 * force / fastest),
        "position": (finest, stroke),
        "stiffness": (0.1 * force / stroke, 2.0 * force / finest),
        "force rate": (force / duration, force / dt),
        "rate": (1.0 / duration, 1.0 / dt),
        "frequency": (1.0 / duration, 0.5 / dt),
        "time": (dt, duration),
    }
