"""Text logs: CSV, TSV, with whatever delimiter, decimal mark, preamble and encoding; also ``.gz``."""

import gzip
import re
import zlib
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from itertools import chain, islice, repeat
from pathlib import Path
from typing import IO, Any

import numpy as np
import pandas as pd

from fric.arrays import Real
from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.io.readers.base import Block, Format, Table
from fric.io.readers.sniff import Shape, is_number, shape_of, split

THREADS = 2
"""Pieces that are parsed at once."""
PIECE = 2 << 20
"""Bytes that are parsed at a time."""
AHEAD = 4
"""Pieces that may wait, parsed or not."""
LOOK = 32_768
"""Bytes at the beginning that are looked at to find how the file is written."""
MOST_PACKED, SMALL = 200, 64 << 20
"""Bytes that a packed byte of text becomes at most, and bytes that any packed file may hold."""
MOST_LINE = 2 << 20
"""Bytes of a line at most."""
MOST_EMPTY = 256
"""Empty cells behind those of the header that a row may have."""

_GZIP = b"\x1f\x8b"

FORMAT = Format("Text", (".csv", ".tsv", ".txt", ".dat", ".log", ".gz"))


def recognises(path: Path, head: bytes) -> float:
    """Text holds no zero byte, unless it is UTF-16; any other reader that knows the file is surer."""
    wide = head.startswith((b"\xff\xfe", b"\xfe\xff"))
    return 0.1 * (head.startswith(_GZIP) or wide or b"\0" not in head)


def tables(path: Path, layout: Layout) -> Iterator[Table]:
    """Read a text log: one table."""
    head, zipped = beginning(path)
    yield TextTable(path, shaped(path, head, layout), layout, zipped)


def beginning(path: Path) -> tuple[bytes, bool]:
    """Return the first bytes of a text, unpacked, and whether it is packed by gzip."""
    zipped = _is_zipped(path)
    try:
        with _opened(path, zipped) as file:
            return file.read(LOOK), zipped
    except (OSError, EOFError, zlib.error) as error:
        raise FricError(f"cannot be read: {error}", where=str(path), hint="Is the .gz file whole?") from None


def shaped(path: Path, head: bytes, layout: Layout) -> Shape:
    """Return how a text is written, by its first bytes."""
    if not head.strip():
        raise FricError("is empty", where=str(path), hint="Export the log again.")
    try:
        return shape_of(head, layout, whole=len(head) < LOOK)
    except FricError as error:
        raise error.at(str(path)) from None


class _Piece:
    """Bytes as pandas' C parser takes them: a BytesIO it would have decoded, only to encode the text again.

    Parameters
    ----------
    parts
        The bytes; they are not joined.
    """

    def __init__(self, parts: Sequence[memoryview]) -> None:
        self._parts = [part for part in parts if len(part)]

    def read(self, size: int) -> bytes:
        """Return the next bytes, ``size`` of them at most, and none at the end."""
        if not self._parts:
            return b""
        taken, left = self._parts[0][:size], self._parts[0][size:]
        self._parts[:1] = [left] if len(left) else []
        return bytes(taken)

    def __iter__(self) -> Iterator[memoryview]:  # without which it is no file to pandas
        return iter(self._parts)


