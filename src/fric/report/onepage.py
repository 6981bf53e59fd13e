"""The page's first part, that prints on one sheet: machine, date, files, tolerance, the decision, pass or not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from fric.documents.provenance import provenance
from fric.results.verdict import machine_name
from fric.units import readable

if TYPE_CHECKING:
    from fric.notice import Notice
    from fric.report.measured import MeasuredView
    from fric.report.report_input import ReportInput
    from fric.verdict.evidence import Verdict


@dataclass(frozen=True)
class Summary:
    """What is printed on one sheet.

    Parameters
    ----------
    facts
        Machine, date, files, tolerance, as pairs for people.
    verdicts
        The verdict of each contour, by its title.
    stamp, meaning
        ``pass``, ``fail``, ``not decided``, and in words; empty where no tolerance was asked.
    measured
        A sentence for each measured circle.
    wrong
        Warnings that must be seen to first, with where they are from.
    doubts
        How many further warnings there are.
    next_step
        What to do where there is no verdict.
    """

    facts: Sequence[tuple[str, str]]
    verdicts: Sequence[tuple[str, Verdict]]
    stamp: str
    meaning: str
    measured: Sequence[str]
    wrong: Sequence[tuple[str, str]]
    doubts: int
    next_step: str


def summary_of(
    inputs: ReportInput,
    verdicts: Sequence[tuple[str, Verdict]],
    measured: Sequence[MeasuredView],
    warnings: Sequence[tuple[str, Sequence[Notice]]],
    next_step: str,
) -> Summary:
    """Return the summary of what a page tells."""
    names = dict.fromkeys(str(test.provenance.get("machine", "")) for test in inputs.tests)
    machine = "; ".join(filter(None, names)) or (machine_name(inputs.machine) if inputs.machine else "")
    files = [Path(inputs.machine).name] if inputs.machine else []
    files += [*(item.source for item in inputs.items), *(test.source for test in inputs.tests)]
    files += [*(one.source for one in inputs.circles), *(name for name, _ in inputs.logs)]
    made = datetime.fromisoformat(str(provenance()["created"]))
    facts = [("machine", machine)] if machine else []
    axes = dict.fromkeys([*inputs.axes(), *(name for test in inputs.tests for name in test.axes)])
    facts += [("axes", ", ".join(axes))] if axes else []
    facts += [("date", f"{made:%Y-%m-%d}"), ("files", ", ".join(dict.fromkeys(files)))]
    if inputs.tolerance is not None:
        facts.append(("tolerance", f"glitch within {readable(inputs.tolerance, 'm')}"))
    every = [(source, notice) for source, notices in warnings for notice in notices]
    told = {str(text) for _, one in verdicts for text in one.why}
    wrong = [(source, str(one)) for source, one in every if one.severity == "wrong" and str(one) not in told]
    grave = sum(one.severity == "wrong" for _, one in every)
    return Summary(
        facts, verdicts, *_stamp(inputs.tolerance, [one for _, one in verdicts]),
        [_sentence(one, inputs.tolerance) for one in measured], wrong, len(every) - grave,
        "" if verdicts else next_step,
    )  # fmt: skip


def _stamp(tolerance: float | None, verdicts: Sequence[Verdict]) -> tuple[str, str]:
    """Return ``pass`` where every verdict keeps the tolerance and may be trusted, and what that means."""
    if tolerance is None:
        return "", ""
    if not verdicts:
        return "not decided", "nothing was simulated"
    if any(one.choice is None for one in verdicts):
        return "not decided", "no scheme is recommended"
    if not all(one.passes for one in verdicts):
        return "fail", "no scheme that was run surely stays within it"
    if not all(one.trusted for one in verdicts):
        return "not decided", "it is kept in simulation, which is not to be trusted yet"
    return "pass", "on 95 % of the machines drawn around this one"


def _sentence(one: MeasuredView, tolerance: float | None) -> str:
    text = f"{one.source}, {one.title[:1].lower()}{one.title[1:]}: measured glitch {readable(one.glitch, 'm', 2)}"
    if tolerance is not None:
        text += ", within the tolerance" if one.glitch <= tolerance else ", beyond the tolerance"
    if one.agrees is not None:
        text += f"; {'as' if one.agrees else 'not as'} predicted for scheme ({one.scheme})"
    return text + "."
