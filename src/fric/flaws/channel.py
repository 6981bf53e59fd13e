"""Channel: what is logged of force and input."""

from fric.flaws.base import Flaw

# fmt: off
FORCE_CLIPPED = Flaw("force-clipped", "wrong",
    "The force is clipped in {samples} samples: what lies beyond is missing.", "Log with a larger range of the trace.",
    widens={"level": 0.1})
INPUT_CLIPPED = Flaw("input-clipped", "wrong",
    "The input is clipped in {samples} samples: what lies beyond is missing.", "Log with a larger range of the trace.")
CLIPPED_UNUSED = Flaw("clipped-unused", "doubt",
    "The force is clipped in {counted}: {left_out:these records are left out|these samples are not compared}.",
    "Log with a larger range of the trace.", widens={"level": 0.1})
DRIVE_OFF = Flaw("drive-off", "note",
    "The drive is off for {share:.0%} of {records}: the force is exactly 0 while the axis rests. That is left out.")
FORCE_COARSE = Flaw("force-coarse", "doubt",
    "The force comes in steps of {step}: forces are off by up to half a step.", "Log it finer.")
ONE_DIRECTION = Flaw("one-direction", "doubt",
    "Only one direction was measured: an offset cannot be distinguished from Coulomb friction.",
    "Log strokes in both directions.")
FORCE_TURNED = Flaw("force-turned", "wrong", "Forward strokes took less force than backward ones: by these signs "
    "friction drives the axis, and the map means nothing.",
    "Turn the force's `sign:` in the mapping, and ingest again.")
DEAD_ZONE = Flaw("dead-zone", "wrong", "Inputs within ±{zone:2} make no force (a dead zone): K_f and B are too "
    "small. Beyond it the force rises by {slope}.", "Take it out of the drive, or excite more strongly.",
    widens={"K_f": 0.05, "B": 0.05})
K_F_DIFFERS = Flaw("K_f-differs", "wrong",
    "K_f was given as {given}, and the logged force is {found} times the input.",
    "Check the scales of force and input.", widens={"K_f": 0.1})
K_F_MISSING = Flaw("K_f-missing", "note", "K_f is not known: no record has force and input both.",
    "Give strokes that have both, or K_f with --force-constant.")
MASS_DIFFERS = Flaw("mass-differs", "wrong", "K_f/B is {found}, and the moving mass was stated as {stated}.",
    "Check the scales of force, input and position, and the mass.", widens={"B": 0.1})
FORCE_RESPONSE_MISSING = Flaw("force-response-missing", "doubt",
    "There is no response of force to input ({why}): the record has no part in K_f.", widens={"K_f": 0.1})
FORCE_NOT_PROPORTIONAL = Flaw("force-not-proportional", "doubt", "Force is not proportional to input: {segments} "
    "steady means are {off:.0%} of their range off a line, whose slope is K_f.",
    "Check that the force is measured at the motor.")
