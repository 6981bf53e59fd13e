"""Circle tests in and out of files: traces, LinuxCNC's sampler text, a ball bar, runs."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
import pytest

import fric
from fric.circles.diagnose import diagnose
from fric.documents.mapping import MappingDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.io.circle import choose_circles, read_circles, write_circles
from fric.io.ingest_circle import StatedCircle, ingest_circles
from fric.reference import circle as circle_reference
from tests.circles.synthetic_circles import Faults, circle
from tests.linuxcnc.bench import CHANNELS, render

ROOT = Path(__file__).parents[2]


def trace(path: Path, *, way: int = 1, header: str | None = None) -> np.ndarray:
    x, y = circle_reference(0.03, 0.1, 2, 1000.0, direction=way)
    rows = np.column_stack([x.time, x.position * 1e3, x.position * 1e3 + 1e-3, y.position * 1e3, y.position * 1e3,
                            0.01 * x.velocity])  # fmt: skip
    header = header or "time [s],x_ref [mm],x_enc [mm],y_ref [mm],y_enc [mm],x_u [V]"
    np.savetxt(path, rows, "%.9g", ",", header=header, comments="")
    return rows


def test_a_trace_of_two_axes_tells_radius_feed_and_direction(tmp_path):
    rows = trace(tmp_path / "a.csv", way=-1)
    done = ingest_circles(tmp_path / "a.csv", tmp_path / "c.h5")
    (test,) = read_circles(tmp_path / "c.h5")
    assert (test.radius, test.feed, test.direction) == (0.03, 0.1, -1)
    assert done.samples == len(rows)
    np.testing.assert_allclose(test.axes["x"].position - test.axes["x"].reference, 1e-6, atol=1e-12)
    assert test.axes["x"].input is not None
    assert test.axes["y"].input is None
    with h5py.File(tmp_path / "c.h5") as file:
        assert file.attrs["fric"] == "circle/1"
        assert set(file["x"]) == {"time", "reference", "position", "input"}
        assert file["x/input"].attrs["unit"] == "V"
        assert (file.attrs["radius"], file.attrs["feed"], file.attrs["direction"]) == (0.03, 0.1, -1)


def test_a_circle_of_a_few_micrometres_is_in_another_unit_unless_its_radius_is_stated(tmp_path):
    """Micrometres in place of millimetres: K_p was 1000 times too large, without a word."""
    trace(tmp_path / "a.csv", header="time [s],x_ref [um],x_enc [um],y_ref [um],y_enc [um],x_u [V]")
    with pytest.raises(FricError, match="the circle has a radius of 30 µm"):
        ingest_circles(tmp_path / "a.csv", tmp_path / "c.h5")
    assert not (tmp_path / "c.h5").exists()
    stated = StatedCircle(radius=30e-6)
    (test,) = ingest_circles(tmp_path / "a.csv", tmp_path / "c.h5", stated=stated).tests
    assert test.radius == 30e-6


@pytest.mark.parametrize(
    "header",
    [
        "time [s],reference x [mm],actual x [mm],reference y [mm],actual y [mm],voltage x [V]",
        "t [s],xcmd [mm],xpos [mm],ycmd [mm],ypos [mm],x [V]",
        "time [s],x command [mm],x [mm],y command [mm],y [mm],x input [V]",
        "time_s,Xcmd_mm,Xfb_mm,Ycmd_mm,Yfb_mm,Xvolt_V",
    ],
)
def test_headers_are_understood(tmp_path, header):
    trace(tmp_path / "a.csv", header=header)
    (test,) = ingest_circles(tmp_path / "a.csv", tmp_path / "c.h5").tests
    assert set(test.axes["x"].channels()) == {"time", "reference", "position", "input"}
    assert set(test.axes["y"].channels()) == {"time", "reference", "position"}


def test_a_commanded_position_in_words_that_are_not_known_is_no_measured_one(tmp_path):
    """The command was the circle that was measured: no glitch at all. Both are told apart."""
    header = "時間 [s],X軸 指令位置 [mm],X軸 実位置 [mm],Y軸 指令位置 [mm],Y軸 実位置 [mm],X軸 トルク指令 [V]"
    trace(tmp_path / "a.csv", header=header)
    circle = ingest_circles(tmp_path / "a.csv", tmp_path / "c.h5").tests[0].axes["x"]
    assert circle.reference is not None
    np.testing.assert_allclose(circle.position - circle.reference, 1e-6, atol=1e-12)


@pytest.mark.parametrize("name", ["Torque x [%]", "Iq x [A]", "x [A]"])
def test_a_force_in_the_drives_unit_stays_in_it(tmp_path, name):
    """The current of a foreign circle was dropped in silence, and its axis had no gains."""
    rows = trace(tmp_path / "a.csv", header=f"time [s],x_ref [mm],x_enc [mm],y_ref [mm],y_enc [mm],{name}")
    ingest_circles(tmp_path / "a.csv", tmp_path / "c.h5")
    (test,) = read_circles(tmp_path / "c.h5")
    unit = name[-2]
    assert test.axes["x"].unit == unit
    taken = test.of_effort({"x": f"linear/{unit}/{unit}"}).axes["x"].input
    np.testing.assert_allclose(taken, rows[-len(taken) :, 5], rtol=1e-8)
    assert test.of_effort({"x": "linear/N/N"}).axes["x"].input is None
    assert test.together()[0].unit == unit


def test_what_a_header_leaves_open_is_assumed_where_asked(tmp_path):
    """`--assume` was taken and did nothing."""
    trace(tmp_path / "a.csv", header="t,x_cmd,x_act,y_cmd,y_act,x_u")
    with pytest.raises(FricError, match="has no unit") as error:
        fric.ingest_circles(tmp_path / "a.csv", output=tmp_path / "c.h5")
    assert "assume=True" in error.value.hint
    done = fric.ingest_circles(tmp_path / "a.csv", output=tmp_path / "c.h5", assume=True)
    (test,) = read_circles(tmp_path / "c.h5")
    assert (test.radius, test.feed) == (0.03, 0.1)
    assert "columns-assumed" in {notice.code for notice in done.warnings} or done.warnings


def test_both_directions_and_more_stand_in_one_file(tmp_path):
    trace(tmp_path / "a.csv")
    trace(tmp_path / "b.csv", way=-1)
    ingest_circles([tmp_path / "a.csv"], tmp_path / "c.h5")
    again = ingest_circles([tmp_path / "a.csv", tmp_path / "b.csv"], tmp_path / "c.h5", append=True)
    assert [warning.code for warning in again.warnings] == ["there-already"]
    assert [test.direction for test in read_circles(tmp_path / "c.h5")] == [1, -1]


def test_linuxcnc_sampler_text_without_header(tmp_path):
    parts = []
    for feed, way in ((0.1, -1), (0.05, 1)):
        x, y = circle_reference(0.03, feed, 2, 1000.0, direction=way)
        motion = np.column_stack([x.position, y.position]) * 1e3
        parts += [np.repeat(motion[:1], 300, 0), motion, np.repeat(motion[-1:], 300, 0)]
    motion = np.vstack(parts)
    encoder = np.round(motion / 2.5e-4) * 2.5e-4
    table = np.column_stack([np.arange(len(motion)), motion, motion + 1e-4, encoder, 0.01 * motion])
    np.savetxt(tmp_path / "trace.txt", table, "%.9g")
    with pytest.raises(FricError, match="no time"):
        ingest_circles(tmp_path / "trace.txt", tmp_path / "c.h5")
    done = ingest_circles(tmp_path / "trace.txt", tmp_path / "c.h5", stated=StatedCircle(sampling=1000.0))
    assert [(test.feed, test.direction) for test in done.tests] == [(0.1, -1), (0.05, 1)]
    assert [warning.code for warning in done.warnings] == ["columns-by-content"]
    steps = done.tests[0].axes["x"].position * 1e7 / 2.5  # the encoder's column was taken, not the other
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)


def test_the_mapping_of_linuxcncs_bench(tmp_path):
    x, y = circle_reference(0.03, 0.1, 2, 4000.0)
    motion = np.column_stack([x.position, y.position]) * 1e3
    rest = np.zeros((len(motion), 4))
    table = np.column_stack([np.arange(len(motion)), motion, rest, motion, motion, 0.01 * motion, rest[:, :3]])
    np.savetxt(tmp_path / "trace.txt", table, "%.9g")
    mapping = read_document(ROOT / "configs/mappings/linuxcnc.yaml", MappingDocument)
    (test,) = ingest_circles(tmp_path / "trace.txt", tmp_path / "c.h5", mapping=mapping).tests
    assert (test.radius, test.feed) == (0.03, 0.1)
    assert np.diff(test.axes["x"].time) == pytest.approx(0.00025)
    np.testing.assert_allclose(test.axes["y"].input, 10 * test.axes["y"].position, rtol=1e-6)
    np.savetxt(tmp_path / "lost.txt", np.delete(table, 900, axis=0), "%.9g")
    with pytest.raises(FricError, match="1 rows are lost: the count jumps from 899 to 901"):
        ingest_circles(tmp_path / "lost.txt", tmp_path / "l.h5", mapping=mapping)


def test_the_mapping_is_that_of_a_trial(tmp_path):
    axes = [{"name": "x"}, {"name": "y"}]
    written = render("trace.yaml.j2", axes=axes, channels=CHANNELS, period_ns=250_000)
    assert (ROOT / "configs/mappings/linuxcnc.yaml").read_text() == written


def test_a_ball_bar_that_logs_each_angle_twice_has_the_feed_of_the_whole(tmp_path):
    """Half of its samples turn by nothing: the median rate of 0 ended in a traceback."""
    angle = np.repeat(np.linspace(0.0, 720.0, 721), 2)
    rows = [f"{n * 1e-3:.3f},{a:.3f},0.0" for n, a in enumerate(angle)]
    (tmp_path / "bb.csv").write_text("\n".join(["time [s],angle [deg],deviation [um]", *rows]))
    ingest_circles(tmp_path / "bb.csv", tmp_path / "bb.h5", stated=StatedCircle(radius=0.15))
    (test,) = read_circles(tmp_path / "bb.h5")
    assert test.feed == pytest.approx(0.15 * 4 * np.pi / 1.441, rel=0.01)


def test_a_ball_bar_needs_radius_and_feed_and_tells_the_direction(tmp_path):
    angle = np.linspace(0, -4 * np.pi, 4001)
    rows = np.column_stack([np.degrees(angle), 3 * np.cos(2 * angle)])
    np.savetxt(tmp_path / "bar.csv", rows, "%.6f", ";", header="angle [deg];deviation [um]", comments="")
    with pytest.raises(FricError, match="radius"):
        ingest_circles(tmp_path / "bar.csv", tmp_path / "bar.h5")
    with pytest.raises(FricError, match="feed"):
        ingest_circles(tmp_path / "bar.csv", tmp_path / "bar.h5", stated=StatedCircle(radius=0.15))
    stated = StatedCircle(radius=0.15, feed=0.1, scheme="f")
    ingest_circles(tmp_path / "bar.csv", tmp_path / "bar.h5", stated=stated)
    assert read_circles(tmp_path / "bar.h5")[0].scheme == "f"
    (test,) = read_circles(tmp_path / "bar.h5")
    assert test.is_ball_bar
    assert test.direction == -1
    found = diagnose([test])
    assert found.figures.G[-1] == pytest.approx(6e-6, rel=1e-3)
    assert "ball-bar-length" in {warning.code for warning in found.warnings}


def test_a_trace_without_a_circle_is_refused(tmp_path):
    t = np.arange(2000) / 1000
    table = np.column_stack([t, 10 * t, 10 * t, 5 * t, 5 * t])
    header = "time [s],x_ref [mm],x [mm],y_ref [mm],y [mm]"
    np.savetxt(tmp_path / "a.csv", table, "%.9g", ",", header=header, comments="")
    with pytest.raises(FricError, match="no whole circle"):
        ingest_circles(tmp_path / "a.csv", tmp_path / "c.h5")
    np.savetxt(tmp_path / "b.csv", table[:, :2], "%.9g", ",", header="time [s],x [mm]", comments="")
    with pytest.raises(FricError, match="takes two axes"):
        ingest_circles(tmp_path / "b.csv", tmp_path / "c.h5")
    assert not (tmp_path / "c.h5").exists()


def test_a_file_goes_out_and_in_unchanged(tmp_path):
    rng = np.random.default_rng(0)
    tests = [circle(Faults(), rng, direction=way, revolutions=1) for way in (1, -1)]
    write_circles(tmp_path / "c.h5", tests)
    for before, after in zip(tests, read_circles(tmp_path / "c.h5"), strict=True):
        assert after.instrument == before.instrument
        for name, axis in before.axes.items():
            for channel, values in axis.channels().items():
                np.testing.assert_array_equal(values, after.axes[name].channels()[channel])


@pytest.mark.long(3)
def test_diagnose_on_the_command_line(tmp_path, capsys, monkeypatch):
    from fric.cli.main import app

    def run(*words: object) -> str:
        with pytest.raises(SystemExit) as end:
            app([str(word) for word in words])
        assert end.value.code in (0, None)
        return capsys.readouterr().out

    table = ROOT / "configs/xy-table.yaml"
    run("simulate", "circle", table, "--scheme", "a,c", "-o", tmp_path / "run.h5")
    figure = tmp_path / "d.png"
    out = run("diagnose", tmp_path / "run.h5", "--scheme", "a", "--machine", table, "--plot", figure, "--json")
    found = json.loads(out)
    assert found["agrees"] is True
    assert set(found["predicted"]) == {"+x", "+y", "-x", "-y"}
    assert figure.stat().st_size > 10_000
    assert "reversal error x" in run("diagnose", tmp_path / "run.h5", "--scheme", "c")
    with pytest.raises(FricError, match="2 schemes"):
        choose_circles([tmp_path / "run.h5"])


def test_names_that_end_in_their_unit_are_a_header(tmp_path: Path) -> None:
    """As the fields of a .mat: the same names were read in a log of one axis."""
    trace(tmp_path / "a.csv", header="time_s,x_ref_mm,x_pos_mm,y_ref_mm,y_pos_mm,x_voltage_V")
    (test,) = ingest_circles(tmp_path / "a.csv", tmp_path / "c.h5").tests
    assert (test.radius, test.feed) == (0.03, 0.1)
    assert test.axes["x"].input is not None


@pytest.mark.parametrize("most", [2e-5, 2.5e-4])
def test_tall_glitches_of_a_measured_position_leave_whole_turns(tmp_path, most):
    """On a grid plate glitches of 211 µm turned the angle by over 1 % in 1/48 of a turn: "it covers 186°"."""
    t = np.arange(0.0, 2.1 * np.pi, 2e-3)
    angle = 2.0 * t
    x, y = 0.025 * np.cos(angle), 0.025 * np.sin(angle)
    late = (angle % np.pi) / 0.3, ((angle + np.pi / 2) % np.pi) / 0.3
    x, y = (axis + most * np.sign(axis) * by * np.exp(1.0 - by) for axis, by in zip((x, y), late, strict=True))
    rows = np.column_stack([t, 1e3 * x, 1e3 * y])
    np.savetxt(tmp_path / "a.csv", rows, "%.6f", ",", header="time [s],x_pos [mm],y_pos [mm]", comments="")
    ingest_circles(tmp_path / "a.csv", tmp_path / "c.h5")
    assert [test.count for test in fric.diagnose(tmp_path / "c.h5").found.tests] == [2]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_voltage_of_a_circle_that_counts_the_other_way_is_turned_and_named(tmp_path, sign):
    """Its gains explained 7 % of the voltage, and no scheme was recommended."""
    x, y = read_circles(Path(__file__).parents[2] / "data/circle.h5")[0].axes.values()
    rows = np.column_stack(
        [x.time, 1e3 * x.reference, 1e3 * x.position, sign * x.input, 1e3 * y.reference, 1e3 * y.position]
    )
    head = "time [s],x_ref [mm],x_pos [mm],x_u [V],y_ref [mm],y_pos [mm]"
    np.savetxt(tmp_path / "a.csv", rows, "%.9g", ",", header=head, comments="")
    done = ingest_circles(tmp_path / "a.csv", tmp_path / "c.h5")
    assert [notice.code for notice in done.warnings] == ["force-by-file"] * (sign < 0)
    turned = done.tests[0].axes["x"].input
    assert np.corrcoef(turned, np.interp(done.tests[0].axes["x"].time, x.time, x.input))[0, 1] > 0.9
