"""Forms that drives, controls and serial monitors write: traces by variable, rows as channels, words around rows."""

from contextlib import closing
from pathlib import Path

import h5py
import numpy as np
import pytest

from fric.errors import FricError
from fric.io.propose import proposal
from fric.io.readers import tables
from fric.io.readers.base import Column, ForeignTable
from fric.io.roles import SURE
from fric.io.words import spoken
from tests.io.judge import open_roles
from tests.io.test_roles import axis_of_a_drive, told, write


def table_of(path: Path) -> tuple[ForeignTable, list[np.ndarray]]:
    with closing(tables(path)) as found:
        table = next(found)
        blocks = [block.columns for block in table.read(range(len(table.columns)))]
    return table, [np.concatenate(parts) for parts in zip(*blocks, strict=True)]


def test_a_trace_of_codesys_has_a_column_a_variable(tmp_path: Path) -> None:
    a, lines = axis_of_a_drive(), ["[key]; [value]", "Version; 0x03050000", "EveryNCycles; 1"]
    for k, (name, of) in enumerate([("ActPos", "position"), ("ActVel", "velocity"), ("ActTorque", "current")]):
        lines += [f"{k}.Variable; PLC_PRG.X.lr{name}", f"{k}.Class; 14", f"{k}.Data; "]
        lines += [f"; {n + 2}; {value:.7g}" for n, value in enumerate(a[of])]
    (path := tmp_path / "Application.Trace.csv").write_text("\n".join(lines) + "\n")
    table, values = table_of(path)
    assert [column.name for column in table.columns] == [
        "time",
        *(f"PLC_PRG.X.lr{n}" for n in ("ActPos", "ActVel", "ActTorque")),
    ]
    assert values[1] == pytest.approx(a["position"], abs=1e-6)
    (axis,) = told(path)
    assert {of: role.column for of, role in axis.roles.items()} == {"time": 0, "position": 1, "velocity": 2, "force": 3}
    assert axis.roles["time"].unit == "ms"


def test_a_trace_of_codesys_without_samples_is_refused(tmp_path: Path) -> None:
    (path := tmp_path / "a.csv").write_text("[key]; [value]\n0.Variable; PLC_PRG.fPos\n0.Data; \n")
    with pytest.raises(FricError, match="holds no"):
        table_of(path)


@pytest.mark.parametrize("form", ["comment", "none"])
def test_few_long_rows_are_channels(tmp_path: Path, form: str) -> None:
    """As ``numpy.savetxt`` writes a list of three arrays."""
    a = axis_of_a_drive()
    names, values = ["timestamp", "actual_q_0", "actual_current_0"], [a["t"], a["position"], a["current"]]
    lines = [" ".join(f"{value:.9e}" for value in row) for row in values]
    (path := tmp_path / "log.csv").write_text("\n".join([f"# {' '.join(names)}"] * (form == "comment") + lines) + "\n")
    table, found = table_of(path)
    assert np.array(found) == pytest.approx(np.array(values), rel=1e-8)
    (axis,) = told(path)
    assert {of: role.column for of, role in axis.roles.items()} == {"time": 0, "position": 1, "force": 2}
    if form != "none":
        assert [column.name for column in table.columns] == names
        assert axis.roles["position"].unit_likelihood > SURE


def test_signals_of_xml_that_repeat_their_clock(tmp_path: Path) -> None:
    """As IndraWorks saves an oscilloscope: names and units as elements, values between bars."""
    a, parts = axis_of_a_drive(), list[str]()
    channels = [
        ("Position feedback", "mm", a["position"]),
        ("Velocity feedback", "mm/s", a["velocity"]),
        ("Torque", "%", a["current"]),
    ]
    for name, unit, values in channels:
        cells = ["|".join(f"{value:.6f}" for value in of) for of in (1e3 * a["t"], values)]
        parts.append(f"<Signal><Name>{name}</Name><Unit>{unit}</Unit><XUnit>ms</XUnit><XValue>{cells[0]}</XValue>"
                     f"<YValue>{cells[1]}</YValue></Signal>")  # fmt: skip
    (path := tmp_path / "trace.xml").write_text(
        f'<root xmlns="http://example.org/a"><Signals>{"".join(parts)}</Signals></root>'
    )
    table, _ = table_of(path)
    assert {*table.columns} == {Column("time"), *(Column(name, unit) for name, unit, _ in channels)}
    (axis,) = told(path)
    assert axis.roles["time"].unit_likelihood > SURE
    assert {of: role.unit for of, role in axis.roles.items()} == {
        "time": "ms",
        "position": "mm",
        "velocity": "mm/s",
        "force": "%",
    }


