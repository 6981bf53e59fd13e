"""What every reader gives: tables of columns, read block by block as float64, NaN where a cell is no number."""

import logging
import re
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar
from xml.etree.ElementTree import Element, ParseError, TreeBuilder, XMLParser, fromstring

from fric.errors import FricError, near, printable
from fric.flaws.files import LIBRARY_WARNS
from fric.input import foreign, regular
from fric.notice import Notice
from fric.units import is_unit

if TYPE_CHECKING:
    from fric.arrays import Real

MOST_COLUMNS = 2000  # Columns of a table at most: to find what they are takes a time that grows with their square
MOST_LETTERS = 1000  # Letters of a column's name at most: words are searched for in it
MOST_ROWS = 50_000_000  # Rows of a table at most: a log file is read whole, a gigabyte of three channels
MOST_HEARD = 4  # Largest number of warnings of a library that are reported for a file
BLOCK = 131_072  # Samples a block: a few MiB, for any size of the file
OF_SEVERAL = "axes"  # Key of the names of the axes that the file of a table has tables of
RECORD = "record"  # The same for a table that is one of several records of its file, some of which may not be records


class Format(NamedTuple):
    """A format that a reader reads: its name, endings of files, and the module and extra that it needs, if any."""

    name: str
    endings: tuple[str, ...]
    module: str = ""
    extra: str = ""


class _Heard(logging.Handler):
    """Collects what a library logs about a file, as warnings of the file."""

    def __init__(self, path: Path, notices: list[Notice]) -> None:
        super().__init__(logging.WARNING)
        self._path, self._notices = path, notices

    def emit(self, record: logging.LogRecord) -> None:
        """Keep the first few."""
        if len(self._notices) < MOST_HEARD:
            self._notices.append(LIBRARY_WARNS.found(str(self._path), message=printable(record.getMessage(), 160)))


_LISTENING: dict[str, tuple[list[_Heard], list[tuple[logging.Logger, list[logging.Handler], bool]]]] = {}
"""By module: who listens, and how its loggers were before the first did."""


@contextmanager
def heard(form: Format, path: Path) -> Iterator[list[Notice]]:
    """Collect in a list what the library of a format logs meanwhile, instead of on standard error; give the list.

    Files may be open at once, and be closed in any order: the library logs as before when the last file is closed.
    """
    top = form.module.partition(".")[0]
    logger, notices = logging.getLogger(top), list[Notice]()
    listening, before = _LISTENING.setdefault(top, ([], []))
    if not listening:
        below = [logging.getLogger(name) for name in logging.root.manager.loggerDict if name.startswith(f"{top}.")]
        before[:] = [(logger, logger.handlers, logger.propagate) for logger in (logger, *below)]
        for child in below:
            child.handlers, child.propagate = [], True
        logger.propagate = False
    handler = _Heard(path, notices)
    listening.append(handler)
    logger.handlers = [handler]
    try:
        yield notices
    finally:
        listening.remove(handler)
        logger.handlers = [*listening[-1:]]
        for child, handlers, passed in () if listening else before:
            child.handlers, child.propagate = handlers, passed


