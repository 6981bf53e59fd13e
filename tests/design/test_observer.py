from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from scipy.signal import freqz

from fric.control.base import Setting
from fric.control.inverse_model import DisturbanceObserver
from fric.control.q_filter import Q_FILTERS, QFilter
from fric.design.loop import SampledLoop, decibel, margins
from fric.design.observer import (
    StructuralMode,
    WholeLoop,
    design_observer,
    measured_perturbation,
    model_perturbation,
    robust_limit,
)
from fric.errors import FricError
from fric.log import FrequencyResponse
from tests.design.plants import CASCADE_X, CASCADE_Y, X, Y

NO_DELAY = replace(X, T_d=0.0)


def response(f: np.ndarray, G: np.ndarray, coherence: np.ndarray | None = None) -> FrequencyResponse:
    return FrequencyResponse(f, np.abs(G), np.unwrap(np.angle(G)), coherence)


def test_the_sixty_hertz_observer_has_the_margins_of_the_notes() -> None:
    """PM 32°, GM 10.5 dB, Ms 5.8 dB of the whole loop, to 1° and 0.2 dB."""
    found = design_observer(X, CASCADE_X, cutoff=60.0).input
    assert np.degrees(found.phase_margin) == pytest.approx(32, abs=1)
    assert decibel(found.gain_margin) == pytest.approx(10.5, abs=0.2)
    assert decibel(found.peak_sensitivity) == pytest.approx(5.8, abs=0.2)


def test_sixty_hertz_is_about_where_six_decibel_are_reached() -> None:
    for plant, cascade in ((X, CASCADE_X), (Y, CASCADE_Y)):
        design = design_observer(plant, cascade)
        assert design.observer.q.cutoff == pytest.approx(63, abs=4)
        assert "peak sensitivity" in design.reason
        assert decibel(design.input.peak_sensitivity) == pytest.approx(6.0, abs=1e-3)


@pytest.mark.parametrize("name", Q_FILTERS)
def test_a_pure_delay_of_650_microseconds_limits_every_q_between_355_and_385_hertz(name: str) -> None:
    limit = robust_limit(model_perturbation(X, 2000.0), name)
    assert limit.q is not None
    assert 355 < limit.q.bandwidth < 385
    # |Delta| = 2 |sin(π f T_d)| by hand, and Q touches 1/|Delta| from below.
    assert limit.size == pytest.approx(2 * np.sin(pi * limit.frequency * 0.65e-3), rel=1e-9)
    f = np.geomspace(1, 2000, 50_000)
    product = np.abs(limit.q.response(f)) * 2 * np.abs(np.sin(pi * f * 0.65e-3))
    assert product.max() == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize(("frequency", "damping", "share"), [(180.0, 0.02, 1.0), (300.0, 0.01, 0.5), (90.0, 0.05, 2.0)])
def test_a_resonance_limits_q_where_the_hand_calculation_says(frequency: float, damping: float, share: float) -> None:
    """Without delay |Delta| = share·x²/√((1 − x²)² + 4ζ²x²), x = f/f_r, and binomial2 has |Q| = 1/(1 + (f/f_c)²).

    |Q·Delta| ≤ 1 for every x is f_c² ≤ f_r²·x²/(|Delta| − 1); for light damping the least is close to x = 1, where
    |Delta| = share/(2ζ): f_c = f_r/√(share/(2ζ) − 1).
    """
    limit = robust_limit(model_perturbation(NO_DELAY, 2000.0, [StructuralMode(frequency, damping, share)]))
    assert limit.q is not None
    at_peak = frequency / sqrt(share / (2 * damping) - 1)
    assert limit.q.cutoff == pytest.approx(at_peak, rel=0.02)
    x = np.linspace(0.5, 1.5, 2_000_001)
    size = share * x**2 / np.sqrt((1 - x**2) ** 2 + 4 * damping**2 * x**2)
    exact = np.sqrt(np.min(frequency**2 * x[size > 1] ** 2 / (size[size > 1] - 1)))
    assert limit.q.cutoff == pytest.approx(exact, rel=5e-5)


def test_a_resonance_that_decides_is_named() -> None:
    Delta = model_perturbation(X, 2000.0, [StructuralMode(20.0, 0.03, 0.3)])
    design = design_observer(X, CASCADE_X, perturbation=Delta)
    assert "eq. (8)" in design.reason
    assert design.robust.frequency == pytest.approx(20, rel=0.02)
    assert design.observer.q == design.robust.q


