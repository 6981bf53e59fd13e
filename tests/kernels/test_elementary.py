"""Elementary functions against decimals of 50 digits; the bits of whole circles under the settings of processors."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from decimal import Decimal, localcontext
from fractions import Fraction
from math import factorial, inf, isnan, log, nan, pi, ulp
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fric.exact import riccati
from fric.kernels import elementary, plant
from fric.kernels.spline import spline_slopes
from tests import legs
from tests.kernels import bits

EXACT = {
    "exp": lambda x: x.exp(),
    "expm1": lambda x: x.exp() - 1,
    "log": lambda x: x.ln(),
    "log1p": lambda x: (1 + x).ln(),
}
RANGE = {"exp": (-744.0, 709.7), "expm1": (-50.0, 700.0), "log": (1e-300, 1e300), "log1p": (-0.999, 1e6)}


@pytest.mark.parametrize("name", EXACT)
@given(data=st.data())
def test_a_function_is_within_four_units_in_the_last_place(name: str, data: st.DataObject) -> None:
    low, high = RANGE[name]
    # below 1e-20 the decimals do not tell e^x - 1 any more
    both = st.floats(low, high) | st.floats(max(low, -1.0), 1.5)
    x = data.draw(both.filter(lambda x: abs(x) > 1e-20 or name == "log"))
    with localcontext() as context:
        context.prec = 50
        exact = EXACT[name](Decimal(x))
        off = abs(Decimal(getattr(elementary, name)(x)) - exact)
    assert off <= 4 * Decimal(ulp(float(exact)))


@given(st.floats(-1e6, 1e6))
def test_cosine_and_sine_are_within_four_units_of_one(angle: float) -> None:
    """NumPy's functions are right to a unit in the last place; near a zero only the angle's own last place counts."""
    c, s = elementary.cos_sin(np.array([angle]))
    assert abs(c[0] - np.cos(angle)) <= 4 * ulp(1.0)
    assert abs(s[0] - np.sin(angle)) <= 4 * ulp(1.0)
    assert abs(c[0] ** 2 + s[0] ** 2 - 1.0) <= 4 * ulp(1.0)
    assert elementary.sin(-angle) == -elementary.sin(angle)


@given(st.floats(1e-6, 1e6), st.floats(0.05, 6.0))
def test_a_power_is_the_librarys_to_what_its_logarithm_tells(x: float, y: float) -> None:
    assert elementary.power(x, y) == pytest.approx(x**y, rel=(4 + 2 * abs(y * log(x))) * ulp(1.0))


def test_functions_at_their_ends() -> None:
    assert elementary.exp(-inf) == elementary.exp(-1e300) == elementary.exp(-744.5) == 0.0
    assert elementary.exp(inf) == elementary.exp(710.0) == inf
    assert elementary.exp(0.0) == 1.0
    assert isnan(elementary.exp(nan))
    assert elementary.log(0.0) == -inf
    assert elementary.log(inf) == inf
    assert isnan(elementary.log(-1.0))
    assert elementary.log(1.0) == elementary.expm1(0.0) == elementary.log1p(0.0) == elementary.sin(0.0) == 0.0
    assert elementary.power(0.0, 2.0) == 0.0
    assert elementary.cos(pi) == -1.0


@pytest.mark.parametrize("ends", ["natural", "periodic", "not-a-knot"])
def test_slopes_are_those_of_scipys_spline(ends: str) -> None:
    from scipy.interpolate import CubicSpline

    rng = np.random.default_rng(5)
    x = np.cumsum(rng.uniform(0.5, 2.0, 60))
    y = rng.normal(size=60)
    y[-1] = y[0]
    np.testing.assert_allclose(spline_slopes(x, y, ends), CubicSpline(x, y, bc_type=ends)(x, 1), rtol=0, atol=1e-12)


@pytest.mark.parametrize("noise", [1e-12, 1e-6, 1.0, 1e6])
def test_the_riccati_equation_is_solved_as_scipy_solves_it(noise: float) -> None:
    from scipy.linalg import solve_discrete_are

    a = np.array([[1.0, 0.0, 0.0], [1.0, 0.99, 0.0], [0.5, 0.9, 1.0]])
    G, H = np.diag([1.0, 0.0, 0.0]), np.diag([0.0, 0.0, noise])
    exact = solve_discrete_are(a, np.eye(3)[:, :1], H, np.eye(1))
    np.testing.assert_allclose(riccati(a.tolist(), G.tolist(), H.tolist()), exact, rtol=1e-7)


def test_weights_of_the_extrapolation_are_the_exact_fractions_rounded_once() -> None:
    """Those that cancel h² to h^(k+1). Off by 5e-12, as a solver finds them, they moved all circles by a count."""
    for k, row in enumerate(plant.WEIGHTS):
        n = k + 1
        parts = range(1, n + 1)
        exact = [
            Fraction((-1) ** (n - j) * 2 * j ** (n + 1), n * (n + 1) * factorial(j) * factorial(n - j)) for j in parts
        ]
        assert sum(exact) == 1
        assert not any(sum(w / j**m for w, j in zip(exact, parts, strict=True)) for m in range(2, n + 1))
        assert [*row] == [*map(float, exact), *[0.0] * (len(row) - n)]


CIRCLES = Path(bits.__file__)
SETTINGS = {
    "as it is": {},
    "Haswell": {"OPENBLAS_CORETYPE": "Haswell", "NPY_DISABLE_CPU_FEATURES": "AVX512F AVX512CD AVX512_SKX"},
    "Prescott, two threads": {"OPENBLAS_CORETYPE": "Prescott", "OMP_NUM_THREADS": "2"},
    "no fused products": {
        "OPENBLAS_CORETYPE": "Sandybridge", "NPY_DISABLE_CPU_FEATURES": "AVX2 FMA3 AVX512F AVX512CD AVX512_SKX",
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable", "NUMBA_CPU_NAME": "nehalem",
    },
}  # fmt: skip


@pytest.mark.skipif(platform.machine() != "x86_64", reason="names processors of x86-64")
def test_two_circles_have_the_same_bits_under_another_blas_dispatch_and_c_library() -> None:
    """In one further process, which takes what is compiled from the same cache."""
    settings = {name: value for name, value in legs.processor("old").items() if not name.startswith("NUMBA")}
    environment = os.environ | settings | {"OMP_NUM_THREADS": "2"}
    words = [sys.executable, CIRCLES, "few"]
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == list(bits.circles(*bits.FEW))


@pytest.mark.long(150)
def test_circles_have_the_same_bits_under_any_blas_dispatch_and_c_library(tmp_path: Path) -> None:
    """24 circles and a GMS model with its intervals, each setting with a cache of compiled code of its own."""
    found = {}
    for n, (name, setting) in enumerate(SETTINGS.items()):
        environment = {**os.environ, **setting, "NUMBA_CACHE_DIR": str(tmp_path / str(n))}
        done = subprocess.run([sys.executable, CIRCLES], env=environment, capture_output=True, text=True, check=True)
        found[name] = done.stdout.splitlines()
    assert len(set(found["as it is"])) == len(found["as it is"]) == 25
    for name, lines in found.items():
        assert lines == found["as it is"], name
