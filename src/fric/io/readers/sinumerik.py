"""Traces of SINUMERIK Operate, saved as XML.

There is no genuine sample in public; the elements are those that the public package Trace-Tools reads: ``traceData``,
``dataFrame``, a ``dataSignal`` (``name``, ``description``) for each signal, a ``rec`` (``time`` in seconds, ``f1``,
``f2``, …) for each instant, in which a slower signal may lack. Units are not told: a mapping says them.
"""

from array import array
from collections.abc import Iterator
from pathlib import Path
from xml.parsers import expat

import numpy as np

from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.flaws.files import SAMPLES_WITHOUT_VALUE
from fric.input import regular
from fric.io.readers.base import Column, Format, Memory, Table
from fric.io.readers.joined import Joined, Part

FORMAT = Format("SINUMERIK trace", (".xml",))
MOST = 1 << 30
"""Bytes of a trace that are read at most: its samples are held in memory."""
NO_VALUE = 9.2e18
"""What is above is no value: the bits of a NaN, written as an integer."""


def recognises(path: Path, head: bytes) -> float:
    """A trace is XML that names its signals or its frame near its beginning."""
    return 0.9 * (b"<traceData" in head or b"<dataSignal" in head)


def tables(path: Path, layout: Layout) -> Iterator[Table]:
    """Read a trace: one table; signals of different rates are put on one clock."""
    trace = _Trace(regular(path, MOST))
    if not trace.names:
        raise FricError("names no signal", where=str(path), hint="Save the trace again, with its data.")
    clocks: dict[bytes, list[int]] = {}
    for n, time in enumerate(trace.time):
        if len(time):
            clocks.setdefault(time.tobytes(), []).append(n)
    if not clocks:
        raise FricError("holds no samples", where=str(path), hint="Save the trace again, with its data.")
    parts = []
    for members in clocks.values():
        columns = (Column("time", "s"), *(Column(trace.names[n]) for n in members))
        data = [np.frombuffer(trace.time[members[0]]), *(np.frombuffer(trace.values[n]) for n in members)]
        parts.append(Part(Memory(path, columns, data), 0))
    without = [SAMPLES_WITHOUT_VALUE.found(str(path), samples=trace.without)] if trace.without else []
    yield Joined(path, parts, notices=without)


class _Trace:
    """The signals of a trace, read element by element."""

    def __init__(self, path: Path) -> None:
        self.path, self.without = path, 0
        self.names: list[str] = []
        self.time: list[array[float]] = []
        self.values: list[array[float]] = []
        parser = expat.ParserCreate()
        parser.StartElementHandler, parser.StartDoctypeDeclHandler = self._begin, self._refuse
        try:
            with path.open("rb") as file:
                parser.ParseFile(file)
        except expat.ExpatError as error:
            raise FricError(f"is no whole XML ({error})", where=str(path), hint="Save the trace again.") from None

    def _begin(self, tag: str, about: dict[str, str]) -> None:
        if tag == "dataSignal":
            self.names.append(about.get("description") or about.get("name") or f"signal {len(self.names) + 1}")
            self.time.append(array("d"))
            self.values.append(array("d"))
        elif tag == "rec":
            try:
                time = float(about.pop("time"))
                for key, text in about.items():
                    if key[0] == "f" and key[1:].isdigit():
                        self._take(int(key[1:]) - 1, time, float(text))
            except (KeyError, ValueError, IndexError):
                raise FricError(
                    f"has a rec that does not read: {about}", where=str(self.path), hint="Save the trace again."
                ) from None

    def _take(self, n: int, time: float, value: float) -> None:
        if value > NO_VALUE:
            self.without += 1
        else:
            self.time[n].append(time)
            self.values[n].append(value)

    def _refuse(self, *_: object) -> None:
        raise FricError("declares a document type, as no trace does", where=str(self.path), hint="Save it again.")
