"""A plan: the records to take of an axis, programs that make its motions, and the intervals to be expected.

After a first identification: the further record that would narrow the predicted glitch most.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise, product
from pathlib import Path
from typing import Annotated, Any

from fric.documents.friction import FrictionDocument
from fric.documents.plan import SETTINGS, plan_tree
from fric.documents.plant import PlantDocument, PlantPart
from fric.documents.yaml import dump
from fric.drive.sensing import Encoder
from fric.errors import FricError, near
from fric.export.motion import DIALECTS, Arc, Move
from fric.flaws.prediction import PLAN_FRICTION_ALONE
from fric.friction import models
from fric.friction.stribeck import StaticMap
from fric.notice import Notice
from fric.output import write_folder
from fric.planning.choose import KIND_OF, TYPICAL, Wanted, durations, narrowing, planned_for, prior_axis
from fric.results.base import Advance, Piece, Result, Table, bounded, in_si, logs_of, plain_names, positive, silent
from fric.results.given_models import document_of, friction_of, machine_of, schemes_of
from fric.results.kinds import AxisName, FrictionLike, LogLike, MachineLike, PlantLike, Quantity, SchemesLike
from fric.simulate.experiment import Limits, Narrowing, Plan, Planned
from fric.simulate.machine import Axis
from fric.units import prefixed, readable, rotates, si_unit, significant
from fric.verb import Kind, verb

GOOD_TO = "expected half-widths are those of simulated records, and good to ± 20 %"  # Simulated records vary by chance


class PlanResult(Result, tree=plan_tree):
    """Records to take of an axis."""

    plan: Plan  # The records to take, and their expected results
    blocks: int | None  # Slip blocks that the identification will find; None where it finds no GMS model
    prior: str  # The axis that was assumed, in words
    notices: Sequence[Notice]  # Substitutes for unknown properties, and what cannot be expected
    narrowing: Narrowing | None = None  # Effect of a further record after a first result

    def report(self) -> list[Piece]:
        """Return the experiments, and the expected half-widths."""
        rows = [
            (record.kind, readable(lasting, "s"), settings_in_words(record, self.plan.axis.motion))
            for record, lasting in zip(self.plan.planned, self.plan.lasting, strict=True)
        ]
        described = []
        for name, expected in self.plan.expected.items():
            size = max(abs(expected.value), min(expected.half_width, 1e3 * abs(expected.value)))
            scale, unit = prefixed(size, expected.unit)
            half, *most = (significant(scale * width, 2) for width in (expected.half_width, *expected.between))
            described.append([name, significant(scale * expected.value, 4), half, " … ".join(most), unit])
        names = plain_names(self.plan.expected)
        columns = ("", "value", "± 95 %", "single runs", "unit", "what it is")
        table = Table(columns, [(*row, name) for row, name in zip(described, names, strict=True)])
        total = readable(sum(self.plan.lasting) + self.approaching, "s")
        speed = readable(self.plan.limits.approach, si_unit("velocity", self.plan.axis.motion))
        blocks = self.blocks
        with_blocks = [f"they resolve {blocks} slip blocks: identify gms --blocks {blocks}"] if blocks else []
        records = Table(("record", "time", "what to run"), rows)
        altogether = [f"{total} in all, with approaches at {speed}", *with_blocks]
        return [records, table, *altogether, *([GOOD_TO] if described else [])]

    @cached_property
    def moves(self) -> list[Move | Arc]:
        """The programs for controllers, in the order of the plan."""
        made: list[Move | Arc] = []
        approach = self.plan.limits.approach
        for record in self.plan.planned:
            if record.kind == "circle":
                s = {name: value for name, value in record.settings.items() if not isinstance(value, tuple)}
                axes = (self.plan.axis.name, "y" if self.plan.axis.name != "y" else "x")
                name = f"circle-{1e3 * s['feed']:g}-mm-s".replace(".", "-")
                made.append(Arc(len(made) + 1, name, axes, s["radius"], s["feed"], int(s["revolutions"]), approach))
            for trial in record.trials(self.plan.axis):
                begin, end = (n / trial.reference.sampling for n in trial.window)
                about = (len(made) + 1, trial.name, self.plan.axis.name, self.plan.axis.motion)
                made.append(Move(*about, trial.reference, (begin, end), approach, trial.excitation))
        return made

    @property
    def approaching(self) -> float:
        """Time from the end of each motion to the begin of the next [s]; to the first it is from the middle."""
        ways = [move.ends for move in self.moves]
        return sum(abs(b[0] - a[1]) for a, b in pairwise([(0.0, 0.0), *ways])) / self.plan.limits.approach

    def files(self) -> dict[str, dict[str, str]]:
        """Return the programs of each dialect by folder and file name."""
        found = {name: dict[str, str]() for name in DIALECTS}
        for move, (name, dialect) in product(self.moves, DIALECTS.items()):
            found[name] |= dialect.arc(move) if isinstance(move, Arc) else dialect.move(move)
        return found

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write a folder: plan.yaml, and a folder of programs for each dialect."""
        programs = {f"{name}/{file}": text for name, files in self.files().items() for file, text in files.items()}
        write_folder(Path(path), {"plan.yaml": dump(self.document), **programs}, force=force)


