"""Friction models compared on held-out samples."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Mask, Real
from fric.choice import ranked
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.drift import RECORDS_VARY
from fric.friction import FrictionModel
from fric.friction.stribeck import StaticMap
from fric.identify.replay.replay_fit import ReplayFit, identify_by_replay, record_notices
from fric.notice import Notice
from fric.records.prepared import Prepared
from fric.threads import one_blas_thread

Masks = tuple[Mask, ...]


@dataclass(frozen=True)
class Split:
    """The samples to fit and to score, as a mask for each record."""

    fitted: Masks  # fitted, scored: masks of the records' samples, each of shape (n,)
    scored: Masks


def split_by_record(records: Sequence[Prepared], fitted: Sequence[str]) -> tuple[Split, ...]:
    """Return a split: fit the records of these names, score the others.

    Raises FricError: When a name has no record, or no record is left to score.
    """
    names = [record.log.name for record in records]
    for name in fitted:
        if name not in names:
            raise FricError(f"there is no record '{name}'", hint=f"The records are {', '.join(names)}.")
    if set(names) <= set(fitted):
        raise FricError("every record is fitted, and none is left to score", hint="Leave one out of `fit_on=`.")
    none = [np.zeros(len(record.force), bool) for record in records]
    chosen = [record.used if name in fitted else no for record, name, no in zip(records, names, none, strict=True)]
    others = [no if name in fitted else record.used for record, name, no in zip(records, names, none, strict=True)]
    return (Split(tuple(chosen), tuple(others)),)


def split_by_cycles(records: Sequence[Prepared], cycles: int) -> tuple[Split, ...]:
    """Return a split: fit the first cycles of every record after its first reversal, score the rest.

    Raises FricError: When a record has no more cycles than that.
    """
    fitted, scored = [], []
    for record in records:
        if len(record.reversals) < 2 * cycles + 2:
            raise FricError(
                f"there are {max(len(record.reversals) - 1, 0) // 2} cycles", where=record.log.where,
                hint="Fit fewer of them, and leave some to score.",
            )  # fmt: skip
        first = np.arange(len(record.force)) < record.reversals[2 * cycles]
        fitted.append(record.used & first)
        scored.append(record.used & ~first)
    return (Split(tuple(fitted), tuple(scored)),)


def split_by_folds(records: Sequence[Prepared], folds: int) -> tuple[Split, ...]:
    """Return ``folds`` splits: each record is cut into as many parts, each of which a fit to the others scores."""
    part = [(np.cumsum(record.used) - 1) * folds // max(int(record.used.sum()), 1) for record in records]
    return tuple(
        Split(
            tuple(record.used & (p != fold) for record, p in zip(records, part, strict=True)),
            tuple(record.used & (p == fold) for record, p in zip(records, part, strict=True)),
        )
        for fold in range(folds)
    )


NEAR = 0.3
"""Time after a reversal that counts as near it [s]."""
LENGTHS = 10.0
"""Pre-sliding lengths after a reversal that count as near it."""


def presliding_length(record: Prepared) -> float:
    """Return the median travel after a reversal [m] in which the force makes nine tenths of its change.

    For a record without two reversals it is a hundredth of its travel.
    """
    z, found = record.motion.position, []
    for begin, end in zip(record.reversals[:-1], record.reversals[1:], strict=True):
        force = record.force[begin:end]
        if len(force) < 8:
            continue
        tail = float(np.median(force[len(force) // 2 :]))
        share = (force - force[0]) / (tail - force[0]) if tail != force[0] else np.zeros_like(force)
        passed = np.flatnonzero(share >= 0.9)
        if len(passed):
            found.append(abs(float(z[begin + passed[0]] - z[begin])))
    return float(np.median(found)) if found else 0.01 * float(np.ptp(z))


def near_reversals(record: Prepared, presliding: float) -> Mask:
    """Return the samples within 0.3 s or ten pre-sliding lengths [m] after a reversal, shape (n,)."""
    near = np.zeros(len(record.force), bool)
    t, z = record.motion.time, record.motion.position
    for begin, end in zip(record.reversals, [*record.reversals, len(t)][1:], strict=True):
        part = slice(int(begin), int(end))
        near[part] = (t[part] - t[begin] < NEAR) | (np.abs(z[part] - z[begin]) < LENGTHS * presliding)
    return near


@dataclass(frozen=True)
class Score:
    """Score of a model."""

    name: str  # The model
    fits: tuple[ReplayFit, ...]  # Its fit in each split
    parameters: int  # Number of parameters that were fitted
    # Measured minus replayed force [N] of each record, from the split that scores a sample; nan where none does
    residual: tuple[Real, ...]
    rms: float  # rms, rms_near: root mean square of that over all samples scored, and over those near reversals [N]
    rms_near: float
    rms_fitted: float  # Root mean square over the samples that were fitted, of all splits [N]
    # What the model saves of the description of the fitted samples against a constant force, by BIC [bit]: ``n·log2(rms
    # of the force/rms of the residual) - p/2·log2(n)``, with n the number of independent residuals of the model that
    # has most of them
    bits: float
    bits_per_parameter: float  # That, for each parameter
    nanoseconds: float  # Time of one replayed step [ns]

    @property
    def model(self) -> FrictionModel:
        """The model fitted by the first split."""
        return self.fits[0].model


@dataclass(frozen=True)
class Baseline:
    """Residual without a dynamic model: a useful model leaves less."""

    name: str  # What is subtracted
    parameters: int  # Number of parameters that were fitted
    residual: tuple[Real, ...]  # As of a `Score` [N]
    rms: float  # Root mean square of that over all samples scored [N]
    rms_near: float  # The same near reversals [N]


@dataclass(frozen=True)
class Comparison:
    """Friction models, the best first."""

    # The models by their rms; of those that differ by rounding the model of fewer parameters is first
    scores: tuple[Score, ...]
    records: tuple[Prepared, ...]  # The records
    near: Masks  # Which samples are near reversals, one mask a record
    # Pre-sliding length of each record [m]: the travel after a reversal until the force has changed by nine tenths
    presliding: tuple[float, ...]
    baselines: tuple[Baseline, ...]  # What is left without a dynamic model
    # The best model; None where its lead over another, or over a baseline, does not exceed the error of that lead
    winner: str | None
    # For each other model and baseline, how much lower the mean squared residual of the best model is, and half the 95
    # % interval of that [N²]
    leads: dict[str, tuple[float, float]]
    warnings: tuple[Notice, ...]  # Warnings: what the records do not determine


@one_blas_thread()
def compare_models(
    names: Sequence[str],
    records: Sequence[Prepared],
    splits: Sequence[Split],
    *,
    static: Mapping[str, Estimate] | None = None,
    negative: StaticMap | None = None,
    blocks: int = 4,
    seed: int = 0,
    advance: Callable[[], None] = lambda: None,
) -> Comparison:
    """Fit every model on some samples and score it on others, by replay through whole records.

    Offset (and inertia) of a record are those of its fitted samples or, without any, of the scored samples. The best is
    named the winner only if its mean squared residual is lower than every other's by more than the 95 % error of that
    difference, taken over the strokes between reversals.

    names: Models to compare.
    records: See `fric.records.prepared.prepared`.
    splits: The samples to fit and to score.
    static, negative, blocks, seed: As in `identify_by_replay`.
    advance: Called after each model.
    Raises FricError: When there is no such model, or nothing to score.
    """
    lengths = tuple(presliding_length(record) for record in records)
    near = tuple(near_reversals(record, length) for record, length in zip(records, lengths, strict=True))
    if not any(mask.any() for split in splits for mask in split.scored):
        raise FricError("there is no sample to score", where=records[0].log.where)
    scores = []
    for name in names:
        fitting = partial(identify_by_replay, name, static=static, negative=negative, blocks=blocks, seed=seed)
        scores.append(_scored(name, fitting, records, splits, near))
        advance()
    independent = max(score.fits[0].independent for score in scores)
    scores = sorted((_with_bits(score, independent) for score in scores), key=lambda score: score.parameters)
    scores = [scores[n] for n in ranked([score.rms for score in scores])]
    columns = {"constant force": _nothing, "Coulomb and viscous": _coulomb_viscous}
    if static and {"F_c", "F_s", "v_s"} <= set(static):
        columns["static map"] = partial(_static_map, static, negative)
    plain = tuple(_baseline(name, look, records, splits, near) for name, look in columns.items())
    others: list[Score | Baseline] = [*scores[1:], *plain]
    leads = {other.name: _lead(records, scores[0].residual, other.residual) for other in others}
    winner = scores[0].name if leads and all(lead > error for lead, error in leads.values()) else None
    amiss = record_notices(records)  # of all records, and once: the warnings of a fit are of some records only
    of_records = {notice.code for notice in amiss}
    amiss += [warning for warning in scores[0].fits[0].warnings if warning.code == RECORDS_VARY.code]
    of_records.add(RECORDS_VARY.code)
    warnings = [
        warning.at(score.name)
        for score in scores
        for warning in score.fits[0].warnings
        if warning.code not in of_records
    ]
    return Comparison(tuple(scores), tuple(records), near, lengths, plain, winner, leads, (*amiss, *warnings))


def _scored(
    name: str, fitting: Callable[..., ReplayFit], records: Sequence[Prepared], splits: Sequence[Split], near: Masks
) -> Score:
    fits: list[ReplayFit] = []
    residual = [np.full(len(record.force), np.nan) for record in records]
    fitted: list[Real] = []
    for split in splits:
        chosen = [record.restricted(mask) for record, mask in zip(records, split.fitted, strict=True)]
        fit = fitting(chosen, start=fits[0].model if fits else None)
        fits.append(fit)
        for record, mask, scored, rest in zip(records, split.fitted, split.scored, residual, strict=True):
            left = _score(record, record.force - record.replay(fit.model), mask, scored, rest)
            fitted.append(left[mask & record.used])
    all_of_it, all_near = np.concatenate(residual), np.concatenate(near)
    spent = min(_seconds(fits[0].model, records) for _ in range(3))
    return Score(
        name=name,
        fits=tuple(fits),
        parameters=len(fits[0].x),
        residual=tuple(residual),
        rms=_rms(all_of_it),
        rms_near=_rms(all_of_it[all_near]),
        rms_fitted=_rms(np.concatenate(fitted)),
        bits=float("nan"),
        bits_per_parameter=float("nan"),
        nanoseconds=spent / sum(len(record.force) for record in records) * 1e9,
    )


def _nothing(record: Prepared) -> Real:
    return np.empty((len(record.force), 0))


def _coulomb_viscous(record: Prepared) -> Real:
    return np.column_stack([np.sign(record.motion.velocity), record.motion.velocity])


def _static_map(static: Mapping[str, Estimate], negative: StaticMap | None, record: Prepared) -> Real:
    v = record.motion.velocity
    forward = StaticMap(
        **{
            parameter.name: float(static[parameter.name])
            for parameter in StaticMap.parameters
            if parameter.name in static
        }
    )
    backward = negative or forward
    force = np.sign(v) * np.where(v < 0, backward.level(v), forward.level(v))
    return np.asarray((force + v * np.where(v < 0, backward.sigma, forward.sigma))[:, np.newaxis])


def _baseline(
    name: str, columns: Callable[[Prepared], Real], records: Sequence[Prepared], splits: Sequence[Split], near: Masks
) -> Baseline:
    """Return the residual of columns fitted by least squares to the models' samples; a map has the factor 1."""
    of_records, known = [columns(record) for record in records], name == "static map"
    count = of_records[0].shape[1]
    residual = [np.full(len(record.force), np.nan) for record in records]
    for split in splits:
        rows = []
        for X, record, mask in zip(of_records, records, split.fitted, strict=True):
            fitted = record.restricted(mask)  # the terms of the record are projected out (Frisch and Waugh)
            both = np.column_stack([X, record.force])
            rows.append((both - record.own @ np.column_stack([fitted.record_part(y) for y in both.T]))[fitted.used])
        A, y = np.vstack(rows)[:, :count], np.vstack(rows)[:, count]
        factor = np.ones(count) if known else np.linalg.lstsq(A, y, rcond=None)[0]
        for X, record, mask, scored, left in zip(
            of_records, records, split.fitted, split.scored, residual, strict=True
        ):
            _score(record, record.force - X @ factor, mask, scored, left)
    everything = np.concatenate(residual)
    return Baseline(
        name, 0 if known else count, tuple(residual), _rms(everything), _rms(everything[np.concatenate(near)])
    )


