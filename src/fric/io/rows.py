"""Rows of a table in which every cell that is wanted is a number."""

import numpy as np
from numpy.typing import NDArray

from fric.arrays import Real
from fric.errors import FricError
from fric.io.channels import Plan
from fric.io.readers.base import Block, Table


class WholeRows:
    """Finds the rows of a table that are whole."""

    def __init__(self, table: Table, chosen: Plan, drop: bool) -> None:
        self._table, self._wanted, self._drop = table, chosen.wanted, drop

    def good(self, block: Block) -> tuple[list[Real], NDArray[np.int64]]:
        """Return the columns without the rows that are not whole, and the rows' numbers in the file."""
        rows = np.arange(block.row, block.row + len(block.columns[0]))
        # a sum is finite when all of its terms are: cheaper than looking at each
        with np.errstate(invalid="ignore", over="ignore"):
            if np.isfinite(sum(float(values.sum()) for values in block.columns)):
                return block.columns, rows
        whole = np.logical_and.reduce([np.isfinite(values) for values in block.columns])
        if whole.all():
            return block.columns, rows
        if self._drop:
            return [values[whole] for values in block.columns], rows[whole]
        first = int(np.argmin(whole))
        bad = (n for n, values in zip(self._wanted, block.columns, strict=True) if not np.isfinite(values[first]))
        raise self._bad(block.row + first, next(bad))

    def _bad(self, row: int, column: int) -> FricError:
        text, run = self._table.text(row, column), self._table.run(row, column)
        what = "the cell is empty" if not text else f"'{text}' is no number"
        if run > 1:
            what = f"{run} cells in a row are no numbers, the first {'empty' if not text else repr(text)}"
        return FricError(
            what, where=self._table.place(row, column),
            hint="Mend the file, or leave such samples out with --bad-cells drop.",
        )  # fmt: skip
