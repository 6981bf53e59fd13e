"""Inputs are regular files of a bounded size, and what a library meets in a damaged one is told as such."""

import stat
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from fric.errors import FricError, near, printable

MOST_TEXT = 32 << 20
"""Bytes of a document or a report that are read at most."""

_OWN = str(Path(__file__).parent)


def regular(path: Path, most: int | None = None, *, of_folder: str = "Name a file in it.") -> Path:
    """Return the path of a regular file, of so many bytes at most.

    Raises
    ------
    FricError
        When there is no such file, or it is a folder, a device or a pipe, or is larger.
    """
    try:
        found = Path(path).stat()
    except (FileNotFoundError, NotADirectoryError):
        raise missing(Path(path)) from None
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise FricError(f"cannot be read: {getattr(error, 'strerror', '') or error}", where=str(path)) from None
    if stat.S_ISDIR(found.st_mode):
        raise FricError("is a folder", where=str(path), hint=of_folder)
    if not stat.S_ISREG(found.st_mode):
        raise FricError("is no regular file", where=str(path), hint="Name a file on a disk.")
    if most is not None and found.st_size > most:
        raise FricError(
            f"holds {found.st_size / 1e6:.3g} MB, and {most / 1e6:.3g} MB are read at most", where=str(path),
            hint="Name the right file.",
        )  # fmt: skip
    return Path(path)


def missing(path: Path, names: Sequence[str] = ()) -> FricError:
    """Return the error of a file that is not there, with the name of one that is near, beside it or bundled."""
    try:
        beside = near(path.name, [one.name for one in path.parent.iterdir()])
    except OSError:
        beside = ""
    bundled = near(str(path), names).replace("?", ", which comes with fric?")
    if not (beside or bundled) and names and not path.suffix:
        bundled = f"These come with fric, by name: {', '.join(names)}."
    return FricError("there is no such file", where=str(path), hint=(beside or bundled).rstrip())


@contextmanager
def foreign(path: Path | str, hint: str = "Make it again.", *, lacking: bool = False) -> Iterator[None]:
    """Tell what another library raises while it reads a file as damage of that file.

    An exception that arises in fric itself is a bug, and stays what it is; but for a missing key or a value of the
    wrong shape where ``lacking`` is set, in the few lines that take a file apart which fric itself wrote.

    Raises
    ------
    FricError
        When the library gives up, or asks for more memory than there is.
    """
    try:
        yield
    except FricError:
        raise
    except MemoryError:
        raise FricError("asks for more memory than there is", where=str(path), hint=hint) from None
    except Exception as error:
        value = lacking and isinstance(error, KeyError | ValueError | TypeError | IndexError | AttributeError)
        if not (value or isinstance(error, RecursionError | OSError)) and _ours(error):
            raise
        text = printable(str(error).partition("\n")[0] or type(error).__name__, 160)
        raise FricError(f"is damaged: {text}", where=str(path), hint=hint) from None


def _ours(error: Exception) -> bool:
    """Say whether an exception arose in fric's own code, and not in a library that it calls."""
    place = error.__traceback__
    while place is not None and place.tb_next is not None:
        place = place.tb_next
    return place is not None and place.tb_frame.f_code.co_filename.startswith(_OWN)
