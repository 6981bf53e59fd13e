"""A plan: the records to take of an axis, programs that make its motions, and the intervals to be expected."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil, inf, isfinite
from pathlib import Path
from typing import Any

from fric.documents.friction import FrictionDocument
from fric.documents.plan import SETTINGS, plan_tree
from fric.documents.plant import PlantDocument, PlantPart
from fric.documents.yaml import dump
from fric.errors import FricError, near
from fric.export.motion import DIALECTS, Arc, Move
from fric.flaws.plan import PLAN_ACCURACY
from fric.friction import models
from fric.friction.stribeck import STATIC_PARAMETERS
from fric.notice import Notice
from fric.output import write_folder
from fric.planning.choose import choose, durations
from fric.planning.plan import Expected, Limits, Plan, Planned
from fric.results.base import Result
from fric.results.expected import DRAWS, Expectation, expected
from fric.results.given import Advance, in_si, silent
from fric.results.given_models import document_of
from fric.results.prior import TYPICAL, prior_axis
from fric.results.text import Piece, Table, named
from fric.simulate.machine import Axis
from fric.units import readable, si_unit
from fric.verb import verb

MOST = 16
"""Times as many strokes, cycles or periods as usual that an accuracy may take."""

IDENTIFIED_BY = {
    "constant-velocity": (*STATIC_PARAMETERS, "offset"), "presliding-sine": ("alpha", "k"),
    "sliding-sine": ("C",), "frequency-response": ("A", "B", "T_d", "K_f", "force_lag"),
}  # fmt: skip
"""Which parameters each kind of record tells."""


GOOD_TO = "expected half-widths are those of simulated records, and good to ± 20 %"
"""What is said under half-widths that rest on simulated records, and so on chance."""


@dataclass(frozen=True, eq=False, repr=False)
class PlanResult(Result):
    """Records to take of an axis.

    Parameters
    ----------
    plan
        What is to be run, and what it will tell.
    blocks
        Slip blocks that the identification will find; None where it finds no GMS model.
    prior
        What the axis was taken to be, in words.
    notices
        What stands in for what is not known, and what cannot be expected.
    narrowing
        Of one more record after a first result: what it would do, as it stands in the document.
    """

    plan: Plan
    blocks: int | None
    prior: str
    notices: Sequence[Notice]
    narrowing: Mapping[str, Any] | None = None

    @cached_property
    def document(self) -> dict[str, Any]:
        """The plan file."""
        return plan_tree(
            self.plan, prior=self.prior, blocks=self.blocks, notices=self.notices, narrowing=self.narrowing
        )

    def report(self) -> list[Piece]:
        """Return the experiments, and the half-widths to be expected."""
        rows = [
            (one.kind, readable(lasting, "s"), settings_in_words(one, self.plan.axis.motion))
            for one, lasting in zip(self.plan.planned, self.plan.lasting, strict=True)
        ]
        described = [
            (name, readable(one.value, one.unit, 4), f"± {readable(one.half_width, one.unit, 2)}", spread(one))
            for name, one in self.plan.expected.items()
        ]
        table = named(("", "value", "95 % to be expected", "in most runs"), described)
        total = readable(sum(self.plan.lasting), "s")
        blocks = self.blocks
        with_blocks = f"; these records tell {blocks} slip blocks: identify gms --blocks {blocks}" if blocks else ""
        records = Table(("record", "time", "what to run"), rows)
        return [records, table, f"{total} altogether{with_blocks}", *([GOOD_TO] if described else [])]

    @cached_property
    def moves(self) -> list[Move | Arc]:
        """What controllers run, in the order of the plan."""
        made: list[Move | Arc] = []
        for one in self.plan.planned:
            if one.kind == "circle":
                s = {name: value for name, value in one.settings.items() if not isinstance(value, tuple)}
                axes = (self.plan.axis.name, "y" if self.plan.axis.name != "y" else "x")
                feed = f"{1e3 * s['feed']:g}".replace(".", "-")
                name = f"circle-{feed}-mm-s"
                made.append(Arc(len(made) + 1, name, axes, s["radius"], s["feed"], int(s["revolutions"])))
            for trial in one.trials(self.plan.axis):
                begin, end = (n / trial.reference.sampling for n in trial.window)
                about = (len(made) + 1, trial.name, self.plan.axis.name, self.plan.axis.motion)
                made.append(Move(*about, trial.reference, (begin, end), trial.excitation))
        return made

    def files(self) -> dict[str, dict[str, str]]:
        """Return the programs of each dialect by folder and file name."""
        return {
            name: {
                file: text
                for one in self.moves
                for file, text in (dialect.arc(one) if isinstance(one, Arc) else dialect.move(one)).items()
            }
            for name, dialect in DIALECTS.items()
        }

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write a folder: plan.yaml, and a folder of programs for each dialect."""
        programs = {f"{name}/{file}": text for name, files in self.files().items() for file, text in files.items()}
        write_folder(Path(path), {"plan.yaml": dump(self.document), **programs}, force=force)


def spread(one: Expected) -> str:
    """Return between which two the half-widths of single runs lie, for people."""
    least, most = (readable(half, one.unit, 2) for half in one.between)
    return f"{least} … {most}"


def settings_in_words(one: Planned, motion: Any) -> str:
    """Return what an experiment is run with, for people."""
    described = []
    for name, value in one.settings.items():
        unit = si_unit(SETTINGS[name], motion)
        if isinstance(value, tuple):
            shown = [readable(v, unit) for v in value]
            described.append(
                f"{name} {', '.join(shown) if len(shown) < 4 else f'{shown[0]} … {shown[-1]} ({len(shown)})'}"
            )
        else:
            described.append(f"{value:g} {name}" if SETTINGS[name] == "ratio" else f"{name} {readable(value, unit)}")
    return ", ".join(described)


