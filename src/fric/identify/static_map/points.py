"""Strokes of one axis on their way to a map: points with velocity, force and errors, and the corrections of these."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import compress
from typing import Literal, Self

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from fric.arrays import Real
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.channel import CLIPPED_UNUSED
from fric.flaws.static_map import ERRORS_OF_MEANS, RECORDS_WITHOUT_STROKE, ROWS_AT_REST, STICKS, STROKES_IN_PRESLIDING
from fric.identify.static_map.stribeck_fit import StribeckProblem
from fric.log import ForceVelocity, Log
from fric.notice import Notice, enumerated
from fric.records.over_strokes import REPEATED, OverPlace, over_place
from fric.records.recognition import kind_of
from fric.records.resolution import CONVERTED, clipped, fine, lattice_step
from fric.records.segments import ENOUGH, SHORTEST, Segment, steady_segments, travelled, velocity_swing
from fric.statistics import robust_deviation
from fric.units import Motion, readable, si_unit

Average = Literal["robust", "median"]
STILL = 1e-12  # Speed below which a row is at rest: no drive takes eleven days for 1 µm
ROW = ", row "  # Separator of the name of a table and the number of a row
UNEVEN = 0.25  # Largest relative difference in speed of the halves of a stroke with ripple
RISES = 0.02  # Least rise of the force in the second half of a stroke that ends in pre-sliding, as a share
ENDS = 0.15  # Share of the travel left out at either end of a stroke with ripple, for its ramps
SHORT = 32  # Number of lags summed one by one before a Fourier transform of all
HUBER = 1.345  # Huber's tuning constant: 95 % efficiency on Gaussian noise (Huber 1964)
GLITCH = 8.0  # Deviations from the median beyond which a sample is a glitch, if few are
LEVELS = 16  # Number of levels of a segment's force up to which its steps are coarse
CLIPPED = 0.1  # Largest share of clipped samples: their mean is off by a twentieth of the noise
LARGER = "Friction is not known beyond: log with a larger range of the force's trace."
FEWEST = 4  # Largest number of strokes that give no map: it has four parameters
GLITCHES = 0.01  # Largest share of glitches in the samples: more are real motion
Direction = Literal["auto", "both", "each"]
Form = Literal["auto", "coulomb", "stribeck"]
ShapeFactor = float | Literal["auto", "free"]
Weights = Literal["error", "equal"]


@dataclass(frozen=True)
class SpeedPoint:
    """The friction force at a constant velocity, from a stroke or a row of a table."""

    velocity: float  # Signed [m/s]
    force: float  # Robust mean [N], signed, without the linear damping of the drive where the plant is known
    standard_error: float  # Of the force [N], with autocorrelation
    samples: int  # From which it was taken
    record: str
    start: float  # Time in the record at which the steady segment begins [s]
    stop: float  # Time in the record at which it ends [s]
    settled: bool = True  # False where the force had not settled by half of the stroke
    swing: float = 0.0  # Root mean square of the velocity about its mean over that mean [1]; 0 where it does not swing
    clipped: float = 0.0  # Share of its samples whose force is clipped
    over_position: float = 0.0  # Force subtracted since it recurs at the places of this stroke [N]
    rounding: float = 0.0  # What steps in which the force was logged have of the standard error [N]
    stretch: tuple[Log, Segment] | None = field(default=None, repr=False, compare=False)  # None for a row of a table

    @property
    def of_record(self) -> str:
        """The name of the record, or of the table."""
        return self.record if self.stretch is not None else self.record.rpartition(ROW)[0] or self.record

    def less(self, force: float) -> Self:
        """Return the point without a force [N]."""
        return replace(self, force=self.force - float(force))


def stroke_points(
    records: Sequence[Log | ForceVelocity], *, average: Average = "robust", plant: Plant | None = None
) -> tuple[list[SpeedPoint], list[Notice]]:
    """Return a point for each stroke of the records, by velocity, and the warnings about the others.

    Each row of a table of forces and velocities gives a point. A record stated to be of constant velocity, but with too
    much ripple for a steady segment, gives its inner part.
    """
    logs = logs_of_strokes(records)
    points, notices = table_points([record for record in records if isinstance(record, ForceVelocity)], plant)
    without, step = [], force_step(logs)
    for log in logs:
        if isinstance(found := _points_of(log, average, plant, step), str):
            without += [f"{log.name} ({found})"] if kind_of(log) in {"constant-velocity", "motion"} else []
        else:
            points += found
    if not points:
        stated = any(log.kind == "constant-velocity" for log in logs)
        kinds = ", ".join(sorted({log.kind for log in logs if log.kind}))
        what = "no stroke at constant velocity was found"
        what += f" (the records say that they are {kinds})" if kinds else ""
        what += f": {'; '.join(without[:3])}" if stated else ""
        hint = "Log strokes long enough to settle at constant velocity; `fric inspect` shows what is there."
        raise FricError(what, where=records[0].source, hint=hint)
    if cut := dict.fromkeys(point.record for point in points if point.clipped > CLIPPED):
        if len(whole := [point for point in points if point.clipped <= CLIPPED]) > 0:
            points = whole
            notices.append(CLIPPED_UNUSED.found(counted=f"strokes of {enumerated(cut)}", left_out=True))
        elif any(fine(log.force, CONVERTED) for log in logs if log.force is not None):
            raise FricError("the force is clipped in each stroke", where=records[0].source, hint=LARGER)
    if without:
        notices.append(RECORDS_WITHOUT_STROKE.found(without=len(without), records=len(logs), why="; ".join(without)))
    return sorted(points, key=lambda point: point.velocity), notices


def slid(points: Sequence[SpeedPoint]) -> tuple[list[SpeedPoint], list[SpeedPoint]]:
    """Return the points of strokes that slid, and of those that ended in pre-sliding.

    In pre-sliding the force rises along the stroke in all logged directions; a place of higher friction raises it in
    one direction and lowers it in the other. Only the slowest strokes can end in pre-sliding, and are left out if they
    are at most half of all.
    """
    v, rising = np.array([point.velocity for point in points]), np.array([_rises(point) for point in points])
    ended = rising & [bool(rising[np.abs(v + back) <= REPEATED * abs(back)].all()) for back in v]
    slower = np.abs(v) < (1.0 - REPEATED) * np.max(np.abs(v[ended]), initial=0.0)
    if 2 * ended.sum() > len(points) or slower.sum() > ended.sum():
        ended[:] = False
    return list(compress(points, ~ended)), list(compress(points, ended))


def _rises(point: SpeedPoint) -> bool:
    """Return whether the magnitude of the force still rises in the second half of an unsettled stroke."""
    if point.settled or point.stretch is None or point.swing:
        return False
    log, segment = point.stretch
    force = np.sign(segment.velocity) * log.require("force", "the friction map")[segment.onset : segment.stop]
    parts = np.array([part.mean() for part in np.array_split(force[len(force) // 2 :], 8)])
    along = np.arange(8) - 3.5
    slope = float(along @ parts) / float(along @ along)
    error = float(np.sqrt(np.sum((parts - parts.mean() - slope * along) ** 2) / 6.0 / (along @ along)))
    return 7.0 * slope > RISES * abs(float(parts[-1])) and slope > 4.0 * error


def logs_of_strokes(records: Sequence[Log | ForceVelocity]) -> list[Log]:
    """Return the records in time to search for strokes: those stated to hold strokes, or else all."""
    logs = [record for record in records if isinstance(record, Log)]
    return [log for log in logs if log.kind == "constant-velocity"] or logs


def force_step(logs: Sequence[Log]) -> float:
    """Return the step of the forces of records [N], of any size; 0 without a step."""
    forces = [log.force[:: max(len(log) // ENOUGH, 1)] for log in logs if log.force is not None]
    return (lattice_step(np.concatenate(forces)) or 0.0) if forces else 0.0


def _points_of(log: Log, method: Average, plant: Plant | None, step: float) -> list[SpeedPoint] | str:
    """Return the points of a record, or the reason why there is none."""
    force = log.require("force", "the friction map")
    if not (segments := steady_segments(log)):
        rippling = _inner_part(log) if log.kind == "constant-velocity" else "no segment at constant velocity"
        if isinstance(rippling, str):
            return rippling
        segments = [rippling]
    points, at_limit = [], clipped(force)
    for segment in segments:
        part = slice(segment.start, segment.stop)
        mean = average(force[part], method, step)
        damping = plant.damping * segment.velocity if plant else 0.0
        swing = velocity_swing(log, segment)
        # The fast part of a slip is lost in noise: an axis that sticks is seen to swing less, by up to a half
        share = float(np.clip(2.0 * swing / STICKS - 1.0, 0.0, 1.0))
        error = float(np.hypot(mean.standard_error, 0.5 * share * np.std(force[part])))
        points.append(
            SpeedPoint(
                segment.velocity, mean.value - damping, error, len(segment), log.name, float(log.time[segment.start]),
                float(log.time[segment.stop - 1]), segment.settled, swing, float(at_limit[part].mean()),
                rounding=mean.rounding, stretch=(log, segment),
            )
        )  # fmt: skip
    return points


def _inner_part(log: Log) -> Segment | str:
    """Return the inner part of a stroke with ripple of the velocity, or the reason why there is none."""
    if len(log) < 2 * SHORTEST:
        return f"{len(log)} samples"
    z, unit = travelled(log), si_unit("velocity", log.motion)
    travel = float(z[-1] - z[0])
    count = (lattice_step(log.position) or 0.0) if log.position is not None else 0.0
    if abs(travel) <= SHORTEST * count or travel == 0.0:
        steps = f"{abs(travel) / count:.0f} steps of the encoder" if count else "nothing"
        return f"it moves by {steps}"
    if float(np.ptp(z)) > 1.2 * abs(travel):
        return "it moves to and fro"
    along = (z - z[0]) / travel
    first, last = int(np.argmax(along > ENDS)), int(len(along) - np.argmax(along[::-1] < 1 - ENDS))
    if last - first < 2 * SHORTEST:
        return f"{last - first} samples at speed"
    t, inner = log.time[first:last], z[first:last]
    half = (last - first) // 2
    speeds = [float(np.polyfit(t[part], inner[part], 1)[0]) for part in (slice(None, half), slice(half, None))]
    velocity = float(np.polyfit(t, inner, 1)[0])
    if abs(speeds[0] - speeds[1]) > UNEVEN * abs(velocity):
        return f"its speed goes from {readable(abs(speeds[0]), unit)} to {readable(abs(speeds[1]), unit)}"
    return Segment(first, last, velocity, abs(speeds[0] - speeds[1]) / 2, onset=first)


def standard_errors(table: ForceVelocity) -> tuple[Real, str]:
    """Return the standard error of each mean [N], shape (n,), and where it is from, if the table does not give it.

    It is that of the table; else the deviation over √n; else the deviation itself, an upper bound; or 0 if nothing is
    known, so that the scatter of the means about the map is their only error.
    """
    if table.error is not None:
        return table.error, ""
    if table.deviation is None:
        why = "it has no errors: the scatter of its means about the map is used instead"
        return np.zeros_like(table.force), why
    if table.n is None:
        why = "it has deviations but no n: each is used as the error of its mean, an upper bound"
        return table.deviation, why
    errors = np.asarray(table.deviation / np.sqrt(table.n))
    most = readable(float(errors.max()), table.unit("force"), 2)
    return errors, f"the errors of its means are deviation/√n, {most} at most; further scatter is allowed for"


def table_points(tables: Sequence[ForceVelocity], plant: Plant | None) -> tuple[list[SpeedPoint], list[Notice]]:
    """Return a point for each row that moves, without the plant's damping, and warnings about the tables."""
    points: list[SpeedPoint] = []
    notices: list[Notice] = []
    damping = plant.damping if plant else 0.0
    for table in tables:
        errors, why = standard_errors(table)
        counts = np.ones_like(table.force) if table.n is None else table.n
        for row, (v, F, error, n) in enumerate(zip(table.velocity, table.force, errors, counts, strict=True)):
            if abs(v) >= STILL:
                name = f"{table.name}{ROW}{row + 1}"
                points.append(SpeedPoint(float(v), float(F - damping * v), float(error), int(n), name, 0.0, 0.0))
        if still := int(np.count_nonzero(np.abs(table.velocity) < STILL)):
            notices.append(ROWS_AT_REST.found(f"'{table.name}'", rows=still))
        notices += [ERRORS_OF_MEANS.found(f"'{table.name}'", why=why)] if why else []
    return points, notices


