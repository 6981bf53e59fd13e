"""Differences between two folders of documents: numbers beyond rounding, and all else that is not equal."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

TINY = 1e-300
NOTICES = {"codes", "warnings_coded"}
"""Keys of lists whose order is free."""


def differences(before: Path, after: Path, within: float) -> Iterator[str]:
    """Yield a line for each value that differs.

    Parameters
    ----------
    before, after
        Folders that `Golden` filled.
    within
        Relative difference up to which numbers are alike; of numbers in a list, relative to the largest of them.
    """
    files = [{str(file.relative_to(folder)) for file in folder.rglob("*.json")} for folder in (before, after)]
    for name in sorted(files[0] ^ files[1]):
        yield f"{name}: only in {before if name in files[0] else after}"
    for name in sorted(files[0] & files[1]):
        a, b = (json.loads((folder / name).read_text(encoding="utf-8")) for folder in (before, after))
        yield from (f"{name}: {line}" for line in _apart(a, b, within, ""))


def _apart(a: Any, b: Any, within: float, where: str, scale: float = 0.0) -> Iterator[str]:
    """Yield what differs below one place of two documents; ``scale`` is the largest number in the list around it."""
    if isinstance(a, dict) and isinstance(b, dict):
        for key in sorted(a.keys() | b.keys()):
            if key in a and key in b:
                pair = (sorted(one[key], key=str) if key in NOTICES else one[key] for one in (a, b))
                yield from _apart(*pair, within, f"{where}.{key}")
            else:
                yield f"{where}.{key}: {'gone' if key in a else 'new'}"
    elif isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        sizes = [abs(value) for value in (*a, *b) if _is_number(value)]
        for n, pair in enumerate(zip(a, b, strict=True)):
            yield from _apart(*pair, within, f"{where}[{n}]", max(sizes, default=0.0))
    elif _is_number(a) and _is_number(b):
        by = abs(a - b) / max(abs(a), abs(b), scale, TINY)
        if by > within:
            yield f"{where}: {a!r} -> {b!r} ({by:.1e})"
    elif a != b:
        yield f"{where}: {_short(a)} -> {_short(b)}"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _short(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 200 else f"{text[:200]}…"
