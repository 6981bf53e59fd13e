"""The rigid axis fitted to a motion: the published benchmark, known axes, intervals that cover."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat
from scipy.signal import lfilter

import fric
from fric.errors import FricError
from fric.identify.plant.identify import identify_motion
from fric.identify.replay import replay_fit
from fric.log import Log
from fric.records.motion import Conditioning
from fric.records.prepared import Prepared
from fric.reference import strokes
from tests.chance import fewest, most

DATA = Path(__file__).parents[2] / "data"
EMPS = Path(__file__).parents[3] / "shared" / "data" / "emps" / "DATA_EMPS.mat"

M, F_V, F_C, OFFSET = 61.0, 1200.0, 53.0, 4.0


def motion(
    seconds: float = 12.0, rate: float = 4000.0, noise: float = 0.0, rho: float = 0.0, seed: int = 0, begin: float = 0.0
) -> Log:
    """Return two slow sines and what they take of an axis; the noise is a first-order autoregression of 100 Hz."""
    t = begin + np.arange(int(seconds * rate)) / rate
    w1, w2 = 2 * np.pi * 0.5, 2 * np.pi * 1.7
    position = 0.05 * np.sin(w1 * t) + 0.01 * np.sin(w2 * t)
    velocity = 0.05 * w1 * np.cos(w1 * t) + 0.01 * w2 * np.cos(w2 * t)
    acceleration = -0.05 * w1**2 * np.sin(w1 * t) - 0.01 * w2**2 * np.sin(w2 * t)
    force = M * acceleration + F_V * velocity + F_C * np.sign(velocity) + OFFSET
    if noise:
        slow = np.random.default_rng(seed).normal(0, noise * np.sqrt(1 - rho**2), len(t) // 40 + 1)
        force = force + np.repeat(lfilter([1], [1, -rho], slow), 40)[: len(t)]
    return Log(t, position=np.round(position / 0.25e-6) * 0.25e-6, force=force)


@pytest.fixture(scope="module")
def emps() -> Log:
    if not EMPS.parent.exists():
        pytest.skip("the real logs are not in ../shared/data")
    data = {key: np.ravel(value) for key, value in loadmat(EMPS).items() if not key.startswith("_")}
    return Log(data["t"], position=data["qm"], force=data["gtau"][0] * data["vir"], input=data["vir"])


@pytest.mark.real
def test_published_figures_of_the_benchmark(emps: Log) -> None:
    """Janot, Gautier, Brunot 2019, to the digits printed, from the sampling rate alone."""
    fit = identify_motion([emps])
    assert {name: round(float(e), 4) for name, e in fit.estimates.items()} == {
        "M": 95.1089, "F_v": 203.5034, "F_c": 20.3935, "offset": -3.1648,
    }  # fmt: skip
    assert {name: round(sd, 4) for name, sd in fit.deviation.items()} == {
        "M": 0.1085, "F_v": 1.1460, "F_c": 0.1012, "offset": 0.0444,
    }  # fmt: skip
    assert round(100 * fit.relative_error, 4) == 4.0834
    assert int(100 * fit.condition_number) / 100 == 25.98  # 25.9883: printed cut off, not rounded
    assert float(fit.plant["K_f"]) == pytest.approx(35.15065, rel=1e-6)


@pytest.mark.real
def test_published_figures_per_direction(emps: Log) -> None:
    fit = identify_motion([emps], direction="each")
    assert {name: round(float(e), 4) for name, e in fit.estimates.items()} == {
        "M": 95.1540, "F_v_positive": 166.7061, "F_c_positive": 20.1440,
        "F_v_negative": 240.4236, "F_c_negative": 20.6277,
    }  # fmt: skip
    assert round(100 * fit.relative_error, 4) == 3.1117


@pytest.mark.real
def test_an_input_with_its_force_constant_is_the_force(emps: Log) -> None:
    voltage = Log(emps.time, position=emps.position, input=emps.input)
    scaled = identify_motion([voltage], force_constant=35.15065188248547)
    bare = identify_motion([voltage])
    assert float(scaled.estimates["M"]) == pytest.approx(95.1089, abs=5e-5)
    assert "K_f" not in bare.plant
    for name in ("A", "B"):
        assert float(bare.plant[name]) == pytest.approx(float(scaled.plant[name]), rel=1e-9)


@pytest.mark.real
def test_correlated_residuals_widen_the_published_deviations(emps: Log) -> None:
    fit = identify_motion([emps])
    assert fit.autocorrelation > 0.5
    for name, estimate in fit.estimates.items():
        low, high = estimate.ci95
        assert high - low > 1.5 * 2 * 1.96 * fit.deviation[name]


def test_a_known_axis_is_found_again() -> None:
    fit = identify_motion([motion()])
    for name, true in zip(("M", "F_v", "F_c", "offset"), (M, F_V, F_C, OFFSET), strict=True):
        assert float(fit.estimates[name]) == pytest.approx(true, rel=0.01), name
    assert float(fit.plant["A"]) == pytest.approx(F_V / M, rel=0.01)


def test_a_force_acts_the_stated_delay_after_it_was_logged() -> None:
    """The force of the voltage that makes it, logged at once, acts T_d later: the axis is the same with and without."""
    at_once, T_d = motion(), 4e-3
    early = Log(
        at_once.time, position=at_once.position, force=np.interp(at_once.time + T_d, at_once.time, at_once.force)
    )
    right, wrong = identify_motion([early], delay=T_d), identify_motion([early])
    for name, true in zip(("M", "F_v", "F_c"), (M, F_V, F_C), strict=True):
        assert float(right.estimates[name]) == pytest.approx(true, rel=0.01), name
    assert right.relative_error < 0.2 * wrong.relative_error


def test_a_volt_is_no_newton() -> None:
    """Of records without a force constant either all have a force or all an input: one of each is refused."""
    log = motion()
    with pytest.raises(FricError, match="no force"):
        identify_motion([Log(log.time, position=log.position, input=log.force), log])


@pytest.mark.parametrize("rate", [200.0, 1000.0, pytest.param(10_000.0, marks=pytest.mark.long(3))])
def test_the_filters_follow_the_sampling_rate(rate: float) -> None:
    fit = identify_motion([motion(rate=rate)])
    assert float(fit.estimates["M"]) == pytest.approx(M, rel=0.03)
    assert fit.sampling / fit.conditioning.decimation <= 200


def test_the_mirrored_motion_mirrors_the_directions() -> None:
    log = motion()
    mirrored = Log(log.time, position=-log.position, force=-log.force)
    fit, other = identify_motion([log], direction="each"), identify_motion([mirrored], direction="each")
    for term in ("F_v", "F_c"):
        assert float(fit.estimates[f"{term}_positive"]) == pytest.approx(float(other.estimates[f"{term}_negative"]))
    assert float(fit.estimates["F_c_positive"]) - float(fit.estimates["F_c_negative"]) == pytest.approx(
        2 * OFFSET, rel=0.05
    )


def test_records_are_fitted_together() -> None:
    log = motion()
    fit = identify_motion([log.slice(0, 20_000), log.slice(20_000, 48_000)])
    assert float(fit.estimates["M"]) == pytest.approx(M, rel=0.02)


@pytest.mark.long
def test_a_record_that_hardly_accelerates_is_left_out() -> None:
    """A sine of 0.1 mm/s, whose friction is not of sliding: beside it M was 0.5 ± 4."""
    fast, t = motion(noise=1.0), np.arange(40_000) / 4000
    position = 0.2e-3 * np.sin(np.pi * t)
    slow = Log(t, position=np.round(position / 0.25e-6) * 0.25e-6, force=25.0 * np.sign(np.cos(np.pi * t)), name="slow")
    found, alone = identify_motion([fast, slow]), identify_motion([fast])
    assert {name: float(value) for name, value in found.estimates.items()} == pytest.approx(
        {name: float(value) for name, value in alone.estimates.items()}
    )
    (notice,) = (notice for notice in found.warnings if notice.code == "record-left-out")
    assert "'slow'" in notice.values["why"]


def test_records_at_rest_end_in_a_sentence() -> None:
    t = np.arange(4000) / 1000.0
    rest = Log(t, position=np.zeros(4000), force=np.sin(t))
    for logs in ([rest], [rest, replace(rest, name="b")]):
        with pytest.raises(FricError):
            identify_motion(logs)


@pytest.mark.parametrize(
    ("rho", "seeds"), [(0.9, 10), *(pytest.param(rho, 100, marks=pytest.mark.long(15)) for rho in (0.0, 0.9))]
)
def test_intervals_cover_with_correlated_noise(rho: float, seeds: int) -> None:
    """Ordinary intervals of correlated noise cover far less, which the second figure shows.

    Chance of failing: one in a thousand, for 40 numbers and for 400.
    """
    true = dict(zip(("M", "F_v", "F_c", "offset"), (M, F_V, F_C, OFFSET), strict=True))
    inside, plain, total = 0, 0, 0
    clean = identify_motion([motion(rate=1000.0, seconds=10)]).estimates  # what filters and differences leave of it
    for seed in range(seeds):
        fit = identify_motion([motion(rate=1000.0, seconds=10, noise=3.0, rho=rho, seed=seed)])
        for name in true:
            value, (low, high) = float(fit.estimates[name]), fit.estimates[name].ci95
            inside += low <= float(clean[name]) <= high
            plain += abs(value - float(clean[name])) <= 1.96 * fit.deviation[name]
            total += 1
    assert fewest(total) <= inside <= most(total)
    assert plain < inside


def test_what_the_data_cannot_tell_is_refused_or_told() -> None:
    log = motion()
    forth = Log(log.time, position=0.02 * log.time + 0.001 * np.sin(20 * log.time), force=log.force)
    with pytest.raises(FricError, match="does not separate"):
        identify_motion([forth])
    with pytest.raises(FricError, match="no force"):
        identify_motion([Log(log.time, position=log.position)])
    gap = Log(np.delete(log.time, slice(500, 600)), position=np.delete(log.position, slice(500, 600)),
              force=np.delete(log.force, slice(500, 600)))  # fmt: skip
    with pytest.raises(FricError, match="uneven"):
        identify_motion([gap])
    fit = identify_motion([motion()])
    told = " ".join(fit.warnings)
    assert "`delay=`" in told
    assert "`force_constant=`" in told
    assert fit.plant["T_d"].assumed


def way_forth() -> Log:
    """Return a sine on a steady speed, whose end overshoots."""
    t = np.arange(8000) / 1000.0
    v = 0.02 * np.clip(np.minimum(t - 0.5, 7.0 - t) / 0.2, 0.0, 1.0) * (1.0 + 0.3 * np.sin(40.0 * t))
    v -= 2e-3 * np.exp(-(((t - 7.1) / 0.03) ** 2))  # the overshoot
    a = np.gradient(v, t)
    noise = np.random.default_rng(0).normal(0.0, 0.5, len(t))
    force = M * a + F_V * v + F_C * np.tanh(v / 1e-4) + OFFSET + noise
    return Log(t, position=np.cumsum(v) / 1000.0, force=force, kind="motion")


def test_a_way_forth_with_an_overshoot_does_not_tell_coulomb_friction_from_the_offset() -> None:
    """F_c was 349 (171 … 527) for 700."""
    with pytest.raises(FricError, match="does not separate"):
        fric.identify_plant(way_forth(), method="motion")


@pytest.mark.long(10)
def test_a_way_forth_and_a_way_back_tell_coulomb_friction() -> None:
    log = way_forth()
    back = replace(log, position=-np.asarray(log.position), force=2.0 * OFFSET - np.asarray(log.force))
    fit = fric.identify_plant([log, back], method="motion").fit
    low, high = fit.estimates["F_c"].ci95
    assert low < F_C < high


def test_a_reversed_force_is_told() -> None:
    log = motion()
    fit = identify_motion([Log(log.time, position=log.position, force=-log.force)])
    assert any("sign" in warning for warning in fit.warnings)


def test_conditioning_of_the_benchmark_rate() -> None:
    assert Conditioning.of(1000.0) == Conditioning(cutoff=100.0, decimation=10, border=49)
    with pytest.raises(FricError, match="cut-off"):
        Conditioning.of(1000.0, cutoff=600.0)


def session(seed: int, records: int, vary: float) -> list[Log]:
    """Return records of one axis whose mass, level of friction and offset vary, by so much standard deviation.

    Each begins elsewhere in the motion: what filtering does to the same reversals is the same in all, and no scatter.
    """
    rng = np.random.default_rng([seed, records])
    logs = []
    for number in range(records):
        log = motion(seconds=4.0, rate=1000.0, begin=rng.uniform(0.0, 20.0))
        t = log.time
        acceleration = -0.05 * np.pi**2 * np.sin(np.pi * t) - 0.01 * (3.4 * np.pi) ** 2 * np.sin(3.4 * np.pi * t)
        velocity = 0.05 * np.pi * np.cos(np.pi * t) + 0.01 * 3.4 * np.pi * np.cos(3.4 * np.pi * t)
        u, w, o = vary * rng.standard_normal(3)
        more = w * M * acceleration + u * F_C * np.sign(velocity) + o * F_C + rng.normal(0, 2.0, len(t))
        logs.append(Log(t, position=log.position, force=log.force + more, name=f"run {number + 1}"))
    return logs


@pytest.mark.parametrize(
    ("records", "vary", "count"),
    [
        pytest.param(5, 0.05, 5, marks=pytest.mark.long(4)),
        *(pytest.param(n, by, 60, marks=pytest.mark.long(40)) for n in (3, 8) for by in (0.0, 0.01, 0.2)),
    ],
)
def test_intervals_are_those_of_the_mean_over_records(records: int, vary: float, count: int) -> None:
    """Chance of failing: below one in a thousand for each parameter (`tests/chance.py`)."""
    fits = [identify_motion(session(seed, records, vary)) for seed in range(count)]
    for name, truth in (("M", M), ("F_v", F_V), ("F_c", F_C), ("offset", OFFSET)):
        limits = [fit.estimates[name].ci95 for fit in fits]
        assert sum(low <= truth <= high for low, high in limits) >= fewest(count), name  # type: ignore[misc]
    told = [any(one.code == "records-vary" for one in fit.warnings) for fit in fits]
    assert all(told) if vary >= 0.05 else sum(told) <= 2 or vary > 0.0


def test_a_force_that_no_motion_explains_shows_no_mass() -> None:
    """LuGre's fit is viscous friction alone then, and has no Coulomb friction to compare."""
    t = np.arange(600) * 2e-3
    force = np.random.default_rng(1).normal(0.0, 60.0, len(t))
    log = Log(time=t, position=0.03 * np.sin(np.pi * t), velocity=0.03 * np.pi * np.cos(np.pi * t), force=force)
    low, high = identify_motion([log]).estimates["M"].ci95
    assert low < 0.0 < high


