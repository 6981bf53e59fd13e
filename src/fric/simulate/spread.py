"""Machines around a nominal machine: which of its true parameters are spread, how, and machine number i of a seed.

Drawn are the true properties of a machine: its friction, its plant. The nominal models of its controller stay: the
friction that is fed forward, the nominal plant of the inverse model, the observer.
"""

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import exp, inf, log, sqrt
from typing import Any, Literal, get_args
from zlib import crc32

import numpy as np

from fric.control.cascade import Cascade
from fric.drive.plant import Plant, hold_delay
from fric.errors import FricError, require_known
from fric.estimate import NORMAL_97_5, Covariance, Estimate, as_filed, elements
from fric.friction import FrictionModel, Parameter, models
from fric.friction.directed import Directed
from fric.simulate.machine import Axis, Machine
from fric.verb import refused, require_within

Intervals = Mapping[str, tuple[float, float]]  # 95 %, by parameter, also ``negative.F_c`` (direction), ``k_2`` (block)
Distribution = Literal["uniform", "log-uniform", "normal", "log-normal"]
GROUPS = {"level": "force", "stiffness": "stiffness"}  # Spreads of all friction parameters of one dimension
PLANT = ("A", "B", "T_d", "K_f", "M")  # Spreads of the plant


def normals(
    covariances: Iterable[Covariance], drawn: Container[str], normal: Callable[[str], float]
) -> dict[str, float]:
    """Return a standard normal number for each parameter of a covariance, correlated accordingly.

    drawn: Parameters that are drawn from their intervals; the others of a block are passed over.
    normal: Gives an independent standard normal number for a name: the numbers do not depend on the order of the names.
    """
    found: dict[str, float] = {}
    for block in covariances:
        kept = [n for n, name in enumerate(block.names) if name in drawn and block.matrix[n][n] > 0]
        matrix = np.array(block.matrix)[np.ix_(kept, kept)]
        size = np.sqrt(np.diag(matrix))
        values, vectors = np.linalg.eigh(matrix / np.outer(size, size))
        root = (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T  # of all roots, that without an order
        mixed = root @ [normal(block.names[n]) for n in kept]
        found |= {block.names[n]: float(z) for n, z in zip(kept, mixed, strict=True)}
    return found


def draw_within(value: float, interval: tuple[float, float], lower: float, normal: float) -> float:
    """Draw a value whose median is the estimate and whose 2.5 and 97.5 % quantiles are the interval's limits.

    Half a normal distribution lies on either side of the estimate, each as wide as its side of the interval: an
    interval need not be symmetric. A parameter that is positive, with a positive interval, is drawn in its logarithm;
    where an interval passes a bound of the parameter, values beyond it are moved to the bound.

    interval: The estimate's 95 % interval, both limits finite, around the value.
    lower: The parameter's lower bound; 0 where it is positive by its nature.
    normal: A standard normal number; correlated with those of other parameters where they have a covariance.
    """
    low, high = interval
    z = normal / NORMAL_97_5
    if lower > -inf and low > 0:
        return value * exp(z * (log(high / value) if z > 0 else log(value / low)))
    return max(value + z * (high - value if z > 0 else value - low), lower)


def declared_parameters(model: FrictionModel) -> list[Parameter]:
    """Return the parameters of a model and of those that it builds upon, without those of its static map."""
    declared = (parameter for kind in reversed(type(model).__mro__) for parameter in vars(kind).get("parameters", ()))
    return [*{parameter.name: parameter for parameter in declared if hasattr(model, parameter.name)}.values()]


def friction_intervals(
    model: FrictionModel, sections: Mapping[str, Mapping[str, Estimate]]
) -> tuple[dict[str, tuple[float, float]], list[str]]:
    """Return the intervals of a friction model's parameters, and the names of those that cannot be drawn from."""
    found, refused = dict[str, tuple[float, float]](), list[str]()
    law = model.model if isinstance(model, Directed) else model
    parts = (("", law), ("", getattr(law, "static", None)), ("negative.", getattr(model, "negative", None)))
    for prefix, part in parts:
        if part is None:
            continue
        base_names = [vars(base)["name"] for base in type(part).__mro__ if "name" in vars(base)]
        names = ["static_negative"] if prefix else base_names
        for parameter in declared_parameters(part):
            given = (sections[name].get(parameter.name) for name in names if name in sections)
            if (estimate := next((estimate for estimate in given if estimate is not None), None)) is not None:
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
    found, refused = dict[str, tuple[float, float]](), []
    for label, item in elements({name: estimate}):
        low, high = item.limits
        if -inf < low <= float(item) <= high < inf:
            found[label] = (low, high)
        else:
            refused.append(label)
    return found, refused


@dataclass(frozen=True)
class Spread:
    """The factor by which a parameter of a drawn machine differs from that of the nominal machine.

    low, high: The limits of the factor [1]; for ``normal`` and ``log-normal`` its 95 % interval.
    distribution: ``uniform`` or ``normal`` in the factor, ``log-uniform`` or ``log-normal`` in its logarithm.
    source: Why so much.
    Raises FricError: When a limit is not between 1e-9 and 1e9, they are not in order, or the distribution is not known.
    """

    low: float
    high: float
    distribution: Distribution = "uniform"
    source: str = ""

    def __post_init__(self) -> None:
        require_within(self, "the spread", low="[1e-9, 1e9]", high="[1e-9, 1e9]")
        if self.low > self.high:
            raise FricError(f"the spread from {self.low:g} to {self.high:g} falls", hint="Give the lower factor first.")
        require_known(self.distribution, get_args(Distribution), "there is no distribution")

    def factor(self, generator: np.random.Generator) -> float:
        """Draw a factor; a value of a normal distribution that is not positive is drawn again."""
        if self.low == self.high:
            return self.low
        logarithmic = self.distribution.startswith("log")
        low, high = (log(self.low), log(self.high)) if logarithmic else (self.low, self.high)
        while True:
            if self.distribution.endswith("uniform"):
                found = float(generator.uniform(low, high))
            else:
                found = float((low + high) / 2 + (high - low) / (2 * NORMAL_97_5) * generator.standard_normal())
            if logarithmic or found > 0:
                return exp(found) if logarithmic else found


DEFAULT_SPREADS: dict[str, Spread] = {  # The default spreads; `configs/spread.yaml` states the same
    "level": Spread(0.7, 1.3, "uniform", "friction changes with load, lubricant, temperature and wear"),
    "stiffness": Spread(0.3, 2.0, "log-uniform", "stiffness before sliding is the least certain of what is identified"),
    "C": Spread(0.1, 10.0, "log-uniform", "the attraction parameter is seldom identified: known to a power of ten"),
    "K_f": Spread(0.9, 1.1, "uniform", "tolerance of a motor's force constant, and its loss as magnets warm up"),
    "T_d": Spread(0.8, 1.2, "uniform", "delay of drive and field bus, that differs from setup to setup"),
}


def known_spreads() -> tuple[str, ...]:
    """Return the names of all that can be spread."""
    names = {parameter.name for model in models().values() for parameter in model.parameters}
    return (*GROUPS, *PLANT, "load", *sorted(names))


def check_spreads(spreads: Mapping[str, Spread]) -> None:
    """Raise a `FricError` when a name is none that can be spread, or its spread is none."""
    for name, spread in spreads.items():
        if not isinstance(spread, Spread):
            raise refused("the spread", f"{name} as a Spread", spread)
        if name not in known_spreads():
            raise FricError(f"'{name}' is nothing that can be spread", hint=f"Known are {', '.join(known_spreads())}.")


@dataclass
class _Draws:
    """The draws of one axis of one machine: each by a seed of its name, so that none depends on the others."""

    seed: int
    index: int
    axis: str  # Its name
    spreads: Mapping[str, Spread]
    intervals: Intervals
    covariances: Sequence[Covariance] = ()
    beyond: Mapping[str, Spread] = field(default_factory=dict)
    factors: dict[str, float] = field(default_factory=dict)
    drawn: dict[str, float] = field(default_factory=dict)

    def generator(self, name: str) -> np.random.Generator:
        key = (self.index, crc32(self.axis.encode()), crc32(name.encode()))
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=key))

    def normal(self, name: str) -> float:
        return float(self.generator(f"interval {name}").standard_normal())

    @cached_property
    def joint(self) -> dict[str, float]:
        return normals(self.covariances, self.intervals, self.normal)

    def factor(self, name: str, element: str = "") -> float:
        """Return the factor of a spread; an element of a vector (``k_2``) has a separate factor."""
        if name not in self.spreads:
            return 1.0
        key = element or name
        if key not in self.factors:
            self.factors[key] = as_filed(self.spreads[name].factor(self.generator(key)))
            self.drawn[f"{self.axis}.{key}"] = self.factors[key]
        return self.factors[key]

    def value(self, name: str, value: float, lower: float, *spreads: str) -> float:
        """Return a parameter drawn from its interval; where it has none, times the factors of its spreads."""
        by = self.discrepancy(name, spreads)
        if (interval := self.intervals.get(name)) is None:
            for spread in spreads:
                value *= self.factor(spread, name if name.startswith(f"{spread}_") else "")
            return by * value
        normal = self.joint[name] if name in self.joint else self.normal(name)
        found = as_filed(draw_within(by * value, (by * interval[0], by * interval[1]), lower, normal))
        self.drawn[f"{self.axis}.{name}"] = found
        return found

    def discrepancy(self, name: str, spreads: Sequence[str]) -> float:
        """Return the factor of additional spreads: of the groups of a parameter, and of it or its element alone."""
        total = 1.0
        for key in (*(group for group in spreads if group in GROUPS), name, name.rpartition("_")[0]):
            if (spread := self.beyond.get(key)) is None:
                continue
            group = key if key in GROUPS else name
            if (drawn := f"{self.axis}.beyond {group}") not in self.drawn:
                self.drawn[drawn] = as_filed(spread.factor(self.generator(f"beyond {group}")))
            total *= self.drawn[drawn]
        return total


