"""The uncertainty of a machine: spreads in a file; intervals of identified parameters, and errors beyond them."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, pi
from pathlib import Path
from typing import Any, Self

from pydantic import Field, model_validator
from scipy.special import stdtrit

from fric.documents.base import Document, Part, Quantity, refused
from fric.documents.friction import FrictionDocument
from fric.documents.machine_files import read_machine, read_machine_document, spring_of, true_friction
from fric.documents.plant import PlantDocument, PlantPart
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.estimate import Covariance, Estimate
from fric.flaws import flaw_of
from fric.flaws.prediction import INTERVAL_OPEN, NOT_DRAWN, PREDICTION_WIDENED
from fric.notice import Notice, once
from fric.simulate.machine import Machine
from fric.simulate.reality.flaws import NONE
from fric.simulate.spread import Distribution, Intervals, Spread, check_spreads, closed_intervals, friction_intervals
from fric.verb import verb


class SpreadPart(Part):
    """The factor by which a parameter of a drawn machine differs from that of the nominal machine."""

    distribution: Distribution = Field("uniform", description="of the factor, or of its logarithm")
    factor: Quantity = Field(
        description="limits [low, high] of the factor; its 95 % interval where the distribution is normal or log-normal"
    )

    def spread(self) -> Spread:
        """Return the spread."""
        limits = self.factor.si("ratio", "linear")
        if not isinstance(limits.value, tuple) or len(limits.value) != 2:
            raise FricError("a spread has a lower and an upper factor", hint="Give them as value: [0.7, 1.3].")
        return Spread(*limits.value, self.distribution, limits.source)


class SpreadDocument(Document, type="spread"):
    """A spread file: which parameters of the true machine are drawn around the nominal values, and how widely."""

    spreads: dict[str, SpreadPart] = Field(
        description="by level (every friction force), stiffness (every stiffness), load, M, or a parameter's name"
    )

    @model_validator(mode="after")
    def _names_and_factors_fit(self) -> Self:
        for name, part in self.spreads.items():
            with refused(f"spreads.{name}"):
                check_spreads({name: part.spread()})
        return self

    def read(self) -> dict[str, Spread]:
        """Return the spreads by name."""
        return {name: part.spread() for name, part in self.spreads.items()}


@verb
def read_spreads(path: Path | str) -> dict[str, Spread]:
    """Read spreads by name from a spread file."""
    return read_document(path, SpreadDocument).read()


CROSSED = 50.0
"""Frequency at which a misfit of the response counts as a phase error [Hz]: about that of a feed drive's loop."""
OPEN = 2.0  # Factor to either side that bounds a parameter whose interval is open, or does not contain its estimate
AT_LEAST = 1e-3  # Errors below this share are neglected
FORM: Mapping[str, float] = {"k": 0.1, "alpha": 0.05, "C": 0.2, "v_s": 0.1, "T_d": 0.05, "B": 0.01}
"""Least difference of a real axis from a model of a few blocks and a single mass."""


def discrepancies(
    friction: FrictionDocument, plant: PlantPart, undrawn: Sequence[str] = ()
) -> tuple[dict[str, Spread], tuple[Notice, ...]]:
    """Return the factors of additional differences of the true axis from the parameters of its files, and the reasons.

    friction: Its friction file: strokes that scatter, sines at another level than strokes, blocks that miss the virgin
        curve.
    plant: Its plant file: the residual of eq. (1).
    undrawn: Parameters whose interval cannot be drawn from.
    """
    shares: dict[str, float] = {}
    reasons: list[Notice] = []
    delay = float(plant.estimates(friction.motion)["T_d"])
    found = [*_of_friction(friction), *_beyond_the_plant(plant, delay), *_of_warnings(friction, plant)]
    for name, share in FORM.items():
        shares[name] = share
    for name, share, why in found:
        if share >= AT_LEAST:
            shares[name] = (shares.get(name, 0.0) ** 2 + share**2) ** 0.5
            reasons.append(PREDICTION_WIDENED.found(name=name, share=share, why=why))
    spreads = {name: Spread(1 / (1 + share), 1 + share, "log-normal") for name, share in shares.items()}
    for name in undrawn:
        if name != "offset":
            spreads[name] = Spread(1 / OPEN, OPEN, "log-normal")
            reasons.append(INTERVAL_OPEN.found(name=name, low=1 / OPEN, high=OPEN))
    return spreads, once(reasons)


Found = Iterator[tuple[str, float, str]]


