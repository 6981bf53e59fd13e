"""Whole commands on inputs of every type whose fields, shapes, lengths, types and values are changed, not their bytes.

`python -m tests.fuzz.structure --count 1000 --seed 7` runs cases, each in a fork of this process with a limit of
processor time and memory, and prints those that end as none may: in a traceback, a signal, a foreign warning, what does
not print, over 60 s or 2 GB. A case is known by its seed and number alone.
"""

from __future__ import annotations

import argparse
import faulthandler
import gzip
import json
import os
import re
import resource
import shutil
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from random import Random
from typing import Any

import h5py
import numpy as np

from fric import units
from fric.control.scheme import choose_schemes
from fric.documents.machine_files import read_machine
from fric.io.circle import read_circles, write_circles, write_runs
from fric.io.hdf5 import write_logs
from fric.io.recognise import REPORT_MARK, read_report
from fric.log import ForceVelocity, Log
from fric.results.circles import learn
from fric.simulate import processes
from fric.simulate.contour_run import Circle, run_circle
from tests.fuzz.whole import ROOT, _few, csv, old_matlab
from tests.warm import LATE, modules

SECONDS, MEMORY = 60, 2 << 30
LONGER = {"reproduce": 300}
"""Processor time of a command that works longer on whole inputs [s]."""
N = 240
NAMES = ("a", "", " ", "time", "position", "\x1b[2J", "[/]", "x" * 300, "a\nb", "/", "..", "\u202e", "ü", "*/", "9")
UNITS = ("mm", "m", "s", "ms", "N", "V", "", "furlong", "$", "9**9", "%", "1", "K", "N*m", "deg", "\x01", "m" * 70)
NUMBERS = (
    0.0,
    -0.0,
    1.0,
    -1.0,
    1e-300,
    5e-324,
    1e300,
    -1e300,
    1e12,
    1e-12,
    float("nan"),
    float("inf"),
    -float("inf"),
    2.0**53,
    1e-6,
    1e6,
    1e9,
    -1e-9,
    1e18,
    0.5,
    100.0,
)
WORDS = (
    "",
    "x",
    "inf m",
    "nan N",
    "1e400 m",
    "-5 mm",
    "0 mm",
    "1e300 N",
    "[/]",
    "../..",
    "\x1b[2J",
    "auto",
    "all",
    "1",
)


def number(r: Random) -> float:
    """Return a number, odd more often than not."""
    return r.choice(NUMBERS) if r.random() < 0.7 else r.gauss(0.0, 1.0) * 10.0 ** r.randint(-12, 12)


