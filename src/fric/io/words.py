"""What names and units of columns say: the one list of words, in the languages of those who write headers."""

import re
import tomllib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import chain, product
from math import exp, log
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from fric.arrays import Real
from fric.columns import CHANNELS, channel_dimension
from fric.errors import FricError
from fric.io.readers.base import Column, ForeignTable, named, plain_name
from fric.units import MOTIONS, PLAIN, Motion, converts, factor, is_unit

_LISTS = tomllib.loads(Path(__file__).with_name("words.toml").read_text("utf-8"))


def _in_all_languages(kind: str) -> dict[str, tuple[str, ...]]:
    """Return the lists of words of a kind."""
    return {name: tuple(chain(*of.values())) for name, of in _LISTS[kind].items()}


QUANTITIES, SHOWS = _in_all_languages("quantity"), _in_all_languages("shows")
"""Words of each quantity, in the order in which they are tried, and of what else a name shows."""
LETTERS, EXACT, OF_MEANS, CLOCKS, SUFFIX = map(dict[str, str], _LISTS["names"].values())
ROWS, COUNTED, _SILENT = (frozenset(_LISTS["plain"][name]) for name in ("rows", "counted", "silent"))
AXES = "xyzabcuvw"  # Letters that name axes of machine tools


def named_as(column: Column) -> str | None:
    """Return the channel that the name of a column shows; None where it shows none. A demand is a reference."""
    says = spoken(column)
    shown = says.means if says.means in {"error", "time"} or not says.commanded else "reference"
    return shown if shown in {"error", *CHANNELS} else None


def axis_of(*names: str) -> str | None:
    """Return the axis that names show, as ``X actual position`` or ``y_strokes``; None where none or several do.

    A letter, or ``AxisX``, denotes an axis where it is the first or the last word and not the only word; u, v and w
    only beside ``axis`` or a quantity: they are a voltage, a speed and a power, too.
    """
    found = set()
    for name in names:
        parts = re.sub(r"[\W_]+", " ", plain_name(name)).split()
        ends = [re.sub(r"^(?:axis|achse)(?=.$)", "", word) for word in (*parts[:1], *parts[-1:])]
        rest = " ".join(word for word in parts if len(word) > 1)
        clear = any(_has(rest, known) for known in (("axis", "achse"), *QUANTITIES.values()))
        found |= {word for word in ends if word in {*(AXES if clear else AXES[:6])} and len(parts) > 1}
    return found.pop() if len(found) == 1 else None


def axis_of_file(path: Path) -> str | None:
    """Return the axis x, y or z that the name of a file, or else of its folder, shows; other letters may be of runs."""
    folder = path.absolute().parent.name
    found = map(axis_of, (path.name.split(".")[0], folder, f"axis {folder}"))
    return next((name for name in found if name in {*"xyz"}), None)


def said_axis(constants: Mapping[str, str]) -> str | None:
    """Return the axis that a line of the preamble states, as ``Axis: Y``."""
    said = (text.strip().lower() for name, text in constants.items() if re.search(r"(?i)(?:^|\.)(axis|achse)$", name))
    return next((text for text in said if text in {*AXES}), None)


def measures(column: Column, channel: str) -> bool:
    """Return whether the unit of a column suits a channel."""
    if (unit := (column.unit or "").strip()) in {"", "1", "%", "-"} or not is_unit(unit):
        return False
    return any(converts(unit, channel_dimension(channel), motion) for motion in PLAIN)


def looking_like(table: ForeignTable, channel: str, taken: Collection[int]) -> list[int]:
    """Return the columns that look like a channel, those whose name shows it first, without ``taken``.

    A column whose name shows another channel is excluded, with any unit; time is recognised by its name or its unit.
    """
    by_name, by_unit = [], []
    for n, column in enumerate(table.columns):
        if n in taken:
            continue
        text = named_as(column)
        if channel == "reference" and not (text == channel and (not column.unit or measures(column, channel))):
            continue  # what has the unit of a position is a position first; the reference of a force is none
        if text == channel:
            by_name.append(n)
        elif (text is None or (text == "reference" and channel == "input")) and measures(column, channel):
            by_unit.append(n)
    return by_name + by_unit


