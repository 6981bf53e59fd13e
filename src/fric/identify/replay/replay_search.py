"""The search behind a fit by replay: its coordinates, a coarse search over few samples, least squares, the gradient.

A search knows no model: it needs only `fric.friction.base.Parameter`. A stiffness, a force or a velocity is
searched in its logarithm, a viscous coefficient linearly from zero, shares by the logarithms of their ratios, and a
parameter that is never below another by the logarithm of their ratio. The records set the range of the search.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from math import exp, isfinite, isnan, log
from operator import itemgetter
from typing import Literal, Self

import nlopt
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.linalg import block_diag
from scipy.optimize import least_squares, nnls

from fric.arrays import Mask, Real
from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction import FrictionModel
from fric.friction.base import Parameter
from fric.friction.directed import Directed, directed
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.kernels.replay import replay_loads
from fric.process import tried
from fric.records.inspection import identifiability_of
from fric.records.motion import BANDWIDTH
from fric.records.prepared import Prepared
from fric.records.resolution import noise_level
from fric.search import minimised

Ranges = Mapping[str, tuple[float, float]]  # Least and largest value in SI that records can show, by dimension
Scale = Literal["log", "linear", "ratio", "share"]
Key = tuple[str, str]  # Section and name of a parameter
LEVEL = Parameter("ratio", doc="friction level of the records relative to the static map", typical=1.0, name="level")
"""Scale of F_c and F_s of a fixed static map, if each record has a level of friction."""
FEW_A_SWING = 75  # Samples from reversal to reversal below which a motion may change between them
BLOCK_STEP = 1e-4  # Step of the difference quotients, in the logarithm of alpha or k
COARSE = 4_000  # Number of samples in the coarse search
LITTLE, SEARCHES = 0.1, 4  # Share of the force's squares that a search may leave, and the most searches
FAST, RIGID = 0.1, 1.5  # Speed from which friction slides, over the fastest; what a line in speed may leave of it
EVALUATIONS = 150  # Replays of the coarse search, over the number of unknowns plus one
HOP, HOPS = 12, 4  # Least-squares steps after a hop of a block, and hops of each block
GOLDEN = 0.6180339887498949
STEP = 1e-5  # Step of the difference quotients, as a share of the search range


@dataclass(frozen=True)
class Coordinate:
    """A direction of the search."""

    section: str  # section, parameter: the section of a friction file, and the parameter in it
    parameter: Parameter
    block: int | None  # Number of the block, from 0; None for a parameter that is one number
    scale: Scale  # ``log``, ``linear``; ``ratio``: log over `Parameter.at_least`; ``share``: over the last's share
    lower: float  # lower, upper: bounds of the coordinate
    upper: float

    @property
    def key(self) -> Key:
        """Section and name of the parameter."""
        return self.section, self.parameter.name

    @property
    def label(self) -> str:
        """Name for messages, as ``sigma_0`` or ``k_2``."""
        return self.parameter.name if self.block is None else f"{self.parameter.name}_{self.block + 1}"


@dataclass(frozen=True)
class Coordinates:
    """The free coordinates of a model, and its fixed values."""

    model: type[FrictionModel]  # The model
    free: tuple[Coordinate, ...]  # What is searched
    held: Mapping[Key, float]  # Of parameters that are not searched [SI]; nan for one equal to its lower bound, another
    blocks: int  # Number of blocks of a model that has any
    negative: StaticMap | None = None  # Static map of the negative direction, where each direction has a map

    @classmethod
    def of(
        cls, model: type[FrictionModel], ranges: Ranges, *, blocks: int, held: Mapping[Key, float], level: bool = False,
        negative: StaticMap | None = None,
    ) -> Self:  # fmt: skip
        """Return the coordinates of a model with all parameters free that are not fixed, and the level if requested."""
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
            what = f"every parameter of {model.name} is given, and none is left to fit"
            raise FricError(what, hint="Fix fewer of them, or leave out the friction file that gives them.")
        return cls(model, tuple(free), dict(held), blocks, negative)

    @cached_property
    def by_parameter(self) -> dict[Key, list[Coordinate]]:
        """The free coordinates of each parameter, of which a vector has one a block, in the order of `free`."""
        return {key: list(of) for key, of in groupby(self.free, key=lambda c: c.key)}

    @property
    def lower(self) -> Real:
        """Lower bounds, shape (p,)."""
        return np.array([c.lower for c in self.free])

    @property
    def upper(self) -> Real:
        """Upper bounds, shape (p,)."""
        return np.array([c.upper for c in self.free])

    def without(self, index: int, value: float) -> Self:
        """Return the coordinates with the coordinate of a scalar parameter held at a value in SI."""
        held = {**self.held, self.free[index].key: value}
        return replace(self, free=(*self.free[:index], *self.free[index + 1 :]), held=held)

    def values(self, x: Real) -> dict[str, dict[str, float | tuple[float, ...]]]:
        """Return all parameters in SI, by section and name, at a point of the search, shape (p,)."""
        take = iter(x.tolist())
        given = {key: [next(take) for _ in of] for key, of in self.by_parameter.items()}
        found: dict[str, dict[str, float | tuple[float, ...]]] = {}
        for section, parameters in self.model.declared().items():
            found[section] = {}
            for p in parameters:
                key = section, p.name
                if key in self.held:
                    value = self.held[key]
                    found[section][p.name] = found[section][p.at_least] if isnan(value) else value
                elif key not in given:  # the share of a single block
                    found[section][p.name] = (1.0,)
                elif p.shares:
                    ratio = np.exp([*given[key], 0.0])
                    found[section][p.name] = tuple(float(r) for r in ratio / ratio.sum())
                else:
                    base = found[section].get(p.at_least, 1.0) if p.at_least else 1.0
                    assert isinstance(base, float)
                    linear = self.by_parameter[key][0].scale == "linear"
                    out = [min(max(at if linear else base * exp(at), p.lower), p.upper) for at in given[key]]
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
        x, take = list[float](), iter(y)
        for of in self.by_parameter.values():
            shares = [next(take)] if of[0].block is None else np.linspace(next(take), next(take), len(of))
            x += [c.lower + share * (c.upper - c.lower) for c, share in zip(of, shares, strict=True)]
        return np.array(x)

    @property
    def coarse(self) -> int:
        """Number of arguments of `spread_start`."""
        return sum(1 if of[0].block is None else 2 for of in self.by_parameter.values())


def coordinates_of(coordinates: Coordinates, model: FrictionModel) -> Real:
    """Return the point of the search that corresponds to a model."""
    model = model.model if isinstance(model, Directed) else model
    x = np.empty(len(coordinates.free))
    for n, c in enumerate(coordinates.free):
        owner = model if c.section == model.name else getattr(model, c.section)
        value, base = getattr(owner, "F_s" if c.parameter is LEVEL else c.parameter.name), 1.0
        if c.parameter is LEVEL:
            base = coordinates.held["static", "F_s"]
        elif c.scale == "share":
            base = value[-1]
        elif c.parameter.at_least:
            base = getattr(owner, c.parameter.at_least)
        value = value if c.block is None else value[c.block]
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
    fastest = float(np.quantile(np.concatenate([np.abs(r.motion.velocity[r.used]) for r in records]), 0.99))
    strokes = [float(np.ptp(r.motion.position)) for r in records]
    stroke = max(strokes)
    grain = [0.0 if r.log.position is None else max(r.motion.step, 4.0 * noise_level(r.log.position)) for r in records]
    seen = identifiability_of(records)
    finest = min(max(g, 1e-4 * s) for g, s in zip(grain, strokes, strict=True))
    duration = max(float(r.motion.time[-1] - r.motion.time[0]) for r in records)
    dt = min(float(np.median(np.diff(r.motion.time))) for r in records)
    if not (force > 0 and fastest > 0):
        hint = "Look at the mapping."
        raise FricError("the records hold no force or no motion", where=records[0].log.where, hint=hint)
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


@dataclass(frozen=True)
class Point:
    """State of a search."""

    x: Real  # Coordinates, shape (p,)
    residual: Real  # Residual force there, weighted [N], shape (n,)
    gradient: Real  # The derivatives of the residual, shape (n, p)


@dataclass(frozen=True)
class Search:
    """A model's coordinates and the records that it is fitted to."""

    coordinates: Coordinates  # What is searched
    records: Sequence[Prepared]  # Force that it is compared with
    weights: tuple[Real, ...] | None = None  # Of each used sample, by record; their mean square is 1. None: equal

    @cached_property
    def _weighted(self) -> list[tuple[Real, Real]]:
        """The weights of each record, and an orthonormal basis of its terms (`Preparation.own`)."""
        given = self.weights or tuple(np.ones(int(record.used.sum())) for record in self.records)
        owns = (record.own[record.used] / np.abs(record.own).max(axis=0) for record in self.records)
        bases = [np.linalg.qr(own * weight[:, None])[0] for own, weight in zip(owns, given, strict=True)]
        return list(zip(given, bases, strict=True))

    def projected(self, forces: Sequence[Real]) -> Real:
        """Return a force of each record, shape (n,), weighted, at the samples used, less the terms of the record.

        Linear parameters are projected out (variable projection: Golub, Pereyra 1973). Several forces are columns.
        """
        parts = []
        for record, force, (weight, basis) in zip(self.records, forces, self._weighted, strict=True):
            rest = force[record.used] * (weight if force.ndim == 1 else weight[:, None])
            parts.append(rest - basis @ (basis.T @ rest))
        return np.concatenate(parts)

    def residual(self, x: Real) -> Real:
        """Return measured minus replayed force, weighted [N], of all records one after the other, shape (n,)."""
        tried()
        model = self.coordinates.build(x)
        return self.projected([record.force - record.replay(model) for record in self.records])

    def weighed(self, x: Real) -> Self:
        """Return the search with each sample weighted by its spread at a point, see `spread`."""
        model = self.coordinates.build(x)
        weights = [1.0 / spread(record, model) for record in self.records]
        size = float(np.sqrt(np.mean(np.concatenate(weights) ** 2)))
        return replace(self, weights=tuple(weight / size for weight in weights))

    def cost(self, x: Real) -> float:
        """Return the sum of squared residuals [N²]."""
        residual = self.residual(x)
        total = float(residual @ residual)
        return total if np.isfinite(total) else 1e300

    def gradient(self, x: Real, *, both: bool = True) -> Real:
        """Return the residual's derivatives, shape (n, p): central differences, or backward at half the cost."""
        slopes = [block_slopes(self.coordinates, x, record, both=both) for record in self.records]
        known = list(slopes[0])
        found = np.empty((sum(int(record.used.sum()) for record in self.records), len(x)))
        if known:
            tried()
            found[:, known] = -self.projected([np.column_stack([mapping[n] for n in known]) for mapping in slopes])
        here = None if both or len(known) == len(x) else self.residual(x)
        for n, (low, high) in enumerate(zip(self.coordinates.lower, self.coordinates.upper, strict=True)):
            if n in slopes[0]:
                continue
            h = STEP * (high - low)
            before, after = x.copy(), x.copy()
            before[n], after[n] = max(x[n] - h, low), min(x[n] + h, high)
            if here is not None and before[n] < x[n]:
                found[:, n] = (here - self.residual(before)) / (x[n] - before[n])
            else:
                found[:, n] = (self.residual(after) - self.residual(before)) / (after[n] - before[n])
        return found

    def at(self, x: Real) -> Point:
        """Return the state at a point, shape (p,)."""
        return Point(x, self.residual(x), self.gradient(x))

    def seen(self, point: Point) -> Mask:
        """Return the coordinates that change the residual, over their whole range, by more than its standard error."""
        force = np.linalg.norm(self.projected([record.force for record in self.records]))
        effect = np.linalg.norm(point.gradient, axis=0) * (self.coordinates.upper - self.coordinates.lower)
        error = float(np.linalg.norm(point.residual)) / np.sqrt(len(point.residual))
        return np.asarray(effect > max(error, 1e-9 * float(force)))

    def fine(self, x: Real, most: int = 60, *, both: bool = True) -> Real:
        """Return the least-squares point next to x, within the bounds, in a bounded number of steps; see `gradient`."""
        lower, width = self.coordinates.lower, self.coordinates.upper - self.coordinates.lower

        def residual(y: Real) -> Real:
            return self.residual(lower + width * y)

        def jacobian(y: Real) -> Real:
            return self.gradient(lower + width * y, both=both) * width

        begin = np.clip((x - lower) / width, 1e-9, 1 - 1e-9)
        found = least_squares(residual, begin, jacobian, bounds=(0.0, 1.0), xtol=1e-7, ftol=1e-8, max_nfev=most)
        return np.asarray(lower + width * found.x)

    def coarse(self, seed: int) -> Real:
        """Return a point in the right basin, over few samples.

        A controlled random search (Kaelo and Ali's CRS2) places the scalars and a geometric row of blocks; where that
        explains little, or fast sliding worse than Coulomb and viscous friction do, it is repeated. Then blocks hop,
        the weakest first: a block is redrawn and the fit repeated, and a better result is kept.
        """
        every = -(-sum(len(r.force) for r in self.records) // COARSE)
        few = Search(self.coordinates, [record.thinned(every) for record in self.records])

        start = np.full(self.coordinates.coarse, 0.5)
        most_tried = EVALUATIONS * (len(start) + 1)
        spread, found = self.coordinates.spread_start, list[tuple[float, Real]]()
        most = LITTLE * float(np.sum(few.projected([record.force for record in few.records]) ** 2))
        fast, rigid = few._rigid()

        def explains(cost: float, x: Real) -> bool:
            return bool(cost <= most and np.sum(few.residual(few.fine(x, HOP, both=False))[fast] ** 2) <= RIGID * rigid)

        while len(found) < SEARCHES and not (found and explains(*min(found, key=itemgetter(0)))):
            nlopt.srand(seed + len(found) + 1)  # 0 would be the time of day
            y = minimised(
                "GN_CRS2_LM", lambda y: few.cost(spread(y)), start, 0.0, 1.0, maxeval=most_tried, ftol_rel=1e-4
            )
            found.append((few.cost(spread(y)), spread(y)))
        return few._hopped(min(found, key=itemgetter(0))[1], np.random.default_rng(seed))

    def _rigid(self) -> tuple[Mask, float]:
        """Return which samples slide fast, and the squares that Coulomb and viscous friction leave of them [N²]."""
        v = np.concatenate([record.motion.velocity[record.used] for record in self.records])
        fast = np.abs(v) > FAST * np.quantile(np.abs(v), 0.99)
        nuisances = block_diag(*(record.own[record.used] for record in self.records))
        force = np.concatenate([record.force[record.used] for record in self.records])[fast]
        basis = np.column_stack([np.sign(v), v, nuisances])[fast]
        left = force - basis @ np.linalg.lstsq(basis, force)[0]
        return fast, float(left @ left)

    def _hopped(self, x: Real, rng: np.random.Generator) -> Real:
        free = self.coordinates.free
        if len(blocks := sorted({c.block for c in free if c.block is not None})) < 2:
            return x
        x = self.fine(x, HOP, both=False)
        best = self.cost(x)
        first = rng.uniform()
        for n in range(HOPS * len(blocks)):
            effect = np.linalg.norm(self.gradient(x, both=False), axis=0)
            of = [max(e for e, c in zip(effect, free, strict=True) if c.block == b) for b in blocks]
            weak = blocks[int(np.argsort(of)[(n // 2 if n % 2 else 0) % len(blocks)])]
            share = (first + n * GOLDEN) % 1.0  # hops that are spread evenly
            hopped = x.copy()
            of_last = [i for i, c in enumerate(free) if c.scale == "share"] if weak == blocks[-1] else []
            hopped[of_last] -= max(hopped[of_last], default=0.0)  # shares are relative to that of the last block
            for i, c in enumerate(free):
                if c.block == weak:
                    hopped[i] = 0.0 if c.scale == "share" else c.lower + share * (c.upper - c.lower)
            hopped = self.fine(hopped, HOP, both=False)
            if (found := self.cost(hopped)) < (1 - 1e-3) * best:
                x, best = hopped, found
        return x


def few_a_swing(record: Prepared) -> bool:
    """Return whether few samples show a swing, at a rate that is low for what a position loop passes."""
    slow = 5.0 * BANDWIDTH * float(np.median(np.diff(record.motion.time))) > 1.0
    return slow and len(record.force) < FEW_A_SWING * len(record.reversals)


def unseen(record: Prepared, model: FrictionModel) -> tuple[Real, Real]:
    """Return the squared residuals [N²] at the samples used, and what of them is due to motion between samples.

    Where few samples show a swing, the fitted force differs along the motion of every second sample, most beside starts
    and stops. If by more than the residual, the squares of that, by sample and neighbours, are a shape of the variance,
    whose rest is that of the samples below the median. The level of the record is fitted.
    """
    replayed = record.replay(model)
    terms = np.column_stack([record.own, replayed])[record.used]
    terms /= np.abs(terms).max(axis=0, initial=1e-300)
    rest = (record.force - replayed)[record.used]
    squares = (rest - terms @ np.linalg.lstsq(terms, rest, rcond=None)[0]) ** 2
    if "mass" in record.done.own and record.done.starts and few_a_swing(record):
        moved = record.own - record.coarse.own
        apart = replayed - record.coarse.replay(model) + moved @ record.record_part(record.force - replayed)
        shape = sliding_window_view(np.pad(apart**2, 1), 3).max(axis=1)[record.used]
        more = squares.mean() - squares[shape <= np.median(shape)].mean()
        if shape.mean() > squares.mean() and more > 0.0:
            return squares, shape * more / shape.mean()
    return squares, np.zeros_like(squares)


def spread(record: Prepared, model: FrictionModel) -> Real:
    """Return the standard deviation of each residual [N] at the samples used: ``σ² = σ_F² + (σ_z·dF/dz)²``.

    The stiffness of the contact magnifies the remaining encoder steps in the motion (effective variance: Orear, Am. J.
    Phys. 50 (1982) 912). σ_F and σ_z are fitted to the squared residuals, with σ_z up to ``step/√12`` of a plain count,
    so that errors of the model near a reversal do not count as those of the encoder, and the level of the record is
    fitted, so that levels near their mean do not weigh more. Where samples are few the second term is that of `unseen`.
    """
    replayed, (squares, hidden) = record.replay(model), unseen(record, model)
    floor = max(0.01 * float(squares.mean()), 1e-12 * float(np.mean(record.force[record.used] ** 2)), 1e-300)
    if record.motion.step == 0.0 or hidden.any():
        return np.sqrt(np.maximum(squares.mean() - hidden.mean() + hidden, floor))
    stiffness = _stiffness(record, replayed)[record.used]
    size = max(float(stiffness.max()), 1e-300)
    shape = (stiffness / size) ** 2
    by_step = min(float(nnls(np.column_stack([np.ones_like(shape), shape]), squares)[0][1]),
                  (record.motion.step * size) ** 2 / 12.0)  # fmt: skip
    by_noise = max(float(np.mean(squares - by_step * shape)), 0.0)
    return np.asarray(np.sqrt(np.maximum(by_noise + by_step * shape, floor)))


def _stiffness(record: Prepared, force: Real) -> Real:
    """Return ``|dF/dz|`` of a replayed force [N/m], shape (n,): the greater of the two steps around each sample."""
    dz, dF = np.abs(np.diff(record.motion.position)), np.abs(np.diff(force))
    slope = np.divide(dF, dz, out=np.zeros_like(dz), where=dz > 1e-6 * float(dz.max()))
    return np.maximum(np.append(slope, 0.0), np.append(0.0, slope))


def block_slopes(coordinates: Coordinates, x: Real, record: Prepared, *, both: bool) -> dict[int, Real]:
    """Return the derivatives of a replayed force [N], shape (n,), over the coordinates of blocks, by their number.

    GMS blocks are in parallel and independent. The load F_i of a block depends on its alpha_i and k_i, on C and on the
    level s(v), and is homogeneous twice (Euler): ``F_i = alpha_i·∂F_i/∂alpha_i + k_i·∂F_i/∂k_i`` and ``s·∂F_i/∂s =
    alpha_i·∂F_i/∂alpha_i - C·∂F_i/∂C``. So two replays, with a slightly softer copy of each block and with another C,
    give all derivatives.

    coordinates: The coordinates; only the GMS model has slopes, any other gives an empty mapping.
    both: Whether by central differences; else by backward differences.
    """
    if coordinates.model is not GMS:
        return {}
    model = coordinates.build(x)
    law = model.model if isinstance(model, Directed) else model
    assert isinstance(law, GMS)
    alpha, k, C = np.array(law.alpha), np.array(law.k), law.C
    factors = np.exp([-BLOCK_STEP, BLOCK_STEP] if both else [-BLOCK_STEP])
    loads = side_by_side(model, np.tile(alpha, (len(factors) + 1, 1)), np.outer([1.0, *factors], k), C, record)
    here = loads[:, 0]

    def slope(moved: list[Real]) -> Real:
        return (moved[1] - moved[0]) / (2 * BLOCK_STEP) if both else (here - moved[0]) / BLOCK_STEP

    by_k = slope([loads[:, n] for n in range(1, loads.shape[1])])
    by_alpha, by_C = here - by_k, np.zeros(len(here))
    if any(c.block is None for c in coordinates.free):
        by_force = slope([side_by_side(model, alpha[None], k[None], C * factor, record)[:, 0] for factor in factors])
        by_C = by_force.sum(axis=1)
    found: dict[int, Real] = {}
    for n, c in enumerate(coordinates.free):
        if c.parameter is LEVEL:
            found[n] = by_alpha.sum(axis=1) - by_C
        elif c.section != GMS.name:
            continue
        elif c.block is None:
            found[n] = by_C / (1.0 if c.scale == "log" else C)
        elif c.scale == "share":
            found[n] = by_alpha[:, c.block] - alpha[c.block] * by_alpha.sum(axis=1)
        else:
            found[n] = by_k[:, c.block] / (1.0 if c.scale == "log" else k[c.block])
    return found


def side_by_side(model: FrictionModel, alpha: Real, k: Real, C: float, record: Prepared) -> Real:
    """Return the loads [N], shape (n, m, blocks), of blocks with any shares and stiffnesses at the level of a GMS
    model.

    All of them are in parallel in a single model. Its shares must sum to 1: they are divided by their sum, and level
    and C multiplied by it.
    """
    total, motion = float(alpha.sum()), record.motion

    def wide(model: FrictionModel) -> FrictionModel:
        if isinstance(model, Directed):
            return Directed(wide(model.model), times(model.negative, total))
        assert isinstance(model, GMS)
        return GMS(times(model.static, total), tuple(alpha.ravel() / total), tuple(k.ravel()), C * total)

    moved = wide(model)
    z, v, t = (np.ascontiguousarray(array, float) for array in (motion.position, motion.velocity, motion.time))
    return replay_loads(type(moved).step, z, v, t, moved.initial_state(), moved.packed(), k.size).reshape(-1, *k.shape)


def times(static: StaticMap, factor: float) -> StaticMap:
    """Return a static map with its level multiplied by a factor, except viscous friction, which blocks do not have."""
    return replace(static, F_c=factor * static.F_c, F_s=factor * static.F_s)
