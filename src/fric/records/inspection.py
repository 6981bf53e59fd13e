"""The content of a record, its information on friction, and its uses."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Indices, Mask, Real
from fric.columns import FORCE_VELOCITY, PRESLIDING, Kind
from fric.estimate import Estimate
from fric.flaws.channel import ENCODER_TOO_COARSE, FOREIGN_COMPENSATION, ONE_DIRECTION
from fric.flaws.drift import ENERGY_DRIFTS, ENERGY_IN_ONE_SEGMENT
from fric.log import ForceVelocity, FrequencyResponse, Log, Record
from fric.notice import Notice
from fric.records.flaws import GAP, Transmission, clock_flaws, foreign_compensation, stroke_flaws, transmission_of
from fric.records.holding import HoldingMap, holding_map, holds
from fric.records.motion import find_reversals
from fric.records.over_strokes import over_place
from fric.records.recognition import LOOP_SHARE, Sine, Staircase, force_rises, recognised_kind, turns_of
from fric.records.resolution import STUCK, clipped_samples, counts, encoder_step
from fric.records.segments import Segment, segments_and_rests, travelled, velocity_swing
from fric.units import Motion, readable, rotates, si_unit

if TYPE_CHECKING:
    from fric.records.prepared import Prepared

STEPS = 3.0  # Least amplitude in encoder steps to show pre-sliding
RESOLVED = 4.0  # Least distance in encoder steps of a knot from the reversal, and from the previous knot
SWINGING = 5.0  # Least ratio of reversals of the position to those of its reference at which the loop swings
SAMPLES = 3  # Least number of samples after a reversal that show a stiffness
SATURATED = 0.05  # Least slope of a branch, relative to its mean slope, under which it has reached its plateau
RISES = 0.2  # The same for logged branches, which include viscous friction: above it they surely have no plateau
SHORT = 0.1  # Share of the longest branch, or of the largest speed, up to which it is a rest
PIECES, MOVES = 64, 0.6  # Least number of steps that are held against the next, and their correlation in a motion
FAR = 5.0  # Travel relative to the root of the steps' sum of squares that no noise has
CONDITION = 1e3  # Condition number up to which a motion separates mass, viscous and Coulomb friction
CHANGES = 0.03  # Least change of the energy per cycle over a record that gives a warning, as a share
STANDS_OFF = 0.1  # Least deviation of the energy of cycles from the others that gives a warning, as a share
SPEEDS = 5  # Least number of speeds for a map: the number of its parameters plus one


@dataclass(frozen=True)
class Identifiability:
    """Information of several records on friction, together."""

    slides: bool  # False where the force rises up to every reversal, so that no branch ever slides
    slope: float  # Least slope of the branches that come nearest to a plateau, relative to their mean slope
    peak: float  # Largest friction force: half of its swing between reversals [N]
    resolved: float  # Shortest travel after a reversal that is seen [m]: a count, and that in `SAMPLES` samples


def identifiability_of(records: Sequence["Prepared"]) -> Identifiability:
    """Return the information of prepared records on friction."""
    slopes, peaks, resolved = [], [], []
    for record in records:
        reversals = record.reversals[record.reversals < len(record.force)]
        if record.slides or len(reversals) < 2:
            slopes.append(0.0)
            continue
        z, force = record.motion.position, record.force - _of_speed(record)
        slopes.append(branch_slope(z, force, reversals))
        peaks.append(0.5 * float(np.median([np.ptp(force[a : b + 1]) for a, b in pairwise(reversals)])))
        resolved.append(max(record.motion.step, resolved_travel(z, reversals)))
    slope = min(slopes, default=0.0)
    return Identifiability(slope < RISES, slope, max(peaks, default=0.0), min(resolved, default=0.0))


def _of_speed(record: "Prepared") -> Real | float:
    """Return inertia and damping [N], shape (n,), of a record with a fitted mass, which rise like a stiffness: by least
    squares of force on acceleration, sign of v, v and an offset in motion. A stiffness, of negative mass, is excluded.
    """
    m = record.motion
    if "mass" not in record.done.own:
        return 0.0
    moving = record.used & (np.abs(m.velocity) >= SHORT * np.abs(m.velocity[record.used]).max())
    basis = np.column_stack([m.acceleration, np.sign(m.velocity), m.velocity, np.ones_like(m.time)])[moving]
    size = np.abs(basis).max(axis=0, initial=1e-300)
    mass, coulomb, damping, _ = np.linalg.lstsq(basis / size, record.force[moving], rcond=None)[0] / size
    return m.acceleration * mass + m.velocity * max(damping, 0.0) if mass > 0.0 < coulomb else 0.0


def too_coarse(records: Sequence["Prepared"]) -> list[Notice]:
    """Return the records whose encoder is too coarse for their motion, judged as by `inspect`, with warnings."""
    found = []
    for record in records:
        z = record.motion.position
        inside = record.reversals[record.reversals < len(z)]
        if record.slides or not record.motion.step:
            continue
        strokes = np.abs(np.diff(z[inside])) if len(inside) > 2 else np.ptp(z)  # so small that no reversal is seen
        if (steps := 0.5 * float(np.median(strokes)) / record.motion.step) < STEPS:
            found.append(ENCODER_TOO_COARSE.found(f"record '{record.log.name}'", steps=steps))
    return found


def branch_slope(position: Real, force: Real, reversals: Indices) -> float:
    """Return the least slope of the branches between reversals, relative to their mean slope; see `least_slope`.

    The branches are averaged over the share of their travel, in fiftieths, without those of a rest, which are short. A
    branch starts with the force at the end of the branch before: its first samples may have risen already.
    """
    grid = (np.arange(50) + 0.5) / 50
    branches, before = [], None
    shortest = SHORT * float(np.abs(np.diff(position[reversals])).max(initial=0.0))
    for a, b in pairwise(reversals):
        z, F = position[a : b + 1], force[a : b + 1]
        travel = np.maximum.accumulate(np.abs(z - z[0]))
        end = float(np.mean(F[-max(len(F) // 20, 1) :]))
        if before is not None and end != before and len(z) >= 8 and travel[-1] > shortest:
            branches.append(np.interp(grid, travel / travel[-1], (F - before) / (end - before)))
        before = end
    return least_slope(grid, np.mean(branches, axis=0)) if branches else 0.0


def least_slope(displacement: Real, force: Real) -> float:
    """Return the least slope of any fifth of a curve's outer half, relative to its mean slope [1].

    A concave curve is flattest at its end. If the Stribeck effect is not divided out, the force rises again as the
    motion slows down, which is not a stiffness.
    """
    slopes = []
    for start in np.linspace(0.5, 0.8, 7):
        part = (displacement >= start * displacement[-1]) & (displacement <= (start + 0.2) * displacement[-1])
        if part.sum() > 2:
            slopes.append(float(np.polyfit(displacement[part] - displacement[-1], force[part], 1)[0]))
    return float(min(slopes, default=np.inf) * displacement[-1] / force[-1])


def resolved_travel(position: Real, reversals: Indices) -> float:
    """Return the travel of the axis in `SAMPLES` samples after a reversal, the median of all [m]."""
    after = np.minimum(reversals + SAMPLES, len(position) - 1)
    return float(np.median(np.abs(position[after] - position[reversals])))


def _averaged(position: Real, width: int) -> Real:
    """Return the means over pieces of a number of samples."""
    count = len(position) // width
    return np.asarray(position[: count * width].reshape(count, width).mean(axis=1))


def is_at_rest(position: Real) -> bool:
    """Return whether a position is noise, or the sum of a noisy velocity: none of its steps predicts the next.

    Steps between means correlate by -1/2 where the position is white noise, by 1/4 where the velocity is, and by
    nearly 1 in a motion; and n of them lead about √n steps far. Pieces of 5, 20, 80, … samples are tried.
    """
    width, rests = 5, False
    while len(means := _averaged(position, width)) >= PIECES:
        steps = np.diff(means)
        steps = steps - steps.mean()
        size = float(steps @ steps)
        rests = bool(steps[1:] @ steps[:-1] <= MOVES * size and np.ptp(means) <= FAR * np.sqrt(size))
        if not rests:
            return False
        width *= 4
    return rests


def excites(time: Real, position: Real) -> bool:
    """Return whether a motion separates mass, viscous and Coulomb friction and an offset.

    Position is averaged over pieces of 10 ms or five samples, so that encoder steps do not count as acceleration.
    """
    dt = float(np.median(np.diff(time)))
    width = max(round(0.01 / dt), 5)
    if len(z := _averaged(position, width)) < 32:
        return False
    v = np.gradient(z, width * dt)
    columns = np.column_stack([np.gradient(v, width * dt), v, np.sign(v), np.ones_like(v)])
    size = np.linalg.norm(columns, axis=0)
    both = (v > 0.1 * np.abs(v).max()).any() and (v < -0.1 * np.abs(v).max()).any()
    return bool(both and (size > 0).all() and np.linalg.cond(columns / size) < CONDITION)


def cycle_energies(position: Real, force: Real, reversals: Indices) -> Real:
    """Return the energy lost in each whole cycle of two strokes, ``∮F·dz`` [J], shape (cycles,).

    position, force: The motion [m] and the force along it [N], each of shape (n,).
    reversals: Samples at which the motion reverses.
    """
    work = np.append(0.0, np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(position)))
    return np.asarray(np.diff(work[ends])) if len(ends := reversals[::2]) > 1 else np.zeros(0)


def energy_per_cycle(energies: Real, motion: Motion) -> Estimate | None:
    """Return the mean energy of cycles with its 95 % interval by Student's t; None for fewer than two cycles."""
    if len(energies) < 2:
        return None
    mean, n = float(energies.mean()), len(energies)
    half = float(stdtrit(n - 1, 0.975) * energies.std(ddof=1) / np.sqrt(n))
    return Estimate.around(mean, si_unit("energy", motion), half)


