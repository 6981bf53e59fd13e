"""Feedforward files: HDF5 with ``fric = "feedforward/1"``, voltage against friction, as it was learned."""

from pathlib import Path

import numpy as np

from fric.arrays import Real
from fric.circles.learn import Table
from fric.io.safe_hdf5 import check_type, column, open_file
from fric.io.staged_hdf5 import staged_hdf5, write_column

FORMAT = "feedforward/1"
UNITS = {"time": "s", "reference": "m", "voltage": "V"}


def write_feedforward(path: Path, table: Table, provenance: str = "", *, force: bool = False) -> None:
    """Write the feedforward of the next round: attributes of its circle, and a group per axis; whole or not at all."""
    test = table.test
    with staged_hdf5(path, force=force) as (file, check):
        file.attrs.update({"fric": FORMAT, "provenance": provenance})
        file.attrs.update({"radius": test.radius, "feed": test.feed, "direction": test.direction})
        file.attrs.update({"share": table.how.share, "bandwidth": table.how.bandwidth})
        for name in table.voltage:
            group = file.create_group(name)
            for key, unit in UNITS.items():
                write_column(group, key, np.asarray(getattr(table, key)[name], float), unit)
            check()


def read_feedforward(path: Path) -> dict[str, Real]:
    """Read the voltage that each axis fed forward against friction [V], by its name.

    Raises FricError: When it is no feedforward file, or cut short.
    """
    with open_file(path) as file:
        check_type(file, path, FORMAT, "Give a file of `fric learn -o`.")
        return {name: column(group, "voltage") for name, group in file.items()}
