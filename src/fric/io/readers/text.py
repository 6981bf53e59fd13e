"""Text logs: CSV, TSV, with any delimiter, decimal mark, preamble and encoding; also ``.gz``."""

import csv
import gzip
import io
import re
import zlib
from collections import deque
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, lru_cache, partial
from itertools import chain, islice, pairwise, repeat
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
import pandas as pd

from fric.arrays import Indices, Real
from fric.documents.mapping import Layout
from fric.errors import FricError, printable
from fric.flaws.files import LINE_CUT
from fric.input import foreign, other_kind
from fric.io.readers.base import (
    RECORD,
    Column,
    ForeignTable,
    Format,
    Memory,
    RowBlock,
    begins_again,
    named,
    number,
    whole_stamps,
)
from fric.io.readers.joined import GAP
from fric.io.words import fits, in_counts, spoken
from fric.units import is_unit

MINUS = "\N{MINUS SIGN}"  # As it is typeset, and as some tables are exported
SNIFFED = 300  # Lines from which delimiter and decimal mark are determined
DELIMITERS = (";", "\t", ",", "|", "whitespace")
_NUMBER = {
    ".": re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf(?:inity)?)", re.IGNORECASE),
    ",": re.compile(r"[+-]?(?:\d+(?:,\d+)?|,\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf(?:inity)?)", re.IGNORECASE),
}
_GROUPS = {".": r"[,'’\s]", ",": r"[.'’\s]"}  # Marks between groups of three digits, by the mark of the fraction
_GROUPED = {
    mark: rf"[+-]?\d{{1,3}}(?:({of})\d{{3}}(?:\1\d{{3}})*\{mark}\d+|({of})\d{{3}}(?:\2\d{{3}})+|['’\s]\d{{3}})"
    for mark, of in _GROUPS.items()
}
"""Numbers with them that have no other reading: 1,234 alone may have a fraction."""
_KANJI = re.compile(rb"[\x81-\x9f][\x40-\xfc]")
"""Pairs of bytes of Japanese text, whose first are control characters in Latin-1."""
_SPACED = re.compile(r'"[^"]*"|[^\s\[(]\S*(?:\s*\[[^\]]*\]|\s*\([^)]*\))?|\S+')
"""A cell between spaces; a unit in brackets belongs to the name before it."""
_DATA = re.compile(rb"""\s*["']?[-+.,]?\d""")  # Begins a line of samples
_NUMBER_OF = re.compile(r"(?i)(\b|_)(id|joint|motor|axis|node|servo|channel|achse|gelenk)(\b|_|$)")
"""The name of a column that says of which motor a row is."""
_NUMBERED = re.compile(r"[#%\s]*((?:[A-Za-z][A-Za-z _]*?)?)[ _]?(\d{1,3})\s*[=:]\s*(\S.*)")
_BY_NUMBERS = re.compile(
    r"(?i)[#%;/\s]*[#%;/]\s*(?:col(?:umn)?s?\.?\s*)?(\d{1,3}(?:(?:\s*(?:\.\.+|,|-|to)\s*|\s+)\d{1,3})*)[\s:.)=-]+([^\W\d].*)"
)
"""A line above the data that says what numbered columns are, as ``%  5  6 Drive current left, right [A]: 0.1 0.0``."""
_SIMPLEFOC = ("target", "voltage q [V]", "d axis voltage [V]", "current q [mA]", "d axis current [mA]",
              "velocity [rad/s]", "angle [rad]")  # fmt: skip
"""What the monitor of SimpleFOC prints where all of it is chosen, below lines that begin with ``MOT:``."""
OF_UNITS = re.compile(r"unit|einheit|unidad", re.IGNORECASE)  # Begins a line above the header that names units


@dataclass(frozen=True)
class Shape:
    """How a text is written: the reading of its data, and the lines above them."""

    encoding: str  # encoding, delimiter, decimal: as in a mapping's ``format``
    delimiter: str
    decimal: str
    first: int  # Lines before the first line of data
    columns: tuple[Column, ...]  # Names and units
    preamble: dict[str, str]  # Values named in the lines above the header, as in ``Sampling period:;51.200``
    spaced: bool  # Whether there are spaces behind delimiters


def encoding_of(head: bytes) -> str:
    """Return the encoding: by its mark, else UTF-8 or Japanese where that fits, else Latin-1."""
    for mark, encoding in ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16")):
        if head.startswith(mark):
            return encoding
    whole = head[: head.rfind(b"\n") + 1 or len(head)]
    for encoding, pairs in (("utf-8", 0), ("cp932", len(_KANJI.findall(whole)))):
        with suppress(UnicodeDecodeError):
            whole.decode(encoding)
            if encoding == "utf-8" or pairs > 3:
                return encoding
    return "latin-1"


def split(line: str, delimiter: str) -> list[str]:
    """Split a line into cells, without quotes and spaces around them."""
    if delimiter == "whitespace":
        cells = _SPACED.findall(line.lstrip("#% \t"))
    else:
        cells = line.split(delimiter)
        if '"' in line:
            with suppress(csv.Error):  # a cell longer than any real cell is not quoted
                cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    return [cell.strip(" \t;").strip('"').strip() for cell in cells]  # lines may end in ; whatever delimits their cells


def is_number(cell: str, decimal: str) -> bool:
    """Return whether a cell is a number."""
    return _NUMBER[decimal].fullmatch(cell) is not None


class _Row(NamedTuple):
    cells: list[str]
    numeric: list[bool]

    @property
    def score(self) -> int:
        """Numbers count for the reading, words against it; empty cells, dates and times of a day do not count."""
        rest = (cell for cell, number in zip(self.cells, self.numeric, strict=True) if cell and not number)
        return sum(self.numeric) - sum(not _STAMP.match(cell) for cell in rest)


