"""From the columns of a foreign table to channels in SI: which column, which factor, which sign."""

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fric.arrays import Real
from fric.columns import CHANNELS, FORCE_VELOCITY, Kind, channel_dimension
from fric.documents.mapping import ColumnMapping, FileMapping, filled
from fric.errors import FricError
from fric.input import foreign
from fric.io.readers.base import ForeignTable, plain_name
from fric.io.words import DRIVE_UNITS, EXACT, OF_MEANS, looking_like, measures, refuse_left_out, spoken
from fric.log import ForceVelocity, FrequencyResponse
from fric.series import CLOSEST, largest, require_plausible
from fric.units import Motion, factor, kinds_of, parse, si_unit

Form = Literal["time", "response", "means"]  # What a table holds: samples, a response, or mean forces at velocities
NEEDED: dict[Form, tuple[str, ...]] = {  # Channels that each form has at least
    "time": ("time",),
    "response": ("frequency", "magnitude", "phase"),
    "means": ("velocity", "force"),
}
ORDER: dict[Form, tuple[str, ...]] = {  # Channels that each form can have
    "time": CHANNELS,
    "response": tuple(FrequencyResponse.dimensions),
    "means": tuple(ForceVelocity.dimensions),
}
MOST_DECIBEL = 400.0  # Magnitude of a cell in decibels at most
SLOWEST = 1e-6  # Samples a second that a mapping may state, at least [Hz]
TINY = 1e-300
_NEPER_A_DECIBEL = math.log(10.0) / 20.0
_DECIBEL = re.compile(r"dB\s*(?:\((.*)\))?")  # Decibels of a unit in brackets; of a magnitude, those of its SI unit


@dataclass(frozen=True)
class Origin:
    """Where a channel comes from: a column with its factor to SI, or one value.

    ``decibel`` undoes a logarithm; an angle that ``wraps`` begins again after so much, in SI.
    """

    column: int | None
    factor: float
    decibel: bool = False
    wraps: float = 0.0


@dataclass(frozen=True)
class ColumnPlan:
    """How a table becomes a record."""

    motion: Motion
    origins: dict[str, Origin]
    names: tuple[str, ...] = ()  # Names of all the columns of the table
    form: Form = "time"  # What the table holds
    stated: frozenset[str] = frozenset()  # Channels whose sign the mapping states

    @cached_property
    def wanted(self) -> tuple[int, ...]:
        """Columns that are read; the position precedes what is resampled to its clock."""
        known = {name: n for n, name in enumerate(ORDER[self.form])}
        ranked = (self.origins[name].column for name in sorted(self.origins, key=lambda name: known.get(name, 0)))
        return tuple(dict.fromkeys(column for column in ranked if column is not None))

    def convert(self, columns: list[Real], rows: NDArray[np.int64]) -> dict[str, Real]:
        """Return the channels in SI from the wanted columns; a time that was not logged counts the rows."""
        by_index = dict(zip(self.wanted, columns, strict=True))
        found: dict[str, Real] = {}
        for channel, origin in self.origins.items():
            if origin.column is None and channel == "time":
                found[channel] = rows.astype(np.float64) * origin.factor
            elif origin.column is None:
                found[channel] = np.full(len(rows), origin.factor)
            elif origin.decibel:
                found[channel] = np.exp(by_index[origin.column] * _NEPER_A_DECIBEL) * origin.factor
            else:
                values = by_index[origin.column]
                found[channel] = values if origin.factor == 1.0 else values * origin.factor
        if "phase" in found:
            found["phase"] = np.unwrap(found["phase"])
        return found

    def limits(self) -> list[float]:
        """Return, for each wanted column, the magnitude that no cell of it has on a machine."""
        found = dict.fromkeys(self.wanted, math.inf)
        for channel, origin in self.origins.items():
            if origin.column is not None:
                most = largest(_dimension(channel, self.form), self.motion)
                most = MOST_DECIBEL if origin.decibel else most / max(abs(origin.factor), TINY)
                found[origin.column] = min(found[origin.column], most)
        return list(found.values())

    def unwrapped(self, channels: dict[str, Real], last: dict[str, float]) -> dict[str, Real]:
        """Return the channels with angles that begin again going on from where they were ``last``, which is moved."""
        for name, origin in self.origins.items():
            if origin.wraps and len(channels[name]):
                values = np.concatenate([[last.get(name, channels[name][0])], channels[name]])
                channels[name] = np.unwrap(values, period=origin.wraps)[1:]
                last[name] = float(channels[name][-1])
        return channels

    def description(self) -> dict[str, str]:
        """Return each channel with the column that it is read from."""
        return {name: "" if o.column is None else self.names[o.column] for name, o in self.origins.items()}