def refuse_left_out(table: ForeignTable, origins: Collection[str], taken: Collection[int]) -> None:
    """Refuse a table of which a column that looks like force, position or velocity would be left out."""
    for channel in ("force", "position", "velocity"):
        if channel in origins or (channel == "velocity" and "position" in origins):
            continue
        if not (found := [table.columns[n] for n in looking_like(table, channel, taken)]):
            continue
        listed = " and ".join(f"'{name} [{unit}]'" if unit else f"'{name}'" for name, unit in found)
        what = f"no column is named {channel}, and {listed} {'looks' if len(found) == 1 else 'look'} like it"
        hint = "Say in a mapping (`mapping=`) which is what, or is left out; `fric ingest --propose` writes it."
        raise FricError(what, where=str(table.path), hint=hint)


OF_UNITS = ("time", "position", "velocity", "force", "input", "acceleration")  # Dimensions that a unit shows
DRIVE_UNITS = ("A", "mA", "%", "count")
"""Units of a force that is logged in a unit of the drive; a signal in V is an input first."""
_RATIO = re.compile(r"(?i)(?:^|[_\s])([a-z]+)[_\s]per[_\s](s|sec|secs|seconds?|min|minute)$")
"""The unit of a velocity behind a name, as in ``speed_meters_per_sec``."""
TURNS: Mapping[Motion, float] = {"rotary": 1e3}  # What a velocity in 1/s shows: radians, or revolutions, no metres
_TYPED = re.compile(r"(?<![^\W_])(?:[bfinrsuwx]|lr|u?[dsu]?i|d?w|st)(?=[A-Z][a-z])")  # Of a PLC: the type of a variable


class Spoken(NamedTuple):
    """What a name and a unit show of a column."""

    quantity: str | None
    unit: str | None = None
    commanded: bool = False
    measured: bool = False
    moves: Mapping[Motion, float] = MappingProxyType({})  # How much more likely a motion is than the other
    at_load: bool = False  # Whether it is of a second encoder
    means: str = ""  # Which of `QUANTITIES` the name shows: a force may be a current, or a load


def spoken(column: Column) -> Spoken:
    """Return what the name and the unit of a column show."""
    if column.unit is None and (said := re.fullmatch(r"(\w+)/([a-zA-Zµ°]+(?:/[a-z]+)?)", column.name)):
        of, unit = spoken(Column(said[1])).quantity, said[2]  # force/N is a force [N]; arm/position is of an arm
        if of and is_unit(unit) and _quantity_of(unit) == of:
            return spoken(Column(said[1], unit))
    path = re.sub(r"(?i)(header\.stamp|states?|status\w*|\w+_mapper)(?=[./])", " ", bare(column))  # as state.speed
    typed = _TYPED.sub("", path)  # iActualPosition is no current, though iActual is one
    path = typed if any(_has(_words(typed), known) for known in QUANTITIES.values()) else path
    name, leaf = _words(path), _words(path.rpartition("/")[2])  # /joint_states/elbow/position is a position
    shows = leaf in LETTERS or leaf.startswith("f ") or any(_has(leaf, known) for known in QUANTITIES.values())
    field = _words(re.split(r"\.(?=\w+$)", path)[-1])  # log.sig.u is an input, as u is
    name = leaf if shows else field if field in LETTERS else name
    by_name = next((quantity for quantity, known in QUANTITIES.items() if _has(name, known)), None)
    unit = _unit_of(column)
    unit = "N*m" if unit == "nm" and by_name == "force" else unit or ("count" if _has(name, SHOWS["counts"]) else None)
    counted = is_counted(unit)
    by_unit = _quantity_of(unit) if unit and not counted else None
    sensed = by_unit == "input" and by_name in {"position", "velocity"} and not _has(name, SHOWS["reference"])
    by_name = "other" if sensed else by_name
    turns = unit in {"1/s", "s^-1", "s-1"} and by_name == "velocity"
    commanded, measured = _has(name, SHOWS["reference"]), _has(name, SHOWS["measured"])
    wrong = by_unit == "other" and by_name in {"position", "velocity"} and (commanded or measured)  # a position in kg
    unit, by_unit = (None, None) if turns or wrong else (unit, by_unit)
    by_name = LETTERS.get(name, by_name) if by_name is None and not commanded else by_name
    by_name = "time" if by_name is None and path.endswith(".t") else by_name  # a field of a structure
    by_name = "force" if by_name is None and name.startswith("f ") and name != "f n" else by_name
    if by_name == "force" and _has(name, QUANTITIES["input"]):  # a feedforward (ff) in volts
        by_name, commanded = "input", commanded or _has(name, ("ff",))
    means = by_name or ""
    is_row = name.split()[-1:] == ["seq"] or name in ROWS
    by_name = "row" if is_row else {"current": "force", "load": "force", "duty": "input"}.get(means, by_name)
    quantity = by_name if by_unit is None or by_name in {"error", "other"} else by_unit
    if counted:
        unit = "count" if quantity == "force" else None
    elif unit and quantity != by_unit and by_name not in {"error", "other", "row"}:
        unit = None
    if by_name == "time" and by_unit in {None, "time"}:
        last = _words(re.split(r"\.(?=\w)", path)[-1]).split()  # ms.time is of a multisine
        quantity, unit = "time", unit or next((size for word, size in CLOCKS.items() if word in last), None)
    moves = TURNS if turns else motions_in(name)
    return Spoken(quantity, unit, commanded, measured, moves, _has(name, SHOWS["at_load"]), means)


