"""Whether what would be exported may be trusted: by what its files say of themselves, and by a simulated circle."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from fric.control.scheme import NONE
from fric.errors import FricError
from fric.notice import Notice
from fric.simulate.circle import Circle, run_circle
from fric.simulate.contour_run import pair
from fric.verdict.candidates import candidates_of
from fric.verdict.decide import reasons_against as verdict_against
from fric.verdict.evidence import Evidence

if TYPE_CHECKING:
    from fric.control.scheme import Scheme
    from fric.simulate.machine import Machine


def reasons_against(machine: Machine, name: str, scheme: Scheme, notices: Iterable[Notice]) -> list[Notice]:
    """Return why a scheme should not be put on an axis; empty where nothing speaks against it.

    Each warning of severity ``wrong`` in what the machine is made of is a reason. Where the axis is one of a circle's,
    the circle is simulated at 100 and at 10 mm/s: what the verdict has against the scheme at one of them, or a drive
    that saturates, is one too.

    Raises
    ------
    FricError
        When the scheme asks for what the axis does not have, or the loop with it is not stable.
    """
    against = [notice for notice in notices if notice.severity == "wrong"]
    try:
        names = pair(machine)
    except FricError:
        return against
    if name not in names:
        return against
    bare = replace(NONE, gain=None)
    for feed in (0.1, 0.01):
        runs = [run_circle(machine, one, Circle(feed=feed), only=name) for one in (bare, scheme)]
        alone, with_it = candidates_of(runs)
        given = Evidence(candidates=(alone, with_it), resolution=machine.axis(name).encoder.resolution)
        where = f"axis {name} at {1e3 * feed:g} mm/s"
        found = verdict_against(with_it, given)
        against += [Notice(f"{where}: {text}", text.code, text.severity) for text in found]
        if with_it.warnings and not alone.warnings:
            against.append(Notice(f"{where}: {with_it.warnings[0]}", "scheme-saturates", "wrong"))
    return against