@contextmanager
def warned(path: Path, notices: list[Notice]) -> Iterator[None]:
    """Collect the warnings of a library meanwhile in a list, as warnings of the file."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", DeprecationWarning)
        yield
    for warning in caught[: max(MOST_HEARD - len(notices), 0)]:
        notices.append(LIBRARY_WARNS.found(str(path), message=printable(str(warning.message), 160)))


def library(form: Format) -> Any:
    """Return the module that reads a format."""
    try:
        return import_module(form.module)
    except ImportError:
        what = f"{form.name} needs {form.module.partition('.')[0]}, which is not installed"
        raise FricError(what, hint=f"pip install 'fric[{form.extra}]'") from None


Item = TypeVar("Item")


def guarded(path: Path, found: Iterator[Item]) -> Generator[Item, None, None]:
    """Yield what is read of a file; an exception of a library in that becomes an error about damage of the file."""
    try:
        while True:
            with foreign(path, "Export it again.", lacking=True):
                part = next(found, None)
            if part is None:
                return
            yield part
    finally:
        if isinstance(found, Generator):
            found.close()  # an error on the way would else keep the file open as long as the error is kept


class Column(NamedTuple):
    """Name and unit of a column; no unit where the file gives none."""

    name: str
    unit: str | None = None


class RowBlock(NamedTuple):
    """Consecutive rows: the number of the first, the wanted columns, and the bytes of the file they took."""

    row: int
    columns: list["Real"]
    size: int


class ForeignTable(ABC):
    """One table of a foreign file, which becomes one record.

    path: The file.
    columns: Names and units.
    constants: Values that the file holds once: scalars, lines of the preamble. They serve as ``{fields}`` of a mapping.
    said: What the file itself says of the record: ``axis``, ``motion``, ``name``, ``kind``, ``sha256``, ``source``.
    """

    notices: Sequence[Notice] = ()  # Warnings about the table, once it is read
    states: int | None = None  # Column whose words are states: each becomes a number, and is listed in ``labels``
    labels: Sequence[str] = ()  # Words of that column, as far as it is read

    def __init__(
        self, path: Path, columns: Sequence[Column], constants: Mapping[str, str] | None = None,
        said: Mapping[str, str] | None = None,
    ) -> None:  # fmt: skip
        if len(columns) > MOST_COLUMNS:
            raise FricError(f"has {len(columns)} columns", where=str(path), hint="Save those of one axis alone.")
        if (longest := max((len(column.name) for column in columns), default=0)) > MOST_LETTERS:
            raise FricError(f"a column's name has {longest} letters", where=str(path), hint="Give it a shorter name.")
        self.path, self.columns = path, _with_suffixes(columns)
        self.constants, self.said = dict(constants or {}), dict(said or {})

    @abstractmethod
    def blocks(self, wanted: Sequence[int]) -> Iterator[RowBlock]:
        """Read the wanted columns (indices, in this order) from the first row to the last."""

    def read(self, wanted: Sequence[int]) -> Iterator[RowBlock]:
        """Yield `blocks`, one at least, `guarded`."""
        rows = 0
        for block in guarded(self.path, iter(self.blocks(wanted))):
            rows += max(len(block.columns[0]), 1)
            if rows > MOST_ROWS:
                raise FricError(f"has over {MOST_ROWS} rows", where=str(self.path), hint="Export a part of it.")
            yield block
        if not rows:
            raise FricError("holds no samples", where=str(self.path), hint="Export it again, with its samples.")

    def quick(self) -> Sequence[int]:
        """Return the columns that are logged often enough to be of a motion beside the others."""
        return range(len(self.columns))

    def place(self, row: int, column: int | None = None) -> str:
        """Return where a row (counted from 0) and a column are, for messages."""
        return self._described(f"sample {row + 1}", column)

    def text(self, row: int, column: int) -> str | None:
        """Return the text of a cell that is no number, where it is known."""
        return None

    def listed(self, most: int = 24) -> str:
        """Return the names of the columns, for messages."""
        names = ", ".join(f"'{column.name}'" for column in self.columns[:most])
        return f"{names}, …" if len(self.columns) > most else names

    def run(self, row: int, column: int) -> int:
        """Return how many rows in a row, from ``row`` on, have no number in a column (1 where that is not known)."""
        return 1

    def _described(self, place: str, column: int | None) -> str:
        beside = f", column '{self.columns[column].name}'" if column is not None else ""
        return f"{self.path}, {place}{beside}"

    def find(self, wanted: str | int, channel: str) -> int:
        """Return the index of a column given by its name or its index from 0."""
        listed = self.listed()
        if isinstance(wanted, int):
            if 0 <= wanted < len(self.columns):
                return wanted
            raise FricError(
                f"there is no column {wanted} for {channel}: there are {len(self.columns)}, counted from 0",
                where=str(self.path), hint=f"The columns are {listed}.",
            )  # fmt: skip
        for same in (str, plain_name):
            if len(found := [n for n, column in enumerate(self.columns) if same(column.name) == same(wanted)]) > 1:
                raise FricError(
                    f"{len(found)} columns are named '{wanted}'", where=str(self.path),
                    hint=f"Give the index instead: {' or '.join(map(str, found))}, counted from 0.",
                )  # fmt: skip
            if found:
                return found[0]
        beside = near(str(wanted), [column.name for column in self.columns])
        what = f"there is no column '{wanted}' for {channel}"
        raise FricError(what, where=str(self.path), hint=f"{beside}The columns are {listed}.")


class Memory(ForeignTable):
    """A table whose columns are in memory already (or behave as if): ``data``, anything that slices to numbers."""

    def __init__(
        self, path: Path, columns: Sequence[Column], data: Sequence[Any], constants: Mapping[str, str] | None = None,
        said: Mapping[str, str] | None = None,
    ) -> None:  # fmt: skip
        super().__init__(path, columns, constants, said)
        self.data = data

    def blocks(self, wanted: Sequence[int]) -> Iterator[RowBlock]:
        """Slice the columns; raise a `FricError` when they differ in length."""
        samples = len(self.data[wanted[0]])
        if any(len(self.data[n]) != samples for n in wanted):
            text = ", ".join(f"'{self.columns[n].name}' {len(self.data[n])}" for n in dict.fromkeys(wanted))
            raise FricError(f"the columns differ in length: {text}", where=str(self.path), hint="Map others.")
        for start in range(0, samples, BLOCK):
            part = [self.data[n][start : start + BLOCK].astype("f8") for n in wanted]
            yield RowBlock(start, part, sum(values.nbytes for values in part))


_SUFFIX = re.compile(r"(?:.+_(?:ms|us|µs|mm|um|µm|nm|deg|rad|mrad|Nm|mNm|kN|V|mV)|(?:[tT]|[tT]ime|[zZ]eit)_s|\w{2,}_N)")
"""Names that end in their unit; F_N is a normal force, and x_m may be a motor's or a mean."""
_OF_AXIS = re.compile(  # No unit in brackets: a column's axis, or what it is of it, as in ``X[Position Feedback]``
    r"\d+|[xyzXYZ]\d?|(?:[jJ]|(?i:joint|axis|achse) ?)\d+|"
    r"(?i:(position|velocity|current|torque) (feedback|command|error))"
)
_NAMED = re.compile(
    r"(?P<name>.*?)(?:\s*(?:\[(?P<square>[^\[\]]*)\]|[({<](?P<round>[^(){}<>]*)[)}>])|"
    r"(?:\s+(?:/|in)\s+|,\s+|\s(?=\S+/))(?P<behind>[^\s\[\](){}<>]+))"
)
_SLASHED = re.compile(r"([^/\s]+)/([a-zA-Zµ°%]{2,}(?:/[a-zA-Z]+)?)|([^/\s]*\w_\w+)/([NAVms%](?:/s)?)")
"""A name and its unit, as ``X_ist/mm``; a single letter, as of ``arm/A``, is a unit behind ``F_mot/`` alone."""


