"""Exported units: FMPy finds them valid, and simulates what the library does."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pytest

from fric.export.base import ExportedPart
from fric.export.fmi import fmi_files
from fric.friction import models
from tests.export.parts import (
    EXPORTED,
    SAMPLES,
    SAMPLING,
    along_a_run,
    exportable,
    motions,
    part,
    replayed,
    scheme_part,
    typical,
)
from tests.turns import in_turns

fmpy = pytest.importorskip("fmpy")
pytestmark = pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler is installed")


class Unit:
    """A unit that was exported, loaded as a co-simulation slave by FMPy."""

    def __init__(self, content: str | bytes, version: int, folder: Path) -> None:
        from fmpy import extract, read_model_description
        from fmpy.validation import validate_fmu

        file = folder / "unit.fmu"
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
        assert validate_fmu(str(file)) == []
        told = read_model_description(str(file))
        self.index = {one.name: one.valueReference for one in told.modelVariables}
        self.version, self.place, self.told = version, extract(str(file), str(folder / f"unit{version}")), told

    def run(self, wanted: str, rows: Iterable[tuple[float, ...]], names: Sequence[str]) -> np.ndarray:
        """Step a new instance through rows of inputs, and return an output behind each."""
        from fmpy import fmi2, fmi3

        slave = {2: fmi2.FMU2Slave, 3: fmi3.FMU3Slave}[self.version](
            guid=self.told.guid, unzipDirectory=self.place, instanceName="one",
            modelIdentifier=self.told.coSimulation.modelIdentifier,
        )  # fmt: skip
        slave.instantiate()
        if self.version == 2:
            slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        put, get = (slave.setReal, slave.getReal) if self.version == 2 else (slave.setFloat64, slave.getFloat64)
        given, asked, found = [self.index[name] for name in names], [self.index[wanted]], []
        for n, row in enumerate(rows):
            put(given, row)
            slave.doStep(n / SAMPLING, 1 / SAMPLING)
            found.append(get(asked)[0])
        assert get([self.index["fault"]]) == [0.0]
        slave.terminate()
        slave.freeInstance()
        return np.array(found)


def _units(one: ExportedPart, folder: Path) -> list[Unit]:
    """The units of both versions, which are made at once."""
    made = {int(name[-5]): content for name, content in fmi_files(one).items()}
    assert sorted(made) == [2, 3]
    return [Unit(content, version, folder) for version, content in made.items()]


QUICK = "gms", "lugre by direction"
"""With blocks, and without, of two directions."""


@pytest.mark.parametrize("samples", [3000, pytest.param(SAMPLES, marks=pytest.mark.long)])
@pytest.mark.parametrize("name", in_turns(exportable(), QUICK))
def test_a_unit_gives_the_librarys_force(name: str, samples: int, tmp_path: Path) -> None:
    model = typical(name)
    units = _units(part(model, lead=0.0), tmp_path)
    for motion, (dz, v) in motions(samples).items():
        z = np.cumsum(dz)
        library = replayed(model, np.diff(z, prepend=z[0]), v, begins=True)
        for unit in units:
            found = unit.run("force", zip(z.tolist(), v.tolist(), strict=True), ("position", "velocity"))
            assert np.abs(found - library).max() <= 1e-9, (motion, unit.version)


@pytest.mark.parametrize("scheme", in_turns(EXPORTED, ("f",)))
def test_a_unit_adds_what_the_simulated_controller_added(scheme: str, tmp_path: Path) -> None:
    asked, added = along_a_run(scheme)
    names = ("position", "velocity", "acceleration", "measured", "control", "input")
    rows = [tuple(one[name] for name in names) for one in asked]
    for unit in _units(scheme_part(scheme), tmp_path):
        found = unit.run("volts", rows, (*names[:5], "previous"))
        assert np.abs(found - added).max() <= 1e-9, unit.version


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
