import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fric.contour import circularity
from fric.errors import FricError


def turned(revolutions: float, direction: int = 1, samples: int = 20_000) -> np.ndarray:
    return direction * np.linspace(-np.pi / 4, -np.pi / 4 + 2 * np.pi * revolutions, samples)


@given(
    st.tuples(*[st.floats(-30e-6, 30e-6)] * 4),
    st.floats(-20e-6, 20e-6),
    st.sampled_from([1, -1]),
    st.floats(0.005, 0.2),
)
@settings(max_examples=40, deadline=None)
def test_spikes_at_the_quadrants_are_found_with_their_signs(
    spikes: tuple[float, ...], offset: float, direction: int, radius: float
) -> None:
    angle = turned(2, direction)
    rho = np.full_like(angle, radius + offset)
    for quarter, height in enumerate(spikes):
        away = (angle - quarter * np.pi / 2 - direction * 0.1 + np.pi) % (2 * np.pi) - np.pi
        rho += height * np.exp(-((away / 0.04) ** 2))
    found = circularity(rho * np.cos(angle), rho * np.sin(angle), radius)
    np.testing.assert_allclose(found.quadrants, spikes, atol=1e-4 * max(map(abs, spikes)) + 1e-12)
    assert found.glitch == pytest.approx(max(map(abs, spikes)), abs=1e-8)
    assert found.range == pytest.approx(max(*spikes, 0.0) - min(*spikes, 0.0), abs=1e-8)


def test_a_perfect_circle_of_another_radius_has_no_glitch() -> None:
    angle = turned(1.5)
    found = circularity(0.03001 * np.cos(angle), 0.03001 * np.sin(angle), 0.03)
    assert found.glitch < 1e-15
    assert found.rms == pytest.approx(10e-6)
    assert abs(found.angle[-1] - found.angle[0]) == pytest.approx(2 * np.pi, abs=1e-3)


def test_only_the_last_revolution_counts() -> None:
    angle = turned(3)
    rho = 0.03 + 50e-6 * (angle < 2 * np.pi) * np.exp(-((np.sin(angle) / 0.1) ** 2))
    assert circularity(rho * np.cos(angle), rho * np.sin(angle), 0.03).glitch < 1e-15


def test_errors_between_the_quadrants_are_no_glitch() -> None:
    angle = turned(2)
    rho = 0.03 + 40e-6 * np.exp(-(((angle % (np.pi / 2) - np.pi / 4) / 0.04) ** 2))
    found = circularity(rho * np.cos(angle), rho * np.sin(angle), 0.03)
    assert found.glitch < 1e-9
    assert found.range == pytest.approx(40e-6, rel=1e-3)


def test_half_a_circle_is_refused() -> None:
    angle = turned(0.5)
    with pytest.raises(FricError, match="180°"):
        circularity(np.cos(angle), np.sin(angle), 1.0)
