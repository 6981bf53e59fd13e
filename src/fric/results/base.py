"""What verbs take and return: records, paths and quantities; results with document, figure and report of lines."""

from __future__ import annotations

import tomllib
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import copy, deepcopy
from dataclasses import dataclass, field, fields
from functools import cache, cached_property
from html import escape
from io import StringIO
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Protocol, dataclass_transform

from fric.errors import FricError, clean, names, printable, require_known
from fric.estimate import GAIN, LEAST, Estimate, elements, estimate_rows
from fric.flaws import flaw_of
from fric.flaws.unit import BOUNDS
from fric.log import ForceVelocity, FrequencyResponse, Log, Record, refuse_several_axes
from fric.notice import Notice
from fric.plausibility import Finding, settled
from fric.series import largest
from fric.units import Motion, known_digits, likely, parse, readable
from fric.verb import UnfitError, refused, verb

if TYPE_CHECKING:
    import rich.console
    import rich.table
    from matplotlib.figure import Figure as Figure
    from pandas import DataFrame as DataFrame

    from fric.documents.base import Document
    from fric.records.flaws import Encoder
    from fric.simulate.machine import Belief
else:  # no result needs them before it is drawn, or made a table
    Figure = DataFrame = Any

OTHERS = tomllib.loads(Path(__file__).with_name("symbols.toml").read_text("utf-8"))


@cache
def _of_models() -> dict[str, str]:
    """Return the names of friction models' parameters, where all models with the parameter agree."""
    from fric.friction import models

    found: dict[str, set[str]] = {}
    for model in models().values():
        for parameter in model.parameters:
            found.setdefault(parameter.name, set()).add(parameter.doc)
    return {name: next(iter(docs)) for name, docs in found.items() if len(docs) == 1}


def plain_names(symbols: Iterable[str]) -> list[str]:
    """Return the plain name of each symbol; of ``alpha_1``, ``alpha_2``, … only at the first."""
    named: set[str] = set()
    names = []
    for symbol in symbols:
        base, _, number = symbol.rpartition("_")
        key = symbol if not number.isdigit() or symbol in OTHERS or symbol in _of_models() else base
        names.append("" if key in named else OTHERS.get(key) or _of_models().get(key, ""))
        named.add(key)
    return names


NAMES = "  what it is"  # Heading of the column of plain names
WORDS = {NAMES: None, "what it is": 24, "what to run": 36}  # Columns of words, with their largest width
WIDTH = 1000  # Width of text outside a terminal: lines are not wrapped


@dataclass(frozen=True)
class Table:
    """A table for people: the first column to the left, numbers to the right."""

    columns: Sequence[str]  # Headings
    rows: Sequence[Sequence[str]] = field(default_factory=list)  # Cells, a row of as many as there are headings
    title: str = ""  # What stands above it

    def __rich_console__(self, console: rich.console.Console, options: Any) -> Iterator[rich.table.Table]:
        """Yield the table as Rich prints it; where a terminal is too narrow in parts, so that no cell is cut."""
        from rich.cells import cell_len
        from rich.table import Table as RichTable
        from rich.text import Text

        rows = [list(map(printable, row)) for row in self.rows]
        cells = [[printable(column), *(row[n] for row in rows)] for n, column in enumerate(self.columns)]
        full = [max(map(cell_len, column)) for column in cells]
        least = [max(map(cell_len, ["", *" ".join(column).split()])) for column in cells]  # cells wrap between words
        least[0] = full[0]  # but what rows are called stays on its line
        parts: list[list[int]] = [[0]]
        for n in range(1, len(self.columns)):
            if len(parts[-1]) > 1 and sum(least[k] + 2 for k in (*parts[-1], n)) - 2 > options.max_width:
                parts.append([0])
            parts[-1].append(n)
        title: Text | None = Text(printable(self.title))
        for part in parts:
            title, over = None, title or None
            made = RichTable(title=over, title_justify="left", box=None, pad_edge=False, header_style="bold")
            for n in part:
                side: Literal["left", "right"] = "left" if n == 0 or self.columns[n] in WORDS else "right"
                made.add_column(
                    Text(cells[n][0]), justify=side, no_wrap=full[n] == least[n], min_width=least[n],
                    max_width=WORDS.get(self.columns[n]),
                )  # fmt: skip
            for row in rows:
                made.add_row(*(Text(row[n]) for n in part))
            yield made

    def html(self) -> str:
        """Return the table as HTML."""
        head = "".join(f"<th>{escape(column)}</th>" for column in self.columns)
        body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in self.rows)
        caption = f"<caption>{escape(self.title)}</caption>" if self.title else ""
        return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


