"""The base of all results: document, figure, report, table, and how they are saved."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from functools import cached_property
from math import inf, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from fric.errors import FricError
from fric.estimate import Estimate, elements, note_of
from fric.notice import Notice
from fric.results.text import Piece, html, plain, told_alone
from fric.units import readable
from fric.verb import verb

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Figure
    from pandas import DataFrame as DataFrame

    from fric.documents.base import Document
else:  # no result needs them before it is drawn, or made a table
    Figure = DataFrame = Any

BRIEF = 53  # Columns of a line that names values


class Result(ABC):
    """A result: it prints a report, draws a figure, and is saved to the file that its command writes."""

    _schema: ClassVar[tuple[type[Document], str] | None] = None

    def __init_subclass__(cls, schema: type[Document] | None = None, of: str = "") -> None:
        """Keep the schema of the document, and the object that fills it: a field, or the result itself."""
        if schema is not None:
            cls._schema = schema, of
        if "save" in vars(cls):
            cls.save = verb(cls.save)  # type: ignore[method-assign]

    @cached_property
    def document(self) -> dict[str, Any]:
        """What ``--json`` prints: the document that is saved, or the values found."""
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
        raise FricError(f"a {type(self).__name__} has no figure of its own")

    def by_row(self) -> dict[str, dict[str, Any]]:
        """Return the values of the report in SI units, by row and column."""
        raise FricError(f"a {type(self).__name__} is no table", hint="Take its document.")

    def to_frame(self) -> DataFrame:
        """Return the values of the report as a table in SI units."""
        import pandas as pd

        return pd.DataFrame.from_dict(self.by_row(), orient="index")

    @property
    def warnings(self) -> Sequence[Notice]:
        """Warnings: what the data do not show."""
        if self._schema is not None:
            return tuple(getattr(getattr(self, self._schema[1], None), "warnings", ()))
        return tuple(map(Notice.of, self.document.get("warnings_coded") or self.document.get("warnings", ())))

    def views(self) -> list[str]:
        """Return the names of the figures that the result can draw."""
        from fric.figures.style import views_of

        return list(views_of([*vars(self).values()]))

    @verb
    def plot(self, path: Path | str | None = None, *, view: str | None = None, force: bool = False) -> Figure:
        """Draw a figure, and save it where a path is given (.png, .svg or .pdf).

        Parameters
        ----------
        path
            The file.
        view
            The name of a figure, one of `views`; by default the usual figure of the result.
        force
            Replace a file that exists.

        Raises
        ------
        FricError
            When there is no figure of that name, or no format of that ending.
        """
        from fric.figures.style import figure_named

        drawn = self.figure() if view is None else figure_named(view, [*vars(self).values()])
        if path is not None:
            from fric.figures.style import save_figure

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
        return plain([*self.report(), *(f"warning: {text}" for text in told_alone(self.warnings))])

    def _repr_html_(self) -> str:
        return html(self.report(), told_alone(self.warnings))


class Identified(Result):
    """A result whose document holds identified parameters, each with unit and 95 % interval."""

    @abstractmethod
    def sections(self) -> dict[str, dict[str, dict[str, Any]]]:
        """Return the parameters by section and name, as the document holds them."""

    def to_frame(self) -> DataFrame:
        """Return value, interval and unit of each parameter in SI, by section and name; vectors by element."""
        import pandas as pd

        rows = [row for name, section in self.sections().items() for row in _rows(name, section)]
        frame = pd.DataFrame(rows, columns=["section", "parameter", "value", "low", "high", "unit", "note"])
        return frame.set_index(["section", "parameter"])

    def __getattr__(self, name: str) -> Estimate:
        """Return a parameter by its name, with unit and interval: ``static.F_c``."""
        if not name.startswith("_") and name != "document":
            for section in self.sections().values():
                if name in section:
                    return Estimate.read(section[name])
        raise AttributeError(f"{type(self).__name__} has no '{name}'")

    def brief(self) -> str:
        """Return the values that have no index, as ``F_c 63.3 N``."""
        named = ((name, entry) for section in self.sections().values() for name, entry in section.items())
        values = [
            f"{name} {readable(entry['value'], entry['unit'])}" for name, entry in named
            if isinstance(entry.get("value"), int | float) and not entry.get("fixed")
        ]  # fmt: skip
        while len(text := ", ".join(values)) > BRIEF:
            values.pop()
        return text

    def conf_int(self) -> DataFrame:
        """Return the 95 % interval of each parameter that has an interval, in SI; infinite where the data set no
        limit.
        """
        return self.to_frame()[["low", "high"]].dropna()


def _rows(section: str, entries: dict[str, dict[str, Any]]) -> Iterator[tuple[Any, ...]]:
    for name, value, interval, entry in elements(entries):
        low, high = (nan, nan) if interval is None else interval
        ends = (-inf if low is None else low, inf if high is None else high)
        yield section, name, value, *ends, entry["unit"], note_of(entry)
