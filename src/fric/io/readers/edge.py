"""Recordings of a SINUMERIK Edge (Analyze MyWorkpiece, Capture): JSON, or its rows as CSV with the addresses above.

The elements are those that public recordings and parsers have: ``Header.SignalListHFData`` lists the columns (``Name``,
``Axis``, ``Address`` as ``ENC_POS|1``: a signal and the number of its axis), ``Header.CycleTimeMs`` is the sampling
interval, and ``HFData`` in the list ``Payload`` holds the rows, between blocks of the program and slow data. The
column ``CYCLE`` counts sampling intervals, so that a pause of the recording is a pause of its clock.
"""

import json
import re
from array import array
from collections.abc import Iterator
from json import JSONDecodeError, JSONDecoder
from pathlib import Path
from typing import Any

import numpy as np

from fric.arrays import Real
from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.flaws.files import CYCLE_ASSUMED
from fric.input import reading, regular
from fric.io.readers.base import OF_SEVERAL, Column, ForeignTable, Format, Memory
from fric.io.readers.joined import Joined, SharedClock
from fric.io.readers.text import tables as text_tables

FORMAT = Format("SINUMERIK Edge", (".json", ".csv"))
LARGEST_FILE = 512 << 20  # Bytes of JSON that are read at most: its text and numbers in memory are below 2 GB together
CYCLE_MS = 2.0  # Sampling interval [ms] where the file gives none
CHANNELS = (  # Channels by the names of signals, the better first, and their units on linear and rotary axes
    ("position", ("ENC_POS", "ENC1_POS", "ENC2_POS"), ("mm", "deg")), ("reference", ("DES_POS",), ("mm", "deg")),
    ("force", ("TORQUE",), ("N*m", "N*m")), ("force", ("CURRENT",), ("A", "A")), ("force", ("LOAD",), ("%", "%")),
)  # fmt: skip
_LINEAR, _ROTARY = re.compile(r"[xyzuvw]\d*|axis[1-3]"), re.compile(r"(?:[abc]|sp?)\d*|axis\d+")
"""Names of axes in small letters; without names, axes 1 to 3 are taken for linear."""