def test_of_many_motions_those_that_accelerate_most_are_replayed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each n-th of eight strokes gave M 5 (-88…97) for 30 kg, and all eight 16 (-43…75) after 40 s."""
    taken: list[str] = []

    def alone(record: Prepared) -> None:
        taken.append(record.log.name)

    monkeypatch.setattr(replay_fit, "_axis_alone", alone)
    gains = (0.2, 1.0, 0.1, 0.9, 0.3, 0.8, 0.7, 0.6)
    identify_motion([faster(n, gain) for n, gain in enumerate(gains)], replayed=replay_fit.axis_in_motion)
    assert taken == ["1", "3", "5", "6", "7"]


def faster(n: int, gain: float) -> Log:
    """Return a motion whose travel is a share of that of `motion`."""
    log = motion(4.0, 1000.0)
    assert log.position is not None
    position = np.asarray(log.position)
    return replace(log, name=str(n), position=position[0] + gain * (position - position[0]))


@pytest.mark.parametrize("given", [None, pytest.param("150 N/V", marks=pytest.mark.long(5))])
def test_strokes_share_the_error_of_the_friction_model(given: str | None) -> None:
    """Twelve blocks in each stroke move the mass of LuGre's model alike: their mean had 67.2 (64.7 … 69.7) for 62.5.

    The lag of friction looks like mass as the axis speeds up: 67 to 73 kg of that, 64 to 66 of braking alone.
    """
    fit = fric.identify_plant(DATA / "constant-velocity.h5", method="motion", force_constant=given).fit
    found = {**fit.estimates, "B": fit.plant["B"]}
    for name, truth in (("M", 62.5), ("F_v", 180.0 + 14.0 * 62.5), ("F_c", 63.1), ("B", 2.4)):
        low, high = found[name].ci95  # type: ignore[misc]
        assert low <= truth <= high, name
    assert fit.estimates["M"].half_width < 10.0


def test_cogging_is_no_mass() -> None:
    """Strokes that begin at the same place speed up over the same part of a cogging: it had a mass 4 % too large.

    The phase is the worst: the cogging's force falls where the strokes speed up, and rises where they brake.
    """
    rng = np.random.default_rng(64)

    def stroke(n: int, speed: float) -> Log:
        asked = strokes(speed, 0.1, 2000.0, ramp=speed / 0.5)
        z, v, a = asked.position, asked.velocity, asked.acceleration
        c = 4.0 * np.sin(2 * np.pi * z / 24e-3 + 0.6)
        force = M * a + F_V * v + F_C * np.sign(v) + OFFSET + c + rng.normal(0.0, 0.5, len(z))
        return Log(asked.time, position=z, force=force, name=str(n), kind="constant-velocity")

    logs = [stroke(n, speed) for n, speed in enumerate((0.02, 0.03, 0.05, 0.07, 0.1, 0.14))]
    fit = identify_motion(logs)
    assert abs(float(fit.estimates["M"]) - M) < fit.estimates["M"].half_width < 0.01 * M
    assert "force-over-position" in {notice.code for notice in fit.warnings}
    few = identify_motion(logs[-3:])
    assert abs(float(few.estimates["M"]) - M) < few.estimates["M"].half_width < 0.06 * M
    one = identify_motion(logs[-1:])  # two strokes are too few to separate it from inertia
    assert abs(float(one.estimates["M"]) - M) > 0.02 * M
