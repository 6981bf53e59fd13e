"""Log files: HDF5 with ``fric = "log/1"``, one group a record, one chunked dataset a channel."""

import zlib
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from functools import cached_property
from itertools import chain, count
from pathlib import Path
from typing import Any, cast, get_args

import h5py
import numpy as np
from numpy.typing import NDArray

from fric.arrays import Real
from fric.columns import CHANNELS, FORCE_VELOCITY, KINDS, channel_dimension
from fric.errors import FricError, clean, found_in, printable, require_name
from fric.input import files_of
from fric.io.safe_hdf5 import check_type, members, open_file, staged_hdf5, text
from fric.io.safe_hdf5 import column as safe_column
from fric.log import ForceVelocity, FrequencyResponse, Log, Record, refuse_several_axes
from fric.output import alone
from fric.units import SI_UNITS, Motion, factor, si_unit

CHUNK = 65_536  # Samples a chunk: half a MiB of doubles
AHEAD = 2  # Chunks a column that may wait to be written
LEVEL = 1  # Of deflate: logs are mostly noise in their last digits, which a higher level does not shorten
SAMPLE = 512  # Samples from which the compression of more of their kind is estimated
WORTH = 0.25  # Share of the size above which data are stored without compression
_AS_IT_IS = 0b11  # Filter mask of a chunk that neither filter was applied to


class GrowingColumn:
    """One dataset that values are appended to.

    HDF5's filters (shuffle, deflate) run in a separate thread, while the next block is read, and only where they
    shorten a chunk.

    group, name: Where the dataset is made, once the first chunk is full; a shorter log gets a shorter chunk.
    unit: Its attribute ``unit``.
    thread: Packs and writes chunks; zlib and the file let go of the interpreter meanwhile.
    """

    def __init__(self, group: h5py.Group, name: str, unit: str, thread: ThreadPoolExecutor) -> None:
        self._group, self._name, self._unit, self._thread = group, name, unit, thread
        self._buffer, self._filled = np.empty(CHUNK, dtype="<f8"), 0
        self._jobs: deque[Future[None]] = deque()
        self._written, self._room, self._chunk = 0, 0, CHUNK

    def append(self, values: Real) -> None:
        """Add values."""
        while len(values):
            part = values[: CHUNK - self._filled]
            self._buffer[self._filled : self._filled + len(part)] = part
            self._filled, values = self._filled + len(part), values[len(part) :]
            if self._filled == CHUNK:
                self._jobs.append(self._thread.submit(self._write, self._buffer))
                self._buffer, self._filled = np.empty_like(self._buffer), 0
                self._wait(AHEAD)

    def close(self) -> None:
        """Write what is held."""
        self._wait(0)
        if not self._written:
            self._chunk = max(self._filled, 64)
        self._data.resize((self._written + self._filled,))
        self._data[self._written :] = self._buffer[: self._filled]

    def _wait(self, jobs: int) -> None:
        while len(self._jobs) > jobs:
            self._jobs.popleft().result()

    def _write(self, values: Real) -> None:
        chunk, mask = _packed(values)
        if self._written + CHUNK > self._room:
            self._room = max(2 * self._room, 8 * CHUNK)
            self._data.resize((self._room,))
        self._data.id.write_direct_chunk((self._written,), chunk, mask)
        self._written += CHUNK

    @cached_property
    def _data(self) -> h5py.Dataset:
        data = self._group.create_dataset(
            self._name, shape=(0,), maxshape=(None,), dtype="<f8", compression="gzip", compression_opts=LEVEL,
            shuffle=True, chunks=(self._chunk,),
        )  # fmt: skip
        data.attrs["unit"] = self._unit
        return data


def _packed(values: Real) -> tuple[bytes | Real, int]:
    """Shuffle and deflate one chunk, as HDF5's filters read it, unless a sample shows that it is noise, as the lower
    bytes of a measured channel, on which deflate spends most of an ingest; return it and its filter mask.
    """
    sample = _shuffled(values[:SAMPLE])
    if len(zlib.compress(sample.data, LEVEL)) > WORTH * sample.nbytes:
        return values, _AS_IT_IS
    return zlib.compress(_shuffled(values).data, LEVEL), 0


