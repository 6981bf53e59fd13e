"""Forms of logs that were first met in other people's: stamps that jitter, numbered comments, two sides of a robot."""

import threading
import warnings
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np
import pytest

import fric
from fric.automatic.sources import find_sources
from fric.documents.mapping import MappingDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.estimate import Estimate
from fric.identify.plant.identify import _plant
from fric.io.hdf5 import read_logs
from fric.io.ingest import Signs
from fric.io.ingest_circle import ingest_circles
from fric.io.propose import AT_REST, NO_FORCE, NO_POSITION, Guessed, guesses, proposal
from fric.io.questions import Question, answered
from fric.io.readers import tables
from fric.io.readers.base import Column
from fric.io.roles import SURE
from fric.io.words import spoken
from tests.io.judge import open_roles
from tests.io.test_roles import axis_of_a_drive, told


def rows(path: Path, header: str, *columns: np.ndarray, mark: str = " ") -> Path:
    lines = [mark.join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([*header.splitlines(), *lines]) + "\n")
    return path


@pytest.mark.parametrize("place", [0, 1])
def test_stamps_that_a_program_takes_when_it_can_are_the_time(tmp_path: Path, place: int) -> None:
    """Milliseconds that go on by 1 to 4 a row were no clock: the period was asked, and the stamps were a motion."""
    a = axis_of_a_drive(n=1500, dt=2.5e-3)
    stamps = np.cumsum(np.random.default_rng(1).integers(1, 5, 1500)).astype(float)
    position = np.rad2deg(np.interp(stamps * 1e-3, a["t"], a["position"]))
    current = np.interp(stamps * 1e-3, a["t"], a["current"])
    columns = [stamps, position, current] if place == 0 else [position, stamps, current]
    (axis,) = told(rows(tmp_path / "log.txt", "", *columns))
    assert {channel: role.column for channel, role in axis.roles.items()} == {
        "time": place, "position": 1 - place, "force": 2,
    }  # fmt: skip
    assert axis.roles["time"].unit == "ms"


def test_a_motion_at_one_speed_is_no_clock_of_its_log(tmp_path: Path) -> None:
    """A stroke in one direction rises with every row, too, but evenly or smoothly; an even clock goes before it."""
    a = axis_of_a_drive(n=1500)
    stroke = np.cumsum(1.0 + 0.4 * np.sin(2 * np.pi * a["t"] / 0.7)) * 1e-3
    (axis,) = told(rows(tmp_path / "log.txt", "", stroke, a["t"], a["current"]))
    assert axis.roles["time"].column == 1


def test_rounded_stamps_without_a_header_are_evened(tmp_path: Path) -> None:
    """Some stamps stood twice: their samples were dropped, and the record was uneven to what followed."""
    a = axis_of_a_drive(n=2000)
    t = np.maximum.accumulate(np.round(a["t"] + 5.5e-4 * np.random.default_rng(2).random(2000), 3))
    assert 0.03 < np.mean(np.diff(t) == 0.0) < 0.5
    path = rows(tmp_path / "log.txt", "", t, a["position"], a["velocity"], a["current"])
    done = fric.ingest(path, output=tmp_path / "log.h5", assume=True)
    (log,) = read_logs(tmp_path / "log.h5")
    assert done.done.dropped == 0
    assert np.ptp(np.diff(log.time)) < 1e-9


NUMBERED = """% a cart on two drives
%  1 clock [s]: 0.0
%  2 phase: 1
%  3  4 Terminal voltage [V] left, right: 1.5 1.6
%  5  6 Drive current left, right [A]: 0.1 0.1
%  7  8 Drive speed [m/s] left, right: 0 0
%  9 Yaw rate [r/s]: 0
% 10 11 Cart pose [m,rad]: 0 0
% 12 .. 14 Floor brightness: 5 5 5
% 15 Battery voltage [V]: 12"""


def test_numbered_comments_name_columns(tmp_path: Path) -> None:
    """Without them the battery's voltage was the force, and the pose the position."""
    a, b = axis_of_a_drive(n=3000), axis_of_a_drive(n=3000, seed=3)
    left, right = 0.05 * a["velocity"], 0.05 * np.roll(b["velocity"], 400)
    noise = np.round(20.0 * np.random.default_rng(4).standard_normal((4, 3000)))
    path = rows(
        tmp_path / "log.txt", NUMBERED, a["t"], np.full(3000, 2.0), np.full(3000, 2.1), np.full(3000, 2.1),
        a["current"], np.roll(b["current"], 400), left, right, (right - left) / 0.2, np.cumsum(left + right) * 5e-4,
        np.cumsum(right - left) * 5e-3, *noise[:3], 12.0 - 0.05 * np.abs(a["current"]) + 1e-3 * noise[3],
    )  # fmt: skip
    one, other, *rest = told(path)
    for axis, force, velocity in ((one, 4, 6), (other, 5, 7)):
        assert (axis.roles["force"].column, axis.roles["force"].unit) == (force, "A")
        assert (axis.roles["velocity"].column, axis.roles["velocity"].unit) == (velocity, "m/s")
        assert min(axis.roles["force"].likelihood, axis.roles["velocity"].likelihood) >= SURE
    assert all("force" not in axis.roles for axis in rest)  # no sensor of a line is one


