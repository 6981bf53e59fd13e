"""An exported step under bad input: 0 and a fault until reset, and nothing stuck behind."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.export.parts import INPUTS, InC, scheme_part

pytestmark = pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler is installed")
BAD = [float("nan"), float("inf"), float("-inf"), 1e300, -1e300, 1e12]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> InC:
    return InC(scheme_part("f"), tmp_path_factory.mktemp("c"))


def _circle(n: int) -> list[dict[str, float]]:
    t = np.arange(n) / 4000
    return [
        {"position": 0.03 * float(np.sin(3.3 * x)), "velocity": 0.1 * float(np.cos(3.3 * x)),
         "measured": 0.03 * float(np.sin(3.3 * x))} for x in t
    ]  # fmt: skip


@pytest.mark.parametrize("name", INPUTS)
@pytest.mark.parametrize("value", BAD)
def test_a_bad_input_gives_0_and_a_fault_that_holds_until_reset(made: InC, name: str, value: float) -> None:
    made.reset()
    clean = [made.step(**one) for one in _circle(50)]
    made.reset()
    for one in _circle(20):
        made.step(**one)
    assert made.step(**{name: value}) == 0.0
    assert made.fault
    assert [made.step(**one) for one in _circle(5)] == [0.0] * 5
    made.reset()
    assert not made.fault
    assert [made.step(**one) for one in _circle(50)] == clean


number = st.one_of(st.floats(allow_nan=True, allow_infinity=True), st.floats(-1, 1), st.sampled_from(BAD))


@settings(max_examples=150, deadline=None)
@given(st.lists(st.tuples(*[number] * len(INPUTS), st.sampled_from([1 / 4000, 0.0, -1.0, float("nan")])), max_size=12))
def test_whatever_comes_the_output_is_a_number_within_the_limit(made: InC, rows: list[tuple[float, ...]]) -> None:
    made.reset()
    for *inputs, dt in rows:
        one = dict(zip(INPUTS, inputs, strict=True))
        volts = made.step(dt=dt, **one)
        assert np.isfinite(volts)
        if made.fault:
            assert volts == 0.0
        else:
            assert abs(one["control"] + volts) <= 10.0 * (1 + 1e-12)


def test_a_voltage_beyond_the_limit_is_cut_to_it(made: InC) -> None:
    made.reset()
    assert made.step(control=9.99, acceleration=5.0) + 9.99 == pytest.approx(10.0, abs=1e-12)


def test_a_share_of_0_switches_the_feedforward_off_and_the_model_goes_on(made: InC) -> None:
    def run(share: list[float]) -> list[float]:
        made.reset()
        return [made.step(share=s, **one) for s, one in zip(share, _circle(400), strict=True)]

    on = run([1.0] * 400)
    fallen = run([1.0] * 100 + [0.0] * 100 + [1.0] * 200)
    assert fallen[:100] == on[:100]
    assert max(abs(a - b) for a, b in zip(on[100:200], fallen[100:200], strict=True)) > 0.1
    # the friction model went on; the observer, which was told the same voltages, needs some of its own time constants
    assert np.abs(np.array(on[300:]) - fallen[300:]).max() < 0.01
