"""ASAM MDF 4 measurements (``.mf4``), through asammdf (the extra ``mf4``)."""

import gc
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from traceback import clear_frames
from typing import Any

import numpy as np

from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.input import refuse_declared
from fric.io.readers.base import BLOCK, Column, ForeignTable, Format, RowBlock, heard, library, numbers
from fric.io.readers.joined import Joined, SharedClock

FORMAT = Format("MDF 4", (".mf4",), "asammdf", "mf4")
NUMBERS = range(6)  # Data types of MDF 4 that are numbers: integers and floats, of either byte order


def recognises(path: Path, head: bytes) -> float:
    """A measurement begins with its signature, finished or not."""
    return float(head.startswith((b"MDF     4", b"UnFinMF 4")))


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read a measurement: one table; its groups, each with a separate time, are resampled to a common clock."""
    asammdf = library(FORMAT)
    with heard(FORMAT, path) as notices, path.open("rb") as file:
        head = file.read(68)
        if head[64:] != b"##HD":
            raise FricError("is not a complete measurement", hint="Export it again.")
        # the library copies an unfinished measurement, and finishes the copy
        with _opened(asammdf, path if head.startswith(b"UnFin") else file) as measurement:
            sizes = [group.channel_group for group in measurement.groups]
            refuse_declared(path, sum(size.cycles_nr * (size.samples_byte_nr + 8) for size in sizes))
            for group, size in zip(measurement.groups, sizes, strict=True):  # compiled code reads there without a look
                for channel in group.channels:
                    if 8 * channel.byte_offset + channel.bit_offset + channel.bit_count > 8 * size.samples_byte_nr:
                        what = f"is damaged: channel '{channel.name}' begins beyond its records"
                        raise FricError(what, hint="Export it again.")
            parts = [part for n in range(len(sizes)) if (part := _part(path, measurement, n)) is not None]
            if not parts:
                raise FricError("holds no channel of numbers over time", hint="Export it again.")
            yield Joined(path, parts, {"start": str(measurement.start_time)}, notices=notices)


def _opened(asammdf: Any, source: Any) -> Any:
    """Open a measurement; what cannot be opened is let go of without the words of its finaliser on standard error."""
    try:
        return asammdf.MDF(source)
    except Exception as error:
        hook, sys.unraisablehook = sys.unraisablehook, lambda _: None
        cause: BaseException | None = error
        try:
            while cause is not None:
                clear_frames(cause.__traceback__)
                cause = cause.__context__
            gc.collect()
        finally:
            sys.unraisablehook = hook
        raise


def _part(path: Path, measurement: Any, number: int) -> SharedClock | None:
    """Return a group of channels as a part; None where it has no time, no numbers or no samples."""
    group = measurement.groups[number]
    master = measurement.masters_db.get(number)
    wanted = [
        n for n, channel in enumerate(group.channels)
        if n != master and channel.data_type in NUMBERS and not group.channel_dependencies[n]
    ]  # fmt: skip
    if master is None or not wanted or not group.channel_group.cycles_nr:
        return None
    label = group.channel_group.acq_name or f"group {number}"
    return SharedClock(_Group(path, measurement, number, wanted), 0, label=label)


class _Group(ForeignTable):
    """The channels of a group, physical values, with its time as column 0."""

    def __init__(self, path: Path, measurement: Any, number: int, channels: Sequence[int]) -> None:
        group = measurement.groups[number]
        named = [Column(group.channels[n].name, group.channels[n].unit.strip() or None) for n in channels]
        super().__init__(path, [Column("time", "s"), *named])
        self._measurement, self._group, self._channels = measurement, number, tuple(channels)
        self._samples = int(group.channel_group.cycles_nr)

    def blocks(self, wanted: Sequence[int]) -> Iterator[RowBlock]:
        """Read the group record by record."""
        channels = [n for n in dict.fromkeys(wanted) if n] or [1]
        asked = [(None, self._group, self._channels[n - 1]) for n in channels]
        for row in range(0, self._samples, BLOCK):
            found = self._measurement.select(
                asked, record_offset=row, record_count=min(BLOCK, self._samples - row), copy_master=False,
                ignore_value2text_conversions=True,
            )  # fmt: skip
            by_column = {0: found[0].timestamps}
            for n, item in zip(channels, found, strict=True):
                invalid = False if item.invalidation_bits is None else np.asarray(item.invalidation_bits, dtype=bool)
                by_column[n] = np.where(invalid, np.nan, numbers(item.samples))
            yield RowBlock(row, [by_column[n] for n in wanted], sum(item.samples.nbytes for item in found))