def draw_machine(
    machine: Machine, index: int, *, seed: int = 0, spreads: Mapping[str, Spread] | None = None,
    intervals: Mapping[str, Intervals] | None = None, covariances: Mapping[str, Sequence[Covariance]] | None = None,
    discrepancies: Mapping[str, Mapping[str, Spread]] | None = None,
) -> tuple[Machine, dict[str, float]]:  # fmt: skip
    """Return machine number ``index`` of those that a seed draws, and what was drawn.

    The place of position 0 between two counts of its encoders is drawn, too, and is the same for all schemes.
    The draw of a parameter depends on the seed, the index, the axis and the parameter alone: machine i is the same for
    any number of machines, any order, and any other spreads.

    spreads: By name of a parameter, or ``level`` (every friction force), ``stiffness`` (every stiffness), ``M``,
        ``load``: the `Spread` of its factor on each axis; `DEFAULT_SPREADS` where not given. That of ``alpha`` or ``k``
        is drawn for each block by itself. K_f and M are what a motor and a table have, so B = K_f/M follows them, and
        M·A stays with M.
    intervals: By axis and name: intervals of parameters that were identified. These are drawn from them, and not
        spread.
    covariances: By axis: covariance of these parameters; they are drawn with it, each still within its interval.
    discrepancies: By axis and name, as of ``spreads``: by what factor a parameter is off beyond its interval, as a
        model or a record that is not quite right makes it.
    Returns the machine; and by ``AXIS.NAME`` the factor of each spread, or the value [SI] drawn from an interval.
    """
    spreads = DEFAULT_SPREADS if spreads is None else spreads
    axes, drawn = dict[str, Axis](), dict[str, float]()
    for name, axis in machine.axes.items():
        known = (intervals or {}).get(name, {}), (covariances or {}).get(name, ()), (discrepancies or {}).get(name, {})
        draws = _Draws(seed, index, axis.name, spreads, *known)
        plant = _plant(axis.plant, draws)
        hold = hold_delay(axis.cascade.sampling) if intervals else 0.0
        axes[name] = replace(
            axis,
            plant=replace(plant, T_d=max(plant.T_d, min(hold, axis.plant.T_d))),  # it holds the half sample
            nominal=axis.nominal or axis.plant,
            friction=_friction(axis.friction, draws),
            cascade=_cascade(axis.cascade, draws),
            load=draws.value("offset", axis.load, float("-inf"), "load"),
        ).placed(float(draws.generator("place").random()))
        drawn |= draws.drawn
    return replace(machine, axes=axes), drawn


