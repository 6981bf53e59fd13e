"""What a circle test cannot tell, however well it was measured."""

from collections.abc import Mapping, Sequence
from math import degrees

import numpy as np

from fric.estimate import Estimate
from fric.identify.circle.measured import MeasuredCircle
from fric.identify.circle.revolutions import Revolutions
from fric.notice import Notice


def identifiability_warnings(
    tests: Sequence[MeasuredCircle],
    circles: Sequence[Revolutions],
    geometry: Mapping[str, Estimate],
    both: bool,
    behind: Sequence[Mapping[str, float]],
    largest: float,
) -> tuple[Notice, ...]:
    """Return what the tests leave open: squareness, backlash, scale, scatter, glitches that do not end.

    Parameters
    ----------
    tests, circles
        The tests, and their revolutions.
    geometry
        What was fitted.
    both
        Whether both directions were measured.
    behind
        Per test and quadrant, up to what angle behind the reversal a glitch was seen [rad].
    largest
        Up to what angle it was looked for [rad].
    """
    test, warnings = tests[0], []
    if not both:
        warnings.append(_one_direction(test, float(geometry["mismatch"])))
    elif test.instrument == "encoders":
        text = "the axes' own encoders cannot see squareness: what is told of it is of their loops"
        warnings.append(Notice(text, "squareness-unseen", "note"))
    moved = [name for name in test.names if not _holds_zero(geometry[f"backlash.{name}"])]
    if moved:
        warnings.append(_lost_motion(test, moved, bool(circles[0].errors)))
    if test.is_ball_bar:
        text = (
            "a ball bar alone tells no lag of an axis, and scale only as far as its own length is calibrated: an error "
            "of its length moves both scales alike"
        )
        warnings.append(Notice(text, "ball-bar-length", "note"))
    if min(one.count for one in circles) < 2:
        text = "there is one whole revolution: what does not repeat is not told from what does"
        warnings.append(Notice(text, "one-revolution", "note"))
    wide = sorted({name for of in behind for name, angle in of.items() if angle >= largest - 1e-6})
    if wide:
        text = (
            f"the glitch at {', '.join(wide)} has not ended {degrees(largest):.0f}° behind the reversal: a part of it "
            "may be told as backlash, scale or mismatch. Measure at a lower feed or a larger radius"
        )
        warnings.append(Notice(text, "glitch-does-not-end", "doubt"))
    return tuple(warnings)


def _holds_zero(estimate: Estimate) -> bool:
    limits = np.ravel(estimate.ci95 if estimate.ci95 is not None else (-np.inf, np.inf))
    return bool(limits.min() <= 0.0 <= limits.max())


def _lost_motion(test: MeasuredCircle, moved: Sequence[str], with_reference: bool) -> Notice:
    what = "a ball bar" if test.is_ball_bar else "a circle"
    text = (
        f"a step that stays after the reversal of {' and '.join(moved)}: it is backlash or wind-up of the drive where "
        "position is measured at the table, and an error that the loop keeps (friction without an integral part, or "
        f"one that is slow) where it is the loop's own encoder; {what} alone does not tell which"
    )
    if not with_reference:
        text += ". Record the reference and the axis' own position beside it"
    return Notice(text, "lost-motion-cause", "note")


def _one_direction(test: MeasuredCircle, ellipse: float) -> Notice:
    size = f"{abs(ellipse) * 1e6:.2f} µm"
    if test.instrument == "encoders":
        return Notice(
            f"the ellipse at ±45° ({size}) is all taken for a mismatch of the loops: the axes' own encoders cannot see "
            "squareness",
            "squareness-unseen", "note",
        )  # fmt: skip
    return Notice(
        f"one direction alone does not tell a mismatch of the loops from squareness: the ellipse at ±45° ({size}) is "
        "the sum of both, and is given as mismatch with an open interval. Measure the other direction too"
        + ("" if test.is_ball_bar else "; or say --instrument encoders, if the position is of the axes' own encoders"),
        "mismatch-or-squareness", "doubt",
    )  # fmt: skip
