"""The page's first part, that prints on one sheet: machine, date, files, tolerance, the decision, pass or not."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from fric.documents.base import provenance
from fric.notice import Notice
from fric.report.measured import MeasuredView
from fric.report.report_input import ReportInput
from fric.units import readable
from fric.verdict.decide import decide
from fric.verdict.evidence import Evidence, Verdict, machine_name

ORDER = ("fail", "not decided", "pass", "")
"""Results of verdicts: of several the first is that of the page."""


@dataclass(frozen=True)
class Summary:
    """What is printed on one sheet."""

    facts: Sequence[tuple[str, str]]  # Machine, date, files, tolerance, as pairs for people
    verdicts: Sequence[tuple[str, Verdict]]  # The verdict of each contour, by its title
    # stamp, meaning: of the verdict that passes least (`Verdict.result`)
    stamp: str
    meaning: str
    measured: Sequence[str]  # A sentence for each measured circle
    # Warnings that must be seen to first, with where they are from, where there is no verdict that tells them
    wrong: Sequence[tuple[str, str]]
    further: int  # How many further warnings there are
    next_step: str  # What to do where there is no verdict
    failed: Sequence[str] = ()  # Steps that failed, and why


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
    files += [*(one.source for one in inputs.circles), *(name for name, _ in inputs.logs + inputs.maps)]
    files += [*(one.source for one in inputs.replaced), *(before.source for before, _ in inputs.pairs)]
    files += [before.source for before, _ in inputs.test_pairs]
    made = datetime.fromisoformat(str(provenance()["created"]))
    facts = [("machine", machine)] if machine else []
    axes = dict.fromkeys([*inputs.axes(), *(name for test in inputs.tests for name in test.axes)])
    facts += [("axes", ", ".join(axes))] if axes else []
    facts += [("date", f"{made:%Y-%m-%d}"), ("files", ", ".join(dict.fromkeys(files)))]
    if inputs.tolerance is not None:
        facts.append(("tolerance", f"glitch within {readable(inputs.tolerance, 'm')}"))
    every = [(source, notice) for source, notices in warnings for notice in notices]
    reasons = {str(text) for _, one in verdicts for text in one.why}  # all that is wrong is told by each verdict
    wrong = [(source, str(one)) for source, one in every if one.severity == "wrong" and not verdicts]
    results = [one.result for _, one in verdicts] or [decide(Evidence(tolerance=inputs.tolerance)).result]
    return Summary(
        facts, verdicts, *min(results, key=lambda one: ORDER.index(one[0])),
        [_sentence(one, inputs.tolerance) for one in measured], wrong,
        sum(str(one) not in reasons for _, one in every) - len(wrong), "" if verdicts else next_step,
        inputs.failed,
    )  # fmt: skip


def _sentence(one: MeasuredView, tolerance: float | None) -> str:
    text = f"{one.source}, {one.title[:1].lower()}{one.title[1:]}: measured glitch {readable(one.glitch, 'm', 2)}"
    if tolerance is not None:
        text += ", within the tolerance" if one.glitch <= tolerance else ", beyond the tolerance"
    if one.agrees is not None:
        text += f"; {'as' if one.agrees else 'not as'} the machine file predicts for scheme ({one.scheme})"
    return text + "."
