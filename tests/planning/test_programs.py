"""Programs of a plan, read back by interpreters that know nothing of fric: no dialect leaves the limits."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache
from math import isclose
from pathlib import Path

import blark
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fric.documents.machine_files import read_machine
from fric.errors import FricError
from fric.export.motion import DIALECTS, Arc, Move
from fric.planning.choose import choose
from fric.results.plan import PlanResult
from fric.simulate.experiment import Limits, Plan
from fric.units import readable
from tests.export.structured_text import Program
from tests.linuxcnc.bench import Program as Bench
from tests.linuxcnc.bench import Recording, run_program
from tests.planning.gcode import Control

DWELL = {"linuxcnc": "P", "fanuc": "X", "siemens": "F"}
SLACK = 1e-6
"""Of feed and acceleration: positions are rounded, to 0.1 µm where a control takes no more."""


@cache
def axis(machine: str = "xy-table"):
    return read_machine(Path(machine)).axis("x")


def plan_of(limits: Limits, machine: str = "xy-table") -> PlanResult:
    planned = choose(axis(machine), limits)
    return PlanResult(Plan(axis(machine), limits, planned, [1.0] * len(planned), {}), None, "", ())


LIMITS = st.builds(
    Limits, st.floats(5e-3, 2.0), st.floats(5e-3, 1.0), st.floats(0.1, 20.0)
)  # fmt: skip


def checked(path, limits: Limits, rounding: float) -> None:
    """Hold a path [s], [mm] against the limits; a place is rounded by so much [mm]."""
    t, places = np.array([row[0] for row in path]), np.array([row[1] for row in path])
    assert np.abs(places).max() <= 1e3 * limits.stroke / 2
    dt = np.diff(t)
    assert (dt > 0).all()
    v = np.diff(places, axis=0) / dt[:, None]
    least = dt.min()
    assert np.linalg.norm(v, axis=1).max() <= 1e3 * limits.feed * (1 + SLACK) + rounding / least
    # a piece that is long is even: its change of speed is made in the short one beside it
    a = np.linalg.norm(np.diff(v, axis=0), axis=1) / np.minimum(dt[1:], dt[:-1])
    assert a.max() <= 1e3 * limits.acceleration * (1 + 1e-3) + 2 * rounding / least**2


@settings(max_examples=2, deadline=None)
@example(limits=Limits(0.3, 0.1, 5.0), machine="xy-table")
@example(limits=Limits(0.01, 0.5, 0.2), machine="virtual-rig")
@given(limits=LIMITS, machine=st.sampled_from(["xy-table", "virtual-rig"]))
def test_no_motion_and_no_dialect_leaves_stroke_speed_or_acceleration(limits: Limits, machine: str) -> None:
    try:
        plan = plan_of(limits, machine)
    except FricError:
        return  # the limits leave no room; the examples have room
    for one in plan.moves:
        if isinstance(one, Arc):
            assert 2 * one.radius < limits.stroke
            assert one.feed**2 / one.radius < limits.acceleration
        else:
            m = one.reference
            assert np.ptp(m.position) < limits.stroke
            assert np.abs(m.velocity).max() < limits.feed
            assert np.abs(m.acceleration).max() < limits.acceleration
        for name in DWELL:
            read_back(name, one, limits)


def read_back(name: str, one: Move | Arc, limits: Limits) -> None:
    """Run a dialect's program, and hold it against the limits and the motion that it is of."""
    dialect, rounding = DIALECTS[name], 1e-4 if name == "fanuc" else 1e-6
    (text,) = (dialect.arc(one) if isinstance(one, Arc) else dialect.move(one)).values()
    control = Control("XY" if isinstance(one, Arc) else "X").run(text, DWELL[name])
    assert control.ended
    assert max(control.feeds) <= 1e3 * limits.feed * (1 + SLACK) + rounding / 8e-3
    if isinstance(one, Arc):
        places = np.array([place for _, place in control.path[1:]])
        assert np.allclose(np.hypot(*places.T), 1e3 * one.radius, atol=2e-4)
        assert np.abs(places).max() <= 1e3 * limits.stroke / 2
        return
    begun = control.path[1][0]  # the approach is a move of its own
    path = [(t - begun, place) for t, place in control.path[1:]]
    checked(path, limits, rounding)
    m = one.reference
    assert isclose(path[-1][0], m.time[-1], rel_tol=1e-4)
    middle = 0.5 * (m.position.max() + m.position.min())
    asked = 1e3 * (np.interp([t for t, _ in path], m.time, m.position) - middle)
    off = np.abs(asked - [x for _, (x,) in path]).max()
    assert off < rounding + 1e3 * 2e-4 * limits.feed  # by time lost to rounding, feed for feed


def test_a_program_that_leaves_the_stroke_is_seen() -> None:
    limits = Limits(0.3, 0.1, 5.0)
    one = plan_of(limits).moves[14]
    (text,) = DIALECTS["linuxcnc"].move(one).values()
    control = Control("X").run(text, "P")
    with pytest.raises(AssertionError):
        checked(control.path[1:], replace(limits, stroke=1e-4), 1e-6)
    faster = re.sub(r"F(\d)", r"F9\1", text)
    with pytest.raises(AssertionError):
        checked(Control("X").run(faster, "P").path[1:], limits, 1e-6)