def series(r: Random, whole: np.ndarray) -> Any:
    """Return a series of another length, rank, type or other values."""
    whole = whole.astype(float) if whole.dtype.kind == "b" else whole
    n, some = len(whole), np.array([r.random() < 0.02 for _ in whole])
    return r.choice(
        [
            lambda: whole[: r.choice([0, 1, 2, 3, 5, 16, 17, n // 2])],
            lambda: np.full(n, number(r)),
            lambda: np.where(some, number(r), whole),
            lambda: whole * number(r),
            lambda: whole + number(r),
            lambda: whole[::-1].copy(),
            lambda: np.sort(whole),
            lambda: np.repeat(whole, 2)[:n],
            lambda: np.resize(whole, r.choice([1, n + 1, 2 * n, 20 * n])),
            lambda: np.stack([whole, whole]),
            lambda: whole.astype("f4"),
            lambda: np.nan_to_num(whole * 100).astype("i8"),
            lambda: whole > 0,
            lambda: np.round(whole, r.randint(0, 4)),
            lambda: np.array([r.gauss(0.0, 1.0) for _ in whole]),
            lambda: np.array([r.choice(["a", "", "1,0", "nan"]).encode() for _ in whole]),
            lambda: np.float64(number(r)),
        ]
    )()


def leaf(r: Random) -> Any:
    """Return what stands in place of a value of a tree."""
    return r.choice(
        [
            lambda: number(r),
            lambda: r.choice(WORDS),
            lambda: None,
            list,
            dict,
            lambda: True,
            lambda: 10**30,
            lambda: [number(r)] * r.choice([1, 3, 50]),
            lambda: {"value": number(r), "unit": r.choice(UNITS)},
            lambda: f"{number(r)!r} {r.choice(UNITS)}",
            lambda: r.choice(NAMES),
            lambda: [[number(r)]],
            lambda: r.randint(-3, 9),
        ]
    )()


def tree(r: Random, whole: Any) -> Any:
    """Return a tree with one of its values, keys or lists changed."""
    if isinstance(whole, dict) and whole:
        made, key = dict(whole), r.choice(list(whole))
        what = r.random()
        if what < 0.75:
            made[key] = tree(r, whole[key])
        elif what < 0.85:
            del made[key]
        elif what < 0.95:
            made[key] = leaf(r)
        else:
            made[r.choice(NAMES)] = made.pop(key)
        return made
    if isinstance(whole, list) and whole:
        at, what = r.randrange(len(whole)), r.random()
        if what < 0.6:
            return [tree(r, one) if n == at else one for n, one in enumerate(whole)]
        return r.choice([whole[:at], whole + whole, whole[::-1], whole * 40, [leaf(r)]])
    if isinstance(whole, float | int) and r.random() < 0.6:
        return whole * r.choice([-1, 0, 10, 1e-3, 1e3, 1e6, 1e-9, 1e12, 1e300])
    if isinstance(whole, str) and " " in whole and r.random() < 0.6:
        value, _, unit = whole.partition(" ")
        return r.choice([f"{number(r)!r} {unit}", f"{value} {r.choice(UNITS)}", value, f"-{whole}"])
    return leaf(r)


def changed_yaml(r: Random, path: Path) -> None:
    """Change a document."""
    from ruamel.yaml import YAML

    made = YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8"))
    for _ in range(r.randint(1, 3)):
        made = tree(r, made)
    path.write_text(json.dumps(made, default=str), encoding="utf-8")  # JSON is YAML, but for nan and inf
    path.write_text(path.read_text().replace("NaN", ".nan").replace("Infinity", ".inf"), encoding="utf-8")


def changed_hdf5(r: Random, path: Path) -> None:
    """Change attributes, datasets and groups of an HDF5 file."""
    with h5py.File(path, "a") as file, suppress(ValueError, TypeError, KeyError, RuntimeError):
        for _ in range(r.randint(1, 3)):
            names: list[str] = []
            file.visit(names.append)
            sets = [one for one in names if isinstance(file[one], h5py.Dataset)]
            what = r.random()
            if what < 0.55 and sets:
                name = r.choice(sets)
                held, about = np.asarray(file[name][()]), dict(file[name].attrs)
                del file[name]
                plain = held.ndim == 1 and held.dtype.kind in "fiu" and len(held)
                file[name] = series(r, held) if plain else r.choice([held[:1], number(r)]) if held.ndim else b"x"
                for key, value in about.items():
                    file[name].attrs[key] = value
            elif what < 0.85:
                node = file[r.choice(["/", *names])]
                if list(node.attrs):
                    key = r.choice(list(node.attrs))
                    held = node.attrs[key]
                    if r.random() < 0.2:
                        del node.attrs[key]
                    elif isinstance(held, str) and held[:1] in "[{" and r.random() < 0.8:
                        node.attrs[key] = json.dumps(tree(r, json.loads(held)))
                    else:
                        node.attrs[key] = r.choice(
                            [
                                number(r),
                                np.array([number(r)] * r.choice([1, 3])),
                                r.choice(WORDS),
                                r.choice(UNITS),
                                True,
                            ]
                        )
            elif what < 0.9 and names:
                name = r.choice(names)
                del file[name]
                if r.random() < 0.5:
                    file[name] = series(r, np.arange(float(N)))
            elif names:
                file.move(r.choice(names), f"{r.choice(names)}{r.choice(NAMES)}")


def columns(r: Random) -> tuple[dict[str, Any], str]:
    """Return columns of a log or a circle test by their headers, some of them changed, and what they are."""
    t = np.arange(N) * r.choice([1e-3, 1e-3, 2.5e-4, 1e-9, 10.0])
    if r.random() < 0.3:
        angle = 40.0 * t
        made: dict[str, Any] = {"time [s]": t}
        for n, axis in enumerate("xy"):
            made |= {
                f"{axis}_ref [mm]": 5 * np.cos(angle - n * np.pi / 2),
                f"{axis}_pos [mm]": 5 * np.cos(angle - n * np.pi / 2) + 0.01,
                f"{axis}_input [V]": np.sin(angle),
            }
        form = "circle"
    elif r.random() < 0.15:
        f = np.geomspace(1, 100, N)
        made, form = {"frequency [Hz]": f, "magnitude [m/V]": 1 / f**2, "phase [deg]": -f}, "frequency-response"
    elif r.random() < 0.15:
        made, form = (
            {
                "velocity [mm/s]": np.linspace(-9, 9, N),
                "force [N]": np.sign(np.arange(N) - N / 2),
                "n": np.full(N, 9.0),
            },
            "force-velocity",
        )
    else:
        z = r.choice([np.sin(9 * t), np.abs((4 * t) % 2 - 1), t**2])
        made, form = (
            {"time [s]": t, "position [mm]": z, "force [N]": np.sign(np.gradient(z)), "input [V]": np.cos(t)},
            "motion",
        )
    for _ in range(r.randint(0, 3)):
        name = r.choice(list(made))
        if r.random() < 0.7:
            made[name] = series(
                r,
                t if np.size(made[name]) < 2 or np.asarray(made[name]).dtype.kind == "S" else np.ravel(made[name])[:N],
            )
        else:
            made[
                r.choice([f"{r.choice(NAMES)} [{r.choice(UNITS)}]", f"force [{r.choice(UNITS)}]", r.choice(NAMES)])
            ] = made.pop(name)
    return made, form


def _cells(values: Any) -> list[Any]:
    return np.atleast_1d(np.asarray(values)).ravel().tolist()


def as_csv(path: Path, made: dict[str, Any], r: Random) -> None:
    lists = [_cells(one) for one in made.values()]
    rows = range(max((len(one) for one in lists), default=0))
    lines = [",".join(made), *(",".join(str(one[n]) if n < len(one) else "" for one in lists) for n in rows)]
    path.write_text("\n".join(lines), encoding="utf-8", errors="replace")


def as_mat(path: Path, made: dict[str, Any], r: Random) -> None:
    from scipy.io import savemat

    plain = {"".join(c if c.isalnum() else "_" for c in name)[:30].strip("_") or "a": one for name, one in made.items()}
    savemat(path, {f"v{name}" if name[0].isdigit() else name: one for name, one in plain.items()})


def as_new_mat(path: Path, made: dict[str, Any], r: Random) -> None:
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, one in made.items():
            place = name.replace("/", "_").replace("\0", "").strip(". ") or "a"
            if place not in file:
                file[place] = np.asarray(one).reshape(1, -1) if r.random() < 0.8 and np.size(one) else np.asarray(one)
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file".ljust(512))


def as_tdms(path: Path, made: dict[str, Any], r: Random) -> None:
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(path) as file:
        channels = []
        for name, one in made.items():
            head, _, unit = name.rstrip("]").partition(" [")
            about = {"unit_string": unit, "wf_increment": 1e-3, "wf_start_offset": 0.0}
            if r.random() < 0.3:
                about = tree(r, about)
            about = {k: v for k, v in about.items() if k and isinstance(v, str | float | int) and abs(len(str(v))) < 20}
            data = np.asarray(one).ravel()
            data = np.array(data.tolist()) if data.dtype.kind != "S" else [x.decode() for x in data]
            if len(data):
                channels.append(ChannelObject("g", head or "a", data, about))
        file.write_segment(channels)


def as_parquet(path: Path, made: dict[str, Any], r: Random) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    longest = max((np.size(one) for one in made.values()), default=0)
    table = {
        name: pa.array((_cells(one) * (longest // max(np.size(one), 1) + 1))[:longest] or [None] * longest)
        for name, one in made.items()
    }
    if r.random() < 0.3 and table:
        name = r.choice(list(table))
        table[name] = r.choice(
            [
                pa.array([b"\xff"] * longest),
                pa.array([[1.0]] * longest),
                pa.nulls(longest),
                pa.array(["1"] * longest).dictionary_encode(),
                pa.array(range(longest), pa.timestamp("ns")),
                pa.array(range(longest), pa.duration("us")),
                pa.array([True] * longest),
            ]
        )
    fields = [
        pa.field(name, one.type, metadata={"unit": r.choice([b"\xff", b"mm", b"", b"s"])} if r.random() < 0.2 else None)
        for name, one in table.items()
    ]
    parquet.write_table(pa.Table.from_arrays(list(table.values()), schema=pa.schema(fields)), path)


def as_xlsx(path: Path, made: dict[str, Any], r: Random) -> None:
    from openpyxl import Workbook

    book, lists = Workbook(), [_cells(one)[:200] for one in made.values()]
    book.active.append(["".join(c for c in name if c.isprintable()) for name in made])
    for n in range(max((len(one) for one in lists), default=0)):
        row = [one[n] if n < len(one) else None for one in lists]
        book.active.append([one.decode() if isinstance(one, bytes) else one for one in row])
    book.save(path)


def as_mf4(path: Path, made: dict[str, Any], r: Random) -> None:
    from asammdf import MDF, Signal

    t = np.arange(N) * 1e-3
    with MDF(version="4.10") as file:
        for name, one in made.items():
            head, _, unit = name.rstrip("]").partition(" [")
            data = np.resize(np.asarray(one).ravel(), N) if np.size(one) else np.zeros(N)
            file.append([Signal(data, t, name=head or "a", unit=unit)])
        file.save(path, overwrite=True)


def as_packed(path: Path, made: dict[str, Any], r: Random) -> None:
    as_csv(path, made, r)
    path.write_bytes(gzip.compress(path.read_bytes()))


def as_scope(path: Path, made: dict[str, Any], r: Random) -> None:
    """Write what TwinCAT's Scope exports."""
    heads = [name.rstrip("]").partition(" [") for name in list(made)[1:]]
    lists = [_cells(one) for one in list(made.values())[1:]]
    step = r.choice(["1", "1", "4", "0", "-1", "nan", "1e300", ""])
    lines = [
        "Name;scope", "File;a.svdx", "Starttime of export;132959733843760000;Montag;15:56:24", "Endtime of export;1",
        "", "",
        ";".join(["Name", *(name for name, _, _ in heads)]), ";".join(["Unit", *(f"{u} (a)" for _, _, u in heads)]),
        ";".join(["SampleTime[ms]", *[step] * len(heads)]), "",
    ]  # fmt: skip
    for n in range(max(map(len, lists), default=0)):
        lines.append(";".join([str(n), *(str(one[n]).replace(".", ",") if n < len(one) else "" for one in lists)]))
    path.write_text("\r\n".join(lines), encoding="utf-8", errors="replace")


def as_halscope(path: Path, made: dict[str, Any], r: Random) -> None:
    """Write what LinuxCNC's halscope saves, some of its lines damaged."""
    lists = [_cells(one) for one in list(made.values())[1:]]
    names = ["-".join(name.split()) for name in list(made)[1:]]
    rows = range(min(map(len, lists), default=0))
    lines = [f"Sampling period is {r.choice(['1000000', '1000000', '0', '9' * 30])} nSec"]
    lines += [" ".join(f"{name} {one[n]}" for name, one in zip(names, lists, strict=True)) for n in rows]
    _spoilt(lines, r)
    path.write_text("\n".join(lines), encoding="utf-8", errors="replace")


def as_sampler(path: Path, made: dict[str, Any], r: Random) -> None:
    """Write what LinuxCNC's halsampler prints, some of its lines damaged."""
    lists = [_cells(one) for one in list(made.values())[1:]]
    jump, rows = r.choice([0, 0, 1, 7]), range(min(map(len, lists), default=0))
    lines = [f"{n + jump * (n > N // 2)} " + " ".join(str(one[n]) for one in lists) for n in rows]
    _spoilt(lines, r)
    path.write_text("\n".join(lines), encoding="utf-8", errors="replace")


def _spoilt(lines: list[str], r: Random) -> None:
    for _ in range(r.choice([0, 0, 1, 2]) if lines else 0):
        n = r.randrange(len(lines))
        lines[n] = r.choice([f"{lines[n]} 7", "", lines[n][:5], lines[n].replace(".", ","), "overrun", "a nan " * 3])


def as_trace(path: Path, made: dict[str, Any], r: Random) -> None:
    """Write a trace of SINUMERIK Operate: addresses, intervals, values that are as before."""
    lists = [_cells(one) for one in made.values()]
    of = [f"{name} [u1, 1]" for name in ("CmdPos2ndEnc64", "ActPos2ndEnc64", "ActTorque", "ActVelMotorSide", "ActCurr")]
    types = ["posn", "posn", "torque", "veloRot", "current"]
    signals = "".join(
        f'<dataSignal id="f{n + 1}" name="/Nck/!SD/nckServoData{of[n % 5]}" '
        f'description="{r.choice(["X", "", "&lt;"])}" '
        f'interval="{r.choice(["0.001"] * 6 + ["0", "-1", "nan", "1e300"])}" '
        f'unitsType="{types[n % 5] if r.random() < 0.9 else r.choice([*types, "none", "?"])}"/>'
        for n in range(len(lists) - 1)
    )
    records = "".join(
        f'<rec time="{row[0]}" ' + " ".join(f'f{n}="{x}"' for n, x in enumerate(row[1:], 1) if r.random() < 0.9) + "/>"
        for row in zip(*lists, strict=False)
    )
    text = f"<traceSession><traceData><dataFrame>{signals}{records}</dataFrame></traceData></traceSession>"
    path.write_text(text, encoding="utf-8", errors="replace")


def as_bag(path: Path, made: dict[str, Any], r: Random) -> None:
    """Write a bag of ROS 2 whose stamps or joints are odd now and then."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    names = ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    state, header, stamp = (store.types[name] for name in names)
    lists = [np.asarray(one, float).ravel() for one in made.values()]
    place, odd = path.with_suffix(""), r.random() < 0.3
    with Writer(place, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        joints = bag.add_connection("/j", state.__msgtype__, typestore=store)
        for n in range(min(map(len, lists))):
            head = header(stamp=stamp(sec=7, nanosec=0 if odd and r.random() < 0.1 else 1_000_000 * n), frame_id="")
            joint = ["x"] if not odd or r.random() < 0.9 else r.choice([[], ["x", "y"], ["\u202e"]])
            values = [lists[min(k, len(lists) - 1)][n : n + 1] for k in (1, 2, 3)]
            bag.write(joints, 1_000_000 * n, store.serialize_cdr(state(head, joint, *values), state.__msgtype__))
    shutil.move(next(place.glob("*.mcap")), path)
    shutil.rmtree(place)


WRITERS: dict[str, Callable[[Path, dict[str, Any], Random], None]] = {
    ".csv": as_csv,
    ".mat": as_mat,
    ".7.mat": as_new_mat,
    ".tdms": as_tdms,
    ".parquet": as_parquet,
    ".xlsx": as_xlsx,
    ".mf4": as_mf4,
    ".csv.gz": as_packed,
    ".scope.csv": as_scope,
    ".log": as_halscope,
    ".txt": as_sampler,
    ".xml": as_trace,
    ".mcap": as_bag,
}
"""The writer of each reader's format."""


def commands() -> dict[str, list[str]]:
    """Return whole commands by what they take: FILE is the changed input."""
    found: dict[str, list[str]] = {}
    for line in filter(None, (ROOT / "tests/fuzz/documents/structure.txt").read_text().splitlines()):
        if line.startswith("["):
            found[line.strip("[]")] = last = []
        else:
            last.append(line)
    return found


COMMANDS = commands()
OF_STEM = {"micro-steps": "presliding-sine", "amperes": "presliding-sine", "force-velocity": "constant-velocity"}
"""The kind of log whose commands take another one too."""
DOCUMENTS = (
    *("machine", "plant", "friction", "controller", "observer", "mapping", "schemes", "spread", "block", "plan"),
    *("comparison", "diagnosis", "fleet", "inspection", "circle-map", "circle-result"),
)
"""Types of YAML documents, and of `--json` that is kept as such."""


KINDS = ("foreign", "log", "circle", "run", "yaml", "report", "feedforward", "words")
ODD = (
    *(
        "",
        "-",
        "nan",
        "inf",
        "-1",
        "0",
        "1e300",
        "9" * 400,
        "../..",
        "/dev/null",
        "/dev/full",
        "/dev/zero",
        ".",
        "=",
        "x=",
    ),
    *("1 furlong", "m**9**9", "-5 mm", "1e308 mm", "nan mm", "1e9 Hz", "[/]", "\u202e", "\udcff", "\x1b[2J", "a\nb"),
    *("fifo", "loop", "folder", "sealed/out.h5", "no/out.h5", "FILE", "x" * 300, "all", "auto", "none", "1:0", "12 %"),
)
"""What stands in place of a word of a command line; some are files that are none."""


class Case:
    """A command, and the file that it takes, in a folder."""

    def __init__(self, seed: int, n: int, folder: Path, known: dict[str, list[Path]]) -> None:
        self.n, r = n, Random(f"{seed}-{n}")
        self.kind = r.choices(KINDS, [28, 20, 17, 7, 20, 2, 3, 3])[0]
        self.file, self.words = getattr(self, f"_{self.kind}")(r, folder, known)

    def _foreign(self, r: Random, folder: Path, known: dict[str, list[Path]]) -> tuple[Path, str]:
        ending = r.choices(list(WRITERS), [4, 2, 3, 3, 3, 2, 0.5, 0.5, 2, 2, 1, 3, 1])[0]
        made, form = columns(r)
        path = folder / f"input{ending}"
        try:
            WRITERS[ending](path, made, r)
        except Exception:  # a writer that does not take it
            as_csv(path := folder / "input.csv", made, r)
        return path, r.choice(COMMANDS["foreign"]).replace(
            "KIND", r.choice([form, "presliding-sine", "constant-velocity"])
        )

    def _hdf5(self, r: Random, source: Path, path: Path) -> Path:
        shutil.copy(source, path)
        changed_hdf5(r, path)
        return path

    def _log(self, r: Random, folder: Path, known: dict[str, list[Path]]) -> tuple[Path, str]:
        source = r.choice(known["values"])
        path = self._hdf5(r, source, folder / "input.h5")
        return path, r.choice(COMMANDS[OF_STEM.get(source.stem, source.stem) if r.random() < 0.6 else "records"])

    def _circle(self, r: Random, folder: Path, known: dict[str, list[Path]]) -> tuple[Path, str]:
        return self._hdf5(r, r.choice(known["tests"]), folder / "input.h5"), r.choice(COMMANDS["circle"])

    def _run(self, r: Random, folder: Path, known: dict[str, list[Path]]) -> tuple[Path, str]:
        return self._hdf5(r, known["run"][0], folder / "input.h5"), r.choice([*COMMANDS["circle"], *COMMANDS["run"]])

    def _feedforward(self, r: Random, folder: Path, known: dict[str, list[Path]]) -> tuple[Path, str]:
        return self._hdf5(r, known["feedforward"][0], folder / "input.h5"), r.choice(COMMANDS["feedforward"])

    def _words(self, r: Random, folder: Path, known: dict[str, list[Path]]) -> tuple[Path, str]:
        """Change words of a command, not the file."""
        kind, commands = r.choice([one for one in COMMANDS.items() if one[0] != "foreign"])
        path = folder / ("input.yaml" if kind in DOCUMENTS else "input.h5")
        held = [*known["values"], *known["tests"], *known["run"], *known["feedforward"], *known["yaml"]]
        match = [one for one in held if one.stem in {kind, OF_STEM.get(kind)}]
        match += [one for one in known["yaml"] if f"fric: {kind}/" in one.read_text()]
        shutil.copy((match or known["values"])[0], path)
        (folder / "folder").mkdir()
        (folder / "sealed").mkdir(0o500)
        (folder / "loop").symlink_to("loop")
        os.mkfifo(folder / "fifo")
        words = r.choice(commands).split()
        for _ in range(r.randint(1, 2)):
            at, what = r.randrange(1, len(words)), r.random()
            if what < 0.8:
                words[at] = r.choice(ODD)
            elif what < 0.9:
                words.insert(at, words[at])
            else:
                words.insert(at, r.choice(["--json", "--force", "--implausible", "--plot", "--help", "--", "--scheme"]))
        return path, "\0".join(words)

    def _report(self, r: Random, folder: Path, known: dict[str, list[Path]]) -> tuple[Path, str]:
        held = tree(r, tree(r, read_report(known["report"][0])))
        path = folder / "input.html"
        path.write_text(f"<!doctype html><html>{REPORT_MARK}{json.dumps(held)}</script></html>")
        return path, "report FRICTION FILE -o out.html"

    def _yaml(self, r: Random, folder: Path, known: dict[str, list[Path]]) -> tuple[Path, str]:
        kind = r.choice(DOCUMENTS)
        source = r.choice([one for one in known["yaml"] if f"fric: {kind}/" in one.read_text()])
        path = folder / "reality" / "input.yaml"
        shutil.copytree(ROOT / "configs", folder / "reality")
        shutil.copy(source, path)
        changed_yaml(r, path)
        if kind == "mapping":  # as answers to questions are kept
            (folder / "logs").mkdir()
            shutil.copy(ROOT / "data/strokes/constant-velocity-01.csv", folder / "logs")
            shutil.copy(path, folder / "logs/fric-mapping.yaml")
        return path, r.choice(COMMANDS[kind])


def known_files(folder: Path) -> dict[str, list[Path]]:
    """Return whole inputs, made in a folder."""
    machine = read_machine(ROOT / "configs" / "xy-table.yaml")
    runs = [run_circle(machine, choose_schemes(one)[0], Circle(0.002, 0.05)) for one in "ac"]
    write_runs(folder / "run.h5", runs, "{}")
    write_circles(folder / "circle.h5", read_circles(folder / "run.h5", "a"))
    text = (ROOT / "tests/fuzz/documents/report.json").read_text()
    (folder / "report.html").write_text(f"<!doctype html><html>{REPORT_MARK}{text}</script></html>")
    kinds = (("constant-velocity", 2), ("presliding-sine", 1), ("frequency-response", 1))
    t = np.arange(4000) * 1e-3
    stairs = 2e-6 * np.minimum(np.floor(5 * t), np.floor(5 * t[::-1]))
    z, v = 2e-5 * np.sin(9 * t), np.r_[-np.geomspace(1e-4, 0.1, 9), np.geomspace(1e-4, 0.1, 9)]
    written: dict[str, Any] = {
        "micro-steps": Log(t, stairs, force=40 * np.tanh(stairs / 1e-5), kind="micro-steps", name="a"),
        "amperes": Log(t, z, force=9 * np.sign(np.cos(9 * t)), kind="presliding-sine", motion="linear/A", name="a"),
        "force-velocity": ForceVelocity(v, 60 * np.sign(v) + 99 * v, n=np.full(18, 50.0), name="a"),
    }
    for name, record in written.items():
        write_logs(folder / f"{name}.h5", [record])
    learn(folder / "circle.h5", machine=ROOT / "configs/xy-table.yaml").save(folder / "feedforward.h5")
    return {
        "values": [*(_few(folder, name, each) for name, each in kinds), *(folder / f"{name}.h5" for name in written)],
        "feedforward": [folder / "feedforward.h5"],
        "mat": [old_matlab(folder)],
        "path": [csv(folder)],
        "run": [folder / "run.h5"],
        "tests": [folder / "circle.h5"],
        "report": [folder / "report.html"],
        "yaml": [
            *sorted((ROOT / "tests/documents/before").glob("*.yaml")),
            *sorted((ROOT / "configs").rglob("*.yaml")),
            *sorted((ROOT / "tests/fuzz/documents").glob("*.yaml")),
        ],
    }


def named(known: dict[str, list[Path]]) -> dict[str, str]:
    """Return the whole files that commands name."""
    before = ROOT / "tests/documents/before"
    return {
        "PLANT": str(before / "plant.yaml"),
        "FRICTION": str(before / "gms.yaml"),
        "CIRCLE": str(known["tests"][0]),
        "LOG": str(known["values"][0]),
        "SINE": str(known["values"][1]),
        "PATH": str(known["path"][0]),
        "EMPS": str(known["mat"][0]),
        "STROKE": str(ROOT / "data/strokes/constant-velocity-01.csv"),
    }


def ended(words: list[str], folder: Path) -> tuple[int, str, float, float]:
    """Run a command in a fork; return its status, what it printed, its processor time [s] and its own memory [MB]."""
    beside = int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    with tempfile.TemporaryFile() as heard:
        if (child := os.fork()) == 0:
            _be(words, folder, heard.fileno())
        _, how, used_up = os.wait4(child, 0)
        heard.seek(0)
        text = heard.read().decode(errors="replace")
    return (
        os.waitstatus_to_exitcode(how),
        text,
        used_up.ru_utime + used_up.ru_stime,
        (1024 * used_up.ru_maxrss - beside) / 1e6,
    )


def _be(words: list[str], folder: Path, heard: int) -> None:
    """Be the command, and end."""
    os.dup2(heard, 1)
    os.dup2(heard, 2)
    os.chdir(folder)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY + (1 << 30),) * 2)
    most = LONGER.get("".join(words[:1]), SECONDS)
    resource.setrlimit(resource.RLIMIT_CPU, (most, most + 1))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    faulthandler.disable()  # it would tell of a crash on the screen of the tests
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", encoding="utf-8", errors="backslashreplace", closefd=False)  # noqa: SIM115
    sys.argv[:] = ["fric", *words]
    sys.warnoptions[:] = ["always"]  # which a command says nothing of, and which has a cause
    warnings.simplefilter("always")
    for quiet in (DeprecationWarning, ResourceWarning):
        warnings.filterwarnings("ignore", category=quiet)
    status: Any = 0
    try:
        from fric.cli.main import main

        main()
    except SystemExit as end:
        status = end.code
    except BaseException:
        traceback.print_exc()
        status = 70
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status if isinstance(status, int) else int(status is not None))


def judged(words: list[str], folder: Path) -> str:
    """Return what of a command must not be; empty where it ended well or in a sentence."""
    status, text, seconds, memory = ended(words, folder)
    lines = text.strip().splitlines()
    if "Traceback" in text:
        at = [one.strip() for one in lines if one.strip().startswith("File ") and "/fric/" in one]
        return f"traceback: {lines[-1][:150]} {at[-1] if at else ''}"
    if warned := next((one for one in lines if "Warning:" in one), ""):
        return f"warning: {warned}"
    if status not in {0, 1, 2}:
        return f"status {status}: {' '.join(lines)[-150:]}"
    if odd := {one for one in text if not (one.isprintable() or one == "\n")}:
        return f"unprintable: {odd}"
    if seconds > LONGER.get("".join(words[:1]), SECONDS) or memory > MEMORY / 1e6:
        return f"dear: {seconds:.0f} s, {memory:.0f} MB"
    if left := [one.name for one in folder.rglob(".*") if re.fullmatch(r"\..+-[0-9a-f]{8}(\.\w+)?", one.name)]:
        return f"draft: {left}"
    if status == 0:
        given = " ".join(words).lower()
        outputs = [one for one in sorted(folder.rglob("out*")) if one.is_file()]
        heard = "\n".join(line for line in lines if "which no machine does" not in line)
        for name, held in {"what is printed": heard, **{one.name: _read(one) for one in outputs}}.items():
            for found in NO_NUMBER.finditer(held):
                if found[0].lower() not in given:
                    return f"silent: {name} {held[max(found.start() - 40, 0) : found.end() + 30]!r}"
    return ""


NO_NUMBER = re.compile(
    r"(?<![\w./-])\.?(nan|inf|infinity)(?![\w-])|(?<![\w.#-])\d(\.\d+)?e\+?([4-9]\d|\d{3})(?!\w)", re.IGNORECASE
)
"""What no number of a machine is, as it is written."""


def _read(path: Path) -> str:
    """Return what people read of an output, and what a program of an HDF5 file finds that is no number."""
    if path.suffix == ".h5":
        found: list[str] = []

        def look(name: str, node: Any) -> None:
            if isinstance(node, h5py.Dataset) and node.dtype.kind == "f" and node.size:
                most = float(np.abs(node[()]).max())
                found.extend([] if most < 1e13 else [f"{name} holds {'inf' if most == np.inf else 'nan'}"])

        with h5py.File(path) as file:
            file.visititems(look)
        return " ".join(found)
    text = path.read_text(errors="replace") if path.suffix in {".yaml", ".html"} else ""
    if path.suffix == ".html":
        return re.sub(r"<[^>]*>", " ", re.sub(r"<(script|style|svg).*?</\1>", "", text, flags=re.DOTALL))
    return re.sub(r"^axis: .*$", "", text.partition("\nprovenance:")[0], flags=re.MULTILINE)


def ready() -> None:
    """Import what commands import: each is a fork of this process."""
    for name in (*modules(), *LATE):
        __import__(name)
    processes.default_workers = lambda: 1
    units._registry()


def run(seed: int, numbers: Iterable[int], place: Path) -> Iterator[tuple[Case, list[str], str]]:
    """Yield each case, its words and what of it must not be; its files are in `place / "case"` meanwhile."""
    (place / "whole").mkdir()
    known = known_files(place / "whole")
    files = named(known)
    for n in numbers:
        folder = place / "case"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        with np.errstate(all="ignore"):
            case = Case(seed, n, folder, known)
        split = case.words.split("\0" if "\0" in case.words else None)
        words = [files.get(one, one.replace("FILE", str(case.file))) for one in split]
        yield case, words, judged(words, folder)


def main() -> int:
    """Run cases, tell those that ended as none may, and return 1 where there were any."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--count", type=int, default=1000)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--first", type=int, default=0)
    asked.add_argument("--minutes", type=float, default=1e9)
    asked.add_argument("--keep", type=Path, help="where the files of cases go that ended as none may, each in a folder")
    given = asked.parse_args()
    ready()
    begun, counts, seen = time.monotonic(), Counter[str](), Counter[str]()
    with tempfile.TemporaryDirectory() as place:
        for case, words, wrong in run(given.seed, range(given.first, given.first + given.count), Path(place)):
            counts[case.kind] += 1
            if given.count == 1:
                print(*words, ended(words, Path(place) / "case")[1], sep="\n")
            if wrong and not seen[wrong[:110]]:
                print(f"{case.n} {case.words}: {wrong}", flush=True)
                if given.keep:
                    kept, odd = given.keep / f"{given.seed}-{case.n}", shutil.ignore_patterns("fifo", "loop")
                    shutil.copytree(Path(place) / "case", kept, ignore=odd, dirs_exist_ok=True)
            seen[wrong[:110]] += bool(wrong)
            if time.monotonic() - begun > 60 * given.minutes:
                break
    seen = +seen
    told = ", ".join(f"{kind} {count}" for kind, count in sorted(counts.items()))
    print(f"seed {given.seed}: {counts.total()} cases ({told}), {seen.total()} wrong of {len(seen)} sorts")
    return int(bool(seen))


if __name__ == "__main__":
    sys.exit(main())
