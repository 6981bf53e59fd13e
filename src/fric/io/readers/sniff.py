"""How a text log is written: encoding, delimiter, decimal mark, and where names, units and data stand."""

import csv
import re
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.io.readers.base import Column, named
from fric.units import is_unit

LOOK = 300
"""Lines that tell the delimiter and the decimal mark."""
DELIMITERS = (";", "\t", ",", "|", "whitespace")
_NUMBER = {
    ".": re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf(?:inity)?)", re.IGNORECASE),
    ",": re.compile(r"[+-]?(?:\d+(?:,\d+)?|,\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf(?:inity)?)", re.IGNORECASE),
}
_LINE_END = re.compile(r"\r\n|\n|\r")
_SPACED = re.compile(r'"[^"]*"|[^\s\[(]\S*(?:\s*\[[^\]]*\]|\s*\([^)]*\))?|\S+')
"""A cell between spaces; a unit in brackets belongs to the name before it."""
_MARKS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))


@dataclass(frozen=True)
class Shape:
    """What was found: how to read the data, and what stands above them."""

    # encoding, delimiter, decimal: as in a mapping's ``format``
    encoding: str
    delimiter: str
    decimal: str
    first: int  # Lines before the first line of data
    columns: tuple[Column, ...]  # Names and units
    preamble: dict[str, str]  # Values named in the lines above the header, as in ``Sampling period:;51.200``
    spaced: bool  # Whether there are spaces behind delimiters


def encoding_of(head: bytes) -> str:
    """Return the encoding: by its mark, else UTF-8 where that fits, else Latin-1."""
    for mark, encoding in _MARKS:
        if head.startswith(mark):
            return encoding
    try:
        head[: head.rfind(b"\n") + 1 or len(head)].decode("utf-8")
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"


def split(line: str, delimiter: str) -> list[str]:
    """Split a line into cells, without quotes and spaces around them."""
    if delimiter == "whitespace":
        cells = _SPACED.findall(line.lstrip("#% \t"))
    else:
        cells = line.split(delimiter)
        if '"' in line:
            with suppress(csv.Error):  # a cell longer than any is no quoted one
                cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    return [cell.strip().strip('"').strip() for cell in cells]


def is_number(cell: str, decimal: str) -> bool:
    """Say whether a cell is a number."""
    return _NUMBER[decimal].fullmatch(cell) is not None


class _Row(NamedTuple):
    cells: list[str]
    numeric: list[bool]

    @property
    def score(self) -> int:
        """Numbers count for the reading, words against it; empty cells say nothing."""
        words = sum(not number and bool(cell) for cell, number in zip(self.cells, self.numeric, strict=True))
        return sum(self.numeric) - words


def shape_of(head: bytes, layout: Layout, whole: bool) -> Shape:
    """Find how a text log is written from its beginning.

    head: The first bytes of the file, uncompressed.
    layout: What the user says; it is taken as it is.
    whole: Whether ``head`` is the whole file.
    Raises FricError: When there are no rows of numbers, or what the user says does not fit.
    """
    encoding = layout.encoding or encoding_of(head)
    try:
        lines = _LINE_END.split(head.decode(encoding, errors="replace"))
    except LookupError:
        raise FricError(f"'{encoding}' is no encoding", hint="Say utf-8, latin-1 or utf-16.") from None
    if not whole or not lines[-1]:
        lines.pop()  # cut in the middle, or what stands behind the last line's end
    start = layout.skip
    if layout.data_after is not None:
        ends = [n for n, line in enumerate(lines) if n >= start and line.startswith(layout.data_after)]
        if not ends:
            raise FricError(
                f"no line starts with '{layout.data_after}'", hint="Mend `data_after` in the mapping, or leave it out."
            )
        start = ends[0] + 1
    above = max((n for n in (layout.header or 0, layout.units or 0) if n), default=0)
    start = max(start, above)
    delimiter, decimal, rows = _reading(lines[start:], layout)
    first = start + (_leading(rows) if layout.data_after is not None else _data_start(rows))
    width = len(rows[first - start].cells)
    spare = not any(any(row.cells[-1:]) for row in rows[first - start :])
    table = [_heads(line, delimiter, width) for line in lines[:first]]
    names, units = _header(table, width, decimal, layout, spare)
    if names is not None:
        for n in range(max(names, -1 if units is None else units) + 1, first):  # below the names stand samples
            if sum(is_number(cell, decimal) for cell in table[n]) >= width:
                raise FricError(
                    f"line {n + 1} has more cells than the {width} of the header", hint="Mend or remove the line."
                )
    cells = table[names] if names is not None else [f"column {n}" for n in range(width)]
    cells = [cell or f"column {n}" for n, cell in enumerate((cells + [""] * width)[:width])]
    columns = [named(cell) for cell in cells]
    if units is not None:
        given = (table[units] + [""] * width)[:width]
        bare = [unit.strip("[]()").strip() or None for unit in given]
        columns = [Column(c.name, c.unit or unit) for c, unit in zip(columns, bare, strict=True)]
    top = min(n for n in (names, units, first) if n is not None)
    if spare and columns[-1].name.startswith("column "):
        columns.pop()  # a delimiter at the end of each line makes no column
    spaced = any(delimiter + " " in line for line in lines[first:])
    return Shape(encoding, delimiter, decimal, first, tuple(columns), _preamble(lines[:top], delimiter), spaced)


