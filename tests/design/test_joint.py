"""A block designed together with its cascade: the stiffest loop within a peak sensitivity, used as it is written."""

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import fric
from fric.control import Setting, block_type
from fric.control.kalman import Kalman
from fric.control.scheme import Scheme
from fric.design.blocks import design_block, design_jointly, step_compliance
from fric.design.observer import WholeLoop, model_perturbation
from fric.documents.machine_files import read_machine
from fric.errors import FricError
from fric.export.base import compensation_of
from fric.simulate.contour_run import Circle, run_circle

XY = Path("configs/xy-table.yaml")
MACHINE = read_machine(XY)
AXIS = MACHINE.axis("x")
SETTING = Setting(AXIS.plant, AXIS.cascade, K_f=AXIS.plant.K_f)
DELAY = model_perturbation(AXIS.plant, AXIS.cascade.sampling / 2)


@pytest.fixture(scope="module")
def designed():
    return design_jointly(Kalman, SETTING)


def test_the_compliance_is_that_of_a_step_in_time():
    """By its harmonics, against a plain loop in time: eq. (1) in steps of a fortieth of a sample, 1 V from t = 0."""
    own, plant, parts = AXIS.cascade, AXIS.plant, 40
    T_s = own.T_s
    late = round((plant.T_d - T_s / 2) / T_s * parts)
    pole = np.exp(-2 * np.pi * own.velocity_filter * T_s)
    z = v = seen = filtered = integral = peak = 0.0
    volts = [0.0] * (late + 1)
    for n in range(800 * parts):
        if n % parts == 0:
            filtered = pole * filtered + (1 - pole) * (z - seen) / T_s
            seen = z
            error = -own.K_v * z - filtered
            integral += own.K_i * T_s * error
            u = own.K_p * error + integral
            peak = max(peak, abs(z))
        volts.append(u)
        acceleration = plant.B * (volts.pop(0) + 1.0) - plant.A * v
        z += T_s / parts * (v + 0.5 * T_s / parts * acceleration)
        v += T_s / parts * acceleration
    assert step_compliance(WholeLoop(plant, own, DELAY)) == pytest.approx(peak, rel=0.01)


def test_it_is_stiffer_within_the_same_peak_sensitivity(designed):
    alone = design_block(Kalman, SETTING)
    before = step_compliance(WholeLoop(AXIS.plant, AXIS.cascade, DELAY), (alone.block,))
    assert max(alone.margins.peak_sensitivity, designed.block.margins.peak_sensitivity) <= 2.0
    assert designed.compliance[0] < 0.6 * before


def test_nothing_near_it_is_much_better(designed):
    """Each gain and the cutoff moved by 6 %, all together: what is stiffer by 3 % misses the peak sensitivity."""
    cutoff = designed.block.block.cutoff
    for a, b, c in product((0.94, 1.0, 1.06), repeat=3):
        own = designed.cascade
        cascade = replace(own, K_p=own.K_p * a, K_i=own.K_i * a, K_v=own.K_v * b)
        loop = WholeLoop(AXIS.plant, cascade, DELAY, None, replace(SETTING, cascade=cascade))
        block = (Kalman(cutoff * c),)
        if loop.peak(block) <= 2.0:
            assert step_compliance(loop, block) > 0.96 * designed.compliance[0], (a, b, c)


@pytest.mark.long(2)
def test_a_file_of_both_runs_as_the_scheme_that_designs_both(designed, tmp_path):
    joint = Scheme("j", "", friction="gms", blocks=("kalman",), joint=True)
    circle = Circle(0.01, 0.1, 1)
    wanted = run_circle(MACHINE, joint, circle, only="x").circularity.quadrants
    own, kalman = designed.cascade, {"cutoff": designed.block.block.cutoff}
    written = replace(AXIS, cascade=own, blocks={"kalman": kalman})
    machine = replace(MACHINE, axes={**MACHINE.axes, "x": written})
    np.testing.assert_array_equal(
        run_circle(machine, replace(joint, joint=False), circle, only="x").circularity.quadrants, wanted
    )
    with pytest.raises(FricError, match="gives both"):
        run_circle(machine, joint, circle, only="x")
    with pytest.raises(FricError, match="a cascade is not exported"):
        compensation_of(MACHINE, "x", joint)


def test_the_command_writes_block_and_cascade_into_one_file_that_a_machine_takes(tmp_path):
    (tmp_path / "plant.yaml").write_text(
        "fric: plant/1\naxis: x\nmotion: linear\nA: 28.57 1/s\nB: 4.526 m/(s^2*V)\nT_d: 0.65 ms\nK_f: 548 N/V\n"
    )
    cascade = AXIS.cascade
    found = fric.design_block("two-dof", tmp_path / "plant.yaml", controller=cascade, joint=True)
    assert "times less than without both" in repr(found)
    found.save(tmp_path / "both.yaml")
    axis = read_machine(XY, nominal_files=[f"x={tmp_path / 'both.yaml'}"]).axis("x")
    assert axis.cascade.K_p == found.joint.cascade.K_p > 1.2 * cascade.K_p
    assert axis.blocks["two-dof"]["cutoff"] == found.design.block.cutoff


@pytest.mark.parametrize("blocks", [(), ("kalman", "two-dof"), ("adaptive",)])
def test_a_scheme_that_has_no_one_block_to_design_is_refused(blocks):
    with pytest.raises(FricError, match="designs its cascade together with"):
        Scheme("j", "", friction="gms", blocks=blocks, joint=True)


def test_what_does_not_feed_back_has_nothing_to_share():
    with pytest.raises(FricError, match="does not feed back"):
        design_jointly(block_type("reversal-pulse"), SETTING)
