"""The virgin curve from pre-sliding cycles (Section 3.2.1 of the paper).

A branch after a reversal is the virgin curve stretched by two in both axes (Masing). So each branch is moved with its
start to the origin, both axes are halved, and the branches are averaged over the cycles and over both directions::

      F                          V
      │      ┌──── P             │    ┌──── F_s
      │     ╱                    │   ╱
      │────╱──── z      →        │  ╱
      │   ╱                      │ ╱
     -P──┘ start                 └───────── z

The mean of the two directions is free of the amplifier's bias and of gravity.

Slip blocks from the virgin curve: a concave piecewise-linear fit, and eq. (6) of the paper.

N blocks with slip displacements ``d_1 < … < d_N`` give the curve ``V(z) = Σ k_i·min(z, d_i)``: linear between its
knots d_i, and concave exactly when every k_i is positive.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag
from scipy.ndimage import median_filter, uniform_filter1d
from scipy.special import stdtrit

from fric.arrays import Real
from fric.errors import FricError
from fric.friction.stribeck import StaticMap
from fric.identify.static_map.stribeck_fit import nonnegative
from fric.records.inspection import SATURATED, STEPS, least_slope
from fric.records.prepared import Prepared, begins_loaded, strokes_of
from fric.records.resolution import lattice_step
from fric.search import minimised, simplest

CLOSING = 0.03  # Share of a branch at its end that gives the force at the reversal
SLIDING = 0.85  # Share of the highest force above which a dip is the Stribeck fall along a fast stroke, no backlash
NEIGHBOURS, SCATTERING = 5, 21  # Neighbours: half of the first must show backlash, the second average the scatter
SAME_AMPLITUDE = 1.15  # Ratio of amplitudes up to which records are averaged; beyond, the larger continues the smaller
MOST_BLOCKS = 6  # Largest number of blocks that the information criterion may choose by default
REPEATABLE = 0.005  # Share by which friction repeats along a drive at best: a block must change the curve by more
STRONG = 6.0
"""Difference of Schwarz's criterion below which evidence for a block is not strong (Kass, Raftery, JASA 90, 1995): runs
whose B differs by 1e-13 scatter by 2.5."""
LEAST_SHARE = 1e-5  # Least share of a block in the friction, a few steps of a 16-bit force channel


@dataclass(frozen=True)
class HysteresisCycles:
    """A pre-sliding record and its cycles."""

    record: Prepared  # The record as it was prepared, with the reversals of its strokes
    cycles: tuple[int, int]  # Number of the first and last cycle (from 1) that the identification uses
    loaded: bool = False  # Whether the contact was loaded where it begins: its first stroke is left out

    @property
    def amplitude(self) -> float:
        """Half of the median stroke [m]."""
        return 0.5 * float(np.median(np.abs(np.diff(self.record.motion.position[self.record.reversals]))))

    def chosen(self) -> list[tuple[int, int, int]]:
        """Return the samples of start, reversal and end of the used cycles."""
        r = self.record.reversals.tolist()
        return [(r[n], r[n + 1], r[n + 2]) for n in range(0, len(r) - 2, 2)][self.cycles[0] - 1 : self.cycles[1]]

    def for_replay(self) -> Prepared:
        """Return the part of the record that is compared: from first to last reversal of the chosen cycles.

        Without a plant the force holds the drive's linear damping, which no map tells: the record gets a term for it.
        """
        n, (first, last), reversals = len(self.record.force), self.cycles, self.record.reversals
        done = self.record.done
        done = done if done.plant else replace(done, own=(*done.own, "damping"))
        whole = (len(reversals) - 1) // 2
        used = np.zeros(n, dtype=bool)
        used[reversals[2 * (first - 1)] : n if (first, last) == (1, whole) else reversals[2 * last]] = True
        return replace(self.record, used=used, done=done)


def find_cycles(record: Prepared, cycles: tuple[int, int] | None = None) -> HysteresisCycles:
    """Find the cycles of a record, each of two half cycles between reversals.

    cycles: The first and the last cycle to use, counted from 1; by default all.
    Raises FricError: When there is no whole cycle, the chosen cycles do not exist, or the amplitude is under three
        encoder steps.
    """
    motion, where = record.motion, record.log.where
    if len(reversals := strokes_of(record)) < 3:
        hint = "Log two cycles or more of a slow sine."
        raise FricError(f"no whole cycle is in it ({len(reversals)} reversals)", where=where, hint=hint)
    if loaded := cycles is None and begins_loaded(record, reversals):
        reversals = reversals[1:]
    count = (len(reversals) - 1) // 2
    first, last = cycles or (1, count)
    if first > count:
        hint = "Choose `cycles=` anew."
        raise FricError(f"cycle {first} was asked for, and there are {count}", where=where, hint=hint)
    hysteresis = HysteresisCycles(replace(record, reversals=reversals), (first, min(last, count)), loaded)
    if hysteresis.amplitude < STEPS * motion.step:
        steps = hysteresis.amplitude / motion.step
        what = f"the amplitude is {steps:.1f} steps of the encoder, too few to see the friction"
        raise FricError(what, where=where, hint="Log a larger amplitude: ten steps or more.")
    return hysteresis


@dataclass(frozen=True)
class VirginCurve:
    """Force over displacement of a relaxed contact, from the origin."""

    displacement: Real  # displacement, force: the curve [m], [N], shape (n,)
    force: Real
    band: Real  # Half width of its 95 % band, from the scatter of the cycles [N], shape (n,)
    cycles: Real  # The curve of each cycle by itself [N], NaN where another record gives the curve, shape (cycles, n)
    record: tuple[tuple[str, float], ...]  # Record that gives each part, and the displacement up to which it does [m]
    level: float  # Friction force at the reversals of the largest cycles [N]: the plateau, where these slide
    mismatch: float = 0.0  # Largest step where a larger record continues a smaller [N]; positive where that ends higher
    final_slope: float = 0.0  # Least slope of the curve's outer half over its mean slope: 0 where all blocks slip
    step: float = 0.0  # step, force_step: those of encoder [m] and force [N]; 0 where none is visible
    force_step: float = 0.0
    steps: tuple[float, ...] = ()  # What the end of each record but the largest is above the next [N]
    mismatch_half: float = 0.0  # Half of the 99.7 % interval of the step, by the scatter of cycles [N]

    def __call__(self, z: Real | float) -> Real:
        """Return the force [N] at displacements z [m], linear between the points and from the origin."""
        return np.interp(z, np.append(0.0, self.displacement), np.append(0.0, self.force))

    @property
    def blur(self) -> Real:
        """Uncertainty of the force due to the encoder [N], shape (n,).

        A position is known to ±step/2, evenly spread, at the reversal and after it. Magnified by the slope of the curve
        (its chord over one step to either side), the half of their difference is ``step/√24·dV/dz``.
        """
        if self.step == 0.0:
            return np.zeros_like(self.force)
        before = np.maximum(self.displacement - self.step, 0.0)
        after = np.minimum(self.displacement + self.step, self.displacement[-1])
        return np.asarray(np.abs((self(after) - self(before)) / (after - before)) * self.step / np.sqrt(24.0))

    @property
    def saturates(self) -> bool:
        """True if the curve ends in a plateau."""
        return self.final_slope < SATURATED

    @property
    def hollow(self) -> tuple[float, float]:
        """Where the curve is furthest below its least concave majorant [m], and by how much, beyond its error [N].

        Friction that slips block by block is concave; backlash between motor and table is flat, and rises again. Not
        backlash are a step between two records (friction that grew with the time of rest in the slower record, or that
        is not of blocks in parallel, whose branches are all equal) and a fall with speed once all blocks slide.
        """
        z, F = np.append(0.0, self.displacement), np.append(0.0, self.force)
        for (_, end), step in zip(self.record, self.steps, strict=False):  # a larger record may be all higher or lower
            F[z > end] += step
        # the greatest of many noisy values is above all friction: the majorant is that of neighbours' medians
        F[1:] = median_filter(F[1:], NEIGHBOURS, mode="nearest")
        above = [0]
        for n in range(1, len(z)):
            while len(above) > 1:
                first, last = above[-2:]
                if (F[last] - F[first]) * (z[n] - z[first]) > (F[n] - F[first]) * (z[last] - z[first]):
                    break
                above.pop()
            above.append(n)
        below = (np.interp(z, z[above], F[above]) - F)[1:]
        count = np.isfinite(self.cycles).sum(axis=0)  # not the band, which may include errors of the model
        scatter = np.nansum((self.cycles - self.force) ** 2, axis=0) / np.maximum(count * (count - 1), 1)
        # of few cycles one place scatters too little by chance, its neighbours alike; a drive that hunts repeats itself
        ripple = (self.force - median_filter(self.force, NEIGHBOURS, mode="nearest")) ** 2
        scatter = np.maximum(uniform_filter1d(scatter + ripple, SCATTERING), 0.0)
        below -= 2.5 * np.sqrt(scatter + self.blur**2 + self.force_step**2 / 12.0)
        for _, end in self.record[:-1]:
            below[np.abs(self.displacement - end) < 0.2 * end] = 0.0
        below[F[1:] > SLIDING * F.max()] = 0.0
        below[self.displacement < 2.0 * self.step] = 0.0  # a staircase is hollow between two counts
        at = int(np.argmax(below))
        return float(self.displacement[at]), max(float(below[at]), 0.0)

    def without_cycles(self) -> Iterator["VirginCurve"]:
        """Yield the curve with each cycle left out in turn."""
        for n in range(len(self.cycles)):
            rest = np.delete(self.cycles, n, axis=0)
            seen = np.isfinite(rest).any(axis=0)
            force = np.where(seen, np.nansum(rest, axis=0) / np.maximum(np.isfinite(rest).sum(axis=0), 1), self.force)
            yield replace(self, force=force)


def with_all_errors(curve: VirginCurve, model: Real) -> VirginCurve:
    """Return a curve whose band includes, besides the scatter of its cycles, the error common to all cycles.

    That is the blur of the encoder, the step where one record continues another, and how far the curve is from that of
    the model that was refined by replay: while the controller hunts between two counts, the contact goes through minor
    cycles that the smoothed motion does not have, and the mean force is below the virgin curve. Where the curve ends in
    a plateau, its slope there may be a force over position, which adds as much to the curve from the origin on.

    model: The refined model's force at its displacements [N], shape (n,).
    """
    z, outer = curve.displacement, curve.displacement > 0.5 * curve.displacement[-1]
    place = np.polyfit(z[outer], curve.force[outer], 1)[0] * z if curve.saturates and outer.sum() > 1 else 0.0 * z
    parts = np.nan_to_num(curve.band), 1.96 * curve.blur, curve.mismatch + 0.0 * z, curve.force - model, place
    return replace(curve, band=np.sqrt(sum(part**2 for part in parts)))


def virgin_curve(
    hysteresis: Sequence[HysteresisCycles], static: StaticMap | None = None, negative: StaticMap | None = None
) -> VirginCurve:
    """Return the virgin curve of one or more records: the small cycle up to its amplitude, the larger cycle beyond.

    In a fast cycle the level is below F_s. All limits alpha_i·s(v) scale together, so that with
    ``q = (|s(v)| + F_s)/(2·F_s)`` (slipping at v after a reversal at rest) the halved branch is ``q·V(z/q)``: both
    axes are divided by q. This is exact for the GMS model but for its lag s/C, and puts the plateau at F_s. Where the
    directions have a map each, ``q = (|s_±(v)| + F_s∓)/(F_s+ + F_s-)``, and the plateau is at the mean of the two.

    static: The static map; without it no correction is made, and no viscous friction is subtracted.
    negative: That of the negative direction, where each direction has a map.
    Raises FricError: When the force at the reversals of a record does not oppose its motion.
    """
    ordered = sorted(hysteresis, key=lambda cycle: cycle.amplitude)
    groups: list[list[HysteresisCycles]] = []
    for cycle in ordered:
        if groups and cycle.amplitude < SAME_AMPLITUDE * groups[-1][0].amplitude:
            groups[-1].append(cycle)
        else:
            groups.append([cycle])
    parts, extent, steps = [], 0.0, list[tuple[float, float]]()
    last: tuple[Real, Real] | None = None
    for group in groups:
        edges = _edges(max(cycle.amplitude for cycle in group), max(cycle.record.motion.step for cycle in group))
        places, cycles, levels = zip(*(_branches(record, (static, negative), edges) for record in group), strict=True)
        merged, place = np.vstack(cycles), np.nanmean(np.vstack(places), axis=0)
        seen = np.isfinite(merged).mean(axis=0) > 0.5
        keep = seen & (place > extent)
        if last is not None and keep.any():
            steps.append(_apart(last[1], np.array([np.interp(last[0], place[seen], row[seen]) for row in merged])))
        if not np.mean(levels) > 0.0:
            what = "the force at the reversals does not oppose the motion: too few encoder steps, or a wrong sign"
            hint = "Log a larger amplitude: ten steps or more. Look at the sign of the force."
            raise FricError(what, where=group[0].record.log.where, hint=hint)
        parts.append((group[0].record.log.name, place[keep], merged[:, keep], float(np.mean(levels))))
        extent = float(place[keep].max(initial=extent))
        last = (place[keep][-NEIGHBOURS:], merged[:, keep][:, -NEIGHBOURS:]) if keep.any() else last
    mismatch, half = max(steps, key=lambda step: abs(step[0]), default=(0.0, 0.0))
    coarse = max(lattice_step(cycle.record.log.require("force", "the virgin curve")) or 0.0 for cycle in ordered)
    return replace(
        _spliced(parts, mismatch), mismatch_half=half, step=max(cycle.record.motion.step for cycle in ordered),
        force_step=coarse, steps=tuple(step for step, _ in steps),
    )  # fmt: skip


def _apart(cycles: Real, others: Real) -> tuple[float, float]:
    """Return the mean difference of cycles from others, and half of its interval of 99.7 % [N]; each is a row."""
    rows = [np.nanmean(array[np.isfinite(array).any(axis=1)], axis=1) for array in (cycles, others)]
    error = np.sqrt(sum(float(np.var(row, ddof=1)) / len(row) for row in rows if len(row) > 1))
    surely = float(stdtrit(max(sum(map(len, rows)) - 2, 1), 0.9985))
    return float(rows[0].mean() - rows[1].mean()), surely * float(error)


def _spliced(parts: list[tuple[str, Real, Real, float]], mismatch: float) -> VirginCurve:
    names, places, cycles, levels = zip(*parts, strict=True)
    displacement = np.concatenate(places)
    table = np.where(block_diag(*map(np.ones_like, cycles)), block_diag(*cycles), np.nan)
    count = np.isfinite(table).sum(axis=0)
    force = np.nanmean(table, axis=0)
    scatter = np.sqrt(np.nansum((table - force) ** 2, axis=0) / np.maximum(count - 1, 1))
    band = np.where(count > 1, stdtrit(np.maximum(count - 1, 1), 0.975) * scatter / np.sqrt(count), np.nan)
    relative = least_slope(displacement, force)
    ends = tuple((name, float(place[-1])) for name, place in zip(names, places, strict=True) if len(place))
    return VirginCurve(displacement, force, band, table, ends, levels[-1], mismatch, relative)


def _branches(
    hysteresis: HysteresisCycles, maps: tuple[StaticMap | None, StaticMap | None], edges: Real
) -> tuple[Real, Real, float]:
    """Return the halved branches of one record, binned: displacement, the mean of each cycle's directions, level."""
    motion, force, static = hysteresis.record.motion, hysteresis.record.force, maps[0]
    z, v, ratio = motion.position, motion.velocity, np.ones(len(motion.velocity))
    if static is not None:
        back = maps[1] or static
        force = force - np.where(v < 0, back.sigma, static.sigma) * v
        ratio = np.where(v < 0, back.level(v) + static.F_s, static.level(v) + back.F_s) / (static.F_s + back.F_s)
    found, levels = [], []
    for first, reversal, last in hysteresis.chosen():
        halves = [(first, reversal), (reversal, last)]
        signs = [1.0 if z[b] > z[a] else -1.0 for a, b in halves]
        parts = [(sign, slice(a, b + 1)) for sign, (a, b) in zip(signs, halves, strict=True)]
        ends = [_closing(sign * z[part], v[part], sign * force[part], motion.step) for sign, part in parts]
        level = 0.5 * (ends[0] + ends[1])
        levels.append(level)
        sums = np.zeros((2, len(edges) - 1))
        for sign, end, (a, b) in zip(signs, ends, halves, strict=True):
            q = ratio[a : b + 1]
            halved = 0.5 * (sign * force[a : b + 1] - (end - level) + level) / q
            sums += 0.5 * np.array(_binned(0.5 * sign * (z[a : b + 1] - z[a]) / q, halved, edges))
        found.append(sums)
    where, table = np.swapaxes(found, 0, 1)
    count = np.isfinite(where).sum(axis=0)
    place = np.where(count > 0, np.nansum(where, axis=0) / np.maximum(count, 1), 0.5 * (edges[1:] + edges[:-1]))
    return place, table, float(np.mean(levels))


