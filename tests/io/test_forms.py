"""Forms that genuine logs have, each found to be lost or read wrongly once."""

import json
import re
import shlex
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import h5py
import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat
from typer.testing import CliRunner

import fric
from fric.automatic.sources import Source, find_sources
from fric.automatic.steps import axis_steps
from fric.cli.main import app
from fric.errors import FricError
from fric.io.circle import read_circles
from fric.io.hdf5 import read_logs
from fric.io.propose import guessed, guesses, proposal
from fric.io.questions import Question, answered
from fric.io.readers import tables
from fric.io.readers.base import Column, named
from fric.io.roles import SURE, AxisColumns, axes_of
from fric.io.words import spoken, usual_units
from fric.reference import circle as circle_reference
from fric.units import converts, factor, parse
from tests.io.judge import open_roles
from tests.io.test_roles import axis_of_a_drive, told, write


def channels(axis: AxisColumns) -> dict[str, int | None]:
    return {channel: role.column for channel, role in axis.roles.items()}


@pytest.mark.parametrize("form", ["%d.%m.%Y %H:%M:%S,", "%d/%m/%Y %H:%M:%S.", "seconds"])
def test_stamps_with_a_decimal_comma_or_a_unit_are_a_clock(tmp_path: Path, form: str) -> None:
    """A German date ended the reader, for the column was no text any more where it was looked at again."""
    a = axis_of_a_drive(n=1500)
    base = np.datetime64("2024-03-11T13:01:02")
    stamps = [f"{t:.3f} sec" for t in a["t"]]
    if form != "seconds":
        whole = [base + np.timedelta64(int(t), "s") for t in a["t"]]
        stamps = [
            f"{at.astype(object).strftime(form)}{1e6 * (t % 1):06.0f}" for at, t in zip(whole, a["t"], strict=True)
        ]
    rows = [f"{s};{p:.6f};{i:.4f}".replace(".", ",") if form[2:3] == "." else f"{s};{p:.6f};{i:.4f}"
            for s, p, i in zip(stamps, a["position"], a["current"], strict=True)]  # fmt: skip
    if form[2:3] == ".":
        rows = [f"{s};{row.partition(';')[2]}" for s, row in zip(stamps, rows, strict=True)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["Zeitstempel;Istlage [rad];Motorstrom [A]", *rows]) + "\n")
    (block,) = next(tables(path)).read([0])
    np.testing.assert_allclose(np.diff(block.columns[0]), 1e-3, atol=2e-6)


@pytest.mark.parametrize("unit", ["min-1", "r/min", "tr/min", "U/min", "1/min"])
def test_speeds_in_revolutions_a_minute_are_of_a_rotary_axis(tmp_path: Path, unit: str) -> None:
    a = axis_of_a_drive()
    head = f"t [s];Feedback speed [{unit}];Torque reference [%]"
    (axis,) = told(write(tmp_path / "log.csv", head, a["t"], a["velocity"] * 9.5493, a["current"]))
    assert axis.motion == "rotary/%"
    assert axis.roles["velocity"].unit_likelihood >= SURE


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_a_list_of_names_beside_a_matrix_heads_its_columns(tmp_path: Path, version: str) -> None:
    a = axis_of_a_drive()
    names, units = ["Zeit", "x_ist", "F_motor"], ["s", "rad", "Nm"]
    data = np.column_stack([a["t"], a["position"], a["current"]])
    path = tmp_path / "log.mat"
    if version == "5":
        savemat(path, {"daten": data, "namen": np.array(names, object), "einheiten": np.array(units, object)})
    else:
        with h5py.File(path, "w", userblock_size=512) as file:
            file["daten"] = data.T
            for key, texts in (("namen", names), ("einheiten", units)):
                cells = file.create_dataset(key, (1, 3), dtype=h5py.ref_dtype)
                for n, text in enumerate(texts):
                    cell = file.create_dataset(f"#refs#/{key}{n}", data=np.array([[ord(c)] for c in text], "u2"))
                    cell.attrs["MATLAB_class"] = np.bytes_("char")
                    cells[0, n] = cell.ref
        with path.open("r+b") as raw:
            raw.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM")
    (axis,) = told(path)
    assert {channel: role.unit for channel, role in axis.roles.items()} == {
        "time": "s",
        "position": "rad",
        "force": "Nm",
    }


def test_structs_of_axes_are_axes_and_not_records_of_one(tmp_path: Path) -> None:
    """The currents of two axes were the strokes of a single one, whose friction lay between theirs."""

    def struct(seed: int, size: float) -> dict[str, dict[str, object]]:
        a = axis_of_a_drive(seed=seed)
        units = {"t": ("t", "s"), "pos": ("position", "rad"), "iq": ("current", "A")}
        return {
            key: {"values": a[of] * (size if key == "iq" else 1.0), "unit": unit} for key, (of, unit) in units.items()
        }

    savemat(tmp_path / "run.mat", {"rec": {"X": struct(0, 1.0), "Y": struct(1, 2.0)}})
    found = find_sources([tmp_path / "run.mat"], proposals=tmp_path / "made", assume=True)
    assert sorted((log.axis, log.motion) for log in found.logs) == [("x", "rotary/A"), ("y", "rotary/A")]


