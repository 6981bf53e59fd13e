from dataclasses import replace
from itertools import product
from math import inf, radians

import numpy as np
import pytest

from fric.design.cascade import Requirement, assess_cascade, check_cascade, design_cascade
from fric.design.loop import SampledLoop, decibel, margins
from fric.drive.plant import LinearPlant
from fric.errors import FricError
from tests.design.plants import CASCADE_X, CASCADE_Y, X, Y
from tests.turns import in_turns


def test_the_cascade_of_the_notes_has_the_margins_of_the_notes() -> None:
    """K_p 83.7, K_i 3156, K_v 126 on x: 68° and 13.9 dB, 73° and 19.1 dB, to 1° and 0.2 dB."""
    design = assess_cascade(X, CASCADE_X)
    assert np.degrees(design.velocity.phase_margin) == pytest.approx(68, abs=1)
    assert decibel(design.velocity.gain_margin) == pytest.approx(13.9, abs=0.2)
    assert np.degrees(design.position.phase_margin) == pytest.approx(73, abs=1)
    assert decibel(design.position.gain_margin) == pytest.approx(19.1, abs=0.2)
    assert design.velocity.crossover == pytest.approx(60, rel=0.01)


def test_the_margins_of_the_notes_are_those_of_the_continuous_loop() -> None:
    """The same loop with s/(1 + s/ω) for the velocity and e^(-s·T_d) for delay and hold: the notes' values, as printed.

    The sampled loop differs by what continuous time leaves out: 0.4° and 0.2 dB at most.
    """

    def blocks(f: np.ndarray) -> tuple[np.ndarray, ...]:
        s = 2j * np.pi * f
        return s, X.response(f), 83.7 + 3156.0 / s, s / (1 + s / (2 * np.pi * 500)), 1 / (1 + s / (2 * np.pi * 60)) ** 2

    def velocity(f: np.ndarray) -> np.ndarray:
        _, G, C, D, _ = blocks(f)
        return C * G * D

    def position(f: np.ndarray) -> np.ndarray:
        _, G, C, D, _ = blocks(f)
        return 126.0 * C * G / (1 + C * G * D)

    def with_observer(f: np.ndarray) -> np.ndarray:
        s, G, C, D, Q = blocks(f)
        return G * (C * (D + 126.0) + Q * s * (s + X.A) / X.B) / (1 - Q)

    for loop, phase, gain in ((velocity, 68, 13.9), (position, 73, 19.1), (with_observer, 32, 10.5)):
        found = margins(loop, 2000.0)
        assert np.degrees(found.phase_margin) == pytest.approx(phase, abs=0.55)
        assert decibel(found.gain_margin) == pytest.approx(gain, abs=0.05)
    assert decibel(margins(with_observer, 2000.0).peak_sensitivity) == pytest.approx(5.8, abs=0.05)


@pytest.mark.parametrize(("plant", "cascade"), [(X, CASCADE_X), (Y, CASCADE_Y)])
def test_the_default_rule_gives_the_gains_of_the_notes(plant: LinearPlant, cascade: object) -> None:
    found = design_cascade(plant).cascade
    for gain in ("K_p", "K_i", "K_v"):
        assert getattr(found, gain) == pytest.approx(getattr(cascade, gain), rel=0.02)


@pytest.mark.parametrize(
    ("phase", "gain"), in_turns(product((30.0, 60.0, 80.0), (6.0, 20.0)), [(30.0, 20.0), (60.0, 6.0), (80.0, 6.0)])
)
def test_a_design_has_the_margins_asked_for_and_one_of_them_is_used_up(phase: float, gain: float) -> None:
    asked = Requirement(radians(phase), 10 ** (gain / 20))
    design = design_cascade(X, asked)
    assert asked.met(design.velocity)
    assert asked.met(design.position)
    assert min(
        design.velocity.phase_margin / asked.phase_margin, design.velocity.gain_margin / asked.gain_margin
    ) == pytest.approx(1.0, abs=1e-6)
    faster = replace(design.cascade, K_p=design.cascade.K_p * 1.01, K_i=design.cascade.K_i * 1.01)
    loop = SampledLoop(X, faster)
    assert loop.stable
    with pytest.raises(FricError, match="velocity loop has a phase margin"):
        check_cascade(X, faster, asked)


