"""Text of LinuxCNC's halsampler: a count of the rows (``-t``, or a pin that counts), then pins, without a header.

The sampler loses rows without a word where its buffer overruns. So the count, and each other column that counts evenly,
such as a clock in nanoseconds, must go on evenly to the end.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.io.readers.base import ForeignTable, Format, RowBlock
from fric.io.readers.text import TextTable, beginning

FORMAT = Format("LinuxCNC halsampler", (".txt",))
LEAST_ROWS = 8  # Least number of rows that show a count


def recognises(path: Path, head: bytes) -> float:
    """Rows of numbers between spaces from the first line on, the first of them a count."""
    return 0.2 * bool(b"\0" not in head and (found := _counting(head)) and found[0] == (0, 1))


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read a record: one table, whose columns have no names."""
    yield _Record(path, layout)


def _counting(head: bytes) -> list[tuple[int, int]]:
    """Return the columns of whole numbers that rise by a constant step, with the step."""
    rows = [line.split() for line in head.splitlines()[:-1] if not line.startswith(b"overrun")]
    if len(rows) < LEAST_ROWS or len({len(row) for row in rows}) != 1:
        return []
    found = []
    for n, cells in enumerate(zip(*rows, strict=True)):
        if all(cell.isdigit() and len(cell) < 16 for cell in cells):
            steps = np.diff(np.array(cells, dtype="i8"))
            if (step := int(np.median(steps))) > 0 and np.mean(steps == step) > 0.8:
                found.append((n, step))
    return found


class _Record(TextTable):
    """The table of a record, refused where rows are lost."""

    def blocks(self, wanted: Sequence[int]) -> Iterator[RowBlock]:
        """Read the record, and check its counts."""
        counting = _counting(beginning(self.path)[0])
        last = [np.empty(0)] * len(counting)
        for block in super().blocks([*wanted, *(n for n, _ in counting)]):
            for k, (column, step) in enumerate(counting):
                count = np.concatenate([last[k], block.columns[len(wanted) + k]])
                last[k] = count[-1:]
                if len(jumps := np.flatnonzero(np.diff(count) != step)):
                    n = int(jumps[0])
                    lost = (count[n + 1] - count[n]) / step - 1
                    problem = f"{lost:.0f} rows are lost" if lost > 0 else "the count goes back"
                    raise FricError(
                        f"{problem}: the count jumps from {count[n]:.0f} to {count[n + 1]:.0f}",
                        where=self.place(block.row + n + 1 - (len(count) - len(block.columns[0])), column),
                        hint="Record it again, with a deeper sampler or fewer pins; or cut the file there.",
                    )
            yield RowBlock(block.row, block.columns[: len(wanted)], block.size)