@dataclass(frozen=True)
class Mean:
    """A location with its standard error."""

    value: float  # The robust mean or median, in the unit of the samples
    standard_error: float  # In the same unit
    rounding: float = 0.0  # What coarse steps of the samples have of the standard error, in the same unit


def average(samples: Real, method: Average = "robust", step: float = 0.0) -> Mean:
    """Return the robust mean (Huber) or the median of a segment of samples in steps, shape (n,)."""
    return huber_mean(samples, step) if method == "robust" else median(samples, step)


def huber_mean(samples: Real, step: float = 0.0) -> Mean:
    """Return Huber's M-estimate of location, with the scale from the median absolute deviation, or the mean.

    At constant velocity the mean force equals friction, but Huber's mean does not if encoder counts make the drive push
    to one side (2.5 %, thirty standard errors). If both differ by more than its standard error, which noise causes in
    one of ten thousand segments, the mean without glitches is returned.

    The standard error is that of an M-estimate from correlated samples, ``se² = s²·tau·E[psi²] / (n·E[psi']²)``, with
    tau from the winsorised samples, so that glitches lengthen neither the mean nor the memory.
    """
    x = np.asarray(samples, float)
    centre = float(np.median(x))
    scale = robust_deviation(x - centre) or float(np.std(x))
    rounding = _rounding_error(x, step)
    if scale <= np.finfo(float).eps * abs(centre):
        return Mean(float(np.mean(x)), rounding, rounding)
    for _ in range(50):
        psi = np.clip((x - centre) / scale, -HUBER, HUBER)
        shift = scale * float(np.mean(psi)) / max(float(np.mean(np.abs(psi) < HUBER)), 0.1)
        centre += shift
        if abs(shift) < 1e-10 * scale:
            break
    psi = np.clip((x - centre) / scale, -HUBER, HUBER)
    tau = autocorrelation_time(psi)
    spread = scale * float(np.sqrt(np.mean(psi**2))) / max(float(np.mean(np.abs(psi) < HUBER)), 0.1)
    error = spread * np.sqrt(tau / len(x))
    glitch = np.abs(x - np.median(x)) > GLITCH * scale
    kept = x[~glitch] if np.mean(glitch) <= GLITCHES else x
    if rounding < error and abs(np.mean(kept) - centre) <= error:
        return Mean(centre, float(np.hypot(error, rounding)), rounding)
    tau = autocorrelation_time(kept)
    error = float(np.std(kept)) * np.sqrt(tau / len(kept))
    return Mean(float(np.mean(kept)), float(np.hypot(error, rounding)), rounding)


