"""Readers of foreign formats: time, position and force as floats, beside their library alone reading the same file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import numpy as np

from fric.io.readers import tables
from fric.io.readers.base import BLOCK

N = 1_000_000
"""Samples."""
SLOW = frozenset({"MCAP", "Excel"})
"""Formats whose libraries take tens of microseconds a sample: they are read once, the others three times."""
TIME = np.arange(N) / 4000.0
POSITION, FORCE = np.sin(TIME), np.cos(TIME)

Made = tuple[Path, Callable[[], object]]


def _mf4(folder: Path) -> Made:
    from asammdf import MDF, Signal

    with MDF(version="4.10") as file:
        file.append([Signal(one, TIME, name=name, unit="m") for name, one in (("z", POSITION), ("F", FORCE))])
        path = Path(file.save(folder / "a.mf4", compression=2))

    def alone() -> None:
        with MDF(path) as file:
            for name in ("z", "F"):
                file.get(name)

    return path, alone


def _tdms(folder: Path) -> Made:
    from nptdms import ChannelObject, TdmsFile, TdmsWriter

    clock = {"wf_increment": 1 / 4000.0, "wf_start_offset": 0.0}
    with TdmsWriter(folder / "a.tdms") as file:
        for part in np.array_split(np.arange(N), 100):
            file.write_segment([ChannelObject("g", n, v[part], clock) for n, v in (("z", POSITION), ("F", FORCE))])

    def alone() -> None:
        channels = TdmsFile.read(folder / "a.tdms")["g"]
        for name in ("z", "F"):
            channels[name][:]
        channels["z"].time_track()

    return folder / "a.tdms", alone


def _parquet(folder: Path) -> Made:
    from pyarrow import parquet, table

    parquet.write_table(table([TIME, POSITION, FORCE], ["t", "z", "F"]), folder / "a.parquet")

    def alone() -> None:
        for column in parquet.read_table(folder / "a.parquet").columns:
            column.to_numpy()

    return folder / "a.parquet", alone


def _bag(folder: Path) -> Made:
    from rosbags.highlevel import AnyReader
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    names = ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    state, header, stamp = (store.types[name] for name in names)
    with Writer(folder / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        joints = bag.add_connection("/j", state.__msgtype__, typestore=store)
        for n in range(N):
            at = 250_000 * n
            head = header(stamp=stamp(sec=at // 10**9, nanosec=at % 10**9), frame_id="")
            one: Any = state(head, ["x"], POSITION[n : n + 1], FORCE[n : n + 1], FORCE[n : n + 1])
            bag.write(joints, at, store.serialize_cdr(one, state.__msgtype__))
    (path,) = (folder / "bag").glob("*.mcap")

    def alone() -> None:
        with AnyReader([path], default_typestore=store) as bag:
            for connection, _, raw in bag.messages():
                bag.deserialize(raw, connection.msgtype)

    return path, alone


def _xlsx(folder: Path) -> Made:
    from openpyxl import Workbook, load_workbook

    book = Workbook(write_only=True)
    sheet = book.create_sheet()
    sheet.append(["t [s]", "z [m]", "F [N]"])
    for n in range(N):
        sheet.append([TIME[n], POSITION[n], FORCE[n]])
    book.save(folder / "a.xlsx")

    def alone() -> None:
        read = load_workbook(folder / "a.xlsx", read_only=True)
        for _ in read.worksheets[0].iter_rows(values_only=True):
            pass
        read.close()

    return folder / "a.xlsx", alone


def _resident() -> float:
    """Return the largest memory that this process has held so far [MB]."""
    status = Path("/proc/self/status").read_text()
    return int(status.partition("VmHWM:")[2].split()[0]) / 1024


def _least(work: Callable[[], object], times: int) -> float:
    found = []
    for _ in range(times):
        start = process_time()
        work()
        found.append(process_time() - start)
    return min(found)


def run() -> Iterator[tuple[str, str, str]]:
    """Yield what was measured, beside the target."""
    with TemporaryDirectory() as folder:
        for name, make in (("MF4", _mf4), ("TDMS", _tdms), ("Parquet", _parquet), ("MCAP", _bag), ("Excel", _xlsx)):
            path, alone = make(Path(folder))
            largest = 0

            def own(path: Path = path) -> None:
                nonlocal largest
                for table in tables(path):
                    for block in table.read([1, 0, 2]):
                        largest = max(largest, len(block.columns[0]))

            times = 1 if name in SLOW else 3
            before = _resident()
            ours = _least(own, times)
            more = _resident() - before
            yield (
                f"{name}: speed beside its library alone (blocks of {largest})",
                f"{_least(alone, times) / ours:.2f}",
                ">= 0.5",
            )
            yield f"{name}: memory that reading it takes more than all before", f"{more:.0f} MB", "bounded"
            assert largest <= BLOCK
