"""Non-negative least squares: optimal by their conditions, with SciPy's inner function and without it."""

import numpy as np
import pytest

from fric.identify.static_map import stribeck_fit as module
from fric.identify.static_map.stribeck_fit import nonnegative

RNG = np.random.default_rng(3)
A, B = RNG.normal(size=(40, 6)), RNG.normal(size=40)


@pytest.fixture(params=["inner", "public"])
def way(request, monkeypatch):
    if request.param == "public":  # as another version of SciPy may be: what is reached into is not there
        monkeypatch.setattr(module, "_unchecked", None)


@pytest.mark.usefixtures("way")
def test_no_step_that_is_allowed_leaves_less():
    x, rest = nonnegative(A, B, 60)
    slope = A.T @ (A @ x - B)
    assert rest == pytest.approx(np.linalg.norm(A @ x - B), rel=1e-12)
    assert 0 < np.count_nonzero(x) < len(x)  # some are at their bound
    assert np.all(x >= 0)
    assert slope[x > 0] == pytest.approx(0.0, abs=1e-12)
    assert np.all(slope[x == 0] > 0)


@pytest.mark.usefixtures("way")
def test_what_cannot_be_solved_is_an_error():
    with pytest.raises(RuntimeError):
        nonnegative(A, A @ np.ones(6), 1)
    with pytest.raises(ValueError, match=r"inf|nan|NaN"):
        nonnegative(A, np.where(np.arange(40) == 3, np.nan, B), 60)
