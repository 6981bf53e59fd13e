"""Modes of the control that switch within a record: found from a state channel, else from the error at reversals."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import compress, groupby, pairwise

import numpy as np

from fric.arrays import Indices, Real
from fric.columns import PRESLIDING, Kind
from fric.estimate import Estimate
from fric.flaws.channel import MODES_SWITCH
from fric.log import Log
from fric.notice import Notice
from fric.records.flaws import SAMPLES, Tracking, tracking
from fric.records.motion import find_reversals
from fric.records.recognition import kind_of, visible_step
from fric.records.segments import SHORTEST, travelled
from fric.units import readable

GAP = 9.5  # Ratio of an interval to the usual one above which samples that lack are a gap
PAUSE = 0.2  # Least duration of a rest between two experiments of one record [s]
MOST_PARTS = 64  # Largest number of parts of a record: a state that changes more often is no mode of the control
STROKES_ALIKE = 0.02  # Largest relative difference in length and speed of strokes of the same motion
ERRORS_APART = 1.15  # Ratio of errors at reversals of the same motion above which the control has two modes
COUNTS = 3.0  # Least difference of these errors in encoder counts
SCATTER = 0.1  # Largest scatter of either size over their distance, on a logarithmic scale
STROKES = 3  # Least number of consecutive strokes in a mode that no channel shows


@dataclass(frozen=True)
class ModePart:
    """Samples of a record from ``start`` to ``stop`` in one mode, and whether a channel names it."""

    mode: str
    start: int
    stop: int
    logged: bool


@dataclass(frozen=True)
class _ModeStroke:
    start: int  # First sample of the look at its reversal
    stop: int  # At the next reversal
    motion: tuple[float, float, float]  # Length [m], highest speed [m/s], direction
    error: float  # Root mean square of the tracking error [m]
    glitch: float  # Range of the deviation about its reversal [m]


def modes_of(log: Log) -> list[ModePart]:
    """Return the parts of a record, each in one mode of the control; empty if the mode does not switch."""
    found = _logged(log) if log.mode is not None else _seen(log)
    return found if len({part.mode for part in found}) > 1 else []


def parts_of(log: Log) -> list[Log]:
    """Return the parts of a record, each named by its mode, without those in which the drive is off: its force is 0.

    The whole record is returned if no mode switches; of a motion with gaps, the parts between these.
    """
    gaps = np.flatnonzero((steps := np.diff(log.time)) > GAP * np.median(steps)) + 1
    if 0 < len(gaps) < MOST_PARTS and kind_of(log) == "motion":
        ends = [cut for cut in pairwise([0, *gaps, len(log)]) if cut[1] - cut[0] >= SAMPLES]
        pieces = [replace(log.slice(*cut), name=f"{log.name} {n}") for n, cut in enumerate(ends, 1)]
        return [part for piece in pieces for part in parts_of(piece)] or [log]
    found, count = list[Log](), dict[str, int]()
    for part in modes_of(log):
        if log.force is not None and log.input is None and not log.force[part.start : part.stop].any():
            continue
        count[part.mode] = n = count.get(part.mode, 0) + 1
        name = f"{log.name} {part.mode}{f' {n}' if n > 1 else ''}"
        found.append(replace(log.slice(part.start, part.stop), name=name))
    return found or _experiments(log)


def _experiments(log: Log) -> list[Log]:
    """Return the parts of a motion between pauses, neighbours of one kind together; the whole if there is no test,
    which is neither a stroke nor any other motion: a sine, a staircase or a broad-band excitation.
    """
    if log.reference is None or log.kind not in {None, "motion"}:
        return [log]
    moves = np.concatenate([[0], np.flatnonzero(np.diff(log.reference)), [len(log) - 1]])
    cuts = [int(a + b) // 2 for a, b in pairwise(moves) if log.time[b] - log.time[a] > PAUSE]
    if not cuts or kind_of(log) != "motion":
        return [log]
    pieces = [log.slice(*cut) for cut in pairwise(sorted({0, *cuts, len(log)})) if cut[1] - cut[0] >= SAMPLES]
    found: list[tuple[Kind, Indices]] = []
    for kind, same in groupby(pieces, kind_of):
        times = [piece.time[[0, -1]] for piece in same]
        found.append((kind, np.searchsorted(log.time, [times[0][0], times[-1][1]])))
    if not {*PRESLIDING, "sliding-sine", "frequency-response"} & {kind for kind, _ in found}:
        return [log]
    parts = ((kind, log.slice(start, stop + 1)) for kind, (start, stop) in found)
    return [replace(part, name=f"{log.name} {n}", kind=kind) for n, (kind, part) in enumerate(parts, 1)]


def switched(log: Log) -> Notice | None:
    """Return the notice on the modes of a record, with the tracking error of each in their common motions."""
    if not (parts := modes_of(log)):
        return None
    names = list(dict.fromkeys(part.mode for part in parts))
    times = [f"{time:.13g}" for time in np.round(log.time, 3)]  # of a clock that counts from 1970 seconds differ late
    spans = [f"{part.mode} from {times[part.start]} to {times[part.stop - 1]} s" for part in parts]
    errors, glitches = _compared(log, parts, names)
    unit, rows = log.unit("position"), zip(names, errors, glitches, strict=False)
    compared = [f"{name} {readable(rms, unit)} rms and {readable(peak, unit)} at reversals" for name, rms, peak in rows]
    return MODES_SWITCH.found(
        log.where, logged=parts[0].logged, parts=spans, compared=compared, modes=names,
        errors=[Estimate(error, unit) for error in errors], glitches=[Estimate(glitch, unit) for glitch in glitches],
    )  # fmt: skip


def _logged(log: Log) -> list[ModePart]:
    """Return the runs of a mode's channel; empty if it is a state of the motion: moving, its direction, in place."""
    assert log.mode is not None
    edges = np.concatenate([[0], np.flatnonzero(np.diff(log.mode)) + 1, [len(log)]])
    if not 2 < len(edges) <= MOST_PARTS + 1:
        return []
    z = travelled(log)
    turns = find_reversals(z)
    if len(turns) > 1 and max(int(((a < turns) & (turns < b)).sum()) for a, b in pairwise(edges)) < 2:
        return []
    onoff, least = set(np.unique(log.mode)) <= {0.0, 1.0}, 0.01 * float(np.ptp(z))
    found = []
    for a, b in pairwise(map(int, edges)):
        value = float(log.mode[a])
        plain = ("off", "on")[int(value)] if onoff else f"mode {value:g}"
        name = log.labels[int(value)] if 0 <= value < len(log.labels) else plain
        if b - a >= SHORTEST and np.ptp(z[a:b]) > least:
            found.append(ModePart(name, a, b, logged=True))
    return found