def _shuffled(values: Real) -> NDArray[np.uint8]:
    """Put the bytes of one significance side by side."""
    return np.ascontiguousarray(values.view(np.uint8).reshape(-1, 8).T)


FORMAT = "log/1"
MOST_NAME = 200  # Characters of the name of a record at most


class LogWriter:
    """An open log file that records are appended to, sample block by sample block.

    threads: Those that compress.
    check: Raises when a write has failed.
    """

    def __init__(
        self, file: h5py.File, axis: str, motion: Motion, threads: ThreadPoolExecutor, check: Callable[[], None]
    ) -> None:
        self.axis, self.motion, self.threads, self.check = axis, motion, threads, check
        if "fric" in file.attrs:
            if (held := check_format(file, Path(file.filename))) != (axis, motion):
                what = f"the file holds the {held[1]} axis {held[0]}, and the new record is of the {motion} axis {axis}"
                raise FricError(what, hint="Write each axis to a separate file, or say `axis=`.")
        else:
            file.attrs.update({"fric": FORMAT, "axis": axis, "motion": motion})
        self._records = file["records"] if "records" in file else file.create_group("records", track_order=True)

    def digests(self) -> dict[str, str]:
        """Return the names of the records in the file by their sha256."""
        found = {text(group.attrs, "sha256"): name for name, group in members(self._records)}
        return {digest: name for digest, name in found.items() if digest}

    def create(self, name: str, **attributes: str | int | None) -> "RecordWriter":
        """Start a record; a name that is taken gets a number."""
        # to HDF5 '20 mm/s' is a group in a group, and '.' the group that holds it
        name = printable(name.replace("/", "\N{DIVISION SLASH}"), MOST_NAME).strip(" .") or "record"
        names = chain([name], (f"{name}-{n}" for n in count(2)))
        group = self._records.create_group(next(name for name in names if name not in self._records))
        group.attrs.update(_whole(attributes))
        return RecordWriter(group, self, f"{FORCE_VELOCITY}." if attributes.get("kind") == FORCE_VELOCITY else "")

    def write(self, log: Record) -> None:
        """Append one whole record."""
        about: dict[str, Any] = {"source": log.source, "sha256": log.sha256}
        if isinstance(log, Log):
            about |= {"dropped": log.dropped or None, "labels": "\n".join(log.labels) or None}
        record = self.create(log.name, kind=log.kind, **about)
        record.extend(log.channels() if isinstance(log, Log) else log.columns())
        record.close()


class RecordWriter:
    """One record that is being written."""

    def __init__(self, group: h5py.Group, writer: LogWriter, prefix: str) -> None:
        self._group, self._writer, self._prefix = group, writer, prefix
        self._columns: dict[str, GrowingColumn] = {}
        self.name = str(group.name).rpartition("/")[2]

    def extend(self, block: Mapping[str, Real]) -> None:
        """Append the same number of samples to each channel (or column of a response), in SI."""
        for channel, values in block.items():
            if channel not in self._columns:
                unit = si_unit(channel_dimension(self._prefix + channel), self._writer.motion)
                self._columns[channel] = GrowingColumn(self._group, channel, unit, self._writer.threads)
            self._columns[channel].append(values)
        self._writer.check()

    def close(self, **attributes: str | int | None) -> None:
        """End the record, with attributes that are known only now; it is in the file from here on."""
        for column in self._columns.values():
            column.close()
        self._group.attrs.update(_whole(attributes))


def _whole(attributes: Mapping[str, str | int | None]) -> dict[str, str | int]:
    """Return the attributes that there are, as HDF5 takes them."""
    known = {key: value for key, value in attributes.items() if value is not None}
    return {key: clean(value) if isinstance(value, str) else value for key, value in known.items()}


def header_of(path: Path) -> tuple[str, Motion]:
    """Return name and motion of the axis of a log file."""
    with open_file(path) as file:
        return check_format(file, path)