@verb
def plan(
    *,
    stroke: float | str,
    feed: float | str,
    acceleration: float | str = 5.0,
    machine: Any = None,
    axis: str = "x",
    friction: Any = None,
    plant: Any = None,
    accuracy: Mapping[str, float | str] | Sequence[str] = (),
    noise: float | str | None = None,
    encoder: float | str | None = None,
    like: Any = None,
    draws: int = DRAWS,
    advance: Advance = silent,
) -> PlanResult:
    """Plan the records that identify an axis, inside its stroke, feed and acceleration.

    Parameters
    ----------
    stroke, feed, acceleration
        What the axis may do [m], [m/s], [m/s²], also as texts with units.
    machine
        The machine, its file, or the name of a bundled one; a typical one where not given.
    axis
        Name of the axis.
    friction
        What is known of its friction: a friction file of this axis, or a result.
    plant
        What is known of its plant, and how its response scattered: a plant file of this axis, or a result.
    accuracy
        Half-widths that are asked for, by parameter: a share as ``2%``, or a quantity; also as ``F_s=2%``.
    noise, encoder, like
        Force noise, rms [N], and encoder step [m] of its logs, or a typical log.
    draws
        Times that the plan is run and identified to see what to expect.
    advance
        Is told of each record simulated, and each identification.

    Raises
    ------
    FricError
        When the limits leave no room, or an accuracy is of no parameter.
    """
    subject, notices = prior_axis(machine, axis, friction, noise=noise, encoder=encoder, like=like, plant=plant)
    known = None if friction is None else document_of("plan", FrictionDocument, friction)
    responded = None if plant is None else document_of("plan", PlantDocument, plant)
    limits = Limits(
        in_si(stroke, "position", subject.motion), in_si(feed, "velocity", subject.motion),
        in_si(acceleration, "acceleration", subject.motion),
    )  # fmt: skip
    wanted = _accuracies(accuracy, subject)
    times: dict[str, int] = {}
    while True:
        planned = choose(subject, limits, times)
        found = expected(subject, planned, advance, draws, known, responded)
        more = _more(wanted, found, times)
        if more == times:
            break
        times = more
    notices += _missed(wanted, found)
    named = TYPICAL if machine is None else str(machine) if isinstance(machine, str | Path) else "a machine"
    prior = f"axis {subject.name} of {named}"
    prior += f" with the friction of {friction}" if isinstance(friction, str | Path) else ""
    if subject.motion == "rotary":
        planned = tuple(one for one in planned if one.kind != "circle")
    prior += f" and the plant of {plant}" if isinstance(plant, str | Path) else ""
    made = Plan(subject, limits, planned, list(durations(subject, planned)), found.parameters)
    return PlanResult(made, found.blocks, prior, [*notices, *found.notices])


def _accuracies(given: Mapping[str, float | str] | Sequence[str], axis: Axis) -> dict[str, tuple[float, bool]]:
    """Return the half-width asked for by parameter, and whether it is relative to the value."""
    pairs = given.items() if isinstance(given, Mapping) else (one.partition("=")[::2] for one in given)
    dimensions = {p.name: p.dimension for name in ("static", "gms") for p in models()[name].parameters}
    dimensions |= {"offset": "force", **PlantPart.dimensions}
    known = {name for names in IDENTIFIED_BY.values() for name in names}
    found = {}
    for name, value in pairs:
        if name not in known:
            raise FricError(f"'{name}' is no parameter that a plan tells", hint=f"{near(name, known)}As in F_s=2%.")
        text = str(value).strip()
        share = text.endswith("%")
        try:
            number = float(text[:-1]) / 100 if share else in_si(value, dimensions[name], axis.motion)
        except ValueError:
            raise FricError(f"'{text}' is no accuracy of {name}", hint="Write it as F_s=2%, or F_s=1 N.") from None
        if not number > 0:
            raise FricError(f"an accuracy of {text} for {name} is not positive")
        found[name] = (number, share)
    return found


def _lacks(wanted: Mapping[str, tuple[float, bool]], found: Expectation) -> Iterator[tuple[str, float]]:
    """Yield each parameter asked for, and the half-width to be expected over the one asked for; of blocks the worst."""
    for name, (target, relative) in wanted.items():
        of = [one for key, one in found.parameters.items() if key == name or key.rpartition("_")[0] == name]
        yield name, max((one.half_width / (target * (abs(one.value) if relative else 1.0)) for one in of), default=inf)


def _more(wanted: Mapping[str, tuple[float, bool]], found: Expectation, times: Mapping[str, int]) -> dict[str, int]:
    """Return how many times as many strokes, cycles or periods to take: a half-width falls with their root."""
    more = dict(times)
    for name, lack in _lacks(wanted, found):
        kind = next(kind for kind, names in IDENTIFIED_BY.items() if name in names)
        if lack > 1.0:
            needed = times.get(kind, 1) * lack**2 if isfinite(lack) else MOST
            more[kind] = max(more.get(kind, 1), min(ceil(needed), MOST))
    return more


def _missed(wanted: Mapping[str, tuple[float, bool]], found: Expectation) -> list[Notice]:
    return [
        PLAN_ACCURACY.found(name=name, lack=lack, times=MOST)
        for name, lack in _lacks(wanted, found)
        if lack > 1.0
    ]  # fmt: skip