def test_the_turn_of_an_encoder_says_what_a_count_is(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    counts = np.round(5.0 * a["position"] / (2 * np.pi) * 4096) % 4096
    path = write(tmp_path / "log.csv", "ms;present_position;present_current", 1e3 * a["t"], counts, a["current"])
    (axis,) = told(path)
    assert axis.roles["time"].unit == "ms"
    assert axis.motion.startswith("rotary")
    assert parse(axis.roles["position"].unit, "position", "rotary") == pytest.approx(2 * np.pi / 4096)
    assert axis.roles["position"].unit_likelihood >= SURE


def test_a_speed_in_rpm_says_what_a_count_is(tmp_path: Path) -> None:
    """The position was taken for micrometres, and the speed, whose unit the header gives, left out."""
    a = axis_of_a_drive()
    counts, speed = np.round(a["position"] / (2 * np.pi) * 65536), a["velocity"] * 9.5493
    head = "Time (ms);IL.FB (Arms);PL.FB (counts);VL.FB (rpm)"
    (axis,) = told(write(tmp_path / "scope.csv", head, 1e3 * a["t"], a["current"], counts, speed))
    assert channels(axis) == {"time": 0, "position": 2, "velocity": 3, "force": 1}
    assert parse(axis.roles["position"].unit, "position", "rotary") == pytest.approx(2 * np.pi / 65536)


def test_encoders_of_motor_and_load_are_of_one_axis(tmp_path: Path) -> None:
    """A motor's speed in rpm is none of the angle behind its gear; that angle is the position of the load."""
    a = axis_of_a_drive()
    counts, speed = np.round(50 * a["position"] / (2 * np.pi) * 4096), 50 * a["velocity"] * 9.5493
    head = "t_s;motor_enc_cnt;link_angle_deg;torque_sensor_Nm;motor_speed_rpm"
    columns = [a["t"], counts, np.degrees(a["position"]), a["current"], speed]
    (axis,) = told(write(tmp_path / "joint.dat", head, *columns))
    assert channels(axis) == {"time": 0, "position": 1, "velocity": 4, "force": 3, "load_position": 2}
    assert axis.roles["load_position"].unit == "deg"


def test_the_same_current_twice_is_no_question(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    columns = [a["t"], a["position"], a["current"], a["current"]]
    (axis,) = told(write(tmp_path / "log.csv", "t;pos;current_motor;iq", *columns))
    assert axis.roles["force"].likelihood >= SURE


def test_runs_of_a_file_are_records(tmp_path: Path) -> None:
    """A time that began again was dropped until it had caught up: of four runs, parts of each were one record."""
    a = axis_of_a_drive(n=2000)
    rows = []
    for n in range(3):
        rows += [f"# run {n + 1}", "time (s), x (rad), i (A)"]
        columns = (a[name][n * 100 :] for name in ("t", "position", "current"))
        rows += [f"{t:.3f}, {p + 0.1 * n:.6f}, {i:.4f}" for t, p, i in zip(*columns, strict=True)]
    (tmp_path / "runs.txt").write_text("\n".join(rows) + "\n")
    done = fric.ingest(tmp_path / "runs.txt", output=tmp_path / "log.h5", assume=True)
    assert [len(log) for log in read_logs(tmp_path / "log.h5")] == [2000, 1900, 1800]
    assert done.done.samples == 5700
    assert all(np.diff(log.time).max() < 2e-3 for log in read_logs(tmp_path / "log.h5"))


def test_a_demand_that_the_axis_follows_badly_is_of_its_axis(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    columns = [a["t"], a["position"], 0.7 * a["position"] + 0.02 * np.sin(9 * a["t"]), a["velocity"], a["current"]]
    idle = np.zeros_like(a["t"])
    of_axis = (
        "Position mesurée {} (rad)",
        "Consigne position {} (rad)",
        "Vitesse mesurée {} (rad/s)",
        "Courant {} (A)",
    )
    head = ";".join(["Temps (s)", *(name.format(k) for k in (4, 5) for name in of_axis)])
    axes = axes_of([next(tables(write(tmp_path / "essai.csv", head, *columns, idle, idle, idle, idle)))])
    assert [channels(axis) for axis in axes] == [{"time": 0, "reference": 2, "position": 1, "velocity": 3, "force": 4}]


def test_a_load_without_its_sign_is_no_force(tmp_path: Path) -> None:
    """Its friction came out near zero, and negative: a magnitude shows friction in no direction."""
    a = axis_of_a_drive()
    head = "t [s];X position [mm];X feed [mm/s];X Auslastung [%]"
    columns = [a["t"], 1e2 * a["position"], 1e2 * a["velocity"], np.round(np.abs(a["current"]), 1)]
    (axis,) = told(write(tmp_path / "log.csv", head, *columns))
    assert "force" not in axis.roles
    columns[-1] = 3.0 * np.abs(a["current"]).max() + a["current"]  # that holds a weight, and keeps its sign
    (axis,) = told(write(tmp_path / "up.csv", head, *columns))
    assert axis.roles["force"].column == 3


def test_japanese_names_say_what_columns_are(tmp_path: Path) -> None:
    a = axis_of_a_drive(n=3000)
    rows = [
        f"{1e3 * t:.0f},{9.5493 * v:.1f},{i:.2f}" for t, v, i in zip(a["t"], a["velocity"], a["current"], strict=True)
    ]
    head = "時間[ms],フィードバック速度[min-1],トルク指令[%]"
    (tmp_path / "log.csv").write_text("\r\n".join([head, *rows]) + "\r\n", encoding="cp932")
    (table,) = tables(tmp_path / "log.csv")
    assert [column.name for column in table.columns] == ["時間", "フィードバック速度", "トルク指令"]
    (axis,) = told(tmp_path / "log.csv")
    assert {channel: role.unit for channel, role in axis.roles.items()} == {
        "time": "ms", "velocity": "min-1", "force": "%"
    }  # fmt: skip


def test_strokes_in_motions_make_a_map(tmp_path: Path) -> None:
    """With one record of strokes and two of moves by the same commands, the moves were replayed: 9.9 A for 0.7 A."""
    logs = [Source(tmp_path / f"{kind}.h5", "x", "rotary/A", frozenset({kind}), frozenset({"static", "motion"}),
                   strokes=n) for kind, n in (("constant-velocity", 5), ("motion", 8))]  # fmt: skip
    steps = axis_steps(logs, tmp_path)
    assert [step.command for step in steps.steps if "static" in step.name] == ["identify static"]
    assert not any("lugre" in step.name for step in steps.steps)


@pytest.mark.parametrize(
    ("name", "values", "unit"),
    [
        ("total_volts", [0.3, -2.4], "V"), ("Uq", [0.3, -2.4], "V"), ("pwm", [0.25, -1.0], "100 %"),
        ("duty", [40.0, -87.5], "%"), ("PWM", [255.0, -120.0], "count"), ("ActualTorque", [420.0, -377.0], "count"),
        ("column 5", [0.3, -2.4], "count"), ("column 5", [12.0, *[-12.0] * 50, 3.1], "V"),
    ],
)  # fmt: skip
def test_an_effort_without_a_unit_is_asked_for_and_is_in_its_counts_where_nothing_says(
    name: str, values: list[float], unit: str
) -> None:
    """What a drive puts out was assumed to be in A, with 50 %."""
    found, sure, others = usual_units("force", spoken(Column(name)), "rotary", np.array(values))
    assert found == unit
    assert sure < SURE
    assert len(others) > 1


def test_a_duty_of_one_is_a_hundred_per_cent(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    duty = np.clip(0.4 * a["current"], -1, 1)
    path = write(tmp_path / "log.csv", "t [s];angle [rad];pwm", a["t"], a["position"], duty)
    fric.ingest(path, output=tmp_path / "log.h5", assume=True)
    (log,) = read_logs(tmp_path / "log.h5")
    assert (log.motion, log.unit("force")) == ("rotary/%", "%")
    assert log.force is not None
    assert np.median(np.abs(log.force)) == pytest.approx(40.0, rel=0.1)


def test_volts_of_a_feedforward_are_not_the_force(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    head = "time_ms;set_position;actual_position;actual_speed;ff_volts;total_volts"
    volts = np.sign(a["speed"]) + 0.01 * a["acceleration"]
    (axis,) = told(write(tmp_path / "log.csv", head, 1e3 * a["t"], a["asked"], a["position"], a["velocity"], volts,
                         a["current"]))  # fmt: skip
    assert axis.roles["force"].column == 5
    assert axis.motion.endswith("/V")


def test_motors_by_number_take_turns(tmp_path: Path) -> None:
    """Rows of three motors were one record, and its friction was 0.95 (open above) of 0.6, 0.4 and 0.25 N·m."""
    a, n = axis_of_a_drive(), 1500
    rows = [f"{a['t'][k]:.4f},{j},{a['position'][k + 300 * j]:.6f},{a['current'][k + 300 * j]:.4f}"
            for k in range(n) for j in (1, 2)]  # fmt: skip
    (tmp_path / "log.csv").write_text("timestamp,motor_id,position,torque\n" + "\n".join(rows) + "\n")
    table = next(tables(tmp_path / "log.csv"))
    assert [c.name for c in table.columns] == ["timestamp", "position[1]", "position[2]", "torque[1]", "torque[2]"]


def test_names_on_numbered_lines_head_columns(tmp_path: Path) -> None:
    """Data recorders of stages list names one a line; four words of another line were taken for them."""
    a = axis_of_a_drive()
    head = ["REM Created by Recorder", "SAMPLE_TIME = 0.001", "NAME0 = Commanded Position", "NAME1 = Actual Position",
            "NAME2 = Actual Velocity", "NAME3 = Motor Output", "END_HEADER"]  # fmt: skip
    path = tmp_path / "rec.dat"
    data = np.column_stack([a["asked"], a["position"], a["velocity"], a["current"]])
    np.savetxt(path, data, header="\n".join(head), fmt="%.6f")
    (axis,) = told(path)
    assert channels(axis) == {"time": None, "reference": 0, "position": 1, "velocity": 2, "force": 3}
    assert axis.roles["time"].unit == "0.001 s"
    assert axis.roles["time"].unit_likelihood >= SURE
    head = "[HEADER]\nSampleTime=0.001\n[SIGNALS]\n1=s actual Y [mm]\n2=v actual Y [mm/min]\n3=I actual Y [A]\n[DATA]"
    (axis,) = told(write(tmp_path / "scope.dat", head, a["position"], 60 * a["velocity"], a["current"]))
    assert [(role.unit, role.unit_likelihood >= SURE) for role in axis.roles.values()] == [
        ("0.001 s", True), ("mm", True), ("mm/min", True), ("A", True)
    ]  # fmt: skip


def test_a_speed_in_a_state_is_that_of_vesc_and_electrical(tmp_path: Path) -> None:
    """A state is no position: the velocity was header.stamp.nsecs."""
    a = axis_of_a_drive()
    (axis,) = told(write(tmp_path / "core.csv", "Time;state.speed;state.displacement;state.current_motor", a["t"],
                         10 * a["velocity"], a["position"], a["current"]))  # fmt: skip
    assert channels(axis) == {"time": 0, "position": 2, "force": 3}
    assert not axis.roles["position"].unit


def test_a_scale_in_mm_and_a_motor_in_rpm_are_on_a_screw(tmp_path: Path) -> None:
    """They were revolutions, at 43 %."""
    a = axis_of_a_drive()
    (axis,) = told(write(tmp_path / "nut.csv", "Time;Position;Drehzahl;Strom", a["t"], 20 * a["position"],
                         120.0 * a["velocity"], a["current"]))  # fmt: skip
    assert (axis.motion, axis.roles["position"].unit, axis.roles["time"].unit) == ("linear/A", "mm", "s")


@pytest.mark.parametrize(
    "head", ["position_actual_value;velocity_actual_value;torque_actual_value", "pos_counts;vel_counts;current"]
)
def test_counts_of_a_drive_are_not_assumed(tmp_path: Path, head: str) -> None:
    """They were micrometres, at 85 %."""
    a = axis_of_a_drive()
    path = write(tmp_path / "pdo.csv", f"time_us;{head}",
                 np.round(1e6 * a["t"]), np.round(1e4 * a["position"]), np.round(1e4 * a["velocity"]),
                 np.round(100 * a["current"]))  # fmt: skip
    found = find_sources([path], proposals=tmp_path / "maps", assume=True)
    assert not found.logs
    assert any("is in counts: say what one is" in why for why in found.refused)


def test_structs_of_matrices_are_records(tmp_path: Path) -> None:
    """The times of three experiments were one another's positions."""
    a = axis_of_a_drive()
    runs = np.empty(3, object)
    for k in range(3):
        x = np.column_stack([a["position"], a["velocity"]])
        runs[k] = {"t": a["t"], "x": x, "u": a["current"][:, None]}
    savemat(tmp_path / "traces.mat", {"tests": runs, "dt": 1e-3})
    found = list(tables(tmp_path / "traces.mat"))
    assert [[c.name for c in table.columns] for table in found] == [["t", "x(:,1)", "x(:,2)", "u"]] * 3


def test_a_column_named_rpm_is_in_rpm(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    counts = np.floor(a["position"] * 1440 / (2 * np.pi))
    (axis,) = told(write(tmp_path / "log.csv", "Time(ms);Encoder;RPM;Current(mA)", 1e3 * a["t"], counts,
                         a["velocity"] * 9.5493, 1e3 * a["current"]))  # fmt: skip
    assert axis.motion == "rotary/A"
    assert not open_roles(axis)


def test_a_question_about_a_position_in_counts_takes_the_counts_of_a_turn(tmp_path: Path) -> None:
    """A servo's log in counts and tenths of rpm could be said to be in µm or mdeg, and not in what it is."""
    a = axis_of_a_drive()
    counts, tenths = np.round(a["position"] * 131072 / (2 * np.pi)), np.round(a["velocity"] * 95.493)
    path = write(tmp_path / "pdo.csv", "Time[ms];ActualPosition;ActualVelocity;ActualTorque", 1e3 * a["t"], counts,
                 tenths, np.round(100 * a["current"]))  # fmt: skip
    asked = list[str]()

    def ask(question: Question) -> None:
        asked.append(question.text)
        assert question.take("131072" if "counts has a turn" in question.text else "0.1 %")

    with ExitStack() as files:
        guess = guessed([path], files, assume=True)
        mapping, _ = answered(guess, ask, tmp_path)
    assert len(asked) == 2
    fric.ingest(path, output=tmp_path / "log.h5", mapping=mapping)
    (log,) = read_logs(tmp_path / "log.h5")
    assert log.motion == "rotary/%"
    np.testing.assert_allclose(log.position, a["position"], atol=1e-4)
    np.testing.assert_allclose(log.force, np.round(100 * a["current"]) / 10)


def test_letters_behind_names_are_axes_and_those_before_them_are_not(tmp_path: Path) -> None:
    """``s-Ist X``, ``v-Ist X`` and ``I-Ist X`` were of axes s, v and i, and no axis had a current."""
    a = axis_of_a_drive()
    parts = [(a["position"][k:][:3500], a["velocity"][k:][:3500], a["current"][k:][:3500]) for k in (0, 325)]
    head = ";".join(["t [s]", *(f"{q} {ax} [{u}]" for ax in "XY" for q, u in
                                (("s-Ist", "mm"), ("v-Ist", "mm/s"), ("I-Ist", "A")))])  # fmt: skip
    found = told(write(tmp_path / "log.csv", head, a["t"][:3500], *parts[0], *parts[1]))
    assert [channels(axis) for axis in found] == [
        {"time": 0, "position": 1, "velocity": 2, "force": 3}, {"time": 0, "position": 4, "velocity": 5, "force": 6},
    ]  # fmt: skip


def test_stamps_with_a_zone_are_seconds(tmp_path: Path) -> None:
    rows = [f"2024-05-11T08:00:{0.1 * k:06.3f}Z,{k},{k}" for k in range(50)]
    (tmp_path / "log.csv").write_text("timestamp,x,y\n" + "\n".join(rows) + "\n")
    (block,) = next(tables(tmp_path / "log.csv")).read([0])
    np.testing.assert_allclose(np.diff(block.columns[0]), 0.1, atol=1e-6)


def test_counts_a_second_are_no_radians_a_second(tmp_path: Path) -> None:
    """Of a linear motor's counts a rotary axis was made without a question."""
    a = axis_of_a_drive()
    head = "Time [sec];Position [counts];Velocity [counts/sec];Active Current [A]"
    path = write(tmp_path / "rec.csv", head, a["t"], np.round(2e4 * a["position"]), 2e4 * a["velocity"], a["current"])
    (axis,) = told(path)
    assert channels(axis) == {"time": 0, "position": 1, "velocity": 2, "force": 3}
    assert axis.roles["position"].unit_likelihood < SURE
    assert parse("180 Grd", "position", "rotary") == pytest.approx(np.pi)


def labview(path: Path, rows: list[str], head: str = "X_Value\tPosition\tForce\tComment") -> Path:
    """Write a measurement of LabVIEW without its time."""
    lines = ["LabVIEW Measurement\t", "Separator\tTab", "X_Columns\tNo", "***End_of_Header***\t", "\t",
             "Channels\t2\t\t", "Samples\t9\t9\t", "Y_Unit_Label\tmm\tN\t", "X0\t0.0E+0\t0.0E+0\t",
             "Delta_X\t0.000500\t0.000500\t", "***End_of_Header***\t\t\t", head]  # fmt: skip
    path.write_text("\n".join([*lines, *rows]) + "\n")
    return path


def test_a_measurement_of_labview_without_its_time_has_its_period(tmp_path: Path) -> None:
    """`Delta_X` above the header passed for the first sample, whose first cell is empty below it."""
    a = axis_of_a_drive(dt=5e-4)
    rows = [f"\t{x:.6f}\t{f:.4f}" for x, f in zip(a["position"], a["current"], strict=True)]
    table = next(tables(labview(tmp_path / "run.lvm", rows)))
    assert [*table.columns][1:] == [Column("Position", "mm"), Column("Force", "N")]
    (axis,) = axes_of([table])
    assert channels(axis) == {"time": None, "position": 1, "force": 2}
    assert (axis.roles["time"].unit, open_roles(axis)) == ("0.0005 s", [])


def test_a_sheet_of_notes_hides_no_sheet_of_numbers(tmp_path: Path) -> None:
    book = pytest.importorskip("openpyxl").Workbook()
    for row in (("Load", "10 kg"), ("Grease", "yes")):
        book.active.append(row)
    sheet = book.create_sheet("Data")
    for row in (("Zeit [s]", "Weg [mm]"), *((0.01 * k, 0.5 * k) for k in range(20))):
        sheet.append(row)
    book.save(tmp_path / "test.xlsx")
    (table,) = tables(tmp_path / "test.xlsx")
    assert [*table.columns] == [Column("Zeit", "s"), Column("Weg", "mm")]


def test_decimal_commas_in_quotes_are_numbers_between_commas(tmp_path: Path) -> None:
    rows = [f'"{0.1 * k:.1f}","{2.5 * k:.2f}"'.replace(".", ",") for k in range(40)]
    (tmp_path / "export.csv").write_text("\n".join(['"Time [s]","Position [mm]"', *rows]) + "\n")
    (block,) = next(tables(tmp_path / "export.csv")).read([0, 1])
    np.testing.assert_allclose(block.columns, [0.1 * np.arange(40), 2.5 * np.arange(40)])


@pytest.mark.parametrize(
    ("name", "quantity", "unit"),
    [("motor_torque_nm", "force", "N*m"), ("position_nm", "position", "nm"), ("currentADC", "force", "count"),
     ("field.header.seq", "row", None)],
)  # fmt: skip
def test_what_names_and_their_ends_say(name: str, quantity: str, unit: str | None) -> None:
    """A torque was a position in nanometres, a converter's counts were amperes, and a count of messages an axis."""
    assert spoken(named(name))[:2] == (quantity, unit)


def test_a_speed_whose_unit_begins_with_a_number_is_no_scale(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    path = write(tmp_path / "spindle.csv", "Zeit in ms;Drehzahl (1/min);Motormoment (%)", 1e3 * a["t"],
                 9.5493 * a["velocity"], a["current"])  # fmt: skip
    done = fric.ingest(path, output=tmp_path / "log.h5", assume=True)
    assert done.warnings
    (log,) = read_logs(tmp_path / "log.h5")
    assert log.velocity is not None
    np.testing.assert_allclose(log.velocity, a["velocity"], atol=1e-3)


@pytest.mark.parametrize(("names", "unit", "size"), [("q1;dq1;tau1", "rad", 1.0), ("a;b;c", "rad", 1.0),
                         ("enc.pos_estimate;enc.vel_estimate;Iq", "rev", 20.0)])  # fmt: skip
def test_customs_and_steps_of_encoders_say_what_an_angle_is_in(
    tmp_path: Path, names: str, unit: str, size: float
) -> None:
    a = axis_of_a_drive()
    step = 2.0 * np.pi / 2.0**16 if unit == "rad" else 1e-5
    position = np.round(size * a["position"] / step) * step
    (axis,) = told(write(tmp_path / "log.csv", f"t;{names}", a["t"], position, size * a["velocity"], a["current"]))
    assert axis.roles["position"].unit == unit
    assert axis.roles["position"].unit_likelihood > (0.85 if unit == "rev" else SURE)


def test_an_axis_that_does_not_move_is_no_log_of_friction(tmp_path: Path) -> None:
    """A plant of −0.006 was identified from its noise."""
    rng = np.random.default_rng(0)
    noise = [rng.normal(level, 0.01, 4000) for level in (120.0, 0.0, 0.3)]
    path = tmp_path / "still.csv"
    write(path, "time [s];position [mm];velocity [mm/s];force [N]", 1e-3 * np.arange(4000), *noise)
    with pytest.raises(FricError, match="does not move"):
        fric.auto(path, output=tmp_path / "out")


def test_a_zip_beside_other_files_is_opened(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    log = write(tmp_path / "run.csv", "time [s];position [rad];torque [N*m]", a["t"], a["position"], a["current"])
    folder = tmp_path / "logs"
    folder.mkdir()
    (folder / "overview.csv").write_text("file,grease\nrun.csv,yes\n")
    zipped(folder / "raw.zip", "run.csv", log.read_bytes())
    assert [source.path.name for source in find_sources([folder], (), tmp_path / "out" / "mappings").logs] == [
        "run.csv"
    ]


def test_channels_in_files_of_their_own_are_joined_where_the_likeliest_is_assumed(tmp_path: Path) -> None:
    """Whose names share no more than a run, which `fric auto` joins not: it said that there was no position."""
    a = axis_of_a_drive()
    for run in (1, 2):
        write(tmp_path / f"run{run}_of_laser.csv", "Time [s];Displacement [mm]", a["t"], a["position"])
        write(tmp_path / f"run{run}_cell.csv", "Time [s];Load cell [N]", a["t"][::2], a["current"][::2])
    with pytest.raises(FricError, match=r"--join run1_cell\.csv run1_of_laser\.csv --assume"):
        fric.auto(tmp_path, output=tmp_path.parent / f"{tmp_path.name}-out", assume=True)
    pair = [tmp_path / "run1_cell.csv", tmp_path / "run1_of_laser.csv"]
    done = fric.ingest(*pair, output=tmp_path / "log.h5", join=True, assume=True)
    assert any('force is "Load cell"' in warning for warning in done.warnings)
    (log,) = read_logs(tmp_path / "log.h5")
    assert log.force is not None
    np.testing.assert_allclose(log.force, a["current"][::2], atol=1e-6)


def test_files_to_join_whose_units_are_open_are_given_a_command_that_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was to --assume them, which ends in "a unit is open that no likelihood tells"."""
    a = axis_of_a_drive()
    (logs := tmp_path / "logs").mkdir()
    write(logs / "status_0.csv", "timestamp;timestamp_sample;pitch;pitch_rate", 1e6 * a["t"], 1e6 * a["t"] - 180,
          a["position"], a["velocity"])  # fmt: skip
    write(logs / "motor_0.csv", "timestamp;motor_current", 1e6 * a["t"], a["current"])
    with pytest.raises(FricError) as error:
        fric.auto(logs, output=tmp_path / "out")
    monkeypatch.chdir(logs)
    assert CliRunner().invoke(app, shlex.split(re.findall("`(fric .*?)`", error.value.hint)[0])[1:]).exit_code == 0
    assert 'column: "timestamp", unit: "?"' in (logs / "map.yaml").read_text()


def test_the_reason_of_a_choice_is_that_of_the_choice(tmp_path: Path) -> None:
    """A velocity without a name was one that was "smooth as a position is", and a stated period one of the motion."""
    a = axis_of_a_drive(n=8000)
    (axis,) = told(write(tmp_path / "log.csv", "", a["t"], a["velocity"], a["current"]))
    assert "a force goes with it" in axis.roles["velocity"].why
    savemat(tmp_path / "z.mat", {"u": a["current"], "y": a["position"], "Ts": 0.001})
    assert '{period: "0.001 s"}      # the file says Ts' in proposal([tmp_path / "z.mat"])


def test_an_axis_that_rests_at_first_moves(tmp_path: Path) -> None:
    """Of 2000 rows at rest it had two values, and was no axis."""
    a = axis_of_a_drive(n=6000)
    rest = np.zeros(3000)
    columns = [np.concatenate([before, a[name]]) for before, name in ((rest, "position"), (rest, "current"))]
    path = write(tmp_path / "log.csv", "Time (s);Angle (rad);Torque (Nm)", 1e-3 * np.arange(9000), *columns)
    (axis,) = told(path)
    assert channels(axis) == {"time": 0, "position": 1, "force": 2}


def test_a_voltage_that_never_changes_drives_nothing(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    names = "t_us;motor_pos_rad;motor_vel_radps;iq_A;battery_V"
    same = np.full(4000, 24.0)
    write(tmp_path / "log.csv", names, 1e6 * a["t"], a["position"], a["velocity"], a["current"], same)
    with ExitStack() as files:
        (guess,) = guessed([tmp_path / "log.csv"], files, assume=True).found
        assert set(guess.axis.roles) == {"time", "position", "velocity", "force"}


def test_names_beside_matrices_in_cells_are_those_of_their_columns(tmp_path: Path) -> None:
    cells = np.empty((1, 3), object)
    for k in range(3):
        a = axis_of_a_drive(seed=k)
        cells[0, k] = np.column_stack([a[name] for name in ("t", "position", "velocity", "current")])
    names = np.array(["time", "theta", "omega", "torque"], object)
    savemat(tmp_path / "data.mat", {"data": cells, "labels": names})
    found = [[column.name for column in table.columns] for table in tables(tmp_path / "data.mat")]
    assert found == [[*names]] * 3


@pytest.mark.parametrize("lying", [True, False])
def test_groups_and_datasets_of_foreign_hdf5_are_records(tmp_path: Path, lying: bool) -> None:
    """A folder of such files had "no log" in it."""
    with h5py.File(tmp_path / "runs.h5", "w") as file:
        for k in range(2):
            a = axis_of_a_drive(seed=k)
            group = file.create_group(f"run_{k}")
            for name, key, unit in (("time", "t", "s"), ("angle", "position", "rad"), ("torque", "current", "N*m")):
                values = a[key] if lying else a[key][:, None]
                group.create_dataset(name, data=values).attrs["unit"] = unit
    found = find_sources([tmp_path], (), tmp_path.parent / f"{tmp_path.name}-out", assume=True)
    (source,) = found.logs
    log = tmp_path.parent / f"{tmp_path.name}.h5"
    fric.ingest(tmp_path / "runs.h5", output=log, assume=True)
    assert [len(record) for record in read_logs(log)] == [4000, 4000]
    assert source.motion == "rotary"


@pytest.mark.parametrize("clock", ["attribute of each", "a dataset"])
def test_a_circle_in_a_group_beside_those_of_strokes_is_found(tmp_path: Path, clock: str) -> None:
    """It was dropped without a word, and the rate that is an attribute of a group was not read."""
    folder, x, y = tmp_path / "logs", *circle_reference(0.03, 0.1, 2, 1000.0)
    folder.mkdir()

    def put(group: h5py.Group, rate: float, **columns: np.ndarray) -> None:
        if clock == "a dataset":
            columns["time"] = np.arange(len(next(iter(columns.values())))) / rate
        else:
            group.attrs["fs"] = rate
        for name, values in columns.items():
            unit = {"time": "s", "current": "A"}.get(name.rpartition("_")[2], "mm")
            group.create_dataset(name, data=values).attrs["unit"] = unit

    with h5py.File(folder / "runs.h5", "w") as file:
        for k, thinned in enumerate((1, 2)):
            a = axis_of_a_drive(seed=k)
            moved = {"position": 10 * a["position"][::thinned], "current": a["current"][::thinned]}
            put(file.create_group(f"run_{k}"), 1e3 / thinned, **moved)
        shown = {f"{name}_{of}": at for name, axis in (("x", x), ("y", y)) for of, at in (
            ("reference", 1e3 * axis.position), ("position", 1e3 * axis.position + 1e-3), ("current", axis.velocity),
        )}  # fmt: skip
        put(file.create_group("circle"), 1e3, **shown)
    found = find_sources([folder], (), tmp_path / "out", assume=True)
    assert [*found.traces] == [folder / "runs.h5"]
    (source,) = found.logs
    log = tmp_path / "log.h5"
    fric.ingest(folder / "runs.h5", output=log, mapping=source.mapping or None)
    assert [record.time[1] - record.time[0] for record in read_logs(log)] == pytest.approx([1e-3, 2e-3])
    fric.ingest_circles(folder / "runs.h5", output=tmp_path / "c.h5")
    (test,) = read_circles(tmp_path / "c.h5")
    assert (test.radius, test.feed) == (0.03, 0.1)
    assert not found.refused


@pytest.mark.parametrize("name", ["Control voltage", "Command voltage", "Steuerspannung", "DAC output"])
def test_a_control_voltage_beside_exact_names_is_the_input(tmp_path: Path, name: str) -> None:
    """Time, position and force were read by their names, and the voltage was left out: gains and delay were lost."""
    a = axis_of_a_drive()
    rows = np.column_stack([a["t"], a["position"], a["current"], 0.1 * a["current"]])
    np.savetxt(
        tmp_path / "a.csv", rows, "%.7g", ",", header=f"Time [s],Position [mm],Force [N],{name} [V]", comments=""
    )
    fric.ingest(tmp_path / "a.csv", output=tmp_path / "log.h5")
    (log,) = read_logs(tmp_path / "log.h5")
    assert log.input is not None


def test_a_line_of_the_preamble_names_the_axis(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    rows = "\n".join(f"{t:g};{x:.5f};{i:.4f}" for t, x, i in zip(a["t"], a["position"], a["current"], strict=True))
    (tmp_path / "a.txt").write_text(f"Scope 5.2\nAxis: Y\nt [s];s actual [mm];I nominal [A]\n{rows}\n")
    with ExitStack() as files:
        (found,) = guessed([tmp_path / "a.txt"], files).found
    assert found.axis.name == "y"


def test_matrices_of_a_group_have_its_time_and_the_unit_that_is_their_attribute(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their units were part of the names, both runs had the time of one, and each number was read by itself."""
    with h5py.File(tmp_path / "arm.h5", "w") as file:
        for k, name in enumerate(("run_1", "run_2")):
            group = file.create_group(name)
            group["time"] = np.arange(500) * 1e-3 + k
            for of, unit in (("q", "rad"), ("tau", "N.m")):
                group.create_dataset(of, data=np.full((500, 3), float(k))).attrs["unit"] = unit
    reads, get = [], h5py.Dataset.__getitem__
    monkeypatch.setattr(h5py.Dataset, "__getitem__", lambda *given: reads.append(1) or get(*given))
    for table, began in zip(tables(tmp_path / "arm.h5"), (0.0, 1.0), strict=True):
        named = [tuple(column) for column in table.columns]
        assert named[1:] == [(f"{of}(:,{n})", unit) for of, unit in (("q", "rad"), ("tau", "N.m")) for n in (1, 2, 3)]
        assert named[0] == ("time", None)
        assert table.data[0][:2][0] == began
    assert len(reads) < 50


def zipped(path: Path, name: str, text: bytes) -> Path:
    with ZipFile(path, "w", ZIP_DEFLATED) as archive:
        archive.writestr("dataset/README.txt", "measured in 2021")
        archive.writestr(name, text)
    return path


def test_logs_in_a_zip_are_those_of_a_folder(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    log = write(tmp_path / "log.csv", "time [s];position [rad];torque [N*m]", a["t"], a["position"], a["current"])
    folder = tmp_path / "logs"
    folder.mkdir()
    zipped(folder / "set.zip", "dataset/../../run.csv", log.read_bytes())  # whose name does not lead out of its folder
    found = find_sources([folder], (), tmp_path / "out" / "mappings")
    assert [source.path for source in found.logs] == [tmp_path / "out" / "unpacked" / "set" / "dataset" / "run.csv"]


def test_a_zip_that_unpacks_to_too_much_is_named(tmp_path: Path) -> None:
    zipped(tmp_path / "set.zip", "run.csv", b"0" * (65 << 20))
    found = find_sources([tmp_path], (), tmp_path / "out" / "mappings")
    assert [files for why, files in found.refused.items() if "unpack it beside it" in why] == [[tmp_path / "set.zip"]]
    assert not (tmp_path / "out" / "unpacked").exists()


def test_an_archive_alone_is_named_with_what_to_do(tmp_path: Path) -> None:
    """A folder with a ZIP in it had no log, and nothing said why."""
    (tmp_path / "dataset.zip").write_bytes(b"PK\x05\x06" + bytes(18))
    with pytest.raises(FricError, match=r"dataset\.zip.*unpack it"):
        fric.auto(tmp_path, output=tmp_path.parent / f"{tmp_path.name}-out", assume=True)


@pytest.mark.parametrize(("unit", "known"), [
    ("% rated", "%"), ("% vom Nennmoment", "%"), ("Prozent", "%"), ("pct", "%"), ("0.1 %", "0.1 %"), ("0,1%", "0.1 %"),
    ("‰", "0.1 %"), ("promille of rated", "0.1 %"),
])  # fmt: skip
def test_a_share_of_the_rated_torque_is_no_newton_metre(tmp_path: Path, unit: str, known: str) -> None:
    """`% rated` was N·m by likelihood, and 0.1 % was a per cent."""
    a = axis_of_a_drive()
    path = write(tmp_path / "log.csv", f"Time [s];Speed [rpm];Torque [{unit}]", a["t"], a["velocity"], a["current"])
    (axis,) = told(path)
    force = axis.roles["force"]
    assert (force.unit, force.unit_likelihood) == (known, 1.0)


@pytest.mark.parametrize("name", ["0x6077 Torque actual value", "Torque_6077h", "0x6078:00 current", "present_load"])
def test_objects_of_a_profile_have_its_units(tmp_path: Path, name: str) -> None:
    a = axis_of_a_drive()
    (axis,) = told(write(tmp_path / "log.csv", f"t;speed [rpm];{name}", a["t"], a["velocity"], np.rint(a["current"])))
    assert (axis.roles["force"].unit, axis.roles["force"].unit_likelihood) == ("0.1 %", 1.0)


def test_a_letter_of_an_axis_in_brackets_is_no_unit(tmp_path: Path) -> None:
    """The question was what one X is."""
    a = axis_of_a_drive()
    path = write(tmp_path / "log.csv", "Time [s];POSF(X);TCMD(X) [%]", a["t"], a["position"], a["current"])
    (axis,) = told(path)
    assert channels(axis) == {"time": 0, "position": 1, "force": 2}
    assert "logged in" not in proposal([path])


def test_a_speed_in_reciprocal_seconds_turns(tmp_path: Path) -> None:
    """It was left out."""
    a = axis_of_a_drive()
    names = "Time [s];SPEED_ACT [1/s];ISQ_ACT [A]"
    (axis,) = told(write(tmp_path / "log.csv", names, a["t"], a["velocity"] / (2 * np.pi), a["current"]))
    assert axis.motion.startswith("rotary")
    assert channels(axis) == {"time": 0, "velocity": 1, "force": 2}
    assert axis.roles["velocity"].unit_likelihood < 0.95  # radians or revolutions
    counts = np.rint(a["position"] * 10000 / (2 * np.pi))
    names = "Time [s];S_ACT [Units];SPEED_ACT [1/s];ISQ_ACT [A]"
    (axis,) = told(write(tmp_path / "log.csv", names, a["t"], counts, a["velocity"] / (2 * np.pi), a["current"]))
    assert axis.roles["position"].unit == "0.0001 rev"  # which no count of radians would be


def test_a_word_that_all_names_share_makes_no_command_an_actual_value(tmp_path: Path) -> None:
    """The fb of fbAxis was a feedback, and the commanded position the position."""
    a = axis_of_a_drive()
    heads = ";".join(f"MAIN.fbAxis.{name}" for name in ("SetPos", "ActPos", "ActTorque"))
    lagged = np.interp(a["t"] - 0.004, a["t"], a["position"])
    (axis,) = told(write(tmp_path / "log.csv", f"Time[s];{heads}", a["t"], a["position"], lagged, a["current"]))
    assert channels(axis) == {"time": 0, "reference": 1, "position": 2, "force": 3}


@pytest.mark.parametrize(
    "head", ["time [s],position [mm],force [N]", "time [s],actual position [mm],actual current [A]"]
)
def test_files_named_by_axes_are_of_these(tmp_path: Path, head: str) -> None:
    """Both were one axis x, and its friction between those of two; runs a and b are of one axis."""
    a = axis_of_a_drive()
    logs = tmp_path / "logs"
    logs.mkdir()
    for name, share in (("X_axis", 1.0), ("Y_axis", 2.0)):
        write(logs / f"{name}.csv", head.replace(",", ";"), a["t"], a["position"], share * a["current"])
    found = find_sources([logs], (), tmp_path / "out" / "mappings")
    assert {log.axis: log.path.stem for log in found.logs} == {"x": "X_axis", "y": "Y_axis"}
    for old, new in (("X_axis", "run_a"), ("Y_axis", "run_b")):
        (logs / f"{old}.csv").rename(logs / f"{new}.csv")
    assert {log.axis for log in find_sources([logs], (), tmp_path / "out" / "mappings").logs} == {"x"}


@pytest.mark.parametrize("form", ["header", "none", "lines"])
def test_whole_seconds_and_their_rest_are_a_clock(tmp_path: Path, form: str) -> None:
    """Of ROS 2 the seconds alone were taken, as rounded stamps, with a period 1.3 % off, or the nanoseconds."""
    a = axis_of_a_drive(n=4000)
    stamps = 1_700_000_000_123_456_789 + np.rint(1e9 * a["t"]).astype(np.int64)
    cells = [
        [s // 10**9, s % 10**9, f"{x:.6f}", f"{v:.5f}", f"{f:.4f}"]
        for s, x, v, f in zip(stamps, a["position"], a["velocity"], a["current"], strict=True)
    ]
    if form == "lines":
        path = tmp_path / "log.jsonl"
        of = ('{{"stamp": {{"secs": {}, "nsecs": {}}}, "position": {}, "velocity": {}, "effort": {}}}'.format(*row)
              for row in cells)  # fmt: skip
        path.write_text("\n".join(of) + "\n")
    else:
        path = tmp_path / "log.csv"
        head = "header.stamp.sec,header.stamp.nanosec,position,velocity,effort\n" if form == "header" else ""
        path.write_text(head + "\n".join(",".join(map(str, row)) for row in cells) + "\n")
    fric.ingest(path, output=tmp_path / "log.h5", assume=True)
    (log,) = read_logs(tmp_path / "log.h5")
    assert len(log) == 4000
    np.testing.assert_allclose(np.diff(log.time), 1e-3, atol=1e-6)


def test_rounded_stamps_have_the_period_of_whole_ones(tmp_path: Path) -> None:
    """It was the span from the first stamp to the last: off by what the rounding left out at both ends."""
    a = axis_of_a_drive(n=4000)
    stamps = np.floor(2.0 * a["t"] + 0.99) / 2.0
    path = write(tmp_path / "log.csv", "time [s];position;current", stamps, a["position"], a["current"])
    (axis,) = told(path)
    assert parse(axis.roles["time"].unit, "time") == pytest.approx(1e-3, rel=1e-3)


def test_seconds_beside_a_stamp_of_its_own_stay_as_they_are(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t_sec,t_usec,x\n" + "".join(f"{n * 0.01:.2f},{n * 10_000},{n}\n" for n in range(50)))
    (block,) = next(tables(path)).read([0, 1])
    np.testing.assert_allclose(block.columns[0], np.arange(50) * 0.01)


@pytest.mark.parametrize("values", [1, 3])
def test_dates_and_times_of_a_day_are_no_words(tmp_path: Path, values: int) -> None:
    """A trend with a label, a date, a time and three values a row had "no rows of numbers"."""
    names = ",".join(f'"Axis.Value{n}"' for n in range(values))
    lines = ['"Trend:","Axis"', f'"Header:","Date","Time",{names}']
    for n in range(300):
        row = ",".join(f"{np.sin(n / 30 + k):.4f}" for k in range(values))
        lines.append(f"11/8/2023,11/8/2023,09:37:{n // 100:02d};{n % 100 * 10:03d},{row}")
    path = tmp_path / "trend.csv"
    path.write_text("\n".join(lines) + "\n")
    table = next(tables(path))
    assert table.columns[2].name == "Time"
    (block,) = table.read([2, 3])
    np.testing.assert_allclose(np.diff(block.columns[0]), 0.01, atol=1e-9)
    assert np.isfinite(block.columns[1]).all()


def test_remarks_between_rows_are_passed_over(tmp_path: Path) -> None:
    """A line ``# stroke 2`` was a row with a bad cell, or with too many of them; places are still those of the file."""
    lines = ["t [s] x [mm]", *(f"{n * 0.01:.2f} {n * 0.1:.3f}" for n in range(100))]
    lines[51:51] = ["# stroke 2, at 5 mm/s of the plan", ""]
    lines[80] = "0.77 ?"
    path = tmp_path / "log.txt"
    path.write_text("\n".join(lines) + "\n")
    table = next(tables(path))
    (block,) = table.read([0, 1])
    assert len(block.columns[0]) == 100
    (bad,) = np.flatnonzero(np.isnan(block.columns[1]))
    assert table.place(int(bad)).endswith("line 81")
    assert table.text(int(bad), 1) == "?"


def test_a_damaged_log_is_left_out_with_its_reason_beside_good_ones(tmp_path: Path) -> None:
    """Its error ended the whole folder."""
    a = axis_of_a_drive(n=2000)
    write(tmp_path / "good.csv", "t;position;velocity;current", a["t"], a["position"], a["velocity"], a["current"])
    rows = [f"{t:.4f},{x:.6f},{v:.5f},{f:.4f}" for t, x, v, f in zip(
        a["t"], a["position"], a["velocity"], a["current"], strict=True
    )]  # fmt: skip
    (tmp_path / "bad.csv").write_text("\n".join(["a,b,c,d", *rows, "1,2,3,4,5", ""]))
    found = find_sources([tmp_path], proposals=tmp_path / "out", assume=True)
    assert [log.path.name for log in found.logs] == ["good.csv"]
    assert [why for why, files in found.refused.items() if "bad.csv" in files[0].name] == [
        "has more cells than the 4 of the header"
    ]


def test_a_letter_that_falls_is_no_time_and_a_torque_that_never_changes_no_force(tmp_path: Path) -> None:
    """Of ``time, p, v, t, t_ff`` the torque t was a time, and the feedforward, which is 0, the force."""
    a = axis_of_a_drive(n=2000)
    path, still = tmp_path / "log.csv", 0.0 * a["t"]
    write(path, "time;t_ff;p;v;t", a["t"], still, a["position"], a["velocity"], a["current"])
    (axis,) = told(path)
    assert channels(axis) == {"time": 0, "position": 2, "velocity": 3, "force": 4}
    write(path, "time;torque;p;v", a["t"], still, a["position"], a["velocity"])
    assert "force" not in proposal([path]).partition("# force")[0].partition("columns:")[2]


def test_joints_that_rest_are_no_axes(tmp_path: Path) -> None:
    """The noise of their velocities made an axis of each, with three questions more."""
    a, noise = axis_of_a_drive(n=3000), np.random.default_rng(4).standard_normal((6, 3000))
    positions = 0.3 + 1e-5 * noise[0], a["position"], 1.0 + 1e-5 * noise[1]
    speeds, forces = (5e-4 * noise[2], a["velocity"], 5e-4 * noise[3]), (0.1 * noise[4], a["current"], 0.1 * noise[5])
    head = ";".join(["time", *(f"{name}[{k}]" for name in ("q", "dq", "tau") for k in range(3))])
    (axis,) = told(write(tmp_path / "log.csv", head, 1e3 * a["t"], *positions, *speeds, *forces))
    assert channels(axis) == {"time": 0, "position": 2, "velocity": 5, "force": 8}


def test_a_large_current_in_whole_numbers_may_be_in_counts() -> None:
    """The current of a gimbal's motor, in steps of 3 A / 16384, was in mA without a question."""
    unit, sure, others = usual_units("force", spoken(Column("given_current")), "rotary", np.array([-3000.0, 1450.0]))
    assert (unit, sure < SURE, others[0]) == ("mA", True, "count")
    assert usual_units("force", spoken(Column("current")), "rotary", np.array([-3000.25, 1450.5]))[1] > SURE


@pytest.mark.parametrize("name", ["Normalkraft", "normal force", "Reibwert", "COF", "Normal Load"])
def test_what_presses_on_a_tribometer_is_no_force_of_its_axis(name: str) -> None:
    assert spoken(Column(name)).quantity == "other"


def test_lines_of_json_are_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They were parsed each of a dozen times that a log is looked at."""
    from fric.io.readers import structured

    path, parsed = tmp_path / "log.jsonl", []
    path.write_text("".join(f'{{"t": {n}, "x": {n * n}}}\n' for n in range(50)))
    columns = structured._columns
    monkeypatch.setattr(structured, "_columns", lambda value, depth=0: parsed.append(depth) or columns(value, depth))
    for _ in range(3):
        next(tables(path))
    assert parsed.count(0) == 1
    path.write_text("".join(f'{{"t": {n}, "x": {n * n}}}\n' for n in range(60)))
    (block,) = next(tables(path)).read([0])
    assert len(block.columns[0]) == 60


@pytest.mark.parametrize("delimiter", [",", "\t", ";"])
@pytest.mark.parametrize(("end", "rows"), [("0.0299,1.1", 30), ("0.0299,1.1,2.5,3.5", 31), ("0.0299,1.1\n", None)])
def test_a_line_that_ends_where_the_log_stopped_is_left_out(
    tmp_path: Path, delimiter: str, end: str, rows: int | None
) -> None:
    """`auto` could use no log whose last line was cut: "the cell is empty". A short line with an end is no cut."""
    lines = [
        "time [s],position [mm],velocity [mm/s],force [N]",
        *(f"{0.001 * n:.4f},{0.1 * n:.3f},100.0,5.0" for n in range(30)),
    ]
    path = tmp_path / "a.csv"
    path.write_text("\n".join([*lines, end]).replace(",", delimiter))
    if rows is None:
        with pytest.raises(FricError, match="the cell is empty"):
            fric.ingest(path, output=tmp_path / "a.h5")
        return
    result = fric.ingest(path, output=tmp_path / "a.h5")
    (log,) = read_logs(tmp_path / "a.h5")
    assert len(log) == rows
    assert [notice.code for notice in result.warnings if notice.code == "line-cut"] == ["line-cut"] * (rows == 30)


@pytest.mark.parametrize("end", ["End of record   30 samples   max 0.345\n", "Rows: 30", "done\n", "0.03 3.0 x\n"])
def test_a_line_of_words_behind_the_samples_is_none(tmp_path: Path, end: str) -> None:
    """Where it had numbers, too, "no log here can be used: has more cells than the 4 of the header"."""
    rows = [f"{0.001 * n:.4f}  {0.1 * n:.3f}  100.0  5.0" for n in range(30)]
    path = tmp_path / "a.txt"
    path.write_text("\n".join(["time pos speed current", "[s] [mm] [mm/s] [A]", *rows, end]))
    blocks = list(next(tables(path)).read(range(4)))
    assert sum(len(block.columns[0]) for block in blocks) == 30 + (end[0] == "0")  # a sample that is bad is one


def test_why_a_log_with_a_bad_cell_is_left_out_names_its_line_and_the_remedy(tmp_path: Path) -> None:
    """`auto` said "the cell is empty", and to name columns in a mapping."""
    rows = [f"{0.001 * n:.3f},{0.1 * n:.3f},{5.0 if n != 17 else ''}" for n in range(30)]
    (tmp_path / "a.csv").write_text("\n".join(["time [s],position [mm],force [N]", *rows, ""]))
    (why,) = find_sources([tmp_path]).refused
    assert "line 19" in why
    assert "`assume=True`" in why
    assert find_sources([tmp_path], assume=True).logs


@pytest.mark.parametrize(("mark", "header"), [
    (".", "Time;Position;Speed;Current"), (",", "Zeit;Position;Drehzahl;Strom"),
    (".", "Time;Position [mm];Speed / 1/min;Current (A)"),
])  # fmt: skip
def test_units_in_cells_are_those_of_columns(tmp_path: Path, mark: str, header: str) -> None:
    a = axis_of_a_drive(n=1500)
    rows = [f"{1e3 * t:.1f} ms;{x:.4f} mm;{v:.3f} 1/min;{i:.4f} A".replace(".", mark)
            for t, x, v, i in zip(a["t"], a["position"], a["velocity"], a["current"], strict=True)]  # fmt: skip
    path = tmp_path / "trend.csv"
    path.write_text("\n".join([header, *rows]) + "\n")
    (table,) = tables(path)
    assert [column.unit for column in table.columns][1:] == ["mm", "1/min", "A"]
    (block,) = table.read([0, 1, 3])
    seconds = block.columns[0] * parse(f"1 {table.columns[0].unit or 's'}", "time")
    for found, wanted in zip((seconds, *block.columns[1:]), (a["t"], a["position"], a["current"]), strict=True):
        assert found == pytest.approx(wanted, abs=6e-5)
    rows[700] = rows[700].replace(" mm", " um")  # a cell in another unit is no number of its column
    path.write_text("\n".join([header, *rows]) + "\n")
    (block,) = next(tables(path)).read([1])
    assert np.flatnonzero(np.isnan(block.columns[0])).tolist() == [700]


@pytest.mark.parametrize(("header", "name", "unit"), [
    ("Weg / mm", "Weg", "mm"), ("Geschwindigkeit / mm/s", "Geschwindigkeit", "mm/s"), ("n in 1/min", "n", "1/min"),
    ("Drehzahl U/min", "Drehzahl", "U/min"), ("Current {A}", "Current", "A"), ("Current <A>", "Current", "A"),
    ("Torque (N-m)", "Torque", "N-m"), ("master / slave", "master / slave", None), ("plug in", "plug in", None),
    ("x/y", "x/y", None), ("POSF(X)", "POSF(X)", None), ("X_ist/mm", "X_ist", "mm"), ("U_st/mV", "U_st", "mV"),
    ("F_mot/N", "F_mot", "N"), ("t/us", "t", "us"), ("arm/A", "arm/A", None),
])  # fmt: skip
def test_units_behind_a_slash_and_in_other_brackets(header: str, name: str, unit: str | None) -> None:
    assert named(header) == Column(name, unit)
    if unit == "N-m":
        assert parse(f"2 {unit}", "force", "rotary") == 2.0


def test_a_unit_in_the_next_cell_is_that_of_the_sampling_cycle(tmp_path: Path) -> None:
    """A cycle of 1 ms was one of 1 s, since the word before it is also one of rates."""
    a = axis_of_a_drive(n=1500)
    head = "Servo Guide\nSampling Cycle,1,msec\nNo.,CH1,CH2\nUnit,rad,A"
    rows = [f"{n},{x:.4f},{i:.4f}" for n, (x, i) in enumerate(zip(a["position"], a["current"], strict=True))]
    (tmp_path / "log.csv").write_text("\n".join([head, *rows]) + "\n")
    (axis,) = told(tmp_path / "log.csv")
    assert (axis.roles["time"].column, axis.roles["time"].unit) == (None, "0.001 s")


def test_lines_with_numbers_above_stamped_rows_are_no_samples(tmp_path: Path) -> None:
    """A waveform's start and step, a cell a channel, were the header, and one was a sample."""
    a = axis_of_a_drive(n=1500)
    begun = "2024-03-01 10:00:00.000"
    head = f"waveform,[0],[1]\nt0,{begun},{begun}\ndelta t,0.001,0.001\n\ntime,Enc (rad),I (A)"
    stamps = np.datetime64("2024-03-01T10:00:00.000") + np.arange(1500) * np.timedelta64(1, "ms")
    rows = [f"{str(t).replace('T', ' ')},{x:.4f},{i:.4f}"
            for t, x, i in zip(stamps, a["position"], a["current"], strict=True)]  # fmt: skip
    (tmp_path / "log.csv").write_text("\n".join([head, *rows]) + "\n")
    (table,) = tables(tmp_path / "log.csv")
    assert table.columns[1:] == (Column("Enc", "rad"), Column("I", "A"))
    (block,) = table.read([0, 1])
    assert block.columns[1] == pytest.approx(a["position"], abs=1e-4)
    assert np.diff(block.columns[0]) == pytest.approx(1e-3, abs=1e-6)


def test_columns_of_one_motor_are_of_no_several_axes(tmp_path: Path) -> None:
    """VL.FB, IL.FB and VL.CMD, IL.CMD were those of two axes, and the current was left out."""
    a = axis_of_a_drive()
    head = "Time (ms);PL.FB (Counts16Bit);VL.FB (rpm);IL.FB (Arms);VL.CMD (rpm);IL.CMD (Arms)"
    path = write(tmp_path / "log.csv", head,
                 1e3 * a["t"], np.round(a["position"] * 65536 / (2 * np.pi)), a["velocity"] * 9.5493, a["current"],
                 a["speed"] * 9.5493, a["current"] + 0.01)  # fmt: skip
    (axis,) = told(path)
    assert channels(axis) == {"time": 0, "position": 1, "velocity": 2, "force": 3}


def test_the_voltage_of_a_tachometer_is_no_input(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    path = write(tmp_path / "log.csv", "t;Encoder (rad);Torque (Nm);Tacho (V)", a["t"], a["position"], a["current"],
                 a["velocity"])  # fmt: skip
    (axis,) = told(path)
    assert "input" not in axis.roles


def test_a_bad_cell_is_mended_by_one_sentence(tmp_path: Path) -> None:
    """A mapping was asked for as well, which opens nothing."""
    a = axis_of_a_drive()
    path = write(tmp_path / "log.csv", "time [s];position [rad];torque [N*m]", a["t"], a["position"], a["current"])
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:800], "0.799;1.0;#DIV/0!", *lines[801:]]) + "\n")
    with pytest.raises(FricError, match=r"line 801.*assume") as error:
        fric.auto(path, output=tmp_path / "out")
    assert "mapping" not in str(error.value)


def test_registers_of_a_servo_are_counts_and_not_assumed(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    path = write(tmp_path / "log.csv", "timestamp;id;goal_position;present_position;present_velocity;present_current",
                 a["t"], np.full(len(a["t"]), 7), np.round(a["asked"] * 652), np.round(a["position"] * 652),
                 np.round(a["velocity"] * 41.7), np.round(a["current"] * 100))  # fmt: skip
    found = find_sources([path], proposals=tmp_path / "maps", assume=True)
    assert not found.logs
    assert any("is in counts" in why for why in found.refused)


def test_the_unit_of_a_clock_is_open_once_for_all_axes_of_a_file(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    path = write(tmp_path / "log.csv", "tick;X pos;X torque;C angle;C torque", 20 * np.arange(4000), 50 * a["position"],
                 a["current"], np.cumsum(np.roll(a["velocity"], 500)) * 0.02, np.roll(a["current"], 500))  # fmt: skip
    with ExitStack() as files:
        guess = guessed([path], files, assume=True)
        clocks = {settled for part in guess.found for what, settled in part.open.items() if "(time)" in what}
    assert len(guess.found) == 2
    assert len(clocks) == 1


def test_a_reference_along_a_line_is_not_that_of_a_motor_that_turns(tmp_path: Path) -> None:
    """A motor's angle, a slide's reference and scale in mm: the log could be neither used nor asked about."""
    a = axis_of_a_drive()
    head = "t_ms;x_soll_mm;phi_mot_deg;x_scale_mm;n_mot_rpm;i_q_A"
    path = write(tmp_path / "log.csv", head, 1e3 * a["t"], 2 * a["asked"], 57.2958 * a["position"], 2 * a["position"],
                 9.5493 * a["velocity"], a["current"])  # fmt: skip
    (source,) = find_sources([path], proposals=tmp_path / "maps").logs
    assert source.motion == "rotary/A"


def test_the_unit_of_a_clock_is_asked_once_for_all_axes_of_a_file(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    path = write(tmp_path / "log.csv", "tick;X pos;X torque;C angle;C torque", 20 * np.arange(4000), 50 * a["position"],
                 a["current"], np.cumsum(np.roll(a["velocity"], 500)) * 0.02, np.roll(a["current"], 500))  # fmt: skip
    clocks = list[set[str]]()

    def ask(question: Question) -> None:
        if "units" in question.text:
            clocks.append({reading.time for _, reading in question.choices})
        question.take("")

    with ExitStack() as files:
        guess = guessed([path], files, assume=True)
        assert len(guess.found) == 2
        answered(guess, ask, tmp_path)
    assert len(clocks) == 2
    assert len(clocks[0]) > len(clocks[1]) == 1


def test_a_labelled_line_of_units_is_no_line_of_names(tmp_path: Path) -> None:
    """As a servo's trace is: 'pulse' was the name of the position, and its unit was guessed."""
    a = axis_of_a_drive(n=1500)
    head = ("Trace\nSampling Time,500,us\nData Name,Feedback Speed,Torque Reference,Pulse Counter (Low)\n"
            "Unit,min-1,%,pulse")  # fmt: skip
    rows = [f"{n},{9.5493 * v:.3f},{20 * i:.3f},{np.rint(x * 65536):.0f}"
            for n, (v, i, x) in enumerate(zip(a["velocity"], a["current"], a["position"], strict=True), 1)]  # fmt: skip
    (tmp_path / "log.csv").write_text("\n".join([head, *rows]) + "\n")
    (table,) = tables(tmp_path / "log.csv")
    assert [column.unit for column in table.columns] == [None, "min-1", "%", "pulse"]
    assert table.columns[2].name == "Torque Reference"
    (axis,) = told(tmp_path / "log.csv")
    assert channels(axis) == {"velocity": 1, "force": 2, "position": 3, "time": None}
    assert axis.roles["time"].unit == "0.0005 s"


def test_a_first_column_without_a_name_above_labelled_units_may_be_the_time(tmp_path: Path) -> None:
    a = axis_of_a_drive(n=1500)
    rows = [f"{t:.4f},{x:.4f},{i:.3f}" for t, x, i in zip(a["t"], a["position"], a["current"], strict=True)]
    for first in ("Name", "Time"):
        (tmp_path / "log.csv").write_text("\n".join([f"{first},Angle,Current", "Unit,rad,A", *rows]) + "\n")
        (axis,) = told(tmp_path / "log.csv")
        assert axis.roles["time"].column == 0
        assert next(tables(tmp_path / "log.csv")).columns[0].name == ("Time" if first == "Time" else "column 0")


def test_a_torque_within_a_status_of_a_drive_is_the_force(tmp_path: Path) -> None:
    """As a technology object of a controller names it; its name was taken for a state."""
    assert spoken(Column("PosAxis_2.StatusDrive.ActualTorque")).quantity == "force"
    assert spoken(Column("StatusWord")).quantity == "other"


def test_a_name_of_a_measured_position_tells_it_from_another(tmp_path: Path) -> None:
    """The only actual one beside another was 90 % the position, with nothing to choose: a question without answers."""
    a = axis_of_a_drive()
    for k, (measured, other) in enumerate([("A.ActualPosition", "A.Position"), ("pos_estimate", "input_pos")]):
        path = write(tmp_path / f"{k}.csv", f"time [s];{measured} [rad];{other} [rad];torque [N*m]", a["t"],
                     a["position"], a["asked"], a["current"])  # fmt: skip
        (axis,) = told(path)
        assert axis.roles["position"].column == 1
        assert axis.roles["position"].likelihood > SURE


def test_currents_of_one_name_are_in_one_unit_and_forces_are_not(tmp_path: Path) -> None:
    """A robot's small currents were A, and the large ones of its next joint a question."""
    a, turned = axis_of_a_drive(), np.roll(axis_of_a_drive()["position"], 900)
    for name, sure in (("current", True), ("torque", False)):
        head = f"time;q_0;q_1;{name}_0;{name}_1"
        values = a["t"], a["position"], turned, 0.4 * a["current"], 4.0 * np.roll(a["current"], 900)
        path = write(tmp_path / f"{name}.csv", head, *values)
        with ExitStack() as files:
            found = guessed([path], files, assume=True).found
            assert len(found) == 2
            assert [guess.axis.roles["force"].unit_likelihood > SURE for guess in found] == [sure, sure]
            assert not sure or {guess.axis.motion for guess in found} == {"rotary/A"}


def test_the_command_of_a_proposal_quotes_names_with_spaces(tmp_path: Path) -> None:
    a = axis_of_a_drive(n=1500)
    path = write(tmp_path / "Friction X.csv", "time;pos;torque", a["t"], a["position"], a["current"])
    text = proposal([path])
    assert "fric ingest 'Friction X.csv'" in text
    assert "Guessed from Friction X.csv." in text


@pytest.mark.parametrize(("unit", "steps"), [("0.01 A", 100), ("0.1 A", 10), ("0.001 Nm", 1000), ("10 mA", 100)])
def test_steps_of_a_unit_are_the_unit_of_a_force(tmp_path: Path, unit: str, steps: int) -> None:
    """As a servo drive's scope names them; mA, A or % were offered, and none of these was right."""
    a = axis_of_a_drive()
    path = write(tmp_path / "log.csv", f"time [s];position [rad];Actual Torque ({unit})", a["t"], a["position"],
                 np.rint(steps * a["current"]))  # fmt: skip
    found = find_sources([path], proposals=tmp_path / "maps")
    (log,) = found.logs
    fric.ingest(path, output=tmp_path / "log.h5", mapping=log.mapping)
    (record,) = read_logs(tmp_path / "log.h5")
    assert np.abs(record.force).max() == pytest.approx(np.abs(a["current"]).max(), rel=0.02)


def test_what_is_in_brackets_behind_an_axis_is_no_unit(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    head = "Time (ms);X[Position Feedback] (rad);X[Current Feedback] (A);X[Position Command] (rad)"
    path = write(tmp_path / "log.csv", head, 1e3 * a["t"], a["position"], a["current"], a["asked"])
    (axis,) = told(path)
    assert channels(axis) == {"time": 0, "position": 1, "force": 2, "reference": 3}
    assert axis.roles["position"].likelihood > SURE
    assert named("X[Torque Command]") == Column("X[Torque Command]", None)


def test_what_a_count_is_is_asked_for_and_nothing_else(tmp_path: Path) -> None:
    """A motion and a force are there: that they be logged is no remedy."""
    a = axis_of_a_drive()
    path = write(tmp_path / "log.csv", "time [s];Position [cnt];Current [A]", a["t"], np.rint(652 * a["position"]),
                 a["current"])  # fmt: skip
    with pytest.raises(FricError, match="in counts") as error:
        fric.auto(path, output=tmp_path / "out")
    assert "Log time" not in error.value.hint
    assert "--propose" in error.value.hint


@pytest.mark.parametrize(("delimiter", "head"), [(",", "Time [s],Position [mm],Current [A]"), (" ", "t z current")])
def test_a_semicolon_at_the_end_of_lines_is_no_part_of_the_last_cell(tmp_path: Path, delimiter: str, head: str) -> None:
    """The last column, the current, was `Current [A];` and held no number."""
    rows = [delimiter.join((f"{0.1 * k:.1f}", f"{k}", f"{0.5 * k:.1f};")) for k in range(40)]
    (tmp_path / "log.csv").write_text("\n".join([f"{head};", *rows]) + "\n")
    table = next(tables(tmp_path / "log.csv"))
    (block,) = table.read([0, 1, 2])
    np.testing.assert_allclose(block.columns[2], 0.5 * np.arange(40))
    assert table.columns[2] == Column("Current" if delimiter == "," else "current", "A" if delimiter == "," else None)


@pytest.mark.parametrize("said", ["units: Radians, Amps", "# Units = Radians; Amps", "# units: Amps Radians"])
def test_units_above_the_header_are_those_of_the_columns_that_may_have_them(tmp_path: Path, said: str) -> None:
    """The second was taken for the unit of the second column: a position in amperes, and no log."""
    rows = [f"{0.1 * k:.1f},{k},{0.5 * k:.1f}" for k in range(40)]
    (tmp_path / "log.csv").write_text("\n".join([said, "Time,Position,Current", *rows]) + "\n")
    time, position, current = next(tables(tmp_path / "log.csv")).columns
    assert parse(f"1 {position.unit}", "position", "rotary") == parse(f"1 {current.unit}", "force", "rotary/A") == 1.0
    assert time.unit is None


def test_a_unit_with_its_number_is_one() -> None:
    for unit, size in {"100ns": 1e-7, "0.1us": 1e-7, "10ms": 1e-2}.items():
        assert factor(unit, "time") == pytest.approx(size, rel=1e-12)
    assert not converts("1e-7 s", "time")


def two_axes(stamps: np.ndarray) -> tuple[str, list[np.ndarray]]:
    """The columns of a trace whose names have the axis between other words, with both encoders and velocities."""
    head, columns = ["Ticks [100ns]"], [stamps]
    for k, letter in enumerate("XY"):
        a = axis_of_a_drive(n=len(stamps), seed=k)
        head += [f"Axes.{letter}.Plc.ActPos [mm]", f"Axes.{letter}.Plc.ActVelo [mm/min]", f"Axes.{letter}.Drive.I [A]"]
        columns += [a["position"] * (k + 1.0), a["velocity"] * 60.0 * (k + 1.0), a["current"]]
    return ";".join(head), columns


@pytest.mark.parametrize("since", [638412345670000000, 133500000000000000, 0])
def test_ticks_of_18_digits_are_even_and_an_axis_stands_within_names(tmp_path: Path, since: int) -> None:
    """A number holds 16 digits: the stamps jittered by 1 %, and of .NET they had no unit."""
    n = 3000
    head, columns = two_axes(np.zeros(n))
    rows = np.column_stack(columns[1:])
    lines = [f"{since + 10000 * k};" + ";".join(f"{value:.6f}" for value in row) for k, row in enumerate(rows)]
    path = tmp_path / "trace.csv"
    path.write_text("\n".join([head, *lines]) + "\n")
    with ExitStack() as opened:
        found = guessed([path], opened)
        assert [guess.axis.name for guess in found.found] == ["x", "y"]
        assert found.sure, [guess.open for guess in found.found]
        text = found.text()
    (tmp_path / "map.yaml").write_text(text)
    fric.ingest(path, output=tmp_path / "log.h5", mapping=tmp_path / "map.yaml", axis="x")
    (log,) = read_logs(tmp_path / "log.h5")
    np.testing.assert_allclose(np.diff(log.time), 1e-3, rtol=1e-6)


@pytest.mark.parametrize(
    ("head", "size", "unit"),
    [("position [m]", 1.0, "mm"), ("position [um]", 1.0, "mm"), ("position [mm]", 1e-3, "m")],
)
def test_units_of_position_and_velocity_that_contradict_are_asked(
    tmp_path: Path, head: str, size: float, unit: str
) -> None:
    """A position in mm below ``[m]`` was one in m: its velocity was left out as that of the other side of a gear."""
    a = axis_of_a_drive()
    columns = a["t"], a["position"] * size, a["velocity"], a["current"]
    path = write(tmp_path / "log.csv", f"time [s];{head};velocity [mm/s];current [A]", *columns)
    with ExitStack() as opened:
        found = guessed([path], opened)
        (guess,) = found.found
        assert guess.axis.readings[0].position == unit  # by how usual its travel is
        assert len({*map(str, guess.open.values())}) == 1  # which settles both
        assert not found.sure


def test_a_speed_in_another_unit_of_turns_is_asked_and_that_of_a_gear_is_not(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    for factor_of, asked in ((1.0, True), (30.0 / np.pi * 20.0, False)):  # rad/s below rpm; a gear of 20
        columns = a["t"], np.rad2deg(a["position"]), a["velocity"] * factor_of, a["current"]
        (axis,) = told(write(tmp_path / "log.csv", "time [s];angle [deg];speed [rpm];current [A]", *columns))
        assert (axis.roles.get("velocity") is not None) == asked
        assert (axis.roles["position"].unit_likelihood < SURE) == asked or not asked


def test_a_current_that_no_drive_has_is_asked() -> None:
    column, values = spoken(Column("current", "A")), np.linspace(-2000.0, 2000.0, 500)
    unit, sure, others = usual_units("force", column, "linear", values)
    assert (unit, sure < SURE, others) == ("mA", True, ("A",))
    assert usual_units("force", column, "linear", 0.1 * values)[:2] == ("A", 1.0)


@pytest.mark.parametrize("form", ["struct array", "common time"])
def test_axes_in_structs_have_their_labels_units_and_common_time(tmp_path: Path, form: str) -> None:
    a, b = axis_of_a_drive(seed=1), axis_of_a_drive(seed=2)
    path = tmp_path / "session.mat"
    if form == "struct array":
        axes = np.zeros((2,), dtype=[("label", object), ("encoder", object), ("drive", object)])
        for k, of in enumerate((a, b)):
            at, by = ({name: of[name], "unit": unit} for name, unit in (("position", "mm"), ("current", "A")))
            axes[k] = f"stage {'XY'[k]}", at, by
        savemat(path, {"session": {"info": {"sample_rate": 1000.0}, "axes": axes}})
    else:
        x, y = ({"pos_mm": of["position"], "current_A": of["current"]} for of in (a, b))
        savemat(path, {"log": {"time": a["t"][:, None], "X": x, "Y": y}})
    found = [*tables(path)]
    assert [table.said["axis"] for table in found] == ["x", "y"]
    for table in found:
        (axis,) = axes_of([table])
        assert axis.motion == "linear/A"
        assert axis.roles["position"].unit == "mm"
        assert axis.roles["position"].unit_likelihood >= SURE
        assert axis.roles["time"].unit_likelihood >= SURE


def test_a_period_that_each_file_states_is_taken_from_each(tmp_path: Path) -> None:
    """The period of the first file was that of all: strokes of 80 mm/s had 10."""
    a = axis_of_a_drive(n=4000)
    for name, every in (("slow", 8), ("fast", 2)):
        rows = zip(a["position"][::every], a["current"][::every], strict=True)
        lines = [f"{n},{1e3 * z:.6f},{i:.5g}" for n, (z, i) in enumerate(rows)]
        head = ["SERVO", f"Sampling cycle,{every} msec", "INDEX,POS(mm),TCMD(A)"]
        (tmp_path / f"{name}.csv").write_text("\n".join([*head, *lines]) + "\n")
    assert 'time: {period: "{Sampling cycle}"}' in proposal(sorted(tmp_path.glob("*.csv")))
    fric.ingest(*sorted(tmp_path.glob("*.csv")), output=tmp_path / "log.h5", assume=True)
    assert {log.name: round(float(np.median(np.diff(log.time))), 6) for log in read_logs(tmp_path / "log.h5")} == {
        "fast": 0.002, "slow": 0.008,
    }  # fmt: skip


def test_a_count_of_rows_without_a_header_is_no_time_in_milliseconds(tmp_path: Path) -> None:
    a = axis_of_a_drive(n=3000)
    table = np.column_stack([np.arange(3000), a["position"], a["current"]])
    np.savetxt(tmp_path / "sampler.txt", table, ["%d", "%.6f", "%.5f"])
    assert "? ms" in proposal([tmp_path / "sampler.txt"])


@pytest.mark.parametrize("ids", ["01 02 03", "a b c", "7 3 12"])
@pytest.mark.parametrize("clock", ["restarts", "jumps"])
def test_a_column_of_tests_parts_a_table(tmp_path: Path, ids: str, clock: str) -> None:
    """Tests of other rates in one table, with a clock that goes on, were two rates in one record, and left out."""
    a, lines, begin = axis_of_a_drive(n=3000), ["test;time [s];position [mm];current [A]"], 0.0
    for every, name in zip((1, 3, 4), ids.split(), strict=True):
        t = 1e-3 * np.arange(1000) * every + begin
        rows = zip(t, a["position"][:1000], a["current"][:1000], strict=True)
        lines += [f"{name};{s:.4f};{1e3 * z:.6f};{i:.5g}" for s, z, i in rows]
        begin = t[-1] + 5.0 if clock == "jumps" else 0.0
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    found = list(tables(tmp_path / "log.csv"))
    steps = [float(np.median(np.diff(next(table.read([0])).columns[0]))) for table in found]
    assert [table.said["name"] for table in found] == [
        str(int(name)) if name.isdigit() else name for name in ids.split()
    ]
    np.testing.assert_allclose(steps, [1e-3, 3e-3, 4e-3], rtol=1e-6)


def test_a_state_that_changes_once_parts_no_table(tmp_path: Path) -> None:
    a = axis_of_a_drive(n=3000)
    state, t = np.repeat([0, 1], 1500), 1e-3 * np.arange(3000)
    path = write(
        tmp_path / "log.csv", "enabled;time [s];position [mm];current [A]", state, t, a["position"], a["current"]
    )
    assert len(list(tables(path))) == 1


def test_json_of_pandas_is_a_table_and_lines_that_end_in_cr_alone_are_named(tmp_path: Path) -> None:
    a = axis_of_a_drive(n=500)
    frame = pd.DataFrame({"time [s]": a["t"], "position [rad]": a["position"], "current [A]": a["current"]})
    frame.to_json(tmp_path / "a.json", double_precision=15)
    (table,) = tables(tmp_path / "a.json")
    np.testing.assert_allclose(next(table.read([1])).columns[0], a["position"])
    (tmp_path / "cr.csv").write_bytes(frame.to_csv(index=False).replace("\n", "\r").encode())
    with pytest.raises(FricError, match="end in CR alone"):
        list(tables(tmp_path / "cr.csv"))


def test_the_size_of_a_count_is_said_beside_the_columns_of_json(tmp_path: Path) -> None:
    """`counts_per_mm` was not read: "in counts: say what one is"."""
    a = axis_of_a_drive(n=500)
    content = {"counts_per_mm": 10000, "time [s]": a["t"].tolist(), "current [A]": a["current"].tolist(),
               "position_counts": np.rint(1e5 * a["position"]).tolist()}  # fmt: skip
    (tmp_path / "a.json").write_text(json.dumps(content), encoding="utf-8")
    (table,) = tables(tmp_path / "a.json")
    assert {column.name: column.unit for column in table.columns}["position_counts"] == "0.0001 mm"


def test_units_of_a_scope_may_be_in_brackets(tmp_path: Path) -> None:
    cells = {"Name": ("X.SetPos", "X.ActPos", "X.Command"), "SymbolComment": ("", "", ""),
             "Data-Type": ("REAL64",) * 3, "SampleTime[ms]": ("0.5",) * 3, "VariableSize": ("8",) * 3,
             "Unit": ("(mm)", "mm (Length)", "(V)"), "ScaleFactor": ("1",) * 3, "Offset": ("0",) * 3}  # fmt: skip
    head = ["Name\tScope Project", "File\tx.svdx", "Starttime of export\t134123456780000000", ""]
    head += ["\t".join(f"{key}\t{cell}" for cell in row) for key, row in cells.items()]
    rows = ["\t".join(f"{0.5 * n}\t{value}" for value in (n, 0.5 * n, n % 7)) for n in range(200)]
    head += ["", ""]
    (tmp_path / "a.csv").write_text("\n".join([*head, *rows]), encoding="utf-8")
    (table,) = tables(tmp_path / "a.csv")
    assert [c.unit for c in table.columns if c.unit not in {"ms", "s"}] == ["mm", "mm", "V"]


def test_comments_give_units_to_columns_by_their_names(tmp_path: Path) -> None:
    a = axis_of_a_drive(n=1500)
    rows = zip(1000 * np.arange(1500), np.rint(a["position"] / 1e-4), a["current"], strict=True)
    head = ["# tick enc_cnt load", "# 1 count = 0.1 um, load: N, tick: us", "# no: unit here, m: s"]
    (tmp_path / "a.dat").write_text("\n".join([*head, *(f"{t} {z:.0f} {f:.4f}" for t, z, f in rows)]) + "\n")
    (table,) = tables(tmp_path / "a.dat")
    assert [tuple(column) for column in table.columns] == [("tick", "us"), ("enc_cnt", "0.1 um"), ("load", "N")]
    fric.ingest(tmp_path / "a.dat", output=tmp_path / "log.h5", assume=True)
    (log,) = read_logs(tmp_path / "log.h5")
    assert log.position is not None
    np.testing.assert_allclose(log.position, np.rint(a["position"] / 1e-4) * 1e-7, atol=1e-15)


def test_periods_that_differ_and_no_field_can_name_are_asked(tmp_path: Path) -> None:
    a = axis_of_a_drive(n=4000)
    for name, every in (("slow", 8), ("fast", 2)):
        rows = zip(a["position"][::every], a["current"][::every], strict=True)
        head = ["SERVO", f"Sampling cycle {{x}},{every} msec", "INDEX,POS(mm),TCMD(A)"]
        (tmp_path / f"{name}.csv").write_text("\n".join([*head, *(f"0,{z:.6f},{i:.5g}" for z, i in rows)]) + "\n")
    assert 'time: {period: "? ms"}' in proposal(sorted(tmp_path.glob("*.csv")))


def test_a_single_letter_is_a_unit_where_others_of_the_table_end_in_theirs(tmp_path: Path) -> None:
    """Of ``t_s, F_N, x_m, xref_m, u_V`` positions had none; beside other names x_m may be a mean."""
    a = axis_of_a_drive()
    columns = a["t"], 40.0 * a["current"], a["position"], a["position"] + 1e-5, a["current"]
    table = next(tables(write(tmp_path / "a.csv", "t_s;F_N;x_m;xref_m;u_V", *columns)))
    assert [column.unit for column in table.columns] == ["s", "N", "m", "m", "V"]
    other = next(tables(write(tmp_path / "b.csv", "time;force;x_m;xref_m;u", *columns)))
    assert [column.unit for column in other.columns] == [None] * 5


def test_comments_say_what_a_count_and_a_sample_are(tmp_path: Path) -> None:
    """``n`` was taken for milliseconds, without a question, and the step was asked for."""
    a = axis_of_a_drive()
    rows = zip(np.arange(len(a["t"])), np.rint(a["position"] / 5e-7), a["current"], strict=True)
    text = "\n".join(f"{n}\t{count:.0f}\t{current:.4f}" for n, count, current in rows)
    path = tmp_path / "trace.txt"
    path.write_text(f"# drive trace, sample 0.5 ms\n# 1 count = 0.5 um\n# n\tpos_act\ti_q [A]\n{text}\n")
    (axis,) = told(path)
    assert (axis.roles["time"].column, axis.roles["time"].unit) == (None, "0.0005 s")
    assert (axis.roles["position"].column, axis.roles["position"].unit) == (1, "0.5 um")


def test_a_voltage_that_hardly_changes_is_a_drive_s_input_where_the_force_does_neither(tmp_path: Path) -> None:
    """A multisine about a stroke in one direction: its voltage was a supply, and was left out without a word."""
    rng, t = np.random.default_rng(7), np.arange(6000) * 1e-3
    swing = sum(np.sin(2 * np.pi * f * t + f) for f in (3.0, 7.0, 13.0, 29.0))
    speed = 0.03 + 0.002 * swing
    force = 140.0 + 90.0 * np.gradient(speed, t) + rng.normal(0.0, 2.0, len(t))
    position = np.cumsum(speed) * 1e-3
    columns = t * 1e6, position * 1e3, force, force / 0.24
    (axis,) = told(write(tmp_path / "multisine.log", "t/us;s_ist/mm;F_mot/N;U_st/mV", *columns))
    assert [axis.roles[of].column for of in ("position", "force", "input")] == [1, 2, 3]
    supply = 24_000.0 - 0.3 * np.abs(force)  # sags by a share that is far below that of the force
    (axis,) = told(write(tmp_path / "supply.log", "t/us;s_ist/mm;F_mot/N;U_st/mV", *columns[:3], supply))
    assert "input" not in axis.roles


def test_a_circle_among_the_tests_of_a_table_is_a_circle(tmp_path: Path) -> None:
    """It was left out as a response of fewer than two cycles, and a circle was asked for."""
    a, t = axis_of_a_drive(), np.arange(9000) * 5e-4
    angle = 2 * np.pi * t / 1.9
    parts = [
        pd.DataFrame({"test": f"stroke_{n}", "time [s]": a["t"], "x_pos [mm]": 1e3 * a["position"],
                      "x_force [N]": 40 * a["current"], "y_pos [mm]": 1e3 * a["position"] * (1 + n),
                      "y_force [N]": 30 * a["current"]})
        for n in range(2)
    ]  # fmt: skip
    turn = {"x": 30 * np.cos(angle), "y": 30 * np.sin(angle)}
    parts.append(pd.DataFrame({"test": "round", "time [s]": t} | {
        name: values for axis, z in turn.items()
        for name, values in ((f"{axis}_pos [mm]", z), (f"{axis}_force [N]", 20 * np.sign(np.gradient(z))))
    }))  # fmt: skip
    pd.concat(parts).to_csv(path := tmp_path / "session.csv", index=False, float_format="%.6f")
    (circle,) = fric.ingest_circles(path, output=tmp_path / "circle.h5").document["tests"]
    assert circle["radius"] == pytest.approx(0.03, rel=1e-3)
    found = find_sources([path], proposals=tmp_path / "maps")
    assert [*found.traces] == [path]
    assert {(log.axis, *log.kinds) for log in found.logs} == {("x", "constant-velocity"), ("y", "constant-velocity")}


def test_an_axis_stands_in_a_line_below_that_of_the_names(tmp_path: Path) -> None:
    """All columns were named X, and the position was any of them."""
    a = axis_of_a_drive(n=1500)
    head = ("SERVO TRACE\nSampling cycle(us),1000\nChannel,CH1,CH2,CH3,CH4\nKind,POSCMD,POSF,FORCE,FORCE\n"
            "Axis,X,X,X,Y\nUnit,mm,mm,N,N\n")  # fmt: skip
    rows = [f"{n},{1e3 * r:.5f},{1e3 * x:.5f},{i:.3f},{2 * i:.3f}"
            for n, (r, x, i) in enumerate(zip(a["asked"], a["position"], a["current"], strict=True))]  # fmt: skip
    (tmp_path / "log.csv").write_text("\n".join([head, *rows]) + "\n")
    (table,) = tables(tmp_path / "log.csv")
    assert [column.name for column in table.columns[1:]] == ["X POSCMD", "X POSF", "X FORCE", "Y FORCE"]
    assert [column.unit for column in table.columns[1:]] == ["mm", "mm", "N", "N"]


def test_a_scope_s_export_with_names_in_the_header_alone_is_read(tmp_path: Path) -> None:
    """It has no lines about each channel, and was refused: "names no channels"."""
    a = axis_of_a_drive(n=1500)
    head = ["Name;A1.ActPos;;A1.Force", "File;Scope Project", "Starttime of export;133000000000000000", "",
            "Time (ms);A1.ActPos [mm];Time (ms);A1.Force [N]"]  # fmt: skip
    rows = [f"{1e3 * t:.3f};{1e3 * x:.5f};{1e3 * t:.3f};{40 * i:.3f}".replace(".", ",")
            for t, x, i in zip(a["t"], a["position"], a["current"], strict=True)]  # fmt: skip
    (tmp_path / "log.csv").write_text("\n".join([*head, *rows]) + "\n")
    (axis,) = told(tmp_path / "log.csv")
    assert [axis.roles[of].unit for of in ("time", "position", "force")] == ["ms", "mm", "N"]


def test_an_axis_without_a_name_beside_a_circle_of_slides_is_a_slide(tmp_path: Path) -> None:
    """It was guessed to turn, so that the X of the circle, which moves along a line, became x2."""
    a, t = axis_of_a_drive(), np.arange(9000) * 5e-4
    write(tmp_path / "strokes.csv", "time [s];pos;effort", a["t"], a["position"], a["current"])
    angle = 2 * np.pi * t / 1.9
    turn = [0.03 * np.cos(angle), -np.sign(np.sin(angle)), 0.03 * np.sin(angle), np.sign(np.cos(angle))]
    write(tmp_path / "circle.csv", "time [s];x.actual;x.voltage;y.actual;y.voltage", t, *turn)
    with ExitStack() as files:
        found = guesses([tmp_path / "strokes.csv", tmp_path / "circle.csv"], files)
    assert [(guess.axis.name, guess.axis.motion) for guess in found] == [*[("x", "linear")] * 2, ("y", "linear")]


def test_stamps_with_a_date_are_the_time_of_files_of_several_rates(tmp_path: Path) -> None:
    """By the steps of all files together none was even: "the sampling period (time) is not in the file"."""
    for name, rate in (("response", 4), ("stroke", 1)):
        a = axis_of_a_drive(n=1500, dt=1e-3 / rate)
        stamps = pd.Timestamp("2024-05-02 10:11:12") + pd.to_timedelta(a["t"], unit="s")
        columns = [stamps.strftime("%d/%m/%Y %H:%M:%S.%f"), 1e3 * a["position"], 40 * a["current"]]
        frame = pd.DataFrame(dict(zip(["Date et heure", "Mesure (mm)", "Effort (N)"], columns, strict=True)))
        frame.to_csv(tmp_path / f"{name}.csv", sep=";", index=False)
    with ExitStack() as files:
        (guess,) = guesses([tmp_path / "response.csv", tmp_path / "stroke.csv"], files)
    assert guess.axis.roles["time"].column == 0
    assert guess.axis.roles["time"].unit == "s"


def test_an_attribute_names_the_columns_of_a_matrix(tmp_path: Path) -> None:
    """Positions were asked for among numbered columns, and the rate beside the names was not seen."""
    a = axis_of_a_drive(n=1500)
    with h5py.File(path := tmp_path / "run.h5", "w") as file:
        data = file.create_dataset("data", data=np.column_stack([1e3 * a["position"], 40 * a["current"]]))
        data.attrs["columns"] = ["x_act_mm", "x_F_N"]
        data.attrs["sample_rate_hz"] = 1000.0
    (axis,) = told(path)
    assert [axis.roles[of].unit for of in ("time", "position", "force")] == ["0.001 s", "mm", "N"]


def workbook(path: Path, sheets: Mapping[str, Mapping[str, Any]]) -> Path:
    with pd.ExcelWriter(path) as book:
        for sheet, columns in sheets.items():
            rounded = pd.DataFrame({name: np.round(values, 5) for name, values in columns.items()})
            rounded.to_excel(book, sheet_name=sheet, index=False)
    return path


def test_a_circle_in_a_sheet_among_the_tests_is_a_circle(tmp_path: Path) -> None:
    """It was a record of an axis x and of one y, whose plant was that of x: 120 kg were said of 80 kg."""
    a, t = axis_of_a_drive(), np.arange(9000) * 5e-4
    angle = 2 * np.pi * t / 1.9
    stroke = {"Temps [s]": a["t"], "Consigne [mm]": 1e3 * a["asked"], "Position [mm]": 1e3 * a["position"],
              "Force [N]": 40 * a["current"]}  # fmt: skip
    turn = {f"{name} {axis} [{unit}]": values for axis, z in (("X", 30 * np.cos(angle)), ("Y", 30 * np.sin(angle)))
            for name, unit, values in (("Position", "mm", z), ("Tension", "V", np.sign(np.gradient(z))))}  # fmt: skip
    sheets = {"aller": stroke, "retour": stroke, "cercle": {"Temps [s]": t} | turn}
    path = workbook(tmp_path / "essais.xlsx", sheets)
    found = find_sources([path], proposals=tmp_path / "maps")
    assert [*found.traces] == [path]
    assert [log.axis for log in found.logs] == ["x"]


@pytest.mark.parametrize("above", ["*** Test: stroke{n}\n*** Operator: N. N.\n", ""])
def test_a_text_that_repeats_its_header_holds_a_record_a_block(tmp_path: Path, above: str) -> None:
    """The blocks were one log whose time jumped back, and the advice was about circles."""
    a, path = axis_of_a_drive(n=1500), tmp_path / "tests.log"
    rows = [f"{t:.3f},{1e3 * r:.5f},{1e3 * x:.5f},{40 * i:.3f}"
            for t, r, x, i in zip(a["t"], a["asked"], a["position"], a["current"], strict=True)]  # fmt: skip
    block = "\n".join(["t(s),Xref(mm),Xact(mm),Force(N)", *rows]) + "\n"
    path.write_text("".join(above.format(n=n) + block for n in (1, 2, 3)))
    found = list(tables(path))
    assert [table.said["name"] for table in found] == [f"{'stroke' if above else 'block '}{n}" for n in (1, 2, 3)]
    assert [len(next(table.read([2])).columns[0]) for table in found] == [1500] * 3
    assert f"line {1509 if above else 1505}" in found[1].place(2)  # as an editor counts
    circle = "t(s),Xact(mm),Yact(mm),XU(V),YU(V)\n" + "\n".join(f"{n * 0.01:.2f},{n},{-n},1,2" for n in range(50))
    path.write_text("".join(above.format(n=n) + block for n in (1, 2)) + circle + "\n")
    assert [len(table.columns) for table in tables(path)] == [4, 4, 5]


def test_a_header_within_a_log_whose_time_goes_on_parts_nothing(tmp_path: Path) -> None:
    rows = [f"{n * 0.01:.2f},{-n},{n % 7}" for n in range(200)]  # its position falls, there as elsewhere
    text = "\n".join(["time [s],position [um],force [N]", *rows[:100], "time [s],position [um],force [N]", *rows[100:]])
    (tmp_path / "log.csv").write_text(text + "\n")
    (table,) = tables(tmp_path / "log.csv")
    assert sum(len(block.columns[0]) for block in table.read([1])) == 200


def test_units_behind_an_axis_and_a_word_are_units(tmp_path: Path) -> None:
    """Behind one underscore they were, behind two they were not: the voltage of a circle was left out."""
    names = ["timestamp", "x_cmd_m", "x_act_m", "x_cmd_V", "y_cmd_V", "velocity_rad_s"]
    write(tmp_path / "circle.csv", ";".join(names), *(np.arange(50.0) for _ in names))
    (table,) = tables(tmp_path / "circle.csv")
    assert [column.unit for column in table.columns] == [None, "m", "m", "V", "V", None]


def test_a_text_in_a_matlab_file_says_how_long_a_count_is(tmp_path: Path) -> None:
    """It was shown, and the counts were asked for."""
    savemat(tmp_path / "log.mat", {"PosAct_cnt": np.arange(50), "F_N": np.ones(50), "info": "1 count = 0.1 um"})
    (table,) = tables(tmp_path / "log.mat")
    assert {column.name: column.unit for column in table.columns}["PosAct_cnt"] == "0.1 um"


@pytest.mark.parametrize("names", [
    "tid [s];börläge [mm];läge [mm];kraft [N];spänning [V]",
    "aika [s];asetusarvo [mm];sijainti [mm];voima [N];jännite [V]",
    "zaman [s];komut konumu [mm];gerçek konum [mm];kuvvet [N];gerilim [V]",
    "tid [s];ønsket posisjon [mm];posisjon [mm];kraft [N];spenning [V]",
    "idő [s];előírt pozíció [mm];pozíció [mm];erő [N];feszültség [V]",
    "время, с;заданное положение, мм;положение, мм;сила, Н;напряжение, В",
    "时间(秒);指令位置(毫米);实际位置(毫米);推力(牛);电压(伏)",
])  # fmt: skip
def test_names_and_units_of_further_languages_are_read(tmp_path: Path, names: str) -> None:
    """Swedish, Turkish, Russian and Finnish were asked about, and so was a unit behind a comma."""
    a = axis_of_a_drive(n=1500)
    write(tmp_path / "log.csv", names, a["t"], 1e3 * a["asked"], 1e3 * a["position"], 40 * a["current"], a["current"])
    (axis,) = told(tmp_path / "log.csv")
    assert {of: role.column for of, role in axis.roles.items()} == {
        "time": 0, "reference": 1, "position": 2, "force": 3, "input": 4,
    }  # fmt: skip
    (table,) = tables(tmp_path / "log.csv")
    units = zip(table.columns[:3], ("time", "position", "position"), strict=True)
    assert [factor(column.unit or "", of) for column, of in units] == [1.0, 1e-3, 1e-3]


def test_a_circle_of_positions_in_other_words_is_found_among_the_tests_of_a_workbook(tmp_path: Path) -> None:
    """`posición X` was the position of no axis; each test was then of x and of y, and y had the numbers of x."""
    a, t = axis_of_a_drive(), np.arange(9000) * 5e-4
    angle = 2 * np.pi * t / 1.9
    stroke = {"tiempo (s)": a["t"], "posición real (mm)": 1e3 * a["position"], "consigna (mm)": 1e3 * a["asked"],
              "corriente del motor (A)": a["current"]}  # fmt: skip
    turn = {f"{name} {axis} ({unit})": values for axis, z in (("X", 30 * np.cos(angle)), ("Y", 30 * np.sin(angle)))
            for name, unit, values in (
                ("consigna", "mm", z), ("posición", "mm", z), ("corriente", "A", np.sign(np.gradient(z))),
            )}  # fmt: skip
    sheets = {"ida": stroke, "vuelta": stroke, "círculo": {"tiempo (s)": t} | turn}
    path = workbook(tmp_path / "ensayos.xlsx", sheets)
    found = find_sources([path], proposals=tmp_path / "maps")
    assert [*found.traces] == [path]
    assert [log.axis for log in found.logs] == ["x"]
    columns = "columns: {{time: {{column: tiempo}}, position: {{column: {}}}, force: {{column: {}}}}}"
    of = f"{{{{axis: {{}}, motion: linear/A, {columns}}}}}"
    parts = [("z", "posición real", "corriente del motor"), ("y", "posición Y", "corriente Y")]
    text = "".join(f"  - {of.format(*part)}\n" for part in parts)
    (tmp_path / "map.yaml").write_text(f"fric: mapping/1\nparts:\n{text}", encoding="utf-8")
    fric.ingest(path, output=tmp_path / "z.h5", mapping=tmp_path / "map.yaml", axis="z")
    assert [log.name for log in fric.read(tmp_path / "z.h5")] == ["ida", "vuelta"]  # the circle is not of z


def test_rows_of_json_that_a_word_parts_into_tests_are_records(tmp_path: Path) -> None:
    """ "Time runs backwards" was said of a file of tests that a field named."""
    a = axis_of_a_drive(n=600)
    samples = [*zip(a["t"], a["position"], a["current"], strict=True)]
    rows = [json.dumps({"test": test, "t_s": round(t, 4), "x_mm": round(1e3 * x, 5), "F_N": round(40 * i, 3)})
            for test in ("v1", "v0.5") for t, x, i in samples]  # fmt: skip
    (tmp_path / "trace.jsonl").write_text("\n".join(rows), encoding="utf-8")
    found = list(tables(tmp_path / "trace.jsonl"))
    assert [len(next(table.read([0])).columns[0]) for table in found] == [600, 600]
    assert [[column.name for column in table.columns] for table in found] == [["t_s", "x_mm", "F_N"]] * 2
    state = [row.replace("v0.5", "v1") if n % 100 else row for n, row in enumerate(rows)]  # a state, which returns
    (tmp_path / "trace.jsonl").write_text("\n".join(state), encoding="utf-8")
    assert len(list(tables(tmp_path / "trace.jsonl"))) == 1


def test_a_word_beside_a_time_that_goes_on_parts_nothing(tmp_path: Path) -> None:
    """A phase is no test: its position falls from the one to the next, as within it."""
    rows = [json.dumps({"phase": "in" if n < 50 else "out", "t": n * 1e-3, "x_mm": -n / 100, "F_N": 1.0 + n % 3})
            for n in range(100)]  # fmt: skip
    (tmp_path / "trace.jsonl").write_text("\n".join(rows), encoding="utf-8")
    assert len(list(tables(tmp_path / "trace.jsonl"))) == 1


def test_a_sentence_above_the_header_gives_units(tmp_path: Path) -> None:
    """They were asked for."""
    lines = ["# temps en s, position en mm, consigne en mm, effort en N", "temps\tposition\tconsigne\teffort"]
    rows = [f"{n / 1000}\t{n / 100}\t{n / 100}\t{n % 7}" for n in range(60)]
    (tmp_path / "essai.txt").write_text("\n".join([*lines, *rows]) + "\n", encoding="utf-8")
    (table,) = tables(tmp_path / "essai.txt")
    assert [column.unit for column in table.columns] == ["s", "mm", "mm", "N"]
