"""The map over feed and radius shows each glitch in its place, and frames the circles on which an observer spoils."""

from pathlib import Path

import numpy as np
from matplotlib.patches import Rectangle

from fric.control.scheme import PAPER_SCHEMES
from fric.documents.machine_files import read_machine
from fric.figures.circle import draw_circle_map
from fric.simulate.contour_run import Cell, CircleGrid, CircleMap

MICROMETRES = np.array(
    [[[6.0, 7.0, 8.0], [9.0, np.nan, 11.0]], [[2.0, 9.5, 3.0], [4.0, 5.0, 12.0]]]
)  # scheme, radius, feed


def test_each_cell_stands_in_its_place_with_its_glitch():
    schemes = tuple(PAPER_SCHEMES[name] for name in "cf")
    grid = CircleGrid(read_machine(Path("configs/xy-table.yaml")), schemes, (0.01, 0.05, 0.1), (0.01, 0.03), 5e-9)
    cells = [Cell(grid.circle(n), 1e-6 * MICROMETRES[:, *divmod(n, 3)], {}) for n in range(6)]
    figure = draw_circle_map(CircleMap(grid, cells))
    for panel, values in zip(figure.axes, MICROMETRES, strict=False):
        np.testing.assert_allclose(np.ma.filled(panel.images[0].get_array(), np.nan), values)
        written = {
            (round(text.get_position()[1]), round(text.get_position()[0])): text.get_text() for text in panel.texts
        }
        for (row, column), value in np.ndenumerate(values):
            assert written[row, column] == ("×" if np.isnan(value) else f"{value:.3g}")
        assert (panel.get_xlabel(), panel.get_ylabel()) == ("feed [mm/s]", "radius [mm]")
        assert [tick.get_text() for tick in panel.get_xticklabels()] == ["10", "50", "100"]
        assert [tick.get_text() for tick in panel.get_yticklabels()] == ["10", "30"]
    left, right = ([p for p in panel.patches if isinstance(p, Rectangle)] for panel in figure.axes[:2])
    assert left == []
    assert {(round(p.get_y()), round(p.get_x())) for p in right} == {(0, 1), (1, 2)}  # where (f) leaves more than (c)
    assert figure.axes[-1].get_ylabel() == "glitch [µm]"
