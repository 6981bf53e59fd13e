"""`fric export` as a user runs it."""

from __future__ import annotations

import csv
import json
import re
import shutil
from dataclasses import replace
from functools import cache
from hashlib import sha256
from pathlib import Path
from pickle import dumps

import numpy as np
import pytest
from scipy.io import loadmat

import fric
from fric.control.scheme import PAPER_SCHEMES, Scheme
from fric.errors import FricError
from fric.estimate import Estimate
from fric.export import targets
from fric.export.sinumerik import rise_of, through_controller
from fric.export.tables import sheets
from fric.export.twincat import POINTS, list_of
from fric.flaws.static_map import FORCE_OVER_POSITION
from fric.friction.gms import GMS
from fric.results.export import ExportResult, _of_session
from fric.simulate.contour_run import Circle, CircleRun, run_circle
from fric.simulate.machine import Machine
from tests.export.parts import MACHINE, part, scheme_part
from tests.turns import in_turns

SPOILING = """fric: friction/1
axis: x
motion: linear
static:
  F_c: {value: 500, unit: N}
  F_s: {value: 900, unit: N}
  v_s: {value: 1, unit: mm/s}
"""
DOUBTED = """fric: friction/1
axis: x
motion: linear
static:
  F_c: {value: 80, unit: N}
  F_s: {value: 120, unit: N}
  v_s: {value: 1, unit: mm/s}
warnings: [the logged force lags]
warnings_coded: [{code: force-lags, severity: wrong, text: the logged force lags}]
"""


@pytest.fixture(autouse=True)
def simulated_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Simulate a circle by which exports are judged once: it takes a second at 10 mm/s, and many judge the same."""
    monkeypatch.setattr("fric.results.export.run_circle", once)


RUNS: dict[bytes, CircleRun] = {}


def once(machine: Machine, scheme: Scheme, test: Circle, *, only: str) -> CircleRun:
    if (key := dumps((machine, scheme, test, only))) not in RUNS:
        RUNS[key] = run_circle(machine, scheme, test, only=only)
    return RUNS[key]


@cache
def exported(target: str) -> ExportResult:
    return fric.export_axis(
        target, MACHINE, axis="x", scheme="b" if target == "twincat" else "c", gain=1.0, lead="auto"
    )


@pytest.mark.parametrize("target", in_turns(sorted(targets()), sorted(set(targets()) - {"sinumerik"}), 3))
def test_every_target_writes_its_files_and_a_manifest_that_holds_their_digests(
    target: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # of what is trusted no file but the manifest tells: it is judged for one target
    if target != "c":
        monkeypatch.setattr("fric.results.export.trust_of", lambda *given, **known: ([], []))
    found = exported(target)
    found.save(tmp_path / "out", force=True)
    manifest = json.loads((tmp_path / "out/manifest.json").read_text())
    written = {file.name: file for file in (tmp_path / "out").iterdir() if file.name != "manifest.json"}
    assert manifest["files"] == {name: sha256(file.read_bytes()).hexdigest() for name, file in written.items()}
    assert manifest["sources"] == [{"file": str(MACHINE), "sha256": sha256(MACHINE.read_bytes()).hexdigest()}]
    assert manifest["friction"]["static"]["F_s"] == {"value": 165.0, "unit": "N"}
    if target != "sinumerik":  # it takes 5 s; the files of its page are made anew in test_docs.py
        assert exported.__wrapped__(target).files == found.files


def test_a_friction_that_makes_the_circle_worse_is_not_exported_unless_forced(tmp_path: Path) -> None:
    (tmp_path / "f.yaml").write_text(SPOILING)
    found = fric.export_axis("c", MACHINE, axis="x", scheme="b", nominal_files=[f"x={tmp_path / 'f.yaml'}"])
    with pytest.raises(FricError, match=r"not to be trusted: axis x at 100 mm/s: Scheme b leaves"):
        found.save(tmp_path / "out")
    assert not (tmp_path / "out").exists()
    found.save(tmp_path / "out", force=True)
    assert "scheme-spoils" in (tmp_path / "out/manifest.json").read_text()


def test_what_a_file_says_of_itself_stands_against_its_export(tmp_path: Path) -> None:
    (tmp_path / "f.yaml").write_text(DOUBTED)
    found = fric.export_axis("c", MACHINE, axis="x", scheme="b", nominal_files=[f"x={tmp_path / 'f.yaml'}"])
    assert [one.code for one in found.against] == ["force-lags"]
    assert "the logged force lags" in repr(found)


@pytest.mark.parametrize("taken_off", [True, False])
def test_a_force_over_position_that_is_taken_off_is_no_reason_against_an_export(
    taken_off: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was wrong until mended, with the remedy to take it off."""
    notice = FORCE_OVER_POSITION.found(
        varies=Estimate(12.0, "N"), length=Estimate(0.03, "m"), either=False, level=30.0, half_width=0.1,
        taken_off=taken_off,
    )  # fmt: skip
    text = DOUBTED.replace("force-lags", notice.code).replace("severity: wrong", f"severity: {notice.severity}")
    (tmp_path / "f.yaml").write_text(text)
    short = Circle(feed=0.2)
    monkeypatch.setattr("fric.results.export.run_circle", lambda *of, only: run_circle(*of[:2], short, only=only))
    found = fric.export_axis("c", MACHINE, axis="x", scheme="b", nominal_files=[f"x={tmp_path / 'f.yaml'}"])
    assert notice.code in [one.code for one in found.notices]
    assert [one.code for one in found.against if one.code == notice.code] == [notice.code] * (not taken_off)


