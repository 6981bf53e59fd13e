"""Exported units: FMPy finds them valid, and simulates what the library does."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from fric.export.fmi import fmi_files
from fric.friction import models
from tests.export.parts import SAMPLING, part, replayed

fmpy = pytest.importorskip("fmpy")
pytestmark = pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler is installed")


@pytest.mark.parametrize("version", [2, 3])
def test_a_unit_gives_the_librarys_force_along_a_circle(version: int, tmp_path: Path) -> None:
    from fmpy.validation import validate_fmu

    model = models()["gms"].typical()
    content = fmi_files(part(model, lead=0.0))[f"fric_x-fmi{version}.fmu"]
    file = tmp_path / "unit.fmu"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    assert validate_fmu(str(file)) == []
    t = np.arange(2001) / SAMPLING
    w = 100 / 30
    columns = {"position": 0.03 * np.sin(w * t), "velocity": 0.03 * w * np.cos(w * t),
               "acceleration": -0.03 * w**2 * np.sin(w * t)}  # fmt: skip
    kinds = [("time", "f8"), *((name, "f8") for name in columns)]
    given = np.array(list(zip(t, *columns.values(), strict=True)), dtype=kinds)
    found = fmpy.simulate_fmu(
        str(file), stop_time=0.5, step_size=1 / SAMPLING, output_interval=1 / SAMPLING, input=given,
        output=["force", "fault"], fmi_type="CoSimulation",
        start_values={"measured": 0.0, "control": 0.0, "previous": 0.0},
    )  # fmt: skip
    z = columns["position"]
    # row n + 1 of the result is after the step that began at n, with the input that FMPy held from there
    library = replayed(model, np.append(0.0, np.diff(z))[:2000], columns["velocity"][:2000])
    state, step = model.initial_state(), type(model).step
    library[0] = step(0.0, columns["velocity"][0], 0.0, state, model.packed())
    for n in range(1, 2000):
        library[n] = step(z[n] - z[n - 1], columns["velocity"][n], 1 / SAMPLING, state, model.packed())
    assert np.abs(found["force"][1:2001] - library).max() < 1e-9 * 150
    assert not found["fault"].any()


@pytest.mark.parametrize("version", [2, 3])
def test_the_axis_as_a_unit_stands_still_until_it_breaks_away(version: int, tmp_path: Path) -> None:
    model = models()["gms"].typical()
    content = fmi_files(part(model, "machine"))[f"fric_x_machine-fmi{version}.fmu"]
    file = tmp_path / "unit.fmu"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())

    def travel(volts: float) -> float:
        t = np.array([0.0, 1.0])
        given = np.array([(one, volts) for one in t], dtype=[("time", "f8"), ("voltage", "f8")])
        found = fmpy.simulate_fmu(
            str(file), stop_time=0.5, step_size=1 / SAMPLING, output_interval=0.1, input=given, output=["position"],
            fmi_type="CoSimulation",
        )  # fmt: skip
        return float(found["position"][-1])

    assert 0 < travel(0.4 * 150 / 548) < 1e-4  # a step below half of break-away: in the springs
    assert travel(1.5 * 150 / 548) > 1e-2