@pytest.mark.parametrize("name", Q_FILTERS)
def test_a_measured_response_of_the_model_gives_the_limit_of_the_model(name: str) -> None:
    f = np.arange(1.0, 1500.0, 1.0)
    measured = robust_limit(measured_perturbation(response(f, X.response(f)), X), name)
    model = robust_limit(model_perturbation(X, 2000.0), name)
    assert measured.q is not None
    assert model.q is not None
    assert measured.q.cutoff == pytest.approx(model.q.cutoff, rel=1e-4)


def test_a_response_from_sample_to_sample_has_the_hold_in_it_and_leaves_nothing_unmodelled() -> None:
    f = np.arange(1.0, 1500.0, 1.0)
    G = SampledLoop(X, CASCADE_X).G(f)
    Delta = measured_perturbation(response(f, G), X, sampling=4000.0)
    np.testing.assert_allclose(Delta.ratio, 1.0, atol=1e-9)
    assert np.abs(measured_perturbation(response(f, G), X).ratio[-1] - 1.0) > 0.1


def test_a_line_that_the_plant_was_not_fitted_to_limits_no_observer() -> None:
    """A harmonic of friction at 7 Hz, left out of the plant, held the bandwidth at 57 Hz."""
    f = np.arange(1.0, 1500.0, 1.0)
    G = X.response(f)
    G[6] *= 2.5
    clean, marred, without = (
        robust_limit(measured_perturbation(response(f, values), X, deviating=lines)).q
        for values, lines in ((X.response(f), ()), (G, ()), (G, (7.00001,)))
    )
    assert clean is not None
    assert marred is not None
    assert without is not None
    assert marred.cutoff < 0.2 * clean.cutoff
    assert without.cutoff == pytest.approx(clean.cutoff, rel=1e-6)


def test_less_coherence_means_less_bandwidth() -> None:
    f = np.arange(1.0, 1500.0, 1.0)
    limits = []
    for gamma2 in (1.0, 0.99, 0.9, 0.6):
        Delta = measured_perturbation(response(f, X.response(f), np.full(f.size, gamma2)), X, averages=8)
        limits.append(robust_limit(Delta))
    cutoffs = [limit.q.cutoff for limit in limits if limit.q is not None]
    assert len(cutoffs) == 4
    assert cutoffs == sorted(cutoffs, reverse=True)
    assert cutoffs[0] > 1.2 * cutoffs[-1]


def test_confidence_circle_holds_95_of_100_measured_responses() -> None:
    """Responses averaged over n records with noise of a known coherence: Delta lies in its circle 95 % of the time."""
    rng = np.random.default_rng(7)
    f, n, gamma2 = np.full(4000, 100.0) + np.arange(4000) * 1e-6, 16, 0.9
    G = X.response(f)
    spread = np.abs(G) * np.sqrt((1 - gamma2) / gamma2 / 2)  # real and imaginary part, of one record
    errors = rng.normal(size=(2, n, f.size)).mean(axis=1) * spread
    Delta = measured_perturbation(response(f, G + errors[0] + 1j * errors[1], np.full(f.size, gamma2)), X, averages=n)
    true = np.exp(-2j * pi * f * X.T_d) - 1
    inside = np.mean(np.abs(Delta.Delta - true) < Delta.radius)
    assert inside == pytest.approx(0.95, abs=0.012)


def test_a_given_cutoff_beyond_a_limit_is_refused_with_the_nearest_that_holds() -> None:
    with pytest.raises(FricError, match="beyond the limit by the peak sensitivity") as refused:
        design_observer(X, CASCADE_X, cutoff=160.0)
    nearest = float(refused.value.hint.split("is ")[1].split()[0])
    assert design_observer(X, CASCADE_X, cutoff=nearest).observer.q.cutoff == nearest


def test_a_loop_that_is_too_sensitive_without_an_observer_is_refused() -> None:
    loud = replace(CASCADE_X, K_p=3 * CASCADE_X.K_p, K_i=3 * CASCADE_X.K_i)
    with pytest.raises(FricError, match="without any observer"):
        design_observer(X, loud)


def test_stability_of_a_loop_with_resonance_agrees_with_the_eigenvalues_of_a_plant_that_has_the_same_response() -> None:
    """A true B twice as large is Delta = 1 at all frequencies: the winding test must see what the eigenvalues see."""
    observer = DisturbanceObserver(QFilter(), X.A, X.B)
    loop = SampledLoop(X, CASCADE_X, (observer,))
    edge = margins(loop.input, loop.nyquist).gain_margin
    f = np.arange(0.5, 2000.0, 0.5)
    for factor, stable in ((0.98 * edge, True), (1.02 * edge, False)):
        true = replace(X, B=factor * X.B)
        assert SampledLoop(true, CASCADE_X, (observer,), setting=Setting(X, CASCADE_X)).stable is stable
        whole = WholeLoop(X, CASCADE_X, measured_perturbation(response(f, true.response(f)), X))
        assert np.isfinite(whole.peak((observer,))) == stable