def _rounding_error(x: Real, step: float) -> float:
    """Return the error of a mean by rounding to coarse steps q, if noise σ covers only a few of them.

    The samples determine the step where they have two levels or more, and none was given.

    Rounding Gaussian noise shifts a mean by at most about ``q/π·exp(-2π²σ²/q²)`` (Widrow and Kollár, Quantization
    Noise, 2008). Of the variance that is seen, up to q²/4 may be of two neighbouring levels alone, and is no noise; and
    without noise the error is uniform over a step: so ``q/√12·exp(-2π²·max(s² - q²/4, 0)/q²)`` is taken.
    """
    if len(levels := np.unique(x)) > LEVELS or (len(levels) == 1 and not step):
        return 0.0
    q = step or float(np.min(np.diff(levels)))
    variance = max(float(np.var(x)) - q**2 / 4, 0.0)
    return q / np.sqrt(12) * float(np.exp(-2 * np.pi**2 * variance / q**2))


def median(samples: Real, step: float = 0.0) -> Mean:
    """Return the median; its standard error is read off the order statistics around it.

    With n/tau independent samples the rank of the true median is n/2 ± sqrt(n/tau)/2 of the effective ranks, so one
    standard error is half the distance between the two quantiles ``1/2 ± 1/(2·sqrt(n/tau))``. Of samples in steps it is
    one of the steps, at any noise.
    """
    x = np.asarray(samples, float)
    middle = float(np.median(x))
    half = min(0.5, 0.5 / np.sqrt(len(x) / autocorrelation_time(np.sign(x - middle))))
    low, high = np.quantile(x, [0.5 - half, 0.5 + half])
    rounding = step / np.sqrt(12)
    return Mean(middle, float(np.hypot((high - low) / 2, rounding)), rounding)


