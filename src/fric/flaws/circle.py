"""Circle: what measured circles do not say."""

from fric.flaws.base import Flaw

# fmt: off
COMPENSATION_KICKS = Flaw("compensation-kicks", "note", "The axes move inwards behind reversals: {quadrants}.",
    "A compensation is too early, or the loop overshoots: switch it off before friction is tuned on the circle.")
PREDICTION_WITHOUT_INTERVAL = Flaw("prediction-without-interval", "doubt",
    "The machine file has no intervals: only those of the circle and an encoder step are allowed for.",
    "Give the files of `fric identify` or `fric tune`.")
MODEL_DISAGREES = Flaw("model-disagrees", "wrong",
    "The circle is not as predicted: {glitches}.", "Find out why, or fit the machine to the circle with `fric tune`.",
    disagrees=True)
SQUARENESS_UNSEEN = Flaw("squareness-unseen", "note", "The axes' own encoders cannot see squareness: {ellipse:the "
    "ellipse at ±45° ({ellipse}) is taken for mismatch|what is found is of their loops}.",
    word=("squareness", "not told"))
MISMATCH_OR_SQUARENESS = Flaw("mismatch-or-squareness", "doubt",
    "One direction does not tell mismatch from squareness: the ellipse at ±45° ({ellipse}) is their sum.",
    "Measure the other direction too{ball_bar:|, or ingest it with `instrument='encoders'` where it is of the axes' "
    "encoders}.")
LOST_MOTION_CAUSE = Flaw("lost-motion-cause", "note",
    "A step remains after {axes} reverses: backlash or wind-up at the table, or an error of the loop.",
    "{reference:|Record the reference and the axis' own encoder too.}")
BALL_BAR_LENGTH = Flaw("ball-bar-length", "note",
    "A ball bar does not show the lag of an axis, and an error of its length changes both scales equally.")
ONE_REVOLUTION = Flaw("one-revolution", "note",
    "There is one whole revolution: what does not repeat cannot be distinguished from what does.")
GLITCH_DOES_NOT_END = Flaw("glitch-does-not-end", "doubt",
    "The glitch at {quadrants} lasts beyond {degrees:.0f}°: some may pass for backlash or mismatch.",
    "Measure at a lower feed or a larger radius.")
TABLE_UNSEEN = Flaw("table-unseen", "doubt",
    "The axis has a second mass, and the circle is of its motor: the motion of the table is not known.",
    "Measure it with a grid encoder or a ball bar.")
CIRCLE_CANNOT_RUN = Flaw("circle-cannot-run", "wrong", "The identified machine cannot run this circle: {why}.",
    disagrees=True)
COMPLETED_DISAGREES = Flaw("completed-disagrees", "wrong",
    "Completed by this circle, the machine does not reproduce it ({glitches}).",
    "Was a compensation on, a gain changed, velocity or acceleration not fed forward? State it with the gains.",
    disagrees=True)
DELAY_DIFFERS = Flaw("delay-differs", "wrong",
    "The delay is {plant} in the plant file, {circle} on the circle: a log shifts position or voltage.")
GAINS_UNKNOWN = Flaw("gains-unknown", "wrong",
    "The circle has no voltage, and fric guessed the gains: wrong gains look like different friction.",
    "Give yours: `controllers='K_v=… 1/s, K_p=… V*s/m, K_i=… V/m'`.")
CONTROLLER_DIFFERS = Flaw("controller-differs", "wrong", "{how}{friction:; no error here shows friction|}.")
FEEDFORWARD_FOUND = Flaw("feedforward-found", "note",
    "The recorded voltage shows feedforward of velocity and inverse model: both are assumed here.")
LOOP_LAGS = Flaw("loop-lags", lambda of: "wrong" if of.differs else "note",
    "The drive feeds no velocity forward{differs:, the simulated drive does|}: the axis lags by {lag}.",
    "Switch velocity feedforward on in the drive{differs:, or state a velocity_feedforward of 0 with its gains|}.")
ADDED_VOLTAGE_FOUND = Flaw("added-voltage-found", "note",
    "The voltage is not the controller's in {share:.1%} of the samples, by up to {most:.3g} V: taken as added.")
