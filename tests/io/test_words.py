"""Words of column names in the languages and programs of those who write headers."""

import pytest

from fric.io.readers.base import Column
from fric.io.words import axis_of, spoken, tags

NAMES = """
current -: current.q; q_current; Motorstrom; I_motor; motor_current; MotorCurrent_A; corriente motor
current -: corrente motore; stroom; prąd; proud; 电流; ток; akım
current commanded: CurCmd; I nominal; I (N) NOML; Commanded Current (Q axis); IL.CMD; iq_ref; Iq_setpoint
current measured: CurFbk; CurrentFeedback; ICTRL_ISQ_ACT; Actual Current (Q axis); Current actual value averaged
current measured: IL.FB; Stromistwert iq; iq_meas
duty -: pwm
error -: PE; PosErr; _TEA; s diff; ERRC; PosDiff; Position Error; PL.ERR; Schleppfehler; following_error
error -: lag_error; contour_error; tracking error
force -: Drehmoment; motor_torque; joint_torque_1; tau_J; load_torque; effort; couple moteur; koppel
force -: moment; 转矩; 力矩; момент; torque
force commanded: TCMD; Torque Reference; Momentensollwert; cmd_torque; tau_cmd; トルク指令
force measured: ActTorque; Torque/force feedback value; Torque actual value; TorqueActual; Momentenistwert
force measured: r80 M_ist; Torque feedback; torque_feedback_Nm; coppia attuale; torque atual
input -: Motor Output; voltage.q; u_ctrl; u; control; motor_voltage
position -: theta; posX; encoder; encoder_count; Joint1 Position; positie; pozycja; poloha; 位置; Положение
position -: konum; posição
position commanded: RPOS; APOS; PosCmd; POSCMD; PositionCommand; _RPA; s nominal; SetPos; PCTRL_S_SET
position commanded: Position command value; Target Position; Commanded Position; Position Demand Value
position commanded: TargetPosition; PL.CMD; Lagesollwert; Sollposition; desired_position; nominalPosition; 位置指令
position commanded: 目标位置; 指令位置
position measured: FPOS; PosFbk; POSFBK; PositionFeedback; _TPA; s actual; POSF; ActPos; Axis1.PosAct; PCTRL_S_ACT
position measured: Position feedback value 1; Current Position; current_position; current pos; Actual Motor Position
position measured: Position Actual Value; ActualPosition; PL.FB; Lageistwert; Istposition; measured_position
position measured: actualPosition; Fpos; pos_actual_mm; フィードバック位置; posición real; position mesurée
position measured: posizione attuale; 实际位置
velocity -: theta_dot; thetadot; x_dot; xdot; vel_x; omega_m; speed_rpm; Spindle speed; feedrate; snelheid
velocity -: prędkość; rychlost; 速度; 转速; скорость; hız; velocidade
velocity commanded: RVEL; VelCmd; v nominal; V (N) NOML; VCMD; SetVelo; Speed Reference; VL.CMD; Drehzahlsollwert
velocity commanded: r62 n_soll; vitesse consigne
velocity measured: FVEL; VelFbk; VelocityFeedback; v actual; ActVelo; SCTRL_SPEED_ACT; Velocity feedback value
velocity measured: current_velocity; currentVelocity; Feedback Speed; Velocity actual value averaged; ActualVelocity
velocity measured: VL.FB; Drehzahlistwert; Istgeschwindigkeit; r63 n_ist; rpm_actual; 速度フィードバック
velocity measured: velocità attuale
"""
"""Quantity, and which of the two is said, with names of servo drives, robots, numeric controls and their users."""
ROWS = [line.partition(": ") for line in NAMES.strip().splitlines()]


@pytest.mark.parametrize(
    ("name", "quantity", "which"), [(name, *key.split()) for key, _, names in ROWS for name in names.split("; ")]
)
def test_a_name_shows_its_quantity_and_whether_it_was_commanded(name: str, quantity: str, which: str) -> None:
    says = spoken(Column(name))
    assert quantity in {says.means, says.quantity}
    assert says.commanded == (which == "commanded")
    assert says.measured or which != "measured"


@pytest.mark.parametrize(
    ("name", "quantity"),
    [
        ("motorpos", None), ("motorvel", None), ("axis act torque", "force"), ("interrupt", None),
        ("control mode", "other"), ("temperature", "other"), ("Current", "current"), ("current time", "time"),
    ],
)  # fmt: skip
def test_what_a_name_contains_by_chance_says_nothing(name: str, quantity: str | None) -> None:
    says = spoken(Column(name))
    assert (says.means or None) == quantity
    assert not says.commanded


@pytest.mark.parametrize(
    ("name", "axis"),
    [
        ("AxisX.ActPos", "x"), ("X actual position", "x"), ("achse_y_soll", None), ("pos.AxisZ", "z"),
        ("axis pos", None), ("AxisError.x1", None), ("x", None),
        ("v+0.20", None), ("data.u", None), ("u actual position", "u"), ("axis v", "v"),  # a speed, a voltage
    ],
)  # fmt: skip
def test_a_letter_or_axis_and_a_letter_name_an_axis(name: str, axis: str | None) -> None:
    assert axis_of(name) == axis


@pytest.mark.parametrize(
    ("header", "quantity", "unit"),
    [
        ("force/N", "force", "N"), ("velocity/mm/s", "velocity", "mm/s"), ("t/s", "time", "s"), ("F/N", "force", "N"),
        ("current/A", "force", "A"), ("elbow/position", "position", None), ("data/V", "velocity", None),
    ],
)  # fmt: skip
def test_a_slash_before_a_unit_of_what_is_named_is_no_path(header: str, quantity: str, unit: str | None) -> None:
    says = spoken(Column(header))
    assert (says.quantity, says.unit) == (quantity, unit)


@pytest.mark.parametrize(("name", "commanded"), [("xref", True), ("ycmd", True), ("zsoll", True), ("xact", False)])
def test_a_letter_of_an_axis_is_joined_to_what_it_is_of(name: str, commanded: bool) -> None:
    """``t, xref, x, F, u`` had two positions or a force more, and no reference."""
    assert spoken(Column(name)).commanded is commanded
    assert tags([Column(name), Column(f"{name[0]}_force"), Column("w_ref"), Column("w_force")])[0] == name[0]