@pytest.mark.parametrize("place", ["Place, heading", "pose", "odometry", "alpha"])
@pytest.mark.parametrize(("sides", "turns"), [("left right", 0.3), ("1 2", 0.02), ("port starboard", 0.0)])
def test_a_force_of_a_side_moves_no_whole(tmp_path: Path, place: str, sides: str, turns: float) -> None:
    """The place of a cart was taken for the position of its left drive: the mass would be that of the cart's middle."""
    a, rng = axis_of_a_drive(n=3000), np.random.default_rng(5)
    turn = turns * np.sin(2 * np.pi * a["t"] / 0.9)
    moved = [0.05 * (a["velocity"] + sign * turn) + 2e-4 * rng.standard_normal(3000) for sign in (1, -1)]
    pushed = [a["current"] + 0.03 * rng.standard_normal(3000), 0.2 * a["current"] + 0.03 * rng.standard_normal(3000)]
    left, right = sides.split()
    header = ";".join(["time [s]", f"drive current {left} [A]", f"drive current {right} [A]",
                       f"wheel speed {left} [m/s]", f"wheel speed {right} [m/s]", f"{place} [m]"])  # fmt: skip
    middle = 1e-3 * np.cumsum(0.05 * a["velocity"])
    axes = told(rows(tmp_path / "log.csv", header, a["t"], *pushed, *moved, middle, mark=";"))
    found = [(axis.roles["velocity"].column, axis.roles["force"].column, axis.roles.get("position"))
             for axis in axes if "force" in axis.roles]  # fmt: skip
    assert found == [(3, 1, None), (4, 2, None)]


def test_a_position_without_a_side_is_that_of_the_side_whose_velocity_it_has(tmp_path: Path) -> None:
    a, b = axis_of_a_drive(n=3000), axis_of_a_drive(n=3000, seed=3)
    header = "time [s];left current [A];right current [A];left speed [rad/s];right speed [rad/s];encoder [rad]"
    shift = 400
    path = rows(tmp_path / "log.csv", header, a["t"], a["current"], np.roll(b["current"], shift), a["velocity"],
                np.roll(b["velocity"], shift), a["position"], mark=";")  # fmt: skip
    found = [{of: role.column for of, role in axis.roles.items() if of != "time"} for axis in told(path)]
    assert {"position": 5, "velocity": 3, "force": 1} in found
    assert {"velocity": 4, "force": 2} in found


def test_which_of_two_motors_moves_a_beam_is_asked(tmp_path: Path) -> None:
    """The stronger current of two that share the work was taken for all of it, sure to 99 %."""
    a, rng = axis_of_a_drive(n=3000), np.random.default_rng(6)
    weak = 0.01 * a["current"] + 0.3 * rng.standard_normal(3000)
    header = "time [s];motor 1 current [A];motor 2 current [A];motor 1 temp;motor 2 temp;beam position [mm]"
    warm = 40.0 + 0.01 * np.cumsum(rng.standard_normal((2, 3000)), axis=1)
    path = rows(tmp_path / "log.csv", header, a["t"], a["current"], weak, *warm, 10.0 * a["position"], mark=";")
    (axis,) = told(path)
    assert axis.roles["force"].likelihood < SURE
    assert {axis.roles["force"].column, *axis.roles["force"].others} == {1, 2}


def test_two_axes_of_velocities_alone_are_no_circle(tmp_path: Path) -> None:
    """`fric auto` looked for circles in their positions, and ended in a traceback."""
    a, b = axis_of_a_drive(n=1000), axis_of_a_drive(n=1000, seed=3)
    header = "time [s],left velocity [m/s],right velocity [m/s],left current [A],right current [A]"
    path = rows(tmp_path / "log.csv", header, a["t"], 0.05 * a["velocity"], 0.05 * b["velocity"], a["current"],
                b["current"], mark=",")  # fmt: skip
    (tmp_path / "map.yaml").write_text(proposal([path], assume=True))
    with pytest.raises(FricError, match="no whole circle"):
        ingest_circles(path, tmp_path / "circle.h5", mapping=read_document(tmp_path / "map.yaml", MappingDocument))


@pytest.mark.parametrize("numbers", ["# {} : {}", "% col {}: {}", "#{}) {}", "// {} - {}"])
def test_comments_number_columns_in_several_ways(tmp_path: Path, numbers: str) -> None:
    a = axis_of_a_drive(n=1000)
    said = ["time [s]", "joint angle [rad]", "motor current [A]"]
    header = "\n".join(numbers.format(n, name) for n, name in enumerate(said, 1))
    (axis,) = told(rows(tmp_path / "log.txt", header, a["t"], a["position"], a["current"]))
    assert open_roles(axis) == []


def test_a_supply_that_its_unit_alone_shows_is_no_input(tmp_path: Path) -> None:
    """16.1 to 16.3 V beside a motion both ways was taken for what drives the axis."""
    a = axis_of_a_drive(n=2000)
    psu = np.round(16.3 - 0.1 * np.abs(a["current"]), 1)
    path = rows(tmp_path / "log.csv", "time [s];motor_pos [rad];motor_psu [V];motor_current [A]", a["t"], a["position"],
                psu, a["current"], mark=";")  # fmt: skip
    with ExitStack() as files:
        (guess,) = guesses([path], files)
    assert guess.axis.roles.keys() == {"time", "position", "force"}


@pytest.mark.parametrize(
    ("header", "unit"), [("time,ODrive 0 Position,ODrive 0 Velocity,ODrive 0 Current", "rev"), ("time,pos,vel,iq", "m")]
)
def test_positions_of_an_odrive_are_in_turns(tmp_path: Path, header: str, unit: str) -> None:
    """What creeps by 0.01 was sure to be in metres."""
    a = axis_of_a_drive(n=2000)
    path = rows(
        tmp_path / "log.csv", header, a["t"], 3e-3 * a["position"], 3e-3 * a["velocity"], a["current"], mark=","
    )
    (axis,) = told(path)
    assert axis.roles["position"].unit == unit


def test_the_speed_of_a_motor_is_likely_in_rpm(tmp_path: Path) -> None:
    a = axis_of_a_drive(n=2000)
    header = "time [ms],Servo motor speed,Torque"
    (axis,) = told(rows(tmp_path / "log.csv", header, 1e3 * a["t"], 300.0 * a["velocity"], a["current"], mark=","))
    assert axis.roles["velocity"].unit == "rpm"
    assert axis.roles["velocity"].unit_likelihood < SURE


