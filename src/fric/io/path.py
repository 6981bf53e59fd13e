"""Paths from files: two columns x and y with their units, as in ``x [mm], y [mm]``, or a recorded reference."""

from pathlib import Path

import numpy as np

from fric.arrays import Real
from fric.circles.measured import AxisTrace
from fric.errors import FricError
from fric.io.circle import read_circles
from fric.io.readers import tables
from fric.io.run import read_runs
from fric.io.safe_hdf5 import open_file
from fric.simulate.axis import Trace
from fric.simulate.path import PointPath, RecordedPath
from fric.units import factor


def read_path(path: Path, feed: float) -> PointPath | RecordedPath:
    """Read a path from a CSV file with a header such as ``x [mm], y [mm]``, or a reference that was recorded.

    With a column ``time`` it is a recorded reference, as is that of the first test of a circle file, or of the first
    scheme of a run file.

    path: The file.
    feed: Speed along the path [m/s]; a recorded reference has its own.
    Raises FricError: When a column or its unit is missing, a cell is no number, or the path cannot be followed.
    """
    try:
        if Path(path).suffix in {".h5", ".hdf5"}:
            return _of_circle(Path(path))
        found = _columns(Path(path))
        return RecordedPath(**found) if "time" in found else PointPath(**found, feed=feed)
    except FricError as error:
        raise error if error.where else error.at(str(path)) from None


def _of_circle(path: Path) -> RecordedPath:
    with open_file(path) as file:
        is_run = str(file.attrs.get("fric", "")).startswith("run/")
    traces: list[Trace | AxisTrace | None] = [
        *(read_runs(path)[0].traces if is_run else read_circles(path)[0].axes).values(), None, None
    ]  # fmt: skip
    first, second = traces[:2]
    if first is None or second is None or first.reference is None or second.reference is None:
        raise FricError("holds no reference of two axes", hint="Record where the axes were asked to be.")
    if len(first.time) != len(second.time) or not np.allclose(first.time, second.time):
        raise FricError("has axes that were recorded at different times")
    return RecordedPath(first.time, first.reference, second.reference)


def _columns(path: Path) -> dict[str, Real]:
    """Return x and y [m], and time [s] where there is such a column."""
    table = next(iter(tables(path)))
    names = ["time"] if any(column.name.lower() == "time" for column in table.columns) else []
    names += ["x", "y"]
    columns = [table.find(name, name) for name in names]
    scales = []
    for name, column in zip(names, columns, strict=True):
        unit = table.columns[column].unit
        if unit is None:
            raise FricError(
                f"column '{table.columns[column].name}' has no unit", where=str(path), hint="Head it 'x [mm], y [mm]'."
            )
        scales.append(factor(unit, "time" if name == "time" else "position"))
    blocks = [block.columns for block in table.read(columns)]
    return {
        name: scale * np.concatenate([block[n] for block in blocks])
        for n, (name, scale) in enumerate(zip(names, scales, strict=True))
    }