def _of_friction(friction: FrictionDocument) -> Found:
    static = friction.estimates("static") if friction.static else {}
    fit = friction.fit_of("static")
    level = float(static["F_c"]) if "F_c" in static else 0.0
    if level > 0 and fit.between_strokes is not None:
        why = "strokes of one speed scatter so much beyond their own noise"
        yield "level", 1.96 * _number(fit.between_strokes) / level, why
    elif level > 0 and fit.rmse is not None:
        yield "level", 1.96 * _number(fit.rmse) / level, "the static map misses the strokes by so much"
    if level > 0 and fit.over_position is not None:
        yield "level", 1.96 * _number(fit.over_position) / level, "friction differs so much from place to place"
    if varies := level_of_next_record(friction):
        yield "level", varies, "friction differs so much from record to record"
    blocks = friction.fit_of("gms")
    if blocks.alpha_sum is not None:
        limits: Any = blocks.alpha_sum.ci95 or [blocks.alpha_sum.value]
        apart = max(abs(float(limit) - 1.0) for limit in limits if limit is not None)
        yield "level", apart, "the sines show another level than the strokes"
    rise = float(static["F_s"]) if "F_s" in static else 0.0
    if rise > 0 and blocks.virgin_curve_rmse is not None:
        share = 1.96 * _number(blocks.virgin_curve_rmse) / rise
        count = max(len(friction.estimates("gms")["alpha"].value), 1) if "alpha" in friction.section("gms") else 1  # type: ignore[arg-type]
        yield "k", 2.0 * share * count, "the blocks miss the virgin curve"
        yield "alpha", share * count, "the blocks miss the virgin curve"


def level_of_next_record(friction: FrictionDocument) -> float:
    """Return half the 95 % interval of the level of the next record [1], beyond the error of the mean.

    It is the deviation of the levels by Student's t of their number less one; a single record has four windows.
    """
    from fric.identify.static_map.corrections import WINDOWS  # which loads SciPy's optimisation

    made = friction.provenance.model_dump() if friction.provenance else {}
    strokes = len({log.get("record") for log in (made.get("static") or made).get("logs", ())})
    found = []
    for name in ("static", *friction.model_names()):
        fit = friction.fit_of(name)
        count = len(fit.records) if fit.records else strokes
        deviation = _number((fit.between_records or {}).get("level"))
        found.append(float(stdtrit(count - 1 if count > 1 else WINDOWS - 1, 0.975)) * deviation)
    return max(found)


def _beyond_the_plant(plant: PlantPart, delay: float) -> Found:
    fit = plant.fit if isinstance(plant, PlantDocument) else None
    if fit is not None and fit.misfit is not None:
        share, why = _number(fit.misfit), "eq. (1) leaves so much of the measured response"
        late = min(share / (2 * pi * CROSSED * max(delay, 1e-4)), 1.0)
        yield "B", share, why
        yield "T_d", late, "eq. (1) leaves so much of the response's phase"
        yield "A", min(3.0 * share, 1.0), why
    elif fit is not None and fit.relative_error is not None:
        share, why = _number(fit.relative_error), "the rigid axis leaves so much of the force of an ordinary motion"
        yield "B", share, why
        yield "A", min(3.0 * share, 1.0), why
        yield "T_d", 0.3, "an ordinary motion hardly shows the delay"


def _of_warnings(friction: FrictionDocument, plant: PlantPart) -> Found:
    parts = [friction, *([plant] if isinstance(plant, PlantDocument) else [])]
    coded = {notice.code: notice for part in parts for notice in part.notices() if notice.severity != "note"}
    for notice in coded.values():
        for name, share in flaw_of(notice).widens.items():
            yield name, share, str(notice)


def _number(given: Quantity | None) -> float:
    value: Any = None if given is None else given.value
    return float(value) if isinstance(value, int | float) and abs(value) < inf else 0.0


NO_INTERVAL = "no parameter has a 95 % interval"


@dataclass(frozen=True)
class IdentifiedMachine:
    """An identified machine."""

    machine: Machine  # The machine, true to the estimates
    # By axis and parameter, the 95 % intervals that include their estimate and are closed
    intervals: Mapping[str, Intervals]
    covariances: Mapping[str, Sequence[Covariance]]  # By axis, covariance of these parameters, where the files hold it
    # By axis, factors of additional differences, from misfit and warnings of the files
    discrepancies: Mapping[str, Mapping[str, Spread]]
    widened: Mapping[str, tuple[Notice, ...]]  # By axis, why
    warnings: tuple[Notice, ...]  # Which parameters cannot be drawn from their interval

    def drawn(self) -> dict[str, Any]:
        """Return the uncertainty that a study draws its machines from."""
        return {
            "intervals": self.intervals, "covariances": self.covariances, "discrepancies": self.discrepancies
        }  # fmt: skip


