"""The whole way in one command: what is found, what is done, what is said to be missing, and what is not done again."""

from __future__ import annotations

import contextlib
import json
import re
import shlex
import shutil
import subprocess
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from ruamel.yaml import YAML
from typer.testing import CliRunner

import fric
from fric.automatic.run import Stated, _circles, _found, _schemes, find_gains, gains_of
from fric.automatic.sources import Sources, find_sources
from fric.automatic.steps import (
    NO_GMS,
    NO_OBSERVER,
    NO_STRIBECK,
    AxisOutcome,
    Session,
    Step,
    axis_steps,
    identify_axes,
    trace_step,
)
from fric.cli.main import app
from fric.documents.controller import ControllerDocument
from fric.documents.mapping import MappingDocument
from fric.documents.yaml import plain, read_document, read_tree
from fric.errors import FricError
from fric.io.circle import read_circles, write_circles
from fric.io.hdf5 import read_logs, write_logs
from fric.io.readers.base import ForeignTable, Memory
from fric.log import Log
from fric.notice import Notice
from fric.records.inspection import inspect
from fric.records.prepared import prepared
from tests.figures.drawn import undrawn

ROOT = Path(__file__).parents[2]
DATA = ROOT / "data"
LOGS = [DATA / f"{name}.h5" for name in ("frequency-response", "constant-velocity", "presliding-sine")]
RUN = CliRunner()


def run(*words: object) -> dict:
    done = RUN.invoke(app, ["auto", *map(str, words), "--json"])
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert [one["text"] for one in told["warnings_coded"]] == told["warnings"]
    assert all(one["code"] for one in told["warnings_coded"])
    return told


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("auto")


@pytest.fixture(scope="module")
def first(folder) -> dict:
    before = {path: path.stat().st_mtime_ns for path in DATA.rglob("*")}
    with undrawn():
        found = run(*LOGS, "-o", folder / "out", "--tolerance", "5 um")
    assert {path: path.stat().st_mtime_ns for path in DATA.rglob("*")} == before  # nothing is written among the logs
    return found


def test_logs_end_in_a_report_and_a_verdict_that_is_not_sure_of_itself(first, folder):
    out = folder / "out"
    assert first["axes"]["x"]["done"] == ["plant", "static", "gms", "observer"]
    assert float(fric.read_machine(out / "machine.yaml").axis("x").cascade.K_p) == pytest.approx(130.9, rel=0.03)
    assert first["axes"]["x"]["missing"] == ["C of the GMS model: a sine in sliding, around a steady speed"]
    assert (out / "report.html").read_text(encoding="utf-8").lower().startswith("<!doctype html")
    found = first["verdict"]
    shown = fric.circle(out / "machine.yaml").document
    low, high = found["ci95"]
    assert low <= found["glitch"] <= high <= 5e-6
    # of machines around the one that is believed the glitch is larger than where belief and truth are one
    assert shown["schemes"][found["scheme"]]["glitch"] < high
    # of the schemes that surely stay within the tolerance the first, which asks for the least
    weaker = [name for name in shown["schemes"] if name < found["scheme"]]
    assert all(shown["schemes"][name]["glitch"] > 4.5e-6 for name in weaker)
    assert not found["trusted"]
    assert any("not compared with a measured circle" in why for why in found["why"])
    assert "designed" not in found["headline"]  # the strokes, in closed loop, show the gains


def test_what_was_found_says_which_one_more_record_narrows_it(first, folder):
    """A traceback: strokes that are simulated without noise had no error, and a sum of infinities no order."""
    out = folder / "out"
    found = fric.plan_next(out / "x/friction.yaml", machine=out / "machine.yaml").narrowing.candidates
    assert {candidate.planned.kind for candidate in found} >= {"constant-velocity", "presliding-sine"}
    assert all(np.isfinite([candidate.half_width, candidate.scatter]).all() for candidate in found)


@pytest.mark.parametrize("unit", ["Fm [N]", "Fm"])
def test_a_file_that_counts_the_other_way_than_those_beside_it_is_turned_and_named(tmp_path, unit):
    """It was left out: a folder of turned strokes lost its response and sines. Each is turned by its own friction."""
    t = np.arange(6000) * 1e-3
    for n, sign in enumerate((1, 1, -1)):
        z = (8.0 - 2.0 * n) * np.sin(2 * np.pi * t / 3.0)
        force = sign * 20.0 * np.sign(np.gradient(z)) + np.random.default_rng(n).normal(size=len(t))
        rows, header = np.column_stack([t, z, force]), f"Zeit [s];Weg [mm];{unit}"
        np.savetxt(tmp_path / f"log_{n}.csv", rows, "%.5f", ";", header=header, comments="")
    found = find_sources([tmp_path], proposals=tmp_path / "maps", assume=True)
    assert sorted(log.path.name for log in found.logs) == ["log_0.csv", "log_1.csv", "log_2.csv"]
    (why,) = (notice for notice in found.description if notice.code == "force-by-file")
    assert "log_2.csv" in str(why)
    for log in found.logs:
        fric.ingest(log.path, output=tmp_path / "log.h5", mapping=log.mapping or None, force=True)
        (read,) = read_logs(tmp_path / "log.h5")
        assert np.mean(read.force * np.gradient(read.position)) > 0.0


def test_what_is_up_to_date_is_not_done_again(first, folder):
    again = fric.auto(*LOGS, output=folder / "out", tolerance="5 um", run=lambda step: pytest.fail(f"ran {step}"))
    assert (again.steps, again.made) == (7, 0)
    assert again.document["axes"] == first["axes"]


def test_steps_are_commands_to_be_run_again_by_hand(first, folder):
    script = (folder / "out" / "steps.sh").read_text(encoding="utf-8")
    commands = [shlex.split(line) for line in script.splitlines() if line.startswith("fric ")]
    assert [" ".join(words[1:3]) for words in commands[:5]] == [
        "identify controller", "identify plant", "identify static", "identify gms", "design observer",
    ]  # fmt: skip
    assert subprocess.run(["sh", "-n", folder / "out" / "steps.sh"], check=False).returncode == 0
    done = RUN.invoke(app, commands[1][1:])
    assert done.exit_code == 0, done.output


@pytest.mark.long(30)
def test_a_measured_circle_that_differs_is_told_and_the_verdict_is_not_trusted(first, folder):
    def without_tune(step):
        if step.command == "tune":
            raise FricError("not here: it takes long")
        step.make()

    def verdict(name: str, **given):
        return fric.auto(*LOGS, output=folder / "out", circles=[folder / name], run=without_tune, **given).verdict

    fric.circle(folder / "out" / "machine.yaml", "a", revolutions=3).save(folder / "same.h5")
    designed = shutil.copy(folder / "out" / "x" / "controller.yaml", folder / "designed.yaml")
    same = verdict("same.h5")
    assert same.trusted, same.why
    fric.circle("xy-table", "a", revolutions=3).save(folder / "other.h5")
    other = verdict("other.h5", controllers=[designed])  # without, the gains are those of the circle, which explain it
    assert not other.trusted
    assert other.choice is None
    assert "completed-disagrees" in {getattr(why, "code", "") for why in other.why}, other.why


def test_foreign_logs_are_recognised_and_copies_left_out(tmp_path):
    strokes = sorted((DATA / "strokes").glob("*.csv"))[:6]
    found = find_sources([DATA / "constant-velocity.h5", *strokes])
    assert [one.path for one in found.logs] == [DATA / "constant-velocity.h5"]
    assert "as copies of other files" in found.description[0]
    alone = find_sources(strokes)
    assert all(one.mapping == "" and one.kinds == {"constant-velocity"} and "static" in one.uses for one in alone.logs)
    (tmp_path / "noise.csv").write_text("a,b\n1,2\n2,3\n", encoding="utf-8")
    told = find_sources([tmp_path / "noise.csv", *strokes]).description
    (left,) = (one for one in told if one.code == "file-left-out")
    assert "noise.csv --propose map.yaml" in left


def test_a_copy_of_a_file_of_fric_is_left_out(tmp_path):
    """A folder copied among the logs would pass for repeated records, and narrow every interval."""
    for folder in ("", "copy"):
        (tmp_path / folder).mkdir(exist_ok=True)
        for name in ("sliding-sine", "circle"):
            shutil.copy(DATA / f"{name}.h5", tmp_path / folder)
    found = find_sources([tmp_path])
    assert [*(log.path.name for log in found.logs), *(path.name for path in found.circles)] == [
        "sliding-sine.h5", "circle.h5",
    ]  # fmt: skip
    assert len(found.copies) == 2


