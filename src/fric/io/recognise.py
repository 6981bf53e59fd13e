"""The type of a file, by its content and not by its name; and reports, HTML with their data as JSON in it."""

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fric.documents.yaml import read_tree
from fric.errors import FricError
from fric.input import MOST_TEXT, reading, regular
from fric.io.safe_hdf5 import open_file, text

FORMAT = "report/1"
REPORT_MARK = '<script type="application/json" id="fric-report">'  # Of a report's data; pages have it letter by letter


def read_report(path: Path) -> dict[str, Any]:
    """Return the data that a report was made of."""
    content = regular(path, MOST_TEXT).read_text(encoding="utf-8", errors="replace")
    try:
        data = json.loads(content.partition(REPORT_MARK)[2].partition("</script>")[0])
    except (ValueError, RecursionError):
        data = None
    if not isinstance(data, dict) or data.get("fric") != FORMAT:
        raise FricError("is not a complete report", where=str(path), hint="Make it again with `fric report`.")
    return data


HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def is_hdf5(path: Path) -> bool:
    """Return whether a file is HDF5 from its first byte and says that it is fric's."""
    with reading(path) as file:
        if not file.read(8).startswith(HDF5_SIGNATURE):
            return False
    with open_file(path, most=sys.maxsize) as opened:
        return "fric" in opened.attrs


def recognise(path: Path) -> str:
    """Return the stated type of a file: ``run/1``, ``log/1``, ``report/1``, ``friction/1``, …."""
    with reading(path) as file:
        head = file.read(512)
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
        hint = "Give run files, log files, or YAML documents that fric wrote; `fric ingest` reads foreign logs."
        raise FricError("is not a file of fric", where=str(path), hint=hint)
    return found