def of_axis(column: Column, tag: str | None) -> Spoken:
    """Return what a name shows beside the letter of its axis: ``u_x`` an input, ``x`` and ``x_ref`` positions."""
    if tag not in {*"xyz"}:
        return spoken(column)
    if (says := spoken(column)).quantity is None:
        name = _words(bare(column))
        rest = re.sub(rf"\b{tag}\b" if tag in name.split() else rf"\b{tag}|{tag}\b", "", name).strip()
        says = spoken(Column(rest or "pos", column.unit))
        of = "position" if says.quantity is None and (says.commanded or says.measured) else says.quantity
        says = says._replace(quantity=of)
    return says._replace(moves=says.moves if max(says.moves.values(), default=0.0) > 3.0 else {"linear": 12.0})


CUSTOMS = tuple((unit, weight, re.compile(known)) for unit, weight, known in _LISTS["customs"]["units"])


def customary_unit(columns: Sequence[Column]) -> tuple[str, float]:
    """Return the unit in which a program whose names these are logs positions or speeds, and its weight."""
    names = [column.name.casefold() for column in columns]
    return next(((unit, weight) for unit, weight, known in CUSTOMS if any(map(known.search, names))), ("", 1.0))


def is_counted(unit: str | None) -> bool:
    """Return whether a unit is counts, or counts/s."""
    return unit is not None and unit.partition("/")[0] in COUNTED


def in_counts(column: Column) -> bool:
    """Return whether a motion is in counts or volts by its unit, or by its name, as that of an object of CiA 402."""
    return is_counted(column.unit) or converts(column.unit, "input") or bool(_COUNTED.search(column.name))


_COUNTED = re.compile(
    r"(?i)(position|velocity)_actual_(internal_)?value|"
    r"^(present|goal)_(position|velocity)$|[_ ](counts?|cnts?|cts|incs?|increments|pulses|ticks)$"
)


def says_mode(column: Column) -> float:
    """Return how surely a name is that of a mode of the control; 0 where it is not."""
    name = _words(column.name)
    return next((1.0 / (1 + n) for n, word in enumerate(SHOWS["mode"]) if _has(name, (word,))), 0.0)


def is_electrical(column: Column) -> bool:
    """Return whether a name says that a turn is that of a pair of poles."""
    return _has(_words(column.name), SHOWS["electrical"])


def motions_in(name: str) -> Mapping[Motion, float]:
    """Return how much more likely a motion is by a name: words show it, and a letter of a linear axis a little."""
    words = name.casefold()
    for motion in PLAIN:
        if _has(words, SHOWS[motion]):
            return {motion: 12.0}
    return {"linear": 3.0} if set(words.split()) & set("xyz") else {}


