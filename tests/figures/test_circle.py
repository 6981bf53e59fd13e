"""The figure of a circular test says of its own axes what they are."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fric.control.scheme import PAPER_SCHEMES
from fric.documents.machine_files import read_machine
from fric.figures.circle import SchemeContour, monte_carlo_figure, overlay_figure, polar_figure
from fric.simulate.contour_run import Circle, run_circle
from fric.simulate.processes import Study
from tests.studies import monte_carlo

MACHINE = read_machine(Path("configs/xy-table.yaml"))


@pytest.mark.parametrize("names", ["a", "af"])
def test_grid_and_magnification_are_those_that_are_drawn(names: str) -> None:
    circle = Circle(5e-3, 50e-3, 1)
    figure = polar_figure([run_circle(MACHINE, PAPER_SCHEMES[name], circle) for name in names])
    title = figure.get_suptitle()
    grid, magnified = (float(re.search(text, title)[1]) for text in (r"lines (\S+) µm", r"magnified (\S+) times"))
    for axes in figure.axes:
        assert np.diff(axes.get_yticks()) == pytest.approx(grid)
        nominal = -axes.get_ylim()[0]  # µm from the centre of the plot to the circle that was asked for
        assert magnified * nominal == pytest.approx(5000, rel=0.005)
    left, _, width, _ = figure._suptitle.get_window_extent().bounds
    assert left >= 0
    assert left + width <= figure.bbox.width


def test_the_label_of_the_share_is_whole() -> None:
    """It ended in "[%", where no scheme is the best on all machines: it is wider than its axes."""
    found = monte_carlo(Study(MACHINE, tuple(PAPER_SCHEMES.values()), Circle(5e-3, 50e-3, 1)), 2, workers=1)
    first, second = found.outcomes
    figure = monte_carlo_figure(replace(found, outcomes=(first, replace(second, quadrants=second.quadrants[::-1]))))
    figure.draw_without_rendering()
    label = figure.axes[1].xaxis.label.get_window_extent()
    assert label.x1 <= figure.bbox.width


@pytest.mark.parametrize("magnification", [100.0, 200.0, 300.0])
def test_each_label_of_a_ring_has_its_ring_within_the_figure(magnification: float) -> None:
    """Those of +100 and -150 µm had none."""
    around = SchemeContour(PAPER_SCHEMES["a"], np.linspace(0, 6.28, 50), np.zeros(50))
    (axes,) = overlay_figure([around], 30e-3, 1, magnification).axes
    rings = {line.get_gid(): line.get_ydata() for line in axes.lines if str(line.get_gid()).startswith("ring:")}
    low, high = axes.get_ylim()
    for text in (text for text in axes.texts if str(text.get_gid()).startswith("ring:")):
        at = rings[text.get_gid()]
        if text.get_text().strip():
            assert float(text.get_text()[:-3].replace("−", "-")) == pytest.approx(at[0], abs=0.01)
            assert 0.7 * low <= at[0] <= high
        else:
            assert at[0] == pytest.approx(low)
    assert len(rings) == 5
