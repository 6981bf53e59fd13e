from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from fric.control.scheme import PAPER_SCHEMES
from fric.documents.base import Quantity
from fric.documents.machine_files import read_identified, read_machine, read_spreads
from fric.errors import FricError
from fric.simulate.contour_run import Circle, run_circle
from fric.simulate.spread import DEFAULT_SPREADS, draw_machine

MACHINE = Path("configs/xy-table.yaml").resolve()
FRICTION = """fric: friction/1
axis: x
static:
  F_c: {value: 100, unit: N, ci95: [98, 103]}
  F_s: {value: 160, unit: N, ci95: [150, 165]}
  v_s: {value: 1, unit: mm/s, ci95: [0.9, null]}
  sigma: {value: 40, unit: N*s/m}
  offset: {value: 2, unit: N, ci95: [1, 3]}
gms:
  alpha: {value: [0.6, 0.3, 0.1], unit: "1", ci95: [[0.55, 0.65], [0.25, 0.35], [0.08, 0.12]]}
  k: {value: [90, 2, 0.1], unit: N/um, ci95: [[80, 100], [1.5, null], [0.2, 0.3]]}
  C: {value: 1e4, unit: N/s, assumed: true}
"""


@pytest.fixture
def friction(tmp_path: Path) -> str:
    (tmp_path / "x.yaml").write_text(FRICTION)
    return f"x={tmp_path / 'x.yaml'}"


def test_the_spread_file_is_what_is_spread_where_none_is_given():
    assert read_spreads(Path("configs/spread.yaml")) == DEFAULT_SPREADS


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("levels: {factor: {value: [0.7, 1.3], unit: '1'}}", "line 3: spreads.levels: 'levels' is nothing"),
        ("level: {factor: {value: [1.3, 0.7], unit: '1'}}", "line 3: spreads.level: the spread from 1.3 to 0.7 falls"),
        ("level: {factor: {value: 0.3, unit: '1'}}", "a lower and an upper factor"),
        ("level: {factor: {value: [0.7, 1.3], unit: N}}", "ratio cannot be in 'N'"),
        ("level: {distribution: triangular, factor: {value: [0.7, 1.3], unit: '1'}}", "uniform"),
    ],
)
def test_bad_spread_files_are_told_with_their_line(tmp_path, text, told):
    (tmp_path / "spread.yaml").write_text(f"fric: spread/1\nspreads:\n  {text}\n")
    with pytest.raises(FricError, match=told):
        read_spreads(tmp_path / "spread.yaml")


def test_what_was_identified_is_the_centre_and_the_belief(friction):
    found = read_identified(MACHINE, nominal_files=[friction])
    axis, before = found.machine.axes["x"], read_machine(MACHINE).axes["x"]
    assert axis.friction.static.F_c == 100
    assert axis.friction == axis.nominal_friction.models["gms"]
    assert (axis.plant, axis.load) == (before.plant, 2.0)
    assert found.machine.axes["y"] == read_machine(MACHINE).axes["y"]
    names = {"F_c", "F_s", "offset", "alpha_1", "alpha_2", "alpha_3", "k_1"}
    assert set(found.intervals) == {"x"}
    assert set(found.intervals["x"]) == names
    assert found.intervals["x"]["k_1"] == (80e6, 100e6)
    # an open limit, and an interval that does not hold its estimate
    (warning,) = found.warnings
    assert warning.code == "not-drawn"
    assert "axis x: k_2, k_3, v_s" in warning


def test_what_was_not_identified_is_as_the_machine_file_says(tmp_path):
    static = FRICTION[: FRICTION.index("gms:")]
    (tmp_path / "x.yaml").write_text(static)
    axis = read_identified(MACHINE, nominal_files=[f"x={tmp_path / 'x.yaml'}"]).machine.axes["x"]
    assert axis.friction.static.F_c == 100
    assert axis.friction.k == read_machine(MACHINE).axes["x"].friction.k
    assert set(axis.nominal_friction.models) == {"static"}


def test_the_nominal_plant_is_what_was_identified(tmp_path):
    plant = """fric: plant/1
axis: x
A: {value: 30, unit: 1/s, ci95: [28, 33]}
B: {value: 4.5, unit: m/(s^2*V), ci95: [4.4, 4.6]}
T_d: {value: 0.6, unit: ms, ci95: [0.55, 0.65]}
K_f: {value: 548, unit: N/V}
"""
    (tmp_path / "plant.yaml").write_text(plant)
    text = MACHINE.read_text().replace("    controller:", "    nominal: plant.yaml\n    controller:", 1)
    (tmp_path / "machine.yaml").write_text(text)
    found = read_identified(tmp_path / "machine.yaml")
    assert found.machine.axes["x"].plant.B == 4.5
    assert found.intervals["x"] == {"A": (28, 33), "B": (4.4, 4.6), "T_d": pytest.approx((0.55e-3, 0.65e-3))}


SURE = """fric: friction/1
axis: x
static: {F_c: {value: 105, unit: N, ci95: [104, 106]}, F_s: {value: 165, unit: N}, v_s: {value: 1, unit: mm/s}}
"""


def test_a_gain_that_a_log_shows_to_a_third_is_drawn_and_one_that_is_known_is_not(tmp_path):
    """The glitch had the same range whether K_p was known to 1 % or to 30 %: 0.2 µm, for 1.8."""
    (tmp_path / "x.yaml").write_text(SURE)
    ranges = {}
    for share in (0.01, 0.3):
        limits = f"K_p: {{ci95: [{83.7 * (1 - share)}, {83.7 * (1 + share)}], "
        (tmp_path / "machine.yaml").write_text(MACHINE.read_text().replace("K_p: {", limits, 1))
        found = read_identified(tmp_path / "machine.yaml", nominal_files=[f"x={tmp_path / 'x.yaml'}"])
        assert found.gains["x"] == pytest.approx(share)
        assert ("K_p" in found.intervals["x"]) is (share == 0.3)
        machines = [draw_machine(found.machine, n, spreads={}, intervals=found.intervals)[0] for n in range(6)]
        runs = [run_circle(machine, PAPER_SCHEMES["a"], Circle(revolutions=1), only="x") for machine in machines]
        ranges[share] = np.ptp([run.circularity.glitch for run in runs])
    assert found.intervals["x"]["K_p"] == pytest.approx((0.7 * 83.7, 1.3 * 83.7))
    assert ranges[0.3] > 3.0 * ranges[0.01]


def test_a_machine_without_intervals_is_told():
    with pytest.raises(FricError, match="no parameter has a 95 % interval"):
        read_identified(MACHINE)


@pytest.mark.parametrize(
    ("value", "ci95"), [(1.0, [1.0]), (1.0, [[0.0, 2.0]]), ([1.0, 2.0], [0.0, 3.0]), ([1.0, 2.0], [[0.0, 3.0]])]
)
def test_intervals_fit_their_values(value, ci95):
    with pytest.raises(ValidationError, match="ci95 does not fit"):
        Quantity(value=value, unit="N", ci95=ci95)


def test_an_open_limit_is_infinite():
    given = Quantity(value=[1.0, 2.0], unit="mm", ci95=[[None, 2.0], [1.0, None]]).si("position", "linear")
    assert given.ci95 == ((float("-inf"), 2e-3), (1e-3, float("inf")))
    assert given.as_dict()["ci95"] == [[None, 2e-3], [1e-3, None]]
