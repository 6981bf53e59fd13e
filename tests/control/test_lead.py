"""Lead: what leaves the controller acts T_d later, so friction and inverse model are fed forward that much ahead."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from fric.cli.main import app
from fric.control.scheme import Scheme
from fric.documents.machine_files import read_machine
from fric.documents.schemes import read_schemes
from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.friction.stribeck import StaticMap
from fric.reference import Reference, sine
from fric.simulate.axis import run_axis
from fric.simulate.contour_run import Circle, run_circle
from tests.turns import in_turns

TABLE = Path("configs/xy-table.yaml")
GMS = Scheme("c", "GMS", friction="gms")


def test_the_motion_ahead_is_exact_for_a_cubic_and_a_shift_for_whole_samples() -> None:
    t = np.arange(40) / 4000.0
    rate, change, jerk = 0.1, 3.0, 500.0
    motion = Reference(4000.0, rate * t + change * t**2 / 2 + jerk * t**3 / 6, rate + change * t + jerk * t**2 / 2,
                       change + jerk * t)  # fmt: skip
    lead = 0.65e-3
    later, inside = t + lead, slice(0, -3)
    ahead = motion.ahead(lead)
    exact = rate * later + change * later**2 / 2 + jerk * later**3 / 6
    np.testing.assert_allclose(ahead.position[inside], exact[inside], rtol=1e-12)
    np.testing.assert_allclose(ahead.acceleration[inside], (change + jerk * later)[inside], rtol=1e-12)
    # velocity is linear between samples: off by v̈·s·(1 - s)·T²/2 at most
    off = jerk * 0.25 / 4000.0**2 / 2
    assert np.abs(ahead.velocity - (rate + change * later + jerk * later**2 / 2))[inside].max() <= off * 1.001
    np.testing.assert_array_equal(motion.ahead(0.5e-3).position[:-2], motion.position[2:])
    assert motion.ahead(0.0) is motion


def test_beyond_its_end_the_motion_goes_on_as_it_does() -> None:
    t = np.arange(20) / 1000.0
    motion = Reference(1000.0, 0.2 * t, np.full(20, 0.2), np.zeros(20))
    np.testing.assert_allclose(motion.ahead(5.3e-3).position, 0.2 * (t + 5.3e-3), rtol=1e-12)


@pytest.mark.parametrize(("feed", "most"), in_turns([(0.1, 0.2e-6), (0.01, 0.3e-6)], [(0.1, 0.2e-6)], 2))
def test_with_friction_and_plant_known_the_glitch_is_what_is_asked_for(feed: float, most: float) -> None:
    """What is left without lead is delay: 1.0 µm at 100 mm/s."""
    runs = [
        run_circle(read_machine(TABLE, gain=1.0, lead=lead), GMS, Circle(feed=feed), accuracy=1e-9)
        for lead in (0.0, "auto")
    ]
    before, after = (run.circularity.glitch for run in runs)
    assert after <= most
    if feed == 0.1:
        assert 0.8e-6 < before < 1.2e-6


def test_fed_forward_alone_the_drive_is_late_by_its_delay_and_with_the_lead_it_is_not() -> None:
    """Without friction and feedback the position is the reference, T_d later: v·T_d off at most."""
    axis = read_machine(TABLE).axis("x")
    motion, lead = sine(1e-3, 10.0, 3, 4000.0), axis.plant.T_d
    plain = replace(
        axis, friction=StaticMap(0.0, 0.0, 1e-3), encoder=Encoder(),
        cascade=replace(axis.cascade, K_v=1e-12, K_p=1e-12, K_i=0.0),
    )  # fmt: skip
    errors = []
    for given in (0.0, lead):
        nominal_friction = replace(plain.nominal_friction, lead=given)
        run = run_axis(replace(plain, nominal_friction=nominal_friction), motion)
        errors.append(np.abs(run.position - motion.position).max())
    assert errors[0] == pytest.approx(np.abs(motion.velocity).max() * lead, rel=0.05)
    assert errors[1] < errors[0] / 50


def test_files_and_options_give_the_lead(tmp_path: Path) -> None:
    text = TABLE.read_text()
    for given, lead in (("auto", "auto"), ("0.6 ms", 0.6e-3)):
        own = tmp_path / "machine.yaml"
        own.write_text(text.replace("    feedforward:\n", f"    feedforward:\n      lead: {given}\n"))
        assert read_machine(own).axis("x").nominal_friction.lead == lead
    own.write_text(text.replace("    feedforward:\n", "    feedforward:\n      lead: -1 ms\n"))
    with pytest.raises(FricError, match=r"lead of the feedforward is -0\.001 s"):
        read_machine(own)
    assert read_machine(TABLE).axis("x").nominal_friction.lead == 0.0
    schemes = tmp_path / "schemes.yaml"
    schemes.write_text("fric: schemes/1\nschemes:\n  g: {friction: gms, lead: 0.5 ms, gain: 1}\n")
    assert read_schemes(schemes)["g"].lead == 0.5e-3
    words = ["simulate", "circle", str(TABLE), "--scheme", "c", "--gain", "1", "--json"]
    glitch = [
        json.loads(CliRunner().invoke(app, [*words, *more]).stdout)["schemes"]["c"]["glitch"]
        for more in ([], ["--lead", "auto"], ["--lead", "0.65 ms"])
    ]
    assert glitch[1] < 0.2 * glitch[0]
    assert glitch[2] == glitch[1]
