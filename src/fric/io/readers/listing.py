"""Texts of one value a line, as historians and loggers of events write them: time, name of the channel, value."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache, reduce
from math import log10
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from fric.arrays import Real
from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.flaws.files import COLUMNS_LEFT_OUT
from fric.io.readers import text
from fric.io.readers.base import MOST_COLUMNS, Column, ForeignTable, Format, named
from fric.io.readers.joined import Joined, on_clocks
from fric.io.words import spoken
from fric.series import LARGEST
from fric.units import is_unit

FORMAT = Format("Text of one value a line", text.FORMAT.endings)
MOST_LINES = 12_000_000  # Lines of such a text at most: it is held in memory
LOOKED_AT = 600  # Lines that show how a text is written
OFTEN = 3.0  # Lines in a row of each name, from which on a name beside a time that never repeats is a state
RARE = 0.05  # Samples of a channel, relative to those of the most frequent one, below which it is left out
_QUALITY = re.compile(r"(?i)qualit|status|good|flag")
_NUMBERED = re.compile(r"(?i)(\b|_)(id|channel|signal|tag|variable|kanal|canale?)(\b|_|$)")
"""The name of a column whose numbers name channels."""


class _Listing(NamedTuple):
    """How a text is written, and its columns of the time, the value, the name of the channel, and the unit."""

    shape: text.Shape
    time: int
    value: int
    names: Sequence[int]
    unit: Sequence[int]


def recognises(path: Path, head: bytes) -> float:
    """A text each of whose lines has a stamp, a name that comes again, and a value."""
    lines = head.splitlines() or [b""]
    words = re.search(rb"[A-Za-z\x80-\xff]", lines[len(lines) // 2]) or _NUMBERED.search(lines[0].decode("latin-1"))
    return 0.2 * bool(words and text.recognises(path, head) and _listing(text.beginning(path)[0], Layout()))


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read a text of one value a line: one table, with a column a channel."""
    form = _listing(text.beginning(path)[0], layout)
    wide = _wide(text.TextTable(path, layout, form.shape), form) if form else None
    yield from text.tables(path, layout) if wide is None else [wide]