def test_tables_in_structured_text_run_through_the_motion() -> None:
    limits = Limits(0.1, 0.05, 1.0)
    for one in plan_of(limits).moves:
        if isinstance(one, Arc) or one.name not in {"constant-velocity-12", "presliding-sine-01", "sliding-sine"}:
            continue
        (text,) = DIALECTS["table"].move(one).values()
        block, m = _table(text), one.reference
        middle = 0.5 * (m.position.max() + m.position.min())
        instants = np.linspace(0.0, m.time[-1], 400)
        z, v, a = np.array([block(t)[:3] for t in instants]).T / 1e3
        assert np.abs(z - np.interp(instants, m.time, m.position - middle)).max() < 0.1e-6
        assert np.abs(z).max() < limits.stroke / 2
        assert np.abs(v).max() < limits.feed
        assert np.abs(a).max() < limits.acceleration
        assert block(m.time[-1])[3]
        assert not block(0.5 * m.time[-1])[3]


@pytest.mark.long
def test_tables_are_structured_text_by_the_grammar() -> None:
    (text,) = DIALECTS["table"].move(plan_of(Limits(0.1, 0.05, 1.0)).moves[0]).values()
    assert blark.parse_source_code(text).exception is None


def _table(text: str):
    """Return a table's block as a function of time: its loop is turned by hand, the rest by the interpreter."""
    text = re.sub(r"\s*\n\s+\+", " +", text)  # an expression over two lines
    text = re.sub(r":= \[(.*?)\]", lambda m: f":= [{' '.join(m[1].split())}]", text, flags=re.S)
    loop = re.search(r"WHILE (.*?) DO\n(.*?)END_WHILE;\n", text, re.S)
    assert loop is not None
    count = int(re.search(r"n < (\d+)", loop[1])[1])
    text = text.replace(loop[0], f"FOR i := 1 TO {count} DO\nIF {loop[1]} THEN\n{loop[2]}END_IF;\nEND_FOR;\n")
    program = Program(text)
    program.run("")
    call = program.instance()

    def at(t: float):
        found = call(instant=t)
        return found.position, found.velocity, found.acceleration, found.done

    return at


@pytest.mark.skipif(shutil.which("rs274") is None, reason="LinuxCNC's interpreter is not installed")
def test_linuxcnc_reads_its_programs(tmp_path: Path) -> None:
    for one in plan_of(Limits(0.3, 0.1, 5.0)).moves:
        dialect = DIALECTS["linuxcnc"]
        ((name, text),) = (dialect.arc(one) if isinstance(one, Arc) else dialect.move(one)).items()
        (tmp_path / name).write_text(text)
        done = subprocess.run(["rs274", "-g", name], cwd=tmp_path, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr
        assert "error" not in done.stderr.lower()
        feeds = [tuple(map(float, m.groups())) for m in re.finditer(r"STRAIGHT_FEED\((\S+), (\S+), ", done.stdout)]
        arcs = done.stdout.count("ARC_FEED")
        assert (arcs == 6) if isinstance(one, Arc) else (len(feeds) >= 10 and max(abs(x) for x, _ in feeds) < 150), (
            name, len(feeds), arcs,
        )  # fmt: skip
        assert "PROGRAM_END" in done.stdout


@pytest.mark.long
@pytest.mark.skipif(
    not (shutil.which("linuxcnc") and shutil.which("halcompile") and os.geteuid() == 0),
    reason="LinuxCNC is not installed, or this is not root",
)
def test_linuxcnc_runs_its_programs_inside_the_limits(tmp_path: Path) -> None:
    """Its planner, from the first block to the last, two at a time: neither touches the other's components.

    On a busy computer blocks come late, and the motion waits.
    """
    limits, machine = Limits(0.3, 0.1, 5.0), read_machine(Path("xy-table"))
    moves = [one for one in plan_of(limits).moves if one.name in {"constant-velocity-15", "sliding-sine"}]

    def run(one: Move) -> Recording:
        (text,) = DIALECTS["linuxcnc"].move(one).values()
        bench = Bench(text, limits.feed, limits.acceleration, 0.5 * limits.stroke)
        return run_program(machine, bench, tmp_path / one.name)

    with ThreadPoolExecutor(len(moves)) as pool:
        records = list(pool.map(run, moves))
    for one, found in zip(moves, records, strict=True):
        z, v, a = (found.channel(channel, 0) for channel in ("reference", "velocity", "acceleration"))
        middle = 0.5 * (one.reference.position.max() + one.reference.position.min())
        assert z.max() == pytest.approx(one.reference.position.max() - middle, abs=1e-8)
        assert z.min() == pytest.approx(one.reference.position.min() - middle, abs=1e-8)
        assert np.abs(v).max() <= limits.feed * (1 + SLACK)
        assert np.abs(v).max() == pytest.approx(max(np.abs(one.reference.velocity).max(), one.approach), rel=5e-3)
        # where blocks meet it may take both
        assert np.quantile(np.abs(a), 0.9999) <= limits.acceleration * (1 + 1e-3)
        reached = found.channel("position", 0)
        assert np.abs(reached - z).max() < 1e-3


@pytest.mark.parametrize("limits", [Limits(0.3, 0.1, 5.0), Limits(0.5, 0.01, 1.0)])
def test_the_begin_of_a_motion_is_approached_in_a_time_that_is_printed(limits: Limits) -> None:
    """A sine of micrometres begins at micrometres a second, and was approached so from the end of the stroke."""
    plan = plan_of(limits)
    for one in plan.moves:
        dialect = DIALECTS["linuxcnc"]
        (text,) = (dialect.arc(one) if isinstance(one, Arc) else dialect.move(one)).values()
        feed = float(re.search(r"G94 (?:G17 )?G1 X\S+ (?:Y\S+ )?F(\S+)", text)[1]) / 60
        assert 1e3 * limits.stroke / feed <= max(20.1, 2.01 * limits.stroke / limits.feed)
        assert feed <= 1e3 * limits.feed
    motion = sum(plan.plan.lasting)
    assert 0 < plan.approaching < len(plan.moves) * limits.stroke / limits.approach
    assert f"{readable(motion + plan.approaching, 's')} in all, with approaches at" in str(plan)
