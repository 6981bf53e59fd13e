"""Channels on several clocks, resampled to a common clock.

The clock is that of the first requested channel, the position if any, or every n-th of its samples where another
channel was sampled more slowly: no position is invented between counts of an encoder, no sample between those of the
slowest channel. Channels sampled at other instants are interpolated linearly.
"""

from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import ceil
from pathlib import Path

import numpy as np

from fric.arrays import Mask, Real
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.files import JOINED_IN_PART, JOINED_MOVED, JOINED_THINNED
from fric.io.readers.base import Column, ForeignTable, Memory, RowBlock
from fric.notice import Notice
from fric.series import LARGEST

SAME_INSTANT = 1e-3  # Share of a sampling interval up to which two instants are equal
GAP = 2.5  # Sampling intervals above which a part has a gap, across which nothing is interpolated
SLOWEST = 50.0  # Ratio of the sampling rates of two channels above which the slower one is of no motion
MOST_SLOWER = 1e9  # Largest ratio of the sampling rates of two channels


@dataclass(frozen=True)
class SharedClock:
    """Channels that share a clock."""

    table: ForeignTable  # Where they are read from
    time: int  # Index of the column that is their time
    columns: tuple[int, ...] | None = None  # Indices of the channels; all other columns where not given
    factor: float = 1.0  # What one unit of that time is [s]
    label: str = ""  # Goes before the name of a channel that another part has too

    def channels(self) -> tuple[int, ...]:
        """Return the indices of the channels."""
        every = tuple(n for n in range(len(self.table.columns)) if n != self.time)
        return every if self.columns is None else self.columns


def on_clocks(path: Path, clock: Column, channels: Iterable[tuple[Column, Real, Real]]) -> list[SharedClock]:
    """Return channels, each with its instants and values, in parts of those that share their instants."""
    groups = dict[bytes, tuple[list[Column], list[Real]]]()
    for column, time, values in channels:
        columns, data = groups.setdefault(time.tobytes(), ([clock], [time]))
        columns.append(column)
        data.append(values)
    return [SharedClock(Memory(path, columns, data), 0) for columns, data in groups.values()]