def bare(column: Column) -> str:
    """Return the name of a column without the unit that it ends in."""
    if column.unit or _unit_of(column) is None:
        return column.name.removesuffix(f"_{column.unit}")
    if ratio := _RATIO.search(column.name):
        return column.name[: ratio.start()] or column.name
    parts = re.split(r"(?<=[^_\s])[_\s]+(?=[^_\s])", column.name)
    two = len(parts) > 2 and "_".join(parts[-2:]).casefold() in SUFFIX
    return " ".join(parts[: -2 if two else -1]) or column.name


def tags(columns: Sequence[Column]) -> list[str | None]:
    """Return the axis in each name: a number or a word that several columns share, whose rest others have, too.

    ``roll_angle, roll_rate, yaw_angle, yaw_rate`` are of two axes, ``x1, x2, force`` of none; x, y, z may be within.
    """
    plain = (re.sub(r"\((?::,)?(\w+)\)$", r" \1", bare(column)) for column in columns)  # J1 is no joule
    names = _parted([_words(name).split() for name in plain])
    shown = [spoken(column).quantity or "" for column in columns]  # IL.FB [A] and VL.FB [rpm] are of no two axes
    first, last = [0] * len(names), [len(name) - 1 for name in names]
    letters = sum(name[-1:] in {("x",), ("y",), ("z",)} for name in names)
    numbers = [next((n for n in reversed(range(len(name))) if re.fullmatch(r"\d{1,2}", name[n])), -1) for name in names]
    within = [next((n for n, word in enumerate(name) if word in {*"xyz"}), -1) for name in names]
    for places in (numbers, within, last, first) if letters > 1 else (numbers, first, last, within):
        rests: dict[str, set[tuple[str, ...]]] = {}
        found = [""] * len(names)
        for k, (name, n) in enumerate(zip(names, places, strict=True)):
            if n >= 0 and (len(name) > 1 or places is within) and not says_something(name[n]):
                found[k] = name[n]
                rests.setdefault(name[n], set()).add((*name[:n], *name[n + 1 :], shown[k]))
        common = {word: rest & set().union(*(r for w, r in rests.items() if w != word)) for word, rest in rests.items()}
        if len(known := {word for word, rest in common.items() if rest and len(rests[word]) > 1}) > 1:
            return [word if word in known else None for word in found]
    return _twins(names, shown)


def _twins(names: Sequence[tuple[str, ...]], shown: Sequence[str]) -> list[str | None]:
    """Return the axes of names of which two or more differ from others by a letter: ``pos, ref, force, pos y, ref y``.

    shown: The quantity that each shows.
    """
    for letter, other in (("y", "x"), ("x", "y"), ("z", "x")):
        plain = {name: what for name, what in zip(names, shown, strict=True) if letter not in name}
        pairs = [_twin(name, letter, what, plain) for name, what in zip(names, shown, strict=True)]
        if len(both := {*pairs} - {None}) > 1:
            its = (
                name in both or what in {"force", "input", "velocity"} for name, what in zip(names, shown, strict=True)
            )
            return [letter if twin else other if mine and name in plain else None
                    for name, twin, mine in zip(names, pairs, its, strict=True)]  # fmt: skip
    return [None] * len(names)


def _twin(
    name: tuple[str, ...], letter: str, shows: str, plain: Mapping[tuple[str, ...], str]
) -> tuple[str, ...] | None:
    """Return the name that one with a letter has beside it: ``pos`` of ``pos y``, ``pos act`` of ``y act``."""
    without = tuple(word for word in name if word != letter)
    stuck = (*name[:-1], name[-1].removesuffix(letter)) if name else name
    at = name.index(letter) if letter in name else -1
    alike = [other for other in plain if len(other) == len(name) and at >= 0
             and (*other[:at], *other[at + 1 :]) == without]  # fmt: skip
    found = (other for other in (*alike, without, stuck) if other != name and other in plain and other)
    return next((other for other in found if not (plain[other] and shows) or plain[other] == shows), None)


