"""The friction that a machine has: any model that its file holds."""

from pathlib import Path

import pytest

from fric.control.scheme import NONE
from fric.documents.machine_files import read_machine
from fric.errors import FricError
from fric.friction.lugre import LuGre
from fric.simulate.contour_run import Circle, run_circle
from fric.simulate.machine import Machine

ROOT = Path(__file__).parents[2]


def with_lugre(tmp_path) -> Path:
    """Return the paper's table with a LuGre model beside the GMS model of each axis."""
    text = (ROOT / "configs/xy-table.yaml").read_text()
    assert text.count("      gms:\n") >= 2
    own = "      lugre: {sigma_0: 60 N/um, sigma_1: 300 N*s/m}\n      gms:\n"
    path = tmp_path / "machine.yaml"
    path.write_text(text.replace("      gms:\n", own))
    return path


def glitch(machine: Machine, scheme) -> float:
    return run_circle(machine, scheme, Circle(30e-3, 0.1), only="x").contour.glitch


def test_the_model_is_chosen_by_name(tmp_path):
    path = with_lugre(tmp_path)
    assert isinstance(read_machine(path, friction_model="lugre").axis("x").friction, LuGre)
    assert read_machine(path).axis("x").friction.name == "gms"
    with pytest.raises(FricError, match="in 'dahl'"):
        read_machine(path, friction_model="dahl")


def test_a_lugre_axis_glitches_as_its_break_away_force_tells(tmp_path):
    """The force of a reversal is the same as that of GMS, and so is the glitch, to a quarter."""
    path = with_lugre(tmp_path)
    gms, lugre = (glitch(read_machine(path, friction_model=name), NONE) for name in ("gms", "lugre"))
    assert abs(lugre) == pytest.approx(abs(gms), rel=0.25)