def drift(values: Real) -> tuple[float, float]:
    """Return the change of values along their regression line from first to last, and half its 95 % interval."""
    n = len(values)
    at = (np.arange(n) - 0.5 * (n - 1)) / max(n - 1, 1)
    slope = float(at @ values / (at @ at))
    rest = values - values.mean() - slope * at
    return slope, float(stdtrit(n - 2, 0.975)) * float(np.sqrt(rest @ rest / (n - 2) / (at @ at)))


def energy_warnings(energies: Real, ends: Real, motion: Motion) -> list[Notice]:
    """Return the warnings from the energies of equal cycles of a record: outlying cycles in one segment, or a drift.

    ends: Instants at which the cycles begin, and the last cycle ends [s], shape (n + 1,).
    """
    if len(energies) < 4:
        return []
    usual = float(np.median(energies))
    off = np.flatnonzero(np.abs(energies - usual) > STANDS_OFF * abs(usual))
    off = off[np.abs(energies[off] - usual) > 6 * float(np.median(np.abs(energies - usual)))]
    if len(off) and len(off) < 0.5 * len(energies) and off[-1] - off[0] + 1 == len(off):
        there, elsewhere = float(energies[off].mean()), float(np.delete(energies, off).mean())
        span = {"begin": float(ends[off[0]]), "end": float(ends[off[-1] + 1])}
        energy = {"there": Estimate(there, unit := si_unit("energy", motion)), "elsewhere": Estimate(elsewhere, unit)}
        return [ENERGY_IN_ONE_SEGMENT.found(**energy, **span)]
    change, half = drift(energies)
    if abs(change) <= max(half, CHANGES * abs(usual)):
        return []
    return [ENERGY_DRIFTS.found(change=change / usual, half=half / abs(usual))]


