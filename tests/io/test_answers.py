"""What answers, and mappings, do for folders as they are: papers beside logs, two axes in a file, counts, clocks."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import fric
from fric.automatic.sources import find_sources
from fric.io.questions import Question
from fric.io.readers.base import Column
from fric.io.words import spoken
from tests.io.test_roles import axis_of_a_drive, write


def answers(asked: list[str], **of: str) -> Callable[[Question], None]:
    """Return what answers a question by a word in it, and the first choice elsewhere."""

    def ask(question: Question) -> None:
        asked.append(question.text)
        assert question.take(next((answer for word, answer in of.items() if word in question.text), ""))

    return ask


def test_a_paper_beside_logs_is_skipped_once_questions_were_answered(tmp_path: Path) -> None:
    """The mapping that answers leave made it an error: "there are no rows of numbers", and no second run."""
    a = axis_of_a_drive()
    (logs := tmp_path / "logs").mkdir()
    write(logs / "log.csv", "Zeit [s];Winkel;Kraft", a["t"], a["position"], a["current"])
    (logs / "README.txt").write_text("Strokes of an axis.\nNothing else.\n")
    asked = list[str]()
    first = find_sources([logs], (), tmp_path / "made", ask=answers(asked))
    assert asked
    assert (logs / "fric-mapping.yaml").is_file()
    again = find_sources([logs], (), tmp_path / "made")
    assert [source.path for source in again.logs] == [source.path for source in first.logs] == [logs / "log.csv"]
    assert not again.refused


TWO = """fric: mapping/1
parts:
  - {axis: x, motion: linear/V, columns: {time: {period: 1 ms}, position: {column: a, unit: mm}, force: {column: u, unit: V}}}
  - {axis: y, motion: linear/V, columns: {time: {period: 1 ms}, position: {column: b, unit: mm}, force: {column: w, unit: V}}}
