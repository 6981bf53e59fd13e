"""Every document is one typed schema: what is written is checked as what is read, and older files stay readable."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from contextlib import nullcontext
from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np
import pytest

import fric
from fric.documents import document_types
from fric.documents.base import CodedWarning
from fric.documents.circle_findings import ResidualPart
from fric.documents.controller import ControllerDocument
from fric.documents.friction import FrictionDocument, gms_tree, replay_tree, static_tree
from fric.documents.machine_files import read_machine
from fric.documents.plant import PlantDocument, plant_tree
from fric.documents.yaml import dump, plain, read_document, read_tree, write_document
from fric.errors import FricError
from fric.estimate import Estimate
from fric.identify.gms.identify import identify_gms
from fric.identify.plant.identify import identify_plant
from fric.identify.replay.replay_fit import identify_by_replay
from fric.identify.static_map.identify import identify_static
from fric.identify.static_map.points import Asked
from fric.io.hdf5 import read_logs, read_records
from fric.notice import Notice
from fric.records.prepared import prepared
from fric.report.collect import collect
from fric.report.view import render_report
from fric.units import readable, significant
from tests.legs import numpys

BEFORE = Path(__file__).parent / "before"
LOGS = Path(__file__).parents[2] / "data"


def axis_plant(folder: Path) -> fric.Plant:
    records = read_records(LOGS / "frequency-response.h5")
    path = folder / "plant.yaml"
    write_document(path, plant_tree(identify_plant(records), records))
    return read_document(path, PlantDocument).plant("linear")


@pytest.mark.parametrize("path", sorted(BEFORE.glob("*.yaml")), ids=lambda path: path.stem)
def test_files_of_the_version_before_are_read_with_all_that_they_hold(path: Path) -> None:
    tree = plain(read_tree(path))
    kind = document_types()[tree["fric"].partition("/")[0]]
    document = read_document(path, kind)
    assert [str(one) for one in document.notices()] == tree["warnings"]
    assert {one.severity for one in document.notices()} <= {"doubt"}
    again = document.tree()
    for key in ("static", "static_negative", "gms", "lugre", "A", "B", "T_d", "K_f", "K_v", "cutoff"):
        assert (key in tree) == (key in again)
        for name, entry in (tree.get(key) or {}).items():
            assert again[key][name] == entry


def test_the_words_of_older_files_become_data_once() -> None:
    assert read_document(BEFORE / "static.yaml", FrictionDocument).fit_of("static").taken_off == ["damping"]
    assert read_document(BEFORE / "static-each.yaml", FrictionDocument).fit_of("static").taken_off is None
    gms = read_document(BEFORE / "gms.yaml", FrictionDocument)
    assert gms.fit_of("gms").taken_off == ["inertia", "damping"]
    assert gms.fit_of("static").taken_off == ["damping"]
    law, load = read_document(BEFORE / "plant-of-motion.yaml", PlantDocument).coulomb()
    assert (law.F_c, load) == (pytest.approx(20.0166), pytest.approx(1.49542))


def test_a_static_map_carries_plant_and_covariance_into_the_files_that_build_upon_it(tmp_path: Path) -> None:
    plant, logs = axis_plant(tmp_path), read_logs(LOGS / "constant-velocity.h5")
    fit = identify_static(logs, Asked(plant=plant, delta=1.0, over_position="off"))
    path = tmp_path / "static.yaml"
    write_document(path, static_tree(fit, logs))
    document = read_document(path, FrictionDocument)
    told = document.fit_of("static")
    assert told.plant is not None
    assert told.plant.plant("linear").damping == pytest.approx(plant.damping, rel=1e-5)
    assert told.covariance is not None
    assert told.covariance.names == ["F_c", "F_s", "v_s", "sigma", "offset"]
    deviation = np.sqrt(np.diag(told.covariance.matrix))
    for name, one in zip(told.covariance.names, deviation, strict=True):
        low, high = fit.static.estimates[name].ci95  # profile likelihood and covariance tell nearly the same
        assert (high - low) / 2 == pytest.approx(2.05 * one, rel=0.15)
    waves = read_logs(LOGS / "sliding-sine.h5")
    given = read_document(path, FrictionDocument)
    gms = FrictionDocument.model_validate(
        gms_tree(identify_gms(read_logs(LOGS / "presliding-sine.h5"), static=given.maps()[0], blocks=3), waves, given)
    )
    lugre = FrictionDocument.model_validate(
        replay_tree(identify_by_replay("lugre", prepared(waves), static=document.estimates("static")), document)
    )
    for built, name in ((gms, "gms"), (lugre, "lugre")):
        block = built.fit_of(name).covariance
        assert block is not None
        within = built.estimates(name)
        for one, scale, row in zip(block.names, block.scales, np.diag(block.matrix), strict=True):
            symbol, _, number = one.rpartition("_") if name == "gms" and one != "C" else (one, "", "")
            value, limits = within[symbol].value, within[symbol].ci95
            if number:
                value, limits = value[int(number) - 1], limits[int(number) - 1]
            if scale == "log" and limits[0] > 0 and limits[1] < np.inf:  # half the interval is two deviations or so
                assert np.log(limits[1] / limits[0]) / 2 == pytest.approx(2.0 * np.sqrt(row), rel=0.15)
        assert built.fit_of("static") == told
        assert set(document.notices()) <= set(built.notices())
        assert all(one.carried for one in built.notices() if one in document.notices())  # and is not said again
        assert built.provenance.static["logs"][0]["record"] == "constant-velocity-01"
    assert lugre.fit_of("lugre").r2 is not None
    assert lugre.fit_of("lugre").rmse != told.rmse


def test_a_notice_goes_through_a_file_with_code_and_severity(tmp_path: Path) -> None:
    notices = [Notice("the force lags: mend it.", "force-lags", "wrong"), Notice("known", "seen", "note"), "a text"]
    document = PlantDocument.made(
        {"axis": "x", "A": "2 1/s", "T_d": "1 ms"}, notices=[*notices, "a text"], also={"static": {"fric": "0"}}
    )
    path = tmp_path / "plant.yaml"
    write_document(path, document.tree())
    read = read_document(path, PlantDocument)
    assert [(str(one), one.code, one.severity) for one in read.notices()] == [
        ("the force lags: mend it.", "force-lags", "wrong"), ("known", "seen", "note"), ("a text", "", "doubt"),
    ]  # fmt: skip
    assert plain(read_tree(path))["warnings"] == [str(one) for one in notices]


def test_what_fits_no_schema_is_told_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "friction.yaml"
    head = "fric: friction/1\naxis: x\nstatic:\n  F_c: 100 N\n  F_s: 150 N\n  v_s: 1 mm/s\n"
    path.write_text(head + "lugre_fit:\n  r2: good\n")
    with pytest.raises(FricError, match=r"lugre_fit.r2: give a number") as caught:
        read_document(path, FrictionDocument)
    assert str(caught.value.where).endswith("line 8")
    path.write_text(head + "lugre:\n  sigma_9: 1 N/m\n")
    with pytest.raises(FricError, match="'sigma_9' is not a parameter"):
        read_document(path, FrictionDocument)
    path.write_text(head + "coulomb:\n  F: 1 N\n")
    with pytest.raises(FricError, match="'coulomb' is not a friction model"):
        read_document(path, FrictionDocument)
    path.write_text(head + "fit:\n  covariance: {names: [F_c], scales: [linear], matrix: [[1, 2]]}\n")
    with pytest.raises(FricError, match="does not fit its 1 names"):
        read_document(path, FrictionDocument)


def test_every_type_has_a_schema_in_which_warnings_are_records() -> None:
    for kind in document_types().values():
        schema = kind.json_schema()
        assert schema["properties"]["fric"]
        assert set(schema["$defs"]["CodedWarning"]["properties"]) == set(CodedWarning.model_fields)
    friction = FrictionDocument.json_schema()
    assert "1/s" in str(PlantDocument.json_schema()["properties"]["A"])
    assert set(friction["properties"]["lugre"]["properties"]) == {"sigma_0", "sigma_1"}
    assert not friction["additionalProperties"]
    assert friction["properties"]["gms_fit"]["$ref"] == "#/$defs/Fit"


def test_doubts_of_a_file_are_told_again_by_what_builds_upon_it(tmp_path: Path) -> None:
    """A plant with a misfit: the design, the circle and its report all say so; a note stays where it is."""
    told = [
        Notice("eq. (1) leaves 40 % that noise does not explain", "response-misfit", "wrong"),
        Notice("A holds the guideway's viscous friction", "damping-joint", "note"),
    ]
    plant = tmp_path / "plant.yaml"
    content = {"axis": "x", "A": "17 1/s", "B": "2.4 m/(s^2*V)", "T_d": "0.6 ms", "K_f": "548 N/V"}
    write_document(plant, PlantDocument.made(content, notices=told).tree())
    retold = "plant of axis x: eq. (1) leaves 40 % that noise does not explain"
    observer = fric.design_observer(plant)
    assert retold in observer.document["warnings"]
    coded = {one["text"]: one for one in observer.document["warnings_coded"]}
    assert (coded[retold]["code"], coded[retold]["severity"]) == ("response-misfit", "wrong")
    assert not any("guideway" in text for text in observer.document["warnings"])
    assert retold in fric.design_controller(plant).document["warnings"]
    observer.save(tmp_path / "observer.yaml")
    machine = read_machine(
        Path("configs/xy-table.yaml"), nominal_files=[f"x={plant}", f"x={tmp_path / 'observer.yaml'}"]
    )
    assert [str(one) for one in machine.warnings].count(retold) == 1  # told twice over, and said once
    found = fric.circle(machine, "a", radius=0.005)
    assert retold in found.document["warnings"]
    assert set(document_types()["circle-result"].model_validate(found.document).model_fields_set) >= {"schemes"}
    found.save(tmp_path / "run.h5")
    page = render_report(collect([tmp_path / "run.h5", plant]))
    assert page.count("eq. (1) leaves 40 % that noise does not explain") >= 2


def test_what_commands_print_besides_files_is_typed_too(tmp_path: Path) -> None:
    """Inspect, ingest and report: each prints a document that its schema takes again, and the schema names each key."""
    strokes = sorted((LOGS / "strokes").glob("*.csv"))[::4]
    read = fric.ingest(*strokes, output=tmp_path / "log.h5", kind="constant-velocity")
    table = fric.ForceVelocity(np.array([-1.0, 1.0]), np.array([-5.0, 5.0]))
    results = [
        read,
        fric.inspect(tmp_path / "log.h5", LOGS / "presliding-sine.h5", table),
        fric.make_report(BEFORE / "static.yaml", BEFORE / "gms.yaml"),
    ]
    for result, name in zip(results, ("ingest", "inspection", "report"), strict=True):
        document = result.document
        assert document["fric"] == f"{name}/1"
        kind = document_types()[name]
        again = kind.model_validate(document)
        assert again.tree() == document
        assert set(document) <= set(fric.document_schema(name)["properties"])
        json.dumps(document, allow_nan=False)
        assert [one["text"] for one in document["warnings_coded"]] == document["warnings"]
    records = results[1].document["records"]
    typed = document_types()["inspection"].model_validate(results[1].document).records
    assert {type(one).__name__ for one in typed} == {"InspectedLog", "InspectedTable"}
    assert records[0]["channels"]["force"]["unit"] == "N"


def test_a_tuning_whose_noise_is_not_known_is_told_so() -> None:
    """Circles whose voltage leaves no noise to tell, as LinuxCNC's: nothing ends for it."""
    given = {"before": 0.01, "after": 0.001, "noise": None}
    assert ResidualPart.model_validate(given).noise is None