@contextmanager
def log_writer(
    path: Path, *, axis: str, motion: Motion, append: bool = False, force: bool = False
) -> Iterator[LogWriter]:
    """Open a log file for writing; it appears under its name only when the block ends well.

    axis, motion: Name and motion of the axis; with ``append`` they must be those of the file.
    append: Keep what is in the file and add to it.
    """
    require_name(axis, str(path))
    with alone(path) if append else nullcontext():
        adding = append and path.exists()
        if adding:
            header_of(path)
        threads = ThreadPoolExecutor(1, thread_name_prefix="compress")
        with staged_hdf5(path, force=force, add=adding) as (file, check), threads:
            yield LogWriter(file, axis, motion, threads, check)


def write_logs(path: Path, logs: Sequence[Record], *, force: bool = False) -> None:
    """Write records of one axis to a new log file."""
    with log_writer(path, axis=logs[0].axis, motion=logs[0].motion, force=force) as writer:
        for log in logs:
            writer.write(log)


def check_format(file: h5py.File, path: Path) -> tuple[str, Motion]:
    """Return name and motion of the axis of an open HDF5 file."""
    check_type(file, path, FORMAT, "Give a log file that `fric ingest` wrote.")
    axis, motion, records = text(file.attrs, "axis"), text(file.attrs, "motion"), file.get("records")
    if motion not in get_args(Motion):
        what = f"is of an axis whose motion is '{motion}', and not linear or rotary"
        raise FricError(what, where=str(path), hint="Make it again with `fric ingest`.")
    if not isinstance(records, h5py.Group) or not len(records):
        raise FricError("holds no record", where=str(path), hint="Add one with `fric ingest --append`.")
    for name, group in members(records):
        if not isinstance(group, h5py.Group):
            raise FricError(f"is damaged: record '{name}' is not a group", where=str(path), hint="Make it again.")
    return require_name(axis, str(path)), cast("Motion", motion)


def read_records(path: Path) -> list[Record]:
    """Read every record of a log file, in the order of their names as written."""
    with open_file(path) as file:
        axis, motion = check_format(file, path)
        common = {"axis": axis, "motion": motion}
        return [_read(name, group, common, path) for name, group in members(file["records"])]


def read_logs(paths: Iterable[Path] | Path) -> list[Log]:
    """Read the records in time of one or more log files of one axis."""
    paths = files_of(paths)
    if not (logs := [record for path in paths for record in read_records(path) if isinstance(record, Log)]):
        raise FricError(
            "holds no record in time", where=", ".join(map(str, paths)),
            hint="Give a log of samples, as `fric ingest` writes it.",
        )  # fmt: skip
    refuse_several_axes(logs)
    return logs


def _read(name: str, group: h5py.Group, common: Mapping[str, Any], path: Path) -> Record:
    motion: Motion = common["motion"]
    attributes = {"name": name, "source": str(path), "sha256": text(group.attrs, "sha256"), **common}

    def column(key: str, dimension: str) -> Real | None:
        if key not in group:
            return None
        values, unit = safe_column(group, key), text(group[key].attrs, "unit", si_unit(dimension, motion))
        with found_in(f"{path}, record '{name}', {key}"):
            return values if unit in SI_UNITS[dimension] else values * factor(unit, dimension, motion)

    kind = text(group.attrs, "kind") or None
    form = FrequencyResponse if "frequency" in group else ForceVelocity if kind == FORCE_VELOCITY else None
    if form is not None:
        table: dict[str, Any] = {key: column(key, dimension) for key, dimension in form.dimensions.items()}
        return form(**table, **attributes)
    if kind is not None and kind not in KINDS:
        raise FricError(f"record '{name}' is of unknown kind '{kind}'", where=str(path))
    channels = {channel: column(channel, channel_dimension(channel)) for channel in CHANNELS}
    labels = tuple(filter(None, text(group.attrs, "labels").split("\n")))
    dropped = whole(text(group.attrs, "dropped"))
    return Log(**cast("Any", channels), kind=kind, dropped=dropped, labels=labels, **attributes)


def whole(words: str) -> int:
    """Return a whole number that is written so; 0 of anything else."""
    return int(words) if words.isdecimal() else 0