def pins(file: Path, **axes: np.ndarray) -> None:
    """Write what LinuxCNC's halscope saves of joints: reference in mm, position 3 ms behind, and an effort."""
    rows = [""] * len(axes["joint_0"])
    for name, path in axes.items():
        pin, speed = name.replace("_", "."), np.gradient(path, 1e-3)
        effort = 2.0 * np.tanh(speed) + 1e-3 * np.gradient(speed, 1e-3) + 0.01 * speed
        for n, value in enumerate(zip(path, path - 0.003 * speed, effort, strict=True)):
            names = (f"{pin}.motor-pos-cmd", f"{pin}.motor-pos-fb", f"pid.{'xy'[int(pin[-1])]}.output")
            rows[n] += " ".join(f"{key} {number:.6f}" for key, number in zip(names, value, strict=True)) + " "
    file.write_text("\n".join(["Sampling period is 1000000 nSec", *rows]) + "\n", encoding="utf-8")


def test_a_circle_that_a_controller_traced_is_one_and_its_axes_are_those_of_the_strokes(tmp_path):
    """It was read as a motion of two axes, of which the first had another name than in the traces of it alone."""
    angle, time = np.linspace(0.0, 4 * np.pi, 2400), np.arange(1500) / 1000.0
    pins(tmp_path / "circle.log", joint_0=30 * np.cos(angle), joint_1=30 * np.sin(angle))
    pins(tmp_path / "move.log", joint_0=9.0 * np.sin(2 * np.pi * time))
    found = find_sources([tmp_path], proposals=tmp_path / "made", ask=lambda question: question.take("") and None)
    assert [(log.path.stem, log.axis) for log in found.logs] == [("move", "axis0")]  # a circle is no log besides
    assert all(log.motion.startswith("linear") for log in found.logs)
    ((trace, mapping),) = found.traces.items()
    made = trace_step(trace, tmp_path / "out", mapping)
    made.leaves[0].parent.mkdir(parents=True)
    assert RUN.invoke(app, list(made.words)).exit_code == 0
    (circle,) = read_circles(made.leaves[0])
    assert circle.names == ("axis0", "axis1")
    assert circle.radius == 0.03
    with pytest.raises(FricError, match="reads axis0 in it, and a circle test takes two axes"):
        fric.ingest_circles(tmp_path / "move.log", output=tmp_path / "move.h5", mapping=mapping)


def test_files_of_the_same_names_in_two_folders_are_said_to_be_pooled(tmp_path):
    """Two machines, and two days, were one axis without a word of the folders."""
    strokes = sorted((DATA / "strokes").glob("*.csv"))[:4]
    for folder, factor in (("mill", 1.0), ("laser", 1.1)):
        (tmp_path / folder).mkdir()
        for path in strokes:
            head, *rows = path.read_text().splitlines()
            cells = [row.rpartition(",") for row in rows]
            text = "\n".join([head, *(f"{first},{factor * float(last):.4g}" for first, _, last in cells)])
            (tmp_path / folder / path.name).write_text(text + "\n")
    (told,) = (one for one in find_sources([tmp_path]).description if one.code == "folders-together")
    assert "laser, mill" in str(told)
    assert not [one for one in find_sources([tmp_path / "mill"]).description if one.code == "folders-together"]


def test_a_circle_alone_shows_its_glitches(tmp_path):
    """ "Nothing was simulated" was all that was said of a glitch of 87 µm."""
    (tmp_path / "logs").mkdir()
    (test,) = read_circles(DATA / "circle.h5")
    of = [column for trace in test.axes.values() for column in (trace.reference, trace.position)]
    rows = np.column_stack([test.axes["x"].time, *(1e3 * column for column in of)])
    head = "time [s],x_ref [mm],x_pos [mm],y_ref [mm],y_pos [mm]"
    np.savetxt(tmp_path / "logs" / "circle.csv", rows, "%.8g", ",", header=head, comments="")
    done = RUN.invoke(app, ["auto", str(tmp_path / "logs"), "-o", str(tmp_path / "out")])
    assert re.search(r"circle: diagnosis +measured \d", done.stdout + done.stderr)


def test_a_table_of_forces_over_velocities_becomes_a_map(tmp_path):
    v = np.outer([-1.0, 1.0], [0.05, 0.5, 2.0, 4.0, 8.0, 20.0]).ravel()
    force = np.sign(v) * (80.0 + 30.0 * np.exp(-np.abs(v))) + 2.0 * v
    rows = (f"{speed:g}, {f:.4g}, 2.0, 400" for speed, f in zip(v, force, strict=True))
    (tmp_path / "means.csv").write_text("\n".join(["velocity [mm/s],force [N],deviation [N],n", *rows]))
    found = find_sources([tmp_path])
    assert not found.refused
    (made,) = (one for one in axis_steps(found.logs, tmp_path / "x").steps if one.command == "identify static")
    assert made.given == (tmp_path / "means.csv",)


def test_a_folder_that_is_refused_is_read_once(tmp_path, monkeypatch):
    """Each proposal read all files again: a folder of 94 sessions took 400 s to be refused."""
    reads, read = list[Path](), ForeignTable.read

    def counted(table, wanted):
        reads.extend([table.path] * (not isinstance(table, Memory)))
        yield from read(table, wanted)

    monkeypatch.setattr(ForeignTable, "read", counted)
    rng = np.random.default_rng(3)
    files = [tmp_path / f"log{n}.csv" for n in range(3)]
    for file in files:
        np.savetxt(file, rng.standard_normal((400, 5)), fmt="%.5g", delimiter=",", header="a,b,c,d,e", comments="")
    found = find_sources([tmp_path], proposals=tmp_path / "proposed")
    assert not found.logs
    assert sorted(reads) == files


def test_the_one_bundled_mapping_that_fits_is_used_and_said(tmp_path):
    log = read_logs(DATA / "constant-velocity.h5")[12]
    time, velocity = log.time * 1e3, np.gradient(log.position, log.time) * 1e3
    rows = np.column_stack([time, velocity, log.force])
    header = "ms;Velocity actual value averaged;Torque actual value averaged"
    np.savetxt(tmp_path / "50.csv", rows, delimiter=";", header=header, comments="", fmt="%.6g")
    found = find_sources([tmp_path])
    assert [one.mapping for one in found.logs] in ([], ["screwdrive1"])
    assert found.description  # said either way: which mapping it was, or why none


def write(file: Path, header: str, columns: list[np.ndarray]) -> None:
    np.savetxt(file, np.column_stack(columns), delimiter=";", header=header, comments="", fmt="%.9g")


