"""What a circle test cannot tell, however well it was measured."""

from collections.abc import Mapping, Sequence
from math import degrees

import numpy as np

from fric.circles.measured import MeasuredCircle
from fric.circles.revolutions import Revolutions
from fric.estimate import Estimate
from fric.flaws import circle
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

    tests, circles: The tests, and their revolutions.
    geometry: What was fitted.
    both: Whether both directions were measured.
    behind: Per test and quadrant, up to what angle behind the reversal a glitch was seen [rad].
    largest: Up to what angle it was looked for [rad].
    """
    test, warnings = tests[0], []
    if not both:
        warnings.append(_one_direction(test, float(geometry["mismatch"])))
    elif test.instrument == "encoders":
        warnings.append(circle.SQUARENESS_UNSEEN.found(ellipse=None))
    moved = [name for name in test.names if not _holds_zero(geometry[f"backlash.{name}"])]
    if moved:
        warnings.append(circle.LOST_MOTION_CAUSE.found(axes=" and ".join(moved), reference=bool(circles[0].errors)))
    if test.is_ball_bar:
        warnings.append(circle.BALL_BAR_LENGTH.found())
    if min(one.count for one in circles) < 2:
        warnings.append(circle.ONE_REVOLUTION.found())
    wide = sorted({name for of in behind for name, angle in of.items() if angle >= largest - 1e-6})
    if wide:
        warnings.append(circle.GLITCH_DOES_NOT_END.found(quadrants=wide, degrees=degrees(largest)))
    return tuple(warnings)


def _holds_zero(estimate: Estimate) -> bool:
    limits = np.ravel(estimate.ci95 if estimate.ci95 is not None else (-np.inf, np.inf))
    return bool(limits.min() <= 0.0 <= limits.max())


def _one_direction(test: MeasuredCircle, ellipse: float) -> Notice:
    size = Estimate(abs(ellipse), "m")
    if test.instrument == "encoders":
        return circle.SQUARENESS_UNSEEN.found(ellipse=size)
    return circle.MISMATCH_OR_SQUARENESS.found(ellipse=size, ball_bar=test.is_ball_bar)
