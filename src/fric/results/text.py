"""Tables and lines, the same on the command line, in a result's repr, and in a notebook."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from html import escape
from io import StringIO
from typing import TYPE_CHECKING, Any, Literal

from fric.errors import printable
from fric.estimate import Estimate, estimate_rows
from fric.flaws import flaw_of
from fric.notice import Notice

if TYPE_CHECKING:
    import rich.console
    import rich.table

OTHERS = {
    "A": "damping over mass",
    "B": "acceleration per volt",
    "T_d": "delay of the drive",
    "K_f": "force constant",
    "force_lag": "lag of the logged force",
    "force_filter": "low-pass of the logged force",
    "offset": "constant force",
    "M": "moving mass",
    "F_v": "viscous friction",
    "frequency": "resonance",
    "ratio": "share of the second mass",
    "damping": "damping ratio",
    "K_v": "position gain",
    "K_p": "velocity gain",
    "K_i": "integral velocity gain",
    "velocity_filter": "low-pass of the velocity",
    "sampling": "rate of the controller",
    "limit": "largest voltage",
    "cutoff": "cutoff of Q",
    "sigma_0": "stiffness at rest",
    "sigma_1": "damping of the bristles",
    "n": "shape of the transition",
}
"""Names of symbols that are no parameters of friction models."""


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
        whole = not number.isdigit() or symbol in OTHERS or symbol in _of_models()
        key = symbol if whole else base
        name = OTHERS.get(key) or _of_models().get(key, "")
        names.append("" if key in named else name)
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
    made = named(("", "value", "95 % interval", "unit"), estimate_rows(section), title)
    words = dict(flaw_of(notice).word for notice in notices)
    rows = [(*row[:-1], f"{row[-1]}, {words[row[0]]}") if row[0] in words else row for row in made.rows]
    return replace(made, rows=rows)


def told_alone(notices: Iterable[Notice]) -> list[str]:
    """Return the warnings that are not words in a table; those that a file stated first are only counted."""
    known = list(map(Notice.of, notices))
    found: list[str] = [notice for notice in known if not notice.carried and not any(flaw_of(notice).word)]
    before = [notice for notice in known if notice.carried and notice.severity != "note"]
    if before:
        codes = ", ".join(dict.fromkeys(notice.code for notice in before))
        found.append(f"{len(before)} doubt{'s' * (len(before) > 1)} carried over: {codes}")
    return found


def named(columns: Sequence[str], rows: Sequence[Sequence[str]], title: str = "") -> Table:
    """Return a table of symbols in its first column, with a last column of their plain names."""
    names = plain_names(row[0] for row in rows)
    if not any(names):
        return Table(columns, rows, title)
    return Table((*columns, NAMES), [(*row, f"  {name}") for row, name in zip(rows, names, strict=True)], title)


def plain(pieces: Iterable[Piece]) -> str:
    """Return pieces of a report as plain text."""
    from rich.console import Console

    out = StringIO()
    console = Console(
        file=out,
        width=WIDTH,
        highlight=False,
        soft_wrap=True,
        color_system=None,
        legacy_windows=False,
        force_jupyter=False,
    )  # in a notebook, too, it is a text, and not shown beside the result
    for piece in pieces:
        console.print(piece, markup=False)
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines())


def html(pieces: Iterable[Piece], warnings: Iterable[str] = ()) -> str:
    """Return pieces of a report, and its warnings, as HTML."""
    text = [piece.html() if isinstance(piece, Table) else f"<p>{escape(piece)}</p>" for piece in pieces]
    text += [f"<p><b>warning:</b> {escape(warning)}</p>" for warning in warnings]
    return "<div>" + "".join(text) + "</div>"