def energy_changes(record: "Prepared", modelled: Real, seen: Mask) -> Iterator[Notice]:
    """Yield the warnings about changes during a record, by the ratio of its cycles' energy to that of a model.

    modelled: The model's force along the motion [N], shape (n,).
    seen: Samples whose cycles count, shape (n,).
    """
    motion, reversals = record.motion, record.reversals
    reversals = reversals[seen[np.minimum(reversals, len(seen) - 1)]]
    measured, replayed = (cycle_energies(motion.position, force, reversals) for force in (record.force, modelled))
    usual = float(np.sum(replayed)) / max(len(replayed), 1)
    for notice in energy_warnings(measured / replayed * usual, motion.time[reversals[::2]], record.log.motion):
        yield notice.at(f"record '{record.log.name}'")


@dataclass(frozen=True)
class Use:
    """Whether a record is suited to an identification, and why."""

    purpose: str
    good: bool
    why: str


@dataclass(frozen=True)
class Channel:
    """Content of a channel, in its SI unit."""

    unit: str  #: Its SI unit
    low: float  #: low, high: least and greatest value
    high: float
    step: float | None  #: Of the lattice that its values lie on
    clipped: int = 0  #: Samples at which a force or an input is stuck at its extreme


@dataclass(frozen=True)
class Gap:
    """Missing samples."""

    time: float  #: Before them [s]
    intervals: float  #: Sampling intervals that the gap is long


