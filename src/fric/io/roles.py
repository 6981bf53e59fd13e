"""Which column of a foreign log is which channel, and in which unit: by physics first, by names second.

A velocity is the derivative of a position at a factor that only certain units give; a force follows the sign of the
velocity and with the acceleration; what is exact is a command. Each choice has a likelihood: what is under `SURE` is
for the user to state.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from json import dumps
from math import log

import numpy as np

from fric.arrays import Mask, Real
from fric.columns import LARGEST_TURN
from fric.errors import FricError
from fric.io.readers.base import Column, ForeignTable, Memory
from fric.io.words import (
    TIME_UNITS,
    TOLERANCE,
    TURNS,
    USUAL,
    Reading,
    Spoken,
    contradicting,
    customary_unit,
    in_counts,
    is_electrical,
    motions_in,
    of_axis,
    readings,
    says_mode,
    spoken,
    tags,
    time_units,
    usual_units,
)
from fric.records.resolution import lattice_step
from fric.units import PLAIN, Motion, converts, in_units_of, parse, rotates, si_unit
from fric.units import factor as si_factor

LIKELY = ("time", "reference", "position", "velocity", "force", "input")
"""Channels in the order in which columns are given to them by their names."""
SURE = 0.95  # Likelihood above which a choice is taken without a question
MOST_VALUES = 8_000_000  # Numbers of all tables together that are used
MOST_MOVING, MOST_WEIGHED = 500, 5000
"""Columns that move at most, and of these with each that may be a position: the time grows with either product."""
ROWS = 12_000  # Increments that a pair of columns is judged by
WINDOWS = (2, 8, 32, 128, 512)
"""Rows over which increments are taken: short ones show lags, long ones are robust to quantisation and noise."""
PAIR, NAMED_PAIR = 0.985, 0.8
"""Share of the variance that makes a column the derivative of another; where names or units show it, too."""
NEARLY = 0.05  # Deviation from 1, in SI, of the factor of a rate and an angle that was roughly integrated from it
SAME = 0.97  # Correlation of increments above which two positions are of one axis
EXACT = 0.99999  # Share of the variance above which a derivative is that of a command
SEEN = 0.5  # Share that the acceleration explains of what the velocity leaves, from which on a mass is well seen
BRAKED = 0.1  # Share that the sign of the velocity explains of a force at least; an acceleration has less
JITTERS, ALONG = 0.82, 0.08
"""How even stamps without a name count that come when they can; how far from even ones they are, of their range."""
REPEATED = 0.01  # Share of repeated stamps above which stamps are rounded
UNUSUAL, BY_CHANCE = 0.01, 0.1
"""Weight of unusual units, relative to that of usual units; how often these have a usual factor."""
SHOWN = 20.0  # Weight of a unit in which a turn is of a usual number of the position's steps
ENCODER = 1e-3  # Relative deviation of that number
SMOOTH = "smooth, and a force goes with it and its slope"
UNFIT = 0.5  # Likelihood at most of units that do not explain the factor between position and velocity
WORSE = 20.0
"""How much more of the variance a column without a name leaves than the velocity does, before it may be a force."""
DRIVING = 0.2  # Score of a voltage that drives an axis, at least
FILETIME, DATED = "100 ns", ((1.26e10, 1.42e10), (6.3e10, 6.47e10))  # Stamps of Windows and of .NET, 2000 to 2050 [s]
LASTS = 16  # Rows whose mean velocity shows a motion
ALIKE = 0.7  # Correlation, and relative score, above which two columns may be the same force, asked and measured
CLEARLY = 0.8  # What the actual position leaves of a force, relative to what the commanded one leaves, at most
FALLING = 0.2  # Share of rows from which on what falls is no time, whatever its name
JUMPS = 0.5  # Step from row to row, relative to the spread, from which on a position cannot be followed
LOOKED_AT = 2000  # Rows that the different values of a column are counted in
MODES = 4  # Values that a mode has at most
OF_SIDE = 0.1  # What the velocity of its side leaves of a position, relative to those of other sides, at most


@dataclass(frozen=True)
class Role:
    """A column that is taken for a channel."""

    channel: str
    column: int | None  # None for a time that was not logged
    unit: str  # Its unit; of a time that was not logged, its period; empty where not known
    likelihood: float  # That the column is the channel
    unit_likelihood: float  # That the unit is the unit
    why: str
    sign: int = 1  # -1 where it counts against the position, or the force against the friction
    others: Mapping[int, int] = field(default_factory=dict)  # Columns that it may be instead, with their signs
    units: tuple[str, ...] = ()  # Units that it may have instead
    turn: float = 0.0  # What its values begin again after, as logged; 0 where they go on
    field: str = ""  # Of a period that each file states for itself: ``period: "{Sampling cycle}"``


@dataclass
class AxisColumns:
    """The channels of one axis of a table."""

    name: str
    motion: Motion
    motion_likelihood: float
    roles: dict[str, Role] = field(default_factory=dict)
    readings: tuple[Reading, ...] = ()  # Units that it may be in, the likeliest first; their weights are likelihoods
    factor: float | None = None  # Velocity per slope of the position, where the clock gives no time
    rests: bool = False  # Whether there is a velocity, and it is noise

    @property
    def columns(self) -> list[int]:
        """The columns of its channels."""
        return [role.column for role in self.roles.values() if role.column is not None]


BEYOND = 1e20  # Magnitude of a value that no log holds, in any unit: stamps in ns are 1e18


class Samples:
    """The numbers of tables with the same columns, concatenated, with what names and units show of them."""

    def __init__(self, tables: Sequence[ForeignTable]) -> None:
        self.columns, self.path = tables[0].columns, tables[0].path
        most = max(MOST_VALUES // max(len(self.columns), 1) // len(tables), 64)
        pieces = [_head(table, most) for table in tables]
        self.x = np.concatenate(pieces)
        self.starts = np.cumsum([0, *map(len, pieces)])[:-1]
        self.said, self.tags = _spoken_of(self.columns), tags(self.columns)
        good = np.abs(self.x) < BEYOND
        self.numeric = good.mean(axis=0) > 0.9 if len(self.x) else np.zeros(len(self.columns), bool)
        for n in np.flatnonzero(self.numeric & ~good.all(axis=0)):
            rows = np.flatnonzero(good[:, n])
            self.x[:, n] = self.x[rows[np.maximum(np.searchsorted(rows, np.arange(len(self.x)), "right") - 1, 0)], n]
        self.x[:, ~self.numeric] = 0.0
        falls = np.mean(np.diff(self.x, axis=0) < 0.0, axis=0) if len(self.x) > 1 else np.zeros(len(self.columns))
        self.said = [  # no time falls: t is a torque there
            Spoken(None) if says.quantity == "time" and share > FALLING else says
            for says, share in zip(self.said, falls, strict=True)
        ]
        self.moving = self.numeric & (np.ptp(self.x, axis=0) > 0 if len(self.x) else False)
        pieces = np.split(self.x, self.starts[1:])  # what jumps from record to record is no turn
        self.turn = np.zeros(len(self.columns))
        for n in np.flatnonzero(self.moving):
            if self.said[n].quantity in {None, "position"}:
                self.turn[n] = max(_turn(piece[:, n]) for piece in pieces)
            for piece in pieces if self.turn[n] else ():
                piece[:, n] = np.unwrap(piece[:, n], period=self.turn[n])
        resting = np.flatnonzero(self.numeric & ~self.moving)
        still = [n for n in resting if self.said[n].quantity == "time" and len(self.x)]
        self.constants = {f"dt {self.columns[n].name}": f"{self.x[0, n]:.9g} {self.said[n].unit or 's'}" for n in still}
        some = self.x[:: len(self.x) // LOOKED_AT + 1]  # of all rows: an axis may rest at first
        self.levels = np.array([len(np.unique(some[:, n])) for n in range(len(self.columns))])

    def rows(self, window: int) -> np.ndarray:
        """Return rows that have a number of further rows in the same table, at most `ROWS`."""
        inside = np.ones(max(len(self.x) - window, 0), bool)
        for start in self.starts[1:]:
            inside[max(start - window, 0) : start] = False
        rows = np.flatnonzero(inside)
        return rows[:: max(len(rows) // ROWS, 1)]


def _spoken_of(columns: Sequence[Column]) -> list[Spoken]:
    """Return what names show of columns: beside ``q[0]``, ``q_d[0]`` is what is desired."""
    names, plain = {column.name for column in columns}, [re.sub(r"_d(?=\W|_?\d|$)", "", c.name) for c in columns]
    desired = [name in names and name != column.name for name, column in zip(plain, columns, strict=True)]
    said = [of_axis(column, tag) for column, tag in zip(columns, tags(columns), strict=True)]
    if not any(says.quantity in {"position", "velocity"} for says in said):  # what an oscilloscope has of sensors
        bare = {n: spoken(of._replace(unit=None)) for n, of in enumerate(columns) if converts(of.unit, "input")}
        bare = {n: says for n, says in bare.items() if says.quantity != "input"}
        said = [bare.get(n, says) if len(bare) > 1 else says for n, says in enumerate(said)]
    return [says._replace(commanded=True) if of else says for says, of in zip(said, desired, strict=True)]


def _turn(x: Real) -> float:
    """Return the range after which an angle repeats: it jumps from end to end; 0 where it is none, as few counts."""
    steps, span = np.diff(x), float(np.ptp(x))
    few = span < 0.9 * COUNTS.min() * np.abs(steps[steps != 0.0]).min(initial=np.inf)
    jumps = np.flatnonzero(np.abs(steps) > 0.7 * span)
    jumps = jumps[(jumps > 3) & (jumps < len(steps) - 4)]
    if few or not 0 < len(jumps) < 0.05 * len(steps) or span > LARGEST_TURN:
        return 0.0
    around = steps[jumps - 1] + steps[jumps - 2] + steps[jumps + 1] + steps[jumps + 2]
    if np.mean(around * steps[jumps] < 0.0) < 0.8 or np.quantile(np.abs(steps), 0.9) > 0.3 * span:
        return 0.0
    turn = span + float(np.median(np.abs(around))) / 4.0
    usual = [360.0, 2.0 * np.pi, 1.0, 100.0, 400.0, *(10.0**k for k in range(3, 7)), *(2.0**k for k in range(8, 25))]
    return next((value for value in sorted(usual) if span <= value < 1.03 * turn), turn)


def in_memory(table: ForeignTable, *, rows: bool = True) -> Memory:
    """Return a table with its first rows in memory, or none of them, for when its file is closed."""
    count = MOST_VALUES // max(len(table.columns), 1) // 4
    head = list(_head(table, count).T) if rows else [np.empty(0)] * len(table.columns)
    return Memory(table.path, table.columns, head, table.constants, table.said)


def _head(table: ForeignTable, most: int) -> Real:
    """Return the first rows of a table, shape (rows, columns); what is too slow for a motion is still."""
    parts, rows, quick = [], 0, table.quick()
    for block in table.read(quick):
        parts.append(np.zeros((len(block.columns[0]), len(table.columns))))
        for n, values in zip(quick, block.columns, strict=True):
            parts[-1][:, n] = values
        rows += len(parts[-1])
        if rows >= most:
            break
    return np.concatenate(parts)[:most]


def axes_of(tables: Sequence[ForeignTable]) -> list[AxisColumns]:
    """Return the axes of tables that have the same columns, in the order of these."""
    data = Samples(tables)
    _refuse_many(tables[0], moving := int(data.moving.sum()), MOST_MOVING)
    n = (clock := _clock(data)).column
    if not clock.unit if n is None else not data.said[n].unit and _counts_rows(data.x[:, n]):
        clock = said_clock(data.constants | tables[0].constants) or clock
    t = data.x[:, clock.column] if clock.column is not None else np.arange(len(data.x), dtype=float)
    data.moving &= ~_stamps(data, t)
    if clock.column is None and clock.unit:
        t = t * parse(clock.unit, "time")
    pairs = Pairs(data, t, clock)
    if pairs.torn and clock.unit_likelihood < 1.0 and not pairs.edge.any():
        clock = replace(clock, unit_likelihood=min(clock.unit_likelihood, 0.5))
    movements = [_movement(data, pairs, members) for members in _clusters(data, pairs)]
    movements += _by_velocity(data, movements)
    if not movements:
        roles = {"time": clock} if clock.column is not None else {}
        return [AxisColumns("1", "linear", 0.5, roles, rests=any(says.quantity == "velocity" for says in data.said))]
    _refuse_many(tables[0], moving * len(movements), MOST_WEIGHED)
    used = {n for movement in movements for n in movement.columns} | {clock.column}
    scores = _drives(data, t, pairs, movements, used)
    moved = [(movement, movement.roles["position"]) for movement in movements if "position" in movement.roles]
    named = any(says.quantity == "position" for says in data.said)
    if len(moved) == len(movements) and not (named or pairs.edge.any()):
        # what is smooth may be a velocity, if a force goes with it
        speeds = [replace(m, roles={"velocity": replace(main, channel="velocity", why=SMOOTH)}) for m, main in moved]
        others = _drives(data, t, pairs, speeds, used)
        best, better = (max((s for one in group for s, _ in one.values()), default=0.0) for group in (scores, others))
        movements, scores = (speeds, others) if better > max(2.0 * best, BRAKED) else (movements, scores)
    drives = [_driven(data, score) for score in scores]
    movements = [_by_force(data, t, m, pushed.get("force")) for m, pushed in zip(movements, drives, strict=True)]
    _open_motions(data, t, movements, drives)
    whole = [(movement, movement.roles | pushed) for movement, pushed in zip(movements, drives, strict=True)]
    found = [_in_units(data, t, movement, roles, clock) for movement, roles in whole]
    turning = [rotates(axis.motion) for axis in found if axis]
    kind: Motion = "rotary" if 2 * sum(turning) > len(turning) else "linear"
    for n, (axis, (movement, roles)) in enumerate(zip(found, whole, strict=True)):
        if axis and axis.motion_likelihood < SURE and rotates(axis.motion) != rotates(kind):
            found[n] = _in_units(data, t, movement, roles, clock, kind)  # what is open is as the others of its table
    axes = sorted((axis for axis in found if axis), key=_first_column)
    for n, axis in enumerate(axes, 1):
        axis.name = str(n)
        if (mode := _mode(data, _first_column(axis))) is not None:
            axis.roles["mode"] = Role("mode", mode, "1", 0.97, 1.0, "by its name")
        counted = [
            channel for channel, role in axis.roles.items()
            if role.column is not None and role.unit in _OF_MOTION and in_counts(data.columns[role.column])
        ]  # fmt: skip
        if counted == ["velocity"] and "position" in axis.roles:  # the derivative of the position will do
            del axis.roles[counted.pop()]
        for channel in counted:  # a file that says counts says that it is in no unit
            role = axis.roles[channel]
            axis.roles[channel] = replace(role, unit_likelihood=0.5 * role.unit_likelihood)
    return axes


PITCHES = np.array([2.0, 2.5, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0, 30.0, 32.0, 40.0])  # Of screws [mm]


def _is_on_screw(factor: float, reading: Reading) -> bool:
    """Return whether a factor is that of a position on a screw of usual pitch, and the speed of its motor in rpm."""
    size = si_factor(reading.position, "position", reading.motion) / si_factor(reading.time, "time")
    return reading.motion == "linear" and bool(np.abs(np.log(6e4 * size / factor / PITCHES)).min() < TOLERANCE)


_OF_MOTION = {unit for of in USUAL.values() for units in of[:2] for unit in units}


def _refuse_many(table: ForeignTable, found: int, most: int) -> None:
    if found > most:
        raise FricError("has too many columns that may be an axis", where=str(table.path),
                        hint="Say in a mapping (--map) which are time, position and force.")  # fmt: skip


def _mode(data: Samples, main: int) -> int | None:
    """Return the column of the mode of the control of an axis, of few numbers or of words."""
    found = {n: says_mode(column) for n, column in enumerate(data.columns) if not _apart(data, n, main)}
    found = {
        n: sure for n, sure in found.items()
        if sure and (not data.numeric[n] or 1 < len(np.unique(data.x[:, n])) <= 2 * MODES)
    }  # fmt: skip
    return max(found, key=lambda n: found[n], default=None)


def _first_column(axis: AxisColumns) -> int:
    """Return the column of the position of an axis, or of its velocity."""
    return (axis.roles.get("position") or axis.roles["velocity"]).column or 0


# --- time ---------------------------------------------------------------------------------------------------------


def _clock(data: Samples) -> Role:
    """Return the column that is the time: a rising column, by its name, its unit, and how even its steps are."""
    best: tuple[float, int] = (0.0, -1)
    unnamed = [column.name == f"column {k}" for k, column in enumerate(data.columns)]
    first, uneven = data.starts[1] if len(data.starts) > 1 else 0, set[int]()
    for n in map(int, np.flatnonzero(data.moving)):
        steps = np.diff(data.x[:, n])
        steps = np.delete(steps, data.starts[1:] - 1)[1:]  # the first row may be another run's last
        says = data.said[n]
        if len(steps) < 3 or (steps < 0).mean() > 0.001 or not np.mean(steps) > 0:
            continue
        if says.quantity != "time" and (steps == 0).mean() > 0.5:
            continue  # the number of a line of a program
        usual = float(np.median(steps)) or float(np.quantile(steps, 0.9)) or np.inf
        even = 1.0 - min(float(np.subtract(*np.quantile(steps, [0.9, 0.1]))) / usual, 1.0)
        if unnamed[n] and even < JITTERS and _advances(data.x[: first or None, n]):
            even, uneven = JITTERS, {*uneven, n}
        dated = says.quantity is None and 1e9 < data.x[0, n] < 2.5e9 and 0.0 < usual < 1.0  # seconds since 1970
        score = 3.0 * (says.quantity == "time" or dated) + 0.5 * (says.quantity == "row") + even + 0.2 / (1 + n)
        score -= 2.0 * (says.quantity not in {None, "time", "row"})
        best = max(best, (score, -n))
    if best[0] < 0.9:
        return Role("time", None, "", 1.0, 0.0, "no column rises evenly")
    n = -best[1]
    counts = data.said[n].quantity == "row" or unnamed[n] or data.columns[n].name in {*"nik#"}
    if counts and _counts_rows(data.x[:, n]):
        return Role("time", None, "", 1.0, 0.0, f"'{data.columns[n].name}' counts rows")
    says, stamps = data.said[n], data.x[: first or None, n]
    dated = any(low < stamps[0] * 1e-7 < high for low, high in DATED) and np.ptp(stamps) < 1e13
    jumps = np.flatnonzero(np.diff(stamps))  # between the first and the last, periods are whole
    coarse = np.spacing(stamps[-1]) > 1e-3 * np.median(np.diff(stamps))  # of 18 digits, a number holds 16
    if ((np.diff(stamps) == 0.0).mean() > REPEATED or coarse) and len(jumps) > 2 and _is_rounded(stamps):
        period = float(np.ptp(stamps[jumps[[0, -1]]]) / np.ptp(jumps))
        weights = {said: 1.0} if (said := FILETIME if dated else says.unit) else time_units(period, len(stamps))
        if unit := _sure(weights):
            every = f"{period:.6g} {unit}" if unit in TIME_UNITS else f"{period * si_factor(unit, 'time'):.6g} s"
            return Role("time", None, every, 0.97, 0.97, "its stamps are rounded, and even")
    sure = 0.99 if says.quantity == "time" else 0.97 if best[0] > 1.05 or n in uneven else 0.9
    since_1970 = (u for u, size in TIME_UNITS.items() if 1e9 < stamps[0] * size < 2.5e9 and np.ptp(stamps) * size < 1e6)
    stated = (FILETIME if dated else "") or says.unit or next(since_1970, "")
    counted = np.all(stamps == np.rint(stamps)) and re.search(r"(?i)(count(er)?|cycle|sample)s?$", data.columns[n].name)
    unit = stated or ("" if counted else _sure(time_units(float(np.median(np.diff(stamps))), len(stamps))))
    known = 1.0 if stated else 0.5 if data.columns[n].unit else 0.97  # where a header has one that is none, ask
    why = f"it rises {'with every row' if n in uneven else 'evenly'}"
    return Role("time", n, unit, sure, known if unit else 0.0, why)


def _sure(weights: Mapping[str, float]) -> str:
    """Return the unit that is sure by its weight; empty where none is."""
    unit = max(weights, key=lambda unit: weights[unit])
    return unit if weights[unit] > SURE * sum(weights.values()) else ""


def _advances(x: Real) -> bool:
    """Return whether a column rises with every row, on average alike, as stamps do that a program takes when it can.

    A position at one speed does, too: its steps change little from row to row, those of stamps as much as they differ.
    """
    if len(steps := np.diff(x)) < 32 or not (steps > 0.0).all():
        return False
    along = np.abs(x - np.linspace(x[0], x[-1], len(x))).max()
    return bool(along < ALONG * np.ptp(x) and np.diff(steps).std() > 0.7 * steps.std())


def _counts_rows(x: Real) -> bool:
    return bool(np.mean(np.diff(x) == 1.0) > 0.999)


def _stamps(data: Samples, t: Real) -> Mask:
    """Return which columns without another name count rows, or are the clock again: another epoch, its wrapped rest."""
    first = slice(None, data.starts[1] if len(data.starts) > 1 else None)
    found = np.zeros(len(data.columns), bool)
    for n in np.flatnonzero(data.moving):
        x, of = data.x[first, n], data.said[n].quantity
        if of in {None, "time", "row"} and len(x) > 32 and np.mean(np.diff(x) < 0.0) < REPEATED:
            slope = (x[-1] - x[0]) / ((t[first][-1] - t[0]) or 1.0)
            left = np.abs(x - x[0] - slope * (t[first] - t[0])).max()
            near = 1e-4 if of else 1e-5 if np.all(x == np.rint(x)) else 1e-9  # a motion at one speed is not so even
            decade = np.log10(slope) if slope > 0.0 else 0.5  # of units of a time
            steps = np.median(np.diff(x)) == 0.0 and left < 1.01 and (of or abs(decade - np.rint(decade)) < 1e-2)
            found[n] = left < near * np.ptp(x) or steps or _counts_rows(x)
    return found


def _is_rounded(stamps: Real) -> bool:
    """Return whether repeated stamps are those of an even clock, rounded to their digits."""
    steps = np.diff(stamps)
    least = steps[steps > 0].min() if np.any(steps == 0.0) else np.spacing(stamps[-1])
    return bool(np.abs(stamps - np.linspace(stamps[0], stamps[-1], len(stamps))).max() < 2.0 * least)


_RATE = re.compile(r"(?i)\b(fs|f_s|rate|frequency|freq|sampling|samplerate|abtastrate)\b")
_PERIOD = re.compile(r"(?i)\b(ts|t_s|dt|period|interval|delta x|sampl(ing|e) time|abtastzeit|step|cycle|\w*zyklus)\b")


def said_clock(constants: Mapping[str, str]) -> Role | None:
    """Return the sampling period in the preamble of a file or as a scalar, in s or Hz where it gives no unit."""
    for name, text in constants.items():
        plain = re.sub(r"[._]|(?<=[a-z])(?=[A-Z])", " ", name) + " "
        found = re.match(r"\s*([-+.\deE]+)\s*([a-zA-Zµ]*)", text)
        of_period, of_rate = _PERIOD.search(plain) or _PERIOD.search(name), _RATE.search(plain) or _RATE.search(name)
        if found and found[2] in TIME_UNITS:
            of_period = of_period or re.search(r"(?i)\bsample\b", plain)
        if not found or not (of_period or of_rate):
            continue
        unit = found[2] or next(iter(re.findall(r"[\[(](kHz|Hz|ms|us|s)[])]|_(k?[Hh]z|ms|us|s)$", name)), ("", ""))
        unit = unit if isinstance(unit, str) else "".join(unit).replace("hz", "Hz")
        try:
            value = float(found[1])
            rate = converts(unit, "frequency") or (not unit and bool(of_rate) and not of_period)
            usual = "Hz" if rate else "s" if value < 0.5 else "ms" if value < 100.0 else "us"
            seconds = value * si_factor(unit or usual, "frequency" if rate else "time")
        except (ValueError, FricError):
            continue
        seconds = 1.0 / seconds if rate and seconds else seconds
        if 1e-6 < seconds < 10.0:
            why, sure = f"the file says {name} = {text}", 0.97 if unit or usual in {"Hz", "s"} else 0.9
            template = dumps(f"{{{name}}}" if found[2] else f"{{{name}}} {unit or usual}", ensure_ascii=False)
            nameable = name.isprintable() and not {*"{}"} & {*name}
            of_file = f"{'rate' if rate else 'period'}: {template}" if nameable else ""
            return Role("time", None, f"{seconds:.9g} s", 0.97, sure, why, field=of_file)
    return None


# --- pairs of positions and velocities --------------------------------------------------------------------------------


class Pairs:
    """How well each column (second) is the derivative of each (first), and at which factor.

    Over a window the position grows by the integral of the velocity: no slope is taken, and neither noise nor counts
    matter. ``share`` is that of the variance of the increments, ``factor`` the velocity per slope.
    """

    def __init__(self, data: Samples, t: Real, clock: Role) -> None:
        x, m = data.x, len(data.columns)
        steps = np.diff(t, prepend=t[:1])
        self.step = float(np.median(steps))
        sums = np.cumsum(0.5 * (x + np.roll(x, 1, axis=0)) * steps[:, None], axis=0)
        self.share, self.factor, self.alike = np.full((m, m), -np.inf), np.ones((m, m)), np.zeros((m, m))
        self.slope = np.ones((m, m))
        for window in WINDOWS:
            if len(rows := data.rows(window)) < 8:
                break
            d, s = x[rows + window] - x[rows], sums[rows + window] - sums[rows]
            with np.errstate(all="ignore"):
                cross, dd, ss = d.T @ s, (d * d).sum(0), (s * s).sum(0)
                spread = np.maximum(dd - len(d) * d.mean(0) ** 2, 1e-12 * dd)
                share = 1.0 - (dd[:, None] - cross**2 / ss) / spread[:, None]
                better = np.nan_to_num(share, nan=-np.inf) > self.share
                self.share[better] = share[better]
                self.factor[better] = (ss / cross)[better]
                both = d.T @ d
                alike = both / np.sqrt(np.outer(dd, dd))
                closer = np.nan_to_num(alike) > self.alike
                self.alike[closer] = alike[closer]
                self.slope[closer] = (both / dd[:, None])[closer]  # of the second per the first
        np.fill_diagonal(self.share, -np.inf)
        out = ~data.moving
        if clock.column is not None:
            out[clock.column] = True
        self.share[out], self.share[:, out] = -np.inf, -np.inf
        self.alike[out], self.alike[:, out] = 0.0, 0.0
        self.torn = False  # Whether a velocity is that of a position by another clock, or at the other side of a gear
        self.edge = self._edges(data, clock)

    def _edges(self, data: Samples, clock: Role) -> Mask:
        """Return which pairs are a position and its velocity."""
        m = len(data.columns)
        edge, rough = np.zeros((m, m), bool), np.zeros((m, m), bool)
        unit = clock.unit if clock.column is not None else "s" if clock.unit else ""
        likely = {unit: 1.0} if unit or clock.column is None else time_units(self.step, len(data.x))
        size = si_factor(max(likely, key=lambda unit: likely[unit]), "time") if {*likely} != {""} else np.inf
        for p, v in zip(*np.nonzero(self.share > NAMED_PAIR), strict=True):
            first, second = data.said[p], data.said[v]
            if _apart(data, int(p), int(v)) or self._of_all(data, p, v):
                continue
            wrong = first.quantity not in {None, "position"} or second.quantity not in {None, "velocity"}
            speaks = first.quantity == "position" and second.quantity == "velocity"
            factor = self.factor[p, v]
            if wrong or (factor < 0 and not speaks) or data.levels[p] <= MODES:
                continue
            fits = bool(clock.column is not None or unit) and bool(readings(first, second, unit, factor))
            fits |= second.quantity == "velocity" and bool(second.unit) and not first.unit  # which may be in counts
            if first.unit and second.unit and unit and not fits:
                edge[p, v] = contradict = self.share[p, v] > PAIR and bool(contradicting(first, second, unit, factor))
                self.torn |= bool(self.share[p, v] > PAIR) and not contradict
                continue  # of the other side of a gear
            # nearly 1 in SI: an angle that was integrated roughly; a force has it by chance in one log of 200
            rough[p, v] = {first.quantity, second.quantity} == {None} and abs(np.log(factor * size)) < NEARLY
            edge[p, v] = speaks or (self.share[p, v] > PAIR and (fits or self.share[p, v] > 0.9995))
        return edge if edge.any() else rough  # where one axis has its velocity, the others have theirs

    def _of_all(self, data: Samples, p: int, v: int) -> bool:
        """Return whether a position of no side is as near to the velocity of another side, as that of a cart is."""
        sides = [n for n in _sided(data, "velocity") if data.tags[n] != data.tags[v] and data.moving[n]]
        nearest = max(self.share[p, sides], default=-np.inf) if data.tags[p] is None and data.tags[v] else -np.inf
        return bool(1.0 - self.share[p, v] > OF_SIDE * (1.0 - nearest))


def _apart(data: Samples, first: int, second: int) -> bool:
    """Return whether two names are of different axes."""
    a, b = data.tags[first], data.tags[second]
    return a is not None and b is not None and a != b


def _sided(data: Samples, *quantities: str) -> list[int]:
    """Return the measured columns of quantities whose names are of an axis."""
    said = enumerate(data.said)
    return [n for n, says in said if says.quantity in quantities and data.tags[n] and not says.commanded]


def _clusters(data: Samples, pairs: Pairs) -> list[list[int]]:
    """Return the columns that are positions, by axis."""
    edge, rough = pairs.edge, _roughness(data)
    onward = edge & ~edge.T
    roots = [
        p for p in range(len(data.columns))
        if edge[p].any() and not any(onward[q, p] and pairs.share[q, p] > 0.9 * pairs.share[p].max()
                                     for q in range(len(data.columns)))
    ]  # fmt: skip
    named = [n for n, says in enumerate(data.said) if says.quantity == "position" and data.moving[n]]
    free = [
        n for n in np.flatnonzero(data.moving & (data.levels > MODES))
        if n not in roots and not onward[:, n].any() and data.said[n].quantity in {None, "position"}
        and np.isfinite(pairs.share[n]).any() and rough[n] < JUMPS
        and (data.said[n].quantity or any(
            _of_an_axis(data, pairs, int(n), k) for k in (*roots, *(named if data.said[n].commanded else ()))
        ))
    ]  # fmt: skip
    candidates = [*sorted(roots, key=lambda p: -float(pairs.share[p].max())), *map(int, free)]
    if not candidates and not any(says.quantity == "velocity" for says in data.said):
        candidates = _smooth(data, pairs)
    found: list[list[int]] = []
    for n in candidates:
        like = (members for members in found if any(_of_an_axis(data, pairs, n, k) for k in members))
        if (members := next(like, None)) is None:
            found.append(members := [])
        members.append(n)
    moved = [n for members in found for n in members if not data.said[n].commanded]

    def asks(n: int) -> bool:  # in another unit, or followed badly
        return data.said[n].commanded and any(pairs.alike[n, k] > 0.5 and not _apart(data, n, k) for k in moved)

    return [members for members in found if not all(map(asks, members))]


def _of_an_axis(data: Samples, pairs: Pairs, n: int, k: int) -> bool:
    """Return whether two positions are of one axis: equal motion of equal size, or the names show it."""
    tagged = data.tags[n] is not None and data.tags[n] == data.tags[k]
    demand = tagged and data.said[n].commanded != data.said[k].commanded  # which it may follow badly
    if _apart(data, n, k) or pairs.alike[n, k] < (SAME if not demand else 0.5):
        return False
    spoken_both = data.said[n].quantity == data.said[k].quantity == "position"
    return bool(0.8 < pairs.slope[n, k] < 1.25 or (spoken_both and data.tags[n] == data.tags[k]))


def _roughness(data: Samples) -> Real:
    """Return the step from row to row of each column relative to its spread."""
    if len(rows := data.rows(1)) < 32:
        return np.full(len(data.columns), np.inf)
    with np.errstate(all="ignore"):
        return np.asarray((data.x[rows + 1] - data.x[rows]).std(0) / data.x.std(0))


def _smooth(data: Samples, pairs: Pairs) -> list[int]:
    """Return columns that may be positions where no pair shows it, the smoothest first."""
    rough = _roughness(data)
    free = [
        int(n) for n in np.flatnonzero(data.moving & (data.levels > MODES))
        if data.said[n].quantity is None and np.isfinite(pairs.share[n]).any() and rough[n] < 0.3
        and not _jumps(data.x[:, n])
    ]  # fmt: skip
    least = min((rough[n] for n in free), default=0.0)
    return sorted((n for n in free if rough[n] <= 3.0 * least), key=lambda n: rough[n])


def _jumps(x: Real) -> bool:
    """Return whether a column mostly stands and else jumps, as a command in steps does, and nothing that has a mass."""
    steps = np.abs(np.diff(x))
    moving = steps[steps > 0.0]
    return bool(len(moving) < 0.05 * len(steps) and np.median(moving) > 0.02 * np.ptp(x))


# --- one axis ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Movement:
    """Position, reference and velocity of an axis, and all columns that are of its motion."""

    roles: dict[str, Role]
    columns: frozenset[int]
    factor: float | None = None  # Velocity per slope of the position

    def column(self, channel: str) -> int | None:
        return self.roles[channel].column if channel in self.roles else None

    def tag(self, data: Samples) -> str | None:
        """Return the axis that the names show."""
        shown = [data.tags[n] for of in ("position", "velocity") if (n := self.column(of)) is not None]
        return next(filter(None, shown), None)


def _movement(data: Samples, pairs: Pairs, members: list[int]) -> _Movement:
    """Return the channels of an axis by its positions."""
    at_load = [n for n in members if not data.said[n].commanded and data.said[n].at_load]
    load = at_load[0] if at_load and len(members) > len(at_load) else None
    position, reference, sure = _actual(data, [n for n in members if load is None or n not in at_load])
    speeds = [int(v) for v in np.flatnonzero(pairs.edge[members].any(axis=0)) if v not in members]
    speeds = [v for v in speeds if not any(pairs.edge[u, v] and not pairs.edge[v, u] for u in speeds)]
    speeds = [
        v for v in speeds
        if reference is None or data.said[v].quantity == "velocity" or not _is_difference(data, v, reference, position)
    ]  # fmt: skip
    velocity = _velocity(data, pairs, speeds, position, reference)
    paired = bool(pairs.edge[position].any())
    why = "a velocity is its derivative" if paired else "smooth as a position is"
    if paired and not data.said[position].quantity and pairs.share[position, pairs.edge[position]].max() <= PAIR:
        sure, why = min(sure, 0.9), "a velocity is nearly its derivative"
    roles = {"position": Role("position", position, "", sure, 0.0, why)}
    if load is not None:
        roles["load_position"] = Role("load_position", load, "", 0.97, 0.0, "by its name, it moves with the position")
    if reference is not None:
        roles["reference"] = Role("reference", reference, "", max(sure, 0.9), 0.0, "the position follows it")
    factor = None
    if velocity is not None:
        share, factor = pairs.share[position, velocity], float(pairs.factor[position, velocity])
        roles["velocity"] = Role(
            "velocity", velocity, "", min(0.5 + 0.5 * share, 0.99), 0.0,
            f"the derivative of the position (R² {share:.3f})", -1 if factor < 0 else 1,
        )  # fmt: skip
    least = 1.0 - max((pairs.share[position, v] for v in speeds), default=0.0)
    of_motion = [v for v in speeds if data.said[v].quantity or 1.0 - pairs.share[position, v] < WORSE * least + 1e-6]
    return _Movement(roles, frozenset({*members, *of_motion}), factor)


def _is_difference(data: Samples, n: int, reference: int, position: int) -> bool:
    """Return whether a column is the following error, which may well go as the velocity does."""
    rows = data.rows(1)
    error, y = data.x[rows, reference] - data.x[rows, position], data.x[rows, n]
    slope, level = np.polyfit(error, y, 1) if np.ptp(error) > 1e-9 * np.abs(error).max() else (0.0, 0.0)
    decade = abs(slope) and abs(np.log10(abs(slope)) - round(np.log10(abs(slope)))) < 0.02
    return bool(decade and (y - slope * error - level).var() < 0.1 * y.var())


def _actual(data: Samples, members: list[int]) -> tuple[int, int | None, float]:
    """Return which of the positions of an axis was measured, which was commanded, and how sure that is."""
    commanded = [n for n in members if data.said[n].commanded]
    if len(members) > 1 and not commanded and all(data.said[n].quantity == "position" for n in members):
        sure = 0.98 if sum(data.said[n].measured for n in members) == 1 else 0.9  # else two encoders
        return max(members, key=lambda n: (data.said[n].measured, bool(data.said[n].unit))), None, sure
    rest = [n for n in members if n not in commanded] or members
    measured = [n for n in rest if data.said[n].measured]
    if commanded and rest != members:
        return (measured or rest)[0], commanded[0], 0.98
    rows = data.rows(16)
    if len(members) == 1 or not len(rows):
        return members[0], None, 0.97 if len(members) == 1 else 0.5
    v = data.x[rows + 16, members[0]] - data.x[rows, members[0]]
    leads = []
    for n in members:
        other = members[0] if n != members[0] else members[1]
        scale = np.polyfit(data.x[rows, other], data.x[rows, n], 1)
        ahead = data.x[rows + 8, n] - np.polyval(scale, data.x[rows + 8, other])
        leads.append(float((ahead * v).sum() / np.sqrt((ahead**2).sum() * (v**2).sum() + 1e-300)))
    noise = [_noise(data, n) for n in members]
    score = [lead - 0.2 * log(max(value, 1e-12)) for lead, value in zip(leads, noise, strict=True)]
    order = np.argsort(score)
    sure = 0.98 if score[order[-1]] - score[order[0]] > 0.5 else 0.8
    return members[order[0]], members[order[-1]], sure


def _noise(data: Samples, n: int) -> float:
    """Return the third differences of a column beside its spread: of a command they are nearly nothing."""
    rows = data.rows(3)
    x = data.x[:, n]
    return float(np.abs(x[rows + 3] - 3 * x[rows + 2] + 3 * x[rows + 1] - x[rows]).mean() / (x.std() + 1e-300))


def _velocity(data: Samples, pairs: Pairs, speeds: list[int], position: int, reference: int | None) -> int | None:
    """Return the measured velocity; None where there is only a commanded velocity."""
    actual = [v for v in speeds if not data.said[v].commanded and not _apart(data, position, v)]
    measured = [v for v in actual if data.said[v].measured]
    if reference is not None and not measured:
        exact = [v for v in actual if pairs.share[reference, v] > max(EXACT, pairs.share[position, v])]
        actual = [v for v in actual if v not in exact]
    named = [v for v in measured or actual if data.said[v].quantity == "velocity" and pairs.share[position, v] > PAIR]
    unit = [v for v in named if data.said[v].unit and not is_electrical(data.columns[v])]
    return max(unit or named or measured or actual, key=lambda v: pairs.share[position, v], default=None)


# --- force ------------------------------------------------------------------------------------------------------------


def _drives(
    data: Samples, t: Real, pairs: Pairs, movements: Sequence[_Movement], used: set[int | None]
) -> list[dict[int, tuple[float, int]]]:
    """Return how much each column follows sign(v) and acceleration of each axis, and the sign by which it brakes."""
    motions = [_Motion(data, t, movement.column("position"), movement.column("velocity")) for movement in movements]
    scores: list[dict[int, tuple[float, int]]] = [{} for _ in movements]
    shown = [movement.tag(data) for movement in movements]
    named = ({*shown} | {data.tags[n] for n in _sided(data, "position", "velocity")}) - {None}
    least = BRAKED if any(data.moving[n] and says.quantity == "force" for n, says in enumerate(data.said)) else 0.02
    for n in np.flatnonzero(data.moving):
        says = data.said[n]
        is_mode = data.levels[n] <= MODES and says.quantity is None
        if is_mode or n in used or says.quantity not in {None, "force", "input"}:
            continue
        of_axes = []
        for tag, movement, motion in zip(shown, movements, motions, strict=True):
            apart = tag != data.tags[n] and (data.tags[n] in named or bool(tag and data.tags[n]))
            of_axes.append((0.0, 1) if apart else _weighed(data, pairs, int(n), movement, motion))
        best = max(pair[0] for pair in of_axes)
        for known, (score, sign) in zip(scores, of_axes, strict=True):
            if score >= 0.5 * best and score > (least if says.quantity != "force" else 0.0):
                known[int(n)] = score if score == best else 0.3 * score, sign
    return scores


def _weighed(data: Samples, pairs: Pairs, n: int, movement: _Movement, motion: "_Motion") -> tuple[float, int]:
    """Return how much a column is the force of an axis, and its sign."""
    says = data.said[n]
    score, braking, sign = motion.score(data.x[:, n])
    if motion.is_magnitude(data.x[:, n]):
        return 0.0, 1
    exact = max((pairs.share[v, n] for v in movement.columns), default=0.0)
    if says.quantity is None and exact > 0.98 and braking < 0.5:
        main = max(movement.columns, key=lambda v: pairs.share[v, n])
        decade = np.log10(abs(float(pairs.factor[main, n])))
        score *= 0.0 if abs(decade - round(decade)) < 0.01 else 0.05  # the derivative of a velocity: an acceleration
    elif says.quantity is None and braking < BRAKED:
        score *= 0.25
    if says.quantity == "force":
        score = max(score, 0.02) * (0.6 if says.commanded else 3.0)
    return score * (1.5 if says.unit in {"N", "N*m", "Nm", "N.m", "A", "mA"} else 1.0), sign


def _by_force(data: Samples, t: Real, movement: _Movement, force: Role | None) -> _Movement:
    """Return an axis whose actual position, where names do not show it, is the one that explains the force better."""
    shown, named = movement.roles, [data.said[role.column or 0] for role in movement.roles.values()]
    if force is None or not {"position", "reference"} <= shown.keys() or any(s.commanded or s.measured for s in named):
        return movement
    both = [shown["position"], shown["reference"]]
    left = [_Motion(data, t, role.column, None).left(data.x[:, force.column or 0]) for role in both]
    noise = [_noise(data, role.column or 0) for role in both]
    better = int(np.argmin(left))
    if not left[better] < CLEARLY * left[1 - better] or 10.0 * noise[better] < noise[1 - better]:  # which was measured
        return movement
    for of, role in zip(("position", "reference"), both if better == 0 else both[::-1], strict=True):
        shown[of] = replace(shown[of], column=role.column, likelihood=0.98)
    return movement


def _open_motions(data: Samples, t: Real, movements: Sequence[_Movement], drives: Sequence[dict[str, Role]]) -> None:
    """Leave open which of several sides moves what is of none, which position the only force moves, and its sign."""
    moved = [m.roles["position"].column or 0 if "position" in m.roles else -1 for m in movements]
    named = [n for n in moved if n >= 0 and data.said[n].quantity == "position"]
    motions = [_Motion(data, t, movement.column("position"), movement.column("velocity")) for movement in movements]
    pushed = [k for k, roles in enumerate(drives) if "force" in roles]
    for k in pushed:
        force, values = drives[k]["force"], data.x[:, drives[k]["force"].column or 0]
        free = data.tags[force.column or 0] is None and data.said[force.column or 0].quantity == "force"
        both = {n: motions[moved.index(n)] for n in named} if len(pushed) == 1 and len(named) > 1 and free else {}
        whole = [n for n, motion in both.items() if motion.score(values)[0] > BRAKED and not motion.is_torn(values)]
        if motions[k].is_torn(values) and moved[k] in both and whole:  # the mass of that one is above 0
            force = replace(drives[k].pop("force"), sign=both[whole[0]].score(values)[2])
            k = moved.index(whole[0])
            drives[k]["force"] = force
        elif motions[k].is_torn(values):
            others = {force.column or 0: -force.sign, **force.others}
            why = f"{force.why}; friction and inertia show different signs"
            drives[k]["force"] = replace(force, likelihood=min(force.likelihood, 0.8), others=others, why=why)
        if moved[k] in both:
            others = {n: both[n].score(values)[2] * force.sign for n in named if n != moved[k]}
            roles = movements[k].roles
            roles["position"] = replace(roles["position"], likelihood=0.8, others=others)
    for movement, roles in zip(movements, drives, strict=True):
        for of, role in roles.items():
            sides = {data.tags[n] for n in (role.column or 0, *role.others)} - {None}
            if movement.tag(data) is None and len(sides) > 1:
                roles[of] = replace(role, likelihood=min(role.likelihood, 0.8))


def _driven(data: Samples, scores: dict[int, tuple[float, int]]) -> dict[str, Role]:
    """Return force and input of an axis by the scores of its columns."""
    roles: dict[str, Role] = {}
    for channel in ("force", "input"):
        kept = {n: score for n, score in scores.items() if (data.said[n].quantity == "input") == (channel == "input")}
        if channel == "input":
            kept = {n: pair for n, pair in kept.items() if pair[0] > DRIVING and not data.said[n].commanded}
            force = roles["force"].column or 0 if "force" in roles else -1
            varies = _varies(data.x[:, force]) if force >= 0 else np.inf  # a supply does by far less than the force
            supplies = {n for n in kept if is_supply(data.x[:, n]) and _varies(data.x[:, n]) < 0.5 * varies}
            of_sensor = data.columns[force].name if force >= 0 else ""
            supplies |= {n for n in kept if data.columns[n].name == of_sensor}  # what its sensor gives out
            kept = {n: pair for n, pair in kept.items() if n not in supplies}
        named = [n for n in kept if data.said[n].means]
        if channel == "force" and named:  # what goes as a force does, and has no name, is that force again
            kept = {n: pair for n, pair in kept.items() if n in named or max(_alike(data, n, k) for k in named) < ALIKE}
        if not kept:
            continue
        if all(data.said[n].quantity is None for n in kept):  # of those that go alike, what is exact is a command
            noise, most = {n: _noise(data, n) for n in kept}, max(kept.values())[0]
            rough = max((n for n in kept if kept[n][0] > ALIKE * most), key=lambda n: noise[n])
            exact = [n for n in kept if 5.0 * noise[n] < noise[rough] and _alike(data, n, rough) > ALIKE]
            kept = {n: pair for n, pair in kept.items() if n not in exact}
        best = max(kept, key=lambda n: kept[n][0])
        measured = [n for n in kept if data.said[n].unit and not data.said[n].commanded]
        if channel == "input":  # a duty is the voltage that it makes, which has a unit
            best = next((n for n in measured if _alike(data, n, best) > EXACT), best)
            kept = {n: pair for n, pair in kept.items() if n == best or _alike(data, n, best) <= EXACT}
        twins = [n for n in kept if {n, best} <= {*measured} and (n == best or _alike(data, n, best) > 0.99)]
        plain = {n for n in twins if any(converts(data.said[n].unit, "force", motion) for motion in PLAIN)}
        best = max(twins, key=lambda n: (n in plain, kept[n][0]), default=best)
        kept = {n: pair for n, pair in kept.items() if n == best or not (
            n in twins or np.allclose(data.x[:, n], data.x[:, best])
        )}  # fmt: skip
        weights = np.array([pair[0] ** 2 for pair in kept.values()])
        clear = kept[best][0] > 0.1 or data.said[best].quantity or data.columns[best].name.endswith("_N")
        sure = 0.99 if clear else 0.9
        sure *= float(kept[best][0] ** 2 / max(weights.sum(), 1e-300))
        others = {n: kept[n][1] for n in sorted(kept, key=lambda n: -kept[n][0])[:4] if n != best}
        why = f"it follows the sign of the velocity and the acceleration (score {kept[best][0]:.2f})"
        roles[channel] = Role(channel, best, "", sure, 0.0, why, kept[best][1], others)
    if "force" not in roles and "input" in roles and not data.said[roles["input"].column or 0].unit:
        roles["force"] = replace(roles.pop("input"), channel="force")  # what is put in, in a unit of the drive
    return roles


def is_supply(values: Real, *, by_unit: bool = True) -> bool:
    """Return whether a voltage hardly changes, as that of a supply; where its name tells it, whether it never does."""
    real = values[np.isfinite(values)]
    real = real / max(float(np.abs(real).max(initial=0.0)), 1e-300)  # what a cut file holds may overflow
    return not len(real) or bool(real.std() <= (0.2 if by_unit else 0.0) * abs(real.mean()))


def _varies(values: Real) -> float:
    """Return the standard deviation over the mean."""
    return float(values.std()) / max(abs(float(values.mean())), 1e-300)


def _alike(data: Samples, n: int, k: int) -> float:
    """Return the correlation of two columns, without its sign."""
    return abs(float(np.corrcoef(data.x[:, n], data.x[:, k])[0, 1]))


def follows(table: ForeignTable) -> float:
    """Return how much of a force of a table goes with a motion in it, by their names: 0 to 1.

    Of 396 pairs of other motions it was 0.27 at most; of 36 records 1, with noise of an eighth of their range 0.56.
    """
    data = Samples([table])
    shown = [says.quantity for says in data.said]
    t = data.x[:, shown.index("time")] if "time" in shown else np.arange(len(data.x), dtype=float)
    moves = [n for n, of in enumerate(shown) if of in {"position", "velocity"}]
    motions = [_Motion(data, t, *((n, None) if shown[n] == "position" else (None, n))) for n in moves]
    pushes = [data.x[:, n] for n, of in enumerate(shown) if of in {"force", "input"}]
    return max((motion.score(push)[0] for motion in motions for push in pushes), default=0.0) / MOST_SCORE


MOST_SCORE = 2.2  # Score of what is wholly a force of a motion


class _Motion:
    """Velocity and acceleration of an axis, at several windows, to hold columns against."""

    def __init__(self, data: Samples, t: Real, position: int | None, velocity: int | None) -> None:
        self.bases = []
        for h in (1, 5, 21):
            rows = data.rows(4 * h)
            rows = rows[t[rows + 4 * h] > t[rows]]  # a clock may stand, and count back
            if len(rows) < 40:
                break
            if velocity is not None:
                sums = np.cumsum(data.x[:, velocity])
                early, late = sums[rows + 2 * h] - sums[rows], sums[rows + 4 * h] - sums[rows + 2 * h]
                span = np.full(len(rows), 2.0 * h)
            else:
                p = data.x[:, position if position is not None else 0]
                early, late = p[rows + 2 * h] - p[rows], p[rows + 4 * h] - p[rows + 2 * h]
                span = t[rows + 4 * h] - t[rows]
                span /= span.max()  # no unit matters below
            v, a = (early + late) / span, (late - early) / span**2
            if (fast := np.abs(v) > 0.1 * np.quantile(np.abs(v), 0.98)).sum() < 30:
                continue
            basis = np.column_stack([np.sign(v), v / np.abs(v).max(), a / (np.abs(a).max() or 1.0), np.ones(len(v))])
            self.bases.append((rows[fast], 4 * h, basis[fast]))

    def is_magnitude(self, values: Real) -> bool:
        """Return whether a column is a force without its sign, as the load of a drive often is."""
        if not self.bases or values.min() < -0.02 * values.max():
            return False
        rows, width, basis = self.bases[0]
        y = values[rows + width // 2]
        sign = basis[:, 0]
        if not 0.2 < np.mean(sign > 0.0) < 0.8:
            return False
        return _left(np.column_stack([np.abs(basis[:, 1]), sign * basis[:, 2], basis[:, 3]]), y)[0] < _left(basis, y)[0]

    def _over(self, values: Real) -> Iterator[tuple[Real, Real, float]]:
        """Yield the motion over each window, the means of a column there, and their squares."""
        sums = np.concatenate([[0.0], np.cumsum(values)])
        for rows, width, basis in self.bases:
            y = (sums[rows + width + 1] - sums[rows]) / (width + 1)
            yield basis, y, float(((y - y.mean()) ** 2).sum())

    def left(self, values: Real) -> float:
        """Return the least share of a column's squares that the motion leaves, of the windows."""
        return min((_left(basis, y)[0] / (spread + 1e-300) for basis, y, spread in self._over(values)), default=1.0)

    def score(self, values: Real) -> tuple[float, float, int]:
        """Return how much of a column follows sign(v) and a, sign(v) alone, and the sign by which it brakes."""
        best, braking, sign = 0.0, 0.0, 1
        for basis, y, spread in self._over(values):
            whole, weights = _left(basis, y)
            if not spread > 0 or whole < 1e-9 * spread:
                continue  # exactly of the motion itself
            parts = [1.0 - whole / _left(np.delete(basis, k, 1), y)[0] for k in (0, 2)]
            joint = 1.0 - whole / _left(basis[:, 2:], y)[0]
            if (score := parts[0] + (parts[1] if parts[0] > 0.01 else 0.2 * parts[1]) + 0.2 * joint) > best:
                pushes = _pushes(basis, weights)
                turned = pushes[0] < 0.0 and pushes.sum() < -BRAKED * y.var()  # in the mean its power drives the axis
                best, braking, sign = score, parts[0], -1 if turned else 1
        return best, braking, sign

    def is_torn(self, values: Real) -> bool:
        """Return whether friction brakes by one sign of a force, and the mass is above 0 by the other."""
        best = (1.0, 0.0, 0.0, 0.0)
        for basis, y, spread in self._over(values):
            left, weights = _left(basis, y)
            of_mass = 1.0 - left / _left(np.delete(basis, 2, 1), y)[0]
            pushes = _pushes(basis, weights)
            best = min(best, (left / (spread + 1e-300), of_mass, *pushes / (max(y.var(), *np.abs(pushes)) or 1.0)))
        _, of_mass, brakes, accelerates = best
        return of_mass > SEEN and brakes * accelerates < 0.0 and min(abs(brakes), abs(accelerates)) > BRAKED