def test_a_mapping_is_proposed_where_nothing_in_it_is_a_guess(tmp_path):
    log = read_logs(DATA / "constant-velocity.h5")[12]
    channels = [log.time * 1e3, log.position * 1e3, log.force]
    named = "t [ms];Y actual position [mm];Motor force [N]"
    for number in range(2):
        write(tmp_path / f"{number}.csv", named, [*channels[:2], channels[2] + number])
    either = named.replace("actual ", "") + ";Y table position [mm]"  # neither is said to be the actual one
    write(tmp_path / "two.csv", either, [*channels, channels[1]])
    found = find_sources([tmp_path], proposals=tmp_path / "made")
    assert [(one.path.name, one.axis, one.mapping) for one in found.logs] == [
        (f"{number}.csv", "y", str(tmp_path / "made" / "mapping.yaml")) for number in range(2)
    ]
    told = " ".join(found.description)
    assert "two.csv: " in told
    columns = read_document(tmp_path / "made" / "mapping.yaml", MappingDocument).columns
    assert (columns["position"].column, columns["force"].column) == ("Y actual position", "Motor force")
    again = fric.ingest(tmp_path / "0.csv", output=tmp_path / "0.h5", mapping=tmp_path / "made" / "mapping.yaml")
    (read,) = read_logs(tmp_path / "0.h5")
    assert again.done.axis == "y"
    np.testing.assert_allclose(read.position, log.position, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(read.force, log.force, rtol=1e-6, atol=1e-6)
    assert not find_sources([tmp_path / "0.csv"]).logs  # nobody said where a proposal may lie
    write(tmp_path / "bare.csv", named.replace(" [N]", ""), [*channels[:2], channels[2] + 2.0])
    told = find_sources([tmp_path / "bare.csv"], proposals=tmp_path / "made").description
    assert "bare.csv: " in " ".join(told)  # alone, its force has no unit
    assert len(find_sources([tmp_path], proposals=tmp_path / "made").logs) == 3


def test_compounds_tell_channels_and_a_reference_of_another_unit_is_none(tmp_path):
    log = read_logs(DATA / "constant-velocity.h5")[12]
    header = "Zeit [ms];Drehzahlsollwert [mm/s];Speed command [mm/s];Istlage [mm];Motorkraft [N];Drive command [mV]"
    columns = [log.time * 1e3, 0.0 * log.time, 0.0 * log.time, log.position * 1e3, log.force, 1.0 + log.force]
    write(tmp_path / "a.csv", header, columns)
    found = find_sources([tmp_path], proposals=tmp_path / "made")
    assert [one.both for one in found.logs] == [True]
    columns = read_document(tmp_path / "made" / "mapping.yaml", MappingDocument).columns
    assert {name: channel.column for name, channel in columns.items() if name != "time"} == {
        "position": "Istlage", "force": "Motorkraft", "input": "Drive command"
    }  # fmt: skip


def test_a_foreign_circle_test_is_recognised_and_ingested(tmp_path):
    angle = np.linspace(0.0, 4 * np.pi, 4001)
    x, y = 30.0 * np.cos(angle), 30.0 * np.sin(angle)
    header = (
        "Time [s];X reference [mm];Y reference [mm];X actual position [mm];Position Y (measured) [mm];X voltage [V]"
    )
    write(tmp_path / "round.csv", header, [angle * 0.3, x, y, x, y, 0.1 * x])
    found = find_sources([tmp_path])
    assert (found.traces, found.logs, found.description) == ({tmp_path / "round.csv": ""}, [], [])
    made = trace_step(tmp_path / "round.csv", tmp_path / "out")
    made.leaves[0].parent.mkdir(parents=True)
    done = RUN.invoke(app, list(made.words))
    assert done.exit_code == 0, done.output
    assert "x: reference position input, y: reference position" in done.stdout


@pytest.mark.parametrize(
    ("names", "done", "missing"),
    [
        (["constant-velocity"], ["static"], ["plant", "GMS", "controller", "observer"]),
        (["presliding-sine"], ["gms"], ["plant", "static map", "C of the GMS model", "controller", "observer"]),
        (["frequency-response"], ["plant", "controller", "observer"], ["static map", "GMS"]),
    ],
)
def test_what_cannot_be_made_says_which_record_is_missing(names, done, missing, tmp_path):
    plan = axis_steps(find_sources([DATA / f"{name}.h5" for name in names]).logs, tmp_path)
    assert [one.name.partition(": ")[2] for one in plan.steps] == done
    assert [text.partition(":")[0] for text in plan.missing] == missing


def moving(*, driven: bool) -> Log:
    """Return a production motion: moves of many speeds and lengths, 10 s."""
    rng, t = np.random.default_rng(5), np.arange(5000) * 2e-3
    v = np.repeat(rng.uniform(-0.2, 0.2, 25), 200)
    v = np.convolve(v, np.hanning(160) / np.hanning(160).sum(), "same")
    z, a = np.cumsum(v) * 2e-3, np.gradient(v, 2e-3)
    force = 8.0 * a + 30.0 * v + 12.0 * np.tanh(v / 1e-3) + rng.normal(0.0, 0.5, len(t))
    return Log(time=t, position=z, force=force, input=force / 40.0 if driven else None)


@pytest.mark.parametrize("driven", [True, pytest.param(False, marks=pytest.mark.long(3))])
def test_a_motion_is_a_record_of_what_it_tells(driven, tmp_path):
    """Mass, viscous and Coulomb friction are identified from it, and what is left is missing."""
    write_logs(tmp_path / "log.h5", [moving(driven=driven)])
    found = find_sources([tmp_path / "log.h5"])
    assert [one.kinds for one in found.logs] == [{"motion"}]
    plan = axis_steps(found.logs, tmp_path / "out")
    assert [one.command for one in plan.steps] == ["identify plant", "identify lugre"]
    assert [text.partition(":")[0] for text in plan.missing][:2] == ["F_s and v_s of the static map", "GMS"]
    for one in plan.steps:
        one.leaves[0].parent.mkdir(exist_ok=True)
        one.make()
    plant, friction = (plain(read_tree(tmp_path / "out" / f"{part}.yaml")) for part in ("plant", "friction"))
    assert plant["fit"]["parameters"]["M"]["value"] == pytest.approx(8.0, rel=0.05)
    assert friction["static"]["F_c"]["value"] == pytest.approx(12.0, rel=0.1)


def test_a_motion_with_gaps_is_missing_for_the_plant_by_reason_of_its_gaps(tmp_path):
    """Of a log with 5 % of its rows lost it was only said that an ordinary motion was missing, which it was."""
    log = moving(driven=True)
    for share, given in ((0.03, 1), (0.09, 0)):
        kept = np.random.default_rng(6).uniform(size=len(log)) >= share
        channels = {name: values[kept] for name, values in log.channels().items()}
        write_logs(tmp_path / "log.h5", [Log(**channels, kind="constant-velocity")], force=True)
        plan = axis_steps(find_sources([tmp_path / "log.h5"]).logs, tmp_path / "out")
        assert len(plan.shaken) == given
        lacks = "".join(text for text in plan.missing if text.startswith("plant"))
        assert ("% of the samples are missing" in lacks) is not bool(given)


@pytest.mark.parametrize(("F_s", "shown"), [([18.0, 20.0], True), ([18.0, None], False)])
def test_the_fall_of_friction_that_a_motion_showed_is_not_missing(F_s, shown, tmp_path):
    """The line "missing for F_s and v_s" stood below an F_s and a v_s with their intervals."""
    write_logs(tmp_path / "log.h5", [moving(driven=True)])
    text = f"static: {{F_s: {{value: 19.0, ci95: {json.dumps(F_s)}}}, v_s: {{value: 0.001, ci95: [0.0009, 0.0011]}}}}\n"

    terms = "A: {value: 0, unit: 1/s}, B: {value: 0.1, unit: m/(s^2*V)}, T_d: {value: 0, unit: s}"

    def made(step):
        plant = step.command == "identify plant"
        step.output.write_text(f"{{fric: plant/1, axis: x, {terms}}}" if plant else text)

    session = Session(tmp_path / "made", made, lambda text: None)
    (outcome,) = identify_axes(session, find_sources([tmp_path / "log.h5"]), lambda _: None).values()
    assert (NO_STRIBECK in outcome.missing) is not shown


def test_friction_at_one_speed_is_that_of_the_plants_motion_and_more_speeds_are_missing(tmp_path):
    """F_c and F_v of the motion were in steps.log alone, and nothing asked for strokes at more speeds."""
    write_logs(tmp_path / "log.h5", [moving(driven=True)])
    texts = {
        "plant": "fit: {parameters: {F_c: {value: 12.0, unit: N, ci95: [11.0, 13.0]}}}\n",
        "static": "at_speed: {velocity: {value: 0.1, unit: m/s}, force: {value: 15.0, unit: N}}\n",
    }
    (found,) = find_sources([tmp_path / "log.h5"]).logs
    strokes = replace(found, kinds=frozenset({"constant-velocity"}), uses=found.uses | {"static"}, strokes=9)

    def made(step):
        part = step.name.removeprefix("x: ")
        step.output.write_text(texts[part])

    session = Session(tmp_path / "made", made, lambda text: None)
    given = Sources(logs=[replace(strokes, motion="linear/N/N")])
    (outcome,) = identify_axes(session, given).values()
    assert outcome.missing.count(NO_STRIBECK) == 1
    assert "F_c" in str(_found("x", outcome))


def test_friction_is_identified_on_the_encoder_that_is_asked_for(tmp_path):
    log = moving(driven=True)
    write_logs(tmp_path / "one.h5", [log])
    write_logs(tmp_path / "two.h5", [replace(log, load_position=log.position)])
    for name, options in (("one", [None, None]), ("two", ["load", "load"])):
        plan = axis_steps(find_sources([tmp_path / f"{name}.h5"]).logs, tmp_path / "out", encoder="load")
        assert [step.options.get("encoder") for step in plan.steps] == options
    with pytest.raises(FricError, match="no log has the position of the load"):
        fric.auto(tmp_path / "one.h5", output=tmp_path / "out", encoder="load")


@pytest.mark.long(15)
def test_a_production_move_in_closed_loop_shows_the_gains_too(tmp_path):
    K_v, K_p, K_i, dt, rng = 60.0, 250.0, 6000.0, 2.5e-4, np.random.default_rng(8)
    ends, share = np.append(0.0, rng.uniform(-0.1, 0.1, 12)), np.clip(np.linspace(0.0, 1.2, 4000), 0.0, 1.0)
    steps = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    reference = np.concatenate([a + (b - a) * steps for a, b in pairwise(ends)])
    z, u = np.zeros(len(reference)), np.zeros(len(reference))
    x = v = integral = before = 0.0
    for k, wanted in enumerate(reference):
        z[k] = round(x / 1e-7) * 1e-7
        error = K_v * (wanted - z[k]) - (z[k] - before) / dt
        before, integral = z[k], integral + K_i * error * dt
        u[k] = K_p * error + integral
        v += dt * (35.0 * u[k] - 30.0 * np.tanh(v / 2e-3) - 150.0 * v) / 50.0
        x += dt * v
    time = dt * np.arange(len(z))
    write_logs(tmp_path / "log.h5", [Log(time=time, reference=reference, position=z, input=u, force=35.0 * u)])
    found = fric.auto(tmp_path / "log.h5", output=tmp_path / "out").axes["x"]
    tree = plain(read_tree(found.files["controller"]))
    for name, gain in (("K_v", K_v), ("K_p", K_p), ("K_i", K_i)):
        assert tree[name]["value"] == pytest.approx(gain, rel=0.1)
    assert any(text.startswith("observer: ") for text in found.missing)


def test_what_is_recognised_as_a_motion_keeps_its_inertia():
    stated, told = (prepared([replace(moving(driven=False), kind=kind)])[0] for kind in ("motion", None))
    assert told.done.own == stated.done.own == ("offset", "mass")


def test_a_log_too_slow_for_presliding_is_not_good_for_gms():
    """Ten samples a second, steps of a millimetre: the axis is through pre-sliding within a sample."""
    (log,) = read_logs(DATA / "presliding-sine.h5")[:1]
    slow = replace(log, **{name: values[::90] for name, values in log.channels().items()})
    uses = {one.purpose: one for record in (log, slow) for one in inspect(record).uses}
    assert not uses["gms"].good


@pytest.mark.parametrize(("names", "unused"), [(["sliding-sine", "presliding-sine"], 0), (["sliding-sine"], 1)])
def test_a_log_that_no_step_reads_is_told(names, unused, tmp_path):
    """Of a mix of two machines with one name of axis, the ordinary motion of the one vanished without a word."""
    found = find_sources([DATA / f"{name}.h5" for name in names])
    session = Session(tmp_path, lambda step: step.output.touch(), lambda text: None)
    identify_axes(session, found)
    assert (
        sum(one.code == "file-unused" and "sliding-sine" in one and "axis x" in one for one in found.description)
        == unused
    )


def test_axes_are_identified_side_by_side_as_one_after_the_other(tmp_path):
    """A robot of seven axes took 76 s on two cores. Axis c's motion is too short for its friction: that step fails."""
    (tmp_path / "logs").mkdir()
    short = moving(driven=True)
    short = replace(short, **{name: values[:1000] for name, values in short.channels().items()})
    of_axes = {"a": read_logs(LOGS[0]), "b": read_logs(LOGS[1])[::4], "c": [short]}
    for name, logs in of_axes.items():
        write_logs(tmp_path / "logs" / f"{name}.h5", [replace(log, axis=name) for log in logs])

    def run(folder: str, workers: int):
        session = Session(tmp_path / folder, Step.make, lambda text: None)
        axes = identify_axes(session, find_sources([tmp_path / "logs"]), lambda _: None, workers=workers)
        session.close()
        return session, axes

    (alone, first), (beside, other) = run("found", 1), run("other", 2)
    assert list(first) == list(other) == ["a", "b", "c"]
    assert {name: axis.done for name, axis in first.items()} == {
        "a": ["plant", "controller", "observer"], "b": ["static"], "c": ["plant"]
    }  # fmt: skip
    assert {name: axis.done for name, axis in first.items()} == {name: axis.done for name, axis in other.items()}
    assert [*alone.failed] == ["c: lugre"]
    assert (alone.steps, alone.made, alone.failed) == (beside.steps, beside.made, beside.failed)
    script = (tmp_path / "found" / "steps.sh").read_text()
    assert (tmp_path / "other" / "steps.sh").read_text() == script.replace("found", "other")
    for name in "ac":
        plant, same = (read_tree(tmp_path / folder / name / "plant.yaml") for folder in ("found", "other"))
        assert {key: plant[key] for key in ("A", "B", "T_d")} == {key: same[key] for key in ("A", "B", "T_d")}
    again, _ = run("other", 1)
    assert again.made == 0


def test_a_motion_beside_a_session_is_for_validation_and_of_no_other_machine(tmp_path):
    """An axis' own validation record was answered with 'Keep logs of another machine in another folder'."""
    write_logs(tmp_path / "validation.h5", [moving(driven=True)])
    found = find_sources([DATA / "frequency-response.h5", DATA / "constant-velocity.h5", tmp_path / "validation.h5"])
    identify_axes(Session(tmp_path, lambda step: step.output.touch(), lambda text: None), found)
    (unused,) = [one for one in found.description if one.code == "file-unused"]
    assert unused.values["others"] is False  # it was said that others show the same
    assert "validation.h5" in unused
    assert "fric validate" in unused
    assert "machine" not in unused


def test_a_log_that_a_step_failed_on_is_not_said_to_be_unused(tmp_path):
    """The plant could not be identified, and beside that reason no step used the log."""
    write_logs(tmp_path / "motion.h5", [moving(driven=True)])
    found = find_sources([tmp_path / "motion.h5"])

    def refuse(step):
        if step.command == "identify plant":
            raise FricError("the mass is not seen")
        step.output.touch()

    identify_axes(session := Session(tmp_path / "made", refuse, lambda text: None), found)
    assert "x: plant" in session.failed
    assert not [one for one in found.description if one.code == "file-unused"]


def test_why_the_only_log_is_unused_is_what_is_missing(tmp_path):
    """A log beside which there is no other was answered with 'Keep logs of another machine in another folder'."""
    found = find_sources([DATA / "sliding-sine.h5"])
    (outcome,) = identify_axes(Session(tmp_path, lambda step: None, lambda text: None), found).values()
    (unused,) = [one for one in found.description if one.code == "file-unused"]
    assert outcome.missing
    assert unused.values["alone"] is True
    assert "machine" not in unused


def test_what_is_next_names_files_that_are_there(tmp_path):
    """Voltage and force in different logs: K_f is open, no machine is made, and 'next:' named MACHINE.yaml."""
    (tmp_path / "logs").mkdir()
    for name, without in (("frequency-response", "force"), ("constant-velocity", "input")):
        bare = [replace(log, **{without: None}) for log in read_logs(DATA / f"{name}.h5")]
        write_logs(tmp_path / "logs" / f"{name}.h5", bare)
    with undrawn():
        counted = []
        found = fric.auto(tmp_path / "logs", output=tmp_path / "out", advance=lambda n=1, **of: counted.append((n, of)))
    assert 0 < sum(n for n, _ in counted) <= counted[0][1]["total"]
    totals = [of["total"] for _, of in counted if of.get("total")]
    assert sum(n for n, _ in counted) == totals[-1] == found.steps  # the bar ended at 7 of 10, and at 10 of 8 steps
    assert totals == sorted(totals, reverse=True)
    assert {n for n, _ in counted} == {0, 1}  # it went from 4 to 6
    assert any(text.startswith("K_f") for text in found.axes["x"].missing)
    assert "MACHINE.yaml" not in str(found)
    assert "next: fric plan" in str(found)


def test_a_step_that_fails_is_told_and_the_rest_goes_on(first, folder, tmp_path, monkeypatch):
    monkeypatch.setattr("fric.automatic.run.MACHINES", 4)

    def refuse_gms(step):
        if step.command == "identify gms":
            raise FricError("no cycle is whole", hint="Log three.")
        if not step.command.startswith(("identify", "design")):
            return step.make()
        for path in step.leaves:  # as they were made of the same logs
            shutil.copy(folder / "out" / path.relative_to(tmp_path / "out"), path)
        return None

    said: list[str] = []
    with undrawn():
        found = fric.auto(*LOGS, output=tmp_path / "out", run=refuse_gms, say=said.append)
    assert found.axes["x"].done == ["plant", "static", "observer"]
    assert any("no cycle is whole" in text for text in found.axes["x"].missing)
    assert "# failed: fric identify gms" in (tmp_path / "out" / "steps.sh").read_text(encoding="utf-8")
    assert found.verdict.choice is None  # the static map alone is simulated, which holds the axis before it slides
    assert "friction before sliding was not identified" in found.verdict.headline
    assert ["x: gms" in line for line in said if "failed" in line] == [True]  # where it fails
    *_, counted, failed, page = str(found).splitlines()  # in the last lines
    assert counted.startswith("7 steps: 6 run, 1 failed")
    assert failed == "failed: x: gms: no cycle is whole. Log three."
    assert page.endswith("report.html")
    assert "x: gms: no cycle is whole. Log three." in (tmp_path / "out/report.html").read_text(encoding="utf-8")
    log = (tmp_path / "out/steps.log").read_text(encoding="utf-8")
    with undrawn():
        again = fric.auto(*LOGS, output=tmp_path / "out", run=refuse_gms)
    assert "7 steps: 6 up to date, 1 failed" in str(again)
    kept = (tmp_path / "out/steps.log").read_text(encoding="utf-8")  # "what they printed" was "up to date" alone
    assert kept.replace("up to date", "") == log


def test_a_report_that_fails_is_not_named_and_the_log_names_options(tmp_path):
    """The last line named a page that was not there, and steps.log had arguments as Python writes them."""

    def refuse(step):
        if step.command == "report":
            raise FricError("the disk is full", hint="Say `delay='1 ms'`.")
        return step.make()

    with undrawn():
        found = fric.auto(ROOT / "data/constant-velocity.h5", output=tmp_path / "out", run=refuse)
    assert not (tmp_path / "out/report.html").exists()
    assert "report.html" not in str(found)
    assert "Say --delay '1 ms'." in (tmp_path / "out/steps.log").read_text(encoding="utf-8")


def test_logs_that_are_open_are_asked_for_though_a_circle_is_not(tmp_path):
    """A machine was made of the circle alone, and 22 of 23 files were left out in a warning at the end."""
    test = read_circles(DATA / "circle.h5")[0]
    rows = [test.axes["x"].time[::4]]
    rows += [
        values[::4] for axis in test.axes.values() for values in (1e3 * axis.reference, 1e3 * axis.position, axis.input)
    ]
    header = "t [s],x_ref [mm],x_pos [mm],x_u [V],y_ref [mm],y_pos [mm],y_u [V]"
    np.savetxt(tmp_path / "circle.csv", np.column_stack(rows), "%.6f", ",", header=header, comments="")
    for stroke in sorted((ROOT / "data/strokes").glob("*.csv"))[:5]:
        text = stroke.read_text().splitlines()
        (tmp_path / stroke.name).write_text("\n".join(["t,x,F", *text[1:]]))
    with pytest.raises(FricError, match="5 files do not say what their columns are") as refused:
        fric.auto(tmp_path, output=tmp_path.parent / "out")
    assert "fric: mapping/1" in refused.value.form


def test_a_loop_that_is_not_stable_leaves_the_page_of_what_was_identified(first, folder, tmp_path):
    """There was no page, one reason three times, and "nothing was simulated" with a file that there was not."""
    gains = ["K_v=9000 1/s, K_p=54000 V*s/m, K_i=2700000 V/m"]

    def copied(step):
        if step.command not in {"identify plant", "identify static", "identify gms"}:
            return step.make()
        for path in step.leaves:  # as they were made of the same logs
            shutil.copy(folder / "out" / path.relative_to(tmp_path / "out"), path)
        return None

    with undrawn():
        found = fric.auto(*LOGS, output=tmp_path / "out", controllers=gains, run=copied)
    shown = str(found)
    assert (tmp_path / "out/report.html").exists()
    assert found.verdict.headline.startswith("No scheme is recommended: the loop of axis x is not stable")
    assert found.verdict.next == ()
    reasons = [text.split(": ", 1)[1] for text in shown.splitlines() if text.startswith("failed: ")]
    assert len(reasons) == len(set(reasons)) >= 2
    assert "MACHINE.yaml" not in shown


def test_an_error_in_a_mapping_names_its_file_its_line_and_its_mend(tmp_path):
    """It named a log, and "line 3" of no file, with the mend of a log that lacks a channel."""
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs/a.csv").write_text("t,p\n0,1\n1,2\n2,3\n", encoding="utf-8")
    mapping = tmp_path / "map.yaml"
    mapping.write_text("fric: mapping/1\ncolumns:\n  position: {column: p, unit: N}\n", encoding="utf-8")
    with pytest.raises(FricError) as found:
        fric.auto(tmp_path / "logs", output=tmp_path / "out", mapping=str(mapping))
    with pytest.raises(FricError) as alone:
        fric.ingest(tmp_path / "logs/a.csv", output=tmp_path / "a.h5", mapping=mapping)
    assert (found.value.where, found.value.hint) == (alone.value.where, alone.value.hint)
    assert "map.yaml, line 3" in found.value.where


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--circle", str(LOGS[0])], "there is no measured circle in it"),
        (["--machine", str(ROOT / "data/circle.h5")], "a machine file is needed"),
        (["--map", "no.yaml"], "no.yaml: there is no such file"),
        (["--controller", "Kv=100 1/s, Kp=131, Ki=4090"], "'Kv' is not a gain"),
        (["--controller", "K_v=100 1/s"], "lacks K_p and K_i"),
        (["--tolerance", "5 kg"], "`tolerance=`: length cannot be in 'kg'"),
    ],
)
def test_a_wrong_option_is_refused_before_the_steps(tmp_path, options, told):
    """A circle of another kind was left out without a word, and a wrong machine met after half a minute of steps."""

    def run(step):
        raise AssertionError(step.name)

    names = {"--circle": "circles", "--map": "mapping", "--controller": "controllers"}
    name = names.get(options[0], options[0].strip("-"))
    given = {name: options[1:] if name in {"circles", "controllers"} else options[1]}
    with pytest.raises(FricError, match=re.escape(told)):
        fric.auto(LOGS[2], output=tmp_path / "out", run=run, **given)


