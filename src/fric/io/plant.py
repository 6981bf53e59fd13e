"""Reading a plant for work on one axis."""

from __future__ import annotations

from pathlib import Path

from fric.drive.plant import Plant
from fric.errors import FricError
from fric.io.documents.plant import PlantDocument
from fric.io.of_axis import read_of_axis
from fric.units import Motion


def read_plant(path: Path, *, axis: str, motion: Motion) -> Plant:
    """Read the plant of one axis, eq. (1), in SI.

    Raises
    ------
    FricError
        When the file is no plant, of another axis or motion, or lacks a value.
    """
    document = read_of_axis(path, PlantDocument, axis=axis, motion=motion)
    try:
        return document.plant(motion)
    except FricError as error:
        raise error.at(str(path)) from None
