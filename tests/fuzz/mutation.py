"""Real files of every kind, mutated, and read as the commands read them."""

from __future__ import annotations

import gzip
import os
import resource
import signal
import tempfile
import traceback
from collections.abc import Callable, Iterator
from multiprocessing import get_context
from pathlib import Path

import h5py
import numpy as np

from fric.control.scheme import choose_schemes
from fric.documents import document_types
from fric.documents.machine_files import read_machine
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.io.hdf5 import read_records
from fric.io.ingest import ingest
from fric.io.recognise import recognise
from fric.io.report import read_report
from fric.io.run import read_drawn, read_run_provenance, read_runs, write_runs
from fric.simulate.circle import Circle, run_circle

ROOT = Path(__file__).parents[2]
SECONDS, MEMORY = 60, 2 << 30
BATCH = 100
"""Inputs that one process takes: one that dies tells which it was."""


def seeds(folder: Path) -> dict[str, list[Path]]:
    """Return whole files by how they are read, some of them made in a folder."""
    t = np.arange(300) * 1e-3
    rows = zip(t, 50 * np.sin(9 * t), np.cos(9 * t), strict=True)
    text = "time [s],position [um],force [N]\n" + "".join(f"{a:.4f},{b:.3f},{c:.2f}\n" for a, b, c in rows)
    (folder / "log.csv").write_text(text)
    (folder / "log.csv.gz").write_bytes(gzip.compress(text.encode()))
    from scipy.io import savemat

    savemat(
        folder / "log.mat", {"time": t, "position": np.sin(t), "told": "x axis", "cells": np.array([1, "a"], object)}
    )
    with h5py.File(folder / "new.mat", "w", userblock_size=512) as file:
        for name in ("time", "position"):
            file[name] = t.reshape(1, -1)
        file["struct/force"] = t.reshape(-1, 1)
    with (folder / "new.mat").open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file".ljust(512))
    foreign = [folder / name for name in ("log.csv", "log.csv.gz", "log.mat", "new.mat")]
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        pass
    else:
        parquet.write_table(pa.table({"time [s]": t, "position [m]": np.sin(t)}), folder / "log.parquet")
        foreign.append(folder / "log.parquet")
    machine = read_machine(ROOT / "configs" / "xy-table.yaml")
    scheme = choose_schemes("a")[0]
    write_runs(folder / "run.h5", [run_circle(machine, scheme, Circle(0.0005, 0.05))], "{}", most_samples=50)
    yaml = [*sorted((ROOT / "tests/documents/before").glob("*.yaml")), *sorted((ROOT / "configs").rglob("*.yaml"))]
    return {
        "foreign": foreign,
        "log": [ROOT / "data" / f"{name}.h5" for name in ("presliding-sine", "frequency-response")],
        "run": [folder / "run.h5"],
        "yaml": yaml,
    }


def _read_run(path: Path) -> None:
    read_runs(path)
    read_run_provenance(path)
    read_drawn(path)


def _read_yaml(path: Path) -> None:
    kind = recognise(path).partition("/")[0]
    read_document(path, document_types().get(kind, document_types()["plant"]))


READ: dict[str, Callable[[Path], object]] = {
    "foreign": lambda path: ingest(path, path.with_name("out.h5"), bad_cells="drop", force=True),
    "log": lambda path: (read_records(path), ingest(path, path.with_name("out.h5"), force=True)),
    "run": _read_run,
    "yaml": _read_yaml,
    "report": read_report,
}
ODD = (
    b"\0",
    b"\xff" * 8,
    b"1e999",
    b"nan",
    b"-",
    b"\x1b[2J",
    b"[[[[",
    b"9" * 40,
    b"\n" * 9,
    b"&a",
    b"*a",
    b"\xef\xbb\xbf",
)


def mutated(whole: bytes, rng: np.random.Generator) -> bytes:
    """Return bytes with some changed, cut, put in or doubled."""
    data = bytearray(whole)
    for _ in range(int(rng.integers(1, 9))):
        if not data:
            break
        near = len(data) if rng.random() < 0.5 else min(len(data), 4096)
        at, what = int(rng.integers(near)), int(rng.integers(6))
        size = int(rng.integers(1, 64))
        if what == 0:
            data[at] ^= 1 << int(rng.integers(8))
        elif what == 1:
            data[at] = int(rng.integers(256))
        elif what == 2:
            del data[at : at + size]
        elif what == 3:
            data[at:at] = ODD[int(rng.integers(len(ODD)))]
        elif what == 4:
            data[at:at] = data[at : at + size]
        elif rng.random() < 0.3:
            del data[at:]
    return bytes(data)


class TooSlowError(BaseException):
    """An input took longer than it may."""


def _too_slow(number: int, frame: object) -> None:
    raise TooSlowError


def judged(kind: str, path: Path) -> str:
    """Return how reading a file failed, as it must not; empty where it went well or ended in a sentence."""
    signal.signal(signal.SIGALRM, _too_slow)
    signal.alarm(SECONDS)
    try:
        READ[kind](path)
    except FricError as error:
        told = str(error)
        if len(told.splitlines()) > 3 or not all(one.isprintable() or one == "\n" for one in told):
            return f"message: {told[:200]!r}"
    except TooSlowError:
        return f"slow: over {SECONDS} s"
    except Exception:
        return f"traceback: {traceback.format_exc(limit=-3)}"
    finally:
        signal.alarm(0)
    return ""


def _batch(kind: str, source: Path, seed: int, first: int, count: int, folder: Path, told: object) -> None:
    usage = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (usage + MEMORY, usage + MEMORY))
    whole = source.read_bytes()
    for n in range(first, first + count):
        path = folder / f"input{''.join(source.suffixes)}"
        path.write_bytes(mutated(whole, np.random.default_rng([seed, n])))
        told.send((n, judged(kind, path)))  # type: ignore[attr-defined]
    told.send((-1, ""))  # type: ignore[attr-defined]


def run(count: int, seed: int) -> Iterator[tuple[str, Path, int, str]]:
    """Yield kind, source and number of each mutated input, and how it failed; empty where it did not."""
    context = get_context("fork")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        known = seeds(folder)
        share_of = {kind: -(-count // (len(known) * len(paths))) for kind, paths in known.items()}
        sources = [(kind, source, share_of[kind]) for kind, paths in known.items() for source in paths]
        for kind, source, share in sources:
            first = 0
            while first < share:
                size = min(BATCH, share - first)
                here, there = context.Pipe(duplex=False)
                child = context.Process(target=_batch, args=(kind, source, seed, first, size, folder, there))
                child.start()
                there.close()
                last = first
                try:
                    while True:
                        n, failed = here.recv()
                        if n < 0:
                            break
                        last = n + 1
                        yield kind, source, n, failed
                except EOFError:
                    child.join()
                    yield kind, source, last, f"crash: exit status {child.exitcode}"
                    last += 1
                child.join()
                first = last


def replayed(kind: str, source: Path, seed: int, n: int) -> bytes:
    """Return a mutated input again, to be looked at and kept in the corpus."""
    return mutated(source.read_bytes(), np.random.default_rng([seed, n]))
