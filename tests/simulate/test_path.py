import tracemalloc
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

import fric
from fric.control.scheme import PAPER_SCHEMES
from fric.documents.machine_files import read_machine
from fric.errors import FricError
from fric.io.circle import read_path, read_runs, write_runs
from fric.simulate.contour_run import Circle, PathRun, PointPath, RecordedPath, run_circle, run_path

MACHINE = read_machine(Path("configs/xy-table.yaml"))


def turned(first: float, last: float, points: int = 400) -> tuple[np.ndarray, np.ndarray]:
    angle = np.radians(np.linspace(first, last, points))
    return 0.03 * np.cos(angle), 0.03 * np.sin(angle)


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("scheme", ["a", "f"])
def test_a_circle_given_by_points_has_the_glitches_of_the_circle(scheme: str, direction: int) -> None:
    path = PointPath(*turned(direction * -135, direction * 405), 0.1)
    found = run_path(MACHINE, PAPER_SCHEMES[scheme], path).contour
    circle = run_circle(MACHINE, PAPER_SCHEMES[scheme]).circularity
    assert [turn.axis for turn in found.reversals] == [1, 0, 1, 0, 1, 0]
    outwards = direction * np.array([turn.glitch for turn in found.reversals])
    np.testing.assert_allclose(outwards, circle.glitch, atol=0.4e-6)
    for turn in found.reversals:
        np.testing.assert_allclose(sorted((abs(turn.x), abs(turn.y))), [0.0, 0.03], atol=50e-6)


def test_the_reference_follows_the_points_at_its_feed_with_exact_derivatives() -> None:
    t = np.linspace(0, 2 * np.pi, 200)
    path = PointPath(0.04 * np.sin(t), 0.02 * np.sin(2 * t), 0.08)
    x, y = path.references(4000.0)
    for motion in (x, y):
        for integral, derivative in ((motion.position, motion.velocity), (motion.velocity, motion.acceleration)):
            middle = (derivative[1:] + derivative[:-1]) / 2
            np.testing.assert_allclose(np.diff(integral) * 4000.0, middle, atol=2e-3 * np.abs(derivative).max())
    feed = np.hypot(x.velocity, y.velocity)
    assert np.mean(np.isclose(feed, 0.08, rtol=1e-9)) > 0.9
    assert feed[0] == feed[-1] == 0.0
    start, end = ([motion.position[n] for motion in (x, y)] for n in (0, -1))
    np.testing.assert_allclose(start, end, atol=1e-9)
    fine = np.column_stack([x.position, y.position])
    nearest = [np.min(np.hypot(*(fine - point).T)) for point in np.column_stack([path.x, path.y])[::10]]
    assert max(nearest) < 0.08 / 4000


def test_runs_of_a_path_pass_through_their_file(tmp_path: Path) -> None:
    run = run_path(MACHINE, PAPER_SCHEMES["f"], PointPath(*turned(0, 300), 0.1))
    write_runs(tmp_path / "run.h5", [run, run_circle(MACHINE, PAPER_SCHEMES["a"])])
    circle, path = read_runs(tmp_path / "run.h5")
    assert isinstance(path, PathRun)
    assert path.contour.reversals == run.contour.reversals
    np.testing.assert_array_equal(path.contour.error, run.contour.error)
    np.testing.assert_array_equal(path.traces["y"].input, run.traces["y"].input)
    assert circle.scheme.name == "a"
    with h5py.File(tmp_path / "run.h5", "a") as file:
        del file["f"].attrs["scheme_name"]
    with pytest.raises(FricError, match=r"run\.h5, /f: Scheme needs name"):
        read_runs(tmp_path / "run.h5")


def test_a_machine_of_one_axis_follows_a_path_and_draws_it(tmp_path: Path) -> None:
    """The other follows its reference exactly; the figure ended in an IndexError."""
    alone = replace(MACHINE, axes={"x": MACHINE.axes["x"]})
    result = fric.path(alone, PointPath(*turned(0, 300), 0.1), "a")
    (run,) = result.runs
    assert [*run.traces] == ["x"]
    (plan, _) = result.plot().axes
    assert (plan.get_xlabel(), plan.get_ylabel()) == ("x [mm]", "y [mm]")
    x, y = plan.lines[0].get_data()
    np.testing.assert_allclose(np.hypot(x, y), 30.0, atol=1e-3)
    result.save(tmp_path / "run.h5")
    assert [*read_runs(tmp_path / "run.h5")[0].traces] == ["x"]


