"""Whole files of every kind that is read: what the mutated ones are made from."""

from __future__ import annotations

import gzip
import io
import json
import zipfile
from pathlib import Path

import h5py
import numpy as np

from fric.circles.measured import AxisTrace, MeasuredCircle
from fric.control.scheme import choose_schemes
from fric.documents.machine_files import read_machine
from fric.io.circle import write_circles, write_runs
from fric.io.hdf5 import read_logs, write_logs
from fric.io.recognise import REPORT_MARK
from fric.simulate.contour_run import Circle, run_circle

ROOT = Path(__file__).parents[2]
N = 300
TIME = np.arange(N) * 1e-3
POSITION, FORCE = 50.0 * np.sin(9 * TIME), np.cos(9 * TIME)


def whole_files(folder: Path) -> dict[str, list[Path]]:
    """Return whole files by how they are read, most of them made in a folder."""
    run_of_circles(folder / "run.h5")
    t = TIME
    turned = 70.0 * t**2  # from rest
    asked = {"x": 0.01 * np.sin(turned), "y": 0.01 * np.cos(turned)}
    traces = {name: AxisTrace(t, s, s + 1e-6, s) for name, s in asked.items()}
    write_circles(folder / "circle.h5", [MeasuredCircle(0.01, 0.21, 1, traces, source="a.txt")])
    (folder / "path.csv").write_text("x [mm],y [mm]\n" + "".join(f"{np.sin(a):.5f},{np.cos(a):.5f}\n" for a in 6 * t))
    summary = json.dumps(json.loads((ROOT / "tests/fuzz/documents/report.json").read_text()))
    (folder / "report.html").write_text(f"<!doctype html><html>{REPORT_MARK}{summary}</script></html>")
    documents = [
        *sorted((ROOT / "tests/documents/before").glob("*.yaml")),
        *sorted((ROOT / "configs").rglob("*.yaml")),
        *sorted((ROOT / "tests/fuzz/documents").glob("*.yaml")),
    ]
    return {
        "foreign": [make(folder) for make in (*TEXT, *LIBRARIES)],
        "log": [ROOT / "data" / f"{name}.h5" for name in ("presliding-sine", "frequency-response")],
        "run": [folder / "run.h5"],
        "circle": [folder / "circle.h5"],
        "path": [folder / "path.csv", folder / "circle.h5"],
        "yaml": documents,
        "report": [folder / "report.html"],
        "machine": [
            *(ROOT / "configs" / name for name in ("xy-table.yaml", "virtual-rig.yaml", "reality/all.yaml")),
            ROOT / "tests/fuzz/documents/machine-joint.yaml",
        ],
        "words": [ROOT / "tests/fuzz/documents/commands.txt"],
        "values": [
            _few(folder, name, each)
            for name, each in (("constant-velocity", 2), ("presliding-sine", 1), ("frequency-response", 1))
        ],
    }


def run_of_circles(path: Path) -> None:
    """Write a run of a small circle."""
    machine = read_machine(ROOT / "configs" / "xy-table.yaml")
    write_runs(path, [run_circle(machine, choose_schemes("a")[0], Circle(0.0005, 0.05))], "{}", most_samples=50)


def _few(folder: Path, name: str, each: int) -> Path:
    """Write some records of a bundled log."""
    path = folder / f"{name}.h5"
    write_logs(path, read_logs(ROOT / "data" / f"{name}.h5")[::each])
    return path


def csv(folder: Path) -> Path:
    """Write a text log whose header says all."""
    rows = zip(TIME, POSITION, FORCE, strict=True)
    text = "time [s],position [um],force [N]\n" + "".join(f"{a:.4f},{b:.3f},{c:.2f}\n" for a, b, c in rows)
    (folder / "log.csv").write_text(text)
    return folder / "log.csv"


def packed(folder: Path) -> Path:
    """Write a text log, packed."""
    (folder / "log.csv.gz").write_bytes(gzip.compress(csv(folder).read_bytes()))
    return folder / "log.csv.gz"


def old_matlab(folder: Path) -> Path:
    """Write a MATLAB file of version 5."""
    from scipy.io import savemat

    cells = np.array([1, "a"], object)
    savemat(folder / "log.mat", {"time": TIME, "position": POSITION, "told": "x axis", "cells": cells})
    return folder / "log.mat"


def new_matlab(folder: Path) -> Path:
    """Write a MATLAB file of version 7.3."""
    path = folder / "new.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        for name in ("time", "position"):
            file[name] = TIME.reshape(1, -1)
        file["struct/force"] = TIME.reshape(-1, 1)
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file".ljust(512))
    return path


def twincat(folder: Path) -> Path:
    """Write an export of TwinCAT's Scope."""
    head = [
        "Name;scope",
        "File;a.svdx",
        "Starttime of export;132959733843760000;Montag;15:56:24",
        "Endtime of export;1",
    ]
    about = [
        "Name;position;velocity;Name;torque",
        "Unit;mm (Length);mm/s (Velocity);Unit;N (Force)",
        "SampleTime[ms];1;1;SampleTime[ms];4",
    ]
    rows = [
        f"{n};{POSITION[n]:.4f};{FORCE[n]:.4f}" + (f";{4 * n};{FORCE[4 * n]:.4f}" if 4 * n < N else "")
        for n in range(N)
    ]
    (folder / "scope.csv").write_bytes("\r\n".join([*head, "", "", *about, "", *rows, ""]).encode())
    return folder / "scope.csv"


