"""Static map: what strokes at constant velocity do not say of friction over speed, and what the place adds."""

from math import inf
from typing import Any

from fric.flaws.base import Flaw, by_size
from fric.notice import Severity

REMOVED = 0.05  # Subtracted share of friction up to which nothing is to be done: beyond, it widens a prediction
SCATTERED = 0.1  # Scatter between strokes, as a share of their force, above which a map of speed is doubted
ANOTHER = 0.5  # The same above which strokes cannot be of one axis
LEVELS = 1.3  # Ratio of two levels of strokes of the same speeds from which on they cannot either
SMALL, LARGE = 0.01, 0.1
"""Subtracted share of friction up to which there is no doubt, and above which the result is wrong."""
STICKS = 0.6  # Swing of the speed above which the axis rests during a stroke: its mean force belongs to no velocity


def _severity(f: Any) -> Severity:
    if f.taken_off:  # what is left of it is in the intervals
        return "note" if float(f.varies) <= REMOVED * abs(f.level) else "doubt"
    return by_size(float(f.varies), f.level, f.half_width)


# fmt: off
FORCE_OVER_POSITION = Flaw("force-over-position", _severity,
    "Force depends on position: {varies:2} over {length:2} (cogging, cable{either:, friction|}?).",
    "{taken_off:Removed; nothing to do.|Log each speed over the same whole stroke: the map is of these places.}",
    widens={"level": 0.05}, circle_settles=True)
FRICTION_OVER_POSITION = Flaw("friction-over-position",
    lambda f: "note" if float(f.varies) <= REMOVED * abs(f.level) < inf else "doubt",
    "Friction depends on position: ±{share:.2g%} over {length:2} (rollers, alignment?).",
    "{taken_off:The map is its mean: elsewhere the glitch differs.|"
    "Log each speed over the same whole stroke: the map is of these places.}",
    widens={"level": "share"}, circle_settles=True)
FORCE_ALONG_AXIS = Flaw("force-along-axis", "note",
    "The force rises by {rises} over {length} (spring, cable, tilt): removed; the offset is at {middle}.")
FALL_NOT_SEEN = Flaw("fall-not-seen", "doubt",
    "No fall with speed from {slowest} up (held out: {plain} without, {falling} with): F_s = F_c is assumed.",
    "Log slower strokes, or force the fall with `form='stribeck'`.", widens={"v_s": 0.5})
FALL_OPEN = Flaw("fall-open", "doubt",
    "The strokes do not determine F_s and v_s: the slowest, {slowest}, is too fast, or they scatter.",
    "Log slower strokes.", widens={"v_s": 0.5})
F_S_EXTRAPOLATED = Flaw("F_s-extrapolated", "wrong",
    "{below:.0%} of the fall is below the slowest stroke ({slowest}): F_s continues eq. (2) from {lowest}.",
    "Log slower strokes, or a finer encoder.")
F_C_AT_BOUND = Flaw("F_c-at-bound", "wrong", "F_c is 0, its bound: friction still falls at the fastest stroke.",
    "Log faster strokes, or take Coulomb plus viscous friction with `form='coulomb'`.",
    widens={"level": 0.2, "v_s": 0.5}, circle_settles=True)
STROKES_STAND_OFF = Flaw("strokes-stand-off", lambda f: "doubt" if f.share > SCATTERED else "note",
    "Strokes deviate by up to {most:2} and weigh less: {strokes}. A slow axis may stick between two counts.",
    "Look at their records. In logs slower than the loop, speeds of whole counts a sample err alike: log others, too.")
STROKES_SCATTER = Flaw("strokes-scatter",
    lambda f: "wrong" if f.share > ANOTHER or f.levels > LEVELS else "doubt" if f.share > SCATTERED else "note",
    "Strokes scatter by {spread:2} beyond noise, {two:at two levels {levels:.2g} times apart: intervals|{share:.2g%} "
    "of the force: weights and intervals} allow for it.",
    "{large:Are they of two machines? Friction that does not repeat, play, a hunting axis are no map of speed.|}")
STROKES_IN_PRESLIDING = Flaw("strokes-in-presliding", "doubt",
    "At {speeds} the force still rises when strokes end: they do not slide, and are left out.",
    "Log longer strokes.", widens={"v_s": 0.3})
STROKES_SETTLING = Flaw("strokes-settling",
    lambda f: "note" if f.share < SMALL else "doubt" if f.share < LARGE else "wrong",
    "In {strokes} strokes from {slowest:2} to {fastest:2} the force settles: up to {most:2} removed (C = {C:2}).",
    "Log longer strokes.", widens={"v_s": 0.3}, circle_settles=True)
STROKES_SWING = Flaw("strokes-swing", lambda f: "doubt" if f.most > STICKS else "note",
    "{several:{strokes} strokes {speeds} swing|A stroke {speeds} swings} by up to {most:.0%} "
    "(rms){sticks:, some stick|}: allowed for.")
RESIDUALS_FOLLOW_SPEED = Flaw("residuals-follow-speed", "doubt", "Eq. (2) does not describe these strokes: residuals "
    "{smooth:follow the speed|are the same in both directions, {missed} (rms)}.",
    "`method` in the file says which forms were tried. Look at the figure.", widens={"v_s": 0.2, "C": 0.2})
DAMPING_TOO_LARGE = Flaw("damping-too-large", "wrong",
    "The plant's damping of {damping} is {beyond} larger than the strokes show.",
    "The axis reversed while it was excited, the strokes differ, or one is of another axis. Excite it one way.",
    widens={"A": 0.2, "level": 0.05})
SIGMA_IN_A = Flaw("sigma-in-A", "note", "sigma is 0: the plant's damping, {damping}, includes viscous friction.",
    word=("sigma", "included in A"))
ONE_SPEED = Flaw("one-speed", "doubt", "Only one speed was logged ({speed}): the friction there is given, and no map.",
    "Log strokes at ten speeds.")
RECORDS_WITHOUT_STROKE = Flaw("records-without-stroke", lambda f: "doubt" if 4 * f.without > f.records else "note",
    "{without} of {records} records give no stroke: {why}.")
ROWS_AT_REST = Flaw("rows-at-rest", "note",
    "{rows} rows are at rest, where friction has no unique value: they are left out.")
ERRORS_OF_MEANS = Flaw("errors-of-means", "note", "{why}.")
