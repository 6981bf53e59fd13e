"""Results of Renishaw's ball bar (``.b5r``, XML): diagnosed figures, and no trace.

The elements are those that a public parser reads: a ``PLANE`` with its ``TEST_PLANE``, and for each figure a
``FEATURE`` with its ``NAME`` and type ``DT``; ``A`` and ``B`` in a name are the axes of the plane. Others are passed
over.
"""

import re
from collections.abc import Iterator
from math import isfinite
from pathlib import Path

from fric.documents.mapping import Layout
from fric.errors import FricError, printable
from fric.estimate import Estimate
from fric.io.readers.base import ForeignTable, Format, number, read_xml

FORMAT = Format("Renishaw ball bar", (".b5r",))
MOST_BYTES = 64 << 20  # Bytes of a file that are read at most
UNITS = {  # Units of figures by their type: what is one of them in SI
    "UT_LENGTH_UM": (1e-6, "m"), "UT_LENGTH_MM": (1e-3, "m"), "UT_LENGTH_M": (1.0, "m"), "UT_SQUARENESS": (1e-6, "rad"),
    "UT_SERVO_MISMATCH": (1e-3, "s"), "UT_SCALE_ERROR": (1e-6, "1"),
}  # fmt: skip
_SIDE = re.compile(r"_([ab])(?:_(pos|neg))?(?=_|$)")
_SIGNS = {"pos": "+", "neg": "-", None: ""}


def recognises(path: Path, head: bytes) -> float:
    """It is XML, and named so or has a plane of a test."""
    return 1.0 * (head.lstrip(b"\xef\xbb\xbf \r\n").startswith(b"<") and (
        b"TEST_PLANE=" in head or path.suffix.lower() in FORMAT.endings
    ))  # fmt: skip


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Refuse the file: it has no trace."""
    hint = f"See them beside those of the circle: `fric diagnose CIRCLE.h5 --reported {path}`."
    raise FricError("holds the figures of a ball bar, and no trace", hint=hint)


def figures(path: Path) -> tuple[tuple[str, str], dict[str, Estimate]]:
    """Return both axes of the test, and its figures in SI by name: ``circularity``, ``backlash +x``, …."""
    root = read_xml(path, MOST_BYTES)
    plane = next((text for element in root.iter() if (text := element.get("TEST_PLANE", "").strip().lower())), "")
    if not re.fullmatch(r"[a-z]{2}", plane) or plane[0] == plane[1]:
        raise FricError(f"has the test plane '{plane}'", where=str(path), hint="Save the result of the test again.")
    found = dict[str, Estimate]()
    for element in root.iter("FEATURE"):
        name, known = element.get("NAME", "").lower().removeprefix("af_"), UNITS.get(element.get("DT", ""))
        value = number((element.text or "").strip().replace(",", "."))
        if known and name and isfinite(value):
            if abs(value * known[0]) > 1.0:
                what = f"{printable(name)} is {value * known[0]:g} {known[1]}, which no circle shows"
                raise FricError(what, where=str(path), hint="Save the result of the test again.")
            side = _SIDE.search(name)
            of_axis = f" {_SIGNS[side[2]]}{plane['ab'.index(side[1])]}" if side else ""
            found.setdefault(_SIDE.sub("", name).replace("_", " ") + of_axis, Estimate(value * known[0], known[1]))
    if not found:
        raise FricError("holds no figure", where=str(path), hint="Save the result of the test, with its diagnosis.")
    return (plane[0], plane[1]), found