def _binned(at: Real, value: Real, edges: Real) -> tuple[Real, Real]:
    """Return the means of displacement and value in each bin; between samples that are further apart, the chord."""
    index = np.digitize(at, edges) - 1
    inside = (index >= 0) & (index < len(edges) - 1)
    number = np.bincount(index[inside], minlength=len(edges) - 1)
    filled = number > 0
    place = 0.5 * (edges[1:] + edges[:-1])
    mean = np.full_like(place, np.nan)
    for target, values in ((place, at), (mean, value)):
        target[filled] = (np.bincount(index[inside], values[inside], len(place)) / np.maximum(number, 1))[filled]
    gap = ~filled & (place > place[filled][0]) & (place < place[filled][-1])
    mean[gap] = np.interp(place[gap], place[filled], mean[filled])
    return place, mean


def _closing(z: Real, v: Real, force: Real, step: float) -> float:
    """Return the force at the end of a branch: its last part, regressed on the travel and on the speed that are left.

    The speed falls as the root of the travel to the reversal, and s(v) rises to F_s with it. Within the last count the
    drive may hunt, and its force may have turned already: that count is left out, where the motion is no dwell.
    """
    stroke = z[-1] - z[0]
    left = z[-1] - z
    near = (left <= CLOSING * stroke + 4.0 * step) & (left >= step)
    if near.sum() < 12:
        near = left <= CLOSING * stroke + 4.0 * step
    columns = [np.ones(near.sum()), left[near] / stroke, np.abs(v[near]) / np.abs(v).max()]
    solution, *_ = np.linalg.lstsq(np.column_stack(columns), force[near], rcond=1e-9)
    return float(solution[0])


