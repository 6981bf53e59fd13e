"""What contours tell besides the verdict, in words that follow from the numbers. One rule a function."""

from collections.abc import Sequence
from math import degrees, sqrt

import numpy as np

from fric.circles.next_circle import wrong_shape
from fric.control.scheme import OBSERVER
from fric.report.report_input import Contour, ContourTest
from fric.units import readable
from fric.verdict.decide import EARNED
from fric.verdict.evidence import Candidate, bare

SAME_SIGN_LEFT = 0.1
"""Share of the glitch that a feedforward of the whole friction may leave before it is called too weak."""

UNEVEN = 1.3
"""Ratio of the glitches of two axes, or of the two ends of one, from which they are called different."""


def observations(test: ContourTest, presliding: float | None = None) -> list[str]:
    """Return what the contours of one test tell besides the verdict, of differences that count.

    test: What each scheme leaves of one contour.
    presliding: Displacement over which friction builds up after a reversal [m], where a friction file tells it.
    """
    found = [*overcompensation(test), *too_weak(test.contours), *observer_share(test), *observer_spoils(test)]
    found += [*uneven(test), *learned_says(test.contours)]
    if presliding is not None and test.radius is not None:
        found.append(build_up(presliding, test.radius, test.feed))
    return found


def least(test: ContourTest) -> float:
    """Return the least difference of two glitches that is spoken of [m]: of what is worth effort, encoder, and chance.

    The share of the largest glitch where the bare loop was not run.
    """
    without = bare(test.contours)
    size = max(one.glitch for one in test.contours) if without is None else without.glitch
    by_chance = max((one.chance.half for one in test.contours), default=0.0)
    return max(EARNED * size, float(test.provenance.get("resolution", 0.0)), by_chance)


def peak(contour: Candidate) -> float:
    """Return the glitch with its sign [m]: outwards is positive."""
    return max(contour.glitches, key=abs, default=0.0)


def overcompensation(test: ContourTest) -> list[str]:
    """Tell of friction feedforward that leaves an inward spike where the bare loop has an outward one."""
    contours, without = test.contours, bare(test.contours)
    if without is None:
        return []
    reversed_signs = [
        one for one in contours if one.scheme.friction and peak(one) * peak(without) < 0 and one.glitch > least(test)
    ]
    static = [one for one in reversed_signs if one.scheme.friction == "static"]
    said = [
        f"{one.named} overcompensates: its spike of {readable(abs(peak(one)), 'm')} points the other way. The friction "
        "that is fed forward is larger than the true one: lower its gain or identify again."
        for one in reversed_signs
        if one not in static
    ]
    if static:
        spikes = " and ".join(f"{one.named} ({readable(abs(peak(one)), 'm')})" for one in static)
        text = (
            f"{spikes} overcompensate{'s' if len(static) == 1 else ''}: the spike points the other way. A static map "
            "switches at the reversal at once, and true friction builds up over the pre-sliding."
        )
        follows = [one for one in contours if one.scheme.friction not in {None, "static"} and not one.scheme.observer]
        if follows and follows[0].glitch < static[0].glitch:
            text += f" {follows[0].named}, which follows that, leaves {readable(follows[0].glitch, 'm')}."
        said.insert(0, text)
    return said


def too_weak(contours: Sequence[Contour]) -> list[str]:
    """Tell of a feedforward with pre-sliding that leaves a part of the glitch, with the same sign at every reversal.

    The glitch of a linear loop is proportional to the friction that is not fed forward, so the share that is left
    is the share that the feedforward lacks.
    """
    without = bare(contours)
    if without is None or not without.glitch:
        return []
    for one in contours:
        if one.scheme.friction in {None, "static"} or one.scheme.observer:
            continue
        left = one.glitch / without.glitch
        same = all(a * b > 0 for a, b in zip(one.glitches, without.glitches, strict=True))
        if same and left > SAME_SIGN_LEFT:
            return [
                f"{one.named} leaves {left:.0%} of the glitch with the same sign at every reversal: it feeds forward "
                f"about {1 - left:.0%} of the friction. Raise its gain, or identify again if the logs are old."
            ]
    return []


def learned_says(contours: Sequence[Contour]) -> list[str]:
    """Tell of a friction model whose shape is wrong: a circle that was learned leaves clearly less."""
    texts = wrong_shape((one.scheme, one.glitch) for one in contours)
    return [f"{text[0].upper()}{text[1:]}." for text in texts]


def _pairs(contours: Sequence[Contour]) -> list[tuple[Contour, Contour]]:
    """Return each feedforward without and with the observer."""
    cascades = [one for one in contours if one.scheme.controller == "cascade"]
    with_observer = {one.scheme.friction: one for one in cascades if one.scheme.blocks == (OBSERVER,)}
    alone = [one for one in cascades if not one.scheme.blocks and one.scheme.friction in with_observer]
    return [(one, with_observer[one.scheme.friction]) for one in alone]


def observer_share(test: ContourTest) -> list[str]:
    """Tell how much the observer takes off each feedforward."""
    parts = [
        f"{1 - with_it.glitch / alone.glitch:.0%} off "
        + ("the bare loop" if alone.scheme.friction is None else alone.named)
        for alone, with_it in _pairs(test.contours)
        if alone.glitch - with_it.glitch > least(test)
    ]
    return [f"The disturbance observer takes {', '.join(parts)}."] if parts else []


def observer_spoils(test: ContourTest) -> list[str]:
    """Tell of an observer that makes a feedforward worse."""
    return [
        f"With the observer, {alone.named} gets worse by {readable(with_it.glitch - alone.glitch, 'm')}: does the "
        "observer see the feedforward? It must be given the control voltage without it, or friction is compensated "
        "twice."
        for alone, with_it in _pairs(test.contours)
        if with_it.glitch - alone.glitch > least(test)
    ]


def uneven(test: ContourTest) -> list[str]:
    """Tell which axis, and which of its two reversals, the glitch of the bare loop is from."""
    without = bare(test.contours)
    if without is None or test.radius is None:
        return []
    size = np.abs(without.glitches)
    first, second = float(size[[0, 2]].max()), float(size[[1, 3]].max())
    both = len(test.axes) == 2
    said = []
    if both and max(first, second) > UNEVEN * min(first, second):
        larger, lesser = ("x", "y") if first > second else ("y", "x")
        said.append(
            f"Axis {larger} has the larger glitch without compensation, {readable(max(first, second), 'm')} against "
            f"{readable(min(first, second), 'm')} of axis {lesser}: begin there."
        )
    for axis, ends in (("x", (0, 2)), ("y", (1, 3))):
        if axis not in test.axes:
            continue
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
