"""Inputs are regular files of a bounded size; errors of a library in a damaged file become a `FricError`."""

import shlex
import stat
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path

from fric.errors import FricError, near, printable

MOST_TEXT = 32 << 20  # Bytes of a document or a report that are read at most
MOST_PACKED, SMALL = 3000, 1 << 20  # Most bytes that a stored byte declares (DEFLATE: 1032), and that any may
_OWN = str(Path(__file__).parent)


def regular(path: Path, most: int | None = None, *, of_folder: str = "Name a file in it, or use `fric auto`.") -> Path:
    """Return the path of a regular file of a bounded size [byte]."""
    try:
        found = Path(path).stat()
    except (FileNotFoundError, NotADirectoryError):
        raise missing(Path(path)) from None
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise _unread(path, error) from None
    if stat.S_ISDIR(found.st_mode):
        raise FricError("is a folder", where=str(path), hint=of_folder)
    if not stat.S_ISREG(found.st_mode):
        raise FricError("is not a regular file", where=str(path), hint="Name a file on a disk.")
    if most is not None and found.st_size > most:
        what = f"holds {found.st_size / 1e6:.3g} MB, and {most / 1e6:.3g} MB are read at most"
        raise FricError(what, where=str(path), hint="Name the right file.")
    return Path(path)


@contextmanager
def reading(path: Path, most: int | None = None, **of_folder: str) -> Iterator[BufferedReader]:
    """Give a file that is `regular`, open to be read as bytes; raise a `FricError` where the system does not let it."""
    try:
        with regular(path, most, **of_folder).open("rb") as file:
            yield file
    except OSError as error:
        raise _unread(path, error) from None


def _unread(path: Path, error: Exception) -> FricError:
    why = getattr(error, "strerror", "") or error
    return FricError(f"cannot be read: {why}", where=str(path), hint="May you read it, and is it a whole file?")


def files_of(paths: Iterable[Path | str] | Path | str) -> list[Path]:
    """Return files that are given alone or several; raise a `FricError` where there is none."""
    if not (found := list(map(Path, [paths] if isinstance(paths, str | Path) else paths))):
        raise FricError("there is no file to read", hint="Name one.")
    return found


def refuse_declared(where: Path | str, declared: int, stored: int | None = None) -> None:
    """Raise where samples are declared [byte] that what is stored of them, or the whole file, cannot hold."""
    stored = Path(where).stat().st_size if stored is None else stored
    if declared > max(SMALL, MOST_PACKED * stored):
        what = f"declares {declared / 1e6:.3g} MB of samples, and has {stored / 1e6:.3g} MB"
        raise FricError(what, where=str(where), hint="Export it again.")


def missing(path: Path, names: Sequence[str] = (), kind: str = "") -> FricError:
    """Return the error of a missing file, with a similar name of a file in its folder or of a bundled file.

    kind: Type of the document that is wanted, as ``plant``: no file of another type is named.
    """
    try:
        others = [other for other in path.parent.iterdir() if other != path and (not kind or _is_of(other, kind))]
        beside = near(path.name, [other.name for other in others if near(path.stem, [other.stem])])  # not by its ending
    except OSError:
        beside = ""
    bundled = near(str(path), names).replace("?", ", which comes with fric?")
    if not (beside or bundled) and names and not path.suffix:
        bundled = f"These come with fric, by name: {', '.join(names)}."
    hint = (beside or bundled).rstrip() or f"It was looked for in {path.parent.absolute()}."
    return FricError("there is no such file", where=str(path), hint=hint)


def _is_of(path: Path, kind: str) -> bool:
    small = path.suffix in {".yaml", ".yml", ".json"} and path.is_file() and path.stat().st_size < MOST_TEXT
    return small and f"fric:{kind}/".encode() in path.read_bytes()[:4096].translate(None, b' "')


