"""Outputs are written whole or not at all."""

import os
import re
import stat
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path

from fric.errors import FricError

REPLACE = "Name another file, or replace it with `force=True`."
LOCKED_MOVE = find_spec("fcntl") is not None  # Whether a file that is open and locked can be moved
WAIT = 30.0  # How long a file that another process adds to is waited for [s]

FORMATS = {  # The type of a file by the ending of its name
    "YAML": (".yaml", ".yml"),
    "HDF5": (".h5", ".hdf5"),
    "HTML": (".html", ".htm"),
    "JSON": (".json",),
    "a figure": (".png", ".svg", ".pdf"),
    "text": (".csv", ".tsv", ".txt", ".gz", ".dat", ".log"),
    "another program's log": (".mat", ".parquet", ".mf4", ".tdms", ".mcap", ".db3", ".bag", ".xlsx", ".xlsm", ".xml"),
}


def refuse_ending(path: Path | None, written: str) -> None:
    """Raise when the name of an output belongs to another of the `FORMATS` than what is written."""
    if path is not None and path.name == "-":
        raise FricError("'-' is no name of a file", hint="Name the output; --json prints on standard output.")
    said = next((name for name, endings in FORMATS.items() if path and path.suffix.lower() in endings), written)
    if path is not None and said != written:
        hint = f"Call it {path.with_suffix(FORMATS[written][0]).name}."
        raise FricError(f"what is written is {written}, and the name ends in {path.suffix}", where=str(path), hint=hint)


def refuse_existing(*paths: Path | None, force: bool = False) -> None:
    """Raise when one of the outputs exists and may not be replaced, or has no folder to go to, before any work.

    What is no regular file, a device, a pipe or a folder, is never replaced.
    """
    for path in paths:
        if path is None:
            continue
        target = _target(path)
        try:
            mode = target.stat().st_mode if target.exists() else None
            if not target.parent.is_dir():
                what = f"cannot be written: there is no folder {target.parent}"
                raise FricError(what, where=str(path), hint="Make the folder first.")
        except OSError as error:  # the folder may not be looked into
            raise _refused(path, error) from None
        if mode is not None and not stat.S_ISREG(mode):
            what = "a folder" if stat.S_ISDIR(mode) else "not a regular file"
            raise FricError(f"cannot be written: it is {what}", where=str(path), hint="Name a file.")
        if mode is not None and not force:
            raise FricError("the output exists", where=str(path), hint=REPLACE)


def _target(path: Path) -> Path:
    """Return the file that a path denotes: the target of a link, whether it exists or not."""
    if not os.path.islink(path):  # False also where the folder may not be looked into
        return path
    try:
        return path.resolve()
    except (OSError, RuntimeError):
        raise FricError("is a link that leads nowhere", where=str(path), hint="Name a file.") from None


@contextmanager
def staged(path: Path, *, force: bool = False) -> Iterator[Path]:
    """Give a temporary path beside ``path``; move it there when the block ends well, remove it otherwise.

    The temporary file is locked while this process lives, so that files left by killed processes are recognised and
    removed; on Windows, which moves no open file, they stay. Without ``force`` the move fails where the output has come
    to be in the meantime: of two runs, the second to end.
    """
    path = Path(path)
    refuse_existing(path, force=force)
    target = _target(path)
    draft, lock = target.with_name(f".{target.stem}-{os.urandom(4).hex()}{target.suffix}"), -1
    try:  # from here on, so that an interrupt at any moment finds the name of what it must remove
        _remove_leftovers(target)
        while lock < 0:
            lock = _locked(draft)
        if not LOCKED_MOVE:
            os.close(lock)
            lock = -1
        yield draft
        if force:
            os.replace(draft, target)
        else:
            _move(draft, target)
    except FileExistsError:
        hint = f"Another process wrote it. {REPLACE}"
        raise FricError("the output came to be while this one was made", where=str(path), hint=hint) from None
    except OSError as error:
        raise _refused(path, error) from None
    finally:
        with suppress(OSError):  # the folder may not be looked into: then there is nothing in it
            draft.unlink(missing_ok=True)
        if lock >= 0:
            os.close(lock)


def written(path: Path, text: str, *, force: bool = False) -> None:
    """Write a text whole or not at all."""
    with staged(path, force=force) as draft:
        draft.write_text(text, encoding="utf-8")


