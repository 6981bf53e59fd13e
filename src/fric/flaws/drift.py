"""Drift: what changes with time, from record to record and with direction."""

from typing import Any

from fric.flaws.base import Flaw, by_size
from fric.notice import Severity


def _severity(f: Any) -> Severity:
    found = by_size(f.change * f.level, f.level, f.half_width)
    return found if f.sure and (f.clocked or found != "note") else "doubt"


# fmt: off
FORCE_DRIFTS = Flaw("force-drifts", _severity,
    "The force {rate:rises|falls} by {change:.2g%} over the records, {a_minute:.2g%} a minute within "
    "strokes{clocked:| and more in pauses}.",
    "Friction or force constant {sure:drifts|may drift}: run the axis warm first, and log the speeds in another "
    "order, each again.", widens={"level": 0.08}, circle_settles=True)
ENERGY_DRIFTS = Flaw("energy-drifts", "doubt",
    "The energy lost per cycle changes by {change:+.1%} (± {half:.1%}) over the record.",
    "Warm the axis up, and log again.", widens={"level": 0.08})
ENERGY_IN_ONE_SEGMENT = Flaw("energy-in-one-segment", "doubt",
    "The energy lost per cycle is {there} from {begin:.4g} to {end:.4g} s, and {elsewhere} in the rest.",
    "Check the axis (chips, lubrication, cables), or leave this part out.")
SLIGHT = 0.01  # Share of the friction below which what differs with the motion is a note: so much any model misses
NOT_ONE = 0.5  # Share of the friction by which records of one axis do not differ: the mean of two axes is of neither
RECORDS_VARY = Flaw("records-vary",
    lambda v: "doubt" if not v.motions or SLIGHT <= v.scatter <= NOT_ONE else "note" if v.scatter < SLIGHT else "wrong",
    "{within:Quarters of the record|Records} differ: {by} (standard deviation). In their order: {order}.",
    "Intervals are of the mean over them, and allow for it.{one_speed: Each holds one speed: log several in each, "
    "which separates records from friction over speed.|}{motions: Their motions differ, too: log each twice, "
    "which shows whether friction changed or the model misses a motion.|}")
FRICTION_DIFFERS = Flaw("friction-differs", "doubt",
    "Curves of two records differ by {by:2} where they meet: friction changed, or GMS does not fit it.")
REST_RAISES_FRICTION = Flaw("rest-raises-friction", "wrong",
    "Where records meet, the slower is {by:2} higher: friction grows with rest, or fell meanwhile.",
    "Log both amplitudes at one mean speed, in turn, and the static map down to that speed.")
FRICTION_AGES = Flaw("friction-ages", "wrong",
    "Static friction grows by {rise:2} with each tenfold rest: after a long rest F_s is too small.",
    "Log strokes as slow as the axis moves at work, and break-away after rests.")
DIRECTIONS_DIFFER = Flaw("directions-differ", "wrong",
    "Friction differs between the directions by up to {by:2}: a common map fits neither.",
    "Identify again with `direction='each'`, and with `load=` where you know the weight.",
    widens={"level": 0.05}, circle_settles=True)
OFFSET_SHARED = Flaw("offset-shared", lambda f: "wrong" if f.differ else "note",
    "Both directions share {offset}: taken for an offset (gravity, amplifier bias), but may be friction.",
    "Give `load=` where you know it.")
