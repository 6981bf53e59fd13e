"""Foreign logs in, one log file out: columns are mapped to channels in SI, and checked, block by block."""

import ctypes
import hashlib
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, pairwise
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from fric.arrays import Mask, Real
from fric.columns import FORCE_VELOCITY, KINDS, Kind
from fric.documents.listings import IngestedPart
from fric.documents.mapping import FileMapping, MappingDocument, filled
from fric.errors import FricError
from fric.flaws.files import AXES_LEFT_OUT, CELLS_DROPPED, SAMPLES_MISSING
from fric.input import files_of, reading
from fric.io.channels import ColumnPlan, Form, Origin, plan
from fric.io.hdf5 import LogWriter, header_of, log_writer, whole
from fric.io.readers import tables
from fric.io.readers.base import OF_SEVERAL, RECORD, ForeignTable, RowBlock
from fric.io.readers.joined import Joined, SharedClock
from fric.io.words import axis_of_file
from fric.log import Log
from fric.notice import Notice
from fric.output import refuse_ending, refuse_existing
from fric.plausibility import Finding, doubts, speed_of
from fric.units import Motion, drive_unit, words_of

if TYPE_CHECKING:
    from fric.circles.measured import MeasuredCircle


def digest_of(path: Path) -> str:
    """Return the sha256 of a file."""
    with reading(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


WINDOW = 32  # Samples that a sampling period is taken over
RATES_DIFFER = 1.3  # Two segments whose periods differ by more than this factor were sampled at two rates
ODD_SHARE = 0.1  # A segment at another rate that is shorter than this, and inside the record, is missing samples
RUN = 100  # Samples of a run of a file at least


class ClockCheck:
    """Checks that time runs forward, and at one rate.

    Missing samples and jitter are no second rate: that has the mean period of a window changed and four in five of its
    periods with it, for two windows one after the other. (A real log of 75 s at 200 Hz has 1.8 s in which every second
    sample is missing: that gives a warning, not an error.)

    place: Names the place of a sample, by its row in the file.
    uneven: Whether a record of two rates gives a warning, not an error.
    """

    def __init__(self, place: Callable[[int], str], *, uneven: bool = False) -> None:
        self._place, self._uneven, self._window = place, uneven, 0
        self._first, self._last = inf, -inf  # Of the run
        self._left, self._left_rows = np.empty(0), np.empty(0, dtype=np.int64)
        self._periods: list[Real] = []
        self._rows: list[NDArray[np.int64]] = []

    def tick(self, time: Real, rows: NDArray[np.int64]) -> None:
        """Take the next instants [s] and their rows in the file."""
        begins = int(self._last == -inf)
        steps, rows = np.diff(time, prepend=self._last)[begins:], rows[begins:]
        if len(steps) and steps.min() <= 0:
            n = int(np.argmax(steps <= 0))
            now = float(time[len(time) - len(steps) + n])
            problem = f"time runs backwards, from {now - steps[n]:.9g} s to {now:.9g} s"
            problem, hint = (problem, "Split the file there, one record a file.") if steps[n] else (
                f"the stamp {now:.9g} s is repeated",
                "Log the time with more digits, or map it by its rate, as in `time: {rate: 4 kHz}`.",
            )  # fmt: skip
            raise FricError(problem, where=self._place(int(rows[n])), hint=hint)
        self._first = min([self._first, *time[:1]])
        self._last = float(time[-1]) if len(time) else self._last
        self._gather(steps, rows)

    def rising(self, time: Real) -> Mask:
        """Return the samples whose stamps rise, shape (n,); the first may be another run's last."""
        stamps = time.copy()
        if self._last == -inf and len(time) > 2 and time[0] > time[1]:
            stamps[0] = -inf
        return np.asarray(stamps > np.maximum.accumulate(np.concatenate([[self._last], stamps[:-1]])))

    def restarts(self, time: Real) -> list[int]:
        """Return the samples at which another run begins: the time goes back by half of the run or more."""
        found, first = list[int](), self._first
        steps = np.diff(time, prepend=self._last)
        for n in np.flatnonzero(steps < 0.0):
            first = float(time[0]) if first == inf else first
            if n and n - (found[-1] if found else 0) < RUN:
                continue
            if time[n] - first < 0.5 * (time[n] - steps[n] - first):
                found.append(int(n))
                first = float(time[n])
        return found

    def begin(self) -> None:
        """Begin another run, at the rate of which nothing is known."""
        self._last, self._first = -inf, inf

    def _gather(self, steps: Real, rows: NDArray[np.int64]) -> None:
        if not self._window:
            self._window = int(np.clip(len(steps) // 8, 4, WINDOW))
        if len(self._left):
            steps, rows = np.concatenate([self._left, steps]), np.concatenate([self._left_rows, rows])
            self._left, self._left_rows = steps[:0], rows[:0]
        if len(steps) and steps.max() < RATES_DIFFER * steps.min():  # as nearly always: a single entry for all
            mean = steps.mean()
            self._periods.append(np.array([[mean], [mean], [mean], [len(steps) / self._window]]))
            self._rows.append(rows[:1].copy())  # a view would keep all of the rows
            return
        count = len(steps) // self._window
        cut = count * self._window
        self._left, self._left_rows = steps[cut:], rows[cut:]
        windows, fifth = np.sort(steps[:cut].reshape(count, self._window), axis=1), self._window // 5
        once = np.ones(count)
        self._periods.append(np.stack([windows.mean(axis=1), windows[:, fifth], windows[:, -1 - fifth], once]))
        self._rows.append(rows[: cut : self._window].copy())

    def stop(self) -> list[Notice]:
        """End the record; return the warnings about its clock.

        Raises FricError: When the record was sampled at two rates: a tenth of it or more, or its beginning or end.
        """
        if not self._rows:
            return []
        mean, short, long, windows = np.concatenate(self._periods, axis=1)
        rows = np.concatenate(self._rows)
        if windows.sum() < 4:  # too short to judge
            return []
        order = np.argsort(mean)
        upto = np.cumsum(windows[order])
        usual = float(mean[order][np.searchsorted(upto, upto[-1] / 2)])
        slower = (mean > RATES_DIFFER * usual) & (short > RATES_DIFFER * usual)
        faster = (mean * RATES_DIFFER < usual) & (long * RATES_DIFFER < usual)
        for odd in (slower, faster):
            segment = odd & (np.append(odd[1:], False) | np.append(False, odd[:-1]) | (windows > 1))
            if not segment.any():
                continue
            n = int(np.argmax(segment))
            edge = int(rows[n if n else np.argmin(segment)])
            place, text = f"{self._place(edge)} (about)", f"{1 / mean[n]:.4g} Hz there, {1 / usual:.4g} Hz elsewhere"
            share = float((mean * windows)[segment].sum() / (mean * windows).sum())
            if not self._uneven and (share > ODD_SHARE or segment[0] or segment[-1]):
                raise FricError(f"two sampling rates in one record: {text}", where=place,
                                hint="Split the file there, one record a rate.")  # fmt: skip
            return [SAMPLES_MISSING.found(place, rates=text)]
        return []


FEW = 32  # Samples up to which noise may run against the motion


class Signs:
    """Weighs whether the channels agree in sign: friction takes work from the drive, and velocity is dx/dt.

    Work and agreement are summed over windows, so that the steps of an encoder and noise average out. A controller
    that answers each count does work against the motion: the means over windows have to show it, too.
    """

    def __init__(self) -> None:
        self.work = np.zeros(2)
        self.of_means = np.zeros(2)
        self.agreement = np.zeros(2)
        self.samples = 0
        self.pushed = "force"  # What is looked at: of a voltage alone, that

    def add(self, block: Mapping[str, Real]) -> None:
        """Take the next samples of each channel, in SI."""
        time, x, v, force = (block.get(name) for name in ("time", "position", "velocity", "force"))
        if force is None and (force := block.get("input")) is not None:
            self.pushed = "input"
        if time is None and v is not None and force is not None:  # a table of mean forces
            self.work += _weighed(force * v)
        if time is None or len(time) < 2:
            return
        self.samples += len(time)
        moved = np.diff(x) if x is not None and v is None else None
        if v is not None:
            moved = (v[1:] + v[:-1]) * np.diff(time)  # twice the travel: factors do not matter here
            if x is not None:
                self.agreement += _weighed(np.diff(x[:-1:WINDOW], append=x[-1]) * _summed(moved))
        if force is not None and moved is not None:
            self.work += _weighed(_summed((force[1:] + force[:-1]) * moved))
            counts = _summed(np.ones(len(force)))
            F = _summed(force) / counts
            if x is not None:
                self.of_means += _weighed((F[1:] + F[:-1]) * np.diff(_summed(x) / counts))
            elif v is not None:
                self.of_means += _weighed(F * _summed(v) / counts)

    def against(self) -> str:
        """Return the channel with the wrong sign: ``force``, ``input``, ``velocity``, or none."""
        if 0 < self.samples <= FEW:
            return ""
        velocity, force, of_means = (
            size > 0 and total < -0.5 * size for total, size in (self.agreement, self.work, self.of_means)
        )
        return "velocity" if velocity else self.pushed if force and (of_means or not self.of_means[1]) else ""


def _summed(values: Real) -> Real:
    return np.add.reduceat(values, np.arange(0, len(values), WINDOW))


def _weighed(values: Real) -> Real:
    return np.array([values.sum(), np.abs(values).sum()])


OPPOSES = "opposes the motion throughout: by these signs friction drives the axis"
PLAIN = "Write the numbers without a mark between thousands, or other marks."
GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}")  # A number with a mark of a fraction, or between thousands


class WholeRows:
    """Finds the rows of a table that are whole."""

    def __init__(self, table: ForeignTable, chosen: ColumnPlan, drop: bool) -> None:
        self._table, self._wanted, self._drop = table, chosen.wanted, drop
        self._first: tuple[bool, tuple[int, int, float]] | None = None  # Of what is dropped: has it digits, and where
        self._limits = chosen.limits()
        state = chosen.origins.get("mode")
        table.states = None if state is None else state.column

    def good(self, block: RowBlock) -> tuple[list[Real], NDArray[np.int64]]:
        """Return the columns without the rows that are not whole, and the rows' numbers in the file."""
        rows = np.arange(block.row, block.row + len(block.columns[0]))
        if self._table.states is not None:  # a state that lacks is one, too
            n = self._wanted.index(self._table.states)
            block.columns[n] = np.where(np.isfinite(block.columns[n]), block.columns[n], -1.0)
        bounded = list(zip(block.columns, self._limits, strict=True))
        if not len(rows) or all(-most <= values.min() and values.max() <= most for values, most in bounded):  # no NaN
            return block.columns, rows
        whole = np.logical_and.reduce([np.abs(values) <= most for values, most in bounded])
        first = int(np.argmin(whole))
        n = next(n for n, (values, most) in enumerate(bounded) if not np.abs(values[first]) <= most)
        bad = row, column, _ = block.row + first, self._wanted[n], float(block.columns[n][first])
        if self._drop:
            text = (self._table.text(row, column) or "") if self._first is None else ""
            if GROUPED.fullmatch(text):
                raise FricError(f"'{text}' has one of two values", where=self._table.place(row, column), hint=PLAIN)
            self._first = self._first or (any(map(str.isdigit, text)), bad)
            return [values[whole] for values in block.columns], rows[whole]
        raise self._bad(*bad)

    def require_most(self, kept: int, dropped: int) -> None:
        """Raise where most samples are dropped, and the first has digits that are not read: an unknown way to write."""
        if dropped > kept and self._first is not None and self._first[0]:
            raise self._bad(*self._first[1], f"{dropped} of {kept + dropped} samples cannot be used: ")

    def _bad(self, row: int, column: int, value: float, most: str = "") -> FricError:
        text, run = self._table.text(row, column), self._table.run(row, column)
        what = "the cell is empty" if not text else f"'{text}' is not a number"
        if isfinite(value):
            what = f"{value:.3g} is beyond what a machine reaches"
        elif run > 1:
            what = f"{run} cells in a row are not numbers, the first {'empty' if not text else repr(text)}"
        return FricError(
            most + what, where=self._table.place(row, column),
            hint=PLAIN if most else "Mend the file, or leave such samples out with `bad_cells='drop'`.",
        )  # fmt: skip


def joined(files: Sequence[tuple[ForeignTable, ColumnPlan]]) -> tuple[Joined, ColumnPlan]:
    """Return one table of the channels of several files, and the meaning of its columns.

    files: Table and plan of each file; each plan has a time and the channels that the file holds.
    """
    parts: list[SharedClock] = []
    origins = {"time": Origin(0, 1.0)}
    names, holders, stated = ["time"], dict[str, str](), frozenset[str]()
    for table, of_file in files:
        held = {name: origin.column for name, origin in of_file.origins.items() if origin.column is not None}
        if held.keys() < of_file.origins.keys():
            raise FricError(
                "has no column of time, and files are joined by their times", where=str(table.path),
                hint="Write the time into the file, or join files that have it.",
            )  # fmt: skip
        time = held.pop("time")
        columns = tuple(dict.fromkeys(held.values()))
        parts.append(SharedClock(table, time, columns, of_file.origins["time"].factor, table.path.stem))
        for name, column in held.items():
            if name in holders:
                raise FricError(
                    f"{name} is in {holders[name]} and in {table.path.name}", where="`join=True`",
                    hint=f"Say in a mapping which is meant, as in `{name}: {{column: …, file: \"NAME*\"}}`.",
                )  # fmt: skip
            holders[name] = table.path.name
            origins[name] = replace(of_file.origins[name], column=len(names) + columns.index(column))
        names += [f"{table.path.name}: {table.columns[column].name}" for column in columns]
        stated |= of_file.stated
    if not {"position", "velocity"} & origins.keys():
        raise FricError(
            "no file holds position or velocity", where=", ".join(str(table.path) for table, _ in files),
            hint="Name the columns so, or map them.",
        )  # fmt: skip
    first, plan_of_first = files[0]
    table = Joined(first.path, parts, first.constants, first.said)
    return table, ColumnPlan(plan_of_first.motion, origins, tuple(names), stated=stated)


KIND_OF_FORM: dict[Form, Kind] = {"response": "frequency-response", "means": FORCE_VELOCITY}
"""Kinds that follow from the columns."""
EVERYTHING = (-inf, inf)  # A window that leaves nothing out [s]
Progress = Callable[[int], None]


@dataclass(frozen=True)
class StatedLog:
    """What the user states about foreign logs, in addition to their headers."""

    # What the columns mean. Without it the header must name channels and units, as in ``time [s], position [um]``.
    mapping: MappingDocument | None = None
    # kind, axis, motion: kind of the experiment, name and motion of the axis; they have priority over mapping and files
    kind: Kind | None = None
    axis: str | None = None
    motion: Motion | None = None
    # ``error``: a cell that is no number is an error; ``drop``: its sample is left out, and counted
    bad_cells: Literal["error", "drop"] = "error"
    window: tuple[float, float] = EVERYTHING  # First and last time that is read, as the files count it [s]
    join: bool = False  # Make one record of all files, which hold its channels on a common clock, in memory
    is_other: Callable[[ForeignTable], bool] = lambda _: False  # Whether a table beside records is none, as a circle


class IngestSession:
    """One call of `ingest`: its arguments, and its progress."""

    def __init__(self, stated: StatedLog, progress: Progress, beside: ThreadPoolExecutor) -> None:
        self._about, self._progress, self._signs, self._beside = stated, progress, Signs(), beside
        self._stated, self._dropped = set[str](), 0
        self.named = "x"  # What an axis is called that neither its file nor a mapping names
        self.known: dict[str, str] = {}
        self.records: list[IngestedPart] = []
        self.skipped: list[tuple[str, str]] = []
        self.warnings: list[Notice] = []

    def of_axis(self, table: ForeignTable, held: tuple[str, Motion] | None) -> tuple[str, Motion]:
        """Return name and motion of the axis: as stated, as in the file that is added to, or from the units."""
        mapping, fields = self._of(table)
        axis = self._about.axis or table.said.get("axis")
        if mapping and mapping.axis and axis in {None, mapping.axis}:
            axis = filled(mapping.axis, fields, str(table.path))
        said = cast("Motion | None", table.said.get("motion"))
        motion = self._about.motion or (mapping.motion if mapping else None) or said or (held[1] if held else None)
        if motion is None or not (drive_unit(motion) or self._about.join):  # in which unit are forces?
            motion = self._plan(table, motion).motion
        return axis or (held[0] if held else self.named), motion

    def tables(self, path: Path, files: ExitStack) -> Iterator[ForeignTable]:
        """Yield the tables of a file; of a file with several axes, those of the requested axis, or of the first."""
        mapping, axis = self._about.mapping, self._about.axis
        for table in files.enter_context(closing(tables(path, mapping.format if mapping else None))):
            names = table.said.get(OF_SEVERAL, "").split()
            if not names or table.said["axis"] == (axis if axis in names else names[0]):
                yield table

    def first_readable(
        self, sources: Sequence[Path], held: tuple[str, Motion] | None, files: ExitStack
    ) -> tuple[int, Iterable[ForeignTable], tuple[str, Motion], list[FricError]]:
        """Open the first file that can be, and return it with what is wrong with those before it."""
        refused: list[FricError] = []
        for n, source in enumerate(sources):
            try:
                rest = self.tables(source, files)
                first = next(rest)
                return n, chain([first], rest), self.of_axis(first, held), refused
            except FricError as error:
                refused.append(error)
        raise _together(refused, len(sources))

    def read(self, path: Path, found: Iterable[ForeignTable], writer: LogWriter) -> None:
        """Add the records of one file, which are its tables."""
        axis, motion = writer.axis, writer.motion
        digest, none, before = self._beside.submit(digest_of, path), list[FricError](), len(self.records)
        if self.known and digest.result() in self.known:
            self.skipped.append((str(path), self.known[digest.result()]))
            self._progress(path.stat().st_size)
            return
        for table in found:
            try:
                mapping, chosen = self.of_axis(table, (axis, motion)), self._plan(table, motion)
            except FricError as error:
                if RECORD not in table.said:
                    raise
                none.append(error)  # parameters, or a circle, are beside the records
                continue
            if RECORD in table.said and self._about.is_other(table):
                none.append(FricError("is a circle test", where=str(path), hint="Read it with `kind='circle'`."))
                continue
            part = self._of(table)[0] if RECORD in table.said and self._about.axis else None
            if part is not None and part.axis not in {None, axis} and (of := self._about.mapping) and of.parts:
                none.append(FricError(f"is of axis {part.axis}", where=str(path), hint=f"Say `axis='{part.axis}'`."))
                continue
            if mapping != (axis, motion):
                what = f"is of the {words_of(mapping[1])} axis {mapping[0]}, and the log file of the "
                raise FricError(f"{what}{words_of(motion)} {axis}", where=str(path),
                                hint="Write each axis to a separate file, or say `axis=`.")  # fmt: skip
            if "name" in table.said and (same := _digest(table, digest)) in self.known:
                self.skipped.append((f"{path}, record '{table.said['name']}'", self.known[same]))
                continue
            others = [name for name in table.said.get(OF_SEVERAL, "").split() if name != table.said["axis"]]
            if (given := self._about.mapping) and not self._about.axis:
                parts = given.all_of(path, [column.name for column in table.columns])[1:]
                others += [part.axis for part in parts if part.axis not in {None, axis}]
            if others:
                self.warnings.append(AXES_LEFT_OUT.found(str(path), axes=others))
            source = table.said.get("source") or str(path)
            record = self._add(table, chosen, writer, source, partial(_digest, table, digest))
            self.known[record.sha256] = record.name
            self.records.append(record)
        if none and len(self.records) == before:
            raise none[0]

    def check_signs(self) -> None:
        """Refuse logs in which friction would drive the axis, unless the signs are stated."""
        if (against := self._signs.against()) and against not in self._stated:
            what = f"the {against} {OPPOSES}"
            what = "velocity and position run against each other" if against == "velocity" else what
            raise FricError(
                what, where=self.records[0].source if len(self.records) == 1 else f"{len(self.records)} records",
                hint=f"Say `sign: -1` for the {against} in the mapping; or `sign: 1`, if it is meant so.",
            )  # fmt: skip

    def _of(self, table: ForeignTable) -> tuple[FileMapping | None, dict[str, str]]:
        """Return the mapping of a table, None where its header decides; and the ``{fields}`` of its file."""
        path, names = table.path, [column.name for column in table.columns]
        stem = Path(path.name.removesuffix(".gz")).stem
        fields = {"stem": stem, "name": path.name, "parent": path.absolute().parent.name, **table.constants}
        mapping = self._about.mapping.of(path, names, self._about.axis) if self._about.mapping else None
        return mapping, mapping.fields(fields, str(path)) if mapping else fields

    def _kind(self, table: ForeignTable, mapping: FileMapping | None) -> Kind | None:
        said = table.said.get("kind")  # by the file, which may say anything
        found = (mapping and mapping.kind) or (said if said in KINDS else None)
        return self._about.kind or cast("Kind | None", found)

    def _plan(self, table: ForeignTable, motion: Motion | None) -> ColumnPlan:
        mapping, fields = self._of(table)
        return plan(table, mapping, self._kind(table, mapping), motion, fields, part=self._about.join)

    def join(self, paths: Sequence[Path], found: Iterable[Iterable[ForeignTable]], writer: LogWriter) -> None:
        """Add one record whose channels are in several files."""
        sha256 = hashlib.sha256("".join(map(digest_of, paths)).encode()).hexdigest()
        source = " + ".join(map(str, paths))
        if sha256 in self.known:
            self.skipped.append((source, self.known[sha256]))
            return
        files = []
        for path, tables_of in zip(paths, found, strict=True):
            table, *more = tables_of
            if more:
                raise FricError(f"holds {len(more) + 1} tables", where=str(path), hint="Join files of one table each.")
            if (chosen := self._plan(table, writer.motion)).form != "time":
                raise FricError("has no time", where=str(path), hint="Files are joined by their time.")
            if chosen.motion != writer.motion:
                raise FricError(f"has a force in {drive_unit(chosen.motion)}", where=str(path),
                                hint=f"Say `motion='{chosen.motion}'`.")  # fmt: skip
            files.append((table, chosen))
        self.records.append(self._add(*joined(files), writer, source, lambda: sha256))

    def _blocks(self, table: ForeignTable, chosen: ColumnPlan, kind: Kind | None) -> Iterator[dict[str, Real]]:
        """Yield the channels of a table block by block, checked, inside the window; `_dropped` counts what is left out.

        An empty block is between two runs of a file, where samples that cannot be used are dropped.
        """
        drop = self._about.bad_cells == "drop"
        clock = ClockCheck(table.place, uneven=drop or kind == "holding-map")
        rows_of, last = WholeRows(table, chosen, drop), dict[str, float]()
        self._dropped, self._span, kept = 0, (inf, -inf), 0
        for block in table.read(chosen.wanted):
            good, rows = rows_of.good(block)
            kept += len(rows)
            channels = chosen.unwrapped(chosen.convert(good, rows), last)
            self._dropped += len(block.columns[0]) - len(rows)
            starts = clock.restarts(channels["time"]) if drop and chosen.form == "time" else []
            for begin, end in pairwise([0, *starts, len(rows)]):
                if begin in starts:
                    clock.begin()
                    yield {}
                part, taken = {name: values[begin:end] for name, values in channels.items()}, rows[begin:end]
                if drop and chosen.form == "time":
                    rising = clock.rising(part["time"])
                    part, taken = {name: values[rising] for name, values in part.items()}, taken[rising]
                    self._dropped += end - begin - len(taken)
                if chosen.form == "time":
                    clock.tick(part["time"], taken)
                    part = self._inside(part)
                elif self._about.window != EVERYTHING:
                    what = "has no time to take a window of"
                    raise FricError(what, where=str(table.path), hint="Leave out --begin and --end.")
                yield part
            self._progress(block.size)
        rows_of.require_most(kept, self._dropped)
        self.warnings += [*table.notices, *clock.stop()]

    def _add(
        self, table: ForeignTable, chosen: ColumnPlan, writer: LogWriter, source: str, sha256_of: Callable[[], str]
    ) -> IngestedPart:
        mapping, fields = self._of(table)
        name = table.said.get("name") or filled(mapping.record if mapping else "{stem}", fields, str(table.path))
        kind = KIND_OF_FORM.get(chosen.form, self._kind(table, mapping))
        begin = partial(writer.create, name.replace("/", "-"), kind=kind, source=source)
        record, samples = begin(), 0
        for channels in self._blocks(table, chosen, kind):
            if not channels:
                record.close(sha256=sha256_of())
                record = begin()
                continue
            if chosen.form != "response":
                self._signs.add(channels)
            if chosen.form == "time" and not samples and channels["time"].size > 1:
                begun = Log(**cast("Any", channels), motion=writer.motion, name=name, source=source)
                self.warnings += doubts([Finding("speed", speed_of(begun), begun.motion, begun.where)])
            samples += len(next(iter(channels.values())))
            record.extend(channels)
        if samples < 2:
            (low, high), whole_time = self._span, self._about.window == EVERYTHING
            inside = "" if whole_time else f" between `begin=` and `end=`, of {low:g} to {high:g} s"
            raise FricError(f"has {samples} samples{inside}", where=str(table.path), hint="A log needs two at least.")
        self._stated |= chosen.stated
        dropped, sha256 = self._dropped, sha256_of()
        total = dropped + whole(table.said.get("dropped", ""))
        record.close(sha256=sha256, dropped=total or None, labels="\n".join(table.labels) or None)
        if dropped:
            self.warnings.append(CELLS_DROPPED.found(str(table.path), dropped=dropped, samples=samples + dropped))
        return IngestedPart(
            name=record.name, source=source, sha256=sha256, kind=kind, samples=samples, dropped=total,
            channels=chosen.description(),
            left_out=[column.name for n, column in enumerate(table.columns) if n not in chosen.wanted],
        )  # fmt: skip

    def _inside(self, channels: dict[str, Real]) -> dict[str, Real]:
        """Return the samples whose time is inside the window."""
        if self._about.window == EVERYTHING:
            return channels
        kept = (channels["time"] >= self._about.window[0]) & (channels["time"] <= self._about.window[1])
        self._span = min(self._span[0], *channels["time"][:1]), max(self._span[1], *channels["time"][-1:])
        return {name: values[kept] for name, values in channels.items()}


def _digest(table: ForeignTable, file: Future[str]) -> str:
    """Return the digest of a record, or that of its file, with the record's name where the file holds several."""
    said = table.said
    return said.get("sha256") or file.result() + (f":{said['name']}" if "name" in said else "")


_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD = -1, -3  # malloc.h of glibc


def keep_freed_memory() -> None:
    """Let glibc's malloc keep up to 64 MiB of freed bytes a heap, instead of handing large blocks back to the kernel.

    A stream allocates and frees blocks of some hundred KiB over and over; fetching each from the kernel, page by page,
    takes a third of the time of an ingest. Where there is no glibc, nothing is done.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):
        return
    mallopt(_M_MMAP_THRESHOLD, 32 << 20)  # the most that it takes
    mallopt(_M_TRIM_THRESHOLD, 64 << 20)


@dataclass(frozen=True)
class IngestedCircles:
    """What was read: the tests, the file they are in, and warnings."""

    output: str
    tests: tuple["MeasuredCircle", ...]
    samples: int
    warnings: tuple[Notice, ...]
    beside: int = 0  # Tables of the files that hold no circle


@dataclass(frozen=True)
class Ingested:
    """What `ingest` did."""

    output: str  # The log file
    axis: str  # axis, motion: of the log file
    motion: Motion
    records: tuple[IngestedPart, ...]  # Records that were added, in order
    # Files (or records of a log file) that were there already, with the name of the record they are
    skipped: tuple[tuple[str, str], ...]
    warnings: tuple[Notice, ...]  # Warnings

    @property
    def samples(self) -> int:
        """Samples that were added."""
        return sum(record.samples for record in self.records)

    @property
    def dropped(self) -> int:
        """Samples that were left out, because a cell was no number."""
        return sum(record.dropped for record in self.records)


def ingest(
    paths: Iterable[Path] | Path, output: Path, *, append: bool = False, force: bool = False,
    progress: Progress | None = None, **said: Any,
) -> Ingested:  # fmt: skip
    """Read foreign logs of one axis into a log file, one record a file; memory does not grow with the files.

    paths: Text logs (also ``.gz``), MATLAB ``.mat``, Parquet, or log files of fric.
    output: The log file that is written, whole or not at all.
    append: Add to the log file. A file that it holds already (by its sha256) is skipped.
    force: Replace an output that exists.
    progress: Called with the number of bytes that were read since the last call.
    said: What `StatedLog` takes.
    Raises FricError: When a file, its mapping or its data do not allow it: with file, line and column, and nothing is
        written. Of several such files each is named.
    """
    sources, output = files_of(paths), Path(output)
    refuse_ending(output, "HDF5")
    refuse_existing(None if append else output, force=force)
    stated = StatedLog(**said)
    held = header_of(output) if append and output.exists() else None
    with ThreadPoolExecutor(1) as beside, ExitStack() as files:  # digests are taken while the file is read
        session = IngestSession(stated, progress or (lambda _: None), beside)
        if len(letters := {letter for path in sources if (letter := axis_of_file(path))}) == 1:
            session.named = letters.pop()
        first, opened, (chosen_axis, chosen_motion), refused = session.first_readable(sources, held, files)
        with log_writer(output, axis=chosen_axis, motion=chosen_motion, append=append, force=force) as writer:
            session.known = writer.digests()
            if stated.join and not refused:
                session.join(sources, [opened, *(session.tables(source, files) for source in sources[1:])], writer)
            for n, source in enumerate([] if stated.join else sources[first:], first):
                found = opened if n == first else session.tables(source, files)
                try:
                    session.read(source, found, writer)
                except FricError as error:
                    refused.append(error)
            if refused:
                raise _together(refused, len(sources))
            session.check_signs()
    return Ingested(
        str(output), chosen_axis, chosen_motion, tuple(session.records), tuple(session.skipped),
        tuple(session.warnings),
    )  # fmt: skip


def _together(refused: Sequence[FricError], files: int) -> FricError:
    """Return the errors of files as a single error: that of a single file, or a line for each."""
    if len(refused) == 1:
        return refused[0]
    lines = [f"{error.where}: {error.what}" if error.where else error.what for error in refused]
    hints = list(dict.fromkeys(error.hint for error in refused if error.hint))
    return FricError(f"{len(refused)} of {files} files cannot be read:\n" + "\n".join(lines), hint=" ".join(hints[:2]))


def sizes(paths: Sequence[Path]) -> int:
    """Return the total size of the existing files [byte]; for a progress bar."""
    return sum(path.stat().st_size for path in map(Path, paths) if path.is_file())
