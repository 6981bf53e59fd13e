"""Parquet files, through pyarrow (the extra ``parquet``)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.io.readers.base import BLOCK, Block, Column, Table, named

if TYPE_CHECKING:
    from numpy.typing import NDArray


def recognises(path: Path, head: bytes) -> float:
    """Parquet begins with its own mark."""
    return float(head.startswith(b"PAR1"))


def tables(path: Path, layout: Layout) -> Iterator[Table]:
    """Read a Parquet file: one table."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise FricError(
            "Parquet needs pyarrow, which is not installed", where=str(path), hint="pip install 'fric[parquet]'"
        ) from None
    try:
        file = parquet.ParquetFile(path)
    except (pyarrow.ArrowException, OSError) as error:
        raise FricError(f"is no whole Parquet file ({error})", where=str(path), hint="Export it again.") from None
    with file:
        yield ParquetTable(path, file)


class ParquetTable(Table):
    """The table of a Parquet file; a unit stands in the name, or in the field's metadata as ``unit``."""

    def __init__(self, path: Path, file: Any) -> None:
        super().__init__(path, [_column(field) for field in file.schema_arrow])
        self._file = file

    def blocks(self, wanted: Sequence[int]) -> Iterator[Block]:
        """Read the file batch by batch."""
        schema, row = self._file.schema_arrow, 0
        for batch in self._file.iter_batches(BLOCK, columns=[schema[n].name for n in dict.fromkeys(wanted)]):
            columns = [_numbers(batch.column(schema[n].name)) for n in wanted]
            yield Block(row, columns, batch.nbytes)
            row += batch.num_rows


def _column(field: Any) -> Column:
    name, unit = named(field.name)
    said = (field.metadata or {}).get(b"unit")
    return Column(name, said.decode() if said else "s" if _is_time(field.type) else unit)


def _is_time(kind: Any) -> bool:
    return str(kind).startswith(("timestamp", "duration"))


def _numbers(column: Any) -> NDArray[np.float64]:
    """Return a column as floats, NaN where it is null; stamps in seconds since the epoch."""
    values = column.to_numpy(zero_copy_only=False)
    if values.dtype.kind in "mM":
        ticks = values.astype("timedelta64[ns]" if values.dtype.kind == "m" else "datetime64[ns]").astype("i8")
        return np.where(np.isnat(values), np.nan, ticks * 1e-9)
    if values.dtype.kind not in "fiu":
        return np.full(len(values), np.nan)
    return values.astype("f8")
