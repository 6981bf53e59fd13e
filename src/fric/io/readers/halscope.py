"""Text of LinuxCNC's halscope: ``Sampling period is 100000 nSec``, then ``pin value pin value …`` a sample.

Later ones write ``# Sampling period is 100000 ns``, the pins once, and values between semicolons. A decimal comma is
that of the locale, a pin may occur twice, and the last sample may be zeros that were not measured. Pins give no units.
"""

import re
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path

import numpy as np

from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.input import regular
from fric.io.readers.base import Column, ForeignTable, Format, Memory, number

FORMAT = Format("LinuxCNC halscope", (".log", ".txt", ".csv"))
MOST_BYTES = 256 << 20  # Bytes of a record that are read at most: halscope itself holds 64,000 samples
_BITS = {"TRUE": "1", "FALSE": "0"}
_PERIOD = re.compile(rb"[\s#]*Sampling period is (\d+)\s*n(?:Sec|s)\b")


def recognises(path: Path, head: bytes) -> float:
    """Its first line gives the sampling period in nanoseconds."""
    return 1.0 * bool(_PERIOD.match(head))


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read a record: one table of the time and of each pin."""
    content = regular(path, MOST_BYTES).read_bytes()
    period = int(found[1]) * 1e-9 if (found := _PERIOD.match(content)) else 0.0
    lines = content.decode("utf-8", "replace").splitlines()[1:]
    lines = [line.strip().rstrip("; ") for line in lines if line.strip() and not line.startswith("#")]
    if (rows := [re.split(r"\s*;\s*|\s+", line) for line in lines]) and any(";" in line for line in lines):
        rows = [[cell for pair in zip_longest(rows[0], row, fillvalue="") for cell in pair] for row in rows[1:]]
    if not rows or not period:
        raise FricError("holds no samples", hint="Save the record again.")
    names = rows[0][0::2]
    samples = []
    for n, row in enumerate(rows, 2):
        if row[0::2] != names or len(row) != 2 * len(names):
            raise FricError("does not name the pins of the first sample", where=f"{path}, line {n}",
                            hint="Save the record again.")  # fmt: skip
        samples.append([number(_BITS.get(cell, cell).replace(",", ".")) for cell in row[1::2]])
    if len(values := np.array(samples)) > 1 and not values[-1].any() and values[-2].any():
        values = values[:-1]
    before = [names[:n].count(name) for n, name in enumerate(names)]
    distinct = [f"{name} ({count + 1})" if count else name for name, count in zip(names, before, strict=True)]
    columns = (Column("time", "s"), *map(Column, distinct))
    yield Memory(path, columns, [*np.vstack([np.arange(len(values)) * period, values.T])])