@pytest.mark.parametrize("unit", [1.0, 1e3])
@pytest.mark.parametrize(("seed", "trust"), [(0, 0.97), (1, 0.97), (1, 0.95), (3, 0.97)])
def test_an_angle_that_was_roughly_integrated_is_no_velocity(
    tmp_path: Path, seed: int, trust: float, unit: float
) -> None:
    """A filter of rate and tilt makes an angle of which the rate is not quite the slope, and was taken for a force."""
    rng, dt, n = np.random.default_rng(seed), 5e-3, 300
    t = 3.0 + np.cumsum(rng.uniform(0.9, 1.1, n) * dt)
    swing = 20.0 * np.tanh((t - t.mean()) / 0.3) + np.sin(2.6 * np.pi * t + seed)
    rate = np.gradient(swing, t) + rng.standard_normal(n)
    tilt = swing + 5.0 * np.sin(4.0 * np.pi * t)
    angle = tilt.copy()
    for k in range(1, n):
        angle[k] = trust * (angle[k - 1] + rate[k] * dt) + (1.0 - trust) * tilt[k]
    command = np.cumsum(np.round(-4.0 * angle - 0.3 * rate))
    axes = told(rows(tmp_path / "balance.dat", "", unit * t, rate, angle, command))
    (axis,) = [axis for axis in axes if 2 in {role.column for role in axis.roles.values()}]
    assert (axis.roles["position"].column, axis.roles["velocity"].column) == (2, 1)
    assert axis.roles["position"].likelihood < SURE
    assert all(other.roles["force"].column != 1 for other in axes if "force" in other.roles)


@pytest.mark.parametrize("mass", [0.1, 0.5])
def test_a_force_beside_a_velocity_stays_one(tmp_path: Path, mass: float) -> None:
    """The slope of a velocity explains most of the force of a heavy axis, too, but at any factor."""
    a = axis_of_a_drive(n=3000)
    force = mass * a["acceleration"] + 3.0 * a["current"]
    (axis,) = told(rows(tmp_path / "log.dat", "", a["t"], a["velocity"], force))
    assert {of: role.column for of, role in axis.roles.items()} == {"time": 0, "velocity": 1, "force": 2}


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("friction", "resistance"), [(0.05, 1.0), (0.2, 0.5), (0.1, 3.0)])
def test_a_current_that_falls_as_a_drive_speeds_up_still_drives_it(
    tmp_path: Path, friction: float, resistance: float, sign: int
) -> None:
    """At a constant voltage a current falls with the speed, which was taken for friction that counts the other way."""
    dt, rng, v, rotor = 1e-3, np.random.default_rng(7), 0.0, 0.02
    speed, current = np.zeros(600), np.zeros(600)
    for k in range(600):
        current[k] = (2.0 - v) / resistance
        v += dt / rotor * (current[k] - friction)
        speed[k] = v
    t = dt * np.arange(600)
    logged = np.round(speed + 0.01 * rng.standard_normal(600), 3), sign * (current + 0.003 * rng.standard_normal(600))
    (axis,) = told(rows(tmp_path / "log.csv", "time [s],speed [rad/s],current [A]", t, *logged, mark=","))
    assert axis.roles["force"].sign == sign
    assert axis.roles["force"].likelihood >= SURE


def swing(friction: float) -> tuple[np.ndarray, ...]:
    """Return time, angle, and the torque of a damper that a motor makes at a swing whose weight it carries, too."""
    t = 2e-3 * np.arange(3000)
    angle = 0.4 * np.sin(2.0 * np.pi * 0.7 * t) + 0.15 * np.sin(2.0 * np.pi * 1.9 * t)
    velocity = np.gradient(angle, t)
    torque = 0.02 * np.gradient(velocity, t) + friction * (velocity + 0.3 * np.sign(velocity))
    return t, np.round(angle, 5), torque + 0.01 * np.random.default_rng(8).standard_normal(3000)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_sign_by_which_the_mass_is_below_0_is_asked(tmp_path: Path, sign: int) -> None:
    """What friction shows was taken, sure to 99 %, and a mass below 0 was identified."""
    t, angle, torque = swing(-0.15)
    path = rows(tmp_path / "log.csv", "time [s],angle [rad],torque [N*m]", t, angle, sign * torque, mark=",")
    with ExitStack() as files:
        found = Guessed(tuple(guesses([path], files)))
        force = found.found[0].axis.roles["force"]
        assert force.likelihood < SURE
        assert force.others == {2: -force.sign}
        assert f"'torque' with sign: {-force.sign}" in " ".join(found.found[0].open)
        asked: list[Question] = []
        answered(found, lambda question: (asked.append(question), question.take("2")), tmp_path)
        assert [text for text, _ in asked[0].choices] == ["'torque'", "'torque', turned"][:: force.sign]
        assert found.found[0].axis.roles["force"].sign == -force.sign
        assert found.sure


@pytest.mark.parametrize("late", [-4e-3, 0.0, 4e-3])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_sign_that_friction_and_inertia_share_is_sure(tmp_path: Path, late: float, sign: int) -> None:
    """Nor is it asked where a filter delays the force or the position."""
    t, angle, torque = swing(0.15)
    torque = sign * np.interp(t - late, t, torque)
    path = rows(tmp_path / "log.csv", "time [s],angle [rad],torque [N*m]", t, angle, torque, mark=",")
    (axis,) = told(path)
    assert axis.roles["force"].sign == sign
    assert axis.roles["force"].likelihood >= SURE


def test_the_only_current_beside_two_angles_leaves_open_which_it_moves(tmp_path: Path) -> None:
    """Of a wheel on a pendulum, which both follow the current, the pendulum was taken without a word."""
    a = axis_of_a_drive(n=3000)
    wheel, pendulum = np.round(a["position"] / 0.13) * 0.13, -0.1 * a["position"] + 0.02 * np.sin(7.0 * a["t"])
    header = "time(s),current(A),rw angle(rad),pendulum angle(rad)"
    path = rows(tmp_path / "log.csv", header, a["t"], a["current"], wheel, pendulum, mark=",")
    (pushed,) = [axis for axis in told(path) if "force" in axis.roles]
    position = pushed.roles["position"]
    assert position.likelihood < SURE
    assert {position.column, *position.others} == {2, 3}


