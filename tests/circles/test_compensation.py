"""A friction compensation on a circle: said to be too early, too late, too high or too low by its kicks."""

from dataclasses import replace

import numpy as np
import pytest

from fric.circles.diagnose import diagnose
from fric.circles.measured import AxisTrace, MeasuredCircle
from fric.circles.revolutions import GlitchPulse, kick_of
from fric.drive.sensing import Encoder
from fric.reference import circle
from fric.results.given_models import machine_of
from fric.simulate.axis import run_axis
from tests.chance import fewest, most
from tests.turns import in_turns

FRICTION = {"base": (80.0, 64.0), "xy-table": (105.0, 53.3), "virtual-rig": (60.0, 60.0)}
"""Coulomb friction of x and y, about [N]."""


def measured(machine: str, level: float, late: float, seed: int = 0, feed: float = 0.1) -> MeasuredCircle:
    """Return a circle with so much of Coulomb friction added to the voltage, so much later than the reversal [s]."""
    rng, axes = np.random.default_rng([seed, len(machine)]), {}
    count = float(10 ** rng.uniform(-8, -6.6))
    for n, name in enumerate("xy"):
        axis = replace(machine_of(machine).axis(name), encoder=Encoder(count))
        reference = circle(0.03, feed, 2, axis.cascade.sampling)[n]
        asked = np.interp(reference.time - late, reference.time, reference.velocity)
        added = level * FRICTION[machine][n] / axis.plant.K_f * np.sign(asked)
        run = run_axis(axis, reference, excitation=added)
        axes[name] = AxisTrace(run.time, np.round(run.position / count) * count, run.reference)
    return MeasuredCircle(0.03, feed, 1, axes, instrument="encoders")


def kicks(test: MeasuredCircle) -> dict[str, str]:
    found = [warning for warning in diagnose([test]).warnings if warning.code == "compensation-kicks"]
    return dict(text.split(" ", 1) for warning in found for text in warning.values["quadrants"])


CASES = {"too high": ((1.7, 3.0), (0.0, 0.002)), "too late": ((1.0, 2.0), (0.015, 0.025)),
         "too early": ((0.8, 1.5), (-0.02, -0.01)), "too low": ((0.45, 0.6), (0.0, 0.002))}  # fmt: skip
"""Level and lateness [s] of a compensation, from and to."""


@pytest.mark.parametrize(
    "how", [pytest.param(how, marks=pytest.mark.long(4)) if how in {"too early", "too high"} else how for how in CASES]
)
def test_a_compensation_is_said_to_be_early_late_high_or_low(how):
    (_, level), (late, _) = CASES[how]
    test = measured("xy-table", level, late)
    found = kicks(test)
    assert set(found.values()) == {how}
    assert set(found) >= {"+y", "-y"}
    assert not kicks(replace(test, scheme="f"))  # what is known to be on needs no such word


@pytest.mark.parametrize("share", in_turns((0.2, 0.25, 0.3), (0.25,)))
def test_friction_that_rises_as_the_axis_slows_down_is_no_compensation(share):
    """Such an axis dips inwards before it sticks, within 20 ms where v_s is 4 mm/s, by a seventh of what follows."""
    phi = np.arange(-0.6, 0.8, 1e-3)
    time, turn = phi / 3.2, np.zeros(len(phi), int)  # 25 mm at 80 mm/s
    slowing = np.clip(time / 17e-3, 0.0, 1.0) * np.exp(-np.clip(time - 17e-3, 0.0, 1.0) / 5e-3)
    stuck = np.clip((time - 17e-3) / 30e-3, 0.0, None)
    pulse = 60e-6 * (stuck * np.exp(1.0 - stuck) - share * slowing)
    assert kick_of(GlitchPulse(phi, pulse, turn), 3.2, 1e-7) == ""
    sudden = np.clip(time / 5e-3, 0.0, 1.0) * np.exp(-np.clip(time - 5e-3, 0.0, 1.0) / 5e-3)
    pulse = 60e-6 * (stuck * np.exp(1.0 - stuck) - share * sudden)
    assert kick_of(GlitchPulse(phi, pulse, turn), 3.2, 1e-7) == "too low"


@pytest.mark.long(200)
@pytest.mark.parametrize("machine", FRICTION)
def test_kicks_are_said_rightly_and_none_without_a_compensation(machine):
    """Of 40 circles with one 95 % of the quadrants, of 40 without none but 2 %; low ones may hide behind friction."""
    right, false = [], 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        how = tuple(CASES)[seed % 4]
        feed = float(rng.uniform(0.08, 0.15))
        level, late = (float(rng.uniform(*span)) for span in CASES[how])
        found = kicks(measured(machine, level, late, seed, feed))
        right.append(
            all(found.get(name) == how for name in ("+x", "+y", "-x", "-y") if how != "too low" or name in found)
        )
        false += bool(kicks(measured(machine, 0.0, 0.0, seed, float(rng.uniform(0.02, 0.15)))))
    assert sum(right) >= fewest(40, 0.95)
    assert false <= most(40, 0.02)
