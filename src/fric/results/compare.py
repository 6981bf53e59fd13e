"""Friction models compared on held-out samples."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Annotated, Any

from fric.circles.next_circle import wrong_shape, wrong_shape_measured
from fric.documents.comparison import ComparisonDocument, HalvesDocument
from fric.errors import FricError
from fric.estimate import estimate_rows
from fric.friction import models as known_models
from fric.identify.halves import Halves
from fric.identify.halves import halves as find_halves
from fric.identify.replay.compare import (
    Baseline,
    Comparison,
    Score,
    compare_models,
    split_by_cycles,
    split_by_folds,
    split_by_record,
)
from fric.io.circle import choose_circles
from fric.io.recognise import recognise
from fric.io.run import read_runs
from fric.log import Log
from fric.records.prepared import prepared, without_loaded
from fric.results.base import Result
from fric.results.given import Advance, logs_of, silent
from fric.results.given_models import friction_of, plant_of
from fric.results.kinds import CircleFiles, Count, FrictionLike, LogLike, PlantLike, Seed
from fric.results.text import Piece, Table
from fric.units import readable, si_unit
from fric.verb import Kind, verb


@dataclass(frozen=True, eq=False, repr=False)
class ComparisonResult(Result, schema=ComparisonDocument, of="comparison"):
    """Friction models by how well they predict held-out samples."""

    comparison: Comparison  # The scores, the best model first

    @property
    def logs(self) -> list[Log]:
        """The records."""
        return [record.log for record in self.comparison.records]

    def report(self) -> list[Piece]:
        """Return a line for each model, and whether one is surely the best."""
        unit = si_unit("force", self.comparison.records[0].log.motion)

        def left(one: Score | Baseline) -> tuple[str, str, str]:
            near = readable(one.rms_near, unit) if isfinite(one.rms_near) else "–"
            return one.name, readable(one.rms, unit), near

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


@dataclass(frozen=True, eq=False, repr=False)
class HalvesResult(Result, schema=HalvesDocument, of="halves"):
    """How far apart the results of two halves of the records are.

    halves: Each parameter of each halving.
    logs: The records.
    """

    halves: Halves
    logs: Sequence[Log]

    def report(self) -> list[Piece]:
        """Return a line for each halving and parameter, and how many halves agree."""
        rows = []
        for halved in self.halves.found:
            ((_, first, width, unit), (_, second, other, _)) = estimate_rows({"a": halved.first, "b": halved.second})
            rows.append(
                (
                    halved.by,
                    halved.parameter,
                    f"{first} ({width})",
                    f"{second} ({other})",
                    unit,
                    f"{halved.half_widths:.2f}",
                )
            )
        columns = ("halved by", "", "first half", "second half", "unit", "half-widths apart")
        untold = [f"{by}: {why}" for by, why in self.halves.untold.items()]
        return [Table(columns, rows), self.halves.conclusion, *untold]

    def by_row(self) -> dict[str, dict[str, Any]]:
        """Return by how many half-widths the halves differ, by halving and parameter."""
        return {f"{halved.by} {halved.parameter}": {"half_widths": halved.half_widths} for halved in self.halves.found}


@verb
def compare(
    *logs: LogLike,
    models: Annotated[str | Sequence[str], Kind(str, "all|NAME,NAME…")] = "all",
    fit_on: Annotated[str | Sequence[str] | None, Kind(list[str], "RECORD", "records")] = None,
    cycles: Annotated[int | None, Kind(metavar="N", least=1)] = None,
    folds: Annotated[int, Kind(least=2, most=100)] = 3,
    halves: bool = False,
    static: FrictionLike | None = None,
    plant: PlantLike | None = None,
    blocks: Count = 4,
    seed: Seed = 0,
    circles: CircleFiles = (),
    advance: Advance = silent,
) -> ComparisonResult | HalvesResult:
    """Fit friction models to some records or cycles and score them on others.

    Parameters
    ----------
    models
        Models to compare, by name.
    fit_on
        Fit on this record, score on those not named; repeatable.
    cycles
        Fit on the first N cycles of a record, score on the rest.
    folds
        Cut each record into N parts, each scored by a fit to the others. The default.
    halves
        Compare halves of strokes and motions instead, split by time, record, direction and place.
    circles
        Runs or measured tests of one circle, learned and with a friction model: they check the model's shape. Ingest
        the learned one with ``--scheme learned``. If learning leaves clearly less, a warning says that the shape is
        wrong.

    Raises
    ------
    FricError
        When there is no such model, or nothing to fit or to score.
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
    ready, loaded = without_loaded(prepared(records, plant_of(plant, axis, motion)))
    if fit_on:
        splits = split_by_record(ready, [fit_on] if isinstance(fit_on, str) else list(fit_on))
    else:
        splits = split_by_cycles(ready, cycles) if cycles else split_by_folds(ready, folds)
    advance(0, total=len(names))
    settings: dict[str, Any] = {"blocks": blocks, "seed": seed, "advance": advance}
    if kept:
        settings |= {"static": kept.estimates("static"), "negative": kept.backward()}
    found = compare_models(names, ready, splits, **settings)
    paths = [Path(path) for path in circles]
    measured = [path for path in paths if recognise(path).startswith("circle/")]
    runs = [run for path in paths if path not in measured for run in read_runs(path, traces=False)]
    notices = wrong_shape((run.scheme, run.contour.glitch) for run in runs)
    notices += wrong_shape_measured(choose_circles(measured))
    return ComparisonResult(replace(found, warnings=(*found.warnings, *loaded, *notices)))