def test_nothing_to_read_is_an_error(tmp_path):
    (tmp_path / "logs").mkdir()
    for given, told in ((tmp_path / "none", "there is no such file"), (tmp_path / "logs", "there is no log")):
        done = RUN.invoke(app, ["auto", str(given), "-o", str(tmp_path / "out")])
        assert told in str(done.exception)


@pytest.mark.usefixtures("first")
def test_what_one_axis_could_use_is_said_where_the_other_has_no_model(folder, tmp_path):
    """The advice was (b) for both axes, at 17 µm, without a word of the 0.6 µm that (c) leaves on x."""
    files = {part: folder / "out/x" / f"{part}.yaml" for part in ("plant", "controller", "friction", "observer")}
    others = {part: tmp_path / path.name for part, path in files.items()}
    for part, path in files.items():
        if path.exists():
            tree = YAML().load(path.read_text()) | {"axis": "y"}
            tree.pop("gms", None)
            tree.get("fit", {}).pop("gms", None)
            YAML().dump(tree, others[part])
    outcomes = {"x": AxisOutcome("linear", files=files), "y": AxisOutcome("linear", files=others)}
    assert all(axis.whole for axis in outcomes.values())
    tree = YAML().load((folder / "out/machine.yaml").read_text())
    there = {name: {p: path for p, path in axis.files.items() if path.exists()} for name, axis in outcomes.items()}
    tree["axes"] = {name: {part: str(path) for part, path in of.items()} for name, of in there.items()}
    YAML().dump(tree, machine := tmp_path / "machine.yaml")
    can, said = _schemes(outcomes, machine)
    assert can == ["a", "b"] + ["d", "e"] * files["observer"].exists()
    assert said.startswith("Schemes with the GMS model were left out, since Y has none. For X alone: `fric simulate ")
    assert said.endswith("/machine.yaml --axis x`.")
    assert _schemes({"x": outcomes["x"]}, machine)[1] == ""