def _edges(amplitude: float, step: float) -> Real:
    """Return bin edges from 0 to the amplitude: fine at the origin, growing with the displacement."""
    least = max(step / 16, 1e-3 * amplitude)
    edges = [0.0]
    while edges[-1] < amplitude:
        edges.append(edges[-1] + max(least, 0.02 * edges[-1]))
    return np.append(edges[:-1], amplitude * 1.001)


@dataclass(frozen=True)
class Blocks:
    """Slip blocks in the order of their slip displacements."""

    k: Real  # Stiffness of each block [N/m], shape (N,)
    displacement: Real  # Displacement at which each block slips [m], shape (N,)

    def __len__(self) -> int:
        return len(self.k)

    @property
    def limit(self) -> Real:
        """Force ``W_i = k_i·d_i`` at which each block slips [N]."""
        return self.k * self.displacement

    def __call__(self, z: Real | float) -> Real:
        """Return the virgin curve [N] at displacements z [m]."""
        return np.asarray(np.minimum(np.asarray(z)[..., None], self.displacement) @ self.k)


def blocks_from_knots(knots: Real, force: Real) -> Blocks:
    """Solve eq. (6) for any number of blocks, from the knots that the user chose.

    ``K_j = Σ_{i≥j} k_i`` is the slope before knot j, so ``k_j = K_j - K_{j+1}``, and ``Σ W_i`` is the force at the
    last knot (the paper prints four blocks and lost a row).

    knots: Displacements of the knots [m], increasing, shape (N,).
    force: The virgin curve at the knots [N], shape (N,).
    Raises FricError: When the knots do not increase, or the curve is not concave there (a stiffness would be negative).
    """
    knots, force = np.asarray(knots, float), np.asarray(force, float)
    if len(knots) == 0 or (np.diff(knots, prepend=0.0) <= 0).any():
        raise FricError("the knots do not increase from zero", hint="Name them in order, as in '0.9 um, 26 um, 54 um'.")
    slopes = np.diff(force, prepend=0.0) / np.diff(knots, prepend=0.0)
    k = slopes - np.append(slopes[1:], 0.0)
    if (k <= 0).any():
        bad = int(np.flatnonzero(k <= 0)[0])
        knot = f"knot {bad + 1} ({knots[bad] * 1e6:.3g} µm)"
        what = f"the virgin curve does not get flatter at {knot}, so its block would have no stiffness"
        raise FricError(what, hint="Move that knot, leave it out, or use `knots='auto'`.")
    return Blocks(k, knots)


