"""Circle: what measured circles do not say."""

from fric.flaws.base import Flaw

# fmt: off
COMPENSATION_KICKS = Flaw("compensation-kicks", "note",
    "A friction compensation (or an observer) drives the axes inwards behind reversals: {quadrants}.",
    "Correct it by that, or switch it off before friction is tuned on the circle.")
PREDICTION_WITHOUT_INTERVAL = Flaw("prediction-without-interval", "doubt", "The machine file has no intervals: the "
    "prediction is compared by the measured interval and a step of the encoder alone.",
    "Give the files of `fric identify` or `fric tune`.")
MODEL_DISAGREES = Flaw("model-disagrees", "wrong",
    "The model does not agree with the circle: {glitches}. No scheme can be recommended until that is explained.",
    "`fric tune` fits the machine to the circle.", disagrees=True)
SQUARENESS_UNSEEN = Flaw("squareness-unseen", "note", "The axes' own encoders cannot see squareness: {ellipse:the "
    "ellipse at ±45° ({ellipse}) is taken for mismatch|what is found is of their loops}.",
    word=("squareness", "not told"))
MISMATCH_OR_SQUARENESS = Flaw("mismatch-or-squareness", "doubt", "One direction does not distinguish mismatch of the "
    "loops from squareness: the ellipse at ±45° ({ellipse}) is their sum.", "Measure the other direction "
    "too{ball_bar:|; or say `instrument='encoders'`, if the position is of the axes' own encoders}.")
LOST_MOTION_CAUSE = Flaw("lost-motion-cause", "note", "A step stays after the reversal of {axes}: backlash or "
    "wind-up seen at the table, or an error that the loop keeps.",
    "{reference:|Record the reference and the axis' own position beside it.}")
BALL_BAR_LENGTH = Flaw("ball-bar-length", "note",
    "A ball bar shows no lag of an axis, and an error of its length moves both scales alike.")
ONE_REVOLUTION = Flaw("one-revolution", "note",
    "There is one whole revolution: what does not repeat cannot be distinguished from what does.")
GLITCH_DOES_NOT_END = Flaw("glitch-does-not-end", "doubt", "The glitch at {quadrants} has not ended {degrees:.0f}° "
    "behind the reversal: a part may be taken for backlash, scale or mismatch.",
    "Measure at a lower feed or a larger radius.")
TABLE_UNSEEN = Flaw("table-unseen", "doubt",
    "The axis has a second mass, and the circle was measured on its motor: the motion of the table is not known.",
    "Measure it with a grid encoder or a ball bar.")
CIRCLE_CANNOT_RUN = Flaw("circle-cannot-run", "wrong", "The machine as it is known cannot run this circle: {why}.",
    disagrees=True)
COMPLETED_DISAGREES = Flaw("completed-disagrees", "wrong",
    "The machine does not show the circle that it was fitted to ({glitches}).",
    "Controller, plant or record is not as stated: check them.", disagrees=True)
DELAY_DIFFERS = Flaw("delay-differs", "wrong", "The plant file has a delay of {plant}, the circle {circle}: a log "
    "has position and voltage of different times.")
GAINS_UNKNOWN = Flaw("gains-unknown", "wrong", "The circle has no voltage, and fric designed the controller's gains: "
    "wrong gains look like other friction.", "Give yours: `controllers='K_v=… 1/s, K_p=… V*s/m, K_i=… V/m'`.")
CONTROLLER_DIFFERS = Flaw("controller-differs", "wrong", "{how}{friction:; no error here shows friction|}.")
FEEDFORWARD_FOUND = Flaw("feedforward-found", "note",
    "The recorded voltage shows that velocity and inverse model are fed forward: so they are here.")
ADDED_VOLTAGE_FOUND = Flaw("added-voltage-found", "note", "The recorded voltage differs from the controller's in "
    "{share:.1%} of the samples, by up to {most:.3g} V: taken for an added voltage.")
LEARNING_DIVERGES = Flaw("learning-diverges", "doubt",
    "The glitch has risen again, from {least} to {last} µm: what does not repeat is learned too.",
    "Stop earlier, or lower the share or the bandwidth.")
