"""Records whose level of friction and offset vary: the interval of the mean holds it, and that they vary is said."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.special import stdtrit

from fric.arrays import Real
from fric.estimate import Estimate
from fric.friction.dahl import Dahl
from fric.identify.plant.identify import identify_motion
from fric.identify.replay.replay_fit import ReplayFit, identify_by_replay
from fric.identify.replay.replay_search import spread
from fric.identify.static_map.corrections import corrected
from fric.identify.static_map.identify import StaticFit, identify_static
from fric.identify.static_map.map_fit import fit_map
from fric.identify.static_map.points import Asked, SpeedPoint, Strokes
from fric.log import ForceVelocity, Log
from fric.records.prepared import prepared
from fric.statistics import DIFFERENT, between_records, mixed_model, reach
from tests.chance import fewest, most
from tests.identify.presliding import APART, PAPER, identify_gms, pair, record
from tests.identify.test_rigid_body import M, motion

TRUTH = {"F_c": 50.0, "F_s": 80.0, "sigma": 100.0, "offset": 0.0}


def session(seed: int, records: int, level: float, offset: float) -> StaticFit:
    """Return the map of records that each have their own level and offset, of so much standard deviation."""
    rng = np.random.default_rng([seed, records])
    v = np.outer([-1.0, 1.0], np.geomspace(1e-4, 0.05, 8)).ravel()
    friction = TRUTH["F_c"] + (TRUTH["F_s"] - TRUTH["F_c"]) * np.exp(-np.abs(v) / 2e-3)
    tables = [
        ForceVelocity(
            v,
            np.sign(v) * (1.0 + level * rng.standard_normal()) * friction + TRUTH["sigma"] * v
            + offset * rng.standard_normal() + 0.3 * rng.standard_normal(len(v)),
            error=np.full(len(v), 0.1), name=f"run {n + 1}",
        )
        for n in range(records)
    ]  # fmt: skip
    return identify_static(tables, Asked(delta=1.0, form="stribeck", direction="both", over_position="off"))


def held(fits: list[StaticFit], name: str) -> int:
    return sum(low <= TRUTH[name] <= high for low, high in (fit.static.estimates[name].ci95 for fit in fits))


MANY = [(n, *of, 100) for n in (3, 5, 8) for of in ((0.0, 0.0), (0.01, 0.5), (0.2, 5.0))]


@pytest.mark.parametrize(
    ("records", "level", "offset", "count"),
    [(5, 0.05, 2.0, 6), *(pytest.param(*one, marks=pytest.mark.long(60)) for one in MANY)],
)
def test_the_interval_of_the_mean_holds_it(records: int, level: float, offset: float, count: int) -> None:
    """Chance of failing: below one in a thousand for each parameter (`tests/chance.py`)."""
    fits = [session(seed, records, level, offset) for seed in range(count)]
    for name in ("F_c", "F_s", "offset"):
        assert held(fits, name) >= fewest(count), name
    told = [any(one.code == "records-vary" for one in fit.warnings) for fit in fits]
    assert all(told) if level >= 0.05 else sum(told) <= 2 or level > 0.0


def test_records_without_a_level_of_friction_have_no_scatter_of_it() -> None:
    """The force has the wrong sign: no friction is found, and a scatter of it divided nothing by nothing."""
    rng, v = np.random.default_rng(5), np.outer([-1.0, 1.0], np.geomspace(1e-4, 0.05, 8)).ravel()
    forces = [-60.0 * np.sign(v) - 100.0 * v + 0.3 * rng.standard_normal(len(v)) for _ in range(3)]
    tables = [ForceVelocity(v, F, error=np.full(len(v), 0.1), name=f"run {n}") for n, F in enumerate(forces)]
    fit = identify_static(tables, Asked(delta=1.0, over_position="off"))
    assert float(fit.static.estimates["F_c"]) == 0.0
    assert "level" not in fit.between_records


def test_the_scatter_of_records_is_in_the_fit_and_widens_what_five_alone_would_widen() -> None:
    fit = session(3, 5, 0.05, 2.0)
    assert 0.02 < float(fit.between_records["level"]) < 0.12
    assert 0.7 < float(fit.between_records["offset"]) < 5.0
    assert fit.static.estimates["F_c"].half_width > 0.02 * TRUTH["F_c"]  # 2.78 standard errors of five of 5 %: 6 %
    assert session(3, 5, 0.0, 0.0).static.estimates["F_c"].half_width < 0.01 * TRUTH["F_c"]


def test_effects_that_are_a_million_times_the_error_are_found() -> None:
    """Products over the variance left nothing of what is fixed there, and the search ended in a traceback."""
    rng = np.random.default_rng(6)
    levels, n = 1e6 * rng.standard_normal(8), 12
    kinds = [np.repeat(np.eye(8), n, axis=0)]
    found = mixed_model(
        kinds[0] @ levels + 1e-3 * rng.standard_normal(8 * n), np.ones((8 * n, 1)), np.zeros(8 * n), kinds
    )
    np.testing.assert_allclose(found.deviations, np.std(levels, ddof=1), rtol=1e-3)
    np.testing.assert_allclose(found.predicted, levels - levels.mean(), rtol=0, atol=1e-2)


def test_effects_are_those_of_a_balanced_analysis_of_variance() -> None:
    """Of as many values in each group REML's variance is (MS between - MS within)/n, its prediction a shrunk mean."""
    rng = np.random.default_rng(2)
    groups, n = 6, 8
    effects = 2.0 * rng.standard_normal(groups)
    y = np.repeat(effects, n) + rng.standard_normal(groups * n)
    Z = np.kron(np.eye(groups), np.ones((n, 1)))
    found = mixed_model(y, np.ones((groups * n, 1)), np.zeros(groups * n), [Z])
    means = y.reshape(groups, n).mean(axis=1)
    within = float(np.sum((y.reshape(groups, n) - means[:, np.newaxis]) ** 2)) / (groups * (n - 1))
    between = float(np.var(means, ddof=1)) - within / n
    assert float(found.deviations[0]) == pytest.approx(between**0.5, rel=1e-3)
    assert float(found.measured[0]) == pytest.approx(np.std(means, ddof=1), rel=1e-3)
    assert float(found.error[0]) == pytest.approx((within / n) ** 0.5, rel=1e-2)
    shrunk = between / (between + within / n) * (means - means.mean())
    np.testing.assert_allclose(found.predicted, shrunk, rtol=2e-3)
    assert found.likelier > 20.0


