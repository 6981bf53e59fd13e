"""A plant that is integrated to an accuracy, against the same to the last digits."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import ks_2samp

from fric.control.scheme import NONE, PAPER_SCHEMES
from fric.documents.machine_files import read_machine
from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.kernels.loop import closed_loop
from fric.kernels.plant import TOLERANCE, velocity_tolerance
from fric.kernels.signatures import compiled_step
from fric.reference import sine
from fric.simulate.axis import _loop_arguments, run_axis
from fric.simulate.contour_run import Circle, run_circle
from fric.simulate.machine import Machine
from fric.simulate.processes import ACCURACY, Study
from tests.friction.instances import INSTANCES

MACHINE = read_machine(Path("configs/xy-table.yaml"))
CIRCLE = Circle(0.005, 0.05, 1)
REVERSALS = sine(1e-3, 2.9, 1, 4000.0, run_in=0.5)


def ideal(machine: Machine) -> Machine:
    return replace(machine, axes={name: replace(axis, encoder=Encoder()) for name, axis in machine.axes.items()})


def pushed(machine: Machine) -> Machine:
    """The same machine but for a force of a tenth of a millinewton, which moves it by some picometres."""
    return replace(machine, axes={name: replace(axis, load=1e-4) for name, axis in machine.axes.items()})


def glitches(machines: list[Machine], schemes: str, accuracy: float) -> NDArray[np.float64]:
    return np.array(
        [
            [run_circle(machine, PAPER_SCHEMES[name], CIRCLE, accuracy=accuracy).circularity.glitch for name in schemes]
            for machine in machines
        ]
    )


def drawn(number: int) -> list[Machine]:
    study = Study(MACHINE, (NONE,), seed=11)
    return [study.drawn(index)[0] for index in range(number)]


def test_without_encoder_no_glitch_differs_by_more_than_the_accuracy() -> None:
    machines = [ideal(machine) for machine in drawn(10)]
    exact = glitches(machines, "abcdef", 0.0)
    change = [np.abs(glitches(machines, "abcdef", accuracy) - exact) for accuracy in (ACCURACY, 50 * ACCURACY)]
    assert exact.min() > 100 * ACCURACY
    assert change[0].max() <= ACCURACY
    assert change[1].max() <= 50 * ACCURACY
    assert change[0].mean() < change[1].mean()  # it is an accuracy: asked for less, it gives less


def test_with_an_encoder_glitches_differ_as_much_as_by_a_tenth_of_a_millinewton_and_are_the_same_in_the_mean() -> None:
    """A count that falls otherwise leads the loop another way, whether by a force or by an accuracy."""
    machines = drawn(25)
    exact = glitches(machines, "af", 0.0)
    by_force = glitches([pushed(machine) for machine in machines], "af", 0.0) - exact
    change = glitches(machines, "af", ACCURACY) - exact
    assert np.median(np.abs(by_force)) > 1e-9
    assert ks_2samp(np.abs(change).ravel(), np.abs(by_force).ravel()).pvalue > 1e-3
    assert abs(change.mean()) < ACCURACY + 3 * change.std() / np.sqrt(change.size)


@pytest.mark.parametrize("name", INSTANCES)
def test_no_position_differs_by_more_than_the_accuracy_whatever_the_friction(name: str) -> None:
    axis = replace(ideal(MACHINE).axis("x"), friction=INSTANCES[name])
    exact, quick = (run_axis(axis, REVERSALS, accuracy=accuracy) for accuracy in (0.0, ACCURACY))
    assert 0 < np.abs(exact.position - quick.position).max() <= ACCURACY


@compiled_step
def counting(dz: float, v: float, dt: float, state: NDArray[np.float64], parameters: NDArray[np.float64]) -> float:
    """Friction with memory, smooth; it counts how often it is asked."""
    parameters[0] += 1.0
    state[0] += 1e8 * dz * (1.0 - state[0] / 100.0 * (1.0 if dz > 0.0 else -1.0))
    return state[0]


def test_an_accuracy_asks_friction_less_than_a_third_as_often() -> None:
    axis = ideal(MACHINE).axis("x")
    asked = []
    for accuracy in (0.0, ACCURACY):
        calls = np.zeros(1)
        others = _loop_arguments(axis, REVERSALS, NONE, np.zeros(len(REVERSALS)), accuracy=accuracy)[3:]
        closed_loop(counting, np.zeros(1), calls, *others)
        asked.append(calls[0] / len(REVERSALS))
    assert asked[0] > 3 * asked[1]


def test_a_velocity_tolerance_is_what_pushes_a_loop_aside_by_the_accuracy() -> None:
    """A velocity that gains an error in each half sample, under P-P control: it settles where the accuracy says."""
    K_v, K_pB, T_s, accuracy = 126.0, 379.0, 0.25e-3, 5e-9
    error = velocity_tolerance(accuracy, K_v * K_pB, T_s)
    z = v = 0.0
    for _ in range(4000):
        for _ in range(2):
            v += 0.5 * T_s * K_pB * (-K_v * z - v) + error
            z += 0.5 * T_s * v
    assert z == pytest.approx(accuracy, rel=1e-2)
    assert velocity_tolerance(0.0, K_v * K_pB, T_s) == TOLERANCE


def test_an_accuracy_below_zero_is_told() -> None:
    with pytest.raises(FricError, match="accuracy"):
        Study(MACHINE, (NONE,), accuracy=-1e-9)
