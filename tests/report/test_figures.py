"""The figures of a page draw the numbers of its files: each curve, held against what it must be."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.lines import Line2D

import fric
from fric.control.q_filter import QFilter
from fric.control.scheme import PAPER_SCHEMES
from fric.documents.machine_files import read_machine
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.io.circle import read_runs, write_runs
from fric.log import Log
from fric.report.collect import Change, collect
from fric.report.plots import (
    PageFigure,
    contour_figure,
    drift_figure,
    friction_curves,
    friction_map,
    hysteresis,
    motions,
    q_filter,
    reversal_figures,
    virgin_curves,
)
from fric.simulate.contour_run import PointPath, run_path
from tests.figures.drawn import edges, labels

from .conftest import LOGS

LABEL = re.compile(r"^\S.*\S? \[[^\[\]]+\]$")
Check = Callable[[], None]


def curves(drawn: PageFigure) -> Iterator[tuple[Line2D, np.ndarray, np.ndarray]]:
    """Give each line and each set of points of a figure, with its x and y, but straight levels and bars."""
    for axes in drawn.figure.axes:
        for line in axes.get_lines():
            own, x = line.get_transform() == axes.transData, np.asarray(line.get_xdata(), float)
            if own and len(x) > 1 and line.get_marker() not in {"_", "|", 2, 3}:  # caps of error bars
                yield line, x, np.asarray(line.get_ydata(), float)


def named(drawn: PageFigure) -> dict[str, Line2D]:
    """Return the lines that the page switches, by name."""
    found = {str(line.get_gid()): line for axes in drawn.figure.axes for line in axes.get_lines()}
    return {name: line for name, line in found.items() if name.startswith(("now:", "earlier:"))}


def spread(y: np.ndarray) -> float:
    return float(np.nanmax(y) - np.nanmin(y))


def each_fails_when_level(drawn: PageFigure, check: Check) -> None:
    """Hold a check against the figure, and then with each of its curves made level: it must fail."""
    check()
    levelled = 0
    for line, _, y in curves(drawn):
        if spread(y) > 0:
            line.set_ydata(np.full(len(y), np.nanmean(y)))
            with pytest.raises(AssertionError):
                check()
            line.set_ydata(y)
            levelled += 1
    check()
    assert levelled


def labelled(drawn: PageFigure) -> None:
    for label in labels(drawn.figure):
        assert LABEL.match(label), label


def close(found: Any, wanted: Any, rel: float = 1e-6) -> None:
    np.testing.assert_allclose(found, wanted, rtol=rel, atol=rel * np.abs(wanted).max())


@pytest.fixture(scope="module")
def inputs(files: SimpleNamespace) -> Any:
    return collect([files.march, LOGS / "constant-velocity.h5", LOGS / "presliding-sine.h5"])


def test_the_map_is_eq_2_of_the_file(files: SimpleNamespace) -> None:
    alone = collect([files.march])
    item = alone.items[0]
    static = StaticMap(105.0, 165.0, 1e-3, 1.0, 40.0)
    for drawn in friction_map(item, friction_curves(alone, item)):
        labelled(drawn)

        def check(drawn: PageFigure = drawn) -> None:
            found = [(x, y) for _, x, y in curves(drawn)]
            assert len(found) == (1 if "log" in drawn.id else 2)
            for x, y in found:
                close(y, np.asarray(static.steady_state(x * 1e-3)))

        each_fails_when_level(drawn, check)
        for x, low, high in (band for axes in drawn.figure.axes for band in edges(axes)):
            y = np.asarray(static.steady_state(x * 1e-3))
            assert np.all((np.minimum(low, high) <= y) & (y <= np.maximum(low, high)))


def test_measured_strokes_stand_where_they_were_measured(inputs: Any) -> None:
    item = inputs.items[0]
    found = friction_curves(inputs, item)
    v, F = (np.array([getattr(point, name) for point in found.points]) for name in ("velocity", "force"))
    wide, _ = friction_map(item, found)

    def check() -> None:
        points = [(x, y) for _, x, y in curves(wide) if len(x) == len(v)]
        assert len(points) == 1
        close(points[0][0], v * 1e3)
        close(points[0][1], F)
        assert sum(spread(y) > 0 for _, _, y in curves(wide)) == 3  # and the two branches of the map

    each_fails_when_level(wide, check)


def test_the_virgin_curve_is_that_of_the_blocks_and_of_the_record(inputs: Any) -> None:
    item = inputs.items[0]
    found = friction_curves(inputs, item)
    model = GMS.from_sections(item.sections())
    knots = np.sort(model.slip_displacements)
    measured = found.virgin.measured
    for drawn in virgin_curves(item, found):
        labelled(drawn)

        def check(drawn: PageFigure = drawn) -> None:
            points, line, at = [(x, y) for _, x, y in curves(drawn)]
            seen = measured.displacement <= (np.inf if "log" in drawn.id else 2 * knots[-1])
            close(points[0], measured.displacement[seen] * 1e6)
            close(points[1], measured.force[seen])
            close(line[1], np.minimum(model.k * line[0][:, None] * 1e-6, np.array(model.alpha) * 165).sum(axis=1))
            close(at[0], knots * 1e6)
            close(at[1], np.asarray(model.virgin_curve(knots)))

        each_fails_when_level(drawn, check)


def test_loops_are_the_record_and_its_replay(inputs: Any) -> None:
    item = inputs.items[0]
    found = friction_curves(inputs, item)
    shown = hysteresis(item, found)
    assert len(shown) == 2
    for drawn, cycle in zip(shown, found.hysteresis, strict=True):
        labelled(drawn)

        def check(drawn: PageFigure = drawn, cycle: Any = cycle) -> None:
            measured, replayed = [(x, y) for _, x, y in curves(drawn)]
            for x, _ in (measured, replayed):
                close(x, cycle.position * 1e6)
            close(measured[1], cycle.measured)
            close(replayed[1], cycle.model)

        each_fails_when_level(drawn, check)


def test_loops_of_a_model_alone_are_told_apart(files: SimpleNamespace) -> None:
    alone = collect([files.march])
    (drawn,) = hysteresis(alone.items[0], friction_curves(alone, alone.items[0]))
    found = friction_curves(alone, alone.items[0]).hysteresis

    def check() -> None:
        for (_, x, y), cycle in zip(curves(drawn), found, strict=True):
            close(x, cycle.position * 1e6)
            close(y, cycle.model)

    each_fails_when_level(drawn, check)
    assert len({line.get_linestyle() for line, _, _ in curves(drawn)}) == 3


def test_q_and_its_limits_are_the_filters_of_the_file(files: SimpleNamespace) -> None:
    item = collect([files.observer]).items[0]
    drawn = q_filter(item, None)
    labelled(drawn)

    def check() -> None:
        found = [(x, y) for _, x, y in curves(drawn)]
        for (f, size), cutoff in zip(found, (60.0, 372.0), strict=True):
            close(size, 20 * np.log10(np.abs(QFilter("binomial2", cutoff).response(f))))

    each_fails_when_level(drawn, check)


def test_contours_carry_the_radial_error_of_the_run(files: SimpleNamespace) -> None:
    (test,) = collect([files.run]).tests
    drawn = contour_figure(0, test, None)
    labelled(drawn)
    runs = {run.scheme.name: run.circularity for run in read_runs(files.run)}
    lines = named(drawn)
    assert set(lines) == {f"now:{name}" for name in runs}

    def check() -> None:
        for name, found in runs.items():
            angle, error = (np.asarray(values) for values in lines[f"now:{name}"].get_data())
            at = np.argmin(np.abs(found.angle - angle[:, None]), axis=1)  # a part of the samples, the peaks among them
            close(found.angle[at], angle)
            close(error, found.error[at] * 1e6)
            close(np.abs(error).max(), np.abs(found.error).max() * 1e6)

    check()
    for line in lines.values():
        kept = np.asarray(line.get_ydata())
        line.set_ydata(np.full_like(kept, kept.mean()))
        with pytest.raises(AssertionError):
            check()
        line.set_ydata(kept)


def test_an_earlier_run_is_drawn_under_the_later_one(files: SimpleNamespace) -> None:
    inputs = collect([files.run, files.later_run])
    (before, after) = inputs.test_pairs[0]
    lines = named(contour_figure(0, after, before))
    assert list(lines) == [*(f"earlier:{name}" for name in "abcf"), *(f"now:{name}" for name in "abcf")]
    for which, test in (("earlier", before), ("now", after)):
        for contour in test.contours:
            close(lines[f"{which}:{contour.scheme.name}"].get_ydata(), contour.error * 1e6)


def test_reversals_are_the_radial_error_over_time_behind_them(files: SimpleNamespace) -> None:
    (test,) = collect([files.run]).tests
    runs = [run.circularity for run in read_runs(files.run)]
    for k, drawn in enumerate(reversal_figures(0, test)):
        labelled(drawn)

        def check(k: int = k, drawn: PageFigure = drawn) -> None:
            for (_, time, error), found in zip(curves(drawn), runs, strict=True):
                assert -5.01 <= np.degrees(time.min() * 1e-3 * test.feed / test.radius) < -4
                assert 24 < np.degrees(time.max() * 1e-3 * test.feed / test.radius) <= 25.01
                glitch = found.quadrants[k] * 1e6
                peak = error[np.argmax(np.abs(error))]
                assert abs(peak - glitch) < 0.1 * abs(glitch) + 1.0
                assert np.abs(error[time < 0]).max() < 0.5 * np.abs(error).max()

        each_fails_when_level(drawn, check)


def test_a_path_carries_the_contour_error_along_it(tmp_path: Path) -> None:
    s = np.linspace(0, 2 * np.pi, 120)
    points = PointPath(0.01 * np.cos(s), 0.006 * np.sin(s), 0.05)
    runs = [run_path(read_machine("xy-table"), PAPER_SCHEMES[name], points) for name in "af"]
    write_runs(tmp_path / "path.h5", runs, "{}")
    (test,) = collect([tmp_path / "path.h5"]).tests
    drawn = contour_figure(0, test, None)
    labelled(drawn)

    def check() -> None:
        for (_, station, error), run in zip(curves(drawn), runs, strict=True):
            at = np.argmin(np.abs(run.contour.station * 1e3 - station[:, None]), axis=1)
            close(error, run.contour.error[at] * 1e6, 1e-5)
            close(np.abs(error).max(), np.abs(run.contour.error).max() * 1e6)

    each_fails_when_level(drawn, check)


def test_a_motion_is_the_logged_force_and_that_of_a_rigid_axis(tmp_path: Path) -> None:
    t = np.arange(4000) / 1000.0
    v, a = 0.1 * np.cos(np.pi * t), -0.1 * np.pi * np.sin(np.pi * t)
    force = 61 * a + 53 * np.sign(v) + 60 * v + np.random.default_rng(3).normal(size=4000)
    log = Log(t, position=0.1 / np.pi * np.sin(np.pi * t), force=force, kind="motion")
    fric.identify_plant(log, method="motion").save(tmp_path / "plant.yaml")
    item = collect([tmp_path / "plant.yaml"]).items[0]
    (drawn,) = motions(item, [log])
    labelled(drawn)

    def check() -> None:
        (_, time, logged), (_, again, rigid), (_, _, left) = curves(drawn)
        at = np.round(time * 1000).astype(int)
        close(again, time)
        close(logged, force[at])
        close(left, logged - rigid)
        sure = np.abs(v[at]) > 5e-3  # the sign of a velocity near 0 is what the encoder's steps make of it
        np.testing.assert_allclose(rigid[sure], (61 * a + 53 * np.sign(v) + 60 * v)[at][sure], atol=2.0)

    each_fails_when_level(drawn, check)


def test_drift_is_the_change_in_per_cent() -> None:
    moved = Change("F_c", "N", 105.0, 96.0, (104.1, 105.9), (94.8, 97.2))  # together 0.9 and 1.2: 1.5
    drawn = drift_figure("d", "Drift", [moved])
    assert drawn is not None
    labelled(drawn)
    (axes,) = drawn.figure.axes
    _, bar, dot = axes.get_lines()
    close(bar.get_xdata(), [-1050.0 / 105.0, -750.0 / 105.0])
    close(dot.get_xdata(), [-900.0 / 105.0])
    assert dot.get_marker() == "D"
    within = drift_figure("d", "Drift", [replace(moved, after=104.5)])
    assert within is not None
    assert [line.get_marker() for line in within.figure.axes[0].get_lines()] == ["None", "None", "o"]
    assert drift_figure("d", "Drift", []) is None
