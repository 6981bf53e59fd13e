"""Steps that leave files, and are not made again as long as nothing that they depend on has changed."""

import json
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import fric
from fric.output import folder_made, written
from fric.process import tried

LEDGER = ".steps.json"


class StepCache:
    """A folder with a ledger of what each step was made from.

    A step is made again when a file that it reads, its settings, or the code of fric has changed, or when what it left
    is gone or was edited.

    folder: The folder; made where it is not there.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder_made(folder)
        ledger = self.folder / LEDGER
        try:
            found = json.loads(ledger.read_text(encoding="utf-8")) if ledger.exists() else {}
        except (ValueError, RecursionError):
            found = {}
        self._known: dict[str, Any] = found if isinstance(found, dict) else {}

    def __len__(self) -> int:
        """Return the number of steps that were made, now or before."""
        return len(self._known)

    def step(
        self, name: str, make: Callable[[], None], *, reads: Iterable[Path], leaves: Iterable[Path],
        settings: Mapping[str, Any] | None = None,
    ) -> bool:  # fmt: skip
        """Make a step unless its files are up to date; return whether it was made."""
        leaves = list(leaves)
        wanted = {
            "code": code_digest(),
            "settings": json.loads(json.dumps(dict(settings or {}))),
            "reads": {path.name: _digest(path) for path in reads},
        }
        known = self._known.get(name, {})
        if known.get("from") == wanted and known.get("leaves") == _digests(leaves):
            return False
        tried(name)
        for path in leaves:
            path.unlink(missing_ok=True)
        make()
        self._known[name] = {"from": wanted, "leaves": _digests(leaves)}
        written(self.folder / LEDGER, json.dumps(self._known, indent=1), force=True)
        return True


@cache
def code_digest() -> str:
    """Return a digest of the code of fric."""
    package = Path(fric.__file__).parent
    files = sorted(path for path in package.rglob("*") if path.suffix in {".py", ".j2", ".css", ".toml", ".mplstyle"})
    return sha256(b"".join(path.read_bytes() for path in files)).hexdigest()


def _digest(path: Path) -> str:
    return sha256(path.read_bytes()).hexdigest() if path.exists() else ""


def _digests(paths: Iterable[Path]) -> dict[str, str]:
    return {path.name: _digest(path) for path in paths}
