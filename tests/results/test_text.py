"""Tables for people: what rows are called is never cut, and symbols have their plain names beside them."""

from __future__ import annotations

from dataclasses import replace
from io import StringIO

import numpy as np
from rich.console import Console

import fric
from fric.estimate import Estimate
from fric.flaws.blocks import C_WITHOUT_PLANT, LEVEL_DIFFERS
from fric.flaws.static_map import SIGMA_IN_A
from fric.results.base import Table, parameters, plain, plain_names, told_alone


def printed(table: Table, width: int) -> list[str]:
    out = StringIO()
    Console(file=out, width=width, color_system=None).print(table)
    return out.getvalue().splitlines()


def test_record_names_are_whole_in_a_narrow_terminal():
    names = [f"constant-velocity-at-a-long-name-{n:02}" for n in range(3)]
    rows = [[name, "constant-velocity", "100.6 s", "5.952 Hz", "-80.01 µm/s, 80 µm/s", "", "static"] for name in names]
    lines = printed(Table(["record", "kind", "duration", "sampling", "what", "flaws", "good for"], rows), 80)
    assert max(map(len, lines)) <= 80
    assert [line.split()[0] for line in lines if line.startswith("constant-velocity-at")] == 2 * names


def test_a_symbol_is_named_once():
    assert plain_names(["F_c", "alpha_1", "alpha_2", "k_1", "sigma_0", "sigma_1", "unheard"]) == [
        "Coulomb friction", "share of the Stribeck level", "", "stiffness of the block", "stiffness at rest",
        "damping of the bristles", "",
    ]  # fmt: skip
    table = parameters({"F_c": {"value": 60.0, "unit": "N", "ci95": [59.0, 61.0]}})
    assert table.rows == [("F_c", "60.0", "59.0 … 61.0", "N", "  Coulomb friction")]


def test_the_moving_mass_is_beside_what_gives_it_and_nowhere_else():
    """Daniels taken for newtons are a tenth of the mass of the drawing."""
    B, K_f = Estimate(2.4, "m/(s²·V)", (2.39, 2.41)), Estimate(150.0, "N/V", (147.0, 153.0))
    rows = {row[0]: row for row in parameters({"B": B, "K_f": K_f}).rows}
    low, high = map(float, rows["K_f/B"][2].split(" … "))
    drawn = np.random.default_rng(5).normal([2.4, 150.0], [0.01 / 1.96, 3.0 / 1.96], (4000, 2))
    np.testing.assert_allclose(np.quantile(drawn[:, 1] / drawn[:, 0], [0.025, 0.975]), [low, high], rtol=3e-3)
    assert rows["K_f/B"][3:] == ("kg", "  moving mass")
    fixed, current = replace(K_f, ci95=None, fixed=True), Estimate(1.0, "A/V", (0.9, 1.1))
    torque = Estimate(0.83, "N*m/V", (0.82, 0.84))  # which moves a slide by a lead that is not known
    for other in (fixed, current, torque):  # of a stated force constant, or one of amperes, the quotient is no mass
        assert "K_f/B" not in {row[0] for row in parameters({"B": B, "K_f": other}).rows}


def test_what_every_session_shows_is_a_word_in_the_table_and_what_a_file_said_is_counted():
    own = SIGMA_IN_A.found(damping=Estimate(1060.0, "N*s/m"))
    section = {"sigma": Estimate(0.0, "N*s/m", (0.0, 28.0)), "F_c": Estimate(63.0, "N", (62.0, 64.0))}
    shown = {row[0]: row[-1].strip() for row in parameters(section, notices=[own]).rows}
    assert shown == {"sigma": "viscous friction, included in A", "F_c": "Coulomb friction"}
    level = LEVEL_DIFFERS.found(level=0.98)
    before = [one.at("friction.yaml", carried=True) for one in (own, level, C_WITHOUT_PLANT.found())]
    assert told_alone([own, *before, level]) == [level, "2 doubts carried over: level-differs, C-without-plant"]


def test_a_text_is_a_text_in_a_notebook_too(monkeypatch):
    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)  # Rich would show what it prints, beside the result
    assert plain(["F_c"]) == "F_c"


def test_a_table_that_is_wider_than_the_terminal_comes_in_parts_and_cuts_no_cell() -> None:
    """At 80 columns the circles of `reproduce` read 13.2±… and "pa" and "per" on two lines."""
    cells = [f"{n}.2±0.1" for n in range(13, 20)]
    table = Table(("scheme", "+x", "+y", "near reversals", *"abcd"), [("(f) GMS + observer", *cells)], "circle")
    out = StringIO()
    Console(file=out, width=50, color_system=None, soft_wrap=True).print(table)
    lines = [line.rstrip() for line in out.getvalue().splitlines()]
    assert max(map(len, lines)) <= 50
    assert sum(line.startswith("(f) GMS + observer") for line in lines) == 3
    assert all(cell in out.getvalue() for cell in cells)
    assert "…" not in out.getvalue()
    assert lines.count("circle") == 1


def test_a_name_that_does_not_print_reaches_neither_terminal_nor_notebook():
    t = np.arange(1000) * 0.01
    position, force = 30e-6 * np.sin(np.pi * t), 60.0 * np.sign(np.cos(np.pi * t))
    log = fric.Log(t, position, force=force, kind="presliding-sine", name="x\x00\x1b[31my")
    found = fric.inspect(log)
    for text in (repr(found), str(found), found._repr_html_()):
        assert text.replace("\n", "").isprintable()
        assert "[31my" in text
