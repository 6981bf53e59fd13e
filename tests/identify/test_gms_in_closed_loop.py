"""The issue's own experiment: the paper's machine in closed loop, as a drive logs it."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import fric
from fric.circles.measured import measured_from_run
from fric.circles.tune import tune
from fric.control.scheme import PAPER_SCHEMES
from fric.drive.sensing import Encoder
from fric.friction.gms import GMS
from fric.identify.gms.identify import identify_gms
from fric.simulate.contour_run import Circle, run_circle
from fric.simulate.experiment import experiment
from fric.simulate.machine import NominalFriction
from tests.identify.presliding import PAPER, TABLE_1, rms_error

MACHINE = Path(__file__).parents[2] / "configs/xy-table.yaml"


@cache
def axis():
    return fric.read_machine(MACHINE).axes["x"]


@cache
def quiet(kind):
    """Return the records of an experiment without noise; it is added a seed at a time."""
    return tuple(experiment(replace(axis(), force_noise=0.0), kind))


def noisy(kind, seed):
    made = []
    for n, log in enumerate(quiet(kind)):
        noise = np.random.default_rng([seed, n]).standard_normal(len(log))
        made.append(replace(log, force=log.force + noise))
    return made


@pytest.mark.long(50)
def test_every_seed_is_within_one_newton_and_three_blocks():
    errors = []
    for seed in range(20):
        fit = identify_gms(noisy("presliding-sine", seed), static=PAPER, plant=axis().plant)
        errors.append(rms_error(fit.model))
        assert len(fit.blocks) == 3
        assert "blocks: another lowers" in fit.choice.reason
    assert max(errors) < 1.0


@pytest.mark.long(10)
def test_C_within_a_fifth_and_covered():
    logs = [*noisy("presliding-sine", 0), *noisy("sliding-sine", 0)]
    fit = identify_gms(logs, static=PAPER, plant=axis().plant)
    low, high = fit.C.ci95
    assert low < TABLE_1.C < high
    assert float(fit.C) == pytest.approx(TABLE_1.C, rel=0.2)


@pytest.mark.long(10)
def test_noise_free_and_unquantised_the_virgin_curve_is_exact_to_a_thousandth():
    ideal = replace(axis(), encoder=Encoder(0.0), force_noise=0.0)
    fit = identify_gms(list(experiment(ideal, "presliding-sine")), static=PAPER, plant=ideal.plant)
    z = np.linspace(0.0, 100e-6, 1001)[1:]
    assert np.sqrt(np.mean((fit.curve(z) - TABLE_1.virgin_curve(z)) ** 2)) < 1e-3 * PAPER.F_s
    assert rms_error(fit.model) < 1e-3 * PAPER.F_s


@pytest.mark.long(60)
def test_fewer_blocks_than_the_machine_has_hold_their_own_mean_and_the_curve_is_in_its_band():
    """Ten blocks in closed loop: alpha and k held their own mean in 37 to 47 %, the curve its band in 21 %."""
    slip, share = np.geomspace(0.6e-6, 85e-6, 10), np.array([20, 16, 13, 11, 10, 9, 8, 6, 4, 3]) / 100
    ten = replace(axis().friction, alpha=tuple(share), k=tuple(share * PAPER.F_s / slip))
    machine = replace(axis(), friction=ten, force_noise=0.0)
    logs = [*experiment(machine, "presliding-sine"), *experiment(machine, "sliding-sine")]
    fits, inside = [], []
    for seed in range(8):
        made = [replace(log, force=log.force + np.random.default_rng([seed, n]).standard_normal(len(log)))
                for n, log in enumerate(logs)]  # fmt: skip
        fits.append(identify_gms(made, static=PAPER, plant=machine.plant, blocks=6))
        curve = fits[-1].curve
        inside.append(np.abs(curve.force - ten.virgin_curve(curve.displacement)) < curve.band)
    values = np.array([[*fit.alpha.value, *fit.k.value] for fit in fits])
    limits = np.array([[*fit.alpha.ci95, *fit.k.ci95] for fit in fits])
    mean = values.mean(axis=0)
    held = np.mean((limits[:, :, 0] <= mean) & (mean <= limits[:, :, 1]), axis=0)
    assert held.mean() >= 0.95
    assert held.min() >= 0.75  # of each alone: alpha_1 and k_1 in 67 %, where a start decided which place blocks took
    assert np.mean(inside) >= 0.9
    assert all(fit.C.ci95[0] < 1e4 < fit.C.ci95[1] for fit in fits)


@pytest.mark.long(60)
def test_blocks_of_another_law_leave_on_circles_what_parameters_tuned_from_two_leave():
    """Elements that yield one by one (Iwan) were taken by two blocks: (c) left 2.9 µm, tuned 0.8; now 0.12 and 0.08."""
    scheme, feeds = PAPER_SCHEMES["c"], (0.1, 0.01)

    def identified(subject):
        static, slip = subject.friction.static, 40e-6 * np.linspace(0.03, 1.0, 20)
        law = GMS(static, (0.05,) * 20, tuple(0.05 * static.F_s / slip), subject.friction.C)
        subject = replace(subject, friction=law)
        fit = identify_gms(list(experiment(subject, "presliding-sine")), static=static, plant=subject.plant, places=1)
        assert len(fit.blocks) > 3
        models = {**subject.nominal_friction.models, "gms": replace(fit.model, C=law.C), "static": static}
        return replace(subject, nominal_friction=NominalFriction(models, 1.0, subject.plant.T_d))

    def glitches(machine):
        runs = [run_circle(machine, scheme, Circle(feed=feed), accuracy=1e-8, places=1) for feed in feeds]
        return runs, np.array([run.chance().median for run in runs])

    machine = fric.read_machine(MACHINE)
    machine = replace(machine, axes={name: identified(one) for name, one in machine.axes.items()})
    runs, left = glitches(machine)
    _, tuned = glitches(tune(machine, [measured_from_run(run) for run in runs]).machine)
    assert (left < tuned + 0.2e-6).all(), (left, tuned)