def test_lines_that_name_all_values_at_once_and_an_encoder_that_begins_again(tmp_path: Path) -> None:
    """Wrapped counts and rpm give the period of a log without a clock."""
    a, turn = axis_of_a_drive(dt=2e-3), 8192 / (2.0 * np.pi)
    cells = np.column_stack(
        [np.rint(7000.0 + a["position"] * turn) % 8192, a["velocity"] * 30.0 / np.pi, 400.0 * a["current"]]
    )
    lines = [f"ecd,speed_rpm,given_current:{int(p)},{v:.2f},{int(i)} " for p, v, i in cells]
    (path := tmp_path / "putty.log").write_text("\n".join(["=~=~= PuTTY log =~=~=", *lines]) + "\n")
    (axis,) = told(path)
    assert axis.roles["time"].unit == "0.002 s"
    assert axis.roles["position"].unit == f"{1 / 8192:.9g} rev"
    assert {of: role.column for of, role in axis.roles.items()} == {
        "time": None,
        "position": 0,
        "velocity": 1,
        "force": 2,
    }


@pytest.mark.parametrize("place", ["end", "middle"])
def test_lines_of_words_are_no_samples(tmp_path: Path, place: str) -> None:
    a = axis_of_a_drive()
    lines = ["tag,time_ms,position_rad,current_a"]
    lines += [f"run,{1e3 * t:.3f},{p:.6f},{i:.6f}" for t, p, i in zip(a["t"], a["position"], a["current"], strict=True)]
    lines.insert(len(lines) if place == "end" else 2000, "done")
    (path := tmp_path / "terminal.txt").write_text("\n".join(lines) + "\n")
    table, values = table_of(path)
    assert len(values[1]) == len(a["t"])
    assert np.isfinite(values[1:]).all()
    assert f"line {len(lines) - (place == 'end')}" in table.place(len(a["t"]) - 1)
    lines[3000] = "run,nan,nan,nan"  # a sample that was lost
    path.write_text("\n".join(lines) + "\n")
    assert np.isnan(table_of(path)[1][1]).sum() == 1


