"""Time in exported programs: a compensation looks ahead by the lead, and a machine is late by the delay of eq. (1)."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fric.documents.machine_files import read_machine
from fric.export.base import machine_of
from fric.export.st import st_files
from fric.friction.maxwell_slip import MaxwellSlip
from fric.friction.stribeck import StaticMap
from tests.export.parts import MACHINE, SAMPLING, InC, part
from tests.export.structured_text import Program

needs_compiler = pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler is installed")
T_s = 1 / SAMPLING
LEADS = (0.0, 0.4 * T_s, 0.65e-3, 4e-3)
STIFFNESS = 1e6
SPRING = MaxwellSlip(W=(1e5,), k=(STIFFNESS,))
"""A contact that never slips here: its force shows the position that it is asked at."""
REST = 0.2


def position(t: float, acceleration: float) -> float:
    """From rest at `REST` [m] with a constant acceleration from t = 0 on."""
    return REST + acceleration / 2 * t**2


def start(acceleration: float) -> list[dict[str, float]]:
    """What the controller is given of that motion: a sample at rest, then 40 samples of constant acceleration."""
    times = np.arange(40) * T_s
    moving = [
        {"position": position(t, acceleration), "velocity": acceleration * t, "acceleration": acceleration}
        for t in times
    ]
    return [{"position": REST, "velocity": 0.0, "acceleration": 0.0}, *moving]


def in_c(lead: float, acceleration: float, folder: Path) -> list[float]:
    made = InC(part(SPRING, lead=lead), folder)
    made.reset()
    return [made.step(**one) for one in start(acceleration)]


def in_structured_text(lead: float, acceleration: float, folder: Path) -> list[float]:
    (text,) = st_files(part(SPRING, lead=lead)).values()
    block = Program(str(text)).instance()
    return [block(**one).volts for one in start(acceleration)]


@pytest.mark.parametrize("lead", LEADS)
@pytest.mark.parametrize("acceleration", [2.0, -3.0])
@pytest.mark.parametrize("volts_in", [pytest.param(in_c, marks=needs_compiler), in_structured_text])
def test_friction_and_velocity_are_those_of_the_motion_a_lead_later(volts_in, lead, acceleration, tmp_path) -> None:
    """From rest, so that the first step of a constant acceleration shows ``lead²/2``, which later steps do not."""
    axis = part(SPRING, lead=lead)
    later = np.arange(40) * T_s + lead
    friction = axis.gain * STIFFNESS * (position(later, acceleration) - REST) / axis.K_f
    model = (acceleration + axis.A * acceleration * later) / axis.B
    volts = np.array(volts_in(lead, acceleration, tmp_path))
    assert np.abs(volts).max() < axis.limit
    np.testing.assert_allclose(volts, np.append(0.0, friction + model), atol=1e-11)


@needs_compiler
@pytest.mark.parametrize("T_d", [T_s / 2, 0.65e-3, 1e-3])
def test_an_exported_machine_answers_a_sine_with_the_phase_of_eq_1(T_d: float, tmp_path: Path) -> None:
    """The voltage is held for a sample: this is half a sample of T_d, and the machine holds the rest.

    The delay is right to 1 % of a sample; T_d and the lead of the feedforward are half a sample and more off.
    """
    machine = read_machine(MACHINE)
    axis = machine.axis("x")
    free = replace(
        axis, plant=replace(axis.plant, T_d=T_d), friction=StaticMap(F_c=0.0, F_s=0.0, v_s=1.0),
        encoder=replace(axis.encoder, resolution=0.0),
        nominal_friction=replace(axis.nominal_friction, lead=T_d + T_s),
    )  # fmt: skip
    made = InC(machine_of(replace(machine, axes={"x": free}), "x"), tmp_path)
    frequency, periods = 50.0, 20
    time = np.arange(round((1 + periods / frequency) * SAMPLING)) * T_s
    volts = np.sin(2 * np.pi * frequency * time)
    position = np.append(0.0, made.positions(volts)[:-1])  # at the times of the voltages
    steady = time > 1.0 - T_s / 2  # A = 28.57 1/s: what is left of the start is e^-28
    wave = np.exp(-2j * np.pi * frequency * time[steady])
    measured = (position[steady] @ wave) / (volts[steady] @ wave)
    late = -np.angle(measured / free.plant.response(np.array([frequency]))[0]) / (2 * np.pi * frequency)
    assert abs(late) < 0.01 * T_s
