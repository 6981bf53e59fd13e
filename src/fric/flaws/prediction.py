"""Prediction: why the interval of a prediction, a verdict or a plan cannot be trusted yet."""

from fric.flaws.base import Flaw

# fmt: off
NO_MEASURED_CIRCLE = Flaw("no-measured-circle", "doubt", "The simulation was not compared with a measured circle.",
    "Record one: two revolutions without compensation are enough.")
CIRCLE_ELSEWHERE = Flaw("circle-elsewhere", "doubt",
    "No measured circle is near this radius and feed: friction was not seen at its speeds.")
CIRCLE_UNUSED = Flaw("circle-unused", "doubt", "No machine was fitted to this circle: {why}.")
PREDICTION_WIDENED = Flaw("prediction-widened", "note", "{name} ± {share:.2g}: {why}")
INTERVAL_OPEN = Flaw("interval-open", "note",
    "{name} × {low:g} to {high:g}: its interval is open, or does not hold the estimate.")
NOT_DRAWN = Flaw("not-drawn", "doubt",
    "{names} cannot be drawn: the interval is open or misses it; the usual spread is taken.")
SCHEME_UNSTABLE = Flaw("scheme-unstable", "wrong",
    "Scheme {scheme} is not stable on {share:.0%} of the machines that agree with what is known.")
NOT_AS_PREDICTED = Flaw("not-as-predicted", "wrong",
    "{quadrant} shows {measured}, and {predicted} are predicted ({cause}).", disagrees=True)
NOTHING_SIMULATED = Flaw("nothing-simulated", "wrong", "Nothing was simulated.")
BELIEF_IS_TRUTH = Flaw("belief-is-truth", "doubt",
    "Here the controllers know plant and friction exactly, and no varied machines were simulated.")
ONE_MACHINE = Flaw("one-machine", "doubt", "One machine was simulated: how far the glitch scatters is not known.")
FEW_MACHINES = Flaw("few-machines", "doubt", "Machines drawn: {machines}. 95 % of so few is a guess.")
MEASURED_BEYOND = Flaw("measured-beyond", "wrong", "With {scheme} switched on, the measured circle shows {seen:2}.")
GLITCH_OPEN = Flaw("glitch-open", "doubt",
    "The glitch without compensation is {glitch:2}, or up to {most:2}: the records leave it open.",
    "Record what is missing for the axis.")
PRESLIDING_UNKNOWN = Flaw("presliding-unknown", "wrong",
    "Friction before sliding was not identified, and decides what a compensation leaves.",
    "Log slow sines of some ten micrometres, or a circle with force or voltage.", circle_settles=True)
LIMIT_CYCLE = Flaw("limit-cycle", "wrong",
    "The loop swings by {size:2} away from reversals{machines:, on {machines} of {drawn} machines|}: a limit cycle.")
CANNOT_RUN = Flaw("cannot-run", "wrong", "It cannot run on {share:.0%} of the varied machines.",
    "{bare:The machine itself runs so: the intervals of its plant or gains are too wide.|}")
SCHEME_SPOILS = Flaw("scheme-spoils", "wrong", "Scheme {scheme} leaves {left}, and the controller alone {alone}.")
SCHEME_SATURATES = Flaw("scheme-saturates", "wrong", "{how}")
SATURATES = Flaw("saturates", "doubt",
    "The voltage is at its limit in {share:.1%} of the samples: the feed is too high.")
NOT_LINEAR = Flaw("not-linear", "note",
    "{blocks}: not linear, so stability was judged by this run alone, not by poles.")
NO_REVERSAL = Flaw("no-reversal", "doubt", "No axis reverses on this path at full feed: there is no glitch.")
SCHEME_FAILED = Flaw("scheme-failed", "doubt", "It could not run on {failed} of {runs} {of}, which are left out: {why}")
DRIVE_SATURATES = Flaw("drive-saturates", "doubt", "The drive saturates on {saturated} of {machines} machines.")
SPREAD_UNUSED = Flaw("spread-unused", "doubt",
    "The spread of {name} has no effect: no axis has such a parameter, or another spread draws it.")
INTERRUPTED = Flaw("interrupted", "doubt", "Interrupted: {done} of {circles} circles were run, the others are empty.")
T_D_BELOW_HOLD = Flaw("T_d-below-hold", "doubt",
    "T_d is {T_d}, less than the half sample of the hold: half a sample is assumed.")
INVERSE_LEFT_OUT = Flaw("inverse-left-out", "note", "There is no force along this motion: {why}.")
HELD_AS_PULSE = Flaw("held-as-pulse", "doubt",
    "The drive holds a pulse: simulated at {feed} it leaves {pulsed:2}, and {model} fed forward {fed:2}.")
PLAN_TYPICAL = Flaw("plan-typical", lambda f: "note" if f.like else "doubt",
    "Plant, controller, encoder and noise are those of the bundled {machine}.",
    "Give `machine=`, or `like=` with a typical log of the drive.")
PLAN_NOT_ENOUGH = Flaw("plan-not-enough", "doubt", "No more can be identified from these records: {why}.")
PLAN_LEFT_OVER = Flaw("plan-left-over", "note",
    "The last fit leaves more than noise: more such records do not determine {names} better.")
PLAN_PLANT_UNSURE = Flaw("plan-plant-unsure", "doubt", "The expected A and B assume this friction model; a real "
    "response may be several times less certain.", "Give the plant of the last response with `plant=`.")
PLAN_FRICTION_ALONE = Flaw("plan-friction-alone", "note",
    "Errors of the plant are not included: the glitch of scheme {scheme} is narrowed by friction alone.")
PLAN_ACCURACY = Flaw("plan-accuracy", "doubt", "{name}: {records} {reach}; {end}.")