def test_of_two_angles_the_one_whose_mass_is_above_0_is_likelier(tmp_path: Path) -> None:
    """A wheel on a pendulum: its torque turns the wheel one way, and swings the pendulum the other."""
    dt, wheel, tilt, state = 2e-3, np.zeros(2500), np.zeros(2500), np.zeros(4)
    t = dt * np.arange(2500)
    current = 2.0 + np.sin(2.0 * np.pi * 0.9 * t) + np.sin(2.0 * np.pi * 1.7 * t)
    for k in range(2500):
        speed, swing = state[1], state[3]
        push = current[k] - 0.05 * speed
        state += dt * np.array([speed, push / 0.02, swing, -push / 2.0 - 60.0 * state[2] - 0.3 * swing])
        wheel[k], tilt[k] = state[0], state[2]
    header = "time(s),current(A),rotor angle(rad),arm angle(rad)"
    path = rows(tmp_path / "log.csv", header, t, current, np.round(wheel / 0.13) * 0.13, tilt, mark=",")
    (pushed,) = [axis for axis in told(path) if "force" in axis.roles]
    assert (pushed.roles["position"].column, pushed.roles["force"].sign) == (2, 1)
    assert pushed.roles["position"].likelihood < SURE


def test_a_mass_below_0_has_an_interval_that_is_not_turned() -> None:
    """The limits of its B were, and the refusal of that was all that `fric auto` said of such a motion."""
    found = _plant(np.array([-0.2, 0.1, 0.5, 0.0]), 1e-4 * np.eye(4), 2.0, "both", "force",
                   Estimate(1.0, "A/A", fixed=True), None, 1e-4, "rotary/A")  # fmt: skip
    low, high = found["B"].limits
    assert low < float(found["B"]) == -5.0 < high < 0.0


def test_a_motion_that_is_too_short_says_once_where_and_how_long(tmp_path: Path) -> None:
    a = axis_of_a_drive(n=200, dt=7e-4)
    path = rows(tmp_path / "log.csv", "time [s],position [rad],force [A]", a["t"], a["asked"], a["current"], mark=",")
    fric.ingest(path, output=(log := tmp_path / "log.h5"), motion="rotary/A", kind="motion")
    said = r"200 samples are too few: \d+ are needed\nLog a motion of 0\.\d+ s"
    with pytest.raises(FricError, match=said) as refused:
        fric.identify_plant(log, method="motion")
    assert str(refused.value).count("log.h5") == 1


@pytest.mark.parametrize("step", [1.0, 3000.0])
@pytest.mark.parametrize("mark", [";", ",", "\t"])
def test_a_delimiter_at_the_end_of_rows_without_a_header_shifts_no_column(
    tmp_path: Path, step: float, mark: str
) -> None:
    """Their first column, evenly spaced whole numbers, was an index to pandas: each column held what the next does."""
    a = axis_of_a_drive(n=2000)
    path = rows(tmp_path / "scope.sco", "%[DATA]", step * np.arange(2000), a["position"], a["current"], mark=mark)
    path.write_text(path.read_text().replace("\n", f"{mark}\n").replace(f"%[DATA]{mark}", "%[DATA]"))
    with closing(tables(path)) as found:
        (block, *_) = next(found).read(range(3))
    assert np.array_equal(block.columns[0][:9], step * np.arange(9))
    assert np.allclose(block.columns[2], a["current"][: len(block.columns[2])])


def test_units_are_written_out_in_names(tmp_path: Path) -> None:
    """``speed_meters_per_sec`` was a time in s, and counts that have no unit were taken in place of metres."""
    a = axis_of_a_drive(n=2000)
    header = "ms_today;erpm;tachometer;speed_meters_per_sec;tacho_meters;q_axis_current;d_axis_current;torque_enable"
    path = rows(
        tmp_path / "log.csv", header, 1e3 * a["t"], 401.1 * a["velocity"], np.round(42.0 * a["position"]),
        0.4 * a["velocity"], 0.4 * a["position"], a["current"], 0.02 * np.roll(a["current"], 7), np.ones(2000),
        mark=";",
    )  # fmt: skip
    (axis,) = told(path)
    assert {channel: (role.column, role.unit) for channel, role in axis.roles.items()} == {
        "time": (0, "ms"), "position": (4, "m"), "velocity": (3, "m/s"), "force": (5, "A"),
    }  # fmt: skip
    assert "force" not in {open_role.channel for open_role in open_roles(axis)}


@pytest.mark.parametrize(
    ("name", "unit"),
    [("wheel_degrees_per_second", "deg/s"), ("vel_rad_per_s", "rad/s"), ("feed mm per min", "mm/min"),
     ("angle_radians", "rad"), ("motor_amps", "A"), ("load_per_sec", None)],
)  # fmt: skip
def test_units_in_words(name: str, unit: str | None) -> None:
    assert spoken(Column(name, None)).unit == unit


def test_a_flag_named_of_a_torque_is_no_force(tmp_path: Path) -> None:
    """Of a log without a force it was said that the force is ``torque_enable``."""
    a = axis_of_a_drive(n=1000)
    path = rows(tmp_path / "log.csv", "time,position,torque_enable", a["t"], a["position"], np.ones(1000), mark=",")
    with pytest.raises(FricError, match="no column is a force"):
        fric.auto(path, output=tmp_path / "found", assume=True)


