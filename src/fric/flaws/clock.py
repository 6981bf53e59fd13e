"""Clock: when samples were taken."""

from fric.flaws.base import Flaw

# fmt: off
SAMPLES_LOST = Flaw("samples-lost", "wrong",
    "{lost:.2g%} of the samples were lost, and the time was counted on: speeds and times are wrong by that.",
    "Log at a lower rate or fewer channels, or with the time of each sample.", widens={"T_d": 0.1, "C": 0.5})
SAMPLING_JITTERS = Flaw("sampling-jitters", lambda f: "doubt" if f.purpose in ("static", "inspect") else "wrong",
    "Samples are taken {jitter} (rms) off the logged time: noise of {displaced} in the position, which grows with "
    "speed.", "Log by the clock of the control, or the time of each sample.", widens={"T_d": 0.1, "C": 0.5})
SAMPLING_UNEVEN = Flaw("sampling-uneven", "note", "{missing} of {samples} samples are missing, and the others are up "
    "to {off:.0%} of a sample off: the record was made even along a cubic.")
FORCE_LAGS = Flaw("force-lags", "note", "The force is logged {lag} ({samples:.2g} samples) {late:later|earlier} than "
    "the input{corner:, {corner} of it the corner of a filter|}; it is moved back.", widens={"C": 0.3})
FORCE_LATE = Flaw("force-late", "doubt",
    "The force is logged later than the position: {late}. It was moved back by the mean.",
    "Log both channels at one instant.")
FORCE_LATE_OPEN = Flaw("force-late-open", "doubt",
    "The model misses these records as it would a force that is logged late: k may be off.",
    "Log both channels at one instant, and more samples a cycle.")