def test_a_faster_plant_takes_the_gain_off_and_nothing_else() -> None:
    """B enters the loop as a factor alone: twice B is half K_p and K_i, with the same K_v and margins."""
    once, twice = (design_cascade(replace(X, B=X.B * factor)) for factor in (1.0, 2.0))
    assert twice.cascade.K_p == pytest.approx(once.cascade.K_p / 2)
    assert twice.cascade.K_i == pytest.approx(once.cascade.K_i / 2)
    assert twice.cascade.K_v == pytest.approx(once.cascade.K_v)
    assert twice.input.phase_margin == pytest.approx(once.input.phase_margin)


def test_more_delay_makes_a_slower_cascade() -> None:
    speeds = [design_cascade(replace(X, T_d=T_d)).velocity.crossover for T_d in (0.2e-3, 0.65e-3, 2e-3, 6e-3)]
    assert speeds == sorted(speeds, reverse=True)
    assert speeds[0] > 5 * speeds[-1]


def test_what_misses_its_margins_is_refused_with_the_nearest_that_holds() -> None:
    with pytest.raises(
        FricError, match=r"velocity loop has a phase margin of 5\d\.\d° and a gain margin of 9\.\d dB"
    ) as refused:
        design_cascade(X, crossover=100.0)
    words = refused.value.hint.replace(",", "").split()
    named = {gain: float(words[words.index(gain) + 1]) for gain in ("K_p", "K_i", "K_v")}
    best = design_cascade(X).cascade
    for gain, value in named.items():
        assert value == pytest.approx(getattr(best, gain), rel=1e-3)
    assert check_cascade(X, replace(best, **named))  # as it is printed, it does hold


def test_what_is_unstable_is_refused_with_the_nearest_that_holds() -> None:
    fast = replace(CASCADE_X, K_p=10 * CASCADE_X.K_p, K_i=10 * CASCADE_X.K_i)
    with pytest.raises(FricError, match="velocity loop is unstable") as refused:
        check_cascade(X, fast)
    words = refused.value.hint.replace(",", "").split()
    K_p, K_i = float(words[words.index("K_p") + 1]), float(words[words.index("K_i") + 1])
    assert K_i / K_p == pytest.approx(CASCADE_X.K_i / CASCADE_X.K_p, rel=1e-3)
    assert check_cascade(X, replace(CASCADE_X, K_p=K_p, K_i=K_i)).velocity.gain_margin > 4.8


def test_a_position_gain_that_is_too_high_is_lowered_only_as_far_as_it_must() -> None:
    with pytest.raises(FricError, match="position loop has a phase margin") as refused:
        check_cascade(X, replace(design_cascade(X).cascade, K_v=400.0))
    K_v = float(refused.value.hint.split("K_v ")[1].split()[0])
    assert 126 < K_v < 400


def test_margins_beyond_reach_are_refused_with_the_best_there_is() -> None:
    with pytest.raises(FricError, match="100°") as refused:
        design_cascade(X, Requirement(radians(100.0)))
    assert "nearest that holds" in refused.value.hint


def test_a_plant_faster_than_the_hold_of_its_controller_is_refused() -> None:
    with pytest.raises(FricError, match="shorter than half a sample"):
        design_cascade(replace(X, T_d=1e-5))


def test_an_integral_free_loop_has_no_lower_gain_limit() -> None:
    design = assess_cascade(X, replace(CASCADE_X, K_i=0.0))
    assert design.velocity.gain_reduction == 0.0
    assert "gain_reduction" not in design.velocity.as_dict()
    assert assess_cascade(X, CASCADE_X).input.gain_reduction > 0.0
    assert design.velocity.bandwidth < inf


@pytest.mark.parametrize(
    ("phase", "gain"), [(0.0, 2.0), (-10.0, 2.0), (190.0, 2.0), (60.0, 1.0), (60.0, 0.7), (60.0, inf)]
)
def test_what_is_no_margin_is_refused(phase: float, gain: float) -> None:
    with pytest.raises(FricError, match="are not margins"):
        Requirement(radians(phase), gain)


def test_a_velocity_filter_that_lets_nothing_through_is_refused() -> None:
    with pytest.raises(FricError, match="lets no velocity through"):  # the gain was 1/0
        design_cascade(X, velocity_filter=1e-300)