Piece = Table | str


def parameters(
    section: Mapping[str, Estimate | Mapping[str, Any]], title: str = "", notices: Iterable[Notice] = ()
) -> Table:
    """Return the table of estimates, or of a document's section: symbol, value, 95 % interval, unit, plain name.

    A flaw of every session is a word after the name, instead of a warning (`fric.flaws.base.Flaw.word`).
    """
    return named(("", "value", "95 % interval", "unit"), estimate_rows(section), title, notices)


def told_alone(notices: Iterable[Notice]) -> list[Notice]:
    """Return the warnings that are not words in a table; those that a file stated first are only counted."""
    known = list(map(Notice.of, notices))
    found = [notice for notice in known if not notice.carried and not any(flaw_of(notice).word)]
    if before := [notice for notice in known if notice.carried and notice.severity != "note"]:
        codes = ", ".join(dict.fromkeys(notice.code for notice in before))
        found.append(Notice.of(f"{len(before)} doubt{'s' * (len(before) > 1)} carried over: {codes}"))
    return found


def named(
    columns: Sequence[str], rows: Sequence[Sequence[str]], title: str = "", notices: Iterable[Notice] = ()
) -> Table:
    """Return a table of symbols in its first column, with a last column of their plain names, and words of flaws."""
    words = dict(flaw_of(notice).word for notice in notices)
    if not any(names := plain_names(row[0] for row in rows)):
        return Table(columns, rows, title)
    names = ["moment of inertia" if "kg·m²" in row else name for row, name in zip(rows, names, strict=True)]
    said = [f"{name}, {words[row[0]]}" if row[0] in words else name for row, name in zip(rows, names, strict=True)]
    return Table((*columns, NAMES), [(*row, f"  {name}") for row, name in zip(rows, said, strict=True)], title)


def plain(pieces: Iterable[Piece]) -> str:
    """Return pieces of a report as plain text."""
    from rich.console import Console

    out = StringIO()
    plain: dict[str, Any] = dict.fromkeys(("highlight", "legacy_windows", "force_jupyter"), False)
    console = Console(file=out, width=WIDTH, soft_wrap=True, color_system=None, **plain)  # a text in a notebook, too
    for piece in pieces:
        console.print(piece, markup=False)
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines())


def html(pieces: Iterable[Piece], warnings: Iterable[str] = ()) -> str:
    """Return pieces of a report, and its warnings, as HTML."""
    text = [piece.html() if isinstance(piece, Table) else f"<p>{escape(piece)}</p>" for piece in pieces]
    text += [f"<p><b>warning:</b> {escape(warning)}</p>" for warning in warnings]
    return "<div>" + "".join(text) + "</div>"


BRIEF = 53  # Columns of a line that names values


