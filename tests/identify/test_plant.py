"""Eq. (1) from frequency responses: accuracy, intervals that cover, what friction does to A."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fric.documents.machine_files import read_machine
from fric.drive.plant import LinearPlant
from fric.errors import FricError
from fric.identify.plant.identify import PlantFit, identify_plant
from fric.log import FrequencyResponse, Log
from fric.plausibility import lifted
from fric.reference import Reference
from fric.reference import multisine as reference_multisine
from fric.simulate.axis import run_axis
from tests.chance import fewest, most
from tests.identify.excited_axis import RATE, X, Y, excite, multisine, shaken

F_C = 0.19  # volts: 105 N over 548 N/V


def resting(amplitude: float, **options: float) -> Log:
    """Return an axis whose reference is a multisine around a resting mean [m]."""
    lines = np.unique(np.rint(np.geomspace(2, 400, 60)).astype(int))
    tall = multisine(lines, 4000, np.random.default_rng(3))
    r = np.tile(tall / np.abs(tall).max() * amplitude, 7)
    return replace(excite(X, seed=5, reference=r, skip=4000, **options), name=f"{amplitude}")


def inside(fit: PlantFit, plant: LinearPlant) -> list[bool]:
    return [fit.estimates[n].ci95[0] <= getattr(plant, n) <= fit.estimates[n].ci95[1] for n in ("A", "B", "T_d")]


@pytest.mark.long
@pytest.mark.parametrize("plant", [X, Y], ids="xy")
def test_accuracy_and_cover_of_200_seeds(plant: LinearPlant) -> None:
    """A within 2 %, B within 1 %, T_d within 20 µs for each seed; 95 % intervals cover as often as they say.

    Chance of failing: below one in a thousand to each side of each of three numbers.
    """
    covered = np.zeros(3)
    for seed in range(200):
        fit = identify_plant([shaken(plant, seed=seed)])
        assert pytest.approx(plant.A, rel=0.02) == fit.plant.A
        assert pytest.approx(plant.B, rel=0.01) == fit.plant.B
        assert fit.plant.T_d == pytest.approx(plant.T_d, abs=20e-6)
        covered += inside(fit, plant)
    assert np.all(covered >= fewest(200))
    assert np.all(covered <= most(200))


@pytest.mark.parametrize("plant", [X, Y], ids="xy")
def test_a_few_seeds(plant: LinearPlant) -> None:
    for seed in range(3):
        fit = identify_plant([shaken(plant, seed=1000 + seed)])
        assert pytest.approx(plant.A, rel=0.02) == fit.plant.A
        assert pytest.approx(plant.B, rel=0.01) == fit.plant.B
        assert fit.plant.T_d == pytest.approx(plant.T_d, abs=20e-6)


@pytest.mark.parametrize("faster", [30.0, 100.0])
def test_the_intervals_of_a_faster_axis_are_as_wide(faster: float) -> None:
    """Those of an axis of A above 3000 1/s were of no width, and A was 9 % off."""
    f = np.geomspace(2.0, 400.0, 60)
    s, noise = 2j * np.pi * f, np.random.default_rng(0).normal(0.0, 0.05, (2, 60))
    G = 2.4 / (s * (s + 14.0)) * np.exp(-5e-4 * s) * np.exp(noise[0] + 1j * noise[1])

    def width(by: float) -> np.ndarray:
        """Return the relative half-widths of an axis whose time runs so much faster."""
        response = FrequencyResponse(frequency=by * f, magnitude=abs(G) / by, phase=np.unwrap(np.angle(G)))
        return np.array([e.half_width / float(e) for e in identify_plant([response]).estimates.values()])

    with lifted():
        assert width(faster)[:3] == pytest.approx(width(1.0)[:3], rel=0.02)


def test_hold_and_transport_make_up_the_delay() -> None:
    fit = identify_plant([shaken(X, seed=1)])
    assert fit.hold == pytest.approx(RATE)
    assert float(fit.transport) + 0.5 / RATE == pytest.approx(float(fit.estimates["T_d"]))
    assert float(fit.transport) == pytest.approx(X.transport_delay(RATE), abs=5e-6)


def test_the_hold_is_more_than_its_delay() -> None:
    """A sampled response is the sum of all its images behind the hold; eq. (1) alone does not fit it as well."""
    f, T_s = np.array([3.0, 50.0, 500.0, 1500.0]), 1 / RATE
    images = f[:, None] + RATE * np.arange(-4000, 4001)
    s = 2j * np.pi * images
    held = (1 - np.exp(-s * T_s)) / (s * T_s) * replace(X, T_d=X.transport_delay(RATE)).response(images)
    np.testing.assert_allclose(X.response(f, RATE), held.sum(axis=1), rtol=1e-6)
    log = shaken(X, seed=1, position_noise=0.0, voltage_noise=0.0, resolution=0.0)
    held, plain = identify_plant([log]), identify_plant([log], continuous=True)
    assert plain.hold is None
    assert plain.solution.misfit > 10 * held.solution.misfit


def test_a_noiseless_table_gives_its_plant_exactly() -> None:
    f = np.geomspace(1, 800, 60)
    G = Y.response(f)
    fit = identify_plant([FrequencyResponse(f, np.abs(G), np.angle(G), np.full(60, 0.99))])
    for name in ("A", "B", "T_d"):
        assert float(fit.estimates[name]) == pytest.approx(getattr(Y, name), rel=1e-6)
    assert fit.hold is None
    assert float(fit.transport) == float(fit.estimates["T_d"])


@pytest.mark.parametrize("T_d", [0.0, 0.2e-3, 3e-3, 12e-3])
def test_a_phase_that_wraps_often_is_followed(T_d: float) -> None:
    plant = replace(X, T_d=T_d)
    f = np.geomspace(1, 800, 60)
    G = plant.response(f)
    fit = identify_plant([FrequencyResponse(f, np.abs(G), np.angle(G))])
    assert fit.plant.T_d == pytest.approx(T_d, abs=1e-8)
    assert pytest.approx(X.A, rel=1e-4) == fit.plant.A


def test_incoherent_frequencies_are_left_out() -> None:
    f = np.geomspace(1, 800, 60)
    G = X.response(f)
    coherence = np.where(f > 300, 0.3, 0.98)
    spoilt = np.where(f > 300, 5.0, 1.0)
    fit = identify_plant([FrequencyResponse(f, spoilt * np.abs(G), np.angle(G), coherence)])
    assert pytest.approx(X.B, rel=1e-6) == fit.plant.B
    with pytest.raises(FricError, match="coherence"):
        identify_plant([FrequencyResponse(f, np.abs(G), np.angle(G), np.full(60, 0.2))])
    with pytest.raises(FricError, match=r"between 1 and 1\.1 Hz"):
        identify_plant([FrequencyResponse(f, np.abs(G), np.angle(G))], band=(1.0, 1.1))


def test_a_mode_is_fitted_as_such_in_a_table_too() -> None:
    """The factor 1 + 0.3·s²/(s² + …) is a second mass with 1 - 1/1.3 of the moving mass, seen from the motor."""
    f = np.geomspace(1, 800, 200)
    s = 1j * f / 250
    mode = 1 + 0.3 * s**2 / (s**2 + 0.06 * s + 1)
    noisy = np.exp(np.random.default_rng(1).normal(0, [[1e-4], [1e-4]], (2, 200)).T @ [1, 1j])
    G = X.response(f) * mode * noisy
    table = FrequencyResponse(f, np.abs(G), np.angle(G), np.full(200, 0.999), np.full(200, 1e-4))
    wide, narrow = identify_plant([table]), identify_plant([table], band=(0.0, 60.0))
    assert pytest.approx(X.B, rel=0.03) == narrow.plant.B
    assert pytest.approx(X.B, rel=0.01) == wide.plant.B
    assert pytest.approx(X.A, rel=0.02) == wide.plant.A
    assert wide.second_mass is not None
    assert float(wide.second_mass["frequency"]) == pytest.approx(250, rel=0.01)
    assert float(wide.second_mass["ratio"]) == pytest.approx(1 - 1 / 1.3, rel=0.05)


def test_friction_raises_A_at_a_resting_mean_and_that_is_told() -> None:
    fit = identify_plant([resting(2e-3, friction=F_C)])
    assert fit.plant.A > 1.2 * X.A
    told = " ".join(fit.warnings)
    assert "reverses" in told
    assert "volt of Coulomb friction adds" in told


def test_a_moving_mean_keeps_coulomb_friction_out() -> None:
    fit = identify_plant([shaken(X, seed=2, friction=F_C, mean=0.05)])
    assert pytest.approx(X.A, rel=0.02) == fit.plant.A
    assert "reverses" not in " ".join(fit.warnings)


def test_two_amplitudes_take_friction_out_of_A() -> None:
    fit = identify_plant([resting(a, friction=F_C) for a in (2e-3, 6e-3)])
    assert fit.friction.differs
    assert fit.friction.seen[0] > fit.friction.seen[1] > X.A
    assert inside(fit, X)[0]
    assert pytest.approx(X.A, rel=0.1) == fit.plant.A
    assert fit.friction.coulomb is not None
    assert float(fit.friction.coulomb) == pytest.approx(F_C * X.B, rel=0.25)
    assert "friction-in-response" in {warning.code for warning in fit.warnings}


@pytest.mark.long(2)
def test_the_papers_axis_with_its_own_friction_at_a_resting_mean() -> None:
    """GMS friction of Table 1: A of one amplitude is far off, that of two is the axis's own damping."""
    axis = read_machine(Path("configs/xy-table.yaml")).axis("x")
    sampling, lines = axis.cascade.sampling, np.unique(np.rint(np.geomspace(1, 300, 50)))
    logs = []
    for peak in (0.05, 0.15):
        r = reference_multisine(lines, peak, round(5 * sampling), sampling, np.random.default_rng(1))
        r = Reference(sampling, *(np.ascontiguousarray(x) for x in (r.position, r.velocity, r.acceleration)))
        run = run_axis(axis, r)
        log = Log(run.time, position=run.measured, input=run.input, reference=run.reference, name=f"{peak} m/s")
        logs.append(log.slice(round(sampling), len(log)))
    fit = identify_plant(logs, given_force_constant=axis.plant.K_f)
    assert np.all(fit.friction.seen > 1.4 * axis.plant.A)
    low, high = fit.estimates["A"].ci95
    assert low < axis.plant.A + 40.0 / axis.plant.M < high + 0.5
    assert abs(fit.plant.A / axis.plant.A - 1) < 0.06
    assert float(fit.friction.coulomb) * axis.plant.M == pytest.approx(105, rel=0.2)
    assert "friction-in-response" in {one.code for one in fit.warnings}


