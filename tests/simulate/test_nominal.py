"""What the controller believes of the plant is apart from what the plant is."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from fric.control.scheme import NONE, PAPER_SCHEMES
from fric.documents.machine_files import read_machine
from fric.reference import circle
from fric.simulate.axis import run_axis

AXIS = read_machine(Path(__file__).parents[2] / "configs/xy-table.yaml").axis("x")
REFERENCE = circle(0.03, 0.1, 1, AXIS.cascade.sampling)[0]


def _error(axis):
    trace = run_axis(axis, REFERENCE, NONE)
    return float(np.sqrt(np.mean((trace.position - trace.reference) ** 2)))


def test_a_true_belief_changes_nothing():
    assert _error(replace(AXIS, nominal=AXIS.plant)) == _error(AXIS)


def test_a_wrong_mass_in_the_inverse_model_costs_accuracy():
    wrong = replace(AXIS.plant, B=1.5 * AXIS.plant.B)
    assert _error(replace(AXIS, nominal=wrong)) > 1.02 * _error(AXIS)


def test_friction_feedforward_goes_through_the_believed_force_constant():
    double = replace(AXIS.plant, K_f=2 * AXIS.plant.K_f)
    whole, half = (run_axis(axis, REFERENCE, PAPER_SCHEMES["c"]) for axis in (AXIS, replace(AXIS, nominal=double)))
    np.testing.assert_allclose(half.feedforward, 0.5 * whole.feedforward)
