"""Blocks: what replayed records do not say of a friction model, and pre-sliding of a GMS model."""

from fric.flaws.base import Flaw

LARGE = 0.05  # Share of F_s by which a virgin curve is hollow that only a play makes: a drive that hunts makes less

# fmt: off
PARAMETER_UNSEEN = Flaw("parameter-untold", "doubt",
    "These records do not determine {parameter}{left:: it is left at {left}|}.")
PARAMETER_AT_BOUND = Flaw("parameter-at-bound", "note",
    "{parameter} is at its lower bound, {bound}{no_effect:: these records show no difference|}.")
PARAMETER_AT_EDGE = Flaw("parameter-at-edge", "doubt", "{parameter} is at the edge of what these records can show.")
EXPLAINS_LITTLE = Flaw("explains-little", "doubt", "{model} explains {share:.0%} of the variance of the force.")
NO_STATIC_MAP = Flaw("no-static-map", "doubt", "No static map was given: F_c = F_s = {F_s} from the plateau.",
    "Give `static=` for the Stribeck effect.")
FEWER_BLOCKS = Flaw("fewer-blocks", "note", "{why}")
SINE_TOO_FAST = Flaw("sine-too-fast", "doubt", "Inertia is {share:.0%} of the force: the sine is too fast.",
    "Log it at a frequency lower by {slower:.2g} or more.")
BEGINS_LOADED = Flaw("begins-loaded", "note",
    "The contact was loaded where {records} begin: their first strokes are not compared.")
C_ASSUMED = Flaw("C-assumed", "doubt", "C is assumed to be {C}: {why}.",
    "{logged:|Log a sine on top of a steady speed, so that the axis never reverses: `fric plan` writes its program.}")
C_WITHOUT_PLANT = Flaw("C-without-plant", "doubt",
    "C is identified without a plant: inertia was fitted beside the lag, the drive's delay is unknown.",
    "Give `plant=`.", widens={"C": 1.0})
LEVEL_DIFFERS = Flaw("level-differs", "doubt",
    "Pre-sliding friction is {level:.3f} times the map's F_s: its shape is used, at the map's level.",
    "Record both on one day; check the unit of the force.", widens={"B": 0.03}, circle_settles=True)
LEVEL_OF_ANOTHER = Flaw("level-of-another", "wrong",
    "Pre-sliding friction is {level:.3f} times the map's F_s: are they of two machines, or did it warm?",
    "Record both of one machine in one state, warmed up; check the unit of the force.")
LOST_MOTION = Flaw("lost-motion", lambda f: "wrong" if f.share > LARGE else "doubt",
    "After a reversal the force is flat for {slip:2}, {hollow:2} too low: backlash from drive to encoder.",
    "Remove the backlash, or measure at the table.")
ONE_CYCLE = Flaw("one-cycle", "doubt", "Only one whole cycle was logged: there are no intervals.", "Log five cycles "
    "or more.")
NEVER_SATURATES = Flaw("never-saturates", "doubt",
    "The cycles end before sliding, with {force} at {extent}: {missing} of F_s goes to the last block.",
    "Add a record of {amplitude:2} amplitude or more.")
NEVER_SLIDES = Flaw("never-slides", "wrong",
    "The records never slide: {force} is a lower bound of {names}{slope:, still rising by {slope:.0%}|}.",
    "Log a larger amplitude{amplitude:, {amplitude} or more|}{static:, or give `static=`|}.")
