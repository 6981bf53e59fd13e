"""HDF5 outputs, whole or not at all, also on a disk that fills up."""

import shutil
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import h5py

from fric.arrays import Real
from fric.output import staged


class Unfailing:
    """A file for HDF5's ``fileobj`` driver that keeps errors to itself until they are asked for.

    HDF5 does not survive a write that fails: what it could not write it tries again when the file is closed, and the
    process ends in a segmentation fault. So a failed write is noted and later ones are passed over; the file is lost,
    and `check` says why.

    Parameters
    ----------
    file
        Open for reading and writing, in bytes, without a buffer.
    """

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._failed: BaseException | None = None

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
        return self._kept(lambda: self._file.truncate(size), size or 0)

    def flush(self) -> None:
        """Nothing is buffered here."""

    def readinto(self, buffer: memoryview) -> int:
        """Read; what was never written reads as zeros."""
        view = memoryview(buffer).cast("B")
        found = self._file.read(len(view))
        view[: len(found)] = found
        view[len(found) :] = bytes(len(view) - len(found))
        return len(view)

    def read(self, size: int = -1) -> bytes:
        """Read; h5py knows a file by having this."""
        return self._file.read(size)

    def seek(self, offset: int, whence: int = 0) -> int:
        """Move."""
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        """Return where the file stands."""
        return self._file.tell()

    def _kept(self, act: Callable[[], int], otherwise: int) -> int:
        if self._failed is None:
            try:
                return act()
            except BaseException as error:  # an interrupt too: an exception must not pass through HDF5
                self._failed = error
        return otherwise


@contextmanager
def _interrupts_held() -> Iterator[Callable[[], None]]:
    """Hold Ctrl-C and a polite kill back, and give a function that lets them through where it is called.

    An exception that strikes inside h5py is lost there, or leaves the file half closed.
    """
    if threading.current_thread() is not threading.main_thread():  # the only one that signals reach
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
def staged_hdf5(
    path: Path, *, force: bool = False, add: bool = False
) -> Iterator[tuple[h5py.File, Callable[[], None]]]:
    """Open an HDF5 file for writing that takes its name only when the block ends well.

    path: The file.
    force: Replace a file that exists.
    add: Begin with what is in the file.
    Yields the file, and a function to call now and then: it raises when a write has failed, or Ctrl-C was pressed.
    """
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
    dataset = group.create_dataset(name, data=values, compression="gzip", compression_opts=1, shuffle=True)
    dataset.attrs["unit"] = unit
