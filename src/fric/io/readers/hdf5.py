"""HDF5: log files of fric, each record a table; of others, groups and datasets as structs and arrays of MATLAB."""

import sys
from collections.abc import Iterator
from pathlib import Path

from fric.documents.mapping import Layout
from fric.io.hdf5 import check_format
from fric.io.readers.base import Column, ForeignTable, Format, Memory
from fric.io.readers.matlab import tables_in
from fric.io.safe_hdf5 import column, members, open_file, text

FORMAT = Format("HDF5", (".h5", ".hdf5", ".hdf"))


def recognises(path: Path, head: bytes) -> float:
    """HDF5 begins with its signature; MATLAB's has a block before it."""
    return float(head.startswith(b"\x89HDF\r\n\x1a\n"))


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read the records of a log file, each a table whose columns name the channels."""
    with open_file(path, most=sys.maxsize) as file:
        if "fric" not in file.attrs:
            yield from tables_in(path, file)
            return
        axis, motion = check_format(file, path)
        # a list: the iterator of h5py holds its lock between two records
        for name, group in members(file["records"]):
            said = {key: text(group.attrs, key) for key in group.attrs} | {"axis": axis, "motion": motion, "name": name}
            columns = tuple(Column(channel, text(data.attrs, "unit") or None) for channel, data in members(group))
            yield Memory(path, columns, [column(group, channel) for channel in group], said=said)