def _parted(names: Sequence[Sequence[str]]) -> list[tuple[str, ...]]:
    """Return names of words, an x, y or z apart from a rest that two of them are stuck to: ``xfb, yfb``.

    A letter that is known so, or stands alone, is also apart from a word that says something: ``xcur`` without a ycur.
    """
    words = {word for name in names for word in name if len(word) > 1}
    ends = [(word[0], "{} " + word[1:]) for word in words] + [(word[-1], word[:-1] + " {}") for word in words]
    stuck = {(letter, rest) for letter, rest in ends if letter in {*"xyz"}}
    both = {rest for letter, rest in stuck if any((other, rest) in stuck for other in {*"xyz"} - {letter})}
    known = {letter for letter, rest in stuck if rest in both}.union(*names)
    both |= {rest for letter, rest in stuck if letter in known and rest[0] == "{" and says_something(rest[3:])}
    apart = {rest.format(letter).replace(" ", ""): rest.format(letter) for letter, rest in stuck if rest in both}
    return [tuple(" ".join(apart.get(word, word) for word in name).split()) for name in names]


@cache
def says_something(word: str) -> bool:
    """Return whether a word of a name says what a column is, and not of which axis."""
    if word.isdigit() or word in AXES:
        return False
    quantities = (word for words in QUANTITIES.values() for word in words)
    return word in _SILENT or _has(word, (*SHOWS["reference"], *SHOWS["measured"], *quantities, *LETTERS))


def _words(name: str) -> str:
    parted = re.sub(r"(?<=[a-zà-ÿ])(?=[A-Z])|(?<=[A-Za-z])(?=\d)", " ", name)
    words = re.sub(r"[_\W]+", " ", plain_name(parted)).strip()
    return re.sub(r"\b([xyz])(ref|cmd|des|set|act|pos|soll|ist)\b", r"\1 \2", words)


@cache
def _pattern(known: tuple[str, ...]) -> re.Pattern[str]:
    """Return the pattern of words: short words are separate, long words begin or end a compound (Istlage, Sollwert)."""
    return re.compile("|".join(rf"\b{w}\b" if len(w) < 4 else rf"\b{w}|{w}\b" for w in known if w))


def _has(name: str, known: tuple[str, ...]) -> bool:
    return bool(_pattern(known).search(name))


_PERCENT = re.compile(
    r"(\d*[.,]?\d+)?\s*(?:(?:%|percent|pct|prozent|pour ?cents?|por ?ciento|per ?cento)(?![a-z]*/)|"
    r"(‰|per ?mille?|promille)).*", re.IGNORECASE)  # fmt: skip
"""Shares of a rated value, as ``% of rated``, ``0.1 %`` and ``‰``."""
_PER_MILLE = re.compile(
    r"(?<![0-9a-f])(?:0x)?607[478](?![0-9a-f])|\bpresent_load|(torque|current)_actual_value", re.IGNORECASE
)
"""Torques and currents that CiA 402 and Dynamixel define in a thousandth of a rated value."""


def _unit_of(column: Column) -> str | None:
    """Return the valid unit of a column: that of the header, or the end of its name."""
    unit = (column.unit or "").strip()
    if share := _PERCENT.fullmatch(unit):
        tenths = share[2] or re.fullmatch(r"0?[.,]1", share[1] or "")
        return "0.1 %" if tenths else f"{share[1].replace(',', '.')} %" if share[1] else "%"
    if unit.casefold() in COUNTED:
        return unit.casefold()
    if not unit and _PER_MILLE.search(column.name):
        return "0.1 %"
    if unit not in {"", "1", "-"} and is_unit(unit):
        return unit
    if ratio := _RATIO.search(column.name):
        of = ratio[1].casefold()
        text = f"{SUFFIX.get(of, of)}/{ratio[2].casefold()[: 3 if ratio[2][0] in 'mM' else 1]}"
        return text if is_unit(text) or is_counted(text) else None  # counts per sec are no time
    tail = re.split(r"[\s,;:/(]+|_(?=[a-zA-Z%µ/]+$)|_(?=[a-z]+_[a-z]+$)", named(column.name).name.strip())[-1]
    low = tail.casefold()
    if low == "rpm" or (tail != column.name and low in SUFFIX and (len(low) > 1 or tail == "A")):
        return SUFFIX[low]
    two = "_".join(column.name.casefold().split("_")[-2:])
    return SUFFIX.get(two) if two != column.name.casefold() else None