def test_topics_that_fill_their_cells_in_rows_of_their_instants(tmp_path: Path) -> None:
    """As PlotJuggler exports them: the log had no position, for most of its cells are empty."""
    a = axis_of_a_drive(n=3000)
    lines = ["__time,/joint_states/elbow/position,/joint_states/elbow/velocity,/drive/current,/drive/temperature"]
    for k, t in enumerate(a["t"]):
        lines += [f"{1.6e9 + t:.6f},{a['position'][k]:.6f},{a['velocity'][k]:.6f},,"]
        lines += [f"{1.6e9 + t + 4e-4:.6f},,,{a['current'][k]:.5f},"] if k % 2 == 0 else []
        lines += [f"{1.6e9 + t + 6e-4:.6f},,,,{30 + 1e-3 * k:.1f}"] if k % 100 == 50 else []
    path = tmp_path / "export.csv"
    path.write_text("\n".join(lines) + "\n")
    fric.ingest(path, output=tmp_path / "log.h5", assume=True)
    (log,) = read_logs(tmp_path / "log.h5")
    assert log.force is not None
    assert len(log) == 1500  # the instants of the current, though a temperature is slower
    assert np.allclose(log.force, a["current"][::2], atol=1e-5)
    assert np.allclose(np.diff(log.position), np.diff(np.interp(a["t"][::2] + 4e-4, a["t"], a["position"])), atol=1e-6)


def test_a_column_that_is_seldom_written_changes_no_others(tmp_path: Path) -> None:
    a = axis_of_a_drive(n=1000)
    lines = [f"{t:.3f},{x:.6f},{f:.4f},{'31' if k % 9 == 0 else ''}"
             for k, (t, x, f) in enumerate(zip(a["t"], a["position"], a["current"], strict=True))]  # fmt: skip
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["time [s],angle [rad],current [A],temperature", *lines]) + "\n")
    with closing(tables(path)) as found:
        blocks = [*next(found).read(range(3))]
    assert np.allclose(np.concatenate([block.columns[1] for block in blocks]), a["position"], atol=1e-6)


