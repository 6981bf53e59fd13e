"""Text that TwinCAT's Scope View exports: lines about each channel, and a time column for each sampling rate."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.flaws.files import SCOPE_SCALE
from fric.io.readers.base import Column, ForeignTable, Format
from fric.io.readers.joined import Joined, SharedClock
from fric.io.readers.text import Shape, TextTable, beginning, encoding_of, is_number
from fric.notice import Notice

FORMAT = Format("TwinCAT Scope", (".csv", ".txt"))
_MARK = re.compile(
    rb"(?:\xef\xbb\xbf)?Name[\t;,].*?[\r\n]+File[\t;,].*?[\r\n]+Start ?(?:time)? of (?:export|record)[\t;,]",
    re.DOTALL | re.I,
)
_FILETIME = 1e16  # A stamp above this counts ticks of 100 ns since 1601: 1e16 are 31 years, as milliseconds 300,000


def recognises(path: Path, head: bytes) -> float:
    """An export begins with the names of the scope and of its file, and the time of its start; channels follow."""
    return 0.9 * bool(_MARK.match(head) and re.search(rb"[\r\n]Name[\t;,]", head))


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read an export: one table; channels of different rates are resampled to a common clock."""
    head, _ = beginning(path)
    encoding = layout.encoding or encoding_of(head)
    lines = re.split(r"\r\n|\n|\r", head.decode(encoding, errors="replace"))
    delimiter = layout.delimiter or lines[0].lstrip("\ufeff")[4]
    about, first = _about([[cell.strip() for cell in line.split(delimiter)] for line in lines])
    rows = [line.split(delimiter) for line in lines[first:-1] if line.strip()]
    commas = delimiter != "," and any(re.search(r"\d,\d", cell) for row in [*rows, *about.values()] for cell in row)
    decimal = layout.decimal or ("," if commas else ".")
    if not rows or not is_number(rows[0][0].strip(), decimal):
        raise FricError("there is a header and no data", hint="Export it again, with its samples.")
    names, keys = about["Name"], list(about.values())
    clocks = [n for n in range(len(names)) if all(n < len(cells) and cells[n] == cells[0] for cells in keys)]
    units = about.get("Unit", [])
    columns = tuple(Column(name or f"column {n}", _unit(units, n)) for n, name in enumerate(names))
    shape = Shape(encoding, delimiter, decimal, first, columns, {}, spaced=False)
    factor = 1e-7 if float(rows[0][0].replace(",", ".")) > _FILETIME else 1e-3
    groups = [tuple(range(a + 1, b)) for a, b in zip(clocks, [*clocks[1:], len(names)], strict=True)]
    parts = [
        SharedClock(TextTable(path, layout, shape), time, tuple(n for n in group if names[n]), factor, f"clock {k}")
        for k, (time, group) in enumerate(zip(clocks, groups, strict=True), 1)
    ]
    yield Joined(path, parts, notices=_scaled(path, about))


def _about(cells: Sequence[list[str]]) -> tuple[dict[str, list[str]], int]:
    """Return the lines that describe the channels, by their first cell, and the number of the first line of data."""
    if (start := next((n for n, row in enumerate(cells) if n > 3 and row[0] == "Name"), None)) is None:
        raise FricError("names no channels", hint="Export it with the names of the channels.")
    end = next((n for n, row in enumerate(cells) if n > start and not row[0][:1].isalpha()), len(cells))
    first = next((n for n, row in enumerate(cells) if n >= end and any(row)), len(cells))
    return {row[0]: row for row in cells[start:end]}, first


def _unit(units: Sequence[str], n: int) -> str | None:
    """Return a channel's unit, as in ``dV (Voltage)`` or ``(mm)``."""
    before, _, within = units[n].partition("(") if n < len(units) else ("", "", "")
    unit = before.strip() or within.strip(" )")
    return None if unit in {"", "Unit"} else unit


def _scaled(path: Path, about: dict[str, list[str]]) -> list[Notice]:
    """Note the channels that Scope shows scaled: the file does not show whether exported values are scaled."""
    plain = {"ScaleFactor": "1", "Offset": "0", "Unit ScaleFactor": "1", "Unit Offset": "0"}
    scaled = {
        about["Name"][n]
        for key, usual in plain.items()
        for n, cell in enumerate(about.get(key, []))
        if cell not in {usual, key, ""} and n < len(about["Name"])
    }
    return [SCOPE_SCALE.found(str(path), channels=[f"'{name}'" for name in sorted(scaled)])] if scaled else []
