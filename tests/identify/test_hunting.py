"""Where a slow sine hunts from one encoder count to the next, the intervals of a GMS model hold the truth."""

from dataclasses import replace
from functools import cache
from math import degrees

import numpy as np
import pytest

import fric
from fric.design.cascade import assess_cascade
from fric.drive.plant import Plant
from fric.drive.sensing import Encoder
from fric.friction.gms import GMS
from fric.identify.gms import hunting
from fric.identify.gms.hunting import LAGS, MEMORY, Hunting, hunting_share, usual_cascade
from fric.identify.gms.identify import identify_gms
from fric.identify.replay import replay_fit
from fric.simulate.experiment import experiment
from tests.identify.presliding import PAPER, record

THREE = GMS(PAPER, (0.565, 0.396, 0.039), (99.94e6, 2.445e6, 0.119e6), 1e4)
"""Table 1 of the paper with the two blocks in one that slip alike."""


@cache
def axis(name="x"):
    found = fric.read_machine("xy-table").axes[name]
    size = found.friction.static.F_s / PAPER.F_s
    static = replace(PAPER, F_c=size * PAPER.F_c, F_s=size * PAPER.F_s)
    return replace(found, friction=replace(THREE, static=static, k=tuple(size * k for k in THREE.k)))


def fitted(subject, perturbed=0):
    """Return the fit to sines of an axis whose B differs by so many times 1e-13: its counts fall elsewhere."""
    moved = replace(subject, plant=replace(subject.plant, B=subject.plant.B * (1 + 1e-13 * perturbed)))
    logs = experiment(moved, "presliding-sine", seed=perturbed)
    return identify_gms(logs, static=subject.friction.static, plant=subject.plant, blocks=3)


def held(fit, truth):
    limits = np.array([*fit.alpha.ci95, *fit.k.ci95])
    return (limits[:, 0] <= [*truth.alpha, *truth.k]) & ([*truth.alpha, *truth.k] <= limits[:, 1])


@pytest.mark.long(4)
def test_the_interval_of_a_share_holds_the_truth_only_with_what_hunting_adds(monkeypatch):
    """alpha_1 is 0.0065 too low, ± 0.001 from run to run; its half-width is 0.003, and 0.012 with what hunting adds."""
    monkeypatch.setattr(replay_fit, "levels_of", lambda *_: None)  # of motions logged once
    with_it = fitted(axis())
    monkeypatch.setattr(Hunting, "__call__", lambda self, search, x, seen: np.zeros((seen.shape[1],) * 2))
    without = fitted(axis())
    assert with_it.alpha.value == without.alpha.value
    assert not without.alpha.ci95[0][0] < THREE.alpha[0] < without.alpha.ci95[0][1]
    assert with_it.alpha.ci95[0][0] < THREE.alpha[0] < with_it.alpha.ci95[0][1]


@pytest.mark.long(60)
@pytest.mark.parametrize("name", ["x", "y"])
def test_intervals_hold_the_truth_in_runs_that_differ_by_rounding(name):
    """In 97 % and 100 % of five runs each; in 60 % and 73 % before. The chance of under 75 % in six is below 1e-3."""
    subject = axis(name)
    share = np.mean([held(fitted(subject, n), subject.friction) for n in range(6)])
    assert share > 0.75


@pytest.mark.long(15)
def test_without_a_plant_too_intervals_hold_the_truth_on_heavy_and_light_axes():
    """In all of two runs each, in 73 % before; in 90 % over 20 machines of drawn mass, stiffness and friction."""
    shares = []
    for seed, heavier in enumerate((0.5, 0.7, 1.0, 1.4, 2.0)):
        base = axis("xy"[seed % 2])
        loop = replace(base.cascade, K_p=heavier * base.cascade.K_p, K_i=heavier * base.cascade.K_i)
        moved = replace(base, plant=replace(base.plant, B=base.plant.B / heavier), cascade=loop)
        logs = list(experiment(moved, "presliding-sine", seed=seed))
        shares.append(held(identify_gms(logs, static=moved.friction.static, blocks=3), moved.friction))
    assert np.mean(shares) > 0.85


@pytest.mark.long(2)
def test_without_counts_nothing_is_added(monkeypatch):
    """The same to the last digit, and no record is made again."""
    monkeypatch.setattr("fric.identify.gms.hunting.run_axis", None)
    fit = fitted(replace(axis(), encoder=Encoder(0.0)))
    assert max(one.record.motion.step for one in fit.hysteresis) == 0.0
    assert held(fit, THREE)[0]


@pytest.mark.parametrize("T_d", [0.13e-3, 0.65e-3, 3e-3])
@pytest.mark.parametrize("A", [0.0, 28.57, 200.0])
@pytest.mark.parametrize("lags", LAGS)
def test_the_usual_cascades_have_usual_margins(A, T_d, lags):
    plant = Plant(A, 4.526, T_d, 548.0)
    found = assess_cascade(plant, usual_cascade(plant, 4000.0, lags))
    for margins in (found.velocity, found.position):
        assert degrees(margins.phase_margin) > 50.0
        assert margins.gain_margin > 2.5


def test_noise_of_the_force_is_not_taken_for_hunting():
    """The ratio of rms was: 95 % of the variance of alpha and k was of hunting along motions in which nothing hunts.

    Their errors were 0.29 standard errors, and are 0.77; of the independent simulator, no plant known, 0.64 and 0.86.
    """
    rng, n = np.random.default_rng(0), 10_000
    noise, ripple = rng.standard_normal(n), np.convolve(rng.standard_normal(n + 4), np.full(5, 0.2**0.5), "valid")

    def share(*residuals):
        found = [np.array([r[k:] @ r[: n - k] / n for k in range(MEMORY + 1)]) for r in residuals]
        return hunting_share(*found, n)

    assert share(noise, 1.5 * ripple) < 0.15  # 0.67 by rms: two standard errors of noise are left
    assert share(0.5 * ripple, ripple) == pytest.approx(0.5, abs=0.02)
    assert share(0.5 * ripple + noise, ripple) == pytest.approx(0.5, abs=0.06)  # 1.12 by rms
    assert share(3.0 * ripple, ripple) == pytest.approx(3.0, abs=1e-9)  # not above the rms ratio


def test_a_sine_too_slow_for_a_simulated_cycle_adds_nothing(monkeypatch):
    """With an hour a cycle, a million samples of a controller at 4 kHz are over before it reverses; here 8,000 are."""
    monkeypatch.setattr(hunting, "MOST_SIMULATED", 8000)
    fit = identify_gms([record(15e-6)], static=PAPER, blocks=2)
    assert np.isfinite(fit.alpha.ci95).all()