@verb
def read_identified(
    path: Path | str,
    *,
    nominal_files: Iterable[str] = (),
    gain: float | None = None,
    lead: float | str | None = None,
    friction_model: str | None = None,
) -> IdentifiedMachine:
    """Read a machine file with the intervals of what was identified of it.

    What is identified of an axis is what its controller believes: the friction file given in ``nominal_files``, or that
    of its feedforward, and the nominal plant; other values, and axes without these files, are as in the machine file.
    Flaws in the machine file are not used; a second mass is, if the response shows it.

    Parameters
    ----------
    path, nominal_files, gain, lead, friction_model
        As in `fric.documents.machine_files.read_machine`.

    Raises
    ------
    FricError
        As `read_machine`; and when no parameter has an interval.
    """
    nominal_files = tuple(nominal_files)
    machine = read_machine(path, nominal_files=nominal_files, gain=gain, lead=lead, friction_model=friction_model)
    intervals: dict[str, Intervals] = {}
    covariances: dict[str, Sequence[Covariance]] = {}
    beyond: dict[str, Mapping[str, Spread]] = {}
    widened: dict[str, tuple[Notice, ...]] = {}
    axes, warnings = dict(machine.axes), []
    for name, part in read_machine_document(path, nominal_files).axes.items():
        own, of_plant = part.feedforward.friction, part.nominal or part.plant
        friction = part.friction
        if own:  # the identified friction, completed by that of the machine
            head = {"axis": friction.axis, "motion": friction.motion}
            friction = FrictionDocument.made(head | friction.content() | own.content(*own.sections()))
        model, axis = true_friction(friction), machine.axes[name]
        sections = {key: friction.estimates(key) for key in friction.sections()}
        found, undrawn = friction_intervals(model, sections)
        known = of_plant.estimates(part.motion)
        plant: dict[str, Estimate] = {symbol: known[symbol] for symbol in ("A", "B", "T_d", "K_f") if symbol in known}
        if "offset" in sections.get("static", {}):
            plant["offset"] = sections["static"]["offset"]
        for symbol, estimate in plant.items():
            closed, open_ended = closed_intervals(symbol, estimate)
            found |= closed
            undrawn += open_ended
        if undrawn:
            warnings.append(NOT_DRAWN.found(f"axis {name}", names=undrawn))
        if found:
            intervals[name] = found
            covariances[name] = [*_together(own or part.friction)]
            if isinstance(of_plant, PlantDocument) and of_plant.fit is not None and of_plant.fit.covariance is not None:
                covariances[name] = [*covariances[name], of_plant.fit.covariance.covariance()]
            beyond[name], widened[name] = discrepancies(own or part.friction, of_plant, undrawn)
        load = float(plant["offset"]) if "offset" in plant else axis.load
        spring = axis.second_mass if part.nominal is None else spring_of(part.nominal, model, part.motion)
        axes[name] = replace(
            axis, plant=axis.nominal or axis.plant, friction=model, load=load, reality=NONE, second_mass=spring
        )
    if not intervals:
        raise FricError(
            NO_INTERVAL,
            where=str(path),
            hint="Give files that `fric identify` wrote: `nominal_files='x=FRICTION.yaml'`, or in the machine file.",
        )
    return IdentifiedMachine(replace(machine, axes=axes), intervals, covariances, beyond, widened, tuple(warnings))


def machine_to_predict(path: Path) -> tuple[Machine, IdentifiedMachine | None]:
    """Read a machine file as an identified machine, if it has intervals."""
    try:
        found = read_identified(path)
    except FricError as error:
        if error.what != NO_INTERVAL:
            raise
        return read_machine(path), None
    return found.machine, found


def _together(friction: FrictionDocument) -> Iterator[Covariance]:
    """Yield the covariance of the parameters of each section, with the names by which they are drawn."""
    for section in friction.sections():
        block = friction.fit_of(section).covariance if section != "at_speed" else None
        if block is not None:
            found = block.covariance()
            prefix = "negative." if section == "static_negative" else ""
            yield replace(found, names=tuple(prefix + name for name in found.names))
