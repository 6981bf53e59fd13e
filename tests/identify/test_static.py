"""`identify_static`: the paper's map from the paper's strokes, as sure as it claims, frank about what is missing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from fric.drive.plant import Plant
from fric.errors import FricError
from fric.friction.stribeck import StaticMap
from fric.identify.static_map.identify import StaticFit, identify_static
from fric.identify.static_map.points import Asked
from fric.log import ForceVelocity, Log
from tests.chance import fewest
from tests.identify.constant_velocity import PAPER_SPEEDS, TABLE_1, both_directions, stroke
from tests.identify.recovery import QUANTILE, Recovery

NAMES = ("F_c", "F_s", "v_s", "sigma")


def _logs(seed: int = 0, speeds: np.ndarray = PAPER_SPEEDS, **options) -> list[Log]:
    rng = np.random.default_rng(seed)
    return [stroke(v, rng, **options) for v in both_directions(speeds)]


def _value(fit: StaticFit, name: str) -> float:
    assert fit.static is not None
    return float(fit.static.estimates[name])


def _limits(fit: StaticFit, name: str) -> tuple[float, float]:
    assert fit.static is not None
    return fit.static.estimates[name].ci95


@pytest.mark.parametrize("delta", [1.0, None])
def test_noise_free_strokes_give_table_1(delta):
    fit = identify_static(_logs(noise=0.0, encoder=0.0), Asked(delta=delta))
    for name in NAMES:
        assert _value(fit, name) == pytest.approx(getattr(TABLE_1, name), rel=1e-3)
    assert fit.static.rmse < 1e-3


@pytest.mark.long(6)
def test_intervals_cover_the_truth():
    """Of 32 seeds, each beside a line fit at the truth (`Recovery.check`); `test_recovery` has them by replay."""
    truth = {name: getattr(TABLE_1, name) for name in NAMES} | {"offset": 3.0}
    v = both_directions()
    F = TABLE_1.steady_state(v) + 3.0
    columns = []  # what each parameter does, by differences
    for name in NAMES:
        step = 1e-4 * truth[name]
        more, less = (replace(TABLE_1, **{name: truth[name] + sign * step}) for sign in (1, -1))
        columns.append((more.steady_state(v) - less.steady_state(v)) / (2 * step))
    X = np.column_stack([*columns, np.ones_like(v)])
    sd = 0.01 * np.abs(F) / np.sqrt(1000)
    covariance = np.linalg.inv((X / sd[:, None] ** 2).T @ X)
    errors, linear = [], []
    for seed in range(32):
        logs = _logs(seed, offset=3.0, samples=1000)
        fit = identify_static(logs, Asked(delta=1.0))  # a factor that is supposed is not exactly known
        noise = np.array([log.force.mean() for log in logs]) - F
        linear.append(covariance @ X.T @ (noise / sd**2) / np.sqrt(np.diag(covariance)))
        row = []
        for name, value in truth.items():
            found, (low, high) = _value(fit, name), _limits(fit, name)
            row.append(QUANTILE * (found - value) / (found - low if value < found else high - found))
        errors.append(row)
    Recovery(tuple(truth), np.array(errors), np.array(linear)).check()


def test_clipped_forces_are_told():
    logs = _logs(1)
    low, high = min(log.force.min() for log in logs), max(log.force.max() for log in logs)
    assert "force-clipped" not in {one.code for one in identify_static(logs, Asked()).warnings}
    cut = [replace(log, force=np.clip(log.force, 0.8 * low, 0.8 * high)) for log in logs]
    told = [one for one in identify_static(cut, Asked()).warnings if one.code == "force-clipped"]
    assert told
    assert all(one.severity == "wrong" and one.values["samples"] > 0 for one in told)


def test_one_long_record_gives_what_single_strokes_give():
    rng = np.random.default_rng(1)
    dt, parts, z = 1e-3, [], 0.0
    for v in both_directions(PAPER_SPEEDS[5:]):
        ramp = np.linspace(0.0, v, 50)
        speed = np.concatenate([ramp, np.full(1500, v), ramp[::-1], np.zeros(200)])
        parts.append(speed)
    v = np.concatenate(parts)
    z = np.cumsum(v) * dt
    inertia = 121.0 * np.gradient(v, dt)
    force = TABLE_1.steady_state(v) + inertia + rng.standard_normal(len(v))
    log = Log(np.arange(len(v)) * dt, np.round(z / 0.25e-6) * 0.25e-6, force=force)
    fit = identify_static([log], Asked())
    assert len(fit.points) == 2 * len(PAPER_SPEEDS[5:])
    for name in NAMES:
        low, high = _limits(fit, name)
        assert low - 0.02 * high <= getattr(TABLE_1, name) <= 1.02 * high


def test_glitches_in_a_stroke_do_not_move_the_map():
    logs = _logs(2)
    spoiled = []
    for log in logs:
        force = log.force.copy()
        force[7::61] += 5e3
        spoiled.append(replace(log, force=force))
    clean, rough = identify_static(logs, Asked()), identify_static(spoiled, Asked())
    for name in NAMES:
        low, high = _limits(clean, name)
        assert abs(_value(rough, name) - _value(clean, name)) < 3 * (high - low)


def test_the_drives_own_damping_is_taken_off_with_a_plant():
    plant = Plant(A=28.57, B=4.526, T_d=0.65e-3, K_f=548.0)
    friction = replace(TABLE_1, sigma=TABLE_1.sigma + plant.damping)
    logs = _logs(3, friction=friction)
    low, high = _limits(identify_static(logs, Asked(plant=plant)), "sigma")
    assert low < TABLE_1.sigma < high
    assert _value(identify_static(logs, Asked()), "sigma") == pytest.approx(40 + 3459, rel=0.02)


def test_a_damping_that_is_too_large_moves_sigma_alone():
    """Friction is what it is whatever damping is taken off; sigma ends at 0, and is known as well as that is."""
    plant = Plant(A=28.57, B=4.526, T_d=0.65e-3, K_f=548.0)
    logs = _logs(friction=replace(TABLE_1, sigma=0.99 * plant.damping))
    bare, taken = identify_static(logs, Asked()), identify_static(logs, Asked(plant=plant, damping_error=80.0))
    for name in ("F_c", "F_s", "v_s", "offset"):
        assert _value(taken, name) == pytest.approx(_value(bare, name), rel=1e-5, abs=1e-5)
        assert _limits(taken, name) == pytest.approx(_limits(bare, name), rel=1e-3)
    assert _value(taken, "sigma") == 0.0
    low, high = _limits(taken, "sigma")
    assert low == 0.0
    assert 80.0 < high < 90.0
    assert "sigma-in-A" in {notice.code for notice in taken.warnings}


def test_each_direction_gets_its_own_map():
    rng = np.random.default_rng(4)
    other = StaticMap(120.0, 150.0, 2e-3, 1.0, 80.0)
    logs = [stroke(v, rng) for v in PAPER_SPEEDS] + [stroke(-v, rng, friction=other) for v in PAPER_SPEEDS]
    fit = identify_static(logs, Asked(direction="each"))
    offset = _value(fit, "offset")
    assert -7.5 < offset < 0
    assert _value(fit, "F_c") + offset == pytest.approx(105, rel=0.01)
    assert float(fit.negative.estimates["F_c"]) - offset == pytest.approx(120, rel=0.01)
    assert float(fit.negative.estimates["offset"]) == offset
    with pytest.raises(FricError, match="only one direction"):
        identify_static(logs[:17], Asked(direction="each"))


def test_scatter_between_strokes_widens_the_intervals():
    rng = np.random.default_rng(6)
    logs = [replace(log, force=log.force + 3.0 * rng.standard_normal()) for log in _logs(6)]
    fit = identify_static(logs, Asked())
    assert fit.static.between == pytest.approx(3.0, rel=0.4)
    assert "strokes-scatter" in {one.code for one in fit.warnings}
    low, high = _limits(fit, "F_c")
    assert low < 105 < high
    assert high - low > 1.0


@pytest.mark.parametrize(("scatter", "severity"), [(3.0, "note"), (30.0, "doubt")])
def test_a_map_whose_strokes_scatter_by_a_tenth_of_their_force_is_doubted(scatter, severity):
    rng = np.random.default_rng(8)
    logs = [replace(log, force=log.force + scatter * rng.standard_normal()) for log in _logs(6)]
    assert {one.severity for one in identify_static(logs, Asked()).warnings if one.code == "strokes-scatter"} == {
        severity
    }


@pytest.mark.parametrize(("ratio", "severity"), [(1.15, {"note", "doubt"}), (1.6, {"wrong"})])
def test_strokes_at_two_levels_are_of_two_machines(ratio: float, severity: set[str]) -> None:
    """Of two machines in a folder, a factor of 1.6 apart, a scheme was recommended, beside a doubt."""
    logs = [*_logs(6), *(replace(log, force=ratio * log.force, name=f"m2 {log.name}") for log in _logs(7))]
    (told,) = (one for one in identify_static(logs, Asked()).warnings if one.code == "strokes-scatter")
    assert told.severity in severity
    assert float(told.values["levels"]) == pytest.approx(ratio, rel=0.02)


def test_a_damping_that_is_within_its_interval_too_large_is_not_told_wrong():
    plant = Plant(A=100.0, B=1.0, T_d=1e-3, K_f=1000.0)
    sure, unsure = (identify_static(_logs(6), Asked(plant=plant, damping_error=error)) for error in (0.0, 1.2e5))
    assert "damping-too-large" in {one.code for one in sure.warnings}
    assert "damping-too-large" not in {one.code for one in unsure.warnings}


def test_scatter_beside_which_the_noise_of_strokes_is_lost_is_told():
    rng = np.random.default_rng(0)
    logs = [replace(log, force=log.force * (1 + 5 * rng.standard_normal())) for log in _logs(noise=1e-9)]
    assert any(warning.code == "strokes-scatter" for warning in identify_static(logs, Asked()).warnings)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"speeds": PAPER_SPEEDS[10:]}, "fall-not-seen"),
        ({"friction": StaticMap(100, 100, 1e-3, 1.0, 40)}, "fall-not-seen"),
    ],
)
def test_what_the_data_cannot_tell_is_said(change, told):
    found = {one.code: one for one in identify_static(_logs(8, **change), Asked()).warnings}
    assert told in found
    if "speeds" in change and told == "fall-not-seen":
        assert float(found[told].values["slowest"]) == pytest.approx(8e-3, rel=0.01)


def test_friction_of_another_shape_is_noticed():
    rng = np.random.default_rng(9)
    logs = []
    for v in both_directions():
        bump = 15 * np.exp(-(np.log(abs(v) / 5e-3) ** 2))
        log = stroke(v, rng)
        logs.append(replace(log, force=log.force + np.sign(v) * bump))
    assert "residuals-follow-speed" in {one.code for one in identify_static(logs, Asked()).warnings}


def test_one_speed_alone_gives_the_force_there_and_no_map():
    rng = np.random.default_rng(10)
    fit = identify_static([stroke(v, rng) for v in (2e-3, -2e-3, 2e-3)], Asked())
    assert fit.static is None
    low, high = fit.at_speed["force"].ci95
    assert low < float(TABLE_1.steady_state(2e-3)) < high
    assert fit.warnings[0].code == "one-speed"


@pytest.mark.parametrize("offset", [30.0, -30.0, -150.0])
def test_one_direction_alone_bounds_neither_level_and_knows_their_sum(offset):
    """F_c and an offset are one level there: no split of both has an interval."""
    fit = identify_static([replace(log, force=log.force + offset) for log in _logs(11)[17:]], Asked())
    assert fit.static.estimates["offset"].assumed
    assert fit.static.estimates["offset"].ci95 is None
    for name in ("F_c", "F_s"):
        assert fit.static.estimates[name].ci95 == (0.0, np.inf)
    told = fit.warnings[0]
    assert (told.code, told.severity) == ("one-direction", "doubt")
    if offset > -TABLE_1.F_c:
        low, high = told.values["level"].ci95
        assert low < TABLE_1.F_c + offset < high
        force, half = fit.static.predict(np.array([5e-3]))
        assert abs(force - TABLE_1.steady_state(5e-3) - offset) < half < 2.0


def test_a_joint_under_load_in_one_direction_is_not_all_friction():
    """A joint of 0.77 N*m under 2.64 N*m: its table in one direction gave a friction of 3.41 with a narrow interval."""
    v, rng = np.geomspace(0.05, 2.0, 14), np.random.default_rng(2)
    force = 0.77 + 2.64 + 0.1 * v + 0.01 * rng.standard_normal(14)
    fit = identify_static([ForceVelocity(v, force, error=np.full(14, 0.01), motion="rotary")], Asked("rotary"))
    low, high = fit.static.estimates["F_c"].ci95
    assert low <= 0.77 <= high
    assert fit.warnings[0].values["level"].ci95[0] < 3.41 < fit.warnings[0].values["level"].ci95[1]
    known = identify_static(
        [ForceVelocity(v, force, error=np.full(14, 0.01), motion="rotary")], Asked("rotary", load=2.64)
    )
    low, high = known.static.estimates["F_c"].ci95
    assert low < 0.77 < high < 0.8


def test_a_force_of_the_wrong_sign_is_told_first():
    fit = identify_static([replace(log, force=-log.force) for log in _logs(14)], Asked())
    assert fit.warnings[0].code == "force-turned"


@pytest.mark.parametrize("weight", [-150.0, 150.0])
def test_gravity_above_friction_is_no_wrong_sign(weight):
    fit = identify_static([replace(log, force=log.force + weight) for log in _logs(15)], Asked())
    assert "force-turned" not in {one.code for one in fit.warnings}


def test_too_few_speeds_and_no_stroke_are_errors():
    with pytest.raises(FricError, match="cannot give 5 parameters"):
        identify_static(_logs(12, speeds=PAPER_SPEEDS[[3, 9]]), Asked())
    t = np.arange(4000) / 1000
    sine = Log(t, 1e-3 * np.sin(20 * t), force=np.cos(20 * t))
    with pytest.raises(FricError, match="no stroke"):
        identify_static([sine], Asked())
    with pytest.raises(FricError, match="records say that they are sliding-sine"):
        identify_static([replace(sine, kind="sliding-sine")], Asked())
    with pytest.raises(FricError, match="no force"):
        identify_static([Log(t, t)], Asked())


def test_a_stroke_that_stands_off_all_others_hardly_counts_and_is_named():
    logs = _logs(13)
    spoiled = [*logs[:20], replace(logs[20], force=logs[20].force + 40.0), *logs[21:]]
    fit, clean = identify_static(spoiled, Asked()), identify_static(logs, Asked())
    assert [p.velocity for p, _ in fit.static.standing_off] == [clean.points[20].velocity]
    assert {one.code: one.severity for one in fit.warnings}["strokes-stand-off"] == "doubt"
    assert not clean.static.standing_off
    for name in NAMES:
        low, high = _limits(clean, name)
        assert abs(_value(fit, name) - _value(clean, name)) < high - low


def _outlying(seed: int) -> StaticFit:
    """Return the map of 22 strokes that scatter by 0.5 N, each with a chance of a tenth by 2.75 N more."""
    rng, speeds = np.random.default_rng([seed, 77]), np.geomspace(1e-4, 0.03, 11)
    v = np.concatenate([-speeds[::-1], speeds])
    off = 0.5 * rng.standard_normal(22) + 0.1 * rng.standard_normal(22)
    off += 2.75 * (rng.uniform(size=22) < 0.1) * rng.choice([-1, 1], 22)
    table = ForceVelocity(v, SPOILED.steady_state(v) + 3.0 + off, error=np.full(22, 0.1))
    return identify_static([table], Asked(delta=1.0, form="stribeck", direction="both"))


SPOILED = StaticMap(F_c=80.0, F_s=115.0, v_s=1.8e-3, delta=1.0, sigma=120.0)


def _holds(fit: StaticFit, name: str) -> bool:
    low, high = _limits(fit, name)
    return low <= getattr(SPOILED, name) <= high


@pytest.mark.parametrize("seed", [4, 42])
def test_that_other_strokes_may_stand_off_is_in_the_intervals(seed: int) -> None:
    """F_c, v_s and sigma were 1.5 to 4.5 half-widths off: the interval took for granted which strokes weigh less."""
    fit = _outlying(seed)
    assert fit.static.standing_off
    assert all(_holds(fit, name) for name in NAMES)


@pytest.mark.long(60)
def test_intervals_hold_where_a_tenth_of_the_strokes_is_off() -> None:
    """They hold in 90 to 98 % of 60 sessions (83 to 93 % before); chance of failing below 1e-3 each at 92 %."""
    fits = [_outlying(seed) for seed in range(60)]
    for name in NAMES:
        assert sum(_holds(fit, name) for fit in fits) >= fewest(60, 0.92), name


def _sessions(
    slowest: tuple[float, float], deltas: tuple[float, ...], most: float, count: int
) -> Iterator[tuple[StaticMap, StaticFit]]:
    """Yield machines and their maps; the slowest stroke is at these powers of ten of v_s."""
    for seed in range(count):
        rng = np.random.default_rng(seed)
        v_s, scatter = 10 ** rng.uniform(-3.3, -2.0), 10 ** rng.uniform(-3.0, -2.0)
        F_s, sigma, delta = rng.uniform(1.1, most), rng.uniform(1.0, 10.0), float(rng.choice(deltas))
        friction = StaticMap(1.0, F_s, v_s, delta=delta, sigma=sigma)
        v = both_directions(np.geomspace(min(v_s * 10 ** rng.uniform(*slowest), 0.05), 0.1, 8))
        F = friction.steady_state(v) + scatter * rng.standard_normal(len(v))
        yield friction, identify_static([ForceVelocity(v, F, error=np.full(len(v), 1e-4))], Asked())


@pytest.mark.parametrize(("seen", "slowest", "deltas", "most", "names", "count"), [
    (False, (0.5, 1.2), (0.5,), 1.4, ("F_c", "sigma"), 20),
    pytest.param(False, (0.5, 1.2), (0.5,), 1.4, ("F_c", "sigma"), 45, marks=pytest.mark.long(4)),
    pytest.param(True, (-0.3, 0.5), (0.5, 1.0, 2.0), 1.8, ("F_s", "v_s"), 45, marks=pytest.mark.long(8)),
])  # fmt: skip
def test_intervals_hold_what_lies_below_the_slowest_stroke(seen, slowest, deltas, most, names, count) -> None:
    """A rest of an unseen fall is taken for F_c and less sigma: they were held in 6 and 13 of 29 such sessions; F_s and
    v_s depend on the shape of the fall below the strokes: they were held in 29 and 28 of 38.
    """  # fmt: skip
    held = []
    for friction, fit in _sessions(slowest, deltas, most, count):
        if seen != any(notice.code == "fall-not-seen" for notice in fit.warnings):
            limits = [_limits(fit, name) for name in names]
            held.append(
                [low <= getattr(friction, name) <= high for name, (low, high) in zip(names, limits, strict=True)]
            )
    assert len(held) >= 0.45 * count
    assert np.all(np.sum(held, axis=0) >= fewest(len(held)))


def test_a_static_friction_far_above_all_forces_is_open() -> None:
    """F_s of 25 N, at strokes of 1.6 N at most, ended in a refusal of its interval: the search ended below it."""
    rng = np.random.default_rng(31)
    v = both_directions(np.geomspace(7.8e-3, 0.1, 9))
    F = StaticMap(1.0, 1.57, 7.5e-3, delta=5.25, sigma=1.0).steady_state(v) + 1.2e-3 * rng.standard_normal(len(v))
    fit = identify_static([ForceVelocity(v, F, error=np.full(len(v), 1e-4))], Asked())
    low, high = _limits(fit, "F_s")
    assert (low < 1.57, high) == (True, np.inf)


@pytest.mark.parametrize("below", [1.0, 3.0])
def test_slow_strokes_that_stick_between_counts_do_not_spoil_the_rest(below):
    """An axis that hunts at its slowest speed takes less force than eq. (2) says; the other strokes are right."""
    slow = min(abs(p.velocity) for p in identify_static(_logs(), Asked()).points)
    logs = [
        replace(log, force=log.force - below * np.sign(np.median(log.force)))
        if abs(np.ptp(log.position) / np.ptp(log.time)) < 1.5 * slow else log
        for log in _logs()
    ]  # fmt: skip
    whole = identify_static(logs, Asked())
    fit = whole.static
    assert "strokes-stand-off" in {warning.code for warning in whole.warnings}
    assert {round(abs(p.velocity) / slow) for p, _ in fit.standing_off} == {1}
    assert all(by == pytest.approx(below, rel=0.5) for _, by in fit.standing_off)
    assert float(fit.estimates["sigma"]) == pytest.approx(TABLE_1.sigma, rel=0.15)
    low, high = fit.estimates["sigma"].ci95
    assert low < TABLE_1.sigma < high < 1.3 * TABLE_1.sigma


def test_strokes_too_short_to_settle_are_told():
    logs = []
    for log in _logs(14):
        creeping = 1 + 0.3 * np.exp(-(log.time - log.time[0]) / np.ptp(log.time))
        logs.append(replace(log, force=log.force * creeping))
    fit = identify_static(logs, Asked())
    assert {w.code: w.severity for w in fit.warnings}["strokes-settling"] == "wrong"
    low, high = fit.static.estimates["F_s"].ci95
    assert low < TABLE_1.F_s < high


SPEEDS = 0.1 * np.geomspace(1 / 1500, 1, 10)
"""Ten speeds over three decades, as one logs them."""


def of_law(law, seed: int, *, scatter: float = 0.0) -> list[Log]:
    """Return strokes at ten speeds, both ways, of a law of friction that need not be eq. (2)."""
    rng, logs = np.random.default_rng(seed), []
    for v in both_directions(SPEEDS):
        own = law(abs(v)) * (1 + scatter * rng.standard_normal())
        log = stroke(v, rng, noise=0.0)
        logs.append(replace(log, force=np.sign(v) * own + 0.4 * rng.standard_normal(len(log))))
    return logs


def test_a_law_that_is_not_eq_2_is_told_where_both_directions_show_it() -> None:
    """A fall as 1/(1 + (v/v_s)²) (Hess and Soom 1990), or a viscous part as √v, left 1 to 3 N of 50 without a doubt."""

    def told(fit: StaticFit) -> bool:
        return "residuals-follow-speed" in {w.code for w in fit.warnings if w.severity == "doubt"}

    hess, root, plain = (
        lambda v: 50 + 25 / (1 + (v / 2e-3) ** 2) + 720 * v,
        lambda v: 50 + 25 * np.exp(-v / 2e-3) + 720 * v + 150 * np.sqrt(v),
        lambda v: 50 + 25 * np.exp(-v / 2e-3) + 720 * v,
    )
    for law in (hess, root):
        assert all(told(identify_static(of_law(law, seed), Asked())) for seed in range(2))
    for scatter in (0.0, 0.02):
        assert not any(told(identify_static(of_law(plain, seed, scatter=scatter), Asked())) for seed in range(3))
