import numpy as np
import pytest

from fric.compensation.disturbance_observer import Q_FILTERS, DisturbanceObserver, QFilter
from fric.errors import FricError


@pytest.mark.parametrize("name", Q_FILTERS)
def test_q_has_unit_gain_at_rest_and_falls_at_least_as_the_inverse_plant_rises(name: str) -> None:
    q = QFilter(name, 60.0)
    assert q.response(np.array([1e-6]))[0] == pytest.approx(1.0)
    high = np.abs(q.response(np.array([1e5, 2e5])))
    assert high[0] / high[1] >= 4.0 * (1 - 1e-3)


@pytest.mark.parametrize("name", [name for name in Q_FILTERS if name.startswith("butterworth")])
def test_butterworth_is_down_3_db_at_its_cutoff(name: str) -> None:
    assert abs(QFilter(name, 60.0).response(np.array([60.0]))[0]) == pytest.approx(0.5**0.5)


def test_binomial_is_a_chain_of_equal_low_passes() -> None:
    f = np.array([3.0, 60.0, 700.0])
    for n in (2, 3, 4):
        np.testing.assert_allclose(QFilter(f"binomial{n}", 60.0).response(f), (1 / (1 + 1j * f / 60.0)) ** n)


def test_inverse_plant_times_plant_is_one() -> None:
    observer = DisturbanceObserver(QFilter(), A=28.57, B=4.526)
    s = 2j * np.pi * np.array([0.5, 40.0])
    np.testing.assert_allclose(np.polyval(observer.inverse_numerator(), s) * 4.526 / (s * (s + 28.57)), 1.0)


@pytest.mark.parametrize(("name", "cutoff"), [("chebyshev", 60.0), ("binomial2", 0.0)])
def test_a_filter_that_cannot_be_is_refused(name: str, cutoff: float) -> None:
    with pytest.raises(FricError):
        QFilter(name, cutoff)
