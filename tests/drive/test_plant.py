import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from fric.control.cascade import Cascade
from fric.drive.plant import Plant
from fric.drive.sensing import Encoder, low_pass_pole
from fric.errors import FricError
from fric.kernels.sensing import FAULTLESS, read

X_AXIS = Plant(A=28.57, B=4.526, T_d=0.65e-3, K_f=548.0)


def test_moving_mass_and_damping_of_the_paper_s_x_axis() -> None:
    assert pytest.approx(121.08, abs=0.01) == X_AXIS.M
    assert X_AXIS.damping == pytest.approx(3459, abs=1)
    assert X_AXIS.transport_delay(4000.0) == pytest.approx(0.525e-3)


@given(st.floats(0.0, 1e3), st.floats(1e-6, 0.1))
def test_held_input_is_the_matrix_exponential(A: float, T: float) -> None:
    plant = Plant(A, 4.5, 0.0, 500.0)
    augmented = np.array([[0, 1, 0], [0, -A, 4.5], [0, 0, 0]]) * T
    Phi, Gamma = plant.held(T)
    exact = expm(augmented)
    np.testing.assert_allclose(Phi, exact[:2, :2], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(Gamma, exact[:2, 2], rtol=1e-9, atol=1e-16)


def test_response_falls_as_a_double_integrator_far_above_the_corner() -> None:
    low, high = np.abs(X_AXIS.response(np.array([500.0, 1000.0])))
    assert low / high == pytest.approx(4.0, rel=1e-3)


@pytest.mark.parametrize("values", [{"A": -1.0}, {"B": 0.0}, {"K_f": float("nan")}])
def test_a_plant_that_cannot_be_is_refused(values: dict[str, float]) -> None:
    with pytest.raises(FricError, match="plant is"):
        Plant(**({"A": 28.57, "B": 4.526, "T_d": 0.65e-3, "K_f": 548.0} | values))


def test_delay_below_half_a_sample_is_told() -> None:
    with pytest.raises(FricError, match="half a sample"):
        Plant(20.0, 5.0, 0.1e-3, 500.0).transport_delay(4000.0)


def test_a_controller_that_cannot_be_is_refused() -> None:
    with pytest.raises(FricError, match="K_p of the controller is -1"):
        Cascade(126.0, -1.0, 3156.0, 500.0, 4000.0)


def test_encoder_rounds_to_its_steps_and_errs_by_half_of_one() -> None:
    z = np.linspace(-1e-5, 1e-5, 999)
    seen, untouched = z.copy(), z.copy()
    read(seen, 0.25e-6, FAULTLESS)
    assert np.abs(seen - z).max() <= 0.125e-6 * (1 + 1e-9)
    np.testing.assert_allclose(seen / 0.25e-6, np.rint(seen / 0.25e-6), atol=1e-9)
    read(untouched, Encoder().resolution, FAULTLESS)
    assert np.array_equal(untouched, z)
    np.testing.assert_allclose(Encoder(0.25e-6).read(z), seen, atol=1e-15)  # what users call rounds as the loop does
    assert Encoder().read(z) is z


def test_low_pass_is_down_3_db_at_its_corner_when_sampled_fast() -> None:
    p = low_pass_pole(500.0, 1e6)
    assert abs((1 - p) / (1 - p * np.exp(-2j * np.pi * 500.0 / 1e6))) == pytest.approx(0.5**0.5, rel=2e-3)