@pytest.mark.skipif(platform.machine() != "x86_64", reason="names kernels and instructions of x86-64")
def test_provenance_tells_the_kernels_of_blas_and_the_vector_instructions() -> None:
    chosen = np.show_config(mode="dicts")["SIMD Extensions"]
    settings = {"OPENBLAS_CORETYPE": "Sandybridge", "NPY_DISABLE_CPU_FEATURES": numpys(0)}
    code = "from fric.documents.base import provenance; print(*map(provenance().get, ('blas', 'simd')), sep='\\n')"
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | settings, capture_output=True, text=True, check=True
    )
    blas, simd = done.stdout.splitlines()
    assert blas.startswith("openblas 0.")
    assert all(one.endswith(" Sandybridge") for one in blas.split(", "))
    assert simd == chosen["baseline"][-1]


def test_the_load_is_the_mean_over_the_records_that_were_fitted() -> None:
    """A load belongs to the axis, and not to the name of a record."""
    content = {
        "axis": "x", "motion": "linear", "dahl": {"F_c": "50 N", "sigma_0": "1e6 N/m"},
        "dahl_fit": {"records": [{"record": name, "offset": f"{load} N"} for name, load in (("a", 30.0), ("b", 34.0))]},
    }  # fmt: skip
    document = FrictionDocument.model_validate({"fric": FrictionDocument.type_name(), **content})
    assert document.found_with("dahl")[1] == 32.0