def fit_blocks(curve: VirginCurve, count: int, begun: list[Real] | None = None) -> Blocks:
    """Fit a concave piecewise-linear curve of ``count`` blocks by weighted least squares.

    The knots are placed one after the other where each helps most, and all moved each time: a global search (CRS2)
    behind that lowered the squares of 70 fits by 0.8 % at most. For given knots the stiffnesses are a non-negative
    least-squares problem, which makes the curve concave. A block that would not slip within the curve keeps its
    stiffness; its slip displacement is then where the curve reaches ``curve.level``.

    begun: Knots placed one after the other, by number of knots, shared with fits of other numbers of blocks.
    """
    extent = float(curve.displacement[-1])
    low, high = np.log(max(float(curve.displacement[0]), 1e-4 * extent)), np.log(extent)
    sliding = curve.saturates
    solved = _stiffnesses(curve, [] if sliding else [extent])
    free = count if sliding else count - 1
    knots = _placed(lambda x: solved(x)[1], low, high, free, [] if begun is None else begun) if free else np.zeros(0)
    knots = np.sort(knots)
    k, d = solved(knots)[0], np.exp(knots)
    if not sliding:
        left = curve.level - float(k[:-1] @ d)
        d = np.append(d, max(left / k[-1], extent) if k[-1] > 0 else extent)
    if not (keep := k * d > LEAST_SHARE * float(k @ d)).any():
        hint = "Look at the sign and the units of the force, and at the plant whose inertia is taken off."
        raise FricError("the virgin curve does not rise: what is left of the force is not friction", hint=hint)
    return Blocks(k[keep], d[keep])


