"""Paths from files: two columns x and y with their units, as in ``x [mm], y [mm]``."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fric.errors import FricError
from fric.io.readers import tables
from fric.simulate.path import PointPath
from fric.units import factor


def read_path(path: Path, feed: float) -> PointPath:
    """Read a path from a CSV file with a header such as ``x [mm], y [mm]``.

    Parameters
    ----------
    path
        The file.
    feed
        Speed along the path [m/s].

    Raises
    ------
    FricError
        When a column or its unit is missing, a cell is no number, or the path cannot be followed.
    """
    table = next(iter(tables(Path(path))))
    columns = [table.find(name, name) for name in ("x", "y")]
    scales = []
    for column in columns:
        unit = table.columns[column].unit
        if unit is None:
            raise FricError(
                f"column '{table.columns[column].name}' has no unit", where=str(path), mend="Head it 'x [mm], y [mm]'."
            )
        scales.append(factor(unit, "position"))
    blocks = [block.columns for block in table.read(columns)]
    x, y = (scale * np.concatenate([block[n] for block in blocks]) for n, scale in enumerate(scales))
    if not np.all(np.isfinite(x) & np.isfinite(y)):
        row = int(np.flatnonzero(~np.isfinite(x) | ~np.isfinite(y))[0])
        raise FricError("a cell is no number", where=table.place(row), mend="Give every point both its numbers.")
    try:
        return PointPath(x, y, feed)
    except FricError as error:
        raise error.at(str(path)) from None