def test_effects_are_measured_where_none_is_left_beyond_chance() -> None:
    """Levels that agree better than their errors were of no deviation: 15 % of next records of as much were missed."""
    rng = np.random.default_rng(2)
    noise = rng.standard_normal((3, 8))
    y = noise - noise.mean(axis=1, keepdims=True) + np.array([[0.1], [-0.1], [0.0]])
    found = mixed_model(y.ravel(), np.ones((24, 1)), np.zeros(24), [np.kron(np.eye(3), np.ones((8, 1)))])
    assert found.deviations == [0.0]
    assert float(found.measured[0]) == pytest.approx(0.1, rel=1e-6)


@pytest.mark.parametrize(
    ("records", "scatter", "least", "most_of"),
    [(2, 0.0, 0.95, 0.99), (2, 0.05, 0.92, 0.98), (3, 0.0, 0.95, 0.98), (3, 0.002, 0.86, 0.95), (3, 0.05, 0.94, 0.97),
     (3, 0.2, 0.91, 0.96), (8, 0.05, 0.94, 0.97)],
)  # fmt: skip
def test_a_mean_and_the_next_record_are_held_whatever_the_scatter(
    records: int, scatter: float, least: float, most_of: float
) -> None:
    """By moments, levels that scattered as much as their error were held in 85 %, next to 97 % of those that agreed."""
    rng, error, count = np.random.default_rng(5), 1e-3, 150
    mean, following = 0, 0
    for _ in range(count):
        *levels, after = scatter * rng.standard_normal(records + 1)
        seen = np.array(levels) + error * rng.standard_normal(records)
        half = reach(float(np.std(seen, ddof=1)), error, records)
        mean += abs(seen.mean()) <= half / records**0.5
        following += abs(seen.mean() - after) <= half * (1.0 + 1.0 / records) ** 0.5
    assert fewest(count, least) <= mean <= most(count, most_of)
    assert fewest(count, least) <= following


@pytest.mark.parametrize("count", [1, pytest.param(40, marks=pytest.mark.long(150))])
def test_two_sines_of_other_amplitudes_that_differ_in_level_are_held_and_said(count: int) -> None:
    """With 5 % each alpha and k were held in 57 %: two were compared of one motion alone, and gms did not say it."""
    held, told = [], 0
    for seed in range(count):
        levels = 1.0 + 0.05 * np.random.default_rng([seed, 77]).standard_normal(2)
        sines = pair(APART, cycles=3, dt=2e-2, step=0.0, seed=seed)
        logs = [replace(log, force=log.force * by) for log, by in zip(sines, levels, strict=True)]
        fit = identify_gms(logs, static=PAPER, blocks=4)
        held += [
            low <= true <= high
            for found, trues in ((fit.alpha, APART.alpha), (fit.k, APART.k))
            for true, (low, high) in zip(trues, found.ci95, strict=True)
        ]
        told += any(one.code == "records-vary" for one in fit.warnings)
    assert sum(held) >= 0.93 * len(held)
    assert told >= count - 1