@pytest.fixture(scope="module")
def session(folder) -> tuple[fric.AutoResult, list[str], Path]:
    """The example as a new user runs it."""
    fric.example(output=folder / "session")
    said: list[str] = []
    return fric.auto(folder / "session/data", output=folder / "found", say=said.append), said, folder / "found"


@pytest.mark.long(15)
def test_the_first_run_ends_in_trust(session):
    """The gains are those that the circle shows, and the decision is right for the machine that the logs are of."""
    found, _, out = session
    verdict = found.verdict
    assert verdict.trusted, verdict.why
    assert verdict.choice.scheme.name == "c"
    predicted, measured = verdict.compared
    assert predicted == pytest.approx(measured, rel=0.05)
    assert f"measured {1e6 * measured:.1f} µm: trusted." in str(found)
    assert verdict.checked in (out / "report.html").read_text(encoding="utf-8")
    assert "designed" not in verdict.headline
    assert (out / "circle-diagnosis.png").exists()
    true = fric.circle("virtual-rig", "a", axis="x").runs[0].circularity.glitch
    assert measured == pytest.approx(true, rel=0.05)
    believed = fric.read_machine("virtual-rig", nominal_files=[f"x={out / 'x/friction.yaml'}"])
    left = fric.circle(believed, "c", axis="x").runs[0].circularity.glitch
    assert left <= 1.1 * verdict.choice.stays_under


