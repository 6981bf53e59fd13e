"""What a scheme may name, and how it is written and read."""

import json
from pathlib import Path

import numpy as np
import pytest

import fric
from fric.control.scheme import PAPER_SCHEMES, Scheme
from fric.documents.machine_files import read_machine
from fric.documents.schemes import read_schemes
from fric.errors import FricError
from fric.io.circle import read_runs, write_runs
from fric.kernels.block import Sample
from fric.results.given_models import schemes_of
from fric.simulate.axis import blocks_of, setting_of
from fric.simulate.contour_run import Circle, run_circle
from tests.control.blocks import AXIS, MOTION

HEAD = "fric: schemes/1\nschemes:\n"


def test_old_files_and_new_ones_give_the_same_scheme(tmp_path: Path) -> None:
    file = tmp_path / "schemes.yaml"
    file.write_text(HEAD + "  d: {title: observer, observer: true}\n  e: {title: observer, blocks: [inverse-model]}\n")
    old, new = read_schemes(file).values()
    assert (old.blocks, old.observer, old.bare) == (new.blocks, True, False)
    assert old == PAPER_SCHEMES["d"]
    assert Scheme.of(old.plain()) == old


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("{blocks: [nothing]}", "there is no control block 'nothing'"),
        ("{blocks: [sliding-mode]}", "Write it as controller: sliding-mode"),
        ("{controller: kalman}", "Name it among the blocks"),
        ("{blocks: [kalman, two-dof, adaptive, inverse-model]}", "room for 3"),
        ("{blocks: [kalman], peak_sensitivity: 6 V}", "Write it as '6 dB'"),
    ],
)
def test_a_scheme_that_no_loop_runs_is_refused(tmp_path: Path, text: str, told: str) -> None:
    file = tmp_path / "schemes.yaml"
    file.write_text(HEAD + f"  s: {text}\n")
    with pytest.raises(FricError, match=told):
        read_schemes(file)


def test_the_machine_s_file_gives_a_block_its_parameters_and_margins_give_the_rest(tmp_path: Path) -> None:
    text = Path("configs/xy-table.yaml").read_text()
    (tmp_path / "two.yaml").write_text("fric: block/1\naxis: x\nblock: two-dof\nparameters: {cutoff: 0.02 kHz}\n")
    file, scheme = tmp_path / "machine.yaml", Scheme("s", "", blocks=("kalman", "two-dof"))
    given = "    blocks: {kalman: {cutoff: 25 Hz}, two-dof: two.yaml}\n    encoder:\n"
    file.write_text(text.replace("    encoder:\n", given, 1))
    axis = read_machine(file).axis("x")
    _, kalman, two = blocks_of(axis, scheme, setting_of(axis, scheme, MOTION))
    assert (vars(kalman), vars(two)) == ({"cutoff": 25.0}, {"cutoff": 20.0})
    slow, fast = (
        blocks_of(AXIS, one, setting_of(AXIS, one, MOTION))[1]
        for one in (Scheme("s", "", blocks=("kalman",)), Scheme("f", "", blocks=("kalman",), peak_sensitivity=2.8))
    )
    assert 55.0 < vars(slow)["cutoff"] < 70.0
    assert vars(fast)["cutoff"] == 300.0
    for wrong, told in (
        ("{kalman: {cutoff: 25 s}}", "frequency"),
        ("{kalman: {cutof: 25 Hz}}", "cutof"),
        ("{kalman: two.yaml}", "is the block 'two-dof'"),
        ("{kalman: {cutoff: -1 Hz}}", "lies between 1 and 300"),
    ):
        file.write_text(text.replace("    encoder:\n", f"    blocks: {wrong}\n    encoder:\n", 1))
        with pytest.raises(FricError, match=told):
            read_machine(file)


