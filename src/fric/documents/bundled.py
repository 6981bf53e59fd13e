"""What comes with fric: machines, schemes and mappings that have a name, from a checkout or an installed wheel."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import fric
from fric.input import missing


def folder(name: str) -> Path:
    """Return a folder of what comes with fric, ``configs`` or ``data``."""
    package = Path(fric.__file__).parent
    return next((place / name for place in (package, package.parents[1]) if (place / name).is_dir()), package / name)


@cache
def bundled(kind: str) -> dict[str, Path]:
    """Return the bundled documents of a type by their names: ``xy-table`` and ``virtual-rig`` of ``machine``, …."""
    head = f"fric: {kind}/"
    return {path.stem: path for path in sorted(folder("configs").rglob("*.yaml")) if head in path.read_text("utf-8")}


def located(path: Path, kind: str) -> Path:
    """Return a path, or the bundled document whose name was given where there is no such file.

    Raises
    ------
    FricError
        When there is neither: with a name that is near.
    """
    if path.exists():
        return path
    known = bundled(kind)
    if str(path) in known:
        return known[str(path)]
    raise missing(path, tuple(known))
