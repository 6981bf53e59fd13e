"""What every control block must be, whatever it does; a new block is tested here unasked."""

from dataclasses import fields
from importlib import import_module

import numpy as np
import pytest

from fric.control import block_type, blocks
from fric.control.base import ROLES
from fric.control.probe import probed
from fric.kernels.block import Sample
from tests.control.blocks import INPUTS, ROWS, SETTING, Running, along, every_block, no_commands

NAMES = list(blocks())
LINEAR = [name for name in NAMES if blocks()[name].linear]


def noise(samples: int, seed: int = 1) -> np.ndarray:
    """Return samples as a loop might have them: micrometres about the start, and volts."""
    rng = np.random.default_rng(seed)
    size = dict.fromkeys(Sample._fields, 1.0) | {"reference": 1e-5, "measured": 1e-5, "velocity": 1e-3, "excess": 0.0}
    given = rng.normal(size=(samples, INPUTS)) * np.array([size[name] for name in Sample._fields])
    given[0, [Sample._fields.index(name) for name in ("input", "control", "estimate")]] = 0.0
    return given


def started(given: np.ndarray) -> np.ndarray:
    moved = given.copy()
    for name in ("reference", "measured"):
        moved[:, Sample._fields.index(name)] += SETTING.position
    return moved


@pytest.mark.parametrize("name", NAMES)
def test_a_block_says_what_it_is(name: str) -> None:
    kind = blocks()[name]
    assert block_type(name) is kind
    assert import_module(f"fric.control.{name.replace('-', '_')}").__doc__, (
        "the file has the block's name and its equations"
    )
    assert kind.kind in ROLES
    assert kind.asks
    assert {one.name for one in kind.parameters} <= {field.name for field in fields(kind)}
    for one in kind.parameters:
        assert one.doc
        assert one.lower < one.upper
        assert np.isnan(one.typical) or one.lower <= one.typical <= one.upper
    assert not kind.tuned or kind.tuned in {one.name for one in kind.parameters}


@pytest.mark.parametrize("name", NAMES)
def test_it_is_silent_at_rest(name: str) -> None:
    """An axis that waits where it begins: no error, no voltage, nothing to compensate."""
    block = every_block()[name]
    waiting = np.zeros(INPUTS)
    waiting[[Sample._fields.index("reference"), Sample._fields.index("measured")]] = SETTING.seen
    rows = no_commands(200)
    rows[[0, 5]] = SETTING.seen
    running = Running(block, rows=rows)
    given = np.array([running(waiting, n) for n in range(200)])
    # the inverse-model observer starts at the position itself, half an encoder step off what it is told
    allowed = 1e-9 if name not in {"inverse-model"} else 0.05
    if name == "adaptive":  # goes along the reference that it was packed for, which starts smoothly from rest
        allowed = 1e-2 * float(np.abs(ROWS[4]).max())
        given = given[:3]
    assert np.abs(given[-3:]).max() <= allowed


@pytest.mark.parametrize("name", NAMES)
def test_all_that_it_remembers_is_in_its_state(name: str) -> None:
    """The same samples give the same volts, also beside another run; a state that is handed on goes on."""
    block, given = every_block()[name], started(noise(300))
    once = along(block, given)
    np.testing.assert_array_equal(along(block, given), once)
    first, second, between = Running(block), Running(block), []
    kept = first.parameters.copy()
    other = started(noise(300, seed=2))
    for n in range(300):
        between.append(first(given[n], n))
        second(other[n], n)
    np.testing.assert_array_equal(between, once)
    np.testing.assert_array_equal(first.parameters, kept)
    handed = Running(block)
    for n in range(150):
        handed(given[n], n)
    fresh = Running(block)
    fresh.state = handed.state.copy()
    np.testing.assert_array_equal([fresh(given[n], n) for n in range(150, 300)], once[150:])
    assert np.all(np.isfinite(once))


def from_nothing(name: str, given: np.ndarray) -> np.ndarray:
    running = Running(every_block()[name], rows=no_commands(len(given)))
    running.state[:] = 0.0
    return np.array([running(one, n) for n, one in enumerate(given)])


@pytest.mark.parametrize("name", LINEAR)
def test_a_linear_block_adds_up(name: str) -> None:
    samples = 9500 if name == "repetitive" else 400  # it says nothing before one period and its run-in are over
    one, two = noise(samples, 3), noise(samples, 4)
    both = from_nothing(name, 2.0 * one - 0.5 * two)
    apart = 2.0 * from_nothing(name, one) - 0.5 * from_nothing(name, two)
    assert np.abs(both).max() > 0.0
    np.testing.assert_allclose(both, apart, atol=1e-9 * np.abs(both).max())


@pytest.mark.parametrize("name", [name for name in LINEAR if name != "repetitive"])
def test_its_matrices_are_the_step(name: str) -> None:
    """What probing finds, run as a state space, gives what the step gives."""
    found, given = probed(every_block()[name], SETTING), noise(400, 5)
    x, volts = np.zeros(len(found.C)), []
    for one in given:
        volts.append(found.C @ x + found.D @ one)
        x = found.A @ x + found.B @ one
    stepped = from_nothing(name, given)
    np.testing.assert_allclose(volts, stepped, atol=1e-9 * np.abs(stepped).max())
    f = np.array([3.0, 50.0, 700.0])
    z = np.exp(2j * np.pi * f / 4000.0)
    for inputs in (("measured",), ("input", "control"), ("reference", "measured")):
        B, D = found.columns(inputs)
        exact = [found.C @ np.linalg.solve(one * np.eye(len(x)) - found.A, B) + D for one in z]
        np.testing.assert_allclose(found.response(inputs, f, 4000.0), exact, rtol=1e-8, atol=1e-12)