@contextmanager
def foreign(path: Path | str, hint: str = "Make it again.", *, lacking: bool = False) -> Iterator[None]:
    """Report what another library raises while it reads a file as damage of that file; errors without a place get it.

    An exception that arises in fric itself is a bug and is not changed. The exceptions are a missing key and a value of
    the wrong shape where ``lacking`` is set, for lines that read a file which fric wrote.
    """
    try:
        yield
    except FricError as error:
        raise error if error.where else error.at(str(path)) from None
    except MemoryError:
        raise FricError("asks for more memory than there is", where=str(path), hint=hint) from None
    except Exception as error:
        of_value = KeyError | ValueError | TypeError | IndexError | AttributeError | OverflowError
        value = lacking and isinstance(error, of_value)
        if not (value or isinstance(error, RecursionError | OSError)) and _ours(error):
            raise
        text = printable(str(error).partition("\n")[0], 160)
        if value and _ours(error) and not isinstance(error, KeyError):  # whose text only a programmer understands
            text = "a part is not as fric writes it"
        raise FricError(f"is damaged: {text}".rstrip(": "), where=str(path), hint=hint) from None


def _ours(error: Exception) -> bool:
    """Return whether an exception arose in fric's code, and not in a library that it calls."""
    place = error.__traceback__
    while place is not None and place.tb_next is not None:
        place = place.tb_next
    return place is not None and place.tb_frame.f_code.co_filename.startswith(_OWN)


TAKEN = {  # What to type with a file of each kind that fric writes
    "plan": ("fric simulate experiment MACHINE.yaml --plan {0} -o log.h5",),
    "block": ("fric simulate circle MACHINE.yaml --with x={0}",),
    "friction": ("fric simulate circle MACHINE.yaml --friction x={0}", "fric identify gms LOG.h5 --static {0}"),
    "plant": ("fric design controller {0} -o controller.yaml", "fric identify static LOG.h5 --plant {0}"),
    "controller": ("fric design observer PLANT.yaml --controller {0}", "fric auto LOGS --controller {0}"),
    "observer": ("fric simulate circle MACHINE.yaml --with x={0}",),
    "machine": ("fric simulate circle {0}", "fric diagnose CIRCLE.h5 --machine {0}"),
    "log": ("fric inspect {0}",),
    "circle": ("fric diagnose {0}", "fric auto LOGS --circle {0}"),
    "run": ("fric report {0} -o report.html",),
    "mapping": ("fric ingest FILES --map {0} -o log.h5",),
    "schemes": ("fric simulate circle MACHINE.yaml --schemes {0}",),
    "spread": ("fric simulate circle MACHINE.yaml --monte-carlo 100 --spread {0}",),
}
MADE = {  # How a file of each kind is made
    "friction": "`fric identify static LOG.h5 -o friction.yaml`",
    "plant": "`fric identify plant LOG.h5 -o plant.yaml`",
    "controller": "`fric design controller PLANT.yaml -o controller.yaml`",
    "machine": "`fric auto LOGS -o found`, in found/machine.yaml",
    "log": "`fric ingest FILES -o log.h5`",
    "mapping": "`fric ingest FILES --propose map.yaml`",
    "plan": "`fric plan --stroke '300 mm' --feed '100 mm/s' -o plan`, in plan/plan.yaml",
    "circle": "`fric ingest --kind circle FILE -o circle.h5`",
    "run": "`fric simulate circle MACHINE.yaml -o run.h5`",
}


def other_kind(path: Path, given: str, wanted: str) -> FricError:
    """Return the error of a file of fric's that is of another kind than is wanted, with what to type."""
    kind, asked = (text.partition("/")[0] for text in (given, wanted))
    taken = TAKEN.get(kind, ()) if kind != asked else ()  # nothing takes another version
    use = " or ".join(f"`{text.format(shlex.quote(Path(path).as_posix()))}`" for text in taken)
    hints = [f"Use it in {use}."] if use else []
    hints += [f"A {asked} file is made by {MADE[asked]}."] if asked in MADE else []
    what = f"is a {kind} file, and a {asked} file is needed" if taken else f"holds {given}, not {wanted}"
    return FricError(what, where=str(path), hint=" ".join(hints))
