import pytest

from fric.errors import FricError
from fric.units import parse_gain


@pytest.mark.parametrize(("text", "ratio"), [("6 dB", 1.99526), ("-20dB", 0.1), ("20 db", 10.0), (3.0, 3.0), (2, 2.0)])
def test_a_gain_is_a_ratio_or_decibels(text: str, ratio: float) -> None:
    assert parse_gain(text) == pytest.approx(ratio, rel=1e-5)


@pytest.mark.parametrize("text", ["", "dB", "6 V", 0, -2, float("nan"), "1e9 dB"])
def test_anything_else_is_refused(text: str) -> None:
    with pytest.raises(FricError, match="not a gain"):
        parse_gain(text)


def test_a_gain_without_a_unit_is_refused() -> None:
    """`--gain-margin 13.8` was a ratio of 22.8 dB, in silence."""
    with pytest.raises(FricError, match=r"(?s)'13.8' has no unit.*Write decibels, as in '13.8 dB'"):
        parse_gain("13.8")