DAHL = Dahl(F_c=50.0, sigma_0=5e6, n=1.0, sigma=40.0)


def replayed(seed: int, records: int, level: float) -> tuple[ReplayFit, float]:
    """Return a fit to cycles that each have their own level and offset, and the level that a next record has."""
    rng = np.random.default_rng([seed, records])
    levels = 1.0 + level * rng.standard_normal(records + 1)
    logs = [record(200e-6, DAHL, cycles=4, dt=8e-3, step=0.1e-6, seed=100 * seed + n) for n in range(records)]
    logs = [
        replace(log, force=log.force * levels[n] + 2.0 * rng.standard_normal(), name=f"run {n + 1}")
        for n, log in enumerate(logs)
    ]
    return identify_by_replay("dahl", prepared(logs), start=DAHL), float(levels[-1])


OF_REPLAY = [(n, level, 40) for n in (3, 5, 8) for level in (0.01, 0.05, 0.2)]


@pytest.mark.parametrize(
    ("records", "level", "count"),
    [(4, 0.05, 1), *(pytest.param(*one, marks=pytest.mark.long(60)) for one in OF_REPLAY)],
)
def test_the_interval_of_a_model_by_replay_holds_the_mean_and_with_the_scatter_the_next_record(
    records: int, level: float, count: int
) -> None:
    """Chance of failing: below one in a thousand for each parameter (`tests/chance.py`)."""
    fits = [replayed(seed, records, level) for seed in range(count)]
    for name, truth in (("F_c", DAHL.F_c), ("sigma_0", DAHL.sigma_0)):
        inside = [low <= truth <= high for low, high in (fit.estimates["dahl"][name].ci95 for fit, _ in fits)]
        assert sum(inside) >= fewest(count), name
    quantile, following = float(stdtrit(records - 1, 0.975)), 0
    for fit, after in fits:
        found = fit.estimates["dahl"]["F_c"]
        half = np.hypot(found.half_width, quantile * float(fit.between_records["level"]) * float(found))
        following += abs(float(found) - after * DAHL.F_c) <= half
    assert fewest(count) <= following <= max(most(count), count - 1) + 1
    assert all(any(one.code == "records-vary" for one in fit.warnings) for fit, _ in fits)


def test_a_record_weighs_the_same_whatever_its_level() -> None:
    """With 5 % of level one record weighed eight times another, for what its level leaves counted as noise."""
    (same,) = prepared([record(200e-6, DAHL, cycles=3, dt=2e-2, step=0.0, seed=1)])
    noise, other = (spread(replace(same, force=by * same.force), DAHL).mean() for by in (1.0, 1.05))
    assert other == pytest.approx(noise, rel=0.06)


def test_levels_of_cycles_are_in_the_interval_of_a_gms_and_of_records_that_agree_they_are_not() -> None:
    rng = np.random.default_rng(4)
    same = [replace(record(150e-6, APART, cycles=3, dt=2e-2, step=0.0, seed=n), name=f"run {n}") for n in range(4)]
    apart = [replace(one, force=one.force * (1.0 + 0.05 * rng.standard_normal())) for one in same]
    wide, narrow = (identify_gms(logs, static=PAPER, blocks=2) for logs in (apart, same))
    assert 0.02 < float(wide.between_records["level"]) < 0.12
    assert wide.alpha_sum.half_width > 0.04  # 3.18 standard errors of four of 5 %
    assert narrow.alpha_sum.half_width < 0.02
    assert float(narrow.between_records.get("level", 0.0)) < 1e-3
    low, high = wide.alpha_sum.ci95
    assert low < 1.0 < high


def one_speed_each(seed: int, level: float) -> StaticFit:
    """Return the map of twelve records of six strokes at one speed each, whose level varies."""
    rng, tables = np.random.default_rng([seed, 5]), []
    for n, speed in enumerate(np.geomspace(1e-4, 0.05, 12)):
        v = np.tile([-speed, speed], 3) * (1.0 + 2e-3 * rng.standard_normal(6))
        friction = np.sign(v) * (TRUTH["F_c"] + (TRUTH["F_s"] - TRUTH["F_c"]) * np.exp(-np.abs(v) / 2e-3))
        force = (1.0 + level * rng.standard_normal()) * friction + TRUTH["sigma"] * v + 0.3 * rng.standard_normal(6)
        tables.append(ForceVelocity(v, force, error=np.full(6, 0.1), name=f"run {n:02d}"))
    return identify_static(tables, Asked(delta=1.0, form="stribeck", direction="both", over_position="off"))


