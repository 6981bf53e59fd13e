"""Foreign logs in, one log file out: columns are mapped to channels in SI, and checked, block by block."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import chain
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple, cast

from fric.documents.mapping import MappingDocument, filled
from fric.errors import FricError
from fric.io.audit import Clock, Signs
from fric.io.channels import plan
from fric.io.digest import FileDigest
from fric.io.hdf5 import LogWriter, header_of, log_writer
from fric.io.readers import endings, tables
from fric.io.readers.base import Table
from fric.io.rows import WholeRows
from fric.log import KINDS, Kind
from fric.output import refuse_existing
from fric.units import Motion

if TYPE_CHECKING:
    from fric.io.channels import Values

BadCells = Literal["error", "drop"]
EVERYTHING = (-inf, inf)
"""A window that leaves nothing out [s]."""
Progress = Callable[[int], None]


@dataclass(frozen=True)
class IngestedRecord:
    """One record that was added."""

    name: str
    source: str
    sha256: str
    kind: Kind | None
    samples: int
    dropped: int
    channels: dict[str, str]
    """Each channel and the column it was read from."""
    left_out: tuple[str, ...]
    """Columns that were not read."""


@dataclass(frozen=True)
class Ingested:
    """What `ingest` did.

    Parameters
    ----------
    output
        The log file.
    axis, motion
        Of the log file.
    records
        Records that were added, in order.
    skipped
        Files (or records of a log file) that were there already, with the name of the record they are.
    warnings
        What the user should know.
    """

    output: str
    axis: str
    motion: Motion
    records: tuple[IngestedRecord, ...]
    skipped: tuple[tuple[str, str], ...]
    warnings: tuple[str, ...]

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
    mapping: MappingDocument | None = None,
    kind: Kind | None = None,
    axis: str | None = None,
    motion: Motion | None = None,
    append: bool = False,
    bad_cells: BadCells = "error",
    force: bool = False,
    progress: Progress | None = None,
    window: tuple[float, float] = EVERYTHING,
) -> Ingested:
    """Read foreign logs of one axis into a log file, one record a file; memory does not grow with the files.

    Parameters
    ----------
    paths
        Text logs (also ``.gz``), MATLAB ``.mat``, Parquet, or log files of fric's own.
    output
        The log file that is written, whole or not at all.
    mapping
        What the columns mean. Without it the header must name channels and units, as in ``time [s], position [um]``.
    kind, axis, motion
        Kind of the experiment, name and motion of the axis; they go before what mapping and files say.
    append
        Add to the log file. A file that it holds already (by its sha256) is skipped.
    bad_cells
        ``error``: a cell that is no number is an error; ``drop``: its sample is left out, and counted.
    force
        Replace an output that exists.
    progress
        Called with the number of bytes that were read since the last call.
    window
        First and last time that is read, as the files count it [s].

    Raises
    ------
    FricError
        When a file, its mapping or its data do not allow it: with file, line and column, and nothing is written. Of
        several such files each is named.
    """
    sources = [Path(paths)] if isinstance(paths, str | Path) else [Path(path) for path in paths]
    output = Path(output)
    refuse_foreign_name(output)
    refuse_existing(None if append else output, force=force)
    if not sources:
        raise FricError("there is no file to ingest")
    if kind is not None and kind not in KINDS:
        raise FricError(f"'{kind}' is not a kind of record", hint=f"Kinds are {', '.join(KINDS)}.")
    held = header_of(output) if append and output.exists() else None
    with ThreadPoolExecutor(1) as beside:  # digests are taken while the file is read
        session = _Session(mapping, kind, axis, motion, bad_cells, progress or (lambda _: None), beside, window)
        opened, refused = _first_readable(sources, mapping, session, held)
        chosen_axis, chosen_motion = opened.axis
        with log_writer(output, axis=chosen_axis, motion=chosen_motion, append=append, force=force) as writer:
            session.known = writer.digests()
            for n, source in enumerate(sources[opened.number :], opened.number):
                found = opened.tables if n == opened.number else _tables(source, mapping)
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
    sources: Sequence[Path], mapping: MappingDocument | None, session: _Session, held: tuple[str, Motion] | None
) -> tuple[_Opened, list[FricError]]:
    """Open the first file that can be, and return it with what is wrong with those before it."""
    refused: list[FricError] = []
    for n, source in enumerate(sources):
        try:
            rest = iter(_tables(source, mapping))
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
    mends = list(dict.fromkeys(error.hint for error in refused if error.hint))
    return FricError(f"{len(refused)} of {files} files cannot be read:\n" + "\n".join(lines), hint=" ".join(mends[:2]))


def refuse_foreign_name(output: Path) -> None:
    """Refuse to write HDF5 to a name that ends as a foreign log does."""
    if output.suffix.lower() in endings():
        raise FricError(
            f"what is written is HDF5, and the name ends in {output.suffix}", where=str(output),
            hint=f"Call it {output.with_suffix('.h5').name}.",
        )  # fmt: skip


def _tables(path: Path, mapping: MappingDocument | None) -> Iterable[Table]:
    return tables(path, mapping.format if mapping else None)


class _Session:
    """One call of `ingest`: what was said, and what has been done so far."""

    def __init__(
        self,
        mapping: MappingDocument | None,
        kind: Kind | None,
        axis: str | None,
        motion: Motion | None,
        bad_cells: BadCells,
        progress: Progress,
        beside: ThreadPoolExecutor,
        window: tuple[float, float],
    ) -> None:
        self._mapping, self._kind, self._axis, self._motion = mapping, kind, axis, motion
        self._drop, self._progress = bad_cells == "drop", progress
        self._signs, self._beside, self._window = Signs(), beside, window
        self._stated: set[str] = set()
        self.known: dict[str, str] = {}
        self.records: list[IngestedRecord] = []
        self.skipped: list[tuple[str, str]] = []
        self.warnings: list[str] = []

    def of_axis(self, table: Table, held: tuple[str, Motion] | None) -> tuple[str, Motion]:
        """Return name and motion of the axis: as said, as in the file that is added to, or as the units tell."""
        mapping, said = self._mapping, table.said
        axis = self._axis or said.get("axis")
        if axis is None and mapping and mapping.axis:
            axis = filled(mapping.axis, self._fields(table), str(table.path))
        motion = self._motion or (mapping.motion if mapping else None) or said.get("motion")
        if motion is None:
            motion = held[1] if held else plan(table, mapping, self._kind, None, self._fields(table)).motion
        return axis or (held[0] if held else "x"), cast(Motion, motion)

    def read(self, path: Path, found: Iterable[Table], writer: LogWriter, axis: str, motion: Motion) -> None:
        """Add the records of one file, which are its tables."""
        digest = FileDigest(path, self._beside)
        if self.known and digest.result() in self.known:
            self.skipped.append((str(path), self.known[digest.result()]))
            self._progress(path.stat().st_size)
            return
        for table in found:
            if not self.known and table.tells_bytes:
                table.listener = digest.take
            own = self.of_axis(table, (axis, motion))
            if own != (axis, motion):
                raise FricError(
                    f"is of the {own[1]} axis {own[0]}, and the log file of the {motion} axis {axis}", where=str(path),
                    hint="Keep each axis in a file of its own, or say --axis.",
                )  # fmt: skip
            if "name" in table.said and (same := _digest(table, digest)) in self.known:
                self.skipped.append((f"{path}, record '{table.said['name']}'", self.known[same]))
                continue
            record = self._add(table, writer, motion, digest)
            self.known[record.sha256] = record.name
            self.records.append(record)

    def check_signs(self) -> None:
        """Refuse logs in which friction would drive the axis, unless the signs are stated."""
        against = self._signs.against()
        if against and against not in self._stated:
            what = {
                "force": "the force opposes the motion throughout: by these signs friction drives the axis",
                "velocity": "velocity and position run against each other",
            }[against]
            raise FricError(
                what, where=self.records[0].source if len(self.records) == 1 else f"{len(self.records)} records",
                hint=f"Say `sign: -1` for the {against} in the mapping; or `sign: 1`, if it is meant so.",
            )  # fmt: skip

    def _fields(self, table: Table) -> dict[str, str]:
        stem = table.path.name.removesuffix(".gz")
        stem = stem[: stem.rfind(".")] if "." in stem[1:] else stem
        own = {"stem": stem, "name": table.path.name, "parent": table.path.absolute().parent.name, **table.constants}
        return self._mapping.fields(own, str(table.path)) if self._mapping else own

    def _add(self, table: Table, writer: LogWriter, motion: Motion, digest: FileDigest) -> IngestedRecord:
        fields = self._fields(table)
        chosen = plan(table, self._mapping, self._kind, motion, fields)
        said = table.said
        name = said.get("name") or filled(self._mapping.record if self._mapping else "{stem}", fields, str(table.path))
        kind = self._kind or cast("Kind | None", (self._mapping.kind if self._mapping else None) or said.get("kind"))
        kind = "frequency-response" if chosen.response else kind
        source = said.get("source") or str(table.path)
        record = writer.create(name.replace("/", "-"), kind=kind, source=source)
        rows_of, clock, samples, dropped = WholeRows(table, chosen, self._drop), Clock(table.place), 0, 0
        for block in table.read(chosen.wanted):
            good, rows = rows_of.good(block)
            channels = chosen.convert(good, rows)
            if not chosen.response:
                clock.tick(channels["time"], rows)
                channels = self._inside(channels)
                self._signs.add(channels)
            elif self._window != EVERYTHING:
                raise FricError("a frequency response has no time to take a window of", where=str(table.path))
            samples += len(next(iter(channels.values())))
            dropped += len(block.columns[0]) - len(rows)
            record.extend(channels)
            self._progress(block.size)
        if samples < 2:
            inside = "" if self._window == EVERYTHING else " between --from and --to"
            raise FricError(f"has {samples} samples{inside}", where=str(table.path), hint="A log needs two at least.")
        self.warnings += [*table.told, *filter(None, [clock.stop()])]
        self._stated |= chosen.stated
        total = dropped + int(said.get("dropped", 0))
        sha256 = _digest(table, digest)
        record.close(sha256=sha256, dropped=total or None)
        if dropped:
            self.warnings.append(f"{table.path}: {dropped} of {samples + dropped} samples dropped: a cell is no number")
        left_out = tuple(column.name for n, column in enumerate(table.columns) if n not in chosen.wanted)
        return IngestedRecord(record.name, source, sha256, kind, samples, total, chosen.description(), left_out)

    def _inside(self, channels: dict[str, Values]) -> dict[str, Values]:
        """Return the samples whose time is inside the window."""
        if self._window == EVERYTHING:
            return channels
        kept = (channels["time"] >= self._window[0]) & (channels["time"] <= self._window[1])
        return {name: values[kept] for name, values in channels.items()}


def _digest(table: Table, file: FileDigest) -> str:
    """Return the digest of a record: its own, or that of its file, with its name where the file holds several."""
    said = table.said
    return said.get("sha256") or file.result() + (f":{said['name']}" if "name" in said else "")


def sizes(paths: Sequence[Path]) -> int:
    """Return the bytes of the files together, as far as they are there; for a progress bar."""
    return sum(path.stat().st_size for path in map(Path, paths) if path.is_file())