LEARNING_DIVERGES = Flaw("learning-diverges", "doubt",
    "The glitch rises again, from {least} to {last} µm: the rounds also learn what does not repeat.",
    "Stop earlier, or lower the share or the bandwidth.")
EFFORT_SMOOTHED = Flaw("effort-smoothed", "wrong",
    "The gains ask for a velocity filter of {corner}: rather, the logged current or force is smoothed.",
    "Log it as the controller asks for it, or unfiltered: else gains, B and C are those of the filter.",
    widens={"B": 0.3})
LEARNING_GAINS_NOTHING = Flaw("learning-gains-nothing", "doubt",
    "Learning leaves {last} of {first} µm: noise, encoder steps, or a loop upset by falling friction.",
    "`fric tune` says which; `loop=True` designs stable gains.")
LEARNED_FOR_ONE_CIRCLE = Flaw("learned-for-one-circle", "note",
    "What was learned holds for this circle only: it leaves {best} there, but {others}.")
LEARNED_FROM_ONE_CIRCLE = Flaw("learned-from-one-circle", "note", "What is learned holds for this radius, feed and "
    "direction only: elsewhere a tuned model is better.", "`fric learn MACHINE.yaml --rounds N` shows by how much.")
NOTHING_FED_BEFORE = Flaw("nothing-fed-before", "note",
    "A share of {share:g} is learned as if no friction feedforward had been on in this round.",
    "From the second round on give the feedforward file of the recorded circle (`before=`).")
MODEL_SHAPE = Flaw("model-shape", "doubt",
    "Learning leaves {learned}, the best friction model {model} of the circle: its shape is wrong.",
    "`fric compare` shows which model fits the friction of the logs best.")
LAW_DIFFERS = Flaw("law-differs", "doubt",
    "Friction does not follow the model: ({scheme}) leaves {glitch} to {most} at {feed}, not {alone}.",
    "Tune again with circles recorded after this; `fric learn` needs no model and can reach {alone}.")
ONE_FEED = Flaw("one-feed", "doubt", "All circles have about the same feed, {feed}: they do not determine {missing}.",
    "Record one fast and one slow circle, as at 100 and 10 mm/s.")
CIRCLE_MISFIT = Flaw("circle-misfit", "doubt",
    "{left} (rms) of the voltage is unexplained (noise {noise}): GMS does not fit, or the log is faulty.")
DIRECTION = Flaw("direction", "note",
    "Friction is {side:.1%} higher in the {positive:positive|negative} direction of motion: each has its own map.")
TUNED_AT_BOUND = Flaw("tuned-at-bound", "doubt",
    "{names} ended at the search's limit: a misfit, or not determined by the circles.")
POSITION_LATE = Flaw("position-late", "doubt",
    "The position lags the voltage: delay {delay} ({low} to {high}), not {nominal}; logging included.")
POSITION_EARLY = Flaw("position-early", "doubt",
    "The position leads the voltage: delay {delay} ({low} to {high}), not {nominal}; logging included.")
CIRCLE_DRIFTS = Flaw("circle-drifts", "doubt",
    "Friction {change:rises|falls} by {size:.1%} (± {half:.1%}) over the circle at {feed}: its mean is found.",
    "Run the axis warm, and record again.", widens={"level": 0.08})
LOOP_DESIGNED = Flaw("loop-designed", "note",
    "New gains: K_p {K_p:.4g}, K_i {K_i:.4g}, K_v {K_v:.4g}, velocity filter {filter:.4g} Hz{observer:, observer "
    "{observer:.3g} Hz|}.",
    "Stable up to {margin:.2g} times this fall of friction with speed{fed:; {fed:.1%} of the friction is fed "
    "forward|}.")
FALLING_FRICTION = Flaw("falling-friction", "note",
    "The loop is stable up to {margin:.2g} times this fall of friction: errors grow behind slow reversals.",
    "{fed:.1%} of the friction is fed forward.{design: `loop=True` designs gains that hold it.|}")
TUNED_IN_PART = Flaw("tuned-in-part", "note", "With everything found, {why}: {kept}.")
TUNING_REFUSED = Flaw("tuning-refused", "wrong", "{why}: the result is refused, and the nominal parameters are kept.")
TUNING_NO_BETTER = Flaw("tuning-no-better", "wrong",
    "The result leaves {after} of the voltages unexplained, the nominal one {before}, which is kept.")
