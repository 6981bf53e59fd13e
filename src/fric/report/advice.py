"""Which compensation to use and why, in words that follow from the numbers. One rule a function, none knows a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees, sqrt
from typing import TYPE_CHECKING

import numpy as np

from fric.control.scheme import OBSERVER
from fric.units import readable

if TYPE_CHECKING:
    from fric.control.scheme import Scheme
    from fric.report.report_input import Contour, ContourTest

EARNED = 0.05
"""Share of the uncompensated glitch by which a scheme must be better before its further effort is worth it."""

SAME_SIGN_LEFT = 0.1
"""Share of the glitch that a feedforward of the whole friction may leave before it is called too weak."""

UNEVEN = 1.3
"""Ratio of the glitches of two axes, or of the two ends of one, from which they are called different."""


@dataclass(frozen=True)
class Advice:
    """What to do, and the reasons for it.

    Parameters
    ----------
    choice
        The scheme that is advised; None where the numbers do not tell.
    headline
        The advice in a sentence.
    reasons
        What it rests on, and what the numbers tell besides.
    """

    choice: Scheme | None
    headline: str
    reasons: tuple[str, ...]


def advise(test: ContourTest, presliding: float | None = None) -> Advice:
    """Return which of the schemes of one test to use, and why.

    Parameters
    ----------
    test
        What each scheme leaves of one contour.
    presliding
        Displacement over which friction builds up after a reversal [m], where a friction file tells it.
    """
    contours = test.contours
    chosen = choose(contours)
    bare = uncompensated(contours)
    left = readable(chosen.glitch, "m")
    if bare is None:
        headline = f"Use {named(chosen)}: of the schemes that were run it leaves the least that counts, {left}."
    elif chosen is bare:
        headline = f"Leave it as it is: no scheme that was run takes a worthwhile part off the {left} of the bare loop."
    else:
        headline = (
            f"Use {named(chosen)}: it leaves a glitch of {left}, "
            f"{1 - chosen.glitch / bare.glitch:.0%} less than the {readable(bare.glitch, 'm')} without compensation."
        )
    reasons = [
        *on_many_machines(contours, chosen),
        effort(contours, chosen),
        *overcompensation(contours),
        *too_weak(contours),
    ]
    reasons += [*observer_share(contours), *observer_spoils(contours), *uneven(test)]
    if presliding is not None and test.radius is not None:
        reasons.append(build_up(presliding, test.radius, test.feed))
    return Advice(chosen.scheme, headline, tuple(reason for reason in reasons if reason))


def named(contour: Contour) -> str:
    """Return how a scheme is called in a sentence."""
    return f"({contour.scheme.name}) {contour.scheme.title}"


def uncompensated(contours: Sequence[Contour]) -> Contour | None:
    """Return the contour without any compensation."""
    return next((one for one in contours if one.scheme.bare), None)


def demand(scheme: Scheme) -> int:
    """Return how much a scheme asks for: 1 for a static map or a control block, 2 for a model with pre-sliding."""
    model = 0 if scheme.friction is None else 1 if scheme.friction == "static" else 2
    return model + len(scheme.blocks) + int(scheme.controller != "cascade")


def counted(contour: Contour, contours: Sequence[Contour]) -> float:
    """Return the glitch that schemes are compared by [m].

    The upper limit of the interval where every scheme has one: what 95 % of the machines that were drawn stay under,
    or nearly. The glitch of the one machine otherwise.
    """
    if any(one.glitch_ci95 is None for one in contours) or contour.glitch_ci95 is None:
        return contour.glitch
    return contour.glitch_ci95[1]


def tolerance(contours: Sequence[Contour]) -> float:
    """Return by how much two glitches must differ to count [m]: `EARNED` of that without compensation.

    Of the largest, where the bare loop was not run.
    """
    bare = uncompensated(contours)
    return EARNED * (max(one.glitch for one in contours) if bare is None else bare.glitch)


def choose(contours: Sequence[Contour]) -> Contour:
    """Return the scheme that asks for the least among those that are as good as the best, within the tolerance."""
    least = min(counted(one, contours) for one in contours)
    good = [one for one in contours if counted(one, contours) <= least + tolerance(contours)]
    return min(good, key=lambda one: (demand(one.scheme), counted(one, contours)))


def effort(contours: Sequence[Contour], chosen: Contour) -> str:
    """Tell what a scheme that asks for more or for less would change."""
    counts = readable(tolerance(contours), "m", 2)
    best = min(contours, key=lambda one: one.glitch)
    if best is not chosen:
        return (
            f"{named(best)} leaves {readable(best.glitch, 'm')}, {readable(chosen.glitch - best.glitch, 'm', 2)} less, "
            f"which is under the {counts} that count here: it is not worth what it asks for besides."
        )
    simpler = [one for one in contours if 0 < demand(one.scheme) < demand(chosen.scheme)]
    if not simpler:
        return ""
    next_best = min(simpler, key=lambda one: one.glitch)
    return (
        f"The best scheme that asks for less, {named(next_best)}, leaves {readable(next_best.glitch, 'm')}: "
        f"{readable(next_best.glitch - chosen.glitch, 'm', 2)} more, and {counts} count here."
    )


def on_many_machines(contours: Sequence[Contour], chosen: Contour) -> list[str]:
    """Tell what the scheme leaves on the machines that were drawn around this one."""
    if chosen.glitch_ci95 is None:
        return []
    low, high = (readable(limit, "m") for limit in chosen.glitch_ci95)
    text = f"On 95 % of the machines that were drawn around this one, {named(chosen)} leaves between {low} and {high}"
    by_limit = all(one.glitch_ci95 is not None for one in contours)
    return [text + ("; schemes are compared by that upper limit." if by_limit else ".")]


def peak(contour: Contour) -> float:
    """Return the glitch with its sign [m]: outwards is positive."""
    return max(contour.glitches, key=abs, default=0.0)


def overcompensation(contours: Sequence[Contour]) -> list[str]:
    """Tell of friction feedforward that leaves an inward spike where the bare loop has an outward one."""
    bare = uncompensated(contours)
    if bare is None:
        return []
    turned = [one for one in contours if one.scheme.friction and peak(one) * peak(bare) < 0]
    said = []
    for one in turned:
        text = f"{named(one)} overcompensates: its spike of {readable(abs(peak(one)), 'm')} points the other way. "
        if one.scheme.friction == "static":
            text += "A static map switches at the reversal at once, and true friction builds up over the pre-sliding."
            better = [
                other
                for other in contours
                if other.scheme.friction not in {None, "static"}
                and other.scheme.observer == one.scheme.observer
                and other.glitch < one.glitch
            ]
            if better:
                text += f" {named(better[0])}, which follows that, leaves {readable(better[0].glitch, 'm')}."
        else:
            text += "The friction that is fed forward is larger than the true one: lower its gain or identify again."
        said.append(text)
    return said


def too_weak(contours: Sequence[Contour]) -> list[str]:
    """Tell of a feedforward with pre-sliding that leaves a part of the glitch, with the same sign at every reversal.

    The glitch of a linear loop is proportional to the friction that is not fed forward, so the share that is left
    is the share that the feedforward lacks.
    """
    bare = uncompensated(contours)
    if bare is None or not bare.glitch:
        return []
    for one in contours:
        if one.scheme.friction in {None, "static"} or one.scheme.observer:
            continue
        left = one.glitch / bare.glitch
        same = all(a * b > 0 for a, b in zip(one.glitches, bare.glitches, strict=True))
        if same and left > SAME_SIGN_LEFT:
            return [
                f"{named(one)} leaves {left:.0%} of the glitch with the same sign at every reversal, as a feedforward "
                f"of about {1 - left:.0%} of the true friction would: friction has risen since it was identified, or "
                "the gain is low. Identify again before anything else is tuned."
            ]
    return []


def _pairs(contours: Sequence[Contour]) -> list[tuple[Contour, Contour]]:
    """Return each feedforward without and with the observer."""
    cascades = [one for one in contours if one.scheme.controller == "cascade"]
    with_observer = {one.scheme.friction: one for one in cascades if one.scheme.blocks == (OBSERVER,)}
    alone = [one for one in cascades if not one.scheme.blocks and one.scheme.friction in with_observer]
    return [(one, with_observer[one.scheme.friction]) for one in alone]


def observer_share(contours: Sequence[Contour]) -> list[str]:
    """Tell how much the observer takes off each feedforward."""
    parts = [
        f"{1 - with_it.glitch / alone.glitch:.0%} off "
        + ("the bare loop" if alone.scheme.friction is None else named(alone))
        for alone, with_it in _pairs(contours)
        if alone.glitch - with_it.glitch > tolerance(contours)
    ]
    return [f"The disturbance observer takes {', '.join(parts)}."] if parts else []


def observer_spoils(contours: Sequence[Contour]) -> list[str]:
    """Tell of an observer that makes a feedforward worse."""
    return [
        f"With the observer, {named(alone)} gets worse by {readable(with_it.glitch - alone.glitch, 'm')}: does the "
        "observer see the feedforward? It must be given the control voltage without it, or friction is compensated "
        "twice."
        for alone, with_it in _pairs(contours)
        if with_it.glitch - alone.glitch > tolerance(contours)
    ]


def uneven(test: ContourTest) -> list[str]:
    """Tell which axis, and which of its two reversals, the glitch of the bare loop is from."""
    bare = uncompensated(test.contours)
    if bare is None or test.radius is None:
        return []
    size = np.abs(bare.glitches)
    first, second = float(size[[0, 2]].max()), float(size[[1, 3]].max())
    said = []
    if max(first, second) > UNEVEN * min(first, second):
        larger, lesser = ("x", "y") if first > second else ("y", "x")
        said.append(
            f"Axis {larger} has the larger glitch without compensation, {readable(max(first, second), 'm')} against "
            f"{readable(min(first, second), 'm')} of axis {lesser}: begin there."
        )
    for axis, ends in (("x", (0, 2)), ("y", (1, 3))):
        one, other = float(size[ends[0]]), float(size[ends[1]])
        if max(one, other) > UNEVEN * min(one, other):
            said.append(
                f"Axis {axis} shows {readable(one, 'm')} at +{axis} and {readable(other, 'm')} at -{axis}: its "
                "friction depends on direction or place. Identify with --direction each."
            )
    return said


def build_up(presliding: float, radius: float, feed: float) -> str:
    """Tell how long after a reversal friction builds up.

    Near a reversal of a circle the axis moves as z = v²t²/(2R) = R·φ²/2, so a displacement z is reached at the angle
    φ = √(2z/R), after the time √(2zR)/v.
    """
    angle, time = sqrt(2 * presliding / radius), sqrt(2 * presliding * radius) / feed
    return (
        f"Friction builds up over {readable(presliding, 'm')} of pre-sliding. On this circle that is the first "
        f"{degrees(angle):.2g}° after each reversal, {readable(time, 's', 2)}: what a static map cannot follow."
    )
