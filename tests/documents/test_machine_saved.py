"""A machine that was built or changed in Python is written as the machine file that the command line reads."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import fric
from fric.estimate import as_filed
from fric.friction.directed import Completed, Directed, travels

CONFIGS = Path(__file__).parents[2] / "configs"


def again(machine, folder):
    machine.save(folder / "machine.yaml", force=True)
    return fric.read_machine(folder / "machine.yaml")


@pytest.mark.parametrize("name", ["xy-table", "virtual-rig", "reality/all", "reality/second-mass"])
def test_bundled_machines_are_read_as_they_were_saved(name, tmp_path):
    machine = fric.read_machine(CONFIGS / f"{name}.yaml")
    found = again(machine, tmp_path)
    assert as_filed(found.axes) == as_filed(machine.axes)
    assert as_filed(found.published) == as_filed(machine.published)
    assert found.name == machine.name


def test_what_was_changed_in_python_is_in_the_file(tmp_path):
    machine = fric.read_machine("xy-table")
    x = machine.axes["x"]
    worn = replace(x.friction.static, F_c=90.0, F_s=150.0)
    axis = replace(
        x, load=25.0, friction=Directed(replace(x.friction, static=worn), replace(worn, F_c=80.0)),
        blocks={"kalman": {"cutoff": 50.0}}, second_mass=None,
    )  # fmt: skip
    machine = replace(machine, name="worn", axes={"x": axis})
    machine = machine.with_belief(x=[fric.LuGre.typical(), replace(x.plant, T_d=1e-3), replace(x.cascade, K_v=77.0)])
    found = again(machine, tmp_path)
    read, saved = found.axes["x"], machine.axes["x"]
    assert list(read.nominal_friction.models) == ["static", "lugre"]  # the file holds its static map, too
    assert as_filed(replace(read, nominal_friction=saved.nominal_friction)) == as_filed(saved)
    assert as_filed(read.nominal_friction.models["lugre"]) == as_filed(saved.nominal_friction.models["lugre"])


def test_friction_that_no_file_holds_is_refused_with_what_to_do(tmp_path):
    machine = fric.read_machine("xy-table")
    added = (0.0,) * len(travels(1e-3))
    x = machine.axes["x"]
    machine = replace(machine, axes={"x": replace(x, friction=Completed(x.friction, added, added))})
    with pytest.raises(fric.FricError, match="no file holds the friction Completed"):
        machine.save(tmp_path / "machine.yaml")
    machine = fric.read_machine("xy-table").with_belief(
        x={"gms": x.friction, "static": replace(x.friction.static, F_c=1.0)}
    )
    with pytest.raises(fric.FricError, match="several 'static'"):
        machine.save(tmp_path / "machine.yaml")
    assert not (tmp_path / "machine.yaml").exists()
