"""The mapping file, ``fric: mapping/1``: the meaning of the columns of a foreign log."""

import re
from collections.abc import Collection, Mapping
from fnmatch import fnmatch
from functools import cache
from pathlib import Path
from typing import Literal, Self

from pydantic import Field, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from fric.columns import CHANNELS, CIRCLE, FORCE_VELOCITY, LARGEST_TURN, Kind, channel_dimension, is_circle_channel
from fric.documents.base import Document, Part
from fric.documents.fields import said
from fric.errors import FricError
from fric.log import ForceVelocity, FrequencyResponse
from fric.units import Motion, factor, kinds_of, parse

FIELD = re.compile(r"\{([^{}]+)\}")


def filled(template: str, fields: Mapping[str, str], where: str) -> str:
    """Put the fields of one file into a template such as ``"{stem}"`` or ``"{speed} mm/s"``."""

    def value(match: re.Match[str]) -> str:
        if match[1] not in fields:
            raise FricError(f"there is no field '{{{match[1]}}}'", where=where, hint=f"Fields are {', '.join(fields)}.")
        return fields[match[1]]

    return FIELD.sub(value, template)


class Layout(Part):
    """Layout of a text log; by default it is found from the file."""

    delimiter: str | None = said('between cells: ",", ";", "\\t", "|" or "whitespace"')
    decimal: Literal[".", ","] | None = None
    encoding: str | None = said("such as utf-8, latin-1, utf-16")
    skip: int = Field(default=0, ge=0, description="lines at the top to skip")
    header: int | Literal[False] | None = said("line of the names, counted from 1; false: none")
    units: int | Literal[False] | None = said("line of the units, counted from 1; false: none")
    data_after: str | None = said("the data follow the line that starts with this text")
    comment: str | None = Field(default=None, min_length=1, max_length=1, description="begin of comments")


class ColumnMapping(Part):
    """Source of a channel: a column, or a value for the whole record."""

    column: str | int | None = said("name, or index counted from 0")
    value: str | None = said('a value for the whole record, such as "{speed} mm/s"')
    rate: str | None = said('a time that was not logged, such as "4 kHz"')
    period: str | None = said('a time that was not logged, such as "0.25 ms"')
    unit: str | None = said("unit of the column; left out, that of the header")
    scale: str | None = said('size of a logged unit, such as "0.0984 mN*m"')
    file: str | None = said('of --join: files that hold it, as "*force*.csv"')
    wraps: float | None = Field(default=None, gt=0, le=LARGEST_TURN, description="period of an angle, as logged: 360")
    sign: Literal[1, -1] | None = said("-1 where the log counts the other way")

    @model_validator(mode="after")
    def _one_origin(self) -> Self:
        origins = [key for key in ("column", "value", "rate", "period") if getattr(self, key) is not None]
        if len(origins) != 1:
            said = " and ".join(origins) or "neither column nor value"
            raise ValueError(f"is given by {said}\nName its column, or give one value for the whole record.")
        if self.unit is not None and self.scale is not None:
            raise ValueError("has both unit and scale\nKeep one: scale is the unit with a factor before it.")
        if origins != ["column"] and (self.unit or self.scale):
            raise ValueError(f"unit and scale are of a column\nWrite the unit behind the number of '{origins[0]}'.")
        return self