@dataclass(frozen=True, kw_only=True)
class InspectedRecord:
    """Content common to all records."""

    name: str
    source: str
    axis: str
    motion: Motion
    kind: Kind  #: The experiment that it is
    stated: bool  #: Whether the record states it, else it is recognised
    uses: tuple[Use, ...] = ()  #: Its possible uses, and others with the reason why not
    warnings: tuple[Notice, ...] = ()  #: Flaws of its clock, its encoder, its strokes

    @classmethod
    def of(cls, record: Record, **found: Any) -> Self:
        """Return the content of a record with its name, source and axis."""
        return cls(name=record.name, source=record.source, axis=record.axis, motion=record.motion, **found)


@dataclass(frozen=True, kw_only=True)
class Inspection(InspectedRecord):
    """Content of a record in time."""

    samples: int
    duration: float  #: From the first sample to the last [s]
    sampling: float | None  #: By the median interval [Hz]
    jitter: float  #: Standard deviation of the sampling intervals, gaps left out [s]
    channels: dict[str, Channel]  #: By name, what each holds
    gaps: tuple[Gap, ...] = ()  #: Where samples are missing
    stretches: tuple[Segment, ...] = ()  #: At constant velocity
    speeds: tuple[float, ...] = ()  #: Of the stretches, those within three per cent as one [m/s]
    #: Largest root mean square of the velocity about its mean in a stretch, over that mean; 0 where none swings
    swing: float = 0.0
    sine: Sine | None = None  #: That the motion follows, where it does
    reversals: tuple[int, ...] = ()  #: Samples at which the motion reverses
    rise: float | None = None  #: Share of the stroke that the force takes to come up after a reversal
    excites: bool = False  #: Whether the motion separates mass, viscous and Coulomb friction
    slope: float | None = None  #: Least slope of the branches between reversals, over their mean; null without force
    energy: Estimate | None = None  #: Lost per cycle of the logged force; null without cycles
    transmission: Transmission | None = None  #: Between two encoders; null without
    holding: HoldingMap | None = None  #: Forces at places where the axis holds; null of other kinds
    dropped: int = 0  #: Samples that were left out when the record was ingested

    @property
    def encoder_step(self) -> float | None:
        """Step of the position encoder [m]; None where the position is not quantised, or not logged."""
        return self.channels["position"].step if "position" in self.channels else None


@dataclass(frozen=True, kw_only=True)
class ResponseInspection(InspectedRecord):
    """Content of a measured frequency response."""

    points: int  #: Frequencies
    low: float  #: [Hz]
    high: float  #: [Hz]
    coherence: float | None  #: The least; null where none was measured


@dataclass(frozen=True, kw_only=True)
class TableInspection(InspectedRecord):
    """Content of a table of mean forces at velocities."""

    points: int  #: Rows that move
    directions: Literal[0, 1, 2]  #: Of motion that there are
    slowest: float  #: slowest, fastest: speed [m/s]
    fastest: float
    weakest: float  #: weakest, strongest: size of a force [N]
    strongest: float
    columns: tuple[str, ...]  #: That there are


def inspect_response(record: FrequencyResponse) -> ResponseInspection:
    """Return the content of a measured frequency response."""
    frequency = record.frequency
    coherence = None if record.coherence is None else float(np.min(record.coherence))
    decades = float(np.log10(frequency[-1] / frequency[0]))
    good = len(frequency) >= 8 and decades >= 1.0
    why = f"{len(frequency)} frequencies over {decades:.1f} decades" + ": 8 over one decade are needed" * (not good)
    return ResponseInspection.of(
        record, kind="frequency-response", stated=True, uses=(Use("plant", good, why),), points=len(frequency),
        low=float(frequency.min()), high=float(frequency.max()), coherence=coherence,
    )  # fmt: skip


