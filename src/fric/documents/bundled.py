"""What comes with fric: machines, schemes and mappings that have a name, from a checkout or an installed wheel."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import fric
from fric.errors import FricError, near


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


def missing(path: Path, names: Sequence[str] = ()) -> FricError:
    """Return the error of a file that is not there, with the name of one that is near, beside it or bundled."""
    try:
        beside = near(path.name, [one.name for one in path.parent.iterdir()])
    except OSError:
        beside = ""
    bundled = near(str(path), names).replace("?", ", which comes with fric?")
    if not (beside or bundled) and names and not path.suffix:
        bundled = f"These come with fric, by name: {', '.join(names)}."
    return FricError("there is no such file", where=str(path), mend=(beside or bundled).rstrip())