@dataclass(frozen=True)
class Choice:
    """The number of blocks that an information criterion chose, and the candidates."""

    candidates: tuple[Blocks, ...]  # The fit with 1, 2, … blocks
    rms: tuple[float, ...]  # Misfit of each [N]
    criterion: tuple[float, ...]  # Schwarz's of each number: the fewest blocks with the least, to `STRONG`, are chosen
    spread: float  # Median spread that a point of the curve is given [N]
    unit: str = "N"  # Unit of the force, for messages

    @property
    def chosen(self) -> int:
        """Index of the chosen fit."""
        return simplest(self.criterion, STRONG)

    @property
    def blocks(self) -> Blocks:
        """The chosen fit."""
        return self.candidates[self.chosen]

    @property
    def reason(self) -> str:
        """Reason against more blocks, in a sentence."""
        chosen, count = self.chosen, self.chosen + 1
        if count == len(self.candidates):
            return f"{count} blocks fit best (information criterion), the most that were tried"
        return (
            f"{count} block{'s' * (count > 1)}: another lowers the misfit from {self.rms[chosen]:.2g} to "
            f"{self.rms[count]:.2g} {self.unit} rms; friction repeats to {self.spread:.2g} {self.unit}"
        )


def choose_blocks(curve: VirginCurve, most: int = MOST_BLOCKS, unit: str = "N") -> Choice:
    """Choose the number of blocks by Schwarz's information criterion, ``BIC(N) = Σ r²/σ² + 2·N·ln n``.

    σ holds the scatter of the cycles, the blur of the encoder, and a floor of 0.5 % of the level (`REPEATABLE`).
    Without the floor, noise-free simulated cycles would separate two blocks that no drive repeats well enough to show.
    Points of the curve within one step of the encoder count as a single point: n is their number. The search ends when
    the criterion has risen twice.
    """
    standard_error = np.nan_to_num(curve.band, nan=0.0) / 2.0
    spread = np.sqrt(standard_error**2 + curve.blur**2 + (REPEATABLE * curve.level) ** 2)
    share = np.clip(np.gradient(curve.displacement) / curve.step, 0.0, 1.0) if curve.step else np.ones_like(spread)
    number = float(share.sum())
    candidates, rms, criterion = [], [], []
    begun: list[Real] = []
    for count in range(1, most + 1):
        blocks = fit_blocks(curve, count, begun)
        residual = curve.force - blocks(curve.displacement)
        candidates.append(blocks)
        rms.append(float(np.sqrt(np.mean(residual**2))))
        criterion.append(float(share @ (residual / spread) ** 2 + 2 * count * np.log(number)))
        if count > 2 and criterion[-1] > criterion[-2] > criterion[-3]:
            break
    return Choice(tuple(candidates), tuple(rms), tuple(criterion), float(np.median(spread)), unit)