def inspect_table(record: ForceVelocity) -> TableInspection:
    """Return the content of a table of forces and velocities, and whether a map can be fitted to it."""
    moving = record.velocity != 0.0
    v, F = record.velocity[moving], record.force[moving]
    speeds, directions = np.unique(np.round(np.abs(v), 12)), len(np.unique(np.sign(v)))
    good = len(speeds) > 1
    why = f"{len(speeds)} speeds in {'both directions' if directions == 2 else 'one direction'}"
    why += "" if len(speeds) >= SPEEDS else f": a map takes {SPEEDS}, here or with other records"
    found = (ONE_DIRECTION.found(level=None),) if directions == 1 else ()
    size = np.abs(F) if len(F) else np.zeros(1)
    slowest, fastest = (float(speeds.min()), float(speeds.max())) if len(speeds) else (0.0, 0.0)
    return TableInspection.of(
        record, kind=FORCE_VELOCITY, stated=True, uses=(Use("static", good, why),), warnings=found,
        points=len(v), directions=directions, slowest=slowest, fastest=fastest, weakest=float(size.min()),
        strongest=float(size.max()), columns=tuple(record.columns()),
    )  # fmt: skip


ONE_SPEED = 0.03  # Relative difference up to which two segments have the same speed

Inspected = Inspection | ResponseInspection | TableInspection

LONGEST = (0.5e-3, 0.1)  # Largest travel of pre-sliding [m, rad]: tens of micrometres on guideways, a degree in gears
FINE = 12.0  # Least encoder counts in a micro-step: with fewer, the virgin curve is off by more than 2 % of the loop
BRANCH = 20  # Least number of samples in a branch between reversals


def inspect(record: Record, *, flaws: bool = True) -> Inspected:
    """Return the content of a record in time or in frequency or of a table, and its uses.

    flaws: Whether warnings are wanted; without them only what bears on the uses is sought.
    """
    if not isinstance(record, Log):
        return inspect_response(record) if isinstance(record, FrequencyResponse) else inspect_table(record)
    log = record
    channels = {name: _channel(log, name, values) for name, values in log.channels().items()}
    sampling, jitter, gaps = _clock(log.time)
    found = Inspection.of(
        record, dropped=record.dropped, kind=record.kind or "motion", stated=record.kind is not None,
        samples=len(log), duration=float(log.time[-1] - log.time[0]),
        sampling=sampling, jitter=jitter, channels=channels, gaps=gaps, transmission=transmission_of(log),
    )  # fmt: skip
    if len(log) < STUCK:
        return replace(found, uses=(Use("identification", False, f"{len(log)} samples are too few"),))
    if (notice := holds(log)) is not None:
        why = "holding forces show friction at rest, and no motion"
        uses = tuple(Use(purpose, False, why) for purpose in ("static", "gms", "plant"))
        return replace(found, kind="holding-map", holding=holding_map(log), warnings=(notice,), uses=uses)
    segments, rests = segments_and_rests(replace(log, kind=None))
    sine, reversals, stairs = turns_of(log)
    rises = force_rises(log, reversals)
    rise = float(np.median([share for share, *_ in rises])) if rises else None
    warnings = clock_flaws([log], "inspect") if flaws else [*filter(None, [foreign_compensation(log)])]
    if log.force is not None and flaws:
        pairs = [(log, segment) for segment in segments]
        warnings += stroke_flaws(pairs, over_place(pairs))
    kind = record.kind or recognised_kind(log, segments, rests, sine, rise, len(reversals), stairs)
    segments = segments if kind in {"constant-velocity", "motion"} else []
    sine = sine if kind in {"presliding-sine", "sliding-sine"} else None
    if log.position is not None:
        found = replace(found, excites=excites(log.time, log.position))
    if log.position is not None and log.force is not None and len(reversals) > 1:
        energies = cycle_energies(log.position, log.force, reversals)
        lost = energy_per_cycle(energies, log.motion)
        strokes = np.abs(np.diff(log.position[reversals]))
        if kind in {*PRESLIDING, "motion"} and np.ptp(strokes) < ONE_SPEED * float(np.median(strokes)):
            warnings += energy_warnings(energies, log.time[reversals[::2]], log.motion)
        found = replace(found, slope=branch_slope(log.position, log.force, reversals), energy=lost)
    found = replace(
        found, kind=kind, stretches=tuple(segments), speeds=distinct_speeds(segments), sine=sine,
        swing=max((velocity_swing(log, segment) for segment in segments), default=0.0),
        reversals=tuple(map(int, reversals)), rise=rise, warnings=tuple(warnings),
    )  # fmt: skip
    seen = 0.0
    if log.position is not None and len(reversals) > 2:
        stroke = float(np.median(np.abs(np.diff(log.position[reversals]))))
        seen = resolved_travel(log.position, reversals) / stroke if stroke else 0.0  # where the reference alone moves
    kicked = any(notice.code == FOREIGN_COMPENSATION.code for notice in warnings)
    gms = Use("gms", False, "the control compensates friction at reversals") if kicked else None
    gms = gms or _swings(log, reversals) or _too_slow(log, rises) or _gms_use(found, seen, stairs)
    return replace(found, uses=(_static_use(found), gms, _plant_use(found)))


