"""Excel workbooks (``.xlsx``), through openpyxl (the extra ``xlsx``)."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from functools import partial
from importlib import import_module
from io import RawIOBase
from itertools import islice, repeat
from pathlib import Path
from typing import IO, Any
from zipfile import BadZipFile, ZipFile, ZipInfo

import numpy as np

from fric.arrays import Real
from fric.documents.mapping import Layout
from fric.errors import FricError, found_in
from fric.io.readers.base import RECORD, ForeignTable, Format, RowBlock, library, warned
from fric.io.readers.text import shape_of
from fric.notice import Notice

FORMAT = Format("Excel", (".xlsx", ".xlsm"), "openpyxl", "xlsx")
LOOK = 64  # Rows at the beginning that are read to find the header
ROWS = 16_384  # Rows a block: cells are objects until they are numbers
MOST_UNPACKED = 4 << 30  # Bytes of a workbook, unpacked, at most
MOST_HELD, MOST_TEXTS = 8 << 20, 32 << 20  # Largest file in it but a sheet, held in memory, and with its texts [byte]
SMALL, MOST_ROW = 64 << 20, 8 << 20  # Bytes of a sheet that are read anyhow, and of a row (16,384 cells) at most
MOST_PACKED = 200  # Largest ratio of the bytes of a sheet to its stored bytes
MOST_ROWS = 1 << 20  # Rows that a sheet has at most
MOST_KEPT, SHEETS = 1 << 19, 32  # Values of a sheet that is kept, for a workbook is read several times, and kept sheets
_KEPT: dict[tuple[str | int, ...], tuple[list[list[Real]], dict[tuple[int, int], str]]] = {}


def recognises(path: Path, head: bytes) -> float:
    """A workbook is a ZIP archive that is named so."""
    return 0.9 * (head.startswith(b"PK\x03\x04") and path.suffix.lower() in FORMAT.endings)


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read a workbook: a table a sheet; charts and sheets of a row or none are passed over."""
    openpyxl = library(FORMAT)
    try:
        with ZipFile(path) as archive:
            inside = archive.infolist()
    except BadZipFile:
        raise FricError("is not a complete workbook (cut short?)", hint="Save it again.") from None
    if sum(one.file_size for one in inside) > MOST_UNPACKED or any(one.file_size > _most(one) for one in inside):
        raise FricError("unpacks to more than is read", hint="Export it as CSV.")
    notices: list[Notice] = []
    with warned(path, notices), _without_sizes():
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
    try:
        with warned(path, notices):
            for sheet in book.worksheets:
                sheet._get_source = partial(_Rows, sheet._get_source, path)
            sheets = [sheet for sheet in book.worksheets if len(list(islice(sheet.iter_rows(), 2))) == 2]
        if not sheets:
            raise FricError("holds no sheet with rows", hint="Export it again.")
        error, read = None, 0
        for sheet in sheets:
            try:
                said = dict.fromkeys(("name", RECORD), sheet.title) if len(sheets) > 1 else {}
                table = _Sheet(path, sheet, layout, said, notices)
            except FricError as found:  # a sheet of notes beside those of numbers
                error = error or found
                continue
            read += 1
            yield table
        if error and not (read and layout == Layout()):
            raise error
    finally:
        book.close()


def _most(member: ZipInfo) -> int:
    """Return the bytes that a file in a workbook has at most."""
    if member.filename.startswith("xl/worksheets/"):
        return max(SMALL, MOST_PACKED * member.compress_size)
    return MOST_TEXTS if member.filename.endswith("/sharedStrings.xml") else MOST_HELD


@contextmanager
def _without_sizes() -> Iterator[None]:
    """Let the library ask no sheet for its size meanwhile: a sheet may state any, to which each row would be filled."""
    kind = import_module("openpyxl.worksheet._read_only").ReadOnlyWorksheet
    asks, kind._get_size = kind._get_size, lambda sheet: None
    try:
        yield
    finally:
        kind._get_size = asks


