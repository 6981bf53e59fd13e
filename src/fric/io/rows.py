"""Rows of a table in which every cell that is wanted is a number that a machine can reach."""

from math import isfinite

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
        self._limits = chosen.limits()

    def good(self, block: Block) -> tuple[list[Real], NDArray[np.int64]]:
        """Return the columns without the rows that are not whole, and the rows' numbers in the file."""
        rows = np.arange(block.row, block.row + len(block.columns[0]))
        bounded = list(zip(block.columns, self._limits, strict=True))
        if not len(rows) or all(-most <= values.min() and values.max() <= most for values, most in bounded):  # no NaN
            return block.columns, rows
        whole = np.logical_and.reduce([np.abs(values) <= most for values, most in bounded])
        if self._drop:
            return [values[whole] for values in block.columns], rows[whole]
        first = int(np.argmin(whole))
        n = next(n for n, (values, most) in enumerate(bounded) if not np.abs(values[first]) <= most)
        raise self._bad(block.row + first, self._wanted[n], float(block.columns[n][first]))

    def _bad(self, row: int, column: int, value: float) -> FricError:
        text, run = self._table.text(row, column), self._table.run(row, column)
        what = "the cell is empty" if not text else f"'{text}' is no number"
        if isfinite(value):
            what = f"{value:.3g} is beyond what a machine reaches"
        elif run > 1:
            what = f"{run} cells in a row are no numbers, the first {'empty' if not text else repr(text)}"
        return FricError(
            what, where=self._table.place(row, column),
            hint="Mend the file, or leave such samples out with `bad_cells='drop'`.",
        )  # fmt: skip
