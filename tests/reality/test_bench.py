"""The bench of flaws itself: its truths, its verdicts, and that its page says what a session shows."""

from dataclasses import replace
from math import inf
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.reality.bench import STEPS, Outcome, Row, glitches, run
from benchmarks.reality.judge import Number, Step, identified
from benchmarks.reality.page import page
from benchmarks.reality.results import Results
from benchmarks.reality.session import SPEEDS, Sessions, flaws
from benchmarks.reality.truth import plant_truth, static_truth, steady_force, virgin_truth
from fric.notice import Notice
from fric.records.over_strokes import over_time
from fric.records.segments import steady_segments
from tests.turns import in_turns

PAGE = Path("docs/reality.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def base():
    return Sessions("base").session(0)


def test_on_the_base_machine_the_effective_truth_is_that_of_the_machine(base) -> None:
    axis = base.axis
    found = static_truth(base, axis.plant.damping)
    for name in ("F_c", "F_s", "v_s", "sigma"):
        assert found[name] == pytest.approx(getattr(axis.friction.static, name), rel=1e-6)
    assert found["offset"] == pytest.approx(0.0, abs=1e-6)
    z = np.array([1e-7, 2e-6, 50e-6])
    np.testing.assert_allclose(virgin_truth(base, z), axis.friction.virgin_curve(z), rtol=1e-12)
    assert plant_truth(base)["A"] == axis.plant.A + 120 / 70


@pytest.mark.parametrize(
    "flaw", in_turns(["direction", "gravity", "drift", "dwell", "force-constant"], ["direction", "drift"])
)
def test_the_effective_steady_force_is_what_strokes_show(flaw: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("presliding_sine", "sliding_sine_around", "frequency_response"):
        monkeypatch.setattr(f"benchmarks.reality.session.{name}", SimpleNamespace(planned=lambda *_, **__: ()))
    monkeypatch.setattr("benchmarks.reality.session.SPEEDS", [v for v in SPEEDS if v > 3e-4])
    session = Sessions(flaw).session(0)
    shown, expected = [], []
    for trial, run_, _ in session.runs:
        log = trial.log(replace(session.axis, force_noise=0.0), run_)
        v = np.gradient(log.reference, log.time)
        for sign in (1, -1):
            there = np.flatnonzero(np.abs(v - sign * np.abs(v).max()) < 1e-6 * np.abs(v).max())
            shown.append(log.force[there[len(there) // 2 : -5]].mean())
            expected.append(steady_force(session, np.array([sign * np.abs(v).max()]))[0])
    spread = 0.06 if flaw in {"drift", "force-constant"} else 2e-3  # over the minute of the strokes these change
    np.testing.assert_allclose(shown, expected, rtol=spread)


def row(*shares: tuple[bool, bool], code: str = "sampling-jitters") -> Row:
    """Return a row of sessions on the machine that jitters, each covered or not, told or not."""
    outcomes = []
    for n, (covered, told) in enumerate(shares):
        steps = {name: Step() for name in STEPS}
        steps["plant"].numbers["A"] = Number(1.0, 0.9, 1.1, 1.0 if covered else 2.0)
        steps["static"].numbers["F_c"] = Number(1.0, -inf, inf, 2.0)
        steps["plant"].notices = [Notice("A is off", code, "wrong")] if told else []
        outcomes.append(Outcome("jitter", n, steps, None))
    return Row("jitter", tuple(outcomes))


def test_a_verdict_is_covered_told_or_silent() -> None:
    assert row(*[(True, False)] * 9, (False, False)).verdict("plant") == "covered"
    assert row(*[(True, False)] * 7, *[(False, False)] * 3).verdict("plant") == "silent"
    assert row(*[(True, False)] * 3, (False, False)).verdict("plant") == "open"  # of four sessions one may miss
    assert row(*[(True, False)] * 36, *[(False, False)] * 4).verdict("plant") == "covered"
    assert row(*[(True, False)] * 35, *[(False, False)] * 5).verdict("plant") == "silent"
    assert row(*[(True, False)] * 8, *[(False, True)] * 2).verdict("plant") == "warned"
    assert row(*[(False, True)] * 10, code="force-lags").verdict("plant") == "silent"  # it names another flaw
    assert row((False, False)).verdict("static") == "covered"
    assert row((False, True)).codes() == {"sampling-jitters": 1.0}
    crashed = row((True, True))
    crashed.outcomes[0].steps["gms"].crash = "ValueError"
    assert crashed.verdict("gms") == "silent"


def test_the_page_has_every_machine_and_says_which_are_silent() -> None:
    for flaw in flaws():
        assert f"| `{flaw}`" in PAGE
    told = page([row((False, False), (False, False))])
    assert "**silent**<br>A 0%, -50.0%" in told
    assert "Silent now: `jitter` (plant)." in told


def test_results_grow_seed_by_seed_and_are_dropped_where_the_code_is_another(tmp_path, monkeypatch) -> None:
    given = row((True, False), (False, True)).outcomes
    first = Results(tmp_path, "jitter")
    assert first.missing(3) == [0, 1, 2]
    first.add(given[1:])
    assert Results(tmp_path, "jitter").missing(3) == [0, 2]
    Results(tmp_path, "jitter").add(given[:1])
    again = Results(tmp_path, "jitter")
    assert again.missing(2) == []
    kept, whole = Row("jitter", tuple(again.outcomes)), Row("jitter", given)
    assert page([kept]) == page([whole])
    monkeypatch.setattr("benchmarks.reality.results.version", lambda flaw: "of other code")
    assert Results(tmp_path, "jitter").missing(2) == [0, 1]
    assert Results(tmp_path, "jitter", any_version=True).missing(2) == []


@pytest.mark.long
@pytest.mark.parametrize("flaw", flaws())
def test_a_session_on_each_machine_ends_in_numbers_or_words(flaw: str) -> None:
    (outcome,) = run(flaw, [1])
    for step in outcome.steps.values():
        assert not step.crash
        assert step.numbers or step.failure


@pytest.mark.long(40)
@pytest.mark.parametrize("seed", [0, 2])
def test_a_machine_that_drifts_is_surely_said_to_drift(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """F_s is 2 sd off there; of 20 sessions 8 had the drift as likely alone, which no verdict counts."""
    for name in ("presliding_sine", "sliding_sine_around", "frequency_response"):
        monkeypatch.setattr(f"benchmarks.reality.session.{name}", SimpleNamespace(planned=lambda *_, **__: ()))
    strokes = [(log, part) for log in Sessions("drift").session(seed).logs["constant-velocity"]
               for part in steady_segments(log)]  # fmt: skip
    found = over_time(strokes)
    assert found is not None
    assert found.sure
    assert found.change == pytest.approx(-0.11, abs=0.02)


@pytest.mark.long(6)
def test_the_circle_is_that_of_what_was_identified_and_of_the_machine(base) -> None:
    verdict = identified(base)
    found = glitches("base", verdict)
    assert found is not None
    for scheme in ("a", "c"):
        assert found.predicted[scheme] == pytest.approx(found.done[scheme], rel=0.05, abs=0.3e-6)
    assert found.done["a"] > 40e-6 > 10 * found.done["c"]