@lru_cache(maxsize=64)
def _listing(head: bytes, layout: Layout) -> _Listing | None:
    """Return how a text of one value a line is written; None of another."""
    encoding = layout.encoding or text.encoding_of(head)
    lines = head.decode(encoding, "replace").splitlines()[: LOOKED_AT + 1]
    for delimiter in [layout.delimiter] if layout.delimiter else text.DELIMITERS:
        width = len(text.split(lines[len(lines) // 2], delimiter)) if lines else 0
        if not 3 <= width <= text.MOST_TURNS:
            continue
        every = [text.split(line, delimiter) for line in lines[:-1]]  # the last may be cut
        are = [len(row) == width and any(text.is_number(cell.replace(",", "."), ".") for cell in row) for row in every]
        first = are.index(True) if True in are else len(every)
        if len(rows := [row for row in every[first:] if len(row) == width]) < max(8, 0.9 * (len(every) - first)):
            continue
        points = any(text.is_number(cell, ".") and "." in cell for row in rows for cell in row)
        decimal = layout.decimal or ("." if delimiter == "," or points else ",")
        heads = every[first - 1] if first and len(every[first - 1]) == width else [""] * width
        columns = [named(cell or f"column {n}") for n, cell in enumerate(heads)]
        shape = text.Shape(encoding, delimiter, decimal, first, tuple(columns), {}, spaced=True)
        return _columns(shape, [pd.Series(cells) for cells in zip(*rows, strict=True)])
    return None


def _columns(shape: text.Shape, cells: Sequence["pd.Series[Any]"]) -> _Listing | None:
    """Return what the columns of a text are: with the name of a channel, the time rises and one number changes."""
    data, again = [text.as_numbers(column, shape.decimal) for column in cells], 0.5 * len(cells[0])
    words, rest = list[int](), list[int]()
    for n, column in enumerate(cells):
        numbers = np.isfinite(data[n]).mean() > 0.5
        ids = numbers and _NUMBERED.search(shape.columns[n].name) and (data[n] == np.rint(data[n])).all()
        named = bool(ids and column.nunique() > 1) or column.str.contains(r"[^\W\d]").mean() > 0.5
        if (ids or not numbers) and column.nunique() <= again and named:
            words.append(n)
        elif numbers:
            rest.append(n)
    units = [n for n in words if all(word in {"", "-", "1"} or is_unit(word) for word in cells[n].unique())]
    names = [n for n in words if n not in units and not _QUALITY.search(shape.columns[n].name)]
    names, units = (names, units[:1]) if names else (units[:1], units[1:2])
    if not names:
        return None
    key = pd.factorize(pd.concat([cells[n] for n in names], axis=1).agg("\0".join, axis=1))[0]
    of_name = [np.flatnonzero(key == k) for k in range(key.max() + 1)]

    def steps(n: int) -> Real:
        found = np.concatenate([np.diff(data[n][at]) for at in of_name])
        return found[np.isfinite(found)]

    dates = {n for n in rest if re.search(r"\d[:/-]\d", cells[n].iloc[0])}
    changing = [n for n in rest if steps(n).any()]
    if not (times := [n for n in changing if max((steps(n) >= 0.0).mean(), (steps(n) <= 0.0).mean()) > 0.98]):
        return None
    says = [spoken(column).quantity for column in shape.columns]
    time = min(times, key=lambda n: (says[n] != "time", n not in dates, n))
    sampled = [n for n in rest if n in changing or says[n] in text.MOTION]  # what is of a motion may rest at first
    values = [n for n in sampled if n not in {time, *dates} and says[n] not in {"time", "row"}]
    columns = [Column(name, "s" if n in dates else unit) for n, (name, unit) in enumerate(shape.columns)]
    return _Listing(replace(shape, columns=tuple(columns)), time, values[0], names, units) if len(values) == 1 else None


def _wide(table: text.TextTable, form: _Listing) -> ForeignTable | None:
    """Return a table with a column a channel, those of other instants resampled; None where the names are a state."""
    known, parts, path = dict[str, int](), list[tuple[Real, ...]](), str(table.path)
    for frame, _ in table.frames():
        first, *more = (frame[n].astype("str").fillna("").str.strip() for n in (*form.names, *form.unit))
        codes, found = pd.factorize(reduce(lambda words, others: words + "\0" + others, more, first))
        ids = np.array([known.setdefault(words, len(known)) for words in found], int)
        numbers = (text.as_numbers(frame[n], table.shape.decimal) for n in (form.time, form.value))
        parts.append((*numbers, ids[codes]))
        if len(known) > MOST_COLUMNS or sum(len(part[0]) for part in parts) > MOST_LINES:
            what = f"{MOST_COLUMNS} names of channels" if len(known) > MOST_COLUMNS else f"{MOST_LINES} lines"
            raise FricError(f"has over {what}", where=path, hint="Export the channels of one axis, or a shorter time.")
    time, value, key = (np.concatenate(part) for part in zip(*parts, strict=True))
    kept = np.isfinite(time) & np.isfinite(value)
    time, value, key = time[kept], value[kept], key[kept].astype(int)
    count, begins = np.bincount(key, minlength=len(known)), np.append(True, np.diff(key) != 0)[: len(key)]
    often = count / np.maximum(np.bincount(key[begins], minlength=len(known)), 1)
    if np.count_nonzero(count) < 2 or ((np.diff(time) > 0.0).all() and often[count > 0].min() >= OFTEN):
        return None
    scale = 1e-3 ** ((log10(time.max()) - 9.0) // 3.0) if time.max() > LARGEST["time"] else 1.0  # ms since 1970
    clock = table.columns[form.time]._replace(**{"unit": "s"} if scale != 1.0 else {})
    names, of = [words.split("\0") for words in known], table.columns[form.value]
    vary = [k for k in range(len(form.names)) if len({words[k] for words in names}) > 1]
    says, constants, left = spoken(of).quantity, dict[str, str](), list[str]()
    channels = list[tuple[Column, Real, Real]]()
    for words, rows in zip(names, np.split(np.argsort(key, kind="stable"), np.cumsum(count)[:-1]), strict=True):
        column = named(" ".join(words[k] for k in vary))
        name = f"{column.name} {of.name}" if says and spoken(column).quantity is None else column.name
        if len(rows) < max(RARE * count.max(), 3):
            constants |= {name: f"{value[rows[0]]:.9g}"} if len(rows) and not np.ptp(value[rows]) else {}
            left += [] if name in constants else [name]
            continue
        rows = rows[::-1] if time[rows[0]] > time[rows[-1]] else rows  # the newest may be first
        unit = words[-1] if form.unit and is_unit(words[-1]) else of.unit
        channels.append((Column(name, column.unit or unit), scale * time[rows], value[rows]))
    notices = [COLUMNS_LEFT_OUT.found(path, columns=left)] if left else []
    alike = on_clocks(table.path, clock, channels)
    wide = Joined(table.path, alike, notices=notices) if len(alike) > 1 else alike[0].table
    wide.notices, wide.columns, wide.constants = notices, (clock, *wide.columns[1:]), constants
    return wide