def test_words_behind_empty_cells_do_no_harm(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    lines = [f";{t:.3f};{p:.6f};{i:.6f}" for t, p, i in zip(a["t"], a["position"], a["current"], strict=True)]
    lines[40] = "mark" + lines[40]
    (path := tmp_path / "log.csv").write_text("\n".join([";time [s];position [rad];current [A]", *lines]) + "\n")
    assert table_of(path)[1][2] == pytest.approx(a["position"], abs=1e-6)


@pytest.mark.parametrize(
    ("name", "quantity"),
    [
        ("iActualPosition", "position"), ("nActPos", "position"), ("lrActVelo", "velocity"), ("fActTorque", "force"),
        ("GVL.udiActPosition", "position"), ("iActual", "force"), ("nAct", "velocity"), ("busVoltage", "other"),
        ("rpm_sp", "velocity"),
    ],
)  # fmt: skip
def test_the_type_of_a_variable_before_its_name_says_no_quantity(name: str, quantity: str) -> None:
    assert spoken(Column(name)).quantity == quantity
    assert spoken(Column(name)).commanded == name.endswith("_sp")


def test_two_velocities_of_one_motion_are_one_axis(tmp_path: Path) -> None:
    """As of an encoder and a gyroscope."""
    a, rng = axis_of_a_drive(), np.random.default_rng(5)
    rough = a["velocity"] + 0.3 * rng.standard_normal(len(a["t"]))
    path = write(
        tmp_path / "log.csv",
        "time_s;velocity_rad_s;velocity_imu_rad_s;torque_nm",
        a["t"],
        rough,
        a["velocity"],
        a["current"],
    )
    (axis,) = told(path)
    assert axis.roles["velocity"].column == 1


def test_a_command_in_steps_is_no_position(tmp_path: Path) -> None:
    """Without names: a current in steps, and the speed that it leaves."""
    rng, dt, n = np.random.default_rng(3), 1e-3, 24_000
    current = np.repeat([1.5, 2.0, 2.5, 3.0, -1.5, -2.0, -2.5, -3.0], n // 8)
    speed, of = np.zeros(n), 0.0
    for k in range(n):
        of += dt * (current[k] - 0.8 * np.tanh(of / 0.5) - 0.02 * of) / 0.01
        speed[k] = of
    path = tmp_path / "stairs.csv"
    np.savetxt(
        path,
        np.column_stack([np.arange(n) * dt, current, speed + 0.3 * rng.standard_normal(n)]),
        delimiter=",",
        fmt="%.6e",
    )
    (axis,) = told(path)
    assert {of: role.column for of, role in axis.roles.items()} == {"time": 0, "velocity": 2, "force": 1}


def test_a_count_of_cycles_has_no_unit_of_time(tmp_path: Path) -> None:
    a = axis_of_a_drive(dt=0.885e-3)
    count = 18_273_645 + 2 * np.arange(len(a["t"]))
    cells = zip(count, a["position"], a["current"], strict=True)
    lines = ["Sys.ServoCount Motor[1].ActPos Motor[1].IqCmd", *(f"{c} {p:.6f} {i:.6f}" for c, p, i in cells)]
    (path := tmp_path / "Gather.txt").write_text("\n".join(lines) + "\n")
    (axis,) = told(path)
    assert "time" in {role.channel for role in open_roles(axis)}
    assert axis.roles["time"].column == 0
    assert 'time: {column: "Sys.ServoCount", unit: "?"}' in proposal([path])


def test_positions_in_whole_numbers_are_not_in_micrometres_for_sure(tmp_path: Path) -> None:
    a, turn = axis_of_a_drive(), 65536 / (2.0 * np.pi)
    counts = np.rint(turn * a["position"]), np.rint(turn * a["velocity"])
    (axis,) = told(
        write(tmp_path / "log.csv", "time_s;actual_position;actual_velocity;current_a", a["t"], *counts, a["current"])
    )
    assert {role.channel for role in open_roles(axis)} == {"position", "velocity"}
    assert axis.roles["position"].unit_likelihood < 0.6


def test_a_velocity_of_an_odrive_alone_is_in_turns_a_second(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    (axis,) = told(
        write(
            tmp_path / "log.csv", "time;vel_estimate;Iq_measured", a["t"], a["velocity"] / (2.0 * np.pi), a["current"]
        )
    )
    assert axis.roles["velocity"].unit == "rev/s"


def test_signals_of_a_struct_with_stamps_names_and_one_unit(tmp_path: Path) -> None:
    """As loggers of robots save MATLAB 7.3: joints by 1 by instants, and what the joints are called."""
    a, b = axis_of_a_drive(), axis_of_a_drive(seed=2)
    b = {name: np.roll(values, 700) if name != "t" else values for name, values in b.items()}
    with h5py.File(path := tmp_path / "log.mat", "w", userblock_size=512) as file:
        top, names = file.create_group("logger/joints"), file.create_group("#refs#")
        top.parent.attrs["MATLAB_class"] = top.attrs["MATLAB_class"] = np.bytes_("struct")

        def word(group: h5py.Group, name: str, text: str) -> h5py.Dataset:
            data = group.create_dataset(name, data=np.array([ord(letter) for letter in text], "u2")[:, None])
            data.attrs["MATLAB_class"] = np.bytes_("char")
            return data

        called = [word(names, name, name).ref for name in ("hip", "knee")]
        for name, of, unit in (
            ("positions", "position", "rad"),
            ("velocities", "velocity", "rad/s"),
            ("torques", "current", "N*m"),
        ):
            group = top.create_group(name)
            group["data"] = np.stack([a[of], b[of]], axis=-1)[:, None, :]
            group["timestamps"], group["dimensions"] = 1.7e9 + a["t"][:, None], np.array([[2.0], [1.0]])
            group.create_dataset("elements_names", (1, 2), dtype=h5py.ref_dtype)[0] = called
            word(group, "units_of_measure", unit)
    content = bytearray(path.read_bytes())
    content[:128] = b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM"
    path.write_bytes(content)
    axes = told(path)
    assert len(axes) == 2
    table, _ = table_of(path)
    for axis, name in zip(axes, ("hip", "knee"), strict=True):
        found = {of: table.columns[role.column or 0] for of, role in axis.roles.items()}
        assert found["position"] == Column(f"positions.{name}", "rad")
        assert found["force"] == Column(f"torques.{name}", "N*m")
        assert axis.roles["time"].unit == "s"
        assert not open_roles(axis)
