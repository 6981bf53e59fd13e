"""Outputs are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fric.errors import FricError


def refuse_existing(*paths: Path | None, force: bool = False) -> None:
    """Raise when one of the outputs exists and may not be replaced, or has no folder to go to, before any work."""
    for path in paths:
        try:
            exists = path is not None and path.exists()
            if path is not None and not path.parent.is_dir():
                raise FricError(
                    f"cannot be written: there is no folder {path.parent}",
                    where=str(path),
                    mend="Make the folder first.",
                )
        except OSError as error:  # the folder may not be looked into
            raise _refused(Path(str(path)), error) from None
        if exists and not force:
            raise FricError("the output exists", where=str(path), mend="Name another file, or replace it with --force.")


@contextmanager
def staged(path: Path, *, force: bool = False) -> Iterator[Path]:
    """Give a temporary path beside ``path``; move it there when the block ends well, remove it otherwise.

    Raises
    ------
    FricError
        When the output exists and ``force`` is not set, or the folder or the disk does not take it.
    """
    path = Path(path)
    refuse_existing(path, force=force)
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise _refused(path, error) from None
    os.close(handle)
    draft = Path(name)
    try:
        yield draft
        os.chmod(draft, 0o666 & ~_umask())
        os.replace(draft, path)
    except OSError as error:
        raise _refused(path, error) from None
    finally:
        draft.unlink(missing_ok=True)


def _refused(path: Path, error: OSError) -> FricError:
    return FricError(
        f"cannot be written: {error.strerror or error}",
        where=str(path),
        mend="Nothing was written. Make room or name a folder that you may write to.",
    )


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