@pytest.mark.long(15)
def test_a_run_is_read_at_a_glance(session):
    found, said, out = session
    lines = [*said, *str(found).splitlines()]
    assert len(lines) <= 60
    assert len(said) == found.steps
    assert all(line.endswith(" s") for line in said)
    sentences = [part for line in lines for part in line.split(". ") if len(part) > 30]
    assert len(sentences) == len(set(sentences))
    assert "replayed force misses by" in (out / "steps.log").read_text(encoding="utf-8")


@pytest.mark.long(15)
def test_a_run_has_one_upper_limit(session):
    """A sentence had 0.99 µm, the table below it 1.1, and the page 1.2."""
    found, _, out = session
    verdict = found.verdict
    most = f"{1e6 * verdict.choice.stays_under:.1f}"
    assert f"at most {float(most):g} µm" in verdict.headline
    assert found.document["verdict"]["ci95"][1] == found.document["verdict"]["stays_under"]
    table = (out / "steps.log").read_text(encoding="utf-8").partition("$ fric simulate circle")[2]
    (row,) = (line for line in table.splitlines() if line.startswith("(c) GMS"))
    assert row.split()[4] == most
    assert f'data-label="at most">{most}<' in (out / "report.html").read_text(encoding="utf-8").replace("\n", "")


@pytest.mark.long(15)
def test_the_pages_show_what_the_run_says(session):
    """README said 1.7, the run 0.99 µm: one run of the example has one expectation and one upper limit everywhere."""
    found, _, _ = session
    for page in ("README.md", "docs/quickstart.md"):
        text = " ".join((ROOT / page).read_text(encoding="utf-8").split())
        assert found.verdict.headline in text
        assert found.verdict.checked in text


@pytest.mark.long(25)
def test_another_machine_file_is_another_answer_that_says_of_which_axes(session):
    """Held against the example's machine file, (c) <= 0.99 became (f) <= 5.7 µm: its second axis was not named."""
    found, _, out = session
    data, machine = out.parent / "session/data", out.parent / "session/configs/virtual-rig.yaml"
    held = fric.auto(data, output=out.parent / "held", machine=machine).verdict
    assert (held.choice.scheme.name, held.trusted) == (found.verdict.choice.scheme.name, True)
    assert "glitch on X and Y " in held.headline
    assert "glitch on X " in found.verdict.headline
    assert held.choice.stays_under > 0.9 * found.verdict.choice.stays_under  # the worse of two axes


def test_a_run_of_several_schemes_is_left_out_and_no_end(tmp_path):
    fric.circle("xy-table", "a,b,d", velocity="200 mm/s").save(tmp_path / "run.h5")
    found = find_sources([tmp_path])
    assert found.circles == []
    assert "run.h5: Left out: holds 3 schemes." in found.description[0]


def test_gains_that_are_given_are_those_of_the_machine(tmp_path):
    (tmp_path / "x.yaml").write_text(CONTROLLER, encoding="utf-8")
    found = find_sources([tmp_path, *LOGS])
    assert found.controllers == {"x": tmp_path / "x.yaml"}
    plan = axis_steps(found.logs, tmp_path / "out" / "x", controller=found.controllers["x"])
    assert "x: controller" not in [one.name for one in plan.steps]
    (observer,) = (one for one in plan.steps if one.command == "design observer")
    assert observer.options["controller"] == tmp_path / "x.yaml"


def test_gains_are_taken_as_a_text_or_asked_for(tmp_path):
    def open_loop(step):
        raise FricError("no record in closed loop shows the gains")

    session, found = Session(tmp_path, open_loop, str), find_sources([DATA / "constant-velocity.h5"])
    text = "K_v=100 1/s, K_p=130.9 V*s/m, K_i=4091 V/m"

    def gains(given=(), ask=None):
        return find_gains(session, found, found.logs, Stated.of(given), ask, needed=True)

    def gain(path):
        return read_document(path, ControllerDocument).K_p.value

    asked = []
    assert gains(ask=lambda question: (asked.append(question.text), question.take(""))) is None
    assert "K_v=100 1/s" in asked[0]
    assert gains(ask=asked.append) is None  # who does not know is asked once
    session.may_know = True
    assert gain(gains(["y: K_v=1 1/s, K_p=2 V*s/m, K_i=3 V/m"], lambda question: question.take(text))) == 130.9
    assert gain(gains()) == 130.9  # what was answered is kept
    assert gain(gains([f"x: {text.replace('130.9', '120')}"])) == 120.0
    with pytest.raises(FricError, match="lacks K_i"):
        gains(["K_v=100 1/s, K_p=3 N"])
    with pytest.raises(FricError, match=r"K_p has no unit in .*\nWrite 'K_p=131 V\*s/m'"):
        gains(["K_v=100 1/s, K_p=131, K_i=4090"])
    session.close()
    assert "K_p: {value: 120.0, unit: V*s/m}" in (tmp_path / "steps.sh").read_text(encoding="utf-8")


@pytest.mark.parametrize(("K_p", "K_i", "codes"), [(130.9, 4091, []), (65.0, 2045, ["controller-differs"])])
def test_stated_gains_are_held_against_the_voltage_of_logs(K_p, K_i, codes, tmp_path):
    found = find_sources([DATA / "constant-velocity.h5"])
    text = f"K_v=100 1/s, K_p={K_p} V*s/m, K_i={K_i} V/m"
    session = Session(tmp_path, Step.make, lambda _: None)
    path = find_gains(session, found, found.logs, Stated.of([text]), None, needed=True)
    assert [warning["code"] for warning in plain(read_tree(path)).get("warnings_coded", [])] == codes
    (tmp_path / "given.yaml").write_text(CONTROLLER.replace("130.9", str(K_p)).replace("4091", str(K_i)))
    path = find_gains(session, found, found.logs, Stated.of([tmp_path / "given.yaml"]), None, needed=True)
    assert path.name == ("gains.yaml" if codes else "given.yaml")
    assert [warning["code"] for warning in plain(read_tree(path)).get("warnings_coded", [])] == codes


def test_a_compensation_in_the_voltage_of_a_circle_is_no_gain(tmp_path):
    """K_p was 351 to 400 V·s/m for 108: a compensation was on, and nobody said so."""
    test = read_circles(DATA / "circle.h5")[0]
    trace = test.axes["x"]
    added = 0.35 * np.tanh(np.gradient(trace.reference, trace.time) / 2e-3)  # 53 N of 63 N
    axes = test.axes | {"x": replace(trace, input=trace.input + added)}
    write_circles(tmp_path / "circle.h5", [replace(test, axes=axes)])
    found = find_sources([DATA / "constant-velocity.h5", tmp_path / "circle.h5"])
    session = Session(tmp_path / "out", Step.make, lambda _: None)
    path = find_gains(session, found, found.logs, Stated.of([]), None, needed=True)
    low, high = read_document(path, ControllerDocument).K_p.ci95
    assert low <= 130.9 <= high < 1.2 * low


@pytest.mark.long(90)
def test_a_circle_without_voltage_settles_nothing_where_the_gains_are_unknown(tmp_path):
    """23 µm were predicted with gains that fric designed, 41 were measured, and that was called trusted."""
    (tmp_path / "logs").mkdir()
    for path in LOGS:
        bare = [replace(log, reference=None) for log in read_logs(path)]
        write_logs(tmp_path / "logs" / path.name, bare)
    test = read_circles(DATA / "circle.h5")[0]
    axes = {name: replace(trace, input=None) for name, trace in test.axes.items()}
    write_circles(tmp_path / "logs" / "circle.h5", [replace(test, axes=axes)])
    found = fric.auto(tmp_path / "logs", output=tmp_path / "found").verdict
    assert found.choice is None
    assert found.headline == "No scheme is recommended: the controller's gains are not known."
    assert {"not-as-predicted", "gains-unknown"} <= {notice.code for notice in found.why}
    assert "--controller" in found.next[0]


CONTROLLER = """\
fric: controller/1
axis: x
motion: linear
K_v: 100 1/s
K_p: 130.9 V*s/m
K_i: 4091 V/m
velocity_filter: 500 Hz
sampling: 4 kHz
"""


def test_what_is_wrong_of_a_plant_is_said_in_whole_beside_its_values():
    """A of 6628 1/s was shown, and only a code at the end of the screen said that the plant is none."""
    wrong, doubt = (
        Notice(code, code=code, severity=grave) for code, grave in (("no axis", "wrong"), ("late", "doubt"))
    )
    plant = SimpleNamespace(kind="plant", axis="x", warnings=[wrong, doubt])
    page = SimpleNamespace(inputs=SimpleNamespace(items=[plant]))
    found = SimpleNamespace(page=page, verdict=SimpleNamespace(why=(), settled=()))
    assert fric.AutoResult._doubts(found) == ["wrong: plant of axis x: no axis", "doubt: late (`fric help late`)"]