_PER = re.compile("[munk]?m|m?rad|deg|revs?|N|A|V|Nm|counts?")  # Not the s of velocity_rad_s is its unit


def _with_suffixes(columns: Sequence[Column]) -> tuple[Column, ...]:
    """Return columns whose names end in a unit, as ``x_m``, with that unit, where two others' do unmistakably."""
    sure = sum(column.unit is not None and column.name.endswith(f"_{column.unit}") for column in columns)
    if sure < 2:
        return tuple(columns)
    parts = {n: c.name.rpartition("_") for n, c in enumerate(columns) if c.unit is None}
    ends = {n: end for n, (of, _, end) in parts.items() if not _PER.fullmatch(of.rpartition("_")[2])}
    return tuple(c._replace(unit=ends[n]) if ends.get(n) in {*"mAsNV"} else c for n, c in enumerate(columns))


class PlainXML(TreeBuilder):
    """Builds the elements of XML that declares no document type, and so no entities."""

    def doctype(self, *_: object) -> None:
        """Refuse the declaration."""
        raise FricError("declares a document type, as no export does", hint="Save it again.")


def read_xml(path: Path, most: int) -> Element:
    """Return the root of XML of a bounded size [byte]; of whole elements behind each other, a root that holds them."""
    with foreign(path):
        try:
            data = regular(path, most).read_bytes()
            if first := re.match(rb"(?:\xef\xbb\xbf)?\s*<(\w+)", data):  # the last may be cut off
                data = b"<log>%b</log>" % (re.match(rb"(?s).*</%b\s*>" % first[1], data) or [data])[0]
            return fromstring(data, XMLParser(target=PlainXML()))
        except (ParseError, LookupError, ValueError) as error:  # the others: an encoding that is unknown
            raise FricError(f"is not complete XML ({error})", hint="Save it again.") from None


