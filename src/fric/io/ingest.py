"""Foreign logs in, one log file out: columns are mapped to channels in SI, and checked, block by block."""

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from fric.documents.mapping import MappingDocument
from fric.errors import FricError
from fric.io.hdf5 import header_of, log_writer
from fric.io.ingest_session import IngestedRecord, Progress, Session, StatedLog
from fric.io.readers import tables
from fric.io.readers.base import OF_SEVERAL, Table
from fric.notice import Notice
from fric.output import refuse_ending, refuse_existing
from fric.units import Motion


@dataclass(frozen=True)
class Ingested:
    """What `ingest` did."""

    output: str  # The log file
    # axis, motion: of the log file
    axis: str
    motion: Motion
    records: tuple[IngestedRecord, ...]  # Records that were added, in order
    # Files (or records of a log file) that were there already, with the name of the record they are
    skipped: tuple[tuple[str, str], ...]
    warnings: tuple[Notice, ...]  # What the user should know

    @property
    def samples(self) -> int:
        """Samples that were added."""
        return sum(record.samples for record in self.records)

    @property
    def dropped(self) -> int:
        """Samples that were left out, because a cell was no number."""
        return sum(record.dropped for record in self.records)


def ingest(
    paths: Iterable[Path] | Path,
    output: Path,
    *,
    append: bool = False,
    force: bool = False,
    progress: Progress | None = None,
    **said: Any,
) -> Ingested:
    """Read foreign logs of one axis into a log file, one record a file; memory does not grow with the files.

    Parameters
    ----------
    paths
        Text logs (also ``.gz``), MATLAB ``.mat``, Parquet, or log files of fric's own.
    output
        The log file that is written, whole or not at all.
    append
        Add to the log file. A file that it holds already (by its sha256) is skipped.
    force
        Replace an output that exists.
    progress
        Called with the number of bytes that were read since the last call.
    said
        What `StatedLog` takes.

    Raises
    ------
    FricError
        When a file, its mapping or its data do not allow it: with file, line and column, and nothing is written. Of
        several such files each is named.
    """
    sources = [Path(paths)] if isinstance(paths, str | Path) else [Path(path) for path in paths]
    output = Path(output)
    refuse_ending(output, "HDF5")
    refuse_existing(None if append else output, force=force)
    if not sources:
        raise FricError("there is no file to ingest")
    stated = StatedLog(**said)
    mapping, join = stated.mapping, stated.join
    held = header_of(output) if append and output.exists() else None
    with ThreadPoolExecutor(1) as beside, ExitStack() as files:  # digests are taken while the file is read
        session = Session(stated, progress or (lambda _: None), beside)
        opened, refused = _first_readable(sources, stated, session, held, files)
        chosen_axis, chosen_motion = opened.axis
        with log_writer(output, axis=chosen_axis, motion=chosen_motion, append=append, force=force) as writer:
            session.known = writer.digests()
            if join and not refused:
                tables_of = [opened.tables, *(_tables(source, mapping, files, stated.axis) for source in sources[1:])]
                session.join(sources, tables_of, writer, chosen_motion)
            for n, source in enumerate([] if join else sources[opened.number :], opened.number):
                found = opened.tables if n == opened.number else _tables(source, mapping, files, stated.axis)
                try:
                    session.read(source, found, writer, chosen_axis, chosen_motion)
                except FricError as error:
                    refused.append(error)
            if refused:
                raise _together(refused, len(sources))
            session.check_signs()
    return Ingested(
        str(output), chosen_axis, chosen_motion, tuple(session.records), tuple(session.skipped),
        tuple(session.warnings),
    )  # fmt: skip


class _Opened(NamedTuple):
    """The first file that could be opened: its number, its tables, the axis that it is of."""

    number: int
    tables: Iterable[Table]
    axis: tuple[str, Motion]


def _first_readable(
    sources: Sequence[Path],
    stated: StatedLog,
    session: Session,
    held: tuple[str, Motion] | None,
    files: ExitStack,
) -> tuple[_Opened, list[FricError]]:
    """Open the first file that can be, and return it with what is wrong with those before it."""
    refused: list[FricError] = []
    for n, source in enumerate(sources):
        try:
            rest = _tables(source, stated.mapping, files, stated.axis)
            first = next(rest)
            return _Opened(n, chain([first], rest), session.of_axis(first, held)), refused
        except FricError as error:
            refused.append(error)
    raise _together(refused, len(sources))


def _together(refused: Sequence[FricError], files: int) -> FricError:
    """Return what is wrong with files as one error: that of the one, or a line for each."""
    if len(refused) == 1:
        return refused[0]
    lines = [f"{error.where}: {error.what}" if error.where else error.what for error in refused]
    hints = list(dict.fromkeys(error.hint for error in refused if error.hint))
    return FricError(f"{len(refused)} of {files} files cannot be read:\n" + "\n".join(lines), hint=" ".join(hints[:2]))


def _tables(path: Path, mapping: MappingDocument | None, files: ExitStack, axis: str | None) -> Iterator[Table]:
    """Yield the tables of a file; of one that has several axes, those of the one that is asked for, or of the first."""
    for table in files.enter_context(closing(tables(path, mapping.format if mapping else None))):
        names = table.said.get(OF_SEVERAL, "").split()
        if not names or table.said["axis"] == (axis if axis in names else names[0]):
            yield table


def sizes(paths: Sequence[Path]) -> int:
    """Return the bytes of the files together, as far as they are there; for a progress bar."""
    return sum(path.stat().st_size for path in map(Path, paths) if path.is_file())