def draw_friction(
    model: FrictionModel, load: float, index: int, intervals: Intervals, covariances: Sequence[Covariance]
) -> tuple[FrictionModel, float]:
    """Return friction number ``index`` of those drawn from intervals, and the load ``offset``, as in `draw_machine`."""
    draws = _Draws(0, index, "", {}, intervals, covariances)
    return _friction(model, draws), draws.value("offset", load, -inf)


def _plant(plant: Plant, draws: _Draws) -> Plant:
    mass = draws.factor("M")
    A = draws.value("A", plant.A, 0.0, "A") / (1.0 if "A" in draws.intervals else mass)
    # identified from the input, B is valid for any K_f
    B = draws.value("B", plant.B, 0.0, "B", "K_f") / (1.0 if "B" in draws.intervals else mass)
    T_d, K_f = (draws.value(name, getattr(plant, name), 0.0, name) for name in ("T_d", "K_f"))
    return replace(plant, A=A, B=B, T_d=T_d, K_f=K_f)


def _cascade(cascade: Cascade, draws: _Draws) -> Cascade:
    """Return the gains for a K_p from its interval: a slow log shows K_p·K_v + K_i and K_v·K_i far better than K_p."""
    if (ahead := "acceleration_feedforward") in draws.intervals:
        share = draws.value(ahead, cascade.acceleration_feedforward, 0.0)
        unseen = draws.intervals[ahead] == (0.0, 1.0)  # a drive has it or has it not
        cascade = replace(cascade, acceleration_feedforward=float(share == 1.0) if unseen else share)
    if "K_p" not in draws.intervals:
        return cascade
    total, product = cascade.K_p * cascade.K_v + cascade.K_i, cascade.K_v * cascade.K_i
    K_p = draws.value("K_p", cascade.K_p, 0.0)
    root = sqrt(max(total**2 - 4.0 * K_p * product, 0.0))
    first = cascade.K_v * cascade.K_p >= cascade.K_i
    K_v = 0.5 * (total + (root if first else -root)) / K_p
    return replace(cascade, K_v=K_v, K_p=K_p, K_i=product / K_v)