def sinumerik(folder: Path) -> Path:
    """Write a trace of SINUMERIK Operate."""
    rows = "".join(
        f'<rec time="{t!r}" f1="{x!r}" f2="{f!r}"/>'
        for t, x, f in zip(*map(np.ndarray.tolist, (TIME, POSITION, FORCE)), strict=True)
    )
    signals = '<dataSignal name="p" description="Position X"/><dataSignal name="t" description="Torque X"/>'
    (folder / "trace.xml").write_text(f"<root><traceData><dataFrame>{signals}{rows}</dataFrame></traceData></root>")
    return folder / "trace.xml"


def halsampler(folder: Path) -> Path:
    """Write a record of LinuxCNC's halsampler."""
    rows = (f"{n} {1_000_000 + 250_000 * n} {POSITION[n]:.6f} {FORCE[n]:.6f} \n" for n in range(N))
    (folder / "sampler.txt").write_text("".join(rows))
    return folder / "sampler.txt"


def parquet(folder: Path) -> Path:
    """Write a Parquet file."""
    import pyarrow as pa
    from pyarrow import parquet as writer

    table = pa.table({"time [s]": TIME, "position [mm]": POSITION, "force [N]": FORCE})
    writer.write_table(table, folder / "log.parquet", compression="none")
    return folder / "log.parquet"


def mf4(folder: Path) -> Path:
    """Write an MDF 4 measurement of two groups."""
    from asammdf import MDF, Signal

    with MDF(version="4.10") as file:
        file.append([Signal(POSITION, TIME, name="position", unit="mm"), Signal(FORCE, TIME, name="force", unit="N")])
        file.append([Signal(np.arange(75, dtype="u2"), TIME[::4], name="status")])
        return Path(file.save(folder / "log.mf4", overwrite=True))


def tdms(folder: Path) -> Path:
    """Write a TDMS file of two segments."""
    from nptdms import ChannelObject, TdmsWriter

    clock = {"wf_increment": 1e-3, "wf_start_offset": 0.0}
    with TdmsWriter(folder / "log.tdms") as file:
        for part in np.array_split(np.arange(N), 2):
            named = (("position", "mm", POSITION), ("force", "N", FORCE))
            file.write_segment([ChannelObject("g", n, v[part], clock | {"unit_string": u}) for n, u, v in named])
    return folder / "log.tdms"


def _bag(folder: Path, plugin: str) -> Path:
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    names = ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    state, header, stamp = (store.types[name] for name in names)
    place = folder / f"bag-{plugin}"
    with Writer(place, version=9, storage_plugin=StoragePlugin[plugin]) as bag:
        joints = bag.add_connection("/j", state.__msgtype__, typestore=store)
        for n in range(64):
            head = header(stamp=stamp(sec=7, nanosec=1_000_000 * n), frame_id="")
            one = state(head, ["x"], POSITION[n : n + 1], FORCE[n : n + 1], FORCE[n : n + 1])
            bag.write(joints, 1_000_000 * n, store.serialize_cdr(one, state.__msgtype__))
    return next(one for one in place.iterdir() if one.suffix in {".mcap", ".db3"})


def mcap(folder: Path) -> Path:
    """Write a ROS 2 bag as MCAP."""
    return _bag(folder, "MCAP")


def sqlite(folder: Path) -> Path:
    """Write a ROS 2 bag as SQLite."""
    return _bag(folder, "SQLITE3")


def old_bag(folder: Path) -> Path:
    """Write a ROS 1 bag."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    names = ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    state, header, stamp = (store.types[name] for name in names)
    with Writer(folder / "log.bag") as bag:
        joints = bag.add_connection("/j", state.__msgtype__, typestore=store)
        for n in range(64):
            head = header(seq=n, stamp=stamp(sec=7, nanosec=1_000_000 * n), frame_id="")
            one = state(head, ["x"], POSITION[n : n + 1], FORCE[n : n + 1], FORCE[n : n + 1])
            bag.write(joints, 1_000_000 * n, store.serialize_ros1(one, state.__msgtype__))
    return folder / "log.bag"


def xlsx(folder: Path) -> Path:
    """Write a workbook."""
    from openpyxl import Workbook

    book = Workbook()
    book.active.append(["time [s]", "position [mm]", "force [N]"])
    for row in zip(TIME, POSITION, FORCE, strict=True):
        book.active.append(list(map(float, row)))
    book.save(folder / "log.xlsx")
    return folder / "log.xlsx"


def members(whole: bytes) -> dict[str, bytes]:
    """Return the files in a ZIP archive."""
    with zipfile.ZipFile(io.BytesIO(whole)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def archive_of(files: dict[str, bytes]) -> bytes:
    """Return files as a ZIP archive, the same bytes for the same files."""
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)
    return held.getvalue()


TEXT = (csv, packed, old_matlab, new_matlab, twincat, sinumerik, halsampler)
LIBRARIES = (parquet, mf4, tdms, mcap, sqlite, old_bag, xlsx)
"""Of formats whose libraries are extras, all of which development needs."""
