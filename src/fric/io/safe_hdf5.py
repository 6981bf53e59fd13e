"""HDF5 files as they come from anywhere: what leads out of the file, or is not there, is refused before it is read."""

import os
import re
import shutil
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from shlex import join
from typing import IO, Any

import h5py
import numpy as np

from fric.arrays import Real
from fric.errors import FricError, printable
from fric.input import TAKEN, foreign, other_kind, refuse_declared, regular
from fric.output import refuse_ending, staged


class Unfailing:
    """A file for HDF5's ``fileobj`` driver that keeps errors until `check` raises them.

    HDF5 does not survive a write that fails: it repeats the write when the file is closed, and the process ends in a
    segmentation fault. So a failed write is noted and later writes are skipped; the file is lost, and `check` raises
    the reason. What reads, seeks and flushes is the file's.

    file: Open for reading and writing, in bytes, without a buffer.
    """

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._failed: BaseException | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)

    def check(self) -> None:
        """Raise the error that a write has met, if any."""
        if self._failed is not None:
            raise self._failed

    def write(self, data: memoryview) -> int:
        """Write all of the bytes, or note why not."""

        def whole() -> int:
            rest = memoryview(data).cast("B")
            while len(rest):
                rest = rest[self._file.write(rest) :]
            return len(data)

        return self._kept(whole, len(data))

    def truncate(self, size: int | None = None) -> int:
        """Set the length of the file."""
        return self._kept(partial(self._file.truncate, size), size or 0)

    def readinto(self, buffer: memoryview) -> int:
        """Read; what was never written reads as zeros."""
        view = memoryview(buffer).cast("B")
        found = self._file.read(len(view))
        view[: len(found)] = found
        view[len(found) :] = bytes(len(view) - len(found))
        return len(view)

    def _kept(self, act: Callable[[], int], otherwise: int) -> int:
        if self._failed is None:
            try:
                return act()
            except BaseException as error:  # an interrupt too: an exception must not pass through HDF5
                self._failed = error
        return otherwise


@contextmanager
def _interrupts_held() -> Iterator[Callable[[], None]]:
    """Hold SIGINT and SIGTERM back, and give a function that lets them through where it is called: an exception that
    strikes inside h5py is lost there, or leaves the file half closed.
    """
    if threading.current_thread() is not threading.main_thread():  # the only thread that signals reach
        yield lambda: None
        return
    came: list[int] = []
    usual = {n: signal.signal(n, lambda number, _: came.append(number)) for n in (signal.SIGINT, signal.SIGTERM)}

    def let_through() -> None:
        for number, handler in usual.items():
            if number in came:
                came.clear()
                signal.signal(number, handler)
                signal.raise_signal(number)

    try:
        yield let_through
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler)
    let_through()


@contextmanager
def staged_hdf5(path: Path, *, force: bool, add: bool = False) -> Iterator[tuple[h5py.File, Callable[[], None]]]:
    """Open an HDF5 file for writing that takes its name only when the block ends well.

    add: Begin with what is in the file. Yields the file, and a function to call now and then: it raises when a write
        has failed, or Ctrl-C was pressed.
    """
    refuse_ending(path, "HDF5")
    with staged(path, force=force or add) as draft:
        if add:
            shutil.copyfile(path, draft)
        with draft.open("r+b", buffering=0) as raw:
            kept = Unfailing(raw)
            with _interrupts_held() as let_through, h5py.File(kept, "r+" if add else "w") as file:

                def check() -> None:
                    let_through()
                    kept.check()

                yield file, check
            kept.check()


def write_column(group: h5py.Group, name: str, values: Real, unit: str) -> None:
    """Write a dataset, compressed, with its unit."""
    group.create_dataset(name, data=values, compression="gzip", compression_opts=1, shuffle=True).attrs["unit"] = unit


MOST_OBJECTS = 200_000  # Groups and datasets of a file at most
MOST_EMPTY, EMPTY = 256 << 20, 100  # Bytes that a dataset may unpack to if a byte becomes so many; usual are ten
MOST_DEPTH = 32  # Groups in groups at most
MOST_READ = 512 << 20  # Bytes of samples of a file that is read into memory as a whole, which takes some times as much
BLOCK, _HEAP = 16 << 20, b"GCOL\1\0\0\0"  # Bytes that are searched at once for the begin of a heap
_PLAIN = (h5py.h5t.STRING, h5py.h5t.INTEGER, h5py.h5t.FLOAT, h5py.h5t.ENUM)


