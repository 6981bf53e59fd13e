"""Columns of a log file that grow: whole chunks are compressed beside the work, and written as they are."""

import zlib
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from functools import cached_property

import h5py
import numpy as np
from numpy.typing import NDArray

from fric.arrays import Real

Buffer = bytes | Real

CHUNK = 65_536
"""Samples a chunk: half a MiB of doubles."""
AHEAD = 2
"""Chunks a column that may wait to be written."""
LEVEL = 1
"""Of deflate: logs are mostly noise in their last digits, which a higher level does not shorten."""

SAMPLE = 512
"""Samples that tell how far more of their kind can be shortened."""
WORTH = 0.25
"""What cannot be shortened to this is stored as it is."""

_AS_IT_IS = 0b11
"""Filter mask of a chunk that neither filter was applied to."""


def compressor() -> ThreadPoolExecutor:
    """Return the thread that packs and writes chunks; zlib and the file let go of the interpreter meanwhile."""
    return ThreadPoolExecutor(1, thread_name_prefix="compress")


class GrowingColumn:
    """One dataset that values are appended to.

    HDF5's own filters (shuffle, deflate) are applied in a thread beside the work, so that reading the next block goes
    on, and only where they shorten a chunk.

    Parameters
    ----------
    group, name
        Where the dataset is made, once the first chunk is full; a shorter log gets a shorter chunk.
    unit
        Its attribute ``unit``.
    thread
        See `compressor`.
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


def _packed(values: Real) -> tuple[Buffer, int]:
    """Shuffle and deflate one chunk, as HDF5's filters read it; return it and its filter mask.

    The lower bytes of a measured channel are noise, on which deflate spends most of the time of an ingest for little.
    A chunk of which a sample tells so is left as it is.
    """
    sample = _shuffled(values[:SAMPLE])
    if len(zlib.compress(sample.data, LEVEL)) > WORTH * sample.nbytes:
        return values, _AS_IT_IS
    return zlib.compress(_shuffled(values).data, LEVEL), 0


def _shuffled(values: Real) -> NDArray[np.uint8]:
    """Put the bytes of one significance side by side."""
    return np.ascontiguousarray(values.view(np.uint8).reshape(-1, 8).T)