def fit_without_cycles(curve: VirginCurve, blocks: Blocks) -> list[Blocks]:
    """Return the fit with each cycle left out in turn, its knots moved from those of all cycles."""
    extent = float(curve.displacement[-1])
    start = np.log(blocks.displacement[blocks.displacement < extent * (1 - 1e-9)])
    beyond = np.full(len(blocks) - len(start), extent)
    solved = _stiffnesses(curve, beyond)
    found = []
    for other in curve.without_cycles():
        knots = start
        if len(start):

            def cost(x: Real, force: Real = other.force) -> float:
                return solved(x, force)[1]

            knots = _moved(cost, start, start - 1.0, np.minimum(start + 1.0, np.log(extent)))
        k, _ = solved(knots, other.force)
        d = np.append(np.exp(knots), beyond)
        for n in range(len(start), len(d)):
            d[n] = max((curve.level - float(k[:n] @ d[:n])) / max(k[n], 1e-300), extent)
        found.append(Blocks(np.maximum(k, 1e-9 * k.max()), d))
    return found


def _stiffnesses(curve: VirginCurve, beyond: Sequence[float] | Real) -> Callable[..., tuple[Real, float]]:
    """Return stiffnesses of blocks, and misfit, over logarithms of knots; ``beyond``: knots not searched [m]."""
    weight = weights(curve)
    place, rows = curve.displacement[:, None], weight[:, None]

    def solved(knots: Real, force: Real = curve.force) -> tuple[Real, float]:
        d = np.append(np.exp(knots), beyond)
        limit, rest = nonnegative(rows * np.minimum(place / d, 1.0), weight * force, 100 * len(d))
        return limit / d, rest**2

    return solved