@pytest.mark.parametrize("count", [3, pytest.param(40, marks=pytest.mark.long(60))])
def test_records_of_one_speed_each_are_no_repeats_of_a_level(count: int) -> None:
    """Of 30 sessions F_s was held in 7, F_c in 17, and nothing was said. Fails in under one of a thousand."""
    fits = [one_speed_each(seed, 0.05) for seed in range(count)]
    for name in ("F_c", "F_s", "sigma"):
        assert held(fits, name) >= fewest(count), name
    told = [one for fit in fits for one in fit.warnings if one.code == "records-vary"]
    assert len(told) == count
    assert all("one speed" in one for one in told)


@pytest.mark.parametrize("records", [3, 8])
def test_records_that_are_alike_are_not_said_to_differ(records: int) -> None:
    """Of motions without any scatter 12 % of three and half of eight were, of these 7 and 13 of 20 sessions.

    Fails in under one of a thousand.

    Where each record tells the mass to 1 %, a scatter by 1 % as well is seen in 5 % of sessions: the rest is covered.
    """
    rng, t = np.random.default_rng(4), np.linspace(0.0, 4.0, 400)
    v = np.cos(np.pi * t) + 0.7 * np.cos(3.4 * np.pi * t)
    X, told = np.column_stack([np.gradient(v), v, np.sign(v), np.ones_like(t)]), 0
    for _ in range(20):
        noise = [np.repeat(lfilter([1], [1, -0.5], rng.standard_normal(100)), 4) for _ in range(records)]
        noise = [np.convolve(one, np.hanning(11), "same") for one in noise]  # as the filter of a motion leaves it
        joint = np.mean([np.linalg.lstsq(X, one, rcond=None)[0] for one in noise], axis=0)
        found = between_records([X] * records, [one - X @ joint for one in noise], 1.96)
        told += found is not None and found.chance < DIFFERENT
    assert told <= most(20, 0.005)


@pytest.mark.parametrize(("alike", "noise"), [(1e-9, 1.0), (1e-5, 1.0), (1.0, 0.0)])
def test_records_that_tell_two_columns_hardly_apart_or_leave_nothing_are_compared(alike: float, noise: float) -> None:
    rng = np.random.default_rng(4)
    parts = [rng.standard_normal((60, 4)) for _ in range(3)]
    for X in parts:
        X[:, 3] = X[:, 0] + alike * X[:, 3]
    found = between_records(parts, [noise * rng.standard_normal(60) for _ in parts], 1.96)
    if alike < 1e-7:  # such a record has no estimate
        assert found is None
    else:
        assert found is not None
        assert np.isfinite(found.covariance).all()
        assert found.chance > DIFFERENT


@pytest.mark.parametrize("count", [2, pytest.param(40, marks=pytest.mark.long(30))])
def test_a_mass_that_varies_between_records_is_held_and_said(count: int) -> None:
    """Five motions, each with another load on the table. Fails in under one of a thousand (`tests/chance.py`).

    A record tells the mass to 1 %. Five of a deviation of 5 % have under 2 % in one session of 26: with the chance of
    `DIFFERENT` for a false alarm in any of four parameters 93 % are said, by Fisher's F; the interval holds the rest.
    """
    inside, told = [], 0
    for seed in range(count):
        rng = np.random.default_rng([seed, 8])
        logs = [motion(4.0, 1000.0, noise=3.0, rho=0.5, seed=10 * seed + n) for n in range(5)]
        t = logs[0].time
        acceleration = -0.05 * np.pi**2 * np.sin(np.pi * t) - 0.01 * (3.4 * np.pi) ** 2 * np.sin(3.4 * np.pi * t)
        loads = 0.05 * M * rng.standard_normal(5)
        fit = identify_motion([
            replace(log, force=log.force + load * acceleration, name=f"run {n}")
            for n, (log, load) in enumerate(zip(logs, loads, strict=True))
        ])  # fmt: skip
        low, high = fit.estimates["M"].ci95
        inside.append(low <= M <= high)
        told += any(notice.code == "records-vary" for notice in fit.warnings)
        assert high - low > 0.02 * M
    assert sum(inside) >= fewest(count)
    assert told >= fewest(count, 0.93)


