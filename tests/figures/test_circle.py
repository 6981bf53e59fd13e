"""The figure of a circular test says of its own axes what they are."""

import re
from pathlib import Path

import numpy as np
import pytest

from fric.control.scheme import PAPER_SCHEMES
from fric.documents.machine_files import read_machine
from fric.figures.circle import polar_figure
from fric.simulate.contour_run import Circle, run_circle

MACHINE = read_machine(Path("configs/xy-table.yaml"))


@pytest.mark.parametrize("names", ["a", "af"])
def test_grid_and_magnification_are_those_that_are_drawn(names: str) -> None:
    circle = Circle(5e-3, 50e-3, 1)
    figure = polar_figure([run_circle(MACHINE, PAPER_SCHEMES[name], circle) for name in names])
    title = figure.get_suptitle()
    grid, magnified = (float(re.search(text, title)[1]) for text in (r"grid (\S+) µm", r"magnified (\S+) times"))
    for axes in figure.axes:
        assert np.diff(axes.get_yticks()) == pytest.approx(grid)
        nominal = -axes.get_ylim()[0]  # µm from the centre of the plot to the circle that was asked for
        assert magnified * nominal == pytest.approx(5000, rel=0.005)
    left, _, width, _ = figure._suptitle.get_window_extent().bounds
    assert left >= 0
    assert left + width <= figure.bbox.width
