"""Words follow from numbers: each rule on contours that call for it, and on contours that do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fric.control.scheme import PAPER_SCHEMES
from fric.report import view as advice
from fric.report.collect import Contour, ContourTest

UM = 1e-6
TABLE_2 = {"a": 22, "b": 7, "c": 6, "d": 8, "e": 5, "f": 3}
EXACT = {"a": 21.9, "b": -9.1, "c": 1.0, "d": 8.5, "e": -7.2, "f": 0.8}
"""The calibrated machine with a perfect friction model: reading notes of the paper."""


def contour(name: str, glitch: float | tuple[float, ...]) -> Contour:
    glitches = glitch if isinstance(glitch, tuple) else (glitch,) * 4
    return Contour(
        scheme=PAPER_SCHEMES[name], glitches=tuple(g * UM for g in glitches), glitch=max(map(abs, glitches)) * UM,
        rms=0.0, range=0.0, place=np.zeros(1), error=np.zeros(1),
    )  # fmt: skip


def circle(*contours: Contour) -> ContourTest:
    return ContourTest("run.h5", {}, 0.1, 0.03, 1, ("+x", "+y", "-x", "-y"), contours)


def table(glitches: dict[str, float]) -> ContourTest:
    return circle(*(contour(name, glitch) for name, glitch in glitches.items()))


def test_with_an_exact_model_the_static_map_overcompensates_and_what_does_not_count_is_not_said() -> None:
    told = " ".join(advice.observations(table(EXACT)))
    assert "(b) static (9.1 µm) and (e) static + observer (7.2 µm) overcompensate" in told
    assert "builds up over the pre-sliding, as a GMS model does" in told
    assert "identified" not in told
    weak = " ".join(advice.observations(table(TABLE_2)))
    assert "about 73% of the friction" in weak
    assert "has risen" not in weak  # it is of a gain below 1, on the machine that the friction is of
    assert "Raise its gain; only where that is 1, identify again." in weak
    slight = advice.observations(table({"a": 20, "c": -0.9}))
    assert not any("overcompensates" in text for text in slight)  # under what is worth effort, 5 % of 20 µm


def test_an_observer_that_sees_the_feedforward_is_found() -> None:
    """The reading notes: (e) becomes 20 and (f) 22 µm, worse than no observer at all."""
    seen = table({"a": 21.9, "b": 7.4, "c": 6.0, "d": 8.5, "e": 20.0, "f": 22.0})
    told = advice.observer_spoils(seen)
    assert len(told) == 2
    assert all("twice" in text for text in told)
    assert not advice.observer_spoils(table(TABLE_2))
    assert "61% off the bare loop" in advice.observer_share(table(EXACT))[0]


def test_a_weak_feedforward_is_told_only_where_the_sign_is_that_of_the_bare_loop() -> None:
    assert not advice.too_weak(table(EXACT).contours)
    mixed = [contour("a", 20), contour("c", (5, -5, 5, -5))]
    assert not advice.too_weak(mixed)
    assert advice.too_weak([contour("a", 20), contour("c", 5)])


def test_the_axis_and_the_direction_of_uneven_glitches_are_named() -> None:
    assert not advice.uneven(circle(contour("a", 20)))
    (axis,) = advice.uneven(circle(contour("a", (20, 40, 20, 40))))
    assert axis.startswith("Axis y has the larger glitch")
    assert any("`direction='each'`" in text for text in advice.uneven(circle(contour("a", (20, 20, 10, 20)))))
    alone = replace(circle(contour("a", (20, 0.2, 20, 0.4))), provenance={"axes": ["x"]})
    assert not advice.uneven(alone)  # of an axis that was not run nothing is said


@pytest.mark.parametrize("feed", [0.01, 0.1])
def test_the_build_up_is_the_motion_of_a_circle(feed: float) -> None:
    """54 µm from the reversal on a circle of 30 mm: cos φ = 1 − z/R, exactly; the time is φ·R/v."""
    z, R = 54e-6, 0.03
    angle = np.degrees(np.arccos(1 - z / R))
    told = advice.build_up(z, R, feed)
    assert f"{angle:.2g}°" in told
    milliseconds = np.radians(angle) * R / feed * 1e3
    assert f"{float(f'{milliseconds:.2g}'):g} ms" in told
