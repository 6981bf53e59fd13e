"""Response: what the identified plant does not hold."""

from fric.flaws.base import Flaw

UNSURE, FALSE = 0.02, 0.1  # Misfit above which a fit is in doubt, and above which it is wrong [1]


# fmt: off
LOOP_FEEDS_BACK = Flaw("loop-feeds-back", "doubt",
    "No reference excites the axis: in a closed loop, noise biases the response to 1/controller.",
    "Log the reference that excites, or excite periodically.")
NO_COHERENCE = Flaw("no-coherence", "note", "The table has no coherence: every frequency weighs the same.")
FEW_PERIODS = Flaw("few-periods", "doubt", "{periods} periods are too few for an estimate of the variance.", "Log ten.")
A_OPEN = Flaw("A-open", "doubt", "A cannot be distinguished from 0: the lowest frequency used is {lowest:.3g} Hz.",
    "Excite below the corner of A, and harder.", widens={"A": 0.5})
A_HOLDS_FRICTION = Flaw("A-holds-friction", lambda f: "note" if f.small else "doubt",
    "The axis reverses while it is excited, so A includes friction{small:|, and is taken as 0}: {each}.",
    "{small:By the lines between the driven ones it is less than {limit:.0%} of A.|Strokes show all damping instead. "
    "Log a second amplitude, or excite around a steady motion.}", widens={"A": 0.3, "level": 0.05})
A_HOLDS_VISCOUS = Flaw("A-holds-viscous", "note",
    "A includes the guideway's viscous friction over the moving mass, besides the drive's damping.",
    word=("A", "sigma included"))
VISCOUS_BY_DIRECTION = Flaw("viscous-by-direction", "doubt",
    "F_v is {forward} forwards and {backward} backwards: their mean holds for neither direction.",
    "Identify again with `direction='each'`.", widens={"A": 0.1})
T_D_AT_BOUND = Flaw("T_d-at-bound", "doubt",
    "T_d ends at {hold:the hold alone|zero}: input and position are of two instants, or the hold is wrong.",
    "Check the log, and `hold=`.", widens={"T_d": 0.3})
T_D_ASSUMED = Flaw("T_d-assumed", "doubt",
    "A {effort:logged force|motion} does not show T_d: {effort:that of a current loop of 500 Hz|half a sample, the "
    "hold,} is assumed.", "Give it with `delay=`.", widens={"T_d": 0.5}, no_response=True)
LINES_STAND_OFF = Flaw("lines-stand-off", "note",
    "Lines left out ({count}), which deviate as harmonics of friction do: {lines:.4g} Hz.")
RESPONSE_MISFIT = Flaw("response-misfit",
    lambda f: "wrong" if f.wrong else "doubt" if f.misfit >= UNSURE else "note",
    "Eq. (1) leaves {misfit:.2g%} that noise does not explain, most at {worst:.4g} Hz; the intervals allow for it.",
    "{wrong:Look at the figure, and use the range where it fits (`{edge}='{limit:.3g} Hz'`).|}")
SECOND_MASS = Flaw("second-mass", "note",
    "A second mass is seen from the {encoder}: {frequency}{share:, {share:.0%} of the moving mass|}. A and B are "
    "below it.")
SPRING_IN_SERIES = Flaw("spring-in-series", "wrong",
    "The motor's encoder does not see the spring: stiffnesses and C from pre-sliding include it.",
    "Measure at the table for friction alone.")
AMPLITUDES_DISAGREE = Flaw("amplitudes-disagree", "doubt",
    "A rises with the amplitude, which Coulomb friction does not explain: the records differ otherwise.")
FRICTION_IN_RESPONSE = Flaw("friction-in-response", "note",
    "Friction is seen: A is {low:.4g} to {high:.4g} 1/s here, {A:.4g} 1/s without ({coulomb} times the mass).")
CHANGES_BETWEEN = Flaw("changes-between", "doubt",
    "The speed changes between samples: {share:.0%} of them, around starts and stops, {less:weigh less|are left out}.",
    "Log at a higher rate, or start and stop slower.")
NOT_PHYSICAL = Flaw("not-physical", "wrong", "{name} is {value}, which no axis has.",
    "{falls:Log a faster motion: friction falls with speed in this record.|Check the sign of the force.}")
MASS_NOT_SHOWN = Flaw("mass-not-shown", "wrong", "The motion does not show the mass: {mass} ± {half:2}.",
    "Log starts and stops, at a rate that shows them.")
RESPONSE_ENDS = Flaw("response-ends", "doubt", "The response ends at {last:.4g} Hz, and Q (bandwidth "
    "{bandwidth:.4g} Hz) passes more: that part is not checked.", "Measure up to a higher frequency.")
RESPONSE_BEGINS = Flaw("response-begins", "doubt", "The response begins at {first:.4g} Hz, above the bandwidth of Q.",
    "Measure from a lower frequency on.")
RESPONSE_WITHOUT_CONFIDENCE = Flaw("response-without-confidence", "doubt",
    "The response has neither coherence nor standard deviation: its uncertainty is not included.")
CONTROLLER_BY_DEFAULT = Flaw("controller-by-default", "doubt",
    "No controller was given: the default of `fric design controller` is assumed.")
OBSERVER_ASSUMED = Flaw("observer-assumed", "doubt", "No measured response was given: {taken}.",
    "Give the log of a response{given:|, or `first_mode='80 Hz'`}.", no_response=True)