def autocorrelation_time(x: Real, window: float = 5.0) -> float:
    """Return the integrated autocorrelation time [samples], ``1 + 2·Σ rho_k``, at least 1.

    The sum runs to the first lag beyond ``window`` times itself (Sokal 1989): longer sums add noise and no truth.
    """
    n = len(x)
    deviation = x - np.mean(x)
    if n < 8 or not np.any(deviation):
        return 1.0
    tau, power = -1.0, float(deviation @ deviation)
    for lag in range(min(n, SHORT)):  # noise has no memory: a few lags are enough, and a transform takes longer
        tau += 2.0 * float(deviation[: n - lag] @ deviation[lag:]) / power
        if lag >= window * tau:
            return float(np.clip(tau, 1.0, n))
    size = next_fast_len(2 * n, real=True)
    covariance = irfft(np.abs(rfft(deviation, size)) ** 2, size)[:n]
    taus = 2.0 * np.cumsum(covariance / covariance[0]) - 1.0
    enough = np.arange(n) >= window * taus
    at = int(np.argmax(enough)) if enough.any() else n - 1
    return float(np.clip(taus[at], 1.0, n))


@dataclass(frozen=True)
class Asked:
    """The arguments of `fric.identify_static`, by their names, in SI."""

    motion: Motion = "linear"
    plant: Plant | None = None
    delta: ShapeFactor = "auto"
    direction: Direction = "auto"
    over_position: Literal["auto", "off", "on"] = "auto"
    weights: Weights = "error"
    average: Average = "robust"
    form: Form = "auto"
    load: float | None = None
    damping_error: float = 0.0  # Half the 95 % interval of the plant's damping K_f·A/B [N·s/m], for the intervals

    @property
    def damping(self) -> float:
        """The plant's damping, which was subtracted from the forces [N·s/m]."""
        return self.plant.damping if self.plant else 0.0

    def of(self, value: float, dimension: str) -> Estimate:
        """Return a value with its unit of this axis."""
        return Estimate(float(value), si_unit(dimension, self.motion))

    def says(self, value: float, dimension: str, digits: int = 3) -> str:
        """Return a value for people, in the unit of this axis."""
        return readable(value, si_unit(dimension, self.motion), digits)


