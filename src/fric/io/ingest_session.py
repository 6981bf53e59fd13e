"""One call of `fric ingest` at work: tables become records, checked, block by block."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from math import inf
from pathlib import Path
from typing import Literal, cast

from fric.arrays import Real
from fric.columns import FORCE_VELOCITY, KINDS, Kind
from fric.documents.mapping import FileMapping, MappingDocument, filled
from fric.errors import FricError
from fric.flaws.files import CELLS_DROPPED, COLUMNS_LEFT_OUT
from fric.io.audit import Clock, Signs
from fric.io.channels import Form, Plan, plan
from fric.io.digest import FileDigest, digest_of_all
from fric.io.hdf5 import LogWriter
from fric.io.join import joined
from fric.io.readers.base import OF_SEVERAL, RECORD, Table
from fric.io.rows import WholeRows
from fric.notice import Notice
from fric.units import Motion, drive_unit, words_of

KIND_OF_FORM: dict[Form, Kind] = {"response": "frequency-response", "means": FORCE_VELOCITY}
"""Kinds that the columns tell."""
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
class StatedLog:
    """What is said of foreign logs, beside what they say themselves."""

    # What the columns mean. Without it the header must name channels and units, as in ``time [s], position [um]``.
    mapping: MappingDocument | None = None
    # kind, axis, motion: kind of the experiment, name and motion of the axis; they go before what mapping and files say
    kind: Kind | None = None
    axis: str | None = None
    motion: Motion | None = None
    # ``error``: a cell that is no number is an error; ``drop``: its sample is left out, and counted
    bad_cells: BadCells = "error"
    window: tuple[float, float] = EVERYTHING  # First and last time that is read, as the files count it [s]
    join: bool = False  # Make one record of all files, which hold its channels by one clock; these are held in memory

    def __post_init__(self) -> None:
        if self.kind is not None and self.kind not in KINDS:
            raise FricError(f"'{self.kind}' is not a kind of record", hint=f"Kinds are {', '.join(KINDS)}.")


class Session:
    """One call of `ingest`: what was said, and what has been done so far."""

    def __init__(self, stated: StatedLog, progress: Progress, beside: ThreadPoolExecutor) -> None:
        self._mapping, self._about, self._progress = stated.mapping, stated, progress
        self._signs, self._beside = Signs(), beside
        self._stated: set[str] = set()
        self.known: dict[str, str] = {}
        self.records: list[IngestedRecord] = []
        self.skipped: list[tuple[str, str]] = []
        self.warnings: list[Notice] = []

    def of_axis(self, table: Table, held: tuple[str, Motion] | None) -> tuple[str, Motion]:
        """Return name and motion of the axis: as said, as in the file that is added to, or as the units tell."""
        mapping, said = self._of(table), table.said
        axis = self._about.axis or said.get("axis")
        if axis is None and mapping and mapping.axis:
            axis = filled(mapping.axis, self._fields(table), str(table.path))
        motion = self._about.motion or (mapping.motion if mapping else None) or said.get("motion")
        if motion is None and held:
            motion = held[1]
        known = cast("Motion | None", motion)
        if known is None or not (drive_unit(known) or self._about.join):  # in which unit are forces?
            known = self._plan(table, known).motion
        return axis or (held[0] if held else "x"), known

    def read(self, path: Path, found: Iterable[Table], writer: LogWriter, axis: str, motion: Motion) -> None:
        """Add the records of one file, which are its tables."""
        digest, none, before = FileDigest(path, self._beside), list[FricError](), len(self.records)
        if self.known and digest.result() in self.known:
            self.skipped.append((str(path), self.known[digest.result()]))
            self._progress(path.stat().st_size)
            return
        for table in found:
            if not self.known and table.passes_bytes:
                table.listener = digest.take
            try:
                own = self.of_axis(table, (axis, motion))
            except FricError as error:
                if RECORD not in table.said:
                    raise
                none.append(error)  # beside records stand parameters
                continue
            if own != (axis, motion):
                raise FricError(
                    f"is of the {words_of(own[1])} axis {own[0]}, and the log file of the {words_of(motion)} {axis}",
                    where=str(path),
                    hint="Keep each axis in a file of its own, or say `axis=`.",
                )  # fmt: skip
            if "name" in table.said and (same := _digest(table, digest)) in self.known:
                self.skipped.append((f"{path}, record '{table.said['name']}'", self.known[same]))
                continue
            if others := [name for name in table.said.get(OF_SEVERAL, "").split() if name != table.said["axis"]]:
                self.warnings.append(COLUMNS_LEFT_OUT.found(str(path), columns=others))
            source = table.said.get("source") or str(path)
            sha256_of = partial(_digest, table, digest)
            record = self._add(table, self._plan(table, motion), writer, source, sha256_of)
            self.known[record.sha256] = record.name
            self.records.append(record)
        if none and len(self.records) == before:
            raise none[0]

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
        mapping = self._of(table)
        return mapping.fields(own, str(table.path)) if mapping else own

    def _of(self, table: Table) -> FileMapping | None:
        """Return what is said of a table; None where nothing is, and its header has to."""
        names = [column.name for column in table.columns]
        return self._mapping.of(table.path, names, self._about.axis) if self._mapping else None

    def _plan(self, table: Table, motion: Motion | None) -> Plan:
        mapping = self._of(table)
        kind = self._about.kind or cast("Kind | None", table.said.get("kind") if not mapping else None)
        return plan(table, mapping, kind, motion, self._fields(table), part=self._about.join)

    def _name_and_kind(self, table: Table, chosen: Plan) -> tuple[str, Kind | None]:
        mapping = self._of(table)
        said, template = table.said, mapping.record if mapping else "{stem}"
        name = said.get("name") or filled(template, self._fields(table), str(table.path))
        kind = self._about.kind or cast("Kind | None", (mapping.kind if mapping else None) or said.get("kind"))
        return name.replace("/", "-"), KIND_OF_FORM.get(chosen.form, kind)

    def join(self, paths: Sequence[Path], found: Iterable[Iterable[Table]], writer: LogWriter, motion: Motion) -> None:
        """Add one record whose channels are in several files."""
        sha256, source = digest_of_all(paths), " + ".join(map(str, paths))
        if sha256 in self.known:
            self.skipped.append((source, self.known[sha256]))
            return
        files = []
        for path, tables_of in zip(paths, found, strict=True):
            table, *more = tables_of
            if more:
                raise FricError(f"holds {len(more) + 1} tables", where=str(path), hint="Join files of one table each.")
            chosen = self._plan(table, motion)
            if chosen.form != "time":
                raise FricError("has no time", where=str(path), hint="Files are joined by their time.")
            if chosen.motion != motion:
                raise FricError(f"has a force in {drive_unit(chosen.motion)}", where=str(path),
                                hint=f"Say `motion='{chosen.motion}'`.")  # fmt: skip
            files.append((table, chosen))
        self.records.append(self._add(*joined(files), writer, source, lambda: sha256))

    def _blocks(self, table: Table, chosen: Plan) -> tuple[Iterator[dict[str, Real]], list[int]]:
        """Return the channels of a table block by block, checked, inside the window; and a count of what is dropped."""
        drop = self._about.bad_cells == "drop"
        rows_of, clock, dropped = WholeRows(table, chosen, drop), Clock(table.place, uneven=drop), [0]
        last: dict[str, float] = {}

        def blocks() -> Iterator[dict[str, Real]]:
            for block in table.read(chosen.wanted):
                good, rows = rows_of.good(block)
                channels = chosen.unwrapped(chosen.convert(good, rows), last)
                if chosen.form == "time":
                    if drop:
                        rising = clock.rising(channels["time"])
                        channels, rows = {name: one[rising] for name, one in channels.items()}, rows[rising]
                    clock.tick(channels["time"], rows)
                    channels = self._inside(channels)
                elif self._about.window != EVERYTHING:
                    raise FricError("has no time to take a window of", where=str(table.path))
                dropped[0] += len(block.columns[0]) - len(rows)
                yield channels
                self._progress(block.size)
            self.warnings += [*table.notices, *clock.stop()]

        return blocks(), dropped

    def _add(
        self, table: Table, chosen: Plan, writer: LogWriter, source: str, sha256_of: Callable[[], str]
    ) -> IngestedRecord:
        name, kind = self._name_and_kind(table, chosen)
        record = writer.create(name, kind=kind, source=source)
        blocks, missing = self._blocks(table, chosen)
        samples = 0
        for channels in blocks:
            if chosen.form != "response":
                self._signs.add(channels)
            samples += len(next(iter(channels.values())))
            record.extend(channels)
        dropped = missing[0]
        if samples < 2:
            inside = "" if self._about.window == EVERYTHING else " between `begin=` and `end=`"
            raise FricError(f"has {samples} samples{inside}", where=str(table.path), hint="A log needs two at least.")
        self._stated |= chosen.stated
        total = dropped + int(table.said.get("dropped", 0))
        sha256 = sha256_of()
        record.close(sha256=sha256, dropped=total or None)
        if dropped:
            self.warnings.append(CELLS_DROPPED.found(str(table.path), dropped=dropped, samples=samples + dropped))
        left_out = tuple(column.name for n, column in enumerate(table.columns) if n not in chosen.wanted)
        return IngestedRecord(record.name, source, sha256, kind, samples, total, chosen.description(), left_out)

    def _inside(self, channels: dict[str, Real]) -> dict[str, Real]:
        """Return the samples whose time is inside the window."""
        if self._about.window == EVERYTHING:
            return channels
        kept = (channels["time"] >= self._about.window[0]) & (channels["time"] <= self._about.window[1])
        return {name: values[kept] for name, values in channels.items()}


def _digest(table: Table, file: FileDigest) -> str:
    """Return the digest of a record: its own, or that of its file, with its name where the file holds several."""
    said = table.said
    return said.get("sha256") or file.result() + (f":{said['name']}" if "name" in said else "")
