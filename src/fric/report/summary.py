"""A report as a result: the summary that a command prints, and its page."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from math import pi
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np

from fric.documents.bundled import located
from fric.documents.contours import VerdictPart
from fric.documents.listings import ReportDocument
from fric.documents.machine_files import read_machine
from fric.errors import FricError
from fric.notice import Notice
from fric.output import written
from fric.report.collect import ContourTest, ReportInput, collect, description
from fric.report.plots import presliding
from fric.report.view import observations, render_report
from fric.results.base import Advance, Result, bounded, path_of, silent
from fric.results.kinds import CircleFiles, Quantity
from fric.results.records import Records
from fric.results.simulate import CircleResult, PathResult
from fric.simulate.contour_run import Circle, run_circle
from fric.simulate.machine import Machine
from fric.simulate.processes import MonteCarlo, Study, run_all
from fric.units import readable
from fric.verb import Kind, typed, verb

MOST_MACHINES, LEAST_MACHINES = 40, 20  # Number of machines to draw: of these, two or one exceed the bound of 95 %
SECONDS = 160.0  # Total time of two revolutions of all machines [s] above which fewer are drawn, for a page soon
SAME = 1e-9  # Largest difference of the glitch of a repeated run [m], before its machine file counts as changed


def _wanted(test: ContourTest) -> bool:
    """Return whether machines are drawn around a run: it has none, and knows its machine exactly."""
    alone = test.radius is None or len(test.contours) < 2 or any(contour.drawn for contour in test.contours)
    return bool(test.provenance.get("exact")) and not alone and test.machine is not None


def _machines(test: ContourTest) -> int:
    """Return the number of machines to draw, limited by the duration of the circle."""
    assert test.radius is not None
    return int(np.clip(SECONDS / (2 * 2 * pi * test.radius / test.feed), LEAST_MACHINES, MOST_MACHINES))


def _drawn(test: ContourTest, advance: Callable[..., None]) -> ContourTest:
    """Return a run with machines as by `fric simulate circle --monte-carlo`, unless its file is gone or has changed."""
    origin = dict(test.provenance["origin"])
    only = test.axes[0] if len(test.axes) == 1 else None
    assert test.radius is not None
    circle = Circle(test.radius, test.feed, direction=test.direction)
    schemes = tuple(contour.scheme for contour in test.contours)
    try:
        machine = read_machine(located(Path(origin.pop("path")), "machine"), **origin)
        again = run_circle(machine, schemes[0], circle, only=only).circularity
    except FricError:
        return test
    if abs(again.glitch - test.contours[0].glitch) > SAME:
        return test
    study, count = Study(machine, schemes, circle, only=only), _machines(test)
    many = MonteCarlo(study, count, tuple(run_all(study, count, advance=advance)))
    contours = (
        replace(contour, drawn=tuple(map(float, many.glitches[:, n])), swings=tuple(map(float, many.swings[:, n])))
        for n, contour in enumerate(test.contours)
    )
    return replace(test, contours=tuple(contours))


@typed
class Report(Result):
    """A report: identified parameters, measured circles, the verdict, and drift."""

    inputs: ReportInput  # The data that it is made of
    title: str = ""  # Heading of its page

    @cached_property
    def document(self) -> dict[str, Any]:
        """Axes, verdict, advice, drift and warnings."""
        return report_document(self.inputs)

    def report(self) -> Sequence[str]:
        """Return the verdict, the result of a measured circle, and drift."""
        verdicts = [line for test in self.inputs.tests for line in self.inputs.verdict(test).lines()]
        return [*verdicts, *(f"{drift['of']}: {drift['told']}" for drift in self.document["drift"])]

    @property
    def warnings(self) -> Sequence[Notice]:
        """Warnings of the files and of measured circles."""
        measured = (text for circle in self.inputs.circles for text in circle.result.warnings)
        return [*map(Notice.of, self.document["warnings_coded"]), *measured]

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write one self-contained HTML page."""
        written(Path(path), render_report(self.inputs, self.title), force=force)

    def _repr_html_(self) -> str:
        return render_report(self.inputs, self.title)