def _score(record: Prepared, left: Real, fitted: Mask, scored: Mask, into: Real) -> Real:
    """Keep the residuals of the scored samples, without the terms of the record, fitted to the other samples."""
    source = record.restricted(fitted)
    if not source.used.any():
        source = record.restricted(scored)
    if source.used.any():
        left = left - record.own @ source.record_part(left)
    into[scored] = left[scored]
    return left


def _with_bits(score: Score, independent: float) -> Score:
    fit = score.fits[0]
    force = np.concatenate([record.force[record.used] - record.force[record.used].mean() for record in fit.records])
    penalty = 0.5 * score.parameters * np.log2(max(independent, 1.0))
    saved = float(independent * np.log2(_rms(force) / max(fit.rmse, 1e-300)) - penalty)
    return replace(score, bits=saved, bits_per_parameter=saved / max(score.parameters, 1))


def _rms(values: Real) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")


def _seconds(model: FrictionModel, records: Sequence[Prepared]) -> float:
    begin = perf_counter()
    for record in records:
        record.replay(model)
    return perf_counter() - begin


def _lead(records: Sequence[Prepared], best: Sequence[Real], other: Sequence[Real]) -> tuple[float, float]:
    """Return the advantage of the best in the mean squared residual, and half its 95 % interval [N²].

    The strokes between reversals are the independent pieces (thirty equal pieces where there are few strokes).
    """
    sums, counts = [], []
    for record, mine, theirs in zip(records, best, other, strict=True):
        difference = theirs**2 - mine**2
        cuts = record.reversals if len(record.reversals) >= 8 else np.linspace(0, len(mine), 31).astype(int)[1:-1]
        for piece in np.split(difference, cuts):
            known = piece[np.isfinite(piece)]
            if len(known):
                sums.append(float(known.sum()))
                counts.append(len(known))
    total, n = np.array(sums), np.array(counts)
    mean = float(total.sum() / n.sum())
    pieces = len(total)
    if pieces < 2:
        return mean, float("inf")
    error = float(np.sqrt(np.sum((total - mean * n) ** 2) * pieces / (pieces - 1))) / float(n.sum())
    return mean, float(stdtrit(pieces - 1, 0.975)) * error