def _strokes(log: Log, followed: Tracking) -> list[_ModeStroke]:
    """Return the strokes of the reference from reversal to reversal."""
    x, found = log.require("reference", "its strokes"), list[_ModeStroke]()
    error = log.require("position", "its strokes") - x
    speed = np.abs(np.gradient(x, log.time))
    for (begin, first, end), (following, last, _) in pairwise(followed.spans):
        move = float(x[last] - x[first])
        motion = (abs(move), float(speed[first:last].max()), float(np.sign(move)))
        rms = float(np.sqrt(np.mean(error[begin:following] ** 2)))
        found.append(_ModeStroke(begin, following, motion, rms, float(np.ptp(followed.rest[begin:end]))))
    return found


def _motions(strokes: Iterable[_ModeStroke]) -> Iterator[list[_ModeStroke]]:
    """Yield the strokes of each motion, in the order of time."""
    left = list(strokes)
    while left:
        alike = [np.allclose(left[0].motion, stroke.motion, rtol=STROKES_ALIKE, atol=0.0) for stroke in left]
        yield list(compress(left, alike))
        left = [stroke for stroke, taken in zip(left, alike, strict=True) if not taken]


def _compared(log: Log, parts: list[ModePart], names: list[str]) -> tuple[list[float], list[float]]:
    """Return tracking error and error at reversals of each mode [m], over their common motions."""
    if log.reference is None or (followed := tracking(log)) is None:
        return [], []
    rows = list[list[tuple[float, float]]]()
    for group in _motions(_strokes(log, followed)):
        of_modes = [
            [s for s in group if any(p.mode == name and p.start <= s.start and s.stop <= p.stop for p in parts)]
            for name in names
        ]
        if all(of_modes):
            rows.append([
                (float(np.mean([s.error**2 for s in of_mode])), float(np.median([s.glitch for s in of_mode])))
                for of_mode in of_modes
            ])  # fmt: skip
    if not rows:
        return [], []
    squares, glitches = np.mean(rows, axis=0).T
    return np.sqrt(squares).tolist(), glitches.tolist()


def _seen(log: Log) -> list[ModePart]:
    """Return the parts of a record in which errors at reversals of the same motion have one of two sizes.

    The sizes differ by `ERRORS_APART` and by far more than either scatters, in every motion that recurs, and each lasts
    for `STROKES` strokes or more: differing directions alternate, a drift is gradual, and noise is neither. A stroke of
    a size between both contains the switch.
    """
    if log.reference is None or log.position is None or (followed := tracking(log)) is None:
        return []
    least, strokes, large = COUNTS * visible_step(log.position), _strokes(log, followed), dict[int, bool | None]()
    for group in _motions(strokes):
        if (sizes := _of_two(np.array([stroke.glitch for stroke in group]), least)) is not None:
            large |= {stroke.start: size for stroke, size in zip(group, sizes, strict=True)}
    starts = [start for start in sorted(large) if large[start] is not None]
    if len(large) < max(0.8 * len(strokes), 2 * STROKES):
        return []
    switches = [n for n in range(1, len(starts)) if large[starts[n]] != large[starts[n - 1]]]
    edges = [0, *switches, len(starts)]
    if not switches or np.diff(edges).min() < STROKES or len(large) - len(starts) > len(switches):
        return []
    cuts = [0, *(starts[n] for n in switches), len(log)]
    names = ["off" if large[starts[n]] else "on" for n in edges[:-1]]
    return [ModePart(name, *cut, logged=False) for name, cut in zip(names, pairwise(cuts), strict=True)]


def _of_two(glitches: Real, least: float) -> list[bool | None] | None:
    """Return whether each error of a motion has the larger of two sizes, None if between; None for a single size."""
    sizes = np.log(np.maximum(glitches, 1e-300))
    if len(order := np.sort(sizes)) < 4:
        return None
    n = min(
        range(2, len(order) - 1), key=lambda n: n * float(order[:n].var()) + (len(order) - n) * float(order[n:].var())
    )
    low, high = float(np.median(order[:n])), float(np.median(order[n:]))
    gap, off = high - low, np.minimum(np.abs(sizes - low), np.abs(sizes - high))
    if gap < np.log(ERRORS_APART) or np.exp(high) - np.exp(low) < least or np.median(off) > SCATTER * gap:
        return None
    return [None if d > 2.0 * SCATTER * gap else bool(s > 0.5 * (low + high)) for s, d in zip(sizes, off, strict=True)]
