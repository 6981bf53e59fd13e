"""Arguments of verbs: records or their files, paths, quantities with units, and listeners to progress."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from fric.errors import FricError
from fric.flaws.unit import BOUNDS
from fric.log import ForceVelocity, FrequencyResponse, Log, Record, refuse_several_axes
from fric.plausibility import Finding, settled
from fric.series import GAIN, largest
from fric.units import Motion, likely, parse
from fric.verb import UnfitError, refused

if TYPE_CHECKING:
    from fric.records.flaws import Encoder


class Advance(Protocol):
    """Listener to the progress of a verb."""

    def __call__(self, steps: int = 1, *, total: int | None = None) -> None:
        """Receive the number of further steps done, and the total once it is known."""


OF_CHANNELS = ("time", "position", "velocity", "force", "input", "frequency")
"""Dimensions that have a largest value on a machine."""


def silent(steps: int = 1, *, total: int | None = None) -> None:
    """Ignore the progress."""


def records_of(
    given: Iterable[Any], *, one_axis: bool = True, whole: bool = False, encoder: Encoder = "motor"
) -> list[Record]:
    """Return the given records of one axis: records, log files, or lists of them.

    A record in which the control switches its mode is split by modes unless ``whole``. Of two encoders, ``encoder``
    names the one for the position.

    Raises FricError: When something else is given, a file is no log file, or the records are of different axes.
    """
    found = list(_flat(given))
    if not found:
        raise FricError("no record was given", hint="Give log files, or what fric.read returns.")
    if one_axis:
        refuse_several_axes(found)
    if encoder != "motor":
        from fric.records.flaws import by_encoder

        found = [by_encoder(record, encoder) if isinstance(record, Log) else record for record in found]
    return found if whole else [part for record in found for part in in_one_mode(record)]


def in_one_mode(record: Record) -> Sequence[Record]:
    """Return the parts of a record, each in one mode of the control."""
    if not isinstance(record, Log):
        return [record]
    from fric.records.modes import parts_of  # with the motion, which tables need not

    return parts_of(record)


def logs_of(given: Iterable[Any], encoder: Encoder = "motor") -> list[Log]:
    """Return the given records in time of one axis, as `records_of` does."""
    records = records_of(given, encoder=encoder)
    logs = [record for record in records if isinstance(record, Log)]
    if not logs:
        raise FricError("there is no record in time", where=records[0].where)
    return logs


def _flat(given: Iterable[Any]) -> Iterable[Record]:
    for record in given:
        if isinstance(record, Log | FrequencyResponse | ForceVelocity):
            yield record
        elif isinstance(record, str | Path):
            from fric.io.hdf5 import read_records  # with HDF5, which simulations need not

            yield from read_records(Path(record))
        elif isinstance(record, Iterable) and not isinstance(record, bytes | dict):
            yield from _flat(record)
        else:
            raise UnfitError("log files, or records that fric.read returns", record)


def path_of(wanted: str, given: Any) -> Path:
    """Return a path, or raise the error of a wrong type."""
    if not isinstance(given, str | Path):
        raise UnfitError(wanted, given)
    return Path(given)


def where_of(given: Any) -> str:
    """Return the given file for an error message; empty if it is no file."""
    return str(given) if isinstance(given, str | Path) else ""


def quantity(given: str | float | None, dimension: str, motion: Motion = "linear") -> float | None:
    """Return a positive quantity given in SI, or as a text with its unit; None if not given.

    Raises FricError: When the text is no quantity of this dimension, or the value is not positive.
    """
    return None if given is None else positive(given, dimension, motion)


def positive(given: str | float, dimension: str, motion: Motion = "linear") -> float:
    """Return a positive quantity given in SI, or as a text with its unit."""
    value = in_si(given, dimension, motion)
    if not value > 0:
        raise FricError(f"'{given}' is not positive", hint="Give a positive value.")
    return value


def in_si(given: str | float, dimension: str, motion: Motion = "linear") -> float:
    """Return a quantity given in SI, or as a text with its unit."""
    if isinstance(given, bool) or not isinstance(given, int | float | str):
        raise refused(dimension, 'a number in SI, or a text such as "1 mm"', given)
    value = parse(given, dimension, motion) if isinstance(given, str) else float(given)
    if not abs(value) <= (largest(dimension, motion) if dimension in OF_CHANNELS else GAIN):
        raise FricError(f"'{given}' is no {dimension} that a machine has", hint="Look at the number and its unit.")
    return value


def bounded(name: str, given: str | float, motion: Motion = "linear") -> float:
    """Return a given quantity in SI, checked against its bound in `fric.plausibility` as those of files are.

    Raises FricError: When it is no quantity of its dimension, not positive, or beyond that of any machine.
    """
    dimension = BOUNDS[name].dimension
    try:
        value = positive(given, dimension, motion)
    except FricError as error:
        raise error.at(BOUNDS[name].what) from None
    settled([Finding(name, value, motion)], f"Is '{likely(f'{value:g}', dimension, motion)}' meant? Write the unit")
    return value


def several(given: float | str | Sequence[str | float] | None, dimension: str, motion: Motion) -> list[float] | None:
    """Return quantities given as a list, or as a text with commas; None if not given."""
    if given is None:
        return None
    ones = given.split(",") if isinstance(given, str) else [given] if isinstance(given, float | int) else given
    return [in_si(one, dimension, motion) for one in ones]
