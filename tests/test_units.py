"""Units at the edge: what is read is what was meant, what cannot be meant is told, what people read is theirs."""

import subprocess
import sys
from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fric.errors import FricError
from fric.units import _EVERYDAY, SI_UNITS, _registry, factor, is_unit, parse, prefixed, readable, short_of_1


@pytest.mark.parametrize(("unit", "si"), _EVERYDAY)
def test_everyday_units_are_what_pint_says(unit, si):
    registry = _registry()
    assert _EVERYDAY[unit, si] == pytest.approx(registry.Quantity(unit).to(si).magnitude, rel=1e-15)


def test_everyday_units_do_not_wait_for_pint():
    code = "import sys; from fric.units import parse; parse('30 mm', 'position'); assert 'pint' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("dimension", SI_UNITS)
@pytest.mark.parametrize("motion", ["linear", "rotary"])
def test_si_units_are_their_own(dimension, motion):
    assert factor(SI_UNITS[dimension][motion == "rotary"], dimension, motion) == 1.0


@pytest.mark.parametrize(
    ("text", "dimension", "motion", "value"),
    [
        ("30 mm", "position", "linear", 0.03),
        ("30mm", "position", "linear", 0.03),
        ("1e-3 m/s", "velocity", "linear", 1e-3),
        ("60 rpm", "velocity", "rotary", 6.283185307179586),
        ("90 deg", "position", "rotary", 1.5707963267948966),
        ("9.84 mN*m", "force", "rotary", 9.84e-3),
        ("99.94 N/µm", "stiffness", "linear", 99.94e6),
        ("2.5 g", "mass", "linear", 2.5e-3),
    ],
)
def test_quantities_are_parsed(text, dimension, motion, value):
    assert parse(text, dimension, motion) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "dimension", "motion", "told"),
    [
        ("3 mm", "force", "linear", "measures a length"),
        ("3 N*m", "force", "linear", "is it rotary"),
        ("3 N", "force", "rotary", "is it linear. Then say `motion: linear`"),
        ("3 V", "force", "linear", "measures an input"),
        ("3 %", "force", "rotary", "measures nothing that has a dimension"),
        ("3 flub", "force", "linear", "not a unit"),
        ("3", "force", "linear", "no unit"),
        ("much", "force", "linear", "not a quantity"),
    ],
)
def test_what_cannot_be_meant_is_told(text, dimension, motion, told):
    with pytest.raises(FricError, match=told):
        parse(text, dimension, motion)


@given(st.floats(1e-9, 1e9), st.sampled_from(["m", "N", "V", "s", "Hz", "m/s", "N/m", "kg", "1"]))
def test_a_prefix_changes_no_value(value, unit):
    scale, shown = prefixed(value, unit)
    back = 1.0 if unit in {"1", "kg"} else factor(shown.replace("·", "*").replace("µ", "u"), _dimension(unit))
    assert value * scale * back == pytest.approx(value, rel=1e-12)


def _dimension(unit):
    return next(d for d, (linear, _) in SI_UNITS.items() if linear == unit)


@pytest.mark.parametrize(
    ("value", "unit", "told"),
    [
        (2.2e-5, "m", "22 µm"),
        (0.03, "m", "30 mm"),
        (105, "N", "105 N"),
        (0.9996e-3, "N*m", "1 mN·m"),
        (9.9e7, "N/m", "99 N/µm"),
    ],
)
def test_people_read_their_units(value, unit, told):
    assert readable(value, unit) == told


def test_german_headers_degrees_are_degrees():
    assert factor("Grad", "position", "rotary") == pytest.approx(pi / 180)
    assert factor("Grad/s", "velocity", "rotary") == pytest.approx(pi / 180)
    with pytest.raises(FricError, match="degrees in German, and gon elsewhere"):
        factor("grad", "position", "rotary")


def test_a_cache_of_an_installation_that_is_no_more_does_no_harm(monkeypatch: pytest.MonkeyPatch) -> None:
    """As `FileNotFoundError` of each command with a unit, where two environments share a home."""

    def made(*, cache_folder: str = "") -> str:
        if cache_folder:
            raise FileNotFoundError("constants_en.txt")
        return "without a cache"

    monkeypatch.setattr("pint.UnitRegistry", made)
    assert _registry.__wrapped__() == "without a cache"


@pytest.mark.parametrize(
    ("unit", "plain", "step"), [("0.1 rpm", "rpm", 0.1), ("0.001 deg", "deg", 1e-3), ("10 um", "um", 10.0)]
)
def test_a_step_of_a_drive_is_a_unit(unit: str, plain: str, step: float) -> None:
    of = {"rpm": "velocity"}.get(plain, "position")
    motion = "linear" if plain == "um" else "rotary"
    assert is_unit(unit)
    assert factor(unit, of, motion) == pytest.approx(step * factor(plain, of, motion))
    assert factor(f"2.5 {plain}", of, motion) == pytest.approx(2.5 * factor(plain, of, motion))  # as a comment's count
    for no_step in (f"0.0 {plain}", f"2{plain}"):
        with pytest.raises(FricError):
            factor(no_step, of, motion)


@pytest.mark.parametrize(
    ("share", "shown"),
    [
        (0.5, "0.5"),
        (0.97, "0.9700"),
        (0.99998, "0.99998"),
        (-0.3, "-0.3"),
        (0.99996, "0.99996"),
        (2.3e-5, "2.3e-05"),
        (12345.678, "12350"),
        (np.nan, "–"),
        (1.0, "1"),
    ],
)
def test_a_share_short_of_1_is_not_shown_as_1(share: float, shown: str) -> None:
    assert short_of_1(share) == shown
