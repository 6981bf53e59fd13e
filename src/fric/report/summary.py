"""A report as a result: the few words of it that a command prints, and its page."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from fric.documents.contours import VerdictPart
from fric.documents.report_summary import ReportDocument
from fric.io.report import write_report
from fric.notice import Notice
from fric.report.advice import observations
from fric.report.collect import collect
from fric.report.curves import presliding
from fric.report.drawn import with_machines
from fric.report.drift import description, document_changes, glitch_changes
from fric.report.page import render_report
from fric.report.report_input import ReportInput
from fric.results.base import Result
from fric.results.given import Advance, bounded, silent
from fric.units import readable
from fric.verb import verb


@dataclass(frozen=True, eq=False, repr=False)
class Report(Result):
    """A report: what was identified, what a circle shows, what to use, and what drifted.

    Parameters
    ----------
    inputs
        What it is made of.
    title
        Heading of its page.
    """

    inputs: ReportInput
    title: str = ""

    @cached_property
    def document(self) -> dict[str, Any]:
        """Axes, verdict, advice, drift and warnings."""
        return report_document(self.inputs)

    def report(self) -> Sequence[str]:
        """Return the verdict, what a measured circle says, and what drifted."""
        verdicts = [line for test in self.inputs.tests for line in self.inputs.verdict(test).lines()]
        drifts = (f"{drift['of']}: {drift['told']}" for drift in self.document["drift"])
        return [*verdicts, *drifts]

    @property
    def warnings(self) -> Sequence[Notice]:
        """What the files warn of, and the measured circles."""
        return [*self.document["warnings"], *(text for one in self.inputs.circles for text in one.result.warnings)]

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write one self-contained HTML page."""
        write_report(Path(path), render_report(self.inputs, self.title), force=force)

    def _repr_html_(self) -> str:
        return render_report(self.inputs, self.title)


@verb
def make_report(
    *files: Path | str,
    circles: Iterable[Path | str] = (),
    title: str = "",
    tolerance: float | str | None = None,
    advance: Advance = silent,
) -> Report:
    """Make one page of what was identified, what a circle shows, what to use, and what drifted.

    Parameters
    ----------
    files
        Runs, measured circles, a machine (file, or bundled name) to hold them against, documents, logs to draw points
        from, or earlier reports: each is recognised by its content. Of two of one kind the earlier is compared with
        the later.
    circles
        Measured circles besides: also a run file that stands for one.
    title
        Heading of the page; by the machine and its axes where not given.
    tolerance
        Glitch that is allowed [m], also as a text.
    advance
        Is told of each machine that is drawn where a run's controllers know exactly what is true of theirs.

    Raises
    ------
    FricError
        When a file is none of fric's.
    """
    allowed = None if tolerance is None else bounded("tolerance", tolerance)
    paths, measured = (list(map(Path, given)) for given in (files, circles))
    found = collect(paths, measured, allowed)
    return Report(with_machines(found, advance), title)


def report_document(inputs: ReportInput) -> dict[str, Any]:
    """Return axes, warnings, advice and drift of a report as a plain document."""
    longest = presliding(inputs)
    advice = [
        {"velocity": test.feed, "radius": test.radius}
        | VerdictPart.model_validate(inputs.verdict(test)).model_dump()
        | {"reasons": observations(test, longest)}
        for test in inputs.tests
    ]
    changes = [(f"{after.kind} {after.axis}", document_changes(before, after)) for before, after in inputs.pairs]
    changes += [
        (f"glitch at {readable(after.feed, 'm/s')}", glitch_changes(before, after))
        for before, after in inputs.test_pairs
    ]
    drift = [{"of": of, "told": description(found), "changes": found} for of, found in changes]
    warnings: list[Notice] = [text for item in inputs.items for text in item.warnings]
    warnings += [text for test in inputs.tests for one in test.contours for text in one.warnings]
    circles = [{"file": one.source} | one.result.document for one in inputs.circles]
    content = {"axes": list(inputs.axes()), "advice": advice, "drift": drift, "circles": circles}
    return ReportDocument.made(content, notices=warnings).tree()
