"""What a file is, by what stands in it and not by its name."""

from collections.abc import Mapping
from pathlib import Path

from fric.documents.yaml import read_tree
from fric.errors import FricError
from fric.input import regular
from fric.io.report import REPORT_MARK
from fric.io.safe_hdf5 import open_file, text

HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def is_hdf5(path: Path) -> bool:
    """Say whether a file is HDF5 from its first byte, as those of fric's own are."""
    with regular(Path(path)).open("rb") as file:
        return file.read(8).startswith(HDF5_SIGNATURE)


def recognise(path: Path) -> str:
    """Return what the file says of itself: ``run/1``, ``log/1``, ``report/1``, ``friction/1``, ….

    Raises FricError: When it cannot be read, or is none of fric's.
    """
    path = regular(Path(path))
    try:
        with path.open("rb") as file:
            head = file.read(512)
    except OSError as error:
        raise FricError(f"cannot be read: {error.strerror or error}", where=str(path)) from None
    if head.startswith(HDF5_SIGNATURE):
        with open_file(path) as file:
            found = text(file.attrs, "fric")
    elif head.lstrip().lower().startswith((b"<!doctype html", b"<html")):
        found = "report/1" if REPORT_MARK in path.read_text(encoding="utf-8", errors="replace") else ""
    elif b"\0" in head:
        found = ""
    else:
        try:
            tree = read_tree(path)
        except FricError:
            if path.suffix.lower() in {".yaml", ".yml"}:
                raise
            tree = None
        found = str(tree.get("fric", "")) if isinstance(tree, Mapping) else ""
    if not found:
        raise FricError(
            "is no file of fric's",
            where=str(path),
            hint="Give run files, log files, or YAML documents that fric wrote; `fric ingest` reads foreign logs.",
        )
    return found
