"""Channels: when samples were taken, what they hold of force and input, what the position resolves."""

from fric.flaws.base import Flaw

BELOW_SCATTER = 0.005  # Share of lost samples up to which errors of speeds and times are below their scatter
LITTLE = 0.05  # Jitter in sampling intervals up to which interpolation between samples makes as large an error

# fmt: off
SAMPLES_LOST = Flaw("samples-lost", lambda f: "wrong" if f.lost > BELOW_SCATTER else "doubt",
    "{lost:.2g%} of the samples were lost and the time axis ignores them: speeds and times are wrong.",
    "Log at a lower rate or fewer channels, or with the time of each sample.", widens={"T_d": 0.1, "C": 0.5})
SAMPLING_JITTERS = Flaw("sampling-jitters",
    lambda f: "doubt" if f.purpose in ("static", "inspect") or f.share < LITTLE else "wrong",
    "Samples are {jitter} (rms) off the logged time: noise of {displaced}, which grows with speed.",
    "Log by the clock of the control, or the time of each sample.", widens={"T_d": 0.1, "C": 0.5})
SAMPLING_DIFFERS = Flaw("sampling-differs", "doubt",
    "Samples are {interval} apart, those of other records {usual}: is the time in ms, and read as s?",
    "Say the unit of time of each file in a mapping.")
SAMPLING_UNEVEN = Flaw("sampling-uneven", "note",
    "{missing} of {samples} samples are missing, others up to {off:.0%} of a sample off: evened by a cubic.")
FORCE_LAGS = Flaw("force-lags", "note",
    "The force is logged {lag} ({samples:.2g} samples) {late:later|earlier} than the input{corner:, {corner} by a "
    "filter|}: shifted.", widens={"C": 0.3})
FORCE_LATE = Flaw("force-late", "doubt",
    "The force is logged {later:later|earlier} than the position: {late}. It was moved by the mean.",
    "Log both channels at one instant.")
FORCE_LATE_OPEN = Flaw("force-late-open", "doubt",
    "The residuals look as if the force were logged late: k may be wrong.",
    "Log both channels at one instant, and more samples a cycle.")
ENCODER_TOO_COARSE = Flaw("encoder-too-coarse", "wrong",
    "The amplitude is {steps:.1f} steps of the encoder: three are needed.",
    "Log a larger amplitude, or a finer encoder.")
FIRST_BLOCK_UNRESOLVED = Flaw("first-block-unresolved", "doubt",
    "The first block slips at {slip}, within four steps of the encoder ({step}): k_1 is less certain.",
    "Log a finer encoder.", widens={"k": 0.5})
STIFFNESS_UNRESOLVED = Flaw("stiffness-unresolved", "wrong",
    "{name} is a lower bound: it yields within {slip}, and motion is seen {resolved} after a reversal.",
    "Log slower, or a finer encoder.", widens={"k": 1.0})
FORCE_CLIPPED = Flaw("force-clipped", lambda f: "wrong" if f.sure else "doubt",
    "The force is clipped in {samples} samples{sure:: larger values are missing|, or varies within a step}.",
    "Log again with a larger range.", widens={"level": 0.1})
INPUT_CLIPPED = Flaw("input-clipped", lambda f: "wrong" if f.sure else "doubt",
    "The input is clipped in {samples} samples{sure:: what lies beyond is missing|, or varies within a step}.",
    "Log again with a larger range.")
CLIPPED_UNUSED = Flaw("clipped-unused", "doubt",
    "The force is clipped in {counted}: {left_out:these are left out|these samples are not compared}.",
    "Log again with a larger range.", widens={"level": 0.1})
FOREIGN_COMPENSATION = Flaw("foreign-compensation", "wrong",
    "The control compensates friction, {when}: at {count} of {reversals} reversals it jumps {height} ahead.",
    "Switch its friction compensation off, and log again.", widens={"level": 0.1, "k": 1.0})
HOLDING_MAP = Flaw("holding-map", "note",
    "Holding forces at {points} places over {length}: friction {level} at rest, load {load} ± {varies}.",
    "A static map takes strokes at constant velocity.")
MODES_SWITCH = Flaw("modes-switch", "note",
    "{logged:The control switches its mode|A compensation is switched, by the error}: {parts}. Each part is a "
    "record{compared:: error {compared}|}.")
TWO_ENCODERS = Flaw("two-encoders", "note",
    "Friction is identified by the motor's encoder{lost:; the load lags {lost}|}{stiffness:, stiffness at most "
    "{stiffness}|}.", "`encoder='load'` takes the load's.")
DRIVE_OFF = Flaw("drive-off", "note",
    "The drive is off for {share:.0%} of {records} (force exactly 0 at rest): this part is left out.")
FORCE_COARSE = Flaw("force-coarse", "doubt",
    "The force comes in steps of {step}: forces are off by up to half a step.", "Log it with a finer resolution.")
ONE_DIRECTION = Flaw("one-direction", "doubt",
    "Only one direction was measured: F_c and an offset cannot be separated{level:, only their sum, {level}|}.",
    "Log strokes in both directions, or give the offset as the load.")
FORCE_TURNED = Flaw("force-turned", "wrong", "Forward strokes took less force than backward ones: the sign of the "
    "force is wrong.", "Change the force's `sign:` in the mapping, and ingest again.")
DEAD_ZONE = Flaw("dead-zone", "wrong",
    "Inputs within ±{zone:2} make no force (a dead zone), beyond it {slope}: K_f and B are too small.",
    "Take it out of the drive, or excite more strongly.", widens={"K_f": 0.05, "B": 0.05})
K_F_DIFFERS = Flaw("K_f-differs", "wrong", "K_f was given as {given}, and the logged force is {found} times the input.",
    "Check the scales of force and input.", widens={"K_f": 0.1})
FORCE_SCALE_DIFFERS = Flaw("force-scale-differs", "wrong",
    "{every:K_f is {other:.3g} times what {records} show: the response has another scale|"
    "The force of {records} is {ratio:.3g} times what K_f makes of its voltage: another scale, or another axis}.",
    "Check the scales of force and voltage in {every:the response|these files, or leave them out}.",
    widens={"level": 0.2})
POSITION_UNIT_DIFFERS = Flaw("position-unit-differs", "wrong",
    "The encoder step of {records} is {factor:g} times that of the others: a position in another unit.",
    "Check the unit of position in these files, or leave them out.", widens={"level": 0.2})
K_F_MISSING = Flaw("K_f-missing", "note", "K_f is not known: no record shows force over input.",
    "Give strokes that have both, or K_f with `force_constant=`.")
MASS_DIFFERS = Flaw("mass-differs", "wrong", "K_f/B is {found}, and the moving mass was stated as {stated}.",
    "Check the scales of force, input and position, and the mass.", widens={"B": 0.1})
FORCE_NOT_PROPORTIONAL = Flaw("force-not-proportional", "doubt", "Force is not proportional to input: {segments} "
    "steady means deviate {off:.0%} of their range from a line.", "Check that the force is measured at the motor.")