@pytest.mark.parametrize("content", [b"", bytes(range(256)) * 8])
def test_no_mapping_is_offered_for_what_no_reader_opens(content, tmp_path):
    (tmp_path / "log.csv").write_bytes(content)
    with pytest.raises(FricError, match="no log here can be used") as refused:
        fric.auto(tmp_path / "log.csv", output=tmp_path / "found")
    assert "--propose" not in refused.value.hint
    assert refused.value.hint


def test_results_never_lie_among_the_logs(tmp_path):
    for output in (DATA, DATA / "found"):
        with pytest.raises(FricError, match="among the logs") as refused:
            fric.auto(DATA, output=output)
        assert str(DATA.parent / "found") in refused.value.hint
    assert not (DATA / "found").exists()


def test_a_file_in_the_place_of_a_folder_is_named(tmp_path):
    (tmp_path / "x").write_text("")
    with pytest.raises(FricError, match=r"x: cannot be written: File exists"):
        Session(tmp_path, lambda step: None, str).write({"fric": "controller/1"}, tmp_path / "x" / "gains.yaml")


def test_a_file_in_the_place_of_the_folder_is_refused_before_logs_are_read(tmp_path, monkeypatch):
    """It was after half a minute of reading."""
    (tmp_path / "report.html").write_text("")
    monkeypatch.setattr("fric.automatic.run.find_sources", lambda *_, **__: pytest.fail("logs were read"))
    with pytest.raises(FricError, match=r"report.html: is a file, and the results take a folder"):
        fric.auto(DATA, output=tmp_path / "report.html")
    with pytest.raises(FricError, match="no-such"):
        fric.auto(DATA, output=tmp_path / "out", machine=tmp_path / "no-such.yaml")
    with pytest.raises(FricError, match="lacks K_p and K_i"):
        fric.auto(DATA, output=tmp_path / "out", controllers=["K_v=100 1/s"])
    with pytest.raises(FricError, match="velocity_feedforward of the controller is 5"):
        gains_of("K_v=100 1/s, K_p=131 V*s/m, K_i=4090 V/m, velocity_feedforward=5", "x", "linear")


def test_the_table_marks_values_of_the_negative_direction(tmp_path: Path):
    """Both maps of a machine whose friction depends on the direction were shown as F_c."""
    static = {"F_c": {"value": 24.0, "unit": "N"}, "fit": {"value": 1.0, "unit": "1"}}
    negative = {"F_c": {"value": 19.0, "unit": "N"}}
    file = tmp_path / "static.yaml"
    file.write_text(json.dumps({"static": static, "static_negative": negative}), encoding="utf-8")
    none = tmp_path / "none.yaml"
    table = _found("x", SimpleNamespace(files={"plant": none, "controller": none, "friction": file}))
    assert [row[:2] for row in table.rows] == [("F_c", "24"), ("negative.F_c", "19")]


def test_a_damaged_log_is_left_out_with_the_reason(tmp_path):
    """There was said to be no log, and beside others nothing was said."""
    (tmp_path / "short.h5").write_bytes((DATA / "circle.h5").read_bytes()[:3000])
    found = find_sources([tmp_path])
    assert found.refused == {"is an incomplete HDF5 file": [tmp_path / "short.h5"]}
    with pytest.raises(FricError, match="an incomplete HDF5 file") as error:
        fric.auto(tmp_path, output=tmp_path.parent / "out")
    assert "--propose" not in str(error.value)


def test_a_circle_without_compensation_needs_no_gms(tmp_path):
    missing = [NO_GMS, "K_f, and so the circle: a record with voltage", NO_OBSERVER, "lugre: it failed"]
    axis = AxisOutcome("linear", missing=missing, files={"plant": tmp_path / "none.yaml"})
    found = fric.AutoResult(tmp_path, {"x": axis}, [], 1, 1, [], None)
    assert found.verdict.headline.endswith("Missing for a circle: K_f.")
    assert any("GMS" in str(piece) for piece in found.report())  # it is named where the axis is


def test_strokes_that_are_refused_by_their_sign_are_named_where_their_map_is_missing(tmp_path):
    """Strokes at five speeds were asked for, beside five that friction seemed to drive."""
    for path in sorted((DATA / "strokes").glob("*.csv"))[:3]:
        head, *rows = path.read_text().splitlines()
        cells = [row.rpartition(",") for row in rows]
        turned = "\n".join([head, *(f"{first},{-float(force):.4g}" for first, _, force in cells)])
        (tmp_path / path.name).write_text(turned + "\n")
    told = find_sources([tmp_path]).description
    assert [one.code for one in told] == ["file-left-out"]
    axis = AxisOutcome("linear", missing=[NO_STRIBECK, NO_GMS], files={"plant": tmp_path / "none.yaml"})

    def lacking(description):
        found = fric.AutoResult(tmp_path, {"x": axis}, description, 1, 1, [], None).report()
        return [str(piece) for piece in found if str(piece).startswith("missing for ")]

    static, gms = lacking(told)
    assert f"({told[0].where}: see below)" in static
    assert "constant-velocity-01.csv and 2 more" in static
    assert gms == lacking([])[1]
    assert "see below" not in lacking([])[0]


def test_an_axis_whose_friction_is_known_at_one_speed_is_no_machine(rig_plant, rig_static, tmp_path):
    """A machine file without a friction model was written, and the run ended with its error."""
    log = fric.read(DATA / "constant-velocity.h5")[9]
    rig_plant.save(tmp_path / "plant.yaml")
    files = {"plant": tmp_path / "plant.yaml"}
    for name, found in (("one.yaml", fric.identify_static(log)), ("map.yaml", rig_static)):
        found.save(tmp_path / name)
        outcome = AxisOutcome("linear", files=files | {"friction": tmp_path / name})
        assert outcome.whole == (name == "map.yaml")


def test_a_controller_is_as_fast_as_the_fastest_voltage(tmp_path):
    test = read_circles(DATA / "circle.h5")[0]
    rare = {
        name: replace(trace, **{key: values[::4] for key, values in trace.channels().items()})
        for name, trace in test.axes.items()
    }
    for name, axes in {"whole": test.axes, "rare": rare}.items():
        (tmp_path / name).mkdir()
        write_circles(tmp_path / name / "circle.h5", [replace(test, axes=axes)])
        asked = []

        def noted(step, asked=asked):
            asked += [dict(step.options)] if step.command == "identify controller" else []
            raise FricError("it is not made")

        with contextlib.suppress(FricError):
            fric.auto(*LOGS, tmp_path / name, output=tmp_path / f"out-{name}", run=noted)
        assert asked[0].get("sampling") == ("4000 Hz" if name == "rare" else None)


def test_a_slow_circle_is_the_last(folder, tmp_path):
    """Of two, the first was recorded at 200 Hz: gains and tuning failed on it, beside one that shows them."""
    (tmp_path / "logs").mkdir()
    test = read_circles(DATA / "circle.h5")[0]
    every = int(0.005 / float(np.median(np.diff(test.axes[test.names[0]].time))))
    slow = {
        name: replace(trace, **{key: values[::every] for key, values in trace.channels().items()})
        for name, trace in test.axes.items()
    }
    write_circles(tmp_path / "logs" / "a.h5", [replace(test, axes=slow)])
    write_circles(tmp_path / "logs" / "b.h5", [test])
    asked = {}

    def noted(step):
        asked.setdefault(step.command, []).append(step)
        raise FricError("it is not made")

    with contextlib.suppress(FricError):
        fric.auto(*LOGS, tmp_path / "logs", output=tmp_path / "out", run=noted)
    assert asked["identify controller"][0].given[0].stem == "b"
    assert test.is_slow is False
    assert replace(test, axes=slow).is_slow
    steps: list[Any] = []
    session = SimpleNamespace(folder=tmp_path, take=steps.append)
    found, machine = SimpleNamespace(circles=[tmp_path / "logs/b.h5", tmp_path / "logs/a.h5"]), Path("virtual-rig")
    _circles(session, found, {}, machine, [tmp_path / "logs/a.h5"], given=True)
    (tuning,) = [step for step in steps if step.command == "tune"]
    assert list(tuning.given) == [machine, tmp_path / "logs/b.h5"]


