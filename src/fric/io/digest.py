"""The sha256 of a file, by which a record that is there already is known."""

import hashlib
from collections import deque
from collections.abc import Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from fric.errors import FricError
from fric.input import regular

BEHIND = 4
"""Pieces of a file that its digest may lag behind."""


def digest_of(path: Path) -> str:
    """Return the sha256 of a file."""
    try:
        with regular(path).open("rb") as file:  # a device has no end
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise FricError(f"cannot be read: {error.strerror}", where=str(path)) from None


def digest_of_all(paths: Iterable[Path]) -> str:
    """Return the sha256 of files that make one record: of their digests, one after the other."""
    return hashlib.sha256("".join(map(digest_of, paths)).encode()).hexdigest()


class FileDigest:
    """The digest of a file: of its bytes as they are read, or else of the file read for that alone.

    Parameters
    ----------
    path
        The file.
    beside
        A single thread, which takes the bytes in while the work goes on.
    """

    def __init__(self, path: Path, beside: ThreadPoolExecutor) -> None:
        self._path, self._beside = path, beside
        self._sum = hashlib.sha256()
        self._taken: deque[Future[None]] = deque()
        self._found: str | None = None

    def take(self, content: bytes) -> None:
        """Take the next bytes of the file into the sum, in a thread beside the work."""
        self._taken.append(self._beside.submit(self._sum.update, content))
        if len(self._taken) > BEHIND:
            self._taken.popleft().result()

    def result(self) -> str:
        """Return the digest of the whole file."""
        if self._found is None:
            for taken in self._taken:
                taken.result()
            self._found = self._sum.hexdigest() if self._taken else digest_of(self._path)
        return self._found
