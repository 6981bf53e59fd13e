"""Where a document comes from: version, time, command, and the logs with their digests."""

import os
import shlex
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from datetime import UTC, datetime
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

import fric
from fric.log import Record

_COMMAND: ContextVar[tuple[str, ...] | None] = ContextVar("command", default=None)


@contextmanager
def commanded(*words: str) -> Iterator[None]:
    """Let the documents that are made meanwhile name a command in place of that of the process."""
    before = _COMMAND.set(words)
    try:
        yield
    finally:
        _COMMAND.reset(before)


def provenance(logs: Iterable[Record] = ()) -> dict[str, Any]:
    """Return the ``provenance`` of a document made by this process from these records.

    The time is ``SOURCE_DATE_EPOCH`` where that is set, so that an output can be made again to the last byte.
    """
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    made = datetime.fromtimestamp(int(epoch), UTC) if epoch else datetime.now(UTC)
    program = Path(sys.argv[0]).name.replace("__main__.py", "fric")
    return {
        "fric": fric.__version__,
        "created": made.isoformat(timespec="seconds"),
        "command": shlex.join(_COMMAND.get() or (program, *sys.argv[1:])),
        **arithmetic(),
        "logs": [{"file": log.source, "record": log.name, "sha256": log.sha256} for log in logs],
    }


@cache
def arithmetic() -> dict[str, str]:
    """Return what rounds sums here: each BLAS with version and architecture, and NumPy's vector instructions."""
    from threadpoolctl import threadpool_info

    keys = ("internal_api", "version", "architecture")
    blas = {
        " ".join(str(one[key]) for key in keys if one.get(key))
        for one in threadpool_info()
        if one["user_api"] == "blas"
    }
    config: Any = np.show_config(mode="dicts")
    extensions = config.get("SIMD Extensions", {})
    chosen = extensions.get("found") or extensions.get("baseline") or ["none"]
    return {"blas": ", ".join(sorted(blas)), "simd": str(chosen[-1])}


def sources(files: Iterable[Path]) -> list[dict[str, str]]:
    """Return name and digest of each file that something was made from."""
    return [{"file": str(file), "sha256": sha256(Path(file).read_bytes()).hexdigest()} for file in files]
