"""Plan: what a plan of records assumes."""

from fric.flaws.base import Flaw

# fmt: off
PLAN_TYPICAL = Flaw("plan-typical", lambda f: "note" if f.like else "doubt",
    "Plant, controller, encoder and noise are those of the bundled {machine}.",
    "Give --machine, or --like with a typical log of the drive.")
PLAN_NOT_ENOUGH = Flaw("plan-not-enough", "doubt", "No more can be identified from these records: {why}.")
PLAN_LEFT_OVER = Flaw("plan-left-over", "note", "What was identified left more over than its models make: more "
    "records of the same kind will not determine {names} better.")
PLAN_PLANT_UNSURE = Flaw("plan-plant-unsure", "doubt", "A and B are expected as if friction were that of its model "
    "everywhere; a response of this drive may be several times less sure.", "Give the plant of its last with --plant.")
PLAN_FRICTION_ALONE = Flaw("plan-friction-alone", "note",
    "Errors of the plant are not included: the glitch of scheme {scheme} is narrowed by friction alone.")
PLAN_ACCURACY = Flaw("plan-accuracy", "doubt", "{name} reaches {lack:.2g} times the half-width asked for, with "
    "{times} times the usual records: their number does not limit it.")