@lru_cache(maxsize=64)
def shape_of(head: bytes, layout: Layout, whole: bool) -> Shape:
    """Find how a text log is written from its beginning, once for each: a log is looked at before it is read.

    head: The first bytes of the file, uncompressed.
    layout: What the user states; it is used unchanged.
    whole: Whether ``head`` is the whole file.
    """
    encoding = layout.encoding or encoding_of(head)
    try:
        lines = re.split(r"\r\n|\n|\r", head.decode(encoding, errors="replace").replace(MINUS, "-"))
    except LookupError:
        raise FricError(f"'{encoding}' is not an encoding", hint="Say utf-8, latin-1 or utf-16.") from None
    if not whole or not lines[-1]:
        lines.pop()  # cut in the middle, or the text behind the last line's end
    start = layout.skip
    if layout.data_after is not None:
        if not (ends := [n for n, line in enumerate(lines) if n >= start and line.startswith(layout.data_after)]):
            raise FricError(f"no line starts with '{layout.data_after}'",
                            hint="Mend `data_after` in the mapping, or leave it out.")  # fmt: skip
        start = ends[0] + 1
    start = max(start, layout.header or 0, layout.units or 0)
    delimiter, decimal, rows = _reading(lines[start:], layout)
    leading = (n for n, row in enumerate(rows) if row.cells)
    first = start + (_data_start(rows) if layout.data_after is None else next(leading))
    width = len(rows[first - start].cells)
    spare = not any(any(row.cells[-1:]) for row in rows[first - start :])
    table = [_heads(re.sub(r"^[#%]+\s*(?=[\[(\w])", "", line), delimiter, width) for line in lines[:first]]
    names, units = _header(table, width, decimal, layout, spare)
    if names is not None:
        for n in range(max(names, -1 if units is None else units) + 1, first):  # samples are below the names
            if sum(is_number(cell, decimal) for cell in table[n]) >= width:
                what = f"line {n + 1} has more cells than the {width} of the header"
                raise FricError(what, hint="Mend or remove the line.")
    cells = (
        _labelled(table, names)
        if names is not None
        else _unnamed([row.cells for row in rows[first - start :] if row.cells])
    )
    if names is None and width == len(_SIMPLEFOC) and any(line.startswith("MOT:") for line in lines[:first]):
        cells = list(_SIMPLEFOC)
    cells = (layout.header is None and _listed(lines[:first], width)) or cells
    cells = [cell or f"column {n}" for n, cell in enumerate((cells + [""] * width)[:width])]
    columns = [named(cell) for cell in cells]
    if units is not None:
        given = (table[units] + [""] * width)[:width]
        if OF_UNITS.fullmatch(given[0].strip(" :")):  # the first cells of such lines say what is in the others
            given[0], columns[0] = "", columns[0] if spoken(columns[0]).quantity == "time" else Column("column 0")
        bare = [_unit(unit.strip("[]()").strip()) or unit.strip("[]()# ") or None for unit in given]
        both = zip(columns, bare, strict=True)
        columns = [Column(c.name, c.unit if _unit(c.unit or "") else unit or c.unit) for c, unit in both]
    sample = [*rows[first - start].cells, *[""] * width]
    columns = [Column(c.name, c.unit or _unit_in(cell) or None) for c, cell in zip(columns, sample, strict=False)]
    top = min(n for n in (names, units, first) if n is not None)
    if spare and columns[-1].name.startswith("column "):
        columns.pop()  # a delimiter at the end of each line makes no column
    spaced = any(delimiter + " " in line for line in lines[first:])
    about = _preamble(lines[:top], delimiter)
    columns = _in_units(columns, lines[: first if names is None else names], about, delimiter)
    by_column = zip(*(row.cells[:width] for row in rows[first - start :] if len(row.cells) >= width), strict=True)
    counted = {n for n, of in enumerate(by_column) if all(re.fullmatch(r"[-+]?\d+", cell) for cell in of)}
    columns = remarked(columns, lines[:first], counted)
    titles = [named(about.get(column.name, "")) for column in columns]  # as in ``CH1: Feedback Position [PUU]``
    if sum(spoken(title).quantity is not None for title in titles) > 1:
        columns = [Column(title.name or c.name, c.unit or title.unit) for title, c in zip(titles, columns, strict=True)]
    return Shape(encoding, delimiter, decimal, first, tuple(columns), about, spaced)


def _in_units(columns: list[Column], above: Sequence[str], about: dict[str, str], delimiter: str) -> list[Column]:
    """Return columns with the units that lines above them name, as ``Y_Unit_Label;mm;N`` or ``units: Radians``."""
    for line in above:
        of_time = line.lower().startswith("horizontal")  # which an oscilloscope has in S
        label, *cells = split(line.lower() if of_time else line, delimiter) or [""]
        if OF_UNITS.search(label):
            said = zip(columns[1 - of_time :], [*cells, *[""] * len(columns)], strict=False)
            columns[1 - of_time :] = [
                Column(c.name, c.unit or (cell if cell and _unit(cell) and fits(c, cell) else None)) for c, cell in said
            ]
    words = " ".join(value for name, value in about.items() if OF_UNITS.search(name))
    for unit in filter(None, map(_unit, re.findall(r"[^,;\s]+", words))):
        columns = [Column(c.name, c.unit or (unit if spoken(c).quantity and fits(c, unit) else None)) for c in columns]
    return columns


def remarked(columns: Sequence[Column], lines: Sequence[str], whole: Collection[int]) -> list[Column]:
    """Return columns with their units, also those that comments give by their names: ``# 1 count = 0.1 um, dac: V``.

    whole: The columns of whole numbers, which a position without unit has in counts.
    """
    said = ", ".join(line for line in lines if line.startswith(("#", "%", ";", "//")))
    pairs = re.findall(r"(\w[\w .]{0,39}?)(?:\s?[:=]| (?:in|en|em)(?= ))\s*(\d[\d.]* ?[^\W\d]+|[^\s,;]+)", said)
    sizes, lack = re.compile(r"(1 ?)?(count|inc|increment|pulse)s?"), {c.name.casefold() for c in columns if not c.unit}
    folded = ((name.casefold(), unit) for name, unit in pairs)
    units = {name: unit for name, unit in folded if (name in lack or sizes.fullmatch(name)) and _unit(unit)}
    each = next((unit for name, unit in units.items() if sizes.fullmatch(name)), None)
    per = re.search(
        r"(?i)\b(?:count|inc|increment|pulse)s?[ _]?(?:per|/)[ _]?([^\W\d]+)\s?[:=]\s*(\d{1,9}(?:\.\d{1,9})?)", said
    )
    each = f"{1.0 / float(per[2]):.9g} {per[1]}" if per and not each and _unit(per[1]) and float(per[2]) > 0 else each
    counted = {
        n for n, c in enumerate(columns)
        if each and not c.unit and (in_counts(c) or (n in whole and spoken(c).quantity == "position"))
    }  # fmt: skip
    own = (units.get(c.name.casefold(), each if n in counted else None) for n, c in enumerate(columns))
    both = zip(columns, own, strict=True)
    return [Column(c.name, c.unit or (unit if unit and fits(c, unit) else None)) for c, unit in both]


