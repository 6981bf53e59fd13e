"""Models held against records: compared on held-out samples, and replayed in loops."""

from collections.abc import Sequence
from dataclasses import replace
from math import inf, isfinite
from pathlib import Path
from typing import Annotated, Any

from fric.circles.tune import wrong_shape, wrong_shape_measured
from fric.circles.validation import Validation, validate_closed_loop, validate_inverse, validate_open_loop
from fric.documents.comparison import ComparisonDocument, HalvesDocument, ValidationDocument
from fric.documents.plant import PlantDocument
from fric.drive.plant import hold_delay
from fric.errors import FricError
from fric.estimate import Estimate, estimate_rows
from fric.flaws.prediction import INVERSE_LEFT_OUT, T_D_BELOW_HOLD
from fric.friction import models as known_models
from fric.friction.stribeck import StaticMap
from fric.identify.halves import Halves
from fric.identify.halves import halves as find_halves
from fric.identify.replay import compare as scoring
from fric.io.circle import choose_circles, read_runs
from fric.io.recognise import recognise
from fric.log import Log
from fric.notice import Notice, once
from fric.records.flaws import even_sampling as sampling_of
from fric.records.prepared import prepared, without_loaded
from fric.results.base import Advance, DataFrame, Piece, Result, Table, in_si, logs_of, silent
from fric.results.given_models import cascade_of, document_of, friction_of, plant_of
from fric.results.kinds import Blocks, CircleFiles, ControllerLike, FrictionLike, LogLike, PlantLike, Quantity, Seed
from fric.units import readable, si_unit
from fric.verb import Kind, verb


class ComparisonResult(Result, schema=ComparisonDocument, of="comparison"):
    """Friction models by how well they predict held-out samples."""

    comparison: scoring.Comparison  # The scores, the best model first

    @property
    def logs(self) -> list[Log]:
        """The records."""
        return [record.log for record in self.comparison.records]

    def report(self) -> list[Piece]:
        """Return a line for each model, and whether one is surely the best."""
        unit = si_unit("force", self.comparison.records[0].log.motion)

        def left(score: scoring.Score | scoring.Baseline) -> tuple[str, str, str]:
            near = readable(score.rms_near, unit) if isfinite(score.rms_near) else "–"
            return score.name, readable(score.rms, unit), near

        rows = [
            (
                *left(score), readable(score.rms_fitted, unit), str(score.parameters),
                f"{score.bits_per_parameter:.0f}", f"{score.nanoseconds:.0f} ns",
            )
            for score in self.comparison.scores
        ]  # fmt: skip
        rows += [(*left(baseline), "", str(baseline.parameters), "", "") for baseline in self.comparison.baselines]
        columns = ("", "rms scored", "near reversals", "rms fitted", "parameters", "bits per parameter", "a step")
        return [Table(columns, rows), self._verdict()]

    def _verdict(self) -> str:
        found = self.comparison
        if found.winner:
            return f"best: {found.winner}, by more than the error of the difference to any other"
        plain = min(found.baselines, key=lambda baseline: baseline.rms)
        if plain.rms < found.scores[0].rms:
            return f"no winner: {plain.name} leaves less than any model"
        tied = [name for name, (lead, error) in found.leads.items() if not lead > error]
        return f"no winner: the lead of {found.scores[0].name} over {', '.join(tied) or 'nothing'} is within its error"

    def by_row(self) -> dict[str, dict[str, Any]]:
        """Return the scores by model, forces in SI."""
        return {
            name: {key: value for key, value in score.items() if key not in {"records", "estimates"}}
            for name, score in self.document["models"].items()
        }


class HalvesResult(Result, schema=HalvesDocument, of="halves"):
    """How far apart the results of two halves of the records are."""

    halves: Halves  # Each parameter of each halving
    logs: Sequence[Log]  # The records

    def report(self) -> list[Piece]:
        """Return a line for each halving and parameter, and how many halves agree."""
        rows = []
        for halved in self.halves.found:
            ((_, first, width, unit), (_, second, other, _)) = estimate_rows({"a": halved.first, "b": halved.second})
            both = f"{first} ({width})", f"{second} ({other})"
            rows.append((halved.by, halved.parameter, *both, unit, f"{halved.half_widths:.2f}"))
        columns = ("halved by", "", "first half", "second half", "unit", "half-widths apart")
        untold = [f"{by}: {why}" for by, why in self.halves.untold.items()]
        return [Table(columns, rows), self.halves.conclusion, *untold]

    def by_row(self) -> dict[str, dict[str, Any]]:
        """Return by how many half-widths the halves differ, by halving and parameter."""
        return {f"{halved.by} {halved.parameter}": {"half_widths": halved.half_widths} for halved in self.halves.found}