@verb
def make_report(
    *files: Annotated["Result | Machine | Path | str", Kind(Path, "FILE")], circles: CircleFiles = (), title: str = "",
    tolerance: Annotated[Quantity | None, "position"] = None,
    failed: Annotated[Sequence[str], Kind(list[str], "TEXT")] = (), advance: Advance = silent,
) -> Report:  # fmt: skip
    """Make a self-contained HTML page: the verdict, measured circles, identified parameters, and drift.

    If the controllers of a run know its machine exactly, varied machines are simulated first. If a measured circle
    differs from its prediction, the page says so and recommends no scheme, unless varied machines were fitted to it.

    files: Results, or files: runs, measured circles, the machine (file, or bundled name) to compare them with,
        documents of friction, plant, controller and observer, logs to draw points from, or earlier reports: each is
        recognised by its content; of two of one kind the earlier is compared with the later.
    circles: A measured circle, or a run used as one; repeatable.
    title: Heading of the page. By the machine and its axes where not given.
    tolerance: Allowed glitch, as "5 um": pass or not.
    failed: A step that failed, with its reason, to show on the page; repeatable.
    Raises FricError: When a file is not of fric.
    """
    allowed = None if tolerance is None else bounded("tolerance", tolerance)
    with TemporaryDirectory() as folder:
        paths = [_saved(file, Path(folder, str(n))) for n, file in enumerate(files)]
        found = collect(paths, list(map(Path, circles)), allowed)
        if Path(found.machine).is_relative_to(folder):  # the page names what `machine.save` is likely to have written
            found = replace(found, machine=Path(found.machine).name)
    wanted = [test for test in found.tests if _wanted(test)]
    advance(0, total=sum(map(_machines, wanted)))
    tests = tuple(_drawn(test, advance) if test in wanted else test for test in found.tests)
    return Report(replace(found, tests=tests, failed=tuple(failed)), title)


def _saved(given: Any, folder: Path) -> Path:
    """Return a file as it is given, and the file of a result or machine, saved in a folder."""
    if isinstance(given, Machine):
        path = folder / "machine.yaml"
    elif isinstance(given, Result):
        binary = isinstance(given, CircleResult | PathResult | Records)
        names = (given.document["fric"].partition("/")[0], given.document.get("axis", ""))
        path = folder / ("-".join(filter(None, names)) + (".h5" if binary else ".yaml"))
    else:
        return path_of("a result, a machine, or a file", given)
    folder.mkdir()
    given.save(path)
    return path


def report_document(inputs: ReportInput) -> dict[str, Any]:
    """Return axes, warnings, advice and drift of a report as a plain document."""
    longest = presliding(inputs)
    advice = [
        {"velocity": test.feed, "radius": test.radius}
        | VerdictPart.model_validate(inputs.verdict(test)).model_dump()
        | {"reasons": observations(test, longest)}
        for test in inputs.tests
    ]
    changes = [(f"{after.kind} {after.axis}", before.changes(after)) for before, after in inputs.pairs]
    glitches = [(f"glitch at {readable(late.feed, 'm/s')}", old.changes(late)) for old, late in inputs.test_pairs]
    drift = [{"of": of, "told": description(found), "changes": found} for of, found in changes + glitches]
    warnings: list[Notice] = [text for item in inputs.items for text in item.warnings]
    warnings += [text for test in inputs.tests for contour in test.contours for text in contour.warnings]
    circles = [{"file": circle.source} | circle.result.document for circle in inputs.circles]
    content = {"axes": list(inputs.axes()), "advice": advice, "drift": drift, "circles": circles}
    return ReportDocument.made(content, notices=warnings).tree()