class NextRecordResult(PlanResult):
    """A plan of a further record: of all candidates the one that narrows the predicted glitch most."""

    def report(self) -> list[Piece]:
        """Return the candidates in order, and the causes of the glitch's uncertainty."""
        found = self.narrowing
        assert found is not None
        rows = [
            (
                candidate.planned.kind, readable(candidate.lasting, "s"), readable(candidate.half_width, "m", 2),
                f"{candidate.half_width / found.half_width - 1:+.0%}".replace("-", "−"),
                settings_in_words(candidate.planned, self.plan.axis.motion),
            )
            for candidate in found.candidates
        ]  # fmt: skip
        shares = dict[str, float]()
        for name, share in found.shares.items():  # those of blocks depend on each other: alone some are above 1
            symbol = "alpha and k" if name.startswith(("alpha_", "k_")) else name
            shares[symbol] = shares.get(symbol, 0.0) + share
        described = ", ".join(
            f"{name} {share:.0%}" for name, share in sorted(shares.items(), key=lambda item: -item[1]) if share > 0.02
        )
        feed, radius = readable(found.test.feed, "m/s"), readable(found.test.radius, "m")
        return [
            f"the glitch of scheme ({found.scheme}) at {feed} on a circle of {radius} is known to "
            f"± {readable(found.half_width, 'm', 2)}, for {described}",
            Table(("one more record", "time", "then ±", "", "what to run"), rows),
            f"{GOOD_TO}; of records that differ by less the shorter one comes first",
        ]


def settings_in_words(record: Planned, motion: Any) -> str:
    """Return what an experiment is run with, for people."""
    described = []
    for name, value in record.settings.items():
        unit = si_unit(SETTINGS[name], motion)
        if SETTINGS[name] == "ratio":
            described.append(f"{value:g} {name.removesuffix('s') if value == 1 else name}")
            continue
        shown = [readable(v, unit) for v in (value if isinstance(value, tuple) else (value,))]
        listed = ", ".join(shown) if len(shown) < 4 else f"{shown[0]} … {shown[-1]} ({len(shown)})"
        described.append(f"{name} {listed}")
    return ", ".join(described)


@verb
def plan(
    *, stroke: Annotated[Quantity, "position"], feed: Annotated[Quantity, "velocity"],
    acceleration: Annotated[Quantity, "acceleration"] = "5 m/s^2", friction: FrictionLike | None = None,
    plant: PlantLike | None = None, machine: MachineLike | None = None, axis: AxisName = "x",
    accuracy: Annotated[Mapping[str, Quantity] | Sequence[str], Kind(list[str], "F_s=2%")] = (),
    noise: Annotated[Quantity | None, "force"] = None, encoder: Annotated[Quantity | None, "position"] = None,
    like: LogLike | None = None, micro_steps: bool = False,
    draws: Annotated[int | None, Kind(least=1, most=1000)] = None, advance: Advance = silent,
) -> PlanResult:  # fmt: skip
    """Plan the records that identify an axis, with the intervals to expect; or the most useful further record.

    The latter is `plan_next`. All motions stay within stroke, feed and acceleration.

    stroke: Travel of the axis, as "300 mm".
    feed: Largest speed, as "100 mm/s".
    acceleration: Largest acceleration.
    friction: Known friction of the axis. A friction file of this axis, or a result.
    plant: Known plant of the axis, with its scatter. A plant file of this axis, or a result.
    machine: Plant, controller, encoder and noise; by default typical. The machine, its file, or the name of a bundled
        machine.
    axis: The axis, if no friction names it.
    accuracy: Requested half-width; repeatable. By parameter: a share as ``2%``, or a quantity.
    noise: Noise of a logged force (rms), as "1 N".
    encoder: Encoder step, as "0.25 um".
    like: A typical log, which shows noise and encoder.
    micro_steps: A staircase of small steps instead of the sines before sliding, for a drive without them.
    draws: Number of simulated runs of the plan to find the expected intervals; seven, or three where these take long:
        of an axis with a second mass or flaws, and of records that last over 100 s.
    Raises FricError: When the limits leave no room, or an accuracy is of no parameter.
    """
    subject, notices, known, responded = _prior(machine, axis, friction, plant, noise=noise, encoder=encoder, like=like)
    limits = _limits(stroke, feed, acceleration, subject)
    wanted = _accuracies(accuracy, subject)
    planned, found = planned_for(subject, limits, wanted, advance, draws, known, responded, micro_steps=micro_steps)
    named = TYPICAL if machine is None else str(machine) if isinstance(machine, str | Path) else "a machine"
    prior = f"axis {subject.name} of {named}"
    prior += f" with the friction of {friction}" if isinstance(friction, str | Path) else ""
    if rotates(subject.motion):
        planned = tuple(record for record in planned if record.kind != "circle")
    prior += f" and the plant of {plant}" if isinstance(plant, str | Path) else ""
    made = Plan(subject, limits, planned, list(durations(subject, planned)), found.parameters)
    return PlanResult(made, found.blocks, prior, [*notices, *found.notices])