@contextmanager
def open_file(
    path: Path, what: str = "is an incomplete HDF5 file", hint: str = "Make it again with `fric ingest`.", *,
    most: int = MOST_READ, wanted: str = "log",
) -> Iterator[h5py.File]:  # fmt: skip
    """Open an HDF5 file for reading, with errors a user can act on; what h5py raises in it is damage of the file.

    most: Bytes of samples that it holds at most.
    wanted: The kind of file that is needed, for the error of another.
    """
    regular(path)
    _check_heaps(path, hint)
    try:
        file = h5py.File(path, "r")
    except PermissionError:
        raise FricError("may not be read", where=str(path), hint="Ask its owner for leave to read it.") from None
    except Exception:  # any exception of h5py on a damaged file
        if not path.stat().st_size:
            raise FricError("is empty", where=str(path), hint=hint) from None
        with path.open("rb") as file:
            what = what if file.read(4) == b"\x89HDF" else what.replace("an incomplete", "no")
        if what.endswith("HDF5 file") and path.suffix.lower() not in {".h5", ".hdf5"}:
            with path.open("rb") as head:
                kind = re.search(rb"(?m)^fric: (\w+)/", head.read(4096))
            if kind and kind[1].decode() in TAKEN:
                raise other_kind(path, kind[1].decode(), wanted) from None
            what = "is not a log file of fric"
            hint = f"Make one of it: `{join(['fric', 'ingest', str(path), '-o', 'log.h5'])}`."
        raise FricError(what, where=str(path), hint=hint) from None
    with foreign(path, hint), file:
        _check(file, path, most)
        yield file