def drive_logs(folder, names="time [s],position [mm],force [N]", sign=1.0):
    """Write three logs of a motion with Coulomb friction, and a circle with other columns."""
    folder.mkdir()
    t = np.arange(6000) * 1e-3
    for n in range(3):
        z = (8.0 - 2.0 * n) * np.sin(2 * np.pi * t / 3.0)
        force = sign * 20.0 * np.sign(np.gradient(z)) + np.random.default_rng(n).normal(size=len(t))
        np.savetxt(folder / f"log_{n}.csv", np.column_stack([t, z, force]), "%.5f", ",", header=names, comments="")
    angle = 2 * np.pi * t / 1.9
    x, y = 30.0 * np.cos(angle), 30.0 * np.sin(angle)
    head = "time [s],x position [mm],y position [mm],x force [N],y force [N]"
    rows = np.column_stack([t, x, y, -np.sign(np.sin(angle)), np.sign(np.cos(angle))])
    np.savetxt(folder / "circle.csv", rows, "%.5f", ",", header=head, comments="")
    return folder


def test_forces_that_all_count_against_the_motion_are_turned_and_named(tmp_path):
    """All were left out, and the mend, `sign: -1`, was not said: friction drives no axis."""
    found = find_sources([drive_logs(tmp_path / "logs", sign=-1.0)], proposals=tmp_path / "maps")
    assert sorted(log.path.name for log in found.logs) == ["log_0.csv", "log_1.csv", "log_2.csv"]
    assert [path.name for path in found.traces] == ["circle.csv"]
    assert any("turned" in str(notice) for notice in found.description)


def test_each_file_is_read_by_the_mapping_that_has_its_columns_and_else_by_its_header(tmp_path):
    """One mapping served all: the circle of other columns was left out, and of two mappings the first was dropped."""
    folder = drive_logs(tmp_path / "logs", names="a,b,c")
    of = (
        "columns: {{time: {{column: {}, unit: s}}, position: {{column: {}, unit: mm}}, force: {{column: {}, unit: N}}}}"
    )
    for name, columns in (("strokes", "abc"), ("others", "def")):
        (tmp_path / f"{name}.yaml").write_text(f"fric: mapping/1\naxis: x\n{of.format(*columns)}\n", encoding="utf-8")
    maps = [str(tmp_path / f"{name}.yaml") for name in ("others", "strokes")]
    found = find_sources([folder], maps)
    assert {log.path.name: Path(log.mapping).name for log in found.logs} == dict.fromkeys(
        ["log_0.csv", "log_1.csv", "log_2.csv"], "strokes.yaml"
    )
    assert [path.name for path in found.traces] == ["circle.csv"]
    assert not [notice for notice in found.description if notice.severity == "doubt"]


def test_a_circle_alone_identifies_no_friction_that_it_judges(tmp_path):
    """It was read again as a sine in sliding, LuGre fitted to it, and "at most 560 µm: trusted" said of it."""
    folder = drive_logs(tmp_path / "logs")
    axes = [(a, f"{{time: {{column: time}}, position: {{column: {a} position}}, force: {{column: {a} force}}}}")
            for a in "xy"]  # fmt: skip
    parts = "".join(f"  - axis: {axis}\n    columns: {columns}\n" for axis, columns in axes)
    (tmp_path / "map.yaml").write_text(f"fric: mapping/1\nparts:\n{parts}", encoding="utf-8")
    found = fric.auto(folder / "circle.csv", output=tmp_path / "out", mapping=str(tmp_path / "map.yaml"))
    assert not found.axes
    assert found.verdict.headline.startswith("No scheme is recommended yet. Missing for a circle: strokes")
    assert [line for line in found.verdict.next if line.startswith("fric plan")]


def test_the_sign_of_a_force_is_that_of_most_files(tmp_path):
    """The file of most work, a response, had the say: ten strokes of fourteen were left out."""
    logs = drive_logs(tmp_path / "logs", names="Zeit [s],Weg [mm],Fm [N]", sign=-1.0)
    (logs / "circle.csv").unlink()
    rows = np.loadtxt(logs / "log_0.csv", delimiter=",", skiprows=1)
    for n, factor in enumerate((-10.0, 1.0)):  # a file of more work counts the other way than the rest
        np.savetxt(logs / f"a{n}.csv", rows * [1.0, 1.1 + n, factor], "%.5f", ",", header="Zeit [s],Weg [mm],Fm [N]",
                   comments="")  # fmt: skip
    found = find_sources([logs], proposals=tmp_path / "maps")
    assert sorted(log.path.name for log in found.logs) == ["a0.csv", "a1.csv", "log_0.csv", "log_1.csv", "log_2.csv"]
    assert [str(notice.values["files"]) for notice in found.description if notice.code == "force-by-file"] == [
        str(logs / "a0.csv")
    ]


@pytest.mark.parametrize(
    "header", ["time [ms];pos [mm];force [N];voltage [V]", "time [ms];position [mm];force [N];input [V]"]
)
def test_units_that_some_files_say_are_those_of_files_beside_them_without(tmp_path, header):
    """A clock in ms was one in s on the circle: K_v of 0.1 1/s. Its y has no voltage, and was dropped."""
    for n, log in enumerate(read_logs(DATA / "constant-velocity.h5")[::4]):
        rows = np.column_stack([log.time * 1e3, log.position * 1e3, log.force, log.input])
        np.savetxt(tmp_path / f"v{n}.csv", rows, "%.9g", ";", header=header, comments="")
    x, y = read_circles(DATA / "circle.h5")[0].axes.values()
    rows = np.column_stack([x.time, x.reference, x.position, 1e-3 * x.input, y.reference, y.position]) * 1e3
    names = "time;x_ref;x_pos;x_volt;y_ref;y_pos"
    np.savetxt(tmp_path / "circle.csv", rows, "%.9g", ";", header=names, comments="")
    found = find_sources([tmp_path], proposals=tmp_path / "maps")
    assert [path.name for path in found.traces] == ["circle.csv"]
    (mapping,) = found.traces.values()
    done = fric.ingest_circles(tmp_path / "circle.csv", output=tmp_path / "circle.h5", mapping=mapping or None)
    assert done.done.tests[0].feed == pytest.approx(read_circles(DATA / "circle.h5")[0].feed, rel=1e-3)


def test_logs_that_are_left_out_beside_a_circle_are_the_reason_of_the_verdict(tmp_path):
    """It said that strokes are missing, and they were there, in counts of no known size."""
    logs = drive_logs(tmp_path / "logs", names="time [s],position [count],force [N]")
    found = fric.auto(logs, output=tmp_path / "out")
    assert "log_0.csv and 2 more: Left out: " in found.verdict.headline
    assert "counts" in found.verdict.headline


def test_a_mapping_of_circles_gives_the_circle_among_the_logs(tmp_path):
    """A mapping of `kind: circle`, as the formats page has it, was refused: "such a record has no x.force"."""
    logs = drive_logs(tmp_path / "logs", names="a,b,c")
    text = (logs / "circle.csv").read_text(encoding="utf-8").partition("\n")[2]
    (logs / "circle.csv").write_text(f"a,p,q,r,s\n{text}", encoding="utf-8")
    channels = {"time": "a, unit: s", "x.position": "p, unit: mm", "y.position": "q, unit: mm",
                "x.force": "r, unit: N", "y.force": "s, unit: N"}  # fmt: skip
    columns = "".join(f"  {name}: {{column: {of}}}\n" for name, of in channels.items())
    (tmp_path / "circle.yaml").write_text(f"fric: mapping/1\nkind: circle\ncolumns:\n{columns}", encoding="utf-8")
    of = "{time: {column: a, unit: s}, position: {column: b, unit: mm}, force: {column: c, unit: N}}"
    (tmp_path / "strokes.yaml").write_text(f"fric: mapping/1\naxis: x\ncolumns: {of}\n", encoding="utf-8")
    with pytest.raises(FricError, match="there is no such file"):
        fric.auto(logs / "other.csv", output=tmp_path / "out", mapping=None)  # as it was before there were several
    for names in (("circle", "strokes"), ("strokes", "circle")):
        found = find_sources([logs], [str(tmp_path / f"{name}.yaml") for name in names])
        assert found.traces == {logs / "circle.csv": str(tmp_path / "circle.yaml")}
        assert sorted(log.path.name for log in found.logs) == ["log_0.csv", "log_1.csv", "log_2.csv"]
    both = f"fric: mapping/1\nparts:\n- kind: circle\n  columns:\n{columns.replace('  ', '    ')}"
    (tmp_path / "both.yaml").write_text(f"{both}- axis: x\n  columns: {of}\n", encoding="utf-8")
    found = find_sources([logs], [str(tmp_path / "both.yaml")])
    assert (found.traces, len(found.logs)) == ({logs / "circle.csv": str(tmp_path / "both.yaml")}, 3)
    done = fric.ingest_circles(logs / "circle.csv", output=tmp_path / "circle.h5", mapping=tmp_path / "both.yaml")
    assert len(done.done.tests) == 1