def distinct_speeds(segments: list[Segment]) -> tuple[float, ...]:
    """Return the velocities of segments in ascending order; equal speeds are replaced by their mean, by length."""
    speeds: list[list[Segment]] = []
    for segment in sorted(segments, key=lambda s: s.velocity):
        first = speeds[-1][0] if speeds else segment
        error = 3.0 * np.hypot(segment.velocity_se, first.velocity_se)
        if first is segment or segment.velocity - first.velocity > max(ONE_SPEED * abs(segment.velocity), error):
            speeds.append([])
        speeds[-1].append(segment)
    return tuple(float(np.average([s.velocity for s in speed], weights=[len(s) for s in speed])) for speed in speeds)


def _channel(log: Log, name: str, values: Real) -> Channel:
    step = None if name in {"time", "reference"} else counts(values)
    step = encoder_step(values) or None if name == "position" else step
    clipped = clipped_samples(values) if name in {"force", "input"} else 0
    return Channel(log.unit(name), float(values.min()), float(values.max()), step, clipped)


def _clock(time: Real) -> tuple[float, float, tuple[Gap, ...]]:
    """Return the sampling rate [Hz], the standard deviation of the intervals [s], and the gaps."""
    intervals = np.diff(time)
    usual = float(np.median(intervals))
    wide = intervals > GAP * usual
    gaps = tuple(Gap(float(time[k]), float(intervals[k] / usual)) for k in np.flatnonzero(wide))
    return 1.0 / float(intervals[~wide].mean()), float(intervals[~wide].std()), gaps


def _static_use(found: Inspection) -> Use:
    purpose = "static"
    if "force" not in found.channels:
        return Use(purpose, False, "no force was logged")
    if not found.stretches:
        return Use(purpose, False, "no segment at constant velocity")
    if clipped := found.channels["force"].clipped:
        return Use(purpose, False, f"the force is clipped in {clipped} samples")
    if (unsettled := sum(not segment.settled for segment in found.stretches)) == len(found.stretches):
        return Use(purpose, False, "the force never settles: longer strokes are needed")
    text = f"{len(found.speeds)} speeds" if len(found.speeds) > 1 else "one speed: a map takes records at others too"
    text += f", {unsettled} of {len(found.stretches)} segments not settled" if unsettled else ""
    return Use(purpose, True, text)


