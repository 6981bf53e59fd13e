"""Machines from their files."""

from __future__ import annotations

from pathlib import Path

from fric.errors import FricError
from fric.io.documents.machine import MachineDocument
from fric.io.yaml import read_document
from fric.simulate.machine import Machine


def read_machine(path: Path) -> Machine:
    """Read a machine file, and the files that it names.

    Raises
    ------
    FricError
        When a file does not read, a value is missing, of the wrong unit or not physical, or a part is of another axis.
    """
    document = read_document(path, MachineDocument)
    try:
        return document.machine()
    except FricError as error:
        raise error.at(str(path)) from None