def plan(
    table: ForeignTable, mapping: FileMapping | None, kind: Kind | None, motion: Motion | None,
    fields: Mapping[str, str], *, part: bool = False,
) -> ColumnPlan:  # fmt: skip
    """Find every channel of a table.

    mapping: What its columns mean; None where the header says so itself.
    kind: Kind of the record, as said by the caller.
    motion: Motion of the axis; None to take it from the units.
    fields: The ``{fields}`` of the file.
    part: Whether the table holds a part of the channels of its record: time, and at least another channel.
    Raises FricError: When a column is missing, has no unit or a unit of the wrong kind, or there is no time, or no
        position or velocity.
    """
    where = str(table.path)
    if kind is None and mapping is not None and mapping.kind != "circle":
        kind = mapping.kind
    channels = _of_file(table, mapping.columns, part) if mapping else _by_header(table, kind)
    form = _form(channels, kind)
    if strange := channels.keys() - set(ORDER[form]):
        raise FricError(f"such a record has no {min(strange)}", where=where,
                        hint="Leave it out of the mapping, or say another kind.")  # fmt: skip
    refusals: list[tuple[int, FricError]] = []
    for chosen in kinds_of(motion):
        origins: dict[str, Origin] = {}
        try:
            for name, channel in channels.items():
                origins[name] = origin_of(table, name, channel, chosen, fields, form)
        except FricError as error:
            refusals.append((len(origins), error))
            continue
        break
    else:
        raise max(refusals, key=lambda refusal: refusal[0])[1]  # of the motion that more of the columns fit
    if kind == "holding-map":  # whose rows are counted, for want of a time
        origins.setdefault("time", Origin(None, 1.0))
    if mapping is None and form == "time" and "time" in origins and not (part and len(origins) > 1):
        refuse_left_out(table, origins, tuple(o.column for o in origins.values() if o.column is not None))
    for name in NEEDED[form]:
        if name not in origins:
            raise FricError(f"no column is {name}", where=where, hint=_hint(table, name, origins))
    if form == "time" and not ({"position", "velocity"} & origins.keys() or (part and len(origins) > 1)):
        raise FricError("no column is position or velocity", where=where, hint=_hint(table, "position"))
    stated = frozenset(name for name, channel in channels.items() if channel.sign is not None)
    found = ColumnPlan(chosen, origins, tuple(column.name for column in table.columns), form, stated)
    if not found.wanted:
        raise FricError("no channel is read from a column", where=where, hint="Name the column of one at least.")
    return found


def _form(channels: Mapping[str, ColumnMapping], kind: Kind | None) -> Form:
    if "magnitude" in channels and kind not in {FORCE_VELOCITY, "holding-map"}:
        return "response"
    counted = "time" not in channels and {"n", "deviation", "error"} & channels.keys() and kind != "holding-map"
    return "means" if kind == FORCE_VELOCITY or counted else "time"


def _of_file(table: ForeignTable, channels: Mapping[str, ColumnMapping], part: bool) -> dict[str, ColumnMapping]:
    """Return the channels of a mapping that are read from a file: all, or of a part those that it can hold."""
    if not part:
        return dict(channels)
    found = {}
    for name, channel in channels.items():
        if channel.file is not None and not fnmatch(table.path.name, channel.file):
            continue
        try:
            if channel.file is None and channel.column is not None:
                table.find(channel.column, name)
        except FricError:
            continue
        found[name] = channel
    return found