class _Rows(RawIOBase):
    """A sheet as the library reads it, which ends where a row is longer than any: a row is held as a whole."""

    def __init__(self, opened: Callable[[], IO[bytes]], path: Path) -> None:
        self._source, self._path, self._since = opened(), path, 0

    def read(self, size: int = -1) -> bytes:
        data = self._source.read(size)
        end = data.rfind(b"row>")
        self._since = len(data) - end if end >= 0 else self._since + len(data)
        if self._since > MOST_ROW:
            raise FricError(f"has a row of over {MOST_ROW >> 20} MiB", where=str(self._path), hint="Export it as CSV.")
        return data

    def close(self) -> None:
        self._source.close()
        super().close()


class _Sheet(ForeignTable):
    """The table of a sheet; header and units are found as in text."""

    def __init__(self, path: Path, sheet: Any, layout: Layout, said: dict[str, str], notices: list[Notice]) -> None:
        with warned(path, notices):
            first = list(islice(sheet.iter_rows(values_only=True), LOOK))
        wide = max((n + 1 for row in first for n, cell in enumerate(row) if cell is not None), default=0)
        lines = ["\t".join(_shown(cell) for cell in [*row, *repeat(None, wide)][:wide]) for row in first]
        stated = layout.model_copy(update={"delimiter": "\t", "decimal": ".", "encoding": "utf-8"})
        with found_in(f"{path}, sheet '{sheet.title}'"):
            shape = shape_of(("\n".join(lines) + "\n").encode(), stated, whole=True)
        super().__init__(path, shape.columns, shape.preamble, said)
        self.notices = self._heard = notices
        self._sheet, self._first, self._texts = sheet, shape.first, dict[tuple[int, int], str]()
        state = path.stat()
        self._key = str(path.absolute()), state.st_mtime_ns, state.st_size, sheet.title, shape.first, len(shape.columns)

    def blocks(self, wanted: Sequence[int]) -> Iterator[RowBlock]:
        """Read the sheet row by row, or what is kept of it."""
        found, size, width = list[list[Real]](), 0, len(self.columns)
        for columns in self._kept or self._parsed():
            yield RowBlock(size, [columns[n] for n in wanted], 8 * len(columns[0]) * len(wanted))
            size += len(columns[0])
            if size * width <= MOST_KEPT:
                found.append(columns)
                for values in columns:
                    values.flags.writeable = False
        if size * width <= MOST_KEPT:
            _KEPT[self._key] = found, self._texts
            while len(_KEPT) > SHEETS:
                del _KEPT[next(iter(_KEPT))]

    @property
    def _kept(self) -> list[list[Real]] | None:
        found, self._texts = _KEPT.get(self._key, (None, self._texts))
        return found

    def _parsed(self) -> Iterator[list[Real]]:
        """Yield the columns of the sheet, some rows at a time."""
        row, rows = 0, self._rows()
        while True:
            with warned(self.path, self._heard):
                part = list(islice(rows, ROWS))
            if not part:
                return
            numbered = [*enumerate(part, row)]
            yield [np.array([self._number(cells, n, k) for k, cells in numbered]) for n in range(len(self.columns))]
            row += len(part)

    def place(self, row: int, column: int | None = None) -> str:
        """Return sheet and row as the workbook counts them."""
        return self._described(f"sheet '{self._sheet.title}', row {row + self._first + 1}", column)

    def text(self, row: int, column: int) -> str | None:
        return self._texts.get((row, column))

    def _rows(self) -> Iterator[Sequence[Any]]:
        """Yield the rows of cells without empty rows at the end."""
        empty = 0
        for row, cells in enumerate(self._sheet.iter_rows(min_row=self._first + 1, values_only=True), self._first):
            if row > MOST_ROWS:
                raise FricError("says that it has more rows than a sheet has", where=self.place(row - self._first))
            if any(cell is not None for cell in cells):
                yield from repeat((), empty)
                yield cells
                empty = 0
            else:
                empty += 1

    def _number(self, cells: Sequence[Any], n: int, row: int) -> float:
        cell = cells[n] if n < len(cells) else None
        if isinstance(cell, int | float):
            return float(cell)
        if isinstance(cell, datetime):
            return cell.replace(tzinfo=UTC).timestamp()
        if cell is not None and len(self._texts) < LOOK:
            self._texts[row, n] = str(cell)
        return np.nan


def _shown(cell: Any) -> str:
    """Return a cell as text writes it; what would end a cell of text does not."""
    if isinstance(cell, datetime):
        return repr(cell.replace(tzinfo=UTC).timestamp())
    return "" if cell is None else " ".join(str(cell).split())
