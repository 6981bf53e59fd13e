"""Tables and lines that are told the same on the command line, as a result's repr, and in a notebook."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from html import escape
from io import StringIO
from typing import TYPE_CHECKING, Any

from fric.errors import printable
from fric.estimate import Estimate, estimate_rows
from fric.flaws import flaw_of
from fric.notice import Notice
from fric.results.names import plain_names

if TYPE_CHECKING:
    import rich.table

NAMES = "  what it is"
"""Heading of the column of plain names, which reads from the left."""

WIDTH = 1000
"""Columns of text that is no terminal's: a line is as long as it is."""


@dataclass(frozen=True)
class Table:
    """A table for people: the first column to the left, numbers to the right."""

    columns: Sequence[str]  # Headings
    rows: Sequence[Sequence[str]] = field(default_factory=list)  # Cells, a row of as many as there are headings
    title: str = ""  # What stands above it

    def __rich__(self) -> rich.table.Table:
        """Return the table as Rich prints it."""
        from rich.cells import cell_len
        from rich.table import Table as RichTable
        from rich.text import Text

        def shown(text: str) -> Text:
            return Text(printable(text))

        title = shown(self.title) if self.title else None
        made = RichTable(title=title, title_justify="left", box=None, pad_edge=False, header_style="bold")
        least = [max((cell_len(printable(row[0])) for row in self.rows), default=0), *(None for _ in self.columns)]
        for n, column in enumerate(self.columns):
            words = n == 0 or column == NAMES
            # what rows are called is never cut: other columns give way, and wrap
            made.add_column(shown(column), justify="left" if words else "right", no_wrap=n == 0, min_width=least[n])
        for row in self.rows:
            made.add_row(*map(shown, row))
        return made

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

    What every session shows is a word behind the name, in place of a warning (`fric.flaws.base.Flaw.word`).
    """
    made = named(("", "value", "95 % interval", "unit"), estimate_rows(section), title)
    words = dict(flaw_of(one).word for one in notices)
    rows = [(*row[:-1], f"{row[-1]}, {words[row[0]]}") if row[0] in words else row for row in made.rows]
    return replace(made, rows=rows)


def told_alone(notices: Iterable[Notice]) -> list[str]:
    """Return the warnings that no word of a table says; those that a file said first are counted."""
    known = list(map(Notice.of, notices))
    found: list[str] = [one for one in known if not one.carried and not any(flaw_of(one).word)]
    before = [one for one in known if one.carried and one.severity != "note"]
    if before:
        codes = ", ".join(dict.fromkeys(one.code for one in before))
        found.append(f"{len(before)} doubt{'s' * (len(before) > 1)} carried over: {codes}")
    return found


def named(columns: Sequence[str], rows: Sequence[Sequence[str]], title: str = "") -> Table:
    """Return a table whose first column holds symbols, with their plain names in a last one."""
    names = plain_names(row[0] for row in rows)
    if not any(names):
        return Table(columns, rows, title)
    return Table((*columns, NAMES), [(*row, f"  {name}") for row, name in zip(rows, names, strict=True)], title)


def plain(pieces: Iterable[Piece]) -> str:
    """Return pieces of a report as plain text."""
    from rich.console import Console

    out = StringIO()
    console = Console(file=out, width=WIDTH, highlight=False, soft_wrap=True, color_system=None, legacy_windows=False)
    for piece in pieces:
        console.print(piece, markup=False)
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines())


def html(pieces: Iterable[Piece], warnings: Iterable[str] = ()) -> str:
    """Return pieces of a report, and its warnings, as HTML."""
    text = [piece.html() if isinstance(piece, Table) else f"<p>{escape(piece)}</p>" for piece in pieces]
    text += [f"<p><b>warning:</b> {escape(warning)}</p>" for warning in warnings]
    return "<div>" + "".join(text) + "</div>"