def test_an_F_s_that_drifts_within_a_record_is_covered_in_its_quarters() -> None:
    """From 2.36 to 2.43 N, as in a real joint: 44 % of the windows agreed with the whole."""
    rng, v = np.random.default_rng(3), np.tile(np.outer(np.geomspace(2e-4, 0.02, 6), [1.0, -1.0]).ravel(), 8)
    F_s, noise = np.linspace(2.36, 2.43, len(v)), rng.normal(0.0, 0.01, len(v))

    def fit(F_s: Real) -> tuple[Estimate, Strokes]:
        force = np.sign(v) * (1.6 + (F_s - 1.6) * np.exp(-np.abs(v) / 2e-3)) + 3.0 * v + noise
        points = [
            SpeedPoint(*pair, 0.01, 60, "r", float(n), n + 0.9) for n, pair in enumerate(zip(v, force, strict=True))
        ]
        strokes = corrected(Strokes.at(points, Asked(delta=1.0, form="stribeck")))
        return fit_map(strokes).estimates["F_s"], strokes

    found, strokes = fit(F_s)
    low, high = found.ci95
    first, *_, last = (part.mean() for part in np.array_split(F_s, 4))
    assert low < first < last < high
    assert [one.code for one in strokes.notices] == ["records-vary"]
    level, strokes = fit(np.full_like(F_s, 2.395))
    assert level.half_width < 0.5 * found.half_width
    assert not strokes.between_records


def test_motions_logged_twice_show_whether_friction_changed_or_the_model_misses_one() -> None:
    """A loop that is 2 % larger than the model has it widened shares by Student's t of one, logged twice or not."""

    def sines(seed: int, *levels: float) -> list[Log]:
        logs = zip(pair(APART, cycles=3, dt=2e-2, step=0.0, seed=seed), levels, strict=True)
        return [replace(log, name=f"{log.name}, {seed}", force=log.force * by) for log, by in logs]

    single, twice, changed = (
        identify_gms(logs, static=PAPER, blocks=4)
        for logs in (
            sines(1, 0.99, 1.01),
            [*sines(1, 0.99, 1.01), *sines(2, 0.99, 1.01)],
            [*sines(1, 0.99, 1.01), *sines(2, 1.03, 0.97)],
        )
    )
    of = [[notice.code for notice in fit.warnings if notice.code == "records-vary"] for fit in (single, twice, changed)]
    assert of == [["records-vary"], [], ["records-vary"]]
    assert float(twice.between_records["level"]) < 1e-3
    assert float(changed.between_records["level"]) == pytest.approx(0.04 / 2**0.5, rel=0.2)
    missed = identify_gms([*sines(1, 0.94, 1.06), *sines(2, 0.94, 1.06)], static=PAPER, blocks=4)
    assert "friction-differs" in [notice.code for notice in missed.warnings]
    assert all(low <= true <= high for true, (low, high) in zip(APART.alpha, missed.alpha.ci95, strict=True))
    single_half, half = ((high - low) / 2 for fit in (single, twice) for low, high in [fit.alpha.ci95[0]])
    assert half < 0.6 * single_half


@pytest.mark.long(120)
@pytest.mark.parametrize("scatter", [0.0, 0.01, 0.05])
def test_shares_and_stiffnesses_are_held_where_motions_were_logged_twice(scatter: float) -> None:
    """In 97, 100 and 98 % of 24 sessions of four records. The chance of failing is below one in a thousand."""
    held, whole, said, count = [], 0, 0, 24
    for seed in range(count):
        levels = 1.0 + scatter * np.random.default_rng([seed, 5]).standard_normal(4)
        sines = [log for n in range(2) for log in pair(APART, cycles=3, dt=2e-2, step=0.0, seed=2 * seed + n)]
        logs = [
            replace(log, force=log.force * by, name=f"run {n}")
            for n, (log, by) in enumerate(zip(sines, levels, strict=True))
        ]
        fit = identify_gms(logs, static=PAPER, blocks=4)
        held += [
            [low <= true <= high for true, (low, high) in zip(trues, found.ci95, strict=True)]
            for found, trues in ((fit.alpha, APART.alpha), (fit.k, APART.k))
        ]
        low, high = fit.alpha_sum.ci95
        whole += low <= 1.0 <= high
        said += any(notice.code == "records-vary" for notice in fit.warnings)
    assert whole >= fewest(count)
    assert all(sum(block) >= fewest(count) for half in (held[::2], held[1::2]) for block in zip(*half, strict=True))
    assert said == (count if scatter else 0)