def _gms_use(found: Inspection, seen: float, stairs: Staircase | None) -> Use:
    """Return whether pre-sliding is visible; ``seen`` is the share of a stroke within `SAMPLES` after a reversal."""
    purpose = "gms"
    if missing := [name for name in ("position", "force") if name not in found.channels]:
        return Use(purpose, False, f"no {' and no '.join(missing)} was logged")
    if clipped := found.channels["force"].clipped:
        return Use(purpose, False, f"the force is clipped in {clipped} samples")
    position, step = found.channels["position"], found.encoder_step
    amplitude = found.sine.amplitude if found.sine else 0.5 * (position.high - position.low)
    if not amplitude:
        return Use(purpose, False, "the position does not move")
    if found.kind == "sliding-sine" and len(found.reversals) < 3:
        return Use(purpose, True, "for the attraction parameter C; knots take a sine in pre-sliding")
    if len(found.reversals) < 3:
        return Use(purpose, False, f"{len(found.reversals)} reversals: whole branches take three")
    if step and amplitude < STEPS * step:
        return Use(purpose, False, f"the amplitude is {amplitude / step:.1f} steps of the encoder: three are needed")
    if (branch := (found.reversals[-1] - found.reversals[0]) / (len(found.reversals) - 1)) < BRANCH:
        return Use(purpose, False, f"{branch:.0f} samples a branch are too few")
    if found.rise and seen > found.rise:
        why = f"{SAMPLES} samples behind a reversal go through pre-sliding: log faster, or move slower"
        return Use(purpose, False, why)
    if found.kind not in PRESLIDING and (found.rise is None or found.rise <= LOOP_SHARE):
        return Use(purpose, False, f"pre-sliding is over in {100 * (found.rise or 0.0):.1f} % of a stroke")
    if stairs is not None and stairs.step < FINE * stairs.count:
        counts = f"{stairs.step / stairs.count:.1f} steps of the encoder, or of its noise"
        return Use(purpose, False, f"a micro-step is {counts}: {FINE:.0f} are needed, so take larger steps")
    steps = f" of {2 * amplitude / step:.0f} steps of the encoder" if step else ""
    text = f"{len(found.reversals) - 1} branches{steps}"
    if found.slope is not None and found.slope > RISES:
        text += "; none of them slides: F_s takes `static=`, or a larger amplitude"
    return Use(purpose, True, text)


def _swings(log: Log, reversals: Indices) -> Use | None:
    """Return why a log shows no pre-sliding, if the axis swings about a slow reference; else None."""
    asked = 0 if log.reference is None else len(find_reversals(log.reference))
    if asked < 2 or len(reversals) < SWINGING * asked:
        return None
    frequency = 0.5 / float(np.median(np.diff(log.time[reversals])))
    return Use("gms", False, f"the axis swings at {frequency:.0f} Hz about its slow reference: log it at a lower K_p")


def _too_slow(log: Log, rises: list[tuple[float, int, float]]) -> Use | None:
    """Return why a log shows no pre-sliding, if its force rises between samples or over a long travel; else None."""
    if not rises:
        return None
    samples, travel = (float(np.median([rise[n] for rise in rises])) for n in (1, 2))
    usual = float(np.median(np.abs(np.diff(travelled(log)))))
    over, moves = (readable(size, log.unit("position")) for size in (travel, usual))
    if samples < 2 * SAMPLES or travel < 2 * SAMPLES * usual:
        rate = f"{1.0 / float(np.median(np.diff(log.time))):.3g} Hz"
        why = f"the force comes up within {over} of a reversal, and a sample at {rate} moves {moves}: log faster"
        return Use("gms", False, why)
    why = f"the force comes up over {over} after a reversal, which is not pre-sliding"
    return Use("gms", False, why) if travel > LONGEST[rotates(log.motion)] else None


def _plant_use(found: Inspection) -> Use:
    purpose = "plant"
    if "position" not in found.channels:
        return Use(purpose, False, "no position was logged")
    broad = found.kind == "frequency-response"
    by_motion = found.kind == "motion" and found.excites and not found.gaps  # a motion is filtered: evenly sampled
    if "input" not in found.channels:
        if broad and "force" in found.channels:
            why = "the excitation is broad-band, and determines B if the force is the drive's input"
            return Use(purpose, True, why)
        if by_motion and "force" in found.channels:
            return Use(purpose, True, "a motion in both directions; B and K_f take an input too")
        return Use(purpose, False, "no input was logged")
    if clipped := found.channels["input"].clipped:
        return Use(purpose, False, f"the input is clipped in {clipped} samples")
    if by_motion:
        return Use(purpose, True, "a motion in both directions, with changing speed and acceleration")
    motion = "; take it as a motion: `method='motion'`" * (found.excites and found.kind == "sliding-sine")
    return Use(purpose, broad, f"the excitation is {'' if broad else 'not '}broad-band{motion}")