def recognises(path: Path, head: bytes) -> float:
    """A recording is JSON whose header lists its fast signals, or a table under their addresses."""
    listed = head.lstrip(b"\xef\xbb\xbf \r\n\t").startswith(b"{") and b'"SignalListHFData"' in head
    return 1.0 * (listed or bool(re.match(rb"(?:\xef\xbb\xbf)?[^\n]*\b(?:ENC\d?|DES)_POS\|\d", head)))


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read a recording: a table for each axis whose position and force, torque, current or load were recorded."""
    whole: ForeignTable
    with reading(path) as file:
        is_json = file.read(64).lstrip(b"\xef\xbb\xbf \r\n\t").startswith(b"{")
    if is_json:
        whole, names, step = _recording(path)
        moves = [n for n, values in enumerate(whole.data) if values.min() < values.max()]  # JSON knows Infinity
    else:
        (whole,), names, step = text_tables(path, layout), {}, 0.0
        moves = list(range(len(whole.columns)))
    if "CYCLE" not in (addresses := [column.name for column in whole.columns]):
        raise FricError("lacks the column CYCLE", hint="Export the recording again, with CYCLE.")
    found: dict[str, dict[str, int]] = {}
    for n in moves:  # axes that a machine lacks are listed too, and stay at zero
        name, _, axis = addresses[n].partition("|")
        if axis:
            found.setdefault(axis, {}).setdefault(name, n)
    found = {axis: members for axis, members in found.items() if {"position", "force"} <= _channels(members).keys()}
    if not found:
        what = "records no axis that moves with its torque, current or load"
        raise FricError(what, hint="Record ENC_POS, DES_POS and CURRENT of an axis.")
    said = [] if step else [CYCLE_ASSUMED.found(str(path), interval=CYCLE_MS)]
    named = {axis: names.get(axis) or f"axis{axis}" for axis in found}
    for axis, members in found.items():
        about = {"axis": named[axis]}
        if len(found) > 1:
            about |= {"name": f"{path.stem}-{named[axis]}", OF_SEVERAL: " ".join(named.values())}
        clock = SharedClock(whole, addresses.index("CYCLE"), tuple(members.values()), (step or CYCLE_MS) * 1e-3)
        table = Joined(path, [clock], said=about, notices=said)
        channels = {n: channel for channel, n in _channels(members).items()}
        table.columns = (Column("time", "s"), *(
            Column(channels[n], _unit(name, named[axis])) if n in channels else Column(name)
            for name, n in members.items()
        ))  # fmt: skip
        yield table


def _channels(members: dict[str, int]) -> dict[str, int]:
    """Return the column of each channel by the names of signals; of two encoders the second is that of the load."""
    taken: dict[str, int] = {}
    for channel, names, _ in CHANNELS:
        for name in names:
            if name in members:
                taken.setdefault(channel, members[name])
    if {"ENC1_POS", "ENC2_POS"} <= members.keys():
        taken |= {"position": members["ENC1_POS"], "load_position": members["ENC2_POS"]}
    return taken


def _unit(name: str, axis: str) -> str | None:
    """Return the unit of a signal; a position has none where the name of the axis does not say how it moves."""
    linear, rotary = next(units for _, names, units in CHANNELS if name in names)
    return linear if linear == rotary or _LINEAR.fullmatch(axis) else rotary if _ROTARY.fullmatch(axis) else None


def _recording(path: Path) -> tuple[Memory, dict[str, str], float]:
    """Return the rows of a recording, the names of its axes by their numbers, and the sampling interval [ms]."""
    text = regular(path, LARGEST_FILE).read_text(encoding="utf-8-sig", errors="replace")
    header, _ = _decoded(path, text, _begin(text, "Header"))
    columns, names = list[Column](), dict[str, str]()
    for signal in _listed(header, "SignalListHFData"):
        about = signal if isinstance(signal, dict) else {}
        columns.append(Column(str(about.get("Address") or about.get("Name") or f"column {len(columns)}")))
        names.setdefault(columns[-1].name.partition("|")[2], str(about.get("Axis") or "").lower())
    rows, step = _rows(path, text, len(columns)), header.get("CycleTimeMs", CYCLE_MS)
    if type(step) not in (int, float) or not 1e-3 <= step <= 1e4:
        raise FricError(f"has a CycleTimeMs of {json.dumps(step)[:20]}", hint="Export the recording again.")
    return Memory(path, tuple(columns), [*rows.T]), names, float(step)


def _begin(text: str, key: str) -> int:
    """Return the place at which the value of a key of the file begins."""
    if (found := re.search(rf'"{key}"\s*:\s*', text)) is None:
        raise FricError(f"has no {key}", hint="Export the recording again.")
    return found.end()


def _decoded(path: Path, text: str, place: int) -> tuple[dict[str, Any], int]:
    """Return the object that begins at a place, and where it ends."""
    try:
        found, end = JSONDecoder().raw_decode(text, place)
    except (JSONDecodeError, RecursionError) as error:
        line = text.count("\n", 0, getattr(error, "pos", place)) + 1
        raise FricError("is cut off, or no JSON", where=f"{path}, line {line}",
                        hint="Export the recording again.") from None  # fmt: skip
    if not isinstance(found, dict):
        raise FricError(f"has {json.dumps(found)[:40]} in place of an object", hint="Export the recording again.")
    return found, end


def _listed(holder: dict[str, Any], key: str) -> list[Any]:
    found = holder.get(key, [])
    return found if isinstance(found, list) else []


def _rows(path: Path, text: str, columns: int) -> Real:
    """Return the rows of the fast signals, NaN where a cell is no number."""
    place, numbers, row = _begin(text, "Payload") + 1, array("d"), 0
    while True:
        while text[place : place + 1] in set(" ,\r\n\t"):
            place += 1
        if text.startswith("]", place):
            break
        message, place = _decoded(path, text, place)
        for cells in _listed(message, "HFData"):
            row += 1
            if not isinstance(cells, list) or len(cells) != columns:
                raise FricError(f"does not hold the {columns} signals of the header", where=f"{path}, sample {row}",
                                hint="Export the recording again.")  # fmt: skip
            numbers.extend(float(cell) if type(cell) in (int, float) else np.nan for cell in cells)
    if not row:
        raise FricError("holds no samples", hint="Export the recording again, with its fast data.")
    return np.frombuffer(numbers).reshape(row, columns)
