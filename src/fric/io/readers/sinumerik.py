"""Traces of SINUMERIK Operate, saved as XML.

The elements are those that the public package Trace-Tools reads, and that genuine traces have: a ``dataFrame`` holds
a ``dataSignal`` (``id``, ``name``: its address, ``description``, ``interval``, ``unitsType``) for each signal, and a
``rec`` (``time`` in seconds, ``f1``, ``f2``, …) for each instant. Where intervals are given, a missing value equals the
value before, and so does a whole record; a signal of a longer interval is slower. Else a missing value is of a slower
signal. The address names the signal and its axis in every language; ``unitsType`` its unit. Else a mapping gives them.
"""

import re
from array import array
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import NamedTuple
from xml.parsers import expat

import numpy as np

from fric.arrays import Indices, Real
from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.flaws.files import SAMPLES_WITHOUT_VALUE
from fric.input import regular
from fric.io.readers.base import OF_SEVERAL, Column, ForeignTable, Format, Memory, PlainXML, number
from fric.io.readers.joined import Joined, SharedClock, on_clocks
from fric.series import CLOSEST, LARGEST

FORMAT = Format("SINUMERIK trace", (".xml",))
AGAIN = "Save the trace again, with its data."
MOST_BYTES = 1 << 30  # Bytes of a trace that are read at most: its samples are held in memory
NO_VALUE = 9.2e18  # What is above is no value: the bits of a NaN, written as an integer
SETUP = 1 << 20  # Bytes of setup before the data at most
MOST_FILLED = 4_000_000  # Instants of a trace at most, with those at which nothing changed
CHANNELS = (  # Channels by the address of a signal, the better address first
    ("reference", r"CmdPos"), ("position", r"ActPos2nd"), ("position", r"ActPos"), ("velocity", r"ActVel"),
    ("force", r"Act(ual)?Torque|TorqueAct|\bMotTorque"), ("force", r"Act(ual)?Curr|CurrAct|CurrentAct|ActCurrent"),
)  # fmt: skip
UNITS = {"posn": ("mm", "deg"), "velo": ("mm/min", "rpm"), "veloRot": ("rpm", "rpm"), "current": ("A", "A"),
         "torque": ("N*m", "N*m"), "accel": ("m/s^2", "rev/s^2")}  # fmt: skip
"""Units of linear and rotary axes by ``unitsType``."""
_AXIS = re.compile(r"\[[^\]]*?(\d+)\s*\]\s*$")


class Signal(NamedTuple):
    """One signal, as the trace declares it."""

    address: str
    description: str
    interval: float
    units: str

    @property
    def axis(self) -> str:
        """Number of the axis in the address; empty where there is none."""
        return found[1] if (found := _AXIS.search(self.address)) else ""


