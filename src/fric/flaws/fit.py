"""Fit: what replayed records do not say of a friction model."""

from fric.flaws.base import Flaw

# fmt: off
PARAMETER_UNSEEN = Flaw("parameter-untold", "doubt",
    "The gradient over {parameter} is flat: these records do not determine it{left:, and it is left at {left}|}.")
PARAMETER_AT_BOUND = Flaw("parameter-at-bound", "note",
    "{parameter} is at its lower bound, {bound}{no_effect:: these records show no difference|}.")
PARAMETER_AT_EDGE = Flaw("parameter-at-edge", "doubt", "{parameter} is at the edge of what these records could show.")
PARAMETERS_CORRELATED = Flaw("parameters-correlated", "note",
    "{first} and {second} are correlated by {correlation:.3f}: these records hardly distinguish them.")
EXPLAINS_LITTLE = Flaw("explains-little", "doubt", "{model} explains {share:.0%} of the variance of the force.")