def _placed(cost: Callable[[Real], float], low: float, high: float, count: int, begun: list[Real]) -> Real:
    """Return the knots (logarithms) of least cost; see `fit_blocks`."""
    while len(begun) < count:  # add a knot where it helps most, then move all
        tried = (np.append(begun[-1] if begun else np.zeros(0), place) for place in np.linspace(low, high, 40))
        begun.append(_moved(cost, min(tried, key=cost), low, high))
    return _moved(cost, begun[count - 1], low, high)  # again with large steps, out of a flat valley


def _moved(cost: Callable[[Real], float], start: Real, low: Real | float, high: Real | float) -> Real:
    """Return the nearest minimum by NLopt's Sbplx (Rowan 1990) within bounds."""
    start, most = np.clip(start, low, high), 500 * len(start)
    return minimised("LN_SBPLX", cost, start, low, high, maxeval=most, xtol_abs=1e-7, ftol_rel=1e-10)


def weights(curve: VirginCurve) -> Real:
    """Return a weight for each point of a virgin curve, the inverse of its spread [1/N], shape (n,).

    So that points at which the cycles agree by chance do not dominate the fit, the spread is at least the median spread
    and 0.02 % of the level; it includes the blur of the encoder.
    """
    spread = np.nan_to_num(curve.band, nan=0.0)
    floor = max(float(np.median(spread)), 2e-4 * abs(curve.level))
    return np.asarray(1.0 / np.sqrt(spread**2 + floor**2 + curve.blur**2))
