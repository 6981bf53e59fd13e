"""One record of a drive's log, in SI units."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, Self

import numpy as np

from fric import columns
from fric.columns import CHANNELS, Kind, channel_dimension
from fric.errors import FricError, near, printable, require_known, require_name
from fric.series import keep, real
from fric.units import Motion, factor, is_effort, si_unit
from fric.verb import refused, typed, verb

if TYPE_CHECKING:
    from pandas import DataFrame

    from fric.arrays import Real


class Columns(Protocol):
    """A data frame, or a mapping: columns by name."""

    def __iter__(self) -> Iterator[Any]:
        """Iterate over the names."""

    def __getitem__(self, name: Any, /) -> Any:
        """Return a column."""


def _require_least(record: Any, bounds: Mapping[str, float]) -> None:
    """Raise a `FricError` where a value of a table is below the least that its column allows."""
    for name, least in bounds.items():
        if (values := getattr(record, name)) is not None and values.min() < least:
            row, bound = int((values < least).argmax()), f"{least:g} at least" if round(least) == least else "above 0"
            raise FricError(f"{name} is {values[row]:g} in row {row + 1}, and is {bound}", where=record.where,
                            hint="Look at the columns: is this the right table? Leave such rows out.")  # fmt: skip


class FromFile:
    """What was read from a file: a record, or what ``called`` says."""

    called: ClassVar[str] = "record"
    name: str
    source: str

    @property
    def where(self) -> str:
        """File and record, for messages."""
        named = f"{self.called} '{self.name}'"
        return f"{self.source}, {named}" if self.source else named


class _Table(FromFile):
    kind: ClassVar[Kind]
    dimensions: ClassVar[Mapping[str, str]]  # Of its columns, the first of which it always has
    motion: Motion

    def __len__(self) -> int:
        return len(next(iter(self.columns().values())))

    def columns(self) -> dict[str, Real]:
        """Return the columns that there are, by name."""
        return {name: values for name in self.dimensions if (values := getattr(self, name)) is not None}

    def unit(self, column: str) -> str:
        """Return the SI unit of a column on this axis."""
        return si_unit(self.dimensions[column], self.motion)


@typed
@dataclass(frozen=True)
class Log(FromFile):
    """One record of one axis: what was logged over time.

    A record holds the position, the velocity, or both; force, input and reference as they were logged.

    time: Sample instants [s], strictly increasing, shape (n,).
    position: Measured position [m or rad], shape (n,).
    velocity: Measured velocity [m/s or rad/s], shape (n,).
    force: Motor force or torque [N or N·m], positive in the direction of positive position, shape (n,).
    input: Control voltage [V], shape (n,).
    reference: Reference position [m or rad], shape (n,).
    added: Voltage that was added to the controller's output, and is in the input [V], shape (n,).
    load_position: Position by a second encoder at the load, where the first is at the motor [m or rad], shape (n,).
    mode: State of the control, as a compensation that is off (0) or on (1), shape (n,).
    name: Name of the record in its file.
    kind: The experiment; None where the log does not state it.
    axis, motion: Name of the axis, and whether it is linear or rotary.
    source, sha256: File the record was read from, and the digest of what was read.
    dropped: Samples left out when the record was ingested, because a cell was no number.
    labels: Names of the modes 0, 1, … where the log gave words.
    Raises FricError: Where `fric.series.keep` raises, or there is neither position nor velocity.
    """

    time: Real
    position: Real | None = None
    velocity: Real | None = None
    force: Real | None = None
    input: Real | None = None
    reference: Real | None = None
    added: Real | None = None
    load_position: Real | None = None
    mode: Real | None = None
    name: str = "record"
    kind: Kind | None = None
    axis: str = "x"
    motion: Motion = "linear"
    source: str = ""
    sha256: str = ""
    dropped: int = 0
    labels: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        require_name(self.axis, self.where)
        if is_effort(self.motion):  # both are one signal
            vars(self)["force"] = vars(self)["input"] = self.input if self.force is None else self.force
        keep(self, {name: channel_dimension(name) for name in CHANNELS}, self.where, motion=self.motion)
        if self.position is None and self.velocity is None:
            hint = "Map one of them to a column."
            raise FricError("there is neither position nor velocity", where=self.where, hint=hint)

    @classmethod
    @verb
    def from_frame(
        cls, frame: Columns, units: Mapping[str, str] | None = None, *, name: str = "record", kind: Kind | None = None,
        axis: str = "x", motion: Motion = "linear",
    ) -> Self:  # fmt: skip
        """Return a record of the columns of a data frame that are channels: ``position [um]``, or ``position``.

        frame: A `pandas.DataFrame`, or a mapping of columns.
        units: Unit by channel, where a column's name does not include it; SI else.
        name, kind, axis, motion: As of the record.
        Raises FricError: When there is no time, a unit does not fit, or a column holds no numbers.
        """
        if not hasattr(frame, "keys"):
            raise refused("Log.from_frame", "a data frame, or columns by name", frame)
        index = getattr(getattr(frame, "index", None), "name", None)
        if str(index).partition("[")[0].strip() == "time":
            frame = frame.reset_index()  # type: ignore[attr-defined]
        found, read = dict[str, Any](), list[Any]()
        for column in frame:
            channel, _, unit = str(column).partition("[")
            channel, unit = channel.strip(), unit.rstrip("] ")
            channel = "input" if channel == "voltage" else channel
            if channel in CHANNELS:
                read.append(column)
                unit = str((units or {}).get(channel, unit))
                scale = factor(unit, channel_dimension(channel), motion) if unit else 1.0
                found[channel] = scale * real(frame[column], "Log.from_frame", f"the column '{column}'")
        for lacking in ("time", "position or velocity"):
            if found.keys().isdisjoint(lacking.split(" or ")):
                named = f"Its columns are {', '.join(map(str, frame))}."
                hint = f"{named} Rename them to {', '.join(CHANNELS)}, as in 'time [ms]'."
                hint += " Of a value a row, take frame.pivot(index=…, columns=…, values='value')." * ("value" in frame)
                raise FricError(f"no column is named {lacking}", hint=hint)
        left = [str(column) for column in frame if column not in read]
        if left and found.keys() <= {"time", "position", "velocity", "mode"}:
            hint = f"Rename the one that is the force or the input, as in 'force [N]', or leave out {', '.join(left)}."
            raise FricError("no column is named force or input", hint=hint)
        for channel in (units or {}).keys() - found.keys():
            hint = f"{near(channel, found)}Its channels are {', '.join(found)}."
            raise FricError(f"`units=` names '{channel}', and no column is of this channel", hint=hint)
        return cls(**found, name=name, kind=kind, axis=axis, motion=motion)

    def __repr__(self) -> str:
        text = ", ".join(name for name in self.channels() if name != "time")
        span = f"{len(self)} samples in {self.time[-1] - self.time[0]:.4g} s"
        return f"<Log '{printable(self.name)}' of the {self.motion} axis {self.axis}: {span}: {text}>"

    def __len__(self) -> int:
        return len(self.time)

    def channels(self) -> dict[str, Real]:
        """Return the channels that were logged, by name, time first, in SI units: ``DataFrame(log.channels())``."""
        return {channel: values for channel in CHANNELS if (values := getattr(self, channel)) is not None}

    def to_frame(self) -> DataFrame:
        """Return the channels as a data frame, each with its unit in its name, as `from_frame` reads it."""
        from pandas import DataFrame

        return DataFrame({f"{name} [{self.unit(name)}]": values for name, values in self.channels().items()})

    def unit(self, channel: str) -> str:
        """Return the SI unit of a channel on this axis."""
        require_known(channel, CHANNELS, "a record has no channel", "Its channels are")
        return si_unit(channel_dimension(channel), self.motion)

    def require(self, channel: str, purpose: str) -> Real:
        """Return a channel, or raise a `FricError` that names its use."""
        if (values := self.channels().get(channel)) is None:
            raise FricError(f"no {channel} was logged, and {purpose} needs it", where=self.where,
                            hint=f"Log the {channel}, or map its column when ingesting.")  # fmt: skip
        return values

    def slice(self, start: int, stop: int) -> Log:
        """Return the samples from ``start`` up to ``stop`` as a separate record."""
        cut: dict[str, Any] = {channel: values[start:stop] for channel, values in self.channels().items()}
        return replace(self, **cut)


@typed
@dataclass(frozen=True)
class FrequencyResponse(_Table):
    """A measured frequency response from control voltage to position, as a table.

    frequency: Frequencies [Hz], increasing, shape (n,).
    magnitude: |Z/U| [m/V or rad/V], shape (n,).
    phase: Phase [rad], unwrapped, shape (n,).
    coherence: Coherence at each frequency (0 to 1), shape (n,), where it was measured.
    deviation: Standard deviation of the magnitude over the magnitude, and of the phase [rad], shape (n,), where it is
        known.
    name, axis, motion, source, sha256: As in `Log`.
    Raises FricError: Where `fric.series.keep` raises, a frequency does not increase from above 0 Hz, a magnitude is not
        positive, or a coherence is not above 0 and at most 1.
    """

    kind = "frequency-response"
    dimensions = columns.RESPONSE_DIMENSIONS

    frequency: Real
    magnitude: Real
    phase: Real
    coherence: Real | None = None
    deviation: Real | None = None
    name: str = "response"
    axis: str = "x"
    motion: Motion = "linear"
    source: str = ""
    sha256: str = ""

    def __post_init__(self) -> None:
        require_name(self.axis, self.where)
        keep(self, self.dimensions, self.where, motion=self.motion, least=3)
        above = float(np.finfo(float).tiny)
        _require_least(self, {"frequency": above, "magnitude": above, "coherence": above, "deviation": 0.0})
        if not (np.diff(self.frequency) > 0).all() or (self.coherence is not None and self.coherence.max() > 1 + 1e-9):
            raise FricError("the frequencies do not increase, or a coherence is above 1", where=self.where,
                            hint="Sort the table by frequency, and look at the unit of the coherence.")  # fmt: skip

    def relative_deviation(self, averages: int = 1) -> Real | None:
        """Return the deviation; where there is none that by the coherence γ², √((1 − γ²)/(2 n γ²)); None without both.

        It is that of the real and of the imaginary part of a response averaged over n records (Bendat and Piersol,
        Random Data).
        """
        if self.deviation is not None or self.coherence is None:
            return self.deviation
        coherence = np.clip(self.coherence, 1e-6, 1 - 1e-9)
        return np.sqrt((1 - coherence) / (2 * averages * coherence))

    def __repr__(self) -> str:
        f = self.frequency
        span = f"{len(f)} frequencies from {f[0]:.4g} to {f[-1]:.4g} Hz"
        return f"<FrequencyResponse '{printable(self.name)}' of the {self.motion} axis {self.axis}: {span}>"


@typed
@dataclass(frozen=True)
class ForceVelocity(_Table):
    """Mean forces at constant velocities, as a table: strokes that were averaged before.

    velocity: Mean velocities [m/s or rad/s], signed, shape (n,).
    force: Mean force or torque at each [N or N·m], signed as the velocity, shape (n,).
    deviation: Standard deviation of the samples about each mean [N], shape (n,), where it is known.
    error: Standard error of each mean [N], shape (n,), where it is known.
    n: Samples of each mean, shape (n,), where they are known.
    name, axis, motion, source, sha256: As in `Log`.
    Raises FricError: Where `fric.series.keep` raises, or an error, a deviation or a number of samples is negative.
    """

    kind = columns.FORCE_VELOCITY
    dimensions = columns.FORCE_VELOCITY_DIMENSIONS

    velocity: Real
    force: Real
    deviation: Real | None = None
    error: Real | None = None
    n: Real | None = None
    name: str = "table"
    axis: str = "x"
    motion: Motion = "linear"
    source: str = ""
    sha256: str = ""

    def __post_init__(self) -> None:
        require_name(self.axis, self.where)
        keep(self, self.dimensions, self.where, motion=self.motion)
        _require_least(self, {"deviation": 0.0, "error": 0.0, "n": 1.0})

    def __repr__(self) -> str:
        return f"<ForceVelocity '{printable(self.name)}' of the {self.motion} axis {self.axis}: {len(self)} velocities>"


Record = Log | FrequencyResponse | ForceVelocity


def refuse_several_axes(records: Iterable[Record]) -> None:
    """Raise a `FricError` where records are of different axes."""
    if len(axes := {(record.axis, record.motion) for record in records}) > 1:
        text = ", ".join(f"{axis} ({motion})" for axis, motion in sorted(axes))
        raise FricError(f"the logs are of different axes: {text}", hint="Identify one axis at a time.")
