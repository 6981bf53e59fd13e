"""Reading a document that describes one axis, for work on a log of that axis."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from fric.errors import FricError
from fric.io.documents.controller import ControllerDocument
from fric.io.documents.friction import FrictionDocument
from fric.io.documents.plant import PlantDocument
from fric.io.yaml import read_document
from fric.units import Motion

D = TypeVar("D", FrictionDocument, PlantDocument, ControllerDocument)


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