@cache
def _quantity_of(unit: str) -> str | None:
    """Return the quantity of a unit; ``other`` for a unit of no channel."""
    if unit in DRIVE_UNITS or unit.endswith(" %") or converts(unit, "force", "linear/A"):
        return "force"
    return next((of for of in OF_UNITS if any(converts(unit, of, motion) for motion in PLAIN)), "other")


def fits(column: Column, unit: str) -> bool:
    """Return whether a column may be in a unit by its name."""
    of = spoken(column).quantity
    return of not in OF_UNITS or any(converts(unit, of, motion) for motion in MOTIONS)


# --- units that fit together ------------------------------------------------------------------------------------------

USUAL: dict[Motion, tuple[dict[str, float], dict[str, float], float, float]]
USUAL = {motion: tuple(_LISTS["usual"][motion].values()) for motion in PLAIN}
TOLERANCE = 0.02  # Deviation of a factor from that of its units, from counts and noise
GEARED = log(1.5) / TOLERANCE
"""The same, relative to it, beyond which position and velocity in known units are of two sides of a gear."""
SIZE = log(12.0)  # Spread of usual travels and speeds
SMALL_CURRENT, LARGE_CURRENT = 5.0, 400.0
"""Currents of drives: below the first value it is in A, above the second in mA; % of the rated current between them."""
MOST_CURRENT = 1000.0  # What no drive of an axis gives: a header that says A is wrong [A]
SUPPLIES = (5.0, 6.0, 12.0, 24.0, 36.0, 48.0)  # Voltages that an output clips at [V]
CLIPPED = 0.003  # Share of samples at its largest size from which on an output clips there
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


@dataclass(frozen=True)
class Reading:
    """Units that a clock, a position and a velocity may have together, and how likely they are."""

    motion: Motion
    time: str
    position: str
    velocity: str
    weight: float


def time_units(step: float, rows: int) -> dict[str, float]:
    """Return the units that a clock may have by its steps: samplings from 20 µs to 0.2 s are usual."""
    found = {}
    for unit, size in TIME_UNITS.items():
        outside = max(log(2e-5 / dt), log(dt / 0.2), 0.0) if (dt := step * size) > 0 else 99.0
        long = max(log(max(dt * rows, 1e-12) / 2e4), log(0.3 / max(dt * rows, 1e-12)), 0.0)
        weight = exp(-1.5 * outside - 1.0 * long) * {"s": 0.5, "ms": 0.35, "us": 0.12, "ns": 0.03}[unit]
        if unit == "s" and step == 1.0:
            weight *= 0.3  # a count of rows, or milliseconds
        found[unit] = weight
    return found


@cache
def _candidates(unit: str | None, quantity: str) -> tuple[tuple[Motion, str, float, float], ...]:
    """Return motion, unit, its factor to SI and how usual it is: from the header, motion and unit alone."""
    found = []
    for motion, (positions, velocities, *_) in USUAL.items():
        usual = positions if quantity == "position" else velocities
        if unit:
            if converts(unit, quantity, motion):
                found.append((motion, unit, factor(unit, quantity, motion), 1.0))
        else:
            found += [(motion, text, factor(text, quantity, motion), weight) for text, weight in usual.items()]
    return tuple(found)


def readings(
    first: Spoken, second: Spoken, time: str, ratio: float | None,
    sizes: tuple[float | None, float | None] = (None, None), with_position: bool = True, with_velocity: bool = True,
) -> list[Reading]:  # fmt: skip
    """Return the units that position, velocity and clock may have.

    first, second: What is stated of the position and of the velocity.
    time: Unit of the clock; empty where it is not known, and then any of `TIME_UNITS`.
    ratio: Velocity per slope of the position, as logged; None where there is no such pair.
    sizes: Travel and speed, as logged.
    """
    nothing = tuple((motion, "", 1.0, 1.0) for motion in PLAIN)
    positions = _candidates(first.unit, "position") if with_position else nothing
    velocities = _candidates(second.unit, "velocity") if with_velocity else nothing
    clocks = {time: factor(time, "time")} if time else TIME_UNITS
    found = []
    for p, v, (unit, second_of) in product(positions, velocities, clocks.items()):
        if p[0] != v[0]:
            continue
        weight = p[3] * v[3] * _size(p[0], p[2], sizes[0], 2) * _size(v[0], v[2], sizes[1], 3)
        weight *= max(first.moves.get(p[0], 1.0), second.moves.get(p[0], 1.0))
        if ratio is not None:
            off = log(abs(ratio) / (p[2] / (second_of * v[2]))) / TOLERANCE
            if abs(off) > (2.0 if not (first.unit and second.unit and time) else GEARED):
                continue
            weight *= exp(-0.5 * max(min(abs(off), 2.0) - 0.5, 0.0) ** 2)
            weight *= 3.0 if _family(p[1]) == _family(v[1]) else 1.0
        found.append(Reading(p[0], unit, p[1], v[1], weight))
    return found