@pytest.mark.parametrize("value", [np.inf, -np.inf, np.nan])
def test_no_document_holds_what_is_no_number(tmp_path, value):
    """As "inf" and "nan" in the YAML of `identify gms` and in a report."""
    whole = {"axis": "x", "A": {"value": 1.0, "unit": "1/s"}, "T_d": "1 ms", "B": {"value": value, "unit": "m/(s^2*V)"}}
    with pytest.raises(FricError, match="comes out as no number"):
        PlantDocument.made(whole)
    path = tmp_path / "a.yaml"
    path.write_text(dump({"fric": "plant/1"} | whole))
    with pytest.raises(FricError, match="B"):
        read_document(path, PlantDocument)
    assert readable(value, "m") == significant(value) == "–"


@pytest.mark.parametrize("frequency", ["{value: [1.0, 2.0], unit: Hz}", "null"])
def test_a_limit_of_an_observer_is_a_number_or_none(tmp_path, frequency):
    """A list, or no cutoff, ended `fric report` in a traceback."""
    file = tmp_path / "observer.yaml"
    limits = f"{{robust: {{cutoff: null, frequency: {frequency}, Delta: {{value: 1.5, unit: '1'}}}}}}"
    file.write_text(f"fric: observer/1\naxis: x\ncutoff: 40 Hz\nlimits: {limits}\n")
    if frequency == "null":
        assert "cutoff" in render_report(collect([file]))
    else:
        with pytest.raises(FricError, match="frequency: a list of 2 where one value is expected"):
            collect([file])


