"""The machine file of what was identified: what an axis is, and what its controller believes, are the same."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fric.documents.machine import MachineDocument
from fric.documents.provenance import provenance
from fric.documents.yaml import plain, read_tree

PARTS = ("plant", "controller", "observer", "friction")
TWIN = {"x": "y", "y": "x"}
"""The axis that stands in for the other one of a circle, where one alone was identified."""


def machine_tree(axes: Mapping[str, Mapping[str, Path]], folder: Path) -> dict[str, Any]:
    """Return a machine file whose axes name the files of what was identified.

    Parameters
    ----------
    axes
        The files of each axis by `PARTS`.
    folder
        Where the machine file goes.
    """
    tree: dict[str, Any] = {"fric": MachineDocument.type_name(), "name": "identified machine", "axes": {}}
    for name, files in axes.items():
        tree["axes"][name] = {part: str(path.relative_to(folder)) for part, path in files.items()}
    if len(axes) == 1:
        ((name, files),) = axes.items()
        twin = {part: _bare(path) for part, path in files.items()}
        tree["axes"][TWIN.get(name, "y")] = twin
    return tree | {"provenance": provenance()}


def _bare(path: Path) -> dict[str, Any]:
    """Return the values of a file, without what ties it to its axis."""
    tree = plain(read_tree(path))
    tied = {"fric", "axis", "motion", "fit", "warnings", "warnings_coded", "provenance", "margins", "limits", "reason"}
    tied |= {"bandwidth", "second_mass"}
    return {key: value for key, value in tree.items() if key not in tied and not key.endswith("_fit")}