class TextTable(Table):
    """The table of a text log.

    Parameters
    ----------
    path
        The file.
    shape
        How it is written.
    layout
        What the user says of it.
    zipped
        Whether it is compressed by gzip.
    """

    def __init__(self, path: Path, shape: Shape, layout: Layout, zipped: bool) -> None:
        super().__init__(path, shape.columns, shape.preamble)
        self._shape, self._comment, self._zipped = shape, layout.comment, zipped
        self._ragged = False

    def blocks(self, wanted: Sequence[int]) -> Iterator[Block]:
        """Read the file piece by piece through pandas; the next pieces are parsed while one is worked on."""
        row = 0
        waiting: deque[tuple[int, Future[pd.DataFrame]]] = deque()
        with ThreadPoolExecutor(THREADS, thread_name_prefix="parse") as threads:
            for piece in chain(self._pieces(), repeat(None, AHEAD)):
                if piece:
                    waiting.append((sum(map(len, piece)), threads.submit(self._parsed, piece)))
                if waiting and (piece is None or len(waiting) == AHEAD):
                    size, parsed = waiting.popleft()
                    frame = self._frame(parsed, row)
                    yield Block(row, [_numbers(frame[n], self._shape.decimal) for n in wanted], size)
                    row += len(frame)

    @property
    def passes_bytes(self) -> bool:
        """A compressed file, and one whose digits are no bytes, are not read as they are."""
        return not (self._zipped or self._wide)

    @property
    def _wide(self) -> bool:
        return "\0".encode(self._shape.encoding) != b"\0"

    def _pieces(self) -> Iterator[list[memoryview]]:
        """Cut the data into pieces of whole lines, each of some parts, in an encoding in which a digit is a byte."""
        wide, pass_on = self._wide, self.listener or (lambda _: None)
        rest: list[memoryview] = []
        try:
            with _opened(self.path, self._zipped, self._shape.encoding if wide else None) as file:
                for _ in range(self._shape.first):
                    pass_on(file.readline())
                read_so_far = 0
                while read := file.read(PIECE):
                    content = read.encode() if wide else read
                    pass_on(content)
                    end, whole = content.rfind(b"\n") + 1, memoryview(content)
                    read_so_far += len(content)
                    self._refuse_bomb(read_so_far, len(content) if end else sum(map(len, rest)) + len(content))
                    rest.append(whole[:end] if end else whole)
                    if end:
                        yield rest
                        rest = [whole[end:]]
        except (OSError, EOFError, zlib.error, UnicodeError) as error:
            raise FricError(f"is damaged: {error}", where=str(self.path), hint="Copy the file again.") from None
        if any(map(len, rest)):
            yield rest

    def _refuse_bomb(self, unpacked: int, pending: int) -> None:
        """Raise where a packed file holds more than text packs to, or a line goes on without an end."""
        if self._zipped and unpacked > max(SMALL, MOST_PACKED * self.path.stat().st_size):
            raise FricError(
                f"unpacks to over {MOST_PACKED} times its size, as no log does", where=str(self.path),
                hint="Unpack it, and look at it.",
            )  # fmt: skip
        if pending > MOST_LINE:
            raise FricError(
                f"has a line of over {MOST_LINE >> 20} MiB", where=str(self.path), hint="Export it again, a row a line."
            )

    def _parsed(self, piece: Sequence[memoryview]) -> pd.DataFrame:
        # Cells are read by their place. The encoding matters for names alone, which are known by now.
        shape, names = self._shape, range(len(self.columns))
        read_csv: Callable[..., pd.DataFrame] = pd.read_csv  # whose types ask for more of a file than it does
        options: dict[str, Any] = {
            "sep": r"\s+" if shape.delimiter == "whitespace" else shape.delimiter, "decimal": shape.decimal,
            "comment": self._comment, "skipinitialspace": shape.spaced, "encoding_errors": "replace",
            "header": None, "low_memory": False,
        }  # fmt: skip
        try:
            if not self._ragged:
                with suppress(pd.errors.ParserError):
                    frame = read_csv(_Piece(piece), names=names, **options)
                    if isinstance(frame.index, pd.RangeIndex):  # no row is so long that its first cells are an index
                        return frame
                self._ragged = True
            # columns behind those of the header catch rows that are too long: those with a cell there that is not empty
            mark = None if shape.delimiter == "whitespace" else shape.delimiter.encode()
            lines = b"".join(piece).splitlines()
            widest = max((line.count(mark) + 1 if mark else len(line.split()) for line in lines), default=0)
            if widest > len(names) + MOST_EMPTY:
                raise pd.errors.ParserError("too many fields in line")
            return read_csv(_Piece(piece), names=range(max(widest, len(names)) + 1), index_col=False, **options)
        except pd.errors.EmptyDataError:
            return pd.DataFrame({name: np.empty(0) for name in names})

    def _frame(self, parsed: Future[pd.DataFrame], row: int) -> pd.DataFrame:
        """Return what was parsed, having checked that no row is longer than the header."""
        try:
            frame = parsed.result()
            if frame.iloc[:, len(self.columns) :].notna().any(axis=None):
                raise self._too_long(row)
        except pd.errors.ParserError as error:
            if "fields in line" in str(error):
                raise self._too_long(row) from None
            text = str(error).strip().rsplit("C error: ", 1)[-1]
            raise FricError(f"is no table: {text}", where=self.place(row), hint="Mend the file.") from None
        return frame

    def _too_long(self, row: int) -> FricError:
        width = len(self.columns)
        lines = islice(self._rows(), row, None)
        long = (number for number, line in lines if any(split(line, self._shape.delimiter)[width:]))
        return FricError(
            f"has more cells than the {width} of the header",
            where=f"{self.path}, line {next(long, '?')}",
            hint="Mend or remove the line.",
        )

    def place(self, row: int, column: int | None = None) -> str:
        """Return the line of a row, found by counting lines."""
        return self._described(f"line {self._line(row)[0]}", column)

    def text(self, row: int, column: int) -> str | None:
        """Return the cell as it stands in the file."""
        cells = split(self._line(row)[1], self._shape.delimiter)
        return cells[column] if column < len(cells) else None

    def run(self, row: int, column: int) -> int:
        """Return how many rows from ``row`` on have no number in a column."""
        count = 0
        for _, line in islice(self._rows(), row, None):
            cells = split(line, self._shape.delimiter)
            cell = cells[column] if column < len(cells) else ""
            if is_number(cell, self._shape.decimal) and cell.lower().strip("+-")[:3] not in {"nan", "inf"}:
                break
            count += 1
        return count

    def _line(self, row: int) -> tuple[int, str]:
        return next(islice(self._rows(), row, None))

    def _rows(self) -> Iterator[tuple[int, str]]:
        """Give the number (from 1) and the text of every line of data, passing over what pandas passes over."""
        blank = " \r\n" if self._shape.delimiter == "\t" else " \t\r\n"
        with _opened(self.path, self._zipped, self._shape.encoding) as file:
            for number, line in enumerate(file, 1):
                content = line.partition(self._comment)[0] if self._comment else line
                if number > self._shape.first and content.strip(blank):
                    yield number, content