def _left(basis: Real, y: Real) -> tuple[float, Real]:
    weights, *_ = np.linalg.lstsq(basis, y, rcond=1e-9)
    return float(((y - basis @ weights) ** 2).sum()) + 1e-300, np.asarray(weights, float)


def _pushes(basis: Real, weights: Real) -> Real:
    """Return the square that friction and inertia have in a force, below 0 where they drive: shape (2,)."""
    braking = [0, 1, 3] if abs(basis[:, 0].mean()) > 0.9 else [0, 1]  # in one direction its level is friction
    brakes, accelerates = basis[:, braking] @ weights[braking], basis[:, 2] * weights[2]
    return np.array([np.sign(brakes @ basis[:, 1]) * (brakes**2).mean(), np.sign(weights[2]) * accelerates.var()])


def _by_velocity(data: Samples, movements: Sequence[_Movement]) -> list[_Movement]:
    """Return axes with a velocity and no position, by its name or unit; beside others those of a force's side."""
    speeds = [n for n in range(len(data.columns)) if data.said[n].quantity == "velocity"]
    wanted = [n for n in speeds if not data.said[n].commanded] or speeds[:1]
    wanted = [n for n in wanted if _goes_on(data.x[:, n])]
    moving = [n for n in wanted if data.moving[n]]
    same = {n for k, n in enumerate(moving) for m in moving[:k] if not _apart(data, n, m) and _alike(data, n, m) > SAME}
    wanted = [n for n in wanted if n not in same]  # as a second sensor has it
    if movements:
        pushed = {data.tags[n] for n, says in enumerate(data.said) if says.quantity == "force" and data.moving[n]}
        named = zip(data.columns, data.tags, strict=True)
        names = [column.name.casefold().replace(tag or " ", "#") for column, tag in named]
        moved = {names[m.roles["position"].column or 0] for m in movements if "position" in m.roles}
        still = {data.tags[n] for n, name in enumerate(names) if name in moved}  # their position is logged, and rests
        pushed -= {None, *still, *(movement.tag(data) for movement in movements)}
        wanted = [n for n in wanted if data.moving[n] and data.tags[n] in pushed]
    roles = {v: Role("velocity", v, "", 0.97, 0.0, "by its name or unit") for v in wanted}
    return [_Movement({"velocity": roles[v]}, frozenset(n for n in speeds if not _apart(data, n, v))) for v in wanted]


