"""Real files of every kind, mutated, and read as the commands read them."""

from __future__ import annotations

import gzip
import os
import resource
import shutil
import signal
import tempfile
import traceback
import warnings
from collections.abc import Iterator
from multiprocessing import get_context
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any

import numpy as np

from fric.errors import FricError
from fric.io.hdf5 import write_logs
from tests.fuzz.reading import READ, AbsurdError, changed_values
from tests.fuzz.whole import archive_of, members, whole_files
from tests.fuzz.words import changed_words

SECONDS, MEMORY = 60, 2 << 30
BATCH = 100
"""Inputs that one process takes: one that dies tells which it was."""
WEIGHTS = {
    "yaml": 0.25, "values": 0.1, "machine": 0.3, "words": 1.0, "log": 4.0, "run": 8.0, "circle": 4.0, "report": 6.0,
    ".mf4": 0.2, ".mat": 0.1, ".tdms": 3.0, ".mcap": 3.0, ".db3": 3.0, ".bag": 3.0, ".parquet": 3.0, ".xml": 3.0,
}  # fmt: skip
"""Inputs of a kind, or of files of an ending, beside those of another: by what they cost."""
CONFIGS = Path(__file__).parents[2] / "configs"
NAMED = ("xy-table.yaml", "reality/base.yaml")
"""Files that others name, as they lie beside them."""
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


def replayed(kind: str, source: Path, seed: int, n: int) -> bytes:
    """Return a mutated input: of what is packed, half are changed inside."""
    rng = np.random.default_rng([seed, n])
    if kind == "values":
        with tempfile.TemporaryDirectory() as folder:
            write_logs(Path(folder) / "log.h5", changed_values(source, rng))
            return (Path(folder) / "log.h5").read_bytes()
    if kind == "words":
        return changed_words(source, rng)
    whole, inside = source.read_bytes(), n % 2 == 0
    if inside and source.suffix == ".gz":
        return gzip.compress(mutated(gzip.decompress(whole), rng), mtime=0)
    if inside and source.suffix == ".xlsx":
        files = members(whole)
        name = sorted(files)[int(rng.integers(len(files)))]
        return archive_of(files | {name: mutated(files[name], rng)})
    return mutated(whole, rng)


class TooSlowError(BaseException):
    """An input took longer than it may."""


def _too_slow(number: int, frame: object) -> None:
    raise TooSlowError


def judged(kind: str, path: Path) -> str:
    """Return how reading a file failed, as it must not; empty where it went well or ended in a sentence."""
    signal.signal(signal.SIGPROF, _too_slow)
    signal.setitimer(signal.ITIMER_PROF, SECONDS)  # of the processor: a busy machine is no failure
    try:
        READ[kind](path)
    except FricError as error:
        told = str(error)
        if len(told.splitlines()) > 3 or not all(one.isprintable() or one == "\n" for one in told):
            return f"message: {told[:200]!r}"
    except AbsurdError as error:
        return f"absurd: {error}"
    except TooSlowError:
        return f"slow: over {SECONDS} s"
    except Exception:
        return f"traceback: {traceback.format_exc(limit=-3)}"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return ""


def _batch(kind: str, source: Path, seed: int, first: int, count: int, folder: Path, told: object) -> None:
    usage = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (usage + MEMORY, usage + MEMORY))
    for quiet in (DeprecationWarning, ResourceWarning):  # as users see warnings, but each time
        warnings.simplefilter("always")
        warnings.filterwarnings("ignore", category=quiet)
    heard = os.open(folder / "heard", os.O_RDWR | os.O_CREAT | os.O_APPEND)
    os.dup2(heard, 2)
    for n in range(first, first + count):
        path = folder / f"input{''.join(source.suffixes)}"
        path.write_bytes(replayed(kind, source, seed, n))
        os.ftruncate(heard, 0)
        failed = judged(kind, path)
        if not failed and (size := os.fstat(heard).st_size):
            failed = f"stderr: {os.pread(heard, min(size, 300), 0).decode(errors='replace')!r}"
        told.send((n, failed))  # type: ignore[attr-defined]
    told.send((-1, ""))  # type: ignore[attr-defined]


