"""Records of a drive, and what they are good for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from fric.columns import CHANNELS
from fric.documents.records import InspectionDocument, RecordsDocument
from fric.io.hdf5 import write_logs
from fric.log import ForceVelocity, FrequencyResponse, Log, Record
from fric.notice import Notice
from fric.records.inspected import Inspection
from fric.records.inspection import Inspected
from fric.records.inspection import inspect as inspect_record
from fric.results.base import Result
from fric.results.given import records_of
from fric.results.inspected import described
from fric.results.kinds import LogLike
from fric.results.text import Piece, Table
from fric.units import readable
from fric.verb import verb

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False)
class Records(Result, Sequence[Record]):
    """Records of one axis.

    Parameters
    ----------
    records
        Records in time, measured frequency responses, and tables of forces and velocities.
    """

    records: Sequence[Record]

    @overload
    def __getitem__(self, index: int) -> Record: ...
    @overload
    def __getitem__(self, index: slice) -> Records: ...
    def __getitem__(self, index: int | slice) -> Record | Records:
        return Records(self.records[index]) if isinstance(index, slice) else self.records[index]

    def __len__(self) -> int:
        return len(self.records)

    def __iter__(self) -> Iterator[Record]:
        return iter(self.records)

    @property
    def axis(self) -> str:
        """Name of the axis."""
        return self.records[0].axis

    @cached_property
    def document(self) -> dict[str, Any]:
        """Kind and samples by record."""
        records = {log.name: {"kind": _kind(log), "samples": _samples(log)} for log in self.records}
        return RecordsDocument.made({"axis": self.axis, "records": records}).tree()

    def report(self) -> list[Piece]:
        """Return a line a record."""
        rows = [(log.name, str(_kind(log)), str(_samples(log)), _duration(log)) for log in self.records]
        return [Table(("record", "kind", "samples", "time"), rows), f"{len(self)} records of axis {self.axis}"]

    def figure(self) -> Figure:
        """Return what each record holds."""
        return inspect(self).figure()

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write a log file, whole or not at all."""
        write_logs(Path(path), self.records, force=force)

    def to_frame(self) -> pd.DataFrame:
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


def _kind(log: Record) -> str | None:
    return "frequency-response" if isinstance(log, FrequencyResponse) else log.kind


def _samples(log: Record) -> int:
    if isinstance(log, ForceVelocity):
        return len(log.velocity)
    return len(log.frequency) if isinstance(log, FrequencyResponse) else len(log)


def _duration(log: Record) -> str:
    return "" if not isinstance(log, Log) else readable(log.time[-1], "s")


@verb
def read(
    *files: LogLike,
) -> Records:
    """Read the records of log files of one axis.

    Parameters
    ----------
    files
        Log files, as `ingest` writes them.

    Raises
    ------
    FricError
        When one is no log file, or they are of different axes.
    """
    return Records(records_of(files))


@dataclass(frozen=True, eq=False, repr=False)
class InspectionResult(Result):
    """What records hold, and what they are good for.

    Parameters
    ----------
    records
        The records.
    found
        What was found in each.
    """

    records: Sequence[Record]
    found: Sequence[Inspected]

    @cached_property
    def document(self) -> dict[str, Any]:
        """What was found, by record."""
        return InspectionDocument.made({"records": self.found}, notices=self.warnings).tree()

    @property
    def warnings(self) -> tuple[Notice, ...]:
        """What is amiss with each record, after its name."""
        return tuple(
            notice.at(one.name) for one in self.found if isinstance(one, Inspection) for notice in one.warnings
        )

    def report(self) -> list[Piece]:
        """Return all that a few records hold; of many, a line each."""
        return described(self.found)

    def figure(self) -> Figure:
        """Return the channels of each record."""
        from fric.figures.record import draw_record

        return draw_record(self.records, self.found)

    def by_row(self) -> dict[str, dict[str, Any]]:
        """Return a line a record: kind, samples and what it is good for."""
        uses = {one.name: {use.purpose: use.good for use in one.uses} for one in self.found}
        return {one.name: {"kind": one.kind, "stated": one.stated} | uses[one.name] for one in self.found}


@verb
def inspect(
    *logs: LogLike,
) -> InspectionResult:
    """Tell what each record of log files holds, and what it is good for.

    Parameters
    ----------
    logs
        Log files of one axis. Records are taken, too.
    """
    records = records_of(logs, one_axis=False)
    return InspectionResult(records, [inspect_record(record) for record in records])
