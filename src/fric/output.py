"""Outputs are written whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
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
    draft = path.with_name(f".{path.stem}-{secrets.token_hex(4)}{path.suffix}")
    try:  # from here on, so that an interrupt at any moment finds the name of what it must remove
        draft.touch(exist_ok=False)
        yield draft
        os.replace(draft, path)
    except OSError as error:
        raise _refused(path, error) from None
    finally:
        with suppress(OSError):  # the folder may not be looked into: then there is nothing in it
            draft.unlink(missing_ok=True)


def _refused(path: Path, error: OSError) -> FricError:
    return FricError(
        f"cannot be written: {error.strerror or error}",
        where=str(path),
        mend="Nothing was written. Make room or name a folder that you may write to.",
    )