def shares(count: int, known: dict[str, list[Path]], seed: int) -> list[tuple[str, Path, int]]:
    """Return how many inputs are made from each source; what is left of a share is one input by chance."""
    weights = {
        (kind, source): WEIGHTS.get(kind, 1.0) * WEIGHTS.get(source.suffix, 1.0)
        for kind, paths in known.items()
        for source in paths
    }
    whole = sum(weights.values())
    chance = np.random.default_rng(seed).random(len(weights))
    found = [
        (*which, int(count * each / whole + by)) for (which, each), by in zip(weights.items(), chance, strict=True)
    ]
    return [one for one in found if one[2]]


def run(
    count: int, seed: int, kinds: frozenset[str] = frozenset(READ), workers: int = 1
) -> Iterator[tuple[str, Path, int, str]]:
    """Yield kind, source and number of each mutated input, and how it failed; empty where it did not.

    The inputs are the same with any number of workers, and so is what fails; the order in which they end is not.
    """
    context = get_context("fork")
    with tempfile.TemporaryDirectory() as name, tempfile.TemporaryDirectory() as scratch:
        folders = [Path(scratch) / str(n) / "reality" for n in range(workers)]
        for folder in folders:
            folder.mkdir(parents=True)
            for beside in NAMED:
                shutil.copy(CONFIGS / beside, folder.parent / beside)
        chosen = [one for one in shares(count, whole_files(Path(name)), seed) if one[0] in kinds]
        for kind, source, _ in chosen:  # what is imported and compiled here, no child of ours needs to
            path = folders[0] / f"input{''.join(source.suffixes)}"
            shutil.copy(source, path)
            judged(kind, path)
        pieces = [
            (kind, source, first, min(first + BATCH, share))
            for kind, source, share in chosen
            for first in range(0, share, BATCH)
        ]
        taken = context.Value("i", 0)
        pipes: list[Any] = [context.Pipe(duplex=False) for _ in range(workers)]
        processes = [
            context.Process(target=_work, args=(pieces, taken, seed, folder, pipes, n))
            for n, folder in enumerate(folders)
        ]
        for process in processes:
            process.start()
        for _, there in pipes:
            there.close()
        open_ends: list[Any] = [here for here, _ in pipes]
        while open_ends:
            for here in wait(open_ends):
                try:
                    at, n, failed = here.recv()
                except EOFError:
                    open_ends.remove(here)
                else:
                    yield *pieces[at][:2], n, failed
        for process in processes:
            process.join()
            if process.exitcode:
                raise RuntimeError(f"a worker ended with status {process.exitcode}")


def _work(
    pieces: list[tuple[str, Path, int, int]], taken: Any, seed: int, folder: Path, pipes: list[Any], mine: int
) -> None:
    """Take the next piece until there is none, each in a process that may die of it; tell piece, number and failure."""
    told = pipes[mine][1]
    for end in (end for ends in pipes for end in ends if end is not told):
        end.close()  # else none would hear that another has ended
    context = get_context("fork")
    while True:
        with taken.get_lock():
            at, taken.value = taken.value, taken.value + 1
        if at >= len(pieces):
            return
        kind, source, first, until = pieces[at]
        while first < until:
            here, there = context.Pipe(duplex=False)
            child = context.Process(target=_batch, args=(kind, source, seed, first, until - first, folder, there))
            child.start()
            there.close()
            try:
                while (heard := here.recv())[0] >= 0:
                    told.send((at, *heard))
                    first = heard[0] + 1
            except EOFError:
                child.join()
                told.send((at, first, f"crash: exit status {child.exitcode}"))
                first += 1
            child.join()