def contradicting(
    first: Spoken, second: Spoken, time: str, ratio: float, sizes: tuple[float | None, float | None] = (None, None)
) -> list[Reading]:
    """Return what position and velocity may be in where the unit of one of them is stated wrongly.

    The other one is then in a usual unit, as mm for m. Of angles, a factor that is a whole number is that of a gear.
    """
    stated = product(_candidates(first.unit, "position"), _candidates(second.unit, "velocity"))
    off = {p[0]: abs(ratio) * factor(time, "time") * v[2] / p[2] for p, v in stated if p[0] == v[0]}
    gear = max(off.get("rotary", 0.5), 1.0 / off.get("rotary", 0.5))
    if not off or ("rotary" in off and abs(gear - round(gear)) < TOLERANCE * gear):
        return []
    free = first._replace(unit=None), second._replace(unit=None)
    return [*readings(free[0], second, time, ratio, sizes), *readings(first, free[1], time, ratio, sizes)]


def _family(unit: str) -> str:
    return {"rpm": "rev"}.get(unit, unit.split("/")[0])


def _size(motion: Motion, si: float, logged: float | None, column: int) -> float:
    """Return how usual a travel or a speed of this size is."""
    return exp(-0.5 * (log(logged * si / USUAL[motion][2:][column - 2]) / SIZE) ** 2) if logged else 1.0


def usual_units(channel: str, says: Spoken, motion: str, values: Real) -> tuple[str, float, tuple[str, ...]]:
    """Return the unit of a force or an input, how sure it is, and what else it may be."""
    size = float(np.quantile(np.abs(values), 0.98)) if len(values) else 0.0
    if says.unit == "A" and size > MOST_CURRENT:
        return "mA", 0.8, ("A",)
    if says.unit:
        return says.unit, 1.0, ()
    newtons = "N*m" if motion == "rotary" else "N"
    whole = bool(np.all(np.rint(values) == values))  # amperes have decimals, milliamperes and counts need none
    if says.means == "current":
        if size < SMALL_CURRENT or size > LARGE_CURRENT:
            return ("A", 0.96, ("%",)) if size < SMALL_CURRENT else ("mA", 0.8 if whole else 0.96, ("count", "A"))
        return ("mA", 0.6, ("A", "%")) if whole and size > 20.0 else ("A", 0.7, ("%", "mA"))
    if whole and size > (20.0 if says.means in {"force", ""} else 100.0):
        return "count", 0.6, ("0.1 %", newtons, "A")  # the step of a converter, or of CiA 402
    if says.means == "input":
        beside = channel == "input" and size <= max(
            SUPPLIES
        )  # a force, it is in the unit of its gains, whatever that is
        return "V", 0.96 if beside else 0.8, ("%", "count")
    if says.means in {"force", "load"}:
        return (newtons, 0.6, ("A", "%")) if says.means == "force" else ("%", 0.7, ("A", newtons))
    top = np.abs(values).max(initial=0.0)
    if says.means == "duty" or np.mean(np.abs(values) > 0.999 * top) > CLIPPED:
        if np.any(np.isclose(top, SUPPLIES, rtol=1e-3)):
            return "V", 0.7, ("%", "count")
        if says.means == "duty" or np.any(np.isclose(top, (1.0, 100.0), rtol=1e-3)):
            return ("100 %" if top < 1.5 else "%" if top < 110.0 else "count"), 0.7, ("count", "V")
    return "count", 0.4, ("A", newtons, "V", "%")
