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

if TYPE_CHECKING:
    from fric.control.scheme import Scheme
    from fric.simulate.machine import Machine


def reasons_against(machine: Machine, name: str, scheme: Scheme, notices: Iterable[Notice]) -> list[Notice]:
    """Return why a scheme should not be put on an axis; empty where nothing speaks against it.

    Each warning of severity ``wrong`` in what the machine is made of is a reason. Where the axis is one of a circle's,
    the circle is simulated at 100 and at 10 mm/s: a scheme that leaves more than the controller alone at one of them,
    or saturates, is one too.

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
        alone, with_it = (run_circle(machine, one, Circle(feed=feed), only=name) for one in (bare, scheme))
        before, after = alone.circularity.glitch, with_it.circularity.glitch
        if after > before + 2 * machine.axis(name).encoder.resolution:
            text = (
                f"at {1e3 * feed:g} mm/s scheme {scheme.name} leaves {1e6 * after:.1f} µm on axis {name}, and the "
                f"controller alone {1e6 * before:.1f} µm"
            )
            against.append(Notice(text, "scheme-spoils", "wrong"))
        if with_it.warnings and not alone.warnings:
            against.append(Notice(f"at {1e3 * feed:g} mm/s {with_it.warnings[0]}", "scheme-saturates", "wrong"))
    return against
