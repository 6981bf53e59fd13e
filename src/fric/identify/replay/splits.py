"""Which samples of some records are fitted, and which are scored."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fric.arrays import Mask
from fric.errors import FricError
from fric.records.prepared import Prepared

Masks = tuple[Mask, ...]


@dataclass(frozen=True)
class Split:
    """Which samples are fitted and which are scored; one mask a record each."""

    # fitted, scored: masks of the records' samples, each of shape (n,)
    fitted: Masks
    scored: Masks


def split_by_record(records: Sequence[Prepared], fitted: Sequence[str]) -> tuple[Split, ...]:
    """Return one split: fit the records of these names, score the others.

    Raises FricError: When there is no record of a name, or none is left to score.
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
    """Return one split: fit the first cycles of every record after its first reversal, score the rest of it.

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
    """Return so many splits: each record is cut into as many parts, and each part is scored by a fit to the others.

    Raises FricError: When there are fewer than two folds.
    """
    if folds < 2:
        raise FricError(f"{folds} fold leaves nothing to score", hint="Ask for two or more.")
    part = [(np.cumsum(record.used) - 1) * folds // max(int(record.used.sum()), 1) for record in records]
    return tuple(
        Split(
            tuple(record.used & (p != fold) for record, p in zip(records, part, strict=True)),
            tuple(record.used & (p == fold) for record, p in zip(records, part, strict=True)),
        )
        for fold in range(folds)
    )