def named(header: str) -> Column:
    """Split a header, as ``force [N]``, ``force (N)``, ``force / N``, ``force, N``, ``v in mm/s``; not ``force_N``."""
    text = header.strip().strip("\"'").lstrip("#%").strip()
    if (slashed := _SLASHED.fullmatch(text)) and is_unit(unit := slashed[2] or slashed[4]):
        return Column(slashed[1] or slashed[3], unit)
    found = _NAMED.fullmatch(text)
    inside = found and (found["square"] or found["round"] or found["behind"] or "").strip()
    lacks = found is None or not found["name"] or (found["behind"] and not is_unit(inside or ""))
    if found is None or lacks or _OF_AXIS.fullmatch(inside or ""):  # q[0], POSF(X)
        return Column(text, text.rpartition("_")[2] if _SUFFIX.fullmatch(text) else None)
    unit = re.sub(r"^in\s+(?=\S)", "", inside or "")
    return Column(text if found["square"] is None and not is_unit(unit) else found["name"], unit.strip() or None)


def number(value: Any) -> float:
    """Return a number, also one in a text; else NaN."""
    with suppress(ValueError, OverflowError):
        return float(value) if isinstance(value, int | float | str) else nan
    return nan


_REST = re.compile(r"(?i)(?P<of>.*?)(?P<unit>nano|n|micro|u)_?sec(?:ond)?s?")


def whole_stamps(columns: Sequence[Column], values: Callable[[int], Any], wanted: Iterable[int]) -> list[Any]:
    """Return the values of columns; those of whole seconds with the rest in the next one, as ``sec, nanosec``."""
    found = []
    for n in wanted:
        rest, whole = _REST.fullmatch(columns[n + 1].name) if n + 1 < len(columns) else None, values(n)
        if rest and re.fullmatch(f"(?i){re.escape(rest['of'])}sec(ond)?s?", columns[n].name):
            seconds, beside = whole[:], values(n + 1)[:] * (1e-9 if rest["unit"][0] in "nN" else 1e-6)
            two_clocks = (seconds % 1.0 > 0.0) | (beside < 0.0) | (beside >= 1.0)  # the second column is no rest
            whole = whole if two_clocks.any() else seconds + beside
        found.append(whole)
    return found


def begins_again(ends: Sequence[tuple["Real", "Real"]]) -> bool:
    """Return whether a column rises over each of several parts, and falls back from each to the next.

    ends: The first and the last row of each part.
    """
    import numpy as np  # the name of a column needs none

    first, last = (np.array(rows, float) for rows in zip(*ends, strict=True))
    back = last[:-1] - first[1:] > 0.5 * (last - first)[:-1]
    return len(ends) > 1 and bool(np.any(back.all(axis=0) & (last > first).all(axis=0)))


def plain_name(name: str) -> str:
    """Return a name without its unit, in small letters, with single spaces; ``X軸`` is x."""
    return " ".join(re.sub("[軸轴축]", " ", named(name).name.casefold()).split())


def numbers(values: Any) -> "Real":
    """Return an array as floats: stamps in seconds (since the epoch), NaN where there is none or it is no number."""
    import numpy as np

    if (found := np.asarray(values)).dtype.kind in "mM":
        ticks = found.astype("timedelta64[ns]" if found.dtype.kind == "m" else "datetime64[ns]").astype("i8")
        return np.where(np.isnat(found), np.nan, ticks * 1e-9)
    real = found.dtype.kind in "fiub" and found.ndim == 1
    return found.astype("f8", copy=False) if real else np.full(len(found), np.nan)
