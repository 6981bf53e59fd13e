import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import linalg, signal

from fric.control.inverse_model import DifferenceEquation, DisturbanceObserver
from fric.control.q_filter import Q_FILTERS, QFilter
from fric.errors import FricError
from fric.exact import matrix_exponential

A, B, T_S = 28.57, 4.526, 1 / 4000
FILTERS = pytest.mark.parametrize("name", Q_FILTERS)


def run(equation: DifferenceEquation, x: np.ndarray) -> np.ndarray:
    return np.asarray(signal.lfilter(equation.b, equation.a, x))


@given(st.lists(st.floats(-4.0, 4.0), min_size=16, max_size=16))
def test_the_matrix_exponential_is_scipys(numbers: list[float]) -> None:
    matrix = np.reshape(numbers, (4, 4))
    exact = linalg.expm(matrix)
    np.testing.assert_allclose(
        matrix_exponential(matrix.tolist()), exact, rtol=0, atol=1e-12 * (1.0 + np.abs(exact).max())
    )


@FILTERS
@pytest.mark.parametrize("cutoff", [1.0, 60.0, 400.0])
def test_discrete_filters_are_causal_proper_stable_and_of_right_gain_at_rest(name: str, cutoff: float) -> None:
    both = DisturbanceObserver(QFilter(name, cutoff), A, B).discrete(4000.0)
    for equation in (both.inverse, both.low_pass):
        assert len(equation.b) == len(equation.a) == len(QFilter(name).poles) + 1
        assert equation.a[0] == 1.0
        assert np.all(np.abs(np.roots(equation.a)) < 1)
    assert both.low_pass.b[0] == 0.0
    assert both.low_pass.b.sum() / both.low_pass.a.sum() == pytest.approx(1.0, abs=1e-12)
    assert abs(both.inverse.b.sum()) < 1e-12 * np.abs(both.inverse.b).sum()


@FILTERS
def test_held_filter_is_the_continuous_one_at_the_samples(name: str) -> None:
    observer = DisturbanceObserver(QFilter(name), A, B)
    u = np.repeat(np.random.default_rng(1).normal(size=20), 10)
    q = observer.q
    gain = np.real(np.prod(-q.poles) / np.prod(-q.zeros))
    continuous = signal.ZerosPolesGain(q.zeros, q.poles, gain)
    fine = 16  # the same steps, sampled sixteen times as often
    time = np.arange(u.size * fine) * T_S / fine
    _, y, _ = signal.lsim(continuous, np.repeat(u, fine), time, interp=False)
    assert run(observer.discrete(4000.0).low_pass, u) == pytest.approx(y[::fine], abs=1e-9)


@FILTERS
def test_discrete_filters_follow_the_continuous_ones_far_below_nyquist(name: str) -> None:
    observer = DisturbanceObserver(QFilter(name), A, B)
    f = np.array([0.1, 1.0, 10.0, 100.0])
    s = 2j * np.pi * f
    Q = observer.q.response(f)
    both = observer.discrete(4000.0)
    inverse, low_pass = (signal.freqz(part.b, part.a, f, fs=4000.0)[1] for part in (both.inverse, both.low_pass))
    assert inverse == pytest.approx(Q * s * (s + A) / B, rel=3e-2)
    hold = np.sinc(f * T_S) * np.exp(-0.5 * s * T_S)
    assert low_pass == pytest.approx(Q * hold, rel=3e-2)


@FILTERS
def test_a_constant_disturbance_is_found_and_a_uniform_motion_is_none(name: str) -> None:
    """d̂ at rest under a held voltage u_t is −u_t; at constant velocity v with u_t = A·v/B it is 0."""
    both = DisturbanceObserver(QFilter(name), A, B).discrete(4000.0)
    n = np.arange(4000)
    v = 0.1
    ramp, voltage = v * n * T_S, np.full(n.size, A * v / B)
    d_hat = run(both.inverse, ramp) - run(both.low_pass, voltage)
    assert d_hat[-1] == pytest.approx(0.0, abs=1e-7)
    at_rest = run(both.inverse, np.zeros(n.size)) - run(both.low_pass, voltage)
    assert at_rest[-1] == pytest.approx(-A * v / B)


def test_what_makes_no_observer_is_refused() -> None:
    for name, cutoff, a, b in (
        ("chebyshev", 60, A, B),
        ("binomial2", 0, A, B),
        ("binomial2", 60, -1, B),
        ("binomial2", 60, A, 0),
    ):
        with pytest.raises(FricError):
            DisturbanceObserver(QFilter(name, cutoff), a, b)
    with pytest.raises(FricError, match="sampling"):
        DisturbanceObserver(QFilter("binomial2", 2000.0), A, B).discrete(4000.0)
    with pytest.raises(FricError, match="too low"):
        DisturbanceObserver(QFilter("binomial4", 0.1), A, B).discrete(4000.0)
