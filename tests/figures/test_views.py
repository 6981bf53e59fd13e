"""Figures are found by name; a new one, of docs/new-figure.md, is drawn and tested without another edit."""

import re
from pathlib import Path

import numpy as np
import pytest

import fric
from fric.errors import FricError
from fric.figures.style import views
from tests.figures.cases import SUBJECTS
from tests.figures.drawn import labels
from tests.new_file import place, python, shared_tests

ROOT = Path(__file__).parents[2]
FRIC = "import sys, new_figure_plugin; from fric.cli.main import main; sys.exit(main())"


def kind(found):
    return type(found[0] if isinstance(found, list) else found).__name__


@pytest.mark.parametrize("subject", SUBJECTS)
def test_each_figure_draws_what_it_is_of(subject):
    """Labels with units, and curves of finite numbers that are no constants; the same again from the same numbers."""
    found = SUBJECTS[subject]()
    drawn = [one for one in views() if one.of == kind(found)]
    assert drawn
    for one in drawn:
        figure, again = one.draw(found), one.draw(found)
        assert all(re.fullmatch(r"\S.*\[[^\[\]]+\]", label) for label in labels(figure)), (one.name, labels(figure))
        lines = [line for axes in figure.axes for line in axes.get_lines()]
        assert any(np.ptp(np.ma.filled(line.get_ydata(), 0.0)[:10000]) > 0 for line in lines), one.name
        for first, second in zip(lines, [line for axes in again.axes for line in axes.get_lines()], strict=True):
            np.testing.assert_array_equal(first.get_ydata(), second.get_ydata())
        assert one.summary.endswith("."), one.name


def test_a_result_draws_its_figures_by_name(tmp_path):
    found = fric.circle("configs/xy-table.yaml", "a", radius=0.005, revolutions=1)
    assert {"contour", "reversal"} <= set(found.views())
    found.plot(tmp_path / "reversal.svg", view="reversal")
    assert "time" in (tmp_path / "reversal.svg").read_text()
    with pytest.raises(FricError, match="there is no figure 'reversals'"):
        found.plot(view="reversals")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("figure")
    place(folder, "new-figure.md", "fric.figures", "harmonics.py", "new_figure_plugin")
    return folder


def test_a_new_figure_is_drawn_by_command_and_report_and_held_by_the_shared_tests(folder, warm):
    run = folder / "run.h5"
    words = ["simulate", "circle", "xy-table", "--scheme", "a,f", "--radius", "5 mm", "-o", str(run)]
    assert "wrote" in python(warm, folder, FRIC, *words, "--plot", f"harmonics={folder / 'harmonics.png'}")
    assert (folder / "harmonics.png").read_bytes()[1:4] == b"PNG"
    python(warm, folder, FRIC, "report", str(run), "-o", str(folder / "report.html"))
    page = (folder / "report.html").read_text()
    assert page.count('aria-label="Draw the amplitude of each harmonic of the radial error, a curve a scheme."') == 1
    words = ["tests/figures/test_views.py", "-k", "draws_what_it_is_of and circles"]
    assert "1 passed" in shared_tests(warm, folder, "new_figure_plugin", *words)
