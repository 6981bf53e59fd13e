"""Words follow from numbers: each rule on contours that call for it, and on contours that do not."""

from __future__ import annotations

import numpy as np
import pytest

from fric.control.scheme import PAPER_SCHEMES
from fric.report import advice
from fric.report.report_input import Contour, ContourTest

UM = 1e-6
TABLE_2 = {"a": 22, "b": 7, "c": 6, "d": 8, "e": 5, "f": 3}
EXACT = {"a": 21.9, "b": -9.1, "c": 1.0, "d": 8.5, "e": -7.2, "f": 0.8}
"""The calibrated machine with a perfect friction model: reading notes of the paper."""


def contour(name: str, glitch: float | tuple[float, ...], interval: tuple[float, float] | None = None) -> Contour:
    glitches = glitch if isinstance(glitch, tuple) else (glitch,) * 4
    return Contour(
        PAPER_SCHEMES[name], tuple(g * UM for g in glitches), max(map(abs, glitches)) * UM, 0.0, 0.0, np.zeros(1),
        np.zeros(1), glitch_ci95=None if interval is None else (interval[0] * UM, interval[1] * UM),
    )  # fmt: skip


def circle(*contours: Contour) -> ContourTest:
    return ContourTest("run.h5", {}, 0.1, 0.03, 1, ("+x", "+y", "-x", "-y"), contours)


def table(glitches: dict[str, float]) -> ContourTest:
    return circle(*(contour(name, glitch) for name, glitch in glitches.items()))


def test_the_paper_s_table_calls_for_gms_and_observer_and_for_identifying_again() -> None:
    found = advice.advise(table(TABLE_2))
    assert found.choice == PAPER_SCHEMES["f"]
    assert "3 µm" in found.headline
    assert "86%" in found.headline  # the paper's own figure
    assert any("about 73% of the true friction" in reason for reason in found.reasons)


def test_with_an_exact_model_the_observer_is_not_worth_it_and_the_static_map_overcompensates() -> None:
    found = advice.advise(table(EXACT))
    assert found.choice == PAPER_SCHEMES["c"]
    told = " ".join(found.reasons)
    assert "(b) static overcompensates" in told
    assert "(c) GMS, which follows that, leaves 1 µm" in told
    assert "identified" not in told


def test_nothing_is_advised_where_nothing_helps() -> None:
    found = advice.advise(table({"a": 3.0, "b": 2.9, "d": 2.95}))
    assert found.choice == PAPER_SCHEMES["a"]
    assert found.headline.startswith("Leave it as it is")


def test_on_many_machines_the_upper_limit_is_what_counts() -> None:
    nominal = [contour("a", 20), contour("b", 6), contour("f", 3)]
    spread = [contour("a", 20, (15, 25)), contour("b", 6, (4, 7)), contour("f", 3, (1, 12))]
    assert advice.choose(nominal).scheme.name == "f"
    assert advice.choose(spread).scheme.name == "b"
    assert "between 4 µm and 7 µm; schemes are compared" in advice.advise(circle(*spread)).reasons[0]
    half_known = [*nominal[:2], spread[2]]  # one interval alone compares nothing
    assert advice.choose(half_known).scheme.name == "f"


def test_an_observer_that_sees_the_feedforward_is_found() -> None:
    """The reading notes: (e) becomes 20 and (f) 22 µm, worse than no observer at all."""
    seen = table({"a": 21.9, "b": 7.4, "c": 6.0, "d": 8.5, "e": 20.0, "f": 22.0}).contours
    told = advice.observer_spoils(seen)
    assert len(told) == 2
    assert all("twice" in text for text in told)
    assert not advice.observer_spoils(table(TABLE_2).contours)
    assert "61% off the bare loop" in advice.observer_share(table(EXACT).contours)[0]


def test_a_weak_feedforward_is_told_only_where_the_sign_is_that_of_the_bare_loop() -> None:
    assert not advice.too_weak(table(EXACT).contours)
    mixed = [contour("a", 20), contour("c", (5, -5, 5, -5))]
    assert not advice.too_weak(mixed)
    assert advice.too_weak([contour("a", 20), contour("c", 5)])


def test_the_axis_and_the_direction_of_uneven_glitches_are_named() -> None:
    assert not advice.uneven(circle(contour("a", 20)))
    (axis,) = advice.uneven(circle(contour("a", (20, 40, 20, 40))))
    assert axis.startswith("Axis y has the larger glitch")
    assert any("--direction each" in text for text in advice.uneven(circle(contour("a", (20, 20, 10, 20)))))


@pytest.mark.parametrize("feed", [0.01, 0.1])
def test_the_build_up_is_the_motion_of_a_circle(feed: float) -> None:
    """54 µm from the reversal on a circle of 30 mm: cos φ = 1 − z/R, exactly; the time is φ·R/v."""
    z, R = 54e-6, 0.03
    angle = np.degrees(np.arccos(1 - z / R))
    told = advice.build_up(z, R, feed)
    assert f"{angle:.2g}°" in told
    milliseconds = np.radians(angle) * R / feed * 1e3
    assert f"{float(f'{milliseconds:.2g}'):g} ms" in told


def test_a_scheme_alone_is_told_without_a_bare_loop() -> None:
    found = advice.advise(circle(contour("c", 6)))
    assert found.choice == PAPER_SCHEMES["c"]
    assert "of the schemes that were run" in found.headline