def _by_header(table: ForeignTable, kind: Kind | None) -> dict[str, ColumnMapping]:
    """Return the channels that the header names itself."""
    names = [plain_name(column.name) for column in table.columns]
    said = [EXACT.get(name, name) for name in names]
    table_of_response = "magnitude" in said or (kind == "frequency-response" and "time" not in said)
    known = ORDER["response" if table_of_response else "time"]
    means = [OF_MEANS.get(name, name) for name in said]
    has = {"velocity", "force"} <= set(means) and {"n", "deviation", "error"} & set(means)
    if kind == FORCE_VELOCITY or (kind is None and has and "time" not in said):
        said, known = means, ORDER["means"]
    found: dict[str, ColumnMapping] = {}
    for channel in known:
        columns = [n for n, name in enumerate(names) if name == channel]
        columns = columns or [n for n, name in enumerate(said) if name == channel]
        if columns:
            found[channel] = ColumnMapping(column=table.find(table.columns[columns[0]].name, channel))
    taken = [n for channel in found.values() if isinstance(n := channel.column, int)]
    driven = {"time", "position"} <= found.keys() and {"force", "input"} & found.keys()
    lacking = [channel for channel in ("force", "input", "reference") if channel not in found]
    for channel in lacking if driven and len(found) < len(table.columns) else ():
        alike = [n for n in looking_like(table, channel, taken) if measures(table.columns[n], channel)]
        if channel == "force":
            pushes = [n for n, column in enumerate(table.columns) if spoken(column).quantity == "force"]
            alike = [n for n in pushes if (of := table.columns[n]).unit in DRIVE_UNITS or measures(of, "force")]
        if len(alike) == 1 and alike[0] not in taken:  # 'Motor voltage [V]'
            found[channel] = ColumnMapping(column=alike[0])
    return found


def _hint(table: ForeignTable, channel: str, found: Collection[str] = ()) -> str:
    for main, means, kind in (("velocity", "a mean force at one velocity", FORCE_VELOCITY),
                              ("position", "the force that holds the axis at a place", "holding-map")):  # fmt: skip
        if channel == "time" and {main, "force"} <= set(found):
            return (
                f"If each row is {means}, say `kind='{kind}'`; else say the sampling in a mapping (`mapping=`), as in "
                "`time: {rate: 1 kHz}`."
            )
    return f"The columns are {table.listed(12)}. Say in a mapping (`mapping=`) which is {channel}, or name it so."


def origin_of(
    table: ForeignTable, name: str, given: ColumnMapping, motion: Motion, fields: Mapping[str, str], form: Form = "time"
) -> Origin:
    """Return where one channel comes from: its column, with the factor to SI."""
    where, dimension = str(table.path), _dimension(name, form)
    sign = given.sign or 1

    def parsed(template: str, measured: str) -> float:
        with foreign(where):
            return parse(filled(template, fields, where), measured, motion)

    if given.value is not None:
        value = np.array([sign * parsed(given.value, dimension)])
        require_plausible(name, value, dimension, where, motion=motion)
        return Origin(None, float(value[0]))
    if given.rate is not None or given.period is not None:
        said = parsed(given.period, "time") if given.period else parsed(given.rate or "", "frequency")
        period = said if given.period or not said else 1 / said
        if not 1 / SLOWEST >= period >= CLOSEST:
            what = f"a sampling period of {period:.3g} s is none"
            raise FricError(what, where=where, hint="Mend `rate` or `period`.")
        return Origin(None, period)
    wanted = filled(given.column, fields, where) if isinstance(given.column, str) else given.column or 0
    column = table.find(wanted, name)
    if given.scale is not None:
        scale = parsed(given.scale, dimension)
        return Origin(column, sign * scale, wraps=abs(scale) * (given.wraps or 0.0))
    unit = filled(given.unit, fields, where) if given.unit is not None else table.columns[column].unit
    if unit is None and dimension == "ratio":
        return Origin(column, 1.0)
    if unit is None:
        raise FricError(
            f"column '{table.columns[column].name}' ({name}) has no unit", where=where,
            hint=f"Write it into the header, as '{name} [{si_unit(dimension, motion)}]', or say `unit:` in a mapping.",
        )  # fmt: skip
    if decibel := _DECIBEL.fullmatch(unit.strip()):
        unit = decibel[1] or (si_unit(dimension, motion) if name == "magnitude" else unit)
    try:
        size = factor(unit, dimension, motion)
    except FricError as error:
        beside = f' Or say what one logged unit is, as in scale: "12.5 {si_unit(dimension, motion)}".'
        hint = error.hint + ("" if "scale" in error.hint else beside)
        raise FricError(error.what, where=f"{where}, column '{table.columns[column].name}'", hint=hint) from None
    return Origin(column, sign * size, decibel is not None, size * (given.wraps or 0.0))


def _dimension(channel: str, form: Form) -> str:
    return channel_dimension(f"{FORCE_VELOCITY}.{channel}" if form == "means" else channel)
