"""Scheduled gains: the loop along any reference is stable, a load is no friction, and nothing grows."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from pathlib import Path

import control
import numpy as np
import pytest

from fric.control.gain_scheduled import (
    BEFORE,
    FILTERED,
    HANDED,
    INTEGRAL,
    PENDING,
    SEEN,
    GainScheduled,
)
from fric.control.scheme import Scheme
from fric.design.blocks import design_block
from fric.design.loop import SampledLoop
from fric.documents.machine_files import read_machine
from fric.drive.plant import SampledPlant
from fric.friction.gms import GMS
from fric.simulate.axis import setting_of
from fric.simulate.contour_run import Circle, run_circle
from fric.simulate.machine import Axis
from tests.control.blocks import AXIS, MOTION, Running, no_commands

MACHINE = read_machine(Path("configs/xy-table.yaml"))
SCHEME = Scheme("s", "", friction="gms", controller="gain-scheduled")
LINEAR = [SEEN, FILTERED, INTEGRAL, PENDING, BEFORE, HANDED]
"""What of the state goes by the measured position; the rest by the reference alone."""


def multipliers(block: GainScheduled, amplitude: float, frequency: float) -> np.ndarray:
    """Return the Floquet multipliers of the loop of block and plant (1), no friction, along a sine of the reference."""
    setting = setting_of(AXIS, SCHEME, MOTION)
    plant = SampledPlant.of(AXIS.plant, setting.sampling)
    samples = round(setting.sampling / frequency)
    angle = 2 * pi * np.arange(samples) / samples
    reference, velocity = -amplitude * np.cos(angle), 2 * pi * frequency * amplitude * np.sin(angle)

    def period(x: np.ndarray, running: Running) -> np.ndarray:
        """Return motion and voltages on their way a period later; the block goes on with its own state."""
        for n, (r, v) in enumerate(zip(reference, velocity, strict=True)):
            # plus where the reference is: the drive of the plant's own equation, about the reference
            u = running(np.array([r, v, 0.0, r + x[0], 0.0, 0.0, 0.0, 0.0]), n)
            inputs = np.append(u, x[2:])
            motion = plant.Phi @ x[:2] + plant.early * inputs[plant.whole] + plant.late * inputs[plant.whole + 1]
            x = np.concatenate([motion, inputs[:-1]])
        return x

    running, x = Running(block, setting, no_commands(samples)), np.zeros(3 + plant.whole)
    for _ in range(2):
        x = period(x, running)
    start, state = x, running.state.copy()
    ended = period(start, running)
    after, size = running.state.copy(), len(start) + len(LINEAR)
    columns = np.empty((size, size))
    for i in range(size):
        step = np.eye(size)[i]
        running.state[:] = state
        running.state[LINEAR] += step[len(start) :]
        moved = period(start + step[: len(start)], running)
        columns[:, i] = np.concatenate([moved - ended, running.state[LINEAR] - after[LINEAR]])
    return np.abs(np.linalg.eigvals(columns))


@pytest.mark.parametrize(("amplitude", "frequency"), [(3e-4, 50.0), (1e-2, 8.0)])
def test_the_loop_is_stable_along_strokes_as_fast_as_the_drive_can(amplitude: float, frequency: float) -> None:
    """What the integral is handed over feeds back from stroke to stroke: where these are slow it dies out at once."""
    block = design_block(GainScheduled, setting_of(AXIS, SCHEME, MOTION)).block
    assert AXIS.plant.B * AXIS.cascade.limit > 0.65 * amplitude * (2 * pi * frequency) ** 2
    found = multipliers(block, amplitude, frequency)
    assert found.max() < 0.7
    slow = multipliers(block, amplitude, frequency / 5)
    assert slow.max() < 0.1


def test_multipliers_tell_a_loop_that_is_not_stable() -> None:
    """Strokes that end before the blocks slip keep the full gains: then they may not be larger than the drive bears."""
    designed = design_block(GainScheduled, setting_of(AXIS, SCHEME, MOTION)).block
    assert isinstance(designed, GainScheduled)
    for factor, stable in ((1.0, True), (4.0, True), (12.0, False)):
        found = multipliers(replace(designed, proportional=factor * designed.proportional), 1e-6, 20.0)
        assert found.max() < 1.0 + 1e-9 if stable else found.max() > 1.01  # 1: a memory that short strokes leave alone


SMALL = {"radius": 1e-3, "feed": 0.0182}
"""A circle whose axes reverse with 0.33 m/s², as on one of 30 mm at 100 mm/s."""


def left(axis: Axis, revolutions: int = 3, carried: float | None = None) -> np.ndarray:
    """Return the glitches of the last revolution with one axis simulated, at its reversals [m]."""
    if carried is not None:
        axis = replace(axis, blocks={"gain-scheduled": {"carried": carried}})
    machine = replace(MACHINE, axes={**MACHINE.axes, "x": axis})
    found = run_circle(machine, SCHEME, Circle(**SMALL, revolutions=revolutions), only="x").circularity  # type: ignore[arg-type]
    return np.array(found.quadrants)[[0, 2]]


def test_the_load_stays_and_the_friction_changes_its_sign() -> None:
    """What the machine's friction has beyond what is fed forward is 45 N: a reset would let 60 N of load go with it."""
    free, loaded = (left(replace(AXIS, load=load)) for load in (0.0, 60.0))
    assert np.abs(free - loaded).max() < 0.15e-6
    assert np.abs(free).max() < 1.2e-6
    assert np.abs(left(AXIS, carried=0.0)).min() > 1.5 * np.abs(free).max()


def test_nothing_grows_where_the_drive_is_late_and_stiff() -> None:
    """The corner of configs/spread.yaml where the loop, frozen on the spring of the friction, is not stable."""
    true = AXIS.friction
    assert isinstance(true, GMS)
    static = replace(true.static, F_c=1.3 * true.static.F_c, F_s=1.3 * true.static.F_s)
    stiff = replace(true, static=static, k=tuple(2.0 * k for k in true.k))
    late = replace(AXIS, friction=stiff, plant=replace(AXIS.plant, T_d=1.2 * AXIS.plant.T_d), nominal=AXIS.plant)
    early, later = (np.abs(left(late, revolutions=n)).max() for n in (3, 9))
    assert later < early + 0.1e-6
    assert later < 3e-6


def test_around_rest_the_full_gains_keep_6_dB_by_python_control() -> None:
    setting = setting_of(AXIS, SCHEME, MOTION)
    block = design_block(GainScheduled, setting).block
    assert isinstance(block, GainScheduled)
    cascade, f = AXIS.cascade, np.geomspace(1.0, 1990.0, 800)
    T, z = cascade.T_s, np.exp(2j * pi * f * cascade.T_s)
    K_p, K_i = cascade.K_p * (1 + block.proportional), cascade.K_i * (1 + block.integral)
    pole = np.exp(-2 * pi * cascade.velocity_filter * T)
    PI = control.tf([K_p + K_i * T, -K_p], [1, -1], T)
    D = control.tf([(1 - pole) / T, -(1 - pole) / T], [1, -pole], T)
    loop = SampledLoop(AXIS.plant, cascade, (), block, setting)
    L = loop.G(f) * PI(z) * (D(z) + cascade.K_v)
    np.testing.assert_allclose(loop.input(f), L, rtol=1e-6)
    assert 5.9 < 20 * np.log10(np.abs(1 / (1 + L)).max()) <= 6.0