def recognises(path: Path, head: bytes) -> float:
    """A trace is XML that names its session, its signals or its frame, some 19 kB behind its beginning or sooner."""
    marks = (b"<traceSession", b"<traceData", b"<dataSignal")
    if not any(mark in head for mark in marks) and head.lstrip(b"\xef\xbb\xbf \r\n").startswith(b"<?xml"):
        with path.open("rb") as file:
            head = file.read(SETUP)
    return 0.9 * any(mark in head for mark in marks)


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read a trace: a table an axis, where signals name their axis; signals of different rates get a common clock."""
    if not (trace := _Trace(regular(path, MOST_BYTES))).signals or not len(trace.time):
        raise FricError("holds no samples" if trace.signals else "names no signal", hint=AGAIN)
    time, values = np.frombuffer(trace.time), np.frombuffer(trace.values).reshape(len(trace.time), -1)
    values = np.where(values > NO_VALUE, np.nan, values)
    said = [SAMPLES_WITHOUT_VALUE.found(str(path), samples=trace.without)] if trace.without else []
    if not any(signal.interval for signal in trace.signals):
        channels = (
            (Column(signal.description or signal.address), time[there], column[there])
            for signal, column in zip(trace.signals, values.T, strict=True) if (there := np.isfinite(column)).any()
        )  # fmt: skip
        if not (parts := on_clocks(path, Column("time", "s"), channels)):
            raise FricError("holds no samples", hint=AGAIN)
        yield Joined(path, parts, notices=said)
        return
    time, values = _filled(trace, time, values)
    axes = list(dict.fromkeys(signal.axis for signal in trace.signals if signal.axis)) or [""]
    names = " ".join(f"axis{axis}" for axis in axes) if len(axes) > 1 else ""
    for axis in axes:
        members = [n for n, signal in enumerate(trace.signals) if signal.axis in {axis, ""}]
        about = {"axis": f"axis{axis}", "name": f"{path.stem}-axis{axis}", OF_SEVERAL: names} if names else {}
        units = {trace.signals[n].units for n in members}
        rotary = "veloRot" in units and "velo" not in units  # its speeds are in revolutions, and none is along a line
        columns = dict(zip(members, _columns([trace.signals[n] for n in members], rotary=rotary), strict=True))
        parts = []
        for interval in sorted({trace.signals[n].interval for n in members}):
            same_rate = [n for n in members if trace.signals[n].interval == interval]
            rows = _instants(time, values[:, same_rate], interval)
            data = [time[rows], *(values[rows, n] for n in same_rate)]
            parts.append(SharedClock(Memory(path, (Column("time", "s"), *(columns[n] for n in same_rate)), data), 0))
        yield Joined(path, parts, trace.constants, about, said)


def _filled(trace: "_Trace", time: Real, values: Real) -> tuple[Real, Real]:
    """Return the trace with unchanged data filled in: missing values, and records where nothing changed."""
    order = np.argsort(time, kind="stable")
    time, values = time[order], values[order]
    step = min(signal.interval for signal in trace.signals if signal.interval)
    if not trace.lost:
        count = np.maximum(np.rint(np.diff(time) / step), 1)
        if count.sum() > MOST_FILLED:
            what = f"spans {time[-1] - time[0]:.4g} s at {step:.4g} s a sample"
            raise FricError(what, hint="Save the trace again, a shorter part of it.")
        source = np.concatenate([np.repeat(np.arange(len(count)), count.astype(int)), [len(time) - 1]])
        within = np.arange(len(source)) - np.concatenate([[0], np.cumsum(count)])[source]
        values = np.where((within == 0)[:, None], values[source], np.nan)
        time = time[source] + within * step
    last = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(len(time))[:, None], -1), axis=0)
    return time, np.where(last >= 0, np.take_along_axis(values, np.maximum(last, 0), axis=0), np.nan)


def _instants(time: Real, values: Real, interval: float) -> Indices:
    """Return the rows of signals of one interval: from the first that all have a value at."""
    if not len(there := np.flatnonzero(np.isfinite(values).all(axis=1))):
        return there
    phase = (time[there] - time[there[0]]) / interval if interval else np.zeros(len(there))
    return np.asarray(there[np.abs(phase - np.rint(phase)) < 0.25])


def _columns(signals: list[Signal], *, rotary: bool) -> list[Column]:
    """Return the columns of an axis: channels by their addresses, other signals by theirs."""
    taken: dict[str, int] = {}
    for channel, pattern in CHANNELS:
        for n, signal in enumerate(signals):
            unit = UNITS.get(signal.units, ("", ""))[rotary]
            along = channel != "velocity" or rotary or signal.units == "velo"  # a motor's speed is none of its axis
            if channel not in taken and unit and along and re.search(pattern, signal.address):
                taken[channel] = n
    motor = next((n for n, signal in enumerate(signals) if "ActPos1st" in signal.address), None)
    if motor is not None and "ActPos2nd" in signals[taken["position"]].address:
        taken |= {"position": motor, "load_position": taken["position"]}
    names = {n: channel for channel, n in taken.items()}
    return [
        Column(names.get(n) or signal.address or signal.description, UNITS.get(signal.units, (None, None))[rotary])
        for n, signal in enumerate(signals)
    ]


class _Trace:
    """The signals of a trace, read element by element: a row a record, NaN where a value lacks."""

    def __init__(self, path: Path) -> None:
        self.without, self.lost = 0, 0
        self.signals: list[Signal] = []
        self.constants: dict[str, str] = {}
        self.time, self.values = array("d"), array("d")
        self._at: dict[str, int] = {}
        parser = expat.ParserCreate()
        parser.StartElementHandler, parser.StartDoctypeDeclHandler = self._begin, PlainXML().doctype
        try:
            with path.open("rb") as file:
                parser.ParseFile(file)
        except (expat.ExpatError, LookupError, ValueError) as error:  # the others: an encoding that is unknown
            if error.__traceback__ is not None and error.__traceback__.tb_next is not None:  # of what reads an element
                raise
            raise FricError(f"is not complete XML ({error})", hint="Save the trace again.") from None

    def _begin(self, tag: str, about: dict[str, str]) -> None:
        if tag == "rec":
            self._record(about)
        elif tag == "dataSignal":
            if len(self.time):
                raise FricError("holds several frames", hint="Save them one by one.")
            n, address, interval = len(self.signals) + 1, about.get("name", ""), _number(about.get("interval"))
            description = about.get("description") or ("" if address else f"signal {n}")
            self._at[about.get("id") or f"f{n}"] = n - 1
            self.signals.append(Signal(address, description, interval, about.get("unitsType", "")))
        elif tag == "frameHeader":
            self.lost += int(_number(about.get("dropOuts")))
            self.constants |= {key: about[key] for key in ("startTime",) if key in about}

    def _record(self, about: dict[str, str]) -> None:
        row = [np.nan] * len(self.signals)
        try:
            if not abs(time := float(about.pop("time"))) <= LARGEST["time"]:
                raise ValueError
            for key, text in about.items():
                if key[0] == "f" and key[1:].isdigit():
                    value = float(text)
                    self.without += value > NO_VALUE
                    row[self._at[key]] = value
        except (KeyError, ValueError):
            raise FricError(f"has a rec that does not read: {dict(islice(about.items(), 9))}", hint=AGAIN) from None
        self.time.append(time)
        self.values.extend(row)


def _number(text: str | None) -> float:
    """Return a number that an attribute holds, 0 where it holds none."""
    found = number(text)
    return found if CLOSEST <= found <= LARGEST["time"] else 0.0