def test_a_record_without_terms_of_its_own_has_none():
    (record,) = prepared([fric.Log(np.arange(9.0), np.arange(9.0), force=np.sin(np.arange(9.0)))])
    bare = replace(record, done=replace(record.done, own=()))
    assert bare.own.shape == (9, 0)


def test_an_interval_that_reaches_beyond_all_drives_is_open() -> None:
    """A fit of 1.5e-9 N·s/m gave a limit of 1.5e19 N·s/m, which says nothing and looks as if it did."""
    found = Estimate(1.5e-9, "N*s/m", (0.0, 1.5e19))
    assert found.limits == (0.0, inf)
    assert found.as_dict()["ci95"] == [0.0, None]
    assert Estimate.read(found.as_dict()) == found
    assert Estimate((1.0, 2.0), "N/m", ((-1e16, 3.0), (0.0, 1e14))).ci95 == ((-inf, 3.0), (0.0, 1e14))


@pytest.mark.parametrize("text", ["!!binary aGVsbG8=", "2024-01-01T10:00:00", "!!set {a, b}", "!!omap [a: 1]"])
def test_a_type_of_yaml_that_no_part_has_is_refused(text: str, tmp_path: Path) -> None:
    """It was taken for an object of which the part is made: a traceback."""
    file = tmp_path / "plant.yaml"
    file.write_text(f"fric: plant/1\naxis: x\nA: 20 1/s\nB: 3 m/(s^2*V)\nT_d: 0.6 ms\nfit:\n  friction: {text}\n")
    with pytest.raises(FricError, match=r"friction"):
        read_document(file, PlantDocument)


def test_the_plant_of_a_fit_is_in_units_of_a_plant(tmp_path: Path) -> None:
    """Its A in ㎜ was read, and ended a report in a traceback."""
    file, static = tmp_path / "friction.yaml", "F_c: 105 N, F_s: 165 N, v_s: 1 mm/s, sigma: 40 N*s/m"
    plant = "B: 3 m/(s^2*V), T_d: 0.6 ms, K_f: 500 N/V"
    for A, fits in (("20 1/s", True), ("5 ㎜", False)):
        text = f"fric: friction/1\naxis: x\nstatic: {{{static}}}\nfit: {{plant: {{A: {A}, {plant}}}}}\n"
        file.write_text(text, "utf-8")
        with nullcontext() if fits else pytest.raises(FricError, match=r"plant.*A: "):
            read_document(file, FrictionDocument)


def test_gains_are_of_an_axis_whatever_its_forces_are_in() -> None:
    """A circle without force showed them, the logs had a current: `auto` ended at its machine file."""
    head = {"fric": "controller/1", "axis": "y", "K_v": "80 1/s", "K_p": "180 V*s/m", "K_i": "9000 V/m"}
    head |= {"velocity_filter": "500 Hz", "sampling": "4 kHz"}
    gains = ControllerDocument.model_validate(head | {"motion": "linear"})
    assert gains.belongs("y", "linear/A")
    assert not gains.belongs("x", "linear/A")
    assert not gains.belongs("y", "rotary")
    assert not gains.belongs("y", "linear/%/%")  # whose input is in per cent, too
    plant = {"fric": "plant/1", "axis": "y", "A": "7 1/s", "B": "2 m/(s^2*V)", "T_d": "0.7 ms", "K_f": "250 N/V"}
    assert not PlantDocument.model_validate(plant | {"motion": "linear"}).belongs("y", "linear/A")