class Joined(ForeignTable):
    """One table of the channels of several parts; column 0 is the time [s].

    Instants at which one of the channels has not begun, has ended or has a gap are left out. The channels that were
    shifted, and by how much, are in `notices` once the table is read.

    notices: What is known of the table before it is read.
    Raises FricError: When a stamp of a part is empty, repeated with another value, or runs backwards, or the parts
        share no time.
    """

    def __init__(
        self, path: Path, parts: Sequence[SharedClock], constants: Mapping[str, str] | None = None,
        said: Mapping[str, str] | None = None, notices: Sequence[Notice] = (),
    ) -> None:  # fmt: skip
        self._parts, self._before = tuple(parts), notices
        self._places = [(n, column) for n, part in enumerate(parts) for column in part.channels()]
        names = [parts[n].table.columns[column].name for n, column in self._places]
        columns = [Column("time", "s")]
        for name, (n, column) in zip(names, self._places, strict=True):
            distinct = f"{parts[n].label}.{name}" if names.count(name) > 1 and parts[n].label else name
            columns.append(Column(distinct, parts[n].table.columns[column].unit))
        super().__init__(path, columns, constants, said)

    def blocks(self, wanted: Sequence[int]) -> Iterator[RowBlock]:
        """Read the parts beside each other, block by block of the clock."""
        asked = list(dict.fromkeys(self._places[n - 1] for n in wanted if n))
        used = list(dict.fromkeys(n for n, _ in asked)) or [0]
        streams = {n: _Stream(self._parts[n], [place for place in asked if place[0] == n]) for n in used}
        try:
            yield from self._beside(streams, wanted)
        finally:
            for stream in streams.values():
                stream.close()

    def _beside(self, streams: Mapping[int, "_Stream"], wanted: Sequence[int]) -> Iterator[RowBlock]:
        lead, *others = streams.values()
        slowest = max(streams.values(), key=lambda stream: stream.interval)
        slower = slowest.interval / lead.interval  # inf beside a lone sample
        every = max(ceil(slower - 0.05), 1) if slower < MOST_SLOWER else 1
        # the samples that are kept are those at the instants of the slowest stream
        phase = round((slowest.begun - lead.begun) / lead.interval) if every > 1 else 0
        slack = SAME_INSTANT * lead.interval
        begin = max(stream.time[0] for stream in streams.values()) - slack
        first, seen, row, early, late, holes = lead.time[0], 0, 0, 0, 0, 0
        while len(lead.time):
            time, end = lead.time[(phase - seen) % every :: every], lead.time[-1]
            ended = min((other.upto(end) for other in others), default=np.inf) + slack
            inside = (time >= begin) & (time <= ended)
            early, late = early + int(np.sum(time < begin)), late + int(np.sum(time > ended))
            for other in others:
                hole = inside & ~other.follows(time)
                inside, holes = inside & ~hole, holes + int(np.count_nonzero(hole))
            kept = slice(None) if inside.all() else inside
            time = time[kept]
            values = [value[(phase - seen) % every :: every][kept] for value in lead.values]
            found = dict(zip(lead.columns, values, strict=True))
            for other in others:
                found |= zip(other.columns, other.at(time), strict=True)
            if len(time):
                columns = [found[self._places[n - 1]] if n else time for n in wanted]
                yield RowBlock(row, columns, sum(stream.taken() for stream in streams.values()))
            row, seen = row + len(time), seen + len(lead.time)
            lead.forward()
        if not row:
            spans = "; ".join(f"{s.listed} from {s.begun:.9g} s to {s.last:.9g} s" for s in streams.values())
            raise FricError(
                f"the channels have no time in common: {spans}", where=str(self.path),
                hint="Log them by one clock, or ingest them one by one.",
            )  # fmt: skip
        cut = max(early, late) * every * lead.interval > 2 * slowest.interval
        self.notices = [*self._before]
        if cut or holes:
            found_there = {"samples": row, "begin": max(begin, first), "holes": holes}
            self.notices.append(JOINED_IN_PART.found(str(self.path), **found_there))
        if every > 1:
            self.notices.append(JOINED_THINNED.found(str(self.path), channels=lead.listed, every=every))
        self.notices += [note for other in others for note in other.moved(str(self.path), lead)]

    def quick(self) -> list[int]:
        """Return the columns of all parts but those so slow that others would be thinned to a few samples."""
        intervals = [np.inf] * len(self._parts)
        for n, part in enumerate(self._parts):
            with suppress(FricError):  # a part without samples
                stream = _Stream(part, [(n, column) for column in part.channels()[:1]])
                stream.close()
                intervals[n] = stream.interval
        fast = [interval <= SLOWEST * min(intervals) for interval in intervals]
        return [0, *(k for k, (n, _) in enumerate(self._places, 1) if fast[n])]