def test_what_a_response_cannot_tell_is_said() -> None:
    f = np.arange(1.0, 120.0, 1.0)
    design = design_observer(X, CASCADE_X, perturbation=measured_perturbation(response(f, X.response(f)), X))
    found = {warning.code: warning for warning in design.warnings}
    assert {"response-ends", "response-without-confidence"} <= found.keys(), found
    with pytest.raises(FricError, match="frequency is 0 in row 1"):
        response(np.arange(3.0), np.ones(3, complex))


def noisy(at: float, coherence: float) -> FrequencyResponse:
    """Return the response of X with one line that puts the loop near -1, and as well known as it says."""
    f = np.arange(1.0, 1900.0, 1.0)
    G, known = X.response(f), np.full(f.size, 0.9999)
    G[f == at] *= -0.8 / SampledLoop(X, CASCADE_X).input(f[f == at])
    known[f == at] = coherence
    return response(f, G, known)


def test_the_controller_is_blamed_only_where_the_response_is_good() -> None:
    """The loop is at 4 dB without an observer; one line is not, and there the loop is not to be blamed."""
    with pytest.raises(FricError, match=r"response does not tell.* at 70 Hz"):
        design_observer(X, CASCADE_X, perturbation=measured_perturbation(noisy(70.0, 0.05), X))
    with pytest.raises(FricError, match="without any observer"):
        design_observer(X, CASCADE_X, perturbation=measured_perturbation(noisy(70.0, 0.9999), X))


def test_no_loop_is_recommended_that_misses_the_peak_on_the_measured_response() -> None:
    """M_s is taken of the open loop with the measured response itself, line by line, apart from the design."""
    f = np.geomspace(1.0, 1900.0, 800)
    mode = StructuralMode(140.0, 0.08, 0.15)
    G = X.response(f) * (1.0 + mode.response(f))
    design = design_observer(X, CASCADE_X, perturbation=measured_perturbation(response(f, G, np.full(800, 0.999)), X))
    loop = SampledLoop(X, CASCADE_X, (design.observer,))
    L = loop.input(f) * G / X.response(f)
    assert decibel(float((1 / np.abs(1 + L)).max())) <= 6.0 + 1e-3
    assert design.observer.q.cutoff < design_observer(X, CASCADE_X).observer.q.cutoff


def test_no_resonance_is_refused() -> None:
    for wrong in ((0.0, 0.1, 1.0), (10.0, 0.0, 1.0), (10.0, 1.5, 1.0), (10.0, 0.1, 0.0)):
        with pytest.raises(FricError):
            StructuralMode(*wrong)


def test_a_peak_sensitivity_that_no_loop_has_is_refused() -> None:
    with pytest.raises(FricError, match="a peak sensitivity of"):
        design_observer(X, CASCADE_X, peak_sensitivity=1.0)


@pytest.mark.parametrize("name", Q_FILTERS)
def test_t_of_the_observer_loop_is_q(name: str) -> None:
    """Plant and observer alone, at the plant's input, are L = F·G/(1 − Q): T = L/(1 + L) is Q for the nominal G.

    The nominal plant behind a hold is G with T_d = T_s/2, and F and Q are here the difference equations that run.
    """
    observer = DisturbanceObserver(QFilter(name, 60.0), X.A, X.B)
    loop = SampledLoop(replace(X, T_d=0.5 / 4000), CASCADE_X, (observer,))
    f, both = np.geomspace(1.0, 400.0, 50), observer.discrete(4000.0)
    F, Q = (freqz(equation.b, equation.a, f, fs=4000.0)[1] for equation in (both.inverse, both.low_pass))
    L = F * loop.G(f) / (1 - Q)
    assert np.abs(L / (1 + L)) == pytest.approx(np.abs(observer.q.response(f)), abs=0.01)


@pytest.mark.parametrize("hidden", [2.5, 0.3])
def test_lines_that_friction_hides_do_not_hold_Q_down(hidden: float):
    """The lowest lines of an axis with friction tell nothing of its plant: a deviation of 2.5 is no plant."""
    f = np.arange(2.0, 500.0, 2.0)
    plant = X
    G = plant.response(f)
    off = np.where(f < 6, 1 + hidden, 1.0)
    told = FrequencyResponse(f, off * np.abs(G), np.unwrap(np.angle(G)), deviation=np.where(f < 6, hidden, 1e-3))
    found = measured_perturbation(told, plant)
    assert found.frequency[0] == 6.0
    sure = measured_perturbation(replace(told, magnitude=np.abs(G), deviation=np.full(f.size, 1e-3)), plant)
    assert robust_limit(found).q.cutoff == pytest.approx(robust_limit(sure).q.cutoff, rel=1e-6)
