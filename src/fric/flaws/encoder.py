"""Encoder: what the position does not resolve."""

from fric.flaws.base import Flaw

# fmt: off
ENCODER_ERRS = Flaw("encoder-errs", "doubt", "The position ripples by {amplitude} with a pitch of {pitch}: the "
    "encoder interpolates wrongly, and shows knots of that size.", "Adjust the reading head, or log a finer encoder.",
    widens={"resolution": 2.0})
ENCODER_TOO_COARSE = Flaw("encoder-too-coarse", "wrong",
    "The amplitude is {steps:.1f} steps of the encoder: three are needed.",
    "Log a larger amplitude, or a finer encoder.")
FIRST_BLOCK_UNRESOLVED = Flaw("first-block-unresolved", "doubt",
    "The first block slips at {slip}, within four steps of the encoder ({step}): k_1 is uncertain beyond its interval.",
    "Log a finer encoder.", widens={"k": 0.5})
STIFFNESS_UNRESOLVED = Flaw("stiffness-unresolved", "wrong", "{name} is a lower bound: its spring yields within "
    "{slip}, and after a reversal motion is seen again {resolved} later.", "Log slower, or a finer encoder.",
    widens={"k": 1.0})