class FileMapping(Part):
    """Files of a kind: format of a foreign log, and the source of each channel."""

    axis: str | None = None
    motion: Motion | None = None
    kind: Kind | Literal["circle"] | None = None
    record: str = said("name of the record", "{stem}")
    file: str | None = said('pattern of the file name, as "{axis}_{speed}mmps"')
    format: Layout = Layout()
    columns: dict[str, ColumnMapping] = Field(default_factory=dict)
    files: str | list[str] | None = said('of a part: names of its files, as "*.csv"')

    def fits(self, path: Path, names: Collection[str]) -> bool:
        """Return whether the mapping fits a file: by the patterns of names, and by its columns, if any."""
        wanted = {column.column for column in self.columns.values() if isinstance(column.column, str)}
        patterns = ["*"] if self.files is None else [self.files] if isinstance(self.files, str) else self.files
        return any(fnmatch(path.name, pattern) for pattern in patterns) and wanted <= set(names)

    @model_validator(mode="after")
    def _columns_fit(self) -> Self:
        in_time = self.kind != "frequency-response" or "time" in self.columns
        known = CHANNELS if in_time else tuple(FrequencyResponse.dimensions)
        known = tuple(ForceVelocity.dimensions) if self.kind == FORCE_VELOCITY else known
        errors: list[InitErrorDetails] = []
        for name, channel in self.columns.items():
            try:
                self._check(name, channel, known)
            except FricError as error:
                text = PydanticCustomError("mapping", "{told}", {"told": f"{error.what}\n{error.hint}"})
                errors.append({"type": text, "loc": ("columns", name), "input": None})
        if errors:
            raise ValidationError.from_exception_data("mapping", errors)
        return self

    def _check(self, name: str, channel: ColumnMapping, known: tuple[str, ...]) -> None:
        if self.kind == CIRCLE:
            if not is_circle_channel(name):
                hint = "Channels are time, x.reference, x.position, x.input, x.force, for y too; angle, deviation."
                raise FricError(f"'{name}' is not a channel of a circle test", hint=hint)
        elif name not in known:
            raise FricError(f"'{name}' is not a channel", hint=f"Channels are {', '.join(known)}.")
        if name != "time" and (channel.rate or channel.period):
            raise FricError("rate and period are of the time", hint="Name a column, or give a value.")
        if name == "time" and (channel.value or channel.sign):
            raise FricError("has no sign and no single value", hint="Name its column, or give rate or period.")
        motions = kinds_of(self.motion)
        full = "ball-bar.deviation" if (self.kind, name) == (CIRCLE, "deviation") else name
        dimension = channel_dimension(f"{FORCE_VELOCITY}.{name}" if self.kind == FORCE_VELOCITY else full)
        checks = (
            (channel.unit, factor, dimension), (channel.scale, parse, dimension), (channel.value, parse, dimension),
            (channel.rate, parse, "frequency"), (channel.period, parse, "time"),
        )  # fmt: skip
        for text, understand, measured in checks:
            if text is None or FIELD.search(text) or text.startswith("dB(") or (name, text) == ("magnitude", "dB"):
                continue
            refusals = []
            for motion in motions:
                try:
                    understand(text, measured, motion)
                except FricError as error:
                    refusals.append(error)
            if len(refusals) == len(motions):
                raise refusals[0]

    def fields(self, constants: Mapping[str, str], where: str) -> dict[str, str]:
        """Return the fields of one file: those stated, and those that ``file`` reads from its stem."""
        if self.file is None:
            return dict(constants)
        if (found := _taken_apart(constants["stem"], FIELD.split(self.file)[::2])) is None:
            raise FricError(f"the name '{constants['stem']}' is not made like '{self.file}'", where=where,
                            hint="Mend `file:` in the mapping, or ingest such files on their own.")  # fmt: skip
        return {**constants, **dict(zip(FIELD.findall(self.file), found, strict=True))}


class MappingDocument(Document, FileMapping, type="mapping"):
    """A mapping of foreign logs: of an axis; or in parts, for each axis or each kind of files."""

    parts: list[FileMapping] = said("mappings, in place of columns", list)

    @model_validator(mode="after")
    def _columns_or_parts(self) -> Self:
        if bool(self.columns) == bool(self.parts):
            raise ValueError("has neither columns nor parts, or both\nGive columns; or parts with columns each.")
        return self

    def of(self, path: Path, names: Collection[str], axis: str | None = None) -> FileMapping | None:
        """Return the mapping of a file with columns of these names; of several that of the axis, or the first."""
        return next(iter(self.all_of(path, names, axis)), None)

    def all_of(self, path: Path, names: Collection[str], axis: str | None = None) -> list[FileMapping]:
        """Return the mappings of a log, one for each of its axes."""
        if not self.parts:
            return [self]
        fitting = [part for part in self.parts if part.kind != CIRCLE and part.fits(path, names)]
        return [mapping for mapping in fitting if axis == mapping.axis] or fitting

    def of_circle(self, path: Path, names: Collection[str]) -> FileMapping | None:
        """Return the mapping of a circle test with columns of these names; None where it is none."""
        return next((part for part in self.parts or [self] if part.kind == CIRCLE and part.fits(path, names)), None)


def _taken_apart(stem: str, literals: list[str]) -> tuple[str, ...] | None:
    """Return the parts between texts in a name, each as short as possible; None where the name differs."""

    @cache
    def behind(n: int, start: int) -> tuple[str, ...] | None:
        text = literals[n]
        if n == len(literals) - 1:
            end = len(stem) - len(text)
            return (stem[start:end],) if stem.endswith(text) and end > start else None
        at = stem.find(text, start + 1)
        while at >= 0:
            if (rest := behind(n + 1, at + len(text))) is not None:
                return stem[start:at], *rest
            at = stem.find(text, at + 1)
        return None

    if not stem.startswith(literals[0]):
        return None
    return behind(1, len(literals[0])) if len(literals) > 1 else () if stem == literals[0] else None
