"""Table 2 of the paper, and the figures of the reading notes, on configs/xy-table.yaml."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from fric.control.scheme import PAPER_SCHEMES
from fric.documents.machine_files import read_machine
from fric.drive.sensing import Encoder
from fric.simulate.contour_run import Circle, run_circle

CALIBRATED = read_machine(Path("configs/xy-table.yaml"))
MACHINES = {"calibrated": CALIBRATED, "matched": read_machine(Path("configs/xy-table.yaml"), gain=1.0)}


@cache
def of_one(machine: str, feed: float, name: str, **changes: int) -> np.ndarray:
    run = run_circle(MACHINES[machine], PAPER_SCHEMES[name], replace(Circle(), feed=feed, **changes))
    return 1e6 * np.array([one.median for one in run.glitches])


def quadrants(machine: str, feed: float, schemes: str = "abcdef", **changes: int) -> dict[str, np.ndarray]:
    """Return the four signed glitches in µm by scheme."""
    return {name: of_one(machine, feed, name, **changes) for name in schemes}


@pytest.fixture(scope="module")
def fast() -> dict[str, np.ndarray]:
    return quadrants("calibrated", 0.1)


@pytest.mark.parametrize(("scheme", "paper"), {"a": 22, "b": 7, "c": 6, "d": 8, "e": 5, "f": 3}.items())
def test_every_quadrant_of_table_2_within_a_micron(fast: dict[str, np.ndarray], scheme: str, paper: float) -> None:
    assert np.abs(fast[scheme] - paper).max() < 1.0


def test_the_order_of_the_six_schemes_is_that_of_the_paper(fast: dict[str, np.ndarray]) -> None:
    size = {name: np.abs(found).max() for name, found in fast.items()}
    assert sorted(size, key=lambda name: size[name]) == ["f", "e", "c", "b", "d", "a"]


def test_the_paper_s_reduction_of_86_per_cent(fast: dict[str, np.ndarray]) -> None:
    assert 1 - np.abs(fast["f"]).max() / np.abs(fast["a"]).max() == pytest.approx(0.86, abs=0.04)


@pytest.mark.parametrize(
    ("machine", "feed", "expected"),
    [
        ("matched", 0.1, {"a": 21.9, "b": -9.1, "c": 1.0, "d": 8.5, "e": -7.2, "f": 0.8}),
        ("calibrated", 0.1, {"a": 21.9, "b": 7.4, "c": 6.0, "d": 8.5, "e": 4.5, "f": 2.5}),
        ("matched", 0.01, {"c": 0.2}),
        pytest.param("matched", 0.01, {"b": -16.6, "d": 3.3, "e": -10.4, "f": 0.2}, marks=pytest.mark.long(3)),
        ("calibrated", 0.01, {"a": 13.1, "f": 1.4}),
        pytest.param("calibrated", 0.01, {"b": -8.4, "c": 4.1, "d": 3.3, "e": 6.0}, marks=pytest.mark.long(4)),
    ],
    ids=[
        "matched fast",
        "calibrated fast",
        "matched slow",
        "matched slow, others",
        "calibrated slow",
        "calibrated slow, others",
    ],
)
def test_the_table_of_the_reading_notes(machine: str, feed: float, expected: dict[str, float]) -> None:
    found = quadrants(machine, feed, "".join(expected))
    for name, value in expected.items():
        # below a micron the sign is that of the encoder's last step
        compared = np.abs(found[name]) if abs(value) < 0.5 else found[name]
        assert np.abs(compared - value).max() < 0.5, name


def test_gms_feedforward_leaves_less_than_half_of_static_feedforward_at_10_mm_s() -> None:
    found = {name: np.abs(values).max() for name, values in quadrants("matched", 0.01, "bcef").items()}
    assert found["c"] < 0.5 * found["b"]
    assert found["f"] < 0.5 * found["e"]


def test_halving_the_plant_step_moves_no_glitch() -> None:
    """0.02 µm is asked for. With the encoder on nothing less will do than that every count falls where it fell."""
    for scheme in PAPER_SCHEMES.values():
        usual, halved, quarter = (run_circle(CALIBRATED, scheme, halvings=n) for n in (0, 1, 2))
        for finer in (halved, quarter):
            for name, trace in usual.traces.items():
                np.testing.assert_array_equal(trace.measured, finer.traces[name].measured)
            change = np.subtract(usual.circularity.quadrants, finer.circularity.quadrants)
            assert np.abs(change).max() < 1e-10


def test_halving_the_plant_step_moves_no_glitch_at_10_mm_s_without_an_encoder() -> None:
    axes = {name: replace(axis, encoder=Encoder()) for name, axis in CALIBRATED.axes.items()}
    smooth, slow = replace(CALIBRATED, axes=axes), replace(Circle(), feed=0.01)
    for name in "af":
        usual, halved = (
            np.array(run_circle(smooth, PAPER_SCHEMES[name], slow, halvings=n, only="x").circularity.quadrants)
            for n in (0, 1)
        )
        assert np.abs(usual - halved).max() < 1e-10


def test_at_10_mm_s_the_encoder_s_rounding_scatters_a_glitch_by_about_one_of_its_steps() -> None:
    """There s(v) falls with v faster than the controller brakes, for a third of a second after each reversal: what the
    last digit of a position decides grows to whole counts. The machine does not repeat better, nor does a simulation.
    """
    slow = replace(Circle(), feed=0.01)
    found = [run_circle(CALIBRATED, PAPER_SCHEMES["a"], slow, halvings=n, places=1, only="x") for n in (0, 1, 2)]
    assert 0.01e-6 < np.ptp([run.circularity.quadrants for run in found], axis=0).max() < 0.75e-6


def test_turning_the_other_way_leaves_the_same_glitches() -> None:
    ccw, cw = (quadrants("calibrated", 0.1, direction=direction) for direction in (1, -1))
    for name in PAPER_SCHEMES:
        np.testing.assert_allclose(cw[name], ccw[name], atol=0.3)


def test_one_axis_alone_leaves_the_glitches_of_its_own_reversals() -> None:
    both = np.array(run_circle(CALIBRATED, PAPER_SCHEMES["a"]).circularity.quadrants)
    alone = np.array(run_circle(CALIBRATED, PAPER_SCHEMES["a"], only="x").circularity.quadrants)
    np.testing.assert_allclose(alone[[0, 2]], both[[0, 2]], atol=0.8e-6)  # the median moves
    assert np.abs(alone[[1, 3]]).max() < 1.5e-6