def test_a_path_on_which_no_axis_turns_is_told() -> None:
    run = run_path(MACHINE, PAPER_SCHEMES["a"], PointPath(*turned(10, 80), 0.05))
    assert run.contour.reversals == ()
    assert [one.code for one in run.warnings] == ["no-reversal"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("x [mm],y [mm]\n0,0\n10,0\n20,0\n20,10\n20,20\n", "corner at x = 20 mm, y = 0 mm"),
        ("x [mm],y [mm]\n0,0\n1,0\n1,0\n", "2 different points"),
        ("x,y\n0,0\n1,0\n2,0\n3,0\n", "no unit"),
        ("x [mm],y [N]\n0,0\n1,0\n2,0\n3,0\n", "position cannot be in 'N'"),
        ("x [mm],z [mm]\n0,0\n1,0\n2,0\n3,0\n", "no column 'y'"),
        ("x [mm],y [mm]\n0,0\n1,bad\n2,0\n3,0\n4,0\n", "is not a number"),
    ],
)
def test_paths_that_cannot_be_followed_are_told(tmp_path: Path, text: str, told: str) -> None:
    file = tmp_path / "path.csv"
    file.write_text(text)
    with pytest.raises(FricError, match=told):
        read_path(file, 0.1)


def test_a_path_too_short_for_its_feed_is_told() -> None:
    with pytest.raises(FricError, match="too short"):
        PointPath(*turned(0, 10), 0.1).references(4000.0)


@pytest.mark.parametrize("apart", [0.0, 1e-310, 1e-20, 1e-13])
def test_a_point_that_comes_twice_is_followed_once(apart: float) -> None:
    """Twice on the same place, or nearer than a billionth of the path: over such a chord no slope is finite."""
    x, y = turned(0, 80)
    asked = PointPath(x, y, 0.05).references(4000.0)
    n = int(np.argmin(np.hypot(x, y)))  # where the smallest distance is not lost in the digits
    x, y = x - x[n], y - y[n]
    twice = PointPath(np.insert(x, n, apart), np.insert(y, n, 0.0), 0.05).references(4000.0)
    for reference, of_both in zip(asked, twice, strict=True):
        moved = [each.position - each.position[0] for each in (reference, of_both)]
        np.testing.assert_allclose(*moved, atol=1e-11)


RECORDED = Circle(0.03, 0.1, 1)


def test_a_recorded_reference_is_followed_as_it_was_asked_for(tmp_path: Path) -> None:
    """A circle's reference from a CSV file, from a run file, and the circle itself: the same motion and glitches."""
    scheme = PAPER_SCHEMES["f"]
    circle_run = run_circle(MACHINE, scheme, RECORDED)
    x, y = (trace.reference for trace in circle_run.traces.values())
    t = circle_run.traces["x"].time
    table, runs = tmp_path / "reference.csv", tmp_path / "run.h5"
    rows = np.column_stack([t * 1e3, x * 1e3, y * 1e3])
    np.savetxt(table, rows, delimiter=",", header="time [ms],x [mm],y [mm]", comments="", fmt="%.9f")
    write_runs(runs, [circle_run])
    peaks = np.sort(np.abs(circle_run.circularity.quadrants))
    for file in (table, runs):
        path = read_path(file, 1.0)
        assert isinstance(path, RecordedPath)
        assert path.feed == pytest.approx(0.1, rel=1e-3)
        run = run_path(MACHINE, scheme, path)
        np.testing.assert_allclose(run.traces["x"].reference, x, atol=1e-11)
        found = np.sort([abs(turn.glitch) for turn in run.contour.reversals])
        np.testing.assert_allclose(found[-4:], peaks, atol=0.3e-6)  # counts of the encoder may fall otherwise
    again = tmp_path / "again.h5"
    write_runs(again, [run])
    (read,) = read_runs(again)
    assert isinstance(read.test, RecordedPath)
    np.testing.assert_array_equal(read.test.x, run.test.x)


def test_a_recording_that_cannot_be_followed_is_refused(tmp_path: Path) -> None:
    t = np.arange(200) / 1000.0
    with pytest.raises(FricError, match="begins at"):
        RecordedPath(t, 0.1 * t, 0.0 * t)
    with pytest.raises(FricError, match="does not run forward"):
        RecordedPath(t[::-1], t, t)
    for tiny in (1e-310, 1e-20):  # 0, 1e-310, 2e-3 …: no acceleration has a finite value
        with pytest.raises(FricError, match="run forward at sample 1"):
            RecordedPath(np.where(t == t[1], tiny, t), 0.1 * t, 0.0 * t)
    with pytest.raises(FricError, match="does not move"):
        RecordedPath(t, 0.0 * t, 0.0 * t)


def test_a_path_that_is_too_long_is_refused_before_it_is_laid_out():
    """Both axes count: six million samples of each took 2 GB before they were refused."""
    path = PointPath(*turned(0, 300), 0.03 * np.radians(300) / 1500)  # 25 minutes
    tracemalloc.start()
    try:
        with pytest.raises(FricError, match="are simulated at most"):
            path.references(4000.0)
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()