"""  # noqa: E501


def test_all_axes_that_a_given_mapping_has_of_a_file_are_read(tmp_path: Path) -> None:
    """Of two parts that fit one file the first was read, without a word of the other."""
    t = np.arange(6000) * 1e-3
    x, y = 9.0 * np.cos(2 * t), 9.0 * np.sin(2 * t)
    force = [np.tanh(np.gradient(of)) + 0.01 * np.gradient(of) for of in (x, y)]
    path = write(tmp_path / "circle.csv", "a;u;b;w", x, force[0], y, force[1])
    (tmp_path / "map.yaml").write_text(TWO)
    found = find_sources([path], [str(tmp_path / "map.yaml")], tmp_path / "made")
    assert found.traces == {path: str(tmp_path / "map.yaml")}
    assert not found.logs  # a circle identifies no friction that it judges
    (tmp_path / "map.yaml").write_text(TWO.replace("unit: V}}}", "unit: N}}}", 1).replace("linear/V", "linear", 1))
    done = fric.ingest(path, output=tmp_path / "x.h5", mapping=tmp_path / "map.yaml")
    assert [(notice.code, notice.values["axes"]) for notice in done.warnings] == [("axes-left-out", ["y"])]
    other = fric.ingest(path, output=tmp_path / "y.h5", mapping=tmp_path / "map.yaml", axis="y")
    assert not other.warnings
    np.testing.assert_allclose(fric.read(tmp_path / "y.h5").records[0].position, 1e-3 * y, atol=1e-8)


def test_all_axes_of_earlier_answers_are_read_again(tmp_path: Path) -> None:
    """Of seven axes whose units had been answered a second run of `auto` read the first, without a word."""
    a = axis_of_a_drive()
    of_x, of_y = ((size * a["position"], a["current"]) for size in (1e3, 5e2))
    path = write(tmp_path / "log.csv", "a;u;b;w", *of_x, *of_y)
    (tmp_path / "fric-mapping.yaml").write_text(TWO)
    found = find_sources([path], (), tmp_path / "made")
    assert [source.axis for source in found.logs] == ["x", "y"]


def test_a_part_of_a_mapping_that_cannot_be_read_is_told_beside_one_that_can(tmp_path: Path) -> None:
    a = axis_of_a_drive()
    path = write(tmp_path / "log.csv", "a;u;b;w", a["position"], a["current"], a["position"], np.nan * a["t"])
    (tmp_path / "map.yaml").write_text(TWO)
    found = find_sources([path], [str(tmp_path / "map.yaml")], tmp_path / "made")
    assert [source.axis for source in found.logs] == ["x"]
    assert "file-left-out" in [notice.code for notice in found.description]


@pytest.mark.parametrize("unit", [" [r/min]", ""])
def test_counts_of_a_turn_leave_a_velocity_its_unit_or_have_the_rate_asked(tmp_path: Path, unit: str) -> None:
    """It ended in "velocity cannot be in ''": by the velocity of the header the period is 1 ms."""
    a = axis_of_a_drive()
    counts, rpm = np.rint(a["position"] * 2**22 / (2 * np.pi)), np.round(a["velocity"] * 30 / np.pi, 1)
    path = write(tmp_path / "trace.csv", f"No.;Motor speed{unit};Torque [%];Feedback position [pulse]",
                 np.arange(len(counts)), rpm, np.round(20 * a["current"], 1), counts)  # fmt: skip
    asked = list[str]()
    fric.ingest(path, output=tmp_path / "log.h5", ask=answers(asked, counts=str(2**22), rate="1 kHz"))
    assert len(asked) == (1 if unit else 2)
    (log,) = fric.read(tmp_path / "log.h5").records
    np.testing.assert_allclose(np.diff(log.time), 1e-3)
    np.testing.assert_allclose(log.position, a["position"], atol=1e-6)
    if unit:
        np.testing.assert_allclose(log.velocity, a["velocity"], atol=6e-3)


def test_a_field_t_of_a_structure_is_the_time() -> None:
    """A file of MATLAB 7.3 whose columns are all known had an open question that nothing asked."""
    assert spoken(Column("data(1).t")).quantity == "time"
    assert spoken(Column("data(1).tau_Nm")).quantity == "force"
    assert [spoken(Column(f"log.sig.{name}")).quantity for name in "Fu"] == ["force", "input"]  # u was left out


@pytest.mark.parametrize("answer", ["1", "2"])
def test_a_column_that_rises_evenly_without_a_name_of_a_time_is_asked_about(tmp_path: Path, answer: str) -> None:
    a = axis_of_a_drive()
    path = write(tmp_path / "log.csv", "position [rad];velocity [rad/s];current [A];zeta", a["position"], a["velocity"],
                 a["current"], a["t"])  # fmt: skip
    asked = list[str]()
    fric.ingest(path, output=tmp_path / "log.h5", ask=answers(asked, rate="2 kHz", column=answer))
    assert "Which column is the time" in asked[0]
    assert len(asked) == int(answer)
    (log,) = fric.read(tmp_path / "log.h5").records
    np.testing.assert_allclose(np.diff(log.time), 1e-3 if answer == "1" else 5e-4)


def test_a_period_that_the_motion_shows_and_that_is_not_sure_is_asked(tmp_path: Path) -> None:
    """It stood in the mapping as "? ms", and was not asked."""
    a = axis_of_a_drive(dt=3.1e-3)
    moved = np.degrees(a["position"]), np.degrees(a["velocity"])
    path = write(tmp_path / "log.csv", "pos [deg];vel [deg/s];current [A]", *moved, a["current"])
    asked = list[str]()
    fric.ingest(path, output=tmp_path / "log.h5", ask=answers(asked))
    assert ["At which rate" in text for text in asked] == [True]
    (log,) = fric.read(tmp_path / "log.h5").records
    np.testing.assert_allclose(np.diff(log.time), 3.1e-3, rtol=1e-3)


@pytest.mark.parametrize("position", [True, False])
def test_pole_pairs_are_asked_where_a_speed_counts_electrical_turns(tmp_path: Path, *, position: bool) -> None:
    """A VESC's log was refused: a mapping had to say what a turn of its erpm is."""
    a, pairs = axis_of_a_drive(n=3000), 7
    counted = [np.floor(42 * 40.0 * a["position"])] * position  # of 40 turns a metre
    erpm = np.rint(pairs * 60.0 * 40.0 * a["velocity"])
    header = ["ms", *["tachometer"] * position, "erpm", "current_motor"]
    path = write(tmp_path / "log.csv", ";".join(header), a["t"] * 1e3, *counted, erpm, a["current"])
    asked: list[str] = []
    found = find_sources([path], (), tmp_path, ask=answers(asked, pole=str(pairs)))
    assert sum("pole pairs" in text for text in asked) == 1
    fric.ingest(path, output=tmp_path / "log.h5", mapping=found.logs[0].mapping)
    (log,) = fric.read(tmp_path / "log.h5").records
    assert log.motion == "rotary/A"
    assert log.velocity is not None
    np.testing.assert_allclose(log.velocity, 2.0 * np.pi * 40.0 * a["velocity"][: len(log)], atol=0.05)


@pytest.mark.parametrize(("answer", "motion", "size"), [("0.5 mm", "linear/A", 5e-4), ("3 deg", "rotary/A", 0.052360)])
def test_a_position_in_volts_is_asked_for_what_a_volt_is(tmp_path: Path, answer: str, motion: str, size: float) -> None:
    """Of an oscilloscope's channels the answers were rad, mm, deg and rev, and a mapping had to say the scale."""
    a = axis_of_a_drive(n=3000)
    volts = 40.0 * a["position"]
    path = write(tmp_path / "log.csv", "TIME (s);CH1 (V);CH2 (V)", a["t"], volts, 0.1 * a["current"])
    asked: list[str] = []
    found = find_sources([path], (), tmp_path, ask=answers(asked, motion=answer, unit="10 A"))
    fric.ingest(path, output=tmp_path / "log.h5", mapping=found.logs[0].mapping)
    (log,) = fric.read(tmp_path / "log.h5").records
    assert log.motion == motion
    assert log.position is not None
    assert log.force is not None
    np.testing.assert_allclose(np.ptp(log.position), size * np.ptp(volts), rtol=1e-3)
    np.testing.assert_allclose(np.ptp(log.force), np.ptp(a["current"]), rtol=1e-3)


def test_an_answer_in_small_letters_is_the_choice_that_it_names() -> None:
    taken = list[str]()
    question = Question("In which unit?", [("N", "N"), ("A", "A")], taken.append)
    assert question.take("a")
    assert not question.take("newton")
    assert taken == ["A"]
