"""Examples that come with fric, copied to be tried and edited; and the formats of logs that fric reads."""

from pathlib import Path
from shlex import quote
from typing import Annotated

from fric.documents.bundled import RIG
from fric.documents.bundled import example as files_of
from fric.documents.listings import ExampleDocument, FormatsDocument
from fric.io import readers
from fric.io.propose import proposal
from fric.output import write_folder
from fric.results.base import Piece, Result, Table
from fric.verb import Kind, verb


class FormatsResult(Result, schema=FormatsDocument):
    """The formats, and the libraries that they need."""

    rows: tuple[tuple[str, tuple[str, ...], str, str | None, str], ...]
    """Name, endings, library, its version (empty if none is needed, None if it is missing) and extra of each."""

    def report(self) -> list[Piece]:
        """Return a row for each format."""
        rows = [
            (name, " ".join(endings), f"{library} {version}" if version else "yes" if version is not None
             else f"no: pip install 'fric[{extra}]'")
            for name, endings, library, version, extra in self.rows
        ]  # fmt: skip
        return [Table(("format", "files", "installed"), rows)]


@verb
def formats() -> FormatsResult:
    """Return the formats of logs that `ingest` reads, and which of their libraries are installed."""
    rows = ((f.name, f.endings, f.module.partition(".")[0], readers.installed(f), f.extra) for f in readers.formats())
    return FormatsResult(tuple(rows))


class ExampleResult(Result, schema=ExampleDocument):
    """An example that was copied."""

    name: str  # Its name
    folder: Path  # Where it is
    files: tuple[str, ...]  # Its files, relative to the folder

    def report(self) -> list[Piece]:
        """Return the files, and a command to try."""
        shown = [name for name in self.files if "/strokes/" not in name]
        strokes = len(self.files) - len(shown)
        lines: list[Piece] = [*shown, *([f"data/strokes: {strokes} files"] if strokes else [])]
        if self.name == RIG:
            lines.append(f"try: cd {quote(self.folder.as_posix())} && fric auto data -o found")
        return lines


@verb
def example(
    name: Annotated[str, Kind(metavar="NAME", complete="examples")] = "rig", *,
    output: Annotated[Path | str, Kind(metavar="DIR")], force: bool = False,
) -> ExampleResult:  # fmt: skip
    """Copy an example: logs, mapping and machine of the virtual rig, or a machine, mapping or schemes by name.

    name: rig: logs, mapping, machine; or xy-table, … The name of a bundled machine, mapping, schemes or spread file.
    output: Folder to copy it into. It is made if it does not exist.
    Raises FricError: When there is no such example, or the folder cannot be written.
    """
    files: dict[str, str | bytes] = {**files_of(name)}
    write_folder(Path(output), files, force=force)
    if name == RIG:  # a mapping of these logs, as `fric ingest --propose` makes it: they need none, others will
        made = proposal([Path(output) / file for file in files if "/strokes/" in file])
        write_folder(Path(output), {"mapping.yaml": made}, force=force)
        files["mapping.yaml"] = made
    return ExampleResult(name, Path(output), tuple(files))