def test_a_folder_of_auto_gives_machine_run_and_circle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    command = "fric simulate circle found/machine.yaml --measured 'my circle.h5' --monte-carlo 24 -o found/circle.h5"
    monkeypatch.setattr("fric.results.export.read_run_provenance", lambda path: {"command": command})
    machine, run = tmp_path / "machine.yaml", tmp_path / "circle.h5"
    assert _of_session(tmp_path, (), ()) == (machine, (), ())
    run.touch()
    assert _of_session(tmp_path, (), ()) == (machine, [run], ["my circle.h5"])
    assert _of_session(tmp_path, ["r.h5"], ["c.h5"]) == (machine, ["r.h5"], ["c.h5"])
    # `fric auto logs -o ../found` was run in a folder beside it
    command = "fric simulate circle ../found/machine.yaml --measured ../found/circles/c.h5 -o ../found/circle.h5"
    folder = tmp_path / "found"
    (folder / "circles").mkdir(parents=True)
    (folder / "circle.h5").touch()
    (folder / "circles/c.h5").touch()
    (*_, (circle,)) = _of_session(folder, (), ())
    assert Path(circle).samefile(folder / "circles/c.h5")


@pytest.mark.parametrize(("schemes", "best"), [("a,b,c", "b"), ("a,c", "c")])
def test_a_folder_of_auto_is_exported_in_the_scheme_that_its_run_recommends(
    schemes: str, best: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It ended in "the run is without scheme f", beside a verdict for another."""
    monkeypatch.setattr("fric.results.export.trust_of", lambda *given, **known: ([], []))
    shutil.copy(MACHINE, tmp_path / "machine.yaml")
    of = {"axis": "x", "machines": 3, "workers": 1, "seed": 1, "revolutions": 1, "radius": "10 mm"}
    run = fric.circle(tmp_path / "machine.yaml", schemes, **of)
    run.save(tmp_path / "circle.h5")
    assert run.verdict.choice is not None
    assert run.verdict.choice.scheme.name == best
    assert fric.export_axis("c", tmp_path, axis="x").part.scheme == best
    assert fric.export_axis("c", tmp_path, axis="x", scheme="c").part.scheme == "c"
    (tmp_path / "circle.h5").unlink()
    assert fric.export_axis("c", tmp_path, axis="x").part.scheme == "f"


def test_a_measured_circle_that_is_not_as_predicted_forbids_the_export(tmp_path: Path) -> None:
    risen = MACHINE.parent / "risen/machine.yaml"
    for machine, agrees in ((MACHINE, True), (risen, False)):
        run = fric.circle(machine, "a")
        run.save(tmp_path / "circle.h5", force=True)
        found = fric.export_axis("csv", MACHINE, axis="x", scheme="c", circles=[tmp_path / "circle.h5"])
        assert {one.code for one in found.against} == (set() if agrees else {"not-as-predicted"})
        assert "no-measured-circle" not in [one.code for one in found.distrust]
    with pytest.raises(FricError, match=r"not to be trusted: .*circle.h5: .* shows .*the whole level"):
        found.save(tmp_path / "out")


def test_what_the_verdict_doubts_is_told_and_kept(tmp_path: Path) -> None:
    found = fric.export_axis("csv", MACHINE, axis="x", scheme="c")
    assert {one.code for one in found.distrust} >= {"no-measured-circle"}
    assert "Not to be trusted yet" in repr(found)
    assert not found.document["verdict"]["trusted"]
    with pytest.raises(FricError, match=r"not to be trusted yet. .*no varied machines were simulated"):
        found.save(tmp_path / "out")
    with pytest.raises(FricError, match="not to be trusted yet"):  # before LinuxCNC is started
        fric.export_axis("linuxcnc", MACHINE, axis="x", scheme="c", trial=tmp_path / "trial")
    assert not list(tmp_path.iterdir())


@pytest.mark.long(6)  # the page targets.md has an axis that is trusted, too
def test_what_the_verdict_trusts_is_exported(tmp_path: Path) -> None:
    fric.circle(MACHINE, "a").save(tmp_path / "circle.h5")
    fric.circle(MACHINE, "a,c", machines=20, axis="x", workers=1).save(tmp_path / "run.h5")
    known = {"axis": "x", "drawn": [tmp_path / "run.h5"], "circles": [tmp_path / "circle.h5"]}
    found = fric.export_axis("csv", MACHINE, scheme="c", **known)
    assert found.document["verdict"] == {"trusted": True, "why": []}
    found.save(tmp_path / "out")
    alone = fric.export_axis("csv", MACHINE, scheme="c", **(known | {"circles": []}))
    assert [one.code for one in alone.distrust] == ["no-measured-circle"]


@pytest.mark.long(3)
def test_a_run_of_machines_that_does_not_fit_the_export_is_refused(tmp_path: Path) -> None:
    fric.circle(MACHINE, "a").save(tmp_path / "circle.h5")
    fric.circle(MACHINE, "a,c", machines=2, axis="y", workers=1).save(tmp_path / "run.h5")
    known = {"axis": "y", "drawn": [tmp_path / "run.h5"], "circles": [tmp_path / "circle.h5"]}
    for other, told in (
        ({"scheme": "f"}, "without scheme f"),
        ({"scheme": "c", "gain": 1.0}, "another friction, gain"),
    ):
        with pytest.raises(FricError, match=told):
            fric.export_axis("csv", MACHINE, **(known | other))
    with pytest.raises(FricError, match="without axis x"):
        fric.export_axis("csv", MACHINE, scheme="c", **(known | {"axis": "x"}))
    few = fric.export_axis("csv", MACHINE, scheme="c", **known)
    assert [one.code for one in few.distrust] == ["few-machines"]


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (("cc", {}), "there is no target 'cc'"),
        (("st", {"part": "machine"}), "has no part 'machine'"),
        (("st", {"single": True}), "has no single precision"),
        (("c", {"scheme": "a"}), "feeds no friction forward"),
        (("c", {"axis": "w"}), "no axis 'w'"),
        (("csv", {"trial": "somewhere"}), "a trial is for the target linuxcnc"),
    ],
)
def test_what_cannot_be_is_told_in_a_sentence(given: tuple[str, dict[str, object]], told: str, tmp_path: Path) -> None:
    target, options = given
    with pytest.raises(FricError, match=told):
        fric.export_axis(target, MACHINE, **({"axis": "x"} | options))  # type: ignore[arg-type]


def test_a_file_that_exists_is_kept_and_nothing_is_half_written(tmp_path: Path) -> None:
    (tmp_path / "fric_x_machine.c").write_text("mine")
    with pytest.raises(FricError, match="exists"):
        fric.export_axis("c", MACHINE, axis="x", part="machine").save(tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["fric_x_machine.c"]
    assert (tmp_path / "fric_x_machine.c").read_text() == "mine"


def test_tables_hold_the_parameters_and_the_steady_friction(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fric.results.export.trust_of", lambda *given, **known: ([], []))
    for target in ("csv", "mat", "xlsx"):
        fric.export_axis(target, MACHINE, axis="x", scheme="c").save(tmp_path, force=True)
    with (tmp_path / "fric_x-parameters.csv").open() as file:
        rows = {(row["section"], row["parameter"]): (float(row["value"]), row["unit"]) for row in csv.DictReader(file)}
    assert rows["static", "F_s"] == (165.0, "N")
    assert rows["gms", "k_1"] == (99.94e6, "N/m")
    found = loadmat(tmp_path / "fric_x.mat", simplify_cells=True)["fric"]
    assert found["gms"]["k"].tolist() == [99.94e6, 1.364e6, 1.081e6, 0.119e6]
    table = np.loadtxt(tmp_path / "fric_x-steady.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(table, found["steady"])
    np.testing.assert_allclose(table[:, 1], -table[::-1, 1])  # odd
    openpyxl = pytest.importorskip("openpyxl")
    sheet = openpyxl.load_workbook(tmp_path / "fric_x.xlsx")["parameters"]
    assert ("static", "F_s", 165, "N") in list(sheet.iter_rows(values_only=True))


def test_a_voltage_without_a_limit_is_an_empty_cell() -> None:
    rows = sheets(replace(scheme_part("b"), limit=float("inf")))["parameters"]
    assert ("controller", "limit", None, "V") in [tuple(row) for row in rows]


def test_twenty_points_leave_of_the_stribeck_curve_what_is_said() -> None:
    one = scheme_part("b")
    velocity, volts, error = list_of(one)
    assert len(velocity) <= POINTS
    v = np.geomspace(1e-7, 0.5, 20001)
    off = np.interp(v, velocity, volts * one.K_f / one.gain) - np.asarray(one.model.steady_state(v))
    assert np.abs(off).max() <= 1.01 * error + 1e-9
    assert error < 0.01 * 165.0
    wide = part(GMS.typical())
    assert list_of(wide)[2] < 0.01 * 150.0


@pytest.mark.parametrize("scheme", ["c", "d", "e", "f"])
def test_a_list_over_velocity_is_exported_of_a_static_map_alone(scheme: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """It was written from any scheme, and called by its name."""
    monkeypatch.setattr("fric.results.export.trust_of", lambda *given, **known: ([], []))
    with pytest.raises(FricError, match=rf"holds a static map alone, and no scheme {scheme}\n.*scheme='b'.*linuxcnc"):
        fric.export_axis("twincat", MACHINE, axis="x", scheme=scheme)
    assert fric.export_axis("twincat", MACHINE, axis="x").part.scheme == "b"


@pytest.mark.parametrize("scheme", ["b", "c"])
def test_friction_rises_at_the_reversal_that_a_pulse_is_fitted_to(scheme: str) -> None:
    """The static map rises within the sample of the reversal, which was left out, so that its pulse was 0."""
    part = scheme_part(PAPER_SCHEMES[scheme])
    force, both = rise_of(part) * part.K_f / part.gain, 2 * part.model.steady_state(0.1)
    assert force[0] > 0.9 * both or scheme == "c"
    assert force.max() > 0.9 * both


@pytest.mark.long(4)
def test_the_pulse_of_a_sinumerik_takes_a_glitch_off_and_less_than_the_model() -> None:
    found = exported("sinumerik")
    lines = dict(re.findall(r"^\$MA_FRICT_COMP_(\w+)(?:\[0\])?=(\S+)", str(found.files["fric_x.mpf"]), re.M))
    assert {"MODE", "ENABLE", "CONST_MAX", "CONST_MIN", "TIME", "ACCEL1", "ACCEL2", "ACCEL3"} <= set(lines)
    assert 0 < float(lines["CONST_MIN"]) <= float(lines["CONST_MAX"])
    assert float(lines["ACCEL1"]) <= float(lines["ACCEL2"]) < float(lines["ACCEL3"])
    rows = re.findall(r"\| (\d+) mm/s \| ([\d.]+) µm \| ([\d.]+) µm \| ([\d.]+) µm \|", str(found.files["README.md"]))
    table = {int(feed): tuple(map(float, row)) for feed, *row in rows}
    bare, pulsed, model = table[100]
    assert bare == pytest.approx(21.4, abs=1.0)  # the other axis follows exactly
    assert model < pulsed < 0.4 * bare
    assert not found.document["verdict"]["trusted"]  # scheme c leaves less than what is exported
    left = next(one.values["pulsed"].value for one in found.warnings if one.code == "held-as-pulse")
    assert 1e6 * left == pytest.approx(pulsed, abs=0.06)


def test_a_pulse_that_decays_with_the_integral_time_is_a_step_of_voltage() -> None:
    one = scheme_part("c")
    volts = through_controller(one, one.K_p / one.K_i, np.linspace(0, 0.2, 100))
    np.testing.assert_allclose(volts, one.K_p, rtol=1e-12)


IN_PER_CENT = [("c", "c"), ("st", "c"), ("linuxcnc", "c"), ("csv", "b"), ("twincat", "b")]


@pytest.mark.parametrize(("target", "scheme"), IN_PER_CENT)
def test_a_drive_in_per_cent_is_fed_in_per_cent(target: str, scheme: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Comments, tables and manifest said V."""
    if target != "c":  # as above
        monkeypatch.setattr("fric.results.export.trust_of", lambda *given, **known: ([], []))
    table = fric.read_machine(MACHINE)
    machine = replace(table, axes={**table.axes, "x": replace(table.axes["x"], motion="linear/%/%")})
    made = fric.export_axis(target, machine, axis="x", scheme=scheme)
    assert made.document["parameters"]["limit"]["unit"] == "%"
    files = [content if isinstance(content, str) else content.decode() for content in made.files.values()]
    assert not re.search(r"\[V\]|\| V", "".join(files))
    assert "%" in "".join(files)
