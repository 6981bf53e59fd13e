"""Parquet files, through pyarrow (the extra ``parquet``)."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fric.documents.mapping import Layout
from fric.input import refuse_declared
from fric.io.readers.base import BLOCK, Column, ForeignTable, Format, RowBlock, library, named, numbers
from fric.io.readers.text import MOST_HELD, parted

FORMAT = Format("Parquet", (".parquet",), "pyarrow.parquet", "parquet")


def recognises(path: Path, head: bytes) -> float:
    """Parquet begins with its signature."""
    return float(head.startswith(b"PAR1"))


MOST_WORDS = 1 << 16  # Size of the words of a column that parts records [byte]


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read a Parquet file: one table."""
    parquet = library(FORMAT)
    with parquet.ParquetFile(path) as file:
        refuse_declared(path, 8 * file.metadata.num_rows * file.metadata.num_columns)
        table = ParquetTable(path, file)
        yield from _of_ids(table, file) or [table]


def _of_ids(table: "ParquetTable", file: Any) -> Sequence[ForeignTable]:
    """Return a table for each word of the only column of words, as of text."""
    kinds = [str(field.type) for field in file.schema_arrow]
    words = [n for n, kind in enumerate(kinds) if "string" in kind]
    if len(words) != 1 or table.path.stat().st_size > MOST_HELD:
        return []
    rest = [n for n in range(len(kinds)) if n not in words]
    blocks = [block.columns for block in table.blocks(rest)]
    values = [np.concatenate(pieces) for pieces in zip(*blocks, strict=True)]
    name = file.schema_arrow[words[0]].name
    with library(FORMAT).ParquetFile(table.path, read_dictionary=[name]) as packed:  # a text that recurs is held once
        texts = packed.read(columns=[name]).column(0)
    if max((part.dictionary.nbytes for part in texts.chunks), default=0) > MOST_WORDS:
        return []
    named = texts.to_pandas().astype("str").str.strip()
    return parted(table, named, [table.columns[n] for n in rest], values)


class ParquetTable(ForeignTable):
    """The table of a Parquet file; a unit is in the name, or in the field's metadata as ``unit``."""

    def __init__(self, path: Path, file: Any) -> None:
        super().__init__(path, [_column(field) for field in file.schema_arrow])
        self._file = file

    def blocks(self, wanted: Sequence[int]) -> Iterator[RowBlock]:
        """Read the file batch by batch."""
        names, row = [field.name for field in self._file.schema_arrow], 0
        read = {names[n] for n in wanted if _is_number(self._file.schema_arrow[n].type)}
        for batch in self._file.iter_batches(BLOCK, columns=[*read]):
            columns = [numbers(batch.column(name).to_numpy(zero_copy_only=False)) if name in read
                       else np.full(batch.num_rows, np.nan) for name in (names[n] for n in wanted)]  # fmt: skip
            yield RowBlock(row, columns, batch.nbytes)
            row += batch.num_rows


def _is_number(kind: Any) -> bool:
    """Return whether a column holds numbers or stamps: no text is read: one of a MB that recurs takes gigabytes."""
    from pyarrow.types import is_primitive

    return bool(is_primitive(kind.value_type if hasattr(kind, "index_type") else kind))


def _column(field: Any) -> Column:
    name, unit = named(field.name)
    if str(field.type).startswith(("timestamp", "duration")):
        unit = "s"
    said = (field.metadata or {}).get(b"unit")
    return Column(name, said.decode("utf-8", "replace") if said else unit)
