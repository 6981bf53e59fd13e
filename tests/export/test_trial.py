"""Exported compensation in a real LinuxCNC."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import numpy as np
import pytest

import fric
from fric.control.scheme import PAPER_SCHEMES
from fric.documents.machine_files import read_machine
from fric.errors import FricError
from fric.results.export import TriedCircle
from tests.export.parts import MACHINE
from tests.linuxcnc.bench import Program, read_session, read_trace, run_program
from tests.linuxcnc.trial import try_in_linuxcnc

IDENTIFIED = MACHINE.with_name("xy-table-identified.yaml")

needs_linuxcnc = pytest.mark.skipif(
    not (shutil.which("linuxcnc") and shutil.which("halcompile") and os.geteuid() == 0),
    reason="LinuxCNC is not installed, or this is not root",
)


@pytest.mark.parametrize(("lost", "rows"), [(1, "0 1\n1 1\n"), (0, "0 1\n2 1\n"), (0, "")])
@pytest.mark.filterwarnings("ignore:loadtxt")
def test_a_record_that_lost_rows_is_an_error(lost: int, rows: str, tmp_path: Path) -> None:
    (tmp_path / "trace.txt").write_text(rows)
    with pytest.raises(FricError, match="lost rows"):
        read_trace(tmp_path / "trace.txt", lost)


@pytest.mark.parametrize(
    ("printed", "told"),
    [
        ("task: main loop took 5 s\nUSRMOT: ERROR: command timeout\nShutting down", "broke the program off: USRMOT"),
        ("session: TimeoutError: no power", "did not finish: session: TimeoutError: no power"),
        ("", ""),
    ],
)
def test_a_program_that_was_broken_off_is_an_error_and_no_shorter_record(
    printed: str, told: str, tmp_path: Path
) -> None:
    """LinuxCNC is idle behind a command that its servo thread did not take in time, as behind the program's end."""
    (tmp_path / "trace.txt").write_text("0 1\n1 1\n")
    if "session" not in printed:
        (tmp_path / "lost.txt").write_text("0\n")
    if not told:
        assert len(read_session(tmp_path, printed)) == 2
        return
    with pytest.raises(FricError, match=told):
        read_session(tmp_path, printed)
    assert (tmp_path / "log.txt").read_text() == printed


@pytest.fixture(scope="module")
def trials(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[TriedCircle], list[TriedCircle], Path]:
    machine = read_machine(IDENTIFIED)
    folders = [tmp_path_factory.mktemp("linuxcnc") for _ in range(2)]
    slow = try_in_linuxcnc(machine, PAPER_SCHEMES["f"], folders[0])
    fast = try_in_linuxcnc(machine, PAPER_SCHEMES["f"], folders[1], feeds=(0.1,))
    return slow, fast, folders[1]


@needs_linuxcnc
@pytest.mark.long
def test_each_quadrant_is_as_simulated_and_the_feedforward_takes_off_what_it_should(
    trials: tuple[list[TriedCircle], list[TriedCircle], Path],
) -> None:
    for arc in trials[0]:
        assert arc.difference < 0.5e-6, (arc.scheme.title, arc.feed, arc.direction)
    for feed in (0.1, 0.01):
        left = {a.scheme.name: a.measured.glitch for a in trials[0] if a.feed == feed and a.direction == 1}
        assert max(left["feedforward"], left["f"]) < 0.2 * left["none"], feed


@needs_linuxcnc
@pytest.mark.long
def test_two_runs_are_equal_byte_by_byte(
    trials: tuple[list[TriedCircle], list[TriedCircle], Path], tmp_path: Path
) -> None:
    try_in_linuxcnc(read_machine(IDENTIFIED), PAPER_SCHEMES["f"], tmp_path, feeds=(0.1,))
    for session in ("session-none", "session-feedforward", "session-f"):
        first, second = ((folder / session / "trace.txt").read_bytes() for folder in (trials[2], tmp_path))
        assert first == second


@needs_linuxcnc
@pytest.mark.long
def test_exact_belief_with_lead_takes_off_97_percent_at_100_mm_s(tmp_path: Path) -> None:
    machine = read_machine(IDENTIFIED, lead="auto")
    arcs = try_in_linuxcnc(machine, PAPER_SCHEMES["c"], tmp_path, feeds=(0.1,))
    left = {a.scheme.name: a.measured.glitch for a in arcs if a.direction == 1}
    assert left["c"] < 0.03 * left["none"]
    assert max(arc.difference for arc in arcs) < 0.5e-6


def test_a_trial_without_linuxcnc_says_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FricError, match="apt-get install linuxcnc-uspace"):
        try_in_linuxcnc(read_machine(MACHINE), PAPER_SCHEMES["c"], tmp_path)
    assert not any(tmp_path.iterdir())


def test_a_trial_finds_its_bench_in_a_checkout_and_says_where_it_is_elsewhere(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def export() -> None:
        fric.export_axis("linuxcnc", MACHINE, axis="x", scheme="c", trial=tmp_path / "trial", force=True)

    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FricError, match="a trial needs linuxcnc"):  # so the bench was there
        export()
    monkeypatch.setattr(fric, "__file__", str(tmp_path / "site-packages" / "fric" / "__init__.py"))
    with pytest.raises(FricError, match="test bench that is not part of the installed package"):
        export()


def test_a_machine_whose_friction_has_risen_is_what_its_page_says() -> None:
    machine = read_machine(MACHINE.parent / "risen/machine.yaml")
    old = read_machine(MACHINE)
    for name in ("x", "y"):
        then, now = old.axis(name).friction, machine.axis(name).friction
        assert np.isclose(now.steady_state(0.0 + 1e-9) / then.steady_state(1e-9), 1.25, rtol=2e-3)
        assert machine.axis(name).nominal_friction.models["gms"].steady_state(0.1) == then.steady_state(0.1)


@needs_linuxcnc
@pytest.mark.long
def test_a_program_of_strokes_is_run_and_recorded_from_its_first_motion_on(tmp_path: Path) -> None:
    text = "G21 G90 G64\nG1 X10 F600\nG4 P0.1\nG1 X0 F300\nM2\n"
    machine = read_machine(MACHINE)
    found = run_program(machine, Program(text, speed=0.1, acceleration=5.0, travel=0.05), tmp_path)
    speed = found.channel("velocity", 0)
    assert speed.max() == pytest.approx(0.01)
    assert speed.min() == pytest.approx(-0.005)
    assert np.abs(found.channel("reference", 0)[-1]) < 1e-9
    steady = np.abs(speed - 0.01) < 1e-9
    axis = machine.axis("x")
    force = axis.plant.K_f * found.channel("input", 0)[steady]
    drag = axis.plant.K_f * axis.plant.A / axis.plant.B * 0.01  # of the drive itself
    assert np.mean(force[len(force) // 2 :]) == pytest.approx(axis.friction.steady_state(0.01) + drag, rel=0.01)
    with pytest.raises(FricError, match="LinuxCNC did not finish"):
        run_program(machine, Program("G1 X100 F600\nM2\n", 0.1, 5.0, travel=0.05), tmp_path / "beyond")
