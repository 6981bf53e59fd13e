"""Friction models compared on held-out samples."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from timeit import repeat

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Mask, Real
from fric.errors import FricError, require_known
from fric.estimate import Estimate
from fric.flaws.drift import ENERGY_DRIFTS, ENERGY_IN_ONE_SEGMENT, RECORDS_VARY
from fric.friction import FrictionModel
from fric.friction.directed import directed
from fric.friction.stribeck import STATIC_PARAMETERS, StaticMap
from fric.identify.replay.replay_fit import ReplayFit, fitted_model, identify_by_replay, record_notices
from fric.notice import Notice
from fric.process import one_blas_thread, tried
from fric.records.prepared import Prepared
from fric.search import ranked
from fric.statistics import rms

Masks = tuple[Mask, ...]  # Samples of each record, each of shape (n,)
NEAR = 0.3  # Time after a reversal that counts as near it [s]
LENGTHS = 10.0  # Pre-sliding lengths after a reversal that count as near it
Modelled = Callable[[Prepared], Real]  # The force of a fit along a record [N], shape (n,)


def split_by_record(records: Sequence[Prepared], fitted: Sequence[str]) -> tuple[Masks, ...]:
    """Return a split, the samples to fit of each record: all of the records of these names; the others are scored."""
    names = [record.log.name for record in records]
    for name in fitted:
        require_known(name, names, "there is no record", "The records are")
    if set(names) <= set(fitted):
        raise FricError("every record is fitted, and none is left to score", hint="Leave one out of `fit_on=`.")
    return (tuple(record.used & (record.log.name in fitted) for record in records),)


def split_by_cycles(records: Sequence[Prepared], cycles: int) -> tuple[Masks, ...]:
    """Return a split: fit the first cycles of every record after its first reversal, score the rest."""
    for record in records:
        if len(record.reversals) < 2 * cycles + 2:
            what = f"there are {max(len(record.reversals) - 1, 0) // 2} cycles"
            raise FricError(what, where=record.log.where, hint="Fit fewer of them, and leave some to score.")
    return (tuple(r.used & (np.arange(len(r.force)) < r.reversals[2 * cycles]) for r in records),)


def split_by_folds(records: Sequence[Prepared], folds: int) -> tuple[Masks, ...]:
    """Return ``folds`` splits: each record is cut into as many parts, each of which a fit to the others scores."""
    part = [(np.cumsum(record.used) - 1) * folds // max(int(record.used.sum()), 1) for record in records]
    return tuple(tuple(r.used & (p != fold) for r, p in zip(records, part, strict=True)) for fold in range(folds))


def presliding_length(record: Prepared) -> float:
    """Return the median travel after a reversal [m] in which the force makes nine tenths of its change.

    For a record without two reversals it is a hundredth of its travel.
    """
    z, found = record.motion.position, []
    for begin, end in pairwise(record.reversals):
        if len(force := record.force[begin:end]) < 8:
            continue
        if (tail := float(np.median(force[len(force) // 2 :]))) != force[0]:
            passed = int(np.argmax((force - force[0]) / (tail - force[0]) >= 0.9))
            found.append(abs(float(z[begin + passed] - z[begin])))
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
class Baseline:
    """Residual of held-out samples without a dynamic model: a useful model leaves less."""

    name: str  # What is subtracted
    parameters: int  # Number of parameters that were fitted
    residual: tuple[Real, ...]  # Measured less modelled force [N], by record, from the split that scores; nan elsewhere
    rms: float  # rms, rms_near: root mean square of that over all samples scored, and over those near reversals [N]
    rms_near: float


@dataclass(frozen=True)
class Score(Baseline):
    """The same of a model."""

    fits: tuple[ReplayFit, ...]  # Its fit in each split
    rms_fitted: float  # Root mean square over the samples that were fitted, of all splits [N]
    nanoseconds: float  # Time of one replayed step [ns]
    # What the model saves of the description of the fitted samples against a constant force, by BIC [bit]: ``n·log2(rms
    # of the force/rms of the residual) - p/2·log2(n)``, with n the number of independent residuals of the model that
    # has most of them
    bits: float = float("nan")

    @property
    def model(self) -> FrictionModel:
        """The model fitted by the first split."""
        return self.fits[0].model

    @property
    def bits_per_parameter(self) -> float:
        """That, for each parameter."""
        return self.bits / max(self.parameters, 1)


@dataclass(frozen=True)
class Comparison:
    """Friction models, the best first."""

    scores: tuple[Score, ...]  # The models by rms; of those that differ by rounding that of fewer parameters first
    records: tuple[Prepared, ...]  # The records
    near: Masks  # Which samples are near reversals, one mask a record
    presliding: tuple[float, ...]  # Travel after a reversal until nine tenths of the force's change [m], by record
    baselines: tuple[Baseline, ...]  # What is left without a dynamic model
    winner: str | None  # The best model; None where its lead over another or a baseline is within its error
    # For each other model and baseline, and those without memory near reversals, how much lower the mean squared
    # residual of the best model is, and half the 95 % interval of that [N²]
    leads: dict[str, tuple[float, float]]
    warnings: tuple[Notice, ...]  # Warnings: what the records do not determine


@one_blas_thread()
def compare_models(
    names: Sequence[str], records: Sequence[Prepared], splits: Sequence[Masks], *,
    static: Mapping[str, Estimate] | None = None, negative: StaticMap | None = None, blocks: int = 4, seed: int = 0,
    advance: Callable[[], None] = lambda: None,
) -> Comparison:  # fmt: skip
    """Fit every model on some samples and score it on others, by replay through whole records.

    Offset (and inertia) of a record are those of its fitted samples or, without any, of the scored samples. The best is
    named the winner only if its mean squared residual is lower than every other's, and near reversals than that of each
    without memory, by more than the 95 % error of that difference, taken over the strokes between reversals.

    splits: The samples to fit; the others are scored.
    """
    lengths = tuple(presliding_length(record) for record in records)
    near = tuple(near_reversals(record, length) for record, length in zip(records, lengths, strict=True))
    if not any((r.used & ~mask).any() for split in splits for r, mask in zip(records, split, strict=True)):
        hint = "Give longer records, or fewer folds."
        raise FricError("there is no sample to score", where=records[0].log.where, hint=hint)
    scores = []
    for name in [fitted_model(name).name for name in names]:  # each is known before any is fitted
        tried(name)
        fitting = partial(identify_by_replay, name, static=static, negative=negative, blocks=blocks, seed=seed)
        scores.append(_scored(name, fitting, records, splits, near))
        advance()
    independent = max(score.fits[0].independent for score in scores)
    scores = sorted((_with_bits(score, independent) for score in scores), key=lambda score: score.parameters)
    scores = [scores[n] for n in ranked([score.rms for score in scores])]
    plain = [
        _baseline("constant force", 0, lambda _: lambda record: np.zeros(len(record.force)), records, splits, near),
        _baseline("Coulomb and viscous", 2, _coulomb_viscous, records, splits, near),
    ]
    if static and {"F_c", "F_s", "v_s"} <= set(static):
        forward = StaticMap(**{name: float(static[name]) for name in STATIC_PARAMETERS if name in static})
        plain.append(_baseline("static map", 0, lambda _: _of_map(forward, negative), records, splits, near))
    others: list[Baseline] = [*scores[1:], *plain]
    leads = {other.name: _lead(records, scores[0].residual, other.residual) for other in others}
    if any((mask & record.used).any() for record, mask in zip(records, near, strict=True)):
        best = _where(near, scores[0].residual)
        for other in (score for score in others if score.name == "static" or not isinstance(score, Score)):
            leads[f"{other.name} near reversals"] = _lead(records, best, _where(near, other.residual))
    winner = scores[0].name if leads and all(lead > error for lead, error in leads.values()) else None
    # of all records, and once: the warnings of a fit are of some records only
    amiss = record_notices(records, scores[0].model)
    amiss += [warning for warning in scores[0].fits[0].warnings if warning.code == RECORDS_VARY.code]
    of_records = {notice.code for notice in amiss}
    of_records |= {flaw.code for flaw in (RECORDS_VARY, ENERGY_DRIFTS, ENERGY_IN_ONE_SEGMENT)}
    of_scores = ((score.name, warning) for score in scores for warning in score.fits[0].warnings)
    warnings = [warning.at(name) for name, warning in of_scores if warning.code not in of_records]
    return Comparison(tuple(scores), tuple(records), near, lengths, tuple(plain), winner, leads, (*amiss, *warnings))


def _held_out(
    fit: Callable[[Sequence[Prepared]], Modelled], records: Sequence[Prepared], splits: Sequence[Masks]
) -> tuple[tuple[Real, ...], Real]:
    """Return what fits leave of the samples that they did not see, by record, and of those that they saw, in one row;
    the terms of a record are fitted to the samples seen, or to the others where none was.
    """
    residual = tuple(np.full(len(record.force), np.nan) for record in records)
    seen = []
    for split in splits:
        chosen = [record.restricted(mask) for record, mask in zip(records, split, strict=True)]
        modelled = fit(chosen)
        for record, fitted, into in zip(records, chosen, residual, strict=True):
            left = record.force - modelled(record)
            left = left - record.own @ (fitted if fitted.used.any() else record).record_part(left)
            scored = record.used & ~fitted.used
            into[scored] = left[scored]
            seen.append(left[fitted.used])
    return residual, np.concatenate(seen)


def _scored(
    name: str, fitting: Callable[..., ReplayFit], records: Sequence[Prepared], splits: Sequence[Masks], near: Masks
) -> Score:
    fits: list[ReplayFit] = []

    def fit(chosen: Sequence[Prepared]) -> Modelled:
        fits.append(fitting(chosen, start=fits[0].model if fits else None))
        return lambda record: record.replay(fits[-1].model)

    residual, seen = _held_out(fit, records, splits)
    spent = min(repeat(lambda: [record.replay(fits[0].model) for record in records], repeat=3, number=1))
    steps = sum(len(record.force) for record in records)
    return Score(name, len(fits[0].x), residual, *_sizes(residual, near), tuple(fits), rms(seen), spent / steps * 1e9)


def _baseline(
    name: str, parameters: int, fit: Callable[[Sequence[Prepared]], Modelled], records: Sequence[Prepared],
    splits: Sequence[Masks], near: Masks,
) -> Baseline:  # fmt: skip
    residual, _ = _held_out(fit, records, splits)
    return Baseline(name, parameters, residual, *_sizes(residual, near))


def _coulomb_viscous(chosen: Sequence[Prepared]) -> Modelled:
    """Fit both by least squares, with the terms of each record projected out (Frisch and Waugh)."""

    def columns(record: Prepared) -> Real:
        return np.column_stack([np.sign(record.motion.velocity), record.motion.velocity])

    rows = []
    for record in chosen:
        both = np.column_stack([columns(record), record.force])
        rows.append((both - record.own @ np.column_stack([record.record_part(y) for y in both.T]))[record.used])
    A = np.vstack(rows)
    factor = np.linalg.lstsq(A[:, :2], A[:, 2], rcond=None)[0]
    return lambda record: columns(record) @ factor


def _of_map(forward: StaticMap, negative: StaticMap | None) -> Modelled:
    model = directed(forward, negative)
    return lambda record: np.asarray(model.steady_state(record.motion.velocity))


def _with_bits(score: Score, independent: float) -> Score:
    fit = score.fits[0]
    force = np.concatenate([record.force[record.used] - record.force[record.used].mean() for record in fit.records])
    penalty = 0.5 * score.parameters * np.log2(max(independent, 1.0))
    return replace(score, bits=float(independent * np.log2(rms(force) / max(fit.rmse, 1e-300)) - penalty))


def _where(near: Masks, residual: Sequence[Real]) -> list[Real]:
    return [np.where(mask, values, np.nan) for mask, values in zip(near, residual, strict=True)]


def _sizes(residual: Sequence[Real], near: Masks) -> tuple[float, float]:
    everything = np.concatenate(residual)
    return rms(everything), rms(everything[np.concatenate(near)])


def _lead(records: Sequence[Prepared], best: Sequence[Real], other: Sequence[Real]) -> tuple[float, float]:
    """Return the advantage of the best in the mean squared residual, and half its 95 % interval [N²], by the strokes
    between reversals as independent pieces (thirty equal pieces where there are few strokes).
    """
    sums, counts = [], []
    for record, mine, theirs in zip(records, best, other, strict=True):
        cuts = record.reversals if len(record.reversals) >= 8 else np.linspace(0, len(mine), 31).astype(int)[1:-1]
        for piece in np.split(theirs**2 - mine**2, cuts):
            if len(known := piece[np.isfinite(piece)]):
                sums.append(float(known.sum()))
                counts.append(len(known))
    total, n = np.array(sums), np.array(counts)
    mean = float(total.sum() / n.sum())
    if (pieces := len(total)) < 2:
        return mean, float("inf")
    error = float(np.sqrt(np.sum((total - mean * n) ** 2) * pieces / (pieces - 1))) / float(n.sum())
    return mean, float(stdtrit(pieces - 1, 0.975)) * error
