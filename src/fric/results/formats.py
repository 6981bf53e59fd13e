"""The formats of logs that are read here."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from fric.documents.listings import FormatsDocument
from fric.io import readers
from fric.results.base import Result
from fric.results.text import Piece, Table
from fric.verb import verb


@dataclass(frozen=True, eq=False, repr=False)
class FormatsResult(Result):
    """The formats, and the libraries that they need.

    Parameters
    ----------
    rows
        Of each its name, endings, library, its version (empty where none is needed, None where it lacks) and extra.
    """

    rows: tuple[tuple[str, tuple[str, ...], str, str | None, str], ...]

    @cached_property
    def document(self) -> dict[str, Any]:
        """Each format: endings of its files, library, version, whether it is read here, and the extra."""
        rows = [
            {"name": name, "endings": list(endings), "library": library or None, "version": version or None,
             "installed": version is not None, "extra": extra or None}
            for name, endings, library, version, extra in self.rows
        ]  # fmt: skip
        return FormatsDocument.made({"formats": rows}).tree()

    def report(self) -> list[Piece]:
        """Return a row a format."""
        rows = [
            (name, " ".join(endings), f"{library} {version}" if version else "yes" if version is not None
             else f"no: pip install 'fric[{extra}]'")
            for name, endings, library, version, extra in self.rows
        ]  # fmt: skip
        return [Table(("format", "files", "installed"), rows)]


@verb
def formats() -> FormatsResult:
    """Return the formats of logs that `ingest` reads, and which of their libraries are installed."""
    return FormatsResult(
        tuple(
            (form.name, form.endings, form.module.partition(".")[0], readers.installed(form), form.extra)
            for form in readers.formats()
        )
    )
