"""National Instruments' TDMS files, through npTDMS (the extra ``tdms``)."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fric.arrays import Real
from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.flaws.files import CHANNELS_WITHOUT_TIME
from fric.input import refuse_declared
from fric.io.readers.base import Column, ForeignTable, Format, Memory, heard, library, named, numbers
from fric.io.readers.joined import Joined, SharedClock
from fric.io.words import named_as
from fric.notice import Notice
from fric.series import LARGEST
from fric.units import factor

FORMAT = Format("TDMS", (".tdms",), "nptdms", "tdms")
UNITS = ("unit_string", "NI_UnitDescription", "Unit", "unit")  # Properties with a channel's unit, tried in this order


def recognises(path: Path, head: bytes) -> float:
    """TDMS begins with its signature."""
    return float(head.startswith(b"TDSm"))


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read a TDMS file: a record a group where the groups hold the same channels, else one of all on a common clock."""
    nptdms = library(FORMAT)
    with heard(FORMAT, path) as notices, path.open("rb") as content, nptdms.TdmsFile.open(content) as file:
        constants = {str(key): str(value) for key, value in file.properties.items()}
        every = {group.name: list(filter(_is_number, group.channels())) for group in file.groups()}
        groups = {name: channels for name, channels in every.items() if channels}
        odd = (_column(channel) for group in file.groups() for channel in group.channels() if not _is_number(channel))
        if lost := [f"'{column.name}'" for column in odd if named_as(column)]:
            notices.append(CHANNELS_WITHOUT_TIME.found(str(path), channels=lost))
        refuse_declared(path, sum(8 * len(channel) for channels in groups.values() for channel in channels))
        names = [[channel.name for channel in channels] for channels in groups.values()]
        apart = len(groups) > 1 and all(name == names[0] for name in names)
        for gathered in [[group] for group in groups] if apart else [list(groups)]:
            channels = {name: groups[name] for name in gathered}
            yield _table(path, channels, constants, {"name": gathered[0]} if apart else {}, notices)


def _is_number(channel: Any) -> bool:
    return channel.dtype is not None and np.dtype(channel.dtype).kind in "fiubM" and len(channel) > 0


def _table(
    path: Path, groups: dict[str, list[Any]], constants: dict[str, str], said: dict[str, str], notices: list[Notice]
) -> ForeignTable:
    """Return groups as one table: a waveform has a separate clock, other channels that of their group's time."""
    clocks: dict[tuple[Any, ...], list[Any]] = {}
    for name, channels in groups.items():
        for channel in channels:
            step, offset, start = _clock(channel.properties)
            begun = (start, offset)
            clocks.setdefault((name, len(channel), step, *(begun if step > 0 else (None, 0.0))), []).append(channel)
    first = min((begun for _, _, _, begun, _ in clocks if begun is not None), default=None)
    parts, without = [], list[Memory]()
    for (name, _, step, begun, offset), members in clocks.items():
        columns, data = tuple(map(_column, members)), list(map(_Channel, members))
        if step > 0:
            start = offset + (float((begun - first) / np.timedelta64(1, "ns")) * 1e-9 if begun is not None else 0.0)
            time = start + step * np.arange(len(data[0]))
            parts.append(SharedClock(Memory(path, (Column("time", "s"), *columns), [time, *data]), 0, label=name))
            continue
        table = Memory(path, columns, data)
        if (at := next((n for n, column in enumerate(columns) if named_as(column) == "time"), None)) is None:
            without.append(table)
        else:
            parts.append(SharedClock(table, at, factor=factor(columns[at].unit or "s", "time"), label=name))
    if not parts and len(without) == 1:
        return without[0]  # a mapping may state its rate
    if not parts:
        raise FricError("holds no channel of numbers over time", hint="Export it with its time.")
    if lost := [f"'{column.name}'" for table in without for column in table.columns]:
        notices.append(CHANNELS_WITHOUT_TIME.found(str(path), channels=lost))
    return Joined(path, parts, constants, said, notices)


def _clock(about: Mapping[str, Any]) -> tuple[float, float, np.datetime64 | None]:
    """Return step and offset of a waveform's clock [s], and when it began; 0 and None where they are missing."""
    stated = (about.get("wf_increment"), about.get("wf_start_offset"))
    step, offset = (float(v) if isinstance(v, int | float) and abs(v) < LARGEST["time"] else 0.0 for v in stated)
    begun = about.get("wf_start_time")
    return step, offset, begun if isinstance(begun, np.datetime64) else None


class _Channel:
    """The values of a channel, read when it is sliced."""

    def __init__(self, channel: Any) -> None:
        self._channel = channel

    def __len__(self) -> int:
        return len(self._channel)

    def __getitem__(self, part: slice) -> Real:
        start, stop, _ = part.indices(len(self))
        return numbers(self._channel.read_data(start, stop - start))


def _column(channel: Any) -> Column:
    name, unit = named(channel.name)
    said = next((str(channel.properties[key]).strip() for key in UNITS if channel.properties.get(key)), None)
    return Column(name, said or unit)