def _unnamed(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return names of columns without names, by their number; of stamps of ROS 2 they are seconds and nanoseconds."""
    stamps = [tuple(int(cell) if re.fullmatch(r"\d{1,10}", cell) else 0 for cell in row[:2]) for row in rows]
    of_ros = all(len(stamp) == 2 and 1e9 < stamp[0] < 2.5e9 and stamp[1] < 1e9 for stamp in stamps)
    of_ros = of_ros and max(stamp[1] for stamp in stamps) > 1e6 and stamps == sorted(stamps)
    return [*["sec", "nanosec"] * bool(of_ros), *(f"column {n}" for n in range(2 * bool(of_ros), len(rows[0])))]


def _listed(lines: Sequence[str], width: int) -> list[str] | None:
    """Return names that stand on a numbered line each, as in ``# NAME0 = Target Position``, with units; or None."""
    groups: dict[str, list[tuple[int, str]]] = {}
    for line in lines:
        if found := _NUMBERED.fullmatch(line):
            groups.setdefault(found[1], []).append((int(found[2]), found[3].strip()))
    whole = {
        group: [name for _, name in names] for group, names in groups.items()
        if [n for n, _ in names] in ([*range(width)], [*range(1, width + 1)])
    }  # fmt: skip
    units = next((whole.pop(group) for group in [*whole] if OF_UNITS.search(group)), [])
    names = next((names for names in whole.values() if any(re.match("[^\\W\\d]", name) for name in names)), None)
    if names is None:
        return _by_numbers(lines, width)
    return [f"{name} [{unit}]" for name, unit in zip(names, units, strict=True)] if units else names


def _by_numbers(lines: Sequence[str], width: int) -> list[str] | None:
    """Return the names that comments give to each of the numbered columns, counted from 0 or 1; or None."""
    found: dict[int, str] = {}
    for said in filter(None, map(_BY_NUMBERS.fullmatch, lines)):
        numbers = re.findall(r"\d+|\.\.|-|to", said[1])
        ends = [int(text) for text in numbers if text.isdigit()]
        columns = [*range(ends[0], ends[-1] + 1)] if len(ends) == 2 and len(numbers) > 2 else ends
        text = re.sub(r"(?<=\s)[-+(]*\d[\d.,e+-]*\)?(?=\s|$)", "", re.split(r":(?=\s|$)", said[2])[0])  # an example
        unit = re.search(r"\[([^\]]*)\]", text)
        plain = " ".join(re.sub(r"\[[^\]]*\]", " ", text).split())
        head, _, last = plain.partition(",")[0].rpartition(" ")
        each, units = [last, *plain.split(",")[1:]], unit[1].split(",") if unit else [""]
        for k, column in enumerate(columns):
            name = f"{head} {each[k].strip()}" if len(each) == len(columns) else f"{plain} {column}"
            of = units[k % len(units)].strip()
            found[column] = f"{name.strip()} [{of}]" if of else name.strip()
    whole = [*range(start := min(found, default=0), start + width)]
    return [found[n] for n in whole] if start < 2 and sorted(found) == whole else None


def _heads(line: str, delimiter: str, width: int) -> list[str]:
    """Split a line above the data; between spaces, names of several words are separated by two spaces or more."""
    cells = split(line, delimiter)
    if delimiter == "whitespace" and len(cells) != width:
        apart, pins = re.split(r"\s{2,}|\t", line.strip("#% \t")), line.rpartition(": ")[2].split()
        if ": " in line and all(re.fullmatch(r"[A-Za-z]\w*[.-][\w.-]*", pin) for pin in pins):  # as what sampled says
            apart = ["sample", *pins] if len(pins) == width - 1 else pins
        return apart if len(apart) == width else cells
    return cells


def _reading(lines: list[str], layout: Layout) -> tuple[str, str, list[_Row]]:
    """Return delimiter, decimal mark and rows of the reading that makes most numbers of the lines."""
    if not any(line.strip() for line in lines):
        raise FricError("there is a header and no data", hint="Export the log again, with its samples.")
    best: tuple[int, int, str, str] = (0, 0, "", "")
    sniffed = lines[-SNIFFED:]  # the preamble is above
    text = "".join(sniffed)
    lacking = [mark for mark in DELIMITERS[:-1] if mark not in text]  # each reads a line as a single cell
    for delimiter in [layout.delimiter] if layout.delimiter else [d for d in DELIMITERS if d not in lacking[1:]]:
        for decimal in [layout.decimal] if layout.decimal else [".", ","] if "," in text else ["."]:
            if decimal == delimiter and '"' not in text:  # "1,5","2,5" has its commas in quotes
                continue
            scores: dict[int, int] = {}
            for line in sniffed:
                row = _row(line, delimiter, decimal, layout.comment)
                scores[len(row.cells)] = scores.get(len(row.cells), 0) + max(row.score, 0)
            width = max(scores, key=lambda n: (scores[n], n))
            if scores[width] and (scores[width], width) > best[:2]:
                best = scores[width], width, delimiter, decimal
    _, width, delimiter, decimal = best
    if not width:
        hint = "A header alone is not a log; if there are data, say in a mapping how they are written (`format:`)."
        raise FricError("there are no rows of numbers", hint=hint)
    rows = [_row(line, delimiter, decimal, layout.comment) for line in lines]
    rows = [_Row(row.cells[:width], row.numeric[:width]) if not any(row.cells[width:]) else row for row in rows]
    return delimiter, decimal, [row if len(row.cells) == width else _Row([], []) for row in rows]


def _row(line: str, delimiter: str, decimal: str, comment: str | None) -> _Row:
    cells = split(line.partition(comment)[0] if comment else line, delimiter)
    return _Row(cells, [is_number(cell.removesuffix(_unit_in(cell)).rstrip(), decimal) for cell in cells])


def _data_start(rows: list[_Row]) -> int:
    """Return the first row of data: numbers where most rows have them; a word in it is a bad cell, not a header."""
    known = [[n or bool(_STAMP.match(c)) for c, n in zip(*row, strict=True)] for row in rows]
    good = [n for n, row in enumerate(rows) if row.score > 0]
    wanted = [2 * sum(column) > len(good) for column in zip(*(known[n] for n in good), strict=True)]
    wanted[0] |= 2 * sum(not rows[n].cells[0] for n in good) > len(good)  # a label, where samples have an empty cell
    cells = {n: zip(rows[n].cells, known[n], wanted, strict=True) for n in good}
    whole = (n for n in good if all(k or not (w and cell) for cell, k, w in cells[n]))
    first = next(whole, next(n for n, row in enumerate(rows) if row.cells))
    above = first
    while above and rows[above - 1].cells and any(rows[above - 1].numeric):
        above -= 1
    return above if above and rows[above - 1].cells else first


def _header(
    table: list[list[str]], width: int, decimal: str, layout: Layout, spare: bool
) -> tuple[int | None, int | None]:
    """Return the lines of names and of units above the data, counted from 0."""
    names = None if not layout.header else layout.header - 1
    units = None if not layout.units else layout.units - 1
    above = [
        n for n in range(layout.skip, len(table))
        if (len(table[n]) in {width, width - spare} or (len(table[n]) == width + 1 and table[n][-1] in {"", "Comment"}))
        and sum(map(bool, table[n])) * 2 >= width
        and not any(is_number(cell, decimal) for cell in table[n])
        and n not in {names, units}
    ]  # fmt: skip
    if units is None and layout.units is None and above and (names is not None or len(above) > 1):
        cells = [cell.strip("[]()").strip() for cell in table[above[-1]]]
        labelled = bool(OF_UNITS.fullmatch(cells[0].strip(" :")))  # as in ``Unit,min-1,%,pulse``
        if any(map(_unit, cells)) and (labelled or all(cell in {"", "-", "#"} or _unit(cell) for cell in cells)):
            units = above.pop()
    if names is None and layout.header is None and above:
        names = above[-1]
        over = table[names - 1] if names else []  # the names of channels may be numbers, as in ``x-axis,1,2``
        if units is None and len(over) == width and any(over) and all(map(_unit, table[names])):
            names, units = names - 1, names
    return names, units


def _labelled(table: list[list[str]], names: int) -> list[str]:
    """Return the names of columns; of ``Axis,X,X`` below ``Kind,Command,Volt`` each of the second behind its axis."""
    cells, above = table[names], table[max(names - 3, 0) : names]
    if len({*cells[1:]}) == len(cells) - 1:
        return cells
    for row in reversed([row for row in above if len(row) == len(cells)]):
        both = [" ".join(pair) for pair in zip(cells, row, strict=True)]
        if len({*both}) == len(both) and any(spoken(named(cell)).quantity for cell in row[1:]):
            return both
    return cells


def _unit_in(cell: str) -> str:
    """Return the unit behind the number of a cell, as in ``12.5 mm``; a duration has none, it is taken in seconds."""
    found = _QUANTITY.fullmatch(cell)
    return found[1] if found and _unit(found[1]) and not _STAMP.match(cell) else ""


@cache
def _unit(cell: str) -> str:
    """Return the unit of a cell, a written-out unit in small letters; empty where it has none."""
    spellings = (cell, cell.lower()) if len(cell) > 2 else (cell,)  # Volt, but not MS
    return next((text for text in spellings if is_unit(text)), "") if len(cell) < 16 else ""


def _preamble(lines: list[str], delimiter: str) -> dict[str, str]:
    """Return the named values above the header, as in ``Sampling period:;51.200`` or ``# load: 3 kg``."""
    found: dict[str, str] = {}
    for line in lines:
        head, mark, rest = line.partition(delimiter if delimiter != "whitespace" else ":")
        if not mark or (":" in head.rstrip(" :") and delimiter != "whitespace"):
            head, mark, rest = line.partition(":" if ":" in line else "=")
        if not mark and (said := re.fullmatch(r"(\W+[^\W\d].*?)\s+(\d\S*\s*[^\W\d]+)\s*", line)):
            head, rest = said.groups()  # ; sample time 250 us
        name = head.strip(" \t:;#%\"'=")
        value, *more = [rest.strip().strip("\"'")] if delimiter == "whitespace" else split(rest, delimiter) or [""]
        if name and value and name not in found:
            found |= {f"{name} [{more[0]}]": f"{value} {more[0]}"} if more and _unit(more[0]) else {}  # Cycle;2;ms
            found[name] = value
    return found


THREADS = 2  # Pieces that are parsed at once
PIECE = 2 << 20  # Bytes that are parsed at a time
AHEAD = 4  # Pieces that may wait, parsed or not
LOOK = 32_768  # Bytes at the beginning that are read to find how the file is written
MOST_PACKED, SMALL = 200, 64 << 20
"""Bytes that a packed byte of text becomes at most, and bytes that any packed file may hold."""
MOST_LINE = 2 << 20  # Bytes of a line at most
MOST_EMPTY = 256  # Empty cells behind those of the header that a row may have
MOST_TURNS = 16  # Words that may take turns from row to row
_LIST = re.compile(rb'"?[\[(]\s*([^\[\]()"]*[^\[\]()"\s,;][\s,;]+[^\[\]()"]*)[\])]"?')
"""A cell with two items or more in brackets."""
_ITEMS = re.compile(rb"[\s,;]+")
MOTION = {"position", "velocity", "force", "input"}
HELD, LEAST_ROWS = 0.1, 31
"""How often, relative to the most frequent, a column is written that is held; rows by which empty cells are known."""
MOST_STATES = 64  # Words of a column of states at most: others are no state

_REMARK = re.compile(rb"(?m)^#.*\n?")  # A line between rows that is none
_WORDS = re.compile(rb"(?im)^(?=[^\d\n]*(?:\n|\Z))(?!.*(?:nan|inf))(?=.*[a-z]).*\n?")  # Another, as ``done`` at the end
_TRAILER = re.compile(rb"(?i)\s*(?!nan|inf)[a-z]{2}")  # ``End of record   8800 samples``
_DATE = re.compile(r"\d{1,4}[-/.]\d{1,2}[-/.]\d")
_STAMP = re.compile(rf"{_DATE.pattern}|\d+:\d\d|\d+(\.\d+)?\s*(s|sec|ms|us|min|hr)\Z")
_QUANTITY = re.compile(r"[+-]?[\d.,]*\d(?:[eE][+-]?\d+)?\s*((?:1/)?[^\W\d_]\S*|[%°‰]\S*)")
_GZIP = b"\x1f\x8b"

FORMAT = Format("Text", (".csv", ".tsv", ".txt", ".dat", ".log", ".gz"))


def recognises(path: Path, head: bytes) -> float:
    """Text holds no zero byte, unless it is UTF-16; any other reader that knows the file is surer."""
    return 0.1 * (head.startswith((_GZIP, b"\xff\xfe", b"\xfe\xff")) or b"\0" not in head)


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read a text log: one table."""
    head, zipped = beginning(path)
    if (packed := None if zipped or layout != Layout() else _of_lists(path, head)) is not None:
        yield packed
        return
    table = TextTable(path, layout)
    if not zipped and layout == Layout() and (blocks := _of_blocks(table, layout)):
        yield from blocks
        return
    lines = head.decode(table.shape.encoding, "replace").splitlines()[table.shape.first : -1]
    rows = [split(line, table.shape.delimiter) for line in lines]
    labels = _in_turns(rows[:200], table.shape)
    topics = _of_topics(table) if labels is None and _has_gaps(rows, table.shape) else None
    if topics is not None:
        yield topics
        return
    yield from (_of_ids(table, rows) or [table]) if labels is None else [_beside_each_other(table, *labels)]


MOST_HELD = 1 << 28  # Size of a file that is held in memory for its records [byte]
MOST_LINES, MOST_BLOCKS = 4_000_000, 2000  # Lines, and blocks, of a text that is looked through for them at most
JUMP = 10.0  # Least jump of a clock between two records, over a step of either


def _of_blocks(table: "TextTable", layout: Layout) -> Sequence[ForeignTable]:
    """Return a table for each block of a text that repeats its header, where a column begins again below each.

    A block of other columns, as of a circle, is a table besides. Its name is what only it says above its header.
    """
    shape, path = table.shape, table.path
    if not 0 < path.stat().st_size <= MOST_HELD or not shape.first or shape.encoding.startswith("utf-16"):
        return []
    with path.open("rb") as file, mmap(file.fileno(), 0, access=ACCESS_READ) as whole:
        for _ in range(shape.first - 1):
            whole.readline()
        header = whole.readline()
        if not re.search(rb"[^\W\d]", header) or whole.find(b"\n" + header, whole.tell()) < 0:
            return []
        whole.seek(0)
        text = whole.read()
    if text.count(b"\n") > MOST_LINES:
        return []
    lines = text.splitlines(keepends=True)
    of_data = [_DATA.match(line) is not None for line in lines]
    begins = [n for n in range(1, len(lines)) if of_data[n - 1] and not of_data[n]]
    blocks = list[TextTable]()
    for first, last in pairwise([0, *begins, len(lines)] if len(begins) < MOST_BLOCKS else []):
        part = b"".join(lines[first:last])
        if not any(of_data[first:last]):
            continue
        try:
            found = shape_of(part[:LOOK], layout, whole=len(part) < LOOK)
        except FricError:  # lines that are no table
            return []
        if all(column.name.startswith("column ") for column in found.columns):  # a remark among the samples
            return []
        blocks.append(TextTable(path, layout, found, (first, part)))
    ends = [block.ends() for block in blocks if block.columns == table.columns]
    if not ends or not begins_again(ends):
        return []
    said = [block.shape.preamble for block in blocks]
    key = next((key for key in said[0] if len({about.get(key) for about in said}) == len(said)), "")
    for n, (block, about) in enumerate(zip(blocks, said, strict=True), 1):
        block.said |= {"name": about.get(key) or f"block {n}", RECORD: str(n)}
    return blocks


def _of_ids(table: "TextTable", rows: Sequence[Sequence[str]]) -> Sequence[ForeignTable]:
    """Return a table for each word, or number, of a column of ids: at each a clock or a count begins again, or jumps.

    The ids are the only column of words, or a column of whole numbers that holds each for many rows.
    """
    cells, decimal = [*zip(*rows, strict=False)], table.shape.decimal
    if table.path.stat().st_size > MOST_HELD:
        return []
    with table.path.open("rb") as file:
        file.seek(max(table.path.stat().st_size - LOOK, 0))
        end = file.read().decode(table.shape.encoding, "replace").rstrip().rpartition("\n")[2]
    last = [*split(end, table.shape.delimiter), *[""] * len(cells)]
    words = [n for n, of in enumerate(cells) if not any(not c or is_number(c, decimal) or _STAMP.match(c) for c in of)]
    ids = words or [n for n, of in enumerate(cells) if all(c.isdigit() for c in of)]
    ids = [n for n in ids if 3 * len({*cells[n]}) <= len(rows) and last[n] != cells[n][0]]  # else of a state
    called = {n: table.columns[n] for n in ids}
    ids = [n for n, of in called.items() if words or (of.name[:7] != "column " and spoken(of).quantity is None)]
    if not ids or len(words) > 1 or (words and cells[words[0]][0] in last):
        return []
    frame = pd.concat([frame for frame, _ in table.frames()], ignore_index=True)
    for k in ids:
        rest = [n for n in range(len(table.columns)) if n != k]
        values = [as_numbers(frame[n], decimal, table.columns[n].unit) for n in rest]
        if found := parted(table, frame[k].astype("str").str.strip(), [table.columns[n] for n in rest], values):
            return found
    return []


def parted(
    table: ForeignTable, named: pd.Series, columns: Sequence[Column], values: Sequence[Real]
) -> Sequence[ForeignTable]:
    """Return a table for each id of rows, where a clock or a count begins again, or jumps, at each; else none.

    named: The id of each row.
    columns, values: The other columns.
    """
    begins = np.flatnonzero(named != named.shift())
    clocks = [x for of, x in zip(columns, values, strict=True) if spoken(of).quantity == "time"] or values
    if not (1 < len(begins) == named.nunique() and any(_begins_again(x, begins[1:]) for x in clocks)):
        return []
    pieces = zip(named[begins], *(np.split(x, begins[1:]) for x in values), strict=True)
    return [Memory(table.path, columns, x, table.constants, {"name": of, RECORD: of}) for of, *x in pieces]


def _begins_again(x: Real, places: Indices) -> bool:
    """Return whether a column rises, but at these places alone: there it falls, or jumps by far more than elsewhere."""
    steps = np.diff(x)
    falls = np.flatnonzero(steps <= 0.0) + 1
    if len(falls):
        return np.array_equal(falls, places)
    usual = [float(np.median(piece)) for piece in np.split(steps, places - 1) if len(piece)]
    return len(usual) > len(places) and bool(
        all(steps[n - 1] > JUMP * max(pair) for n, pair in zip(places, pairwise(usual), strict=True))
    )


def _has_gaps(rows: Sequence[Sequence[str]], shape: Shape) -> bool:
    """Return whether a column behind the first, which is filled, is empty in many rows but not in all."""
    width = len(shape.columns)
    cells = [row[:width] for row in rows if len(row) >= width]
    filled = np.array([[bool(cell) for cell in row] for row in cells], bool).reshape(-1, width)
    share = filled.mean(axis=0) if len(filled) > LEAST_ROWS and shape.delimiter != "whitespace" else np.zeros(0)
    return bool(len(share) > 2 and share[0] == 1.0 and np.any((share[1:] > 0.0) & (share[1:] < 0.7)))


def _of_topics(table: ForeignTable) -> Memory | None:
    """Return a table of topics, which fill their cells in different rows, at the instants of the slowest of a motion.

    What is written less than a tenth as often, as a temperature, is held until it is written again. None where all
    but such columns are filled in the same rows.
    """
    every = range(len(table.columns))
    time, *rest = (np.concatenate(pieces) for pieces in zip(*(b.columns for b in table.read(every)), strict=True))
    groups: dict[bytes, list[int]] = {}
    for n, values in enumerate(rest):
        groups.setdefault(np.isfinite(values).tobytes(), []).append(n)
    filled = {tuple(members): np.flatnonzero(np.isfinite(rest[members[0]])) for members in groups.values()}
    most = max(map(len, filled.values()))
    fast = [members for members, rows in filled.items() if len(rows) > HELD * most]
    if len(fast) < 2 or not np.all(np.diff(time) >= 0.0):
        return None
    said = {members: [spoken(table.columns[n + 1]) for n in members] for members in fast}
    moved = [m for m in fast if any(of.quantity in MOTION and not of.commanded for of in said[m])]
    lead = filled[min(moved, key=lambda m: len(filled[m])) if moved else max(fast, key=lambda m: len(filled[m]))]
    at = time[lead]
    columns = [np.full(len(at), np.nan) for _ in rest]
    for members, rows in ((members, rows) for members, rows in filled.items() if len(rows) > 1):
        stamps, held = time[rows], members not in fast
        after = np.clip(np.searchsorted(stamps, at, "right"), 1, len(rows) - 1)
        between = (stamps[0] <= at) & (at <= stamps[-1])  # nor across a gap is anything interpolated
        between &= (stamps[after] - stamps[after - 1] < GAP * np.median(np.diff(stamps))) | np.isin(at, stamps)
        last = np.maximum(np.searchsorted(stamps, at, "right") - 1, 0)
        for n in members:
            values = rest[n][rows]
            columns[n] = values[last] if held else np.where(between, np.interp(at, stamps, values), np.nan)
    return Memory(table.path, table.columns, [at, *columns], table.constants)


def _of_lists(path: Path, head: bytes) -> Memory | None:
    """Return a table whose cells are lists, as ``"[0.1, 0.2]"`` of joints, a column an item; None of any other."""
    header, row = [*head.splitlines(), b"", b""][:2]
    counts = iter([len(_ITEMS.split(found[1].strip())) for found in _LIST.finditer(row)])
    bare = _LIST.sub(b"\1", row)
    mark = max((b",", b";", b"\t"), key=bare.count)
    heads, cells = header.decode("utf-8-sig", "replace").split(mark.decode()), bare.split(mark)
    if bare == row or b"\0" in row or len(heads) != len(cells):
        return None
    names = [
        f"{name.strip()}[{k}]" if b"\1" in cell else name
        for name, cell in zip(heads, cells, strict=True)
        for k in range(next(counts) if b"\1" in cell else 1)
    ]
    data = _LIST.sub(lambda found: _ITEMS.sub(mark, found[1].strip()), path.read_bytes().partition(b"\n")[2])
    with foreign(path, "Export it again."):
        frame = pd.read_csv(io.BytesIO(data), sep=mark.decode(), header=None, names=range(len(names)), index_col=False)
    return Memory(path, tuple(map(named, names)), [as_numbers(frame[n], ".") for n in range(len(names))])


def _in_turns(rows: Sequence[Sequence[str]], shape: Shape) -> tuple[int, list[str]] | None:
    """Return the column whose words take turns from row to row, as the names of joints do, and these; or None."""
    for n, words in enumerate(zip(*rows, strict=False)):
        labels = list(dict.fromkeys(words))
        turns = 1 < len(labels) <= MOST_TURNS and len(words) > 3 * len(labels)
        if any(is_number(label, shape.decimal) for label in labels):
            turns = turns and bool(_NUMBER_OF.search(shape.columns[n].name)) and all(map(str.isdigit, labels))
        if turns and all(word == labels[k % len(labels)] for k, word in enumerate(words)):
            return n, labels
    return None


def _beside_each_other(table: ForeignTable, column: int, labels: Sequence[str]) -> Memory:
    """Return a table in which rows of each label take turns as one with the columns of each label; the first's time."""
    rest = [n for n in range(len(table.columns)) if n != column]
    parts = [np.concatenate(pieces) for pieces in zip(*(block.columns for block in table.read(rest)), strict=True)]
    whole, columns, values = len(parts[0]) // len(labels) * len(labels), list[Column](), list[Real]()
    for at, part in zip((table.columns[n] for n in rest), parts, strict=True):
        turns = part[:whole].reshape(-1, len(labels))
        same = len(turns) > 1 and np.ptp(turns, axis=1).max() <= np.median(np.abs(np.diff(turns[:, 0])))
        rises = bool(np.all(np.diff(turns[:, 0]) > 0.0))
        for k in range(1 if same and rises else len(labels)):
            n = labels[k] if labels[k].isdigit() else k
            columns.append(at if same and rises else Column(f"{at.name}[{n}]", at.unit))
            values.append(turns[:, k])
    names = {f"{table.columns[column].name}[{k}]": label for k, label in enumerate(labels)}
    return Memory(table.path, tuple(columns), values, table.constants | names)


def beginning(path: Path) -> tuple[bytes, bool]:
    """Return the first bytes of a text, unpacked, and whether it is packed by gzip."""
    with path.open("rb") as raw:
        zipped = raw.read(2) == _GZIP
    try:
        with _opened(path, zipped) as file:
            return file.read(LOOK), zipped
    except (OSError, EOFError, zlib.error) as error:
        raise FricError(f"cannot be read: {error}", where=str(path), hint="Is the .gz file whole?") from None


def shaped(path: Path, head: bytes, layout: Layout) -> Shape:
    """Return how a text is written, by its first bytes."""
    if not head.strip():
        raise FricError("the file is empty", hint="Export the log again.")
    if beside := re.search(rb"#BEGINCHANNELHEADER.*?\n211,([^\r\n]+)", head, re.DOTALL):
        what = f"has the names of channels, and their samples are in {printable(beside[1].decode('latin-1'))}"
        raise FricError(f"{what}: export the trace as text (CSV)", hint="DIAdem does, and the viewer of the robot.")
    try:
        return shape_of(head, layout, whole=len(head) < LOOK)
    except FricError:
        if stated := re.match(rb"(?:\s*#[^\n]*\n)*\s*fric:\s*(\w+)/", head):
            raise other_kind(path, stated[1].decode(), "log") from None
        raise


class _Piece:
    """Bytes as pandas' C parser takes them: a BytesIO it would have decoded, only to encode the text again."""

    def __init__(self, whole: bytes) -> None:
        self._left = memoryview(whole)

    def read(self, size: int) -> bytes:
        """Return the next bytes, ``size`` of them at most, and none at the end."""
        taken, self._left = self._left[:size], self._left[size:]
        return bytes(taken)

    def __iter__(self) -> Iterator[int]:  # without which it is no file to pandas
        return iter(self._left)


class TextTable(ForeignTable):
    """The table of a text log, which is written as ``shape``; by default as its beginning shows.

    part: A block of the text that it is of, behind the number of lines above the block.
    """

    def __init__(
        self, path: Path, layout: Layout, shape: Shape | None = None, part: tuple[int, bytes] | None = None
    ) -> None:
        head, self._zipped = beginning(path)
        self.shape, self._part = shape or shaped(path, head, layout), part
        super().__init__(path, self.shape.columns, self.shape.preamble)
        self._comment, self._ragged = layout.comment, False

    def blocks(self, wanted: Sequence[int]) -> Iterator[RowBlock]:
        """Read the wanted columns as numbers."""
        row = 0
        for frame, size in self.frames():
            yield RowBlock(row, whole_stamps(self.columns, partial(self._numbers, frame), wanted), size)
            row += len(frame)

    def _numbers(self, frame: pd.DataFrame, n: int) -> Real:
        if n == self.states:
            return self._states(frame[n])
        return as_numbers(frame[n], self.shape.decimal, self.columns[n].unit)

    def frames(self) -> Iterator[tuple[pd.DataFrame, int]]:
        """Read the file piece by piece through pandas; the next pieces are parsed while a piece is processed."""
        row = 0
        waiting: deque[tuple[int, Future[pd.DataFrame]]] = deque()
        with ThreadPoolExecutor(THREADS, thread_name_prefix="parse") as threads:
            for piece in chain(self._pieces(), repeat(None, AHEAD)):
                if piece:
                    waiting.append((len(piece), threads.submit(self._parsed, piece)))
                if waiting and (piece is None or len(waiting) == AHEAD):
                    size, parsed = waiting.popleft()
                    yield (frame := self._frame(parsed, row)), size
                    row += len(frame)

    def _states(self, column: "pd.Series[Any]") -> Real:
        """Return a column of states as numbers, words by their order of appearance."""
        if pd.api.types.is_numeric_dtype(column) and not self.labels:  # truth values, too
            return column.to_numpy(dtype="f8", na_value=np.nan)
        words = column.astype("str").str.strip()
        self.labels = tuple(dict.fromkeys([*self.labels, *words.dropna().unique()]))[:MOST_STATES]
        return words.map({word: float(n) for n, word in enumerate(self.labels)}).to_numpy(dtype="f8", na_value=np.nan)

    def _pieces(self) -> Iterator[bytes]:
        """Cut the data into pieces of whole lines, in an encoding in which a digit is a byte."""
        wide, held, last = "\0".encode(self.shape.encoding) != b"\0", b"", b""
        try:
            with self._opened(self.shape.encoding if wide else None) as file:
                for _ in range(self.shape.first):
                    file.readline()
                read_so_far = 0
                while read := file.read(PIECE):
                    content = read.encode() if wide else read
                    end = content.rfind(b"\n") + 1
                    read_so_far += len(content)
                    self._refuse_bomb(read_so_far, len(content) if end else len(last) + len(content))
                    if end and held:
                        yield held
                    held = last + content[:end] if end else held
                    last = content[end:] if end else last + content
        except (OSError, EOFError, zlib.error, UnicodeError) as error:
            raise FricError(f"is damaged: {error}", where=str(self.path), hint="Copy the file again.") from None
        if not last:  # the last line may be none
            end = held.rfind(b"\n", 0, -1) + 1
            held, last = held[:end], held[end:]
        cells = last.split() if self.shape.delimiter == "whitespace" else last.split(self.shape.delimiter.encode())
        trails = _TRAILER.match(last) and len(cells) != len(self.columns)
        # a line without an end and with fewer cells: there the log stopped
        cut = last.strip() and not last.startswith(b"#") and len(cells) < len(self.columns) and b"\r" not in last
        if cut and not (trails or last.endswith(b"\n")):
            self.notices = [LINE_CUT.found(str(self.path))]
        elif not trails:
            held += last
        if held:
            yield held

    def _refuse_bomb(self, unpacked: int, pending: int) -> None:
        """Raise where a packed file holds more than text packs to, or a line goes on without an end."""
        what, hint = "", "Export it again, a row a line."
        if self._zipped and unpacked > max(SMALL, MOST_PACKED * self.path.stat().st_size):
            what, hint = f"unpacks to over {MOST_PACKED} times its size, as no log does", "Unpack it, and look at it."
        elif pending > MOST_LINE:
            what = f"has a line of over {MOST_LINE >> 20} MiB"
        if what:
            raise FricError(what, where=str(self.path), hint=hint)

    def _parsed(self, piece: bytes) -> pd.DataFrame:
        whole = piece.replace(MINUS.encode(), b"-")
        whole = _REMARK.sub(b"", whole) if whole.startswith(b"#") or b"\n#" in whole else whole
        frame = self._cells(whole)
        worded = not all(map(pd.api.types.is_numeric_dtype, frame.dtypes))
        return self._cells(plain) if worded and (plain := _WORDS.sub(b"", whole)) != whole else frame

    def _cells(self, whole: bytes) -> pd.DataFrame:
        # Cells are read by their place. The encoding matters for names alone, which are known by now.
        shape, names = self.shape, range(len(self.columns))
        read_csv: Callable[..., pd.DataFrame] = pd.read_csv  # whose types ask for more of a file than it does
        options: dict[str, Any] = {
            "sep": r"\s+" if shape.delimiter == "whitespace" else shape.delimiter, "decimal": shape.decimal,
            "comment": self._comment, "skipinitialspace": shape.spaced, "encoding_errors": "replace",
            "header": None, "low_memory": False,
        }  # fmt: skip
        mark = None if shape.delimiter == "whitespace" else shape.delimiter.encode()
        try:
            # of a first row with many empty cells more, each would be a level of an index, which takes gigabytes
            first = whole[: MOST_LINE >> 5].partition(b"\n")[0]
            if mark and first.count(mark) > len(names) + MOST_EMPTY:
                raise pd.errors.ParserError("too many fields in line")
            # the first cells of a row that is too long are an index to pandas, evenly spaced ones even a RangeIndex
            longer = (first.count(mark) if mark else len(first.split()) - 1) >= len(names)
            if not self._ragged and not longer:
                with suppress(pd.errors.ParserError):
                    frame = read_csv(_Piece(whole), names=names, **options)
                    if isinstance(frame.index, pd.RangeIndex):
                        return frame
                self._ragged = True
            # columns behind those of the header catch rows that are too long: those with a cell there that is not empty
            lines = whole.splitlines()
            widest = max((line.count(mark) + 1 if mark else len(line.split()) for line in lines), default=0)
            if widest > len(names) + MOST_EMPTY:
                raise pd.errors.ParserError("too many fields in line")
            return read_csv(_Piece(whole), names=range(max(widest, len(names)) + 1), index_col=False, **options)
        except pd.errors.EmptyDataError:
            return pd.DataFrame({name: np.empty(0) for name in names})

    def _frame(self, parsed: Future[pd.DataFrame], row: int) -> pd.DataFrame:
        """Return what was parsed, having checked that no row is longer than the header."""
        width = len(self.columns)
        try:
            frame = parsed.result()
            if frame.iloc[:, width:].notna().any(axis=None):
                raise pd.errors.ParserError("too many fields in line")
        except pd.errors.ParserError as error:
            if "fields in line" in str(error):
                lines = islice(self._rows(), row, None)
                more = ((number, split(line, self.shape.delimiter)[width:]) for number, line in lines)
                long = (number for number, cells in more if any(cells) or len(cells) > MOST_EMPTY)
                raise FricError(f"has more cells than the {width} of the header",
                                where=f"{self.path}, line {next(long, '?')}",
                                hint="Mend or remove the line.") from None  # fmt: skip
            text = str(error).strip().rsplit("C error: ", 1)[-1]
            raise FricError(f"is not a table: {text}", where=self.place(row), hint="Mend the file.") from None
        return frame

    def place(self, row: int, column: int | None = None) -> str:
        """Return the line of a row, found by counting lines."""
        return self._described(f"line {self._line(row)[0]}", column)

    def text(self, row: int, column: int) -> str | None:
        """Return the text of the cell in the file."""
        cells = split(self._line(row)[1], self.shape.delimiter)
        return cells[column] if column < len(cells) else None

    def run(self, row: int, column: int) -> int:
        """Return how many rows from ``row`` on have no number in a column."""
        count = 0
        for _, line in islice(self._rows(), row, None):
            cells = split(line, self.shape.delimiter)
            cell = cells[column] if column < len(cells) else ""
            if is_number(cell, self.shape.decimal) and cell.lower().strip("+-")[:3] not in {"nan", "inf"}:
                break
            count += 1
        return count

    def _line(self, row: int) -> tuple[int, str]:
        return next(islice(self._rows(), row, None))

    def _rows(self) -> Iterator[tuple[int, str]]:
        """Give the number (from 1) and the text of every line of data, passing over what pandas passes over."""
        blank = " \r\n" if self.shape.delimiter == "\t" else " \t\r\n"
        above = self._part[0] if self._part else 0
        with self._opened(self.shape.encoding) as file:
            for number, line in enumerate(file, 1):
                content = line.partition(self._comment)[0] if self._comment else line
                plain = content.strip(blank) and content[0] != "#" and not _WORDS.match(content.encode())
                if plain and number > self.shape.first:
                    yield number + above, content

    def ends(self) -> tuple[Real, Real]:
        """Return the first and the last row, NaN where a cell is no number."""
        found, width = [], len(self.columns)
        for _, line in (*islice(self._rows(), 1), *deque(self._rows(), 1)):
            cells = [*split(line, self.shape.delimiter), *[""] * width][:width]
            found.append(np.array([number(cell.replace(self.shape.decimal, ".")) for cell in cells]))
        return (found[0], found[1]) if found else (np.full(width, np.nan),) * 2

    def _opened(self, encoding: str | None) -> IO[Any]:
        if self._part is None:
            return _opened(self.path, self._zipped, encoding)
        part = io.BytesIO(self._part[1])
        return io.TextIOWrapper(part, encoding, "replace") if encoding else part


def as_numbers(column: "pd.Series[Any]", decimal: str, unit: str | None = None) -> Real:
    """Return a column as floats, NaN where a cell is no number, also with its unit behind it."""
    if pd.api.types.is_bool_dtype(column):
        return np.full(len(column), np.nan)
    if not pd.api.types.is_numeric_dtype(column):
        plain = column.astype("str").str.rstrip(" ;").str.removesuffix(unit or "")
        if (grouped := plain.str.strip().str.fullmatch(_GROUPED[decimal]).eq(True)).any():
            plain = plain.mask(grouped, plain.str.replace(_GROUPS[decimal], "", regex=True))
        if decimal == ",":
            plain = plain.astype("str").where(lambda text: ~text.str.contains(".", regex=False))
            plain = plain.str.replace(",", ".", regex=False)
        found = pd.to_numeric(plain, errors="coerce")
        column = found if found.notna().any() else _stamps(column.astype("str").str.strip())
    return column.to_numpy(dtype="f8", na_value=np.nan)


def _stamps(text: "pd.Series[Any]") -> "pd.Series[Any]":
    """Return dates, times of a day or durations (0.001 sec) as seconds; NaN where a cell is none of them."""
    text = text.str.replace(r"(?<=\d)[,;](?=\d)", ".", regex=True)
    if not (first := next((text for text in text.dropna().head(20) if _STAMP.match(text)), "")):
        return pd.Series(np.full(len(text), np.nan))
    if not _DATE.match(first):
        return pd.to_timedelta(text, errors="coerce").dt.total_seconds()
    form = "ISO8601" if re.match(r"\d{4}-", first) else "mixed"
    stamps = pd.to_datetime(text, errors="coerce", format=form, dayfirst=bool(re.match(r"\d+\.", first)), utc=True)
    return (stamps - pd.Timestamp(0, tz="UTC")) / pd.Timedelta(1, "s")


def _opened(path: Path, zipped: bool, encoding: str | None = None) -> IO[Any]:
    mode: Any = "rt" if encoding else "rb"
    options: dict[str, Any] = {"encoding": encoding, "errors": "replace", "newline": None} if encoding else {}
    return gzip.open(path, mode, **options) if zipped else path.open(mode, **options)