def _friction(model: FrictionModel, draws: _Draws, prefix: str = "") -> FrictionModel:
    changed: dict[str, Any] = {}
    for part in ("model", "static", "negative"):
        if isinstance(inner := getattr(model, part, None), FrictionModel):
            changed[part] = _friction(inner, draws, "negative." if part == "negative" else prefix)
    for parameter in declared_parameters(model):
        before = getattr(model, parameter.name)
        spreads = (*(group for group, dimension in GROUPS.items() if parameter.dimension == dimension), parameter.name)
        name = prefix + parameter.name
        if isinstance(before, tuple):
            after: Any = tuple(  # of a block whose interval holds 0 a thousandth is left: it is there
                max(draws.value(f"{name}_{n}", value, parameter.lower, *spreads), 1e-3 * value)
                for n, value in enumerate(before, 1)
            )
            if parameter.name == "alpha" and after != before:
                after = tuple(value / sum(after) for value in after)
        else:
            after = draws.value(name, before, parameter.lower, *spreads)
        changed[parameter.name] = after
    for parameter in declared_parameters(model):
        if parameter.at_least and prefix + parameter.name in draws.intervals:
            changed[parameter.name] = max(changed[parameter.name], changed[parameter.at_least])
    return replace(model, **changed)  # type: ignore[type-var]
