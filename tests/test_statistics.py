"""Covariances where residuals hang together: intervals hold what a slow motion beside a noisy channel leaves."""

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.special import stdtrit

from fric.statistics import hac_covariance, jackknife, parameter_covariance
from tests.chance import fewest, most


def held(memory: float, noise: float, draws: int) -> np.ndarray:
    """Return how many intervals of mass, viscous, Coulomb friction and offset hold 0, of as many draws."""
    rng, t, count = np.random.default_rng(1), np.linspace(0.0, 1.0, 1000), np.zeros(4)
    v = np.sin(6.0 * np.pi * t) + 0.5 * np.sin(14.6 * np.pi * t)
    X = np.column_stack([np.gradient(v, t) / 20.0, v, np.sign(v), np.ones(len(t))])
    for _ in range(draws):
        y = lfilter([1.0], [1.0, -memory], rng.standard_normal(1500))[500:] + noise * rng.standard_normal(len(t))
        found = np.linalg.lstsq(X, y, rcond=None)[0]
        half = stdtrit(len(t) - 4, 0.975) * np.sqrt(np.diag(hac_covariance(X, y - X @ found)))
        count += np.abs(found) <= half
    return count


@pytest.mark.parametrize(("memory", "noise", "share"), [(0.0, 0.0, 0.92), (0.9, 0.0, 0.9), (0.9, 3.0, 0.86)])
def test_intervals_hold_as_often_as_they_claim_whatever_the_memory(memory: float, noise: float, share: float) -> None:
    """An offset was held in 0.69 of the draws where white noise covers the memory. Fails in under one of a thousand."""
    count = held(memory, noise, 60)
    assert (count >= fewest(60, share)).all(), count
    assert (count <= most(60, 0.98)).all(), count


@pytest.mark.parametrize("lengths", [None, [150_000, 260_001]])
def test_a_long_record_has_the_covariance_of_its_memory(lengths: list[int] | None) -> None:
    """Sums of neighbours stand in for 410,001 scores, of which Burg's recursion took a minute and 2 GB.

    The variance of the mean of ``e_t = 0.95·e_(t-1) + w_t`` is ``1/(1 - 0.95)²/n``; four standard errors are 8 %.
    """
    n = 410_001
    noise = lfilter([1.0], [1.0, -0.95], np.random.default_rng(64).normal(size=n))
    variance = hac_covariance(np.ones((n, 1)), noise, lengths)[0, 0]
    assert variance == pytest.approx(1.0 / (1.0 - 0.95) ** 2 / n, rel=0.08)


@pytest.mark.parametrize("unit", [1e-3, 1e-7, 1e9])
def test_intervals_do_not_depend_on_units(unit: float) -> None:
    """A parameter whose column was 1e-8 of another's was certain: a pseudoinverse of squares took it for none."""
    rng = np.random.default_rng(0)
    J, rest = rng.standard_normal((90, 3)), rng.standard_normal(90)
    units, label = np.array([1.0, unit, 1.0 / unit]), np.arange(90) // 15
    scale = np.outer(units, units)
    assert parameter_covariance(J) == pytest.approx(np.linalg.inv(J.T @ J))
    assert parameter_covariance(J / units) / scale == pytest.approx(parameter_covariance(J), rel=1e-6)
    assert jackknife(J / units, rest, label) / scale == pytest.approx(jackknife(J, rest, label), rel=1e-6)


def test_a_long_run_covariance_of_many_values_is_that_of_sums_of_neighbours(monkeypatch):
    """Of 120,000 values it took minutes in a fit of the GMS model."""
    t, rng = np.arange(60_000) / 60_000, np.random.default_rng(7)
    X = np.column_stack([np.ones(len(t)), np.sin(12 * np.pi * t)])
    for memory in (0.0, 0.9, 0.99):
        noise = lfilter([1.0], [1.0, -memory], rng.normal(size=len(t)))
        few = np.diag(hac_covariance(X, noise))
        monkeypatch.setattr("fric.statistics.ENOUGH", len(t))
        assert few == pytest.approx(np.diag(hac_covariance(X, noise)), rel=0.3)
        monkeypatch.undo()