def _heads(line: str, delimiter: str, width: int) -> list[str]:
    """Split a line above the data; between spaces, names of several words stand apart by two spaces or more."""
    cells = split(line, delimiter)
    if delimiter == "whitespace" and len(cells) != width:
        apart = re.split(r"\s{2,}|\t", line.strip("#% \t"))
        return apart if len(apart) == width else cells
    return cells


def _reading(lines: list[str], layout: Layout) -> tuple[str, str, list[_Row]]:
    """Return delimiter, decimal mark and rows of the reading that makes most numbers of the lines."""
    if not any(line.strip() for line in lines):
        raise FricError("there is a header and no data", hint="Export the log again, with its samples.")
    best: tuple[int, int, str, str] = (0, 0, "", "")
    for delimiter in [layout.delimiter] if layout.delimiter else DELIMITERS:
        for decimal in [layout.decimal] if layout.decimal else [".", ","]:
            if decimal == delimiter:
                continue
            scores: dict[int, int] = {}
            for line in lines[-LOOK:]:  # the preamble is above
                row = _row(line, delimiter, decimal, layout.comment)
                scores[len(row.cells)] = scores.get(len(row.cells), 0) + max(row.score, 0)
            width = max(scores, key=lambda n: (scores[n], n))
            if scores[width] and (scores[width], width) > best[:2]:
                best = scores[width], width, delimiter, decimal
    _, width, delimiter, decimal = best
    if not width:
        raise FricError(
            "there are no rows of numbers",
            hint="A header alone is no log; if there are data, say in a mapping how they are written (`format:`).",
        )
    rows = [_row(line, delimiter, decimal, layout.comment) for line in lines]
    rows = [_Row(row.cells[:width], row.numeric[:width]) if not any(row.cells[width:]) else row for row in rows]
    return delimiter, decimal, [row if len(row.cells) == width else _Row([], []) for row in rows]


def _row(line: str, delimiter: str, decimal: str, comment: str | None) -> _Row:
    cells = split(line.partition(comment)[0] if comment else line, delimiter)
    return _Row(cells, [is_number(cell, decimal) for cell in cells])


def _leading(rows: list[_Row]) -> int:
    return next(n for n, row in enumerate(rows) if row.cells)


def _data_start(rows: list[_Row]) -> int:
    """Return the first row of data: numbers where most rows have them; a word in it is a bad cell, not a header."""
    good = [row for row in rows if row.score > 0]
    numeric = [2 * sum(column) > len(good) for column in zip(*(row.numeric for row in good), strict=True)]

    def words(row: _Row) -> int:
        return sum(wanted and bool(c) and not n for c, n, wanted in zip(row.cells, row.numeric, numeric, strict=True))

    as_wide = [n for n, row in enumerate(rows) if row.cells]
    first = next((n for n in as_wide if rows[n].score > 0 and not words(rows[n])), as_wide[0])
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
        n
        for n in range(layout.skip, len(table))
        if (len(table[n]) in {width, width - spare} or (len(table[n]) == width + 1 and not table[n][-1]))
        and sum(map(bool, table[n])) * 2 >= width
        and not any(is_number(cell, decimal) for cell in table[n])
        and n not in {names, units}
    ]
    if units is None and layout.units is None and above and (names is not None or len(above) > 1):
        cells = [cell.strip("[]()").strip() for cell in table[above[-1]]]
        if any(map(_unit, cells)) and all(not cell or cell == "-" or _unit(cell) for cell in cells):
            units = above.pop()
    if names is None and layout.header is None and above:
        names = above[-1]
    return names, units


@cache
def _unit(cell: str) -> bool:
    return len(cell) < 16 and is_unit(cell)


def _preamble(lines: list[str], delimiter: str) -> dict[str, str]:
    """Return what the lines above the header name, as in ``Sampling period:;51.200`` or ``# load: 3 kg``."""
    found: dict[str, str] = {}
    for line in lines:
        head, mark, rest = line.partition(delimiter if delimiter != "whitespace" else ":")
        if not mark or (":" in head.rstrip(" :") and delimiter != "whitespace"):
            head, mark, rest = line.partition(":")
        name = head.strip(" \t:#%\"'=")
        value = rest.strip().strip("\"'") if delimiter == "whitespace" else (split(rest, delimiter) or [""])[0]
        if name and value and name not in found:
            found[name] = value
    return found
