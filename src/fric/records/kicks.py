"""Kicks at reversals, which a friction compensation of the control leaves in a record."""

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
from fric.records.motion import find_reversals
from fric.records.recognition import fitted_sine, visible_step
from fric.units import readable

SAMPLES = 256  # Least number of samples in a record
KICKED, KICK_COUNTS, BEFORE, BEHIND, WITHIN = 0.3, 6.0, 1.5, 0.33, 0.5
"""Least lead about a reversal of a kick: over 99 % of the deviations elsewhere, in counts, over the deviation before
it, and over the lag after it; and the duration of the search [s]. Without a compensation the first is 0.13 at most, of
strokes, and the fourth 0.3, where friction rises as the speed falls.
"""


@dataclass(frozen=True)
class _Kick:
    lead: float  # By how much the axis gets ahead of its reference after a reversal [m]
    lag: float  # By how much it was behind before that [m]
    before: float  # By how much it deviates at most for as long before the reversal [m]
    behind: float  # By how much it is behind at most after that [m]
    late: float  # When it leads most, after the reversal [s]
    decay: float  # Time from there until an e-th of it is left [s]
    sample: int  # At the reversal


@dataclass(frozen=True)
class Tracking:
    """The tracking error of a record."""

    reference: Real  # That was logged, or the sine that the motion follows between its reversals [m]
    position: Real  # Of the encoder of the loop: of two, the one that deviates less from the reference [m]
    rest: Real  # Deviation of that position without what goes with velocity and acceleration, as the lag of a loop [m]
    spans: list[tuple[int, int, int]]  # Of each reversal where the look at it begins, its sample, where the look ends
    far: Mask  # Samples far from reversals


def tracking(log: Log) -> Tracking | None:
    """Return the tracking of a record; None without a reference, reversals, or samples between them."""
    if log.position is None or log.added is not None or len(log) < SAMPLES:
        return None
    reference = _sine_of(log.time, log.position) if log.reference is None else log.reference
    if reference is None or not len(at := find_reversals(reference)):
        return None
    t, speed = log.time, np.gradient(reference, log.time)
    columns = np.column_stack([np.ones(len(t)), speed, np.gradient(speed, t)])
    columns /= np.maximum(np.abs(columns).max(axis=0), 1e-300)
    far = np.ones(len(t), dtype=bool)
    spans = _around_reversals(t, reference, at)
    for begin, _, end in spans:
        far[begin:end] = False
    if far.sum() < SAMPLES // 4:
        return None
    found = []
    for position in (log.position, log.load_position):
        if position is not None:
            deviation = position - reference
            rest = deviation - columns @ np.linalg.lstsq(columns[far], deviation[far], rcond=1e-9)[0]
            found.append(Tracking(reference, position, rest, spans, far))
    return min(found, key=lambda followed: float(np.std(followed.rest)))


def _sine_of(t: Real, position: Real) -> Real | None:
    """Return the sine that a motion to and fro follows away from its reversals [m], shape (n,); None for others."""
    sine = fitted_sine(t, position) if len(find_reversals(position)) > 1 else None
    if sine is None or not sine.reversals:
        return None
    angle = 2.0 * np.pi * sine.frequency * (t - t[0])
    columns = np.column_stack([np.ones_like(t), np.sin(angle), np.cos(angle)])
    slow = np.zeros(len(t), dtype=bool)
    for _ in range(2):  # the first shows where it is slow
        weights = np.linalg.lstsq(columns[~slow], position[~slow], rcond=None)[0]
        phase = np.arctan2(weights[1], -weights[2])
        slow = np.abs(np.cos(angle + phase)) < 0.5
    return np.asarray(columns @ weights)


def foreign_compensation(log: Log) -> Notice | None:
    """Return the warning that a friction compensation of the control kicks the axis at reversals.

    Friction holds an axis behind its reference. If the axis is ahead after most reversals, by encoder counts and by a
    share of all deviations elsewhere, the cause is a pulse or a step of the control. Deviations proportional to
    velocity and acceleration are due to the loop.
    """
    if (followed := tracking(log)) is None:
        return None
    t, rest = log.time, followed.rest
    least = KICKED * float(np.quantile(np.abs(rest[followed.far]), 0.99))
    least = max(least, KICK_COUNTS * visible_step(followed.position))
    found = [_kick(t, followed.reference, rest, *span) for span in followed.spans]
    kicks = [kick for kick in found if kick.lead > max(least, BEFORE * kick.before, BEHIND * kick.behind)]
    if len(kicks) < 2 or 2 * len(kicks) <= len(found):  # a single one is hunting or a disturbance
        return None
    lead, lag, late, decay = (
        float(np.median([getattr(kick, n) for kick in kicks])) for n in ("lead", "lag", "late", "decay")
    )
    when = "too early" if late < 0.0 else "too late" if lag > max(0.2 * lead, least) else "too much"
    return FOREIGN_COMPENSATION.found(
        log.where, count=len(kicks), reversals=len(found), height=Estimate(lead, log.unit("position")),
        time=Estimate(float(t[kicks[0].sample]), "s"), decay=Estimate(decay, "s"), when=when,
        place=Estimate(float(followed.position[kicks[0].sample]), log.unit("position")),
    )  # fmt: skip


def _around_reversals(t: Real, reference: Real, at: Indices) -> list[tuple[int, int, int]]:
    """Return the window around each reversal: its first sample, the reversal, its last sample."""
    spans = []
    for n, first in enumerate(at):
        stop = int(at[n + 1]) if n + 1 < len(at) else len(t)
        moved = np.abs(reference[first:stop] - reference[first]) > 1e-4 * float(np.ptp(reference))
        moves = int(first) + max(int(np.argmax(moved)) - 1, 0)
        until = min(t[moves] + WITHIN, 0.5 * (t[moves] + t[stop - 1]))
        begin = int(np.searchsorted(t, t[first] - min(0.2 * WITHIN, 0.2 * (until - t[first]))))
        begin = max(begin, int(at[n - 1]) + 1 if n else 0)
        spans.append((begin, int(first), min(max(int(np.searchsorted(t, until)), moves + 2), len(t))))
    return spans


def _kick(t: Real, reference: Real, rest: Real, begin: int, first: int, end: int) -> _Kick:
    """Return the largest lead of the axis over its reference around a reversal."""
    before = rest[max(2 * begin - end, 0) : begin + 1]
    sense = float(np.sign(reference[end - 1] - reference[first])) or 1.0
    ahead = sense * (rest[begin:end] - float(np.median(before[-10:])))
    peak = int(np.argmax(ahead))
    left = np.flatnonzero(ahead[peak:] < ahead[peak] / np.e)
    back = begin + peak + (int(left[0]) if len(left) else len(ahead) - 1 - peak)
    return _Kick(
        float(ahead[peak]), max(-float(ahead[: peak + 1].min()), 0.0), float(np.abs(before - np.median(before)).max()),
        -float(ahead[peak:].min()),
        float(t[begin + peak] - t[first]), float(t[back] - t[begin + peak]), first,
    )  # fmt: skip


def without_kicked(logs: Sequence[Log]) -> tuple[list[Log], list[Notice]]:
    """Return the records without kicks of a compensation, and the warnings about the others.

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
