from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fric.figures.record import POINTS, draw_plan, draw_record
from fric.figures.style import thinned
from fric.log import Log
from fric.records.inspection import inspect
from tests.figures.cases import planned
from tests.turns import in_turns


def record(**channels):
    time = np.arange(4000) / 1000.0
    position = 1e-3 * np.abs(time % 2 - 1)
    return Log(time=time, position=position, **{name: make(time) for name, make in channels.items()})


def labels(figure):
    return [label for ax in figure.findobj(lambda a: hasattr(a, "get_xlabel")) for label in (ax.get_ylabel(),) if label]


@pytest.mark.parametrize("samples", [8001, 24_841, 99_999])
def test_thinning_reaches_to_both_ends(samples):
    x, _ = thinned(np.arange(samples) * 1.0, np.arange(samples) * 1.0, POINTS)
    assert (x[0], x[-1]) == (0.0, samples - 1.0)
    assert np.all(np.diff(x) >= 0.0)


CHANNELS = {}, {"force": np.sin}, {"input": np.cos}, {"force": np.sin, "input": np.cos}


@pytest.mark.parametrize("channels", in_turns(CHANNELS, CHANNELS[::3]))
def test_every_axis_carries_its_unit(channels):
    log = record(**channels)
    found = inspect(log)
    for number in (1, 3, 9):
        figure = draw_record([log] * number, [found] * number)
        assert len(labels(figure)) >= 2
        assert all("[" in label for label in labels(figure))


def test_every_stroke_is_a_point_of_the_figure_of_many_records():
    log = record(force=lambda time: np.where(time % 2 < 1, -5.0, 5.0) + 0.01 * np.sin(9 * time))
    found = inspect(log)
    figure = draw_record([log] * 9, [found] * 9)
    (points, *_) = figure.axes[0].lines
    assert len(points.get_xdata()) == 9 * len(found.stretches) > 9


def test_velocity_logs_and_rotary_axes_are_drawn():
    time = np.arange(500) / 100.0
    log = Log(time=time, velocity=np.full(500, 2.0) + 0.01 * np.sin(9 * time), force=np.cos(time), motion="rotary")
    for records in ([log], [replace(log, force=None)], [log] * 9):
        figure = draw_record(records, [inspect(one) for one in records])
        figure.draw_without_rendering()
        assert any("rad/s" in label or "N·m" in label for label in labels(figure))


def test_thinning_keeps_every_peak():
    y = np.zeros(100_000)
    y[[777, 54_321, 99_990]] = 5.0, -3.0, 1.0
    x, thin = thinned(np.arange(len(y)) * 1.0, y, POINTS)
    assert len(thin) < 10_000
    assert (thin.max(), thin.min()) == (5.0, -3.0)
    assert 777.0 in x


def test_a_plan_that_determines_nothing_is_drawn():
    """A logarithmic axis without a bar above 0 ended in a ValueError."""
    figure = draw_plan(replace(planned(), expected={}))
    figure.draw_without_rendering()
