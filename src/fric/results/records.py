"""Records of a drive, and what they are good for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from fric.columns import CHANNELS
from fric.documents.records import InspectionDocument
from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.identify.records.inspected import Inspection
from fric.identify.records.inspection import Inspected
from fric.identify.records.inspection import inspect as inspect_record
from fric.io.hdf5 import write_logs
from fric.log import ForceVelocity, FrequencyResponse, Log, Record
from fric.notice import Notice
from fric.results.base import Result
from fric.results.given import Advance, document_of, in_si, quantity, records_of, several, silent
from fric.results.inspected import described
from fric.results.machine import machine_of
from fric.results.text import Piece, Table
from fric.simulate.experiment import experiment as run_experiment
from fric.simulate.trial import logs_of
from fric.units import readable

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from fric.simulate.machine import Axis
    from fric.simulate.trial import Trial


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
        return {
            "axis": self.axis,
            "records": {log.name: {"kind": _kind(log), "samples": _samples(log)} for log in self.records},
        }

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


def read(*files: Any) -> Records:
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
    return Records(records_of("read", files))


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
        content = {"records": [one.as_dict() for one in self.found]}
        return InspectionDocument.made(content, notices=self.warnings).tree()

    @property
    def warnings(self) -> tuple[Notice, ...]:
        """What is amiss with each record, after its name."""
        return tuple(
            Notice(f"{one.name}: {text}", text.code, text.severity)
            for one in self.found
            if isinstance(one, Inspection)
            for text in one.warnings
        )

    def report(self) -> list[Piece]:
        """Return all that a few records hold; of many, a line each."""
        return described(self.found)

    def figure(self) -> Figure:
        """Return the channels of each record."""
        from fric.figures.record import draw_record

        return draw_record(self.records, self.found)

    def to_frame(self) -> pd.DataFrame:
        """Return a line a record: kind, samples and what it is good for."""
        import pandas as pd

        uses = {one.name: {use.purpose: use.good for use in one.uses} for one in self.found}
        return pd.DataFrame.from_dict(
            {one.name: {"kind": one.kind, "stated": one.stated} | uses[one.name] for one in self.found}, orient="index"
        )


def inspect(*logs: Any) -> InspectionResult:
    """Tell what each record holds, and what it is good for.

    Parameters
    ----------
    logs
        Log files or records.
    """
    records = records_of("inspect", logs, one_axis=False)
    return InspectionResult(records, [inspect_record(record) for record in records])


def experiment(
    machine: Any,
    kind: str | None = None,
    axis: str = "x",
    *,
    plan: Any = None,
    seed: int = 0,
    samples: int | None = None,
    speeds: Sequence[float] | str | None = None,
    amplitudes: Sequence[float] | str | None = None,
    frequency: float | str | None = None,
    mean: float | str | None = None,
    peaks: Sequence[float] | str | None = None,
    encoder: float | str | None = None,
    noise: float | str | None = None,
    advance: Advance = silent,
) -> Records:
    """Make an identification experiment on a virtual axis, logged as a real drive logs it.

    Parameters
    ----------
    machine
        The machine, its file, or the name of a bundled one.
    kind
        ``constant-velocity``, ``presliding-sine``, ``sliding-sine``, ``frequency-response``, or ``all``; left out
        with a plan.
    axis
        The axis that is moved.
    plan
        A plan, its file or its folder: its records are made, and nothing else is to be said of the motion.
    seed
        Seed of all that is random; a plan's excitation is that of the plan.
    samples
        Samples that the drive's trace holds, for each record.
    speeds, amplitudes, frequency, mean, peaks
        Of the motion [m/s], [m], [Hz], [m/s], [m/s]; lists also as texts with commas. The paper's where not given.
    encoder, noise
        Encoder step [m] and force noise, rms [N], instead of the machine's.
    advance
        Is told of each record that is made.

    Raises
    ------
    FricError
        When there is no such axis or kind, or the axis cannot follow.
    """
    named = str(machine) if isinstance(machine, str | Path) else machine_of("experiment", machine).name
    subject = machine_of("experiment", machine).axis(axis)
    motion = subject.motion
    if encoder is not None:
        subject = replace(subject, encoder=Encoder(in_si(encoder, "position", motion)))
    if noise is not None:
        subject = replace(subject, force_noise=in_si(noise, "force", motion))
    settings: dict[str, Any] = {
        "samples": samples,
        "speeds": several(speeds, "velocity", motion),
        "amplitudes": several(amplitudes, "position", motion),
        "frequency": quantity(frequency, "frequency"),
        "mean": None if mean is None else in_si(mean, "velocity", motion),
        "peaks": several(peaks, "velocity", motion),
    }
    given = {name: value for name, value in settings.items() if value is not None}
    if (plan is None) == (kind is None):
        raise FricError("an experiment is of a kind or of a plan", hint="Give --kind, or --plan.")
    if plan is None:
        logs = run_experiment(subject, str(kind), seed=seed, **given)
    elif given:
        raise FricError(f"a plan says its motions, and {', '.join(given)} was given too", hint="Change the plan.")
    else:
        logs = logs_of(subject, _trials(plan, subject), seed)
    made = []
    for log in logs:
        made.append(replace(log, source=Path(named).name))
        advance()
    return Records(made)


def _trials(plan: Any, axis: Axis) -> list[Trial]:
    """Return what a plan asks of an axis."""
    if isinstance(plan, str | Path) and Path(plan).is_dir():
        plan = Path(plan) / "plan.yaml"
    from fric.documents.plan import PlanDocument  # it loads what plans and simulates

    document = document_of("experiment", PlanDocument, plan, (axis.name, axis.motion), "machine")
    return [trial for one in document.planned() for trial in one.trials(axis)]