def _goes_on(v: Real) -> bool:
    """Return whether a velocity is more than noise, of which a mean over rows has less the more there are."""
    means = v[: len(v) // LASTS * LASTS].reshape(-1, LASTS).mean(axis=1)
    return not len(means) or float((means**2).mean()) > 3.0 / LASTS * float((v**2).mean())


# --- units ------------------------------------------------------------------------------------------------------------


def _in_units(
    data: Samples, t: Real, movement: _Movement, roles: dict[str, Role], clock: Role, kind: Motion | None = None
) -> AxisColumns | None:
    """Return the axis with its units: those of the header, or those that the factor and usual sizes leave."""
    nothing = Spoken(None)
    said = {channel: data.said[role.column] for channel, role in roles.items() if role.column is not None}
    p, v = roles.get("position"), roles.get("velocity")
    step = float(np.median(np.diff(t))) if len(t) > 1 else 1.0
    sizes = (
        None if p is None or p.column is None else float(np.ptp(data.x[:, p.column])),
        None if v is None or v.column is None else float(np.quantile(np.abs(data.x[:, v.column]), 0.98)),
    )
    first, second = said.get("position", nothing), said.get("velocity", nothing)
    logged = clock.column is not None or bool(clock.unit)
    factor = abs(movement.factor) if movement.factor and logged else None
    clocks = {"s": 1.0} if clock.column is None else {clock.unit: 1.0} if clock.unit else time_units(step, len(t))

    if counted := _counted(data, movement, roles, clock, said):
        factor, first, sizes, p = None, Spoken(None, moves={counted[1]: 1e6}), (None, sizes[1]), None
        v, second = (v, second) if second.unit else (None, nothing)
        roles = {channel: role for channel, role in roles.items() if v or channel != "velocity"}
    slope = movement.factor if v or not counted else None

    def weighed(factor: float | None) -> list[Reading]:
        found = [
            replace(reading, weight=reading.weight * weight) for unit, weight in clocks.items()
            for reading in readings(first, second, unit, factor, sizes, bool(p), bool(v))
        ]  # fmt: skip
        found = [replace(reading, position=counted[0]) for reading in found] if counted and not logged else found
        found = found if logged or not slope else _clocked(found, slope, len(t))
        return _weighed_by_names(found, data, said.get("force", nothing), p, v)

    found = weighed(factor)
    wrong = contradicting(first, second, clock.unit, factor, sizes) if factor and clock.unit and not found else []
    total = sum(reading.weight for reading in (*found, *wrong, *wrong))  # of two that contradict, none is sure
    found = found or wrong
    if factor and not total:  # counts, or a gear between them: the position alone is of one motion
        roles = {channel: role for channel, role in roles.items() if channel != "velocity"}
        turns = rotates(max(second.moves, key=lambda m: second.moves[m], default="linear")) or second.unit == "rpm"
        v, second, sizes = None, Spoken(None, moves={} if turns else second.moves), (sizes[0], None)
        found = weighed(None)
        on_screw = [turns and _is_on_screw(factor, reading) for reading in found]
        found = [reading for reading, on in zip(found, on_screw, strict=True) if on] or found
        total = sum(reading.weight for reading in found) / (1.0 if any(on_screw) else UNFIT)
    if not total:
        return None
    other = 0.0 if first.unit or second.unit else UNUSUAL * max(clocks.values())  # counts, a pitch, a gear
    other *= BY_CHANCE if factor else 1.0
    counts = data.x[:, p.column] if p is not None and p.column is not None else np.full(1, np.nan)
    other = total if np.all(counts == np.rint(counts)) and not (first.unit or second.unit) else other
    if factor and other > total:  # the velocity may be an acceleration, and the position its velocity
        roles = {name: replace(role, likelihood=min(role.likelihood, 0.8)) for name, role in roles.items()}
    total += other

    def likeliest(of: str) -> tuple[str, float, tuple[str, ...]]:
        weights: dict[str, float] = {}
        for reading in found:
            weights[getattr(reading, of)] = weights.get(getattr(reading, of), 0.0) + reading.weight / total
        order = sorted(weights, key=lambda name: -weights[name])
        return order[0], weights[order[0]], tuple(name for name in order[1:4] if weights[name] > 0.01)

    motion, motion_sure, _ = likeliest("motion")
    if kind is not None and any(reading.motion == kind for reading in found):
        motion, motion_sure = kind, 1.0 - motion_sure
    best = max((reading for reading in found if reading.motion == motion), key=lambda reading: reading.weight)
    units = {"time": (best.time, *likeliest("time")[1:])}
    if clock.unit:
        units["time"] = clock.unit, clock.unit_likelihood, ()
    elif not logged:
        clock = replace(clock, why="by position against velocity") if slope else clock
        units["time"] = _period(slope, best, likeliest("position")[1] * likeliest("velocity")[1])
    for of in ("position", "velocity"):
        first_choice, sure, others = likeliest(of)
        units[of] = getattr(best, of), sure if kind is None else min(motion_sure, sure), (first_choice, *others)
    if counted:
        units["position"] = counted[0], 0.97, ()
    units |= _units_beside(data, movement.roles | roles, said, motion, units["position"])
    whole = {"time": clock} | roles
    for channel, role in whole.items():
        unit, sure, others = units[channel]
        others = tuple(text for text in others if text != unit)
        turn = float(data.turn[role.column]) if role.column is not None else 0.0
        whole[channel] = replace(role, unit=unit, unit_likelihood=sure, units=others, turn=turn)
    moves: Motion = "rotary" if motion == "rotary" else "linear"
    if "force" in whole:
        moves = in_units_of(moves, whole["force"].unit)
    ranked = [replace(reading, weight=reading.weight / total) for reading in sorted(found, key=lambda r: -r.weight)]
    whole = {channel: whole[channel] for channel in (*LIKELY, "load_position") if channel in whole}
    return AxisColumns("", moves, motion_sure, whole, tuple(ranked), None if logged else movement.factor)


Units = tuple[str, float, tuple[str, ...]]  # A unit, how sure it is, and the others that it may be


def _units_beside(
    data: Samples, roles: Mapping[str, Role], said: Mapping[str, Spoken], motion: str, position: Units
) -> dict[str, Units]:
    """Return the units of the channels beside position and velocity."""
    units = {}
    for of in said.keys() & {"reference", "load_position", "force", "input"}:
        if of in {"force", "input"}:
            newtons = of == "force" and motion == "linear" and data.columns[roles[of].column or 0].name.endswith("_N")
            known = said[of]._replace(unit=said[of].unit or "N") if newtons else said[of]
            units[of] = usual_units(of, known, motion, data.x[:, roles[of].column or 0])
        else:
            units[of] = (said[of].unit or "", 1.0, ()) if said[of].unit else position
    moving = [of for of in ("position", "velocity") if of in roles]
    if any(is_electrical(data.columns[roles[of].column or 0]) for of in moving):  # a turn of the axis has several
        units |= {of: ("", 0.0, ()) for of in moving if not said[of].unit or of == "velocity"}
    return units


_DECADES = tuple(m * 10.0**k for m in (1.0, 2.0, 3.6, 4.0, 5.0, 8.0) for k in range(2, 6))
COUNTS = np.array([*(2.0**k for k in range(8, 25)), *_DECADES])  # Steps of a turn that encoders have


def _counted(
    data: Samples, movement: _Movement, roles: Mapping[str, Role], clock: Role, said: Mapping[str, Spoken]
) -> tuple[str, Motion] | None:
    """Return what a count of the position is, and the motion: by the turn after which it repeats, or its velocity."""
    p, says = roles.get("position"), said.get("velocity", Spoken(None))
    unit = says.unit
    if p is None or p.column is None or said["position"].unit:
        return None
    if says.moves == TURNS and not unit:  # in revolutions or radians: by which a turn has a usual count
        both = (says._replace(unit=unit) for unit in ("rev/s", "rad/s"))
        tried = (_counted(data, movement, roles, clock, {**said, "velocity": turn}) for turn in both)
        return next((turn for turn in tried if turn and turn[0].endswith("rev")), None)
    if data.turn[p.column] >= COUNTS.min() and data.turn[p.column] != 360.0:
        return f"{1.0 / data.turn[p.column]:.9g} rev", "rotary"
    if not (unit and clock.unit and movement.factor):
        return None
    stamp, logged = (si_factor(clock.unit, "time"), clock.unit) if clock.column is not None else (1.0, "s")
    motion = next((motion for motion in PLAIN if converts(unit, "velocity", motion)), None)
    if motion is None or readings(said["position"], said["velocity"], logged, movement.factor):
        return None
    size = si_factor(unit, "velocity", motion) * abs(movement.factor) * stamp
    steps = COUNTS[np.argmin(np.abs(np.log(COUNTS * size / (2.0 * np.pi))))]
    usual = rotates(motion) and abs(log(steps * size / (2.0 * np.pi))) < TOLERANCE
    return (f"{1.0 / steps:.9g} rev" if usual else f"{size:.6g} {si_unit('position', motion)}"), motion


def _weighed_by_names(found: Sequence[Reading], data: Samples, force: Spoken, *of: Role | None) -> list[Reading]:
    """Return readings weighed by what names, the unit of the force and the steps of position and speed show."""
    usual, custom = customary_unit(data.columns)
    step, speed = (
        lattice_step(data.x[:ROWS, role.column]) if role and role.column is not None and len({*units}) > 1 else None
        for role, units in zip(of, ((r.position for r in found), (r.velocity for r in found)), strict=True)
    )
    rpm = 30.0 / np.pi * (speed or 0.0)
    of_rpm = {"rad/s"} if 0.5 < rpm < 10.5 and abs(rpm - round(rpm)) < ENCODER * rpm else set()

    def fits(reading: Reading) -> float:
        weight = custom if usual in {reading.position, reading.velocity, reading.velocity.removesuffix("/s")} else 1.0
        weight *= SHOWN if reading.velocity in of_rpm else 1.0
        if step is None or reading.motion != "rotary":
            return weight
        turn = 2.0 * np.pi / (step * si_factor(reading.position, "position", "rotary"))
        decimals = 25 if reading.position == "rev" else 9  # of what rounding to digits looks like: 0.001 rev, 0.001 deg
        return weight * (SHOWN if np.abs(turn / COUNTS[COUNTS % decimals > 0] - 1.0).min() < ENCODER else 1.0)

    shown = motions_in(" ".join(re.split(r"[\W_]+", f"{data.path.parent.name} {data.path.stem}")))
    of_force = {motion for motion in PLAIN if converts(force.unit, "force", motion)} if force.unit else set()
    by_name = {motion: 2.0 if shown.get(motion, 1.0) > 3.0 else 1.0 for motion in PLAIN}
    by_force = {motion: 1e-3 if of_force and motion not in of_force else 1.0 for motion in PLAIN}
    return [replace(r, weight=r.weight * by_name[r.motion] * by_force[r.motion] * fits(r)) for r in found]


def take_reading(axis: AxisColumns, reading: Reading, likelihood: float = 1.0) -> None:
    """Take the units of a reading as those of an axis, which closes its questions where it is sure."""
    axis.readings = (reading, *(other for other in axis.readings if other != reading))
    if (force := axis.roles.get("force")) and force.unit in {"N", "N*m"} and force.unit_likelihood < SURE:
        axis.roles["force"] = replace(force, unit="N*m" if reading.motion == "rotary" else "N")
    axis.motion, axis.motion_likelihood = in_units_of(reading.motion, axis.motion.partition("/")[2]), likelihood
    units = {"time": reading.time, "position": reading.position, "velocity": reading.velocity}
    if axis.factor:
        units["time"] = _period(axis.factor, reading, 1.0)[0]
    units["reference"] = reading.position
    for channel, role in axis.roles.items():
        unit = units.get(channel)
        if unit and role.unit_likelihood < (likelihood if channel == "time" else 1.0):
            logged = channel != "time" or role.column is not None or axis.factor
            others = tuple(text for text in (role.unit, *role.units) if text != unit)
            axis.roles[channel] = replace(
                role, unit=unit if logged else role.unit, unit_likelihood=likelihood, units=others
            )


def _clocked(found: Sequence[Reading], factor: float, rows: int) -> list[Reading]:
    """Return readings weighed by how usual the sampling period is that they imply, where no clock was logged."""
    periods = [_implied_period(factor, reading) for reading in found]
    weights = [time_units(period, rows)["s"] * (1.0 if usual else BY_CHANCE) for period, usual in periods]
    return [replace(reading, weight=reading.weight * w) for reading, w in zip(found, weights, strict=True)]


USUAL_PERIODS = np.array([m * 10.0**e for m in (1.0, 1.25, 2.0, 2.5, 4.0, 5.0, 6.25, 8.0) for e in range(-7, 2)])
"""Sampling periods of drives [s]."""


def _period(factor: float | None, reading: Reading, sure: float) -> tuple[str, float, tuple[str, ...]]:
    """Return the sampling period of a log without time: what makes the velocity that of the position."""
    if not factor:
        return "", 0.0, ()
    period, near = _implied_period(factor, reading)
    return f"{period:.4g} s", 0.98 * sure if near else 0.9 * sure, ()


def _implied_period(factor: float, reading: Reading) -> tuple[float, bool]:
    """Return the period [s] by which a velocity is that of the position in units, and whether it is a usual period."""
    count, _, unit = reading.position.rpartition(" ")
    size = float(count or 1.0) * si_factor(unit, "position", reading.motion)
    period = size / (si_factor(reading.velocity, "velocity", reading.motion) * abs(factor))
    usual = float(USUAL_PERIODS[np.argmin(np.abs(np.log(USUAL_PERIODS / period)))])
    return (usual, True) if abs(log(usual / period)) < TOLERANCE else (period, False)