def _check_heaps(path: Path, hint: str) -> None:
    """Refuse a heap of texts whose objects do not lead on to its end: HDF5 would loop in it for ever."""
    if not os.access(path, os.R_OK):
        return
    size = path.stat().st_size
    with path.open("rb") as file:
        for at in list(_heaps(file)):
            file.seek(at + 8)
            end, place = at + int.from_bytes(file.read(8), "little"), at + 16
            while place + 16 <= min(end, size):
                file.seek(place)
                head = file.read(16)
                taken = int.from_bytes(head[8:], "little")
                step = taken if head[:2] == b"\0\0" else 16 + -(-taken // 8) * 8  # the free rest has no head
                if not 16 <= step <= end - place:
                    raise FricError("is damaged: texts in it have no end", where=str(path), hint=hint)
                place += step


def _heaps(file: IO[bytes]) -> Iterator[int]:
    """Yield where heaps of texts begin, by blocks: a file that is mapped as a whole counts as memory."""
    begin, held = 0, b""
    while block := file.read(BLOCK):
        held += block
        at = held.find(_HEAP)
        while at >= 0:
            yield begin + at
            at = held.find(_HEAP, at + 1)
        begin, held = begin + len(held) - len(_HEAP) + 1, held[1 - len(_HEAP) :]


def _check(file: h5py.File, path: Path, most: int) -> None:
    """Walk through all of a file, and refuse what is not in it, and samples of more bytes than ``most``."""
    pending: list[tuple[h5py.Group, int]] = [(file, 0)]
    seen: set[Any] = set()
    _check_attributes(file, str(path))
    while pending:
        group, depth = pending.pop()
        if depth > MOST_DEPTH or len(seen) > MOST_OBJECTS:
            raise FricError(
                f"nests deeper than {MOST_DEPTH} groups or holds over {MOST_OBJECTS} objects", where=str(path),
                hint="Export the log again.",
            )  # fmt: skip
        for name in group:
            where = f"{path}, '{printable(f'{group.name}/{name}'.replace('//', '/'), 80)}'"
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                raise FricError("is a link, which may lead to another file", where=where, hint="Store the data itself.")
            node = group[name]
            if (mark := h5py.h5o.get_info(node.id).addr) in seen:
                continue
            seen.add(mark)
            _check_attributes(node, where)
            if isinstance(node, h5py.Group):
                pending.append((node, depth + 1))
            elif isinstance(node, h5py.Dataset) and (most := most - _check_dataset(node, where)) < 0:
                raise FricError(
                    "holds more samples than are read at once", where=str(path),
                    hint="Take a part of it: fric ingest LOG.h5 --from 0s --to 60s -o part.h5.",
                )  # fmt: skip


def _check_attributes(node: Any, where: str) -> None:
    """Refuse attributes that are no texts or numbers: HDF5 ends the process where a list's type is damaged."""
    for name in node.attrs:
        kind = node.attrs.get_id(name).get_type().get_class()
        if kind not in _PLAIN and name != "MATLAB_fields":  # which nobody reads
            raise FricError(
                f"is damaged: its attribute '{printable(name, 80)}' is neither a text nor a number", where=where,
                hint="Make the file again.",
            )  # fmt: skip


def _check_dataset(data: h5py.Dataset, where: str) -> int:
    """Return the bytes that a dataset holds, where it can be read."""
    if data.id.get_type().get_class() == h5py.h5t.VLEN:
        raise FricError("is damaged: it holds lists, not numbers", where=where, hint="Make the file again.")
    if _leads_elsewhere(data):
        raise FricError("takes its values from another file", where=where, hint="Store the data itself.")
    declared, stored = data.size * data.dtype.itemsize if data.size else 0, data.id.get_storage_size()
    refuse_declared(where, declared, stored)
    if declared > max(MOST_EMPTY, EMPTY * stored):
        raise FricError(
            f"unpacks {stored / 1e6:.3g} MB to {declared / 1e6:.3g} MB of samples, which are hardly a log", where=where,
            hint="Log a shorter time.",
        )  # fmt: skip
    return int(declared)


def _leads_elsewhere(data: h5py.Dataset) -> bool:
    """Return whether the values are in other files.

    The property list is released with this call: HDF5 ends a process by a segmentation fault where the list of a
    virtual dataset is alive at its end. `Dataset.is_virtual` keeps it, and a traceback keeps that.
    """
    properties = data.id.get_create_plist()
    return bool(properties.get_layout() == h5py.h5d.VIRTUAL or properties.get_external_count())


def column(group: h5py.Group, name: str, *, ndim: int = 1) -> Real:
    """Return a dataset of numbers, checked before it is used."""
    data = group.get(name) if isinstance(group, h5py.Group) else None
    where = f"{group.file.filename}, '{printable(f'{group.name}/{name}', 80)}'"
    if not isinstance(data, h5py.Dataset):
        raise FricError("is damaged: there is no such dataset", where=where, hint="Make the file again.")
    if data.shape is None or len(data.shape) != ndim or data.dtype.kind not in "fiub":
        text = "nothing" if data.shape is None else f"{len(data.shape)} dimensions of {data.dtype}"
        raise FricError(f"is damaged: it has {text}, not {ndim} of numbers", where=where, hint="Make the file again.")
    return np.asarray(data[...], np.float64)


def check_type(file: h5py.File, path: Path, wanted: str, hint: str) -> None:
    """Raise when an open file does not state the required type, as ``log/1``."""
    if (found := text(file.attrs, "fric", "nothing of fric's")) != wanted:
        if found.partition("/")[0] in TAKEN:
            raise other_kind(path, found, wanted)
        raise FricError(f"holds {found}, not {wanted}", where=str(path), hint=hint)


def members(group: Any) -> list[tuple[str, Any]]:
    """Return the names and values of a group, or of attributes.

    The views of h5py hold its lock until their loop ends: an error that ends it, and is kept, would block all threads.
    """
    return list(group.items())


def text(attributes: Any, name: str, otherwise: str = "") -> str:
    """Return an attribute that is a text; ``otherwise`` where it is missing or no text."""
    value = attributes.get(name, otherwise)
    value = otherwise if isinstance(value, h5py.Empty) else value
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    return text.encode("utf-8", "replace").decode("utf-8")  # h5py reads what is no UTF-8 as surrogates