def _numbers(column: "pd.Series[Any]", decimal: str) -> Real:
    """Return a column as floats, NaN where a cell is no number."""
    if pd.api.types.is_bool_dtype(column):
        return np.full(len(column), np.nan)
    if not pd.api.types.is_numeric_dtype(column):
        if decimal == ",":
            text = column.astype("str")
            column = text.where(~text.str.contains(".", regex=False)).str.replace(",", ".", regex=False)
        found = pd.to_numeric(column, errors="coerce")
        column = found if found.notna().any() else _stamps(column)
    return column.to_numpy(dtype="f8", na_value=np.nan)


def _stamps(column: "pd.Series[Any]") -> "pd.Series[Any]":
    """Return dates, or times of a day, as seconds; NaN where a cell is neither."""
    text = column.astype("str").str.strip()
    first = next((one for one in text.head(20) if re.match(r"\d{1,4}[-/.:]\d{1,2}[-/.:]\d", one)), "")
    if not first:
        return pd.Series(np.full(len(column), np.nan))
    if re.match(r"\d{1,2}:", first):  # of a day
        return pd.to_timedelta(text.str.replace(",", ".", regex=False), errors="coerce").dt.total_seconds()
    stamps = pd.to_datetime(text, errors="coerce", format="ISO8601" if re.match(r"\d{4}-", first) else "mixed")
    return (stamps - pd.Timestamp(0)) / pd.Timedelta(1, "s")


def _is_zipped(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(2) == _GZIP


def _opened(path: Path, zipped: bool, encoding: str | None = None) -> IO[Any]:
    mode: Any = "rt" if encoding else "rb"
    options: dict[str, Any] = {"encoding": encoding, "errors": "replace", "newline": None} if encoding else {}
    return gzip.open(path, mode, **options) if zipped else path.open(mode, **options)
