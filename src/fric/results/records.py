"""Records of a drive, and their uses."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import floor, log10
from pathlib import Path
from typing import Any, overload

from fric.columns import CHANNELS
from fric.documents.inspection import InspectionDocument
from fric.documents.listings import RecordsDocument
from fric.estimate import estimate_rows
from fric.io.hdf5 import write_logs
from fric.log import ForceVelocity, Log, Record
from fric.notice import Notice
from fric.plausibility import Finding, doubts, speed_of
from fric.records.inspection import Channel, Inspected, Inspection, ResponseInspection, TableInspection
from fric.records.inspection import inspect as inspect_record
from fric.records.modes import switched
from fric.results.base import DataFrame, Figure, Piece, Result, Table, in_one_mode, records_of
from fric.results.kinds import LogLike
from fric.units import readable, si_unit
from fric.verb import verb

MOST_WHOLE = 4  # Largest number of records that are printed in full; more are rows of a table


def _whole(found: Inspected) -> list[Piece]:
    kind = f"{found.kind} ({'stated' if found.stated else 'recognised'})"
    pieces: list[Piece] = [f"{found.name}: {kind}, {found.motion} axis {found.axis}"]
    if isinstance(found, ResponseInspection):
        pieces.append(f"{found.points} frequencies from {found.low:.4g} to {found.high:.4g} Hz")
        if found.coherence is not None:
            pieces.append(f"least coherence {found.coherence:.2f}")
    elif isinstance(found, TableInspection):
        pieces += [f"  {name:<15} {text}" for name, text in _table_rows(found)]
    else:
        pieces += [f"  {name:<15} {text}" for name, text in _log_rows(found) if text]
        rows = [_channel_row(name, channel) for name, channel in found.channels.items() if name != "time"]
        pieces.append(Table(("channel", "from", "to", "step", "clipped"), rows))
    pieces += [f"{'good' if use.good else 'not good'} for identify {use.purpose}: {use.why}" for use in found.uses]
    return [*pieces, ""]


def _table_rows(found: TableInspection) -> list[tuple[str, str]]:
    length, force = (si_unit(name, found.motion) for name in ("velocity", "force"))
    return [
        ("source", found.source),
        ("means", f"{found.points} in {'both directions' if found.directions == 2 else 'one direction'}"),
        ("speeds", f"{_value(found.slowest, length)} to {_value(found.fastest, length)}"),
        ("forces", f"{_value(found.weakest, force)} to {_value(found.strongest, force)}"),
        ("columns", ", ".join(found.columns)),
    ]


def _log_rows(found: Inspection) -> list[tuple[str, str]]:
    """Return the properties of a record in time, by name; may be empty."""
    length, speed = (si_unit(name, found.motion) for name in ("position", "velocity"))
    rows = [
        ("source", found.source),
        ("samples", f"{found.samples} in {found.duration:.4g} s"),
        ("sampling", _clock(found)),
        ("gaps", _gaps(found)),
        ("dropped", f"{found.dropped} samples when ingested" if found.dropped else ""),
        ("encoder step", _value(found.encoder_step, length) if found.encoder_step else ""),
        ("reversals", str(len(found.reversals)) if "position" in found.channels else ""),
        ("segments", str(len(found.stretches)) if found.stretches else ""),
        ("speeds", _speeds(found, speed)),
        ("swing", f"{100 * found.swing:.2g} % of the velocity, rms, in the worst segment" if found.swing else ""),
    ]
    if sine := found.sine:
        text = f"{_value(sine.amplitude, length)}, {sine.frequency:.4g} Hz, {sine.cycles:.3g} cycles"
        rows.append(("sine", text + (f", at {_value(sine.mean_velocity, speed)}" if sine.mean_velocity else "")))
    estimates = {"lost per cycle": found.energy} if found.kind in {"presliding-sine", "motion"} else {}
    if between := found.transmission:
        estimates |= {"lost motion": between.lost_motion, "wind-up": between.wind_up, "stiffness": between.stiffness}
    if holding := found.holding:
        estimates |= {"friction at rest": holding.level, "load": holding.load}
    known = {name: estimate for name, estimate in estimates.items() if estimate is not None}
    rows += [(name, f"{value} ({interval}) {unit}") for name, value, interval, unit in estimate_rows(known)]
    if found.rise is not None and found.reversals:
        rows.append(("force rises in", f"{100 * found.rise:.3g} % of a stroke"))
    return rows


def _value(value: float, unit: str) -> str:
    return readable(value, unit, 4)


def _clock(found: Inspection) -> str:
    if found.sampling is None:
        return ""
    even = found.jitter * found.sampling < 1e-6
    return f"{found.sampling:.6g} Hz" + ("" if even else f", jitter {_value(found.jitter, 's')} rms")


def _speeds(found: Inspection, unit: str) -> str:
    if len(found.speeds) == 2 and _value(-found.speeds[0], unit) == _value(found.speeds[1], unit):
        return f"±{_value(found.speeds[1], unit)}"
    if len(found.speeds) <= 12:
        return ", ".join(_value(speed, unit) for speed in found.speeds)
    return f"{len(found.speeds)} from {_value(found.speeds[0], unit)} to {_value(found.speeds[-1], unit)}"


def _gaps(found: Inspection) -> str:
    if not found.gaps:
        return ""
    longest = max(found.gaps, key=lambda gap: gap.intervals)
    return f"{len(found.gaps)}, the longest of {longest.intervals:.4g} samples after {longest.time:.13g} s"


def _channel_row(name: str, channel: Channel) -> tuple[str, ...]:
    step = _value(channel.step, channel.unit) if channel.step else ""
    clipped = str(channel.clipped) if channel.clipped else ""
    size, span = max(abs(channel.low), abs(channel.high)), channel.high - channel.low
    digits = min(4 + max(0, floor(log10(size / span))), 9) if span > 0 else 4  # so many that the two differ
    low, high = (readable(value, channel.unit, digits) for value in (channel.low, channel.high))
    return name, low, high, step, clipped


def _briefly(found: Sequence[Inspected]) -> list[Piece]:
    """Return a line for each record, and their common uses."""
    rows: list[tuple[str, ...]] = []
    for inspection in found:
        good = " ".join(use.purpose for use in inspection.uses if use.good)
        if not isinstance(inspection, Inspection):
            of = "frequencies" if isinstance(inspection, ResponseInspection) else "means"
            rows.append((inspection.name, inspection.kind, "", "", f"{inspection.points} {of}", "", good))
            continue
        speed = si_unit("velocity", inspection.motion)
        flaws = [f"{len(inspection.gaps)} gaps"] if inspection.gaps else []
        flaws += [warning.code for warning in inspection.warnings]
        flaws += [f"{name} clipped" for name, channel in inspection.channels.items() if channel.clipped]
        rate = f"{inspection.sampling:.4g} Hz" if inspection.sampling else ""
        what = _speeds(inspection, speed) or (f"{len(inspection.reversals)} reversals" if inspection.reversals else "")
        kind = inspection.kind if inspection.stated else f"{inspection.kind}?"
        rows.append((inspection.name, kind, f"{inspection.duration:.4g} s", rate, what, ", ".join(flaws), good))
    columns: tuple[str, ...] = ("record", "kind", "duration", "sampling", "what", "flaws", "good for")
    alike, title = {row[1] for row in rows}, ""
    if len(alike) == 1:  # said once, for room
        title = f"all of the kind {next(iter(alike))}"
        columns, rows = columns[:1] + columns[2:], [row[:1] + row[2:] for row in rows]
    pieces: list[Piece] = [Table(columns, rows, title)]
    if any(not inspection.stated for inspection in found):
        pieces.append("? the kind was recognised; the record does not state it")
    uses = Counter[str]()
    for use in (use for inspection in found for use in inspection.uses):
        uses[use.purpose] += use.good
    text = ", ".join(f"{purpose} {count}" for purpose, count in uses.items())
    return [*pieces, f"{len(found)} records; good for identify: {text}"]


class Records(Result, Sequence[Record], schema=RecordsDocument):
    """Records of one axis."""

    records: Sequence[Record]  # Records in time, measured frequency responses, and tables of forces and velocities

    @overload
    def __getitem__(self, index: int) -> Record: ...
    @overload
    def __getitem__(self, index: slice) -> "Records": ...
    def __getitem__(self, index: int | slice) -> "Record | Records":
        return Records(self.records[index]) if isinstance(index, slice) else self.records[index]

    def __len__(self) -> int:
        return len(self.records)

    def __iter__(self) -> Iterator[Record]:
        return iter(self.records)

    @property
    def axis(self) -> str:
        """Name of the axis."""
        return self.records[0].axis

    def report(self) -> list[Piece]:
        """Return a line for each record."""
        rows = [
            (log.name, str(log.kind), str(len(log)), readable(log.time[-1], "s") if isinstance(log, Log) else "")
            for log in self.records
        ]
        return [Table(("record", "kind", "samples", "time"), rows), f"{len(self)} records of axis {self.axis}"]

    def figure(self) -> Figure:
        """Return the figure of each record."""
        return inspect(self).figure()

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write a log file, whole or not at all."""
        write_logs(Path(path), self.records, force=force)

    def to_frame(self) -> DataFrame:
        """Return the samples of all records in SI, by record and time (or frequency, or velocity)."""
        import pandas as pd

        frames = {}
        for log in self.records:
            if isinstance(log, Log):
                frames[log.name] = pd.DataFrame(log.channels()).set_index(CHANNELS[0])
            elif isinstance(log, ForceVelocity):
                frames[log.name] = pd.DataFrame(log.columns()).set_index("velocity")
            else:
                columns = {"magnitude": log.magnitude, "phase": log.phase}
                frames[log.name] = pd.DataFrame(columns, index=pd.Index(log.frequency, name="frequency"))
        return pd.concat(frames, names=["record"])