LEARNING_GAINS_NOTHING = Flaw("learning-gains-nothing", "doubt", "Learning leaves {last} µm of {first}: noise and "
    "counts, or what grows where the loop does not hold falling friction.",
    "`fric tune` says which, and `loop=True` designs gains that hold it.")
LEARNED_FOR_ONE_CIRCLE = Flaw("learned-for-one-circle", "note",
    "What was learned is for this circle alone: it leaves {best} there, and carried over {others}.")
LEARNED_FROM_ONE_CIRCLE = Flaw("learned-from-one-circle", "note", "What is learned from a circle is for its radius, "
    "feed and direction alone: on another it leaves more than a tuned model.",
    "`fric learn MACHINE.yaml --rounds N` shows by how much.")
NOTHING_FED_BEFORE = Flaw("nothing-fed-before", "note",
    "A share of {share:g} is learned, and nothing is taken for what this round fed forward against friction.",
    "From the second round on give the file that it was run with (`before=`).")
MODEL_SHAPE = Flaw("model-shape", "doubt",
    "Learning leaves {learned} of the circle, and the best friction model {model}: the shape of the model is wrong.",
    "`fric compare` shows which model fits the friction of the logs best.")
LAW_DIFFERS = Flaw("law-differs", "doubt", "Friction follows another law than the model: ({scheme}) should leave "
    "{alone} at {feed}, and {glitch} to {most} are expected.",
    "Tune again with the circles that this leaves; `fric learn`, which needs no model, can leave {alone} at best.")
ONE_FEED = Flaw("one-feed", "doubt", "All circles are at about {feed}, and do not determine {missing}.",
    "Record one fast and one slow circle, as at 100 and 10 mm/s.")
CIRCLE_MISFIT = Flaw("circle-misfit", "doubt", "{left} of the voltage are not explained, and {noise} are noise: GMS"
    " does not fit, or the log has a flaw.")
DIRECTION = Flaw("direction", "note",
    "Friction is {side:.1%} higher in the {positive:positive|negative} direction of motion: each has its own map.")
TUNED_AT_BOUND = Flaw("tuned-at-bound", "doubt",
    "{names} ended at the limit of the search: the model is far off, or the circles do not determine it.")
POSITION_LATE = Flaw("position-late", "doubt", "The position is late against the voltage: the delay is {delay} "
    "({low} to {high}), not {nominal}. A shift of the log is included.")
POSITION_EARLY = Flaw("position-early", "doubt", "The position is ahead of the voltage: the delay is {delay} ({low} "
    "to {high}), not {nominal}. A shift of the log is included.")
CIRCLE_DRIFTS = Flaw("circle-drifts", "doubt",
    "Friction {change:rises|falls} by {size:.1%} (± {half:.1%}) over the circle at {feed}: its mean is found.",
    "Run the axis warm, and record again.", widens={"level": 0.08})
BLOCKS_ALIKE = Flaw("blocks-alike", "note",
    "Blocks slip at about one displacement, and circles do not determine what each of them has: {together}.")
LOOP_DESIGNED = Flaw("loop-designed", "note", "The loop was designed anew: it holds a Stribeck fall {margin:.2g} "
    "times as steep, with K_p {K_p:.4g}, K_i {K_i:.4g}, K_v {K_v:.4g}, velocity filter {filter:.4g} Hz{observer:, "
    "observer {observer:.3g} Hz|}{fed:; {fed:.1%} of the friction is fed forward|}.")
FALLING_FRICTION = Flaw("falling-friction", "note", "The loop does not hold falling friction ({margin:.2g} times the "
    "fall): errors grow behind slow reversals, and only {fed:.1%} of the friction is fed forward.",
    "{design:`loop=True` designs gains that hold it.|}")
TUNED_IN_PART = Flaw("tuned-in-part", "note", "With all that was found {why}: {kept}.")
TUNING_REFUSED = Flaw("tuning-refused", "wrong", "{why}: the result is refused, and the nominal parameters are kept.")
TUNING_NO_BETTER = Flaw("tuning-no-better", "wrong", "What was found leaves {after} of the recorded voltages, and "
    "the nominal parameters {before}: it is refused, and these are kept.")