class Stretches(dict[int, tuple[Log, Segment]]):
    """Record and steady segment of the strokes that do not swing, by the number of the point."""

    @classmethod
    def of(cls, points: Sequence[SpeedPoint], records: Sequence[Log | ForceVelocity]) -> Self:
        """Return the stretches of points; none where records in time share a name."""
        names = [record.name for record in records if isinstance(record, Log)]
        unique = len({*names}) == len(names)
        return cls({n: p.stretch for n, p in enumerate(points) if unique and p.stretch is not None and not p.swing})

    @property
    def with_position(self) -> dict[int, tuple[Log, Segment]]:
        """Those whose position was logged."""
        return {n: pair for n, pair in self.items() if pair[0].position is not None}

    @cached_property
    def place(self) -> OverPlace | None:
        """What the force shows at the same places again."""
        return over_place(list(self.values()))


Into = Callable[[StribeckProblem, Sequence[SpeedPoint]], StribeckProblem]  # A change of the problem fitted to points


@dataclass(frozen=True)
class Correction:
    """What one thing that bends the forces of strokes does to them, and to the problem that is fitted to them."""

    points: Sequence[SpeedPoint] | None = None  # The points without it; None where they do not change
    records: Sequence[Log | ForceVelocity] | None = None  # The records without it, if subtracted from each sample
    together: Callable[["Strokes"], Real] | Real | None = None  # Moves of forces by its error [N], half widths (m, n)
    notices: Sequence[Notice] = ()  # Its warnings
    tried: Mapping[str, float] = field(default_factory=dict)  # Error at held-out strokes [N] of what was not taken
    into: Into | None = None  # What it changes of the problem
    between_records: Mapping[str, Estimate] = field(default_factory=dict)  # Deviation of records: level [1], offset [N]


