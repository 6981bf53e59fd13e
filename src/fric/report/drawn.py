"""Machines that are drawn for the page, where a run's controllers know exactly what is true of its machine."""

from collections.abc import Callable
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np

from fric.documents.bundled import located
from fric.documents.machine_files import read_machine
from fric.errors import FricError
from fric.report.report_input import ContourTest, ReportInput
from fric.results.given import Advance, silent
from fric.simulate.circle import Circle, run_circle
from fric.simulate.monte_carlo import Study
from fric.simulate.processes import outcomes

MOST, LEAST = 40, 20
"""Machines that are drawn: two, or one, lie beyond what 95 % stay under."""

SECONDS = 160.0
"""Time of two revolutions of all machines together, from which fewer are drawn [s]: a page is not waited for long."""

SAME = 1e-9
"""By how much the glitch of the run made again may differ [m], before its machine file counts as changed."""


def with_machines(inputs: ReportInput, advance: Advance = silent) -> ReportInput:
    """Return a report's input with machines drawn around each run that knows its machine exactly and has none.

    Around the machine that the run was made with, as `fric simulate circle --monte-carlo` draws; nothing is drawn where
    its file is gone or has changed since.
    """
    wanted = [test for test in inputs.tests if _wanted(test)]
    advance(0, total=sum(map(_machines, wanted)))
    return replace(inputs, tests=tuple(_drawn(test, advance) if test in wanted else test for test in inputs.tests))


def _wanted(test: ContourTest) -> bool:
    alone = test.radius is None or len(test.contours) < 2 or any(one.drawn for one in test.contours)
    return bool(test.provenance.get("exact")) and not alone and test.machine is not None


def _machines(test: ContourTest) -> int:
    """Return how many machines are drawn: as many as a page can wait for, by the time that the circle takes."""
    assert test.radius is not None
    return int(np.clip(SECONDS / (2 * 2 * pi * test.radius / test.feed), LEAST, MOST))


def _drawn(test: ContourTest, advance: Callable[..., None]) -> ContourTest:
    origin = dict(test.provenance["origin"])
    only = test.axes[0] if len(test.axes) == 1 else None
    assert test.radius is not None
    circle = Circle(test.radius, test.feed, direction=test.direction)
    schemes = tuple(one.scheme for one in test.contours)
    try:
        machine = read_machine(located(Path(origin.pop("path")), "machine"), **origin)
        again = run_circle(machine, schemes[0], circle, only=only).circularity
    except FricError:
        return test
    if abs(again.glitch - test.contours[0].glitch) > SAME:
        return test
    done = []
    with outcomes(Study(machine, schemes, circle, only=only), _machines(test)) as found:
        for outcome in found:
            done.append(outcome)
            advance()
    glitches, swings = np.array([np.abs(one.quadrants).max(axis=1) for one in done]), np.array([o.swings for o in done])
    contours = (
        replace(one, drawn=tuple(map(float, glitches[:, n])), swings=tuple(map(float, swings[:, n])))
        for n, one in enumerate(test.contours)
    )
    return replace(test, contours=tuple(contours))