def _prior(
    machine: Any, axis: str, friction: Any, plant: Any = None, *, noise: Any, encoder: Any, like: Any
) -> tuple[Axis, list[Notice], FrictionDocument | None, PlantDocument | None]:
    """Return the axis as known beforehand, the substitutes for what is unknown, and its friction and plant."""
    subject = None if machine is None else machine_of(machine)
    if isinstance(friction, StaticMap):
        known = friction_of(friction, axis, "linear" if subject is None else subject.axis(axis).motion)
    else:
        known = None if friction is None else document_of(FrictionDocument, friction)
    of = None if known is None else (known.axis, known.motion)
    responded = None if plant is None else document_of(PlantDocument, plant, of, "friction")
    found, notices = prior_axis(subject, axis, known, responded, () if like is None else logs_of([like]))
    if encoder is not None:
        found = replace(found, encoder=Encoder(in_si(encoder, "small length", found.motion)))
    if noise is not None:
        found = replace(found, force_noise=in_si(noise, "force", found.motion))
    return found, notices, known, responded


def _limits(stroke: float | str, feed: float | str, acceleration: float | str, axis: Axis) -> Limits:
    return Limits(
        bounded("travel-limit", stroke, axis.motion), bounded("speed", feed, axis.motion),
        bounded("acceleration", acceleration, axis.motion),
    )  # fmt: skip


def _accuracies(given: Mapping[str, float | str] | Sequence[str], axis: Axis) -> Wanted:
    """Return the half-width asked for by parameter, and whether it is relative to the value."""
    pairs = given.items() if isinstance(given, Mapping) else (text.partition("=")[::2] for text in given)
    dimensions = {p.name: p.dimension for name in ("static", "gms") for p in models()[name].parameters}
    dimensions |= {"offset": "force", **PlantPart.dimensions}
    found, known = {}, ", ".join(KIND_OF)
    for name, value in pairs:
        if name not in KIND_OF:
            hint = f"{near(name, KIND_OF)}There are {known}: as F_s=2%."
            raise FricError(f"'{name}' is not a parameter of a plan", hint=hint)
        text = str(value).strip()
        share = text.endswith("%")
        if isinstance(value, str) and text.replace(".", "", 1).isdigit():
            raise FricError(
                f"the accuracy '{name}={text}' has no unit", hint=f"Say a share, as {name}={text}%, or a quantity."
            )
        found[name] = (positive(text if share else value, "ratio" if share else dimensions[name], axis.motion), share)
    return found


@verb
def plan_next(
    last: FrictionLike, *, stroke: Annotated[Quantity, "position"] = "300 mm",
    feed: Annotated[Quantity, "velocity"] = "100 mm/s", acceleration: Annotated[Quantity, "acceleration"] = "5 m/s^2",
    machine: MachineLike | None = None, scheme: SchemesLike = "c", noise: Annotated[Quantity | None, "force"] = None,
    encoder: Annotated[Quantity | None, "position"] = None, like: LogLike | None = None, advance: Advance = silent,
) -> NextRecordResult:  # fmt: skip
    """Find the further record that would narrow the predicted glitch of an axis most.

    last: The last result, to find the further record that narrows the predicted glitch most. A friction file with a GMS
        model and its covariance, or a result.
    stroke, feed, acceleration: Limits of the axis.
    machine: The machine that runs the circle: plant, controller, the other axis; a typical one where not given.
    scheme: Scheme whose predicted glitch is to be narrowed, after a last result.
    noise, encoder, like: As in `plan`.
    Raises FricError: When the file has no GMS model with covariance, or the machine no two axes.
    """
    document = document_of(FrictionDocument, last)
    axis, notices, _, _ = _prior(machine, "", document, noise=noise, encoder=encoder, like=like)
    described = [document.fit_of(section).covariance for section in ("static", "gms") if section in document.sections()]
    if len(described) < 2 or not all(described):
        raise FricError(
            "the friction file does not tell how static map and GMS model err",
            hint="It takes one of `fric identify gms --static`; `fric plan --friction` says which records that takes.",
        )
    (chosen,) = schemes_of(scheme)
    subject = machine_of(TYPICAL if machine is None else machine)
    if axis.name not in subject.axes:
        axis = replace(axis, name="x")
    limits = _limits(stroke, feed, acceleration, axis)
    fit = document.fit_of("static")
    between = 0.0 if fit.between_strokes is None else float(fit.between_strokes.si("force", axis.motion))
    covariances = [block.covariance() for block in described if block is not None]
    found = narrowing(subject, axis, limits, covariances, between, chosen, advance)
    axis = replace(axis, name=document.axis)
    best = found.candidates[0]
    notices.append(PLAN_FRICTION_ALONE.found(scheme=chosen.name))
    made = Plan(axis, limits, (best.planned,), [best.lasting], {})
    return NextRecordResult(made, None, f"axis {axis.name} as identified last", notices, found)