@dataclass_transform(eq_default=False, frozen_default=True)
class Result(ABC):
    """A result: it prints a report, draws a figure, and is saved to the file that its command writes.

    What a kind of result holds are its annotated fields: each is a frozen dataclass.
    """

    _schema: ClassVar[tuple[type[Document], str] | None] = None
    _tree: ClassVar[Callable[..., dict[str, Any]] | None] = None

    def __init_subclass__(
        cls, schema: type[Document] | None = None, of: str = "", tree: Callable[..., dict[str, Any]] | None = None
    ) -> None:
        """Keep the schema of the document, and the object that fills it: a field, or the result itself.

        tree: In place of a schema, what makes the document of all fields in their order.
        """
        dataclass(frozen=True, eq=False, repr=False)(cls)
        if schema is not None:
            cls._schema = schema, of
        if tree is not None:
            cls._tree = staticmethod(tree)
        if "save" in vars(cls):
            cls.save = verb(cls.save)  # type: ignore[method-assign]

    @cached_property
    def document(self) -> dict[str, Any]:
        """What ``--json`` prints: the document that is saved, or the values found."""
        if self._tree is not None:
            return self._tree(*(getattr(self, field.name) for field in fields(self)))  # type: ignore[arg-type]
        if self._schema is None:
            raise NotImplementedError(f"{type(self).__name__} states neither a schema nor a document")
        schema, of = self._schema
        holder = getattr(self, of) if of else self
        return schema.made(holder, notices=self.warnings, logs=getattr(self, "logs", ())).tree()

    @abstractmethod
    def report(self) -> Sequence[Piece]:
        """Return tables and lines for people."""

    def brief(self) -> str:
        """Return the result in a few words, for a line of a longer run; may be empty."""
        return ""

    def figure(self) -> Figure:
        """Return the figure that ``--plot`` draws: the default figure of the first part that has any."""
        from fric.figures.style import views_of

        for draw in views_of([*vars(self).values()], usual=True).values():
            return draw()
        raise FricError("this result has no figure", hint="Draw what it is made from, or leave out the plot.")

    def by_row(self) -> dict[str, dict[str, Any]]:
        """Return the values of the report in SI units, by row and column."""
        raise FricError(f"a {type(self).__name__} is not a table", hint="Take its document.")

    def to_frame(self) -> DataFrame:
        """Return the values of the report as a table in SI units."""
        import pandas as pd

        return pd.DataFrame.from_dict(self.by_row(), orient="index")

    @property
    def warnings(self) -> Sequence[Notice]:
        """Warnings: what the data do not show."""
        if self._schema is not None:
            return tuple(getattr(getattr(self, self._schema[1] or "found", None), "warnings", ()))
        return tuple(map(Notice.of, self.document.get("warnings_coded") or self.document.get("warnings", ())))

    def views(self) -> list[str]:
        """Return the names of the figures that the result can draw."""
        from fric.figures.style import views_of

        return list(views_of([*vars(self).values()]))

    @verb
    def plot(self, path: Path | str | None = None, *, view: str | None = None, force: bool = False) -> Figure:
        """Draw a figure, and save it where a path is given (.png, .svg or .pdf).

        path: The file.
        view: The name of a figure, one of `views`; by default the usual figure of the result.
        force: Replace a file that exists.
        Raises FricError: When there is no figure of that name, or no format of that ending.
        """
        from fric.figures.style import save_figure, views_of

        if view is None:
            drawn = self.figure()
        else:
            known = views_of([*vars(self).values()])
            require_known(view, known, "there is no figure", "The result has")
            drawn = known[view]()
        if path is not None:
            save_figure(drawn, Path(path), force=force)
        return drawn

    @verb
    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write the result to a file, whole or not at all; an existing file is only replaced with ``force``."""
        from fric.documents.yaml import write_document

        if "fric" not in self.document:
            raise FricError(f"{type(self).__name__} has no file of its own", hint="Keep its to_frame(), or its plot().")
        write_document(Path(path), self.document, force=force)

    def __repr__(self) -> str:
        return clean(plain([*self.report(), *(f"{text.head} {text}" for text in told_alone(self.warnings))]))

    def _repr_html_(self) -> str:
        return clean(html(self.report(), told_alone(self.warnings)))


class Identified(Result):
    """A result whose document holds identified parameters, each with unit and 95 % interval."""

    @property
    @abstractmethod
    def belief(self) -> Belief:
        """What a controller can believe of it."""

    @abstractmethod
    def sections(self) -> dict[str, dict[str, dict[str, Any]]]:
        """Return the parameters by section and name, as the document holds them."""

    def to_frame(self) -> DataFrame:
        """Return value, interval and unit of each parameter in SI, by section and name; vectors by element."""
        import pandas as pd

        rows = [
            (name, symbol, estimate.value, *(estimate.ci95 or (nan, nan)), estimate.unit, estimate.note)
            for name, section in self.sections().items() for symbol, estimate in elements(section)
        ]  # fmt: skip
        frame = pd.DataFrame(rows, columns=["section", "parameter", "value", "low", "high", "unit", "note"])
        return frame.set_index(["section", "parameter"])

    def __getattr__(self, name: str) -> Estimate:
        """Return a parameter by its name, with unit and interval: ``static.F_c``."""
        if not name.startswith("_") and name != "document":
            for section in self.sections().values():
                if name in section:
                    return Estimate.read(section[name])
        raise AttributeError(f"{type(self).__name__} has no '{name}'")

    def replace(self, **values: float | str | Sequence[float] | Estimate) -> Belief:
        """Return the identified model with other values: ``machine.with_belief(x=static.replace(F_c="60 N"))``.

        As `dataclasses.replace` of ``belief``, for that is what it returns: no record shows such a result.

        values: By name of a parameter, in SI or as a text with a unit.
        Raises FricError: When there is no such parameter, or the model does not bear the value.
        """
        known = {name: entry["unit"] for section in self.sections().values() for name, entry in section.items()}
        other, tree = copy(self), deepcopy(self.document)
        other.__dict__["document"] = tree
        for name, value in values.items():
            require_known(name, known, f"{type(self).__name__} has no")
            if isinstance(value, bool) or not isinstance(value, str | int | float | Sequence | Estimate):
                what = f"{name} was given as {'nothing' if value is None else type(value).__name__}"
                raise FricError(what, hint="Give a number in SI, or a text such as '60 N'.")
            for part in (tree, *(part for part in tree.values() if isinstance(part, dict))):
                if name in part:
                    part[name] = value if isinstance(value, str | Estimate) else {"value": value, "unit": known[name]}
        try:
            return other.belief
        except ValueError as error:  # as a document refuses it
            lines = str(error).splitlines()
            text = next((line.strip() for line in lines[1:] if "error, " in line), lines[0])
            raise FricError(text.partition("error, ")[2].partition(" [type=")[0] or text) from None

    def brief(self) -> str:
        """Return the values that have no index, as ``F_c 63.3 N``."""
        named = ((name, entry) for section in self.sections().values() for name, entry in section.items())
        values = [
            f"{name} {readable(entry['value'], entry['unit'], known_digits(entry['value'], entry.get('ci95')))}"
            for name, entry in named if isinstance(entry.get("value"), int | float) and not entry.get("fixed")
        ]  # fmt: skip
        while len(text := ", ".join(values)) > BRIEF:
            values.pop()
        return text

    def conf_int(self) -> DataFrame:
        """Return the 95 % interval of each parameter that has one, in SI; infinite where the data set no limit."""
        return self.to_frame()[["low", "high"]].dropna()


class Advance(Protocol):
    """Listener to the progress of a verb."""

    def __call__(self, steps: int = 1, *, total: int | None = None) -> None:
        """Receive the number of further steps done, and the total once it is known."""


OF_CHANNELS = ("time", "position", "velocity", "force", "input", "frequency")  # Dimensions with a largest value


def silent(steps: int = 1, *, total: int | None = None) -> None:
    """Ignore the progress."""


def records_of(
    given: Iterable[Any], *, one_axis: bool = True, whole: bool = False, encoder: Encoder = "motor"
) -> list[Record]:
    """Return the given records of one axis: records, log files, or lists of them.

    A record in which the control switches its mode is split by modes unless ``whole``. Of two encoders, ``encoder``
    names the one for the position.
    """
    if not (found := list(_flat(given))):
        raise FricError("no record was given", hint="Give log files, or what fric.read returns.")
    if one_axis:
        refuse_several_axes(found)
    if encoder == "load":
        from fric.records.flaws import by_load

        found = [by_load(record) if isinstance(record, Log) else record for record in found]
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
    if not (logs := [record for record in records if isinstance(record, Log)]):
        hint = "Give a log of samples, as `fric ingest` writes it."
        raise FricError("there is no record in time", where=records[0].where, hint=hint)
    return logs


def _flat(given: Iterable[Any], depth: int = 3) -> Iterable[Record]:
    for record in given:
        holds = isinstance(record, Iterable) and getattr(record, "ndim", True) and not isinstance(record, bytes | dict)
        if isinstance(record, Log | FrequencyResponse | ForceVelocity):
            yield record
        elif isinstance(record, str | Path):
            from fric.io.hdf5 import read_records  # with HDF5, which simulations need not

            yield from read_records(Path(record))
        elif hasattr(record, "columns") and hasattr(record, "dtypes"):
            hint = "`fric.Log.from_frame(frame)` makes one of columns as 'time [s]', 'position [mm]' and 'force [N]'."
            raise FricError("a data frame is no record yet", hint=hint)
        elif depth and holds:
            yield from _flat(record, depth - 1)  # a list may hold itself
        else:
            raise UnfitError("log files, or records that fric.read returns", record)


def path_of(wanted: str, given: Any) -> Path:
    """Return a path, or raise the error of a wrong type."""
    if not isinstance(given, str | Path):
        raise UnfitError(wanted, given)
    return Path(given)


def quantity(given: str | float | None, dimension: str, motion: Motion = "linear") -> float | None:
    """Return a positive quantity given in SI, or as a text with its unit; None if not given."""
    return None if given is None else positive(given, dimension, motion)


@names
def positive(given: str | float, dimension: str, motion: Motion = "linear") -> float:
    """Return a positive quantity given in SI, or as a text with its unit."""
    if not (value := in_si(given, dimension, motion)) > 0:
        raise FricError(f"'{given}' is not positive", hint="Give a positive value.")
    return value


@names
def in_si(given: str | float, dimension: str, motion: Motion = "linear") -> float:
    """Return a quantity given in SI, or as a text with its unit."""
    if isinstance(given, bool) or not isinstance(given, int | float | str):
        raise refused(dimension, 'a number in SI, or a text such as "1 mm"', given)
    value = parse(given, dimension, motion) if isinstance(given, str) else float(given)
    most = largest(dimension, motion) if dimension in OF_CHANNELS else GAIN
    if not abs(value) <= most or 0.0 < abs(value) < LEAST:
        raise FricError(f"'{given}' is no {dimension} that a machine has", hint="Look at the number and its unit.")
    return value


def bounded(name: str, given: str | float, motion: Motion = "linear") -> float:
    """Return a given quantity in SI, checked against its bound in `fric.plausibility` as those of files are."""
    dimension = BOUNDS[name].dimension
    try:
        value = positive(given, dimension, motion)
    except FricError as error:
        raise error if error.where else error.at(BOUNDS[name].what) from None
    stated = isinstance(given, str) and not given.strip()[-1].isdigit()
    mend = "Look at the unit" if stated else f"Is '{likely(f'{value:g}', dimension, motion)}' meant? Write the unit"
    settled([Finding(name, value, motion)], mend)
    return value


@names
def several(given: float | str | Sequence[str | float] | None, dimension: str, motion: Motion) -> list[float] | None:
    """Return quantities given as a list, or as a text with commas; None if not given."""
    if given is None:
        return None
    if isinstance(given, str):
        parts = [text for text in given.split(",") if text.strip()]
        return [in_si(text.strip(), dimension, motion) for text in parts] or [in_si(given, dimension, motion)]
    return [in_si(value, dimension, motion) for value in ([given] if isinstance(given, float | int) else given)]
