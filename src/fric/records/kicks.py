"""Kicks at reversals: what a friction compensation of the control leaves in a record."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fric.arrays import Indices, Mask, Real
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.channel import FOREIGN_COMPENSATION
from fric.flaws.files import RECORD_LEFT_OUT
from fric.log import Log
from fric.notice import Notice
from fric.records.recognition import visible_step
from fric.records.reversals import find_reversals
from fric.units import readable

SAMPLES = 256
"""Samples that a record has at least."""
KICKED, KICK_COUNTS, BEFORE, WITHIN = 0.3, 6.0, 1.5, 0.5
"""Lead about a reversal that is a kick: over the deviations elsewhere (99 % of them), in counts, and over what deviates
before it; and for how long it is looked for [s]. Without a compensation the first is 0.13 at most, of strokes."""


@dataclass(frozen=True)
class _Kick:
    lead: float  # By how much the axis gets ahead of its reference after a reversal [m]
    lag: float  # By how much it was behind before that [m]
    before: float  # By how much it deviates at most for as long before the reversal [m]
    late: float  # When it leads most, after the reversal [s]
    decay: float  # Time from there until an e-th of it is left [s]
    sample: int  # At the reversal


@dataclass(frozen=True)
class Tracking:
    """How a record follows its reference.

    rest: deviation of the position without what goes with velocity and acceleration, as the lag of a loop does [m]
    spans: of each reversal where the look at it begins, its sample, and where the look ends
    far: samples far from reversals
    """

    rest: Real
    spans: list[tuple[int, int, int]]
    far: Mask


def tracking(log: Log) -> Tracking | None:
    """Return how a record follows its reference; None where it has no reference, no reversal, or nothing between."""
    if log.reference is None or log.position is None or log.added is not None or len(log) < SAMPLES:
        return None
    at = find_reversals(log.reference)
    if not len(at):
        return None
    t, speed = log.time, np.gradient(log.reference, log.time)
    columns = np.column_stack([np.ones(len(t)), speed, np.gradient(speed, t)])
    columns /= np.maximum(np.abs(columns).max(axis=0), 1e-300)
    deviation, far = log.position - log.reference, np.ones(len(t), dtype=bool)
    spans = _around_reversals(t, log.reference, at)
    for begin, _, end in spans:
        far[begin:end] = False
    if far.sum() < SAMPLES // 4:
        return None
    return Tracking(deviation - columns @ np.linalg.lstsq(columns[far], deviation[far], rcond=1e-9)[0], spans, far)


def foreign_compensation(log: Log) -> Notice | None:
    """Return that the control kicks the axis at reversals, as a friction compensation does that was left on.

    Friction holds an axis behind its reference. What puts it ahead after most reversals, by counts of the encoder and
    by a share of all deviations elsewhere, is a pulse or a step of the control. Deviations that go with the velocity
    and the acceleration are those of the loop.
    """
    if (followed := tracking(log)) is None or log.reference is None or log.position is None:
        return None
    t, rest = log.time, followed.rest
    least = KICKED * float(np.quantile(np.abs(rest[followed.far]), 0.99))
    least = max(least, KICK_COUNTS * visible_step(log.position))
    found = [_kick(t, log.reference, rest, *span) for span in followed.spans]
    kicks = [kick for kick in found if kick.lead > max(least, BEFORE * kick.before)]
    if len(kicks) < 2 or 2 * len(kicks) <= len(found):  # a single one is hunting or a disturbance
        return None
    lead, lag, late, decay = (
        float(np.median([getattr(kick, n) for kick in kicks])) for n in ("lead", "lag", "late", "decay")
    )
    when = "too early" if late < 0.0 else "too late" if lag > max(0.2 * lead, least) else "too much"
    return FOREIGN_COMPENSATION.found(
        log.where, count=len(kicks), reversals=len(found), height=Estimate(lead, log.unit("position")),
        time=Estimate(float(t[kicks[0].sample]), "s"), decay=Estimate(decay, "s"), when=when,
        place=Estimate(float(log.position[kicks[0].sample]), log.unit("position")),
    )  # fmt: skip


def _around_reversals(t: Real, reference: Real, at: Indices) -> list[tuple[int, int, int]]:
    """Return of each reversal where the look at it begins, its sample, and where the look ends."""
    spans = []
    for n, first in enumerate(at):
        stop = int(at[n + 1]) if n + 1 < len(at) else len(t)
        moved = np.abs(reference[first:stop] - reference[first]) > 1e-4 * float(np.ptp(reference))
        moves = int(first) + max(int(np.argmax(moved)) - 1, 0)
        until = min(t[moves] + WITHIN, 0.5 * (t[moves] + t[stop - 1]))
        begin = int(np.searchsorted(t, t[first] - min(0.2 * WITHIN, 0.2 * (until - t[first]))))
        spans.append((begin, int(first), min(max(int(np.searchsorted(t, until)), moves + 2), len(t))))
    return spans


def _kick(t: Real, reference: Real, rest: Real, begin: int, first: int, end: int) -> _Kick:
    """Return how far the axis gets ahead of its reference about a reversal."""
    before = rest[max(2 * begin - end, 0) : begin + 1]
    sense = float(np.sign(reference[end - 1] - reference[first])) or 1.0
    ahead = sense * (rest[begin:end] - float(np.median(before[-10:])))
    peak = int(np.argmax(ahead))
    left = np.flatnonzero(ahead[peak:] < ahead[peak] / np.e)
    back = begin + peak + (int(left[0]) if len(left) else len(ahead) - 1 - peak)
    return _Kick(
        float(ahead[peak]), max(-float(ahead[: peak + 1].min()), 0.0), float(np.abs(before - np.median(before)).max()),
        float(t[begin + peak] - t[first]), float(t[back] - t[begin + peak]), first,
    )  # fmt: skip


def without_kicked(logs: Sequence[Log]) -> tuple[list[Log], list[Notice]]:
    """Return the records that no compensation of the control kicks, and what there is to say of the others.

    Raises FricError: When no record is left.
    """
    kicked = [(log, notice) for log in logs if (notice := foreign_compensation(log)) is not None]
    kept = [log for log in logs if all(log is not one for one, _ in kicked)]
    if kicked and not kept:
        log, notice = kicked[0]
        height = readable(float(notice.values["height"]), log.unit("position"))
        raise FricError(
            f"the control kicks the axis by {height} at reversals, and its force is no friction", where=log.where,
            hint="Switch its friction compensation off, and log again.",
        )  # fmt: skip
    why = "the control's friction compensation kicks the axis at reversals"
    return kept, [RECORD_LEFT_OUT.found(log.where, why=why) for log, _ in kicked]
