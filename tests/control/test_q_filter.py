import numpy as np
import pytest
from scipy import signal

from fric.control.q_filter import Q_FILTERS, QFilter
from fric.errors import FricError

FILTERS = pytest.mark.parametrize("name", Q_FILTERS)


@FILTERS
def test_bandwidth_is_where_q_has_fallen_by_three_decibel(name: str) -> None:
    q = QFilter(name, 60.0 / QFilter(name, 1.0).bandwidth)
    assert q.bandwidth == pytest.approx(60.0)
    f = np.array([1e-6, 60.0, 60.01, 600.0])
    magnitude = np.abs(q.response(f))
    assert magnitude[:2] == pytest.approx([1.0, np.sqrt(0.5)])
    assert magnitude[2] < magnitude[1]
    assert magnitude[3] < 0.2


def test_shapes_are_those_of_the_literature() -> None:
    for name, order in (("butterworth2", 2), ("butterworth3", 3)):
        b, a = signal.butter(order, 2 * np.pi * 60, analog=True)
        f = np.geomspace(1, 1000, 50)
        _, expected = signal.freqs(b, a, 2 * np.pi * f)
        assert QFilter(name, 60.0).response(f) == pytest.approx(expected)
    # Umeno and Hori's Q_31 leaves 1 − Q = O(s²): a ramp of disturbance is followed without error.
    f = np.array([1e-3, 1e-2])
    left = np.abs(1 - QFilter("umeno-hori", 1.0).response(f))
    assert left[1] / left[0] == pytest.approx(100, rel=1e-3)


@FILTERS
def test_q_falls_at_least_as_fast_as_the_inverse_plant_rises(name: str) -> None:
    high = np.abs(QFilter(name, 60.0).response(np.array([1e5, 2e5])))
    assert high[0] / high[1] >= 4.0 * (1 - 1e-3)


def test_binomial_is_a_chain_of_equal_low_passes() -> None:
    f = np.array([3.0, 60.0, 700.0])
    for n in (2, 3, 4):
        np.testing.assert_allclose(QFilter(f"binomial{n}", 60.0).response(f), (1 / (1 + 1j * f / 60.0)) ** n)


@pytest.mark.parametrize(("name", "cutoff"), [("chebyshev", 60.0), ("binomial2", 0.0)])
def test_a_filter_that_cannot_be_is_refused(name: str, cutoff: float) -> None:
    with pytest.raises(FricError):
        QFilter(name, cutoff)