def test_two_amplitudes_without_friction_agree() -> None:
    fit = identify_plant([resting(a) for a in (2e-4, 6e-4)])
    assert fit.friction.compared
    assert not fit.friction.differs
    assert pytest.approx(X.A, rel=0.02) == fit.plant.A
    low, high = fit.friction.coulomb.ci95
    assert low < 0 < high


def test_a_turned_sign_is_refused_with_the_mend() -> None:
    log = shaken(X, seed=1)
    with pytest.raises(FricError, match="sign"):
        identify_plant([replace(log, position=-log.position)])


def test_the_force_scale_comes_from_a_force_or_from_the_user() -> None:
    log = shaken(X, seed=1)
    assert "K_f" not in identify_plant([log]).estimates
    assert float(identify_plant([log], given_force_constant=548.0).estimates["K_f"]) == 548.0
    noisy = 548.0 * log.input + np.random.default_rng(1).normal(0, 5, len(log))
    low, high = identify_plant([replace(log, force=noisy)]).estimates["K_f"].ci95
    assert low < 548 < high
    assert high - low < 2.0


def test_a_delay_shorter_than_the_hold_is_told() -> None:
    log = shaken(X, seed=1, mean=0.0)
    early = replace(log, position=np.roll(log.position, -3)).slice(0, len(log) - 4)
    fit = identify_plant([early])
    assert "T_d-at-bound" in {warning.code for warning in fit.warnings}
