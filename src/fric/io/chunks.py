"""Columns of a log file that grow: whole chunks are compressed beside the work, and written as they are."""

from __future__ import annotations

import zlib
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING

import h5py
import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

CHUNK = 65_536
"""Samples a chunk: half a MiB of doubles."""
AHEAD = 4
"""Chunks a column that may wait to be written."""
LEVEL = 1
"""Of deflate: logs are mostly noise in their last digits, which a higher level does not shorten."""

SAMPLE = 2048
"""Bytes that tell how far more of their kind can be shortened."""
WORTH = 0.5
"""What cannot be shortened to this is stored as it is."""


def compressor() -> ThreadPoolExecutor:
    """Return the thread that compresses; zlib lets go of the interpreter meanwhile."""
    return ThreadPoolExecutor(1, thread_name_prefix="compress")


class GrowingColumn:
    """One dataset that values are appended to.

    HDF5's own filter pipeline compresses in the thread that writes; here the same filters (shuffle, deflate) are
    applied in threads, so that reading the next block goes on.

    Parameters
    ----------
    group, name
        Where the dataset is made.
    unit
        Its attribute ``unit``.
    first
        Values in the first block; a shorter log gets a shorter chunk.
    threads
        See `compressor`.
    """

    def __init__(self, group: h5py.Group, name: str, unit: str, first: int, threads: ThreadPoolExecutor) -> None:
        self._chunk = min(max(first, 64), CHUNK)
        self._data = group.create_dataset(
            name, shape=(0,), maxshape=(None,), dtype="<f8", chunks=(self._chunk,), compression="gzip",
            compression_opts=LEVEL, shuffle=True,
        )  # fmt: skip
        self._data.attrs["unit"] = unit
        self._threads = threads
        self._held: list[NDArray[np.float64]] = []
        self._jobs: deque[Future[bytes]] = deque()
        self._written = self._room = 0

    def append(self, values: NDArray[np.float64]) -> None:
        """Add values."""
        self._held.append(np.asarray(values, dtype="<f8"))
        if sum(map(len, self._held)) < self._chunk:
            return
        joined = np.concatenate(self._held)
        whole = len(joined) - len(joined) % self._chunk
        for start in range(0, whole, self._chunk):
            self._jobs.append(self._threads.submit(_compressed, joined[start : start + self._chunk]))
            self._write(AHEAD)
        self._held = [joined[whole:].copy()]

    def close(self) -> None:
        """Write what is held."""
        self._write(0)
        rest = np.concatenate(self._held) if self._held else np.empty(0)
        self._data.resize((self._written + len(rest),))
        if len(rest):
            self._data[self._written :] = rest
        self._held = []

    def _write(self, waiting: int) -> None:
        while len(self._jobs) > waiting:
            chunk = self._jobs.popleft().result()
            if self._written + self._chunk > self._room:
                self._room = max(2 * self._room, 8 * self._chunk)
                self._data.resize((self._room,))
            self._data.id.write_direct_chunk((self._written,), chunk)
            self._written += self._chunk


def _compressed(values: NDArray[np.float64]) -> bytes:
    """Shuffle and deflate one chunk, as HDF5's filters read it.

    After the shuffle the bytes of one significance lie together, and the lower ones of a measured channel are noise,
    on which deflate spends most of its time for nothing. So each is a deflate block of its own, and noise is stored.
    """
    planes = np.ascontiguousarray(values).view(np.uint8).reshape(-1, 8).T
    raw, stream = planes.tobytes(), [b"\x78\x01"]  # zlib's header (RFC 1950)
    for significance in range(8):
        plane = raw[significance * len(values) : (significance + 1) * len(values)]
        sample = plane[:SAMPLE]
        noise = len(zlib.compress(sample, LEVEL)) > WORTH * len(sample)
        deflate = zlib.compressobj(0 if noise else LEVEL, zlib.DEFLATED, -zlib.MAX_WBITS)
        last = zlib.Z_FINISH if significance == 7 else zlib.Z_FULL_FLUSH
        stream += [deflate.compress(plane), deflate.flush(last)]
    return b"".join([*stream, zlib.adler32(raw).to_bytes(4, "big")])
