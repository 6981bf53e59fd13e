"""Whether a prediction of a circle may be trusted: warnings of the files, and what a measured circle says."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fric.contour import QUADRANTS
from fric.control.scheme import OBSERVER, PAPER_SCHEMES, Scheme
from fric.errors import FricError
from fric.identify.circle.diagnose import diagnose
from fric.identify.circle.measured import measured_from_run
from fric.notice import Notice
from fric.simulate.circle import Circle, run_circle

if TYPE_CHECKING:
    from collections.abc import Mapping

    from fric.identify.circle.measured import MeasuredCircle
    from fric.simulate.machine import Machine

SETTLED = frozenset(
    {"force-over-position", "directions-differ", "force-drifts", "level-differs", "strokes-unsettled", "F_c-at-bound"}
)
"""Warnings of friction's level, which a measured circle settles: every machine drawn has the level of that circle."""
UNSEEN = frozenset({"plant-from-motion", "T_d-assumed", "observer-assumed"})
"""Warnings that the response of the axis was not measured: an observer acts on what it leaves open."""
APART, SHARE_APART = 5e-7, 0.04
"""By how much a completed machine may miss a glitch that was measured [m], and as a share of it."""
OTHER_FEED = 2.0
"""Ratio of feeds, and of radii, beyond which a measured circle tells little of another."""


def distrusts(
    machine: Machine, notices: Iterable[Notice], tests: Sequence[MeasuredCircle], circle: Circle
) -> tuple[Notice, ...]:
    """Return why no interval of a prediction must be trusted; nothing where all may be.

    Parameters
    ----------
    machine
        The machine at the estimates, completed by the tests where there are any.
    notices
        What its files warn of.
    tests
        Measured circles.
    circle
        The circle that is predicted.
    """
    return tuple(dict.fromkeys([*_of_files(notices, bool(tests)), *_of_circles(machine, tests, circle)]))


def _of_files(notices: Iterable[Notice], measured: bool) -> Iterator[Notice]:
    if not measured:
        yield Notice(
            "there is no measured circle to hold the prediction against: record one, as little as two revolutions "
            "without compensation",
            "no-measured-circle", "doubt",
        )  # fmt: skip
    for notice in notices:
        if notice.severity == "wrong" and not (measured and notice.code in SETTLED):
            yield notice


def _of_circles(machine: Machine, tests: Sequence[MeasuredCircle], circle: Circle) -> Iterator[Notice]:
    for test in tests:
        for name in test.names:
            second = machine.axes[name].second_mass if name in machine.axes else None
            if second is not None and second.encoder == "motor" and test.instrument in ("encoders", ""):
                text = (
                    f"axis {name} has a second mass, and the circle was told by the encoder on its motor: what the "
                    "table does was not measured. Measure it with a grid encoder or a ball bar"
                )
                yield Notice(text, "table-unseen", "doubt")
        yield from _disagreement(machine, test)
    if tests:
        feeds = [max(circle.feed / test.feed, test.feed / circle.feed) for test in tests]
        radii = [max(circle.radius / test.radius, test.radius / circle.radius) for test in tests]
        if min(feeds) > OTHER_FEED or min(radii) > OTHER_FEED:
            text = "no measured circle is near this radius and feed: friction was not seen at its speeds"
            yield Notice(text, "circle-elsewhere", "doubt")


def _disagreement(machine: Machine, test: MeasuredCircle) -> Iterator[Notice]:
    """Yield what is wrong where even the machine that was completed by a circle does not show its glitches."""
    scheme = PAPER_SCHEMES.get(test.scheme or "a")
    if scheme is None:
        return
    try:
        run = run_circle(machine, scheme, Circle(test.radius, test.feed, 2, test.direction))
    except FricError as error:
        yield Notice(f"the machine as it is known cannot run {test.where}: {error.what}", "model-disagrees", "wrong")
        return
    seen, expected = diagnose([test]).glitches, diagnose([measured_from_run(run)]).glitches
    off = {
        name: (seen[name].value, expected[name].value)
        for name in QUADRANTS
        if not np.isclose(seen[name].value, expected[name].value, rtol=SHARE_APART, atol=APART)
    }
    if off:
        microns = {name: (f"{a * 1e6:+.1f}", f"{b * 1e6:+.1f}") for name, (a, b) in off.items()}
        told = "; ".join(f"{name} {a} µm measured, {b} µm simulated" for name, (a, b) in microns.items())
        text = (
            f"{test.where}: the machine does not show the circle that it was made to agree with ({told}): its "
            "controller, its plant or the record is not as stated"
        )
        yield Notice(text, "model-disagrees", "wrong")


def observers_distrust(schemes: Sequence[Scheme], notices: Iterable[Notice]) -> Mapping[str, tuple[Notice, ...]]:
    """Return by scheme with an observer why it must not be trusted: the response was not measured."""
    why = tuple(notice for notice in notices if notice.code in UNSEEN)
    return {scheme.name: why for scheme in schemes if OBSERVER in scheme.blocks and why}