class _Stream:
    """Samples of a part while they are read: their stamps [s] and values, without rows that only fill up the table."""

    def __init__(self, part: SharedClock, columns: Sequence[tuple[int, int]]) -> None:
        self.columns, self._part, self._ended, self._size = columns, part, False, 0
        self.last = -np.inf
        names = [part.table.columns[column].name for _, column in columns]
        self.listed = ", ".join(f"'{name}'" for name in names[:6]) or "the time"
        self._samples = self._read()
        self.forward()
        if not len(self.time):
            raise FricError(f"{self.listed} has no samples", where=str(part.table.path), hint="Map another column.")
        self.begun = float(self.time[0])
        self.interval = float(np.median(np.diff(self.time))) if len(self.time) > 1 else np.inf
        self._shift = np.zeros(3)
        self._most = 0.0

    def close(self) -> None:
        """Read no further: threads that parse what is ahead end here, and not where a collector of garbage runs."""
        self._samples.close()

    def forward(self) -> None:
        """Replace what is held by the next samples; by none at the end."""
        self.time, self.values = self._next()

    def upto(self, end: float) -> float:
        """Read on to an instant; return the last stamp where the part ends before it, else infinity."""
        while not self._ended and self.time[-1] < end:
            time, values = self._next()
            self.time = np.concatenate([self.time, time])
            self.values = [np.concatenate(pair) for pair in zip(self.values, values, strict=True)]
        return float(self.time[-1]) if self.time[-1] < end else np.inf

    def follows(self, time: Real) -> Mask:
        """Return which instants lie between samples without a gap between them."""
        if len(self.time) < 2:
            return np.ones(len(time), bool)
        after = np.clip(np.searchsorted(self.time, time), 1, len(self.time) - 1)
        alike = abs(self.time[after] - time) < SAME_INSTANT * self.interval
        return np.asarray(alike | (self.time[after] - self.time[after - 1] < GAP * self.interval))

    def at(self, time: Real) -> list[Real]:
        """Return the values at instants between what is held, and let go of what is before them."""
        found = [np.interp(time, self.time, values) for values in self.values]
        if len(time):
            after = np.clip(np.searchsorted(self.time, time), 1, max(len(self.time) - 1, 1))
            beside = np.stack([self.time[after - 1] - time, self.time[np.minimum(after, len(self.time) - 1)] - time])
            shift = np.take_along_axis(beside, np.abs(beside).argmin(axis=0)[None], axis=0)[0]
            self._shift += [len(shift), shift.sum(), shift @ shift]
            self._most = max(self._most, float(np.abs(shift).max()))
            start = max(int(np.searchsorted(self.time, time[-1], "right")) - 2, 0)
            self.time, self.values = self.time[start:], [values[start:] for values in self.values]
        return found

    def taken(self) -> int:
        """Return the bytes that were read since the last call."""
        size, self._size = self._size, 0
        return size

    def moved(self, where: str, lead: "_Stream") -> list[Notice]:
        """Return a warning about the shift of samples to the clock of another part; none where they lie on it."""
        if self._most <= SAME_INSTANT * min(self.interval, lead.interval):
            return []
        count, total, square = self._shift
        mean = total / count
        even = np.sqrt(max(square / count - mean**2, 0.0)) < 0.05 * self.interval
        by = Estimate(-mean if even else self._most, "s")
        rate = f"{1 / self.interval:.5g} Hz, {1 / lead.interval:.5g} Hz there"
        return [JOINED_MOVED.found(where, channels=self.listed, rate=rate, even=even, by=by, lead=lead.listed)]

    def _next(self) -> tuple[Real, list[Real]]:
        if (found := next(self._samples, None)) is None:
            self._ended = True
            return np.empty(0), [np.empty(0) for _ in self.columns]
        self.last = float(found[0][-1])
        return found

    def _read(self) -> Generator[tuple[Real, list[Real]], None, None]:
        """Yield the samples; instants at the end that no value was written for are none."""
        held: tuple[Real, list[Real]] | None = None
        for block in self._part.table.blocks([self._part.time, *(column for _, column in self.columns)]):
            self._size += block.size
            found = self._cleaned(block)
            if len(found[0]):
                if held is not None:
                    yield held
                held = found
        if held is None:
            return
        time, values = held
        filled = np.logical_or.reduce([np.isfinite(value) for value in values]) if values else np.ones(len(time), bool)
        end = len(filled) - int(np.argmax(filled[::-1])) if filled.any() else 0
        if end:
            yield time[:end], [value[:end] for value in values]

    def _cleaned(self, block: RowBlock) -> tuple[Real, list[Real]]:
        """Return the samples of a block without rows that lack the time, and without repeated rows."""
        time, values = block.columns[0], list(block.columns[1:])
        if self._part.factor != 1.0:
            time = time * self._part.factor
        if np.isnan(np.max(time, initial=-np.inf)):
            empty = np.isnan(time)
            odd = empty & np.logical_or.reduce([np.isfinite(value) for value in values]) if values else ~empty
            if odd.any():
                place = self._part.table.place(block.row + int(np.argmax(odd)), self._part.time)
                raise FricError("there is a value and no time", where=place, hint="Export the log again.")
            time, values = time[~empty], [value[~empty] for value in values]
        if (beyond := ~(np.abs(time) < LARGEST["time"])).any():
            place = self._part.table.place(block.row + int(np.argmax(beyond)), self._part.time)
            raise FricError("the time is beyond all clocks", where=place, hint="Export the log again.")
        if not len(time):
            return time, values
        steps = np.diff(time, prepend=self._stamp)
        self._stamp = float(time[-1])
        if steps.min() > 0:
            return time, values
        # a slow channel may be repeated until its next sample
        same = [np.append(True, (value[1:] == value[:-1]) | np.isnan(value[1:])) for value in values]
        wrong = (steps < 0) | ((steps == 0) & ~np.logical_and.reduce([np.ones(len(steps), bool), *same]))
        if wrong.any():
            n = int(np.argmax(wrong))
            what = "runs backwards" if steps[n] < 0 else "is repeated with another value"
            raise FricError(
                f"the time {time[n]:.9g} s {what}", where=self._part.table.place(block.row + n, self._part.time),
                hint="Split the file there, or log the time with more digits.",
            )  # fmt: skip
        return time[steps > 0], [value[steps > 0] for value in values]

    _stamp = -np.inf
