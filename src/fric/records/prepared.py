"""A record prepared for a replay: the motion behind the encoder counts, and the friction force along it.

All replays of a friction model (`identify gms`, replay fits, `compare`, `validate`, the report) and the fit of a rigid
axis use these records, so the same force at the same instant.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from fric.arrays import Indices, Mask, Real
from fric.columns import PRESLIDING
from fric.drive.plant import Plant
from fric.errors import FricError, found_in
from fric.flaws.blocks import BEGINS_LOADED
from fric.log import Log, refuse_several_axes
from fric.notice import Notice
from fric.plausibility import Finding
from fric.records.motion import (
    Conditioning,
    Motion,
    between_samples,
    filtered_motion,
    find_reversals,
    local_motion,
    shows_mass,
    smooth_motion,
)
from fric.records.over_strokes import profile
from fric.records.preparation import Own, Preparation
from fric.records.recognition import kind_of
from fric.records.resolution import clipped, drive_off
from fric.records.segments import finer, travelled
from fric.units import is_effort

if TYPE_CHECKING:
    from fric.friction import FrictionModel


def acting_force(time: Real, force: Real, delay: float) -> Real:
    """Return the force [N] that acts at each sample, for a logged force (n,) that acts later by a delay.

    It is interpolated between samples, and constant beyond the ends. A lag of the force is only corrected here.

    delay: ``T_d - force_lag`` of a plant [s]; negative where the force is logged late.
    """
    return force if delay == 0.0 else np.asarray(np.interp(time, time + delay, force))


class Drive(NamedTuple):
    """Force constant and delay of a record without a known plant."""

    K_f: float | None = None  # Force constant [N/V]; None where it is not known
    T_d: float = 0.0  # Delay of the force after its voltage [s]
    force_lag: float = 0.0  # Lag of the logged force behind that voltage [s]


def drive_force(log: Log, drive: Plant | Drive) -> tuple[Real, Literal["force", "input"], float]:
    """Return the logged force of the drive [N], shape (n,), its channel, and its lag [s].

    log: A record with a force, or with an input where the force constant is known.
    drive: The plant, or its known part: a logged force lags its voltage.
    """
    if log.force is None and drive.K_f is not None and log.input is not None:
        return drive.K_f * log.input, "input", 0.0
    return log.require("force", "a replay"), "force", drive.force_lag


MOST_RECORDS = 200  # Records that are replayed together at most
MOST_REPLAYED = 400_000  # Largest number of samples of all records in a fit; of more, every n-th is used
PARTS = 16  # Parts of a stroke, in either direction, within which the error of a model counts as common
CYCLES = 3  # Least number of whole cycles for resampling cycles; with fewer, pieces of equal length are resampled
UNLIKE = 3.0  # Ratio of the difference of the first strokes to any of later ones where a record begins loaded
LOADED = 0.002  # Least difference of the first strokes, as a share of the range of the force
PIECES = 10  # Number of pieces of equal length for resampling without cycles
CREEP = 0.05  # Share of the largest speed below which a record too slow for its starts and stops is not compared
SLIDES = 0.1  # Share of the largest speed from which on friction is that of sliding
ONE_WAY = 0.01  # Ratio of the fastest speeds in both directions below which a motion has only one direction


@dataclass(frozen=True)
class Prepared:
    """A record to replay a model along."""

    log: Log  # The record
    motion: Motion  # Its motion, without the encoder's steps
    force: Real  # Friction [N], shape (n,): the acting force, less inertia and linear damping where a plant is known
    used: Mask  # Samples that are compared, shape (n,), from the first reversal on: the state before is not known
    reversals: Indices  # Samples at which the motion reverses, shape (r,); of a record in sliding, its velocity
    done: Preparation  # What was made of the record

    @cached_property
    def slides(self) -> bool:
        """True for a record in sliding, which only shows the frictional lag; see `in_sliding`."""
        v = self.motion.velocity[self.used]
        return "damping" in self.done.own and not ((v > 0).any() and (v < 0).any())

    @property
    def drive(self) -> Real:
        """The acting force of the drive [N], shape (n,): friction plus the subtracted inertia and damping."""
        return self.force + self.taken_off

    @property
    def taken_off(self) -> Real:
        """Inertia and linear damping that were subtracted [N], shape (n,)."""
        return (self.done.mass or 0.0) * self.motion.acceleration + (self.done.damping or 0.0) * self.motion.velocity

    @cached_property
    def own(self) -> Real:
        """Fitted terms of this record, a column each, shape (n, m).

        Behind those of `Preparation.own` a record in sliding has a force over position, in waves longer than the travel
        of two cycles: so it is slower than what the cycles show.
        """
        m, at = self.motion, self.reversals
        columns = {"offset": np.ones_like(m.time), "damping": m.velocity, "mass": m.acceleration}
        waves = np.pi * np.arange(1, len(at) // 2 + 1 if self.slides else 1)
        along = (m.position - m.position[at[:1]]) / np.diff(m.position[at[[0, -1]]]) if self.slides else m.position
        parts = [*(columns[name] for name in self.done.own), *np.cos(np.multiply.outer(waves, along))]
        return np.column_stack([np.empty((len(m.time), 0)), *parts])

    def replay(self, model: FrictionModel) -> Real:
        """Return the force of a model along the motion [N], shape (n,)."""
        return model.replay(self.motion.time, self.motion.position, self.motion.velocity)

    def record_part(self, rest: Real) -> Real:
        """Return the least-squares coefficients of ``own`` for a force (n,), shape (m,)."""
        size = np.abs(self.own[self.used]).max(axis=0, initial=1e-300)
        return np.asarray(np.linalg.lstsq(self.own[self.used] / size, rest[self.used], rcond=None)[0] / size)

    def fitted(self, model: FrictionModel) -> Real:
        """Return the replayed force with the terms of the record [N], shape (n,)."""
        replayed = self.replay(model)
        return np.asarray(replayed + self.own @ self.record_part(self.force - replayed))

    @cached_property
    def travel(self) -> Real:
        """Half of the travel since the last reversal [m], as on the virgin curve; infinite in sliding, shape (n,)."""
        if self.slides or not len(self.reversals):
            return np.full(len(self.force), np.inf)
        last = np.searchsorted(self.reversals, np.arange(len(self.force)), side="right") - 1
        return 0.5 * np.abs(self.motion.position - self.motion.position[self.reversals[np.maximum(last, 0)]])

    @cached_property
    def cycle(self) -> Indices:
        """Number of the cycle of each sample, shape (n,), for resampling."""
        n, whole = np.arange(len(self.force)), (len(self.reversals) - 1) // 2
        if whole >= CYCLES:
            return np.asarray(np.minimum(np.searchsorted(self.reversals[::2], n, side="right"), whole))
        return np.asarray((np.cumsum(self.used) - 1) * PIECES // max(int(self.used.sum()), 1))

    @cached_property
    def phase(self) -> Indices:
        """Number of the part of a cycle of each sample, shape (n,): errors of a model recur in a part.

        The parts are sixteenths of the samples by travel since the reversal (without reversals by velocity), in each
        direction.
        """
        m, along = self.motion, self.slides or not len(self.reversals)
        progress, sense = (m.velocity, m.acceleration) if along else (self.travel, m.velocity)
        limits = np.quantile(progress, np.arange(1, PARTS) / PARTS)
        return np.asarray(np.searchsorted(limits, progress) + PARTS * (sense > 0))

    def later(self, late: float) -> Prepared:
        """Return the record with its acting force, if the force was logged later than the position by a time [s]."""
        force = acting_force(self.motion.time, self.force, -late)
        return replace(self, force=force, done=replace(self.done, delay=self.done.delay - late))

    def moved(self, late: float) -> Prepared:
        """Return the record with its motion at the instants of the force, which was logged later by a time [s]."""
        motion = replace(_between(self.motion, self.motion.time - late), time=self.motion.time)
        done = replace(self.done, delay=self.done.delay - late)
        return replace(self, motion=motion, used=self.used & between_reversals(motion), done=done)

    @cached_property
    def coarse(self) -> Prepared:
        """The record with its motion as every second sample shows it."""
        m = self.motion
        return replace(self, motion=_between(smooth_motion(m.time[::2], m.position[::2]), m.time))

    def in_motion(self) -> Prepared:
        """Return the record with the samples compared that are apart from rests and reversals."""
        speed = np.abs(self.motion.velocity)
        rests = speed < SLIDES * speed[self.used].max(initial=0.0)
        return self.restricted(np.convolve(rests, np.ones(5), "same") < 0.5)

    def restricted(self, used: Mask) -> Prepared:
        """Return the record with fewer samples compared; the replay still runs through all of them."""
        return replace(self, used=self.used & used)

    def trimmed(self) -> Prepared:
        """Return the record up to the last sample that is compared."""
        return self._cut(slice(None, int(np.flatnonzero(self.used)[-1]) + 1))

    def thinned(self, every: int) -> Prepared:
        """Return the record with every n-th sample; the increments of position are summed."""
        return self if every <= 1 else self._cut(slice(None, None, every))

    def _cut(self, cut: slice) -> Prepared:
        m, every = self.motion, cut.step or 1
        motion = Motion(m.time[cut], m.position[cut], m.velocity[cut], m.acceleration[cut], m.step)
        reversals = self.reversals // every
        return Prepared(
            self.log, motion, self.force[cut], self.used[cut], reversals[reversals < len(motion.time)],
            replace(self.done, every=self.done.every * every),
        )  # fmt: skip

    def in_sliding(self) -> Prepared:
        """Return a record in sliding with the terms for the frictional lag, where the static map is known.

        The lag is out of phase with the velocity. Errors of the map and damping that was not subtracted are in phase:
        the record gets a term in velocity, and without a plant a term in acceleration. Its cycles are those of the
        velocity.

        Raises FricError: When the velocity changes over fewer than two cycles, or the motion reverses.
        """
        v = self.motion.velocity
        if len(reversals := find_reversals(v, threshold=0.3 * float(np.ptp(v)))) < 5:
            hint = "Log five cycles or more of a sine about a mean speed, for C."
            raise FricError("the velocity changes over fewer than two cycles", where=self.log.where, hint=hint)
        used = np.zeros(len(v), dtype=bool)
        used[reversals[0] : reversals[-1]] = True
        if (v[used] > 0).any() and (v[used] < 0).any():
            what = "the motion reverses, and C needs sliding in one direction"
            hint = "Raise the mean speed above the amplitude of the velocity."
            raise FricError(what, where=self.log.where, hint=hint)
        beside: tuple[Own, ...] = ("offset", "damping") if self.done.mass is not None else ("offset", "damping", "mass")
        return replace(self, used=used, reversals=reversals, done=replace(self.done, own=beside))


def prepared(
    logs: Sequence[Log], plant: Plant | None = None, *, drive: Drive | None = None, filters: Sequence[Conditioning] = ()
) -> tuple[Prepared, ...]:
    """Return records ready for replay: ``F = F_drive(t - delay) - M·z̈ - M·A·ż``.

    logs: Records of one axis with a force, or with an input where the force constant is known.
    plant: The plant, whose delay shifts the force, and whose inertia and linear damping are subtracted.
    drive: Force constant and delays, before the plant is identified.
    filters: The published filter of the motion for each record; its border is not used. By default the motion is that
        of `smooth_motion`.
    """
    if not 0 < len(logs) <= MOST_RECORDS:
        what = f"{len(logs)} records are given, and {MOST_RECORDS} at most are replayed"
        raise FricError(what if logs else "there is no record", hint="Name those logs with a force that show most.")
    refuse_several_axes(logs)
    settings: Sequence[Conditioning | None] = filters or [None] * len(logs)
    records = tuple(_prepared(log, plant, drive, setting) for log, setting in zip(logs, settings, strict=True))
    if filters:
        return records
    every = -(-sum(len(record.log) for record in records) // MOST_REPLAYED)
    return tuple(record.thinned(every) for record in records)


def _prepared(log: Log, plant: Plant | None, drive: Drive | None, filters: Conditioning | None) -> Prepared:
    given = plant or drive or Drive()
    log = finer(log) if (kind := kind_of(log)) == "motion" else log
    force, source, lag = drive_force(log, given)
    if not np.ptp(force):
        hint = "Is it the right column? Friction changes its sign."
        raise FricError("the force does not change", where=log.where, hint=hint)
    position = travelled(log)
    moves = filters is not None or kind in {"motion", "constant-velocity"}
    hidden = between_samples(position) if moves else np.zeros(len(log), bool)
    if filters is None and kind == "constant-velocity" and hidden.any():  # no mass is seen, and reversals are needed
        moves, hidden = False, np.zeros(len(log), bool)
    with found_in(log.where):
        if hidden.any():
            motion = local_motion(log.time, position)
        elif filters is not None and filters.cutoff:
            motion = filtered_motion(log, filters)
        else:
            motion = smooth_motion(log.time, position)
    # the lag of force and position is uniform within a sample; without a plant the delay is not known either, nor is it
    # of an effort that no response shows: measured, it acts at once, and a drive's command acts T_d later
    step, unseen = float(np.median(np.diff(log.time))), given.T_d if is_effort(log.motion) and lag == given.T_d else 0.0
    timing = np.hypot(step * (1.0 if plant else 2.0), unseen) / np.sqrt(12.0)
    reversals = find_reversals(position)
    done = Preparation(source, given.T_d - lag, float(timing), motion.step, starts=not hidden.any())
    force = acting_force(log.time, force, done.delay)
    if plant is not None:
        inertia, damping = plant.M * motion.acceleration, plant.damping * motion.velocity
        size = max(0.5 * float(np.quantile(force, 0.99) - np.quantile(force, 0.01)), 1e-300)
        seen = inertia
        if kind == "presliding-sine":  # of a sine the part along its position: counts that jump accelerate nothing
            z = motion.position - motion.position.mean()
            seen = z * float(inertia @ z) / max(float(z @ z), 1e-300)
        shares = [float(np.quantile(np.abs(part), 0.99)) / size for part in (seen, damping)]
        force = force - inertia - damping
        done = replace(
            done, plant=plant, mass=plant.M, damping=plant.damping, inertia_share=shares[0], damping_share=shares[1]
        )
    elif moves and filters is None:
        back, forth = float(motion.velocity.min()), float(motion.velocity.max())
        if min(-back, forth) < ONE_WAY * max(-back, forth):  # an offset is friction, and what trembles at rest is none
            reversals = reversals[:0]
        terms: tuple[Own, ...] = ("offset", "mass") if shows_mass(motion, ~hidden) else ("offset",)
        done = replace(done, own=terms if len(reversals) else terms[1:])
    used = ~hidden & between_reversals(motion) if "mass" in done.own else ~hidden
    if not done.starts:  # how a rest was come to is not known either
        used &= np.abs(motion.velocity) >= CREEP * np.abs(motion.velocity).max()
    if filters is not None:
        used[: filters.border] = False
    elif len(reversals) > 1:
        used[: reversals[0]] = False
    else:
        used[np.abs(position - position[0]) < 0.02 * np.ptp(position)] = False
    if filters is None and log.force is not None and source == "force":
        used &= ~(clipped(log.force) | drive_off(log))
    return Prepared(log, motion, np.asarray(force, float), used, reversals, done)


def _between(m: Motion, time: Real) -> Motion:
    """Return a motion at other instants (n,)."""
    from scipy.interpolate import CubicHermiteSpline  # not at the start

    known = (m.position, m.velocity, m.acceleration, np.gradient(m.acceleration, m.time))
    z, v, a = (CubicHermiteSpline(m.time, *pair)(time) for pair in pairwise(known))
    return Motion(time, z, v, a, m.step)


def between_reversals(motion: Motion) -> Mask:
    """Return the samples, shape (n,), that are not the last or first beside a reversal, which is at neither of both."""
    goes_on = motion.velocity[1:] * motion.velocity[:-1] >= 0.0
    return np.asarray(np.append(goes_on, True) & np.append(True, goes_on))


def strokes_of(record: Prepared) -> Indices:
    """Return the reversals between the long strokes of a record, without smaller ones, as of a hunting drive."""
    span = float(np.ptp(record.motion.position))
    return find_reversals(record.motion.position, threshold=0.3 * span) if span > 0 else np.zeros(0, np.intp)


def begins_loaded(record: Prepared, reversals: Indices) -> bool:
    """Return whether the first stroke of a record differs from the next in its direction, while later strokes repeat.

    The contact may be loaded at the beginning of a record. The force depends on this until each block has slipped, or
    has stuck along a whole stroke; from the second reversal on the effect is at most a constant.
    """
    if len(reversals) < 5:
        return False
    z, F = record.motion.position, record.force
    edges = np.linspace(0.0, float(np.min(np.abs(np.diff(z[reversals[:5]])))) * (1.0 + 1e-9), PARTS + 1)

    def unlike(n: int) -> float:
        """Return the difference of two strokes of the same direction, apart from a constant [N]."""
        pieces = (reversals[n : n + 2], reversals[n + 2 : n + 4])
        before, after = (profile(np.abs(z[begin:end] - z[begin]), F[begin:end], edges) for begin, end in pieces)
        apart = after - before
        return float(np.sqrt(np.nanmean((apart - np.nanmean(apart)) ** 2)))

    later = max(unlike(n) for n in range(1, len(reversals) - 3))  # one alone is small by chance where a drive hunts
    return unlike(0) > max(UNLIKE * later, LOADED * float(np.ptp(F[reversals[1] : reversals[4]])))


def of_shares(records: Iterable[Prepared]) -> Iterator[Finding]:
    """Yield the shares of inertia and damping in the force of each record, where a plant is given."""
    for record in records:
        for name, share in (("inertia", record.done.inertia_share), ("damping", record.done.damping_share)):
            if share is not None:
                yield Finding(name, share, record.log.motion, record.log.where)


def without_loaded(records: Sequence[Prepared]) -> tuple[list[Prepared], list[Notice]]:
    """Return records without the first strokes in comparison if the contact begins loaded, and a notice of these."""
    kept, loaded = [], []
    for record in records:
        at = strokes_of(record) if kind_of(record.log) in PRESLIDING else np.zeros(0, np.intp)
        if begins_loaded(record, at):
            loaded.append(record.log.name)
            record = replace(record, used=record.used & (np.arange(len(record.force)) >= at[1]))
        kept.append(record)
    return kept, [BEGINS_LOADED.found(records=loaded)] if loaded else []