def test_a_run_file_keeps_the_scheme(tmp_path: Path) -> None:
    machine = read_machine(Path("configs/xy-table.yaml"))
    scheme = Scheme("s", "both", friction="gms", lead="auto", blocks=("two-dof",), gain=0.9)
    run = run_circle(machine, scheme, Circle(0.01, 0.1, 1), accuracy=1e-8)
    write_runs(tmp_path / "run.h5", [run])
    assert read_runs(tmp_path / "run.h5")[0].scheme == scheme


def test_a_block_that_is_not_linear_is_said_not_to_be_judged() -> None:
    machine = read_machine(Path("configs/xy-table.yaml"))
    told = run_circle(machine, Scheme("s", "", controller="sliding-mode"), Circle(0.01, 0.1, 1), accuracy=1e-8).warnings
    assert [(one.code, one.severity) for one in told] == [("not-linear", "note")]  # type: ignore[attr-defined]
    quiet = run_circle(machine, Scheme("s", "", blocks=("reversal-pulse",)), Circle(0.01, 0.1, 1), accuracy=1e-8)
    assert quiet.warnings == ()


def test_what_adapts_stays_within_what_was_identified(tmp_path):
    """Level by the intervals of F_c and F_s, stiffness by those of each k; a run leaves neither."""
    (tmp_path / "plant.yaml").write_text(
        "fric: plant/1\naxis: x\nmotion: linear\nA: 28.57 1/s\nB: 4.526 m/(s^2*V)\nT_d: 0.65 ms\nK_f: 548 N/V\n"
    )
    k = "{value: [90, 1], unit: N/µm, ci95: [[60, 100], [0.9, 1.3]]}"
    (tmp_path / "friction.yaml").write_text(
        "fric: friction/1\naxis: x\nmotion: linear\n"
        "static:\n  F_c: {value: 105, unit: N, ci95: [100, 120]}\n  F_s: {value: 165, unit: N, ci95: [150, 170]}\n"
        "  v_s: 1 mm/s\n"
        f"gms:\n  alpha: {{value: [0.7, 0.3], unit: '1'}}\n  k: {k}\n  C: 1e4 N/s\n"
    )
    found = fric.design_block("adaptive", tmp_path / "plant.yaml", friction=tmp_path / "friction.yaml").design.block
    assert (found.lowest, found.highest) == pytest.approx((150 / 165, 120 / 105))
    assert (found.softest, found.stiffest) == pytest.approx((6 / 9, 1.3))
    level = state_over_time(found)
    assert level.min() >= found.lowest
    assert level.max() <= found.highest


def state_over_time(block):
    """Return the level of an adaptive feedforward whose observer always asks for more, then always for less."""
    setting = setting_of(AXIS, Scheme("s", ""), MOTION)
    state, parameters = block.initial_state(setting), block.packed(setting)
    rows, level = np.zeros((len(MOTION), 8)), []
    for n in range(len(MOTION)):
        sample = Sample(**dict.fromkeys(Sample._fields, 0.0) | {"estimate": -5.0 if n < len(MOTION) // 2 else 5.0})
        type(block).step(sample, n, rows, state, parameters)
        level.append(state[0])
    return np.array(level)


@pytest.mark.parametrize("name", ["", ".", "...", "a/b", "x\n", "\ud800", "monte_carlo", "x" * 41])
def test_a_name_that_no_group_of_a_run_file_can_have_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(FricError, match="not a name of a scheme"):
        Scheme(name, "")
    assert Scheme("a", "of \x1b[31m\nred").title.isprintable()
    file = tmp_path / "schemes.yaml"
    file.write_text(f"{HEAD}  {json.dumps(name)}: {{title: t}}\n")
    with pytest.raises(FricError):
        read_schemes(file)


def test_two_schemes_have_two_names_and_one_asked_for_twice_runs_once() -> None:
    assert [scheme.name for scheme in schemes_of("a,c,a")] == ["a", "c"]
    with pytest.raises(FricError, match="two schemes have the name 'a'"):
        schemes_of([Scheme("a", ""), Scheme("a", "", friction="gms")])