@verb
def read(*files: LogLike) -> Records:
    """Read the records of log files of one axis.

    files: Log files, as `ingest` writes them.
    Raises FricError: When a file is no log file, or they are of different axes.
    """
    return Records(records_of(files, whole=True))


class InspectionResult(Result, schema=InspectionDocument):
    """The content of records, and their uses."""

    records: Sequence[Record]  # The records
    found: Sequence[Inspected]  # The inspection of each
    switches: Sequence[Notice] = ()  # Where the control switches its mode within a record, which then counts as several

    @property
    def warnings(self) -> tuple[Notice, ...]:
        """Problems of each record, after its name."""
        inspections = [inspection for inspection in self.found if isinstance(inspection, Inspection)]
        found = (notice.at(inspection.name) for inspection in inspections for notice in inspection.warnings)
        return (*self.switches, *found)

    def report(self) -> list[Piece]:
        """Return the full description of a few records; of many, a line each."""
        if len(self.found) > MOST_WHOLE:
            return _briefly(self.found)
        return [piece for inspection in self.found for piece in _whole(inspection)]

    def figure(self) -> Figure:
        """Return the channels of each record."""
        from fric.figures.record import draw_record

        return draw_record(self.records, self.found)

    def by_row(self) -> dict[str, dict[str, Any]]:
        """Return a row for each record: kind, samples and uses."""
        rows = {}
        for record in self.found:
            uses = {use.purpose: use.good for use in record.uses}
            rows[record.name] = {"kind": record.kind, "stated": record.stated} | uses
        return rows


@verb
def inspect(*logs: LogLike) -> InspectionResult:
    """Show what each record of log files contains, and what it can be used for."""
    records = records_of(logs, one_axis=False, whole=True)
    switches = [notice for log in records if isinstance(log, Log) and (notice := switched(log)) is not None]
    parts = [part for record in records for part in in_one_mode(record)]
    return InspectionResult(parts, list(map(_inspected, parts)), switches)


def _inspected(record: Record) -> Inspected:
    """Return the content of a record; of no use where its speed is implausible, for no verb takes it."""
    found = inspect_record(record)
    if not isinstance(record, Log):
        return found
    if not (implausible := doubts([Finding("speed", speed_of(record), record.motion, record.where)])):
        return found
    uses = tuple(replace(use, good=False, why="its speed is implausible") for use in found.uses)
    return replace(found, uses=uses, warnings=(*found.warnings, *implausible))