@dataclass(frozen=True)
class Strokes:
    """The strokes of an axis, as the corrections have left them."""

    asked: Asked
    records: Sequence[Log | ForceVelocity]
    points: Sequence[SpeedPoint]
    stretches: Stretches
    together: Real  # Correlated errors of the forces of all points [N], half widths, shape (m, n)
    notices: tuple[Notice, ...] = ()
    tried: Mapping[str, float] = field(default_factory=dict)  # Errors at held-out strokes [N] of what was tried
    into: tuple[Into, ...] = ()
    between_records: Mapping[str, Estimate] = field(default_factory=dict)

    @classmethod
    def of(cls, records: Sequence[Log | ForceVelocity], asked: Asked) -> Self:
        """Return the strokes of records; raise FricError when there is none, or all took the same force."""
        points, notices = stroke_points(records, average=asked.average, plant=asked.plant)
        if len(points) <= FEWEST and any(notice.code == CLIPPED_UNUSED.code for notice in notices):
            what = f"the force is clipped in all but {len(points)} strokes"
            raise FricError(what, where=records[0].source, hint=LARGER)
        points, ended = slid(points)
        if ended:
            speeds = [asked.of(v, "velocity") for v in dict.fromkeys(point.velocity for point in ended)]
            notices.append(STROKES_IN_PRESLIDING.found(speeds=speeds))
        found = replace(cls.at(points, asked, records), notices=tuple(notices))
        if np.ptp(force := found.force) <= 1e-9 * np.abs(force).max(initial=0.0):
            what = f"every stroke took the same force, {asked.says(float(force[0]), 'force')}"
            hint = "Is it the right column? Friction changes its sign with the direction."
            raise FricError(what, where=records[0].source, hint=hint)
        return found

    @classmethod
    def at(cls, points: Sequence[SpeedPoint], asked: Asked, records: Sequence[Log | ForceVelocity] = ()) -> Self:
        """Return the strokes of points that are known."""
        return cls(asked, records, points, Stretches.of(points, records), np.empty((0, len(points))))

    @property
    def logs(self) -> list[Log]:
        """The records in time."""
        return [record for record in self.records if isinstance(record, Log)]

    @property
    def velocity(self) -> Real:
        """Of each point [m/s], signed, shape (n,)."""
        return np.array([point.velocity for point in self.points])

    @property
    def force(self) -> Real:
        """Of each point [N], signed, shape (n,)."""
        return np.array([point.force for point in self.points])

    @property
    def size(self) -> float:
        """Median size of the forces [N]."""
        return float(np.median(np.abs(self.force)))

    @property
    def rounded(self) -> float:
        """Common error of strokes at neighbouring speeds by the steps of the logged force [N].

        It is half a step without noise; the error of each point includes 1/√3 of it.
        """
        return float(np.sqrt(3.0) * np.median([point.rounding for point in self.points]))

    @property
    def one_speed(self) -> bool:
        """Whether all points have the same speed, so that there is no map."""
        speed = np.abs(self.velocity)
        return bool(np.ptp(speed) <= 0.02 * speed.max())

    @property
    def both_directions(self) -> bool:
        """Whether strokes of both directions were measured."""
        return len(np.unique(np.sign(self.velocity))) == 2

    @property
    def offset(self) -> float | None:
        """The offset [N] where it is not fitted, which takes strokes of both directions."""
        return None if self.both_directions and self.asked.load is None else self.asked.load or 0.0

    def without(self, found: Correction) -> Self:
        """Return the strokes with a correction made."""
        made = self if found.records is None else type(self).of(found.records, self.asked)
        together = found.together(made) if callable(found.together) else found.together
        return replace(
            made, points=made.points if found.points is None else found.points,
            together=self.together if together is None else np.vstack([self.together, together]),
            notices=(*made.notices, *found.notices), tried={**self.tried, **found.tried},
            into=self.into if found.into is None else (*self.into, found.into),
            between_records={**self.between_records, **found.between_records},
        )  # fmt: skip

    def one_way(self, sense: float) -> Self:
        """Return the strokes of one direction, the negative direction mirrored."""
        chosen = self.velocity * sense > 0
        points = [
            replace(p, velocity=sense * p.velocity, force=sense * p.force)
            for p, item in zip(self.points, chosen, strict=True) if item
        ]  # fmt: skip
        return replace(self, points=points, together=sense * self.together[:, chosen])
