"""Reading a document that describes one axis, for work on a log of that axis."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from fric.documents.base import OfAxis
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.units import Motion

D = TypeVar("D", bound=OfAxis)


def read_of_axis(path: Path, kind: type[D], *, axis: str, motion: Motion) -> D:
    """Read a friction, plant or controller file of one axis.

    Raises
    ------
    FricError
        When the file is of another type, axis or motion.
    """
    document = read_document(path, kind)
    if (document.axis, document.motion) != (axis, motion):
        raise FricError(
            f"is the {kind.type} of the {document.motion} axis {document.axis}, "
            f"and the log is of the {motion} axis {axis}",
            where=str(path),
            mend=f"Give the {kind.type} of the axis that was logged.",
        )
    return document


def refuse_other_axis(what: str, of: tuple[str, Motion], wanted: tuple[str, Motion], where: str) -> None:
    """Raise when a file is of another axis, (name, motion), than the plant that is designed for."""
    if of != wanted:
        raise FricError(
            f"is the {what} of the {of[1]} axis {of[0]}, and the plant is of the {wanted[1]} axis {wanted[0]}",
            where=where,
            mend=f"Give the {what} of the axis that is designed for.",
        )
