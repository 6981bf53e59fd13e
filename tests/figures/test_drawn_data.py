"""Every figure draws the numbers that it is given, says their units, and can be read without colour."""

from __future__ import annotations

import re
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D

import fric.figures
from tests.figures.cases import CASES
from tests.figures.drawn import labels, varied
from tests.turns import in_turns

made = cache(lambda name: CASES[name]())
LABEL = re.compile(r"^\S.*\S? \[[^\[\]]+\]$")


@pytest.mark.parametrize("name", CASES)
def test_what_is_drawn_is_what_was_found(name: str) -> None:
    for panel in made(name)[1]:
        panel.check()


@pytest.mark.parametrize("name", CASES)
def test_nothing_is_cut_at_the_edge(name: str) -> None:
    """The label of a share ended in "[%", for it was wider than its axes."""
    figure = made(name)[0]
    figure.draw_without_rendering()
    box, (width, height) = figure.get_tightbbox(), figure.get_size_inches()
    assert min(box.x0, box.y0, width - box.x1, height - box.y1) > -0.01


@pytest.mark.parametrize("name", CASES)
def test_with_any_curve_replaced_by_a_constant_that_fails(name: str) -> None:
    flattened = 0
    for panel in made(name)[1]:
        for line in varied(panel):
            x, y = (np.array(values, float) for values in line.get_data())
            line.set_ydata(np.full_like(y, np.nanmean(y)))
            with pytest.raises(AssertionError):
                panel.check()
            line.set_data(x, y)
            flattened += 1
        for patch, length in zip(panel.axes.patches, panel.bars, strict=False):
            if length:
                patch.set_width(0.5 * length)
                with pytest.raises(AssertionError):
                    panel.check()
                patch.set_width(length)
        panel.check()
    assert flattened


@pytest.mark.parametrize("name", CASES)
def test_every_label_is_a_quantity_and_its_unit(name: str) -> None:
    figure = made(name)[0]
    assert labels(figure) or name in {"circle", "overlay"}
    assert [label for label in labels(figure) if not LABEL.match(label)] == []


@pytest.mark.parametrize("name", in_turns(CASES, ["circle", "plant", "record"]))
def test_it_is_laid_out(name: str) -> None:
    made(name)[0].draw_without_rendering()


@pytest.mark.parametrize("name", CASES)
def test_curves_of_one_panel_can_be_told_apart_in_grey(name: str) -> None:
    """Two named curves differ in dashes, marker or width, or clearly in how dark they are."""
    for panel in made(name)[1]:
        named = [line for line in panel.axes.get_lines() if not str(line.get_label()).startswith("_")]
        for n, one in enumerate(named):
            for other in named[:n]:
                apart = look(one) != look(other) or abs(grey(one) - grey(other)) > 0.15
                assert apart, (one.get_label(), other.get_label())


def look(line: Line2D) -> tuple[Any, ...]:
    return line.get_linestyle(), line.get_marker(), line.get_linewidth(), line.get_markerfacecolor() == "none"


def grey(line: Line2D) -> float:
    return float(np.dot(to_rgb(line.get_color()), (0.299, 0.587, 0.114)))


def test_every_figure_of_the_package_is_tested() -> None:
    tests = "\n".join(path.read_text() for path in Path("tests").rglob("*.py"))
    for module in iter_modules(fric.figures.__path__):
        for name, made_here in vars(import_module(f"fric.figures.{module.name}")).items():
            own = getattr(made_here, "__module__", "") == f"fric.figures.{module.name}"
            if own and re.fullmatch(r"draw_\w+|(?!new_|save_)\w+_figure", name):
                assert re.search(rf"\b{name}\(", tests), f"no test draws {name}: give it a case in tests/figures"