@verb
def compare(
    *logs: LogLike, models: Annotated[str | Sequence[str], Kind(str, "all|NAME,NAME…")] = "all",
    fit_on: Annotated[str | Sequence[str] | None, Kind(list[str], "RECORD", "records")] = None,
    cycles: Annotated[int | None, Kind(metavar="N", least=1, most=10**6)] = None,
    folds: Annotated[int, Kind(least=2, most=100)] = 3, halves: bool = False, static: FrictionLike | None = None,
    plant: PlantLike | None = None, blocks: Blocks = 4, seed: Seed = 0, circles: CircleFiles = (),
    advance: Advance = silent,
) -> ComparisonResult | HalvesResult:  # fmt: skip
    """Fit friction models to some records or cycles and score them on others.

    models: Models to compare, by name.
    fit_on: Fit on this record, score on those not named; repeatable.
    cycles: Fit on the first N cycles of a record, score on the rest.
    folds: Cut each record into N parts, each scored by a fit to the others. The default.
    halves: Compare halves of strokes and motions instead, split by time, record, direction and place.
    circles: Runs or measured tests of one circle, learned and with a friction model: they check the model's shape.
        Ingest the learned one with ``--scheme learned``. If learning leaves clearly less, a warning says that the shape
        is wrong.
    Raises FricError: When there is no such model, or nothing to fit or to score.
    """
    if models == "all":
        names = [name for name, model in known_models().items() if model.identified]
    else:
        names = [name.strip() for name in (models.split(",") if isinstance(models, str) else models)]
    if fit_on and cycles:
        raise FricError("`fit_on=` and `cycles=` are two ways to split", hint="Give one of them.")
    records = logs_of(logs)
    axis, motion = records[0].axis, records[0].motion
    if halves:
        return HalvesResult(find_halves(records, plant_of(plant, axis, motion)), records)
    kept = friction_of(static, axis, motion)
    held = kept.estimates("static") if kept else {}
    if models == "all" and held.keys() >= {parameter.name for parameter in StaticMap.parameters}:
        names.remove(StaticMap.name)  # all of it is given
    ready, loaded = without_loaded(prepared(records, plant_of(plant, axis, motion)))
    if fit_on:
        splits = scoring.split_by_record(ready, [fit_on] if isinstance(fit_on, str) else list(fit_on))
    else:
        splits = scoring.split_by_cycles(ready, cycles) if cycles else scoring.split_by_folds(ready, folds)
    advance(0, total=len(names))
    settings: dict[str, Any] = {"blocks": blocks, "seed": seed, "advance": advance}
    if kept:
        settings |= {"static": held, "negative": kept.backward()}
    found = scoring.compare_models(names, ready, splits, **settings)
    paths = [Path(path) for path in circles]
    measured = [path for path in paths if recognise(path).startswith("circle/")]
    runs = [run for path in paths if path not in measured for run in read_runs(path, traces=False)]
    notices = wrong_shape((run.scheme, run.contour.glitch) for run in runs)
    notices += wrong_shape_measured(choose_circles(measured))
    return ComparisonResult(replace(found, warnings=(*found.warnings, *loaded, *notices)))


class ValidationResult(Result, schema=ValidationDocument):
    """Records, and their replay by the identified axis."""

    validations: Sequence[Validation]  # A validation for each record and loop
    logs: Sequence[Log]  # The records
    notices: Sequence[Notice] = ()  # Warnings of the files

    @property
    def warnings(self) -> Sequence[Notice]:
        """Warnings of the files, and of the recorded controller and voltage."""
        return once([*self.notices, *(text for validation in self.validations for text in validation.warnings)])

    def report(self) -> list[Piece]:
        """Return relative and rms error of each signal."""
        rows = []
        for found in self.validations:
            title, motion = f"{found.log.name}, {found.loop} loop, {found.friction.name}", found.log.motion
            for name, signal in found.signals.items():
                relative = f"{100 * signal.relative:.4g} %" if signal.relative < inf else "at rest"
                rows.append((title, name, relative, readable(signal.rms, si_unit(name, motion))))
        return [Table(("", "signal", "relative error", "rms error"), rows)]

    def to_frame(self) -> DataFrame:
        """Return the errors by record, loop and signal, in SI."""
        import pandas as pd

        rows = [
            {"record": found["record"], "loop": found["loop"], "signal": name, **signal}
            for found in self.document["validations"] for name, signal in found["signals"].items()
        ]  # fmt: skip
        return pd.DataFrame(rows).set_index(["record", "loop", "signal"])


@verb
def validate(
    *logs: LogLike, plant: PlantLike, controller: ControllerLike | None = None, friction: FrictionLike | None = None,
    model: Annotated[str | None, Kind(metavar="NAME")] = None, load: Annotated[Quantity | None, "force"] = None,
) -> ValidationResult:  # fmt: skip
    """Replay a recorded motion in closed loop, in open loop and inversely, and score it against the record.

    plant: The identified plant. Its file or its result.
    controller: The drive's controller; without it, only the open loop. A `Cascade`, its file or its result.
    friction: The identified friction; by default Coulomb friction of the plant's fit. Its file or its result.
    model: The friction file's model, if it contains several.
    load: Constant load, as "-3.2 N"; by default the identified offset.
    Raises FricError: When a channel is missing, a file is of another axis, or several friction models leave the choice
        open.
    """
    records = logs_of(logs)
    axis, motion = records[0].axis, records[0].motion
    if model and friction is None:
        raise FricError("`model=` names a model of a friction file", hint="Give that file with `friction=`.")
    document = document_of(PlantDocument, plant, (axis, motion))
    identified = document.plant(motion)
    cascade = cascade_of(controller, axis, motion)
    text = friction_of(friction, axis, motion)
    done, short = list[Validation](), list[Notice]()
    measured = replace(identified, T_d=0.0) if document.T_d.assumed else identified
    law, offset = text.found_with(model) if text else document.coulomb()
    weight = offset if load is None else in_si(load, "force", motion)
    for log in records:
        if cascade:
            done.append(validate_closed_loop(log, identified, cascade, law, weight))
        done.append(validate_open_loop(log, identified, law, weight))
        try:
            done.append(validate_inverse(log, measured, law, weight))
        except FricError as error:
            short.append(INVERSE_LEFT_OUT.found(log.name, why=error.what))
        if identified.T_d < hold_delay(sampling_of(log)):
            short.append(T_D_BELOW_HOLD.found(log.where, T_d=Estimate(identified.T_d, "s")))
    return ValidationResult(done, records, (*document.passed_on(), *short))
