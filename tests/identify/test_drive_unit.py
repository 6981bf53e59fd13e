"""Forces in the drive's own unit: the same friction, plant and circle as in newtons, and nothing made of them."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import fric
from fric.documents.friction import FrictionDocument
from fric.documents.yaml import plain, read_document, read_tree, write_document
from fric.errors import FricError
from fric.io.hdf5 import read_logs
from fric.io.ingest import ingest
from fric.units import SI_UNITS, factor, in_units_of, si_unit

DATA = Path(__file__).parents[2] / "data"
NEWTON_A_AMPERE = 50.0


def in_amperes(name: str) -> list[fric.Log]:
    """Return bundled records with their force as a drive of 50 N/A tells it."""
    found = []
    for log in read_logs(DATA / f"{name}.h5"):
        assert log.force is not None
        found.append(replace(log, force=log.force / NEWTON_A_AMPERE, motion="linear/A"))
    return found


def test_friction_in_amperes_is_that_in_newtons() -> None:
    amperes, newtons = (
        fric.identify_static(records, delta="1", over_position="off").document
        for records in (in_amperes("constant-velocity"), list(read_logs(DATA / "constant-velocity.h5")))
    )
    assert amperes["motion"] == "linear/A"
    for name, unit in (("F_c", "A"), ("F_s", "A"), ("sigma", "A*s/m"), ("v_s", "m/s")):
        one, other = amperes["static"][name], newtons["static"][name]
        scale = NEWTON_A_AMPERE if "A" in unit else 1.0
        assert one["unit"] == unit
        np.testing.assert_allclose(np.array(one["ci95"]) * scale, other["ci95"], rtol=2e-3)


def test_a_document_in_amperes_is_read_and_one_in_newtons_is_refused_beside_it(tmp_path: Path) -> None:
    path = tmp_path / "static.yaml"
    fric.identify_static(in_amperes("constant-velocity"), delta="1", over_position="off").save(path)
    read = read_document(path, FrictionDocument)
    assert read.motion == "linear/A"
    tree = plain(read_tree(path))
    tree["static"]["F_c"] = "100 N"
    write_document(path, tree, force=True)
    with pytest.raises(FricError, match="force cannot be in 'N'"):
        read_document(path, FrictionDocument)


@pytest.mark.parametrize(("unit", "motion", "scale"), [("A", "linear/A", 1.0), ("mA", "linear/A", 1e-3),
                                                       ("%", "linear/%", 1.0), ("N", "linear", 1.0)])  # fmt: skip
def test_a_log_keeps_the_unit_of_its_force(tmp_path: Path, unit: str, motion: str, scale: float) -> None:
    path = tmp_path / "log.csv"
    t = np.arange(200) * 1e-3
    header = f"time [s],position [mm],force [{unit}]"
    np.savetxt(path, np.column_stack([t, np.sin(t), np.cos(t)]), delimiter=",", header=header, comments="")
    ingest(path, tmp_path / "log.h5")
    (log,) = read_logs(tmp_path / "log.h5")
    assert log.motion == motion
    assert log.force is not None
    np.testing.assert_allclose(log.force, scale * np.cos(t), rtol=1e-6)
    with h5py.File(tmp_path / "log.h5") as file:
        assert file["records/log/force"].attrs["unit"] == si_unit("force", log.motion)


def test_records_in_amperes_and_newtons_go_into_no_common_file(tmp_path: Path) -> None:
    for name, unit in (("a", "A"), ("b", "N")):
        np.savetxt(tmp_path / f"{name}.csv", np.column_stack([np.arange(9), np.arange(9), np.arange(9)]), delimiter=",",
                   header=f"time [s],position [mm],force [{unit}]", comments="")  # fmt: skip
    with pytest.raises(FricError, match="force cannot be in 'N'"):
        ingest([tmp_path / "a.csv", tmp_path / "b.csv"], tmp_path / "log.h5")


def test_units_of_a_drive_ride_along_and_convert_to_no_newtons() -> None:
    assert [si_unit(one, "rotary/%") for one in ("mass", "viscous", "force per input")] == [
        "%*s^2/rad", "%*s/rad", "%/V",
    ]  # fmt: skip
    assert si_unit("stiffness", "linear/A") == "A/m"
    assert factor("mA/um", "stiffness", "linear/A") == pytest.approx(1e3)
    assert in_units_of("rotary", "mA") == "rotary/A"
    assert in_units_of("rotary", "N*m") == "rotary"
    for dimension in SI_UNITS:
        assert factor(si_unit(dimension, "linear/count"), dimension, "linear/count") == 1.0
    for wrong in ("N", "A", "1", ""):
        with pytest.raises(FricError):
            factor(wrong, "force", "linear/%")


def table_in_amperes(path: Path) -> Path:
    """Write the paper's table with its forces in A, at 50 N/A, and return the file."""

    def converted(node: Any) -> Any:
        if isinstance(node, list):
            return [converted(one) for one in node]
        if not isinstance(node, dict):
            return node
        if str(node.get("unit", "")).startswith("N"):
            value = np.asarray(node["value"]) / NEWTON_A_AMPERE
            return node | {"unit": "A" + node["unit"][1:], "value": value.tolist()}
        return {key: converted(one) for key, one in node.items()}

    tree = converted(plain(read_tree(DATA.parent / "configs" / "xy-table.yaml")))
    for axis in tree["axes"].values():
        axis["motion"] = "linear/A"
    write_document(path, tree)
    return path


def test_a_circle_and_an_export_in_amperes_are_those_in_newtons(tmp_path: Path) -> None:
    table = table_in_amperes(tmp_path / "table.yaml")
    ours, theirs = (fric.circle(one, "a,f").document["schemes"] for one in (table, "xy-table"))
    for scheme in "af":
        assert ours[scheme]["glitch"] == pytest.approx(theirs[scheme]["glitch"], rel=1e-6)
    exported = fric.export_axis("csv", table, axis="x", scheme="f", force=True)
    files, manifest = exported.files, exported.document
    assert manifest["parameters"]["K_f"] == {"value": pytest.approx(548 / 50), "unit": "A/V"}
    assert manifest["friction"]["static"]["F_c"] == {"value": pytest.approx(2.1), "unit": "A"}
    assert "friction [A]" in files["fric_x-steady.csv"]