def _locked(draft: Path) -> int:
    """Make an empty file that this process holds a lock on; -1 where another took it for a leftover, just then."""
    lock = os.open(draft, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
    with suppress(OSError):  # a file system without locks: leftovers stay there
        _take(lock)
    if os.fstat(lock).st_nlink:
        return lock
    os.close(lock)
    return -1


def _take(lock: int) -> None:
    """Lock an open file; a `BlockingIOError` where another process holds it, an OSError where there are no locks."""
    if LOCKED_MOVE:
        import fcntl

        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return
    try:
        import msvcrt

        msvcrt.locking(lock, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined,unused-ignore]
    except ImportError:
        raise OSError("there are no locks here") from None
    except OSError:
        raise BlockingIOError from None


def _remove_leftovers(target: Path) -> None:
    """Remove the temporary files of processes that were killed while they wrote this output."""
    if not LOCKED_MOVE:
        return  # which of them another process writes is not known
    ours = re.compile(re.escape(f".{target.stem}-") + "[0-9a-f]{8}" + re.escape(target.suffix))
    for found in target.parent.iterdir():
        if not ours.fullmatch(found.name):
            continue
        with suppress(OSError):
            lock = os.open(found, os.O_RDWR | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))
            try:
                _take(lock)  # fails where its process lives
                if stat.S_ISREG(os.fstat(lock).st_mode):
                    found.unlink()
            finally:
                os.close(lock)


def _move(draft: Path, target: Path) -> None:
    """Give a file its name where nothing has that name yet."""
    try:
        os.link(draft, target)
    except FileExistsError:
        raise
    except OSError:  # a file system without hard links
        if target.exists():
            raise FileExistsError(str(target)) from None
        os.replace(draft, target)


@contextmanager
def alone(path: Path) -> Iterator[None]:
    """Let one process at a time add to a file; others wait for it."""
    target = _target(Path(path))
    beside = target.with_name(f".{target.name}.lock")
    try:  # the folder: the file itself is replaced, and its lock with it; Windows opens no folder
        lock = os.open(*((target.parent, os.O_RDONLY) if LOCKED_MOVE else (beside, os.O_RDWR | os.O_CREAT)))
    except OSError as error:
        raise _refused(path, error) from None
    try:
        until = time.monotonic() + WAIT
        while True:
            try:
                _take(lock)
                break
            except BlockingIOError:
                if time.monotonic() > until:
                    what = f"another process has been adding to a file of {target.parent} for {WAIT:.0f} s"
                    raise FricError(what, where=str(path), hint="Wait for it to end, and try again.") from None
                time.sleep(0.05)
            except OSError:  # a file system without locks
                break
        yield
    finally:
        os.close(lock)
        if not LOCKED_MOVE:
            with suppress(OSError):  # another process waits with it
                beside.unlink(missing_ok=True)


def folder_made(folder: Path | str) -> Path:
    """Return a folder, made where it is not there, as those above it."""
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _refused(Path(folder), error) from None
    return Path(folder)


def write_folder(folder: Path, files: Mapping[str, str | bytes], *, force: bool = False) -> None:
    """Write files into a folder, made where it is not there, as those in it; all or none."""
    folder = Path(folder)
    for place in (folder, *((folder / name).parent for name in files)):
        folder_made(place)
    refuse_existing(*(folder / name for name in files), force=force)
    with together(*(folder / name for name in files)) as made, ExitStack() as drafts:
        for name, content in files.items():
            drafts.enter_context(_counted(folder / name, made))
            draft = drafts.enter_context(staged(folder / name, force=force))
            draft.write_bytes(content.encode() if isinstance(content, str) else content)


@contextmanager
def _counted(path: Path, made: list[Path]) -> Iterator[None]:
    yield
    made.append(path)


@contextmanager
def together(*paths: Path) -> Iterator[list[Path]]:
    """Give a list for the files that the block has made: where it fails they are removed, so that all exist or none.

    Files that existed before are then not touched, old or new.
    """
    fresh, made = [path for path in paths if not path.exists()], list[Path]()
    try:
        yield made
    except BaseException:
        for path in made:
            if path in fresh:
                with suppress(OSError):
                    path.unlink()
        raise


def _refused(path: Path, error: OSError) -> FricError:
    hint = "Nothing was written. Make room or name a folder that you may write to."
    return FricError(f"cannot be written: {error.strerror or error}", where=str(path), hint=hint)