def test_a_temperature_each_second_hides_no_motion(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All channels were looked at by its clock: of four seconds four samples were left, and no position."""
    a = axis_of_a_drive(n=4000)
    about = {"Name": ("ActPos", "ActVelo", "ActCurrent", "MotorTemp"), "SymbolComment": ("", "", "", ""),
             "SampleTime[ms]": ("1", "1", "1", "1000"),
             "Unit": ("(None)", "(None)", "A (Current)", "(None)")}  # fmt: skip
    lines = ["Name\tScope", "File\tscope.csv", "Starttime of export\t132959733843760000\tMonday", "", ""]
    lines += ["\t".join([key, *cells[:3], key, cells[3]]) for key, cells in about.items()] + [""]
    for k in range(4000):
        slow = f"{1000 * k}\t{31 + 0.1 * k:.1f}" if k < 4 else "\t"
        lines.append(f"{k}\t{a['position'][k]:.6f}\t{a['velocity'][k]:.6f}\t{a['current'][k]:.5f}\t{slow}")
    path = tmp_path / "scope.csv"
    path.write_text("\n".join(lines) + "\n")
    monkeypatch.setattr("fric.io.readers.text.PIECE", 4096)
    (axis,) = told(path)
    assert not any(thread.name.startswith("parse") for thread in threading.enumerate())
    assert {channel: role.column for channel, role in axis.roles.items()} == {
        "time": 0, "position": 1, "velocity": 2, "force": 3,
    }  # fmt: skip
    fric.ingest(path, output=tmp_path / "log.h5", assume=True)
    (log,) = read_logs(tmp_path / "log.h5")
    assert len(log) > 2900
    assert np.median(np.diff(log.time)) == pytest.approx(1e-3)


def test_a_column_that_falls_and_mostly_stands_warns_of_nothing(tmp_path: Path) -> None:
    """NumPy warned of an invalid value in a difference."""
    a = axis_of_a_drive(n=600)
    path = rows(tmp_path / "log.txt", "", np.where(np.arange(600) < 300, 0.5, 0.2), a["position"], a["current"])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        told(path)


def test_what_lacks_a_unit_is_not_said_to_show_no_friction(tmp_path: Path) -> None:
    """A log with a force, whose speed counts turns of pole pairs, was said to show no friction."""
    a = axis_of_a_drive(n=1500)
    path = rows(tmp_path / "log.csv", "time [s];erpm;current_motor [A]", a["t"], 300.0 * a["velocity"], a["current"],
                mark=";")  # fmt: skip
    with pytest.raises(FricError, match=r"can be used: 'erpm'.*counts turns of pole pairs"):
        fric.auto(path, output=tmp_path / "found", assume=True)


def telegrams(a: dict[str, np.ndarray], indent: str) -> str:
    """Return what a robot sends by RSI: whole elements behind each other, without a root; joint 1 moves."""
    form = ('<Rob Type="KUKA">', '<RIst X="%.4f" Y="0" Z="800"/>', '<AIPos A1="%.4f" A2="-90" A3="90"/>',
            '<MACur A1="%.4f" A2="4.0" A3="1.2"/>', "<IPOC>%d</IPOC>", "</Rob>")  # fmt: skip
    degrees = np.rad2deg(a["position"])
    rows = zip(500 + degrees, degrees, a["current"], 4208163634 + np.rint(1e3 * a["t"]), strict=True)
    return "\n".join(indent.join(form) % row for row in rows) + "\n"


@pytest.mark.parametrize("indent", ["", "\n  "])
@pytest.mark.parametrize("end", ["", '<Rob Type="KUKA"><RIst X="1'])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_telegrams_of_a_robot_are_records(tmp_path: Path, indent: str, end: str, mark: str) -> None:
    """They were no rows of numbers; the last one may be cut off."""
    a = axis_of_a_drive(n=1000, dt=4e-3)
    path = tmp_path / "rsi.xml"
    path.write_text(mark + telegrams(a, indent) + end)
    with closing(tables(path)) as found:
        table = next(found)
        assert len(next(table.read([0])).columns[0]) == 1000
    (axis,) = told(path)
    assert {channel: table.columns[role.column].name for channel, role in axis.roles.items()} == {
        "time": "IPOC", "position": "AIPos A1", "force": "MACur A1",
    }  # fmt: skip
    assert [axis.roles[of].unit for of in ("time", "position")] == ["ms", "deg"]
    assert axis.roles["position"].unit_likelihood > SURE
    assert axis.roles["force"].unit_likelihood < SURE  # of KUKA it may be a share


def test_a_blank_line_above_columns_between_spaces_harms_nothing(tmp_path: Path) -> None:
    """The text was said to be damaged."""
    a = axis_of_a_drive(n=1000)
    header = (
        "Scope 3.2\nSample time:  1.000 ms\n\n  s actual    v actual   I nominal\n     [rad]     [rad/s]         [A]"
    )
    path = rows(tmp_path / "scope.txt", header, a["position"], a["velocity"], a["current"], mark="   ")
    (axis,) = told(path)
    assert next(tables(path)).columns == (Column("s actual", "rad"), Column("v actual", "rad/s"),
                                          Column("I nominal", "A"))  # fmt: skip
    assert [axis.roles[of].unit for of in ("time", "position", "force")] == ["0.001 s", "rad", "A"]


def test_channels_have_the_names_that_lines_above_give_them(tmp_path: Path) -> None:
    """Three questions were open of a log that says all: a count, by the speed in tenths of an rpm, is 1e-5 turns."""
    a = axis_of_a_drive(n=2000)
    header = "Sampling Time: 0.001 s\nCH1: Feedback Position [PUU]\nCH2: Motor Speed [0.1 rpm]\nCH3: Motor Torque [%]"
    counts, tenths = np.rint(a["position"] / (2e-5 * np.pi)), np.rint(a["velocity"] * 300.0 / np.pi)
    path = rows(tmp_path / "scope.txt", f"{header}\n\nTime\tCH1\tCH2\tCH3", a["t"], counts, tenths, a["current"],
                mark="\t")  # fmt: skip
    (axis,) = told(path)
    assert {channel: role.unit for channel, role in axis.roles.items()} == {
        "time": "s", "position": "1e-05 rev", "velocity": "0.1 rpm", "force": "%",
    }  # fmt: skip
    assert all(role.unit_likelihood > SURE for role in axis.roles.values())


def test_the_unit_of_the_horizontal_axis_is_that_of_the_time(tmp_path: Path) -> None:
    """A potentiometer was in seconds: the first of the cells behind a label of units was that of the first channel."""
    a = axis_of_a_drive(n=1000)
    header = "Model,MSO24\nHorizontal Units,S,,\nVertical Units,V,V,A\n\nTIME,CH1,CH2,CH3"
    path = rows(tmp_path / "tek.csv", header, a["t"], a["position"], a["velocity"], a["current"], mark=",")
    assert [column.unit for column in next(tables(path)).columns] == ["s", "V", "V", "A"]


def test_of_a_monitor_of_simplefoc_the_rate_alone_is_asked(tmp_path: Path) -> None:
    """Four questions were open; its target was the velocity."""
    a = axis_of_a_drive(n=2000)
    current = 1e3 * a["current"]
    noise = np.random.default_rng(3).standard_normal((2, 2000))
    path = rows(tmp_path / "monitor.txt", "MOT: Monitor enabled!\nMOT: Ready.", a["speed"], 0.9 * a["current"],
                1e-3 * noise[0], current, 2.0 * noise[1], a["velocity"], a["position"], mark="\t")  # fmt: skip
    (axis,) = told(path)
    assert {of: (role.column, role.unit) for of, role in axis.roles.items() if of not in {"time", "input"}} == {
        "position": (6, "rad"), "velocity": (5, "rad/s"), "force": (3, "mA"),
    }  # fmt: skip
    assert [of for of, role in axis.roles.items() if role.unit_likelihood < SURE or role.likelihood < SURE] in (
        [], ["time"],
    )  # fmt: skip


def test_what_a_robot_program_prints_has_a_nanosecond_that_is_no_force(tmp_path: Path) -> None:
    """The rest of the stamps of ROS was said to be the force, perhaps."""
    a = axis_of_a_drive(n=1500, dt=1e-2)
    stamps = 1_700_000_123.25 + a["t"] + 4e-4 * np.random.default_rng(5).standard_normal(1500)
    path = tmp_path / "joint_states.csv"
    whole, rest = np.floor(stamps), (stamps % 1.0) * 1e9
    beside = zip(a["position"], a["velocity"], a["current"], strict=True)
    lines = [f"{int(s)},{int(n)},,hip,{x:.6f},{v:.5f},{f:.4f}"
             for s, n, (x, v, f) in zip(whole, rest, beside, strict=True)]  # fmt: skip
    path.write_text("\n".join(lines) + "\n")
    assert spoken(next(tables(path)).columns[1]).quantity == "time"
    (axis,) = told(path)
    assert axis.roles["force"].others == {}


def test_what_an_odrive_maps_is_a_position_and_in_turns(tmp_path: Path) -> None:
    """A position under `pos_vel_mapper` was a velocity, and the axis was two."""
    a = axis_of_a_drive(n=2000)
    header = "timestamp (ms);axis0.pos_vel_mapper.pos_rel;axis0.pos_vel_mapper.vel;axis0.motor.foc.Iq_measured"
    path = rows(tmp_path / "log.csv", header, 1e3 * a["t"], a["position"], a["velocity"], a["current"], mark=";")
    (axis,) = told(path)
    assert {channel: role.unit for channel, role in axis.roles.items()} == {
        "time": "ms", "position": "rev", "velocity": "rev/s", "force": "A",
    }  # fmt: skip


def test_feedback_is_of_no_feed() -> None:
    """It was likely that an axis with `Feedback Position` moves along a line."""
    assert spoken(Column("Feedback Position")).moves == {}
    assert spoken(Column("Feed Position")).moves == {"linear": 12.0}


def test_a_header_without_samples_says_what_to_export(tmp_path: Path) -> None:
    """A trace of a robot was said to lack a position and a time."""
    path = tmp_path / "KRCIpo.dat"
    channel = "#BEGINCHANNELHEADER\r\n200,{}\r\n202,{}\r\n210,EXPLIZIT\r\n211,KRCIpo.r64\r\n#ENDCHANNELHEADER\r\n"
    names = [("Istposition_A1", "Grad"), ("Iststrom_A1", "A"), ("Istgeschwindigkeit_A1", "Grad/s")]
    path.write_text("DIAEXTENDED\r\n" + "".join(channel.format(*name) for name in names))
    with pytest.raises(FricError, match=r"KRCIpo\.dat: .*samples are in KRCIpo\.r64: export"):
        fric.auto(path, output=tmp_path / "found", assume=True)


def test_a_count_of_rows_is_no_position(tmp_path: Path) -> None:
    """A table that pandas wrote, with a force and no motion: its index was the position, in mm, without a question."""
    rng = np.random.default_rng(3)
    stamps = 0.1 + np.cumsum(1.2e-3 + 3e-5 * rng.standard_normal(400))
    stamps[0] = 1e-3  # the first row is a while before the others
    force = 0.1 + 0.1 * np.sin(8.0 * stamps) + 0.01 * rng.standard_normal(400)
    path = rows(tmp_path / "force.csv", ",Time [s],Fz [N]", np.arange(400.0), stamps, force, mark=",")
    with pytest.raises(FricError, match=NO_POSITION):
        fric.auto(path, output=tmp_path / "found")


@pytest.mark.parametrize("beside", [False, True])
def test_a_log_without_a_force_is_refused_whatever_else_is_open(tmp_path: Path, beside: bool) -> None:
    """The unit of its position was asked first, and the answer led to the message that it has no force."""
    a = axis_of_a_drive(n=2000)
    (tmp_path / "logs").mkdir()
    stuck = np.where(a["t"] < 1.0, -9.0, -18.0)
    rows(tmp_path / "logs" / "a.csv", "time,position,velocity", a["t"], np.rad2deg(a["position"]), stuck, mark=",")
    if beside:
        rows(tmp_path / "logs" / "b.csv", "samples.position,samples.kp", a["position"], a["speed"], mark=",")
    with pytest.raises(FricError, match=NO_FORCE) as refused:
        fric.auto(tmp_path / "logs", output=tmp_path / "found")
    assert not refused.value.form
    assert "--propose" in refused.value.hint


def test_traces_of_two_axes_without_a_force_are_still_asked_about(tmp_path: Path) -> None:
    """They may be a circle."""
    t = np.arange(4000) * 1e-3
    both = [30.0 * f(2.0 * np.pi * 0.5 * t) + 0.001 * np.sin(40.0 * t) for f in (np.cos, np.sin)]
    path = rows(tmp_path / "log.csv", "time,x pos,y pos", t, *both, mark=",")
    found = find_sources([path], (), tmp_path / "made")
    assert NO_FORCE not in found.refused
    assert [path.name for guess in found.open.found for path in guess.files] == ["log.csv"] * 2


def test_a_velocity_that_is_noise_is_no_motion(tmp_path: Path) -> None:
    """Of a motor that was held against a load cell there were three axes, and four questions."""
    rng = np.random.default_rng(4)
    t, step = np.arange(800) * 3e-3, np.pi / 180
    speed = np.round(3.0 * rng.standard_normal(800)) * step
    position = 0.134 + 4e-4 * rng.integers(0, 6, 800)
    current, torque = 2500.0 + 30.0 * rng.standard_normal(800), -2.5 + 0.03 * rng.standard_normal(800)
    header = "timestamp,m:motor_position,m:motor_velocity,m:joint_velocity,m:motor_current,torque"
    path = rows(tmp_path / "log.csv", header, t, position, speed, speed / 9.0, current, torque, mark=",")
    with pytest.raises(FricError, match=AT_REST) as refused:
        fric.auto(path, output=tmp_path / "found")
    assert not refused.value.form


def test_a_slow_motion_in_the_noise_of_its_velocity_is_one(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    noisy = a["speed"] + 1.5 * np.abs(a["speed"]).max() * np.random.default_rng(5).standard_normal(len(a["t"]))
    (axis,) = told(rows(tmp_path / "log.csv", "time,velocity,current", a["t"], noisy, a["current"], mark=","))
    assert axis.roles["velocity"].column == 1


@pytest.mark.parametrize("duty", [255.0, -100.0])
def test_a_duty_is_the_voltage_that_it_makes(tmp_path: Path, duty: float) -> None:
    """The duty was the force, in counts, and the voltage beside it the input."""
    a = axis_of_a_drive()
    volts = 9.0 * a["current"] / np.abs(a["current"]).max()
    header = "Tiempo (s),PWM,Voltaje (V),Velocidad (rad/s)"
    path = rows(tmp_path / "log.csv", header, a["t"], np.round(duty / 9.0 * volts, 3), volts, a["velocity"], mark=",")
    (axis,) = told(path)
    assert {channel: (role.column, role.unit) for channel, role in axis.roles.items()} == {
        "time": (0, "s"), "velocity": (3, "rad/s"), "input": (2, "V"),
    }  # fmt: skip
    assert axis.roles["input"].others == {}


@pytest.mark.parametrize(("size", "unit"), [(np.pi / 30, "rad/s"), (np.pi / 15, "rad/s"), (0.1, None)])
def test_a_speed_in_steps_of_whole_rpm_is_in_radians(tmp_path: Path, size: float, unit: str | None) -> None:
    """An interface gives whole rpm, and who logged it took rad/s: that was not even among the answers."""
    a = axis_of_a_drive()
    speed = np.round(250.0 * a["speed"] / size) * size
    (axis,) = told(rows(tmp_path / "log.csv", "Time,Torque,Velocity", a["t"], a["current"], speed, mark=","))
    found = axis.roles["velocity"]
    assert found.unit_likelihood < SURE
    assert (found.unit == "rad/s") is (unit == "rad/s")


def test_names_and_units_in_lines_of_comment(tmp_path: Path) -> None:
    """The units were the names, and the clock, in counts of a rate, was in ms."""
    a = axis_of_a_drive(n=2000)
    header = "%Steps at 8kHz\n%Date:,02/04/2021\n%timestep,voltage,position,velocity\n%[#],[V],[rad],[rad/s]"
    columns = np.round(8000.0 * a["t"]), 3.0 * a["current"], a["position"], np.gradient(a["position"], a["t"])
    path = rows(tmp_path / "log.csv", header, *columns, mark=",")
    assert next(tables(path)).columns == (
        Column("timestep"), Column("voltage", "V"), Column("position", "rad"), Column("velocity", "rad/s"),
    )  # fmt: skip
    (axis,) = told(path)
    assert axis.roles["time"].unit_likelihood < SURE


def test_a_clock_in_a_unit_that_is_none_is_asked_about(tmp_path: Path) -> None:
    """Counts at 8 kHz, named `timestep (8Hz)`, were milliseconds without a word."""
    a = axis_of_a_drive(n=2000)
    path = rows(
        tmp_path / "log.csv",
        "timestep (8Hz),position,current",
        40.0 * np.arange(2000),
        a["position"],
        a["current"],
        mark=",",
    )
    (axis,) = told(path)
    assert axis.roles["time"].unit_likelihood < SURE


@pytest.mark.parametrize("text", ["interval(ms),2", "interval [ms],2", "time: 2 ms"])
def test_a_sampling_line_is_the_period(tmp_path: Path, text: str) -> None:
    """Its unit in round brackets was asked for."""
    a = axis_of_a_drive(n=2000, dt=2e-3)
    path = rows(tmp_path / "log.csv", f"Sampling {text}\nposition,current", a["position"], a["current"], mark=",")
    (axis,) = told(path)
    assert (axis.roles["time"].unit, axis.roles["time"].unit_likelihood) == ("0.002 s", 0.97)


def test_a_measured_position_in_a_unit_of_another_quantity_is_asked_about(tmp_path: Path) -> None:
    """It was passed over, and the commanded position was taken as the position, unasked."""
    t = np.arange(0.0, 4.0, 1e-3)
    r = 20.0 * np.sin(2 * np.pi * 0.5 * t)
    z = 20.0 * np.sin(2 * np.pi * 0.5 * (t - 4e-3)) + np.random.default_rng(0).normal(0, 1e-3, len(t))
    current = 2.0 * np.sign(np.gradient(z)) + 0.02 * np.random.default_rng(1).normal(size=len(t))
    header = "Time [ms],Commanded Position X [mm],Actual Position X [kg],Current X [A]"
    np.savetxt(tmp_path / "log.csv", np.column_stack([1e3 * t, r, z, current]), "%.6f", ",", header=header, comments="")
    with pytest.raises(FricError, match="logged in kg"):
        fric.ingest(tmp_path / "log.csv", output=tmp_path / "log.h5")


def test_a_column_that_other_files_of_the_axis_show_is_taken_over(tmp_path: Path) -> None:
    """Beside the excitation that it adds, a response did not say which column is the input: the observer had none."""
    rng, t, free = np.random.default_rng(4), np.arange(6000) / 1000.0, "Zeit [s];Ist [mm];Kraft [N];Stellgröße [V]"
    files = {}
    for name, v in (("hin.csv", 0.02), ("her.csv", -0.02), ("frf.csv", 0.0)):
        excited = rng.normal(0.0, 0.3, len(t)) if not v else np.zeros(len(t))
        z = 1e3 * (v * t + 2e-4 * np.cumsum(excited) / 1000.0)
        force = 60.0 * np.sign(v) + 80.0 * excited + rng.normal(0.0, 0.5, len(t))
        columns = [t, z, force, (force + rng.normal(0.0, 0.2, len(t))) / 120.0, excited]
        head = free + ("" if v else ";Zusatzsignal [V]")
        files[name] = tmp_path / name
        rows = np.column_stack(columns[: 4 + (not v)])
        np.savetxt(files[name], rows, delimiter=";", header=head, comments="", fmt="%.6f", encoding="utf-8")
    with ExitStack() as opened:
        found = {guess.files[0].name: guess for guess in guesses([*files.values()], opened)}
    role = found["frf.csv"].axis.roles["input"]
    assert found["frf.csv"].table.columns[role.column] == Column("Stellgröße", "V")
    assert role.why == "as in hin.csv"


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_controller_that_answers_each_count_is_no_force_that_counts_the_other_way(sign: float) -> None:
    """A sine of 1.5 µm before sliding "opposes the motion": its controller's answer to counts did all the work."""
    rng, t = np.random.default_rng(5), np.arange(30000) * 1e-3
    z = np.rint((1.5e-6 * np.sin(2 * np.pi * t / 8.0) + 6e-8 * rng.normal(size=len(t))) / 1e-7) * 1e-7
    damped = -2e5 * np.gradient(z, 1e-3)  # the velocity controller works against what it sees
    elastic = 40e6 * 1.5e-6 * np.sin(2 * np.pi * t / 8.0 + 0.02)
    (signs := Signs()).add({"time": t, "position": z, "force": elastic + damped})
    assert signs.work[0] < -0.5 * signs.work[1]
    assert signs.against() == ""
    stroke = 5e-3 * t + 1e-7 * rng.normal(size=len(t))
    force = sign * 40.0 - 2e4 * (np.gradient(stroke, 1e-3) - 5e-3)
    (signs := Signs()).add({"time": t, "position": stroke, "force": force})
    assert signs.against() == ("" if sign > 0 else "force")
